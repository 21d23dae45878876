/**
 * Inspector of the wiring editor's selection: an LSI's problems, parameters, unwired inputs and output values; or a note, probe, wire or
 * circuit pins.
 */
import { useEffect, useRef, useState, type ReactElement } from 'react';
import { hue_of, type InputDeclaration, type ParameterDeclaration } from '../../core/circuit/classes';
import { ends_of, split_end, type Lsi, type Value } from '../../core/circuit/form';
import { short_time, short_value } from '../../core/circuit/live';
import { find_circuit, inputs_node, note_id, outputs_node, type PinInfo, type View, type ViewNode } from '../../core/circuit/view';
import { circuit, session, useCircuit } from '../app';
import { ChoiceField, NumberField, SwitchField, TextField } from '../NumberField';

export function CircuitSelection(): ReactElement | null {
  const view = useCircuit((s) => s.view);
  const nodes = useCircuit((s) => s.nodes);
  const wires = useCircuit((s) => s.wires);
  if (!view) return null;
  const [only] = nodes;
  if (nodes.size === 1 && only !== undefined) {
    const node = view.node(only);
    if (node?.lsi) return <LsiFields key={only} node={node} lsi={node.lsi} view={view} />;
    if (only === inputs_node || only === outputs_node) return <OwnPins view={view} side={only === inputs_node ? 'inputs' : 'outputs'} />;
    const note = view.notes.find((n) => note_id(n.id) === only);
    if (note) return <><h3>Note</h3><p className="facts">Double-click the note to edit it.</p><p className="note-text">{note.text}</p></>;
    const probe = view.probes.find((p) => `probe:${p.pin}` === only);
    if (probe) return <ProbeFields pin={probe.pin} components={probe.components} view={view} />;
  }
  if (nodes.size > 1) {
    return (
      <>
        <h3>{nodes.size} selected</h3>
        <div className="actions">
          <button type="button" title="Make one circuit of the selected LSIs" onClick={() => circuit.group()}>Group</button>
          <button type="button" onClick={() => circuit.duplicate()}>Duplicate</button>
          <button type="button" onClick={() => circuit.remove()}>Delete</button>
        </div>
      </>
    );
  }
  const [key] = wires;
  const wire = key !== undefined ? view.wire(key) : undefined;
  if (!wire) return null;
  return (
    <>
      <h3>Wire <span className="of">{wire.type}</span></h3>
      <p className="facts">{view.node(wire.from)?.title ?? wire.from} · {wire.from_pin} → {view.node(wire.to)?.title ?? wire.to} · {wire.to_pin}{wire.delayed ? '; delayed by one tick' : ''}</p>
      <LiveValue node={wire.from} pin={view.pin(wire.from, 'out', wire.from_pin)} />
      <div className="actions">
        <button type="button" title="Add or remove a curve of this output" onClick={() => circuit.toggle_probe({ node: wire.from, side: 'out', pin: wire.from_pin })}>Probe</button>
        <button type="button" onClick={() => circuit.remove()}>Remove</button>
      </div>
    </>
  );
}

const title_of = (text: string | undefined, unit?: string): string | undefined => [text, unit && `[${unit}]`].filter(Boolean).join(' ') || undefined;

