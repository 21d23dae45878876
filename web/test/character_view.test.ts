import { describe, expect, it } from 'vitest';
import type { MechanismData } from '../src/core/protocol';
import { lowest_point } from '../src/view/character_view';

const half = Math.SQRT1_2;
/** Mechanism of one link with a capsule along its z axis: radius 0.1 m, length 0.6 m without the end caps. */
const capsule = (neutral: number[]): MechanismData => ({
  id: 'm', name: 'Rod', dofs: 6, mass: 1, height: 0.8,
  links: [{ name: 'rod', parent: -1, joint: 'floating', dofs: 6, neutral, shapes: [{ type: 'capsule', radius: 0.1, half_length: 0.3, pose: [0, 0, 0, 1, 0, 0, 0] }] }],
} as unknown as MechanismData);

describe('the lowest point of a mechanism', () => {
  it('follows from the shapes in the neutral pose', () => {
    expect(lowest_point(capsule([0, 0, 1, 1, 0, 0, 0]))).toBeCloseTo(0.6, 3);
    expect(lowest_point(capsule([0, 0, 1, half, 0, half, 0]))).toBeCloseTo(0.9, 2); // lying; the drawn capsule has facets, up to 1 mm inside the exact surface
  });
  it('is 0 without shapes', () => {
    const rod = capsule([0, 0, 1, 1, 0, 0, 0]);
    expect(lowest_point({ ...rod, links: [{ ...rod.links[0]!, shapes: [] }] })).toBe(0);
  });
});
