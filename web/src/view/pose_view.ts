/** Posing in the viewport: the gizmo of the selected joint, drags of links, and the drawing of poses that are not in the frames yet. */
import * as THREE from 'three';
import type { Poser } from '../core/posing/poser';
import type { PoseEdit, PoseReply, Vec3 } from '../core/protocol';
import type { LinkTag } from './character_view';
import { PoseGizmo, type GizmoLabel } from './pose_gizmo';
import type { Viewport } from './viewport';

const ring_reach = 9; // px, maximum distance between the pointer and an arc that is picked
const gizmo_size = 0.085; // radius of the gizmo relative to the distance of the camera
const min_radius = 0.1; // m, so that the arcs stay outside of a limb
const coarse = (5 * Math.PI) / 180; // rad, steps while Ctrl is held
const edge_on = 0.2; // |cosine| between view and axis below which the pointer's motion along the arc is measured on the screen

type Drag =
  | { kind: 'turn'; dof: number; relative: boolean; link: number; start: number; angle: number; last: number; ring: NonNullable<ReturnType<PoseGizmo['ring_of']>>; x: number; y: number; tangent: { x: number; y: number } | null }
  | { kind: 'reach'; link: number; point: Vec3; plane: THREE.Plane; grabbed: THREE.Vector3; begun: boolean };

const pose_at = (reply: PoseReply, link: number): { origin: THREE.Vector3; rotation: THREE.Quaternion } => {
  const p = reply.links.slice(7 * link, 7 * link + 7);
  return { origin: new THREE.Vector3(p[0], p[1], p[2]), rotation: new THREE.Quaternion(p[4], p[5], p[6], p[3]) };
};
const to_vec3 = (v: THREE.Vector3): Vec3 => [v.x, v.y, v.z];

export class PoseView {
  readonly gizmo = new PoseGizmo();
  private drag: Drag | null = null;
  /** Digits typed while a joint is turned; they set its angle. */
  private typed = '';
  private readonly undo: (() => void)[] = [];

  constructor(private readonly viewport: Viewport, private readonly poser: Poser) {
    viewport.stage.scene.add(this.gizmo.group);
    this.undo.push(
      poser.store.subscribe((state, before) => {
        if (state.shown !== before.shown) viewport.show_pose(state.shown);
        if (state.ghosts !== before.ghosts) viewport.show_pose_ghosts(state.ghosts);
        viewport.invalidate();
      }),
      viewport.before_draw(() => this.place_gizmo()),
    );
    window.addEventListener('keydown', this.key, true);
  }

  dispose(): void {
    window.removeEventListener('keydown', this.key, true);
    for (const stop of this.undo) stop();
    this.viewport.stage.scene.remove(this.gizmo.group);
    this.gizmo.dispose();
  }

  get on(): boolean {
    return this.poser.state.on;
  }

  /** The link whose joint is posed; null: none. */
  get link(): number | null {
    const { target } = this.poser.state;
    const { selection } = this.viewport.session.state;
    return target && selection.kind === 'character' && selection.character === target.character ? (selection.link ?? null) : null;
  }

  labels(): GizmoLabel[] {
    return this.poser.state.on ? this.gizmo.labels() : [];
  }

  private place_gizmo(): void {
    const { target, reply, on } = this.poser.state;
    const { link } = this;
    const facts = target && link !== null ? this.poser.joints_of(target.character)?.[link] : undefined;
    if (!on || !target || !reply || link === null || !facts || this.drag?.kind === 'reach') return this.gizmo.show(null, 1);
    const { origin, rotation } = pose_at(reply, link);
    const mechanism = this.viewport.mechanism_of(target.character);
    const child = mechanism?.links.findIndex((l) => l.parent === link) ?? -1;
    const shape = mechanism?.links[link]?.shapes[0]?.pose;
    const bone = child >= 0 ? pose_at(reply, child).origin.sub(origin) : shape ? new THREE.Vector3(shape[0], shape[1], shape[2]).applyQuaternion(rotation) : new THREE.Vector3();
    if (bone.lengthSq() < 1e-8) bone.set(0, 0, 1).applyQuaternion(rotation);
    this.gizmo.show({ facts, angles: reply.angles[link] ?? [], origin, rotation, bone }, Math.max(min_radius, gizmo_size * this.viewport.rig.current.distance));
  }

  // ---- pointer ----

  /** A press of the main button. @param pick the link under the pointer @return whether posing takes the gesture */
  down(event: PointerEvent, pick: (LinkTag & { point: THREE.Vector3 }) | null): boolean {
    const { on, target, reply } = this.poser.state;
    if (!on) return false;
    const dof = this.gizmo.pick(event.clientX, event.clientY, ring_reach, (p) => this.viewport.to_client(p));
    if (dof !== null && target && reply && this.link !== null) return this.begin_turn(event, dof);
    if (!pick || !target || pick.character !== target.character) return false;
    return this.begin_reach(pick.link, pick.point);
  }

  /** Begins a drag of a link at a world point. The drag has an effect after the pointer has moved. */
  begin_reach(link: number, point: THREE.Vector3): boolean {
    const { reply } = this.poser.state;
    if (!reply) return false;
    const { origin, rotation } = pose_at(reply, link);
    const local = point.clone().sub(origin).applyQuaternion(rotation.invert());
    this.drag = { kind: 'reach', link, point: to_vec3(local), plane: this.viewport.facing_plane(point), grabbed: point.clone(), begun: false };
    return true;
  }

