// The page's modules without a browser: expected values are worked out by other means.

import assert from "node:assert/strict";
import { test } from "node:test";
import { constants, deflateSync } from "node:zlib";

const from = new URL("../../cncgen/report/page/", import.meta.url);
const load = (name) => import(new URL(name, from));
const { band, bytesOf, integers, runAt, runs, summed } = await load("decode.js");
const { inflated } = await load("inflate.js");
const { brief, duration, partly, rounded, stepped, ticks } = await load("format.js");
const { along, lineKey, rowsByLine, rowsByValue, stretches, toolRuns } = await load("lines.js");
const { CHUNK, chunked, lookSignificance, pick, significance } = await load("levels.js");
const { Camera } = await load("camera.js");
const { Depths } = await load("depths.js");
const { parsed, written } = await load("link.js");
const { Extremes } = await load("charts.js");
const { Part } = await load("store.js");

let seed = 7;
const random = () => (seed = (seed * 1103515245 + 12345) % 2 ** 31) / 2 ** 31;

function stream(values, order) {
  let rest = values.slice();
  for (let k = 0; k < order; k++) rest = rest.map((v, i) => v - (i ? rest[i - 1] : 0));
  const folded = rest.map((v) => (v < 0 ? -2 * v - 1 : 2 * v));
  const numbers = deflateSync(Uint8Array.from(folded, (v) => Math.min(v, 255)));
  const large = deflateSync(new Uint8Array(Float64Array.from(folded.filter((v) => v >= 255)).buffer));
  return { order, count: values.length, numbers, large };
}

function placed(list) {
  const parts = [], specs = [];
  let at = 0;
  for (const one of list) {
    specs.push({ order: one.order, count: one.count, at: [at, one.numbers.length], escapes: [at + one.numbers.length, one.large.length] });
    parts.push(one.numbers, one.large);
    at += one.numbers.length + one.large.length;
  }
  return { blob: new Uint8Array(Buffer.concat(parts)), specs };
}

test("integers of every order come back", async () => {
  for (let order = 0; order <= 3; order++) {
    const values = Array.from({ length: 500 }, (_, k) => Math.round(1e5 * Math.sin(k / 9) + 300 * random()));
    const { blob, specs } = placed([stream(values, order)]);
    assert.deepEqual([...integers(blob, specs[0])], values);
  }
});

test("wide integers are doubles", () => {
  const wide = summed(Uint8Array.of(255, 2), Float64Array.of(2 ** 41), { order: 1, count: 2, wide: true });
  assert.deepEqual([...wide], [2 ** 40, 2 ** 40 + 1]);
});

test("runs and bands come back", async () => {
  const { blob, specs } = placed([stream([5, 7, 5], 1), stream([2, 1, 4], 0), stream([-3, 9], 1), stream([4, 0], 1)]);
  const run = runs(blob, { values: specs[0], lengths: specs[1] });
  assert.deepEqual([[...run.values], [...run.starts]], [[5, 7, 5], [0, 2, 3, 7]]);
  assert.deepEqual([0, 1, 2, 3, 6].map((row) => runAt(run.starts, row)), [0, 0, 1, 2, 2]);
  const found = band(blob, { step: 1, block: 2, low: specs[2], spread: specs[3] });
  assert.deepEqual([[...found.low], [...found.high]], [[-3, 9], [1, 9]]);
});

test("base 85: zero, one, the largest word", () => {
  assert.deepEqual([...bytesOf("!!!!!")], [0, 0, 0, 0]);
  assert.deepEqual([...bytesOf("!!!!#")], [0, 0, 0, 1]);
  // 2³² − 1 = 82·85⁴ + 23·85³ + 54·85² + 12·85 + 0.
  const digits = "!#%()*+,./0123456789:;=?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[]^_abcdefghijklmnopqrstuvwxyz{|}~";
  assert.deepEqual([...bytesOf([82, 23, 54, 12, 0].map((k) => digits[k]).join(""))], [255, 255, 255, 255]);
});

