// The picture of the path: levels of detail, colours, what is highlighted, and which row is under the pointer.

import { Camera } from "./camera.js";
import { Depths } from "./depths.js";
import { flatDrawer } from "./flat.js";
import { segmentDrawer } from "./gl.js";
import { CLASSES, chunked, lookSignificance, pick } from "./levels.js";
import { ticks } from "./format.js";

/** Points drawn while the picture moves: six vertices a point. */
const COARSE_POINTS = 30_000;
const HIGHLIGHT_POINTS = 15_000;
const MOVING_VERTICES = 280_000;
const REST_MS = 140;

export class Scene {
  /** `parts` is the number of plans that are shown over each other; of a `turned` part Z lies to the right. */
  constructor(canvas, theme, { parts, turned }) {
    this.canvas = canvas;
    this.camera = new Camera();
    this.drawer = segmentDrawer(canvas) ?? flatDrawer(canvas);
    this.theme = theme;
    this.turned = turned;
    if (turned) this.camera.look("front");
    this.layers = [];
    this.coarsePoints = Math.floor(COARSE_POINTS / parts);
    this.highlight = null;
    this.onframe = () => {};
    this.covered = () => this.camera.covered;
    this.pending = false;
    this.moving = false;
    this.showRapids = this.showSurface = true;
    this.held = false;
  }

  /** Add a part; the first is coloured, others are drawn in one colour of their own. */
  addPart(part) {
    const layer = { part, coarse: null, fine: null, colouring: null, rapid: rapidRows(part), classes: part.classes, levels: part.levels };
    layer.chunks = Array.from({ length: part.levels.boxes.length / 6 }, (_, k) => k);
    this.layers.push(layer);
    this.box = joined([...this.layers.map((one) => boxOf(one.part)), ...(this.surface ? [this.surface.box] : [])]);
    this.radius = 0.6 * Math.hypot(this.box[3] - this.box[0], this.box[4] - this.box[1], this.box[5] - this.box[2]) + 1;
    layer.coarse = this.coarse(layer);
    this.grid = null;
  }

  /** Show a surface: the part that is cut. */
  setSurface(points, triangles) {
    if (!this.drawer.surface) return;
    this.surface = { ...this.drawer.surface(points, triangles), box: bounds(points), depths: new Depths(points, triangles) };
  }

  /** Colour the first part. A straight line is two points, unless its colour changes on the way: so the points are picked anew. */
  setColouring(colouring, paletteBytes) {
    const layer = this.layers[0], { points, classes, unit } = layer.part;
    layer.colouring = colouring;
    this.drawer.setPalette(paletteBytes);
    const looks = lookSignificance(...points, unit, { bytes: colouring.bytes, steps: Boolean(colouring.kinds), rapid: layer.rapid });
    layer.classes = looks.map((one, k) => Math.max(one, classes[k]));
    layer.levels = chunked(...points, layer.classes);
    layer.coarse.buffer.free();
    layer.coarse = this.coarse(layer);
    if (layer.fine) this.refine();
    this.request();
  }

  /** The points that are drawn while the picture moves. */
  coarse(layer) {
    return this.buffer(layer, pick(layer.levels, layer.classes, layer.chunks, 0, this.coarsePoints));
  }

  buffer(layer, picked) {
    const { rows, gaps } = picked;
    const [x, y, z] = layer.part.points;
    const points = new Float32Array(3 * rows.length), styles = new Uint8Array(rows.length);
    for (let k = 0; k < rows.length; k++) {
      const row = rows[k];
      points[3 * k] = x[row];
      points[3 * k + 1] = y[row];
      points[3 * k + 2] = z[row];
      styles[k] = layer.rapid(row);
    }
    for (const gap of gaps) styles[gap + 1] = 2;
    const values = layer.colouring ? gathered(layer.colouring.bytes, rows) : new Uint8Array(rows.length);
    return { rows, buffer: this.drawer.polyline(points, values, styles), level: picked.level };
  }

