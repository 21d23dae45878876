/** The arrow of an event in the viewport: the force of a push, or the velocity of a throw, which a drag of the arrow's tip changes. */
import { find_character, type PushAxes, type ScenarioDocument, type ScenarioEvent } from './document';
import { link_position, link_rotation, type Frame } from './frames';
import type { MechanismData, Vec3 } from './protocol';

const metres_per_newton = 0.004; // 150 N are 0.6 m
const metres_per_speed = 0.15; // m of the arrow for 1 m/s
const max_force = 100000; // N
const max_speed = 1000; // m/s

/** Unit quaternion qw qx qy qz. */
export type Rotation = readonly [number, number, number, number];
const none: Rotation = [1, 0, 0, 0];

/** Where an arrow begins, m, and the rotation from the axes of the pushed link to those of the world. */
export interface ArrowBase {
  from: Vec3;
  rotation: Rotation;
}

const scale_of = (event: ScenarioEvent): number => (event.type === 'throw' ? metres_per_speed : metres_per_newton);

/** The vector, rotated by a unit quaternion. */
export function rotated([w, x, y, z]: Rotation, [a, b, c]: Vec3): Vec3 {
  // v + 2 w (u x v) + 2 u x (u x v)
  const [p, q, r] = [y * c - z * b, z * a - x * c, x * b - y * a];
  return [a + 2 * (w * p + y * r - z * q), b + 2 * (w * q + z * p - x * r), c + 2 * (w * r + x * q - y * p)];
}
const inverse = ([w, x, y, z]: Rotation): Rotation => [w, -x, -y, -z];

/** Rotation from the axes of the vector of the event to those of the world. */
const axes_of = (event: ScenarioEvent, base: ArrowBase): Rotation => (event.type === 'push' && event.axes === 'body' ? base.rotation : none);

/** Vector that the arrow shows, in the axes of the event: N or m/s; null: the event has no arrow. */
export function arrow_vector(event: ScenarioEvent): Vec3 | null {
  if (event.type === 'push') return event.force ?? [0, 0, 0];
  if (event.type === 'throw') return event.velocity ?? [0, 0, 0];
  return null;
}

/** Where the arrow begins: at the pushed link in `frame`, or at the place of the thrown body; null: unknown. @param order ids of the characters in the frame */
export function arrow_base(event: ScenarioEvent, document: ScenarioDocument, mechanisms: Readonly<Record<string, MechanismData>>, order: readonly { id: string }[], frame: Frame | null): ArrowBase | null {
  if (event.type === 'throw') return event.from ? { from: event.from, rotation: none } : null;
  const mechanism = find_character(document, event.character ?? '')?.mechanism;
  const link = mechanism ? (mechanisms[mechanism]?.links.findIndex((l) => l.name === event.link || l.label === event.link) ?? -1) : -1;
  const shown = frame?.characters[order.findIndex((c) => c.id === event.character)];
  return frame && shown && link >= 0 && link < shown.links ? { from: link_position(frame, shown, link), rotation: link_rotation(frame, shown, link) } : null;
}

/** Tip of the arrow in the world, m. */
export function arrow_tip(event: ScenarioEvent, base: ArrowBase): Vec3 | null {
  const vector = arrow_vector(event);
  const along = vector && rotated(axes_of(event, base), vector);
  return along && (base.from.map((x, i) => x + along[i]! * scale_of(event)) as Vec3);
}

/**
 * Upper left corner of the label of an arrow, px: beyond the tip, or on its other side if there is no room, and always inside the viewport.
 * @param tip, label, box position of the tip, and sizes of the label and the viewport, px  @param left true: the arrow points to the left
 */
export function label_corner(tip: { x: number; y: number }, label: { width: number; height: number }, box: { width: number; height: number }, left: boolean): { x: number; y: number } {
  const gap = 15; // px between the tip and the label
  const margin = 4; // px to the edge of the viewport
  const [on_left, on_right] = [tip.x - gap - label.width, tip.x + gap];
  const fits = (x: number): boolean => x >= margin && x + label.width <= box.width - margin;
  const wanted = left ? on_left : on_right;
  const other = left ? on_right : on_left;
  const inside = (at: number, size: number, all: number): number => Math.max(margin, Math.min(at, all - size - margin));
  return { x: inside(fits(wanted) || !fits(other) ? wanted : other, label.width, box.width), y: inside(tip.y - label.height / 2, label.height, box.height) };
}

const rounded = (vector: Vec3, step: number, limit: number): Vec3 =>
  vector.map((x) => Math.max(-limit, Math.min(limit, Math.round(x / step) * step))).map((x) => Math.round(x * 100) / 100 + 0) as Vec3;

/** The fields of the event after its tip was dragged to `tip`: whole newtons, or steps of 0.05 m/s. */
export function with_tip(event: ScenarioEvent, base: ArrowBase, tip: Vec3): Partial<ScenarioEvent> {
  const along = tip.map((x, i) => (x - base.from[i]!) / scale_of(event)) as Vec3;
  const vector = rotated(inverse(axes_of(event, base)), along);
  return event.type === 'throw' ? { velocity: rounded(vector, 0.05, max_speed) } : { force: rounded(vector, 1, max_force) };
}

/** The fields of a push in other axes whose arrow is the same in the pose of `base`; without a pose, the numbers are kept. */
export function with_axes(event: ScenarioEvent, axes: PushAxes, base: ArrowBase | null): Partial<ScenarioEvent> {
  if (!base || axes === (event.axes ?? 'world')) return { axes };
  return { axes, force: rounded(rotated(axes === 'body' ? inverse(base.rotation) : base.rotation, event.force ?? [0, 0, 0]), 0.1, max_force) };
}
