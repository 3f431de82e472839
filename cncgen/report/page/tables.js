// The tables beside the picture: where time is lost, where it goes, what was checked, and what differs.

import { colouring } from "./colouring.js";
import { along, lineKey, rowsByValue, toolName } from "./lines.js";
import { brief, duration, partly, rounded, share } from "./format.js";

/** Return an element with attributes and children; texts are never markup. */
export function element(name, attributes = {}, ...children) {
  const found = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === false || value === undefined || value === null) continue;
    if (key === "class") found.className = value;
    else found.setAttribute(key, value === true ? "" : String(value));
  }
  found.append(...children.filter((child) => child !== null && child !== undefined));
  return found;
}

/** A key or a name of a plan, which a browser may end a line in behind its signs. */
const breakable = (name) => name.split(/(?<=[._=,/])(?!\d)/).flatMap((word) => [element("wbr"), word]).slice(1);

function table(label, header, rows) {
  const cells = rows[0]?.children ?? [];
  const head = element("tr", {}, ...header.map((text, k) => element("th", { scope: "col", class: cells[k]?.className || null }, ...breakable(text))));
  return element("table", { "aria-label": label }, element("thead", {}, head), element("tbody", {}, ...rows));
}

function bar(part) {
  const found = element("span", { class: "bar", "aria-hidden": "true" });
  found.style.setProperty("--part", String(Math.max(0, Math.min(1, part))));
  return found;
}

/** Name a line: with its file where the program has several and it is not the first. */
export function lineName(part, source, line) {
  const file = source ? part.header.sources[source]?.name : "";
  return `line ${line}${file ? ` of ${file.split(/[\\/]/).pop()}` : ""}`;
}

const keyName = (part, key) => lineName(part, Math.floor(key / 2 ** 32), key % 2 ** 32);

/** Name a place: its line, how far along it where it is long; of a row the line that it is on. */
export function placeName(part, row, source = part.source(row), line = part.line(row)) {
  if (!line) return `at ${duration(row * part.period)}`;
  const visits = part.stretches?.visits.get(lineKey(source, line)), name = lineName(part, source, line);
  if (!visits) return name; // of a line between two setpoints
  const { starts } = part.stretches, away = (k) => Math.max(starts[k] - row, row - starts[k + 1], 0);
  const k = visits.reduce((best, one) => (away(one) < away(best) ? one : best));
  const long = starts[k + 1] - starts[k] > 200;
  return long ? `${name}, ${partWay(Math.round(100 * along(part.position, starts[k], starts[k + 1], row)))}` : name;
}

const partWay = (percent) => (percent === 0 ? "at its start" : percent === 100 ? "at its end" : `${percent} % along`);

export function positionText(part, row) {
  return part.axes.map((axis) => `${axis.letter}${part.text(part.positionName(axis), row).replace(/0$/, "")}`).join(" ");
}

/** Words that no line ends within: a browser ends lines behind the sign of "A-0.5". */
const unbroken = (text) => text.split(" ").flatMap((word) => [" ", element("span", { class: "word" }, word)]).slice(1);

/** The places where most time is lost; a click goes there. */
export function losses(part, go) {
  const { places } = part.header;
  if (!places.length) return element("p", { class: "note" }, "The motion keeps the programmed feed everywhere.");
  const most = places[0].lost_s, total = places.reduce((sum, place) => sum + place.lost_s, 0);
  const rows = places.map((place, k) => {
    const row = part.rowAt(place.t_s);
    const button = element("button", { class: "link", type: "button" }, placeName(part, row, place.source, place.line));
    button.addEventListener("click", () => go(row));
    const found = element(
      "tr",
      { "data-row": row },
      element("td", { class: "rank" }, String(k + 1)),
      element("td", {}, button, element("small", {}, ...unbroken(positionText(part, row)))),
      element("td", { class: "number" }, brief(place.lost_s), bar(place.lost_s / most)),
      element("td", {}, place.limit, element("small", {}, `at ${rounded(place.feed_mm_s)} mm/s`)),
    );
    found.addEventListener("click", (event) => event.target !== button && go(row));
    return found;
  });
  const note = `${brief(total)} lost at ${places.length} places against the programmed feed, ${share(total / part.seconds)} of the time.`;
  return element("div", {}, element("p", { class: "note" }, note), table("Places where most time is lost", ["", "Place", "Lost", "Held back by"], rows));
}

