import { describe, expect, it } from 'vitest';
import { from_world, GaitDesk, path_length, smooth_path, to_world, with_lead, type Point } from '../src/core/motion/gait';

function make() {
  const made: unknown[] = [];
  const desk = new GaitDesk({
    ask: () => Promise.resolve({ gaits: { kinds: [{ kind: 'walk', speed: 1.2 }], styles: ['usual'], start: { x: 2, y: 1, heading: 90 } } }),
    make: (request) => {
      made.push(request);
      return Promise.resolve(true);
    },
    fail: (error) => made.push(error.message),
  });
  return { desk, made };
}
const target = { character: 'human', clip: 'k1' };

describe('paths of gaits', () => {
  it('are stored in the frame of the clip', () => {
    const start = { x: 2, y: 1, heading: 90 };
    expect(to_world(start, [3, 0])[0]).toBeCloseTo(2);
    expect(to_world(start, [3, 0])[1]).toBeCloseTo(4);
    const point: Point = [-1.5, 2.25];
    expect(from_world(start, to_world(start, point))).toEqual(point);
  });

  it('go smoothly through all points', () => {
    const corners: Point[] = [[0, 0], [2, 0], [2, 2], [5, 2]];
    const curve = smooth_path(corners, 8);
    for (const c of corners) expect(Math.min(...curve.map((p) => Math.hypot(p[0] - c[0], p[1] - c[1])))).toBeLessThan(1e-9);
    expect(path_length(curve)).toBeGreaterThan(6);
    expect(smooth_path([[0, 0], [4, 0]]).every((p) => Math.abs(p[1]) < 1e-12)).toBe(true);
    expect(path_length(smooth_path([[0, 0], [4, 0]]))).toBeCloseTo(4);
  });

  it('begin straight ahead, because a clip is placed by the heading of its first frame', () => {
    const curve = smooth_path(with_lead([[0, 4]]));
    expect(curve[1]![0]).toBeGreaterThan(0.01);
    expect(Math.abs(curve[1]![1])).toBeLessThan(0.3 * curve[1]![0]);
    expect(curve.at(-1)).toEqual([0, 4]);
  });

  it('are drawn by clicks, and only a finished path changes the gait', async () => {
    const { desk, made } = make();
    expect(desk.add([1, 1])).toBe(false);
    await desk.draw(target);
    expect(desk.add([2, 3])).toBe(true);
    desk.add([2.01, 3.01]); // the second click of a double click
    desk.add([2, 5]);
    desk.add([9, 9]);
    desk.remove_last();
    expect(desk.cancel()).toBe(true);
    expect(made).toEqual([]);
    await desk.draw(target);
    desk.add([2, 3]);
    desk.add([1, 4]);
    await desk.finish();
    expect(made).toEqual([{ ...target, gait: { path: [[2, 0], [3, 1]] } }]);
    expect(desk.state.drawing).toBeNull();
  });
});
