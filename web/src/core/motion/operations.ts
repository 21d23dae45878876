/** What can be done with the motion of a clip, in words for people; docs/studio-protocol.md has the same operations for programs. */
import { find_character, type Clip, type ScenarioDocument } from '../document';

export type Value = number | boolean | string | number[] | string[];
export type Values = Record<string, Value>;

interface FieldBase {
  key: string;
  label: string;
  title?: string;
  /** Absent: always. */
  when?: (values: Values) => boolean;
}
export type Field =
  | (FieldBase & { kind: 'number'; value: number; unit?: string; min: number; max: number; step: number; digits?: number; slider?: boolean })
  | (FieldBase & { kind: 'switch'; value: boolean })
  | (FieldBase & { kind: 'choice'; value: string; choices: [string, string][] })
  /** Links of the figure, with all behind them; none: all of it. */
  | (FieldBase & { kind: 'links'; value: string[] });

export type OperationGroup = 'time' | 'shape' | 'ground' | 'two' | 'body';

export interface Operation {
  id: string;
  label: string;
  /** Where there is little room. */
  short: string;
  group: OperationGroup;
  /** One sentence: what it does. */
  hint: string;
  needs: 'nothing' | 'next' | 'motion' | 'body';
  fields: Field[];
  /** The options that the service gets; absent: the values of the fields that are shown. */
  options?: (values: Values) => Values;
  /** The slider between the two motions. */
  between?: string;
}

const percent = (value: Value | undefined): number => (typeof value === 'number' ? value / 100 : 1);

/** What is asked where another motion acts on parts of the figure. @param most greatest weight, % */
const of_parts = (most: number): Pick<Operation, 'fields' | 'options'> => ({
  fields: [
    { kind: 'links', key: 'joints', label: 'Which parts', value: [], title: 'Each with everything behind it; none: the whole figure' },
    { kind: 'number', key: 'weight', label: 'Weight', unit: '%', value: 100, min: 0, max: most, step: 1, digits: 0, slider: true },
    { kind: 'number', key: 'fade', label: 'Fade', unit: 's', value: 0.2, min: 0, max: 10, step: 0.01 },
  ],
  options: (v) => ({ joints: v.joints!, weight: percent(v.weight), fade: v.fade! }),
});