/** Answers in a row are so many of each kind. */
const ANSWERS = 3;

/**
 * The shortest answers, as links: where most time is lost, what holds the motion back, what would shorten it.
 *
 * `show` has what a click does: `place(row)`, `limits()`, `changes()`.
 */
export function answers(part, show) {
  const { places, why: changes } = part.header;
  const answer = (name, value, act) => {
    const button = element("button", { class: "link", type: "button" }, name, element("small", {}, value));
    button.addEventListener("click", act);
    return button;
  };
  const names = new Set();
  const lost = [];
  for (const place of places) {
    const row = part.rowAt(place.t_s), name = placeName(part, row, place.source, place.line);
    if (names.size < ANSWERS && !names.has(name)) lost.push(answer(name, brief(place.lost_s), () => show.place(row)));
    names.add(name);
  }
  // A stop is an event: the split of the time tells it.
  const limits = part.run.limit ? limitKinds(part).filter(({ name, seconds }) => seconds > 0 && !/^(stop|nothing)$/.test(name)) : [];
  const held = limits.slice(0, ANSWERS).map(({ name, seconds }) => answer(name, share(seconds / (part.seconds || 1)), show.limits));
  const saving = (changes ?? []).filter((item) => item.saved_s > 0).slice(0, ANSWERS);
  const saved = saving.map((item) => answer(`${item.name} ${changeText(item)}`, brief(item.saved_s), show.changes));
  return [["Most time lost", lost], ["Held back by", held], ["Would save most", saved]]
    .filter(([, found]) => found.length)
    .map(([label, found]) => element("span", {}, element("b", {}, label), ...found));
}

/** Return the limits with the time of each, the longest first; found once. */
function limitKinds(part) {
  return (part.limitKinds ??= colouring(part, "limit").kinds);
}

const changeText = ({ change }) => `${change > 0 ? "+" : "−"}${Math.round(100 * Math.abs(change))} %`;

/** Parts of the time as a person calls them, where that is not their key. */
const PARTS = { tool: "tool changes", stops: "operator stops" };

/** Return the events that take no time since the machine has no [times]: "" without any. */
export function untimed(part) {
  const { untimed_events: events, machine } = part.header.summary;
  const told = Object.entries(events ?? {}).map(([name, count]) => `${count} ${UNTIMED[name]}${count > 1 ? "s" : ""}`);
  return told.length ? `${told.join(", ")} taken as instant: ${machine} has no [times].` : "";
}

/** Return what the cycle time leaves out, in a few words. */
export function untimedBadge(part) {
  const [[name, count]] = Object.entries(part.header.summary.untimed_events);
  return `without ${UNTIMED[name]}${count > 1 ? "s" : ""}`;
}

const UNTIMED = { tool: "tool change", spindle: "spindle command", stop: "operator stop" };

/** Return how the time is split: [{ name, seconds, kind }]. The summary's own split goes first. */
export function timeSplit(part) {
  const given = part.header.summary.cycle_time_split_s;
  if (given) {
    return Object.entries(given)
      .filter(([, seconds]) => seconds > 0)
      .map(([name, seconds]) => ({ name: PARTS[name] ?? name, seconds, kind: name }));
  }
  const run = part.run.programmed_feed_mm_s;
  const dwell = part.header.summary.dwell_time_s ?? 0;
  if (!run) return [{ name: "motion", seconds: part.seconds, kind: "cutting" }];
  const rapid = (rowsByValue(run, part.rows).get(0) ?? 0) * part.period;
  const found = [{ name: "cutting", seconds: part.seconds - rapid - dwell, kind: "cutting" }];
  if (rapid > 0) found.push({ name: "rapid", seconds: rapid, kind: "rapid" });
  if (dwell > 0) found.push({ name: "dwell", seconds: dwell, kind: "dwell" });
  return found.filter((item) => item.seconds > 0);
}

