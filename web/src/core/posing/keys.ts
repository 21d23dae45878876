/**
 * Keyed layers of clips (docs/scenario.md, "Keyed layers"): their data, the value of a curve between keys as the service computes it
 * (src/ugoki/motion_edit/keyed_layer.h), and the mapping between time in the motion and time of the scenario.
 */
import type { Clip, Command, ScenarioDocument } from '../document';
import { find_clip } from '../document';

export type Tangent = 'smooth' | 'linear' | 'step' | 'free';
export type JointPart = 'joint' | 'rotation' | 'position';

export interface Key {
  /** Time in the motion, s. */
  time: number;
  /** One number for each DOF of the joint, rad or m. */
  value: number[];
  /** Absent: smooth. */
  tangent?: Tangent;
  /** Slopes before and after a key with a free tangent, rad/s or m/s. */
  in?: number[];
  out?: number[];
}

export interface JointKeys {
  link: string;
  /** Absent: the whole joint. */
  part?: JointPart;
  keys: Key[];
}

export interface KeyedLayer {
  id: string;
  name: string;
  mode: 'additive' | 'replace';
  weight: number;
  /** Time before the first key in which the layer fades in, s; null: no fade. */
  ease_in: number | null;
  ease_out: number | null;
  /** Absent: true. */
  on?: boolean;
  joints: JointKeys[];
}

/** A key of `key.edit`. */
export interface KeyPut extends Omit<Partial<Key>, 'time'> {
  link: string;
  part?: JointPart;
  time: number;
}
export interface KeyName {
  link: string;
  part?: JointPart;
  time: number;
}

/** Keys of one curve nearer than this time are the same key, s. */
export const same_key = 5e-4;

export const part_of = (joint: { part?: JointPart }): JointPart => joint.part ?? 'joint';
export const find_layer = (clip: Clip, id: string | null): KeyedLayer | undefined => clip.layers?.find((l) => l.id === id);
export const find_joint = (layer: KeyedLayer, link: string, part: JointPart): JointKeys | undefined => layer.joints.find((j) => j.link === link && part_of(j) === part);
export const find_key = (joint: JointKeys, time: number): Key | undefined => joint.keys.find((k) => Math.abs(k.time - time) < same_key);

/** Times of all keys of the layer, ascending, each once. */
export function key_times(layer: KeyedLayer): number[] {
  const out: number[] = [];
  for (const time of layer.joints.flatMap((j) => j.keys.map((k) => k.time)).sort((a, b) => a - b)) if (out.length === 0 || time - out[out.length - 1]! >= same_key) out.push(time);
  return out;
}

/** Slope at a smooth key between two pieces of lengths h0, h1 with mean slopes d0, d1 (Fritsch and Butland 1984). */
function smooth_slope(h0: number, h1: number, d0: number, d1: number): number {
  if (!(d0 * d1 > 0)) return 0;
  const w0 = 2 * h1 + h0;
  const w1 = h1 + 2 * h0;
  return (w0 + w1) / (w0 / d0 + w1 / d1);
}

/** Slopes of component `c` just before and just after key `i`. */
export function key_slopes(keys: readonly Key[], i: number, c: number): [number, number] {
  const key = keys[i]!;
  const before = keys[i - 1];
  const after = keys[i + 1];
  if (key.tangent === 'free') return [key.in?.[c] ?? 0, key.out?.[c] ?? 0];
  const h0 = before ? key.time - before.time : 0;
  const h1 = after ? after.time - key.time : 0;
  const d0 = before ? (key.value[c]! - before.value[c]!) / h0 : 0;
  const d1 = after ? (after.value[c]! - key.value[c]!) / h1 : 0;
  if (key.tangent === 'linear') return [d0, d1];
  if (key.tangent === 'step' || !before || !after) return [0, 0];
  const slope = smooth_slope(h0, h1, d0, d1);
  return [slope, slope];
}

/** Value of component `c` at time `t` (s in the motion): cubic Hermite interpolation, constant outside the keys. */
export function value_at(keys: readonly Key[], c: number, t: number): number {
  const first = keys[0];
  const last = keys[keys.length - 1];
  if (!first || !last) return 0;
  if (t <= first.time) return first.value[c]!;
  if (t >= last.time) return last.value[c]!;
  let i = 0;
  while (keys[i + 1]!.time <= t) i++;
  const a = keys[i]!;
  const b = keys[i + 1]!;
  if (a.tangent === 'step') return a.value[c]!;
  const h = b.time - a.time;
  const s = (t - a.time) / h;
  const out = key_slopes(keys, i, c)[1];
  const into = key_slopes(keys, i + 1, c)[0];
  const s2 = s * s;
  const s3 = s2 * s;
  return (2 * s3 - 3 * s2 + 1) * a.value[c]! + (s3 - 2 * s2 + s) * h * out + (3 * s2 - 2 * s3) * b.value[c]! + (s3 - s2) * h * into;
}

const eased = (x: number): number => (x >= 1 ? 1 : x <= 0 ? 0 : x * x * (3 - 2 * x));

/** Weight of a layer at a time, and where its curves are read: value_at(from) (1 - mix) + value_at(to) mix. */
export interface LayerMoment {
  weight: number;
  from: number;
  to: number;
  mix: number;
}

