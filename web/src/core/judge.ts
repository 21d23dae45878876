/** The naturalness measures of a summary, with their limits for good and bad values. */
import type { CharacterSummary } from './protocol';

export interface Measure {
  key: keyof CharacterSummary;
  name: string;
  meaning: string;
  unit: string;
  /** Factor from the service's unit to the displayed unit. */
  scale: number;
  digits: number;
  /** Values up to `good` are good, values above `bad` are bad; in the displayed unit. */
  good: number;
  bad: number;
}

export const measures: readonly Measure[] = [
  { key: 'assist_rms_bw', name: 'Root assist', meaning: 'Invisible help on the root, rms, of body weight', unit: '%', scale: 100, digits: 1, good: 5, bad: 15 },
  { key: 'tracking_rms_deg', name: 'Tracking', meaning: 'Joint angles against the motion, rms', unit: '°', scale: 1, digits: 1, good: 2.5, bad: 5 },
  { key: 'foot_skate_cm', name: 'Foot skate', meaning: 'Distance that a standing foot slides, mean per step', unit: 'cm', scale: 1, digits: 1, good: 1, bad: 3 },
  { key: 'penetration_mm', name: 'Penetration', meaning: 'Deepest overlap with the ground', unit: 'mm', scale: 1, digits: 1, good: 5, bad: 20 },
];

export type Grade = 'good' | 'fair' | 'bad' | 'none';

/** Grade of a measure whose displayed value is `shown`. */
export function grade(measure: Measure, shown: number): Grade {
  if (!Number.isFinite(shown)) return 'none';
  return shown <= measure.good ? 'good' : shown <= measure.bad ? 'fair' : 'bad';
}

/** The displayed value of a measure, or NaN if the summary has none. */
export function shown_value(measure: Measure, summary: CharacterSummary | undefined): number {
  const value = summary?.[measure.key];
  return typeof value === 'number' ? value * measure.scale : NaN;
}

/** Filled fraction, 0 ... 1, of a bar whose full length is 1.5 times the `bad` limit. */
export const bar_fraction = (measure: Measure, shown: number): number => Math.min(1, Math.max(0, shown / (1.5 * measure.bad)));
