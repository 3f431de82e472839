// The page: reads its data, and ties picture, charts, source and tables to one moment.

import { Charts } from "./charts.js";
import { choices, colouring, palette } from "./colouring.js";
import { duration, partly, rounded, share } from "./format.js";
import { heed, tell } from "./host.js";
import { legend } from "./legend.js";
import { lineKey, toolName } from "./lines.js";
import { parsed, written } from "./link.js";
import { Overlay } from "./overlay.js";
import { Scene } from "./scene.js";
import { SourceView } from "./source.js";
import { prepare } from "./prepare.js";
import { Part } from "./store.js";
import { answers, checks, differences, element, losses, placeName, positionText, times, timeSplit, untimed, untimedBadge } from "./tables.js";

const $ = (id) => document.getElementById(id);
const TABS = [["program", "Program"], ["losses", "Losses"], ["time", "Time"], ["checks", "Checks"], ["compare", "Compare"]];
const MARKS = { corners: "Sharp corners", tools: "Tool changes", breaches: "Broken limits", places: "Time lost" };
/** Sharp corners beyond which their marks are hidden until they are asked for. */
const CROWDED = 500;
/** Setpoints up to which the page is ready when it has loaded; more are decoded in a worker, and the page can be used meanwhile. */
const AT_ONCE = 250_000;

class Page {
  constructor() {
    this.header = JSON.parse($("header").textContent);
    this.parts = this.header.parts.map((part) => new Part(part, this.header.limits));
    this.part = this.parts[0];
    this.settings = parsed(location.hash);
    const dark = matchMedia("(prefers-color-scheme: dark)");
    this.theme = this.settings.theme ?? (dark.matches ? "dark" : "light");
    dark.addEventListener("change", () => this.settings.theme || this.setTheme(dark.matches ? "dark" : "light"));
    document.documentElement.dataset.theme = this.theme;
    this.now = this.hover = -1;
    this.selected = null;
    this.scene = new Scene($("path"), this.theme, { parts: this.parts.length, turned: this.part.header.turned });
    this.overlay = new Overlay($("over"), this.scene);
    this.scene.onframe = () => this.overlay.draw();
    this.scene.covered = covered;
    this.charts = new Charts($("charts"), this.theme, {
      hover: (row) => this.setHover(row),
      seek: (row) => this.seek(row),
      zoomed: () => this.zoomed(),
    });
    this.source = new SourceView($("panel-program"), {
      pick: (source, line) => this.pickLine(source, line),
      hover: (source, line) => this.hoverLine(source, line),
    });
    this.heading();
    this.tabs();
    this.listen();
    this.start();
  }

  // -- data

  start() {
    const message = { text: $("blob").textContent, parts: this.header.parts, predictors: this.header.predictors };
    $("blob").remove();
    if (this.parts.reduce((rows, part) => rows + part.rows, 0) <= AT_ONCE) return prepare(message, (data) => this.received(data));
    // A worker runs this same script.
    const script = new Blob([$("script").textContent], { type: "text/javascript" });
    this.worker = new Worker(URL.createObjectURL(script));
    this.worker.onmessage = ({ data }) => this.received(data);
    this.worker.onerror = (event) => this.failed(event.message || "the worker does not start");
    this.worker.postMessage(message);
  }

  failed(message) {
    $("message").hidden = false;
    $("message").textContent = `The page cannot be shown: ${message}`;
  }

  received(data) {
    if (data.kind === "failed") return this.failed(data.message);
    if (data.kind === "done") {
      document.documentElement.dataset.ready = "all";
      return this.worker?.terminate();
    }
    if (data.kind === "mesh") return this.scene.setSurface(data.points, data.triangles);
    const part = this.parts[data.index];
    if (data.kind === "path") this.takePath(part, data);
    if (data.kind === "texts") part.texts = data.texts;
    if (data.kind === "texts" && part === this.part) {
      this.source.setPart(part, part.texts, this.parts.find((one) => one !== part));
      this.showLine(true);
    }
    if (data.kind === "bands") part.bands = data.bands;
    if (data.kind === "bands" && data.index === this.parts.length - 1) this.complete();
  }