  /** Show the rows of stretches (pairs of first and last row), or nothing. */
  setHighlight(spans) {
    this.highlight?.buffer.free();
    this.highlight = null;
    if (spans?.length) {
      const total = spans.reduce((sum, [a, b]) => sum + b - a + 1, 0);
      const stride = Math.max(1, Math.ceil(total / HIGHLIGHT_POINTS));
      const rows = [], gaps = [];
      for (const [a, b] of spans) {
        if (rows.length) gaps.push(rows.length - 1);
        for (let k = a; k < b; k += stride) rows.push(k);
        rows.push(b);
        if (rows.length > HIGHLIGHT_POINTS) break;
      }
      this.highlight = this.buffer({ ...this.layers[0], colouring: null }, { rows: Uint32Array.from(rows), gaps, level: 0 });
    }
    this.request();
  }

  /** Ask for a frame; `moving` says that more will follow soon, so that it is drawn with few points. */
  request(moving = false) {
    if (moving) {
      this.moving = true;
      this.restLater();
    }
    this.stale = true;
    this.frame();
  }

  /** Draw all of the points once nothing has moved for a while; what is held by a pointer may move on. */
  restLater() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      if (this.held) return this.restLater();
      this.moving = false;
      this.refine();
      this.request();
    }, REST_MS);
  }

  /** Ask for what lies over the path to be drawn anew; the path stays as it is, so that a pointer moves at no cost. */
  frame() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      if (this.stale) this.draw();
      else this.onframe();
    });
  }

  /** Show the whole path. */
  fit() {
    this.camera.covered = this.covered();
    this.camera.fit(this.box);
  }

  /** Take the size of the canvas; what filled it fills it again. */
  resize() {
    const paper = document.documentElement.classList.contains("paper");
    const ratio = paper ? 3 : Math.min(2, window.devicePixelRatio || 1);
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    const size = [width, height].map((one) => Math.round(one * ratio));
    if (size[0] === this.canvas.width && size[1] === this.canvas.height && this.ratio === ratio) return;
    [this.canvas.width, this.canvas.height] = size;
    // A scale from a link is of the canvas as it is, not of one that a frame has not laid out yet.
    const kept = this.box && (this.ratio || !this.camera.restored);
    this.camera.resize(width, height, this.covered(), kept ? this.box : null);
    this.ratio = ratio;
    this.request(true);
    // A canvas of a new size is empty, and may be shown before the next frame.
    this.draw();
  }

  /** Pick the points of what is in the view, as fine as its pixels. */
  refine() {
    const pixel = 1 / this.camera.scale;
    for (const layer of this.layers) {
      const { levels, classes } = layer, { unit } = layer.part;
      const finest = Math.max(0, Math.min(CLASSES - 2, 1 + Math.floor(Math.log2((0.25 * pixel) / unit))));
      const seen = layer.chunks.filter((c) => this.inView(levels.boxes, 6 * c));
      layer.fine?.buffer.free();
      layer.fine = seen.length ? this.buffer(layer, pick(levels, classes, seen, finest, this.drawer.most)) : null;
      if (layer.fine) layer.fine.chunks = seen;
    }
  }

  inView(boxes, at) {
    const { camera } = this;
    const { right, up } = camera.frame();
    const half = [0, 1, 2].map((k) => (boxes[at + 3 + k] - boxes[at + k]) / 2);
    const [px, py] = camera.project(...[0, 1, 2].map((k) => (boxes[at + 3 + k] + boxes[at + k]) / 2));
    const rx = camera.scale * (Math.abs(right[0]) * half[0] + Math.abs(right[1]) * half[1]);
    const ry = camera.scale * (Math.abs(up[0]) * half[0] + Math.abs(up[1]) * half[1] + Math.abs(up[2]) * half[2]);
    const room = 40;
    return px + rx > -room && px - rx < camera.width + room && py + ry > -room && py - ry < camera.height + room;
  }

  draw() {
    const { drawer, camera } = this;
    this.stale = false;
    if (!this.layers.length) return this.onframe();
    const size = [this.canvas.width, this.canvas.height], ratio = this.ratio || 1;
    const away = Math.hypot(...[0, 1, 2].map((k) => camera.centre[k] - (this.box[k] + this.box[k + 3]) / 2));
    const matrix = camera.matrix(this.radius + away);
    const colours = COLOURS[this.theme];
    drawer.begin(...size);
    this.grid ??= gridOf(drawer, this.box, this.turned);
    // A path in the plane of the grid is over it.
    if (this.showGrid !== false) drawer.draw(this.grid, { matrix, size, width: ratio, solid: colours.grid, under: true });
    const taken = 6 * (COARSE_POINTS + (this.highlight?.rows.length ?? 0));
    this.surfaceShown = this.surface && this.showSurface && (!this.moving || this.surface.count + taken <= MOVING_VERTICES);
    if (this.surfaceShown) {
      const { toward, up, right } = camera.frame();
      const light = [0, 1, 2].map((k) => 0.8 * up[k] - 0.6 * right[k]), [low, top] = [this.surface.box[2], this.surface.box[5]];
      // A turned part has no top.
      const under = [top, this.turned || top <= low ? 0 : 1 / (top - low)];
      drawer.fill(this.surface, { matrix, toward, light, solid: colours.surface, deep: colours.deep, under });
    }
    // The first part lies over the others, also where nothing has a depth.
    [...this.layers].reverse().forEach((layer) => {
      const k = this.layers.indexOf(layer);
      if (k && this.hideOthers) return;
      const how = { matrix, size, pixels: camera.scale * ratio, width: (k ? 1.4 : 2) * ratio, steps: Boolean(layer.colouring?.kinds), lift: k ? -1e-4 : 0 };
      if (k) how.solid = colours.other;
      else how.rapid = this.showRapids ? colours.rapid : [0, 0, 0, 0.001];
      if (this.highlight && !k) how.opacity = 0.35;
      const few = layer.fine && drawer.vertices + taken + 6 * layer.fine.rows.length <= MOVING_VERTICES;
      if (this.moving || !layer.fine) drawer.draw(layer.coarse.buffer, how);
      if (layer.fine && (!this.moving || few)) drawer.draw(layer.fine.buffer, how);
    });
    if (this.highlight) drawer.draw(this.highlight.buffer, { matrix, size, width: 3.4 * ratio, solid: colours.highlight, lift: 2e-3 });
    this.onframe();
  }

  /** Return what the surface that is drawn hides, or null. */
  depths() {
    if (!this.surfaceShown) return null;
    this.surface.depths.look(this.camera);
    return this.surface.depths;
  }

  /** Return the row of the first part nearest to a pixel, within some pixels, or -1. */
  rowAt(px, py, reach = 9) {
    const layer = this.layers[0];
    const shown = layer && (layer.fine || layer.coarse);
    if (!shown) return -1;
    const { part } = layer, [x, y, z] = part.points, { camera } = this;
    const { right, up, toward } = camera.frame(), c = camera.centre;
    const flat = (row) => {
      const dx = x[row] - c[0], dy = y[row] - c[1], dz = z[row] - c[2];
      return [
        camera.width / 2 + camera.scale * (right[0] * dx + right[1] * dy + right[2] * dz),
        camera.height / 2 - camera.scale * (up[0] * dx + up[1] * dy + up[2] * dz),
        toward[0] * dx + toward[1] * dy + toward[2] * dz,
      ];
    };
    let best = reach * reach, from = -1, to = -1, nearest = -Infinity;
    const { rows } = shown;
    let p = rows.length ? flat(rows[0]) : null;
    for (let k = 0; k + 1 < rows.length; k++) {
      const q = flat(rows[k + 1]);
      if (rows[k + 1] > rows[k]) {
        const ux = q[0] - p[0], uy = q[1] - p[1], length = ux * ux + uy * uy;
        let t = length > 0 ? ((px - p[0]) * ux + (py - p[1]) * uy) / length : 0;
        t = t < 0 ? 0 : t > 1 ? 1 : t;
        const square = (p[0] + t * ux - px) ** 2 + (p[1] + t * uy - py) ** 2;
        const depth = p[2] + t * (q[2] - p[2]);
        if (square < best - 0.5 || (square < best + 0.5 && depth > nearest)) {
          best = Math.min(best, square);
          nearest = depth;
          from = rows[k];
          to = rows[k + 1];
        }
      }
      p = q;
    }
    if (from < 0) return -1;
    let found = from, least = Infinity;
    for (let row = from; row <= to; row++) {
      const [qx, qy] = flat(row);
      const square = (qx - px) ** 2 + (qy - py) ** 2;
      if (square < least) {
        least = square;
        found = row;
      }
    }
    return found;
  }
}

