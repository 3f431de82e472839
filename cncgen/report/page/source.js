// The program's text with the time of each line: only the lines that are in view are in the document.

import { lineKey } from "./lines.js";
import { brief, share } from "./format.js";

const HEIGHT = 20;
/** Browsers draw no element higher than this; longer texts scroll in proportion. */
const TALLEST = 8_000_000;

export class SourceView {
  /** `on` has functions: pick(source, line), hover(source, line or null). */
  constructor(box, on) {
    this.on = on;
    this.list = box.querySelector(".lines");
    this.select = box.querySelector("select");
    this.search = box.querySelector("input");
    this.count = box.querySelector(".found");
    this.space = document.createElement("div");
    this.window = document.createElement("div");
    this.space.className = "space";
    this.window.className = "window";
    this.space.append(this.window);
    this.head = document.createElement("div");
    this.head.className = "row head";
    this.list.append(this.head, this.space);
    this.lines = [];
    this.source = 0;
    this.current = this.hovered = -1;
    this.matches = [];
    this.list.addEventListener("scroll", () => this.draw());
    new ResizeObserver(() => this.draw()).observe(this.list);
    this.list.addEventListener("click", (event) => this.clicked(event));
    this.list.addEventListener("pointerover", (event) => this.pointed(event));
    this.list.addEventListener("pointerleave", () => this.on.hover(null));
    this.list.addEventListener("keydown", (event) => this.key(event));
    this.search.addEventListener("input", () => this.find());
    this.search.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.next(event.shiftKey ? -1 : 1);
    });
    for (const button of box.querySelectorAll("[data-find]")) button.addEventListener("click", () => this.next(Number(button.dataset.find)));
    this.select.addEventListener("change", () => this.show(Number(this.select.value)));
  }

  /** Take the texts of a part's sources, and the rows of each line. */
  setPart(part, texts, other) {
    this.part = part;
    this.other = other;
    this.texts = texts;
    this.select.replaceChildren(
      ...part.header.sources.map((source, k) => {
        const option = document.createElement("option");
        option.value = String(k);
        option.textContent = source.name;
        return option;
      }),
    );
    this.select.hidden = part.header.sources.length < 2;
    this.most = Math.max(1, ...[...(part.lineRows?.values() ?? [])].slice(0, 400_000).reduce((best, v) => [Math.max(best[0], v)], [0]));
    this.total = Math.max(1, part.rows - 1);
    const delta = cell("delta", "difference");
    delta.title = other ? `How much longer ${other.header.label} takes` : "";
    this.head.replaceChildren(cell("number", "line"), cell("time", "time"), cell("share", "share"), ...(other ? [delta] : []), cell("code", "program"));
    this.show(0);
  }

  show(source) {
    this.source = source;
    this.select.value = String(source);
    const text = this.texts[source];
    this.lines = text === null || text === undefined ? [] : text.split(/\r\n|\n|\r/);
    if (this.lines.length > 1 && this.lines[this.lines.length - 1] === "") this.lines.pop();
    this.coloured = /^\s*ISO-10303-21/.test(this.lines[0] ?? "") ? (line) => [document.createTextNode(line)] : coloured;
    this.list.dataset.lines = String(this.lines.length);
    this.space.style.height = `${Math.min(TALLEST, this.lines.length * HEIGHT)}px`;
    this.list.classList.toggle("empty", !this.lines.length);
    this.find();
    this.drawn = null;
    this.draw();
  }

  /** Return the first line in view (from 0), as a fraction where the list is longer than a browser draws. */
  top() {
    const tall = this.lines.length * HEIGHT, scroll = this.list.scrollTop, view = this.list.clientHeight;
    if (tall <= TALLEST) return scroll / HEIGHT;
    return ((scroll / Math.max(1, TALLEST - view)) * (tall - view)) / HEIGHT;
  }

  scrollTo(line, smooth = false) {
    const tall = this.lines.length * HEIGHT, view = this.list.clientHeight;
    const wanted = Math.max(0, Math.min(tall - view, (line - 1) * HEIGHT - view / 2 + HEIGHT / 2));
    const at = tall <= TALLEST ? wanted : (wanted / Math.max(1, tall - view)) * (TALLEST - view);
    this.list.scrollTo({ top: at, behavior: smooth ? "smooth" : "instant" });
  }

  draw() {
    if (!this.part || !this.list.clientHeight) return;
    const first = Math.max(0, Math.floor(this.top()) - 4);
    const last = Math.min(this.lines.length, first + Math.ceil(this.list.clientHeight / HEIGHT) + 9);
    const key = `${this.source} ${first} ${last} ${this.current} ${this.hovered} ${this.matches.length} ${this.at}`;
    if (key === this.drawn) return;
    this.drawn = key;
    const exact = this.lines.length * HEIGHT <= TALLEST;
    const offset = exact ? first * HEIGHT : this.list.scrollTop - (this.top() - first) * HEIGHT;
    this.window.style.transform = `translateY(${offset}px)`;
    this.window.replaceChildren(...this.lines.slice(first, last).map((text, k) => this.row(first + k + 1, text)));
  }

  row(line, text) {
    const found = document.createElement("div");
    found.className = "row";
    found.dataset.line = String(line);
    const rows = this.part.lineRows?.get(lineKey(this.source, line));
    const seconds = (rows ?? 0) * this.part.period;
    if (line === this.current) found.classList.add("current");
    if (line === this.hovered) found.classList.add("hovered");
    if (this.matched?.has(line)) found.classList.add("match");
    const number = cell("number", String(line));
    const time = cell("time", rows ? brief(seconds) : "");
    const part = cell("share", rows ? share(rows / this.total) : "");
    part.style.setProperty("--part", String(Math.min(1, Math.sqrt((rows ?? 0) / this.most))));
    found.append(number, time, part);
    if (this.other) found.append(this.difference(line, rows ?? 0));
    const code = cell("code", "");
    const shown = text.replace(DIRECTIONS, "\ufffd");
    code.append(...this.coloured(shown.length > 400 ? `${shown.slice(0, 400)}…` : shown));
    found.append(code);
    return found;
  }

  difference(line, rows) {
    const there = (this.other.lineRows?.get(lineKey(this.source, line)) ?? 0) * this.other.period;
    const change = there - rows * this.part.period;
    const found = cell("delta", Math.abs(change) < 5e-4 ? "" : `${change > 0 ? "+" : "−"}${brief(Math.abs(change))}`);
    found.classList.add(change > 0 ? "slower" : "faster");
    return found;
  }

  /** Mark the line that the pointer's row is on, and the one that is chosen; the latter comes into view. */
  mark(source, line, hovered, reveal) {
    if (reveal && source !== this.source && this.texts?.[source] != null) this.show(source);
    this.current = source === this.source ? line : -1;
    this.hovered = hovered && hovered.source === this.source ? hovered.line : -1;
    if (reveal && this.current > 0) {
      const top = this.top(), view = this.list.clientHeight / HEIGHT;
      if (line < top + 2 || line > top + view - 2) this.scrollTo(line);
    }
    this.draw();
  }

  clicked(event) {
    const row = event.target.closest(".row[data-line]");
    if (row) this.on.pick(this.source, Number(row.dataset.line));
  }

  pointed(event) {
    const row = event.target.closest(".row[data-line]");
    this.on.hover(row ? this.source : null, row ? Number(row.dataset.line) : 0);
  }

  key(event) {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!step || this.current < 0) return;
    event.preventDefault();
    event.stopPropagation();
    const line = Math.max(1, Math.min(this.lines.length, this.current + step));
    this.on.pick(this.source, line);
  }

  /** Find what stands in the search field: a text anywhere in a line, or ":61" for line 61. */
  find() {
    const wanted = this.search.value.trim().toLowerCase();
    this.matches = [];
    this.at = -1;
    const line = /^:(\d+)$/.exec(wanted);
    if (line) {
      const number = Math.max(1, Math.min(this.lines.length, Number(line[1])));
      this.matches = [number];
    } else if (wanted) {
      for (let k = 0; k < this.lines.length; k++) if (this.lines[k].toLowerCase().includes(wanted)) this.matches.push(k + 1);
    }
    this.matched = new Set(this.matches);
    this.count.textContent = wanted ? `${this.matches.length.toLocaleString("en")} found` : "";
    this.drawn = null;
    if (this.matches.length) this.scrollTo(this.matches[0]);
    this.draw();
  }

  next(step) {
    if (!this.matches.length) return;
    this.at = (this.at + step + this.matches.length) % this.matches.length;
    if (this.at < 0) this.at = 0;
    const line = this.matches[this.at];
    this.count.textContent = `${this.at + 1} of ${this.matches.length.toLocaleString("en")}`;
    this.scrollTo(line);
    this.on.pick(this.source, line);
  }
}

function cell(kind, text) {
  const found = document.createElement("span");
  found.className = kind;
  found.textContent = text;
  return found;
}

/** Controls of the direction of writing, which would show words in another order than they are read. */
const DIRECTIONS = /[\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]/g;

const TOKENS = /(\([^)]*\)|;.*$)|([Gg]\s*\d+(?:\.\d+)?)|([MmTtSs]\s*\d+(?:\.\d+)?)|([Ff]\s*[-+]?[\d.]+)|([XYZABCUVWIJKPQRxyzabcuvwijkpqr](?=\s*[-+]?[\d.#[]))/g;
const CLASSES = ["comment", "code-g", "code-m", "code-f", "code-axis"];

/** Return the parts of a line of G-code as text nodes and spans. */
function coloured(text) {
  const found = [];
  let from = 0;
  for (const match of text.matchAll(TOKENS)) {
    if (match.index > from) found.push(document.createTextNode(text.slice(from, match.index)));
    const kind = match.slice(1).findIndex((part) => part !== undefined);
    found.push(cell(CLASSES[kind], match[0]));
    from = match.index + match[0].length;
  }
  found.push(document.createTextNode(text.slice(from)));
  return found;
}