  takePath(part, data) {
    part.takePath(data);
    if (!part.rows) return this.failed("the program moves nothing");
    this.scene.addPart(part);
    if (part !== this.part) return;
    $("message").hidden = true;
    this.scene.resize();
    this.fillColours();
    this.setColour(this.settings.c ?? "feed");
    this.makeMarks();
    if (!this.settings.v || !this.scene.camera.restore(this.settings.v)) this.scene.fit();
    // First a coarse path, so that a long one is seen at once; the rest follows.
    this.scene.request(true);
    this.scene.draw();
    document.documentElement.dataset.ready ??= "path";
    performance.mark("path-drawn");
    this.split();
    $("scrub").max = String(part.rows - 1);
    this.seek(part.rowAt(Number(this.settings.t) || 0), false);
    $("panel-losses").replaceChildren(losses(part, (row) => this.go(row)));
    $("panel-checks").replaceChildren(checks(part, (row) => this.go(row)));
  }

  /** All parts are decoded: charts, tables of several parts, and what the link asks for. */
  complete() {
    const { settings } = this;
    this.charts.parts = this.parts;
    for (const part of this.parts) if (part !== this.part) part.borrowLines(this.part);
    if (this.parts.length > 1) this.source.setPart(this.part, this.part.texts, this.parts[1]);
    if (settings.x) {
      const [a, b] = settings.x.split(",").map(Number);
      if (b > a) {
        this.charts.range = [a, b];
        this.charts.touched = true;
      }
    }
    if (settings.g !== undefined) this.charts.shown = new Set(settings.g.split(","));
    this.charts.setParts(this.parts);
    this.fillCharted();
    this.fillColours();
    if (settings.c) this.setColour(settings.c);
    $("panel-time").replaceChildren(times(this.part, (row) => this.go(row)));
    $("answers").replaceChildren(...answers(this.part, {
      place: (row) => { this.setTab("losses"); this.go(row); },
      limits: () => { this.setTab("time"); this.setColour("limit"); },
      changes: () => { this.setTab("time"); $("changes").scrollIntoView(); },
    }));
    if (this.parts.length > 1) $("panel-compare").replaceChildren(differences(this.part, this.parts.slice(1), (row) => this.go(row)));
    if (settings.l) this.pickLine(...settings.l.split(",").map(Number), false);
    this.zoomed();
    this.readout();
    this.tell();
  }

  /** Show what a link says: an address that a person changed, or what the host asks for. */
  restore(hash) {
    const settings = (this.settings = parsed(hash)), { scene, charts } = this;
    if (settings.theme) this.setTheme(settings.theme);
    if (!settings.v || !scene.camera.restore(settings.v)) scene.fit();
    scene.request(true);
    this.setColour(settings.c ?? "feed");
    this.makeMarks();
    this.setTab($(`tab-${settings.p}`) ? settings.p : this.tab);
    this.seek(this.part.rowAt(Number(settings.t) || 0));
    this.selected = null;
    scene.setHighlight([]);
    if (settings.l) this.pickLine(...settings.l.split(",").map(Number), false);
    if (settings.g !== undefined) charts.shown = new Set(settings.g.split(","));
    charts.rebuild();
    this.fillCharted();
    const [a, b] = (settings.x ?? "").split(",").map(Number);
    charts.setRange(...(b > a ? [a, b] : [0, charts.whole]));
  }

  /** Tell the host of the view, its moment and its line, once all is there: the host answers with what it asks for. */
  tell() {
    if (!this.charts.all) return;
    clearTimeout(this.remembering);
    const row = Math.max(0, this.now);
    tell({ view: this.link().slice(1), t_s: Number((row * this.part.period).toFixed(6)), line: this.part.line(row) ?? 0 });
  }

  // -- what stands at the top

