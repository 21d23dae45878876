/** Arithmetic of the curves panel: curves of joints over the time of the scenario, and the effect of dragging keys and tangents. */
import type { Clip } from '../document';
import type { CurvesReply } from '../protocol';
import { find_joint, find_key, key_slopes, moment_of, motion_time, part_of, value_at, type JointPart, type Key, type KeyedLayer, type KeyName, type KeyPut } from './keys';

/** One component of one joint. */
export interface Curve {
  link: string;
  part: JointPart;
  component: number;
  /** Unit of the drawn values: degrees, or centimetres for translations. */
  unit: '°' | 'cm';
  /** Drawn units per rad or m. */
  scale: number;
  /** Values of the motion without and with all layers, rad or m, at the samples of the reply. */
  base: readonly number[];
  result: readonly number[];
  /** Keys of the joint in the edited layer. */
  keys: readonly Key[];
}

export const curve_id = (c: { link: string; part: JointPart; component: number }): string => `${c.link}/${c.part}/${c.component}`;

/** A key as it is selected: its joint and time, and the component whose value a vertical drag changes (null: none). */
export interface KeyPick {
  link: string;
  part: JointPart;
  time: number;
  component: number | null;
}
export const same_pick = (a: KeyPick, b: KeyPick): boolean => a.link === b.link && a.part === b.part && Math.abs(a.time - b.time) < 1e-6 && a.component === b.component;

/** Curves of a reply. @param translates whether the joint of a link translates along a component */
export function curves_of(reply: CurvesReply, layer: KeyedLayer | null, translates: (link: string, component: number) => boolean): Curve[] {
  return reply.curves.flatMap(({ link, part, base, result }) =>
    base.map((values, component): Curve => {
      const metric = part === 'position' || (part === 'joint' && translates(link, component));
      return { link, part, component, unit: metric ? 'cm' : '°', scale: metric ? 100 : 180 / Math.PI, base: values, result: result[component]!, keys: (layer && find_joint(layer, link, part)?.keys) ?? [] };
    }),
  );
}

/** Linear interpolation of samples at `from`, `from + step` ...; constant outside. */
export function sample(values: readonly number[], from: number, step: number, t: number): number {
  if (values.length === 0) return 0;
  const x = Math.min(Math.max((t - from) / step, 0), values.length - 1);
  const i = Math.min(Math.floor(x), Math.max(0, values.length - 2));
  const a = values[i]!;
  return a + (x - i) * ((values[i + 1] ?? a) - a);
}

/** Change of a curve at time `t` of the motion when `before` becomes `after`, rad or m. Exact for joints with one DOF. */
export function layer_change(before: KeyedLayer | null, after: KeyedLayer | null, curve: Curve, t: number, period = 0): number {
  const part = (layer: KeyedLayer | null): [number, number] => {
    const keys = layer && find_joint(layer, curve.link, curve.part)?.keys;
    if (!layer || !keys) return [0, 0];
    const { weight, from, to, mix } = moment_of(layer, t, period);
    const value = value_at(keys, curve.component, from);
    return [mix === 0 ? value : value + mix * (value_at(keys, curve.component, to) - value), weight];
  };
  const [v0, w0] = part(before);
  const [v1, w1] = part(after);
  const mode = (after ?? before)?.mode ?? 'additive';
  if (mode === 'additive') return v1 * w1 - v0 * w0;
  return w1 * v1 - w0 * v0; // a replacing layer: the share of the motion below is nearly unchanged
}

/** Value of the edited curve at time `t` of the motion, rad or m. */
export const value_of = (curve: Curve, reply: { from: number; step: number }, before: KeyedLayer | null, after: KeyedLayer | null, t: number, period = 0): number =>
  sample(curve.result, reply.from, reply.step, t) + (before === after ? 0 : layer_change(before, after, curve, t, period));