test("numbers are written to the digit of their step", () => {
  assert.equal(stepped(123456, 1e-4), "12.3456");
  assert.equal(stepped(-4, 1e-2), "-0.04");
  assert.equal(stepped(-0, 1e-2), "0.00");
  assert.equal(stepped(27, 100), "2700");
  assert.equal(duration(172.7555), "2:52.756 min");
  assert.equal(duration(4.102), "4.102 s");
  assert.equal(duration(7384.04), "2:03:04.0 h");
  assert.deepEqual([0.0021, 0.25, 12.3456, 150].map(brief), ["2.1 ms", "250 ms", "12.35 s", "2:30 min"]);
  assert.deepEqual([0.0021, 0.25, 12.3456, 150].map((part) => partly(part, 150)), ["<0.01 s", "0.25 s", "12.35 s", "2:30 min"]);
  assert.deepEqual([0, 0.0021, 0.25].map((part) => partly(part, 0.25)), ["0", "2.1 ms", "250 ms"]);
  assert.deepEqual([0, 2450, 50000, 1.5e7].map(rounded), ["0", "2450", "50k", "15M"]);
  assert.deepEqual(ticks(-525, 525, 4), [-500, 0, 500]);
  assert.deepEqual(ticks(0, 0.042, 5), [0, 0.01, 0.02, 0.03, 0.04]);
});

test("time by line counts periods, over visits and files", () => {
  const line = { values: [3, 4, 3, 4], starts: [0, 2, 5, 6, 9] };
  const source = { values: [0, 1], starts: [0, 6, 9] };
  const found = stretches(line, source, 9);
  assert.deepEqual(found.keys, [3, 4, 3, lineKey(1, 4)]);
  assert.deepEqual(found.starts, [0, 2, 5, 6, 9]);
  assert.deepEqual([...found.visits.get(3)], [0, 2]);
  assert.deepEqual([...rowsByLine(found)], [[3, 3], [4, 3], [lineKey(1, 4), 2]]);
  assert.deepEqual([...rowsByValue(line, 9)], [[3, 3], [4, 5]]);
});

test("tools run from change to change", () => {
  const events = [{ event: "tool", t_s: 0, tool: 2 }, { event: "spindle", t_s: 1 }, { event: "tool", t_s: 1.5, tool: 5 }];
  assert.deepEqual(toolRuns(events, 0.5, 9), [{ tool: 2, start: 0, stop: 3 }, { tool: 5, start: 3, stop: 9 }]);
  assert.equal(along([[0, 3, 3, 3], [0, 4, 4, 9]], 0, 4, 2), 0.5);
});

test("a picked path keeps within its class, and begins and ends where the path does", () => {
  const n = 3 * CHUNK + 1234, unit = 1e-4;
  const x = Float32Array.from({ length: n }, (_, k) => k / 300);
  const y = Float32Array.from({ length: n }, (_, k) => (k > 9000 && k < 9050 ? 5 : 0) + Math.sin(k / 700));
  const z = new Float32Array(n);
  const classes = significance(x, y, z, unit);
  const levels = chunked(x, y, z, classes);
  const chunks = [0, 1, 2, 3];
  for (const finest of [0, 5, 9, 12]) {
    const { rows, gaps, level } = pick(levels, classes, chunks, finest, Infinity);
    assert.deepEqual([rows[0], rows[rows.length - 1], gaps.length, level], [0, n - 1, 0, finest]);
    let worst = 0;
    for (let k = 0, row = 0; k + 1 < rows.length; k++) {
      assert.ok(rows[k + 1] > rows[k]);
      for (row = rows[k]; row <= rows[k + 1]; row++) {
        const ux = x[rows[k + 1]] - x[rows[k]], uy = y[rows[k + 1]] - y[rows[k]];
        worst = Math.max(worst, Math.abs((y[row] - y[rows[k]]) * ux - (x[row] - x[rows[k]]) * uy) / Math.hypot(ux, uy));
      }
    }
    // A class of deviations up to unit · 2^(finest - 1); those of several strides add up to a few of them.
    if (finest) assert.ok(worst <= 4 * unit * 2 ** finest, `${worst} at class ${finest}`);
  }
  const few = pick(levels, classes, chunks, 0, 900);
  assert.ok(few.rows.length <= 900 + 2 * chunks.length, String(few.rows.length));
  assert.deepEqual(pick(levels, classes, [0, 2], 8, Infinity).gaps.length, 1);
});

test("a straight line is two points a chunk", () => {
  const x = Float32Array.from({ length: 2 * CHUNK }, (_, k) => k), y = new Float32Array(x.length);
  const classes = significance(x, y, y, 1e-4);
  assert.equal(pick(chunked(x, y, y, classes), classes, [0, 1], 1, Infinity).rows.length, 3);
});

