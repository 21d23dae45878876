import { describe, expect, it, vi } from 'vitest';
import { curves_of, layer_change, move_keys, picks_at, sample, set_slope, set_tangent } from '../src/core/posing/curves';
import { edit_keys, key_command, key_slopes, key_times, layer_times, moment_of, motion_time, scenario_times, value_at, weight_at, type Key, type KeyedLayer } from '../src/core/posing/keys';
import { clip_at, cross_fade_at, Poser } from '../src/core/posing/poser';
import { apply_command, type Clip } from '../src/core/document';
import { CommandRegistry } from '../src/core/commands';
import type { Session } from '../src/core/session';
import { initial_state } from '../src/core/state';
import { createStore } from 'zustand/vanilla';
import { sample_document } from './sample';

const key = (time: number, value: number, more: Partial<Key> = {}): Key => ({ time, value: [value], ...more });
const layer = (joints: KeyedLayer['joints'], more: Partial<KeyedLayer> = {}): KeyedLayer => ({ id: 'l1', name: 'Fix', mode: 'additive', weight: 1, ease_in: 0.4, ease_out: null, joints, ...more });
const clip: Clip = { id: 'k1', motion: 'n', start: 2, length: 4, offset: 0.5, speed: 2, blend: 0, loop: false };

describe('curves between keys', () => {
  it('have the monotone slopes of Fritsch and Butland, which the service uses too', () => {
    const keys = [key(0, 0), key(1, 1), key(3, 2), key(4, 1)];
    expect(key_slopes(keys, 1, 0)).toEqual([expect.closeTo(9 / 13, 12), expect.closeTo(9 / 13, 12)]);
    expect(key_slopes(keys, 2, 0)).toEqual([0, 0]);
    expect(key_slopes(keys, 0, 0)).toEqual([0, 0]);
    for (let t = 0; t <= 1; t += 0.05) expect(value_at(keys, 0, t)).toBeLessThanOrEqual(1 + 1e-12);
  });
  it('reproduce a cubic polynomial exactly, and constants outside of the keys', () => {
    const p = (t: number): number => 1 + 2 * t - t * t + t ** 3;
    const keys = [-1, 0.5, 2].map((t) => key(t, p(t), { tangent: 'free', in: [2 - 2 * t + 3 * t * t], out: [2 - 2 * t + 3 * t * t] }));
    for (let t = -1; t <= 2; t += 0.1) expect(value_at(keys, 0, t)).toBeCloseTo(p(t), 10);
    expect(value_at(keys, 0, -5)).toBe(p(-1));
    expect(value_at(keys, 0, 5)).toBe(p(2));
    expect(value_at([key(0, 1, { tangent: 'step' }), key(1, 2)], 0, 0.99)).toBe(1);
    expect(value_at([key(0, 1, { tangent: 'linear' }), key(2, 5, { tangent: 'linear' })], 0, 0.5)).toBeCloseTo(2, 12);
  });
  it('fade in before the first key of any joint', () => {
    const l = layer([{ link: 'a', keys: [key(1, 1)] }, { link: 'b', keys: [key(2, 1)] }], { weight: 0.5 });
    expect(key_times(l)).toEqual([1, 2]);
    expect(weight_at(l, 1.5)).toBe(0.5);
    expect(weight_at(l, 0.8)).toBeCloseTo(0.25, 12);
    expect(weight_at(l, 0.5)).toBe(0);
    expect(weight_at(l, 99)).toBe(0.5);
    expect(weight_at({ ...l, on: false }, 1.5)).toBe(0);
    // in a motion that repeats after 3 s, the fade continues in the next round
    expect(moment_of({ ...l, ease_out: 1.5 }, 2, 3).weight).toBe(0.5);
    expect(weight_at({ ...l, ease_out: 1.5 }, 0, 3)).toBeCloseTo(weight_at({ ...l, ease_out: 1.5 }, 3, 3), 12);
    expect(moment_of({ ...l, ease_in: null }, 0, 3)).toEqual({ weight: 0.5, from: 2, to: 1, mix: 0.5 });
  });
});