function shares(title, items, whole) {
  const most = Math.max(...items.map((item) => item.seconds));
  const rows = items.map((item) =>
    element(
      "tr",
      {},
      element("td", {}, item.name),
      element("td", { class: "number" }, partly(item.seconds, most)),
      element("td", { class: "number" }, share(item.seconds / whole), bar(item.seconds / whole)),
    ),
  );
  return element("section", {}, element("h3", {}, title), table(title, ["", "Time", "Share"], rows));
}

/** Where the time goes: by kind of motion, tool, operation, limit, feed and line; and what would shorten it. */
export function times(part, go) {
  const whole = part.seconds || 1, found = [shares("By kind", timeSplit(part), whole)];
  if (untimed(part)) found[0].append(element("p", { class: "note" }, untimed(part)));
  if (part.header.why?.length) found.push(why(part, go));
  const tools = byTool(part);
  if (tools.length > 1 || tools[0].tool) found.push(shares("By tool", tools, whole));
  const operations = byOperation(part);
  if (operations.length > 1) found.push(shares("By operation", operations, whole));
  if (part.run.limit) found.push(shares("By what limits it", limitKinds(part).filter((kind) => kind.seconds > 0), whole));
  if (part.lineRows) found.push(byLine(part, whole, go));
  if (!part.header.why?.length) found.push(element("p", { class: "note" }, "With --why the page ranks what would shorten the part."));
  return element("div", {}, ...found);
}

function byTool(part) {
  const totals = new Map();
  for (const { tool, start, stop } of part.tools) {
    const rows = Math.max(0, Math.min(stop, part.rows - 1) - start);
    totals.set(tool, (totals.get(tool) ?? 0) + rows * part.period);
  }
  return sorted([...totals].map(([tool, seconds]) => ({ tool, name: toolName(tool), seconds })));
}

/** Operations run from one message or comment that names one to the next. */
function byOperation(part) {
  const named = part.header.events.filter((event) => event.event === "operation" || event.event === "workingstep" || event.event === "message");
  const marks = [{ name: "start", row: 0 }, ...named.map((event) => ({ name: event.text ?? event.name ?? event.event, row: part.rowAt(event.t_s) }))];
  const totals = new Map();
  marks.forEach((mark, k) => {
    const stop = k + 1 < marks.length ? marks[k + 1].row : part.rows - 1;
    totals.set(mark.name, (totals.get(mark.name) ?? 0) + Math.max(0, stop - mark.row) * part.period);
  });
  return [...totals].map(([name, seconds]) => ({ name: String(name), seconds })).filter((item) => item.seconds > 0);
}

function sorted(items) {
  return items.sort((a, b) => b.seconds - a.seconds);
}

/** The ranking of `cncgen why`: what each change saves, by a plan and at first, and the lines that save most. */
function why(part, go) {
  const most = part.header.why[0].saved_s;
  const rows = part.header.why.map((item) => {
    const { kind } = item, about = `${brief(item.estimate_s)} ± ${brief(item.bound_s)}`;
    const first = { smooth: brief(item.estimate_s), kink: item.sides_s.map(brief).join(" | "), scatter: about, bend: about, "few plans": about }[kind] ?? kind;
    const change = changeText(item);
    return element(
      "tr",
      {},
      element("td", {}, element("span", {}, ...breakable(item.name)), element("small", {}, item.value ? `${item.value}, ${change}` : change), ...saving(part, item.lines, go)),
      element("td", { class: "number" }, brief(item.saved_s), bar(item.saved_s / most)),
      element("td", { class: "number" }, first),
    );
  });
  const note = "What a change saves: planned, and by the time's derivative. Where the time has a kink, a | b: the change saves a at first, its opposite costs b; where plans scatter by b, a slope changes by b within 5 %, or b is too small a part of the cycle for more plans, a ± b.";
  const title = "What would shorten it";
  return element("section", { id: "changes" }, element("h3", {}, title), element("p", { class: "note" }, note), table(title, ["Change", "Saves", "Derivative"], rows));
}

