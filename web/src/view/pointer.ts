/** Pointer and wheel on the viewport: orbit, pan, zoom, select; pull while the simulation runs, place characters in edit mode. */
import * as THREE from 'three';
import { find_character } from '../core/document';
import { pointer_action } from '../core/keymap';
import { find_instance, instance_of, selection_of_character } from '../core/nested';
import type { Vec3 } from '../core/protocol';
import { selected_character } from '../core/state';
import type { LinkTag } from './character_view';
import type { PoseView } from './pose_view';
import type { Viewport } from './viewport';

const click_px = 4; // pointer travel, px, below which a press is a click

type Gesture =
  | { kind: 'orbit' | 'pan' | 'zoom'; empty: boolean }
  | { kind: 'press'; tag: LinkTag; point: THREE.Vector3 }
  | { kind: 'pose' }
  | { kind: 'place'; character: string; from: THREE.Vector3; plane: THREE.Plane; delta: THREE.Vector3 }
  | { kind: 'pull'; tag: LinkTag; local: THREE.Vector3; plane: THREE.Plane };

export class PointerControl {
  private gesture: Gesture | null = null;
  private start = { x: 0, y: 0 };
  private last = { x: 0, y: 0 };
  private moved = false;
  private cursor: { x: number; y: number } | null = null;
  private readonly stop_drawing: () => void;
  /** Takes presses on the posed character; null: nothing is posed. */
  posing: PoseView | null = null;
  /** Takes clicks on the floor (world, m) while a path is drawn. @return whether it took the click */
  on_floor: (x: number, y: number) => boolean = () => false;
  /** Called with the text to show beside the cursor (empty: none) and the position on the page, px. */
  on_label: (text: string, x: number, y: number) => void = () => undefined;

  constructor(private readonly viewport: Viewport) {
    const { canvas } = viewport;
    canvas.addEventListener('pointerdown', this.down);
    canvas.addEventListener('pointermove', this.move);
    canvas.addEventListener('pointerup', this.up);
    canvas.addEventListener('pointercancel', this.cancel);
    canvas.addEventListener('pointerleave', this.leave);
    canvas.addEventListener('wheel', this.wheel, { passive: false });
    canvas.addEventListener('contextmenu', prevent);
    this.stop_drawing = viewport.on_draw(() => this.follow_pull());
  }

  dispose(): void {
    const { canvas } = this.viewport;
    canvas.removeEventListener('pointerdown', this.down);
    canvas.removeEventListener('pointermove', this.move);
    canvas.removeEventListener('pointerup', this.up);
    canvas.removeEventListener('pointercancel', this.cancel);
    canvas.removeEventListener('pointerleave', this.leave);
    canvas.removeEventListener('wheel', this.wheel);
    canvas.removeEventListener('contextmenu', prevent);
    this.stop_drawing();
  }

  /** Cancels the current gesture (Escape key). @return whether there was one */
  abandon(): boolean {
    const gesture = this.gesture;
    if (!gesture) return false;
    this.gesture = null;
    if (gesture.kind === 'pull') this.release();
    if (gesture.kind === 'place') this.show_offset(gesture.character, new THREE.Vector3());
    if (gesture.kind === 'pose') this.posing?.cancel();
    return true;
  }

  private readonly down = (event: PointerEvent): void => {
    if (this.gesture) return;
    const { viewport } = this;
    const { session } = viewport;
    viewport.canvas.focus({ preventScroll: true });
    viewport.canvas.setPointerCapture(event.pointerId);
    this.start = this.last = { x: event.clientX, y: event.clientY };
    this.moved = false;
    const action = pointer_action(session.state.keymap, event.button, event);
    if (action === 'none') return;
    if (action !== 'select_or_orbit') {
      this.gesture = { kind: action, empty: false };
      return;
    }
    const pick = viewport.pick(event.clientX, event.clientY);
    if (this.posing?.down(event, pick)) {
      this.gesture = { kind: 'pose' };
      return;
    }
    if (!pick) {
      this.gesture = { kind: 'orbit', empty: true };
      return;
    }
    const tag: LinkTag = { character: pick.character, link: pick.link };
    const { mode, playing } = session.state.transport;
    const local = mode === 'simulate' && playing ? viewport.to_link(tag, pick.point) : null;
    if (local) {
      this.gesture = { kind: 'pull', tag, local, plane: viewport.facing_plane(pick.point) };
      session.grab(tag.character, tag.link, to_vec3(local), to_vec3(pick.point));
      session.select(selection_of_character(tag.character, tag.link));
      viewport.show_pull({ tag, local, target: pick.point.clone() });
      viewport.canvas.style.cursor = 'grabbing';
      return;
    }
    this.gesture = { kind: 'press', tag, point: pick.point };
  };

