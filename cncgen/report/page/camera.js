// The camera: parallel projection of a turntable, z up. Angles in radians, scale in pixels a millimetre.

export const VIEWS = {
  iso: [Math.PI / 4, Math.atan(Math.SQRT1_2)],
  top: [0, Math.PI / 2],
  front: [0, 0],
  side: [Math.PI / 2, 0],
};

export class Camera {
  constructor() {
    [this.azimuth, this.elevation] = VIEWS.iso;
    this.centre = [0, 0, 0];
    this.scale = 1;
    this.width = this.height = 1;
    // What covers the canvas, in pixels: width and height of its lower right corner, and height of its upper edge.
    this.covered = { right: 0, below: 0, above: 0 };
    this.restored = false;
  }

  /** Return the directions of the picture in space: right, up, and towards the viewer. */
  frame() {
    const ca = Math.cos(this.azimuth), sa = Math.sin(this.azimuth);
    const ce = Math.cos(this.elevation), se = Math.sin(this.elevation);
    return { right: [ca, sa, 0], up: [-sa * se, ca * se, ce], toward: [sa * ce, -ca * ce, se] };
  }

  /** Return where a point is on the canvas, in pixels from its upper left corner, and its depth (larger is nearer). */
  project(x, y, z) {
    const { right, up, toward } = this.frame();
    const dx = x - this.centre[0], dy = y - this.centre[1], dz = z - this.centre[2];
    return [
      this.width / 2 + this.scale * (right[0] * dx + right[1] * dy + right[2] * dz),
      this.height / 2 - this.scale * (up[0] * dx + up[1] * dy + up[2] * dz),
      toward[0] * dx + toward[1] * dy + toward[2] * dz,
    ];
  }

  orbit(dx, dy) {
    this.azimuth -= dx * 0.008;
    this.azimuth -= 2 * Math.PI * Math.round(this.azimuth / (2 * Math.PI));
    this.elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, this.elevation + dy * 0.008));
  }

  pan(dx, dy) {
    const { right, up } = this.frame();
    for (let k = 0; k < 3; k++) this.centre[k] += (-dx * right[k] + dy * up[k]) / this.scale;
  }

  /** Zoom by a factor, so that what is under a pixel stays there. */
  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const before = this.scale;
    this.scale = Math.max(1e-3, Math.min(1e6, before * factor));
    const shift = 1 - before / this.scale;
    const { right, up } = this.frame();
    const dx = (px - this.width / 2) / before, dy = (this.height / 2 - py) / before;
    for (let k = 0; k < 3; k++) this.centre[k] += shift * (dx * right[k] + dy * up[k]);
  }

  look(name) {
    [this.azimuth, this.elevation] = VIEWS[name];
  }

  /** Fit a box (lowest x y z, highest x y z) into the canvas, with room for what lies over it. */
  fit(box) {
    const [scale, ...shift] = this.fitting(box);
    for (let k = 0; k < 3; k++) this.centre[k] = (box[k] + box[k + 3]) / 2;
    this.scale = scale;
    this.move(shift, 1);
    this.restored = false;
  }

  /** Take the size of the canvas and what covers it; what filled it fills it again. */
  resize(width, height, covered, box) {
    const [before, ...old] = box ? this.fitting(box) : [0];
    Object.assign(this, { width, height, covered });
    if (!before) return;
    const [scale, ...shift] = this.fitting(box);
    this.move(old, -1);
    this.scale *= scale / before;
    this.move(shift, 1);
  }

  /** Move the picture a number of pixels to the left and up, once or back. */
  move([left, above], way) {
    this.pan(-way * left, -way * above);
  }

  /**
   * Return the scale at which a box fits into the canvas below its covered edge, and how many pixels to the left and up its middle is of that
   * of the canvas. It is beside or above the covered corner, unless it does not reach that, or half of the picture would be lost.
   */
  fitting(box, margin = 0.9) {
    const { right, up } = this.frame(), { covered } = this, height = this.height - covered.above;
    let wide = 0, high = 0;
    for (let k = 0; k < 3; k++) {
      const half = (box[k + 3] - box[k]) / 2;
      wide += Math.abs(right[k]) * half;
      high += Math.abs(up[k]) * half;
    }
    [wide, high] = [Math.max(wide, 1e-3), Math.max(high, 1e-3)];
    const within = (x, y) => [margin * Math.min((this.width - x) / (2 * wide), (height - y) / (2 * high)), x / 2, (y - covered.above) / 2];
    const whole = within(0, 0), beside = within(covered.right, 0), above = within(0, covered.below);
    const reached = wide * whole[0] > this.width / 2 - covered.right && high * whole[0] > height / 2 - covered.below;
    if (!reached) return whole;
    const best = beside[0] > above[0] ? beside : above;
    return best[0] > whole[0] / 2 ? best : whole;
  }

  /** Return the matrix from space to clip coordinates, by columns, for points within a radius of the centre. */
  matrix(radius) {
    const { right, up, toward } = this.frame();
    const sx = (2 * this.scale) / this.width, sy = (2 * this.scale) / this.height, sz = -1 / Math.max(radius, 1e-6);
    const c = this.centre;
    const rows = [
      [...right.map((v) => sx * v), -sx * (right[0] * c[0] + right[1] * c[1] + right[2] * c[2])],
      [...up.map((v) => sy * v), -sy * (up[0] * c[0] + up[1] * c[1] + up[2] * c[2])],
      [...toward.map((v) => sz * v), -sz * (toward[0] * c[0] + toward[1] * c[1] + toward[2] * c[2])],
      [0, 0, 0, 1],
    ];
    return new Float32Array([0, 1, 2, 3].flatMap((column) => rows.map((row) => row[column])));
  }

  /** Return six numbers that restore the camera. */
  state() {
    const digits = [this.azimuth.toFixed(4), this.elevation.toFixed(4), ...this.centre.map((v) => v.toFixed(3)), this.scale.toPrecision(5)];
    return digits.map(Number).join(",");
  }

  restore(text) {
    const values = text.split(",").map(Number);
    if (values.length !== 6 || values.some((v) => !Number.isFinite(v)) || !(values[5] > 0)) return false;
    [this.azimuth, this.elevation] = values;
    this.centre = values.slice(2, 5);
    this.scale = values[5];
    this.restored = true;
    return true;
  }
}
