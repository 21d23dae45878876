import { describe, expect, it } from 'vitest';
import type { Clip, ScenarioDocument } from '../src/core/document';
import { Comparer, pose_before, read_changes, type CompareReply } from '../src/core/motion/comparer';

const half = Math.SQRT1_2;
const reply: CompareReply = {
  from: 2, step: 0.5, link: 0, degrees: 3, time: 2.5, move: 0.01, move_time: 2,
  poses: [[0, 0, 0, 1, 0, 0, 0], [1, 0, 2, half, 0, 0, half], [3, 0, 2, -half, 0, 0, -half]],
};
const clip = { id: 'k1', motion: 'old', start: 2, length: 1, offset: 0, speed: 1, blend: 0, loop: false } as Clip;
const doc = (motion: string): ScenarioDocument => ({ characters: [{ id: 'a', track: [{ ...clip, motion }] }] }) as unknown as ScenarioDocument;

describe('the comparison of a corrected clip', () => {
  it('interpolates the poses before, rotations on the shorter way', () => {
    expect(pose_before(reply, 2)).toEqual(reply.poses[0]);
    const between = pose_before(reply, 2.25)!;
    expect(between.slice(0, 3)).toEqual([0.5, 0, 1]);
    expect(2 * Math.acos(between[3]!)).toBeCloseTo(Math.PI / 4, 6); // half of a right angle
    const same = pose_before(reply, 2.75)!; // q and -q are one rotation
    expect(same[3]! / same[6]!).toBeCloseTo(1, 9);
    expect(Math.hypot(...same.slice(3))).toBeCloseTo(1, 9);
    expect(pose_before(reply, 1.9)).toBeNull();
    expect(pose_before(reply, 3.1)).toBeNull();
  });

  it('reads the measures of the report', () => {
    expect(read_changes(['Sliding of standing feet: 2.40 cm before, 0.20 cm after.', 'Force that the ground cannot supply: 0.068 body weights before, 0.001 body weights after.', 'Joints changed by 1.0° rms.'])).toEqual([
      { name: 'Foot sliding', unit: 'cm', before: '2.40', after: '0.20' },
      { name: 'Missing force', unit: '× weight', before: '0.068', after: '0.001' },
    ]);
  });

  it('ends when the correction is undone', async () => {
    let document = doc('new');
    const asked: unknown[] = [];
    const comparer = new Comparer({ document: () => document, ask: (request) => (asked.push(request), Promise.resolve(reply as unknown as Record<string, unknown>)) });
    await comparer.begin('a', 'k1', clip, []);
    expect(asked).toEqual([{ op: 'compare', character: 'a', clip: 'k1', before: clip }]);
    expect(comparer.state.comparison).toMatchObject({ character: 'a', clip: 'k1', motion: 'new' });
    comparer.check();
    expect(comparer.state.comparison).not.toBeNull();
    document = doc('old');
    comparer.check();
    expect(comparer.state.comparison).toBeNull();
  });

  it('does not begin without the earlier motion', async () => {
    const comparer = new Comparer({ document: () => doc('new'), ask: () => Promise.reject(new Error('gone')) });
    await comparer.begin('a', 'k1', clip, []);
    expect(comparer.state.comparison).toBeNull();
  });
});
