/** The action of a rule as chips: play a motion, push, grab, release, or change a variable. */
import type { ReactElement } from 'react';
import type { Character, ScenarioDocument } from '../../core/document';
import type { MechanismData, Vec3 } from '../../core/protocol';
import { action_character, variable_action, type MotionName, type Rule, type RuleAction, type VariableChange } from '../../core/rules';
import { find_variable } from '../../core/variables';
import { session, useLibrary } from '../app';
import { ChoiceChip, NumberChip } from './chips';
import { Body, characters_of, LinkChip } from './Sentence';
import { add_variable } from './Variables';

interface Props<Kind extends RuleAction = RuleAction> {
  doc: ScenarioDocument;
  action: Kind;
  mode: Rule['mode'];
  motion_name: MotionName;
  replace: (action: RuleAction) => void;
}

const kinds: [RuleAction['type'], string][] = [['play', 'play'], ['push', 'push'], ['grab', 'grab'], ['release', 'release'], ['set', 'change']];

/** The motions that a character can play: those of the library's list and of its track. */
function use_motions(doc: ScenarioDocument, character: Character | undefined, motion_name: MotionName): [string, string][] {
  const listed = useLibrary((s) => s.entries);
  const ids = new Set(character?.track.map((k) => k.motion) ?? []);
  for (const entry of listed) if (entry.kind === 'motion' && entry.mechanism === character?.mechanism) ids.add(entry.id);
  for (const rule of doc.rules ?? []) if (rule.do.type === 'play' && rule.do.character === character?.id) ids.add(rule.do.motion);
  return [...ids].map((id): [string, string] => [id, motion_name(id)]).sort((a, b) => a[1].localeCompare(b[1]));
}

/** The link of a mechanism that is most likely meant to grip: a right hand, any hand, or the last link with a shape. */
function gripping_link(mechanism: MechanismData | undefined): string {
  const links = mechanism?.links.filter((l) => l.shapes.length > 0) ?? [];
  const named = (pattern: RegExp) => links.find((l) => pattern.test(`${l.label} ${l.name}`));
  return (named(/hand.*(right|_r\b)|right.*hand/i) ?? named(/hand/i) ?? links[links.length - 1])?.name ?? '';
}

export function Action(props: Props): ReactElement {
  const { doc, action, motion_name, replace } = props;
  const acting = action_character(action) || (doc.characters.find((c) => c.control.mode === 'track') ?? doc.characters[0])?.id || '';
  const character = doc.characters.find((c) => c.id === acting);
  const motions = use_motions(doc, character, motion_name);
  const change = (type: string): void => {
    const grip = (): string => gripping_link(character && session.state.mechanisms[character.mechanism]);
    if (type === 'push') return replace({ type, character: acting, link: '', force: [200, 0, 0], duration: 0.2 });
    if (type === 'release') return replace({ type, character: acting, link: grip() });
    if (type === 'grab') {
      const other = doc.characters.find((c) => c.id !== acting);
      return replace({ type, character: acting, link: grip(), other: other?.id ?? '', other_link: '', rigid: false, limit: 450 });
    }
    if (type === 'set') {
      const variable = doc.variables?.[0];
      if (variable) return replace(variable_action(variable.id, variable.kind));
      return void add_variable('number').then((id) => id && replace(variable_action(id, 'number')));
    }
    const motion = character?.track[0]?.motion ?? motions[0]?.[0];
    if (motion) replace({ type: 'play', character: acting, motion, speed: 1, blend: 0.3, loop: false });
    else session.fail(new Error(`No motion fits ${character?.name ?? 'the character'}. Import one, or drag a motion onto its track first.`));
  };
  return (
    <>
      <ChoiceChip label="Action" hue="plain" value={action.type} choices={kinds} on_commit={change} />
      {action.type === 'play' && <Play {...props} action={action} motions={motions} />}
      {action.type === 'push' && <Push {...props} action={action} />}
      {action.type === 'set' && <SetVariable {...props} action={action} />}
      {(action.type === 'grab' || action.type === 'release') && <Grip {...props} action={action} />}
    </>
  );
}

function Play({ doc, action, motion_name, motions, replace }: Props<RuleAction & { type: 'play' }> & { motions: [string, string][] }): ReactElement {
  const character = doc.characters.find((c) => c.id === action.character);
  const set = (fields: Partial<typeof action>): void => replace({ ...action, ...fields });
  const move_to = (id: string): void => {
    const next = doc.characters.find((c) => c.id === id);
    const motion = next?.mechanism === character?.mechanism ? action.motion : next?.track[0]?.motion;
    if (motion) set({ character: id, motion });
    else session.fail(new Error(`${next?.name ?? id} has no motion yet. Drag one onto its track first.`));
  };
  return (
    <>
      <ChoiceChip label="Motion" hue="motion" value={action.motion} choices={motions.length > 0 ? motions : [[action.motion, motion_name(action.motion)]]} on_commit={(motion) => set({ motion })} />
      <span className="rule-word">on</span>
      <ChoiceChip label="Character of the action" hue="vector" value={action.character} choices={characters_of(doc)} on_commit={move_to} />
      <ChoiceChip label="Once, or repeated" hue="plain" value={action.loop ? 'loop' : ''} choices={[['', 'once'], ['loop', 'looping']]} on_commit={(v) => set({ loop: v === 'loop' })} />
      <NumberChip label="Speed" value={action.speed} unit="×" min={0.1} max={10} on_commit={(speed) => set({ speed })} />
      <NumberChip label="Transition" value={action.blend} unit="s blend" min={0} max={5} on_commit={(blend) => set({ blend })} />
    </>
  );
}

