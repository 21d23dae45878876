/** Comparison of a clip after a physics correction with the clip before: poses for a ghost, and how far it changed. Framework-free. */
import { createStore, type StoreApi } from 'zustand/vanilla';
import { find_clip, type Clip, type ScenarioDocument } from '../document';

/** A row of the report of an operation: a measure before and after. */
export interface MeasureChange {
  name: string;
  unit: string;
  /** Numbers as the report writes them. */
  before: string;
  after: string;
}

/** Names that fit into the card. */
const short_names: Record<string, string> = {
  'Sliding of standing feet': 'Foot sliding',
  'Force that the ground cannot supply': 'Missing force',
  'Error of gravity in flights': 'Gravity error in flight',
};
const short_units: Record<string, string> = { 'body weights': '× weight', 'thousand rad/s³': '1000 rad/s³' };

export interface CompareReply {
  /** Time of the first pose in the scenario, and distance of the poses, s. */
  from: number;
  step: number;
  /** Poses of all links before, 7 values each (position, quaternion wxyz). */
  poses: number[][];
  /** Index of the link whose joint changed most, by `degrees` at `time` (s); -1: none changed. */
  link: number;
  degrees: number;
  time: number;
  /** Largest change of the centre of mass, m, at `move_time` (s). */
  move: number;
  move_time: number;
}

export interface Comparison {
  character: string;
  clip: string;
  /** Motion of the clip after the correction: another one ends the comparison. */
  motion: string;
  changes: MeasureChange[];
  reply: CompareReply;
}

export interface CompareState {
  comparison: Comparison | null;
  /** True: the ghost is shown. */
  on: boolean;
}

/** Rows of a report: "Sliding of standing feet: 2.40 cm before, 0.20 cm after." */
export function read_changes(report: readonly string[]): MeasureChange[] {
  return report.flatMap((line) => {
    const found = /^(.+): (-?[\d.]+) (.+) before, (-?[\d.]+) \3 after\.$/.exec(line);
    if (!found) return [];
    const unit = found[3]!;
    return [{ name: short_names[found[1]!] ?? found[1]!, unit: short_units[unit] ?? unit, before: found[2]!, after: found[4]! }];
  });
}

/** The pose before at a time of the scenario, interpolated between two samples; null outside of the clip. */
export function pose_before({ from, step, poses }: CompareReply, time: number): number[] | null {
  const x = (time - from) / step;
  if (poses.length === 0 || x < -1e-6 || x > poses.length - 1 + 1e-6) return null;
  const i = Math.min(Math.max(0, Math.floor(x)), poses.length - 1);
  const a = poses[i]!;
  const b = poses[Math.min(i + 1, poses.length - 1)]!;
  const share = Math.min(1, Math.max(0, x - i));
  const out = a.map((value, k) => value + (b[k]! - value) * share);
  for (let k = 3; k + 3 < out.length; k += 7) {
    const dot = a[k]! * b[k]! + a[k + 1]! * b[k + 1]! + a[k + 2]! * b[k + 2]! + a[k + 3]! * b[k + 3]!;
    const sign = dot < 0 ? -1 : 1; // the shorter way between two quaternions
    let length = 0;
    for (let j = k; j < k + 4; j++) {
      out[j] = a[j]! + (sign * b[j]! - a[j]!) * share;
      length += out[j]! ** 2;
    }
    for (let j = k; j < k + 4; j++) out[j]! /= Math.sqrt(length);
  }
  return out;
}

export interface CompareHost {
  ask(request: { op: 'compare'; character: string; clip: string; before: Clip }): Promise<Record<string, unknown>>;
  document(): ScenarioDocument | null;
}

export class Comparer {
  readonly store: StoreApi<CompareState> = createStore<CompareState>(() => ({ comparison: null, on: true }));
  constructor(private readonly host: CompareHost) {}

  get state(): CompareState {
    return this.store.getState();
  }

  /** Begins a comparison after a correction. @param before the clip as it was  @param report of the operation  @return whether it can be shown */
  async begin(character: string, clip: string, before: Clip, report: readonly string[]): Promise<boolean> {
    const document = this.host.document();
    const motion = document && find_clip(document, character, clip)?.motion;
    if (!motion) return false;
    try {
      const reply = (await this.host.ask({ op: 'compare', character, clip, before })) as unknown as CompareReply;
      this.store.setState({ comparison: { character, clip, motion, changes: read_changes(report), reply }, on: true });
      return true;
    } catch {
      return false; // the correction itself succeeded; without the earlier motion there is nothing to compare
    }
  }

  /** Ends the comparison if the clip plays another motion: the correction was undone, or the clip was removed. */
  check(): void {
    const { comparison } = this.state;
    const document = this.host.document();
    if (comparison && (!document || find_clip(document, comparison.character, comparison.clip)?.motion !== comparison.motion)) this.end();
  }

  show(on: boolean): void {
    this.store.setState({ on });
  }
  end(): void {
    this.store.setState({ comparison: null });
  }
}