  heading() {
    const { summary, verdict, machine } = this.part.header;
    $("title").textContent = this.header.title;
    const facts = [summary.feedrate], short = (value) => (value < 10 ? rounded(value) : value.toFixed(1));
    if (summary.path_length_mm !== undefined) facts.push(`${short(summary.path_length_mm)} mm`);
    if (summary.feed_mm_s) facts.push(`mean ${short(summary.feed_mm_s.mean)} mm/s${summary.feed_of === "slides" ? " of the slides" : ""}`);
    facts.push(`${this.part.rows.toLocaleString("en")} setpoints of ${Number((1000 * this.part.period).toPrecision(6))}\u00a0ms`);
    $("subtitle").textContent = facts.filter(Boolean).join(" · ");
    $("subtitle").title = `${$("subtitle").textContent}; machine ${machine}`;
    $("cycle").textContent = duration(this.part.seconds);
    const badges = [];
    if (verdict) badges.push(element("button", { class: `badge ${verdict.holds ? "good" : "bad"}`, type: "button" }, verdict.holds ? "✓ every limit holds" : "✕ limits broken"));
    const count = { error: 0, warning: 0 };
    for (const item of summary.diagnostics ?? []) if (item.severity in count) count[item.severity]++;
    if (count.warning + count.error) badges.push(element("button", { class: "badge warn", type: "button" }, `${count.warning + count.error} warning${count.warning + count.error > 1 ? "s" : ""}`));
    const cut = this.part.header.removal?.findings.filter((item) => item.severity === "error").length;
    if (cut) badges.push(element("button", { class: "badge bad", type: "button" }, `✕ ${cut} fault${cut > 1 ? "s" : ""} of the cut`));
    for (const badge of badges) badge.addEventListener("click", () => this.setTab("checks"));
    const without = untimed(this.part);
    if (without) {
      const badge = element("button", { class: "badge warn without", type: "button", title: without }, untimedBadge(this.part));
      badge.addEventListener("click", () => this.setTab("time"));
      badges.push(badge);
    }
    $("badges").replaceChildren(...badges);
  }

  split() {
    const items = timeSplit(this.part), whole = items.reduce((sum, item) => sum + item.seconds, 0) || 1;
    const most = Math.max(...items.map((item) => item.seconds));
    const strip = element("div", { class: "strip" });
    const names = element("div", { class: "names" });
    for (const item of items) {
      const piece = element("span", { class: `kind-${item.kind}`, title: `${item.name}: ${duration(item.seconds)}` });
      piece.style.flexGrow = String(Math.max(item.seconds / whole, 0.004));
      strip.append(piece);
      names.append(element("span", { class: `kind-${item.kind}` }, `${item.name} ${partly(item.seconds, most)}`, element("small", {}, share(item.seconds / whole))));
    }
    $("split").setAttribute("aria-label", items.map((item) => `${item.name} ${duration(item.seconds)}`).join(", "));
    $("split").replaceChildren(strip, names);
  }

