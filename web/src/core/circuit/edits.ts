/** What each edit of a circuit changes: one serialisable command each. Pure functions of a view; null: there is nothing to do. */
import {
  ends_of, fresh_id, fresh_name, split_end, tidy_lsi, write_ends,
  type Change, type Circuit, type Lsi, type Note, type OwnPin, type Point, type Probe, type Value, type Wire,
} from './form';
import { find_circuit, grid, inputs_node, note_id, outputs_node, probe_id, type View, type ViewWire } from './view';
import { types_fit, type PinAt } from './fits';
import type { ClassList } from './classes';

export interface CircuitCommand {
  type: 'circuit.edit';
  label: string;
  changes: Change[];
}

const command = (label: string, changes: Change[]): CircuitCommand | null => (changes.length > 0 ? { type: 'circuit.edit', label, changes } : null);

const round = (v: number): number => Math.round(v * 100) / 100;
export const snap = (p: Point, on: boolean): Point => (on ? [Math.round(p[0] / grid) * grid, Math.round(p[1] / grid) * grid] : [round(p[0]), round(p[1])]);

class Batch {
  readonly changes: Change[] = [];
  private readonly in: string[] | undefined;
  constructor(view: View) {
    this.in = view.level.names.length > 0 ? view.level.names : undefined;
  }
  add(change: Change): void {
    this.changes.push(this.in ? { in: this.in, ...change } : change);
  }
  lsi(lsi: Lsi): void {
    this.add({ list: 'lsis', put: tidy_lsi(lsi) });
  }
}

const ids_of = (view: View): Set<string> => new Set((view.level.circuit.lsis ?? []).map((l) => l.id));
const quote = (name: string): string => `“${name}”`;
const count_of = (n: number, one: string): string => (n === 1 ? one : `${n} ${one}s`);
const title_of = (view: View, id: string): string => view.node(id)?.title ?? id;

// ---- wires ----

/** Adds the changes for a wire; the one that ends at a single input already is replaced. */
function put_wire(view: View, batch: Batch, from: PinAt, to: PinAt, type: string): void {
  const { circuit } = view.level;
  if (from.node === inputs_node) {
    const end = `${to.node}.${to.pin}`;
    free_input(view, batch, to);
    const own = circuit.inputs?.find((p) => p.name === from.pin);
    if (own) batch.add({ list: 'inputs', put: { ...own, to: write_ends([...ends_of(own.to).filter((e) => e !== end), end]) } });
    else batch.add({ list: 'inputs', put: { name: fresh_name(to.pin, names_of(circuit.inputs)), type, to: end } });
    return;
  }
  if (to.node === outputs_node) {
    const own = circuit.outputs?.find((p) => p.name === to.pin);
    const end = `${from.node}.${from.pin}`;
    if (own) batch.add({ list: 'outputs', put: { ...own, from: end } });
    else batch.add({ list: 'outputs', put: { name: fresh_name(from.pin, names_of(circuit.outputs)), type, from: end } });
    return;
  }
  free_input(view, batch, to);
  batch.add({ list: 'wires', put: { from: `${from.node}.${from.pin}`, to: `${to.node}.${to.pin}` } });
}

const names_of = (pins: readonly { name: string }[] | undefined): Set<string> => new Set((pins ?? []).map((p) => p.name));

function free_input(view: View, batch: Batch, to: PinAt): void {
  const target = view.pin(to.node, 'in', to.pin);
  if (target?.multiple) return;
  take_wires(view, batch, view.at_pin(to.node, 'in', to.pin));
}

function take_wires(view: View, batch: Batch, wires: Iterable<ViewWire>): void {
  const inputs = new Map<string, Set<string>>();
  for (const wire of wires) {
    if (wire.from === inputs_node) {
      const gone = inputs.get(wire.from_pin) ?? new Set();
      inputs.set(wire.from_pin, gone.add(`${wire.to}.${wire.to_pin}`));
    } else if (wire.to === outputs_node) {
      const own = view.level.circuit.outputs?.find((p) => p.name === wire.to_pin);
      if (own) batch.add({ list: 'outputs', put: { ...own, from: [] } });
    } else batch.add({ list: 'wires', take: { from: `${wire.from}.${wire.from_pin}`, to: `${wire.to}.${wire.to_pin}` } });
  }
  for (const [name, gone] of inputs) {
    const own = view.level.circuit.inputs?.find((p) => p.name === name);
    if (own) batch.add({ list: 'inputs', put: { ...own, to: write_ends(ends_of(own.to).filter((e) => !gone.has(e))) } });
  }
}

