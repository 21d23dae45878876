/**
 * Operations on the motion of a clip, with their labels, hints and option fields. docs/studio-protocol.md defines the same operations as
 * requests.
 */
import { find_character, type Clip, type ScenarioDocument } from '../document';

export type Value = number | boolean | string | number[] | string[];
export type Values = Record<string, Value>;

interface FieldBase {
  key: string;
  label: string;
  title?: string;
  /** The field is shown if this returns true; absent: always shown. */
  when?: (values: Values) => boolean;
}
export type Field =
  | (FieldBase & { kind: 'number'; value: number; unit?: string; min: number; max: number; step: number; digits?: number; slider?: boolean })
  | (FieldBase & { kind: 'switch'; value: boolean })
  | (FieldBase & { kind: 'choice'; value: string; choices: [string, string][] })
  /** A choice of links of the character, each with all its descendants; none chosen: all links. */
  | (FieldBase & { kind: 'links'; value: string[] });

export type OperationGroup = 'time' | 'shape' | 'ground' | 'two' | 'body';

export interface Operation {
  id: string;
  label: string;
  /** Short label, for places with little space. */
  short: string;
  group: OperationGroup;
  /** One sentence that describes the effect. */
  hint: string;
  /** The second operand: the next clip on the track, another motion, or a target body. */
  needs: 'nothing' | 'next' | 'motion' | 'body';
  fields: Field[];
  /** Converts field values to the request's options; absent: the values of the visible fields are the options. */
  options?: (values: Values) => Values;
  /** Key of the field that is shown as a slider between the two motions. */
  between?: string;
}

const percent = (value: Value | undefined): number => (typeof value === 'number' ? value / 100 : 1);

/** Fields and options of an operation in which another motion acts on chosen parts of the character. @param max_weight % */
const of_parts = (max_weight: number): Pick<Operation, 'fields' | 'options'> => ({
  fields: [
    { kind: 'links', key: 'joints', label: 'Which parts', value: [], title: 'Each part includes everything attached to it. Choose none for the whole character.' },
    { kind: 'number', key: 'weight', label: 'Weight', unit: '%', value: 100, min: 0, max: max_weight, step: 1, digits: 0, slider: true },
    { kind: 'number', key: 'fade', label: 'Fade', unit: 's', value: 0.2, min: 0, max: 10, step: 0.01 },
  ],
  options: (v) => ({ joints: v.joints!, weight: percent(v.weight), fade: v.fade! }),
});

