import { describe, expect, it } from 'vitest';
import { apply_command, type ScenarioDocument } from '../src/core/document';
import { choice_path, action_character, character_for_rule, condition_text, key_name, new_condition, possible_conditions, rule_lsi, rule_problem, rule_text, state_graph, transition_rule, variable_action, variable_condition, type Rule } from '../src/core/rules';
import { free_variable_name, new_variable, variable_pin, variable_text, type Variable } from '../src/core/variables';

const control = { mode: 'track' as const, tracking: 1, balance: 1, assist_limit: 0.5, beyond: 'release' };
const clip = { id: 'k1', motion: 'walk', start: 0, length: 2, offset: 0, speed: 1, blend: 0.3, loop: false };
const place = { x: 0, y: 0, z: 0, heading: 0 };
const play = (id: string, motion: string, fields: Partial<Rule> = {}, loop = false): Rule => ({ id, on: true, mode: 'when', if: [{ type: 'key', key: 'KeyW' }], do: { type: 'play', character: 'a', motion, speed: 1, blend: 0.2, loop }, ...fields });
const doc = (rules: Rule[]): ScenarioDocument => ({
  version: 1, name: 'test', duration: 10, frame_rate: 60, step: 0.002, gravity: [0, 0, -9.81], ground: { height: 0, friction: 0.9, restitution: 0 }, events: [], rules,
  characters: [
    { id: 'b', name: 'Ball', mechanism: 'm-b', place, control: { ...control, mode: 'passive' }, track: [] },
    { id: 'a', name: 'Anna', mechanism: 'm-a', place, control, track: [clip] },
  ],
});
const name = (motion: string): string => ({ walk: 'Walk', jump: 'Jump' })[motion] ?? motion;

