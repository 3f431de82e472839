// The path on a canvas of two dimensions, where the browser has no WebGL2: lines over each other in the order in which they are drawn, and
// no surfaces.

/** Points that are drawn at most, each a stroke that the processor draws. */
const POINTS = 60_000;

const css = ([r, g, b, a = 1]) => `rgba(${[r, g, b].map((v) => Math.round(255 * v))},${a})`;

/** Return what `segmentDrawer` returns (gl.js). */
export function flatDrawer(canvas) {
  const g = canvas.getContext("2d");
  let palette = new Uint8Array(1024);
  return {
    vertices: 0,
    most: POINTS,
    setPalette(bytes) {
      palette = bytes;
    },
    begin() {
      g.clearRect(0, 0, canvas.width, canvas.height);
    },
    polyline(points, values, styles) {
      return {
        points,
        values,
        styles,
        setValues(bytes) {
          this.values = bytes;
        },
        free() {},
      };
    },
    draw({ points, values, styles }, { matrix: m, size: [wide, high], width, solid, rapid, opacity = 1 }) {
      const seen = (k) => {
        const x = points[3 * k], y = points[3 * k + 1], z = points[3 * k + 2];
        return [(m[0] * x + m[4] * y + m[8] * z + m[12] + 1) * 0.5 * wide, (1 - m[1] * x - m[5] * y - m[9] * z - m[13]) * 0.5 * high];
      };
      const colour = (k) => (solid ? css(solid) : styles[k] === 1 ? css(rapid) : css(Array.from(palette.subarray(4 * values[k], 4 * values[k] + 3), (v) => v / 255)));
      g.globalAlpha = opacity;
      g.lineWidth = width;
      g.lineJoin = g.lineCap = "round";
      let drawn = "";
      const finish = () => drawn && g.stroke();
      for (let k = 1, p = styles.length && seen(0); k < styles.length; k++) {
        const q = seen(k);
        if (styles[k] === 2) {
          finish();
          drawn = "";
        } else {
          const look = `${styles[k]} ${colour(k)}`;
          if (look !== drawn) {
            finish();
            drawn = look;
            g.strokeStyle = colour(k);
            g.setLineDash(styles[k] === 1 && !solid ? [2.5 * width, 2 * width] : []);
            g.beginPath();
            g.moveTo(...p);
          }
          g.lineTo(...q);
        }
        p = q;
      }
      finish();
      g.globalAlpha = 1;
    },
  };
}