/** Points of the edited curve in a span of scenario time: [time, value in drawn units] pairs. */
export function points(curve: Curve, value: (t: number) => number, clip: Clip, duration: number, from: number, to: number, count: number): [number, number][] {
  const first = Math.max(from, clip.start);
  const last = Math.min(to, clip.start + clip.length);
  if (last <= first) return [];
  return Array.from({ length: count + 1 }, (_, i): [number, number] => {
    const time = first + ((last - first) * i) / count;
    return [time, value(motion_time(clip, time, duration)) * curve.scale];
  });
}

const unique = (picks: readonly KeyPick[]): KeyPick[] => picks.filter((p, i) => picks.findIndex((q) => q.link === p.link && q.part === p.part && Math.abs(q.time - p.time) < 1e-6) === i);

/**
 * The edit that moves keys by `dt` (s in the motion) and the values of picked components by `dv` (rad or m in the result).
 * @return the edit, and the picks after it
 */
export function move_keys(layer: KeyedLayer, picks: readonly KeyPick[], dt: number, dv: number, duration: number): { take: KeyName[]; put: KeyPut[]; picks: KeyPick[] } {
  const keys = unique(picks);
  const earliest = Math.min(...keys.map((k) => k.time));
  const latest = Math.max(...keys.map((k) => k.time));
  const shift = Math.round(Math.min(Math.max(dt, -earliest), duration - latest) * 1e6) / 1e6;
  const take: KeyName[] = [];
  const put: KeyPut[] = [];
  for (const pick of keys) {
    const key = find_key(find_joint(layer, pick.link, pick.part) ?? { link: '', keys: [] }, pick.time);
    if (!key) continue;
    const value = key.value.map((v, c) => (picks.some((p) => p.component === c && p.link === pick.link && p.part === pick.part && Math.abs(p.time - pick.time) < 1e-6) ? Math.round((v + dv / (layer.weight || 1)) * 1e6) / 1e6 : v));
    if (shift !== 0) take.push({ link: pick.link, part: pick.part, time: key.time });
    put.push({ ...key, link: pick.link, part: pick.part, time: Math.round((key.time + shift) * 1e6) / 1e6, value });
  }
  return { take, put, picks: picks.map((p) => ({ ...p, time: p.time + shift })) };
}

/** The edit that gives keys a tangent. `flat` is a free tangent with slope 0. */
export function set_tangent(layer: KeyedLayer, picks: readonly KeyPick[], tangent: 'smooth' | 'linear' | 'step' | 'flat'): KeyPut[] {
  return unique(picks).map(({ link, part, time }) => {
    const key = find_key(find_joint(layer, link, part) ?? { link: '', keys: [] }, time);
    const zeros = key?.value.map(() => 0);
    return { link, part, time, tangent: tangent === 'flat' ? 'free' : tangent, ...(tangent === 'flat' ? { in: zeros, out: zeros } : {}) };
  });
}

/** The edit that turns one tangent of a component. @param side 0 before, 1 after the key @param broken true: the other side stays */
export function set_slope(layer: KeyedLayer, pick: KeyPick, side: 0 | 1, slope: number, broken: boolean): KeyPut[] {
  const joint = find_joint(layer, pick.link, pick.part);
  const index = joint?.keys.findIndex((k) => Math.abs(k.time - pick.time) < 1e-6) ?? -1;
  const key = joint?.keys[index];
  if (!joint || !key || pick.component === null) return [];
  const slopes = key.value.map((_, c) => key_slopes(joint.keys, index, c));
  const into = slopes.map((s) => s[0]);
  const out = slopes.map((s) => s[1]);
  if (side === 0 || !broken) into[pick.component] = slope;
  if (side === 1 || !broken) out[pick.component] = slope;
  return [{ link: pick.link, part: pick.part, time: key.time, tangent: 'free', in: into, out }];
}

/** Keys of the layer at a time of the motion. */
export const picks_at = (layer: KeyedLayer, time: number): KeyPick[] =>
  layer.joints.flatMap((j) => j.keys.filter((k) => Math.abs(k.time - time) < 5e-4).map((k) => ({ link: j.link, part: part_of(j), time: k.time, component: null })));
