/** Rules panel: sentences by falling priority, and the state machine of one character. What just happened is marked, with a count. */
import { useEffect, useMemo, useState, type DragEvent, type ReactElement } from 'react';
import { action_character, character_for_rule, choice_path, new_condition, rule_lsi, rule_problem, rule_text, set_rule, transition_rule, type Rule } from '../../core/rules';
import { keep_wired, wired_rules, type WiredRule } from '../../core/circuit_rules';
import { variable_pin } from '../../core/variables';
import type { ScenarioDocument } from '../../core/document';
import { with_nameable } from '../../core/nested';
import { selected_character, shown_document } from '../../core/state';
import { run } from '../actions';
import { page, session, useLibrary, useStudio } from '../app';
import { Icon } from '../icons';
import { Menu } from '../Menu';
import { Graph } from './Graph';
import { Sentence } from './Sentence';
import { add_rule, rule_templates } from './templates';
import { VariableRow } from './Variables';

const poll_time = 120; // ms between two looks at the live values; the service sends them at most 15 times a second

/** Values of outputs of the running circuit, NaN while unknown. */
function use_pins(pins: readonly string[]): number[] {
  const key = pins.join(' ');
  const [values, set_values] = useState('');
  useEffect(() => {
    const list = key ? key.split(' ') : [];
    session.watch_rules(list);
    const timer = setInterval(() => {
      const idle = session.state.transport.mode !== 'simulate';
      set_values(JSON.stringify(list.map((pin) => (idle ? null : (session.live.pin(pin)?.numbers[0] ?? null)))));
    }, poll_time);
    return () => {
      clearInterval(timer);
      session.watch_rules([]);
    };
  }, [key]);
  const read = values ? (JSON.parse(values) as (number | null)[]) : [];
  return pins.map((_, i) => read[i] ?? NaN);
}

