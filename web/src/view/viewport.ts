/**
 * The viewport: draws the latest frame of the ring in each animation frame in which something changed, and answers geometric queries for
 * selecting, pulling and placing (PointerControl). Independent of React.
 */
import * as THREE from 'three';
import { find_character, is_left_out } from '../core/document';
import { shot_at, view_of, type FilmCamera } from '../core/film';
import { format_label } from '../core/format';
import { assist_over_cap, body_weight, centre_of_mass, CharacterState, state_of, type CharacterFrame, type Frame } from '../core/frames';
import type { MechanismData } from '../core/protocol';
import type { Session } from '../core/session';
import { selected_character, shown_document, type StudioState } from '../core/state';
import { CameraRig } from './camera';
import { mechanism_geometries, type LinkTag } from './character_view';
import { Crowd } from './crowd';
import { on_texture } from './skin_view';
import type { CrowdMember } from './crowd_member';
import { Arrow, assist_color, ContactDiscs, make_ring, Segments, Spring } from './overlays';
import { CameraOutlines } from './film_view';
import { pose_before, type Comparison } from '../core/motion/comparer';
import { OtherTimes, type PoseGhosts } from './other_times';
import { shadow_reach, Stage } from './stage';

const reach = 10; // maximum distance between the pointer and a link that is picked, px
const max_contact_arrows = 48; // maximum number of contacts that are drawn with arrows

const point_of_mass = new THREE.Vector3();
const force_of_assist = new THREE.Vector3();
const start_of_assist = new THREE.Vector3();

/** The objects drawn for one character. */
interface Drawn {
  member: CrowdMember;
  times: OtherTimes;
  assist: Arrow;
  /** Packed poses of all links to draw instead of those of the frames; null: draw the frames. */
  pose: Float32Array | null;
}

/** The link under the pointer, and the hit point in the world, m. */
export interface Pick extends LinkTag {
  point: THREE.Vector3;
}

/** Called after each drawn frame, so that page elements over the canvas can update. */
export type DrawListener = (viewport: Viewport) => void;

