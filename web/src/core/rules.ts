/** Rules of a scenario (docs/scenario.md): "when the ball touches the chest of Anna, play the fall". Sentences, defaults and the state graph. */
import type { Circuit } from './circuit/form';
import type { Character, Command, PushAxes, ScenarioDocument } from './document';
import type { Vec3 } from './protocol';
import { find_variable, variable_text } from './variables';

export type ConditionType = 'key' | 'touch' | 'near' | 'time' | 'playing' | 'released' | 'variable';

export type Comparison = 'at_least' | 'at_most' | 'above' | 'below' | 'equal';

/** A condition. Only the fields of its type are present. */
export interface RuleCondition {
  type: ConditionType;
  /** True: the condition is true if what it names is false. */
  not?: boolean;
  /** KeyboardEvent.code (key). */
  key?: string;
  character?: string;
  /** Name or label of a link; empty: every link (touch, near). */
  link?: string;
  /** Id of a character, "ground", or empty for everything (touch, near). */
  other?: string;
  other_link?: string;
  /** m (near). */
  distance?: number;
  /** s (time). */
  time?: number;
  /** Id of a rule that plays a motion of `character`; empty: its track (playing). */
  rule?: string;
  /** Id of a variable (variable). */
  variable?: string;
  compare?: Comparison;
  /** Right side of the comparison (variable). */
  value?: number;
}

export type RuleAction =
  | { type: 'play'; character: string; motion: string; speed: number; blend: number; loop: boolean }
  /** `axes` absent: world. */
  | { type: 'push'; character: string; link: string; force: Vec3; axes?: PushAxes; duration: number }
  /** `other` empty: the world. `limit` in N opens the grip. */
  | { type: 'grab'; character: string; link: string; other: string; other_link: string; rigid: boolean; limit: number }
  | { type: 'release'; character: string; link: string }
  /** In the mode `while`, `add` is per second. */
  | { type: 'set'; variable: string; change: VariableChange; value: number };

export type VariableChange = 'set' | 'add' | 'toggle';

/** The character on which an action acts; empty: none. */
export const action_character = (action: RuleAction): string => ('character' in action ? action.character : '');

export interface Rule {
  id: string;
  on: boolean;
  mode: 'when' | 'while';
  if: RuleCondition[];
  do: RuleAction;
}

export const find_rule = (doc: ScenarioDocument, id: string): Rule | undefined => doc.rules?.find((r) => r.id === id);

/** Id of the LSI that does the action of a rule in the generated circuit. */
export const rule_lsi = (rule: { id: string }): string => `rule-${rule.id.replaceAll('.', '_')}`;

/** A key's name for people: "W", "Shift left", "Space". */
export function key_name(code: string): string {
  const letter = /^Key([A-Z])$/.exec(code) ?? /^Digit([0-9])$/.exec(code);
  if (letter) return letter[1]!;
  const side = /^(Shift|Control|Alt|Meta)(Left|Right)$/.exec(code);
  if (side) return `${side[1] === 'Control' ? 'Ctrl' : side[1]} ${side[2]!.toLowerCase()}`;
  const arrow = /^Arrow(Up|Down|Left|Right)$/.exec(code);
  return arrow ? { Up: '↑', Down: '↓', Left: '←', Right: '→' }[arrow[1] as 'Up']! : code.replace(/^Numpad/, 'Num ');
}

/** The condition's verb, in the positive and in the negated form. */
const verbs: Record<ConditionType, [string, string]> = {
  key: ['is held', 'is not held'],
  touch: ['touches', 'does not touch'],
  near: ['is nearer than', 'is farther than'],
  time: ['has passed', 'has not passed'],
  playing: ['plays', 'does not play'],
  released: ['has fallen', 'has not fallen'],
  variable: ['is', 'is not'],
};

export const verb_of = (type: ConditionType, negated: boolean, mode: Rule['mode']): string => (type === 'key' && !negated && mode === 'when' ? 'is pressed' : verbs[type][negated ? 1 : 0]);

/** The verb of a comparison: "reaches" when the value rises to it. */
export const comparisons: Record<Comparison, string> = { at_least: 'reaches', at_most: 'is at most', above: 'is above', below: 'is below', equal: 'is exactly' };

/** Looks up the name of a motion by its id. */
export type MotionName = (motion: string) => string;

const name_of = (doc: ScenarioDocument, id: string | undefined): string => (id === 'ground' ? 'the ground' : id ? (doc.characters.find((c) => c.id === id)?.name ?? id) : 'anything');
const part_of = (doc: ScenarioDocument, id: string | undefined, link: string | undefined): string => (link ? `${link} of ${name_of(doc, id)}` : name_of(doc, id));

/** The motion of a rule, or "its track". */
export function played_name(doc: ScenarioDocument, rule: string | undefined, motion_name: MotionName): string {
  const action = rule ? find_rule(doc, rule)?.do : undefined;
  return action?.type === 'play' ? motion_name(action.motion) : 'its track';
}

