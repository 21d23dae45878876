/** The arrow of the selected push or throw over the viewport. Dragging its tip changes force or velocity, as one undo step. */
import { useEffect, useRef, useState, type PointerEvent, type ReactElement } from 'react';
import * as THREE from 'three';
import { apply_command, find_event, type Command, type ScenarioEvent } from '../core/document';
import { arrow_base, arrow_tip, arrow_vector, label_corner, with_tip, type ArrowBase } from '../core/event_arrows';
import { format_number } from '../core/format';
import { shown_document } from '../core/state';
import type { Viewport } from '../view/viewport';
import { session, useStudio } from './app';

const head = 9; // px, length of the head of the arrow
const flat_view = 0.12; // rad: below this height of the camera, a drag moves the tip in the plane that faces the camera instead of a horizontal one

/** Where the arrow begins in the present frame; null: unknown. */
export function present_base(event: ScenarioEvent): ArrowBase | null {
  const { document, mechanisms, characters } = session.state;
  return document && arrow_base(event, document, mechanisms, characters, session.frames.latest);
}

export function EventArrow({ viewport }: { viewport: Viewport }): ReactElement | null {
  const edit = useStudio((s) => s.transport.mode === 'edit' || !s.transport.playing);
  const event = useStudio((s) => (s.selection.kind === 'event' && s.document ? find_event(shown_document(s)!, s.selection.event) : undefined));
  const line = useRef<SVGPathElement>(null);
  const tip = useRef<HTMLSpanElement>(null);
  const value = useRef<HTMLSpanElement>(null);
  const [drag, set_drag] = useState<{ plane: THREE.Plane; base: ArrowBase; grip: THREE.Vector3 } | null>(null);
  const changed = useRef<Command | null>(null);
  const on = edit && event !== undefined && arrow_vector(event) !== null;

  useEffect(() => {
    if (!on) return;
    const place = (): void => {
      const base = present_base(event);
      const to = base && arrow_tip(event, base);
      const box = viewport.canvas.getBoundingClientRect();
      const [a, b] = [base?.from, to].map((p) => p && viewport.to_client(new THREE.Vector3(...p)));
      const visible = a && b;
      if (line.current) line.current.style.visibility = visible ? 'visible' : 'hidden';
      if (tip.current) tip.current.style.visibility = visible ? 'visible' : 'hidden';
      if (!visible) return;
      const [x0, y0, x1, y1] = [a.x - box.left, a.y - box.top, b.x - box.left, b.y - box.top];
      const length = Math.max(1, Math.hypot(x1 - x0, y1 - y0));
      const [ux, uy] = [(x1 - x0) / length, (y1 - y0) / length];
      const wing = (side: number): string => `M${x1} ${y1}L${x1 - head * (ux - side * 0.5 * uy)} ${y1 - head * (uy + side * 0.5 * ux)}`;
      line.current?.setAttribute('d', `M${x0} ${y0}L${x1} ${y1}${wing(1)}${wing(-1)}`);
      if (tip.current) tip.current.style.transform = `translate(${x1}px, ${y1}px) translate(-50%, -50%)`;
      if (!value.current) return;
      const { offsetWidth: width, offsetHeight: height } = value.current;
      const corner = label_corner({ x: x1, y: y1 }, { width, height }, box, ux < 0);
      value.current.style.translate = `${corner.x - x1}px ${corner.y - y1}px`;
    };
    place();
    return viewport.on_draw(place);
  }, [viewport, on, event]);

  useEffect(() => {
    if (!drag) return;
    const press = (key: KeyboardEvent): void => {
      if (key.key !== 'Escape') return;
      key.preventDefault();
      key.stopPropagation();
      changed.current = null;
      set_drag(null);
      session.show_preview(null);
    };
    window.addEventListener('keydown', press, true);
    return () => window.removeEventListener('keydown', press, true);
  }, [drag]);

  if (!on) return null;
  const amount = Math.hypot(...arrow_vector(event)!);
  const begin = (pointer: PointerEvent<HTMLElement>): void => {
    const base = present_base(event);
    const at = base && arrow_tip(event, base);
    if (!base || !at || pointer.button !== 0) return;
    pointer.preventDefault();
    pointer.stopPropagation();
    pointer.currentTarget.setPointerCapture(pointer.pointerId);
    const point = new THREE.Vector3(...at);
    const upright = viewport.facing_plane(point);
    const flat = pointer.shiftKey || viewport.rig.current.elevation < flat_view;
    const plane = flat ? upright : new THREE.Plane().setFromNormalAndCoplanarPoint(new THREE.Vector3(0, 0, 1), point);
    const grip = viewport.on_plane(pointer.clientX, pointer.clientY, plane);
    changed.current = null;
    if (grip) set_drag({ plane, base, grip: point.sub(grip) });
  };
  const move = (pointer: PointerEvent<HTMLElement>): void => {
    const at = drag && viewport.on_plane(pointer.clientX, pointer.clientY, drag.plane);
    const { document } = session.state;
    if (!at || !document) return;
    const fields = with_tip(event, drag.base, at.add(drag.grip).toArray());
    changed.current = { type: 'event.set', id: event.id, event: fields };
    session.show_preview(apply_command(document, changed.current));
    viewport.invalidate();
  };
  const end = (keep: boolean): void => {
    if (!drag) return;
    set_drag(null);
    if (keep && changed.current) void session.edit(changed.current);
    else session.show_preview(null);
    changed.current = null;
  };
  return (
    <div className="event-arrow">
      <svg aria-hidden="true"><path ref={line} /></svg>
      <span ref={tip} className="arrow-tip" title="Drag to change the force over the floor; with Shift also its height" data-dragged={drag !== null} onPointerDown={begin} onPointerMove={move} onPointerUp={() => end(true)} onPointerCancel={() => end(false)}>
        <span ref={value} className="arrow-value">{event.type === 'throw' ? `${format_number(amount, 1)} m/s` : `${format_number(amount, 0)} N${event.axes === 'body' ? ', body axes' : ''}`}</span>
      </span>
    </div>
  );
}
