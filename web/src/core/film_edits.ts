/** Edits of cameras and shots in the studio. */
import type { Command, ScenarioDocument } from './document';
import { shot_at, view_of, type FilmCamera, type FilmKey, type FilmShot, type FilmView } from './film';

export const find_camera = (doc: ScenarioDocument, id: string): FilmCamera | undefined => doc.cameras?.find((c) => c.id === id);
export const find_shot = (doc: ScenarioDocument, id: string): FilmShot | undefined => doc.shots?.find((s) => s.id === id);

const shortest = 0.1; // s, of a shot that a cut leaves
const clean = (value: number): number => Math.round(value * 1e4) / 1e4;

/** The view with values that are short in the document. */
export const rounded = ({ target, azimuth, elevation, distance, field_of_view }: FilmView): FilmView => ({
  target: [clean(target[0]), clean(target[1]), clean(target[2])],
  azimuth: clean(azimuth),
  elevation: clean(elevation),
  distance: clean(distance),
  field_of_view: clean(field_of_view),
});

/** `angle` plus full turns, so that it is nearest to `other`. */
const nearest_turn = (angle: number, other: number): number => angle + Math.round((other - angle) / (2 * Math.PI)) * 2 * Math.PI;

/** The keys of a camera with a key of `view` at `time` (s). The camera turns to it by the smaller angle. */
export function key_camera(camera: FilmCamera, time: number, view: FilmView): FilmKey[] {
  const others = (camera.keys ?? []).filter((k) => Math.abs(k.time - time) > 1e-3);
  const azimuth = nearest_turn(view.azimuth, view_of({ ...camera, keys: others }, time).azimuth);
  return [...others, { ...rounded({ ...view, azimuth }), time }].sort((a, b) => a.time - b.time);
}

/**
 * Cuts to a camera at `time` (s): the shot there ends, and a new one with the id `id` takes its rest; where there is no shot, the new one
 * ends at the next shot or at the end of the scenario. Null: there is no room.
 */
export function cut_shot(doc: ScenarioDocument, time: number, camera: string, id: string): Command | null {
  const now = shot_at(doc.shots, time);
  if (now && time - now.start < shortest) return now.camera === camera ? null : { type: 'shot.set', id: now.id, shot: { camera } };
  const next = doc.shots?.find((s) => s.start > time)?.start ?? doc.duration;
  const end = now ? Math.min(now.start + now.length, next) : next;
  if (end - time < shortest) return null;
  const add: Command = { type: 'shot.add', shot: { id, camera, start: time, length: clean(end - time) } };
  return now ? { type: 'group', label: 'Cut', commands: [{ type: 'shot.set', id: now.id, shot: { length: clean(time - now.start) } }, add] } : add;
}

/** Focal length of a camera with a picture 36 mm wide, mm. */
export const focal_length = (field_of_view: number): number => 10.125 / Math.tan(field_of_view / 2);
/** Vertical angle of view of a focal length in mm, rad. */
export const field_of_focal_length = (mm: number): number => 2 * Math.atan(10.125 / mm);
