// What lies over the picture: marks, the tool, a scale bar, the axes, and where the pointer is.

import { cleared } from "./sheet.js";

const TOOL_LENGTH = 46;

export class Overlay {
  constructor(canvas, scene) {
    this.canvas = canvas;
    this.scene = scene;
    this.marks = { corners: true, tools: true, breaches: true, places: true };
    this.sets = [];
    this.hover = this.current = -1;
  }

  /** Take marks: [{ kind, rows: [row …], label }]. */
  setMarks(sets) {
    this.sets = sets;
  }

  draw() {
    const { canvas, scene } = this, { camera } = scene;
    const ratio = scene.ratio || 1, g = cleared(canvas, scene.canvas.width, scene.canvas.height);
    g.scale(ratio, ratio);
    const style = getComputedStyle(canvas);
    const ink = style.getPropertyValue("--ink").trim(), quiet = style.getPropertyValue("--quiet").trim();
    const accent = style.getPropertyValue("--accent").trim(), paper = style.getPropertyValue("--paper").trim();
    const part = scene.layers[0]?.part;
    if (!part) return;
    const at = (row) => camera.project(part.points[0][row], part.points[1][row], part.points[2][row]);
    const sets = this.sets.filter((set) => this.marks[set.kind] && set.rows.length), depths = sets.length ? scene.depths() : null;
    for (const set of sets) this.drawMarks(g, set, at, depths, style, paper);
    this.axes(g, camera, quiet);
    this.scaleBar(g, camera, quiet);
    if (this.current >= 0) this.tool(g, camera, at(this.current), accent, paper);
    if (this.hover >= 0) ring(g, at(this.hover), 6, ink, paper);
  }

  drawMarks(g, set, at, depths, style, paper) {
    const colour = style.getPropertyValue(`--mark-${set.kind}`).trim();
    const { width, height } = this.scene.camera;
    const step = Math.max(1, Math.ceil(set.rows.length / 4000));
    g.lineWidth = 1.5;
    for (let k = 0; k < set.rows.length; k += step) {
      const place = at(set.rows[k]), [x, y] = place;
      if (x < -10 || y < -10 || x > width + 10 || y > height + 10 || depths?.hides(place)) continue;
      if (set.kind === "places") badge(g, x, y, String(k + 1), colour, paper);
      else if (set.kind === "tools") shape(g, x, y, 4, 6.5, colour, paper);
      else if (set.kind === "breaches") cross(g, x, y, colour);
      else shape(g, x, y, 20, set.rows.length > 60 ? 1.8 : 3.2, null, colour);
    }
  }

  tool(g, camera, [x, y], accent, paper) {
    const { up } = camera.frame();
    const rise = TOOL_LENGTH * up[2], flat = 7 * Math.abs(Math.sin(camera.elevation));
    g.save();
    g.translate(x, y);
    if (rise > 6 && !this.scene.turned) {
      const body = g.createLinearGradient(-8, 0, 8, 0);
      body.addColorStop(0, "rgba(120,130,145,.55)");
      body.addColorStop(0.4, "rgba(235,240,248,.75)");
      body.addColorStop(1, "rgba(90,100,115,.6)");
      g.fillStyle = body;
      g.beginPath();
      g.moveTo(0, 0);
      g.lineTo(6, -0.3 * rise);
      g.lineTo(6, -rise);
      g.ellipse(0, -rise, 6, Math.max(0.5, flat * 0.85), 0, 0, Math.PI, true);
      g.lineTo(-6, -0.3 * rise);
      g.closePath();
      g.fill();
      g.strokeStyle = "rgba(60,70,85,.6)";
      g.lineWidth = 0.75;
      g.stroke();
    }
    g.restore();
    ring(g, [x, y], 5, accent, paper, true);
  }