/** The lines that save most, as links to where they begin. */
function saving(part, lines, go) {
  const found = lines.map(({ source, line, saved_s: saved }) => {
    const index = Math.max(0, part.header.sources.findIndex((file) => file.name === source));
    const visits = part.stretches?.visits.get(lineKey(index, line));
    const name = `${lineName(part, index, line)}: ${brief(saved)}`;
    if (!visits) return element("span", {}, name);
    const button = element("button", { class: "link", type: "button" }, name);
    button.addEventListener("click", () => go(part.stretches.starts[visits[0]]));
    return button;
  });
  return found.length ? [element("small", { class: "saving" }, ...found)] : [];
}

function byLine(part, whole, go) {
  const longest = [...part.lineRows].sort((a, b) => b[1] - a[1]).slice(0, 25);
  const rows = longest.map(([key, count]) => {
    const first = part.stretches.starts[part.stretches.visits.get(key)[0]];
    const button = element("button", { class: "link", type: "button" }, keyName(part, key));
    button.addEventListener("click", () => go(first));
    const seconds = count * part.period;
    return element("tr", {}, element("td", {}, button), element("td", { class: "number" }, brief(seconds)), element("td", { class: "number" }, share(seconds / whole), bar(seconds / whole)));
  });
  const title = `Longest of ${part.lineRows.size.toLocaleString("en")} lines`;
  return element("section", {}, element("h3", {}, title), table(title, ["", "Time", "Share"], rows));
}

/** What was checked: the verdict, the peaks beside their limits, and what reader and planner remark. */
export function checks(part, go) {
  const { verdict, summary } = part.header, found = [];
  if (verdict) found.push(judged(part, verdict, go));
  else found.push(element("p", { class: "note" }, "The setpoints were not verified: the program cannot be read again."));
  if (part.header.removal) found.push(removed(part, part.header.removal, go));
  if (summary.peak) found.push(peaks(summary.peak));
  if (summary.diagnostics?.length) found.push(remarks(summary.diagnostics));
  return element("div", {}, ...found);
}

function judged(part, verdict, go) {
  const distance = `Setpoints are at most ${(1000 * verdict.setpoints_to_path_mm).toFixed(3)} µm from the path, the path at most ${(1000 * verdict.path_to_setpoints_mm).toFixed(3)} µm from the setpoints.`;
  const head = element("p", {}, element("strong", { class: verdict.holds ? "good" : "bad" }, verdict.holds ? "Every limit holds." : "Limits are broken."), ` ${distance}`);
  const items = verdict.breaches.map((item) => {
    const found = element("li", { class: item.severity }, item.message);
    if (item.t_s === undefined || item.t_s === null) return found;
    const button = element("button", { class: "link", type: "button" }, "Show");
    button.addEventListener("click", () => go(part.rowAt(item.t_s)));
    found.append(" ", button);
    return found;
  });
  return element("section", {}, element("h3", {}, "Verified"), head, items.length ? element("ul", {}, ...items) : null);
}

/** What is cut of the stock, and what is wrong with it. */
function removed(part, removal, go) {
  const { removed_mm3: volume, raw_volume_mm3: raw, cell_mm: cell, findings } = removal;
  const head = element("p", {}, `${rounded(volume)} of ${rounded(raw)} mm³ removed, ${share(volume / raw)}; ${part.header.turned ? "in rings" : "on a grid"} of ${rounded(cell)} mm. `);
  if (!findings.length) head.append(element("strong", { class: "good" }, "Nothing is wrong with the cut."));
  const items = findings.map((item) => {
    const found = element("li", { class: item.severity }, item.message), visits = part.stretches?.visits.get(lineKey(0, item.line));
    if (!visits) return found;
    const button = element("button", { class: "link", type: "button" }, `Line ${item.line}`);
    button.addEventListener("click", () => go(part.stretches.starts[visits[0]]));
    found.append(" ", button);
    return found;
  });
  return element("section", {}, element("h3", {}, "Material removal"), head, items.length ? element("ul", {}, ...items) : null);
}