export const operations: readonly Operation[] = [
  { id: 'trim', label: 'Trim to what the clip shows', short: 'Trim', group: 'time', needs: 'nothing', fields: [], hint: 'Cuts the motion to the part that the clip shows, with the clip\'s speed and repetitions.' },
  { id: 'join', label: 'Join with next clip', short: 'Join next', group: 'time', needs: 'next', fields: [], hint: 'Joins both clips into one motion; where they overlap, the first blends into the second.' },
  {
    id: 'cycle', label: 'Make cyclic', short: 'Cyclic', group: 'time', needs: 'nothing', hint: 'Finds the best cycle in what the clip shows, makes its end match its start, and loops it.',
    fields: [{ kind: 'switch', key: 'lock', label: 'Keep feet in place', value: true, title: 'Standing feet do not slide or sink in the result' }],
  },
  {
    id: 'warp', label: 'Change speed', short: 'Speed', group: 'time', needs: 'nothing', hint: 'Changes the speed over the motion; 100 % keeps the original speed.',
    fields: (['begin', 'middle', 'end'] as const).map((key, i): Field => ({ kind: 'number', key, label: ['At the start', 'In the middle', 'At the end'][i]!, unit: '%', value: 100, min: 10, max: 400, step: 1, digits: 0, slider: true })),
    options: (v) => ({ speeds: [v.begin, v.middle, v.end] as number[] }),
  },
  { id: 'reverse', label: 'Reverse', short: 'Reverse', group: 'time', needs: 'nothing', fields: [], hint: 'Plays the motion backwards.' },
  {
    id: 'resample', label: 'Resample', short: 'Resample', group: 'time', needs: 'nothing', hint: 'Changes the number of frames a second; the motion keeps its duration.',
    fields: [{ kind: 'number', key: 'rate', label: 'Frame rate', unit: '/ s', value: 60, min: 1, max: 1000, step: 1, digits: 0 }],
  },

  { id: 'mirror', label: 'Mirror', short: 'Mirror', group: 'shape', needs: 'nothing', fields: [], hint: 'Exchanges left and right.' },
  {
    id: 'scale', label: 'Scale', short: 'Scale', group: 'shape', needs: 'nothing', hint: 'Scales the distance over the ground and the duration.',
    fields: [
      { kind: 'number', key: 'way', label: 'Distance', unit: '%', value: 100, min: 20, max: 300, step: 1, digits: 0, slider: true, title: 'Distance over the ground; standing feet stay in place' },
      { kind: 'number', key: 'time', label: 'Duration', unit: '%', value: 100, min: 20, max: 500, step: 1, digits: 0, slider: true, title: '200 % lasts twice as long' },
    ],
    options: (v) => ({ way: percent(v.way), time: percent(v.time) }),
  },
  {
    id: 'path', label: 'Change path over the ground', short: 'Path', group: 'shape', needs: 'nothing', hint: 'The same steps along another path; standing feet stay in place.',
    fields: [
      { kind: 'choice', key: 'shape', label: 'Path', value: 'turn', choices: [['straight', 'straight'], ['turn', 'turn'], ['to', 'end at a point']] },
      { kind: 'number', key: 'turn', label: 'Turn', unit: '°', value: 90, min: -720, max: 720, step: 1, digits: 0, title: 'Positive: to the left', when: (v) => v.shape === 'turn' },
      { kind: 'number', key: 'forward', label: 'Forwards', unit: 'm', value: 2, min: -100, max: 100, step: 0.01, title: 'End point relative to the start point and direction', when: (v) => v.shape === 'to' },
      { kind: 'number', key: 'left', label: 'To the left', unit: 'm', value: 0, min: -100, max: 100, step: 0.01, when: (v) => v.shape === 'to' },
    ],
  },
  {
    id: 'reduce', label: 'Reduce keys', short: 'Keys', group: 'shape', needs: 'nothing', hint: 'Keeps as few keys as possible, with smooth curves between them, so that every joint stays within the bounds.',
    fields: [
      { kind: 'number', key: 'degrees', label: 'Angles within', unit: '°', value: 0.25, min: 0.01, max: 20, step: 0.01 },
      { kind: 'number', key: 'metres', label: 'Positions within', unit: 'mm', value: 1, min: 0.01, max: 100, step: 0.1, digits: 1 },
    ],
    options: (v) => ({ degrees: v.degrees!, metres: (v.metres as number) / 1000 }),
  },

  {
    id: 'contacts', label: 'Find contacts', short: 'Contacts', group: 'ground', needs: 'nothing', hint: 'Finds when each foot stands on the ground, and shows it under the clip.',
    fields: [{ kind: 'switch', key: 'find_ground', label: 'Find the ground too', value: false, title: 'For motions whose ground is not at height 0' }],
  },
  {
    id: 'lock', label: 'Lock feet', short: 'Lock feet', group: 'ground', needs: 'nothing', hint: 'Keeps standing feet from sliding.',
    fields: [{ kind: 'number', key: 'ease', label: 'Ease', unit: 's', value: 0.12, min: 0, max: 2, step: 0.01, title: 'Time in which a foot blends into and out of its locked position' }],
  },
  {
    id: 'correct', label: 'Correct the physics', short: 'Correct', group: 'ground', needs: 'nothing', hint: 'Changes the motion as little as possible so that forces of the ground can make it: feet do not slide or sink, flights are parabolas, balance is kept.',
    fields: [
      { kind: 'number', key: 'percent', label: 'Strength', unit: '%', value: 100, min: 0, max: 100, step: 1, digits: 0, slider: true, title: '0 % keeps the motion, 100 % is the complete correction' },
      { kind: 'switch', key: 'find_floor', label: 'Find the floor', value: true, title: 'Moves and levels the floor on which the feet stand' },
      { kind: 'switch', key: 'keep_duration', label: 'Keep the duration', value: false, title: 'Flights keep their duration, even if gravity is wrong in them' },
    ],
  },

  {
    id: 'blend', label: 'Blend with another motion', short: 'Blend', group: 'two', needs: 'motion', hint: 'Makes a motion between the two with matching steps: a walk and a run give a jog.', between: 'percent',
    fields: [{ kind: 'number', key: 'percent', label: 'Share', unit: '%', value: 50, min: 0, max: 100, step: 1, digits: 0 }],
  },
  {
    id: 'mix', label: 'Mix joints of another motion', short: 'Mix joints', group: 'two', needs: 'motion', hint: 'The chosen parts of the character follow the other motion.',
    ...of_parts(100),
  },
  {
    id: 'layer', label: 'Add another motion as a layer', short: 'Layer', group: 'two', needs: 'motion', hint: 'Adds the other motion\'s movement, relative to its first frame, to this motion.',
    ...of_parts(200),
  },

  {
    id: 'retarget', label: 'For another body', short: 'Another body', group: 'body', needs: 'body', hint: 'Adds a character with another body that performs the same motion, with standing feet and joints within their limits.',
    fields: [{ kind: 'switch', key: 'balance', label: 'Keep balance', value: false, title: 'The centre of mass stays over the standing feet; for slow motions of robots' }],
  },
];

export const find_operation = (id: string): Operation | undefined => operations.find((o) => o.id === id);

/** Whether an operation needs input from the user; otherwise it runs at once. */
export const asks = (operation: Operation): boolean => operation.fields.length > 0 || operation.needs === 'motion' || operation.needs === 'body';

/** Initial values of an operation's fields. */
export const first_values = (operation: Operation): Values => Object.fromEntries(operation.fields.map((f) => [f.key, f.value]));

/** Options of the request for the field values `values`. */
export function options_of(operation: Operation, values: Values): Values {
  if (operation.options) return operation.options(values);
  return Object.fromEntries(operation.fields.filter((f) => !f.when || f.when(values)).map((f) => [f.key, values[f.key]!]));
}

/** Why an operation cannot be applied to this clip, as a sentence; null if it can. */
export function refusal(operation: Operation, document: ScenarioDocument, character: string, clip: Clip): string | null {
  if (operation.needs !== 'next') return null;
  const later = find_character(document, character)?.track.some((k) => k.id !== clip.id && k.start >= clip.start);
  return later ? null : 'It is the last clip of its track, so there is no clip to join.';
}