  axes(g, camera, quiet) {
    const { right, up } = camera.frame(), x = 44, y = camera.height - 44;
    g.font = "600 11px system-ui, sans-serif";
    g.textAlign = "center";
    g.textBaseline = "middle";
    const colours = ["#e5484d", "#30a46c", "#3b82f6"];
    const turned = [["Z", 1, 2], ["Y", -1, 1], ["X", 1, 0]], upright = [["X", 1, 0], ["Y", 1, 1], ["Z", 1, 2]];
    (this.scene.turned ? turned : upright).forEach(([name, sign, colour], k) => {
      const dx = sign * 26 * right[k], dy = sign * -26 * up[k];
      if (Math.hypot(dx, dy) < 3) return;
      g.strokeStyle = g.fillStyle = colours[colour];
      g.lineWidth = 1.75;
      g.beginPath();
      g.moveTo(x, y);
      g.lineTo(x + dx, y + dy);
      g.stroke();
      g.fillText(name, x + dx * 1.35, y + dy * 1.35);
    });
    g.fillStyle = quiet;
    g.beginPath();
    g.arc(x, y, 2, 0, 7);
    g.fill();
  }

  scaleBar(g, camera, quiet) {
    // Between the axes on its left and the legend on its right.
    const wanted = Math.max(40, Math.min(110, camera.width - 300)) / camera.scale, power = 10 ** Math.floor(Math.log10(wanted));
    const length = power * [5, 2, 1].find((factor) => factor * power <= wanted * (1 + 1e-9));
    const pixels = length * camera.scale, x = 84, y = camera.height - 26;
    g.strokeStyle = g.fillStyle = quiet;
    g.lineWidth = 1;
    g.beginPath();
    g.moveTo(x + 0.5, y - 4);
    g.lineTo(x + 0.5, y + 0.5);
    g.lineTo(x + pixels + 0.5, y + 0.5);
    g.lineTo(x + pixels + 0.5, y - 4);
    g.stroke();
    g.font = "11px system-ui, sans-serif";
    g.textAlign = "left";
    g.textBaseline = "alphabetic";
    g.fillText(length >= 0.01 ? `${Number(length.toPrecision(6))} mm` : `${Number((1000 * length).toPrecision(6))} µm`, x + 6, y - 6);
  }
}

function ring(g, [x, y], radius, colour, paper, filled = false) {
  g.beginPath();
  g.arc(x, y, radius, 0, 2 * Math.PI);
  g.strokeStyle = paper;
  g.lineWidth = 4;
  g.stroke();
  g.strokeStyle = colour;
  g.lineWidth = 2;
  g.stroke();
  if (filled) {
    g.beginPath();
    g.arc(x, y, 2, 0, 2 * Math.PI);
    g.fillStyle = colour;
    g.fill();
  }
}

function shape(g, x, y, sides, radius, fill, stroke) {
  g.beginPath();
  for (let k = 0; k < sides; k++) {
    const angle = (2 * Math.PI * k) / sides;
    g.lineTo(x + radius * Math.cos(angle), y + radius * Math.sin(angle));
  }
  g.closePath();
  if (fill) {
    g.fillStyle = fill;
    g.fill();
  }
  g.strokeStyle = stroke;
  g.stroke();
}

function cross(g, x, y, colour) {
  g.strokeStyle = colour;
  g.lineWidth = 2.5;
  g.beginPath();
  for (const [a, b] of [[-5, -5], [-5, 5]]) {
    g.moveTo(x + a, y + b);
    g.lineTo(x - a, y - b);
  }
  g.stroke();
}

function badge(g, x, y, text, colour, paper) {
  g.font = "600 10px system-ui, sans-serif";
  g.textAlign = "center";
  g.textBaseline = "middle";
  g.beginPath();
  g.arc(x, y, 8, 0, 2 * Math.PI);
  g.fillStyle = colour;
  g.fill();
  g.strokeStyle = paper;
  g.lineWidth = 1.5;
  g.stroke();
  g.fillStyle = paper;
  g.fillText(text, x, y + 0.5);
}