export function RulesPanel(): ReactElement {
  const scenario = useStudio(shown_document);
  // rules can name the characters of nested scenarios, too
  const doc = useMemo(() => scenario && with_nameable(scenario), [scenario]);
  const selection = useStudio((s) => s.selection);
  const preferred = useStudio(selected_character);
  const generated = useStudio((s) => s.generated);
  const edited = useStudio((s) => Boolean(shown_document(s)?.circuit));
  useLibrary((s) => s.entries);
  useStudio((s) => s.library_revision);
  const [menu, set_menu] = useState<{ x: number; y: number } | null>(null);
  const [dragged, set_dragged] = useState<string | null>(null);
  const rules = doc?.rules ?? [];
  const wired = useMemo(() => (doc?.circuit ? wired_rules(doc.circuit, doc) : []), [doc]);
  const kept = keep_wired(wired);
  const motion_name = (motion: string): string => session.entry(motion)?.name ?? motion;
  const selected = selection.kind === 'rule' ? rules.find((r) => r.id === selection.rule) : undefined;
  const shown = doc && character_for_rule(doc, (selected && action_character(selected.do)) || preferred || rules.flatMap((r) => (r.do.type === 'play' ? [r.do.character] : []))[0]);
  const choice = choice_path(generated, shown?.id);
  const pins = edited ? [] : rules.filter((r) => r.on && !(doc && rule_problem(doc, r))).flatMap((r) => [`${rule_lsi(r)}.active`, `${rule_lsi(r)}.count`]);
  const variables = edited ? [] : (doc?.variables ?? []).map(variable_pin);
  const watched = [...pins, ...variables, ...(choice && !edited ? [`${choice}.now`] : [])];
  const values = use_pins(watched);
  const value_of = (pin: string): number => values[watched.indexOf(pin)] ?? NaN;
  const now = choice ? value_of(`${choice}.now`) : NaN;

  useEffect(() => {
    for (const character of doc?.characters ?? []) void session.need_mechanism(character.mechanism);
  }, [doc?.characters]);
  if (!doc) return <div className="panel empty">No project is open yet.</div>;

  const open_menu = (element: HTMLElement): void => {
    const box = element.getBoundingClientRect();
    set_menu({ x: box.left, y: box.bottom + 2 });
  };
  return (
    <div className="panel rules" role="group" aria-label="Rules">
      <div className="rules-head">
        <p className="facts">{rules.length === 0 ? '' : 'A rule acts while the simulation runs. A rule has priority over those below it.'}</p>
        <button type="button" className="quiet" disabled={rules.length === 0} title="Show what was generated from the rules" onClick={() => run('page.circuit')}>Show as circuit</button>
        <button type="button" className="quiet rule-new" title="Add a rule for the selected character  (R)" disabled={doc.characters.length === 0} onClick={(e) => open_menu(e.currentTarget)}>+ Rule</button>
      </div>
      {edited && (rules.length > 0 || wired.length > 0) && (
        <p className="rules-note" role="note">
          <span>The project has a circuit of its own. The sentences are what this circuit does; change them there.</span>
          <button type="button" className="quiet" title="Open the circuit" onClick={() => run('page.circuit')}>Open the circuit</button>
          {kept && <button type="button" className="quiet" title="Change the rules to these sentences, and drop the circuit with everything else that was changed in it" onClick={() => void session.edit({ type: 'group', label: 'Keep rules of the circuit', commands: kept })}>Keep these rules</button>}
          <button type="button" className="quiet" title="Drop the circuit of the project, and use the rules as they were" onClick={() => run('circuit.reset')}>Use the generated circuit</button>
        </p>
      )}
      {doc.characters.length > 0 && <VariableRow doc={doc} value_of={value_of} />}
      {rules.length === 0 && wired.length === 0 ? (
        <div className="rules-empty">
          <strong>Rules make the content interactive</strong>
          <p>“While W is held, walk.” “When the ball touches her chest, play the fall.”</p>
          <div className="actions">
            {rule_templates.slice(0, 3).map((t) => (
              <button key={t.id} type="button" disabled={doc.characters.length === 0} title={t.hint} onClick={() => add_rule(t.id)}>{t.label}</button>
            ))}
          </div>
          {doc.characters.length === 0 && <p className="hint">Add a character first: drag a mechanism from the library onto the floor.</p>}
        </div>
      ) : (
        <div className="rules-body">
          <ol className="rule-list" aria-label="Rules by priority">
            {edited ? wired.map((w) => <WiredRow key={w.id} doc={doc} wired={w} motion_name={motion_name} />) : rules.map((rule, i) => (
              <RuleRow
                key={rule.id}
                rule={rule}
                index={i}
                last={i === rules.length - 1}
                selected={rule === selected}
                active={value_of(`${rule_lsi(rule)}.active`) > 0}
                count={value_of(`${rule_lsi(rule)}.count`)}
                problem={rule_problem(doc, rule)}
                text={rule_text(doc, rule, motion_name)}
                dragged={dragged}
                set_dragged={set_dragged}
                add_condition={() => void session.edit(set_rule(rule.id, { if: [...rule.if, new_condition('key', doc, action_character(rule.do))] }))}
              >
                <Sentence doc={doc} rule={rule} motion_name={motion_name} />
              </RuleRow>
            ))}
          </ol>
          {shown && rules.some((r) => r.do.type === 'play') && (
            <section className="rule-states" aria-label="State machine">
              <h4>States of {shown.name}</h4>
              <Graph doc={edited ? { ...doc, rules: wired.flatMap((w) => (w.rule ? [w.rule] : [])) } : doc} character={shown} motion_name={motion_name} now={Number.isNaN(now) ? null : now} connect={(from, to) => connect(doc, shown.id, from, to)} add_state={(entry) => add_state(shown.id, entry)} />
            </section>
          )}
        </div>
      )}
      {menu && <Menu x={menu.x} y={menu.y} over label="New rule" close={() => set_menu(null)} items={rule_templates.map((t) => ({ label: t.label, title: t.hint, run: () => add_rule(t.id) }))} />}
    </div>
  );
}

const wired_words: Record<WiredRule['state'], string> = { same: '', changed: 'changed in the circuit', own: 'edited in the circuit', missing: 'not in the circuit' };

/** A rule of the project's own circuit: the sentence of what it does, or the rule that it was before it was edited in the circuit. */
function WiredRow({ doc, wired: { id, state, rule, known }, motion_name }: { doc: ScenarioDocument; wired: WiredRule; motion_name: (motion: string) => string }): ReactElement {
  const before = doc.rules?.find((r) => r.id === id);
  const sentence = rule ?? before;
  const word = known ? wired_words[state] : rule ? 'added in the circuit' : 'own circuit';
  const text = sentence ? rule_text(doc, sentence, motion_name) : `The LSI “${id}”`;
  return (
    <li className="rule wired" aria-label={word ? `${text} (${word})` : text} data-rule={id} data-wired={state} data-off={state === 'own' || state === 'missing'}>
      <span className="rule-sentence" title={before && state !== 'same' ? `Before: ${rule_text(doc, before, motion_name)}` : undefined}>{text}</span>
      {word && <span className="rule-problem" role="note">{word}</span>}
    </li>
  );
}

