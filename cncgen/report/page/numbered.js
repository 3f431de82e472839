// A program's text from its skeleton and the columns of its numbers (docs/page.md).

import { section } from "./decode.js";

const WHOLE = 0xc0, FEWEST = 0xc1, FIXED = 0xf5;
const PLACES = 16, NEWLINE = 10, POINT = 46, MINUS = 45;

/** Return a text: of a place in the blob as it is, else put together. */
export function textOf(blob, spec) {
  if (Array.isArray(spec)) return new TextDecoder().decode(section(blob, spec));
  const columns = spec.columns.map((column) => read(blob, column));
  return new TextDecoder().decode(joined(section(blob, spec.skeleton), columns, spec));
}

function read(blob, { key, decimals, order, count, planes }) {
  const values = new Float64Array(count);
  const bytes = planes.map((at) => section(blob, at));
  for (let p = bytes.length - 1; p >= 0; p--) for (let k = 0; k < count; k++) values[k] = 256 * values[k] + bytes[p][k];
  for (let k = 0; k < count; k++) values[k] = values[k] % 2 ? -(values[k] + 1) / 2 : values[k] / 2;
  for (let n = 0; n < order; n++) for (let k = 1; k < count; k++) values[k] += values[k - 1];
  return { key, decimals, values, next: 0 };
}

function joined(skeleton, columns, { length, bare }) {
  const out = new Uint8Array(length), byKey = new Map(columns.map((column) => [column.key, column]));
  const few = byKey.get(-1), seen = new Map();
  let at = 0, before = NEWLINE;
  for (const sign of skeleton) {
    if (sign === WHOLE || sign === FEWEST || (sign >= FIXED && sign <= FIXED + 6)) {
      const place = seen.get(before) ?? 0;
      seen.set(before, place + 1);
      const column = byKey.get(PLACES * before + Math.min(place, PLACES - 1)) ?? few;
      at = write(out, at, column.values[column.next++], column.decimals, sign, bare);
    } else {
      out[at++] = sign;
      if (sign === NEWLINE) seen.clear();
    }
    before = sign;
  }
  return out;
}

function write(out, at, value, decimals, sign, bare) {
  if (value < 0) out[at++] = MINUS;
  const digits = String(Math.abs(value)).padStart(decimals + 1, "0"), whole = digits.length - decimals;
  const put = (from, to) => {
    for (let k = from; k < to; k++) out[at++] = digits.charCodeAt(k);
  };
  let end = sign >= FIXED ? whole + sign - FIXED : whole;
  if (sign === FEWEST) {
    end = digits.length;
    while (end > whole && digits.charCodeAt(end - 1) === 48) end--;
  }
  if (!(bare && whole === 1 && digits[0] === "0" && sign !== WHOLE)) put(0, whole);
  if (sign !== WHOLE) out[at++] = POINT;
  put(whole, end);
  return at;
}
