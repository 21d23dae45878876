/** Groups of tracks in the timeline: characters with the same name of a group are shown together, below a row that can be folded. */
import { in_track_order, type Character, type ScenarioDocument } from './document';

export type TrackRow = { kind: 'track'; character: Character; grouped: boolean } | { kind: 'group'; name: string; members: Character[]; folded: boolean };

/** Rows of the timeline, from top to bottom. A group is at the place of its first member. @param folded names of folded groups */
export function track_rows(document: ScenarioDocument, folded: ReadonlySet<string>): TrackRow[] {
  const characters = in_track_order(document);
  const rows: TrackRow[] = [];
  const shown = new Set<string>();
  for (const character of characters) {
    const { group } = character;
    if (!group) rows.push({ kind: 'track', character, grouped: false });
    if (!group || shown.has(group)) continue;
    shown.add(group);
    const members = characters.filter((c) => c.group === group);
    rows.push({ kind: 'group', name: group, members, folded: folded.has(group) });
    if (!folded.has(group)) rows.push(...members.map((c): TrackRow => ({ kind: 'track', character: c, grouped: true })));
  }
  return rows;
}

/** Index in the order of tracks at which `moved` is before or after `target`. */
export function index_beside(document: ScenarioDocument, moved: string, target: string, after: boolean): number {
  const ids = in_track_order(document).map((c) => c.id).filter((id) => id !== moved);
  return Math.max(0, ids.indexOf(target)) + (after ? 1 : 0);
}