function LsiFields({ node, lsi, view }: { node: ViewNode; lsi: Lsi; view: View }): ReactElement {
  const inner = node.kind === 'circuit' ? find_circuit(view.level, lsi.type)?.circuit : undefined;
  const declared = view.classes.find(lsi.type);
  const problems = useCircuit((s) => s.problems).length > 0 ? circuit.problems_of(node.id) : [];
  return (
    <>
      <h3>
        {node.kind === 'circuit' ? 'Circuit' : 'LSI'} <span className="of">{lsi.type}</span>
      </h3>
      {node.doc && <p className="facts">{node.doc}</p>}
      {node.kind === 'missing' && <p className="facts">This LSI is not installed. Its wires and parameters are kept. Install its library to run the circuit.</p>}
      {problems.map((p, i) => (
        <p key={i} className="problem-note">{p.message} {p.remedy}</p>
      ))}
      <TextField label="Name" value={node.title} on_commit={(name) => circuit.rename(node.id, name)} />
      {declared && <Parameters node={node} lsi={lsi} declared={declared.parameters} />}
      {inner && (inner.parameters ?? []).length > 0 && <Parameters node={node} lsi={lsi} declared={circuit_parameters(view, lsi.type)} />}
      {node.kind === 'missing' && Object.entries(lsi.parameters ?? {}).map(([name, value]) => (
        <div key={name} className="field"><span>{name}</span><output>{String(value)}</output></div>
      ))}
      {declared && <InputValues node={node} lsi={lsi} declared={declared.inputs} />}
      {node.outputs.length > 0 && (
        <>
          <h4>Outputs</h4>
          <div className="lsi-values">{node.outputs.map((pin) => <LiveValue key={pin.name} node={node.id} pin={pin} probe />)}</div>
        </>
      )}
      <h4>Schedule</h4>
      <ChoiceField
        label="Rate"
        title="How often the LSI runs"
        value={String(lsi.every ?? 1)}
        choices={[...new Set(['1', '2', '4', '8', '16', '0', String(lsi.every ?? 1)])].map((n) => [n, n === '0' ? 'when displayed' : n === '1' ? 'every tick' : `every ${n} ticks`])}
        on_commit={(n) => circuit.set_every(node.id, Number(n))}
      />
      <div className="field"><span>Time</span><output><Time id={node.id} /></output></div>
      <h4>Comment</h4>
      <textarea key={node.note} aria-label="Comment" defaultValue={node.note} placeholder="Purpose of this LSI" spellCheck={false} onBlur={(e) => circuit.comment(node.id, e.target.value)} />
      <div className="actions">
        {inner && <button type="button" title="Show the inside of this circuit" onClick={() => circuit.go_inside(node.id)}>Open</button>}
        {inner && <button type="button" title="Replace this circuit by the LSIs inside it" onClick={() => circuit.ungroup()}>Ungroup</button>}
        <button type="button" onClick={() => circuit.duplicate()}>Duplicate</button>
        <button type="button" onClick={() => circuit.remove()}>Delete</button>
      </div>
    </>
  );
}

/** Declarations of the parameters of the circuit `type`. Each sets a parameter of an inner LSI and has its type, unit and range. */
function circuit_parameters(view: View, type: string): ParameterDeclaration[] {
  const inner = find_circuit(view.level, type)?.circuit;
  return (inner?.parameters ?? []).flatMap((p): ParameterDeclaration[] => {
    const [id, name] = split_end(ends_of(p.to)[0] ?? '');
    const set = inner?.lsis?.find((l) => l.id === id);
    const declared = set && view.classes.find(set.type)?.parameters.find((q) => q.name === name);
    return declared ? [{ ...declared, name: p.name, doc: p.doc ?? declared.doc, initial: set.parameters?.[name] ?? declared.initial }] : [];
  });
}

/** A declared limit; undefined if there is none (null, or at least 1e300 in magnitude). */
const limit = (v: number | null | undefined): number | undefined => (v === null || v === undefined || Math.abs(v) >= 1e300 ? undefined : v);
/** Step of a number field: 1/200 of a range of at most 1000, otherwise 0.1 to 1 % of the value and at least 0.001. */
const step_of = (p: { minimum?: number | null; maximum?: number | null }, value: number): number => {
  const [low, high] = [limit(p.minimum), limit(p.maximum)];
  if (low !== undefined && high !== undefined && high - low <= 1000) return (high - low) / 200;
  return Math.max(0.001, Math.pow(10, Math.floor(Math.log10(Math.abs(value) || 1)) - 2));
};

