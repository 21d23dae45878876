/** Measures of naturalness over time: values of the recorded frames, the time spans in which a value is bad, and a table as CSV. */
import type { MeasuresEvent } from './protocol';

export type TimedKey = 'assist_bw' | 'tracking_deg' | 'slip_cm' | 'depth_mm' | 'fell';

export interface Timed {
  key: TimedKey;
  name: string;
  unit: string;
  /** Factor from the service's unit to the displayed unit. */
  scale: number;
  digits: number;
  /** True: values over time are root mean squares over `rms_time`, because the limit is one of a root mean square. */
  rms?: boolean;
  /** A displayed value above this is bad. The limits are those of `ugoki judge`. */
  bad: number;
  /** Name of the column of a CSV table. */
  column: string;
}

/** All measures of `ugoki judge` with their default limits (apps/ugoki/judge.cpp). */
export const timed_measures: readonly Timed[] = [
  { key: 'assist_bw', name: 'Root assist', unit: '%', scale: 100, digits: 1, rms: true, bad: 15, column: 'root_assist_bw' },
  { key: 'tracking_deg', name: 'Tracking', unit: '°', scale: 1, digits: 1, rms: true, bad: 5, column: 'tracking_deg' },
  { key: 'slip_cm', name: 'Foot skate', unit: 'cm', scale: 1, digits: 1, bad: 3, column: 'foot_slip_cm' },
  { key: 'depth_mm', name: 'Penetration', unit: 'mm', scale: 1, digits: 1, bad: 20, column: 'penetration_mm' },
  { key: 'fell', name: 'Fall', unit: '', scale: 1, digits: 0, bad: 0, column: 'fell' },
];

type Series = Record<TimedKey, number[]>;

/** A time span in which a measure of a character is bad. */
export interface BadSpan {
  character: string;
  measure: Timed;
  /** Begin and end of the span, s. */
  from: number;
  to: number;
  /** Time of the maximum value, s. */
  at: number;
  /** Maximum, in the displayed unit. */
  peak: number;
}

/** Duration of the root mean squares, s: the averaging time after which motion control releases a character ("patience"). */
export const rms_time = 0.25;

/** Bad frames that are nearer than this belong to one span, s: a span must be wide enough for a click. */
const join_time = 0.1;

export class MeasureHistory {
  private readonly series_: ReadonlyMap<string, Series>;

  constructor(
    /** Recorded frames per second. */
    readonly rate = 60,
    series: ReadonlyMap<string, Series> = new Map(),
  ) {
    this.series_ = series;
  }

  /** Number of frames. */
  get frames(): number {
    for (const series of this.series_.values()) return series.assist_bw.length;
    return 0;
  }

  /** The values of a measure in the service's unit, one for each frame; empty for a character without measures. */
  values(character: string, key: TimedKey): readonly number[] {
    return this.series_.get(character)?.[key] ?? [];
  }

  private readonly shown_ = new Map<string, Float64Array>();

  /** The measure over time in the displayed unit, one value for each frame: of the instant, or the root mean square of the time around it. */
  shown(character: string, measure: Timed): Float64Array {
    const key = `${measure.key} ${character}`;
    let shown = this.shown_.get(key);
    if (!shown) {
      const values = this.values(character, measure.key);
      shown = Float64Array.from(values, (value) => value * measure.scale);
      if (measure.rms) {
        const half = Math.round((rms_time * this.rate) / 2);
        const sums = new Float64Array(values.length + 1); // of the squares before each frame
        values.forEach((value, i) => (sums[i + 1] = sums[i]! + value * value));
        shown.forEach((_, i) => {
          const [from, to] = [Math.max(0, i - half), Math.min(values.length, i + half + 1)];
          shown![i] = Math.sqrt((sums[to]! - sums[from]!) / (to - from)) * measure.scale;
        });
      }
      this.shown_.set(key, shown);
    }
    return shown;
  }

