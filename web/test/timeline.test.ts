import { describe, expect, it } from 'vitest';
import { apply_command, type Clip } from '../src/core/document';
import { changed_fields, drag_clip, ends_moving, fit_view, loop_to_end, move_clip, pan_by, ruler_steps, snap_delta, snap_targets, time_to_x, x_to_time, zoom_at, type SnapRules } from '../src/core/timeline';
import { sample_document } from './sample';

const clip: Clip = { id: 'k', motion: 'n', start: 1, length: 2, offset: 0.5, speed: 1, blend: 0.3, loop: false };
const rules = (more: Partial<SnapRules> = {}): SnapRules => ({ targets: [], tolerance: 0.1, frame_rate: 60, enabled: true, ...more });

describe('view', () => {
  it('keeps the time under the cursor when it zooms', () => {
    const view = { origin: 2, scale: 50 };
    const at = x_to_time(view, 300);
    for (const factor of [0.9, 1.1, 4]) expect(x_to_time(zoom_at(view, 300, factor), 300)).toBeCloseTo(at, 9);
  });
  it('limits scale and origin', () => {
    expect(zoom_at({ origin: 0, scale: 50 }, 0, 1e-9).scale).toBe(4);
    expect(zoom_at({ origin: 0, scale: 50 }, 0, 1e9).scale).toBe(2400);
    expect(time_to_x(pan_by({ origin: 0, scale: 50 }, -1e6), 0)).toBeCloseTo(24);
  });
  it('fits the whole duration', () => {
    const view = fit_view(12, 1000);
    expect(time_to_x(view, 0)).toBeGreaterThanOrEqual(0);
    expect(time_to_x(view, 12)).toBeLessThanOrEqual(1000);
  });
  it('keeps ruler labels at least 84 px apart at every scale', () => {
    for (let scale = 4; scale < 2400; scale *= 1.3) {
      const { label, tick } = ruler_steps(scale, 60);
      expect(label * scale).toBeGreaterThanOrEqual(84);
      expect(Math.abs(label / tick - Math.round(label / tick))).toBeLessThan(1e-9);
    }
  });
});

describe('snapping', () => {
  it('moves the edge that is closest to a target onto it, within the tolerance', () => {
    expect(snap_delta([1, 3], 0.43, rules({ targets: [3.5, 1.4] }))).toEqual({ delta: expect.closeTo(0.4), at: 1.4 });
    expect(snap_delta([1, 3], 0.48, rules({ targets: [3.5] }))).toEqual({ delta: 0.5, at: 3.5 });
  });
  it('rounds to a frame without a target', () => {
    const { delta, at } = snap_delta([1], 0.123, rules());
    expect(((1 + delta) * 60) % 1).toBeCloseTo(0, 9);
    expect(at).toBeNull();
  });
  it('ignores a target beyond the tolerance', () => {
    expect(snap_delta([1], 0.5, rules({ targets: [1.7] }))).toEqual({ delta: 0.5, at: null });
  });
  it('does not snap when disabled', () => {
    expect(snap_delta([1], 0.1234, rules({ enabled: false, targets: [1.12] })).delta).toBeCloseTo(0.1234, 3);
  });
  it('targets are clip edges, events, the end and the playhead, without the dragged clip', () => {
    const targets = snap_targets(sample_document(), 'k1', 2.5);
    expect(targets).toContain(2.5);
    expect(targets).toContain(3.4);
    expect(targets).toContain(5);
    expect(targets).not.toContain(1);
  });
});

describe('a track that ends in the middle of a movement', () => {
  const human = sample_document().characters[0]!;
  it('is reported with its time and speed', () => {
    expect(ends_moving(human, 1.3, 20)).toEqual({ time: 5, speed: 1.3 });
  });
  it('is not reported if the character stands, is passive, has no clips, or the scenario ends there', () => {
    expect(ends_moving(human, 0.1, 20)).toBeNull();
    expect(ends_moving(human, undefined, 20)).toBeNull();
    expect(ends_moving(human, 1.3, 5)).toBeNull();
    expect(ends_moving({ ...human, track: [] }, 1.3, 20)).toBeNull();
    expect(ends_moving({ ...human, control: { ...human.control, mode: 'passive' } }, 1.3, 20)).toBeNull();
  });
});

