/** Measures of naturalness over time: values of the recorded frames, the time spans in which a value is bad, and a table as CSV. */
import type { Grade } from './judge';
import type { MeasureInfo, MeasuresEvent } from './protocol';

/** A measure as it is displayed: units and limits in the displayed unit. */
export interface Timed {
  key: string;
  name: string;
  unit: string;
  /** Factor from the service's unit to the displayed unit. */
  scale: number;
  digits: number;
  /** How the value of the run follows from the values over time. */
  kind: string;
  /** True: values over time are root mean squares over `rms_time`, because the limit is one of a root mean square. */
  rms: boolean;
  /** Values over time below `low` or above `bad` are bad. */
  low: number;
  bad: number;
  /** Values of the run are bad below and above these limits, and good between the inner ones. */
  limits: { low: number; good_low: number; good_high: number; high: number };
  meaning: string;
}

/** The displayed form of a measure of the service. */
export function timed_measure(info: MeasureInfo): Timed {
  const percent = info.unit === 'bw' && (info.high ?? 1) < 1;
  const scale = percent ? 100 : 1;
  const lower = (x: number | null): number => (x === null ? -Infinity : x * scale);
  const upper = (x: number | null): number => (x === null ? Infinity : x * scale);
  return {
    key: info.key, name: info.name, unit: percent ? '%' : info.unit === 'deg' ? '°' : info.unit === 'bw' ? '× weight' : info.unit,
    scale, digits: percent ? 1 : info.digits, kind: info.total === 'maximum' ? 'max' : info.total, rms: info.smooth,
    low: lower(info.now_low), bad: upper(info.now_high),
    limits: { low: lower(info.low), good_low: lower(info.good_low), good_high: upper(info.good_high), high: upper(info.high) },
    meaning: info.meaning + (info.smooth ? `; over time: rms over ${rms_time} s` : ''),
  };
}

/** A value with its unit; yes or no for a fall. */
export function with_unit(value: number, measure: Timed): string {
  if (!Number.isFinite(value)) return '–';
  if (measure.key === 'fell') return value > 0 ? 'yes' : 'no';
  return `${value.toFixed(measure.digits)}${measure.unit === '°' || measure.unit === '' ? '' : ' '}${measure.unit}`;
}

/** Grade of the value of a run. */
export function grade_run({ limits }: Timed, value: number): Grade {
  if (!Number.isFinite(value)) return 'none';
  if (value < limits.low || value > limits.high) return 'bad';
  return value < limits.good_low || value > limits.good_high ? 'fair' : 'good';
}

/** "5 to 20 mm", "3 cm" */
export function limit_text(measure: Timed): string {
  if (measure.key === 'fell') return 'none';
  const { low, high } = measure.limits;
  const digits = Number.isInteger(low) && Number.isInteger(high) ? 0 : measure.digits;
  const text = low > 0 ? `${low.toFixed(digits)} – ${high.toFixed(digits)}` : String(Math.round(high * 1000) / 1000);
  return `${text}${measure.unit === '°' || measure.unit === '' ? '' : ' '}${measure.unit}`;
}

type Series = Map<string, number[]>;

/** A time span in which a measure of a character is bad. */
export interface BadSpan {
  character: string;
  measure: Timed;
  /** Begin and end of the span, s. */
  from: number;
  to: number;
  /** Time of the worst value, s. */
  at: number;
  /** Worst value, in the displayed unit. */
  peak: number;
}

/** Duration of the root mean squares, s: the averaging time after which motion control releases a character ("patience"). */
export const rms_time = 0.25;

/** Bad frames that are nearer than this belong to one span, s: a span must be wide enough for a click. */
const join_time = 0.1;

export class MeasureHistory {
  constructor(
    /** Recorded frames per second. */
    readonly rate = 60,
    /** Number of frames. */
    readonly frames = 0,
    /** All measures. */
    readonly list: readonly Timed[] = [],
    private readonly series_: ReadonlyMap<string, Series> = new Map(),
    private readonly totals_: ReadonlyMap<string, Record<string, number | string>> = new Map(),
  ) {}

  /** True if the character has measures. */
  has(character: string): boolean {
    return (this.series_.get(character)?.size ?? 0) > 0;
  }

