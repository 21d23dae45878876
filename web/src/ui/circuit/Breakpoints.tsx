/** Breakpoints: the form that adds one, their list, and the notice of a run that stopped at one. */
import { useState, type ReactElement } from 'react';
import { components_of, condition_alone, relations, takes_value, write_condition, type Relation } from '../../core/circuit/breakpoints';
import { short_number } from '../../core/circuit/live';
import { split_flat } from '../../core/circuit/problems';
import { circuit, parts, session, useCircuit, useStudio } from '../app';
import { Icon } from '../icons';

/** Shows the LSI of a pin, which is given with its path ("arm/elbow.out"), in the canvas. */
function show(pin: string): void {
  const ids = split_flat(pin)[0].split('/');
  circuit.go_to(ids);
  parts.circuit?.fit(new Set([ids.at(-1)!]));
}

export function StopForm({ origin }: { origin: () => DOMRect | undefined }): ReactElement | null {
  const open = useCircuit((s) => s.stopping);
  if (!open) return null;
  const box = origin();
  const left = Math.max(8, Math.min(open.screen.x - (box?.left ?? 0), (box?.width ?? 400) - 310));
  const top = Math.max(8, Math.min(open.screen.y - (box?.top ?? 0), (box?.height ?? 300) - 150));
  return <Form key={open.flat} flat={open.flat} type={open.type} unit={open.unit} left={left} top={top} />;
}

function Form({ flat, type, unit, left, top }: { flat: string; type: string; unit: string; left: number; top: number }): ReactElement {
  const [relation, set_relation] = useState<Relation>('>');
  const [component, set_component] = useState('0');
  const [value, set_value] = useState('0');
  const names = components_of(type);
  const index = Number(component);
  const number = value.trim() === '' ? NaN : Number(value);
  const good = Number.isInteger(index) && index >= 0 && (!takes_value(relation) || Number.isFinite(number));
  const close = (): void => {
    circuit.close_stop();
    document.querySelector<HTMLElement>('.circuit[role=application]')?.focus();
  };
  return (
    <form
      className="stop-form nodrag"
      style={{ left, top }}
      role="dialog"
      aria-label="Add breakpoint"
      onKeyDown={(e) => {
        e.stopPropagation();
        if (e.key === 'Escape') close();
      }}
      onSubmit={(e) => {
        e.preventDefault();
        if (!good) return;
        session.add_breakpoint(write_condition(flat, index, relation, number));
        close();
      }}
    >
      <p>Stop when <strong>{circuit.name_of(flat)}</strong></p>
      <div className="stop-line">
        {names === null && <input className="stop-index" aria-label="Component" title="Index of the component of the pin's value, counted from 0" value={component} onChange={(e) => set_component(e.target.value)} />}
        {names !== null && names.length > 0 && (
          <select aria-label="Component" title="Component of the pin's value" value={component} onChange={(e) => set_component(e.target.value)}>
            {names.map((name, i) => <option key={name} value={i}>{name}</option>)}
          </select>
        )}
        <select autoFocus aria-label="Condition" value={relation} onChange={(e) => set_relation(e.target.value as Relation)}>
          {relations.map(([sign, words]) => <option key={sign} value={sign}>{words}</option>)}
        </select>
        {takes_value(relation) && <input className="stop-value" aria-label="Value" inputMode="decimal" value={value} aria-invalid={!good} onFocus={(e) => e.target.select()} onChange={(e) => set_value(e.target.value)} />}
        {takes_value(relation) && unit && <span className="unit">{unit}</span>}
      </div>
      <div className="actions">
        <button type="submit" disabled={!good}>Add</button>
        <button type="button" onClick={close}>Cancel</button>
      </div>
    </form>
  );
}

/** The number of breakpoints in the bar, and their list, in which each can be switched on or off and removed. */
export function BreakpointCount(): ReactElement | null {
  const list = useStudio((s) => s.breakpoints);
  const [listed, set_listed] = useState(false);
  if (list.length === 0) return null;
  const on = list.filter((b) => b.on).length;
  return (
    <>
      <button type="button" className="stop-count" aria-expanded={listed} title="Show or hide the list of breakpoints" onClick={() => set_listed(!listed)}>
        <span className={`stop-dot${on > 0 ? '' : ' off'}`} />
        {list.length === 1 ? '1 breakpoint' : `${list.length} breakpoints`}{on < list.length ? `, ${on} on` : ''}
      </button>
      {listed && (
        <ul className="problem-list stop-list" role="list" aria-label="Breakpoints">
          {list.map((b) => (
            <li key={b.condition}>
              <button type="button" title="Show the LSI in the circuit" onClick={() => show(b.pin)}>{circuit.name_of(b.pin)} <strong>{condition_alone(b)}</strong></button>
              <label><input type="checkbox" checked={b.on} onChange={(e) => session.switch_breakpoints((x) => x.condition === b.condition, e.target.checked)} /> on</label>
              <button type="button" className="tool small" aria-label={`Remove the breakpoint ${b.condition}`} title="Remove the breakpoint" onClick={() => session.remove_breakpoints((x) => x.condition === b.condition)}><Icon name="close" /></button>
            </li>
          ))}
        </ul>
      )}
    </>
  );
}

/** Button that computes one tick of the simulation and pauses. */
export function OneTick(): ReactElement {
  const simulate = useStudio((s) => s.transport.mode === 'simulate');
  return <button type="button" disabled={!simulate} title={simulate ? 'Compute one tick and pause  (T)' : 'Available in Simulate'} onClick={() => session.step_tick()}>One tick</button>;
}

export function StopNotice(): ReactElement | null {
  const hit = useStudio((s) => s.breakpoint_hit);
  if (!hit) return null;
  return (
    <div className="stop-notice" role="alert">
      <span className="stop-dot" />
      <button type="button" className="stop-name" title="Show the LSI in the circuit" onClick={() => show(hit.pin)}>{circuit.name_of(hit.pin)} <strong>{condition_alone(hit)}</strong></button>
      <span className="of">is {hit.value === null ? 'not finite' : short_number(hit.value)} at {hit.time.toFixed(3)} s, tick {hit.tick}</span>
      <button type="button" className="stop-on" title="Continue playing" onClick={() => session.play()}>Continue</button>
    </div>
  );
}