  /** The displayed value at `time` (s), or NaN if there is none. */
  value_at(character: string, measure: Timed, time: number): number {
    const shown = this.shown(character, measure);
    const frame = Math.round(time * this.rate);
    return shown[frame === shown.length ? frame - 1 : frame] ?? NaN; // the head of the simulation can be up to one frame after the last one
  }

  /**
   * The history after an event. It continues the arrays of this history, which must not be used any more. An event that does not follow the
   * known frames is ignored.
   */
  after(event: MeasuresEvent): MeasureHistory {
    if (event.from > this.frames) return this;
    const series = new Map<string, Series>();
    for (const samples of event.characters) {
      const known = event.from > 0 ? this.series_.get(samples.id) : undefined;
      if (event.from > 0 && !known) return this;
      const join = (key: TimedKey, more: readonly number[]): number[] => {
        const values = known?.[key] ?? [];
        values.length = event.from;
        for (const value of more) values.push(value);
        return values;
      };
      const { fell } = samples;
      series.set(samples.id, {
        assist_bw: join('assist_bw', samples.assist_bw),
        tracking_deg: join('tracking_deg', samples.tracking_deg),
        slip_cm: join('slip_cm', samples.slip_cm),
        depth_mm: join('depth_mm', samples.depth_mm),
        fell: join('fell', samples.assist_bw.map((_, i) => (fell !== null && event.from + i >= fell ? 1 : 0))),
      });
    }
    return new MeasureHistory(event.rate, series);
  }

  /** The spans in which `measure` is bad, by time. */
  bad_spans(character: string, measure: Timed): BadSpan[] {
    const spans: BadSpan[] = [];
    let last: BadSpan | undefined;
    this.shown(character, measure).forEach((shown, frame) => {
      if (!(shown > measure.bad)) return;
      const time = frame / this.rate;
      const end = (frame + 1) / this.rate;
      if (last && time - last.to < join_time) {
        last.to = end;
        if (shown > last.peak) Object.assign(last, { peak: shown, at: time });
      } else spans.push((last = { character, measure, from: time, to: end, at: time, peak: shown }));
    });
    return spans;
  }

  /** The maximum displayed value and its time (s), or null without values. */
  peak(character: string, measure: Timed): { at: number; value: number } | null {
    const values = this.shown(character, measure);
    if (values.length === 0) return null;
    let best = 0;
    values.forEach((value, i) => {
      if (value > values[best]!) best = i;
    });
    return { at: best / this.rate, value: values[best]! };
  }

  /** One row for each frame: the time and the measures of all characters. @param characters ids and names, in the order of the columns */
  csv(characters: readonly { id: string; name: string }[]): string {
    const measured = characters.filter(({ id }) => this.series_.has(id));
    const quoted = (text: string): string => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    const head = ['time_s', ...measured.flatMap(({ name }) => timed_measures.map((m) => quoted(`${name}: ${m.column}`)))];
    const rows = Array.from({ length: this.frames }, (_, frame) =>
      [Math.round((frame / this.rate) * 1e6) / 1e6, ...measured.flatMap(({ id }) => timed_measures.map((m) => this.values(id, m.key)[frame] ?? ''))].join(','),
    );
    return [head.join(','), ...rows].join('\r\n') + '\r\n';
  }
}

/** The span that begins next after (or with `back`, before) `time` (s); null if there is none. */
export function next_span(spans: readonly BadSpan[], time: number, back = false): BadSpan | null {
  const sorted = [...spans].sort((a, b) => a.at - b.at);
  const tolerance = 0.5 / 60; // half a frame: the present span is not the next one
  return (back ? sorted.reverse().find((s) => s.at < time - tolerance) : sorted.find((s) => s.at > time + tolerance)) ?? null;
}

/** "Foot skate 4.2 cm, 1.20 to 1.45 s" */
export function describe_span({ measure, peak, from, to }: BadSpan): string {
  const value = measure.key === 'fell' ? '' : ` ${peak.toFixed(measure.digits)}${measure.unit === '°' ? '' : ' '}${measure.unit}`;
  return `${measure.name}${value}, ${from.toFixed(2)} to ${to.toFixed(2)} s`;
}
