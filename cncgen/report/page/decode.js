// Streams of the page as arrays (docs/page.md): base 85, inflate, integers from their differences, runs, bands.

import { inflated } from "./inflate.js";

const DIGITS = "!#%()*+,./0123456789:;=?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[]^_abcdefghijklmnopqrstuvwxyz{|}~";

/** Return the bytes of a text in base 85, five digits for four bytes; the last bytes may be zeros that fill it. */
export function bytesOf(text) {
  const values = new Uint8Array(128);
  for (let k = 0; k < DIGITS.length; k++) values[DIGITS.charCodeAt(k)] = k;
  const words = Math.floor(text.length / 5);
  const bytes = new Uint8Array(4 * words);
  for (let w = 0, c = 0, b = 0; w < words; w++, c += 5, b += 4) {
    let value = values[text.charCodeAt(c)];
    for (let k = 1; k < 5; k++) value = value * 85 + values[text.charCodeAt(c + k)];
    bytes[b] = value >>> 24;
    bytes[b + 1] = value >>> 16;
    bytes[b + 2] = value >>> 8;
    bytes[b + 3] = value;
  }
  return bytes;
}

/** Return the part of a blob at [offset, length], inflated. */
export function section(blob, at) {
  return inflated(blob.subarray(at[0], at[0] + at[1]));
}

/** Return the integers of a stream: Int32Array, or Float64Array where they are wider. */
export function integers(blob, spec) {
  const bytes = section(blob, spec.at), more = section(blob, spec.escapes);
  const escapes = new Float64Array(more.buffer, 0, more.length >> 3);
  return summed(bytes, escapes, spec);
}

/** Undo zigzag and differences of up to third order. */
export function summed(bytes, escapes, spec) {
  const count = spec.count;
  const out = spec.wide ? new Float64Array(count) : new Int32Array(count);
  let first = 0, second = 0, third = 0, next = 0;
  for (let k = 0; k < count; k++) {
    let folded = bytes[k];
    if (folded === 255) folded = escapes[next++];
    const rest = folded % 2 ? -(folded + 1) / 2 : folded / 2;
    if (spec.order === 3) {
      third += rest;
      second += third;
      first += second;
    } else if (spec.order === 2) {
      second += rest;
      first += second;
    } else if (spec.order === 1) {
      first += rest;
    } else {
      first = rest;
    }
    out[k] = first;
  }
  return out;
}

/** Return a signal of runs: value of each run, and where each begins; the last entry of `starts` is the number of rows. */
export function runs(blob, spec) {
  const values = integers(blob, spec.values), lengths = integers(blob, spec.lengths);
  const starts = new Uint32Array(lengths.length + 1);
  for (let k = 0; k < lengths.length; k++) starts[k + 1] = starts[k] + lengths[k];
  return { values, starts };
}

/** Return a band: lowest and highest value of each block of rows; the same array twice where a block is one row. */
export function band(blob, spec) {
  const low = integers(blob, spec.low);
  if (!spec.spread) return { low, high: low, block: spec.block, step: spec.step };
  const high = integers(blob, spec.spread);
  for (let k = 0; k < high.length; k++) high[k] += low[k];
  return { low, high, block: spec.block, step: spec.step };
}

/** Return the index of the run that a row is in. */
export function runAt(starts, row) {
  let low = 0, high = starts.length - 2;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (starts[middle] <= row) low = middle;
    else high = middle - 1;
  }
  return low;
}
