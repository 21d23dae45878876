/**
 * Unpacks LZMA data (the format .lzma of xz-utils, with its size in the header). LZMA makes the engine a quarter smaller than gzip, and
 * browsers cannot unpack it themselves. Source: I. Pavlov, LZMA specification (draft version 2015-06-14).
 */

/** Number of bits of the probabilities; a new probability is one half. */
const one = 11;
const half = (1 << one) >> 1;
const move = 5; // a probability moves by 1/32 of its distance to 0 or 1
const top = 2 ** 24;

/** Decodes single bits with adaptive probabilities (range coder). */
class BitReader {
  private range = 0xffffffff;
  private code = 0;

  constructor(private readonly bytes: Uint8Array, private at: number) {
    at++; // the first byte is 0
    for (let i = 0; i < 4; i++) this.code = ((this.code << 8) | bytes[at + i]!) >>> 0;
    this.at = at + 4;
  }

  bit(probabilities: Uint16Array, index: number): number {
    const p = probabilities[index]!;
    const bound = (this.range >>> one) * p;
    let bit = 0;
    if (this.code < bound) {
      this.range = bound;
      probabilities[index] = p + (((1 << one) - p) >> move);
    } else {
      this.range -= bound;
      this.code -= bound;
      probabilities[index] = p - (p >> move);
      bit = 1;
    }
    if (this.range < top) this.shift();
    return bit;
  }
  /** Bits of equal probability, most significant first. */
  direct(count: number): number {
    let out = 0;
    for (; count > 0; count--) {
      this.range >>>= 1;
      const bit = this.code >= this.range ? 1 : 0;
      if (bit) this.code -= this.range;
      out = out * 2 + bit;
      if (this.range < top) this.shift();
    }
    return out;
  }
  /** A number of `count` bits, most significant first. @param base index of the first of 2^count probabilities */
  tree(probabilities: Uint16Array, base: number, count: number): number {
    let node = 1;
    for (let i = 0; i < count; i++) node = 2 * node + this.bit(probabilities, base + node);
    return node - (1 << count);
  }
  /** A number of `count` bits, least significant first. */
  reverse_tree(probabilities: Uint16Array, base: number, count: number): number {
    let node = 1;
    let out = 0;
    for (let i = 0; i < count; i++) {
      const bit = this.bit(probabilities, base + node);
      node = 2 * node + bit;
      out |= bit << i;
    }
    return out;
  }
  private shift(): void {
    this.range = (this.range << 8) >>> 0;
    this.code = ((this.code << 8) | (this.bytes[this.at++] ?? 0)) >>> 0;
  }
}

const states = 12;
const fresh = (size: number): Uint16Array => new Uint16Array(size).fill(half);

/** Probabilities of the lengths of matches: 2 ... 273. */
class Lengths {
  private readonly choice = fresh(2);
  private readonly low = fresh(16 << 3);
  private readonly mid = fresh(16 << 3);
  private readonly high = fresh(256);
  read(bits: BitReader, position: number): number {
    if (bits.bit(this.choice, 0) === 0) return 2 + bits.tree(this.low, position << 3, 3);
    if (bits.bit(this.choice, 1) === 0) return 10 + bits.tree(this.mid, position << 3, 3);
    return 18 + bits.tree(this.high, 0, 8);
  }
}

/** Throws an Error if the data are damaged. */
export function from_lzma(bytes: Uint8Array): Uint8Array<ArrayBuffer> {
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  const settings = bytes[0]!;
  const size = view.getUint32(5, true);
  if (bytes.length < 18 || settings >= 225 || view.getUint32(9, true) !== 0) throw new Error('The page is damaged: its engine cannot be unpacked.');
  const lc = settings % 9; // number of high bits of the previous byte that select the probabilities of a literal
  const lp = Math.floor(settings / 9) % 5; // the same: low bits of the position
  const position_mask = (1 << Math.floor(settings / 45)) - 1;
  const out = new Uint8Array(size);
  const bits = new BitReader(bytes, 13);
  const literals = fresh(0x300 << (lc + lp));
  const is_match = fresh(states << 4);
  const is_repeat = fresh(states);
  const is_repeat_0 = fresh(states);
  const is_repeat_1 = fresh(states);
  const is_repeat_2 = fresh(states);
  const is_long_repeat_0 = fresh(states << 4);
  const slots = fresh(4 << 6);
  const specials = fresh(128);
  const aligned = fresh(16);
  const lengths = new Lengths();
  const repeat_lengths = new Lengths();
  let [state, at] = [0, 0];
  let [r0, r1, r2, r3] = [0, 0, 0, 0]; // last distances, less 1
  while (at < size) {
    const position = at & position_mask;
    if (bits.bit(is_match, (state << 4) + position) === 0) {
      const previous = at > 0 ? out[at - 1]! : 0;
      const base = 0x300 * (((at & ((1 << lp) - 1)) << lc) + (previous >> (8 - lc)));
      let symbol = 1;
      if (state >= 7) {
        let match = out[at - r0 - 1]!;
        while (symbol < 0x100) {
          const expected = (match >> 7) & 1;
          match <<= 1;
          const bit = bits.bit(literals, base + ((1 + expected) << 8) + symbol);
          symbol = 2 * symbol + bit;
          if (bit !== expected) break;
        }
      }
      while (symbol < 0x100) symbol = 2 * symbol + bits.bit(literals, base + symbol);
      out[at++] = symbol;
      state = state < 4 ? 0 : state < 10 ? state - 3 : state - 6;
      continue;
    }
    let length: number;
    if (bits.bit(is_repeat, state) === 0) {
      [r1, r2, r3] = [r0, r1, r2];
      length = lengths.read(bits, position);
      state = state < 7 ? 7 : 10;
      const slot = bits.tree(slots, Math.min(length - 2, 3) << 6, 6);
      r0 = slot;
      if (slot >= 4) {
        const more = (slot >> 1) - 1;
        r0 = (2 | (slot & 1)) * 2 ** more;
        if (slot < 14) r0 += bits.reverse_tree(specials, r0 - slot, more);
        else r0 += bits.direct(more - 4) * 16 + bits.reverse_tree(aligned, 0, 4);
      }
      if (r0 === 0xffffffff) break; // mark of the end
    } else {
      let short = false;
      if (bits.bit(is_repeat_0, state) === 0) {
        short = bits.bit(is_long_repeat_0, (state << 4) + position) === 0;
      } else if (bits.bit(is_repeat_1, state) === 0) {
        [r0, r1] = [r1, r0];
      } else if (bits.bit(is_repeat_2, state) === 0) {
        [r0, r1, r2] = [r2, r0, r1];
      } else {
        [r0, r1, r2, r3] = [r3, r0, r1, r2];
      }
      length = short ? 1 : repeat_lengths.read(bits, position);
      if (short) state = state < 7 ? 9 : 11;
      else state = state < 7 ? 8 : 11;
    }
    if (r0 >= at || at + length > size) throw new Error('The page is damaged: its engine cannot be unpacked.');
    for (const end = at + length; at < end; at++) out[at] = out[at - r0 - 1]!;
  }
  if (at !== size) throw new Error('The page is damaged: its engine cannot be unpacked.');
  return out;
}