/** `a` and `b` are an output and an input in any order that fit (fits.ts). `instead`: the wire that moves its end. */
export function connect(view: View, a: PinAt, b: PinAt, instead?: ViewWire): CircuitCommand | null {
  const [from, to] = a.side === 'out' ? [a, b] : [b, a];
  const batch = new Batch(view);
  if (instead) take_wires(view, batch, [instead]);
  const type = view.pin(from.node, 'out', from.pin)?.type ?? 'any';
  const other = view.pin(to.node, 'in', to.pin)?.type ?? 'any';
  put_wire(view, batch, from, to, type === 'any' ? other : type);
  return command(instead ? 'Move wire' : 'Wire', batch.changes);
}

export function disconnect(view: View, wires: readonly ViewWire[]): CircuitCommand | null {
  const batch = new Batch(view);
  take_wires(view, batch, wires);
  return command(wires.length === 1 ? 'Remove wire' : `Remove ${wires.length} wires`, batch.changes);
}

/** Puts a delay into a wire: breaks a circle of values. */
export function insert_delay(view: View, wire: ViewWire, classes: ClassList): { command: CircuitCommand; id: string } | null {
  const type = wire.type === 'scalar' ? 'delay' : `delay ${wire.type}`;
  const from = view.node(wire.from);
  const to = view.node(wire.to);
  if (!from || !to || !classes.find(type)) return null;
  const id = fresh_id('delay', ids_of(view));
  const batch = new Batch(view);
  take_wires(view, batch, [wire]);
  const below = Math.max(from.y + from.height, to.y + to.height) + 30;
  const forwards = to.x - from.x - from.width > 220;
  const at: Point = forwards ? [(from.x + from.width + to.x) / 2 - 80, (from.y + to.y) / 2] : [(from.x + to.x) / 2, below];
  batch.lsi({ id, type, at: snap(at, true) });
  batch.add({ list: 'wires', put: { from: `${wire.from}.${wire.from_pin}`, to: `${id}.in` } });
  if (wire.to === outputs_node) {
    const own = view.level.circuit.outputs?.find((p) => p.name === wire.to_pin);
    if (own) batch.add({ list: 'outputs', put: { ...own, from: `${id}.out` } });
  } else batch.add({ list: 'wires', put: { from: `${id}.out`, to: `${wire.to}.${wire.to_pin}` } });
  return { command: { type: 'circuit.edit', label: 'Insert delay', changes: batch.changes }, id };
}

// ---- LSIs ----

/** Adds an LSI of `type`, wired to `wire_to` by its first pin that fits. */
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

/** The first pin of an LSI or circuit `type` that could be wired to `pin`. */
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

