/** The scenario panel's arithmetic: time and pixels, snapping, and what a drag of a clip's body or edge means. */
import { track_end, type Character, type Clip, type ClipFields, type Command, type ScenarioDocument } from './document';

/** Which part of time a panel shows. */
export interface TimeView {
  /** s at the left edge */
  origin: number;
  /** px per s */
  scale: number;
}

export const min_scale = 4;
export const max_scale = 2400;

export const time_to_x = (view: TimeView, time: number): number => (time - view.origin) * view.scale;
export const x_to_time = (view: TimeView, x: number): number => view.origin + x / view.scale;

const keep_origin = (origin: number, scale: number): number => Math.max(-24 / scale, origin);

/** Zooms by `factor` so that the time under `x` stays under it. */
export function zoom_at(view: TimeView, x: number, factor: number): TimeView {
  const scale = Math.min(max_scale, Math.max(min_scale, view.scale * factor));
  const time = x_to_time(view, x);
  return { scale, origin: keep_origin(time - x / scale, scale) };
}

export const pan_by = (view: TimeView, pixels: number): TimeView => ({ ...view, origin: keep_origin(view.origin + pixels / view.scale, view.scale) });

/** Shows 0 ... `duration` in `width` px with a margin. */
export function fit_view(duration: number, width: number): TimeView {
  const scale = Math.min(max_scale, Math.max(min_scale, (Math.max(width, 80) - 32) / Math.max(duration, 0.5)));
  return { scale, origin: -12 / scale };
}

/** Distance of the ruler's labels in s, so that they are at least `min_px` apart; and of the small ticks between them. */
export function ruler_steps(scale: number, frame_rate: number, min_px = 84): { label: number; tick: number } {
  const frame = 1 / frame_rate;
  const steps: [number, number][] = [
    [frame, frame],
    [5 * frame, frame],
    [10 * frame, frame],
    [0.5, 0.1],
    [1, 0.2],
    [2, 0.5],
    [5, 1],
    [10, 2],
    [15, 5],
    [30, 10],
    [60, 10],
    [120, 30],
    [300, 60],
  ];
  for (const [label, tick] of steps) if (label * scale >= min_px) return { label, tick };
  return { label: 600, tick: 120 };
}

export const round_to_frame = (time: number, frame_rate: number): number => Math.round(time * frame_rate) / frame_rate;

/** Times worth snapping to: 0, the end, clip edges, events and the playhead, without those of what is dragged. */
export function snap_targets(doc: ScenarioDocument, exclude: string, playhead: number): number[] {
  const times = [0, doc.duration, playhead];
  for (const c of doc.characters) {
    for (const k of c.track) if (k.id !== exclude) times.push(k.start, k.start + k.length);
  }
  for (const e of doc.events) if (e.id !== exclude) times.push(e.time);
  return times;
}

export interface SnapRules {
  targets: readonly number[];
  /** s */
  tolerance: number;
  frame_rate: number;
  /** Off: only a hundredth of a frame is rounded away. */
  enabled: boolean;
}

/** Moves `delta` so that one of `edges` meets a target, or else falls on a frame. `at`: the target met, for the guide line. */
export function snap_delta(edges: readonly number[], delta: number, rules: SnapRules): { delta: number; at: number | null } {
  if (!rules.enabled) return { delta: Math.round(delta * rules.frame_rate * 100) / (rules.frame_rate * 100), at: null };
  let best = rules.tolerance;
  let found: { delta: number; at: number } | null = null;
  for (const edge of edges) {
    for (const target of rules.targets) {
      const distance = Math.abs(edge + delta - target);
      if (distance < best) {
        best = distance;
        found = { delta: target - edge, at: target };
      }
    }
  }
  if (found) return found;
  const edge = edges[0] ?? 0;
  return { delta: round_to_frame(edge + delta, rules.frame_rate) - edge, at: null };
}

export type ClipDragKind = 'move' | 'trim_start' | 'trim_end' | 'stretch' | 'slip';

const clean = (value: number): number => Math.round(value * 1e6) / 1e6;

