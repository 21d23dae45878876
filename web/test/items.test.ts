import { describe, expect, it } from 'vitest';
import { apply_command, find_clip, find_event, is_left_out, type Command, type ScenarioDocument } from '../src/core/document';
import { add_items, all_items, describe_items, duplicate_items, items_of, items_span, move_items, remove_items, selection_of, toggle_item, type Item } from '../src/core/items';
import { gallery } from '../src/core/gallery';
import { valid_selection, type Selection } from '../src/core/state';
import { snap_targets } from '../src/core/timeline';
import { sample_document } from './sample';

const pictures = Object.keys(import.meta.glob('../public/gallery/*.webp'));

const k1: Item = { kind: 'clip', character: 'human', clip: 'k1' };
const k2: Item = { kind: 'clip', character: 'human', clip: 'k2' };
const e1: Item = { kind: 'event', event: 'e1' };
const apply = (doc: ScenarioDocument, command: Command | null): ScenarioDocument => apply_command(doc, command!);

describe('selections of several items', () => {
  it('toggle, add and reduce to the kinds of one item and of none', () => {
    let selection: Selection = { kind: 'none' };
    selection = toggle_item(selection, k1);
    expect(selection).toEqual(k1);
    selection = toggle_item(selection, e1);
    expect(selection).toEqual({ kind: 'items', items: [k1, e1] });
    expect(add_items(selection, [e1, k2])).toEqual({ kind: 'items', items: [k1, e1, k2] });
    selection = toggle_item(selection, { ...k1 });
    expect(selection).toEqual(e1);
    expect(toggle_item(selection, e1)).toEqual({ kind: 'none' });
    expect(items_of({ kind: 'character', character: 'human' })).toEqual([]);
  });
  it('keep only the items that the document still has', () => {
    const doc = apply(sample_document(), { type: 'clip.remove', character: 'human', id: 'k1' });
    expect(valid_selection({ kind: 'items', items: [k1, k2, e1] }, doc)).toEqual({ kind: 'items', items: [k2, e1] });
    expect(valid_selection({ kind: 'items', items: [k1, e1] }, doc)).toEqual(e1);
  });
  it('of everything leave out locked tracks', () => {
    const doc = sample_document();
    expect(all_items(doc)).toEqual([k1, k2, e1]);
    doc.characters[0]!.locked = true;
    expect(all_items(doc)).toEqual([e1]);
  });
});

describe('commands for several items', () => {
  it('move them together, as one group, and keep their distances', () => {
    const doc = sample_document();
    const moved = apply(doc, move_items(doc, [k1, k2, e1], 0.5));
    expect(find_clip(moved, 'human', 'k1')!.start).toBe(1.5);
    expect(find_clip(moved, 'human', 'k2')!.start).toBe(3.5);
    expect(find_event(moved, 'e1')!.time).toBe(3.9);
  });
  it('do not move anything before time 0', () => {
    const doc = sample_document();
    const moved = apply(doc, move_items(doc, [k1, e1], -7));
    expect(find_clip(moved, 'human', 'k1')!.start).toBe(0);
    expect(find_event(moved, 'e1')!.time).toBeCloseTo(2.4, 9);
    expect(move_items(moved, [k1, e1], -1)).toBeNull();
  });
  it('fit cross-fades to overlaps that change', () => {
    const doc = sample_document(); // k1 ends at 3.2 s, k2 starts at 3 s
    const moved = apply(doc, move_items(doc, [k2, e1], -0.4));
    expect(find_clip(moved, 'human', 'k2')!.blend).toBeCloseTo(0.6, 9);
  });
  it('remove them and name the count in the label', () => {
    const doc = sample_document();
    const command = remove_items(doc, [k1, k2, e1])!;
    expect(command).toMatchObject({ type: 'group', label: 'Remove 2 clips, 1 event' });
    const after = apply(doc, command);
    expect([after.characters[0]!.track.length, after.events.length]).toEqual([0, 0]);
  });
  it('duplicate them after their last end and make the scenario longer', () => {
    const doc = { ...sample_document(), duration: 6 };
    expect(items_span(doc, [k1, k2, e1])).toEqual({ from: 1, to: 5 });
    let n = 0;
    const { command, copies } = duplicate_items(doc, [k1, k2, e1], (prefix) => `${prefix}x${n++}`)!;
    const after = apply(doc, command);
    expect(after.duration).toBe(9);
    expect(after.characters[0]!.track.map((k) => k.start)).toEqual([1, 3, 5, 7]);
    expect(after.events.map((e) => e.time)).toEqual([3.4, 7.4]);
    expect(after.events[1]!.force).toEqual([150, 0, 0]);
    expect(valid_selection(selection_of(copies), after)).toEqual(selection_of(copies));
  });
  it('leave clips of locked tracks unchanged', () => {
    const doc = sample_document();
    doc.characters[0]!.locked = true;
    expect(remove_items(doc, [k1, k2])).toBeNull();
    expect(describe_items(doc, [k1, e1])).toBe('1 event');
  });
});