export function condition_text(doc: ScenarioDocument, c: RuleCondition, motion_name: MotionName, mode: Rule['mode'] = 'while'): string {
  const verb = verb_of(c.type, Boolean(c.not), mode);
  switch (c.type) {
    case 'key': return `${key_name(c.key ?? '')} ${verb}`;
    case 'touch': return `${part_of(doc, c.character, c.link)} ${verb} ${part_of(doc, c.other, c.other_link)}`;
    case 'near': return `${part_of(doc, c.character, c.link)} ${verb} ${c.distance} m to ${part_of(doc, c.other, c.other_link)}`;
    case 'time': return `${c.time} s ${verb}`;
    case 'playing': return `${name_of(doc, c.character)} ${verb} ${played_name(doc, c.rule, motion_name)}`;
    case 'released': return `${name_of(doc, c.character)} ${verb}`;
    case 'variable': {
      const variable = find_variable(doc, c.variable);
      if (variable?.kind === 'switch') return `${variable.name} is ${variable_text(variable, c.not ? 1 - (c.value ?? 1) : (c.value ?? 1))}`;
      return `${c.not ? 'not: ' : ''}${variable?.name ?? c.variable} ${comparisons[c.compare ?? 'at_least']} ${variable_text(variable ?? { kind: 'number' }, c.value ?? 0)}`;
    }
  }
}

function action_text(doc: ScenarioDocument, action: RuleAction, mode: Rule['mode'], motion_name: MotionName): string {
  switch (action.type) {
    case 'play': return `play ${motion_name(action.motion)} on ${name_of(doc, action.character)}`;
    case 'push': return `push ${part_of(doc, action.character, action.link)}`;
    case 'grab': return `${part_of(doc, action.character, action.link)} grabs ${action.other ? part_of(doc, action.other, action.other_link) : 'the world'}`;
    case 'release': return `${part_of(doc, action.character, action.link)} releases`;
    case 'set': {
      const variable = find_variable(doc, action.variable);
      const named = variable?.name ?? action.variable;
      const value = variable_text(variable ?? { kind: 'number' }, action.value);
      if (action.change === 'toggle') return `toggle ${named}`;
      return action.change === 'set' ? `set ${named} to ${value}` : `add ${value} to ${named}${mode === 'while' ? ' each second' : ''}`;
    }
  }
}

/** The whole rule as a sentence, for screen readers, titles and the log. */
export function rule_text(doc: ScenarioDocument, rule: Rule, motion_name: MotionName): string {
  const conditions = rule.if.map((c) => condition_text(doc, c, motion_name, rule.mode)).join(' and ');
  return `${rule.mode === 'when' ? 'When' : 'While'} ${conditions}, ${action_text(doc, rule.do, rule.mode, motion_name)}`;
}

/** The reason why a rule has no effect, as a sentence with the remedy; null if it has one. */
export function rule_problem(doc: ScenarioDocument, rule: Rule): string | null {
  if (doc.circuit) return 'The project has a circuit of its own, in which rules have no effect. Reset it to the generated circuit, or wire the rule there.';
  const character = doc.characters.find((c) => c.id === action_character(rule.do));
  if (!character || rule.do.type !== 'play') return null;
  if (character.control.mode === 'passive') return `${character.name} is a passive body. Set its drive to “Follow the track”.`;
  if (character.track.length === 0) return `${character.name} has no clip. Drag a motion onto its track; it plays while no rule is active.`;
  if (character.control.assist_limit === 0) return `${character.name} balances without root assist and ignores rules. Set its assist limit above 0 %.`;
  return null;
}

/** A condition of a type with default values. @param characters the preferred characters, best first */
export function new_condition(type: ConditionType, doc: ScenarioDocument, character: string): RuleCondition {
  const other = doc.characters.find((c) => c.id !== character && c.control.mode === 'passive') ?? doc.characters.find((c) => c.id !== character);
  switch (type) {
    case 'key': return { type, key: free_key(doc) };
    case 'touch': return { type, character: other?.id ?? character, link: '', other: other ? character : 'ground', other_link: '' };
    case 'near': return { type, character: other?.id ?? character, other: character, distance: 0.5 };
    case 'time': return { type, time: 2 };
    case 'playing': return { type, character, rule: '' };
    case 'released': return { type, character };
    case 'variable': {
      const variable = doc.variables?.[0];
      return variable_condition(variable?.id ?? '', variable?.kind ?? 'number');
    }
  }
}

/** "The switch is on", or "the number reaches 3". */
export const variable_condition = (variable: string, kind: 'number' | 'switch'): RuleCondition =>
  kind === 'switch' ? { type: 'variable', variable, compare: 'equal', value: 1 } : { type: 'variable', variable, compare: 'at_least', value: 3 };

/** "Add 1 to the number", or "toggle the switch". */
export const variable_action = (variable: string, kind: 'number' | 'switch'): RuleAction => ({ type: 'set', variable, change: kind === 'switch' ? 'toggle' : 'add', value: 1 });

