/** One rule as a sentence of chips. */
import { Fragment, type ReactElement } from 'react';
import type { Character, ScenarioDocument } from '../../core/document';
import { format_label } from '../../core/format';
import { action_character, comparisons, new_condition, played_name, possible_conditions, set_rule, variable_condition, verb_of, type Comparison, type ConditionType, type MotionName, type Rule, type RuleCondition } from '../../core/rules';
import { find_variable } from '../../core/variables';
import { Icon } from '../icons';
import { session, useStudio } from '../app';
import { Action } from './Action';
import { ChoiceChip, KeyChip, NumberChip } from './chips';

interface Props {
  doc: ScenarioDocument;
  rule: Rule;
  motion_name: MotionName;
}

export function Sentence({ doc, rule, motion_name }: Props): ReactElement {
  const send = (fields: Partial<Omit<Rule, 'id'>>): void => void session.edit(set_rule(rule.id, fields));
  const set_condition = (index: number, condition: RuleCondition): void => send({ if: rule.if.map((c, i) => (i === index ? condition : c)) });
  return (
    <span className="rule-sentence">
      <ChoiceChip label="Mode: once, or as long as the conditions are true" hue="plain" value={rule.mode} choices={[['when', 'When'], ['while', 'While']]} on_commit={(mode) => send({ mode: mode as Rule['mode'] })} />
      {rule.if.map((condition, i) => (
        <Fragment key={i}>
          {i > 0 && <span className="rule-word">and</span>}
          <Condition doc={doc} rule={rule} condition={condition} motion_name={motion_name} set={(c) => set_condition(i, c)} />
          {rule.if.length > 1 && (
            <button type="button" className="rule-minor" aria-label={`Remove condition ${i + 1}`} title="Remove this condition" onClick={() => send({ if: rule.if.filter((_, j) => j !== i) })}>
              <Icon name="close" />
            </button>
          )}
        </Fragment>
      ))}
      <span className="rule-then" aria-hidden="true">→</span>
      <Action doc={doc} action={rule.do} mode={rule.mode} motion_name={motion_name} replace={(action) => send({ do: action })} />
    </span>
  );
}

export const characters_of = (doc: ScenarioDocument): [string, string][] => doc.characters.map((c) => [c.id, c.name]);

/** @param without a character that is not offered */
export function Body({ doc, id, link, others, without, any, label, set }: { doc: ScenarioDocument; id: string; link: string; others?: readonly (readonly [string, string])[]; without?: string | undefined; any?: string; label: string; set: (id: string, link: string) => void }): ReactElement {
  const character = doc.characters.find((c) => c.id === id);
  return (
    <>
      {character && <LinkChip character={character} link={link} label={`Part of ${character.name}`} {...(any === undefined ? {} : { any })} set={(name) => set(id, name)} />}
      <ChoiceChip label={label} hue="contacts" value={id} choices={[...characters_of(doc).filter(([other]) => other !== without), ...(others ?? [])]} on_commit={(next) => set(next, '')} />
    </>
  );
}

/** The links of a character. A character with one link has nothing to choose. @param any name of the choice without a link; null: a link is necessary */
export function LinkChip({ character, link, label, set, any = 'any part' }: { character: Character; link: string; label: string; set: (link: string) => void; any?: string | null }): ReactElement | null {
  const mechanism = useStudio((s) => s.mechanisms[character.mechanism]);
  if (!mechanism || mechanism.links.length < 2) return null;
  const links = mechanism.links.filter((l) => l.shapes.length > 0 || l.name === link).map((l): [string, string] => [l.name, format_label(l.label || l.name)]);
  return (
    <>
      <ChoiceChip label={label} hue="contacts" value={link} choices={[...(any === null ? [] : [['', any] as [string, string]]), ...links]} on_commit={set} />
      <span className="rule-word">of</span>
    </>
  );
}

const type_names: Record<ConditionType, string> = { key: 'key', touch: 'touch', near: 'distance', time: 'time', playing: 'motion', released: 'fall', variable: 'variable' };

