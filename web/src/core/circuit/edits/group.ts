/** Group: replaces a selection by a nested circuit. Ungroup: replaces a nested circuit by its contents. */
import { ends_of, fresh_id, fresh_name, split_end, write_ends, type Change, type Circuit, type OwnPin, type Point, type Value, type Wire } from '../form';
import { find_circuit, inputs_node, note_id, outputs_node, type View, type ViewWire } from '../view';
import { snap, Batch, ids_of, quote, count_of, users_of, within, type CircuitCommand } from './batch';
import { take_wires } from './wires';

/** Moves the selected LSIs into a new circuit that replaces them. Wires to other LSIs run through pins of the new circuit. */
export function group(view: View, nodes: ReadonlySet<string>): { command: CircuitCommand; id: string } | null {
  const { circuit } = view.level;
  const lsis = (circuit.lsis ?? []).filter((l) => nodes.has(l.id));
  if (lsis.length === 0) return null;
  const ids = new Set(lsis.map((l) => l.id));
  const name = fresh_name('group', { has: (n) => find_circuit(view.level, n) !== null || view.classes.find(n) !== undefined });
  const id = fresh_id(name, ids_of(view));
  const inputs = new Map<string, OwnPin>(); // pins of the new circuit, by the outer output that feeds them
  const outputs = new Map<string, OwnPin>(); // pins of the new circuit, by the inner output
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
  // a wire at a missing LSI has no known type, but a pin of a circuit needs a type
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

/** Replaces the circuit LSI `id` by its contents; null if it is no circuit or a name conflicts. */
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
  // definitions of circuits inside the removed circuit move to this level
  for (const c of inner.circuits ?? []) {
    const known = find_circuit(view.level, c.name)?.circuit;
    if (known && JSON.stringify(known) !== JSON.stringify(c)) return null; // another circuit has that name here
    if (!known) batch.add({ list: 'circuits', put: c });
  }
  // values of the circuit's parameters are set at the inner LSIs
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
  // when its last use is removed, the definition of the circuit is removed too
  const uses = users_of(view, found.names).reduce((n, u) => n + u.ids.size, 0);
  if (uses <= 1) batch.changes.push({ ...within(found.names.slice(0, -1)), list: 'circuits', take: node.lsi.type } as Change);
  return { command: { type: 'circuit.edit', label: `Ungroup ${quote(node.title)}`, changes: batch.changes }, nodes };
}
