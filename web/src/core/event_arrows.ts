/** The arrow of an event in the viewport: the force of a push, or the velocity of a throw, which a drag of the arrow's tip changes. */
import type { ScenarioEvent } from './document';
import type { Vec3 } from './protocol';

const metres_per_newton = 0.004; // 150 N are 0.6 m
const metres_per_speed = 0.15; // m of the arrow for 1 m/s
const max_force = 100000; // N
const max_speed = 1000; // m/s

const scale_of = (event: ScenarioEvent): number => (event.type === 'throw' ? metres_per_speed : metres_per_newton);

/** Vector that the arrow shows: N or m/s; null: the event has no arrow. */
export function arrow_vector(event: ScenarioEvent): Vec3 | null {
  if (event.type === 'push') return event.force ?? [0, 0, 0];
  if (event.type === 'throw') return event.velocity ?? [0, 0, 0];
  return null;
}

/** Tip of the arrow that begins at `from`, m. */
export function arrow_tip(event: ScenarioEvent, from: Vec3): Vec3 | null {
  const vector = arrow_vector(event);
  return vector && (from.map((x, i) => x + vector[i]! * scale_of(event)) as Vec3);
}

/** The fields of the event after its tip was dragged to `tip`: whole newtons, or steps of 0.05 m/s. */
export function with_tip(event: ScenarioEvent, from: Vec3, tip: Vec3): Partial<ScenarioEvent> {
  const [step, limit] = event.type === 'throw' ? [0.05, max_speed] : [1, max_force];
  const vector = tip.map((x, i) => Math.max(-limit, Math.min(limit, Math.round((x - from[i]!) / scale_of(event) / step) * step))).map((x) => Math.round(x * 100) / 100 + 0) as Vec3;
  return event.type === 'throw' ? { velocity: vector } : { force: vector };
}
