// Charts over time: one above the other on one axis of time and one cursor.

import { rounded, ticks } from "./format.js";
import { cleared } from "./sheet.js";

const LEFT = 58, RIGHT = 12, TOP = 18, BOTTOM = 4;
const COLOURS = {
  dark: ["#56b4e9", "#ff9f45", "#3ddc97", "#f28cc8", "#f0e442", "#a78bfa", "#9aa4b2"],
  light: ["#0b6bb0", "#d55e00", "#00855f", "#b2428b", "#8a7a00", "#6a3dad", "#5c6675"],
};

/** Lowest and highest values of parts of an array, some of them known beforehand, so that a long one is drawn at once. */
export class Extremes {
  constructor(low, high) {
    this.levels = [{ low, high }];
    for (let above = this.levels[0]; above.low.length > 4096; above = this.levels[this.levels.length - 1]) {
      const n = Math.ceil(above.low.length / 16);
      const next = { low: new Float64Array(n), high: new Float64Array(n) };
      for (let k = 0; k < n; k++) {
        let a = Infinity, b = -Infinity;
        const stop = Math.min(above.low.length, 16 * k + 16);
        for (let i = 16 * k; i < stop; i++) {
          if (above.low[i] < a) a = above.low[i];
          if (above.high[i] > b) b = above.high[i];
        }
        next.low[k] = a;
        next.high[k] = b;
      }
      this.levels.push(next);
    }
  }

  /** Return [lowest, highest] of the entries from `start` to before `stop`. */
  between(start, stop) {
    let a = Infinity, b = -Infinity, level = 0;
    const take = (lev, from, to) => {
      const { low, high } = this.levels[lev];
      for (let k = from; k < to; k++) {
        if (low[k] < a) a = low[k];
        if (high[k] > b) b = high[k];
      }
    };
    while (stop - start > 32 && level + 1 < this.levels.length) {
      const first = Math.ceil(start / 16), last = Math.floor(stop / 16);
      take(level, start, Math.min(stop, 16 * first));
      take(level, Math.max(16 * last, 16 * first), stop);
      start = first;
      stop = last;
      level++;
    }
    take(level, start, stop);
    return [a, b];
  }
}

/** Return what a part has to show: [{ id, title, unit, curves: [{ name, label, part }], limits: [number] }]. */
export function panels(parts) {
  const found = [], [first] = parts;
  const add = (id, title, unit, curves, limits = []) => {
    const there = curves.filter((curve) => curve.part.signal(curve.name));
    if (there.length) found.push({ id, title, unit, curves: there, limits });
  };
  const feeds = parts.map((part, k) => ({ part, name: "feed_mm_s", label: k ? part.header.label : "feed", other: k, colour: k }));
  add("feed", "Feed", first.header.summary?.feed_of === "slides" ? "mm/s of the slides" : "mm/s", feeds);
  for (const [order, title, power] of [["vel", "Velocity", ""], ["acc", "Acceleration", "²"], ["jerk", "Jerk", "³"]]) {
    for (const unit of ["mm", "deg"]) {
      const axes = first.axes.filter((axis) => axis.unit === unit);
      const curves = parts.flatMap((part, k) =>
        axes.map((axis, a) => ({ part, name: part.axisSignal(order, axis).name, label: axis.letter + (k ? ` ${part.header.label}` : ""), colour: a, other: k })),
      );
      const limits = axes.map((axis, a) => ({ value: first.axisSignal(order, axis).limit, colour: a })).filter((one) => one.value);
      if (axes.length) add(`${order}-${unit}`, title + (unit === "deg" ? ", rotary" : ""), `${unit}/s${power}`, curves, limits);
    }
  }
  const each = (suffix) => first.axes.map((axis, a) => ({ part: first, name: `${axis.letter.toLowerCase()}_${suffix(axis)}`, label: axis.letter, colour: a }));
  add("contour", "Contour error", "mm", [
    { part: first, name: "contour_error_mm", label: "from the command", colour: 0 },
    { part: first, name: "reference_contour_mm", label: first.header.summary.reference?.name ?? "", colour: 1 },
  ]);
  add("error", "Tracking error", first.axes[0]?.unit ?? "mm", each((axis) => `error_${axis.unit}`));
  add("force", "Force", first.axes[0]?.force_unit || "", each(() => "force"));
  return found;
}

export class Charts {
  /** `on` has functions: hover(row or -1), seek(row), zoomed(). */
  constructor(box, theme, on) {
    this.box = box;
    this.theme = theme;
    this.on = on;
    this.range = [0, 1];
    this.shown = new Set(["feed", "acc-mm", "acc-deg", "jerk-mm", "jerk-deg", "contour"]);
    this.views = [];
    this.hover = this.current = -1;
    this.known = new WeakMap();
    this.axis = document.createElement("canvas");
    this.axis.className = "axis";
    this.axis.setAttribute("aria-hidden", "true");
  }