describe('rules', () => {
  it('are sentences', () => {
    const rule = play('r1', 'jump', { if: [{ type: 'touch', character: 'b', link: '', other: 'a', other_link: 'chest' }, { type: 'key', key: 'Space', not: true }] });
    expect(rule_text(doc([rule]), rule, name)).toBe('When Ball touches chest of Anna and Space is not held, play Jump on Anna');
    expect(rule_text(doc([]), play('r2', 'walk'), name)).toBe('When W is pressed, play Walk on Anna');
    expect(rule_text(doc([]), play('r2', 'walk', { mode: 'while' }), name)).toBe('While W is held, play Walk on Anna');
    expect(condition_text(doc([]), { type: 'near', character: 'a', other: 'b', distance: 0.4 }, name)).toBe('Anna is nearer than 0.4 m to Ball');
    expect(condition_text(doc([]), { type: 'touch', character: 'b', other: 'ground' }, name)).toBe('Ball touches the ground');
    expect(condition_text(doc([rule]), { type: 'playing', character: 'a', rule: 'r1' }, name)).toBe('Anna plays Jump');
    expect(condition_text(doc([rule]), { type: 'playing', character: 'a', rule: '' }, name)).toBe('Anna plays its track');
  });

  it('name keys as people do', () => {
    expect(['KeyW', 'Digit1', 'ShiftLeft', 'ControlRight', 'ArrowUp', 'Space', 'Numpad4'].map(key_name)).toEqual(['W', '1', 'Shift left', 'Ctrl right', '↑', 'Space', 'Num 4']);
  });

  it('begin with the character that follows a track, a passive body and a free key', () => {
    const with_rule = doc([play('r1', 'walk')]);
    expect(character_for_rule(with_rule, undefined)?.id).toBe('a');
    expect(character_for_rule(with_rule, 'b')?.id).toBe('a');
    expect(new_condition('key', with_rule, 'a')).toEqual({ type: 'key', key: 'Space' });
    expect(new_condition('touch', with_rule, 'a')).toMatchObject({ character: 'b', other: 'a' });
    const alone = { ...with_rule, characters: with_rule.characters.slice(1) };
    expect(new_condition('touch', alone, 'a')).toMatchObject({ character: 'a', other: 'ground' });
    expect(possible_conditions(alone)).not.toContain('near');
  });

  it('report why they have no effect', () => {
    const rule = play('r1', 'walk');
    expect(rule_problem(doc([rule]), rule)).toBeNull();
    const changed = (fields: object): ScenarioDocument => ({ ...doc([rule]), characters: [{ ...doc([]).characters[1]!, ...fields }] });
    expect(rule_problem(changed({ track: [] }), rule)).toContain('no clip');
    expect(rule_problem(changed({ control: { ...control, assist_limit: 0 } }), rule)).toContain('assist limit');
    expect(rule_problem(changed({ control: { ...control, mode: 'passive' } }), rule)).toContain('passive');
    expect(rule_problem({ ...doc([rule]), circuit: { name: 'own' } }, rule)).toContain('circuit of its own');
  });

  it('form a state machine', () => {
    const walk = play('r1', 'walk', { mode: 'while' }, true);
    const jump = play('r2', 'jump', { if: [{ type: 'key', key: 'Space' }, { type: 'playing', character: 'a', rule: 'r1' }] });
    const off = play('r3', 'fall', { on: false });
    const { states, edges } = state_graph(doc([walk, jump, off]), 'a');
    expect(states.map((s) => s.rule)).toEqual(['', 'r1', 'r2']);
    expect(edges.filter((e) => !e.back).map((e) => [e.from, e.to])).toEqual([['', 'r1'], ['r1', 'r2']]);
    expect(edges.filter((e) => e.back).map((e) => [e.from, e.to])).toEqual([['r1', ''], ['r2', '']]);
    expect(edges[2]!.conditions).toEqual([{ type: 'key', key: 'Space' }]);
    expect(state_graph(doc([play('r1', 'walk', {}, true)]), 'a').edges.filter((e) => e.back)).toEqual([]); // a loop that a key starts does not end
  });

  it('are added, changed, moved and removed in the preview as in the service', () => {
    let d = doc([play('r1', 'walk')]);
    const { id: _id, ...fields } = play('', 'jump');
    d = apply_command(d, { type: 'rule.add', rule: { ...fields, id: 'r2' } });
    d = apply_command(d, { type: 'rule.add', rule: { ...fields, id: 'r3' }, at: 0 });
    expect(d.rules!.map((r) => r.id)).toEqual(['r3', 'r1', 'r2']);
    d = apply_command(d, { type: 'rule.move', id: 'r3', at: 1 });
    expect(d.rules!.map((r) => r.id)).toEqual(['r1', 'r3', 'r2']);
    d = apply_command(d, { type: 'rule.set', id: 'r3', rule: { on: false } });
    expect(d.rules![1]).toMatchObject({ id: 'r3', on: false, mode: 'when' });
    expect(apply_command(d, { type: 'rule.remove', id: 'r1' }).rules!.map((r) => r.id)).toEqual(['r3', 'r2']);
  });

  it('have LSIs with the name of their id', () => {
    expect(rule_lsi({ id: 'r.1' })).toBe('rule-r_1');
  });
});

const score: Variable = { id: 'x1', name: 'Score', kind: 'number', initial: 0, unit: 'x' };
const door: Variable = { id: 'x2', name: 'Door', kind: 'switch', initial: 1 };
const with_variables = (rules: Rule[]): ScenarioDocument => ({ ...doc(rules), variables: [score, door] });

