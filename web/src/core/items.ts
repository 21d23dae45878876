/** Selections of several clips and events of the scenario, and the commands that change them together, each as one undo step. */
import { apply_command, content_end, find_character, find_clip, find_event, fit_blends, type Clip, type Command, type ScenarioDocument, type ScenarioEvent } from './document';
import type { Selection } from './state';

export type Item = { kind: 'clip'; character: string; clip: string } | { kind: 'event'; event: string };

export const same_item = (a: Item, b: Item): boolean =>
  a.kind === 'clip' ? b.kind === 'clip' && a.clip === b.clip && a.character === b.character : b.kind === 'event' && a.event === b.event;

/** The clips and events of a selection; empty for other selections. */
export function items_of(selection: Selection): readonly Item[] {
  if (selection.kind === 'items') return selection.items;
  return selection.kind === 'clip' || selection.kind === 'event' ? [selection] : [];
}

export function selection_of(items: readonly Item[]): Selection {
  if (items.length === 0) return { kind: 'none' };
  return items.length === 1 ? items[0]! : { kind: 'items', items };
}

export const is_selected = (selection: Selection, item: Item): boolean => items_of(selection).some((other) => same_item(other, item));

/** The selection with `item` added, or removed if it is selected. */
export function toggle_item(selection: Selection, item: Item): Selection {
  const items = items_of(selection);
  return selection_of(is_selected(selection, item) ? items.filter((other) => !same_item(other, item)) : [...items, item]);
}

/** The selection with all `items` added, each once. */
export function add_items(selection: Selection, items: readonly Item[]): Selection {
  return selection_of([...items_of(selection), ...items.filter((item) => !is_selected(selection, item))]);
}

/** The items of a selection that `document` still has. */
export const valid_items = (selection: Selection, document: ScenarioDocument): Selection =>
  selection_of(items_of(selection).filter((item) => (item.kind === 'clip' ? find_clip(document, item.character, item.clip) : find_event(document, item.event))));

/** All clips and events of the scenario, without those of locked tracks. */
export function all_items(document: ScenarioDocument): Item[] {
  const clips = document.characters.filter((c) => !c.locked).flatMap((c) => c.track.map((k): Item => ({ kind: 'clip', character: c.id, clip: k.id })));
  return [...clips, ...document.events.map((e): Item => ({ kind: 'event', event: e.id }))];
}

interface Found {
  clips: { character: string; clip: Clip }[];
  events: ScenarioEvent[];
}

/** Clips of locked tracks are left out: the service refuses to change them. */
function find_items(document: ScenarioDocument, items: readonly Item[]): Found {
  const found: Found = { clips: [], events: [] };
  for (const item of items) {
    if (item.kind === 'event') {
      const event = find_event(document, item.event);
      if (event) found.events.push(event);
    } else if (!find_character(document, item.character)?.locked) {
      const clip = find_clip(document, item.character, item.clip);
      if (clip) found.clips.push({ character: item.character, clip });
    }
  }
  return found;
}

/** Begin and end of the items on the time axis, s; null if there are none. */
export function items_span(document: ScenarioDocument, items: readonly Item[]): { from: number; to: number } | null {
  const { clips, events } = find_items(document, items);
  if (clips.length + events.length === 0) return null;
  return {
    from: Math.min(...clips.map((c) => c.clip.start), ...events.map((e) => e.time)),
    to: Math.max(...clips.map((c) => c.clip.start + c.clip.length), ...events.map((e) => e.time + (e.duration ?? 0))),
  };
}

const clean = (time: number): number => Math.round(time * 1e6) / 1e6;
const count = (found: Found): string => {
  const number = (n: number, noun: string): string => (n === 0 ? '' : n === 1 ? `1 ${noun}` : `${n} ${noun}s`);
  return [number(found.clips.length, 'clip'), number(found.events.length, 'event')].filter(Boolean).join(', ');
};

/** Text for a selection of several items: "2 clips, 1 event". */
export const describe_items = (document: ScenarioDocument, items: readonly Item[]): string => count(find_items(document, items));

/** A group with the commands that adapt the cross-fades to the overlaps that `commands` change. */
function with_blends(document: ScenarioDocument, commands: Command[], label: string): Command {
  const group: Command = { type: 'group', label, commands };
  const after = apply_command(document, group);
  const blends = document.characters.flatMap((c) => {
    const track = find_character(after, c.id)?.track;
    return track ? fit_blends(c.id, c.track, track) : [];
  });
  return { type: 'group', label, commands: [...commands, ...blends] };
}

/** Moves the items by `delta` s, but not before time 0. @return null if nothing would move */
export function move_items(document: ScenarioDocument, items: readonly Item[], delta: number): Command | null {
  const found = find_items(document, items);
  const span = items_span(document, items);
  const by = span ? Math.max(delta, -span.from) : 0;
  if (!span || Math.abs(by) < 1e-9) return null;
  return with_blends(
    document,
    [
      ...found.clips.map(({ character, clip }): Command => ({ type: 'clip.set', character, id: clip.id, start: clean(clip.start + by) })),
      ...found.events.map((event): Command => ({ type: 'event.set', id: event.id, event: { time: clean(event.time + by) } })),
    ],
    `Move ${count(found)}`,
  );
}

export function remove_items(document: ScenarioDocument, items: readonly Item[]): Command | null {
  const found = find_items(document, items);
  if (found.clips.length + found.events.length === 0) return null;
  const commands = [
    ...found.clips.map(({ character, clip }): Command => ({ type: 'clip.remove', character, id: clip.id })),
    ...found.events.map((event): Command => ({ type: 'event.remove', id: event.id })),
  ];
  return { type: 'group', label: `Remove ${count(found)}`, commands };
}

/**
 * Adds copies of the items directly after the items. Copies that end after the scenario make it longer.
 * @param fresh_id makes a new id that begins with the prefix
 */
export function duplicate_items(document: ScenarioDocument, items: readonly Item[], fresh_id: (prefix: string) => string): { command: Command; copies: Item[] } | null {
  const found = find_items(document, items);
  const span = items_span(document, items);
  if (!span) return null;
  const shift = span.to - span.from;
  const copies: Item[] = [];
  const commands: Command[] = [];
  for (const { character, clip } of found.clips) {
    const id = fresh_id('k');
    copies.push({ kind: 'clip', character, clip: id });
    commands.push({ ...clip, type: 'clip.add', character, id, start: clean(clip.start + shift) });
  }
  for (const event of found.events) {
    const id = fresh_id('e');
    copies.push({ kind: 'event', event: id });
    commands.push({ type: 'event.add', event: { ...event, id, time: clean(event.time + shift) } });
  }
  const command = with_blends(document, commands, `Duplicate ${count(found)}`);
  const end = clean(Math.max(content_end(document), span.to + shift));
  if (end > document.duration + 1e-9 && command.type === 'group') command.commands.unshift({ type: 'scenario.set', duration: end });
  return { command, copies };
}
