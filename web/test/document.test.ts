import { describe, expect, it } from 'vitest';
import { apply_command, blend_spans, content_end, find_character, find_clip, fit_blends, free_name, free_place, track_end, with_room } from '../src/core/document';
import { valid_selection } from '../src/core/state';
import { sample_document } from './sample';

describe('apply_command', () => {
  it('does not modify its argument', () => {
    const doc = sample_document();
    const before = structuredClone(doc);
    apply_command(doc, { type: 'clip.set', character: 'human', id: 'k1', start: 9 });
    apply_command(doc, { type: 'character.set', id: 'human', place: { x: 3 } });
    apply_command(doc, { type: 'event.set', id: 'e1', event: { time: 1 } });
    apply_command(doc, { type: 'clip.remove', character: 'human', id: 'k1' });
    expect(doc).toEqual(before);
  });
  it('merges place and control and keeps the other fields', () => {
    const doc = apply_command(sample_document(), { type: 'character.set', id: 'dog', place: { heading: 90 }, control: { tracking: 0.4 } });
    const dog = find_character(doc, 'dog')!;
    expect(dog.place).toEqual({ x: 0, y: 1, z: 0, heading: 90 });
    expect(dog.control).toMatchObject({ tracking: 0.4, balance: 1 });
    expect(dog).not.toHaveProperty('type');
  });
  it('sets fields of a clip without copying the command’s address fields', () => {
    const doc = apply_command(sample_document(), { type: 'clip.set', character: 'human', id: 'k2', speed: 2 });
    expect(find_clip(doc, 'human', 'k2')).toEqual({ id: 'k2', motion: 'n-1', start: 3, length: 2, offset: 0, speed: 2, blend: 0.3, loop: false });
  });
  it('applies the commands of a group in order', () => {
    const doc = apply_command(sample_document(), {
      type: 'group',
      label: 'both',
      commands: [
        { type: 'event.remove', id: 'e1' },
        { type: 'scenario.set', duration: 8 },
        { type: 'character.remove', id: 'dog' },
      ],
    });
    expect([doc.events.length, doc.duration, doc.characters.length]).toEqual([0, 8, 1]);
  });
});

describe('reading a document', () => {
  it('finds overlaps of clips', () => {
    expect(blend_spans(sample_document().characters[0]!.track)).toEqual([{ from: 3, to: expect.closeTo(3.3), into: 'k2' }]);
  });
  it('finds the end of the last clip or event', () => {
    expect(content_end(sample_document())).toBe(5);
    expect(track_end(sample_document().characters[1]!)).toBe(0);
  });
  it('falls back to the character or to no selection if the selected object is gone', () => {
    const doc = sample_document();
    expect(valid_selection({ kind: 'clip', character: 'human', clip: 'gone' }, doc)).toEqual({ kind: 'character', character: 'human' });
    expect(valid_selection({ kind: 'event', event: 'gone' }, doc)).toEqual({ kind: 'none' });
    expect(valid_selection({ kind: 'clip', character: 'human', clip: 'k1' }, doc).kind).toBe('clip');
  });
});

describe('overlaps of clips', () => {
  const doc = sample_document(); // k1 from 1 s to 3.2 s, k2 from 3 s to 5 s
  const { track } = doc.characters[0]!;
  const moved = (start: number) => apply_command(doc, { type: 'clip.set', character: 'human', id: 'k2', start }).characters[0]!.track;
  it('become the cross-fade of the later clip', () => {
    expect(fit_blends('human', track, moved(2))).toEqual([{ type: 'clip.set', character: 'human', id: 'k2', blend: 1.2 }]);
  });
  it('leave a cross-fade alone that does not change', () => {
    expect(fit_blends('human', track, apply_command(doc, { type: 'clip.set', character: 'human', id: 'k1', offset: 0.2 }).characters[0]!.track)).toEqual([]);
  });
  it('give the short cross-fade of new clips when they end', () => {
    const long = apply_command(doc, { type: 'group', label: '', commands: [{ type: 'clip.set', character: 'human', id: 'k2', start: 2 }, ...fit_blends('human', track, moved(2))] }).characters[0]!.track;
    expect(fit_blends('human', long, moved(4).map((k) => (k.id === 'k2' ? { ...k, blend: 1.2 } : k)))).toEqual([{ type: 'clip.set', character: 'human', id: 'k2', blend: 0.3 }]);
  });
  it('also change the cross-fade of a clip that was not dragged', () => {
    const after = apply_command(doc, { type: 'clip.set', character: 'human', id: 'k1', length: 3 }).characters[0]!.track;
    expect(fit_blends('human', track, after)).toEqual([{ type: 'clip.set', character: 'human', id: 'k2', blend: 1 }]);
  });
});

describe('room for a clip', () => {
  const add = { type: 'clip.add', character: 'human', motion: 'n-1', start: 19 } as const;
  it('lengthens the scenario in the same undo step', () => {
    expect(with_room(sample_document(), add, 22.5, 'Add clip')).toEqual({ type: 'group', label: 'Add clip', commands: [{ type: 'scenario.set', duration: 22.5 }, add] });
  });
  it('changes nothing if the clip fits', () => {
    expect(with_room(sample_document(), add, 20, 'Add clip')).toBe(add);
  });
});

describe('places and names of new characters', () => {
  it('puts twenty copies beside each other', () => {
    let doc = sample_document();
    const first = doc.characters[0]!;
    for (let n = 0; n < 20; n++) {
      const place = { ...first.place, ...free_place(doc, { x: first.place.x, y: first.place.y + 1 }) };
      doc = { ...doc, characters: [...doc.characters, { ...first, id: `copy ${n}`, name: free_name(doc, first.name), place }] };
    }
    const places = doc.characters.map((c) => c.place);
    for (const [i, a] of places.entries()) for (const b of places.slice(0, i)) expect(Math.hypot(a.x - b.x, a.y - b.y)).toBeGreaterThan(0.89);
    expect(new Set(doc.characters.map((c) => c.name)).size).toBe(doc.characters.length);
    expect(doc.characters.at(-1)!.name).toBe(`${first.name} 21`);
  });
  it('keeps a place that is free', () => {
    expect(free_place(sample_document(), { x: 50, y: 3 })).toEqual({ x: 50, y: 3 });
  });
});
