/** Copy and paste. The clipboard holds JSON text, so copying between pages works too. */
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

/** Copies the LSIs and notes of a selection, the wires between them and the circuits that they use; null if nothing is selected. */
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

/** Parses clipboard text; null if it is not a circuit clip. */
export function read_clip(text: string): Clip | null {
  try {
    const read = JSON.parse(text) as Clip;
    const good = read.ugoki === 'circuit' && [read.lsis, read.wires, read.notes, read.circuits].every(Array.isArray) && read.lsis.every((l) => typeof l.id === 'string' && typeof l.type === 'string');
    return good ? read : null;
  } catch {
    return null;
  }
}

/** Pastes a clip with fresh ids. @param at upper left corner of the pasted nodes  @return the command and the ids of the new nodes */
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
  const subject = clip.lsis.length === 1 ? quote(clip.lsis[0]!.label || clip.lsis[0]!.id) : count_of(nodes.length, 'item');
  return nodes.length > 0 ? { command: { type: 'circuit.edit', label: `${label} ${subject}`, changes: batch.changes }, nodes } : null;
}
