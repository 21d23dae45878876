/**
 * Reads rules back from a circuit of the project: the inverse of the generator (src/ugoki/content/rule_circuit.cpp). A user who changes the
 * circuit that was generated from rules sees the changed rules as sentences, where the LSIs still have the form of a rule.
 */
import { split_end, type Circuit, type Lsi } from './circuit/form';
import type { Command, ScenarioDocument } from './document';
import { rule_lsi, type Comparison, type Rule, type RuleAction, type RuleCondition, type VariableChange } from './rules';
import type { Vec3 } from './protocol';

/**
 * What the circuit does of a rule.
 *   same      what the rule of the document states
 *   changed   another rule, which `rule` is
 *   own       LSIs that have no form of a rule
 *   missing   nothing: its LSI was removed, or has no condition
 */
export interface WiredRule {
  id: string;
  state: 'same' | 'changed' | 'own' | 'missing';
  rule: Rule | null;
  /** False: the document has no rule of this id; the user added the LSI. */
  known: boolean;
}

const action_types = ['play rule', 'push', 'grip rule', 'set variable'];
const max_conditions = 16; // of a rule (rule_check.cpp)
const released_index = 8; // of the value `released` in the report of motion control (lsi::report_released)

const text = (value: unknown): string => (typeof value === 'string' ? value : '');
const number = (value: unknown, absent: number): number => (typeof value === 'number' ? value : absent);

class Reader {
  private readonly lsis: Map<string, Lsi>;
  private readonly sources: Map<string, string>;
  private readonly play_rules: (character: string) => Rule[];

  constructor(private readonly circuit: Circuit, private readonly doc: ScenarioDocument) {
    this.lsis = new Map((circuit.lsis ?? []).map((lsi) => [lsi.id, lsi]));
    this.sources = new Map((circuit.wires ?? []).map((w) => [w.to, w.from]));
    this.play_rules = (character) => (doc.rules ?? []).filter((r) => r.on && r.do.type === 'play' && r.do.character === character);
  }

  /** The rule whose action this LSI does; null: it has no form of a rule. */
  rule(id: string, lsi: Lsi): Rule | null {
    const from = this.sources.get(`${lsi.id}.${lsi.type === 'push' || lsi.type === 'grip rule' ? 'when' : 'condition'}`);
    const conditions = from === undefined ? null : this.all(from);
    const action = conditions && this.action(lsi);
    return action && { id, on: true, mode: action.mode, if: conditions, do: action.do };
  }

  /** The output that feeds an input, with its LSI; null: none. */
  private source(end: string): { lsi: Lsi; pin: string } | null {
    const from = this.sources.get(end);
    return from === undefined ? null : this.output(from);
  }
  private output(end: string): { lsi: Lsi; pin: string } | null {
    const [id, pin] = split_end(end);
    const lsi = this.lsis.get(id);
    return lsi ? { lsi, pin } : null;
  }

  /** The conditions that an output combines with `and`. */
  private all(end: string, depth = 0): RuleCondition[] | null {
    const from = this.output(end);
    if (from?.lsi.type !== 'and') return this.one(end, 0);
    if (depth > max_conditions) return null; // the wires form a ring
    const [a, b] = [this.sources.get(`${from.lsi.id}.a`), this.sources.get(`${from.lsi.id}.b`)];
    const right = b === undefined ? null : this.all(b, depth + 1);
    const left = right && a !== undefined ? this.all(a, depth + 1) : null;
    return left && right && [...left, ...right];
  }
  private one(end: string, depth: number): RuleCondition[] | null {
    const condition = depth > 4 ? null : this.condition(end, depth);
    return condition && [condition];
  }

  private condition(end: string, depth: number): RuleCondition | null {
    const from = this.output(end);
    if (!from) return null;
    const { lsi, pin } = from;
    const p = lsi.parameters ?? {};
    switch (lsi.type) {
      case 'keyboard': return pin === 'pressed' ? { type: 'key', key: text(p.key) } : null;
      case 'touch':
        if (pin !== 'touching' || this.sources.get(`${lsi.id}.contacts`) !== 'dynamics.contacts') return null;
        return { type: 'touch', character: text(p.character), link: text(p.link), other: text(p.other), other_link: text(p['other link']) };
      case 'not': {
        const source = this.sources.get(`${lsi.id}.in`);
        const inner = source === undefined ? null : this.one(source, depth + 1)?.[0];
        return inner ? contrary(inner) : null;
      }
      case 'compare': return this.comparison(lsi);
      case 'equal': return this.equality(lsi);
      case 'or': return this.same_motion(lsi, depth);
      case 'delay': return this.released(lsi);
      default: return null;
    }
  }