describe('time of the motion', () => {
  it('follows offset, speed and rounds of the clip', () => {
    expect(motion_time(clip, 3, 10)).toBe(2.5);
    expect(scenario_times(clip, 2.5, 10)).toEqual([3]);
    expect(scenario_times(clip, 9.9, 10)).toEqual([]);
    const looped = { ...clip, loop: true, offset: 0 };
    expect(motion_time(looped, 3.25, 1)).toBeCloseTo(0.5, 12);
    expect(scenario_times(looped, 0.5, 1).length).toBe(8);
    for (const t of scenario_times(looped, 0.5, 1)) expect(motion_time(looped, t, 1)).toBeCloseTo(0.5, 9);
  });
});

describe('marks of keys on a clip', () => {
  it('are at the times at which the clip plays keys of layers that are on', () => {
    const first = layer([{ link: 'a', keys: [key(1, 1), key(2.5, 1), key(0.2, 1)] }]);
    const second = layer([{ link: 'b', keys: [key(2.5, 1), key(3, 1)] }], { id: 'l2' });
    expect(layer_times({ ...clip, layers: [first, second] }, 10)).toEqual([2.25, 3, 3.25]);
    expect(layer_times({ ...clip, layers: [first, { ...second, on: false }] }, 10)).toEqual([2.25, 3]);
    expect(layer_times({ ...clip, loop: true, offset: 0, layers: [layer([{ link: 'a', keys: [key(0.5, 1)] }])] }, 2)).toEqual([2.25, 3.25, 4.25, 5.25]);
    expect(layer_times(clip, 10)).toEqual([]);
  });
});

describe('cross-fades', () => {
  it('mix the posed clip with the other clip of the overlap', () => {
    const doc = sample_document(); // k1 from 1 to 3.2 s; k2 from 3 s on, with a cross-fade of 0.3 s
    const mixed = (clip_id: string, time: number): string | undefined => cross_fade_at(doc, { character: 'human', clip: clip_id, time })?.id;
    expect(mixed('k2', 3.1)).toBe('k1');
    expect(mixed('k1', 3.1)).toBe('k2');
    expect(mixed('k2', 3.4)).toBeUndefined();
    expect(mixed('k1', 2.9)).toBeUndefined();
    expect(mixed('k1', 1.1)).toBeUndefined();
  });
});