describe('variables', () => {
  it('are read in conditions and changed by actions', () => {
    const d = with_variables([]);
    const text = (fields: Partial<Rule>): string => rule_text(d, play('r1', 'walk', fields), name);
    expect(text({ if: [variable_condition('x1', 'number')] })).toBe('When Score reaches 3 x, play Walk on Anna');
    expect(text({ if: [variable_condition('x2', 'switch')] })).toBe('When Door is on, play Walk on Anna');
    expect(text({ if: [{ ...variable_condition('x2', 'switch'), not: true }] })).toBe('When Door is off, play Walk on Anna');
    expect(text({ do: variable_action('x1', 'number') })).toBe('When W is pressed, add 1 x to Score');
    expect(text({ do: variable_action('x1', 'number'), mode: 'while' })).toBe('While W is held, add 1 x to Score each second');
    expect(text({ do: variable_action('x2', 'switch') })).toBe('When W is pressed, toggle Door');
    expect(text({ do: { type: 'set', variable: 'x2', change: 'set', value: 0 } })).toBe('When W is pressed, set Door to off');
    expect(action_character(variable_action('x1', 'number'))).toBe('');
    expect(possible_conditions(d)).toContain('variable');
    expect(possible_conditions(doc([]))).not.toContain('variable');
    expect(rule_problem(d, play('r1', 'walk', { do: variable_action('x1', 'number') }))).toBeNull();
  });

  it('have values with units, pins and free names', () => {
    expect([variable_text(score, 2.5), variable_text(door, 1), variable_text({ kind: 'number' }, 3)]).toEqual(['2.5 x', 'on', '3']);
    expect(variable_pin({ id: 'x.1' })).toBe('variable-x_1.value');
    expect(free_variable_name(with_variables([]), 'Score')).toBe('Score 2');
    expect(new_variable(with_variables([]), 'switch', 'x3')).toEqual({ id: 'x3', name: 'Switch', kind: 'switch', initial: 0 });
  });

  it('are changed and removed in the preview', () => {
    let d = apply_command(with_variables([]), { type: 'variable.set', id: 'x1', variable: { name: 'Points' } });
    expect(d.variables![0]).toEqual({ ...score, name: 'Points' });
    d = apply_command(d, { type: 'variable.remove', id: 'x2' });
    expect(d.variables!.map((v) => v.id)).toEqual(['x1']);
  });

  it('grabs and releases are sentences', () => {
    const text = (action: Rule['do']): string => rule_text(doc([]), play('r1', 'walk', { do: action }), name);
    const grab = { type: 'grab' as const, character: 'a', link: 'hand', other: 'b', other_link: '', rigid: false, limit: 450 };
    expect(text(grab)).toBe('When W is pressed, hand of Anna grabs Ball');
    expect(text({ ...grab, other: '' })).toBe('When W is pressed, hand of Anna grabs the world');
    expect(text({ type: 'release', character: 'a', link: 'hand' })).toBe('When W is pressed, hand of Anna releases');
  });
});

describe('transitions of the state graph', () => {
  const walk = play('r1', 'walk', { mode: 'while' }, true);
  const jump = play('r2', 'jump');

  it('play the motion of the target while the origin plays', () => {
    const rule = transition_rule(doc([walk, jump]), 'a', 'r1', 'r2')!;
    expect(rule.if).toEqual([{ type: 'playing', character: 'a', rule: 'r1' }, { type: 'key', key: 'Space' }]);
    expect(rule.do).toEqual(jump.do);
    const { states, edges } = state_graph(doc([walk, jump, { ...rule, id: 'r3' }]), 'a');
    expect(states.map((s) => s.rules)).toEqual([[''], ['r1'], ['r2', 'r3']]); // one state for each motion
    expect(edges.filter((e) => !e.back).map((e) => [e.from, e.to])).toEqual([['', 'r1'], ['', 'r2'], ['r1', 'r2']]);
    expect(transition_rule(doc([walk, jump]), 'a', 'r1', '')).toBeNull();
    expect(transition_rule(doc([walk, jump]), 'a', 'r1', 'r1')).toBeNull();
  });
});

describe('the choice of a character', () => {
  it('is found in its nested circuit', () => {
    const lsi = (character: string) => ({ id: 'choice', type: 'motion choice', parameters: { character } });
    const circuit = { name: 'execution', lsis: [{ id: 'anna', type: 'character anna' }, { id: 'ben', type: 'character ben' }], circuits: [{ name: 'character anna', lsis: [] }, { name: 'character ben', lsis: [lsi('ben')] }] };
    expect(choice_path(circuit, 'ben')).toBe('ben/choice');
    expect(choice_path(circuit, 'anna')).toBeUndefined();
    expect(choice_path(null, 'ben')).toBeUndefined();
  });
});