test("a straight line keeps the points between which its colour, its kind or its style changes", () => {
  // A line of 100 mm that starts and stops: 5 mm each at a growing feed, the rest at the whole feed; a rapid from 70 mm on.
  const n = CHUNK, unit = 1e-4, x = Float32Array.from({ length: n }, (_, k) => (100 * k) / (n - 1)), y = new Float32Array(n);
  const feed = Uint8Array.from(x, (v) => 255 * Math.min(1, v / 5, (100 - v) / 5));
  const plain = significance(x, y, y, unit);
  const kinds = Uint8Array.from(x, (v) => (v < 30 ? 4 : v < 30.2 ? 1 : 0));
  for (const pixel of [0.02, 0.2]) {
    const finest = 1 + Math.floor(Math.log2((0.25 * pixel) / unit));
    const drawn = (looks) => {
      const classes = lookSignificance(x, y, y, unit, looks).map((one, k) => Math.max(one, plain[k]));
      return pick(chunked(x, y, y, classes), classes, [0], finest, Infinity).rows;
    };
    const ramp = drawn({ bytes: feed, steps: false, rapid: () => 0 });
    assert.ok(ramp.length < 200, String(ramp.length));
    for (let k = 0; k + 1 < ramp.length; k++) {
      const [a, b] = [ramp[k], ramp[k + 1]];
      for (let row = a; row <= b; row++) {
        const off = Math.abs(feed[row] - feed[a] - ((row - a) / (b - a)) * (feed[b] - feed[a]));
        // Eight steps of colour are not seen, and those of several strides add up to a few of them; two pixels may be of any.
        assert.ok(off <= 24 || x[b] - x[a] <= 2 * pixel, `${off} of 255 at ${x[row]} mm, between ${x[a]} and ${x[b]}`);
      }
    }
    const changes = drawn({ bytes: kinds, steps: true, rapid: (row) => (x[row] > 70 ? 1 : 0) });
    assert.ok(changes.length < 60, String(changes.length));
    for (const place of [30, 30.2, 70]) {
      const after = changes.findIndex((row) => x[row] >= place);
      assert.ok(x[changes[after]] - x[changes[after - 1]] <= 2 * pixel, `${place} mm at pixels of ${pixel} mm`);
    }
  }
});

test("views look along the axes, and zoom keeps what is under the pointer", () => {
  const camera = new Camera();
  Object.assign(camera, { width: 800, height: 600, scale: 3 });
  const seen = (name, point) => (camera.look(name), camera.project(...point).map((v) => Math.round(v * 1e6) / 1e6 + 0));
  assert.deepEqual(seen("top", [10, 20, 30]), [430, 240, 30]);
  assert.deepEqual(seen("front", [10, 20, 30]), [430, 210, -20]);
  assert.deepEqual(seen("side", [10, 20, 30]), [460, 210, 10]);
  camera.look("iso");
  const before = camera.project(4, -7, 2), [px, py] = before;
  camera.zoom(2.5, px, py);
  const after = camera.project(4, -7, 2);
  assert.ok(Math.hypot(after[0] - px, after[1] - py) < 1e-9);
  const other = new Camera();
  assert.ok(other.restore(camera.state()));
  assert.ok(Math.abs(other.scale - camera.scale) < 1e-3);
  assert.ok(!other.restore("1,2,x") && !other.restore("0,0,0,0,0,-1"));
});

test("a box is fitted below the buttons and beside the legend, and in the middle where it does not reach that", () => {
  const camera = new Camera();
  Object.assign(camera, { width: 800, height: 640, covered: { right: 270, below: 90, above: 40 } });
  camera.look("top");
  const placed = (x, y, scale, px, py) => {
    camera.fit([0, 0, 0, x, y, 0]);
    const [at, down] = camera.project(x / 2, y / 2, 0);
    for (const [found, wanted] of [[camera.scale, 0.9 * scale], [at, px], [down, py]]) assert.ok(Math.abs(found - wanted) < 1e-9, `${found} for ${wanted}`);
  };
  // Below the buttons 600 px are left. 100 x 100 mm at 5.4 px a mm end at x = 670 over the legend; beside that 530 px are left, above it 510.
  placed(100, 100, 5.3, 265, 340);
  // 160 x 100 mm end at x = 760; above the legend the width alone limits them still.
  placed(160, 100, 5, 400, 295);
  // 10 mm wide they end at x = 427, left of the legend.
  placed(10, 100, 6, 400, 340);
  // With a legend as large as the picture, less than half of that would be left.
  camera.covered = { right: 600, below: 590, above: 40 };
  placed(160, 200, 3, 400, 340);
});

test("a link comes back, also with signs of its own", () => {
  const settings = { c: "x_jerk_mm_s3", t: "1.5", x: "0,2", l: "a&b=c#d%" };
  assert.deepEqual(parsed(written(settings)), settings);
  assert.deepEqual(parsed("#v=%E0%A4%A&c=feed"), { c: "feed" });
});

