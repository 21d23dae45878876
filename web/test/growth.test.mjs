import { describe, expect, it } from 'vitest';
import { rise, slope } from '../../benchmarks/studio/growth.mjs';

describe('growth of the memory in a soak', () => {
  it('is the rise of a line, whatever its start', () => {
    expect(slope([7, 7.5, 8, 8.5])).toBeCloseTo(0.5, 12);
    expect(rise([7, 7.5, 8, 8.5])).toBeCloseTo(1.5, 12);
    expect(rise([3])).toBe(0);
  });

  it('changes little by one sample that contains garbage, where the difference of two samples is wrong by all of it', () => {
    const steady = Array.from({ length: 61 }, () => 30);
    steady[60] = 42;
    expect(rise(steady)).toBeLessThan(1.2);
    const leak = Array.from({ length: 61 }, (_, minute) => 30 + 0.2 * minute);
    leak[0] = 42; // the difference of the two ends is 0
    expect(rise(leak)).toBeGreaterThan(10);
  });
});
