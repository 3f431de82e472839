// Levels of detail of a path: how much each point matters, so that any tolerance picks the points that it needs.

/** Rows of a chunk, of which each has its own box and counts. */
export const CHUNK = 8192;
/** Classes of significance: class k matters where a deviation of unit · 2^(k - 1) does. */
export const CLASSES = 32;

/**
 * Return the class of significance of each point, Uint8Array.
 *
 * A point at an odd multiple of a stride counts by its distance from the middle of the chord of its neighbours at that stride,
 * measured across the chord, and at least as much as all points that hang on it (as triangles do in a restricted hierarchy
 * of terrain). So the points above any class are a path that goes on without gaps, nested in those of every lower class.
 */
export function significance(x, y, z, unit) {
  return ranked(x.length, unit, (a, k, b) => distance(x, y, z, a, k, b));
}

/** Steps of colour, of 255, that no eye tells apart. */
const SHADE = 8;

/**
 * Return classes as `significance` does, of points by their looks: { bytes, steps, rapid }, a byte of colour a point (with `steps` the number
 * of a kind), and a function from a point to its style.
 *
 * A point whose colour is not between those of its neighbours at a stride counts by the length that they would colour wrongly, in parts as
 * wrong as the colour is: four pixels of a wholly wrong colour as one pixel beside the path.
 */
export function lookSignificance(x, y, z, unit, { bytes, steps, rapid }) {
  const n = x.length;
  const styles = Uint8Array.from({ length: n }, (_, k) => rapid(k));
  return ranked(n, unit, (a, k, b) => {
    const turns = styles[a] !== styles[k] || styles[k] !== styles[b];
    const kinds = steps && (bytes[a] !== bytes[k] || bytes[k] !== bytes[b]);
    if (!turns && !kinds && (steps || (bytes[a] === bytes[k] && bytes[k] === bytes[b]))) return 0;
    const before = Math.hypot(x[k] - x[a], y[k] - y[a], z[k] - z[a]);
    const way = before + Math.hypot(x[b] - x[k], y[b] - y[k], z[b] - z[k]);
    if (turns || kinds || way === 0) return 0.25 * way;
    const off = Math.abs(bytes[k] - bytes[a] - (before / way) * (bytes[b] - bytes[a]));
    return off > SHADE ? (0.25 * way * off) / 255 : 0;
  });
}

/** Return classes of points that count by `worth(a, k, b)`: what is lost if the path goes from a to b past k. */
function ranked(n, unit, worth) {
  const error = new Float32Array(n);
  for (let stride = 1; stride < n; stride *= 2) {
    for (let k = stride; k < n; k += 2 * stride) {
      const a = k - stride, b = Math.min(k + stride, n - 1);
      let worst = k === b ? 0 : worth(a, k, b);
      if (stride > 1) {
        const half = stride >> 1;
        worst = Math.max(worst, error[k - half]);
        if (k + half < n) worst = Math.max(worst, error[k + half]);
      }
      if (worst > error[k]) error[k] = worst;
    }
  }
  const found = new Uint8Array(n);
  for (let k = 0; k < n; k++) {
    const e = error[k] / unit;
    found[k] = e < 0.5 ? 0 : Math.min(CLASSES - 2, 1 + Math.floor(Math.log2(2 * e)));
  }
  if (n) found[0] = found[n - 1] = CLASSES - 1;
  return found;
}

function distance(x, y, z, a, k, b) {
  const dx = x[b] - x[a], dy = y[b] - y[a], dz = z[b] - z[a];
  const px = x[k] - x[a], py = y[k] - y[a], pz = z[k] - z[a];
  const length = dx * dx + dy * dy + dz * dz;
  let t = length > 0 ? (px * dx + py * dy + pz * dz) / length : 0;
  t = t < 0 ? 0 : t > 1 ? 1 : t;
  const ex = px - t * dx, ey = py - t * dy, ez = pz - t * dz;
  return Math.sqrt(ex * ex + ey * ey + ez * ez);
}

/** Return boxes (6 numbers a chunk: lowest x y z, highest x y z) and counts (a row a chunk: points of at least each class). */
export function chunked(x, y, z, classes) {
  const chunks = Math.ceil(x.length / CHUNK);
  const boxes = new Float32Array(6 * chunks);
  const counts = new Uint32Array(CLASSES * chunks);
  for (let c = 0; c < chunks; c++) {
    const stop = Math.min((c + 1) * CHUNK + 1, x.length);
    const box = [Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity];
    for (let k = c * CHUNK; k < stop; k++) {
      box[0] = Math.min(box[0], x[k]);
      box[1] = Math.min(box[1], y[k]);
      box[2] = Math.min(box[2], z[k]);
      box[3] = Math.max(box[3], x[k]);
      box[4] = Math.max(box[4], y[k]);
      box[5] = Math.max(box[5], z[k]);
      counts[CLASSES * c + classes[k]]++;
    }
    boxes.set(box, 6 * c);
    for (let level = CLASSES - 2; level >= 0; level--) counts[CLASSES * c + level] += counts[CLASSES * c + level + 1];
  }
  return { boxes, counts };
}

/**
 * Return the rows that a view needs: of each listed chunk the points of at least a class, as few classes as keep below `most`.
 *
 * Chunks that follow each other are joined; a gap is marked by a row that stands twice. `finest` is the class that the view
 * asks for.
 */
export function pick(levels, classes, chunks, finest, most) {
  let level = finest, total = Infinity;
  for (; level < CLASSES - 1; level++) {
    total = 0;
    for (const c of chunks) total += levels.counts[CLASSES * c + level] + 2;
    if (total <= most) break;
  }
  const rows = new Uint32Array(Math.min(total, classes.length + 2 * chunks.length) + 2);
  const n = classes.length;
  let count = 0;
  const gaps = [];
  let before = -2;
  for (const c of chunks) {
    const start = c * CHUNK, stop = Math.min(start + CHUNK, n - 1);
    if (c !== before + 1) {
      if (count) gaps.push(count - 1);
      rows[count++] = start;
    }
    for (let k = start + 1; k < stop; k++) if (classes[k] >= level) rows[count++] = k;
    if (stop > start) rows[count++] = stop;
    before = c;
  }
  return { rows: rows.slice(0, count), gaps, level };
}
