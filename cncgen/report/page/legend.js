// The legend: colours with how much time each has.

import { colourOf, css, scaleText } from "./colouring.js";
import { partly, share } from "./format.js";
import { sheet } from "./sheet.js";
import { element } from "./tables.js";

/** Fill a box with the legend of a colouring. */
export function legend(box, colouring, theme, whole) {
  box.replaceChildren();
  if (!colouring) return;
  // On paper, where the choice of colours is not to be seen.
  box.append(element("strong", {}, colouring.label));
  if (colouring.kinds) {
    const most = Math.max(...colouring.kinds.map((kind) => kind.seconds));
    const items = colouring.kinds.slice(0, 12).map((kind, k) => {
      const swatch = element("span", { class: "swatch" });
      swatch.style.background = css(colourOf(colouring, k, theme));
      return element("li", {}, swatch, element("span", { class: "name" }, kind.name), element("span", { class: "value" }, `${partly(kind.seconds, most)} · ${share(kind.seconds / whole)}`));
    });
    if (colouring.note) items.push(element("li", {}, colouring.note));
    box.append(element("ul", {}, ...items));
    return;
  }
  const canvas = element("canvas", { role: "img", "aria-label": "How much time each colour has" });
  const middle = (colouring.low + colouring.high) / 2;
  const scale = [colouring.low, middle, colouring.high].map((value, k) => element("span", {}, scaleText(value, colouring.unit, k === 2)));
  if (colouring.beyond !== null) scale[2].append(element("small", {}, ` up to ${scaleText(colouring.beyond, colouring.unit)}`));
  box.append(canvas, element("div", { class: "scale" }, ...scale));
  drawHistogram(canvas, colouring, theme);
}

function drawHistogram(canvas, colouring, theme) {
  const ratio = window.devicePixelRatio || 1, width = 236, height = 46, ramp = 8;
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  const g = sheet(canvas);
  g.scale(ratio, ratio);
  const { histogram } = colouring, bins = histogram.length, most = Math.max(...histogram) || 1;
  for (let k = 0; k < bins; k++) {
    g.fillStyle = css(colourOf(colouring, Math.round(((k + 0.5) * 255) / bins), theme));
    const x = (k * width) / bins, w = width / bins + 0.4;
    g.fillRect(x, height - ramp, w, ramp);
    const tall = Math.sqrt(histogram[k] / most) * (height - ramp - 3);
    g.globalAlpha = 0.85;
    if (histogram[k]) g.fillRect(x, height - ramp - 2 - Math.max(1, tall), w - 0.8, Math.max(1, tall));
    g.globalAlpha = 1;
  }
}