function Push({ doc, action, mode, replace }: Props<RuleAction & { type: 'push' }>): ReactElement {
  const character = doc.characters.find((c) => c.id === action.character);
  const set = (fields: Partial<typeof action>): void => replace({ ...action, ...fields });
  const axis = (i: number): ReactElement => <NumberChip key={i} label={`Force ${'XYZ'[i]}`} value={action.force[i]!} unit={i === 2 ? 'N' : ''} digits={0} min={-1e6} max={1e6} on_commit={(v) => set({ force: action.force.map((f, j) => (j === i ? v : f)) as Vec3 })} />;
  return (
    <>
      {character && <LinkChip character={character} link={action.link} label={`Part of ${character.name}`} any="the root" set={(link) => set({ link })} />}
      <ChoiceChip label="Character of the action" hue="vector" value={action.character} choices={characters_of(doc)} on_commit={(id) => set({ character: id, link: '' })} />
      <span className="rule-word">with</span>
      {[0, 1, 2].map(axis)}
      <ChoiceChip label="Axes of the force" hue="plain" value={action.axes ?? 'world'} choices={[['world', 'in world axes'], ['body', 'in body axes']]} on_commit={(axes) => set({ axes: axes === 'body' ? 'body' : 'world' })} />
      {mode === 'when' && <><span className="rule-word">for</span><NumberChip label="Duration" value={action.duration} unit="s" min={0.001} max={3600} on_commit={(duration) => set({ duration })} /></>}
    </>
  );
}

function Grip({ doc, action, replace }: Props<RuleAction & { type: 'grab' | 'release' }>): ReactElement {
  const character = doc.characters.find((c) => c.id === action.character);
  const move_to = (id: string): void => {
    const next = doc.characters.find((c) => c.id === id);
    const link = gripping_link(next && session.state.mechanisms[next.mechanism]);
    if (action.type === 'release') return replace({ ...action, character: id, link });
    const other = action.other === id ? (doc.characters.find((c) => c.id !== id)?.id ?? '') : action.other;
    replace({ ...action, character: id, link, other, other_link: other === action.other ? action.other_link : '' });
  };
  return (
    <>
      <span className="rule-word">with</span>
      {character && <LinkChip character={character} link={action.link} label={`Part of ${character.name}`} any={null} set={(link) => replace({ ...action, link })} />}
      <ChoiceChip label="Character of the action" hue="vector" value={action.character} choices={characters_of(doc)} on_commit={move_to} />
      {action.type === 'grab' && (
        <>
          <span className="rule-word">→</span>
          <Body doc={doc} id={action.other} link={action.other_link} without={action.character} any="the root" others={[['', 'the world']]} label="What is gripped" set={(other, other_link) => replace({ ...action, other, other_link })} />
          <ChoiceChip label="Hold" hue="plain" value={action.rigid ? 'rigid' : ''} choices={[['', 'loosely'], ['rigid', 'firmly']]} on_commit={(v) => replace({ ...action, rigid: v === 'rigid' })} />
          <span className="rule-word">up to</span>
          <NumberChip label="Opens above" value={action.limit} unit="N" digits={0} min={1} max={1e6} on_commit={(limit) => replace({ ...action, limit })} />
        </>
      )}
    </>
  );
}

function SetVariable({ doc, action, mode, replace }: Props<RuleAction & { type: 'set' }>): ReactElement {
  const variable = find_variable(doc, action.variable);
  const is_switch = variable?.kind === 'switch';
  const which = (
    <ChoiceChip
      label="Variable"
      hue="scalar"
      value={action.variable}
      choices={(doc.variables ?? []).map((v) => [v.id, v.name])}
      on_commit={(id) => replace(find_variable(doc, id)?.kind === variable?.kind ? { ...action, variable: id } : variable_action(id, find_variable(doc, id)?.kind ?? 'number'))}
    />
  );
  if (is_switch) {
    const state = action.change === 'toggle' ? 'toggle' : action.value > 0 ? 'on' : 'off';
    const set_state = (next: string): void => replace(next === 'toggle' ? { ...action, change: 'toggle', value: 1 } : { ...action, change: 'set', value: next === 'on' ? 1 : 0 });
    return <>{which}<span className="rule-word">to</span><ChoiceChip label="State" hue="scalar" value={state} choices={[['on', 'on'], ['off', 'off'], ['toggle', 'the other state']]} on_commit={set_state} /></>;
  }
  const amount = <NumberChip label="Value" value={action.value} unit={[variable?.unit, action.change === 'add' && mode === 'while' ? 'each second' : ''].filter(Boolean).join(' ')} min={-1e9} max={1e9} on_commit={(value) => replace({ ...action, value })} />;
  return (
    <>
      {which}
      <ChoiceChip label="Change" hue="plain" value={action.change} choices={[['add', 'by'], ['set', 'to']]} on_commit={(change) => replace({ ...action, change: change as VariableChange })} />
      {amount}
    </>
  );
}