  /** "a > b", with one of them fixed: a distance, a time or a variable. */
  private comparison(lsi: Lsi): RuleCondition | null {
    const [a, b] = [this.source(`${lsi.id}.a`), this.source(`${lsi.id}.b`)];
    if (Boolean(a) === Boolean(b)) return null;
    const value = number(lsi.values?.[a ? 'b' : 'a'], 0);
    const { lsi: wired, pin } = (a ?? b)!;
    const p = wired.parameters ?? {};
    if (wired.type === 'closest pair' && pin === 'distance' && b) {
      const links = { ...(p.link ? { link: text(p.link) } : {}), ...(p['other link'] ? { other_link: text(p['other link']) } : {}) };
      return { type: 'near', character: text(p.character), other: text(p.other), ...links, distance: value };
    }
    if (wired.type === 'clock' && pin === 'time' && a) return { type: 'time', time: value };
    const variable = this.variable(wired, pin);
    return variable === null ? null : { type: 'variable', variable, compare: a ? 'above' : 'below', value };
  }

  private equality(lsi: Lsi): RuleCondition | null {
    const from = this.sources.get(`${lsi.id}.a`);
    if (from === undefined || this.sources.has(`${lsi.id}.b`)) return null;
    const value = number(lsi.values?.b, 0);
    const [box, pin] = split_end(from);
    const character = pin === 'now' ? this.character_in(box) : null;
    if (character !== null) {
      const rule = value === 0 ? '' : this.play_rules(character)[value - 1]?.id;
      return rule === undefined ? null : { type: 'playing', character, rule };
    }
    const source = this.output(from);
    const variable = source && this.variable(source.lsi, source.pin);
    return variable === null ? null : { type: 'variable', variable, compare: 'equal', value };
  }

  /** Several rules that play the same motion: the first one stands for all. */
  private same_motion(lsi: Lsi, depth: number): RuleCondition | null {
    const [a, b] = ['a', 'b'].map((pin) => {
      const from = this.sources.get(`${lsi.id}.${pin}`);
      return from === undefined ? null : this.one(from, depth + 1)?.[0];
    });
    if (a?.type !== 'playing' || b?.type !== 'playing' || a.not || b.not || a.character !== b.character) return null;
    const [first, second] = [a, b].map((c) => this.doc.rules?.find((r) => r.id === c.rule)?.do);
    const alike = first?.type === 'play' && second?.type === 'play' && first.motion === second.motion && first.speed === second.speed && first.loop === second.loop;
    return alike ? a : null;
  }

  private released(delay: Lsi): RuleCondition | null {
    const value = this.source(`${delay.id}.in`);
    if (value?.lsi.type !== 'joint value' || number(value.lsi.parameters?.index, -1) !== released_index) return null;
    const from = this.sources.get(`${value.lsi.id}.in`);
    const [box, pin] = split_end(from ?? '');
    const character = pin === 'report' ? this.character_in(box) : null;
    return character === null ? null : { type: 'released', character };
  }

  /** Id of the variable that an output is; null: it is none. */
  private variable(lsi: Lsi, pin: string): string | null {
    if (lsi.type !== 'variable' || pin !== 'value') return null;
    return this.doc.variables?.find((v) => `variable-${v.id.replaceAll('.', '_')}` === lsi.id)?.id ?? null;
  }

  /** The character of the nested circuit `box`, or of the LSI itself; null: it belongs to none. */
  private character_in(box: string): string | null {
    const lsi = this.lsis.get(box);
    if (!lsi) return null;
    const inner = this.circuit.circuits?.find((c) => c.name === lsi.type);
    const names = [lsi, ...(inner?.lsis ?? [])].map((l) => text(l.parameters?.character)).filter(Boolean);
    return names[0] ?? null;
  }

  private action(lsi: Lsi): { mode: Rule['mode']; do: RuleAction } | null {
    const p = lsi.parameters ?? {};
    switch (lsi.type) {
      case 'play rule': return this.play(lsi);
      case 'push': {
        const duration = number(p.duration, 0.2);
        const force = lsi.values?.force;
        if (!Array.isArray(force) || force.length !== 3 || this.sources.has(`${lsi.id}.force`)) return null;
        return { mode: duration > 0 ? 'when' : 'while', do: { type: 'push', character: text(p.character), link: text(p.link), force: force as Vec3, ...(p['body axes'] === true ? { axes: 'body' as const } : {}), duration: duration > 0 ? duration : 0.2 } };
      }
      case 'grip rule': {
        const mode = text(p.mode) || 'grab';
        if (mode === 'release') return { mode: 'when', do: { type: 'release', character: text(p.character), link: text(p.link) } };
        return {
          mode: mode === 'hold' ? 'while' : 'when',
          do: { type: 'grab', character: text(p.character), link: text(p.link), other: text(p.other), other_link: text(p['other link']), rigid: p.rigid === true, limit: number(p.limit, 450) },
        };
      }
      default: return this.change(lsi);
    }
  }

  private play(lsi: Lsi): { mode: Rule['mode']; do: RuleAction } | null {
    const character = this.played_character(lsi.id);
    if (character === null) return null;
    const of_number = this.play_rules(character)[number(lsi.parameters?.number, 1) - 1];
    return of_number ? { mode: text(lsi.parameters?.mode) === 'while' ? 'while' : 'when', do: of_number.do } : null;
  }
  /** The character whose choice a play rule feeds, directly or as a rule of lower priority; null: none. */
  private played_character(id: string): string | null {
    for (let at = id, steps = 0; steps <= this.lsis.size; steps++) {
      const wire = this.circuit.wires?.find((w) => w.from === `${at}.choice`);
      if (!wire) return null;
      const [next, pin] = split_end(wire.to);
      if (pin === 'choice') return this.character_in(next);
      if (pin !== 'below') return null;
      at = next;
    }
    return null;
  }

