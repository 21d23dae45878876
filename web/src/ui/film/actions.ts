/** Commands on cameras and shots, at the playhead and from the view of the viewport. */
import type { Command } from '../../core/document';
import { shot_at, view_of, type FilmView } from '../../core/film';
import { cut_shot, find_camera, find_shot, key_camera, rounded } from '../../core/film_edits';
import { centre_of_mass } from '../../core/frames';
import { parts, session } from '../app';

const frame_time = (): number => {
  const { document } = session.state;
  return document ? Math.round((Math.round(session.now * document.frame_rate) / document.frame_rate) * 1e6) / 1e6 : 0;
};

/** Id of the camera that commands change: the selected one, that of the selected shot, the one of the view, or the only one. */
export function chosen_camera(): string | null {
  const { selection, document, through } = session.state;
  if (!document) return null;
  if (selection.kind === 'camera') return selection.camera;
  if (selection.kind === 'shot') return find_shot(document, selection.shot)?.camera ?? null;
  const shown = parts.viewport?.film_camera?.id ?? (find_camera(document, through) ? through : null);
  return shown ?? (document.cameras?.length === 1 ? document.cameras[0]!.id : null);
}

/** The view of the viewport as a camera that follows a character (empty: none) stores it. */
function view_for(follow: string | null | undefined): FilmView | null {
  const rig = parts.viewport?.rig;
  if (!rig) return null;
  const { target, azimuth, elevation, distance } = rig.current;
  const frame = session.frames.latest;
  const followed = follow ? frame?.characters[session.state.characters.findIndex((c) => c.id === follow)] : undefined;
  const [x, y] = frame && followed ? centre_of_mass(frame, followed) : [0, 0];
  return rounded({ target: [target.x - x, target.y - y, target.z], azimuth, elevation: Math.min(1.5, elevation), distance, field_of_view: rig.field_of_view });
}

/** Adds a camera with the view of the viewport, selects it, and looks through it. */
export async function add_camera(): Promise<void> {
  const { document, view } = session.state;
  const follow = view.follow ? (document?.camera?.follow ?? null) : null;
  const shown = view_for(follow);
  if (!document || !shown) return;
  const id = session.fresh_id('v');
  const cameras = document.cameras ?? [];
  let n = cameras.length + 1;
  while (cameras.some((c) => c.name === `Camera ${n}`)) n++;
  const add: Command = { type: 'camera.add', camera: { id, name: `Camera ${n}`, ...(follow ? { follow } : {}), ...shown } };
  // the first camera gets a shot of the whole scenario, so that exports show it at once
  const shot = cameras.length === 0 ? ({ type: 'shot.add', shot: { id: session.fresh_id('h'), camera: id, start: 0, length: document.duration } } as const) : null;
  if (!(await session.edit(shot ? { type: 'group', label: 'Add camera', commands: [add, shot] } : add))) return;
  session.select({ kind: 'camera', camera: id });
  session.set({ through: id });
}

/** Moves the chosen camera to the view of the viewport; a camera with keys gets a key at the playhead. */
export function place_camera(): void {
  const { document } = session.state;
  const camera = document && find_camera(document, chosen_camera() ?? '');
  if (!camera) return session.notify('Select a camera first.');
  if ((camera.keys?.length ?? 0) > 0) return void key_view();
  const view = view_for(camera.follow);
  if (view) void session.edit({ type: 'camera.set', id: camera.id, camera: view }).then((ok) => ok && session.set({ through: camera.id }));
}

/** Keys the view of the viewport at the playhead. The first key of a camera without keys also keeps its former view at the time 0. */
export function key_view(): void {
  const { document } = session.state;
  const camera = document && find_camera(document, chosen_camera() ?? '');
  if (!camera) return session.notify('Select a camera first.');
  const view = view_for(camera.follow);
  const time = frame_time();
  if (!view) return;
  const before = camera.keys?.length || time < 1e-3 ? camera : { ...camera, keys: [{ ...rounded(view_of(camera, 0)), time: 0 }] };
  void session.edit({ type: 'camera.set', id: camera.id, camera: { keys: key_camera(before, time, view) } }).then((ok) => ok && session.set({ through: camera.id }));
}

/** Cuts to the selected camera at the playhead, or to the one after that of the present shot. */
export function cut_here(): void {
  const { document, selection } = session.state;
  const cameras = document?.cameras ?? [];
  if (!document || cameras.length === 0) return session.notify('Add a camera first.');
  const time = frame_time();
  const shown = shot_at(document.shots, time)?.camera;
  const next = cameras[(cameras.findIndex((c) => c.id === shown) + 1) % cameras.length]!.id;
  const camera = selection.kind === 'camera' ? selection.camera : next;
  const id = session.fresh_id('h');
  const command = cut_shot(document, time, camera, id);
  if (!command) return session.notify('There is no room for a shot at the playhead.');
  void session.edit(command).then((ok) => ok && document.shots && session.set({ through: 'shots' }));
}

/** Looks through the selected camera, else through the shots or the only camera; or back to the free view. */
export function toggle_through(): void {
  const { through, document, selection } = session.state;
  if (through !== 'free') return session.set({ through: 'free' });
  const camera = selection.kind === 'camera' ? selection.camera : (document?.shots?.length ?? 0) > 0 ? 'shots' : chosen_camera();
  if (camera) session.set({ through: camera });
  else session.notify('There is no camera. Choose “New camera from this view”.');
}
