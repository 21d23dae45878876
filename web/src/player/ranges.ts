/** Checks of arguments that another page gives. */
import type { Vec3 } from '../core/protocol';

const text = (value: unknown): string => (typeof value === 'string' ? `'${value.slice(0, 40)}'` : String(value));

/** The value, if it is a number from `min` to `max`; otherwise an error that names it. */
export function in_range(name: string, value: unknown, min: number, max: number): number {
  if (typeof value !== 'number' || !(value >= min && value <= max)) throw new RangeError(`${name} is ${text(value)}; it must be a number from ${min} to ${max}.`);
  return value;
}

/** The value, if it is a vector of three finite numbers with at most the length `max`; otherwise an error that names it. */
export function vector(name: string, value: unknown, max: number): Vec3 {
  if (!Array.isArray(value) || value.length !== 3 || !value.every((x) => Number.isFinite(x))) throw new RangeError(`${name} is not a list of three finite numbers.`);
  if (Math.hypot(...(value as Vec3)) > max) throw new RangeError(`${name} is longer than ${max}.`);
  return value as Vec3;
}
