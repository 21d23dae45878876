/** Variables of the rules: a row of values above the rules, their fields in the inspector, and their values over the viewport. */
import { useEffect, useRef, type ReactElement } from 'react';
import type { Command, ScenarioDocument } from '../../core/document';
import { shown_document } from '../../core/state';
import { new_variable, variable_pin, variable_text, type Variable, type VariableFields as Fields } from '../../core/variables';
import { run } from '../actions';
import { session, useStudio } from '../app';
import { NumberField, SwitchField, TextField } from '../NumberField';

/** Adds a variable and selects it. @returns its id, or null if the service refused it */
export async function add_variable(kind: Variable['kind']): Promise<string | null> {
  const { document } = session.state;
  if (!document) return null;
  const id = session.fresh_id('x');
  if (!(await session.edit({ type: 'variable.add', variable: new_variable(document, kind, id) }))) return null;
  session.select({ kind: 'variable', variable: id });
  return id;
}

/** @param value_of present value of an output, NaN while nothing runs */
export function VariableRow({ doc, value_of }: { doc: ScenarioDocument; value_of: (pin: string) => number }): ReactElement {
  const selection = useStudio((s) => s.selection);
  return (
    <div className="variables" role="group" aria-label="Variables">
      {(doc.variables ?? []).map((variable) => {
        const live = value_of(variable_pin(variable));
        return (
          <button
            key={variable.id}
            type="button"
            className="variable"
            data-kind={variable.kind}
            data-selected={selection.kind === 'variable' && selection.variable === variable.id}
            data-variable={variable.id}
            title={`${variable.name} begins at ${variable_text(variable, variable.initial)}. Click to change it in the inspector`}
            onClick={() => session.select({ kind: 'variable', variable: variable.id })}
          >
            <span>{variable.name}</span>
            <strong data-live={!Number.isNaN(live)}>{variable_text(variable, Number.isNaN(live) ? variable.initial : live)}</strong>
          </button>
        );
      })}
      <button type="button" className="quiet" title="Add a number that rules count and compare: points, health, a time" onClick={() => void add_variable('number')}>+ Number</button>
      <button type="button" className="quiet" title="Add a switch that rules turn on and off" onClick={() => void add_variable('switch')}>+ Switch</button>
    </div>
  );
}

export function VariableFields({ variable }: { variable: Variable }): ReactElement {
  const send = (fields: Fields): void => void session.edit({ type: 'variable.set', id: variable.id, variable: fields } satisfies Command);
  const number = variable.kind === 'number';
  const { minimum = null, maximum = null } = variable;
  return (
    <>
      <h3>
        Variable <span className="of">{variable.name}</span>
      </h3>
      <p className="facts">{number ? 'A number that rules compare and change.' : 'A switch that rules turn on and off.'}</p>
      <TextField label="Name" value={variable.name} on_commit={(name) => send({ name })} />
      {number ? (
        <NumberField label="At the start" unit={variable.unit ?? ''} value={variable.initial} step={0.1} min={minimum ?? -1e9} max={maximum ?? 1e9} title="Value when the content starts" on_commit={(initial) => send({ initial })} />
      ) : (
        <SwitchField label="At the start" value={variable.initial > 0} title="State when the content starts" on_commit={(on) => send({ initial: on ? 1 : 0 })} />
      )}
      {number && (
        <>
          <TextField label="Unit" value={variable.unit ?? ''} optional placeholder="none" title="Text behind the value, for example %" on_commit={(unit) => send({ unit })} />
          <SwitchField label="Lower bound" value={minimum !== null} title="Rules cannot lower the value further" on_commit={(on) => send({ minimum: on ? Math.min(0, variable.initial) : null })} />
          {minimum !== null && <NumberField label="Minimum" value={minimum} step={0.1} min={-1e9} max={Math.min(variable.initial, maximum ?? 1e9)} on_commit={(v) => send({ minimum: v })} />}
          <SwitchField label="Upper bound" value={maximum !== null} title="Rules cannot raise the value further" on_commit={(on) => send({ maximum: on ? Math.max(100, variable.initial) : null })} />
          {maximum !== null && <NumberField label="Maximum" value={maximum} step={0.1} min={Math.max(variable.initial, minimum ?? -1e9)} max={1e9} on_commit={(v) => send({ maximum: v })} />}
        </>
      )}
      <SwitchField label="In the picture" value={variable.shown !== false} title="Show the value over the viewport while the content runs" on_commit={(shown) => send({ shown })} />
      <UsedBy id={variable.id} />
      <div className="actions">
        <button type="button" title="Remove the variable, with the rules that compare or change it" onClick={() => run('edit.remove')}>Delete</button>
      </div>
    </>
  );
}

/** The number of rules that compare or change a variable. */
function UsedBy({ id }: { id: string }): ReactElement {
  const rules = useStudio(shown_document)?.rules ?? [];
  const count = rules.filter((r) => (r.do.type === 'set' && r.do.variable === id) || r.if.some((c) => c.variable === id)).length;
  return <p className="facts">{count === 0 ? 'No rule uses it yet: select it in a condition or an action of a rule.' : `${count} ${count === 1 ? 'rule uses' : 'rules use'} it.`}</p>;
}

const poll_time = 100; // ms

/** Values of variables over the viewport while the content runs. Written to the DOM without rendering in React. */
export function VariableBoard(): ReactElement | null {
  const simulate = useStudio((s) => s.transport.mode === 'simulate');
  const variables = useStudio((s) => s.document?.variables);
  const own_circuit = useStudio((s) => Boolean(s.document?.circuit));
  const shown = simulate && !own_circuit ? (variables ?? []).filter((v) => v.shown !== false) : [];
  const values = useRef(new Map<string, HTMLElement>());
  const key = shown.map(variable_pin).join(' ');
  useEffect(() => {
    const pins = key ? key.split(' ') : [];
    session.watch_variables(pins);
    if (pins.length === 0) return;
    const write = (): void => {
      for (const variable of session.state.document?.variables ?? []) {
        const element = values.current.get(variable.id);
        const value = session.live.pin(variable_pin(variable))?.numbers[0];
        if (element) element.textContent = variable_text(variable, value ?? variable.initial);
      }
    };
    write();
    const timer = setInterval(write, poll_time);
    return () => {
      clearInterval(timer);
      session.watch_variables([]);
    };
  }, [key]);
  if (shown.length === 0) return null;
  return (
    <dl className="variable-board" aria-label="Variables">
      {shown.map((variable) => (
        <div key={variable.id}>
          <dt>{variable.name}</dt>
          <dd
            ref={(element) => {
              if (element) values.current.set(variable.id, element);
              else values.current.delete(variable.id);
            }}
          />
        </div>
      ))}
    </dl>
  );
}
