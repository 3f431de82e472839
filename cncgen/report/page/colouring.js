// What the path is coloured by: a byte a row, the colours of the bytes, and how much time each has.

import { rounded } from "./format.js";
import { runAt } from "./decode.js";
import { toolName } from "./lines.js";

const SLOW_FAST = {
  dark: ["#ff4d4d", "#ff8a4c", "#ffc857", "#d9e57b", "#7fd8c2", "#4fa8ff", "#7b8cff"],
  light: ["#b3122d", "#d9541e", "#c98a00", "#7d9a1f", "#128a7e", "#1668c7", "#3a3fb5"],
};
const CALM_HOT = { dark: [...SLOW_FAST.dark].reverse(), light: [...SLOW_FAST.light].reverse() };
const PASSING = {
  dark: ["#5b6ee1", "#3f9fd6", "#39c5a8", "#9bd85a", "#f4d35e"],
  light: ["#43338f", "#2c6ab0", "#16897f", "#5f9a2a", "#c79a00"],
};
// Colours that can be told apart with any colour vision, after Okabe and Ito (2008), lightened for the dark.
const KINDS = {
  dark: ["#56b4e9", "#e69f00", "#2fc795", "#f0e442", "#4f8ff0", "#f26b3a", "#d98cc0", "#b7bcc6", "#9a7bff", "#ff8fa3", "#8dd3c7", "#c7a76c"],
  light: ["#0072b2", "#d08700", "#009e73", "#a89a00", "#004488", "#d55e00", "#b2528b", "#6c7380", "#6a3dad", "#c23b57", "#2b7f73", "#7a5a1c"],
};
const BINS = 96;
const OTHER = KINDS.dark.length - 1;

/** Return the colours of 256 bytes as RGBA. */
export function palette(colouring, theme) {
  const bytes = new Uint8Array(1024);
  for (let k = 0; k < 256; k++) {
    const [r, g, b] = colourOf(colouring, k, theme);
    bytes.set([r, g, b, 255], 4 * k);
  }
  return bytes;
}

/** Return the colour of a byte as [r, g, b]. */
export function colourOf(colouring, byte, theme) {
  if (colouring.kinds) return hex(KINDS[theme][byte % KINDS[theme].length]);
  const ramp = { slow: SLOW_FAST, hot: CALM_HOT, passing: PASSING }[colouring.ramp][theme];
  const place = (byte / 255) * (ramp.length - 1);
  const k = Math.min(ramp.length - 2, Math.floor(place));
  const [p, q] = [hex(ramp[k]), hex(ramp[k + 1])];
  return p.map((v, i) => Math.round(v + (place - k) * (q[i] - v)));
}

export function css(rgb) {
  return `rgb(${rgb[0]} ${rgb[1]} ${rgb[2]})`;
}

function hex(text) {
  return [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16));
}

/** Return what a part can be coloured by: [{ id, label }] in groups. */
export function choices(part) {
  const found = [{ id: "feed", label: "Feed", group: "Motion" }];
  if (part.run.programmed_feed_mm_s) found.push({ id: "ratio", label: "Feed / programmed feed", group: "Motion" });
  if (part.run.limit) found.push({ id: "limit", label: "What limits it", group: "Motion" });
  for (const [order, title] of [["acc", "Acceleration"], ["jerk", "Jerk"]]) {
    for (const axis of part.axes) {
      const { name } = part.axisSignal(order, axis);
      if (part.spec(name)) found.push({ id: name, label: `${title} ${axis.letter}`, group: "Axes, share of limit" });
    }
  }
  if (part.spec("contour_error_mm")) found.push({ id: "contour_error_mm", label: "Contour error", group: "Servo" });
  if (part.spec("reference_contour_mm")) found.push({ id: "reference_contour_mm", label: `Contour error from ${part.header.summary.reference.name}`, group: "Servo" });
  for (const axis of part.axes) {
    const name = `${axis.letter.toLowerCase()}_error_${axis.unit}`;
    if (part.spec(name)) found.push({ id: name, label: `Tracking error ${axis.letter}`, group: "Servo" });
  }
  found.push({ id: "time", label: "Time", group: "Program" });
  if (part.tools.length > 1 || part.tools[0].tool) found.push({ id: "tool", label: "Tool", group: "Program" });
  if (part.stretches) found.push({ id: "line", label: "Line", group: "Program" });
  return found;
}

/**
 * Return the colouring of a part by one of its choices.
 *
 * { id, bytes, ramp, low, high, unit, histogram } for numbers, { id, bytes, kinds: [{ name, seconds }] } for kinds.
 */
export function colouring(part, id) {
  if (id === "limit") return byLimit(part);
  if (id === "tool") return byTool(part);
  if (id === "line") return byLine(part);
  if (id === "time") return scaled(part, id, (row) => row * part.period, { ramp: "passing", unit: "s" });
  if (id === "feed") return scaled(part, id, feedOf(part), { ramp: "slow", unit: "mm/s", usual: true });
  if (id === "ratio") return byRatio(part);
  return bySignal(part, id);
}

/** Return a function from a row to its feed, quick enough for all rows. */
export function feedOf(part) {
  const rows = part.row.feed_mm_s;
  if (!rows) return (row) => part.chordSpeed(row);
  const step = part.spec("feed_mm_s").step;
  return (row) => rows[row] * step;
}

