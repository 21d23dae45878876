/** The naturalness measures of a summary, with the limits from which they are bad. */
import type { CharacterSummary } from './protocol';

export interface Measure {
  key: keyof CharacterSummary;
  name: string;
  meaning: string;
  unit: string;
  /** From the service's number to the number shown. */
  scale: number;
  digits: number;
  /** In shown units: good up to `good`, bad above `bad`. */
  good: number;
  bad: number;
}

export const measures: readonly Measure[] = [
  { key: 'assist_rms_bw', name: 'Root assist', meaning: 'Invisible help on the root, rms, of body weight', unit: '%', scale: 100, digits: 1, good: 5, bad: 15 },
  { key: 'tracking_rms_deg', name: 'Tracking', meaning: 'Joint angles against the motion, rms', unit: '°', scale: 1, digits: 1, good: 2.5, bad: 5 },
  { key: 'foot_skate_cm', name: 'Foot skate', meaning: 'How far feet slide while they stand, mean per step', unit: 'cm', scale: 1, digits: 1, good: 1, bad: 3 },
  { key: 'penetration_mm', name: 'Penetration', meaning: 'Deepest overlap with the ground', unit: 'mm', scale: 1, digits: 1, good: 5, bad: 15 },
];

export type Grade = 'good' | 'fair' | 'bad' | 'none';

export function grade(measure: Measure, shown: number): Grade {
  if (!Number.isFinite(shown)) return 'none';
  return shown <= measure.good ? 'good' : shown <= measure.bad ? 'fair' : 'bad';
}

/** The number shown for a measure, or NaN where the service gives none. */
export function shown_value(measure: Measure, summary: CharacterSummary | undefined): number {
  const value = summary?.[measure.key];
  return typeof value === 'number' ? value * measure.scale : NaN;
}

/** 0 ... 1 of a bar whose end is twice the bad limit. */
export const bar_fraction = (measure: Measure, shown: number): number => Math.min(1, Math.max(0, shown / (1.5 * measure.bad)));
