/**
 * Mouse and touch gestures on the picture. A drag that begins on a character, with one finger or the left button, pulls or pushes the
 * character; Shift swaps pull and push. A drag that begins beside the characters turns the view. Two fingers pan and zoom, the wheel zooms,
 * and the right or middle button pans.
 */
import * as THREE from 'three';
import type { Vec3 } from '../core/protocol';
import type { Engine } from './engine';
import type { Hit, SceneView } from './scene_view';

export type Tool = 'pull' | 'push';

/** Force of a push divided by the arrow's length and the character's weight, 1/m. An arrow of 1 m on a person of 70 kg pushes with 480 N
 * for push_time, enough to make the person step. */
const push_gain = 0.7;
const push_time = 0.2; // s
const max_arrow = 2.5; // m
const mouse_reach = 10; // px: distance from the pointer up to which a character is found
const touch_reach = 22;

type Gesture =
  | { kind: 'orbit' | 'pan' }
  | { kind: 'pull'; hit: Hit; local: THREE.Vector3 }
  | { kind: 'push'; hit: Hit; local: THREE.Vector3; along: THREE.Vector3 };

export interface GestureHost {
  readonly view: SceneView;
  readonly engine: Engine;
  readonly tool: Tool;
  /** True while the user may act on characters, that is, while the content plays. */
  readonly live: boolean;
  /** Weight of a character, N. */
  weight(character: number): number;
  /** Requests a new picture. */
  invalidate(): void;
  /** Shows a short text beside the pointer; empty: none. @param x, y px from the top left corner */
  label(text: string, x: number, y: number): void;
}

export class Gestures {
  private gesture: Gesture | null = null;
  private readonly pointers = new Map<number, { x: number; y: number }>();
  private acting = -1; // id of the pointer that began the gesture

  constructor(private readonly canvas: HTMLCanvasElement, private readonly host: GestureHost) {
    canvas.addEventListener('pointerdown', this.down);
    canvas.addEventListener('pointermove', this.move);
    canvas.addEventListener('pointerup', this.up);
    canvas.addEventListener('pointercancel', this.cancel);
    canvas.addEventListener('pointerleave', this.leave);
    canvas.addEventListener('wheel', this.wheel, { passive: false });
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  }

  /** Ends the current gesture without a push. */
  abandon(): void {
    if (this.gesture?.kind === 'pull') this.host.engine.release();
    this.finish();
  }

  /** Keeps the target of a pull under the pointer while the camera moves. */
  follow(): void {
    const at = this.pointers.get(this.acting);
    if (this.gesture?.kind === 'pull' && at) this.drag(this.gesture, at);
  }

  private position(event: PointerEvent): { x: number; y: number } {
    const box = this.canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  private readonly down = (event: PointerEvent): void => {
    const at = this.position(event);
    const { view, engine, live, tool } = this.host;
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, at);
    if (this.pointers.size === 2 && this.gesture?.kind !== 'pull' && this.gesture?.kind !== 'push') {
      this.gesture = { kind: 'pan' };
      return;
    }
    if (this.gesture) return;
    this.acting = event.pointerId;
    if (event.button === 1 || event.button === 2) {
      this.gesture = { kind: 'pan' };
      return;
    }
    const hit = live ? view.pick(at.x, at.y, event.pointerType === 'touch' ? touch_reach : mouse_reach) : null;
    if (!hit) {
      this.gesture = { kind: 'orbit' };
      return;
    }
    const local = view.to_link(hit);
    const push = (tool === 'push') !== event.shiftKey;
    if (push) {
      this.gesture = { kind: 'push', hit, local, along: new THREE.Vector3() };
    } else {
      this.gesture = { kind: 'pull', hit, local };
      engine.grab(hit.character, hit.link, local.toArray() as Vec3, hit.point.toArray() as Vec3);
      view.pull = { hit, local, target: hit.point.clone() };
    }
    view.emphasise(hit, 'pulled');
    this.canvas.style.cursor = 'grabbing';
    this.host.invalidate();
  };