describe('edits of keys', () => {
  const two = layer([{ link: 'arm', keys: [key(1, 0.1), key(2, 0.3)] }, { link: 'leg', keys: [key(1, 0.5)] }]);
  const pick = (link: string, time: number, component: number | null = 0) => ({ link, part: 'joint' as const, time, component });

  it('move keys in time and value, within the motion', () => {
    const { take, put, picks } = move_keys(two, [pick('arm', 1)], 0.25, 0.2, 3);
    expect(take).toEqual([{ link: 'arm', part: 'joint', time: 1 }]);
    expect(put).toEqual([{ link: 'arm', part: 'joint', time: 1.25, value: [0.3] }]);
    expect(picks[0]!.time).toBe(1.25);
    expect(edit_keys(two, take, put).joints[0]!.keys.map((k) => k.time)).toEqual([1.25, 2]);
    expect(move_keys(two, [pick('arm', 2)], 9, 0, 3).put[0]!.time).toBe(3);
    expect(move_keys(two, picks_at(two, 1), -5, 0, 3).put.map((k) => k.time)).toEqual([0, 0]);
    expect(move_keys({ ...two, weight: 0.5 }, [pick('arm', 1)], 0, 0.1, 3).put[0]!.value).toEqual([0.3]);
    expect(move_keys(two, [pick('arm', 1, null)], 0, 0.1, 3).put[0]!.value).toEqual([0.1]);
  });
  it('turn tangents: both sides, or with Alt one of them', () => {
    const whole = set_slope(two, pick('arm', 1), 1, 2, false)[0]!;
    expect([whole.tangent, whole.in, whole.out]).toEqual(['free', [2], [2]]);
    const broken = set_slope(two, pick('arm', 1), 1, 2, true)[0]!;
    expect([broken.in, broken.out]).toEqual([[0], [2]]);
    expect(set_tangent(two, picks_at(two, 1), 'flat')).toHaveLength(2);
    const smooth = edit_keys(edit_keys(two, [], [whole]), [], set_tangent(two, [pick('arm', 1)], 'smooth'));
    expect(smooth.joints[0]!.keys[0]).toEqual({ time: 1, value: [0.1], tangent: 'smooth' });
  });
  it('remove the curve of a joint with its last key', () => {
    expect(edit_keys(two, [{ link: 'leg', time: 1 }], []).joints.map((j) => j.link)).toEqual(['arm']);
  });
  it('preview the change of an additive layer exactly', () => {
    const reply = { duration: 3, from: 0, step: 0.5, curves: [{ link: 'arm', part: 'joint' as const, base: [[0, 1, 2, 3, 4, 5, 6]], result: [[0, 1, 2.1, 3, 4.3, 5, 6]] }] };
    const curve = curves_of(reply, two, () => false)[0]!;
    expect(curve.keys).toHaveLength(2);
    expect(sample(curve.result, reply.from, reply.step, 0.25)).toBe(0.5);
    const after = edit_keys(two, [], [{ link: 'arm', time: 1, value: [0.4] }]);
    expect(layer_change(two, after, curve, 1)).toBeCloseTo(0.3, 12);
    expect(layer_change(two, after, curve, 2)).toBeCloseTo(0, 12);
  });
  it('add the layer first if the clip does not have it, and are previewed in the document', () => {
    const doc = sample_document();
    const character = doc.characters.find((c) => c.track.length > 0)!;
    const target = character.track[0]!;
    const command = key_command(doc, character.id, target.id, layer([]), { put: [{ link: 'arm', time: 1, value: [0.2] }] }, 'Pose');
    expect(command.type).toBe('group');
    const changed = apply_command(doc, command);
    const found = changed.characters.find((c) => c.id === character.id)!.track[0]!.layers!;
    expect(found[0]!.joints).toEqual([{ link: 'arm', keys: [{ time: 1, value: [0.2] }] }]);
    expect(key_command(changed, character.id, target.id, found[0]!, { take: [{ link: 'arm', time: 1 }] }, 'Remove').type).toBe('key.edit');
  });
});

