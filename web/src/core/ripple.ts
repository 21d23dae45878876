/** Ripple edits: a change of one clip moves everything after it by the same time, as one undo step. */
import { apply_command, content_end, find_character, fit_blends, with_room, type Clip, type ClipFields, type Command, type ScenarioDocument } from './document';

const clean = (time: number): number => Math.round(time * 1e6) / 1e6;
const same_time = 1e-6; // s: times that differ less are equal

/**
 * Commands that move all clips, events and markers from `time` (s) on by `delta` s, and in and out. Clips of locked tracks stay.
 * @param except ids of clips that stay
 */
function shift_after(document: ScenarioDocument, time: number, delta: number, except: readonly string[]): Command[] {
  const later = (t: number): boolean => t >= time - same_time;
  const moved = (t: number): number => clean(Math.max(0, t + delta));
  const commands = document.characters
    .filter((c) => !c.locked)
    .flatMap((c) => c.track.filter((k) => later(k.start) && !except.includes(k.id)).map((k): Command => ({ type: 'clip.set', character: c.id, id: k.id, start: moved(k.start) })));
  commands.push(...document.events.filter((e) => later(e.time)).map((e): Command => ({ type: 'event.set', id: e.id, event: { time: moved(e.time) } })));
  commands.push(...(document.markers ?? []).filter((m) => later(m.time)).map((m): Command => ({ type: 'marker.set', id: m.id, time: moved(m.time) })));
  const { range } = document;
  if (range && later(range.to)) {
    const next = { from: later(range.from) ? moved(range.from) : range.from, to: moved(range.to) };
    if (next.to > next.from) commands.push({ type: 'scenario.set', range: next });
  }
  return commands;
}

/** One command with the cross-fades that fit the overlaps after `commands`, and a longer scenario if it has become too short. */
function whole(document: ScenarioDocument, commands: Command[], label: string): Command {
  const after = apply_command(document, { type: 'group', label, commands });
  const blends = document.characters.flatMap((c) => {
    const track = find_character(after, c.id)?.track;
    return track ? fit_blends(c.id, c.track, track) : [];
  });
  return with_room(document, { type: 'group', label, commands: [...commands, ...blends] }, clean(content_end(after)), label);
}

/**
 * The change of a clip's fields together with the move of everything after it: after the start of a clip that moves, after the end of a clip
 * whose length changes. A clip that is trimmed at its start keeps its start.
 */
export function ripple_clip(document: ScenarioDocument, character: string, clip: Clip, fields: ClipFields): Command {
  const length = fields.length ?? clip.length;
  const trimmed = fields.length !== undefined;
  const { start, ...others } = fields;
  const own: Command = { type: 'clip.set', character, id: clip.id, ...(trimmed ? others : fields) };
  const [time, delta] = trimmed ? [clip.start + clip.length, length - clip.length] : [clip.start, (start ?? clip.start) - clip.start];
  return whole(document, [own, ...shift_after(document, time, delta, [clip.id])], trimmed ? 'Ripple trim' : 'Ripple move');
}

/** Removes a clip and moves everything after it to its start. */
export function ripple_remove(document: ScenarioDocument, character: string, clip: Clip): Command {
  return whole(document, [{ type: 'clip.remove', character, id: clip.id }, ...shift_after(document, clip.start + clip.length, -clip.length, [clip.id])], 'Ripple delete');
}

/** Moves everything from `time` (s) on by `length` s. Clips that play at `time` keep their place. */
export const insert_time = (document: ScenarioDocument, time: number, length: number): Command => whole(document, shift_after(document, time, length, []), length > 0 ? 'Insert time' : 'Remove time');