  private readonly move = (event: PointerEvent): void => {
    const at = this.position(event);
    const before = this.pointers.get(event.pointerId);
    if (!before) return this.hover(event, at);
    const dx = at.x - before.x;
    const dy = at.y - before.y;
    const { view } = this.host;
    if (this.pointers.size >= 2 && this.gesture?.kind === 'pan') {
      const [a, b] = [...this.pointers.values()] as [{ x: number; y: number }, { x: number; y: number }];
      const gap = Math.hypot(a.x - b.x, a.y - b.y);
      this.pointers.set(event.pointerId, at);
      const [c, d] = [...this.pointers.values()] as [{ x: number; y: number }, { x: number; y: number }];
      const now = Math.hypot(c.x - d.x, c.y - d.y);
      view.rig.pan(dx / 2, dy / 2, view.view_height);
      if (gap > 8 && now > 8) view.rig.zoom(gap / now);
      return this.host.invalidate();
    }
    this.pointers.set(event.pointerId, at);
    if (event.pointerId !== this.acting) return;
    switch (this.gesture?.kind) {
      case 'orbit':
        view.rig.orbit(dx, dy);
        break;
      case 'pan':
        view.rig.pan(dx, dy, view.view_height);
        break;
      case 'pull':
        this.drag(this.gesture, at);
        break;
      case 'push':
        this.aim(this.gesture, at);
        break;
    }
    this.host.invalidate();
  };

  private drag(gesture: Extract<Gesture, { kind: 'pull' }>, at: { x: number; y: number }): void {
    const { view, engine } = this.host;
    const target = view.on_facing_plane(at.x, at.y, view.point_of(gesture.hit, gesture.local));
    if (!target) return;
    target.z = Math.max(view.scene.ground.height + 0.02, target.z);
    view.pull = { hit: gesture.hit, local: gesture.local, target };
    engine.drag(target.toArray() as Vec3);
  }

  private aim(gesture: Extract<Gesture, { kind: 'push' }>, at: { x: number; y: number }): void {
    const { view } = this.host;
    const from = view.point_of(gesture.hit, gesture.local);
    const to = view.on_facing_plane(at.x, at.y, from);
    if (!to) return;
    gesture.along.copy(to).sub(from).clampLength(0, max_arrow);
    view.aim = { hit: gesture.hit, local: gesture.local, along: gesture.along };
    this.host.label(`${Math.round(this.force(gesture).length())} N`, at.x, at.y);
  }

  private force(gesture: Extract<Gesture, { kind: 'push' }>): THREE.Vector3 {
    return gesture.along.clone().multiplyScalar(push_gain * this.host.weight(gesture.hit.character));
  }

  private readonly up = (event: PointerEvent): void => {
    this.pointers.delete(event.pointerId);
    if (this.canvas.hasPointerCapture(event.pointerId)) this.canvas.releasePointerCapture(event.pointerId);
    if (event.pointerId !== this.acting) {
      if (this.gesture?.kind === 'pan') this.finish();
      return;
    }
    const { engine } = this.host;
    const gesture = this.gesture;
    if (gesture?.kind === 'pull') engine.release();
    if (gesture?.kind === 'push' && gesture.along.length() > 0.02) {
      engine.push(gesture.hit.character, gesture.hit.link, this.force(gesture).toArray() as Vec3, push_time);
    }
    this.finish();
  };

  private readonly cancel = (event: PointerEvent): void => {
    this.pointers.delete(event.pointerId);
    if (event.pointerId === this.acting) this.abandon();
  };

  private readonly leave = (event: PointerEvent): void => {
    if (this.gesture || event.pointerType === 'touch') return;
    this.host.view.emphasise(null, 'hover');
    this.host.label('', 0, 0);
    this.host.invalidate();
  };

  private finish(): void {
    const { view } = this.host;
    this.gesture = null;
    this.acting = -1;
    view.pull = view.aim = null;
    view.emphasise(null, 'hover');
    this.host.label('', 0, 0);
    this.canvas.style.cursor = 'grab';
    this.host.invalidate();
  }

  private hover(event: PointerEvent, at: { x: number; y: number }): void {
    if (event.pointerType === 'touch' || !this.host.live) return;
    const hit = this.host.view.pick(at.x, at.y, mouse_reach);
    this.host.view.emphasise(hit, 'hover');
    this.canvas.style.cursor = hit ? 'pointer' : 'grab';
    this.host.invalidate();
  }

  private readonly wheel = (event: WheelEvent): void => {
    event.preventDefault();
    this.host.view.rig.zoom(Math.exp(Math.max(-120, Math.min(120, event.deltaY)) * 0.0016));
    this.host.invalidate();
  };
}
