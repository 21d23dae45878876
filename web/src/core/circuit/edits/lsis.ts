/** Edits of LSIs: add, move, remove and set, including dependent wires, parameters, notes and probes. */
import { ends_of, fresh_id, split_end, write_ends, type Lsi, type Point, type Value } from '../form';
import { find_circuit, inputs_node, note_id, outputs_node, probe_id, type View } from '../view';
import { types_fit, type PinAt } from '../fits';
import { command, snap, Batch, ids_of, quote, title_of, type CircuitCommand } from './batch';
import { put_wire, take_wires } from './wires';

/** Adds an LSI of `type` at `at`. Its first fitting pin is wired to `wire_to`. @return the command and the new id */
export function add_lsi(view: View, type: string, at: Point, wire_to?: PinAt, parameters?: Record<string, Value>): { command: CircuitCommand; id: string } {
  const id = fresh_id(type, ids_of(view));
  const batch = new Batch(view);
  batch.lsi({ id, type, at: snap(at, true), parameters });
  if (wire_to) {
    const pin = first_fit(view, type, wire_to);
    const kind = view.pin(wire_to.node, wire_to.side, wire_to.pin)?.type ?? 'any';
    if (pin) {
      const own: PinAt = { node: id, side: wire_to.side === 'out' ? 'in' : 'out', pin: pin.name };
      const [from, to] = wire_to.side === 'out' ? [wire_to, own] : [own, wire_to];
      put_wire(view, batch, from, to, kind === 'any' ? pin.type : kind);
    }
  }
  return { command: { type: 'circuit.edit', label: `Add ${type}`, changes: batch.changes }, id };
}

/** The first pin of an LSI class or circuit `type` that fits `pin`. */
export function first_fit(view: View, type: string, pin: PinAt): { name: string; type: string } | undefined {
  const wanted = view.pin(pin.node, pin.side, pin.pin)?.type ?? 'any';
  const inner = find_circuit(view.level, type)?.circuit;
  const found = inner ?? view.classes.find(type);
  const pins: readonly { name: string; type: string }[] = (pin.side === 'out' ? found?.inputs : found?.outputs) ?? [];
  return pins.find((p) => types_fit(p.type, wanted));
}

export interface Selection {
  /** Node ids: LSIs, `inputs_node`, `note_id(…)`, `probe_id(…)`. */
  nodes: ReadonlySet<string>;
  wires: ReadonlySet<string>;
}

/** Removes the selection, with the wires, parameters and probes that refer to it. */
export function remove(view: View, selection: Selection): CircuitCommand | null {
  const { circuit } = view.level;
  const batch = new Batch(view);
  const lsis = (circuit.lsis ?? []).filter((l) => selection.nodes.has(l.id));
  const gone = new Set(lsis.map((l) => l.id));
  take_wires(view, batch, view.wires.filter((w) => selection.wires.has(w.key) || gone.has(w.from) || gone.has(w.to)));
  for (const lsi of lsis) batch.add({ list: 'lsis', take: lsi.id });
  for (const p of circuit.parameters ?? []) {
    const ends = ends_of(p.to);
    const kept = ends.filter((e) => !gone.has(split_end(e)[0]));
    if (kept.length < ends.length) batch.add(kept.length > 0 ? { list: 'parameters', put: { ...p, to: write_ends(kept) } } : { list: 'parameters', take: p.name });
  }
  for (const probe of circuit.probes ?? []) {
    if (selection.nodes.has(probe_id(probe.pin)) || gone.has(split_end(probe.pin)[0])) batch.add({ list: 'probes', take: probe.pin });
  }
  for (const note of circuit.notes ?? []) if (selection.nodes.has(note_id(note.id))) batch.add({ list: 'notes', take: note.id });
  const others = batch.changes.length - lsis.length;
  const label = lsis.length === 1 ? `Delete ${quote(title_of(view, lsis[0]!.id))}` : lsis.length > 1 ? `Delete ${lsis.length} LSIs` : others === 1 && selection.wires.size === 1 ? 'Remove wire' : 'Delete';
  return command(label, batch.changes);
}

/** Moves nodes, notes and probes to new positions, by node id. */
export function move(view: View, places: ReadonlyMap<string, Point>, label?: string): CircuitCommand | null {
  const { circuit } = view.level;
  const batch = new Batch(view);
  const differs = (a: Point | undefined, b: Point): boolean => (a?.[0] ?? 0) !== b[0] || (a?.[1] ?? 0) !== b[1];
  let last = '';
  for (const lsi of circuit.lsis ?? []) {
    const at = places.get(lsi.id);
    if (at && differs(lsi.at, at)) {
      batch.lsi({ ...lsi, at: [at[0] + 0, at[1] + 0] }); // + 0 converts -0, which JSON does not preserve, to 0
      last = view.node(lsi.id)?.title ?? lsi.id;
    }
  }
  for (const note of circuit.notes ?? []) {
    const at = places.get(note_id(note.id));
    if (at && differs(note.at, at)) batch.add({ list: 'notes', put: { ...note, at } });
  }
  for (const probe of circuit.probes ?? []) {
    const at = places.get(probe_id(probe.pin));
    if (at && differs(probe.at, at)) batch.add({ list: 'probes', put: { ...probe, at } });
  }
  for (const [id, field] of [[inputs_node, 'inputs_at'], [outputs_node, 'outputs_at']] as const) {
    const at = places.get(id);
    if (at && (!circuit[field] || differs(circuit[field], at))) batch.add({ set: { [field]: at } });
  }
  return command(label ?? (batch.changes.length === 1 ? `Move ${last ? quote(last) : 'item'}` : `Move ${batch.changes.length} items`), batch.changes);
}

export function set_lsi(view: View, id: string, fields: Partial<Omit<Lsi, 'id'>>, label: string): CircuitCommand | null {
  const lsi = view.node(id)?.lsi;
  if (!lsi) return null;
  const batch = new Batch(view);
  batch.lsi({ ...lsi, ...fields });
  return command(label, batch.changes);
}

export const rename = (view: View, id: string, label: string): CircuitCommand | null => set_lsi(view, id, { label: label === id ? '' : label }, `Rename ${quote(title_of(view, id))}`);

/** Sets a parameter; undefined resets it to its default. */
export function set_parameter(view: View, id: string, name: string, value: Value | undefined): CircuitCommand | null {
  const lsi = view.node(id)?.lsi;
  if (!lsi) return null;
  const parameters = { ...lsi.parameters };
  if (value === undefined) delete parameters[name];
  else parameters[name] = value;
  return set_lsi(view, id, { parameters }, `Set ${name} of ${quote(title_of(view, id))}`);
}

/** Sets the value of an input that is not wired; undefined resets it to its default. */
export function set_value(view: View, id: string, pin: string, value: Value | undefined): CircuitCommand | null {
  const lsi = view.node(id)?.lsi;
  if (!lsi) return null;
  const values = { ...lsi.values };
  if (value === undefined) delete values[pin];
  else values[pin] = value;
  return set_lsi(view, id, { values }, `Set ${pin} of ${quote(title_of(view, id))}`);
}
