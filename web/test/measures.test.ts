import { describe, expect, it } from 'vitest';
import { describe_span, MeasureHistory, next_span, timed_measures, type Timed } from '../src/core/measures';
import type { MeasureSamples } from '../src/core/protocol';

const measure = (key: Timed['key']): Timed => timed_measures.find((m) => m.key === key)!;
const samples = (slip: number[], fell: number | null = null): MeasureSamples => ({
  id: 'human', tracking_deg: slip.map(() => 1), assist_bw: slip.map((_, i) => i / 100), slip_cm: slip, depth_mm: slip.map(() => 0), fell,
});
const history = (slip: number[], fell: number | null = null): MeasureHistory => new MeasureHistory().after({ rate: 10, from: 0, characters: [samples(slip, fell)] });

describe('MeasureHistory', () => {
  it('has a limit for each measure of ugoki judge', () => {
    expect(timed_measures.map((m) => [m.key, m.bad])).toEqual([['assist_bw', 15], ['tracking_deg', 5], ['slip_cm', 3], ['depth_mm', 20], ['fell', 0]]);
  });
  it('finds the spans above the limit with their maximum', () => {
    const spans = history([0, 4, 5, 4, 0, 0, 0, 3.1, 0]).bad_spans('human', measure('slip_cm'));
    expect(spans.map(({ from, to, at, peak }) => ({ from, to, at, peak }))).toEqual([
      { from: 0.1, to: 0.4, at: 0.2, peak: 5 },
      { from: 0.7, to: 0.8, at: 0.7, peak: 3.1 },
    ]);
    expect(describe_span(spans[0]!)).toBe('Foot skate 5.0 cm, 0.10 to 0.40 s');
  });
  it('joins spans that are too near to be clicked separately', () => {
    const values = Array.from({ length: 60 }, (_, i) => (i % 2 === 0 && i < 30 ? 9 : 0));
    const made = new MeasureHistory().after({ rate: 60, from: 0, characters: [samples(values)] });
    expect(made.bad_spans('human', measure('slip_cm'))).toHaveLength(1);
  });
  it('compares in the displayed unit: 0.15 body weights are 15 %', () => {
    const still = { ...samples(Array.from({ length: 20 }, () => 0)), assist_bw: Array.from({ length: 20 }, (_, i) => (i < 10 ? 0.1 : 0.2)) };
    const made = new MeasureHistory().after({ rate: 4, from: 0, characters: [still] });
    expect(made.value_at('human', measure('assist_bw'), 0.5)).toBeCloseTo(10, 9);
    expect(made.peak('human', measure('assist_bw'))!.value).toBeCloseTo(20, 9);
    expect(made.value_at('human', measure('assist_bw'), 50)).toBeNaN();
    expect(made.bad_spans('human', measure('assist_bw'))).toHaveLength(1);
  });
  it('averages measures with an rms limit over 0.25 s, so that a short peak is not bad, but a longer one is', () => {
    const assist = (frames: number) => Array.from({ length: 120 }, (_, i) => (i >= 60 && i < 60 + frames ? 0.3 : 0));
    const spans = (frames: number) => new MeasureHistory().after({ rate: 60, from: 0, characters: [{ ...samples(assist(frames)), assist_bw: assist(frames) }] }).bad_spans('human', measure('assist_bw'));
    // the rms of n frames of 30 % among 17 exceeds 15 % if n > 17 / 4
    expect([2, 4, 5].map((n) => spans(n).length)).toEqual([0, 0, 1]);
  });
  it('marks everything after a fall', () => {
    const spans = history([0, 0, 0, 0, 0], 2).bad_spans('human', measure('fell'));
    expect(spans.map((s) => [s.from, s.to])).toEqual([[0.2, 0.5]]);
  });
  it('continues with later frames, and replaces frames that were computed again', () => {
    let made = history([0, 4, 4, 4], 1);
    made = made.after({ rate: 10, from: 4, characters: [samples([1, 1])] });
    expect(made.values('human', 'slip_cm')).toEqual([0, 4, 4, 4, 1, 1]);
    made = made.after({ rate: 10, from: 2, characters: [samples([0])] });
    expect(made.values('human', 'slip_cm')).toEqual([0, 4, 0]);
    expect(made.frames).toBe(3);
    expect(made.after({ rate: 10, from: 9, characters: [samples([7])] })).toBe(made);
  });
  it('an event from frame 0 replaces all characters', () => {
    const made = history([1, 2]).after({ rate: 10, from: 0, characters: [{ ...samples([3]), id: 'dog' }] });
    expect(made.values('human', 'slip_cm')).toEqual([]);
    expect(made.values('dog', 'slip_cm')).toEqual([3]);
  });
  it('writes a table with one row for each frame', () => {
    const text = history([0, 4], 1).csv([{ id: 'human', name: 'Ann, "A"' }, { id: 'ball', name: 'Ball' }]);
    expect(text.split('\r\n')).toEqual([
      'time_s,"Ann, ""A"": root_assist_bw","Ann, ""A"": tracking_deg","Ann, ""A"": foot_slip_cm","Ann, ""A"": penetration_mm","Ann, ""A"": fell"',
      '0,0,1,0,0,0',
      '0.1,0.01,1,4,0,1',
      '',
    ]);
  });
});

describe('next_span', () => {
  const spans = history([0, 4, 0, 0, 0, 5, 0, 0, 9]).bad_spans('human', measure('slip_cm'));
  it('goes forwards and backwards from the playhead', () => {
    expect(next_span(spans, 0)!.at).toBe(0.1);
    expect(next_span(spans, 0.1)!.at).toBe(0.5);
    expect(next_span(spans, 0.5, true)!.at).toBe(0.1);
    expect(next_span(spans, 0.8)).toBeNull();
    expect(next_span(spans, 0.1, true)).toBeNull();
  });
});