const COLOURS = {
  dark: { surface: [0.46, 0.52, 0.6, 1], deep: [0.2, 0.25, 0.34, 1], grid: [0.55, 0.62, 0.72, 0.16], rapid: [0.62, 0.66, 0.74, 0.6], other: [0.95, 0.62, 0.9, 0.75], highlight: [1, 1, 1, 1] },
  light: { surface: [0.8, 0.83, 0.87, 1], deep: [0.46, 0.53, 0.64, 1], grid: [0.2, 0.25, 0.35, 0.14], rapid: [0.42, 0.46, 0.54, 0.65], other: [0.7, 0.1, 0.6, 0.6], highlight: [0.05, 0.07, 0.12, 1] },
};

function gathered(bytes, rows) {
  const out = new Uint8Array(rows.length);
  for (let k = 0; k < rows.length; k++) out[k] = bytes[rows[k]];
  return out;
}

/** Return a function that tells whether the motion to a row is a rapid: 1 or 0. Rows are asked for mostly in order. */
function rapidRows(part) {
  const run = part.run.programmed_feed_mm_s;
  if (!run) return () => 0;
  let k = 0;
  return (row) => {
    if (run.starts[k] > row) k = 0;
    while (run.starts[k + 1] <= row) k++;
    return run.values[k] === 0 ? 1 : 0;
  };
}

