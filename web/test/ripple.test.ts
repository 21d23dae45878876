import { describe, expect, it } from 'vitest';
import { apply_command, find_clip, find_event, in_track_order, type ScenarioDocument } from '../src/core/document';
import { describe_grip, grip_end } from '../src/core/grips';
import { insert_time, ripple_clip, ripple_remove } from '../src/core/ripple';
import { index_beside, track_rows } from '../src/core/track_groups';
import { sample_document } from './sample';

/** k1 from 1 to 3.2 s, k2 from 3 to 5 s, a push at 3.4 s, a marker at 4 s, in and out at 0.5 and 4.5 s. */
const document = (): ScenarioDocument => ({ ...sample_document(), markers: [{ id: 'm1', time: 4, name: 'Land' }], range: { from: 0.5, to: 4.5 } });

describe('ripple', () => {
  it('of a moved clip moves everything after its start', () => {
    const doc = document();
    const after = apply_command(doc, ripple_clip(doc, 'human', find_clip(doc, 'human', 'k1')!, { start: 1.5 }));
    expect(find_clip(after, 'human', 'k1')!.start).toBe(1.5);
    expect(find_clip(after, 'human', 'k2')!.start).toBe(3.5);
    expect(find_event(after, 'e1')!.time).toBe(3.9);
    expect(after.markers![0]!.time).toBe(4.5);
    expect(after.range).toEqual({ from: 0.5, to: 5 });
    expect(find_clip(after, 'human', 'k2')!.blend).toBe(find_clip(doc, 'human', 'k2')!.blend);
  });
  it('of a trimmed clip moves what is after its end, and keeps the start of a clip trimmed at its start', () => {
    const doc = document();
    const clip = find_clip(doc, 'human', 'k1')!;
    const longer = apply_command(doc, ripple_clip(doc, 'human', clip, { length: 2.7 }));
    expect(find_clip(longer, 'human', 'k2')!.start).toBe(3); // begins before the end of k1
    expect(find_event(longer, 'e1')!.time).toBe(3.9);
    const later = { ...doc, characters: doc.characters.map((c) => ({ ...c, track: c.track.map((k) => (k.id === 'k2' ? { ...k, start: 3.2 } : k)) })) };
    const shorter = apply_command(later, ripple_clip(later, 'human', clip, { start: 1.4, length: 1.8, offset: 0.4 }));
    expect(find_clip(shorter, 'human', 'k1')).toMatchObject({ start: 1, length: 1.8, offset: 0.4 });
    expect(find_clip(shorter, 'human', 'k2')!.start).toBeCloseTo(2.8, 9);
  });
  it('of a removed clip closes the gap; locked tracks stay', () => {
    const doc = document();
    doc.characters[1]!.track = [{ ...doc.characters[0]!.track[1]!, id: 'k9', start: 6 }];
    const gone = apply_command(doc, ripple_remove(doc, 'human', find_clip(doc, 'human', 'k1')!));
    expect(find_clip(gone, 'human', 'k1')).toBeUndefined();
    expect(find_clip(gone, 'dog', 'k9')!.start).toBeCloseTo(3.8, 9);
    doc.characters[1]!.locked = true;
    expect(find_clip(apply_command(doc, ripple_remove(doc, 'human', find_clip(doc, 'human', 'k1')!)), 'dog', 'k9')!.start).toBe(6);
  });
  it('makes the scenario longer, if necessary', () => {
    const doc = { ...document(), duration: 5.2 };
    const after = apply_command(doc, insert_time(doc, 2, 1));
    expect(after.duration).toBeCloseTo(6, 9);
    expect(find_clip(after, 'human', 'k1')!.start).toBe(1);
    expect(find_clip(after, 'human', 'k2')!.start).toBe(4);
  });
});

describe('tracks', () => {
  it('are shown in their own order, with new characters at the end', () => {
    let doc = apply_command(sample_document(), { type: 'track.move', character: 'dog', at: 0 });
    expect(in_track_order(doc).map((c) => c.id)).toEqual(['dog', 'human']);
    expect(doc.characters.map((c) => c.id)).toEqual(['human', 'dog']);
    doc = { ...doc, characters: [...doc.characters, { ...doc.characters[0]!, id: 'new' }] };
    expect(in_track_order(doc).map((c) => c.id)).toEqual(['dog', 'human', 'new']);
    expect(index_beside(doc, 'new', 'dog', true)).toBe(1);
    expect(index_beside(doc, 'dog', 'human', true)).toBe(1);
    expect(index_beside(doc, 'human', 'dog', false)).toBe(0);
  });
  it('of a group are together, and hidden while it is folded', () => {
    const base = sample_document();
    const doc = { ...base, characters: ['a', 'b', 'c'].map((id) => ({ ...base.characters[0]!, id, ...(id === 'b' ? {} : { group: 'Band' }) })) };
    const rows = (folded: string[]): string[] => track_rows(doc, new Set(folded)).map((r) => (r.kind === 'group' ? `[${r.name}]` : r.character.id));
    expect(rows([])).toEqual(['[Band]', 'a', 'c', 'b']);
    expect(rows(['Band'])).toEqual(['[Band]', 'b']);
  });
});

describe('grips', () => {
  it('last until the next event of the same link', () => {
    const doc = document();
    const grab = { id: 'g', type: 'grab', time: 1, character: 'human', link: 'hand', other: 'dog', other_link: 'back', limit: 500 };
    doc.events = [grab, { id: 'r1', type: 'release', time: 2, character: 'human', link: 'other hand' }, { id: 'r2', type: 'release', time: 3, character: 'human', link: 'hand' }];
    expect(grip_end(doc, grab)).toBe(3);
    expect(grip_end({ ...doc, events: [grab] }, grab)).toBe(doc.duration);
    expect(describe_grip(grab, doc, () => 'hand left')).toBe('grab · Human left hand on Dog, up to 500 N');
    expect(describe_grip({ ...grab, other: '' }, doc, () => 'hand')).toContain('on the world');
  });
});
