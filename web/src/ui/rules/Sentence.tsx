/** One rule as a sentence of chips. */
import { Fragment, type ReactElement } from 'react';
import type { Character, ScenarioDocument } from '../../core/document';
import { format_label } from '../../core/format';
import type { Vec3 } from '../../core/protocol';
import { new_condition, played_name, possible_conditions, set_rule, verb_of, type ConditionType, type MotionName, type Rule, type RuleAction, type RuleCondition } from '../../core/rules';
import { Icon } from '../icons';
import { session, useLibrary, useStudio } from '../app';
import { ChoiceChip, KeyChip, NumberChip } from './chips';

interface Props {
  doc: ScenarioDocument;
  rule: Rule;
  motion_name: MotionName;
}

export function Sentence({ doc, rule, motion_name }: Props): ReactElement {
  const send = (fields: Partial<Omit<Rule, 'id'>>): void => void session.edit(set_rule(rule.id, fields));
  const set_condition = (index: number, condition: RuleCondition): void => send({ if: rule.if.map((c, i) => (i === index ? condition : c)) });
  const set_action = (fields: Partial<RuleAction>): void => send({ do: { ...rule.do, ...fields } as RuleAction });
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
      <Action doc={doc} action={rule.do} mode={rule.mode} motion_name={motion_name} set={set_action} replace={(action) => send({ do: action })} />
    </span>
  );
}

const characters_of = (doc: ScenarioDocument): [string, string][] => doc.characters.map((c) => [c.id, c.name]);

function Body({ doc, id, link, others, label, set }: { doc: ScenarioDocument; id: string; link: string; others?: readonly (readonly [string, string])[]; label: string; set: (id: string, link: string) => void }): ReactElement {
  const character = doc.characters.find((c) => c.id === id);
  return (
    <>
      {character && <LinkChip character={character} link={link} label={`Part of ${character.name}`} set={(name) => set(id, name)} />}
      <ChoiceChip label={label} hue="contacts" value={id} choices={[...characters_of(doc), ...(others ?? [])]} on_commit={(next) => set(next, '')} />
    </>
  );
}

/** The links of a character. A character with one link has nothing to choose. */
function LinkChip({ character, link, label, set, root }: { character: Character; link: string; label: string; set: (link: string) => void; root?: boolean }): ReactElement | null {
  const mechanism = useStudio((s) => s.mechanisms[character.mechanism]);
  if (!mechanism || mechanism.links.length < 2) return null;
  const links = mechanism.links.filter((l) => l.shapes.length > 0 || l.name === link).map((l): [string, string] => [l.name, format_label(l.label || l.name)]);
  return (
    <>
      <ChoiceChip label={label} hue="contacts" value={link} choices={[['', root ? 'the root' : 'any part'], ...links]} on_commit={set} />
      <span className="rule-word">of</span>
    </>
  );
}

const type_names: Record<ConditionType, string> = { key: 'key', touch: 'touch', near: 'distance', time: 'time', playing: 'motion', released: 'fall' };

function Condition({ doc, rule, condition: c, motion_name, set }: { doc: ScenarioDocument; rule: Rule; condition: RuleCondition; motion_name: MotionName; set: (c: RuleCondition) => void }): ReactElement {
  const verb = (
    <ChoiceChip label="Verb" hue="plain" value={c.not ? 'not' : ''} choices={[['', verb_of(c.type, false, rule.mode)], ['not', verb_of(c.type, true, rule.mode)]]} on_commit={(v) => set({ ...c, not: v === 'not' })} />
  );
  const kind = (
    <ChoiceChip label="Kind of condition" hue="plain" compact value={c.type} choices={possible_conditions(doc).map((t) => [t, type_names[t]])} on_commit={(t) => set(new_condition(t as ConditionType, doc, rule.do.character))} />
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
          {kind}{who}{verb}
          <NumberChip label="Distance" value={c.distance ?? 0.5} unit="m" min={0} max={1000} on_commit={(distance) => set({ ...c, distance })} />
          <span className="rule-word">to</span>
          <ChoiceChip label="Other character" hue="contacts" value={c.other ?? ''} choices={characters_of(doc).filter(([id]) => id !== c.character)} on_commit={(other) => set({ ...c, other })} />
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
  }
}

