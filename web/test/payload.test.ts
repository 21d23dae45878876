import { describe, expect, it } from 'vitest';
import { from_base91 } from '../src/player/payload';

describe('data inside an exported page', () => {
  it('decodes base 91: most significant bits first, bytes dropped at the end', () => {
    const letters = [...Array(94).keys()].map((k) => String.fromCharCode(33 + k)).filter((c) => !'"<\\'.includes(c));
    const text = (dropped: number, words: number[]): string => [dropped, ...words.flatMap((w) => [Math.floor(w / 91), w % 91])].map((d) => letters[d]).join('');
    expect(letters).toHaveLength(91);
    expect([...from_base91(text(0, [8191]))]).toEqual([255]);
    expect([...from_base91(text(1, [0x1234 >> 3, (0x1234 & 7) << 10]))]).toEqual([0x12, 0x34]); // 26 bits: 3 bytes, one dropped
    expect([...from_base91(text(0, []))]).toEqual([]);
    // 13 bytes are 8 words without a rest
    const bytes = [...Array(13).keys()].map((k) => (k * 89 + 200) % 256);
    const bits = bytes.map((b) => b.toString(2).padStart(8, '0')).join('');
    expect([...from_base91(text(0, bits.match(/.{13}/g)!.map((b) => parseInt(b, 2))))]).toEqual(bytes);
  });
});