  private readonly move = (event: PointerEvent): void => {
    this.cursor = { x: event.clientX, y: event.clientY };
    const dx = event.clientX - this.last.x;
    const dy = event.clientY - this.last.y;
    const gesture = this.gesture;
    if (!gesture) {
      this.hover(event);
      return;
    }
    this.last = { x: event.clientX, y: event.clientY };
    if (!this.moved && Math.hypot(event.clientX - this.start.x, event.clientY - this.start.y) < click_px) return;
    this.moved = true;
    this.on_label('', 0, 0);
    const { viewport } = this;
    switch (gesture.kind) {
      case 'orbit':
        viewport.rig.orbit(dx, dy);
        break;
      case 'pan':
        viewport.rig.pan(dx, dy, viewport.size.height);
        break;
      case 'zoom':
        viewport.rig.zoom(Math.exp((dy - dx) * 0.006));
        break;
      case 'pose':
        this.posing?.move(event);
        break;
      case 'press':
        this.begin_place(gesture.tag, gesture.point);
        break;
      case 'place':
        this.drag_place(gesture, event);
        break;
      case 'pull':
        this.drag_pull(gesture);
        break;
    }
    viewport.invalidate();
  };

  private readonly up = (event: PointerEvent): void => {
    const gesture = this.gesture;
    this.gesture = null;
    if (!gesture) return;
    const { viewport } = this;
    const { session } = viewport;
    if (viewport.canvas.hasPointerCapture(event.pointerId)) viewport.canvas.releasePointerCapture(event.pointerId);
    if (!this.moved && (gesture.kind === 'press' || (gesture.kind === 'orbit' && gesture.empty)) && this.take_floor(event)) return;
    if (gesture.kind === 'pull') this.release();
    else if (gesture.kind === 'place') this.end_place(gesture);
    else if (gesture.kind === 'pose') {
      const link = this.posing?.up();
      const character = selected_character(session.state);
      if (character && typeof link === 'number') session.select({ kind: 'character', character, link });
    } else if (gesture.kind === 'press' && !this.moved) {
      session.select(selection_of_character(gesture.tag.character, gesture.tag.link));
    } else if ((gesture.kind === 'orbit' || gesture.kind === 'pan') && gesture.kind === 'orbit' && gesture.empty && !this.moved) {
      session.select({ kind: 'none' });
    }
  };

  /** Gives a click on the floor to on_floor. */
  private take_floor(event: PointerEvent): boolean {
    const at = this.viewport.on_plane(event.clientX, event.clientY, new THREE.Plane(new THREE.Vector3(0, 0, 1), 0));
    return at !== null && at.length() < 500 && this.on_floor(at.x, at.y);
  }

  private readonly cancel = (): void => {
    this.abandon();
  };

  private readonly leave = (): void => {
    if (this.gesture) return;
    this.cursor = null;
    this.viewport.hover(null);
    this.on_label('', 0, 0);
  };

  private readonly wheel = (event: WheelEvent): void => {
    event.preventDefault();
    this.viewport.rig.zoom(Math.exp(Math.max(-120, Math.min(120, event.deltaY)) * 0.0016));
    this.viewport.invalidate();
  };