/** New places, by node id. */
export function move(view: View, places: ReadonlyMap<string, Point>, label?: string): CircuitCommand | null {
  const { circuit } = view.level;
  const batch = new Batch(view);
  const differs = (a: Point | undefined, b: Point): boolean => (a?.[0] ?? 0) !== b[0] || (a?.[1] ?? 0) !== b[1];
  let last = '';
  for (const lsi of circuit.lsis ?? []) {
    const at = places.get(lsi.id);
    if (at && differs(lsi.at, at)) {
      batch.lsi({ ...lsi, at });
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

/** A parameter by name; undefined: back to its default. */
export function set_parameter(view: View, id: string, name: string, value: Value | undefined): CircuitCommand | null {
  const lsi = view.node(id)?.lsi;
  if (!lsi) return null;
  const parameters = { ...lsi.parameters };
  if (value === undefined) delete parameters[name];
  else parameters[name] = value;
  return set_lsi(view, id, { parameters }, `Set ${name} of ${quote(title_of(view, id))}`);
}

/** What an input without wire gets. */
export function set_value(view: View, id: string, pin: string, value: Value | undefined): CircuitCommand | null {
  const lsi = view.node(id)?.lsi;
  if (!lsi) return null;
  const values = { ...lsi.values };
  if (value === undefined) delete values[pin];
  else values[pin] = value;
  return set_lsi(view, id, { values }, `Set ${pin} of ${quote(title_of(view, id))}`);
}

// ---- notes and probes ----

export function add_note(view: View, at: Point): { command: CircuitCommand; id: string } {
  const id = fresh_id('note', new Set(view.notes.map((n) => n.id)));
  const batch = new Batch(view);
  batch.add({ list: 'notes', put: { id, text: '', at: snap(at, true), size: [180, 80] } });
  return { command: { type: 'circuit.edit', label: 'Add note', changes: batch.changes }, id };
}

export function set_note(view: View, id: string, fields: Partial<Omit<Note, 'id'>>, label = 'Write note'): CircuitCommand | null {
  const note = view.notes.find((n) => n.id === id);
  if (!note) return null;
  const batch = new Batch(view);
  batch.add({ list: 'notes', put: { ...note, ...fields } });
  return command(label, batch.changes);
}

export function toggle_probe(view: View, pin: string, at: Point): CircuitCommand | null {
  const batch = new Batch(view);
  const has = view.probes.some((p) => p.pin === pin);
  if (has) batch.add({ list: 'probes', take: pin });
  else batch.add({ list: 'probes', put: { pin, at: snap(at, true) } });
  return command(`${has ? 'Remove probe of' : 'Probe'} ${pin}`, batch.changes);
}

export function set_probe(view: View, pin: string, fields: Partial<Omit<Probe, 'pin'>>): CircuitCommand | null {
  const probe = view.probes.find((p) => p.pin === pin);
  if (!probe) return null;
  const batch = new Batch(view);
  batch.add({ list: 'probes', put: { ...probe, ...fields } });
  return command('Choose what a probe shows', batch.changes);
}

// ---- own pins ----

export function rename_own_pin(view: View, side: 'inputs' | 'outputs', name: string, to: string): CircuitCommand | null {
  const { circuit, names } = view.level;
  const pin = circuit[side]?.find((p) => p.name === name);
  if (!pin || to === name || to.includes('.') || circuit[side]!.some((p) => p.name === to)) return null;
  const batch = new Batch(view);
  // put by name would append: the whole list is written anew, in its order
  for (const p of circuit[side]!) batch.add({ list: side, take: p.name });
  for (const p of circuit[side]!) batch.add({ list: side, put: p.name === name ? { ...p, name: to } : p } as Change);
  // where the circuit is used, its wires follow
  const end = side === 'inputs' ? 'to' : 'from';
  for (const user of users_of(view, names)) {
    for (const wire of user.circuit.wires ?? []) {
      const [id, at] = split_end(wire[end]);
      if (!user.ids.has(id) || at !== name) continue;
      batch.changes.push({ ...within(user.names), list: 'wires', take: wire } as Change, { ...within(user.names), list: 'wires', put: { ...wire, [end]: `${id}.${to}` } } as Change);
    }
  }
  return command(`Rename pin ${quote(name)}`, batch.changes);
}

export function remove_own_pin(view: View, side: 'inputs' | 'outputs', name: string): CircuitCommand | null {
  const batch = new Batch(view);
  batch.add({ list: side, take: name });
  const end = side === 'inputs' ? 'to' : 'from';
  for (const user of users_of(view, view.level.names)) {
    for (const wire of user.circuit.wires ?? []) {
      const [id, at] = split_end(wire[end]);
      if (user.ids.has(id) && at === name) batch.changes.push({ ...within(user.names), list: 'wires', take: wire } as Change);
    }
  }
  return command(`Remove pin ${quote(name)}`, batch.changes);
}

const within = (names: string[]): { in?: string[] } => (names.length > 0 ? { in: names } : {});

/** Circuits that use the one stored under `names`, with the ids of the LSIs that do. */
function users_of(view: View, names: readonly string[]): { circuit: Circuit; names: string[]; ids: Set<string> }[] {
  const found: { circuit: Circuit; names: string[]; ids: Set<string> }[] = [];
  const type = names.at(-1);
  if (type === undefined) return found;
  const visit = (circuit: Circuit, at: string[], scope: string[]): void => {
    // the nearest circuit of that name counts
    const here = circuit.circuits?.some((c) => c.name === type) ? [...at, type].join('\n') : scope.find((s) => s.endsWith(`\n${type}`) || s === type) ?? '';
    if (here === names.join('\n')) {
      const ids = new Set((circuit.lsis ?? []).filter((l) => l.type === type).map((l) => l.id));
      if (ids.size > 0) found.push({ circuit, names: at, ids });
    }
    const known = [...(circuit.circuits ?? []).map((c) => [...at, c.name].join('\n')), ...scope];
    for (const inner of circuit.circuits ?? []) visit(inner, [...at, inner.name], known);
  };
  visit(view.level.scope[0]!.circuit, [], []);
  return found;
}

// ---- copy and paste ----

export interface Clip {
  ugoki: 'circuit';
  lsis: Lsi[];
  wires: Wire[];
  notes: Note[];
  circuits: Circuit[];
}

/** LSIs and notes of a selection, the wires between them and the circuits that they need. */
export function copy(view: View, nodes: ReadonlySet<string>): Clip | null {
  const { circuit } = view.level;
  const lsis = (circuit.lsis ?? []).filter((l) => nodes.has(l.id));
  const notes = (circuit.notes ?? []).filter((n) => nodes.has(note_id(n.id)));
  if (lsis.length + notes.length === 0) return null;
  const ids = new Set(lsis.map((l) => l.id));
  const inside = (end: string): boolean => ids.has(split_end(end)[0]);
  const circuits = new Map<string, Circuit>();
  const collect = (list: readonly Lsi[]): void => {
    for (const lsi of list) {
      const inner = find_circuit(view.level, lsi.type)?.circuit;
      if (!inner || circuits.has(inner.name)) continue;
      circuits.set(inner.name, inner);
      collect(inner.lsis ?? []);
    }
  };
  collect(lsis);
  return { ugoki: 'circuit', lsis, wires: (circuit.wires ?? []).filter((w) => inside(w.from) && inside(w.to)), notes, circuits: [...circuits.values()] };
}

/** What a text from the clipboard holds, or null. */
export function read_clip(text: string): Clip | null {
  try {
    const read = JSON.parse(text) as Clip;
    const good = read.ugoki === 'circuit' && [read.lsis, read.wires, read.notes, read.circuits].every(Array.isArray) && read.lsis.every((l) => typeof l.id === 'string' && typeof l.type === 'string');
    return good ? read : null;
  } catch {
    return null;
  }
}

/** @param at where the upper left corner of what is pasted goes */
export function paste(view: View, clip: Clip, at: Point, label = 'Paste'): { command: CircuitCommand; nodes: string[] } | null {
  const taken = ids_of(view);
  const note_ids = new Set(view.notes.map((n) => n.id));
  const batch = new Batch(view);
  const places = [...clip.lsis.map((l) => l.at ?? [0, 0]), ...clip.notes.map((n) => n.at)];
  const left = Math.min(...places.map((p) => p[0]!));
  const top = Math.min(...places.map((p) => p[1]!));
  const shift = (p: Point | undefined): Point => snap([(p?.[0] ?? 0) - left + at[0], (p?.[1] ?? 0) - top + at[1]], true);
  const types = new Map<string, string>();
  const own = new Set((view.level.circuit.circuits ?? []).map((c) => c.name));
  for (const circuit of clip.circuits) {
    const known = find_circuit(view.level, circuit.name)?.circuit;
    if (known && JSON.stringify(known) === JSON.stringify(circuit)) continue;
    const name = known ? fresh_name(circuit.name, { has: (n) => own.has(n) || find_circuit(view.level, n) !== null }) : circuit.name;
    own.add(name);
    types.set(circuit.name, name);
    batch.add({ list: 'circuits', put: { ...circuit, name } });
  }
  const ids = new Map<string, string>();
  const nodes: string[] = [];
  for (const lsi of clip.lsis) {
    const id = fresh_id(lsi.id.replace(/-\d+$/, ''), taken);
    taken.add(id);
    ids.set(lsi.id, id);
    nodes.push(id);
    batch.lsi({ ...lsi, id, type: types.get(lsi.type) ?? lsi.type, at: shift(lsi.at) });
  }
  for (const wire of clip.wires) {
    const [from, out] = split_end(wire.from);
    const [to, into] = split_end(wire.to);
    if (ids.has(from) && ids.has(to)) batch.add({ list: 'wires', put: { from: `${ids.get(from)}.${out}`, to: `${ids.get(to)}.${into}` } });
  }
  for (const note of clip.notes) {
    const id = fresh_id('note', note_ids);
    note_ids.add(id);
    nodes.push(note_id(id));
    batch.add({ list: 'notes', put: { ...note, id, at: shift(note.at) } });
  }
  const what = clip.lsis.length === 1 ? quote(clip.lsis[0]!.label || clip.lsis[0]!.id) : count_of(nodes.length, 'item');
  return nodes.length > 0 ? { command: { type: 'circuit.edit', label: `${label} ${what}`, changes: batch.changes }, nodes } : null;
}

// ---- group and ungroup ----

/** Makes a circuit of the selected LSIs and puts it in their place; wires go on through its own pins. */
export function group(view: View, nodes: ReadonlySet<string>): { command: CircuitCommand; id: string } | null {
  const { circuit } = view.level;
  const lsis = (circuit.lsis ?? []).filter((l) => nodes.has(l.id));
  if (lsis.length === 0) return null;
  const ids = new Set(lsis.map((l) => l.id));
  const name = fresh_name('group', { has: (n) => find_circuit(view.level, n) !== null || view.classes.find(n) !== undefined });
  const id = fresh_id(name, ids_of(view));
  const inputs = new Map<string, OwnPin>(); // by the output outside that feeds it
  const outputs = new Map<string, OwnPin>(); // by the output inside
  const input_names = new Set<string>();
  const output_names = new Set<string>();
  const inner: Wire[] = [];
  const batch = new Batch(view);
  const outside: Wire[] = [];
  const own_inputs = new Map<string, { gone: Set<string>; added: string }>();
  const own_outputs = new Map<string, string>();

  const input_for = (wire: ViewWire): OwnPin => {
    const source = `${wire.from}.${wire.from_pin}`;
    let pin = inputs.get(source);
    if (!pin) {
      const free = fresh_name(wire.to_pin, input_names);
      input_names.add(free);
      const target = view.pin(wire.to, 'in', wire.to_pin);
      pin = { name: free, type: wire.type === 'any' ? (target?.type ?? 'any') : wire.type, ...(target?.unit ? { unit: target.unit } : {}), to: [] };
      inputs.set(source, pin);
    }
    (pin.to as string[]).push(`${wire.to}.${wire.to_pin}`);
    return pin;
  };
  const output_for = (wire: ViewWire): OwnPin => {
    const source = `${wire.from}.${wire.from_pin}`;
    let pin = outputs.get(source);
    if (!pin) {
      const free = fresh_name(wire.from_pin, output_names);
      output_names.add(free);
      const unit = view.pin(wire.from, 'out', wire.from_pin)?.unit;
      pin = { name: free, type: wire.type, ...(unit ? { unit } : {}), from: source };
      outputs.set(source, pin);
    }
    return pin;
  };
  for (const wire of view.wires) {
    const begins = ids.has(wire.from);
    const ends = ids.has(wire.to);
    if (begins && ends) {
      inner.push({ from: `${wire.from}.${wire.from_pin}`, to: `${wire.to}.${wire.to_pin}` });
    } else if (ends) {
      const known = inputs.has(`${wire.from}.${wire.from_pin}`);
      const pin = input_for(wire);
      if (wire.from === inputs_node) {
        const change = own_inputs.get(wire.from_pin) ?? { gone: new Set<string>(), added: `${id}.${pin.name}` };
        change.gone.add(`${wire.to}.${wire.to_pin}`);
        own_inputs.set(wire.from_pin, change);
      } else if (!known) outside.push({ from: `${wire.from}.${wire.from_pin}`, to: `${id}.${pin.name}` });
    } else if (begins) {
      const pin = output_for(wire);
      if (wire.to === outputs_node) own_outputs.set(wire.to_pin, `${id}.${pin.name}`);
      else outside.push({ from: `${id}.${pin.name}`, to: `${wire.to}.${wire.to_pin}` });
    }
  }
  // pins of wires that could not be typed (of missing LSIs) cannot be pins of a circuit
  if ([...inputs.values(), ...outputs.values()].some((p) => p.type === 'any')) return null;

  const parameters: NonNullable<Circuit['parameters']> = [];
  for (const p of circuit.parameters ?? []) {
    const ends = ends_of(p.to);
    const inside = ends.filter((e) => ids.has(split_end(e)[0]));
    if (inside.length === 0) continue;
    parameters.push({ name: p.name, ...(p.doc ? { doc: p.doc } : {}), to: write_ends(inside) });
    batch.add({ list: 'parameters', put: { ...p, to: write_ends([...ends.filter((e) => !inside.includes(e)), `${id}.${p.name}`]) } });
  }
  const notes = (circuit.notes ?? []).filter((n) => nodes.has(note_id(n.id)));
  const probes = (circuit.probes ?? []).filter((p) => ids.has(split_end(p.pin)[0]));
  const settle = (pin: OwnPin): OwnPin => ({ ...pin, ...(pin.to ? { to: write_ends(ends_of(pin.to)) } : {}) });
  const made: Circuit = {
    name,
    ...(inputs.size > 0 ? { inputs: [...inputs.values()].map(settle) } : {}),
    ...(outputs.size > 0 ? { outputs: [...outputs.values()] } : {}),
    ...(parameters.length > 0 ? { parameters } : {}),
    lsis,
    ...(inner.length > 0 ? { wires: inner } : {}),
    ...(notes.length > 0 ? { notes } : {}),
    ...(probes.length > 0 ? { probes } : {}),
  };
  const box = view.bounds(ids);
  batch.add({ list: 'circuits', put: made });
  for (const wire of view.wires) {
    if ((ids.has(wire.from) || ids.has(wire.to)) && wire.from !== inputs_node && wire.to !== outputs_node)
      batch.add({ list: 'wires', take: { from: `${wire.from}.${wire.from_pin}`, to: `${wire.to}.${wire.to_pin}` } });
  }
  for (const lsi of lsis) batch.add({ list: 'lsis', take: lsi.id });
  for (const note of notes) batch.add({ list: 'notes', take: note.id });
  for (const probe of probes) batch.add({ list: 'probes', take: probe.pin });
  batch.lsi({ id, type: name, at: snap([box.x + box.width / 2 - 80, box.y + box.height / 2 - 40], true) });
  for (const wire of outside) batch.add({ list: 'wires', put: wire });
  for (const [pin, change] of own_inputs) {
    const own = circuit.inputs!.find((p) => p.name === pin)!;
    batch.add({ list: 'inputs', put: { ...own, to: write_ends([...ends_of(own.to).filter((e) => !change.gone.has(e)), change.added]) } });
  }
  for (const [pin, end] of own_outputs) {
    const own = circuit.outputs!.find((p) => p.name === pin)!;
    batch.add({ list: 'outputs', put: { ...own, from: end } });
  }
  return { command: { type: 'circuit.edit', label: `Group ${count_of(lsis.length, 'LSI')}`, changes: batch.changes }, id };
}

/** Puts what is inside of a circuit in its place. */
export function ungroup(view: View, id: string): { command: CircuitCommand; nodes: string[] } | null {
  const node = view.node(id);
  const found = node?.kind === 'circuit' && node.lsi ? find_circuit(view.level, node.lsi.type) : null;
  if (!node?.lsi || !found) return null;
  const inner = found.circuit;
  const taken = ids_of(view);
  const ids = new Map<string, string>();
  for (const lsi of inner.lsis ?? []) {
    const free = fresh_id(lsi.id, taken);
    taken.add(free);
    ids.set(lsi.id, free);
  }
  const moved = (end: string): string => {
    const [at, pin] = split_end(end);
    return `${ids.get(at) ?? at}.${pin}`;
  };
  const batch = new Batch(view);
  // circuits that only this one knows come along
  for (const c of inner.circuits ?? []) {
    const known = find_circuit(view.level, c.name)?.circuit;
    if (known && JSON.stringify(known) !== JSON.stringify(c)) return null; // another circuit has that name here
    if (!known) batch.add({ list: 'circuits', put: c });
  }
  // parameters given to the circuit are given to what they set
  const given = new Map<string, Record<string, Value>>();
  for (const p of inner.parameters ?? []) {
    const value = node.lsi.parameters?.[p.name];
    if (value === undefined) continue;
    for (const end of ends_of(p.to)) {
      const [at, name] = split_end(end);
      given.set(at, { ...given.get(at), [name]: value });
    }
  }
  const own_wires = view.wires.filter((w) => w.from === id || w.to === id);
  take_wires(view, batch, own_wires.filter((w) => w.from !== inputs_node && w.to !== outputs_node));
  batch.add({ list: 'lsis', take: id });
  const places = (inner.lsis ?? []).map((l) => l.at ?? [0, 0]);
  const middle = (i: 0 | 1): number => (places.length > 0 ? (Math.min(...places.map((p) => p[i]!)) + Math.max(...places.map((p) => p[i]!))) / 2 : 0);
  const [cx, cy] = [middle(0), middle(1)];
  const shift = (p: Point | undefined): Point => snap([(p?.[0] ?? 0) - cx + node.x, (p?.[1] ?? 0) - cy + node.y], true);
  for (const lsi of inner.lsis ?? []) {
    const every = (lsi.every ?? 1) * (node.lsi.every ?? 1);
    batch.lsi({ ...lsi, id: ids.get(lsi.id)!, at: shift(lsi.at), every, parameters: { ...lsi.parameters, ...given.get(lsi.id) } });
  }
  for (const wire of inner.wires ?? []) batch.add({ list: 'wires', put: { from: moved(wire.from), to: moved(wire.to) } });
  const input = (name: string): string[] => ends_of(inner.inputs?.find((p) => p.name === name)?.to).map(moved);
  const output = (name: string): string | undefined => ends_of(inner.outputs?.find((p) => p.name === name)?.from).map(moved)[0];
  const own_inputs = new Map<string, string[]>();
  for (const wire of own_wires) {
    if (wire.from === id && wire.to === id) {
      const from = output(wire.from_pin);
      if (from) for (const to of input(wire.to_pin)) batch.add({ list: 'wires', put: { from, to } });
    } else if (wire.to === id) {
      if (wire.from === inputs_node) own_inputs.set(wire.from_pin, [...(own_inputs.get(wire.from_pin) ?? []), ...input(wire.to_pin)]);
      else for (const to of input(wire.to_pin)) batch.add({ list: 'wires', put: { from: `${wire.from}.${wire.from_pin}`, to } });
    } else {
      const from = output(wire.from_pin);
      if (wire.to === outputs_node) {
        const own = view.level.circuit.outputs!.find((p) => p.name === wire.to_pin)!;
        batch.add({ list: 'outputs', put: { ...own, from: from ?? [] } });
      } else if (from) batch.add({ list: 'wires', put: { from, to: `${wire.to}.${wire.to_pin}` } });
    }
  }
  for (const [name, added] of own_inputs) {
    const own = view.level.circuit.inputs!.find((p) => p.name === name)!;
    batch.add({ list: 'inputs', put: { ...own, to: write_ends([...ends_of(own.to).filter((e) => split_end(e)[0] !== id), ...added]) } });
  }
  for (const p of view.level.circuit.parameters ?? []) {
    const ends = ends_of(p.to);
    if (!ends.some((e) => split_end(e)[0] === id)) continue;
    const next = ends.flatMap((e) => {
      const [at, name] = split_end(e);
      return at === id ? ends_of(inner.parameters?.find((q) => q.name === name)?.to).map(moved) : [e];
    });
    batch.add({ list: 'parameters', put: { ...p, to: write_ends(next) } });
  }
  const note_ids = new Set(view.notes.map((n) => n.id));
  const nodes = [...ids.values()];
  for (const note of inner.notes ?? []) {
    const free = fresh_id('note', note_ids);
    note_ids.add(free);
    nodes.push(note_id(free));
    batch.add({ list: 'notes', put: { ...note, id: free, at: shift(note.at) } });
  }
  for (const probe of inner.probes ?? []) batch.add({ list: 'probes', put: { ...probe, pin: moved(probe.pin), at: shift(probe.at) } });
  // the last use gone, the circuit itself goes too
  const uses = users_of(view, found.names).reduce((n, u) => n + u.ids.size, 0);
  if (uses <= 1) batch.changes.push({ ...within(found.names.slice(0, -1)), list: 'circuits', take: node.lsi.type } as Change);
  return { command: { type: 'circuit.edit', label: `Ungroup ${quote(node.title)}`, changes: batch.changes }, nodes };
}
