// A signal with a value for each row, packed (docs/page.md): each block has a predictor and a table of frequencies.

import { section } from "./decode.js";

const BLOCK = 64, SEGMENT = 65536, TABLES = 16, ESCAPE = 255;
const WHOLE = 4096, LOWEST = 8388608, PARTS = 1048576;

/** Return the integers of a packed stream: Int32Array, or Float64Array where they are wider. */
export function packed(blob, spec, predictors) {
  const [blocks, tables, escapes] = [spec.blocks, spec.tables, spec.escapes].map((at) => section(blob, at));
  const code = blob.subarray(spec.code[0], spec.code[0] + spec.code[1]);
  return unpacked(code, blocks, new Uint16Array(tables.buffer), new Float64Array(escapes.buffer, 0, escapes.length >> 3), predictors, spec);
}

function unpacked(code, blocks, tables, escapes, predictors, { count, wide }) {
  const out = wide ? new Float64Array(count) : new Int32Array(count);
  const weights = predictors.map((list) => Float64Array.from(list)), lead = Math.max(...predictors.map((list) => list.length));
  // Differences of rows: those that the longest predictor needs, then those of the segment.
  const d = new Float64Array(lead + SEGMENT);
  const chart = { symbol: new Uint8Array(TABLES * WHOLE), share: new Int32Array(TABLES * 256), below: new Int32Array(TABLES * 256) };
  const { symbol, share, below } = chart, rest = new Float64Array(BLOCK);
  let at = 0, read = 0, escape = 0, block = 0, last = 0;
  for (let start = 0; start < count; start += SEGMENT) {
    const size = Math.min(SEGMENT, count - start);
    read = charted(chart, tables, read);
    let state = (code[at] << 24) | (code[at + 1] << 16) | (code[at + 2] << 8) | code[at + 3];
    at += 4;
    for (let first = 0; first < size; first += BLOCK) {
      const kind = blocks[block++], table = kind % TABLES, w = weights[(kind - table) / TABLES], n = w.length;
      const end = Math.min(first + BLOCK, size);
      for (let k = first; k < end; k++) {
        const slot = state & (WHOLE - 1), found = symbol[table * WHOLE + slot], entry = table * 256 + found;
        state = share[entry] * (state >>> 12) + slot - below[entry];
        while (state < LOWEST) state = (state << 8) | code[at++];
        if (found !== ESCAPE) rest[k - first] = (found >>> 1) ^ -(found & 1);
        else {
          const large = escapes[escape++];
          rest[k - first] = large % 2 ? -(large + 1) / 2 : large / 2;
        }
      }
      for (let k = first, i = 0; k < end; k++, i++) {
        let next = rest[i];
        if (n) {
          let sum = PARTS / 2, from = lead + k - 1;
          for (let j = 0; j < n; j++) sum += w[j] * d[from--];
          next += Math.floor(sum / PARTS);
        }
        d[lead + k] = next;
        last += next;
        out[start + k] = last;
      }
    }
    d.copyWithin(0, size, size + lead);
  }
  return out;
}

/** Take the tables of a segment: the symbol of each slot, its share of them, and how many lie below. Return where the next ones are. */
function charted({ symbol, share, below }, tables, read) {
  for (let table = 0; table < TABLES; table++) {
    const length = tables[read++];
    let slot = 0;
    for (let s = 0; s < length; s++) {
      const wide = tables[read++], entry = table * 256 + s;
      share[entry] = wide;
      below[entry] = slot;
      symbol.fill(s, table * WHOLE + slot, table * WHOLE + slot + wide);
      slot += wide;
    }
  }
  return read;
}