  private hover(event: PointerEvent): void {
    if (event.pointerType === 'touch') return;
    const { viewport } = this;
    if (this.posing?.hover(event)) {
      viewport.hover(null);
      viewport.canvas.style.cursor = 'grab';
      this.on_label('', 0, 0);
      return;
    }
    const pick = viewport.pick(event.clientX, event.clientY);
    viewport.hover(pick);
    const { mode, playing } = viewport.session.state.transport;
    viewport.canvas.style.cursor = pick ? (mode === 'simulate' && playing ? 'grab' : 'pointer') : 'default';
    this.on_label(pick ? viewport.link_label(pick) : '', event.clientX, event.clientY);
  }

  // ---- pulling ----

  private drag_pull(gesture: Extract<Gesture, { kind: 'pull' }>): void {
    const target = this.cursor && this.viewport.on_plane(this.cursor.x, this.cursor.y, gesture.plane);
    if (!target) return;
    target.z = Math.max(0.02, target.z);
    this.viewport.show_pull({ tag: gesture.tag, local: gesture.local, target });
    this.viewport.session.drag(to_vec3(target));
  }

  /** Keeps the target of a pull under the cursor while the camera follows a character. */
  private follow_pull(): void {
    if (this.gesture?.kind === 'pull' && this.moved && this.viewport.session.state.view.follow) this.drag_pull(this.gesture);
  }

  private release(): void {
    this.viewport.session.release();
    this.viewport.show_pull(null);
    this.viewport.canvas.style.cursor = 'default';
  }

  // ---- placing ----

  private begin_place(tag: LinkTag, point: THREE.Vector3): void {
    const { viewport } = this;
    const { state } = viewport.session;
    const { selection } = state;
    const selected = selection.kind === 'instance' ? selection.instance === instance_of(tag.character) : selected_character(state) === tag.character;
    if (state.transport.mode !== 'edit' || !selected || this.posing?.on) {
      this.gesture = { kind: 'orbit', empty: false };
      return;
    }
    const plane = new THREE.Plane(new THREE.Vector3(0, 0, 1), -point.z);
    this.gesture = { kind: 'place', character: tag.character, from: point, plane, delta: new THREE.Vector3() };
    viewport.canvas.style.cursor = 'move';
  }

  private drag_place(gesture: Extract<Gesture, { kind: 'place' }>, event: PointerEvent): void {
    const at = this.viewport.on_plane(event.clientX, event.clientY, gesture.plane);
    if (!at) return;
    const step = event.ctrlKey || event.metaKey ? 0.5 : event.shiftKey ? 0.001 : 0.01;
    gesture.delta.set(Math.round((at.x - gesture.from.x) / step) * step, Math.round((at.y - gesture.from.y) / step) * step, 0);
    if (gesture.delta.length() > 200) gesture.delta.setLength(200);
    this.show_offset(gesture.character, gesture.delta);
  }

  /** Draws a character, or all characters of its instance, displaced by `offset` (m). */
  private show_offset(character: string, offset: THREE.Vector3): void {
    const instance = instance_of(character);
    const { characters } = this.viewport.session.state;
    const moved = instance === null ? [character] : characters.map((c) => c.id).filter((id) => instance_of(id) === instance);
    for (const id of moved) this.viewport.show_offset(id, offset);
  }

  private end_place(gesture: Extract<Gesture, { kind: 'place' }>): void {
    const { viewport } = this;
    const { session } = viewport;
    viewport.canvas.style.cursor = 'default';
    const back = (): void => this.show_offset(gesture.character, new THREE.Vector3());
    const { document } = session.state;
    const instance = instance_of(gesture.character);
    const moved = document && (instance === null ? find_character(document, gesture.character) : find_instance(document, instance));
    if (!moved || gesture.delta.lengthSq() === 0) return back();
    const round = (value: number): number => Math.round(value * 1000) / 1000;
    const place = { x: round(moved.place.x + gesture.delta.x), y: round(moved.place.y + gesture.delta.y) };
    const received = session.frames.received;
    void session.edit({ type: instance === null ? 'character.set' : 'instance.set', id: moved.id, place }).then((ok) => {
      if (!ok || session.frames.received > received) return back();
      const stop = session.frames.on_frame(() => {
        stop();
        back();
      });
      return undefined;
    });
  }
}

const to_vec3 = (v: THREE.Vector3): Vec3 => [v.x, v.y, v.z];
const prevent = (event: Event): void => event.preventDefault();