function Parameters({ node, lsi, declared }: { node: ViewNode; lsi: Lsi; declared: ParameterDeclaration[] }): ReactElement | null {
  const characters = useCharacters();
  if (declared.length === 0) return null;
  return (
    <>
      <h4>Parameters</h4>
      {declared.map((p) => {
        const given = lsi.parameters?.[p.name];
        const value = given ?? p.initial;
        const set = (v: Value): void => circuit.set_parameter(node.id, p.name, v);
        const title = title_of(p.doc, p.unit);
        if (p.kind === 'boolean') return <SwitchField key={p.name} label={p.name} title={title} value={value === true} on_commit={set} />;
        if (p.kind === 'choice') return <ChoiceField key={p.name} label={p.name} title={title} value={String(value)} choices={(p.choices ?? []).map((c) => [c, c])} on_commit={set} />;
        if (p.kind === 'text' && p.name === 'character') return <ChoiceField key={p.name} label={p.name} title={title} value={String(value)} choices={[...new Set([...characters.map((c) => c[0]), String(value)])].map((id) => [id, characters.find((c) => c[0] === id)?.[1] ?? id])} on_commit={set} />;
        if (p.kind === 'text') return <TextField key={p.name} label={p.name} value={String(value)} on_commit={set} />;
        if (p.kind === 'vector') return <VectorField key={p.name} name={p.name} unit={p.unit} title={title} value={value as number[]} step={step_of(p, Math.max(...(value as number[]).map(Math.abs)))} on_commit={set} />;
        const low = limit(p.minimum);
        const high = limit(p.maximum);
        return (
          <NumberField
            key={p.name} label={p.name} title={title} unit={p.unit} value={Number(value)} digits={p.kind === 'integer' ? 0 : 3} step={p.kind === 'integer' ? 1 : step_of(p, Number(value))}
            min={low} max={high} slider={low !== undefined && high !== undefined && high - low <= 1000} on_commit={(v) => set(p.kind === 'integer' ? Math.round(v) : v)}
          />
        );
      })}
    </>
  );
}

function useCharacters(): [string, string][] {
  const [list, set_list] = useState<[string, string][]>([]);
  useEffect(() => {
    const read = (): void => set_list((session.state.document?.characters ?? []).map((c) => [c.id, c.name]));
    read();
    return session.store.subscribe((s, b) => s.document !== b.document && read());
  }, []);
  return list;
}

function VectorField({ name, unit, title, value, step, on_commit }: { name: string; unit?: string; title?: string; value: number[]; step: number; on_commit: (value: number[]) => void }): ReactElement {
  return (
    <>
      {value.map((v, i) => (
        <NumberField key={i} label={`${name} ${'xyzw'[i] ?? i}`} title={title} unit={unit} value={v} digits={3} step={step} on_commit={(next) => on_commit(value.map((old, k) => (k === i ? next : old)))} />
      ))}
    </>
  );
}

/** Fields for the constant values of unwired inputs whose pin type can have a constant value. */
function InputValues({ node, lsi, declared }: { node: ViewNode; lsi: Lsi; declared: InputDeclaration[] }): ReactElement | null {
  const open = declared.filter((p) => !node.inputs.find((q) => q.name === p.name)?.wired && !p.multiple && ['scalar', 'vector', 'rotation', 'pose'].includes(p.type));
  if (open.length === 0) return null;
  const sizes: Record<string, number[]> = { vector: [0, 0, 0], rotation: [1, 0, 0, 0], pose: [0, 0, 0, 1, 0, 0, 0] };
  return (
    <>
      <h4>Unwired inputs</h4>
      {open.map((p) => {
        const given = lsi.values?.[p.name];
        const title = title_of(p.doc, p.unit);
        const set = (v: Value): void => circuit.set_value(node.id, p.name, v);
        if (p.type === 'scalar') return <NumberField key={p.name} label={p.name} title={title} unit={p.unit} value={typeof given === 'number' ? given : (p.value ?? 0)} digits={3} step={0.01} on_commit={set} />;
        return <VectorField key={p.name} name={p.name} unit={p.unit} title={title} value={Array.isArray(given) ? given : sizes[p.type]!} step={0.01} on_commit={set} />;
      })}
    </>
  );
}

function Time({ id }: { id: string }): ReactElement {
  const text = useRef<HTMLSpanElement>(null);
  useEffect(() => {
    const update = (): void => {
      const us = session.live.time_of([...circuit.state.path, id].join('/'));
      if (text.current) text.current.textContent = us === undefined ? 'not measured yet' : `${short_time(us)} per tick`;
    };
    update();
    const timer = setInterval(update, 250);
    return () => clearInterval(timer);
  }, [id]);
  return <span ref={text} />;
}