export function boxOf(part) {
  const { boxes } = part.levels, box = [Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity];
  for (let c = 0; c < boxes.length; c += 6) {
    for (let k = 0; k < 3; k++) {
      box[k] = Math.min(box[k], boxes[c + k]);
      box[k + 3] = Math.max(box[k + 3], boxes[c + 3 + k]);
    }
  }
  return box.some((v) => !Number.isFinite(v)) ? [0, 0, 0, 1, 1, 1] : box;
}

/** Return the box of points, x y z after x y z. */
function bounds(points) {
  const box = [Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity];
  points.forEach((v, k) => {
    box[k % 3] = Math.min(box[k % 3], v);
    box[3 + (k % 3)] = Math.max(box[3 + (k % 3)], v);
  });
  return box;
}

function joined(boxes) {
  return [0, 1, 2, 3, 4, 5].map((k) => (k < 3 ? Math.min : Math.max)(...boxes.map((box) => box[k])));
}

/** Return a grid under a box, or behind a turned part, its lines a round number of millimetres apart. */
function gridOf(drawer, box, turned) {
  const [p, q, r] = turned ? [0, 2, 1] : [0, 1, 2], level = box[turned ? 4 : 2];
  const wide = Math.max(box[3 + p] - box[p], box[3 + q] - box[q], 1e-3);
  const marks = ticks(0, wide, 10);
  const step = marks.length > 1 ? marks[1] - marks[0] : wide;
  const low = [p, q].map((k) => Math.floor(box[k] / step - 0.5) * step);
  const high = [p, q].map((k) => Math.ceil(box[k + 3] / step + 0.5) * step);
  const points = [], styles = [];
  const line = (...ends) => {
    for (const [a, b] of ends) {
      const point = [0, 0, 0];
      [point[p], point[q], point[r]] = [a, b, level];
      points.push(...point);
    }
    styles.push(2, 0);
  };
  for (let x = low[0]; x <= high[0] + step / 2; x += step) line([x, low[1]], [x, high[1]]);
  for (let y = low[1]; y <= high[1] + step / 2; y += step) line([low[0], y], [high[0], y]);
  return drawer.polyline(new Float32Array(points), new Uint8Array(styles.length), new Uint8Array(styles));
}

