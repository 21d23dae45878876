/**
 * The viewport: draws the latest frame of the ring in each animation frame in which something changed. Its parts are the drawn characters,
 * the overlays of a frame, the guide of the view, and the picker, which answers geometric queries for selecting, pulling and placing
 * (PointerControl). Independent of React.
 */
import * as THREE from 'three';
import type { FilmCamera } from '../core/film';
import type { CharacterState, Frame } from '../core/frames';
import type { Comparison } from '../core/motion/comparer';
import type { MechanismData } from '../core/protocol';
import type { Session } from '../core/session';
import { shown_document, type StudioState } from '../core/state';
import { CameraRig } from './camera';
import type { LinkTag } from './character_view';
import { DrawnCharacters } from './drawn_characters';
import { FrameOverlays, type ClosestPair, type Pull } from './frame_overlays';
import { standing, type DrawnBody, type Standing } from './ground';
import type { PoseGhosts } from './other_times';
import { Picker, type Pick } from './picker';
import { on_texture } from './skin_view';
import { shadow_reach, Stage } from './stage';
import { ViewGuide } from './view_guide';

export type { Pick } from './picker';

const rest_ms = 180; // ms after the last motion, after which a frame is drawn at full resolution

/** Called after each drawn frame, so that page elements over the canvas can update. */
export type DrawListener = (viewport: Viewport) => void;

