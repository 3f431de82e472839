// Decoding and preparing the page's data, the path first: a worker shows it before the rest.

import { band, bytesOf, integers, runs } from "./decode.js";
import { chunked, significance } from "./levels.js";
import { textOf } from "./numbered.js";
import { packed } from "./packed.js";

/** Decode the parts of a page; `post` is called with each piece that is ready, and with the buffers that it may hand over. */
export function prepare({ text, parts, predictors }, post) {
  try {
    const blob = bytesOf(text);
    if (parts[0].removal) mesh(blob, parts[0], post);
    parts.forEach((part, k) => path(blob, part, k, { parts, predictors }, post));
    parts.forEach((part, k) => texts(blob, part, k, post));
    parts.forEach((part, k) => bands(blob, part, k, post));
    post({ kind: "done" }, []);
  } catch (error) {
    post({ kind: "failed", message: String((error && error.message) || error) }, []);
  }
}

function path(blob, part, index, { parts, predictors }, post) {
  const rows = {}, buffers = [], signals = {};
  for (const [name, spec] of Object.entries(part.streams)) {
    if (spec.rows) {
      rows[name] = packed(blob, spec.rows, predictors);
      buffers.push(rows[name].buffer);
    } else if (spec.runs) {
      signals[name] = runs(blob, spec.runs);
      buffers.push(signals[name].values.buffer, signals[name].starts.buffer);
    }
  }
  const corners = integers(blob, part.corners);
  const points = placed(part, rows, parts[0].turned);
  const unit = 1e-4;
  const classes = significance(points[0], points[1], points[2], unit);
  const levels = chunked(points[0], points[1], points[2], classes);
  for (const array of [...points, classes, levels.boxes, levels.counts]) buffers.push(array.buffer);
  post({ kind: "path", index, rows, runs: signals, corners, points, classes, levels, unit }, buffers);
}

/** Axes of the picture of a turned part: Z to the right, X up. */
const LYING = [["Z", 1], ["Y", -1], ["X", 1]];

/** Return x, y, z of the picture: the linear axes; of a machine without them, rotary ones as they come. */
function placed(part, rows, turned) {
  const letters = part.axes.map((axis) => axis.letter);
  const wanted = letters.some((l) => "XYZ".includes(l)) ? "XYZ" : letters.some((l) => "UVW".includes(l)) ? "UVW" : letters.slice(0, 3).join("");
  const n = part.rows;
  return [0, 1, 2].map((k) => {
    const [letter, sign] = turned ? LYING[k] : [wanted[k], 1];
    const column = letters.indexOf(letter);
    const out = new Float32Array(n);
    if (column >= 0) {
      const name = `${letters[column].toLowerCase()}_${part.axes[column].unit}`;
      const from = rows[name], step = sign * part.streams[name].step;
      for (let i = 0; i < n; i++) out[i] = from[i] * step;
    }
    return out;
  });
}

/** The part that is cut, whose box the first picture is fitted to. */
function mesh(blob, { removal: { step, vertices, corners }, turned }, post) {
  const columns = [...vertices, ...corners].map((spec) => integers(blob, spec));
  const [x, y, z] = columns;
  if (turned) columns.splice(0, 3, z, y.map((v) => -v), x);
  const woven = (Kind, three, factor) => Kind.from({ length: 3 * three[0].length }, (_, k) => three[k % 3][Math.floor(k / 3)] * factor);
  const points = woven(Float32Array, columns.slice(0, 3), step), triangles = woven(Uint32Array, columns.slice(3), 1);
  post({ kind: "mesh", points, triangles }, [points.buffer, triangles.buffer]);
}

function texts(blob, part, index, post) {
  const found = part.sources.map((source) => (source.text ? textOf(blob, source.text) : null));
  post({ kind: "texts", index, texts: found }, []);
}

function bands(blob, part, index, post) {
  const found = {}, buffers = [];
  for (const [name, spec] of Object.entries(part.streams)) {
    if (!spec.low) continue;
    found[name] = band(blob, spec);
    buffers.push(found[name].low.buffer, found[name].high.buffer);
  }
  post({ kind: "bands", index, bands: found }, buffers);
}
