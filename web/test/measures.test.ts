import { describe, expect, it } from 'vitest';
import { describe_span, grade_run, limit_text, MeasureHistory, next_span, timed_measure, with_unit, type Timed } from '../src/core/measures';
import type { MeasureInfo, MeasureSamples, MeasuresEvent } from '../src/core/protocol';

const info = (key: string, unit: string, high: number, more: Partial<MeasureInfo> = {}): MeasureInfo => ({
  key, name: key, unit, total: 'mean', digits: 1, low: null, good_low: null, good_high: high / 3, high, now_low: null, now_high: high, smooth: false, meaning: '', ...more,
});
const list = [
  info('root_assist_bw', 'bw', 0.15, { name: 'Root assist', total: 'rms', smooth: true }),
  info('tracking_deg', 'deg', 5, { smooth: true }),
  info('foot_slip_cm', 'cm', 3, { name: 'Foot skate' }),
  info('toe_clearance_mm', 'mm', 100, { low: 2, good_low: 10, good_high: 50, now_low: 2 }),
  info('fell', '', 0),
];
const event = (characters: MeasureSamples[], rate = 10, from = 0): MeasuresEvent => ({ rate, from, frames: Object.values(characters[0]!.values)[0]!.length, list, characters });
const samples = (slip: number[], fell = Infinity): MeasureSamples => ({
  id: 'human',
  values: { tracking_deg: slip.map(() => 1), root_assist_bw: slip.map((_, i) => i / 100), foot_slip_cm: slip, fell: slip.map((_, i) => (i >= fell ? 1 : 0)) },
  totals: { foot_slip_cm: 2.5, toe_clearance_mm: 'no walking', root_assist_bw: 0.2 },
});
const assisted = (assist: number[]): MeasureSamples => ({ id: 'human', values: { root_assist_bw: assist }, totals: {} });
const history = (slip: number[], fell = Infinity): MeasureHistory => new MeasureHistory().after(event([samples(slip, fell)]));
const measure = (key: string): Timed => history([0]).list.find((m) => m.key === key)!;