function Condition({ doc, rule, condition: c, motion_name, set }: { doc: ScenarioDocument; rule: Rule; condition: RuleCondition; motion_name: MotionName; set: (c: RuleCondition) => void }): ReactElement {
  const verb = (
    <ChoiceChip label="Verb" hue="plain" value={c.not ? 'not' : ''} choices={[['', verb_of(c.type, false, rule.mode)], ['not', verb_of(c.type, true, rule.mode)]]} on_commit={(v) => set({ ...c, not: v === 'not' })} />
  );
  const kind = (
    <ChoiceChip label="Kind of condition" hue="plain" compact value={c.type} choices={possible_conditions(doc).map((t) => [t, type_names[t]])} on_commit={(t) => set(new_condition(t as ConditionType, doc, action_character(rule.do) || (doc.characters[0]?.id ?? '')))} />
  );
  const who = <ChoiceChip label="Character" hue="contacts" value={c.character ?? ''} choices={characters_of(doc)} on_commit={(character) => set({ ...c, character, ...(c.type === 'playing' ? { rule: '' } : {}) })} />;
  switch (c.type) {
    case 'key':
      return <>{kind}<KeyChip value={c.key ?? ''} on_commit={(key) => set({ ...c, key })} />{verb}</>;
    case 'touch':
      return (
        <>
          {kind}
          <Body doc={doc} id={c.character ?? ''} link={c.link ?? ''} label="What touches" set={(character, link) => set({ ...c, character, link })} />
          {verb}
          <Body doc={doc} id={c.other ?? ''} link={c.other_link ?? ''} others={[['ground', 'the ground'], ['', 'anything']]} label="What is touched" set={(other, other_link) => set({ ...c, other, other_link })} />
        </>
      );
    case 'near':
      return (
        <>
          {kind}
          <Body doc={doc} id={c.character ?? ''} link={c.link ?? ''} label="Character" set={(character, link) => set({ ...c, character, link })} />
          {verb}
          <NumberChip label="Distance" value={c.distance ?? 0.5} unit="m" min={0} max={1000} on_commit={(distance) => set({ ...c, distance })} />
          <span className="rule-word">to</span>
          <Body doc={doc} id={c.other ?? ''} link={c.other_link ?? ''} without={c.character} label="Other character" set={(other, other_link) => set({ ...c, other, other_link })} />
        </>
      );
    case 'time':
      return <>{kind}<NumberChip label="Time" value={c.time ?? 0} unit="s" min={0} max={86400} on_commit={(time) => set({ ...c, time })} />{verb}</>;
    case 'playing': {
      const choices = (doc.rules ?? []).filter((r) => r.id !== rule.id && r.do.type === 'play' && r.do.character === c.character).map((r): [string, string] => [r.id, played_name(doc, r.id, motion_name)]);
      return <>{kind}{who}{verb}<ChoiceChip label="Motion that plays" hue="joints" value={c.rule ?? ''} choices={[['', 'its track'], ...choices]} on_commit={(id) => set({ ...c, rule: id })} /></>;
    }
    case 'released':
      return <>{kind}{who}{verb}</>;
    case 'variable': {
      const variable = find_variable(doc, c.variable);
      const which = <ChoiceChip label="Variable" hue="scalar" value={c.variable ?? ''} choices={(doc.variables ?? []).map((v) => [v.id, v.name])} on_commit={(id) => set(find_variable(doc, id)?.kind === variable?.kind ? { ...c, variable: id } : variable_condition(id, find_variable(doc, id)?.kind ?? 'number'))} />;
      if (variable?.kind === 'switch') {
        const on = (c.value ?? 1) > 0 !== Boolean(c.not);
        return <>{kind}{which}<span className="rule-word">is</span><ChoiceChip label="State" hue="scalar" value={on ? 'on' : 'off'} choices={[['on', 'on'], ['off', 'off']]} on_commit={(v) => set({ type: 'variable', variable: variable.id, compare: 'equal', value: v === 'on' ? 1 : 0 })} /></>;
      }
      return (
        <>
          {kind}{which}
          <ChoiceChip label="Comparison" hue="plain" value={c.compare ?? 'at_least'} choices={Object.entries(comparisons)} on_commit={(compare) => set({ ...c, compare: compare as Comparison })} />
          <NumberChip label="Value" value={c.value ?? 0} unit={variable?.unit ?? ''} min={-1e9} max={1e9} on_commit={(value) => set({ ...c, value })} />
        </>
      );
    }
  }
}
