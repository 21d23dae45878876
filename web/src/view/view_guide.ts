/** Moves the view: the first view of a project, the followed character, and the cameras of the document. */
import * as THREE from 'three';
import { shot_at, view_of, type FilmCamera } from '../core/film';
import { centre_of_mass, type Frame } from '../core/frames';
import type { Session } from '../core/session';
import { instance_of } from '../core/nested';
import { selected_character, shown_document } from '../core/state';
import type { CameraRig } from './camera';
import type { DrawnCharacters } from './drawn_characters';
import { CameraOutlines } from './film_view';

export class ViewGuide {
  private readonly cameras = new CameraOutlines();
  private framed_once = false;
  /** Camera of the document and its view as shown last, as text; null: the view of the user. */
  private filmed: string | null = null;

  constructor(
    scene: THREE.Scene,
    private readonly session: Session,
    private readonly drawn: DrawnCharacters,
    private readonly rig: CameraRig,
  ) {
    scene.add(this.cameras.lines);
    rig.film_border = 1.12;
    rig.on_leave = () => {
      this.filmed = null;
      session.set({ through: 'free' });
    };
  }

  /** The next frame with all characters sets the first view: another project is open. */
  begin(): void {
    this.framed_once = false;
  }

  /** Moves the camera so that the selected character fills the view; without a selection, all characters. */
  frame_selection(): void {
    const { selection, characters } = this.session.state;
    const selected = selected_character(this.session.state);
    const instance = selection.kind === 'instance' ? characters.map((c) => c.id).filter((id) => instance_of(id) === selection.instance) : [];
    const spheres = (selected === null ? instance : [selected]).flatMap((id) => this.drawn.spheres(id));
    this.rig.frame(spheres.length > 0 ? spheres : this.drawn.spheres(null));
  }

  frame_all(): void {
    const spheres = this.drawn.spheres(null);
    this.rig.frame(spheres.length > 0 ? spheres : [new THREE.Sphere(new THREE.Vector3(0, 0, 0.9), 1.4)]);
  }

  /** Sets the camera when all characters are drawn for the first time. @return whether it did */
  first_view(frame: Frame | null): boolean {
    if (this.framed_once || this.drawn.count === 0 || !this.all_placed(frame)) return false;
    this.framed_once = true;
    if (this.filmed !== null) return false;
    const camera = this.session.state.document?.camera;
    if (camera?.azimuth !== undefined) this.rig.look_from(camera.azimuth, camera.elevation ?? 0.25);
    this.frame_all();
    const followed = camera?.follow ? this.drawn.spheres(camera.follow) : [];
    if (followed.length > 0) {
      this.rig.frame(followed);
      if (camera?.distance) this.rig.set({ distance: camera.distance }, false);
    }
    this.rig.set({}, true);
    return true;
  }

  /** Whether all characters of the document are drawn where `frame` has them. A character that is just added is in no frame yet. */
  private all_placed(frame: Frame | null): boolean {
    const count = this.session.state.characters.length;
    return frame !== null && Math.min(this.drawn.count, frame.characters.length) >= count;
  }

  /** Time of the drawn frame, s. */
  private get film_time(): number {
    return this.session.frames.latest?.time ?? this.session.now;
  }

  /** The camera of the document through which the viewport looks now; null: the view of the user. */
  get film_camera(): FilmCamera | null {
    const { through } = this.session.state;
    const doc = shown_document(this.session.state);
    const id = through === 'shots' ? shot_at(doc?.shots, this.film_time)?.camera : through;
    return doc?.cameras?.find((c) => c.id === id) ?? null;
  }

  /** Moves the view with the camera of the document, or with the followed character. @return whether a camera of the document moved it */
  follow(frame: Frame | null): boolean {
    const shown = this.filmed;
    if (this.look_through(frame)) return this.filmed !== shown;
    const moved = this.filmed !== shown;
    const { view, document, characters } = this.session.state;
    if (!view.follow || !frame) return this.release(moved);
    const id = selected_character(this.session.state) ?? document?.camera?.follow ?? characters[0]?.id;
    const character_frame = frame.characters[characters.findIndex((c) => c.id === id)];
    if (!character_frame) return this.release(moved);
    const [x, y, z] = centre_of_mass(frame, character_frame);
    this.rig.follow(new THREE.Vector3(x, y, z), id);
    return moved;
  }

  private release(moved: boolean): boolean {
    this.rig.follow(null);
    return moved;
  }

  /** Places the view at the camera of the document, or returns to the view of the user. @return false: the user moves the view */
  private look_through(frame: Frame | null): boolean {
    const camera = this.film_camera;
    const view = camera && view_of(camera, this.film_time);
    if (!camera && this.filmed === null) return false;
    const { characters } = this.session.state;
    const followed = frame?.characters[characters.findIndex((c) => c.id === camera?.follow)];
    const centre = frame && followed ? centre_of_mass(frame, followed) : null;
    const shown = camera ? `${camera.id} ${JSON.stringify(view)} ${centre?.join(' ')}` : null;
    if (shown === this.filmed) return true;
    this.filmed = shown;
    this.rig.look_through(view, centre && { x: centre[0], y: centre[1] });
    return camera !== null;
  }

  /** Draws the cameras of the document, unless the view is that of one. */
  draw_cameras(frame: Frame | null): void {
    const { selection, characters } = this.session.state;
    const doc = shown_document(this.session.state);
    this.cameras.begin();
    if (this.filmed === null)
      for (const camera of doc?.cameras ?? []) {
        const followed = frame?.characters[characters.findIndex((c) => c.id === camera.follow)];
        const [x, y] = frame && followed ? centre_of_mass(frame, followed) : [0, 0];
        const chosen = selection.kind === 'camera' ? selection.camera : selection.kind === 'shot' ? doc?.shots?.find((s) => s.id === selection.shot)?.camera : null;
        this.cameras.add(camera, this.film_time, { x, y }, camera.id === chosen);
      }
    this.cameras.end();
  }
}