describe('markers, range and left-out tracks', () => {
  it('markers are added in the order of time, renamed, moved and removed', () => {
    let doc = apply(sample_document(), { type: 'marker.add', id: 'm1', time: 4 });
    doc = apply(doc, { type: 'marker.add', id: 'm2', time: 2, name: 'jump' });
    expect(doc.markers).toEqual([{ id: 'm2', time: 2, name: 'jump' }, { id: 'm1', time: 4, name: 'Marker 1' }]);
    doc = apply(doc, { type: 'marker.set', id: 'm1', time: 4.5 });
    expect(snap_targets(doc, [], 0)).toContain(4.5);
    expect(snap_targets(doc, 'm1', 0)).not.toContain(4.5);
    doc = apply(doc, { type: 'marker.remove', id: 'm2' });
    expect(doc.markers!.map((m) => m.id)).toEqual(['m1']);
    expect(valid_selection({ kind: 'marker', marker: 'm2' }, doc)).toEqual({ kind: 'none' });
  });
  it('in and out are snap targets, except for their own drag', () => {
    const doc = apply(sample_document(), { type: 'scenario.set', range: { from: 1.25, to: 6.5 } });
    expect(snap_targets(doc, '', 0)).toEqual(expect.arrayContaining([1.25, 6.5]));
    expect(snap_targets(doc, 'range', 0)).not.toContain(6.5);
  });
  it('a muted character and characters beside a solo one are left out', () => {
    const doc = sample_document();
    const left_out = () => doc.characters.filter((c) => is_left_out(doc, c)).map((c) => c.id);
    expect(left_out()).toEqual([]);
    doc.characters[0]!.muted = true;
    expect(left_out()).toEqual(['human']);
    doc.characters[0]!.solo = true;
    expect(left_out()).toEqual(['human', 'dog']);
    doc.characters[0]!.muted = false;
    expect(left_out()).toEqual(['dog']);
  });
});

describe('the gallery', () => {
  it('names every content once, with one sentence each', () => {
    expect(new Set(gallery.map((g) => g.id)).size).toBe(gallery.length);
    for (const entry of gallery) expect(entry.teaches).toMatch(/^[A-Z][^.?]*[.?]$/);
  });
  it('loads contents with characters, and has a picture of each', async () => {
    for (const entry of gallery) {
      if (entry.id !== 'empty') expect(pictures, entry.id).toContain(`../public/gallery/${entry.id}.webp`);
      if (typeof entry.from !== 'function') continue;
      const { scenario } = (await entry.from()) as { scenario: { version: number; characters: object[]; scenarios?: { characters: object[] }[] } };
      expect(scenario.version, entry.id).toBe(scenario.scenarios ? 2 : 1);
      const characters = [scenario, ...(scenario.scenarios ?? [])].flatMap((s) => s.characters);
      expect(characters.length, entry.id).toBeGreaterThan(0);
    }
  });
});