describe('the last clip of a track', () => {
  const human = sample_document().characters[0]!;
  const last = human.track.at(-1)!;
  it('is looped to the end of the scenario if its motion is cyclic', () => {
    const cyclic = (motion: string): boolean => motion === last.motion;
    expect(loop_to_end(human, cyclic, 20)).toEqual({ type: 'clip.set', character: human.id, id: last.id, loop: true, length: 20 - last.start });
    expect(loop_to_end(human, () => false, 20)).toBeNull();
    expect(loop_to_end({ ...human, track: [] }, cyclic, 20)).toBeNull();
    expect(loop_to_end({ ...human, locked: true }, cyclic, 20)).toBeNull();
  });
});

describe('dragging a clip', () => {
  it('moves the clip, but not before time 0', () => {
    expect(drag_clip(clip, 'move', 0.5, rules(), 3).fields).toEqual({ start: 1.5 });
    expect(drag_clip(clip, 'move', -9, rules(), 3).fields).toEqual({ start: 0 });
  });
  it('trims the start without shifting the rest of the motion', () => {
    const { fields } = drag_clip({ ...clip, speed: 2 }, 'trim_start', 0.5, rules(), 9);
    expect(fields).toEqual({ start: 1.5, length: 1.5, offset: 1.5 });
  });
  it('does not extend a clip beyond its motion', () => {
    expect(drag_clip(clip, 'trim_start', -0.9, rules(), 3).fields).toEqual({ start: 0.5, length: 2.5, offset: 0 });
    expect(drag_clip(clip, 'trim_end', 9, rules(), 3).fields).toEqual({ length: 2.5 });
    expect(drag_clip({ ...clip, loop: true }, 'trim_end', 9, rules(), 3).fields).toEqual({ length: 11 });
  });
  it('keeps at least one frame', () => {
    expect(drag_clip(clip, 'trim_end', -9, rules(), 3).fields.length).toBeCloseTo(1 / 60, 5);
    expect(drag_clip(clip, 'trim_start', 9, rules(), 3).fields.length).toBeCloseTo(1 / 60, 5);
  });
  it('stretches by changing the speed', () => {
    const { fields } = drag_clip(clip, 'stretch', 2, rules(), 3);
    expect(fields).toEqual({ length: 4, speed: 0.5 });
  });
  it('limits the stretched speed to 0.1 ... 4', () => {
    expect(drag_clip(clip, 'stretch', 100, rules(), 3).fields).toEqual({ length: 20, speed: 0.1 });
    expect(drag_clip(clip, 'stretch', -9, rules(), 3).fields).toEqual({ length: 0.5, speed: 4 });
  });
  it('slips the motion under the clip, limited to the motion', () => {
    expect(drag_clip(clip, 'slip', 0.25, rules(), 3).fields).toEqual({ offset: 0.25 });
    expect(drag_clip(clip, 'slip', 5, rules(), 3).fields).toEqual({ offset: 0 });
    expect(drag_clip(clip, 'slip', -5, rules(), 3).fields).toEqual({ offset: 1 });
  });
  it('wraps the offset of a looping clip that is trimmed at its start', () => {
    const { fields } = drag_clip({ ...clip, loop: true, start: 5 }, 'trim_start', -1, rules(), 3);
    expect(fields).toEqual({ start: 4, length: 3, offset: 2.5 });
  });
  it('changes no field if it ends where it began', () => {
    expect(changed_fields(clip, drag_clip(clip, 'move', 0, rules(), 3).fields)).toBeNull();
  });
  it('moves a clip to another track as one undo step', () => {
    const document = sample_document();
    const before = document.characters[0]!.track[0]!;
    const command = move_clip(before, 'human', 'dog', 7.5);
    expect(command).toMatchObject({ type: 'group', commands: [{ type: 'clip.remove' }, { type: 'clip.add' }] });
    const after = apply_command(document, command);
    expect(after.characters[0]!.track.map((k) => k.id)).toEqual(['k2']);
    expect(after.characters[1]!.track).toEqual([{ ...before, start: 7.5 }]);
    expect(document.characters[0]!.track).toHaveLength(2);
  });
});
