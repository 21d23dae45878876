/** Copy and paste, also between pages: what is copied is text. */
import { fresh_id, fresh_name, split_end, type Circuit, type Lsi, type Note, type Point, type Wire } from '../form';
import { find_circuit, note_id, type View } from '../view';
import { snap, Batch, ids_of, quote, count_of, type CircuitCommand } from './batch';

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