export class Viewport {
  readonly rig = new CameraRig();
  readonly stage: Stage;
  private readonly crowd = new Crowd();
  private readonly drawn = new Map<string, Drawn>();
  private readonly geometries = new Map<string, (THREE.BufferGeometry | null)[]>();
  private readonly contact_arrows: Arrow[] = [];
  private readonly contact_discs = new ContactDiscs(max_contact_arrows);
  private readonly normals = new Segments(0x9adcf7, 1.6);
  private readonly closest_lines = new Segments(0x7dd3fc, 1.6);
  /** The closest pairs as drawn, smallest distance first: distance (m), midpoint of the line, indices of the characters. */
  closest_pairs: { distance: number; middle: THREE.Vector3; a: number; b: number }[] = [];
  private readonly spring = new Spring();
  private readonly ring = make_ring();
  private readonly cameras = new CameraOutlines();
  private readonly raycaster = new THREE.Raycaster();
  private readonly listeners = new Set<DrawListener>();
  private readonly drawing_listeners = new Set<() => void>();
  /** Ghosts of the posed character; null: ghosts are drawn from frames. */
  private pose_ghosts: PoseGhosts | null = null;
  /** Returns the comparison whose earlier motion is drawn as a ghost; null: none. */
  before: () => Comparison | null = () => null;
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
  private framed_once = false;
  /** Camera of the document and its view as shown last, as text; null: the view of the user. */
  private filmed: string | null = null;
  private hovered: LinkTag | null = null;
  private pull: { tag: LinkTag; local: THREE.Vector3; target: THREE.Vector3 } | null = null;
  /** The last reported states, in the order of the characters. */
  private readonly shown_states: CharacterState[] = [];
  /** Number of frames drawn; read by browser tests. */
  pictures = 0;

  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly session: Session,
    private readonly report_states: (states: Record<string, CharacterState>) => void,
  ) {
    this.stage = new Stage(canvas);
    this.stage.scene.add(this.crowd.group);
    for (let i = 0; i < max_contact_arrows; i++) {
      const arrow = new Arrow(0xfdba74, 0.009);
      this.contact_arrows.push(arrow);
      this.stage.scene.add(arrow.group);
    }
    this.stage.scene.add(this.cameras.lines, this.spring.group, this.ring, this.contact_discs.mesh, this.normals.lines, this.closest_lines.lines);
    this.undo_subscriptions.push(
      session.store.subscribe((state, before) => this.state_changed(state, before)),
      session.frames.on_frame(() => this.invalidate()),
      on_texture(() => this.invalidate()),
    );
    this.rig.film_border = 1.12;
    this.rig.on_leave = () => {
      this.filmed = null;
      session.set({ through: 'free' });
    };
    this.state_changed(session.state, null);
    this.handle = requestAnimationFrame(this.tick);
  }

  dispose(): void {
    cancelAnimationFrame(this.handle);
    for (const undo of this.undo_subscriptions) undo();
    this.crowd.dispose();
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

  /** The link at a point of the page; else a link within about `reach` px of the point; else null. @param client_x, client_y px */
  pick(client_x: number, client_y: number): Pick | null {
    const groups = [...this.drawn.values()].map((entry) => entry.member.group);
    const look = (dx: number, dy: number): Pick | null => {
      this.aim(client_x + dx, client_y + dy);
      const hit = this.raycaster.intersectObjects(groups, true)[0];
      return hit ? { ...(hit.object.userData as LinkTag), point: hit.point.clone() } : null;
    };
    const exact = look(0, 0);
    if (exact) return exact;
    for (const radius of [reach / 2, reach]) {
      for (let i = 0; i < 8; i++) {
        const near = look(radius * Math.cos((i * Math.PI) / 4), radius * Math.sin((i * Math.PI) / 4));
        if (near) return near;
      }
    }
    return null;
  }

  /** Intersection of the ray under the pointer with a plane, m; null if the ray does not meet it. */
  on_plane(client_x: number, client_y: number, plane: THREE.Plane): THREE.Vector3 | null {
    this.aim(client_x, client_y);
    return this.raycaster.ray.intersectPlane(plane, new THREE.Vector3());
  }

  /** Plane through `point` that faces the camera. */
  facing_plane(point: THREE.Vector3): THREE.Plane {
    return new THREE.Plane().setFromNormalAndCoplanarPoint(this.rig.camera.getWorldDirection(new THREE.Vector3()).negate(), point);
  }

  /** Position on the page of a world point, px; null if the point is behind the camera. */
  to_client(point: THREE.Vector3): { x: number; y: number } | null {
    const p = point.clone().project(this.rig.camera);
    if (p.z > 1) return null;
    const rect = this.canvas.getBoundingClientRect();
    return { x: rect.left + (0.5 + 0.5 * p.x) * rect.width, y: rect.top + (0.5 - 0.5 * p.y) * rect.height };
  }

  private aim(client_x: number, client_y: number): void {
    const rect = this.canvas.getBoundingClientRect();
    const x = ((client_x - rect.left) / rect.width) * 2 - 1;
    const y = 1 - ((client_y - rect.top) / rect.height) * 2;
    this.raycaster.setFromCamera(new THREE.Vector2(x, y), this.rig.camera);
  }

  // ---- interaction ----

  /** Highlights the link under the pointer; null: none. */
  hover(tag: LinkTag | null): void {
    if (this.hovered?.character === tag?.character && this.hovered?.link === tag?.link) return;
    this.hovered = tag;
    this.emphasise();
    this.invalidate();
  }

  /** Draws a pull from `local` (link frame, m) to `target` (world, m); null: no pull. */
  show_pull(pull: { tag: LinkTag; local: THREE.Vector3; target: THREE.Vector3 } | null): void {
    this.pull = pull;
    this.emphasise();
    this.invalidate();
  }

  /** Converts a world point into a link's frame, m; null if the link is not drawn. */
  to_link(tag: LinkTag, point: THREE.Vector3): THREE.Vector3 | null {
    const mesh = this.drawn.get(tag.character)?.member.links[tag.link];
    if (!mesh) return null;
    return point.clone().applyMatrix4(mesh.matrixWorld.clone().invert());
  }

  /** Draws a character displaced by `offset` (m) from its position in the frames. */
  show_offset(character: string, offset: THREE.Vector3): void {
    this.drawn.get(character)?.member.offset.copy(offset);
    this.invalidate();
  }

  /** Draws a character in a pose that is not in the frames; null: as in the frames. */
  show_pose(pose: { character: string; links: readonly number[] } | null): void {
    for (const [id, entry] of this.drawn) entry.pose = pose?.character === id ? Float32Array.from(pose.links) : null;
    this.invalidate();
  }

  /** Draws the ghosts of the posed character from poses before and after the present one; null: from frames. */
  show_pose_ghosts(ghosts: PoseGhosts | null): void {
    this.pose_ghosts = ghosts;
    this.invalidate();
  }

  mechanism_of(character: string): MechanismData | undefined {
    return this.drawn.get(character)?.member.mechanism;
  }

  link_label(tag: LinkTag): string {
    const link = this.drawn.get(tag.character)?.member.mechanism.links[tag.link];
    return format_label(link?.label || link?.name || '');
  }

  /** Bounding spheres of the links of a character (null: of all characters) as drawn now, m. */
  private spheres(character: string | null): THREE.Sphere[] {
    const out: THREE.Sphere[] = [];
    for (const [id, entry] of this.drawn) {
      if (character !== null && id !== character) continue;
      out.push(...entry.member.spheres);
    }
    return out;
  }

  private *each_sphere(): Generator<THREE.Sphere> {
    for (const entry of this.drawn.values()) yield* entry.member.spheres;
  }

  /** Bounding sphere of a character (null: of all characters) as drawn now, m; null if nothing is drawn. */
  bounds(character: string | null): THREE.Sphere | null {
    const box = new THREE.Box3();
    for (const s of this.spheres(character))
      box.expandByPoint(s.center.clone().addScalar(s.radius)).expandByPoint(s.center.clone().subScalar(s.radius));
    return box.isEmpty() ? null : box.getBoundingSphere(new THREE.Sphere());
  }

  /** Moves the camera so that the selected character fills the view; without a selection, all characters. */
  frame_selection(): void {
    const selected = selected_character(this.session.state);
    const spheres = selected === null ? [] : this.spheres(selected);
    this.rig.frame(spheres.length > 0 ? spheres : this.spheres(null));
    this.invalidate();
  }

  frame_all(): void {
    const spheres = this.spheres(null);
    this.rig.frame(spheres.length > 0 ? spheres : [new THREE.Sphere(new THREE.Vector3(0, 0, 0.9), 1.4)]);
    this.invalidate();
  }

  /** Point above a character at which its badge is shown, m. */
  head(character: string): THREE.Vector3 | null {
    const sphere = this.bounds(character);
    return sphere ? sphere.center.clone().add(new THREE.Vector3(0, 0, sphere.radius + 0.06)) : null;
  }

  /**
   * The view as a PNG picture at full resolution, as it is drawn now; of a view through a camera of the document, the camera's picture.
   * Null if the browser cannot encode it.
   */
  picture(): Promise<Blob | null> {
    return new Promise((done) => this.picture_canvas().toBlob(done, 'image/png')); // in the same task as draw(), before the browser clears the buffer
  }

  /** Point on the ground below the centre of the view, m. */
  get looks_at(): { x: number; y: number } {
    const { x, y } = this.rig.current.target;
    return { x, y };
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

  // ---- updates from the state ----

  private state_changed(state: StudioState, before: StudioState | null): void {
    const look = shown_document(state)?.look;
    if (!before || state.theme !== before.theme || look !== shown_document(before)?.look) this.stage.set_look(look ?? {}, state.theme);
    if (!before || state.document !== before.document || state.preview !== before.preview || state.mechanisms !== before.mechanisms || state.theme !== before.theme)
      this.sync_characters(state);
    if (!before || state.selection !== before.selection) this.emphasise();
    if (before && state.opened !== before.opened) this.framed_once = false;
    this.rig.use_perspective = state.view.perspective;
    this.invalidate();
  }

  private sync_characters(state: StudioState): void {
    const doc = shown_document(state);
    const wanted = new Map<string, MechanismData>();
    for (const character of doc?.characters ?? []) {
      const mechanism = state.mechanisms[character.mechanism];
      if (mechanism && doc && !is_left_out(doc, character)) wanted.set(character.id, mechanism);
    }
    for (const [id, entry] of this.drawn) {
      if (wanted.get(id) === entry.member.mechanism) continue;
      this.remove(entry);
      this.drawn.delete(id);
    }
    for (const [id, mechanism] of wanted) {
      const character = find_character(doc!, id)!;
      const color = character.color || '#e6e6ea';
      const entry = this.drawn.get(id) ?? this.add(id, mechanism, color);
      this.drawn.set(id, entry);
      this.crowd.set_look(entry.member, color, character, character.metalness ? this.stage.environment : null);
    }
    this.emphasise();
  }

  private add(id: string, mechanism: MechanismData, color: string): Drawn {
    let geometries = this.geometries.get(mechanism.id);
    if (!geometries) {
      geometries = mechanism_geometries(mechanism);
      this.geometries.set(mechanism.id, geometries);
    }
    const entry: Drawn = {
      member: this.crowd.add(id, mechanism, geometries, color),
      times: new OtherTimes(mechanism, geometries),
      assist: new Arrow(0x34d399, 0.011, true),
      pose: null,
    };
    this.stage.scene.add(entry.assist.group, entry.times.group);
    return entry;
  }

  private remove(entry: Drawn): void {
    this.stage.scene.remove(entry.assist.group, entry.times.group);
    this.crowd.remove(entry.member);
    entry.times.dispose();
  }

  private emphasise(): void {
    const { selection } = this.session.state;
    for (const [id, entry] of this.drawn) {
      entry.member.mechanism.links.forEach((_link, link) => {
        const pulled = this.pull?.tag.character === id && this.pull.tag.link === link;
        const selected = selection.kind === 'character' && selection.character === id && selection.link === link;
        const hovered = this.hovered?.character === id && this.hovered.link === link;
        entry.member.emphasise(link, pulled ? 'pulled' : hovered ? 'hover' : selected ? 'selected' : 'none');
      });
    }
  }

  // ---- drawing ----

  private readonly tick = (now: number): void => {
    this.handle = requestAnimationFrame(this.tick);
    const { draft } = this.session.state.view;
    if (!this.stage.free || (draft && this.stage.rests)) return;
    const dt = Math.min(0.4, Math.max(0.001, (now - this.last_tick) / 1000));
    this.last_tick = now;
    if (this.rect.width <= 2) return;
    const frame = this.session.frames.latest;
    if (this.dirty && frame) this.place_characters(frame);
    this.follow(frame);
    if (this.rig.update(dt)) this.dirty = true;
    if (!this.dirty) {
      // slow machines draw frames at reduced resolution while something moves; 180 ms after the last motion one frame is drawn at full
      // resolution
      if (!this.drawn_still && now - this.still_since > 180) this.draw(frame, true, draft);
      return;
    }
    if (!draft && this.still_since > 0 && now - this.still_since < 200) this.stage.note_frame_time(dt * 1000);
    this.still_since = now;
    this.dirty = false;
    this.draw(frame, false, draft);
  };

  private draw(frame: Frame | null, still: boolean, draft = false): void {
    this.drawn_still = still;
    this.draw_overlays(frame);
    for (const listener of this.drawing_listeners) listener();
    const { target, distance } = this.rig.current;
    this.crowd.update();
    this.stage.focus(target, shadow_reach(this.each_sphere(), target, distance), distance);
    this.stage.render(this.rig.camera, still, draft);
    this.pictures++;
    if (!this.framed_once && this.drawn.size > 0 && this.all_placed(frame)) this.first_view();
    for (const listener of this.listeners) listener(this);
  }

  /** Whether all characters of the document are drawn where `frame` has them. A character that is just added is in no frame yet. */
  private all_placed(frame: Frame | null): boolean {
    const count = this.session.state.document?.characters.length ?? 0;
    return frame !== null && Math.min(this.drawn.size, frame.characters.length) >= count;
  }

  /** Sets the camera when all characters are drawn for the first time. */
  private first_view(): void {
    this.framed_once = true;
    if (this.filmed !== null) return;
    const camera = this.session.state.document?.camera;
    if (camera?.azimuth !== undefined) this.rig.look_from(camera.azimuth, camera.elevation ?? 0.25);
    this.frame_all();
    const followed = camera?.follow ? this.spheres(camera.follow) : [];
    if (followed.length > 0) {
      this.rig.frame(followed);
      if (camera?.distance) this.rig.set({ distance: camera.distance }, false);
    }
    this.rig.set({}, true);
  }

  private place_characters(frame: Frame): void {
    const { characters } = this.session.state;
    let changed = this.shown_states.length !== characters.length;
    characters.forEach((character, index) => {
      const entry = this.drawn.get(character.id);
      const character_frame = frame.characters[index];
      if (!character_frame) return;
      const state = state_of(frame, character_frame);
      changed ||= this.shown_states[index] !== state;
      this.shown_states[index] = state;
      if (!entry) return;
      if (entry.pose) entry.member.place_poses(entry.pose, 0, entry.pose.length / 7);
      else entry.member.place(frame, character_frame);
    });
    if (!changed) return;
    this.shown_states.length = characters.length;
    this.report_states(Object.fromEntries(characters.map((character, index) => [character.id, this.shown_states[index]!])));
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
    this.dirty = true;
    return camera !== null;
  }

  private follow(frame: Frame | null): void {
    if (this.look_through(frame)) return;
    const { view, document, characters } = this.session.state;
    if (!view.follow || !frame) return this.rig.follow(null);
    const id = selected_character(this.session.state) ?? document?.camera?.follow ?? characters[0]?.id;
    const character_frame = frame.characters[characters.findIndex((c) => c.id === id)];
    if (!character_frame) return this.rig.follow(null);
    const [x, y, z] = centre_of_mass(frame, character_frame);
    this.rig.follow(new THREE.Vector3(x, y, z), id);
  }

  private draw_overlays(frame: Frame | null): void {
    const { state } = this.session;
    const { view, characters } = state;
    const selected = selected_character(state);
    this.ring.visible = false;
    this.crowd.show_shapes(view.shapes);
    let arrows = 0;
    characters.forEach((character, index) => {
      const entry = this.drawn.get(character.id);
      const character_frame = frame?.characters[index];
      if (!entry || !character_frame || !frame) return;
      const rate = state.document?.frame_rate ?? 60;
      const posed = this.pose_ghosts && (this.pose_ghosts.character === character.id ? this.pose_ghosts.poses : []);
      entry.times.show_ghosts(view.ghosts, this.session.frames, frame, index, rate, posed);
      const before = this.before();
      entry.times.show_before(before?.character === character.id ? pose_before(before.reply, frame.time) : null);
      entry.times.show_trail(view.trail, this.session.frames, frame, index, rate);
      if (!view.assist || !frame.simulate || !this.draw_assist(entry, frame, character_frame)) entry.assist.hide();
      if (selected === character.id) {
        const com = point_of_mass.set(...centre_of_mass(frame, character_frame)).add(entry.member.offset);
        const bounds = this.bounds(character.id);
        this.ring.scale.setScalar(Math.max(0.3, Math.min(0.5 * (bounds?.radius ?? 0.8), 0.62)));
        this.ring.position.set(com.x, com.y, (state.document?.ground?.height ?? 0) + 0.004);
        this.ring.visible = true;
      }
    });
    this.contact_discs.begin();
    this.normals.begin();
    if (view.contacts && frame) {
      const longest = Math.max(1, ...frame.characters.map((f) => body_weight(frame, f)));
      for (let i = 0; i < frame.contact_count && arrows < max_contact_arrows; i++) {
        const at = frame.contacts + 8 * i;
        const f = frame.floats;
        const force = new THREE.Vector3(f[at + 3], f[at + 4], f[at + 5]).multiplyScalar(0.9 / longest).clampLength(0, 1.6);
        if (force.lengthSq() < 1e-6) continue;
        const point = new THREE.Vector3(f[at], f[at + 1], f[at + 2]);
        const k = frame.normals + 3 * i;
        const normal = frame.normals < 0 ? force : new THREE.Vector3(f[k], f[k + 1], f[k + 2]);
        this.contact_discs.add(point, normal, 0.012 + 0.006 * Math.min(1, force.length()));
        if (frame.normals >= 0) this.normals.add(point, point.clone().addScaledVector(normal, 0.14));
        this.contact_arrows[arrows++]!.show(point, force);
      }
    }
    for (; arrows < max_contact_arrows; arrows++) this.contact_arrows[arrows]!.hide();
    this.normals.end();
    this.draw_closest_pairs(view.closest ? frame : null);
    this.draw_pull();
    this.draw_cameras(frame);
  }

  /** @return false: the force is too small to be shown */
  private draw_assist(entry: Drawn, frame: Frame, character_frame: CharacterFrame): boolean {
    const weight = body_weight(frame, character_frame);
    const force = force_of_assist.fromArray(frame.floats, character_frame.data);
    const share = weight > 0 ? force.length() / weight : 0;
    if (share <= 0.004 || !entry.member.root(start_of_assist)) return false;
    assist_color(assist_over_cap(frame, character_frame), entry.assist.material.color);
    // the length grows with the square root of the force: 1 % of the weight is visible (0.19 m), 100 % fits the view (1.9 m)
    entry.assist.show(start_of_assist, force.setLength(1.9 * Math.sqrt(Math.min(share, 1))));
    return true;
  }

  private draw_cameras(frame: Frame | null): void {
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

  private draw_closest_pairs(frame: Frame | null): void {
    this.closest_lines.begin();
    this.closest_pairs = [];
    for (let i = 0; frame && i < frame.closest_count; i++) {
      const at = frame.closest + 8 * i;
      const f = frame.floats;
      const a = new THREE.Vector3(f[at], f[at + 1], f[at + 2]);
      const b = new THREE.Vector3(f[at + 3], f[at + 4], f[at + 5]);
      const who = frame.words[at + 7]!;
      this.closest_lines.add(a, b);
      this.closest_pairs.push({ distance: f[at + 6]!, middle: a.clone().add(b).multiplyScalar(0.5), a: who >>> 16, b: who & 0xffff });
    }
    this.closest_lines.end();
  }

  private draw_pull(): void {
    const mesh = this.pull && this.drawn.get(this.pull.tag.character)?.member.links[this.pull.tag.link];
    if (!this.pull || !mesh) {
      this.spring.hide();
      return;
    }
    const from = this.pull.local.clone().applyMatrix4(mesh.matrixWorld);
    this.spring.show(from, this.pull.target, this.rig.camera, this.rig.current.distance * 0.0042);
  }
}
