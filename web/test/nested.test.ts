import { describe, expect, it } from 'vitest';
import { apply_command, content_end, is_left_out, type ScenarioDocument } from '../src/core/document';
import { character_choices, characters_of, count_instances, instance_of, nameable_characters, nest_name, selected_tracks, selection_of_character, toggle_track, tracks_selection } from '../src/core/nested';
import { valid_selection } from '../src/core/state';
import { snap_targets } from '../src/core/timeline';
import { sample_document } from './sample';

const origin = { x: 0, y: 0, z: 0, heading: 0 };

/** The sample document with the scenario "Duet" of its first character, placed twice, and "Group", which places it again. */
function nested(): ScenarioDocument {
  const doc = sample_document();
  const duet = { id: 'duet', name: 'Duet', duration: 4, characters: [{ ...doc.characters[0]!, name: 'Ann', color: '#112233' }] };
  const group = { id: 'group', name: 'Group', duration: 9, characters: [], instances: [{ id: 'd', name: 'Inner', scenario: 'duet', start: 1, place: origin }] };
  const instances = [1, 2].map((n) => ({ id: `duet.${n}`, name: `Duet ${n}`, scenario: 'duet', start: n * 30, place: origin }));
  return { ...doc, scenarios: [duet, group], instances };
}

describe('nested scenarios', () => {
  it('moves and places an instance, before the service has answered', () => {
    const moved = apply_command(nested(), { type: 'instance.set', id: 'duet.2', start: 3, place: { y: 2 } });
    expect(moved.instances?.[1]).toMatchObject({ start: 3, place: { ...origin, y: 2 } });
    expect(moved.instances?.[0]).toEqual(nested().instances?.[0]);
    expect(apply_command(nested(), { type: 'instance.remove', id: 'duet.1' }).instances).toHaveLength(1);
  });
  it('takes a click on a character of an instance as a click on the instance', () => {
    expect(instance_of('duet.1/inner/human')).toBe('duet.1');
    expect(selection_of_character('duet.1/human', 3)).toEqual({ kind: 'instance', instance: 'duet.1' });
    expect(selection_of_character('human', 3)).toEqual({ kind: 'character', character: 'human', link: 3 });
  });
  it('selects several tracks by Ctrl-clicks', () => {
    const doc = nested();
    const first = doc.characters[0]!.id;
    const two = toggle_track(doc, { kind: 'character', character: first }, 'duet.1');
    expect(two).toEqual({ kind: 'tracks', tracks: [first, 'duet.1'] });
    expect(toggle_track(doc, two, first)).toEqual({ kind: 'instance', instance: 'duet.1' });
    expect(toggle_track(doc, { kind: 'instance', instance: 'duet.1' }, 'duet.1')).toEqual({ kind: 'none' });
    expect(selected_tracks({ kind: 'items', items: [{ kind: 'clip', character: 'a', clip: '1' }, { kind: 'clip', character: 'a', clip: '2' }, { kind: 'event', event: 'e' }] })).toEqual(['a']);
    expect(tracks_selection(doc, [])).toEqual({ kind: 'none' });
  });
  it('drops tracks from the selection that the document has no longer', () => {
    const doc = nested();
    const first = doc.characters[0]!.id;
    expect(valid_selection({ kind: 'tracks', tracks: [first, 'gone'] }, doc)).toEqual({ kind: 'character', character: first });
    expect(valid_selection({ kind: 'instance', instance: 'gone' }, doc)).toEqual({ kind: 'none' });
  });
  it('names a new scenario by its tracks', () => {
    const doc = nested();
    const name = doc.characters[0]!.name;
    expect(nest_name(doc, [doc.characters[0]!.id])).toBe(name);
    expect(nest_name(doc, ['a', 'b', 'c'])).toBe('Trio');
    expect(nest_name(doc, ['a', 'b'])).toBe('Duet 2');
    expect(nest_name(doc, ['a', 'b', 'c', 'd', 'e'])).toBe('Group 2');
  });
  it('lists the characters and counts the instances of a scenario', () => {
    const doc = nested();
    const first = doc.characters[0]!;
    expect(characters_of(doc, 'group')).toEqual([{ ...first, id: `d/${first.id}`, name: 'Inner / Ann', color: '#112233' }]);
    expect(count_instances(doc, 'duet', [])).toBe(3);
    expect(count_instances(doc, 'group', [])).toBe(0);
  });
  it('offers the characters of instances to events and rules, by their paths', () => {
    const doc = nested();
    const { id } = doc.characters[0]!;
    expect(nameable_characters(doc).slice(-2).map((c) => [c.id, c.name, c.track])).toEqual([
      [`duet.1/${id}`, 'Duet 1 / Ann', doc.characters[0]!.track],
      [`duet.2/${id}`, 'Duet 2 / Ann', doc.characters[0]!.track],
    ]);
    doc.instances![1]!.scenario = 'group';
    expect(character_choices(doc).at(-1)).toEqual([`duet.2/d/${id}`, 'Duet 2 / Inner / Ann']);
    doc.scenarios![1]!.instances![0]!.scenario = 'group'; // a damaged document
    expect(character_choices(doc).length).toBe(doc.characters.length + 1);
  });
  it('snaps to instances, ends with the last one, and leaves characters out if an instance is solo', () => {
    const doc = nested();
    expect(snap_targets(doc, 'duet.1', 0)).toContain(60);
    expect(snap_targets(doc, 'duet.1', 0)).not.toContain(30);
    expect(content_end(doc)).toBe(64);
    doc.instances![0]!.solo = true;
    expect(is_left_out(doc, doc.characters[0]!)).toBe(true);
  });
});