function LiveValue({ node, pin, probe }: { node: string; pin: PinInfo | undefined; probe?: boolean }): ReactElement | null {
  const text = useRef<HTMLOutputElement>(null);
  const name = pin?.name;
  const type = pin?.type ?? 'any';
  useEffect(() => {
    const update = (): void => {
      const flat = name !== undefined ? circuit.flat_output(node, name) : null;
      const value = flat ? session.live.pin(flat) : undefined;
      if (text.current) text.current.textContent = value ? short_value(type, value) : '–';
    };
    update();
    const timer = setInterval(update, 200);
    return () => clearInterval(timer);
  }, [node, name, type]);
  if (!pin) return null;
  return (
    <div className="lsi-value" title={title_of(pin.doc, pin.unit)}>
      <span className={`pin-dot hue-${hue_of(pin.type)}`} />
      <span className="name">{pin.name} <span className="of">{pin.type}</span></span>
      <output ref={text} />
      {pin.unit && <span className="unit">{pin.unit}</span>}
      {probe && <button type="button" className="quiet" title="Add or remove a curve of this output" onClick={() => circuit.toggle_probe({ node, side: 'out', pin: pin.name })}>Probe</button>}
      {probe && circuit.stop_source({ node, side: 'out', pin: pin.name }) && (
        <button type="button" className="quiet" title="Add a breakpoint at this output" onClick={(e) => circuit.ask_stop({ node, side: 'out', pin: pin.name }, { x: e.clientX - 320, y: e.clientY })}>Break…</button>
      )}
    </div>
  );
}

function OwnPins({ view, side }: { view: View; side: 'inputs' | 'outputs' }): ReactElement {
  const pins = view.level.circuit[side] ?? [];
  return (
    <>
      <h3>{side === 'inputs' ? 'Inputs' : 'Outputs'} <span className="of">of {view.level.path.at(-1) ?? 'the execution circuit'}</span></h3>
      <p className="facts">{view.level.path.length > 0 ? 'Connect a wire to “new pin” to add a pin.' : 'Pins used by the player. Input: events. Outputs: state, contacts, events, poses, characters and measures.'}</p>
      {pins.map((pin) => (
        <div key={pin.name}>
          <TextField label={pin.type} value={pin.name} on_commit={(name) => circuit.rename_pin(side, pin.name, name)} />
          {view.level.path.length > 0 && <div className="actions"><button type="button" onClick={() => circuit.remove_pin(side, pin.name)}>Remove</button></div>}
        </div>
      ))}
    </>
  );
}

function ProbeFields({ pin, components, view }: { pin: string; components: number[] | undefined; view: View }): ReactElement {
  const [id, name] = split_end(pin);
  const [text, set_text] = useState<string | null>(null);
  const info = view.pin(id, 'out', name);
  const commit_text = (): void => {
    if (text === null) return;
    const numbers = text.split(/[\s,]+/).filter(Boolean).map(Number).filter((n) => Number.isInteger(n) && n >= 0);
    circuit.set_probe(pin, numbers.length > 0 ? numbers : undefined);
    set_text(null);
  };
  return (
    <>
      <h3>Probe <span className="of">{pin}</span></h3>
      <p className="facts">{info ? `${info.type}${info.unit ? `, ${info.unit}` : ''}` : 'This pin no longer exists.'}</p>
      <div className="field" title="Indices of the components to draw, counted from 0">
        <label htmlFor="probe-components">Components</label>
        <input id="probe-components" className="text" placeholder="the first 6" value={text ?? (components ?? []).join(', ')} onChange={(e) => set_text(e.target.value)} onBlur={commit_text} onKeyDown={(e) => e.key === 'Enter' && commit_text()} />
      </div>
      <div className="actions"><button type="button" onClick={() => circuit.toggle_probe({ node: id, side: 'out', pin: name })}>Remove</button></div>
    </>
  );
}
