/** Rules of a scenario (docs/scenario.md): "when the ball touches the chest of Anna, play the fall". Sentences, defaults and the state graph. */
import type { Character, Command, ScenarioDocument } from './document';
import type { Vec3 } from './protocol';

export type ConditionType = 'key' | 'touch' | 'near' | 'time' | 'playing' | 'released';

/** A condition. Only the fields of its type are present. */
export interface RuleCondition {
  type: ConditionType;
  /** True: the condition is true if what it names is false. */
  not?: boolean;
  /** KeyboardEvent.code (key). */
  key?: string;
  character?: string;
  /** Name or label of a link; empty: every link (touch). */
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
}

export type RuleAction =
  | { type: 'play'; character: string; motion: string; speed: number; blend: number; loop: boolean }
  | { type: 'push'; character: string; link: string; force: Vec3; duration: number };

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
};

export const verb_of = (type: ConditionType, negated: boolean, mode: Rule['mode']): string => (type === 'key' && !negated && mode === 'when' ? 'is pressed' : verbs[type][negated ? 1 : 0]);

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
    case 'near': return `${name_of(doc, c.character)} ${verb} ${c.distance} m to ${name_of(doc, c.other)}`;
    case 'time': return `${c.time} s ${verb}`;
    case 'playing': return `${name_of(doc, c.character)} ${verb} ${played_name(doc, c.rule, motion_name)}`;
    case 'released': return `${name_of(doc, c.character)} ${verb}`;
  }
}

/** The whole rule as a sentence, for screen readers, titles and the log. */
export function rule_text(doc: ScenarioDocument, rule: Rule, motion_name: MotionName): string {
  const conditions = rule.if.map((c) => condition_text(doc, c, motion_name, rule.mode)).join(' and ');
  const action = rule.do.type === 'play' ? `play ${motion_name(rule.do.motion)} on ${name_of(doc, rule.do.character)}` : `push ${part_of(doc, rule.do.character, rule.do.link)}`;
  return `${rule.mode === 'when' ? 'When' : 'While'} ${conditions}, ${action}`;
}

/** The reason why a rule has no effect, as a sentence with the remedy; null if it has one. */
export function rule_problem(doc: ScenarioDocument, rule: Rule): string | null {
  if (doc.circuit) return 'The project has a circuit of its own, in which rules have no effect. Reset it to the generated circuit, or wire the rule there.';
  const character = doc.characters.find((c) => c.id === rule.do.character);
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
  }
}

/** Types of conditions that the scenario can have: the distance needs two characters. */
export const possible_conditions = (doc: ScenarioDocument): ConditionType[] =>
  (['key', 'touch', 'near', 'time', 'playing', 'released'] as const).filter((t) => t !== 'near' || doc.characters.length > 1);

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
  /** Id of the rule; empty: the track. */
  rule: string;
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
  const states: GraphState[] = [{ rule: '', motion: '', speed: 1, loop: true }];
  const edges: GraphEdge[] = [];
  const rules = (doc.rules ?? []).filter((r) => r.on && r.do.type === 'play' && r.do.character === character);
  for (const rule of rules) {
    if (rule.do.type !== 'play') continue;
    states.push({ rule: rule.id, motion: rule.do.motion, speed: rule.do.speed, loop: rule.do.loop });
    const origins = rule.if.filter((c) => c.type === 'playing' && !c.not && c.character === character && (!c.rule || rules.some((r) => r.id === c.rule)));
    const conditions = rule.if.filter((c) => !origins.includes(c));
    for (const from of origins.length > 0 ? origins.map((c) => c.rule ?? '') : ['']) edges.push({ from, to: rule.id, conditions, mode: rule.mode, back: false });
    if (rule.mode === 'while' || !rule.do.loop) edges.push({ from: rule.id, to: '', conditions, mode: rule.mode, back: true });
  }
  return { states, edges };
}