export class Viewport {
  readonly rig = new CameraRig();
  readonly stage: Stage;
  private readonly drawn: DrawnCharacters;
  private readonly overlays: FrameOverlays;
  private readonly guide: ViewGuide;
  private readonly picker: Picker;
  private readonly listeners = new Set<DrawListener>();
  private readonly drawing_listeners = new Set<() => void>();
  private readonly undo_subscriptions: (() => void)[] = [];
  /** True: something changed since the last drawn frame. */
  private dirty = true;
  /** Time of the last drawn frame in which something moved, ms. */
  private still_since = 0;
  /** True: the last frame was drawn at full resolution. */
  private drawn_still = false;
  /** Time of the last animation frame, ms. */
  private last_tick = 0;
  private handle = 0;
  /** Position and size of the canvas on the page, px. */
  private rect = { left: 0, top: 0, width: 1, height: 1 };
  /** Number of frames drawn; read by browser tests. */
  pictures = 0;

  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly session: Session,
    report_states: (states: Record<string, CharacterState>) => void,
  ) {
    this.stage = new Stage(canvas);
    const { scene } = this.stage;
    this.drawn = new DrawnCharacters(scene, () => session.state, report_states);
    this.overlays = new FrameOverlays(scene, session, this.drawn, this.rig);
    this.guide = new ViewGuide(scene, session, this.drawn, this.rig);
    this.picker = new Picker(canvas, this.rig);
    this.undo_subscriptions.push(
      session.store.subscribe((state, before) => this.state_changed(state, before)),
      session.frames.on_frame(() => this.invalidate()),
      on_texture(() => this.invalidate()),
    );
    this.state_changed(session.state, null);
    this.handle = requestAnimationFrame(this.tick);
  }

  dispose(): void {
    cancelAnimationFrame(this.handle);
    for (const undo of this.undo_subscriptions) undo();
    this.drawn.dispose();
    this.stage.dispose();
  }

  /** Requests that a new frame is drawn. */
  invalidate(): void {
    this.dirty = true;
  }

  /** Calls `listener` after each drawn frame. @return a function that removes the listener */
  on_draw(listener: DrawListener): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  /** Calls `listener` before each frame is drawn. @return a function that removes the listener */
  before_draw(listener: () => void): () => void {
    this.drawing_listeners.add(listener);
    return () => this.drawing_listeners.delete(listener);
  }

  resize(): void {
    const rect = this.canvas.parentElement?.getBoundingClientRect() ?? this.canvas.getBoundingClientRect();
    this.rect = { left: rect.left, top: rect.top, width: Math.max(1, rect.width), height: Math.max(1, rect.height) };
    this.stage.resize(rect.width, rect.height);
    this.rig.resize(this.rect.width / this.rect.height);
    this.invalidate();
  }

  get size(): { width: number; height: number } {
    return this.rect;
  }

  // ---- picking and projection ----

  /** The link at a point of the page, or near it; else null. @param client_x, client_y px */
  pick(client_x: number, client_y: number): Pick | null {
    return this.picker.pick(client_x, client_y, this.drawn.targets);
  }

  /** Intersection of the ray under the pointer with a plane, m; null if the ray does not meet it. */
  on_plane(client_x: number, client_y: number, plane: THREE.Plane): THREE.Vector3 | null {
    return this.picker.on_plane(client_x, client_y, plane);
  }

  /** Plane through `point` that faces the camera. */
  facing_plane(point: THREE.Vector3): THREE.Plane {
    return this.picker.facing_plane(point);
  }

  /** Position on the page of a world point, px; null if the point is behind the camera. */
  to_client(point: THREE.Vector3): { x: number; y: number } | null {
    return this.picker.to_client(point);
  }

  // ---- what is drawn ----

  /** Highlights the link under the pointer; null: none. */
  hover(tag: LinkTag | null): void {
    if (this.drawn.hover(tag)) this.invalidate();
  }

  /** Draws a pull; null: no pull. */
  show_pull(pull: Pull | null): void {
    this.overlays.pull = pull;
    this.drawn.pull(pull?.tag ?? null);
    this.invalidate();
  }

  /** Converts a world point into a link's frame, m; null if the link is not drawn. */
  to_link(tag: LinkTag, point: THREE.Vector3): THREE.Vector3 | null {
    return this.drawn.to_link(tag, point);
  }

  /** Draws a character displaced by `offset` (m) from its position in the frames. */
  show_offset(character: string, offset: THREE.Vector3): void {
    this.drawn.show_offset(character, offset);
    this.invalidate();
  }

  /** Draws a character in a pose that is not in the frames; null: as in the frames. */
  show_pose(pose: { character: string; links: readonly number[] } | null): void {
    this.drawn.show_pose(pose);
    this.invalidate();
  }

  /** Draws the ghosts of the posed character from poses before and after the present one; null: from frames. */
  show_pose_ghosts(ghosts: PoseGhosts | null): void {
    this.overlays.pose_ghosts = ghosts;
    this.invalidate();
  }

  /** Returns the comparison whose earlier motion is drawn as a ghost; null: none. */
  set before(comparison: () => Comparison | null) {
    this.overlays.before = comparison;
  }

  /** The closest pairs as drawn, smallest distance first. */
  get closest_pairs(): readonly ClosestPair[] {
    return this.overlays.closest_pairs;
  }

  mechanism_of(character: string): MechanismData | undefined {
    return this.drawn.mechanism_of(character);
  }

  link_label(tag: LinkTag): string {
    return this.drawn.link_label(tag);
  }

  /** Bounding sphere of a character (null: of all characters) as drawn now, m; null if nothing is drawn. */
  bounds(character: string | null): THREE.Sphere | null {
    return this.drawn.bounds(character);
  }

  /** How a character stands on the floor and on the props that do not move, as drawn now; null if it is not drawn. */
  standing(character: string): Standing | null {
    const doc = shown_document(this.session.state);
    const body = this.drawn.find(character)?.member;
    if (!doc || !body) return null;
    const props = new Map<string, DrawnBody>();
    for (const { id, prop } of doc.characters) {
      const member = prop && !(prop.mass > 0) && id !== character ? this.drawn.find(id)?.member : undefined;
      if (member) props.set(id, member);
    }
    return standing(body, props, doc.ground?.height ?? 0);
  }

  /** Point above a character at which its badge is shown, m. */
  head(character: string): THREE.Vector3 | null {
    const sphere = this.bounds(character);
    return sphere ? sphere.center.clone().add(new THREE.Vector3(0, 0, sphere.radius + 0.06)) : null;
  }

  // ---- the view ----

  /** Moves the camera so that the selected character fills the view; without a selection, all characters. */
  frame_selection(): void {
    this.guide.frame_selection();
    this.invalidate();
  }

  frame_all(): void {
    this.guide.frame_all();
    this.invalidate();
  }

  /** The camera of the document through which the viewport looks now; null: the view of the user. */
  get film_camera(): FilmCamera | null {
    return this.guide.film_camera;
  }

  /** Point on the ground below the centre of the view, m. */
  get looks_at(): { x: number; y: number } {
    const { x, y } = this.rig.current.target;
    return { x, y };
  }

  /**
   * The view as a PNG picture at full resolution, as it is drawn now; of a view through a camera of the document, the camera's picture.
   * Null if the browser cannot encode it.
   */
  picture(): Promise<Blob | null> {
    return new Promise((done) => this.picture_canvas().toBlob(done, 'image/png')); // in the same task as draw(), before the browser clears the buffer
  }

  private picture_canvas(): HTMLCanvasElement {
    this.draw(this.session.frames.latest, true);
    const part = this.rig.film_frame;
    if (!part) return this.canvas;
    const [width, height] = [Math.round(this.canvas.width * part.width), Math.round(this.canvas.height * part.height)];
    const out = Object.assign(document.createElement('canvas'), { width, height });
    out.getContext('2d')!.drawImage(this.canvas, -(this.canvas.width - width) / 2, -(this.canvas.height - height) / 2);
    return out;
  }

  // ---- updates ----

  private state_changed(state: StudioState, before: StudioState | null): void {
    const look = shown_document(state)?.look;
    if (!before || state.theme !== before.theme || look !== shown_document(before)?.look) this.stage.set_look(look ?? {}, state.theme);
    if (!before || state.document !== before.document || state.preview !== before.preview || state.mechanisms !== before.mechanisms || state.theme !== before.theme)
      this.drawn.sync(this.stage.environment);
    if (!before || state.selection !== before.selection) this.drawn.emphasise();
    if (before && (state.opened !== before.opened || state.open.join('/') !== before.open.join('/'))) this.guide.begin();
    this.rig.use_perspective = state.view.perspective;
    this.invalidate();
  }

  private readonly tick = (now: number): void => {
    this.handle = requestAnimationFrame(this.tick);
    const { draft } = this.session.state.view;
    if (!this.stage.free || (draft && this.stage.rests)) return;
    const dt = Math.min(0.4, Math.max(0.001, (now - this.last_tick) / 1000));
    this.last_tick = now;
    if (this.rect.width <= 2) return;
    const frame = this.session.frames.latest;
    if (this.dirty && frame) this.drawn.place(frame);
    if (this.guide.follow(frame)) this.dirty = true;
    if (this.rig.update(dt)) this.dirty = true;
    if (!this.dirty) {
      // slow machines draw frames at reduced resolution while something moves
      if (!this.drawn_still && now - this.still_since > rest_ms) this.draw(frame, true, draft);
      return;
    }
    if (!draft && this.still_since > 0 && now - this.still_since < 200) this.stage.note_frame_time(dt * 1000);
    this.still_since = now;
    this.dirty = false;
    this.draw(frame, false, draft);
  };

  private draw(frame: Frame | null, still: boolean, draft = false): void {
    this.drawn_still = still;
    this.overlays.draw(frame);
    this.guide.draw_cameras(frame);
    for (const listener of this.drawing_listeners) listener();
    const { target, distance } = this.rig.current;
    this.drawn.crowd.update();
    this.stage.focus(target, shadow_reach(this.drawn.each_sphere(), target, distance), distance);
    this.stage.render(this.rig.camera, still, draft);
    this.pictures++;
    if (this.guide.first_view(frame)) this.invalidate();
    for (const listener of this.listeners) listener(this);
  }
}