function peaks(peak) {
  const names = ["velocity", "acceleration", "jerk"], powers = ["", "²", "³"];
  const rows = Object.entries(peak).map(([letter, values]) =>
    element(
      "tr",
      {},
      element("td", {}, letter.toUpperCase()),
      ...names.map((name, k) => {
        const part = values[`${name}_of_limit`];
        const cell = element("td", { class: "number" }, `${rounded(values[name])} ${values.unit}/s${powers[k]}`);
        if (part !== null && part !== undefined) cell.append(element("small", {}, `${(100 * part).toFixed(1)} % of limit`), bar(part));
        return cell;
      }),
    ),
  );
  return element("section", {}, element("h3", {}, "Peaks"), table("Peaks of the axes", ["Axis", ...names], rows));
}

function remarks(diagnostics) {
  const rows = diagnostics.map((item) =>
    element("tr", {}, element("td", { class: "number" }, item.line ? String(item.line) : ""), element("td", { class: item.severity }, item.severity), element("td", {}, item.message, element("small", {}, item.code))),
  );
  return element("section", {}, element("h3", {}, "Diagnostics"), table("Diagnostics", ["Line", "", "Message"], rows));
}

/** What differs between the plan and another one: times, and the lines with the largest differences. */
export function differences(part, others, go) {
  const rows = [part, ...others].map((one) => {
    const { label, machine, summary } = one.header, change = one.seconds - part.seconds;
    const about = element("small", {}, [machine, summary.feedrate].filter((text) => text && text !== label).join(", "));
    const length = summary.path_length_mm === undefined ? "" : `${summary.path_length_mm.toFixed(3)} mm`;
    const time = element("td", { class: "number" }, duration(one.seconds));
    if (one !== part) time.append(element("small", { class: changeClass(change) }, signed(change)));
    return element("tr", {}, element("td", {}, ...breakable(label), about), time, element("td", { class: "number" }, length));
  });
  const found = [element("section", {}, element("h3", {}, "Side by side"), table("Plans side by side", ["", "Time", "Path"], rows))];
  if (others.some((other) => other.borrows)) found.push(element("p", { class: "note" }, "Setpoints without lines are matched with the plan by the length of the path."));
  for (const other of others) if (part.lineRows && other.lineRows) found.push(byDifference(part, other, go));
  return element("div", {}, ...found);
}

const changeClass = (seconds) => (seconds > 0 ? "slower" : seconds < 0 ? "faster" : "");

function signed(seconds) {
  return `${seconds > 0 ? "+" : seconds < 0 ? "−" : ""}${brief(Math.abs(seconds))}`;
}

function byDifference(part, other, go) {
  const keys = new Set([...part.lineRows.keys(), ...other.lineRows.keys()]);
  const changes = [...keys].map((key) => {
    const here = (part.lineRows.get(key) ?? 0) * part.period, there = (other.lineRows.get(key) ?? 0) * other.period;
    return { key, here, there, change: there - here };
  });
  const largest = changes.sort((a, b) => Math.abs(b.change) - Math.abs(a.change)).slice(0, 25).filter((one) => one.change);
  const rows = largest.map(({ key, here, there, change }) => {
    const visit = part.stretches.visits.get(key);
    const button = element("button", { class: "link", type: "button", disabled: !visit }, keyName(part, key));
    if (visit) button.addEventListener("click", () => go(part.stretches.starts[visit[0]]));
    const cell = element("td", { class: `number ${changeClass(change)}` }, signed(change));
    return element("tr", {}, element("td", {}, button), element("td", { class: "number" }, brief(here)), element("td", { class: "number" }, brief(there)), cell);
  });
  const title = `Lines that ${other.header.label} changes most`;
  if (!rows.length) return element("section", {}, element("h3", {}, title), element("p", { class: "note" }, "No line takes another time."));
  return element("section", {}, element("h3", {}, title), table(title, ["", part.header.label, other.header.label, "Difference"], rows));
}

