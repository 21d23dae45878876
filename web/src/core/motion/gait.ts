/**
 * Gaits: clips whose motion the service makes from a recipe (docs/studio-protocol.md, "gait"). The store keeps what the service answered
 * about the bodies, and the path that is being drawn. Framework-free.
 */
import { createStore, type StoreApi } from 'zustand/vanilla';

/** A point on the ground, m. */
export type Point = [x: number, y: number];

export interface GaitStage {
  /** Time from the beginning of the motion, s. */
  time: number;
  kind: string;
  /** m/s; 0: stand. */
  speed: number;
  /** Degrees per second, positive to the left. */
  turn: number;
}

/** Recipe of a gait (docs/scenario.md). */
export interface GaitRecipe {
  kind: string;
  style: string;
  /** m/s; -1: a usual speed. */
  speed: number;
  /** Degrees per second, positive to the left. */
  turn: number;
  /** Duration, s. */
  seconds: number;
  from_stand: boolean;
  to_stand: boolean;
  /** Height of the swing feet, m; absent: usual. */
  step_height?: number;
  stages?: GaitStage[];
  /** Points in the frame of the clip's start, m: x ahead, y to the left. */
  path?: Point[];
}

/** Planar pose at which a clip starts: m, degrees about the vertical. */
export interface Start {
  x: number;
  y: number;
  heading: number;
}

/** What the service can make for a body. */
export interface Gaits {
  /** Kinds of gaits with a usual speed (m/s). */
  kinds: { kind: string; speed: number }[];
  styles: string[];
  /** Where the clip starts in the world. */
  start?: Start;
}

export interface GaitTarget {
  character: string;
  clip: string;
}

export interface GaitState {
  /** The clip whose path is drawn by clicks on the floor, and the points so far, world, m. */
  drawing: (GaitTarget & { start: Start; points: Point[] }) | null;
}

export const kind_labels: Record<string, string> = {
  walk: 'Walk', run: 'Run', trot: 'Trot', pace: 'Pace', canter: 'Canter', gallop: 'Gallop', rotary: 'Rotary gallop', bound: 'Bound', pronk: 'Pronk',
};
export const style_labels: Record<string, string> = { usual: 'Usual', sneak: 'Sneak', tired: 'Tired', proud: 'Proud', hurried: 'Hurried' };

/** A point of the frame of the clip's start in the world. */
export function to_world(start: Start, [x, y]: Point): Point {
  const a = (start.heading * Math.PI) / 180;
  return [start.x + x * Math.cos(a) - y * Math.sin(a), start.y + x * Math.sin(a) + y * Math.cos(a)];
}

/** A point of the world in the frame of the clip's start, rounded to centimetres. */
export function from_world(start: Start, [x, y]: Point): Point {
  const a = (start.heading * Math.PI) / 180;
  const dx = x - start.x;
  const dy = y - start.y;
  const round = (v: number): number => Math.round(v * 100) / 100 + 0;
  return [round(dx * Math.cos(a) + dy * Math.sin(a)), round(dy * Math.cos(a) - dx * Math.sin(a))];
}

/**
 * Points of the smooth curve through `points`: the centripetal Catmull-Rom curve along which the service leads the body.
 * @param pieces lines between two points
 */