const faded = (away: number, ease: number): number => (away <= 0 ? 1 : ease > 0 ? eased(1 - away / ease) : 0);

/** State of a layer at time `t` (s in the motion). @param period s, after which the motion of a looped clip repeats; 0: it does not */
export function moment_of(layer: KeyedLayer, t: number, period = 0): LayerMoment {
  const times = key_times(layer);
  const first = times[0];
  const last = times[times.length - 1];
  const { ease_in, ease_out, weight } = layer;
  if (first === undefined || last === undefined || layer.on === false) return { weight: 0, from: t, to: t, mix: 0 };
  if (!(period > 0)) {
    let share = weight;
    if (t < first && ease_in !== null) share *= faded(first - t, ease_in);
    if (t > last && ease_out !== null) share *= faded(t - last, ease_out);
    return { weight: share, from: t, to: t, mix: 0 };
  }
  const phase = t - period * Math.floor(t / period);
  if (phase >= first && phase <= last) return { weight, from: phase, to: phase, mix: 0 };
  const gap = Math.max(period - (last - first), 0);
  const since = phase > last ? phase - last : phase + period - last;
  if (ease_in === null && ease_out === null) return { weight, from: last, to: first, mix: gap > 0 ? eased(since / gap) : 0 };
  let into = ease_in ?? Math.max(gap - ease_out!, 0);
  let out = ease_out ?? Math.max(gap - into, 0);
  if (into + out > gap) [into, out] = [(into * gap) / (into + out), (out * gap) / (into + out)];
  const leaving = faded(since, out);
  const coming = faded(gap - since, into);
  return leaving >= coming ? { weight: weight * leaving, from: last, to: last, mix: 0 } : { weight: weight * coming, from: first, to: first, mix: 0 };
}

/** Weight of a layer at time `t` (s in the motion), with its fades. */
export const weight_at = (layer: KeyedLayer, t: number, period = 0): number => moment_of(layer, t, period).weight;

/** Time in the motion that a clip plays at a time of the scenario, s. @param duration of the motion, s */
export function motion_time(clip: Clip, time: number, duration: number): number {
  const t = clip.offset + Math.max(0, Math.min(time - clip.start, clip.length)) * clip.speed;
  return clip.loop && duration > 0 ? t - Math.floor(t / duration + 1e-9) * duration : Math.min(t, duration);
}

/** The times of the scenario at which a clip plays the time `t` of its motion: several if the clip loops. */
export function scenario_times(clip: Clip, t: number, duration: number): number[] {
  const first = clip.start + (t - clip.offset) / clip.speed;
  const period = clip.loop && duration > 0 ? duration / clip.speed : 0;
  const out: number[] = [];
  const end = clip.start + clip.length + 1e-6;
  if (period === 0) return first >= clip.start - 1e-6 && first <= end ? [first] : [];
  for (let x = first + Math.ceil((clip.start - first) / period - 1e-6) * period; x <= end && out.length < 1000; x += period) out.push(x);
  return out;
}

/** Times in the scenario at which the clip plays a key of a layer that is on, ascending, each once. @param duration of the motion, s; 0: unknown */
export function layer_times(clip: Clip, duration: number): number[] {
  const all = (clip.layers ?? []).filter((l) => l.on !== false).flatMap((l) => key_times(l).flatMap((t) => scenario_times(clip, t, duration)));
  const out: number[] = [];
  for (const time of all.sort((a, b) => a - b)) if (out.length === 0 || time - out[out.length - 1]! >= same_key) out.push(time);
  return out;
}

/** The document after `key.edit`, for the preview. */
export function edit_keys(layer: KeyedLayer, take: readonly KeyName[], put: readonly KeyPut[]): KeyedLayer {
  let joints = layer.joints.map((j) => ({ ...j, keys: j.keys.filter((k) => !take.some((n) => n.link === j.link && part_of(n) === part_of(j) && Math.abs(n.time - k.time) < same_key)) }));
  for (const { link, part, ...fields } of put) {
    let joint = joints.find((j) => j.link === link && part_of(j) === part_of({ part }));
    if (!joint) joints = [...joints, (joint = { link, ...(part && part !== 'joint' ? { part } : {}), keys: [] })];
    const old = joint.keys.find((k) => Math.abs(k.time - fields.time) < same_key);
    const key = { ...(old ?? { value: [] }), ...fields } as Key;
    if (key.tangent !== 'free') {
      delete key.in;
      delete key.out;
    }
    joint.keys = [...joint.keys.filter((k) => k !== old), key].sort((a, b) => a.time - b.time);
  }
  return { ...layer, joints: joints.filter((j) => j.keys.length > 0) };
}

/** Commands that set keys, and that first add the layer if the clip does not have it. */
export function key_command(doc: ScenarioDocument, character: string, clip: string, layer: KeyedLayer, edit: { put?: KeyPut[]; take?: KeyName[] }, label: string): Command {
  const known = find_clip(doc, character, clip)?.layers?.some((l) => l.id === layer.id);
  const keys: Command = { type: 'key.edit', character, clip, layer: layer.id, label, ...edit };
  if (known) return keys;
  const { joints: _joints, ...value } = layer;
  return { type: 'group', label, commands: [{ type: 'layer.add', character, clip, value }, keys] };
}