/** The motions that a character can play: those of the library's list and of its track. */
function use_motions(doc: ScenarioDocument, character: Character | undefined, motion_name: MotionName): [string, string][] {
  const listed = useLibrary((s) => s.entries);
  const ids = new Set(character?.track.map((k) => k.motion) ?? []);
  for (const entry of listed) if (entry.kind === 'motion' && entry.mechanism === character?.mechanism) ids.add(entry.id);
  for (const rule of doc.rules ?? []) if (rule.do.type === 'play' && rule.do.character === character?.id) ids.add(rule.do.motion);
  return [...ids].map((id): [string, string] => [id, motion_name(id)]).sort((a, b) => a[1].localeCompare(b[1]));
}

function Action({ doc, action, mode, motion_name, set, replace }: { doc: ScenarioDocument; action: RuleAction; mode: Rule['mode']; motion_name: MotionName; set: (fields: Partial<RuleAction>) => void; replace: (action: RuleAction) => void }): ReactElement {
  const character = doc.characters.find((c) => c.id === action.character);
  const motions = use_motions(doc, character, motion_name);
  const change = (type: string): void => {
    if (type === 'push') return replace({ type: 'push', character: action.character, link: '', force: [200, 0, 0], duration: 0.2 });
    const motion = character?.track[0]?.motion ?? motions[0]?.[0];
    if (motion) replace({ type: 'play', character: action.character, motion, speed: 1, blend: 0.3, loop: false });
    else session.fail(new Error(`No motion fits ${character?.name ?? 'the character'}. Import one, or drag a motion onto its track first.`));
  };
  const kind = <ChoiceChip label="Action" hue="plain" value={action.type} choices={[['play', 'play'], ['push', 'push']]} on_commit={change} />;
  const who = (
    <ChoiceChip
      label="Character of the action"
      hue="vector"
      value={action.character}
      choices={characters_of(doc)}
      on_commit={(id) => {
        const next = doc.characters.find((c) => c.id === id);
        if (action.type === 'push') return set({ character: id, link: '' });
        const motion = next?.mechanism === character?.mechanism ? action.motion : next?.track[0]?.motion;
        if (motion) set({ character: id, motion });
        else session.fail(new Error(`${next?.name ?? id} has no motion yet. Drag one onto its track first.`));
      }}
    />
  );
  if (action.type === 'push') {
    const axis = (i: number): ReactElement => <NumberChip key={i} label={`Force ${'XYZ'[i]}`} value={action.force[i]!} unit={i === 2 ? 'N' : ''} digits={0} min={-1e6} max={1e6} on_commit={(v) => set({ force: action.force.map((f, j) => (j === i ? v : f)) as Vec3 })} />;
    return (
      <>
        {kind}
        {character && <LinkChip character={character} link={action.link} label={`Part of ${character.name}`} root set={(link) => set({ link })} />}
        {who}
        <span className="rule-word">with</span>
        {[0, 1, 2].map(axis)}
        {mode === 'when' && <><span className="rule-word">for</span><NumberChip label="Duration" value={action.duration} unit="s" min={0.001} max={3600} on_commit={(duration) => set({ duration })} /></>}
      </>
    );
  }
  return (
    <>
      {kind}
      <ChoiceChip label="Motion" hue="motion" value={action.motion} choices={motions.length > 0 ? motions : [[action.motion, motion_name(action.motion)]]} on_commit={(motion) => set({ motion })} />
      <span className="rule-word">on</span>
      {who}
      <ChoiceChip label="Once, or repeated" hue="plain" value={action.loop ? 'loop' : ''} choices={[['', 'once'], ['loop', 'looping']]} on_commit={(v) => set({ loop: v === 'loop' })} />
      <NumberChip label="Speed" value={action.speed} unit="×" min={0.1} max={10} on_commit={(speed) => set({ speed })} />
      <NumberChip label="Transition" value={action.blend} unit="s blend" min={0} max={5} on_commit={(blend) => set({ blend })} />
    </>
  );
}
