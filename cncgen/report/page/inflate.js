// Inflating zlib's format (RFC 1950 and 1951). The browser's own DecompressionStream answers later, so that a page with it is not yet there
// when it has loaded.

/** The order in which the lengths of the code of lengths stand (RFC 1951, 3.2.7). */
const ORDER = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];
/** Lowest value and extra bits of each symbol of a length, and of a distance (3.2.5). */
const LENGTHS = values(29, 3, 2), DISTANCES = values(30, 1, 1);
[LENGTHS.lowest[28], LENGTHS.extra[28]] = [258, 0];

function values(count, first, shift) {
  const lowest = new Uint16Array(count), extra = new Uint8Array(count);
  for (let k = 0, next = first; k < count; k++) {
    lowest[k] = next;
    extra[k] = Math.max(0, (k >> shift) - 1);
    next += 1 << extra[k];
  }
  return { lowest, extra };
}

/** Bits of bytes, the lowest ones first. */
class Bits {
  constructor(bytes, at) {
    Object.assign(this, { bytes, at, held: 0, count: 0 });
  }

  /** Return the next bits as a number, up to 16. */
  take(count) {
    this.need(count);
    const found = this.held & ((1 << count) - 1);
    this.drop(count);
    return found;
  }

  /** Return the next symbol of a code. */
  symbol({ table, width }) {
    this.need(width);
    const found = table[this.held & ((1 << width) - 1)];
    if (!(found & 15)) throw new Error("a code of the data is unknown");
    this.drop(found & 15);
    return found >> 4;
  }

  need(count) {
    for (; this.count < count; this.count += 8) this.held |= this.bytes[this.at++] << this.count;
    if (this.at > this.bytes.length + 4) throw new Error("the data ends too early");
  }

  drop(count) {
    this.held >>>= count;
    this.count -= count;
  }

  /** Go on at the next whole byte. */
  align() {
    this.drop(this.count & 7);
  }
}

/** Return the code of symbols with given lengths (3.2.2) as a table over its next bits: 16 · symbol + length, 0 where there is none. */
function code(lengths) {
  const width = Math.max(1, ...lengths), table = new Uint16Array(1 << width);
  for (let length = 1, next = 0; length <= width; length++, next <<= 1) {
    for (let symbol = 0; symbol < lengths.length; symbol++) {
      if (lengths[symbol] !== length) continue;
      let first = 0;
      for (let k = 0; k < length; k++) first |= ((next >> k) & 1) << (length - 1 - k);
      for (let k = first; k < table.length; k += 1 << length) table[k] = 16 * symbol + length;
      next++;
    }
  }
  return { table, width };
}

/** The codes of a block that does not bring its own (3.2.6). */
function fixed() {
  const lengths = new Uint8Array(288).fill(8);
  lengths.fill(9, 144, 256).fill(7, 256, 280);
  return [code(lengths), code(new Uint8Array(30).fill(5))];
}

/** Read the codes that a block brings (3.2.7). */
function brought(bits) {
  const literals = bits.take(5) + 257, distances = bits.take(5) + 1, count = bits.take(4) + 4;
  const first = new Uint8Array(19);
  for (let k = 0; k < count; k++) first[ORDER[k]] = bits.take(3);
  const lengths = new Uint8Array(literals + distances), of = code(first);
  for (let k = 0; k < lengths.length; ) {
    const symbol = bits.symbol(of);
    if (symbol < 16) {
      lengths[k++] = symbol;
      continue;
    }
    const repeats = symbol === 16 ? 3 + bits.take(2) : symbol === 17 ? 3 + bits.take(3) : 11 + bits.take(7);
    lengths.fill(symbol === 16 ? lengths[k - 1] : 0, k, k + repeats);
    k += repeats;
  }
  return [code(lengths.subarray(0, literals)), code(lengths.subarray(literals))];
}

/** Inflate bytes in zlib's format; whatever stands behind them is passed over. */
export function inflated(bytes) {
  if (!bytes.length) return new Uint8Array(0);
  const bits = new Bits(bytes, 2);
  let out = new Uint8Array(4 * bytes.length + 256), size = 0;
  const room = (more) => {
    if (size + more <= out.length) return;
    const wider = new Uint8Array(2 * out.length + more);
    wider.set(out);
    out = wider;
  };
  for (let last = 0; !last; ) {
    last = bits.take(1);
    const kind = bits.take(2);
    if (kind === 3) throw new Error("a block of the data is of no known kind");
    if (kind === 0) {
      bits.align();
      const length = bits.take(16);
      bits.take(16);
      room(length);
      for (let k = 0; k < length; k++) out[size++] = bits.take(8);
      continue;
    }
    const [literal, distance] = kind === 1 ? fixed() : brought(bits);
    for (let symbol; (symbol = bits.symbol(literal)) !== 256; ) {
      room(258);
      if (symbol < 256) {
        out[size++] = symbol;
        continue;
      }
      const length = LENGTHS.lowest[symbol - 257] + bits.take(LENGTHS.extra[symbol - 257]), far = bits.symbol(distance);
      let from = size - DISTANCES.lowest[far] - bits.take(DISTANCES.extra[far]);
      for (let k = 0; k < length; k++) out[size++] = out[from++];
    }
  }
  bits.align();
  let check = 0;
  for (let k = 0; k < 4; k++) check = 256 * check + bits.take(8);
  if (check !== adler(out, size)) throw new Error("the sum of the data is wrong");
  return out.slice(0, size);
}

/** Return the check value of bytes (RFC 1950, 8.2). */
function adler(bytes, size) {
  let a = 1, b = 0;
  for (let k = 0; k < size; ) {
    // So many bytes may be added before the sums pass 32 bits.
    for (const stop = Math.min(size, k + 3800); k < stop; k++) b += a += bytes[k];
    a %= 65521;
    b %= 65521;
  }
  return b * 65536 + a;
}
