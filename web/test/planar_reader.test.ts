import { describe, expect, it } from 'vitest';
import { fits_planar, to_planar } from '../src/view/planar_reader';

const width = 8;
const height = 6;

/** A picture of random colours. Row 0 is at the bottom. */
function random_picture(): Uint8Array {
  const rgba = new Uint8Array(4 * width * height);
  let seed = 1;
  for (let i = 0; i < rgba.length; i++) {
    seed = (seed * 48271) % 2147483647;
    rgba[i] = [0, 255, seed & 255][seed % 3]!;
  }
  return rgba;
}

describe('to_planar', () => {
  it('gives the values of ITU-R BT.709 in limited range, rows from the top', () => {
    const rgba = random_picture();
    const out = new Uint8Array((3 * width * height) / 2);
    to_planar(rgba, width, height, out);
    const colour = (x: number, y: number): number[] => [0, 1, 2].map((k) => rgba[4 * ((height - 1 - y) * width + x) + k]! / 255);
    const luma = ([r, g, b]: number[]): number => 0.2126 * r! + 0.7152 * g! + 0.0722 * b!;
    // 0.51: half a level of rounding, and the error of the 16-bit coefficients
    for (let y = 0; y < height; y++) for (let x = 0; x < width; x++) expect(Math.abs(out[y * width + x]! - (16 + 219 * luma(colour(x, y))))).toBeLessThan(0.51);
    const plane = (width * height) / 4;
    for (let y = 0; y < height / 2; y++)
      for (let x = 0; x < width / 2; x++) {
        const four = [[0, 0], [1, 0], [0, 1], [1, 1]].map(([i, j]) => colour(2 * x + i!, 2 * y + j!));
        const mean = [0, 1, 2].map((k) => four.reduce((sum, c) => sum + c[k]! / 4, 0));
        const at = width * height + (y * width) / 2 + x;
        expect(Math.abs(out[at]! - (128 + (224 * (mean[2]! - luma(mean))) / 1.8556))).toBeLessThan(0.51);
        expect(Math.abs(out[at + plane]! - (128 + (224 * (mean[0]! - luma(mean))) / 1.5748))).toBeLessThan(0.51);
      }
  });

  it('needs an even width and an even height', () => {
    expect([fits_planar(1920, 1080), fits_planar(1921, 1080), fits_planar(1920, 1081)]).toEqual([true, false, false]);
  });
});
