import { describe, expect, it } from 'vitest';
import { from_base85 } from '../src/player/payload';

describe('data inside an exported page', () => {
  it('decodes base 85: most significant digit first, bytes dropped at the end', () => {
    const letters = [...Array(94).keys()].map((k) => String.fromCharCode(33 + k)).filter((c) => !'"$&\'<>\\`'.includes(c));
    const text = (dropped: number, digits: number[]): string => [dropped, ...digits].map((d) => letters[d]).join('');
    expect([...from_base85(text(0, [0, 0, 0, 0, 1]))]).toEqual([0, 0, 0, 1]);
    expect([...from_base85(text(0, [82, 23, 54, 12, 0]))]).toEqual([255, 255, 255, 255]); // 2^32 - 1
    expect([...from_base85(text(3, [82, 23, 54, 12, 0]))]).toEqual([255]);
    expect([...from_base85(text(0, []))]).toEqual([]);
  });
});
