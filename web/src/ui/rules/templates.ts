/** New rules that the menu of the rules panel offers. */
import type { Command } from '../../core/document';
import { character_for_rule, new_condition, variable_action, variable_condition, type Rule } from '../../core/rules';
import { instance_of, with_nameable } from '../../core/nested';
import { selected_character } from '../../core/state';
import { new_variable } from '../../core/variables';
import { parts, session } from '../app';

export const rule_templates = [
  { id: 'pressed', label: 'When a key is pressed, play…', hint: 'The motion plays once; then the track goes on' },
  { id: 'held', label: 'While a key is held, play…', hint: 'The motion repeats until the key is released' },
  { id: 'touch', label: 'When something touches, play…', hint: 'A touch of two bodies, or of a body and the ground' },
  { id: 'near', label: 'When something is near, play…', hint: 'The distance of two characters falls below a bound' },
  { id: 'time', label: 'When a time has passed, play…', hint: 'At a time of the scenario' },
  { id: 'push', label: 'When a key is pressed, push…', hint: 'A force acts on a part of a character' },
  { id: 'count', label: 'When something touches, count…', hint: 'A number rises by one with each touch' },
  { id: 'reached', label: 'When a number is reached, play…', hint: 'A variable that other rules count reaches a value' },
] as const;

/** Adds a rule of a template for the selected character, shows the rules panel, and selects the rule. */
export function add_rule(template: (typeof rule_templates)[number]['id']): void {
  const document = session.state.document && with_nameable(session.state.document);
  const { selection } = session.state;
  const nested = selection.kind === 'instance' ? document?.characters.find((c) => instance_of(c.id) === selection.instance)?.id : undefined;
  const character = document && character_for_rule(document, selected_character(session.state) ?? nested);
  if (!document || !character) return;
  if (template === 'near' && document.characters.length < 2) return session.notify('A distance needs two characters. Add another one first.');
  const motion = character.track[0]?.motion;
  if (template !== 'push' && template !== 'count' && !motion) return session.notify(`${character.name} has no clip. Drag a motion onto its track first; it plays while no rule is active.`);
  const id = session.fresh_id('r');
  const held = template === 'held';
  const variable = document.variables?.find((v) => v.kind === 'number') ?? new_variable(document, 'number', session.fresh_id('x'));
  const action: Rule['do'] = template === 'count'
    ? variable_action(variable.id, 'number')
    : template === 'push' || !motion
      ? { type: 'push', character: character.id, link: '', force: [200, 0, 0], duration: 0.2 }
      : { type: 'play', character: character.id, motion, speed: 1, blend: 0.3, loop: held };
  const of_type = { touch: 'touch', count: 'touch', near: 'near', time: 'time' } as const;
  const condition = template === 'reached' ? variable_condition(variable.id, 'number') : new_condition(template in of_type ? of_type[template as keyof typeof of_type] : 'key', document, character.id);
  const rule: Command = { type: 'rule.add', rule: { id, on: true, mode: held ? 'while' : 'when', if: [condition], do: action } };
  const needs_variable = (template === 'count' || template === 'reached') && !document.variables?.includes(variable);
  void session.edit(needs_variable ? { type: 'group', label: 'Add rule', commands: [{ type: 'variable.add', variable }, rule] } : rule).then((ok) => {
    if (!ok) return;
    parts.show_panel('rules');
    session.select({ kind: 'rule', rule: id });
  });
}