/** Longest length of a clip on its track, s: to the motion's end, unless it loops or the motion is not known. */
export function max_length(clip: Clip, motion_duration: number | undefined): number {
  if (clip.loop || motion_duration === undefined) return Infinity;
  return Math.max(0, (motion_duration - clip.offset) / clip.speed);
}

/**
 * Fields of `clip` after dragging by `delta` s (before snapping): move shifts it, trims cut or uncover it, stretch changes its
 * speed so that the same motion fills the new length, slip moves the motion under a clip that stays.
 */
export function drag_clip(
  clip: Clip,
  kind: ClipDragKind,
  delta: number,
  rules: SnapRules,
  motion_duration: number | undefined,
): { fields: ClipFields; at: number | null } {
  const frame = 1 / rules.frame_rate;
  const end = clip.start + clip.length;
  switch (kind) {
    case 'move': {
      const snapped = snap_delta([clip.start, end], delta, rules);
      const start = Math.max(0, clip.start + snapped.delta);
      return { fields: { start: clean(start) }, at: snapped.at };
    }
    case 'trim_start': {
      const snapped = snap_delta([clip.start], delta, rules);
      const earliest = clip.loop ? -clip.start : Math.max(-clip.start, -clip.offset / clip.speed);
      const d = Math.min(Math.max(snapped.delta, earliest), clip.length - frame);
      let offset = clip.offset + d * clip.speed;
      if (clip.loop && motion_duration) offset = ((offset % motion_duration) + motion_duration) % motion_duration;
      return {
        fields: { start: clean(clip.start + d), length: clean(clip.length - d), offset: clean(Math.max(0, offset)) },
        at: d === snapped.delta ? snapped.at : null,
      };
    }
    case 'trim_end': {
      const snapped = snap_delta([end], delta, rules);
      const longest = max_length(clip, motion_duration);
      const length = Math.min(Math.max(clip.length + snapped.delta, frame), Math.max(longest, clip.length));
      return { fields: { length: clean(length) }, at: length === clip.length + snapped.delta ? snapped.at : null };
    }
    case 'stretch': {
      const snapped = snap_delta([end], delta, rules);
      const length = Math.max(clip.length + snapped.delta, frame);
      const speed = Math.min(4, Math.max(0.1, (clip.speed * clip.length) / length));
      return { fields: { length: clean((clip.speed * clip.length) / speed), speed: clean(speed) }, at: snapped.at };
    }
    case 'slip': {
      const d = snap_delta([0], delta, { ...rules, targets: [] }).delta;
      const latest = motion_duration === undefined || clip.loop ? Infinity : Math.max(0, motion_duration - clip.length * clip.speed);
      return { fields: { offset: clean(Math.min(latest, Math.max(0, clip.offset - d * clip.speed))) }, at: null };
    }
  }
}

/** Only the fields that differ from the clip's: null where a drag ended where it began. */
export function changed_fields(clip: Clip, fields: ClipFields): ClipFields | null {
  const out: Record<string, unknown> = {};
  for (const [key, value] of Object.entries(fields)) if (clip[key as keyof Clip] !== value) out[key] = value;
  return Object.keys(out).length > 0 ? (out as ClipFields) : null;
}

/** Where and how fast a track leaves its figure in the middle of a movement (after that it holds one pose, and falls); else null. */
export function ends_moving(character: Character, end_speed: number | undefined, duration: number): { time: number; speed: number } | null {
  const time = track_end(character);
  if (character.control.mode !== 'track' || end_speed === undefined || end_speed < 0.25 || time <= 0 || time > duration - 0.1) return null;
  return { time, speed: end_speed };
}

/** Takes `clip` off one character's track and puts it on another's at `start`, as one step of undo. */
export function move_clip(clip: Clip, from: string, to: string, start: number): Command {
  return {
    type: 'group',
    label: 'Move clip to another track',
    commands: [
      { type: 'clip.remove', character: from, id: clip.id },
      { ...clip, type: 'clip.add', character: to, start },
    ],
  };
}