/** Adds a rule and selects it. */
function add(rule: Omit<Rule, 'id'>): void {
  const id = session.fresh_id('r');
  void session.edit({ type: 'rule.add', rule: { ...rule, id } }).then((ok) => ok && session.select({ kind: 'rule', rule: id }));
}

/** A drag between two states: a transition when a key is pressed; the key is a chip of the new rule. */
function connect(doc: ScenarioDocument, character: string, from: string, to: string): void {
  const rule = transition_rule(doc, character, from, to);
  if (rule) add(rule);
  else session.notify('A motion returns to the track by itself: when it ends, or when its “while” ends. Drag to a state with a motion.');
}

/** A motion that is dropped on the states: a new state, which a key starts. */
function add_state(character: string, key: string): void {
  const { document } = session.state;
  const entry = session.entry(key);
  if (!document || !entry) return;
  add({ on: true, mode: 'when', if: [new_condition('key', document, character)], do: { type: 'play', character, motion: entry.id, speed: 1, blend: 0.3, loop: false } });
}

interface RowProps {
  rule: Rule;
  index: number;
  last: boolean;
  selected: boolean;
  active: boolean;
  count: number;
  problem: string | null;
  text: string;
  dragged: string | null;
  set_dragged: (id: string | null) => void;
  add_condition: () => void;
  children: ReactElement;
}

function RuleRow({ rule, index, last, selected, active, count, problem, text, dragged, set_dragged, add_condition, children }: RowProps): ReactElement {
  const move = (at: number): void => void session.edit({ type: 'rule.move', id: rule.id, at });
  /** A motion of the library that is dropped on the rule becomes its motion; a rule that is dropped takes this place. */
  const drop = (event: DragEvent): void => {
    const entry = page.getState().dragged_entry;
    if (dragged) {
      event.preventDefault();
      if (dragged !== rule.id) void session.edit({ type: 'rule.move', id: dragged, at: index });
      set_dragged(null);
    } else if (entry && rule.do.type === 'play' && session.entry(entry)?.kind === 'motion') {
      event.preventDefault();
      event.stopPropagation();
      page.setState({ dragged_entry: null });
      void session.edit(set_rule(rule.id, { do: { ...rule.do, motion: session.entry(entry)!.id } }));
    }
  };
  return (
    <li
      className="rule"
      aria-label={text}
      data-rule={rule.id}
      data-active={active}
      data-off={!rule.on}
      data-selected={selected}
      onPointerDown={() => session.select({ kind: 'rule', rule: rule.id })}
      onDragOver={(e) => {
        if (dragged || page.getState().dragged_entry) e.preventDefault();
      }}
      onDrop={drop}
    >
      <span
        className="rule-grip"
        draggable
        title="Drag to change the priority"
        aria-hidden="true"
        onDragStart={(e) => {
          e.dataTransfer.effectAllowed = 'move';
          set_dragged(rule.id);
        }}
        onDragEnd={() => set_dragged(null)}
      />
      <button type="button" role="switch" className="switch" aria-checked={rule.on} aria-label={`Rule ${index + 1} is on`} onClick={() => void session.edit(set_rule(rule.id, { on: !rule.on }))}>
        <span />
      </button>
      {children}
      {problem && <span className="rule-problem" title={problem} role="note" aria-label={problem}>no effect</span>}
      <span className="rule-count" data-active={active}>{!rule.on ? 'off' : active ? 'now' : count > 0 ? `${count}×` : ''}</span>
      <span className="rule-tools">
        <button type="button" className="rule-minor" aria-label={`+ and: add a condition to rule ${index + 1}`} title="Add a condition that must also be true" onClick={add_condition}>+ and</button>
        <button type="button" className="rule-minor" aria-label={`Move rule ${index + 1} up`} title="Higher priority" disabled={index === 0} onClick={() => move(index - 1)}><Icon name="up" /></button>
        <button type="button" className="rule-minor" aria-label={`Move rule ${index + 1} down`} title="Lower priority" disabled={last} onClick={() => move(index + 1)}><Icon name="down" /></button>
        <button type="button" className="rule-minor" aria-label={`Remove rule ${index + 1}`} title="Remove the rule" onClick={() => void session.edit({ type: 'rule.remove', id: rule.id })}><Icon name="close" /></button>
      </span>
    </li>
  );
}