export const operations: readonly Operation[] = [
  { id: 'trim', label: 'Trim to what the clip shows', short: 'Trim', group: 'time', needs: 'nothing', fields: [], hint: 'The motion becomes the part that the clip shows, with its speed and its rounds.' },
  { id: 'join', label: 'Join with next clip', short: 'Join next', group: 'time', needs: 'next', fields: [], hint: 'Both clips become one motion; where they overlap, one goes over into the other.' },
  {
    id: 'cycle', label: 'Make cyclic', short: 'Cyclic', group: 'time', needs: 'nothing', hint: 'Finds the best round in what the clip shows, closes its seam and loops it.',
    fields: [{ kind: 'switch', key: 'lock', label: 'Keep feet in place', value: true, title: 'Standing feet neither slide nor sink afterwards' }],
  },
  {
    id: 'warp', label: 'Change speed', short: 'Speed', group: 'time', needs: 'nothing', hint: 'Slower here, faster there; 100 % is the speed as it is.',
    fields: (['begin', 'middle', 'end'] as const).map((key, i): Field => ({ kind: 'number', key, label: ['At the start', 'In the middle', 'At the end'][i]!, unit: '%', value: 100, min: 10, max: 400, step: 1, digits: 0, slider: true })),
    options: (v) => ({ speeds: [v.begin, v.middle, v.end] as number[] }),
  },
  { id: 'reverse', label: 'Reverse', short: 'Reverse', group: 'time', needs: 'nothing', fields: [], hint: 'Plays it backwards.' },
  {
    id: 'resample', label: 'Resample', short: 'Resample', group: 'time', needs: 'nothing', hint: 'Another number of frames a second; the motion lasts as long as before.',
    fields: [{ kind: 'number', key: 'rate', label: 'Frame rate', unit: '/ s', value: 60, min: 1, max: 1000, step: 1, digits: 0 }],
  },

  { id: 'mirror', label: 'Mirror', short: 'Mirror', group: 'shape', needs: 'nothing', fields: [], hint: 'Exchanges left and right.' },
  {
    id: 'scale', label: 'Scale', short: 'Scale', group: 'shape', needs: 'nothing', hint: 'Longer or shorter steps over the ground, more or less time.',
    fields: [
      { kind: 'number', key: 'way', label: 'Way', unit: '%', value: 100, min: 20, max: 300, step: 1, digits: 0, slider: true, title: 'Length of the way over the ground; feet stay in place' },
      { kind: 'number', key: 'time', label: 'Time', unit: '%', value: 100, min: 20, max: 500, step: 1, digits: 0, slider: true, title: '200 % lasts twice as long' },
    ],
    options: (v) => ({ way: percent(v.way), time: percent(v.time) }),
  },
  {
    id: 'path', label: 'Change way over the ground', short: 'Way', group: 'shape', needs: 'nothing', hint: 'The same steps along another way; standing feet stay in place.',
    fields: [
      { kind: 'choice', key: 'shape', label: 'Way', value: 'turn', choices: [['straight', 'straight on'], ['turn', 'turn'], ['to', 'end at a place']] },
      { kind: 'number', key: 'turn', label: 'Turn', unit: '°', value: 90, min: -720, max: 720, step: 1, digits: 0, title: 'Positive: to the left', when: (v) => v.shape === 'turn' },
      { kind: 'number', key: 'forward', label: 'Forwards', unit: 'm', value: 2, min: -100, max: 100, step: 0.01, title: 'Where it ends, seen from where it begins', when: (v) => v.shape === 'to' },
      { kind: 'number', key: 'left', label: 'To the left', unit: 'm', value: 0, min: -100, max: 100, step: 0.01, when: (v) => v.shape === 'to' },
    ],
  },
  {
    id: 'reduce', label: 'Reduce keys', short: 'Keys', group: 'shape', needs: 'nothing', hint: 'As few keys as keep every joint within a bound, with smooth curves between them.',
    fields: [
      { kind: 'number', key: 'degrees', label: 'Angles within', unit: '°', value: 0.25, min: 0.01, max: 20, step: 0.01 },
      { kind: 'number', key: 'metres', label: 'Places within', unit: 'mm', value: 1, min: 0.01, max: 100, step: 0.1, digits: 1 },
    ],
    options: (v) => ({ degrees: v.degrees!, metres: (v.metres as number) / 1000 }),
  },

  {
    id: 'contacts', label: 'Find contacts', short: 'Contacts', group: 'ground', needs: 'nothing', hint: 'Finds when each foot stands, and shows it under the clip.',
    fields: [{ kind: 'switch', key: 'find_ground', label: 'Find the ground too', value: false, title: 'For motions whose ground is not at height 0' }],
  },
  {
    id: 'lock', label: 'Lock feet', short: 'Lock feet', group: 'ground', needs: 'nothing', hint: 'Feet that stand stay where they are.',
    fields: [{ kind: 'number', key: 'ease', label: 'Ease', unit: 's', value: 0.12, min: 0, max: 2, step: 0.01, title: 'Time in which a foot comes to rest and leaves' }],
  },

  {
    id: 'blend', label: 'Blend with another motion', short: 'Blend', group: 'two', needs: 'motion', hint: 'A motion between the two, with steps that fit: from a walk and a run, a jog.', between: 'percent',
    fields: [{ kind: 'number', key: 'percent', label: 'Share', unit: '%', value: 50, min: 0, max: 100, step: 1, digits: 0 }],
  },
  {
    id: 'mix', label: 'Mix joints of another motion', short: 'Mix joints', group: 'two', needs: 'motion', hint: 'Parts of the figure do what they do in the other motion.',
    ...of_parts(100),
  },
  {
    id: 'layer', label: 'Add another motion as a layer', short: 'Layer', group: 'two', needs: 'motion', hint: 'What the other motion does, counted from its first frame, comes on top of this one.',
    ...of_parts(200),
  },

  {
    id: 'retarget', label: 'For another body', short: 'Other body', group: 'body', needs: 'body', hint: 'A new figure beside this one does the same, with feet that stand and joints within their limits.',
    fields: [{ kind: 'switch', key: 'balance', label: 'Keep balance', value: false, title: 'The centre of mass stays over the standing feet; for slow motions of robots' }],
  },
];

export const find_operation = (id: string): Operation | undefined => operations.find((o) => o.id === id);

/** What needs nothing more from the user is done at once. */
export const asks = (operation: Operation): boolean => operation.fields.length > 0 || operation.needs === 'motion' || operation.needs === 'body';

export const first_values = (operation: Operation): Values => Object.fromEntries(operation.fields.map((f) => [f.key, f.value]));

export function options_of(operation: Operation, values: Values): Values {
  if (operation.options) return operation.options(values);
  return Object.fromEntries(operation.fields.filter((f) => !f.when || f.when(values)).map((f) => [f.key, values[f.key]!]));
}

/** Why an operation cannot be done with this clip; null: it can. */
export function refusal(operation: Operation, document: ScenarioDocument, character: string, clip: Clip): string | null {
  if (operation.needs !== 'next') return null;
  const later = find_character(document, character)?.track.some((k) => k.id !== clip.id && k.start >= clip.start);
  return later ? null : 'No clip comes after it on this track.';
}