  setParts(parts) {
    this.parts = parts;
    this.whole = Math.max(...parts.map((part) => part.seconds), 1e-6);
    if (!this.touched) this.range = [0, this.whole];
    this.all = panels(parts);
    this.rebuild();
  }

  rebuild() {
    this.box.replaceChildren();
    this.views = this.all.filter((panel) => this.shown.has(panel.id)).map((panel) => this.view(panel));
    if (this.views.length) this.box.append(this.axis);
    this.draw();
  }

  view(panel) {
    const figure = document.createElement("figure");
    figure.className = "chart";
    const canvas = document.createElement("canvas");
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${panel.title} over time, ${panel.unit}`);
    const caption = document.createElement("figcaption");
    figure.append(caption, canvas);
    this.box.append(figure);
    const view = { panel, canvas, caption, curves: document.createElement("canvas") };
    this.listen(view);
    return view;
  }

  listen(view) {
    const { canvas } = view;
    const timeAt = (event) => this.timeAt(canvas, event.offsetX);
    canvas.addEventListener("pointermove", (event) => {
      if (this.drag) {
        this.drag.to = timeAt(event);
        this.draw();
      }
      this.on.hover(this.parts[0].rowAt(timeAt(event)));
    });
    canvas.addEventListener("pointerleave", () => this.on.hover(-1));
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      canvas.setPointerCapture(event.pointerId);
      this.drag = { from: timeAt(event), to: timeAt(event), x: event.offsetX };
    });
    canvas.addEventListener("pointerup", (event) => {
      const drag = this.drag;
      this.drag = null;
      if (!drag) return;
      if (Math.abs(event.offsetX - drag.x) < 4) this.on.seek(this.parts[0].rowAt(drag.from));
      else this.setRange(Math.min(drag.from, drag.to), Math.max(drag.from, drag.to));
    });
    canvas.addEventListener("dblclick", () => this.setRange(0, this.whole));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) this.shift((event.deltaX || event.deltaY) / 800);
      else this.zoom(Math.exp(event.deltaY * 0.0016), timeAt(event));
    }, { passive: false });
  }

  timeAt(canvas, x) {
    const part = (x - LEFT) / Math.max(1, canvas.clientWidth - LEFT - RIGHT);
    return this.range[0] + Math.max(0, Math.min(1, part)) * (this.range[1] - this.range[0]);
  }

  zoom(factor, about = (this.range[0] + this.range[1]) / 2) {
    const [a, b] = this.range;
    this.setRange(about + (a - about) * factor, about + (b - about) * factor);
  }

  shift(part) {
    const width = this.range[1] - this.range[0];
    const start = Math.max(0, Math.min(this.whole - width, this.range[0] + part * width));
    this.setRange(start, start + width);
  }

  setRange(start, stop) {
    const least = 4 * this.parts[0].period;
    if (stop - start < least) [start, stop] = [(start + stop - least) / 2, (start + stop + least) / 2];
    this.range = [Math.max(0, start), Math.min(this.whole, stop)];
    this.touched = this.range[0] > 0 || this.range[1] < this.whole;
    this.draw();
    this.on.zoomed();
  }

  extremes(signal) {
    let found = this.known.get(signal.low);
    if (!found) this.known.set(signal.low, (found = new Extremes(signal.low, signal.high)));
    return found;
  }

  /** Ask for all of the charts to be drawn. */
  draw() {
    for (const view of this.views) view.stale = true;
    this.point();
  }

  /** Ask for the cursors to be drawn over curves that stay as they are. */
  point() {
    if (this.pending) return;
    this.pending = requestAnimationFrame(() => {
      this.pending = null;
      this.paintAll();
    });
  }

  /** Pixels of a canvas in one of the page; on paper there are more. */
  get ratio() {
    return document.documentElement.classList.contains("paper") ? 3 : window.devicePixelRatio || 1;
  }

  paintAll() {
    for (const view of this.views) this.paint(view);
    this.paintAxis();
  }

  /** Draw the axis of time, which stays in view below the charts, with the moment under the pointer. */
  paintAxis() {
    const { axis, ratio } = this, width = axis.clientWidth, height = axis.clientHeight;
    if (!width) return;
    const style = getComputedStyle(axis), ink = (name) => style.getPropertyValue(name).trim();
    const g = cleared(axis, Math.round(width * ratio), Math.round(height * ratio)), [t0, t1] = this.range;
    g.scale(ratio, ratio);
    g.font = "11px system-ui, sans-serif";
    g.textAlign = "center";
    g.textBaseline = "middle";
    g.fillStyle = ink("--quiet");
    const wide = width - LEFT - RIGHT, across = (t) => LEFT + (wide * (t - t0)) / (t1 - t0);
    for (const t of this.timeTicks(wide)) g.fillText(`${Number(t.toPrecision(8))} s`, across(t), height / 2);
    const { period } = this.parts[0], now = this.hover * period;
    if (this.hover < 0 || now < t0 || now > t1) return;
    const text = `${now.toFixed(3)} s`, half = g.measureText(text).width / 2 + 6, x = Math.min(Math.max(across(now), half), width - half);
    g.fillRect(x - half, 1, 2 * half, height - 2);
    g.fillStyle = ink("--panel");
    g.fillText(text, x, height / 2);
  }

  timeTicks(wide) {
    return ticks(...this.range, Math.max(2, Math.floor(wide / 110)));
  }

  paint(view) {
    const { ratio } = this, { canvas, curves } = view;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width) return;
    const size = [Math.round(width * ratio), Math.round(height * ratio)];
    const style = getComputedStyle(canvas), ink = (name) => style.getPropertyValue(name).trim();
    const plot = { x: LEFT, y: TOP, w: width - LEFT - RIGHT, h: height - TOP - BOTTOM };
    if (view.stale || curves.width !== size[0] || curves.height !== size[1]) {
      const g = cleared(curves, ...size);
      g.scale(ratio, ratio);
      this.paintCurves(g, view, plot, ink);
    }
    view.stale = false;
    const g = cleared(canvas, ...size);
    g.drawImage(curves, 0, 0);
    g.scale(ratio, ratio);
    this.cursors(g, plot, ink);
    this.captioned(view);
  }

  paintCurves(g, { panel }, plot, ink) {
    const curves = panel.curves.map((curve) => this.columns(curve, Math.max(1, Math.round(plot.w))));
    const [low, high] = scale(curves, panel);
    const down = (v) => plot.y + plot.h * (1 - (v - low) / (high - low));
    g.font = "11px system-ui, sans-serif";
    this.gridLines(g, plot, low, high, down, ink);
    g.save();
    g.beginPath();
    g.rect(plot.x, plot.y - 1, plot.w, plot.h + 2);
    g.clip();
    for (const limit of panel.limits) this.limitLines(g, plot, limit, low, high, down);
    curves.forEach((columns, k) => this.curve(g, plot, columns, panel.curves[k], down));
    g.restore();
  }

  colour(curve) {
    const list = COLOURS[this.theme];
    return list[(curve.colour ?? 0) % list.length];
  }

  /** Return the lowest and highest value of a curve in each column of pixels. */
  columns(curve, count) {
    const { part, name } = curve, signal = part.signal(name), extremes = this.extremes(signal);
    const [t0, t1] = this.range, n = signal.low.length, perBlock = part.period * signal.block;
    const low = new Float64Array(count).fill(NaN), high = new Float64Array(count).fill(NaN);
    const blocks = (t1 - t0) / perBlock;
    if (blocks < count && signal.block === 1) return { points: this.points(signal, part, t0, t1), step: signal.step };
    for (let k = 0; k < count; k++) {
      const start = Math.floor((t0 + ((t1 - t0) * k) / count) / perBlock);
      const stop = Math.min(n, Math.max(start + 1, Math.ceil((t0 + ((t1 - t0) * (k + 1)) / count) / perBlock)));
      if (start >= n) break;
      const [a, b] = extremes.between(start, stop);
      low[k] = a * signal.step;
      high[k] = b * signal.step;
    }
    return { low, high };
  }

  points(signal, part, t0, t1) {
    const first = Math.max(0, Math.floor(t0 / part.period) - 1), last = Math.min(signal.low.length - 1, Math.ceil(t1 / part.period) + 1);
    const found = [];
    for (let k = first; k <= last; k++) found.push([k * part.period, signal.low[k] * signal.step]);
    return found;
  }

  curve(g, plot, columns, curve, down) {
    g.strokeStyle = g.fillStyle = this.colour(curve);
    g.lineWidth = 1.35;
    g.globalAlpha = curve.other ? 0.6 : 1;
    g.setLineDash(curve.other ? [5, 3] : []);
    g.beginPath();
    if (columns.points) {
      const [t0, t1] = this.range;
      for (const [t, v] of columns.points) g.lineTo(plot.x + (plot.w * (t - t0)) / (t1 - t0), down(v));
      g.stroke();
    } else {
      const { low, high } = columns;
      for (let k = 0; k < low.length && !Number.isNaN(low[k]); k++) {
        const x = plot.x + ((k + 0.5) * plot.w) / low.length, up = k % 2 === 0;
        g.lineTo(x, down(up ? low[k] : high[k]));
        g.lineTo(x, down(up ? high[k] : low[k]));
      }
      g.stroke();
    }
    g.setLineDash([]);
    g.globalAlpha = 1;
  }

  limitLines(g, plot, limit, low, high, down) {
    g.strokeStyle = this.colour(limit);
    g.globalAlpha = 0.65;
    g.lineWidth = 1;
    g.setLineDash([2, 4]);
    for (const value of [limit.value, -limit.value]) {
      if (value < low || value > high) continue;
      g.beginPath();
      g.moveTo(plot.x, down(value));
      g.lineTo(plot.x + plot.w, down(value));
      g.stroke();
    }
    g.setLineDash([]);
    g.globalAlpha = 1;
  }

  gridLines(g, plot, low, high, down, ink) {
    g.strokeStyle = ink("--line");
    g.fillStyle = ink("--quiet");
    g.lineWidth = 1;
    g.textBaseline = "middle";
    g.textAlign = "right";
    for (const value of ticks(low, high, plot.h < 28 ? 2 : 3)) {
      const y = Math.round(down(value)) + 0.5;
      g.beginPath();
      g.moveTo(plot.x, y);
      g.lineTo(plot.x + plot.w, y);
      g.stroke();
      g.fillText(rounded(value), plot.x - 7, y);
    }
    const [t0, t1] = this.range;
    for (const value of this.timeTicks(plot.w)) {
      const x = Math.round(plot.x + (plot.w * (value - t0)) / (t1 - t0)) + 0.5;
      g.beginPath();
      g.moveTo(x, plot.y);
      g.lineTo(x, plot.y + plot.h);
      g.stroke();
    }
  }

  cursors(g, plot, ink) {
    const [t0, t1] = this.range, period = this.parts[0].period;
    const across = (t) => plot.x + (plot.w * (t - t0)) / (t1 - t0);
    if (this.drag && Math.abs(across(this.drag.to) - across(this.drag.from)) > 3) {
      g.fillStyle = ink("--select");
      g.fillRect(across(this.drag.from), plot.y, across(this.drag.to) - across(this.drag.from), plot.h);
    }
    for (const [row, name] of [[this.current, "--accent"], [this.hover, "--ink"]]) {
      const t = row * period;
      if (row < 0 || t < t0 || t > t1) continue;
      g.strokeStyle = ink(name);
      g.lineWidth = row === this.current ? 1.5 : 1;
      g.beginPath();
      g.moveTo(across(t), plot.y);
      g.lineTo(across(t), plot.y + plot.h);
      g.stroke();
    }
  }

  /** Write title and values under the cursor. */
  captioned(view) {
    const row = this.hover >= 0 ? this.hover : this.current;
    const spans = [["title", view.panel.title], ["unit", view.panel.unit]].map(([kind, text]) => span(kind, text));
    // Other plans have many curves: their names stand in the chart of the feed alone.
    const named = view.panel.curves.filter((curve) => !curve.other || view.panel.id === "feed");
    for (const curve of named) {
      const inside = row >= 0 && row < curve.part.rows;
      const item = span("value", `${curve.label} ${inside ? curve.part.text(curve.name, row) : ""}`);
      item.style.color = this.colour(curve);
      item.dataset.signal = curve.other ? "" : curve.name;
      spans.push(item);
    }
    const limits = new Set(view.panel.limits.map((limit) => limit.value));
    if (limits.size) spans.push(span("limit", `limit ${[...limits].map(rounded).join(", ")}`));
    view.caption.replaceChildren(...spans);
  }
}

function span(kind, text) {
  const found = document.createElement("span");
  found.className = kind;
  found.textContent = text;
  return found;
}

/** Return the range of values that a chart shows: the plan's own curves, and limits that are not far beyond them. */
function scale(curves, panel) {
  let low = Infinity, high = -Infinity;
  const take = (v) => {
    if (v < low) low = v;
    if (v > high) high = v;
  };
  const own = curves.filter((_, k) => !panel.curves[k].other);
  for (const curve of own.length ? own : curves) {
    if (curve.points) for (const [, v] of curve.points) take(v);
    else {
      for (const v of curve.low) take(v);
      for (const v of curve.high) take(v);
    }
  }
  if (!(high >= low)) return [0, 1];
  const size = Math.max(Math.abs(low), Math.abs(high));
  for (const { value } of panel.limits) {
    if (value > 2.2 * size) continue;
    take(value);
    if (low < 0) take(-value);
  }
  if (low > 0 && low < 0.6 * high) low = 0;
  const room = 0.06 * (high - low) || Math.abs(high) * 0.1 || 1;
  return [low === 0 ? 0 : low - room, high + room];
}

