/** Live values, curves and computing times of the running circuit (event `values`). Drawing code reads them directly, not through React. */

export interface ValuesEvent {
  /** Simulated time of the values, s. */
  time: number;
  /** [pin with its path ("arm/elbow.out"), number of elements, first scalars]; for contacts and events, the number of records in use */
  pins: [string, number, number[]][];
  /** [LSI with its path ("arm/elbow"), computing time, µs per tick] */
  times?: [string, number][];
  /** Computing time of the whole circuit, µs per tick. */
  tick_us?: number;
  /** [pin with its path, times (s), values of each component]: samples since the previous message */
  probes?: [string, number[], (number | null)[][]][];
}

export interface PinValue {
  /** Number of elements of the value. */
  count: number;
  /** The first scalars of the value. */
  numbers: readonly number[];
  /** Time at which the value last changed, as returned by performance.now(), ms. */
  changed: number;
}

/** Recorded samples of a pin. */
export interface Curve {
  /** Times of the samples, s, ascending. */
  times: number[];
  /** Values [component][sample]; null: the value is not finite. */
  values: (number | null)[][];
}

const curve_capacity = 4000; // maximum number of samples of a curve; older samples are dropped

export class LiveValues {
  time = 0;
  tick_us = 0;
  /** Incremented by every `values` event and by clear(). */
  revision = 0;
  private readonly pins = new Map<string, PinValue>();
  private readonly times = new Map<string, number>();
  private readonly curves = new Map<string, Curve>();

  take(event: ValuesEvent, now: number): void {
    this.revision++;
    if (event.time < this.time - 1e-9) this.cut(event.time);
    this.time = event.time;
    if (event.tick_us !== undefined) this.tick_us = event.tick_us;
    for (const [pin, count, numbers] of event.pins) {
      const old = this.pins.get(pin);
      const same = old !== undefined && old.count === count && old.numbers.length === numbers.length && old.numbers.every((v, i) => v === numbers[i]);
      this.pins.set(pin, { count, numbers, changed: same ? old.changed : now });
    }
    for (const [id, us] of event.times ?? []) this.times.set(id, us);
    for (const [pin, times, values] of event.probes ?? []) this.extend(pin, times, values);
  }

  private extend(pin: string, times: number[], values: (number | null)[][]): void {
    let curve = this.curves.get(pin);
    if (!curve || curve.values.length !== values.length) {
      curve = { times: [], values: values.map(() => []) };
      this.curves.set(pin, curve);
    }
    const first = times[0];
    if (first !== undefined) cut_curve(curve, first);
    curve.times.push(...times);
    values.forEach((list, i) => curve.values[i]!.push(...list));
    const over = curve.times.length - curve_capacity;
    if (over > 0) {
      curve.times.splice(0, over);
      for (const list of curve.values) list.splice(0, over);
    }
  }

  /** Removes the samples from `time` on, because the simulation was set back. */
  private cut(time: number): void {
    for (const curve of this.curves.values()) cut_curve(curve, time);
  }

  pin(flat: string): PinValue | undefined {
    return this.pins.get(flat);
  }
  curve(flat: string): Curve | undefined {
    return this.curves.get(flat);
  }

  /** Computing time of an LSI, or of all LSIs inside a circuit, µs per tick; undefined if not measured. */
  time_of(flat: string): number | undefined {
    const own = this.times.get(flat);
    if (own !== undefined) return own;
    let sum = 0;
    let any = false;
    const prefix = `${flat}/`;
    for (const [id, us] of this.times) {
      if (!id.startsWith(prefix)) continue;
      sum += us;
      any = true;
    }
    return any ? sum : undefined;
  }
  /** Number of LSIs whose computing time was measured. */
  get timed(): number {
    return this.times.size;
  }
  clear(): void {
    this.pins.clear();
    this.times.clear();
    this.curves.clear();
    this.tick_us = 0;
    this.time = 0;
    this.revision++;
  }
}

function cut_curve(curve: Curve, time: number): void {
  let keep = curve.times.length;
  while (keep > 0 && curve.times[keep - 1]! >= time - 1e-9) keep--;
  curve.times.length = keep;
  for (const list of curve.values) list.length = keep;
}

/** A value with three or four significant digits, at most as wide as a pin's label. */
export function short_number(value: number): string {
  if (!Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  if (size === 0) return '0';
  if (size >= 1e5 || size < 1e-3) return value.toExponential(1).replace('e+', 'e');
  const text = size >= 1000 ? value.toFixed(0) : size >= 100 ? value.toFixed(1) : size >= 10 ? value.toFixed(2) : value.toFixed(3);
  return text.includes('.') ? text.replace(/\.?0+$/, '') : text;
}

/** A pin's value as short text: its scalars, or the number of its records. */
export function short_value(type: string, value: PinValue): string {
  if (type === 'contacts' || type === 'event') return String(Math.round(value.numbers[0] ?? 0));
  if (value.count === 1 && value.numbers.length === 1) return short_number(value.numbers[0]!);
  if (value.numbers.length <= 3) return value.numbers.map(short_number).join('  ');
  return `${short_number(value.numbers[0]!)} …`;
}

/** A computing time as text. @param us µs */
export const short_time = (us: number): string => (us >= 1000 ? `${(us / 1000).toFixed(1)} ms` : us >= 100 ? `${us.toFixed(0)} µs` : us >= 0.05 ? `${us.toFixed(1)} µs` : `${Math.round(us * 1000)} ns`);