describe('the poser', () => {
  const reply = (moved: boolean) => ({
    motion_time: 1, links: [], angles: [], planted: [4], changed: moved ? [{ link: 1, q: [0.5] }] : [],
    keys: [{ link: 'arm', part: 'joint', value: [0.5], moved }, { link: 'leg', part: 'joint', value: [0], moved: false }],
  });
  function setup() {
    const doc = sample_document();
    const character = doc.characters.find((c) => c.track.length > 0)!;
    const store = createStore(() => ({ ...initial_state, document: doc, connection: 'open' as const, selection: { kind: 'character' as const, character: character.id }, transport: { ...initial_state.transport, time: character.track[0]!.start + 0.5 } }));
    const ask = vi.fn((request: { op: string; edit?: unknown }) => Promise.resolve(request.op === 'joints' ? { joints: [] } : reply(request.edit !== undefined)));
    const edit = vi.fn((_command: unknown) => Promise.resolve(true));
    const session = { store, get state() { return store.getState(); }, ask, edit, notify: vi.fn(), fail: vi.fn(), pause: vi.fn(), set_mode: vi.fn(), select: vi.fn(), fresh_id: (p: string) => `${p}9`, frames: { received: 0, on_frame: () => () => undefined } } as unknown as Session;
    return { poser: new Poser(session), ask, edit, store, character, doc };
  }

  it('keys only the joints that changed, in a new layer, when a drag ends', async () => {
    const { poser, edit, character } = setup();
    poser.switch_on(true);
    await vi.waitFor(() => expect(poser.state.reply).not.toBeNull());
    expect(poser.pins(character.id)).toEqual([4]);
    expect(poser.begin()).toBe(true);
    poser.drag({ type: 'mirror' });
    await poser.finish('Move hand');
    expect(edit).toHaveBeenCalledTimes(1);
    const command = edit.mock.calls[0]![0] as { type: string; label: string; commands: { type: string; put?: { link: string }[] }[] };
    expect([command.type, command.label]).toEqual(['group', 'Move hand']);
    expect(command.commands.map((c) => c.type)).toEqual(['layer.add', 'key.edit']);
    expect(command.commands[1]!.put!.map((k) => k.link)).toEqual(['arm']);
  });
  it('keeps changes that are not keyed until they are keyed or discarded', async () => {
    const { poser, edit } = setup();
    poser.switch_on(true);
    poser.set_auto_key(false);
    await vi.waitFor(() => expect(poser.state.reply).not.toBeNull());
    await poser.apply({ type: 'mirror' }, 'Mirror pose');
    expect([edit.mock.calls.length, poser.state.pending]).toEqual([0, true]);
    expect(poser.restore()).toBe(true);
    expect(poser.state.pending).toBe(false);
    await vi.waitFor(() => expect(poser.state.reply!.changed).toEqual([]));
    await poser.apply({ type: 'mirror' }, 'Mirror pose');
    await poser.key_changes();
    expect(edit).toHaveBeenCalledTimes(1);
  });
  it('adds keys of value 0 beside the first key of a joint in a layer that has keys at other times', async () => {
    const { poser, edit, store, doc, character } = setup();
    const keyed = layer([{ link: 'leg', keys: [key(0.2, 1), key(1.8, 1)] }]);
    store.setState({ document: { ...doc, characters: doc.characters.map((c) => (c.id === character.id ? { ...c, track: c.track.map((k, i) => (i === 0 ? { ...k, layers: [keyed] } : k)) } : c)) } });
    poser.switch_on(true);
    await vi.waitFor(() => expect(poser.state.reply).not.toBeNull());
    await poser.apply({ type: 'mirror' }, 'Mirror pose');
    expect((edit.mock.calls[0]![0] as { put: { time: number; value: number[] }[] }).put.map((k) => [k.time, k.value[0]])).toEqual([[0.2, 0], [1.8, 0], [1, 0.5]]);
  });
  it('restores the pose when a drag is cancelled', async () => {
    const { poser, edit } = setup();
    poser.switch_on(true);
    await vi.waitFor(() => expect(poser.state.reply).not.toBeNull());
    poser.begin();
    poser.drag({ type: 'mirror' });
    await vi.waitFor(() => expect(poser.state.pending).toBe(true));
    poser.cancel();
    expect([poser.state.pending, poser.state.shown]).toEqual([false, null]);
    await poser.finish('Pose');
    expect(edit).not.toHaveBeenCalled();
  });
  it('finds the clip at the playhead, the later one in an overlap', () => {
    const { doc, character } = setup();
    const later = { ...character.track[0]!, id: 'later', start: character.track[0]!.start + 0.5 };
    const both = { ...doc, characters: [{ ...character, track: [character.track[0]!, later] }] };
    expect(clip_at(both, character.id, later.start + 0.1)!.id).toBe('later');
    expect(clip_at(both, character.id, later.start - 0.1)!.id).toBe(character.track[0]!.id);
    expect(clip_at(both, character.id, 1e6)).toBeNull();
  });
});

describe('keys of commands', () => {
  it('run the first enabled command, so that tools can use keys of other commands', () => {
    const registry = new CommandRegistry();
    let on = false;
    registry.add({ id: 'tool', label: '', group: '', keys: ['S'], enabled: () => on, run: () => undefined }, { id: 'split', label: '', group: '', keys: ['S'], run: () => undefined });
    expect(registry.by_key('S', 'industry')!.id).toBe('split');
    on = true;
    expect(registry.by_key('S', 'industry')!.id).toBe('tool');
  });
});