/** Types of conditions that the scenario can have: the distance needs two characters, a comparison needs a variable. */
export const possible_conditions = (doc: ScenarioDocument): ConditionType[] =>
  (['key', 'touch', 'near', 'time', 'playing', 'released', 'variable'] as const).filter((t) => (t !== 'near' || doc.characters.length > 1) && (t !== 'variable' || (doc.variables?.length ?? 0) > 0));

/** The first of W, A, S, D, Space, ... that no rule reads. */
function free_key(doc: ScenarioDocument): string {
  const used = new Set((doc.rules ?? []).flatMap((r) => r.if.map((c) => c.key)));
  return ['KeyW', 'Space', 'KeyA', 'KeyS', 'KeyD', 'KeyQ', 'KeyE', 'KeyF', 'KeyX'].find((k) => !used.has(k)) ?? 'KeyW';
}

/** The character for which a new rule is made: the preferred one, otherwise the first that follows a track, otherwise the first. */
export function character_for_rule(doc: ScenarioDocument, preferred: string | undefined): Character | undefined {
  return doc.characters.find((c) => c.id === preferred && c.control.mode === 'track') ?? doc.characters.find((c) => c.control.mode === 'track' && c.track.length > 0) ?? doc.characters[0];
}

/** Changes one rule. Only `mode`, `if`, `do` and `on` that are given are sent. */
export const set_rule = (id: string, fields: Partial<Omit<Rule, 'id'>>): Command => ({ type: 'rule.set', id, rule: fields });

/** A state of a character's state graph: its track, or a motion of a rule. */
export interface GraphState {
  /** Id of the first rule that plays the motion; empty: the track. */
  rule: string;
  /** All rules that play the motion at this speed. */
  rules: readonly string[];
  motion: string;
  /** Duration of the motion in s at its speed; null: it repeats, or it is the track. */
  speed: number;
  loop: boolean;
}
/** A transition. `back` transitions end a motion: its end, or the end of a `while`. */
export interface GraphEdge {
  from: string;
  to: string;
  conditions: readonly RuleCondition[];
  mode: 'when' | 'while';
  back: boolean;
}

/** The state machine that the rules of a character form. A rule without a condition `playing` leads there from the track. */
export function state_graph(doc: ScenarioDocument, character: string): { states: GraphState[]; edges: GraphEdge[] } {
  const states: (GraphState & { rules: string[] })[] = [{ rule: '', rules: [''], motion: '', speed: 1, loop: true }];
  const edges: GraphEdge[] = [];
  const rules = (doc.rules ?? []).filter((r) => r.on && r.do.type === 'play' && r.do.character === character);
  for (const rule of rules) {
    if (rule.do.type !== 'play') continue;
    const { motion, speed, loop } = rule.do;
    const same = states.find((s) => s.rule && s.motion === motion && s.speed === speed && s.loop === loop);
    if (same) same.rules.push(rule.id);
    else states.push({ rule: rule.id, rules: [rule.id], motion, speed, loop });
  }
  const state_of = (rule: string): string => states.find((s) => s.rules.includes(rule))!.rule;
  for (const rule of rules) {
    if (rule.do.type !== 'play') continue;
    const origins = rule.if.filter((c) => c.type === 'playing' && !c.not && c.character === character && (!c.rule || rules.some((r) => r.id === c.rule)));
    const conditions = rule.if.filter((c) => !origins.includes(c));
    for (const from of origins.length > 0 ? origins.map((c) => c.rule ?? '') : ['']) edges.push({ from: state_of(from), to: state_of(rule.id), conditions, mode: rule.mode, back: false });
    if (rule.mode === 'while' || !rule.do.loop) edges.push({ from: state_of(rule.id), to: '', conditions, mode: rule.mode, back: true });
  }
  return { states, edges };
}

/**
 * A rule that leads from one state of the graph to another, when a key is pressed.
 * @param from, to rules of the states; empty: the track  @returns null for transitions to the track, which end by themselves
 */
export function transition_rule(doc: ScenarioDocument, character: string, from: string, to: string): Omit<Rule, 'id'> | null {
  const action = find_rule(doc, to)?.do;
  if (action?.type !== 'play' || from === to) return null;
  return { on: true, mode: 'when', if: [{ type: 'playing', character, rule: from }, new_condition('key', doc, character)], do: { ...action } };
}

/** Path of the LSI `motion choice` of a character in a generated circuit; undefined: there is none. */
export function choice_path(circuit: Circuit | null | undefined, character: string | undefined): string | undefined {
  for (const inner of circuit?.circuits ?? []) {
    const lsi = inner.lsis?.find((l) => l.type === 'motion choice' && l.parameters?.character === character);
    const box = lsi && circuit!.lsis?.find((l) => l.type === inner.name);
    if (box) return `${box.id}/${lsi.id}`;
  }
  return undefined;
}
