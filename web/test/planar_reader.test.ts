import { describe, expect, it } from 'vitest';
import { fits_planar } from '../src/view/planar_reader';

describe('planar pictures', () => {
  it('need an even width and an even height', () => {
    expect([fits_planar(1920, 1080), fits_planar(1921, 1080), fits_planar(1920, 1081)]).toEqual([true, false, false]);
  });
});
