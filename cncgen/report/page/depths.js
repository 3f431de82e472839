// What the part hides: how near to the viewer its surface is, in squares of some pixels.

/** Side of a square, pixels. */
const SQUARE = 2;
/** Squares by which a mark may lie behind the surface that it is on: walls that are looked along are as deep. */
const SLACK = 4;

export class Depths {
  constructor(points, triangles) {
    this.points = points;
    this.triangles = triangles;
    this.view = "";
  }

  /** Look from a camera; what was computed for the same view is kept. */
  look(camera) {
    const view = `${camera.state()},${camera.width},${camera.height}`;
    if (view === this.view) return;
    this.view = view;
    this.slack = (SLACK * SQUARE) / camera.scale;
    this.wide = Math.ceil(camera.width / SQUARE);
    this.high = Math.ceil(camera.height / SQUARE);
    this.near = new Float32Array(this.wide * this.high).fill(-Infinity);
    const { points, triangles } = this, seen = new Float32Array(points.length);
    for (let k = 0; k < points.length; k += 3) {
      const [x, y, depth] = camera.project(points[k], points[k + 1], points[k + 2]);
      seen.set([x / SQUARE, y / SQUARE, depth], k);
    }
    for (let k = 0; k < triangles.length; k += 3) this.fill(seen, 3 * triangles[k], 3 * triangles[k + 1], 3 * triangles[k + 2]);
  }

  /** Put a triangle before what is behind it, in the squares whose middle it covers. */
  fill(seen, a, b, c) {
    const ax = seen[a], ay = seen[a + 1], bx = seen[b] - ax, by = seen[b + 1] - ay, cx = seen[c] - ax, cy = seen[c + 1] - ay;
    const area = bx * cy - by * cx;
    if (area === 0) return;
    const left = Math.max(0, Math.ceil(ax + Math.min(0, bx, cx) - 0.5)), right = Math.min(this.wide - 1, Math.floor(ax + Math.max(0, bx, cx) - 0.5));
    const top = Math.max(0, Math.ceil(ay + Math.min(0, by, cy) - 0.5)), bottom = Math.min(this.high - 1, Math.floor(ay + Math.max(0, by, cy) - 0.5));
    for (let row = top; row <= bottom; row++) {
      for (let column = left; column <= right; column++) {
        const x = column + 0.5 - ax, y = row + 0.5 - ay;
        const v = (x * cy - y * cx) / area, w = (bx * y - by * x) / area;
        if (v < -1e-6 || w < -1e-6 || v + w > 1 + 1e-6) continue;
        const depth = seen[a + 2] + v * (seen[b + 2] - seen[a + 2]) + w * (seen[c + 2] - seen[a + 2]);
        const at = this.wide * row + column;
        if (depth > this.near[at]) this.near[at] = depth;
      }
    }
  }

  /** Tell whether the surface is before a point on the canvas, in its square and in all around it. */
  hides([x, y, depth]) {
    const column = Math.floor(x / SQUARE), row = Math.floor(y / SQUARE);
    for (let j = row - 1; j <= row + 1; j++) {
      for (let k = column - 1; k <= column + 1; k++) {
        if (j < 0 || k < 0 || j >= this.high || k >= this.wide || this.near[this.wide * j + k] <= depth + this.slack) return false;
      }
    }
    return true;
  }
}