function byRatio(part) {
  const run = part.run.programmed_feed_mm_s, step = part.spec("programmed_feed_mm_s").step;
  const feed = feedOf(part);
  let k = 0;
  const ratio = (row) => {
    if (run.starts[k] > row) k = runAt(run.starts, row);
    while (run.starts[k + 1] <= row) k++;
    const asked = run.values[k] * step;
    return asked > 0 ? Math.min(1, feed(row) / asked) : 1;
  };
  return scaled(part, "ratio", ratio, { ramp: "slow", unit: "", low: 0, high: 1 });
}

function bySignal(part, name) {
  const signal = part.signal(name);
  if (!signal) return null;
  const axis = part.axes.find((one) => ["acc", "jerk"].some((order) => part.axisSignal(order, one).name === name));
  const order = name.includes("_jerk_") ? "jerk" : "acc";
  const limit = axis ? part.axisSignal(order, axis).limit : undefined;
  const size = (row) => {
    const k = Math.floor(row / signal.block);
    return Math.max(Math.abs(signal.low[k]), Math.abs(signal.high[k])) * signal.step;
  };
  if (limit) return scaled(part, name, (row) => size(row) / limit, { ramp: "hot", unit: "of the limit", low: 0, high: 1 });
  const micro = name.endsWith("_mm");
  return scaled(part, name, (row) => size(row) * (micro ? 1000 : 1), { ramp: "hot", unit: micro ? "µm" : "deg", low: 0, usual: true });
}

function scaled(part, id, value, how) {
  const n = part.rows, values = new Float32Array(n);
  let least = Infinity, most = -Infinity;
  for (let k = 0; k < n; k++) {
    const v = value(k);
    values[k] = v;
    if (v < least) least = v;
    if (v > most) most = v;
  }
  const low = how.low ?? (id === "feed" ? 0 : least);
  let high = how.high ?? most;
  if (how.usual) high = usual(part, values, low, most);
  if (!(high > low)) high = low + (Math.abs(low) || 1);
  const bytes = new Uint8Array(n), histogram = new Float64Array(BINS);
  const factor = 255.999 / (high - low);
  for (let k = 0; k < n; k++) {
    const place = (values[k] - low) * factor;
    const byte = place <= 0 ? 0 : place >= 255 ? 255 : place;
    bytes[k] = byte;
    if (k + 1 < n) histogram[Math.min(BINS - 1, Math.floor((bytes[k] * BINS) / 256))] += part.period;
  }
  return { id, bytes, ramp: how.ramp, low, high, beyond: most > high * (1 + 1e-9) ? most : null, unit: how.unit, histogram };
}

/** Return the value that 99.5 % of the rows keep below, rapids left out, so that a few rows do not take all colours. */
function usual(part, values, low, most) {
  const counts = new Float64Array(1024);
  const run = part.run.programmed_feed_mm_s;
  let total = 0;
  const stride = Math.max(1, Math.floor(values.length / 2e5));
  for (let k = 0, r = 0; k < values.length; k += stride) {
    if (run) {
      while (run.starts[r + 1] <= k) r++;
      if (run.values[r] === 0) continue;
    }
    counts[Math.min(1023, Math.max(0, Math.floor(((values[k] - low) / (most - low || 1)) * 1023)))]++;
    total++;
  }
  if (!total) return most;
  let sum = 0;
  for (let bin = 0; bin < 1024; bin++) {
    sum += counts[bin];
    if (sum >= 0.995 * total) return low + ((bin + 1) / 1023) * (most - low);
  }
  return most;
}

function byRuns(part, id, runs, name) {
  const bytes = new Uint8Array(part.rows), kinds = [], known = new Map();
  for (const { value, start, stop } of runs) {
    let place = known.get(value);
    if (place === undefined) {
      place = known.size;
      known.set(value, place);
      kinds.push({ value, name: name(value), seconds: 0 });
    }
    kinds[place].seconds += Math.max(0, Math.min(stop, part.rows - 1) - start) * part.period;
    bytes.fill(Math.min(place, 255), start, stop);
  }
  // The kinds that take the most time have the first colours; those beyond the last colour share it.
  const order = kinds.map((_, k) => k).sort((a, b) => kinds[b].seconds - kinds[a].seconds);
  const to = new Uint8Array(256);
  order.forEach((from, k) => (to[Math.min(from, 255)] = Math.min(k, OTHER)));
  for (let k = 0; k < bytes.length; k++) bytes[k] = to[bytes[k]];
  return { id, bytes, kinds: order.map((k) => kinds[k]) };
}

function byLimit(part) {
  return byRuns(part, "limit", part.heldRuns(), (value) => value);
}

function byTool(part) {
  const runs = part.tools.map(({ tool, start, stop }) => ({ value: tool, start, stop }));
  return byRuns(part, "tool", runs, toolName);
}

function byLine(part) {
  const found = part.stretches, bytes = new Uint8Array(part.rows);
  for (let k = 0; k < found.keys.length; k++) bytes.fill(k % OTHER, found.starts[k], found.starts[k + 1]);
  return { id: "line", bytes, kinds: [], note: `${found.visits.size} lines; neighbours have different colours` };
}

/** Return the text of a place of the scale of numbers. */
export function scaleText(value, unit, withUnit = true) {
  if (unit === "of the limit" || unit === "") return `${Math.round(100 * value)} %`;
  return `${rounded(value)}${withUnit && unit ? ` ${unit}` : ""}`;
}
