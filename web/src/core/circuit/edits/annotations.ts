/** Edits of notes and probes. */
import { fresh_id, type Note, type Point, type Probe } from '../form';
import type { View } from '../view';
import { command, snap, Batch, type CircuitCommand } from './batch';

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
