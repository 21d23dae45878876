/** Cameras and shots of a scenario. docs/scenario.md describes their fields; view_of() and shot_at() equal those of content/film.cpp. */
import type { Vec3 } from './protocol';

/** The camera is at target + distance * (cos e cos a, cos e sin a, sin e) and looks at the target. */
export interface FilmView {
  /** m; x and y from the centre of mass of the followed character, if there is one. */
  target: Vec3;
  /** rad. */
  azimuth: number;
  elevation: number;
  /** m. */
  distance: number;
  /** Vertical angle of view in a picture of 16:9, rad. */
  field_of_view: number;
}

export interface FilmKey extends FilmView {
  /** s. */
  time: number;
}

export interface FilmCamera extends FilmView {
  id: string;
  name: string;
  follow?: string | null;
  keys?: FilmKey[];
}

export interface FilmShot {
  id: string;
  camera: string;
  start: number;
  length: number;
}

/** Width of the picture of a shot divided by its height. */
export const film_aspect = 16 / 9;

const slope_between = (h0: number, h1: number, d0: number, d1: number): number =>
  d0 * d1 > 0 ? (3 * (h0 + h1)) / ((2 * h1 + h0) / d0 + (h1 + 2 * h0) / d1) : 0;

/** View of a camera at a time, s: between keys a monotone cubic, which is at rest at the first and at the last key. */
export function view_of(camera: FilmCamera, time: number): FilmView {
  const keys = camera.keys ?? [];
  const next = keys.findIndex((k) => time < k.time);
  if (next < 1) return next === 0 ? keys[0]! : (keys.at(-1) ?? camera);
  const a = keys[next - 1]!;
  const b = keys[next]!;
  const h = b.time - a.time;
  const x = (time - a.time) / h;
  const between = (value: (view: FilmView) => number): number => {
    const slope = (k: number): number => {
      const [p, q, r] = [keys[k - 1], keys[k]!, keys[k + 1]];
      return p && r ? slope_between(q.time - p.time, r.time - q.time, (value(q) - value(p)) / (q.time - p.time), (value(r) - value(q)) / (r.time - q.time)) : 0;
    };
    return value(a) + x * x * (3 - 2 * x) * (value(b) - value(a)) + h * x * (1 - x) * ((1 - x) * slope(next - 1) - x * slope(next));
  };
  return {
    target: [0, 1, 2].map((i) => between((v) => v.target[i]!)) as Vec3,
    azimuth: between((v) => v.azimuth),
    elevation: between((v) => v.elevation),
    distance: between((v) => v.distance),
    field_of_view: between((v) => v.field_of_view),
  };
}

/** The shot at a time, s: of the shots that include the time, the one that starts last. */
export const shot_at = (shots: readonly FilmShot[] = [], time: number): FilmShot | undefined =>
  shots.filter((s) => s.start <= time && time < s.start + s.length).at(-1);