  private change(lsi: Lsi): { mode: Rule['mode']; do: RuleAction } | null {
    const p = lsi.parameters ?? {};
    if (this.sources.has(`${lsi.id}.amount`)) return null;
    let from = this.source(`${lsi.id}.value`);
    for (let steps = 0; from?.lsi.type === 'set variable' && steps <= this.lsis.size; steps++) from = this.source(`${from.lsi.id}.value`);
    const variable = from && this.variable(from.lsi, from.pin);
    if (variable === null) return null;
    const change = (text(p.change) || 'add') as VariableChange;
    return { mode: text(p.mode) === 'while' ? 'while' : 'when', do: { type: 'set', variable, change, value: number(lsi.values?.amount, 1) } };
  }
}

/** The negated condition. "Above" and "below" become "at most" and "at least", as the generator wires them. */
function contrary(c: RuleCondition): RuleCondition {
  const strict: Partial<Record<Comparison, Comparison>> = { above: 'at_most', below: 'at_least' };
  const other = c.type === 'variable' && !c.not && c.compare ? strict[c.compare] : undefined;
  if (other) return { ...c, compare: other };
  const { not, ...plain } = c;
  return not ? plain : { ...plain, not: true };
}

/** A rule in a form in which equal rules have equal text: fields that its types do not use are left out. */
function canonical(rule: Rule): string {
  const condition = (c: RuleCondition): unknown => {
    switch (c.type) {
      case 'key': return [c.type, c.key];
      case 'touch': return [c.type, c.character, c.link ?? '', c.other ?? '', c.other_link ?? ''];
      case 'near': return [c.type, c.character, c.link ?? '', c.other ?? '', c.other_link ?? '', c.distance ?? 0.5];
      case 'time': return [c.type, c.time];
      case 'playing': return [c.type, c.character, c.rule ?? ''];
      case 'released': return [c.type, c.character];
      case 'variable': return [c.type, c.variable, c.compare ?? 'at_least', c.value ?? 1];
    }
  };
  const { do: action } = rule;
  const what =
    action.type === 'play' ? [action.character, action.motion, action.speed, action.blend, action.loop]
    : action.type === 'push' ? [action.character, action.link, action.force, action.axes ?? 'world', rule.mode === 'when' ? action.duration : 0]
    : action.type === 'grab' ? [action.character, action.link, action.other, action.other_link, action.rigid, action.limit]
    : action.type === 'release' ? [action.character, action.link]
    : [action.variable, action.change, action.value];
  const mode = action.type === 'release' ? 'when' : rule.mode;
  return JSON.stringify([mode, rule.if.map((c) => [Boolean(c.not), condition(c)]), action.type, what]);
}

/** What a circuit of the project does of each rule of the document that is on, in their order, and of rules that the user added to it. */
export function wired_rules(circuit: Circuit, doc: ScenarioDocument): WiredRule[] {
  const reader = new Reader(circuit, doc);
  const rules = (doc.rules ?? []).filter((r) => r.on);
  const out = rules.map((rule): WiredRule => {
    const lsi = circuit.lsis?.find((l) => l.id === rule_lsi(rule));
    if (!lsi) return { id: rule.id, state: 'missing', rule: null, known: true };
    const read = action_types.includes(lsi.type) ? reader.rule(rule.id, lsi) : null;
    if (!read) return { id: rule.id, state: 'own', rule: null, known: true };
    return { id: rule.id, state: canonical(read) === canonical(rule) ? 'same' : 'changed', rule: read, known: true };
  });
  for (const lsi of circuit.lsis ?? []) {
    if (!action_types.includes(lsi.type) || rules.some((r) => rule_lsi(r) === lsi.id)) continue;
    const rule = reader.rule(lsi.id, lsi);
    out.push({ id: lsi.id, state: rule ? 'changed' : 'own', rule, known: false });
  }
  return out;
}

/**
 * The commands after which the generated circuit does what the circuit of the project does of the rules: rules are changed, added and removed,
 * and the circuit is dropped with all that is not a rule in it. null: a part of the circuit has no form of a rule, or nothing is to be kept.
 */
export function keep_wired(wired: readonly WiredRule[]): Command[] | null {
  if (wired.some((w) => w.state === 'own') || wired.every((w) => w.state === 'same')) return null;
  const commands = wired.flatMap((w): Command[] => {
    if (w.state === 'missing') return [{ type: 'rule.remove', id: w.id }];
    if (w.state === 'same' || !w.rule) return [];
    const { id, ...fields } = w.rule;
    return [w.known ? { type: 'rule.set', id, rule: fields } : { type: 'rule.add', rule: fields }];
  });
  return [...commands, { type: 'circuit.set', circuit: null }];
}