export function smooth_path(points: readonly Point[], pieces = 16): Point[] {
  const p = points.filter((q, i) => i === 0 || Math.hypot(q[0] - points[i - 1]![0], q[1] - points[i - 1]![1]) > 1e-6);
  if (p.length < 2) return [...p];
  const beyond = (a: Point, b: Point): Point => [2 * a[0] - b[0], 2 * a[1] - b[1]];
  const all = [beyond(p[0]!, p[1]!), ...p, beyond(p.at(-1)!, p.at(-2)!)];
  const out: Point[] = [p[0]!];
  for (let i = 1; i + 2 < all.length; i++) {
    const q = all.slice(i - 1, i + 3);
    const t = [0];
    for (let k = 1; k < 4; k++) t.push(t[k - 1]! + Math.sqrt(Math.hypot(q[k]![0] - q[k - 1]![0], q[k]![1] - q[k - 1]![1])));
    for (let k = 1; k <= pieces; k++) {
      const s = t[1]! + ((t[2]! - t[1]!) * k) / pieces;
      // the pyramid of Barry and Goldman
      const mix = (a: Point, b: Point, ta: number, tb: number): Point => [0, 1].map((c) => (a[c]! * (tb - s) + b[c]! * (s - ta)) / (tb - ta)) as Point;
      const first = [0, 1, 2].map((k0) => mix(q[k0]!, q[k0 + 1]!, t[k0]!, t[k0 + 1]!));
      const second = [0, 1].map((k0) => mix(first[k0]!, first[k0 + 1]!, t[k0]!, t[k0 + 2]!));
      out.push(mix(second[0]!, second[1]!, t[1]!, t[2]!));
    }
  }
  return out;
}

/** The points of a recipe's path with its start and the lead-in: the service lets the body first go straight ahead. */
export function with_lead(path: readonly Point[]): Point[] {
  const first = path[0];
  if (!first) return [[0, 0]];
  const lead = Math.min(0.3, 0.25 * Math.hypot(first[0], first[1])); // m
  return [[0, 0], [lead, 0], ...path];
}

/** Length of a line through points, m. */
export const path_length = (points: readonly Point[]): number => points.reduce((sum, p, i) => (i === 0 ? 0 : sum + Math.hypot(p[0] - points[i - 1]![0], p[1] - points[i - 1]![1])), 0);

export interface GaitHost {
  ask(request: { op: 'gaits'; character: string; clip?: string }): Promise<Record<string, unknown>>;
  /** Makes a gait; without `clip`, for a new clip at `start`. */
  make(request: { character: string; clip?: string; start?: number; gait?: Partial<GaitRecipe> }): Promise<boolean>;
  fail(error: Error): void;
}

export class GaitDesk {
  readonly store: StoreApi<GaitState> = createStore<GaitState>(() => ({ drawing: null }));
  constructor(private readonly host: GaitHost) {}

  get state(): GaitState {
    return this.store.getState();
  }

  /** What can be made for the body of `character`. Rejects with the service's sentence if it has no legs. */
  async about(character: string, clip?: string): Promise<Gaits> {
    const reply = await this.host.ask({ op: 'gaits', character, ...(clip ? { clip } : {}) });
    return reply.gaits as Gaits;
  }

  change({ character, clip }: GaitTarget, gait: Partial<GaitRecipe>): Promise<boolean> {
    return this.host.make({ character, clip, gait });
  }

  /** Begins to draw a path for the gait of a clip. */
  async draw(target: GaitTarget): Promise<void> {
    try {
      const { start } = await this.about(target.character, target.clip);
      if (start) this.store.setState({ drawing: { ...target, start, points: [] } });
    } catch (error) {
      this.host.fail(error as Error);
    }
  }
  /** Adds a point of the world to the path that is drawn. @return whether a path is drawn */
  add(point: Point): boolean {
    const { drawing } = this.state;
    if (!drawing) return false;
    const last = drawing.points.at(-1) ?? to_world(drawing.start, [0, 0]);
    const near = 0.1; // m: the second click of a double click adds no point
    if (Math.hypot(point[0] - last[0], point[1] - last[1]) > near) this.store.setState({ drawing: { ...drawing, points: [...drawing.points, point] } });
    return true;
  }
  remove_last(): void {
    const { drawing } = this.state;
    if (drawing) this.store.setState({ drawing: { ...drawing, points: drawing.points.slice(0, -1) } });
  }
  /** Ends the drawing; the gait follows the path. */
  async finish(): Promise<void> {
    const { drawing } = this.state;
    this.store.setState({ drawing: null });
    if (!drawing || drawing.points.length === 0) return;
    await this.change(drawing, { path: drawing.points.map((p) => from_world(drawing.start, p)) });
  }
  cancel(): boolean {
    const was = this.state.drawing !== null;
    this.store.setState({ drawing: null });
    return was;
  }
}
