/** Nested scenarios: an instance places an inner scenario, whose characters the service names "instance/character". */
import type { Character, InnerScenario, ScenarioDocument, ScenarioInstance } from './document';
import { items_of } from './items';
import type { Selection } from './state';

export const find_instance = (doc: ScenarioDocument, id: string): ScenarioInstance | undefined => doc.instances?.find((i) => i.id === id);

export const find_scenario = (doc: ScenarioDocument, id: string): InnerScenario | undefined => doc.scenarios?.find((s) => s.id === id);

/** The instance to which a character of a frame belongs; null: it is a character of the shown scenario itself. */
export const instance_of = (character: string): string | null => (character.includes('/') ? character.slice(0, character.indexOf('/')) : null);

/** The selection that a click on a character means: the character, or the instance to which it belongs. */
export function selection_of_character(character: string, link: number): Selection {
  const instance = instance_of(character);
  return instance === null ? { kind: 'character', character, link } : { kind: 'instance', instance };
}

/** True if the instance is left out of playing. */
export const is_instance_left_out = (doc: ScenarioDocument, instance: ScenarioInstance): boolean =>
  Boolean(instance.muted) || (!instance.solo && (doc.characters.some((c) => c.solo) || Boolean(doc.instances?.some((i) => i.solo))));

/** Ids of the selected tracks: of characters and of instances, each once. */
export function selected_tracks(selection: Selection): string[] {
  if (selection.kind === 'tracks') return [...selection.tracks];
  if (selection.kind === 'instance') return [selection.instance];
  if (selection.kind === 'character') return [selection.character];
  return [...new Set(items_of(selection).flatMap((item) => (item.kind === 'clip' ? [item.character] : [])))];
}

/** The selection of these tracks. */
export function tracks_selection(doc: ScenarioDocument, tracks: readonly string[]): Selection {
  const [only] = tracks;
  if (only === undefined) return { kind: 'none' };
  if (tracks.length > 1) return { kind: 'tracks', tracks };
  return find_instance(doc, only) ? { kind: 'instance', instance: only } : { kind: 'character', character: only };
}

/** The selection after a Ctrl-click on the header of a track: with the track, or without it. */
export function toggle_track(doc: ScenarioDocument, selection: Selection, track: string): Selection {
  const tracks = selected_tracks(selection);
  return tracks_selection(doc, tracks.includes(track) ? tracks.filter((t) => t !== track) : [...tracks, track]);
}

const group_names = ['Group', 'Group', 'Duet', 'Trio', 'Quartet'];

/** Name for a new inner scenario of these tracks that no other one has: the name of a single character, "Duet", "Trio", "Quartet", "Group". */
export function nest_name(doc: ScenarioDocument, tracks: readonly string[]): string {
  const single = tracks.length === 1 ? (doc.characters.find((c) => c.id === tracks[0])?.name ?? find_instance(doc, tracks[0]!)?.name) : undefined;
  const stem = single ?? group_names[tracks.length] ?? 'Group';
  const used = new Set((doc.scenarios ?? []).map((s) => s.name));
  if (!used.has(stem)) return stem;
  let n = 2;
  while (used.has(`${stem} ${n}`)) n++;
  return `${stem} ${n}`;
}

/** How many instances of a scenario the whole document has, in all scenarios that the page knows. */
export function count_instances(doc: ScenarioDocument, scenario: string, open: readonly string[]): number {
  const count = (list: readonly ScenarioInstance[] | undefined): number => (list ?? []).filter((i) => i.scenario === scenario).length;
  const inner = (doc.scenarios ?? []).reduce((sum, s) => sum + count(s.instances), 0);
  return inner + (open.length === 0 ? count(doc.instances) : 0);
}

const inside = (instance: ScenarioInstance) => (c: Character): Character => ({ ...c, id: `${instance.id}/${c.id}`, name: `${instance.name} / ${c.name}` });

/** The characters of an inner scenario, with those of the scenarios inside, whose ids and names are paths from it. */
export function characters_of(doc: ScenarioDocument, scenario: string, depth = 0): Character[] {
  const inner = find_scenario(doc, scenario);
  if (!inner || depth > 16) return [];
  return [...inner.characters, ...(inner.instances ?? []).flatMap((i) => characters_of(doc, i.scenario, depth + 1).map(inside(i)))];
}

/** Every character that events and rules of the document can name: its own, and those of instances, whose ids and names are paths. */
export const nameable_characters = (doc: ScenarioDocument): Character[] => [
  ...doc.characters,
  ...(doc.instances ?? []).flatMap((i) => characters_of(doc, i.scenario).map(inside(i))),
];

/** The document with all nameable characters in the list of its characters, to read from only. */
export const with_nameable = (doc: ScenarioDocument): ScenarioDocument => (doc.instances?.length ? { ...doc, characters: nameable_characters(doc) } : doc);

/** Id and name of every character that events can name. */
export const character_choices = (doc: ScenarioDocument): [string, string][] => nameable_characters(doc).map((c) => [c.id, c.name]);