  tabs() {
    const text = this.part.header.sources.some((source) => source.text);
    const without = new Set([text ? "" : "program", this.parts.length > 1 ? "" : "compare"]);
    const shown = TABS.filter(([id]) => !without.has(id));
    $("tabs").replaceChildren(
      ...shown.map(([id, label]) => {
        const tab = element("button", { type: "button", role: "tab", id: `tab-${id}`, "aria-controls": `panel-${id}` }, label);
        tab.addEventListener("click", () => this.setTab(id));
        return tab;
      }),
    );
    $("tabs").addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      event.stopPropagation();
      const at = shown.findIndex(([id]) => id === this.tab);
      const [next] = shown[(at + step + shown.length) % shown.length];
      this.setTab(next);
      $(`tab-${next}`).focus();
    });
    this.setTab(shown.some(([id]) => id === this.settings.p) ? this.settings.p : shown[0][0]);
  }

  setTab(id) {
    this.tab = id;
    for (const [name] of TABS) {
      $(`panel-${name}`).hidden = name !== id;
      const tab = $(`tab-${name}`);
      tab?.setAttribute("aria-selected", String(name === id));
      tab?.setAttribute("tabindex", name === id ? "0" : "-1");
    }
    if (id === "program") this.source.draw();
    this.remember();
  }

  // -- colours and marks

  fillColours() {
    const groups = new Map();
    for (const { id, label, group } of choices(this.part)) {
      if (!groups.has(group)) groups.set(group, element("optgroup", { label: group }));
      groups.get(group).append(element("option", { value: id }, label));
    }
    $("colour").replaceChildren(...groups.values());
    if (this.colour) $("colour").value = this.colour.id;
  }

  setColour(id) {
    const known = choices(this.part), choice = known.find((one) => one.id === id) ?? known[0];
    const found = colouring(this.part, choice.id);
    if (!found) return;
    found.label = choice.label;
    this.colour = found;
    $("colour").value = found.id;
    this.scene.setColouring(found, palette(found, this.theme));
    legend($("legend"), found, this.theme, this.part.seconds || 1);
    this.remember();
  }

  makeMarks() {
    const { part } = this, { events, verdict, places } = part.header;
    const rows = (items) => items.map((item) => part.rowAt(item.t_s));
    const breaches = (verdict?.breaches ?? []).filter((item) => item.t_s !== undefined && item.t_s !== null);
    const sets = [
      { kind: "corners", rows: Array.from(part.corners, (row) => Math.min(row, part.rows - 1)) },
      { kind: "tools", rows: rows(events.filter((event) => event.event === "tool")) },
      { kind: "places", rows: rows(places) },
      { kind: "breaches", rows: rows(breaches) },
    ];
    this.overlay.setMarks(sets);
    // Corners of a surface in short lines would cover it.
    const crowded = part.corners.length > CROWDED ? "places,corners" : "places";
    const hidden = new Set((this.settings.m ?? crowded).split(","));
    const boxes = [["rapids", "Rapids"], ["grid", "Grid"], ...Object.entries(MARKS)];
    if (this.scene.surface) boxes.unshift(["part", "Part"]);
    if (this.parts.length > 1) boxes.push(["others", "Other plans"]);
    $("marks").replaceChildren(
      ...boxes.map(([kind, label]) => {
        const box = element("input", { type: "checkbox", id: `mark-${kind}`, checked: !hidden.has(kind) });
        box.addEventListener("change", () => this.setMark(kind, box.checked));
        this.setMark(kind, !hidden.has(kind), false);
        const set = sets.find((one) => one.kind === kind);
        return element("label", { for: `mark-${kind}` }, box, label, set ? element("small", {}, String(set.rows.length)) : null);
      }),
    );
  }

  setMark(kind, on, remember = true) {
    if (kind === "part") this.scene.showSurface = on;
    else if (kind === "rapids") this.scene.showRapids = on;
    else if (kind === "grid") this.scene.showGrid = on;
    else if (kind === "others") this.scene.hideOthers = !on;
    else this.overlay.marks[kind] = on;
    this.scene.request();
    if (remember) this.remember();
  }

  // -- moments, lines

  /** Make a row the current moment. */
  seek(row, remember = true) {
    this.now = Math.max(0, Math.min(this.part.rows - 1, row));
    this.overlay.current = this.charts.current = this.now;
    $("scrub").value = String(this.now);
    $("scrub").setAttribute("aria-valuetext", duration(this.part.timeOf(this.now)));
    this.showLine(true);
    this.readout();
    this.scene.frame();
    this.charts.point();
    if (remember) this.remember();
  }

  /** Seek a row and bring it into the picture and the charts. */
  go(row) {
    const { camera } = this.scene, [x, y, z] = this.part.points;
    const [px, py] = camera.project(x[row], y[row], z[row]);
    if (px < 60 || py < 60 || px > camera.width - 60 || py > camera.height - 60) camera.centre = [x[row], y[row], z[row]];
    const [a, b] = this.charts.range, t = row * this.part.period;
    if (this.charts.parts && (t < a || t > b)) this.charts.setRange(t - (b - a) / 2, t + (b - a) / 2);
    this.scene.request(true);
    this.seek(row);
  }

  setHover(row) {
    if (row === this.hover) return;
    this.hover = this.overlay.hover = this.charts.hover = row;
    this.showLine(false);
    this.readout();
    this.scene.frame();
    this.charts.point();
  }

  showLine(reveal) {
    const { part } = this;
    const hovered = this.hover >= 0 ? { source: part.source(this.hover), line: part.line(this.hover) } : null;
    if (this.now >= 0 && part.run.line) this.source.mark(part.source(this.now), part.line(this.now), hovered, reveal);
  }

  spansOf(source, line) {
    const found = this.part.stretches, visits = found?.visits.get(lineKey(source, line));
    return visits ? visits.map((k) => [Math.max(0, found.starts[k] - 1), Math.min(found.starts[k + 1], this.part.rows - 1)]) : [];
  }

  /** Choose a line: its path is shown, and the moment goes to its start. */
  pickLine(source, line, move = true) {
    const same = this.selected && this.selected[0] === source && this.selected[1] === line;
    const spans = same && move ? [] : this.spansOf(source, line);
    this.selected = spans.length ? [source, line] : null;
    this.scene.setHighlight(spans);
    if (spans.length && move) this.go(Math.min(spans[0][0] + 1, this.part.rows - 1));
    this.source.mark(source, line, null, false);
    this.remember();
  }

  hoverLine(source, line) {
    if (source === null) return this.setHover(-1);
    const spans = this.spansOf(source, line);
    this.setHover(spans.length ? Math.min(spans[0][0] + 1, this.part.rows - 1) : -1);
  }

  /** Write what is known of the moment under the pointer, or of the current one. */
  readout() {
    const { part } = this, row = this.hover >= 0 ? this.hover : this.now;
    if (row < 0 || !part.ready) return;
    const feed = part.feed(row), asked = part.programmed(row), items = [];
    const add = (name, value, signal) => items.push(element("span", { "data-signal": signal }, element("b", {}, name), value));
    add("t", (row * part.period).toFixed(Math.max(3, decimalsOf(part.period))), "t_s");
    for (const axis of part.axes) add(axis.letter, part.text(part.positionName(axis), row), part.positionName(axis));
    add("feed", feed.text, "feed_mm_s");
    if (asked !== undefined) add("programmed", asked > 0 ? asked.toFixed(2) : "rapid", "programmed_feed_mm_s");
    const line = part.line(row);
    if (line !== undefined) add("line", String(line), "line");
    if (part.limit(row)) add("held back by", part.limit(row), "limit");
    const tool = part.toolAt(row);
    if (tool) add("tool", toolName(tool), "tool");
    $("readout").replaceChildren(...items);
    $("readout").dataset.row = String(row);
    $("now").textContent = `${duration(part.timeOf(this.now))} of ${duration(part.seconds)}`;
  }

  tip(event) {
    const tip = $("tip"), row = this.hover;
    tip.hidden = row < 0;
    if (row < 0) return;
    const { part } = this, feed = part.feed(row), asked = part.programmed(row);
    const lines = [
      element("b", {}, placeName(part, row)),
      element("span", {}, `${duration(part.timeOf(row))} · ${feed.text} mm/s${asked > 0 ? ` of ${asked.toFixed(2)}` : asked === 0 ? " · rapid" : ""}`),
      element("span", {}, positionText(part, row)),
    ];
    if (part.limit(row)) lines.push(element("span", { class: "held" }, `held back by ${part.limit(row)}`));
    tip.replaceChildren(...lines);
    tip.dataset.row = String(row);
    tip.dataset.line = String(part.line(row) ?? "");
    const box = $("stage").getBoundingClientRect(), left = event.clientX - box.left, top = event.clientY - box.top;
    tip.style.left = `${Math.min(left + 14, box.width - tip.offsetWidth - 8)}px`;
    tip.style.top = `${top + 16 + tip.offsetHeight > box.height ? top - tip.offsetHeight - 12 : top + 16}px`;
  }

  // -- playing

  play(on = !this.playing) {
    this.playing = on;
    $("play").textContent = on ? "❚❚" : "▶";
    $("play").setAttribute("aria-label", on ? "Pause" : "Play");
    if (!on) return this.remember();
    if (this.now >= this.part.rows - 1) this.seek(0, false);
    let before = performance.now(), time = this.now * this.part.period;
    const step = (at) => {
      if (!this.playing) return;
      time += ((at - before) / 1000) * Number($("speed").value);
      before = at;
      this.seek(Math.floor(time / this.part.period + 1e-6), false);
      this.follow();
      if (this.now >= this.part.rows - 1) this.play(false);
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  /** Keep the moment inside the range of the charts. */
  follow() {
    const [a, b] = this.charts.range, t = this.now * this.part.period;
    if (t > b || t < a) this.charts.setRange(t, t + (b - a));
  }

  zoomed() {
    $("unzoom").hidden = !this.charts.touched;
    this.remember();
  }

  fillCharted() {
    $("charted").replaceChildren(
      ...this.charts.all.map((panel) => {
        const box = element("input", { type: "checkbox", id: `chart-${panel.id}`, checked: this.charts.shown.has(panel.id) });
        box.addEventListener("change", () => {
          if (box.checked) this.charts.shown.add(panel.id);
          else this.charts.shown.delete(panel.id);
          this.charts.rebuild();
          this.remember();
        });
        return element("label", { for: box.id }, box, panel.title);
      }),
    );
  }

  // -- settings

  setTheme(theme) {
    this.theme = this.scene.theme = this.charts.theme = theme;
    document.documentElement.dataset.theme = theme;
    if (this.colour) {
      this.scene.drawer.setPalette(palette(this.colour, theme));
      legend($("legend"), this.colour, theme, this.part.seconds || 1);
    }
    this.scene.request();
    this.charts.draw();
  }

  link() {
    const { charts, part } = this;
    return written({
      v: this.scene.camera.state(),
      c: this.colour?.id,
      t: this.now >= 0 ? Number((this.now * part.period).toFixed(6)) : undefined,
      x: charts.touched ? charts.range.map((v) => Number(v.toFixed(6))).join(",") : undefined,
      g: charts.all ? [...charts.shown].join(",") : this.settings.g,
      m: ["part", "rapids", "grid", "others", ...Object.keys(MARKS)].filter((kind) => $(`mark-${kind}`) && !$(`mark-${kind}`).checked).join(",") || "none",
      p: this.tab,
      l: this.selected?.join(","),
      theme: this.settings.theme,
    });
  }

  /** Put the view into the address, a moment after the last change. */
  remember() {
    clearTimeout(this.remembering);
    this.remembering = setTimeout(() => {
      if (!this.part.ready) return;
      this.tell();
      try {
        history.replaceState(null, "", this.link());
      } catch {
        // A frame without an address of its own (a notebook) has no link.
      }
    }, 250);
  }

  // -- pointer and keys

  listen() {
    this.listenToPath();
    new ResizeObserver(() => this.scene.resize()).observe($("stage"));
    new ResizeObserver(() => this.charts.draw()).observe($("charts"));
    for (const button of document.querySelectorAll("[data-view]")) button.addEventListener("click", () => this.look(button.dataset.view));
    $("colour").addEventListener("change", () => this.setColour($("colour").value));
    $("play").addEventListener("click", () => this.play());
    $("scrub").addEventListener("input", () => this.seek(Math.round(Number($("scrub").value))));
    $("unzoom").addEventListener("click", () => this.charts.setRange(0, this.charts.whole));
    $("theme").addEventListener("click", () => this.switchTheme());
    $("help").addEventListener("click", () => $("keys").showModal());
    $("share").addEventListener("click", () => this.copyLink());
    addEventListener("keydown", (event) => this.key(event));
    addEventListener("beforeprint", () => this.print());
    addEventListener("hashchange", () => this.charts.all && this.restore(location.hash));
    heed(({ view, t_s: moment }) => {
      if (!this.charts.all) return;
      if (view !== undefined) this.restore(view);
      if (moment !== undefined) this.go(this.part.rowAt(moment));
    });
  }

  switchTheme() {
    this.settings.theme = this.theme === "dark" ? "light" : "dark";
    this.setTheme(this.settings.theme);
    this.remember();
  }

  async copyLink() {
    history.replaceState(null, "", this.link());
    try {
      await navigator.clipboard.writeText(location.href);
      $("share").textContent = "Copied";
    } catch {
      $("share").textContent = "In the address";
    }
    setTimeout(() => ($("share").textContent = "Link"), 1600);
  }

  listenToPath() {
    const canvas = $("path"), held = new Map();
    let moved = 0, pinch = 0;
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      held.set(event.pointerId, [event.clientX, event.clientY]);
      this.scene.held = true;
      moved = pinch = 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = held.get(event.pointerId), { camera } = this.scene;
      if (!before) {
        if (event.pointerType !== "touch") this.setHover(this.scene.rowAt(event.offsetX, event.offsetY));
        return this.tip(event);
      }
      const dx = event.clientX - before[0], dy = event.clientY - before[1];
      held.set(event.pointerId, [event.clientX, event.clientY]);
      moved += Math.abs(dx) + Math.abs(dy);
      if (held.size === 2) {
        const [[ax, ay], [bx, by]] = [...held.values()], length = Math.hypot(bx - ax, by - ay);
        const box = canvas.getBoundingClientRect();
        if (pinch) camera.zoom(length / pinch, (ax + bx) / 2 - box.left, (ay + by) / 2 - box.top);
        pinch = length;
        camera.pan(dx / 2, dy / 2);
      } else if (event.shiftKey || event.buttons & 6) camera.pan(dx, dy);
      else camera.orbit(dx, dy);
      this.scene.request(true);
    });
    const release = (event) => {
      if (held.delete(event.pointerId) && moved < 4 && event.type === "pointerup" && event.button === 0) {
        const row = this.scene.rowAt(event.offsetX, event.offsetY);
        if (row >= 0) this.seek(row);
      }
      this.scene.held = held.size > 0;
      this.remember();
    };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointerleave", (event) => {
      this.setHover(-1);
      this.tip(event);
    });
    canvas.addEventListener("dblclick", () => this.look("fit"));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.scene.camera.zoom(Math.exp(-event.deltaY * 0.0016), event.offsetX, event.offsetY);
      this.scene.request(true);
      this.remember();
    }, { passive: false });
  }

  look(name) {
    const { camera } = this.scene;
    if (name !== "fit") camera.look(name);
    this.scene.fit();
    this.scene.request(true);
    this.remember();
  }

  key(event) {
    const typing = /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) && event.target.type !== "range" && event.target.type !== "checkbox";
    if (typing || event.ctrlKey || event.metaKey || event.altKey || $("keys").open) return;
    const far = Math.max(1, Math.round(this.part.rows / 100));
    const step = event.shiftKey ? far : 1;
    const button = event.target.tagName === "BUTTON" || event.target.tagName === "SUMMARY";
    const actions = {
      " ": () => !button && this.play(),
      ArrowRight: () => this.seek(this.now + step),
      ArrowLeft: () => this.seek(this.now - step),
      Home: () => this.seek(0),
      End: () => this.seek(this.part.rows - 1),
      1: () => this.look("iso"),
      2: () => this.look("top"),
      3: () => this.look("front"),
      4: () => this.look("side"),
      f: () => this.look("fit"),
      "+": () => this.charts.zoom(0.6, this.now * this.part.period),
      "=": () => this.charts.zoom(0.6, this.now * this.part.period),
      "-": () => this.charts.zoom(1 / 0.6, this.now * this.part.period),
      "/": () => $("tab-program") && (this.setTab("program"), $("search").focus()),
      l: () => this.nextLoss(),
      t: () => this.switchTheme(),
      "?": () => $("keys").showModal(),
    };
    const action = actions[event.key] ?? actions[event.key.toLowerCase()];
    if (!action || !this.part.ready || action() === false) return;
    event.preventDefault();
  }

  nextLoss() {
    const { places } = this.part.header;
    if (!places.length) return;
    this.loss = ((this.loss ?? -1) + 1) % places.length;
    this.setTab("losses");
    this.go(this.part.rowAt(places[this.loss].t_s));
  }

  /** Put the picture where a printer finds it, in colours for white paper, and give the charts their size on it. */
  print() {
    const { theme } = this, { classList } = document.documentElement;
    const { scale } = this.scene.camera;
    const end = () => {
      classList.remove("paper");
      this.setTheme(theme);
      this.scene.resize();
      this.scene.camera.scale = scale;
    };
    addEventListener("afterprint", end, { once: true });
    classList.add("paper");
    this.setTheme("light");
    // The view of the screen, in the frame of the paper.
    this.scene.resize();
    this.scene.draw();
    this.charts.paintAll();
    const sheet = document.createElement("canvas"), { canvas } = this.scene;
    sheet.width = canvas.width;
    sheet.height = canvas.height;
    const g = sheet.getContext("2d");
    for (const layer of [canvas, $("over")]) g.drawImage(layer, 0, 0);
    $("printed").src = sheet.toDataURL();
  }
}

/** Return what covers the path, in pixels: the buttons its upper edge, and the legend its lower right corner. */
function covered() {
  const legend = $("legend"), { clientWidth: width, clientHeight: height } = $("stage"), views = document.querySelector(".views");
  const [right, below] = legend.childElementCount ? [width - legend.offsetLeft, height - legend.offsetTop] : [0, 0];
  return { right, below, above: views.offsetTop + views.offsetHeight };
}

function decimalsOf(period) {
  return (String(Number(period.toPrecision(6))).split(".")[1] ?? "").length;
}

if (typeof document === "undefined") {
  self.onmessage = ({ data }) => prepare(data, (message, buffers) => self.postMessage(message, [...new Set(buffers)]));
} else {
  /** For tests and for those who read on: the page, its parts and its signals. */
  window.cncgen = new Page();
}
