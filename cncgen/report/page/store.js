// One plan of the page: its header, and its signals once they are decoded.

import { runAt } from "./decode.js";
import { rowsByLine, stretches, toolRuns } from "./lines.js";
import { stepped } from "./format.js";

const ORDERS = { vel: "velocity", acc: "acceleration", jerk: "jerk" };
const OF_AXES = Object.fromEntries(Object.entries(ORDERS).map(([order, name]) => [name, order]));
/** An axis holds the motion back where it comes so near to its own limit. */
const HELD = 0.9;

export class Part {
  constructor(header, limits) {
    this.header = header;
    this.limits = limits;
    this.axes = header.axes;
    this.rows = header.rows;
    this.period = header.period_s;
    this.bands = null;
    this.texts = null;
    this.ready = false;
  }

  /** Take what the worker decoded of the path. */
  takePath(message) {
    Object.assign(this, { row: message.rows, run: message.runs, corners: message.corners, points: message.points });
    Object.assign(this, { classes: message.classes, levels: message.levels, unit: message.unit });
    this.position = this.axes.map((axis) => this.row[this.positionName(axis)]);
    if (this.run.line) {
      this.stretches = stretches(this.run.line, this.run.source, this.rows);
      this.lineRows = rowsByLine(this.stretches);
    }
    this.tools = toolRuns(this.header.events, this.period, this.rows);
    this.ready = true;
  }

  /** Take the lines of another part where this one has none: those at the same share of the length of the path. */
  borrowLines(other) {
    if (this.stretches || !other.stretches) return;
    this.run.line = borrowed(lengths(this.points), lengths(other.points), other.run.line);
    this.run.source = other.run.source && borrowed(lengths(this.points), lengths(other.points), other.run.source);
    this.stretches = stretches(this.run.line, this.run.source, this.rows);
    this.lineRows = rowsByLine(this.stretches);
    this.borrows = true;
  }

  positionName(axis) {
    return `${axis.letter.toLowerCase()}_${axis.unit}`;
  }

  /** Cycle time as the summary has it, up to a period before the last setpoint; of setpoints from elsewhere the time of the last one. */
  get seconds() {
    return this.header.summary.cycle_time_s ?? Math.max(0, this.rows - 1) * this.period;
  }

  /** Return the time of a row: the last one's is the cycle time. */
  timeOf(row) {
    return Math.min(row * this.period, this.seconds);
  }

  rowAt(time) {
    return Math.max(0, Math.min(this.rows - 1, Math.round(time / this.period)));
  }

  /** Names of the signals that can be charted. */
  names() {
    return Object.keys(this.header.streams).filter((name) => this.row?.[name] || this.bands?.[name]);
  }

  spec(name) {
    return this.header.streams[name];
  }

  /** Return a signal as { low, high, block, step }: rows are blocks of one. */
  signal(name) {
    if (this.bands?.[name]) return this.bands[name];
    const rows = this.row?.[name];
    return rows ? { low: rows, high: rows, block: 1, step: this.spec(name).step } : null;
  }

  /** Return a signal's value at a row as text, to the printed digit; of a block its lowest and highest value. */
  text(name, row) {
    const signal = this.signal(name);
    if (!signal) return "";
    const k = Math.floor(row / signal.block);
    const low = stepped(signal.low[k], signal.step);
    return signal.block === 1 || signal.low[k] === signal.high[k] ? low : `${low} … ${stepped(signal.high[k], signal.step)}`;
  }

  /** Return a value of a signal of runs at a row; undefined where there is none. */
  runValue(name, row) {
    const run = this.run?.[name];
    return run && run.values.length ? run.values[runAt(run.starts, row)] : undefined;
  }

  line(row) {
    return this.runValue("line", row);
  }

  source(row) {
    return this.runValue("source", row) ?? 0;
  }

  /** Return what holds the speed back at a row: "feed", or "X jerk" where it is the limit of an axis, "axis jerk" where none is near its own; "" where nobody knows. */
  limit(row) {
    const found = this.runValue("limit", row);
    return found === undefined ? "" : this.held(found, row);
  }

