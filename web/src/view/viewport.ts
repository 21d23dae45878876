/**
 * The viewport: draws the latest frame of the ring on each animation frame in which something changed, and turns the pointer into
 * orbiting, selecting, pulling and placing. Knows nothing of React.
 */
import * as THREE from 'three';
import { find_character } from '../core/document';
import { say_label } from '../core/format';
import { assist_force, assist_over_cap, body_weight, centre_of_mass, FigureState, type Frame } from '../core/frames';
import type { MechanismData } from '../core/protocol';
import type { Session } from '../core/session';
import { selected_character, shown_document, type StudioState } from '../core/state';
import { CameraRig } from './camera';
import { Figure, Ghost, mechanism_geometries, type LinkTag } from './figure';
import { Arrow, assist_color, ContactDiscs, make_ring, Polyline, Segments, Spring } from './overlays';
import { Stage } from './stage';

const ghost_offsets = [-0.8, -0.4, 0.4, 0.8]; // s
const trail_seconds = 4;
const max_contact_arrows = 48;

interface Drawn {
  figure: Figure;
  ghosts: Ghost[];
  assist: Arrow;
  trail: Polyline;
  /** Where the figure is drawn while its place is dragged, m from where the frames have it. */
  offset: THREE.Vector3;
}

export interface Pick extends LinkTag {
  point: THREE.Vector3;
}

/** What pages around the canvas draw from: called after each picture. */
export type DrawListener = (viewport: Viewport) => void;