  /** The values of a measure in the service's unit, one for each frame, NaN where there is none; empty for a measure without values. */
  values(character: string, key: string): readonly number[] {
    return this.series_.get(character)?.get(key) ?? [];
  }

  /** The value of the run in the displayed unit; NaN: none. */
  total(character: string, measure: Timed): number {
    const total = this.totals_.get(character)?.[measure.key];
    return typeof total === 'number' ? total * measure.scale : NaN;
  }

  /** Why a measure of the run has no value; '' if it has one. */
  reason(character: string, measure: Timed): string {
    const total = this.totals_.get(character)?.[measure.key];
    return typeof total === 'string' ? total : '';
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
        const counts = new Float64Array(values.length + 1);
        values.forEach((value, i) => {
          sums[i + 1] = sums[i]! + (Number.isNaN(value) ? 0 : value * value);
          counts[i + 1] = counts[i]! + (Number.isNaN(value) ? 0 : 1);
        });
        values.forEach((value, i) => {
          const [from, to] = [Math.max(0, i - half), Math.min(values.length, i + half + 1)];
          shown![i] = Number.isNaN(value) ? NaN : Math.sqrt((sums[to]! - sums[from]!) / (counts[to]! - counts[from]!)) * measure.scale;
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
    const totals = new Map<string, Record<string, number | string>>();
    for (const samples of event.characters) {
      const known = event.from > 0 ? this.series_.get(samples.id) : undefined;
      if (event.from > 0 && !known) return this;
      const joined: Series = new Map();
      for (const key of new Set([...(known?.keys() ?? []), ...Object.keys(samples.values)])) {
        const values = known?.get(key) ?? [];
        while (values.length < event.from) values.push(NaN);
        values.length = event.from;
        const more = samples.values[key];
        for (let i = 0; i < event.frames; i++) values.push(more?.[i] ?? NaN);
        joined.set(key, values);
      }
      series.set(samples.id, joined);
      totals.set(samples.id, samples.totals);
    }
    return new MeasureHistory(event.rate, event.from + event.frames, event.list?.map(timed_measure) ?? this.list, series, totals);
  }

  /** The spans in which `measure` is bad, by time. */
  bad_spans(character: string, measure: Timed): BadSpan[] {
    const spans: BadSpan[] = [];
    let last: BadSpan | undefined;
    this.shown(character, measure).forEach((shown, frame) => {
      const over = Math.max(shown - measure.bad, measure.low - shown);
      if (!(over > 0)) return;
      const time = frame / this.rate;
      const end = (frame + 1) / this.rate;
      if (last && time - last.to < join_time) {
        last.to = end;
        if (over > Math.max(last.peak - measure.bad, measure.low - last.peak)) Object.assign(last, { peak: shown, at: time });
      } else spans.push((last = { character, measure, from: time, to: end, at: time, peak: shown }));
    });
    return spans;
  }

  /** The maximum displayed value and its time (s), or null without values. */
  peak(character: string, measure: Timed): { at: number; value: number } | null {
    const values = this.shown(character, measure);
    let best = -1;
    values.forEach((value, i) => {
      if (!Number.isNaN(value) && (best < 0 || value > values[best]!)) best = i;
    });
    return best < 0 ? null : { at: best / this.rate, value: values[best]! };
  }

  /** One row for each frame: the time and the measures of all characters. @param characters ids and names, in the order of the columns */
  csv(characters: readonly { id: string; name: string }[]): string {
    const measured = characters.filter(({ id }) => this.series_.has(id));
    const quoted = (text: string): string => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    const head = ['time_s', ...measured.flatMap(({ name }) => this.list.map((m) => quoted(`${name}: ${m.key}`)))];
    const rows = Array.from({ length: this.frames }, (_, frame) =>
      [Math.round((frame / this.rate) * 1e6) / 1e6, ...measured.flatMap(({ id }) => this.list.map((m) => { const value = this.values(id, m.key)[frame]; return value === undefined || Number.isNaN(value) ? '' : value; }))].join(','),
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
  const value = measure.key === 'fell' ? '' : ` ${with_unit(peak, measure)}`;
  return `${measure.name}${value}, ${from.toFixed(2)} to ${to.toFixed(2)} s`;
}