test("extremes of any part are those of a plain search", () => {
  const values = Float64Array.from({ length: 70_001 }, () => random() - 0.5);
  const found = new Extremes(values, values);
  for (let k = 0; k < 300; k++) {
    const a = Math.floor(random() * values.length), b = Math.min(values.length, a + 1 + Math.floor(random() ** 4 * values.length));
    const part = values.subarray(a, b);
    assert.deepEqual(found.between(a, b), [part.reduce((m, v) => Math.min(m, v)), part.reduce((m, v) => Math.max(m, v))]);
  }
});

test("what zlib deflates is inflated: stored, with its own codes and with fixed ones", () => {
  const texts = [
    new Uint8Array(0), Uint8Array.from([7]), new Uint8Array(70_000),
    Uint8Array.from({ length: 100_000 }, () => 256 * random()),
    Uint8Array.from({ length: 100_000 }, (_, k) => 40 + 8 * Math.sin(k / 50) * random()),
    new TextEncoder().encode(Array.from({ length: 9000 }, (_, k) => `N${k} G1 X${(random() * 100).toFixed(3)} Y${k % 17}\n`).join("")),
  ];
  const kinds = [{ level: 0 }, { level: 1 }, { level: 9 }, { strategy: constants.Z_FIXED }, { strategy: constants.Z_HUFFMAN_ONLY }, { strategy: constants.Z_RLE }];
  for (const text of texts) for (const kind of kinds) assert.deepEqual(Buffer.compare(inflated(deflateSync(text, kind)), text), 0);
  assert.equal(inflated(new Uint8Array(0)).length, 0);
});

test("bytes that are cut off, or other than they were written, are refused", () => {
  const bytes = deflateSync(Uint8Array.from({ length: 5000 }, (_, k) => (k * k) % 251));
  assert.throws(() => inflated(bytes.subarray(0, bytes.length / 2)), /too early/);
  const changed = Uint8Array.from(bytes);
  changed[bytes.length - 1] ^= 1;
  assert.throws(() => inflated(changed), /sum/);
});

test("a limit of axes names the axis that is near its own, block by block", () => {
  const axes = ["X", "Y"].map((letter) => ({ letter, unit: "mm", limits: { velocity: 100, acceleration: 1000, jerk: letter === "X" ? 50 : 20 } }));
  const streams = Object.fromEntries(["x", "y"].map((letter) => [`${letter}_jerk_mm_s3`, { step: 10, block: 2 }]));
  const part = new Part({ axes, rows: 8, period_s: 1, streams }, ["nothing", "feed", "jerk"]);
  part.row = {};
  part.run = { limit: { values: [1, 2, 1], starts: [0, 1, 7, 8] } };
  // In blocks of two rows X comes to 0, 50, 10 and 0 of 50 mm/s³, Y to 0, 10, 20 and 20 of 20.
  const band = (low, high) => ({ low, high, block: 2, step: 10 });
  part.bands = { x_jerk_mm_s3: band([0, -5, -1, 0], [0, 1, 1, 0]), y_jerk_mm_s3: band([0, 0, 0, -2], [0, 1, 2, 0]) };
  const found = [...part.heldRuns()].map(({ value, start, stop }) => [value, start, stop]);
  assert.deepEqual(found, [["feed", 0, 1], ["axis jerk", 1, 2], ["X jerk", 2, 4], ["Y jerk", 4, 6], ["Y jerk", 6, 7], ["feed", 7, 8]]);
  assert.deepEqual([0, 1, 3, 5].map((row) => part.limit(row)), ["feed", "axis jerk", "X jerk", "Y jerk"]);
});


test("a surface hides what is behind it, and nothing on it, before it or beside it", () => {
  // A square of 20 mm in the plane z = 5, seen from above at 10 pixels a millimetre.
  const camera = new Camera();
  Object.assign(camera, { width: 400, height: 300, scale: 10 });
  camera.look("top");
  const depths = new Depths(Float32Array.from([-10, -10, 5, 10, -10, 5, 10, 10, 5, -10, 10, 5]), Uint32Array.from([0, 1, 2, 0, 2, 3]));
  depths.look(camera);
  const hides = (...point) => depths.hides(camera.project(...point));
  assert.deepEqual([hides(3, 4, 0), hides(-9, -9, 2), hides(3, 4, 5), hides(3, 4, 4.9), hides(3, 4, 8), hides(11, 0, 0), hides(40, 0, 0)], [true, true, false, false, false, false, false]);
  // From the front the square is a line.
  camera.look("front");
  depths.look(camera);
  assert.equal(hides(3, 8, 0), false);
});