describe('MeasureHistory', () => {
  it('shows the measures of the service in the displayed units', () => {
    expect(history([0]).list.map((m) => [m.key, m.unit, m.bad])).toEqual([
      ['root_assist_bw', '%', 15], ['tracking_deg', '°', 5], ['foot_slip_cm', 'cm', 3], ['toe_clearance_mm', 'mm', 100], ['fell', '', 0],
    ]);
    expect(timed_measure(info('ground_force_bw', 'bw', 3.5)).unit).toBe('× weight');
    expect([limit_text(measure('toe_clearance_mm')), limit_text(measure('tracking_deg')), limit_text(measure('fell'))]).toEqual(['2 – 100 mm', '5°', 'none']);
    expect([with_unit(2.04, measure('tracking_deg')), with_unit(NaN, measure('tracking_deg')), with_unit(1, measure('fell'))]).toEqual(['2.0°', '–', 'yes']);
  });
  it('grades the value of the run on both sides', () => {
    expect([1, 5, 20, 60, 200, NaN].map((v) => grade_run(measure('toe_clearance_mm'), v))).toEqual(['bad', 'fair', 'good', 'fair', 'bad', 'none']);
    const made = history([0, 1]);
    expect(made.total('human', measure('root_assist_bw'))).toBeCloseTo(20);
    expect(made.total('human', measure('toe_clearance_mm'))).toBeNaN();
    expect(made.reason('human', measure('toe_clearance_mm'))).toBe('no walking');
  });
  it('finds values that are too small, and frames without a value', () => {
    const swing = (values: (number | null)[]) => new MeasureHistory().after(event([{ id: 'human', values: { toe_clearance_mm: values }, totals: {} }]));
    const made = swing([null, 30, 1, 0.5, null, 30]);
    expect(made.bad_spans('human', measure('toe_clearance_mm')).map(({ from, to, at, peak }) => ({ from, to, at, peak }))).toEqual([{ from: 0.2, to: 0.4, at: 0.3, peak: 0.5 }]);
    expect(made.value_at('human', measure('toe_clearance_mm'), 0)).toBeNaN();
    expect(made.csv([{ id: 'human', name: 'A' }]).split('\r\n')[1]).toBe('0,,,,,');
  });
  it('finds the spans above the limit with their maximum', () => {
    const spans = history([0, 4, 5, 4, 0, 0, 0, 3.1, 0]).bad_spans('human', measure('foot_slip_cm'));
    expect(spans.map(({ from, to, at, peak }) => ({ from, to, at, peak }))).toEqual([
      { from: 0.1, to: 0.4, at: 0.2, peak: 5 },
      { from: 0.7, to: 0.8, at: 0.7, peak: 3.1 },
    ]);
    expect(describe_span(spans[0]!)).toBe('Foot skate 5.0 cm, 0.10 to 0.40 s');
  });
  it('joins spans that are too near to be clicked separately', () => {
    const values = Array.from({ length: 60 }, (_, i) => (i % 2 === 0 && i < 30 ? 9 : 0));
    const made = new MeasureHistory().after(event([samples(values)], 60));
    expect(made.bad_spans('human', measure('foot_slip_cm'))).toHaveLength(1);
  });
  it('compares in the displayed unit: 0.15 body weights are 15 %', () => {
    const made = new MeasureHistory().after(event([assisted(Array.from({ length: 20 }, (_, i) => (i < 10 ? 0.1 : 0.2)))], 4));
    expect(made.value_at('human', measure('root_assist_bw'), 0.5)).toBeCloseTo(10, 9);
    expect(made.peak('human', measure('root_assist_bw'))!.value).toBeCloseTo(20, 9);
    expect(made.value_at('human', measure('root_assist_bw'), 50)).toBeNaN();
    expect(made.bad_spans('human', measure('root_assist_bw'))).toHaveLength(1);
  });
  it('averages measures with an rms limit over 0.25 s, so that a short peak is not bad, but a longer one is', () => {
    const assist = (frames: number) => Array.from({ length: 120 }, (_, i) => (i >= 60 && i < 60 + frames ? 0.3 : 0));
    const spans = (frames: number) => new MeasureHistory().after(event([assisted(assist(frames))], 60)).bad_spans('human', measure('root_assist_bw'));
    // the rms of n frames of 30 % among 17 exceeds 15 % if n > 17 / 4
    expect([2, 4, 5].map((n) => spans(n).length)).toEqual([0, 0, 1]);
  });
  it('marks everything after a fall', () => {
    const spans = history([0, 0, 0, 0, 0], 2).bad_spans('human', measure('fell'));
    expect(spans.map((s) => [s.from, s.to])).toEqual([[0.2, 0.5]]);
  });
  it('continues with later frames, and replaces frames that were computed again', () => {
    let made = history([0, 4, 4, 4], 1);
    made = made.after(event([samples([1, 1])], 10, 4));
    expect(made.values('human', 'foot_slip_cm')).toEqual([0, 4, 4, 4, 1, 1]);
    made = made.after(event([samples([0])], 10, 2));
    expect(made.values('human', 'foot_slip_cm')).toEqual([0, 4, 0]);
    expect(made.frames).toBe(3);
    expect(made.after(event([samples([7])], 10, 9))).toBe(made);
  });
  it('an event from frame 0 replaces all characters', () => {
    const made = history([1, 2]).after(event([{ ...samples([3]), id: 'dog' }]));
    expect(made.values('human', 'foot_slip_cm')).toEqual([]);
    expect(made.values('dog', 'foot_slip_cm')).toEqual([3]);
  });
  it('writes a table with one row for each frame', () => {
    const text = history([0, 4], 1).csv([{ id: 'human', name: 'Ann, "A"' }, { id: 'ball', name: 'Ball' }]);
    expect(text.split('\r\n')).toEqual([
      'time_s,"Ann, ""A"": root_assist_bw","Ann, ""A"": tracking_deg","Ann, ""A"": foot_slip_cm","Ann, ""A"": toe_clearance_mm","Ann, ""A"": fell"',
      '0,0,1,0,,0',
      '0.1,0.01,1,4,,1',
      '',
    ]);
  });
});

describe('next_span', () => {
  const spans = history([0, 4, 0, 0, 0, 5, 0, 0, 9]).bad_spans('human', measure('foot_slip_cm'));
  it('goes forwards and backwards from the playhead', () => {
    expect(next_span(spans, 0)!.at).toBe(0.1);
    expect(next_span(spans, 0.1)!.at).toBe(0.5);
    expect(next_span(spans, 0.5, true)!.at).toBe(0.1);
    expect(next_span(spans, 0.8)).toBeNull();
    expect(next_span(spans, 0.1, true)).toBeNull();
  });
});