export class Viewport {
  readonly rig = new CameraRig();
  readonly stage: Stage;
  private readonly drawn = new Map<string, Drawn>();
  private readonly geometries = new Map<string, (THREE.BufferGeometry | null)[]>();
  private readonly contact_arrows: Arrow[] = [];
  private readonly contact_discs = new ContactDiscs(max_contact_arrows);
  private readonly normals = new Segments(0x9adcf7, 1.6);
  private readonly nearest = new Segments(0x7dd3fc, 1.6);
  /** Pairs of nearest points as drawn now, the nearest first. */
  nearest_pairs: { distance: number; middle: THREE.Vector3; a: number; b: number }[] = [];
  private readonly spring = new Spring();
  private readonly ring = make_ring();
  private readonly raycaster = new THREE.Raycaster();
  private readonly listeners = new Set<DrawListener>();
  private readonly undo_subscriptions: (() => void)[] = [];
  private dirty = true;
  private still_since = 0;
  private drawn_still = false;
  private last_tick = 0;
  private handle = 0;
  private rect = { left: 0, top: 0, width: 1, height: 1 };
  private framed_once = false;
  private hovered: LinkTag | null = null;
  private pull: { tag: LinkTag; local: THREE.Vector3; target: THREE.Vector3 } | null = null;
  private shown_states = '';
  pictures = 0;

  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly session: Session,
    private readonly report_states: (states: Record<string, FigureState>) => void,
  ) {
    this.stage = new Stage(canvas);
    for (let i = 0; i < max_contact_arrows; i++) {
      const arrow = new Arrow(0xfdba74, 0.009);
      this.contact_arrows.push(arrow);
      this.stage.scene.add(arrow.group);
    }
    this.stage.scene.add(this.spring.group, this.ring, this.contact_discs.mesh, this.normals.lines, this.nearest.lines);
    this.undo_subscriptions.push(
      session.store.subscribe((state, before) => this.state_changed(state, before)),
      session.frames.on_frame(() => this.invalidate()),
    );
    this.state_changed(session.state, null);
    this.handle = requestAnimationFrame(this.tick);
  }

  dispose(): void {
    cancelAnimationFrame(this.handle);
    for (const undo of this.undo_subscriptions) undo();
    this.stage.dispose();
  }

  invalidate(): void {
    this.dirty = true;
  }

  on_draw(listener: DrawListener): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
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

  // ---- what is under the pointer ----

  pick(client_x: number, client_y: number): Pick | null {
    this.aim(client_x, client_y);
    const meshes: THREE.Object3D[] = [];
    for (const entry of this.drawn.values()) meshes.push(entry.figure.group);
    const hit = this.raycaster.intersectObjects(meshes, true)[0];
    return hit ? { ...(hit.object.userData as LinkTag), point: hit.point.clone() } : null;
  }

  /** Where the ray under the pointer meets a plane; null where it runs away from it. */
  on_plane(client_x: number, client_y: number, plane: THREE.Plane): THREE.Vector3 | null {
    this.aim(client_x, client_y);
    return this.raycaster.ray.intersectPlane(plane, new THREE.Vector3());
  }

  /** Plane through `point` that faces the camera. */
  facing_plane(point: THREE.Vector3): THREE.Plane {
    return new THREE.Plane().setFromNormalAndCoplanarPoint(this.rig.camera.getWorldDirection(new THREE.Vector3()).negate(), point);
  }

  /** Pixels in the page of a point of the world; null behind the eye. */
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

  hover(tag: LinkTag | null): void {
    if (this.hovered?.character === tag?.character && this.hovered?.link === tag?.link) return;
    this.hovered = tag;
    this.emphasise();
    this.invalidate();
  }

  /** Draws a pull from `local` (in the link's frame) to `target`; null: no pull. */
  show_pull(pull: { tag: LinkTag; local: THREE.Vector3; target: THREE.Vector3 } | null): void {
    this.pull = pull;
    this.emphasise();
    this.invalidate();
  }

  /** A point of the world in a link's frame. */
  to_link(tag: LinkTag, point: THREE.Vector3): THREE.Vector3 | null {
    const mesh = this.drawn.get(tag.character)?.figure.links[tag.link];
    if (!mesh) return null;
    mesh.updateWorldMatrix(true, false);
    return point.clone().applyMatrix4(mesh.matrixWorld.clone().invert());
  }

  /** Draws a character beside where its frames have it, until its next frame. */
  show_offset(character: string, offset: THREE.Vector3): void {
    this.drawn.get(character)?.offset.copy(offset);
    this.invalidate();
  }

  link_label(tag: LinkTag): string {
    const link = this.drawn.get(tag.character)?.figure.mechanism.links[tag.link];
    return say_label(link?.label || link?.name || '');
  }

  /** Spheres about the links of a figure (null: of all) as drawn now. */
  private spheres(character: string | null): THREE.Sphere[] {
    const out: THREE.Sphere[] = [];
    for (const [id, entry] of this.drawn) {
      if (character !== null && id !== character) continue;
      entry.figure.group.updateMatrixWorld(true);
      for (const mesh of entry.figure.links)
        if (mesh?.geometry.boundingSphere) out.push(mesh.geometry.boundingSphere.clone().applyMatrix4(mesh.matrixWorld));
    }
    return out;
  }

  /** The figure's bounds as drawn now; null where there is none. */
  bounds(character: string | null): THREE.Sphere | null {
    const box = new THREE.Box3();
    for (const s of this.spheres(character))
      box.expandByPoint(s.center.clone().addScalar(s.radius)).expandByPoint(s.center.clone().subScalar(s.radius));
    return box.isEmpty() ? null : box.getBoundingSphere(new THREE.Sphere());
  }

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

  /** Top of a figure, where its badge floats. */
  head(character: string): THREE.Vector3 | null {
    const sphere = this.bounds(character);
    return sphere ? sphere.center.clone().add(new THREE.Vector3(0, 0, sphere.radius + 0.06)) : null;
  }

  // ---- following the state ----

  private state_changed(state: StudioState, before: StudioState | null): void {
    if (!before || state.document !== before.document || state.preview !== before.preview || state.mechanisms !== before.mechanisms) {
      this.sync_figures(state);
    }
    if (!before || state.theme !== before.theme || state.document?.look !== before.document?.look) {
      this.stage.set_look({
        theme: state.theme,
        floor: state.document?.look?.floor ?? '#2a2c31',
        light: state.document?.look?.light ?? 0.9,
      });
    }
    if (!before || state.selection !== before.selection) this.emphasise();
    this.rig.use_perspective = state.view.perspective;
    this.invalidate();
  }

  private sync_figures(state: StudioState): void {
    const doc = shown_document(state);
    const wanted = new Map<string, MechanismData>();
    for (const character of doc?.characters ?? []) {
      const mechanism = state.mechanisms[character.mechanism];
      if (mechanism) wanted.set(character.id, mechanism);
    }
    for (const [id, entry] of this.drawn) {
      if (wanted.get(id) === entry.figure.mechanism) continue;
      this.remove(entry);
      this.drawn.delete(id);
    }
    for (const [id, mechanism] of wanted) {
      const color = (doc && find_character(doc, id)?.color) || '#e6e6ea';
      const entry = this.drawn.get(id);
      if (entry) entry.figure.set_color(color);
      else this.drawn.set(id, this.add(id, mechanism, color));
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
      figure: new Figure(id, mechanism, geometries, color),
      ghosts: ghost_offsets.map((_offset, index) => new Ghost(geometries, index)),
      assist: new Arrow(0x34d399, 0.011, true),
      trail: new Polyline(0xff9d5c, 1.6, 0.8),
      offset: new THREE.Vector3(),
    };
    this.stage.scene.add(entry.figure.group, entry.assist.group, entry.trail.line, ...entry.ghosts.map((g) => g.group));
    return entry;
  }

  private remove(entry: Drawn): void {
    this.stage.scene.remove(entry.figure.group, entry.assist.group, entry.trail.line, ...entry.ghosts.map((g) => g.group));
    entry.figure.dispose();
    for (const ghost of entry.ghosts) ghost.dispose();
  }

  private emphasise(): void {
    const { selection } = this.session.state;
    for (const [id, entry] of this.drawn) {
      entry.figure.links.forEach((_mesh, link) => {
        const pulled = this.pull?.tag.character === id && this.pull.tag.link === link;
        const selected = selection.kind === 'character' && selection.character === id && selection.link === link;
        const hovered = this.hovered?.character === id && this.hovered.link === link;
        entry.figure.emphasise(link, pulled ? 'pulled' : hovered ? 'hover' : selected ? 'selected' : 'none');
      });
    }
  }

  // ---- drawing ----

  private readonly tick = (now: number): void => {
    this.handle = requestAnimationFrame(this.tick);
    if (!this.stage.free) return;
    const dt = Math.min(0.4, Math.max(0.001, (now - this.last_tick) / 1000));
    this.last_tick = now;
    if (this.rect.width <= 2) return;
    const frame = this.session.frames.latest;
    if (this.dirty && frame) this.place_figures(frame);
    this.follow(frame);
    if (this.rig.update(dt)) this.dirty = true;
    if (!this.dirty) {
      // moving pictures are drawn coarser on slow machines; one fine picture follows when all is still
      if (!this.drawn_still && now - this.still_since > 180) this.draw(frame, true);
      return;
    }
    if (this.still_since > 0 && now - this.still_since < 200) this.stage.note_frame_time(dt * 1000);
    this.still_since = now;
    this.dirty = false;
    this.draw(frame, false);
  };

  private draw(frame: Frame | null, still: boolean): void {
    this.drawn_still = still;
    this.draw_overlays(frame);
    const { target, distance } = this.rig.current;
    const all = this.bounds(null);
    const spread = all ? all.radius + target.distanceTo(all.center) + 0.5 : 3;
    this.stage.focus(target, Math.min(spread, Math.max(2.6, distance * 0.85)), distance);
    this.stage.render(this.rig.camera, still);
    this.pictures++;
    if (!this.framed_once && frame && this.drawn.size > 0 && this.drawn.size >= (this.session.state.document?.characters.length ?? 0)) this.first_view();
    for (const listener of this.listeners) listener(this);
  }

  private first_view(): void {
    this.framed_once = true;
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

  private place_figures(frame: Frame): void {
    const states: Record<string, FigureState> = {};
    this.session.state.characters.forEach((character, index) => {
      const entry = this.drawn.get(character.id);
      const figure = frame.figures[index];
      if (!figure) return;
      states[character.id] = figure.state;
      if (!entry) return;
      entry.figure.place(frame, figure);
      entry.figure.group.position.copy(entry.offset);
      entry.figure.group.updateMatrixWorld(true);
    });
    const text = JSON.stringify(states);
    if (text !== this.shown_states) {
      this.shown_states = text;
      this.report_states(states);
    }
  }

  private follow(frame: Frame | null): void {
    const { view, document, characters } = this.session.state;
    if (!view.follow || !frame) return this.rig.follow(null);
    const id = selected_character(this.session.state) ?? document?.camera?.follow ?? characters[0]?.id;
    const figure = frame.figures[characters.findIndex((c) => c.id === id)];
    if (!figure) return this.rig.follow(null);
    const [x, y, z] = centre_of_mass(frame, figure);
    this.rig.follow(new THREE.Vector3(x, y, z));
  }

  private draw_overlays(frame: Frame | null): void {
    const { state } = this.session;
    const { view, characters } = state;
    const selected = selected_character(state);
    this.ring.visible = false;
    let arrows = 0;
    characters.forEach((character, index) => {
      const entry = this.drawn.get(character.id);
      const figure = frame?.figures[index];
      if (!entry || !figure || !frame) return;
      const com = new THREE.Vector3(...centre_of_mass(frame, figure)).add(entry.offset);
      this.draw_ghosts(entry, index, frame, view.ghosts);
      if (view.trail) this.draw_trail(entry, index, frame);
      else entry.trail.hide();
      const weight = body_weight(frame, figure);
      const force = new THREE.Vector3(...assist_force(frame, figure));
      const share = weight > 0 ? force.length() / weight : 0;
      if (view.assist && frame.simulate && share > 0.004) {
        const at = new THREE.Vector3().setFromMatrixPosition(entry.figure.links.find((m) => m)?.matrixWorld ?? new THREE.Matrix4());
        entry.assist.material.color.copy(assist_color(assist_over_cap(frame, figure)));
        // a root scale: 1 % of weight is seen, 50 % does not leave the picture
        entry.assist.show(at, force.setLength(1.9 * Math.sqrt(Math.min(share, 1))));
      } else {
        entry.assist.hide();
      }
      if (selected === character.id) {
        const bounds = this.bounds(character.id);
        this.ring.scale.setScalar(Math.max(0.3, Math.min(0.5 * (bounds?.radius ?? 0.8), 0.62)));
        this.ring.position.set(com.x, com.y, (state.document?.ground?.height ?? 0) + 0.004);
        this.ring.visible = true;
      }
    });
    this.contact_discs.begin();
    this.normals.begin();
    if (view.contacts && frame) {
      const longest = Math.max(1, ...frame.figures.map((f) => body_weight(frame, f)));
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
    this.draw_nearest(view.nearest ? frame : null);
    this.draw_pull();
  }

  private draw_nearest(frame: Frame | null): void {
    this.nearest.begin();
    this.nearest_pairs = [];
    for (let i = 0; frame && i < frame.nearest_count; i++) {
      const at = frame.nearest + 8 * i;
      const f = frame.floats;
      const a = new THREE.Vector3(f[at], f[at + 1], f[at + 2]);
      const b = new THREE.Vector3(f[at + 3], f[at + 4], f[at + 5]);
      const who = frame.words[at + 7]!;
      this.nearest.add(a, b);
      this.nearest_pairs.push({ distance: f[at + 6]!, middle: a.clone().add(b).multiplyScalar(0.5), a: who >>> 16, b: who & 0xffff });
    }
    this.nearest.end();
  }

  private draw_pull(): void {
    const mesh = this.pull && this.drawn.get(this.pull.tag.character)?.figure.links[this.pull.tag.link];
    if (!this.pull || !mesh) {
      this.spring.hide();
      return;
    }
    mesh.updateWorldMatrix(true, false);
    const from = this.pull.local.clone().applyMatrix4(mesh.matrixWorld);
    this.spring.show(from, this.pull.target, this.rig.camera, this.rig.current.distance * 0.0042);
  }

  private draw_ghosts(entry: Drawn, index: number, frame: Frame, on: boolean): void {
    const rate = this.session.state.document?.frame_rate ?? 60;
    ghost_offsets.forEach((seconds, i) => {
      const ghost = entry.ghosts[i]!;
      const other = on ? this.session.frames.near(frame.number + Math.round(seconds * rate), 2) : undefined;
      const figure = other?.figures[index];
      if (other && figure && figure.links === frame.figures[index]?.links) ghost.show(other, figure, Math.abs(seconds) > 0.5 ? 0.13 : 0.22);
      else ghost.hide();
    });
  }

  private draw_trail(entry: Drawn, index: number, frame: Frame): void {
    const rate = this.session.state.document?.frame_rate ?? 60;
    const points: number[] = [];
    const first = Math.max(0, frame.number - Math.round(trail_seconds * rate));
    for (let n = first; n <= frame.number; n++) {
      const other = this.session.frames.at(n);
      const figure = other?.figures[index];
      if (other && figure) points.push(...centre_of_mass(other, figure));
    }
    entry.trail.show(points);
  }
}
