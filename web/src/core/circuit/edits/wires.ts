/** Edits of wires: add, move, remove, and insert a delay. */
import { ends_of, fresh_id, fresh_name, write_ends, type Point } from '../form';
import { inputs_node, outputs_node, type View, type ViewWire } from '../view';
import type { PinAt } from '../fits';
import type { ClassList } from '../classes';
import { command, snap, Batch, ids_of, type CircuitCommand } from './batch';

/** Adds the changes for a new wire. An existing wire at an input that accepts only one is removed. */
export function put_wire(view: View, batch: Batch, from: PinAt, to: PinAt, type: string): void {
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

/** Removes the wires at an input that accepts only one. */
function free_input(view: View, batch: Batch, to: PinAt): void {
  const target = view.pin(to.node, 'in', to.pin);
  if (target?.multiple) return;
  take_wires(view, batch, view.at_pin(to.node, 'in', to.pin));
}

/** Adds the changes that remove wires. */
export function take_wires(view: View, batch: Batch, wires: Iterable<ViewWire>): void {
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

/**
 * Wires an output and an input, given in any order, that fit (fits.ts).
 * @param instead the wire that this one replaces, if an end is moved
 */
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

/** Inserts a delay LSI into a wire, which breaks an algebraic loop; null if there is no delay for the wire's type. */
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
