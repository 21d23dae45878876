/** Arithmetic of the scenario panel: conversion between time and pixels, snapping, and the effect of dragging a clip or its edge. */
import { track_end, type Character, type Clip, type ClipFields, type Command, type ScenarioDocument } from './document';

/** The span of time that a panel shows. */
export interface TimeView {
  /** Time at the left edge of the panel, s. */
  origin: number;
  /** Pixels per second. */
  scale: number;
}

/** Limits of the scale, px per s. At 4 a panel 1000 px wide shows about 4 minutes; at 2400 a frame at 60 Hz is 40 px wide. */
export const min_scale = 4;
export const max_scale = 2400;

export const time_to_x = (view: TimeView, time: number): number => (time - view.origin) * view.scale;
export const x_to_time = (view: TimeView, x: number): number => view.origin + x / view.scale;

// keeps time 0 at most 24 px from the left edge
const keep_origin = (origin: number, scale: number): number => Math.max(-24 / scale, origin);

/** Zooms by `factor`. The time at pixel `x` stays at pixel `x`. */
export function zoom_at(view: TimeView, x: number, factor: number): TimeView {
  const scale = Math.min(max_scale, Math.max(min_scale, view.scale * factor));
  const time = x_to_time(view, x);
  return { scale, origin: keep_origin(time - x / scale, scale) };
}

export const pan_by = (view: TimeView, pixels: number): TimeView => ({ ...view, origin: keep_origin(view.origin + pixels / view.scale, view.scale) });

/** The view that shows 0 ... `duration` (s) in `width` px with a margin. */
export function fit_view(duration: number, width: number): TimeView {
  const scale = Math.min(max_scale, Math.max(min_scale, (Math.max(width, 80) - 32) / Math.max(duration, 0.5)));
  return { scale, origin: -12 / scale };
}

/** Distance between the ruler's labels, s, at least `min_px` pixels; and distance between the small ticks, s. */
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

/** Times to snap to: 0, the end, clip edges, events, markers, in, out and the playhead, without those of the dragged objects (ids `exclude`; 'range' is in and out). */
export function snap_targets(doc: ScenarioDocument, exclude: string | readonly string[], playhead: number): number[] {
  const times = [0, doc.duration, playhead];
  const dragged = new Set(typeof exclude === 'string' ? [exclude] : exclude);
  for (const c of doc.characters) {
    for (const k of c.track) if (!dragged.has(k.id)) times.push(k.start, k.start + k.length);
  }
  for (const i of doc.instances ?? []) if (!dragged.has(i.id)) times.push(i.start);
  for (const e of doc.events) if (!dragged.has(e.id)) times.push(e.time);
  for (const m of doc.markers ?? []) if (!dragged.has(m.id)) times.push(m.time);
  if (doc.range && !dragged.has('range')) times.push(doc.range.from, doc.range.to);
  return times;
}

export interface SnapRules {
  targets: readonly number[];
  /** Maximum distance from an edge to a snap target, s. */
  tolerance: number;
  frame_rate: number;
  /** False: no snapping; times are only rounded to a hundredth of a frame. */
  enabled: boolean;
}

/**
 * Adjusts `delta` so that one of `edges` meets a target, or otherwise so that the first edge falls on a frame.
 * @return the adjusted delta, s; `at` is the target that was met, s, for the guide line, or null
 */
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

/** Maximum length of a clip on its track, s: up to the end of the motion; unlimited if it loops or the motion is not known. */
export function max_length(clip: Clip, motion_duration: number | undefined): number {
  if (clip.loop || motion_duration === undefined) return Infinity;
  return Math.max(0, (motion_duration - clip.offset) / clip.speed);
}

/**
 * Fields of `clip` after dragging by `delta` s (before snapping). `move` shifts the clip. The trims shorten or lengthen it at one edge.
 * `stretch` changes its speed so that the same part of the motion fills the new length. `slip` moves the motion under a fixed clip.
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

/** The fields that differ from those of `clip`, or null if none does. */
export function changed_fields(clip: Clip, fields: ClipFields): ClipFields | null {
  const out: Record<string, unknown> = {};
  for (const [key, value] of Object.entries(fields)) if (clip[key as keyof Clip] !== value) out[key] = value;
  return Object.keys(out).length > 0 ? (out as ClipFields) : null;
}

/**
 * When and how fast a character still moves at the end of its track, or null. After that time the character holds one pose, and may fall.
 * Speeds below 0.25 m/s count as standing; a track that ends within 0.1 s of the scenario's end is not reported.
 * @param end_speed m/s  @param duration duration of the scenario, s
 */
export function ends_moving(character: Character, end_speed: number | undefined, duration: number): { time: number; speed: number } | null {
  const time = track_end(character);
  if (character.control.mode !== 'track' || end_speed === undefined || end_speed < 0.25 || time <= 0 || time > duration - 0.1) return null;
  return { time, speed: end_speed };
}

/** Command that repeats the last clip of a track until the end of the scenario (s); null: the motion of the clip is not one of the `cyclic` ones. */
export function loop_to_end(character: Character, cyclic: (motion: string) => boolean, duration: number): Command | null {
  const last = [...character.track].sort((a, b) => a.start + a.length - b.start - b.length).at(-1);
  if (!last || character.locked || last.start >= duration || !cyclic(last.motion)) return null;
  return { type: 'clip.set', character: character.id, id: last.id, loop: true, length: duration - last.start };
}

/** Command that moves `clip` from one character's track to another's, starting at `start` (s), as one undo step. */
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