  held(limit, row, bounds = this.bounds(limit)) {
    let most = HELD, held = bounds.length ? "axis " : "";
    for (const { letter, signal, bound } of bounds) {
      const k = Math.floor(row / signal.block), part = (Math.max(Math.abs(signal.low[k]), Math.abs(signal.high[k])) * signal.step) / bound;
      if (part > most) [most, held] = [part, `${letter} `];
    }
    return held + (this.limits[limit] ?? String(limit));
  }

  /** Return the signals of the axes that a limit bounds, with their bounds. */
  bounds(limit) {
    const order = OF_AXES[this.limits[limit]];
    if (!order) return [];
    const found = this.axes.map((axis) => {
      const { name, limit: bound } = this.axisSignal(order, axis);
      return { letter: axis.letter, signal: this.signal(name), bound };
    });
    return found.filter(({ signal, bound }) => signal && bound);
  }

  /** Return what holds the speed back in stretches of rows: { value, start, stop }. */
  *heldRuns() {
    const { values, starts } = this.run.limit;
    for (let k = 0; k < values.length; k++) {
      const bounds = this.bounds(values[k]), block = bounds[0]?.signal.block ?? Infinity;
      for (let start = starts[k]; start < starts[k + 1]; ) {
        const stop = Math.min(starts[k + 1], block * (Math.floor(start / block) + 1) || Infinity);
        yield { value: this.held(values[k], start, bounds), start, stop };
        start = stop;
      }
    }
  }

  /** Return the programmed feed in mm/s at a row, 0 in a rapid, or undefined. */
  programmed(row) {
    const found = this.runValue("programmed_feed_mm_s", row);
    return found === undefined ? undefined : found * this.spec("programmed_feed_mm_s").step;
  }

  /** Return the feed at a row as { value, text }: as the plan has it, else from the way between two rows. */
  feed(row) {
    const kept = this.row.feed_mm_s;
    if (kept) {
      const step = this.spec("feed_mm_s").step;
      return { value: kept[row] * step, text: stepped(kept[row], step) };
    }
    const value = this.chordSpeed(row);
    return { value, text: `≈ ${value.toFixed(0)}` };
  }

  /** Return the speed in mm/s from the rows before and after a row. */
  chordSpeed(row) {
    const a = Math.max(0, row - 1), b = Math.min(this.rows - 1, row + 1);
    if (a === b) return 0;
    let square = 0;
    for (const axis of this.points) square += (axis[b] - axis[a]) ** 2;
    return Math.sqrt(square) / ((b - a) * this.period);
  }

  /** Return the name of what belongs to an order of derivative of an axis, and its limit. */
  axisSignal(order, axis) {
    const power = { vel: "_s", acc: "_s2", jerk: "_s3" }[order];
    return { name: `${axis.letter.toLowerCase()}_${order}_${axis.unit}${power}`, limit: axis.limits[ORDERS[order]] };
  }

  toolAt(row) {
    let found = this.tools[0];
    for (const run of this.tools) if (run.start <= row) found = run;
    return found?.tool ?? 0;
  }
}

/** Return the length of path up to each row. */
function lengths([x, y, z]) {
  const found = new Float64Array(x.length);
  for (let k = 1; k < x.length; k++) found[k] = found[k - 1] + Math.hypot(x[k] - x[k - 1], y[k] - y[k - 1], z[k] - z[k - 1]);
  return found;
}

/** Return a signal of runs over rows with some lengths of path, as it is at the same shares of another path. */
function borrowed(here, there, signal) {
  const values = [], starts = [0];
  const factor = (there[there.length - 1] || 1) / (here[here.length - 1] || 1);
  let row = 0;
  for (let k = 0; k < signal.values.length; k++) {
    const end = signal.starts[k + 1], until = end < there.length ? there[end] : Infinity;
    const first = row;
    while (row < here.length && here[row] * factor < until) row++;
    if (k === signal.values.length - 1) row = here.length;
    if (row > first) {
      values.push(signal.values[k]);
      starts.push(row);
    }
  }
  return { values, starts };
}