  private begin_turn(event: PointerEvent, dof: number): boolean {
    const { target, reply } = this.poser.state;
    const { link } = this;
    const ring = this.gizmo.ring_of(dof);
    if (!target || !reply || link === null || !ring || !this.poser.begin()) return false;
    const view = this.viewport.rig.camera.getWorldDirection(new THREE.Vector3());
    let tangent: { x: number; y: number } | null = null;
    if (Math.abs(view.dot(ring.axis)) < edge_on) {
      const at = ring.origin.clone().addScaledVector(ring.u, ring.radius);
      const a = this.viewport.to_client(at);
      const b = this.viewport.to_client(at.clone().addScaledVector(ring.v, ring.radius * 0.05));
      if (a && b) tangent = { x: (b.x - a.x) / 0.05, y: (b.y - a.y) / 0.05 };
    }
    const relative = ['spherical', 'floating'].includes(this.poser.joints_of(target.character)![link]!.type);
    this.typed = '';
    this.gizmo.active = dof;
    const drag: Drag = { kind: 'turn', dof, relative, link, start: reply.angles[link]?.[dof] ?? 0, angle: 0, last: 0, ring, x: event.clientX, y: event.clientY, tangent };
    drag.last = this.angle_of(drag, event) ?? 0;
    this.drag = drag;
    return true;
  }

  /** Angle of the pointer on the plane of the arc, rad. */
  private angle_of(drag: Extract<Drag, { kind: 'turn' }>, event: PointerEvent): number | null {
    if (drag.tangent) {
      const { x, y } = drag.tangent;
      return ((event.clientX - drag.x) * x + (event.clientY - drag.y) * y) / (x * x + y * y);
    }
    const at = this.viewport.on_plane(event.clientX, event.clientY, new THREE.Plane().setFromNormalAndCoplanarPoint(drag.ring.axis, drag.ring.origin));
    if (!at) return null;
    at.sub(drag.ring.origin);
    return Math.atan2(at.dot(drag.ring.v), at.dot(drag.ring.u));
  }

  move(event: PointerEvent): void {
    const { drag } = this;
    if (drag?.kind === 'turn') {
      const angle = this.angle_of(drag, event);
      if (angle === null || this.typed !== '') return;
      const step = drag.tangent ? angle - drag.last : Math.atan2(Math.sin(angle - drag.last), Math.cos(angle - drag.last));
      drag.last = angle;
      drag.angle += step * (event.shiftKey ? 0.1 : 1);
      this.turn(drag, event.ctrlKey || event.metaKey, event.altKey);
    } else if (drag?.kind === 'reach') {
      if (!drag.begun && !(drag.begun = this.poser.begin())) {
        this.drag = null;
        return;
      }
      const at = this.viewport.on_plane(event.clientX, event.clientY, drag.plane);
      if (!at) return;
      const target = event.shiftKey ? drag.grabbed.clone().lerp(at, 0.1) : at;
      this.poser.drag({ type: 'reach', link: drag.link, point: drag.point, target: to_vec3(target), moves: this.poser.state.moves }, event.altKey);
    }
  }

  private turn(drag: Extract<Drag, { kind: 'turn' }>, steps: boolean, free: boolean): void {
    const value = drag.relative ? drag.angle : drag.start + drag.angle;
    this.poser.drag(this.turn_edit(drag, steps ? Math.round(value / coarse) * coarse : value), free);
  }
  private turn_edit(drag: Extract<Drag, { kind: 'turn' }>, value: number): PoseEdit {
    if (!drag.relative) return { type: 'set', link: drag.link, dof: drag.dof, value };
    const axis: Vec3 = [0, 0, 0];
    axis[drag.dof % 3] = 1;
    return { type: 'turn', link: drag.link, axis, angle: value };
  }

  /** @return the link that was pressed and not dragged, to be selected; null: none */
  up(): number | null {
    const { drag } = this;
    this.drag = null;
    this.gizmo.active = null;
    this.viewport.invalidate();
    if (!drag) return null;
    if (drag.kind === 'reach' && !drag.begun) return drag.link;
    const label = this.viewport.link_label({ character: this.poser.state.target?.character ?? '', link: drag.link });
    void this.poser.finish(`${drag.kind === 'turn' ? 'Rotate' : 'Move'} ${label}`);
    return null;
  }

  cancel(): void {
    this.drag = null;
    this.gizmo.active = null;
    this.poser.cancel();
  }

  /** Highlights the arc under the pointer. @return whether there is one */
  hover(event: PointerEvent): boolean {
    const dof = this.poser.state.on && this.poser.state.target ? this.gizmo.pick(event.clientX, event.clientY, ring_reach, (p) => this.viewport.to_client(p)) : null;
    if (dof !== this.gizmo.active) {
      this.gizmo.active = dof;
      this.viewport.invalidate();
    }
    return dof !== null;
  }

  /** Digits typed during a turn set the angle in degrees; Enter ends the drag. */
  private readonly key = (event: KeyboardEvent): void => {
    const { drag } = this;
    if (drag?.kind !== 'turn' || !(/^[0-9.-]$/.test(event.key) || event.key === 'Backspace' || event.key === 'Enter')) return;
    event.preventDefault();
    event.stopPropagation();
    if (event.key === 'Enter') {
      this.up();
      return;
    }
    this.typed = event.key === 'Backspace' ? this.typed.slice(0, -1) : this.typed + event.key;
    const value = Number(this.typed);
    if (this.typed !== '' && Number.isFinite(value)) this.poser.drag(this.turn_edit(drag, (value * Math.PI) / 180), event.altKey);
  };
}
