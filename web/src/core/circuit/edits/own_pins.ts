/** Edits of a circuit's own pins. They also change the wires at all LSIs that are instances of the circuit. */
import { split_end, type Change } from '../form';
import type { View } from '../view';
import { command, Batch, quote, users_of, within, type CircuitCommand } from './batch';

export function rename_own_pin(view: View, side: 'inputs' | 'outputs', name: string, to: string): CircuitCommand | null {
  const { circuit, names } = view.level;
  const pin = circuit[side]?.find((p) => p.name === name);
  if (!pin || to === name || to.includes('.') || circuit[side]!.some((p) => p.name === to)) return null;
  const batch = new Batch(view);
  // a put under a new name would append the pin, so the whole list is rewritten to keep its order
  for (const p of circuit[side]!) batch.add({ list: side, take: p.name });
  for (const p of circuit[side]!) batch.add({ list: side, put: p.name === name ? { ...p, name: to } : p } as Change);
  // update the wires at all LSIs that are instances of the circuit
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
