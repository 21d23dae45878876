/** Search for LSIs, circuits and notes that can be added, optionally only those that fit the pin at which a wire was started. */
import type { ClassList } from './classes';
import { types_fit, type PinAt } from './fits';
import { circuit_pins, class_pins } from './pins';
import { type Level, type View } from './view';

export interface Candidate {
  type: string;
  doc: string;
  category: string;
  kind: 'class' | 'circuit' | 'note';
}

/**
 * Everything that can be added at a level: the LSI classes, and circuits of this and the enclosing levels that do not contain this level.
 */
export function candidates(view: View): Candidate[] {
  const out: Candidate[] = [];
  const seen = new Set<string>();
  const { level } = view;
  for (let i = level.scope.length - 1; i >= 0; i--) {
    for (const c of level.scope[i]!.circuit.circuits ?? []) {
      if (seen.has(c.name) || level.scope.some((s) => s.circuit === c)) continue;
      seen.add(c.name);
      out.push({ type: c.name, doc: c.doc ?? `${(c.lsis ?? []).length} LSIs`, category: 'circuit', kind: 'circuit' });
    }
  }
  for (const c of view.classes.all) {
    if (!seen.has(c.name)) out.push({ type: c.name, doc: c.doc ?? '', category: c.from || c.group || '', kind: 'class' });
  }
  return out;
}

const pins_of = (level: Level, classes: ClassList, candidate: Candidate): { inputs: { type: string }[]; outputs: { type: string }[] } => {
  if (candidate.kind === 'circuit') {
    for (let i = level.scope.length - 1; i >= 0; i--) {
      const found = level.scope[i]!.circuit.circuits?.find((c) => c.name === candidate.type);
      if (found) return circuit_pins(found);
    }
  }
  const found = classes.find(candidate.type);
  return found ? class_pins(found) : { inputs: [], outputs: [] };
};

/**
 * Candidates that contain every word of `query`. Order: exact name, name that starts with the first word, a word of the name that starts
 * with it, name that contains all words, match in the description only.
 */
export function search(view: View, query: string, fits?: PinAt): Candidate[] {
  let all = candidates(view);
  if (fits) {
    const type = view.pin(fits.node, fits.side, fits.pin)?.type ?? 'any';
    all = all.filter((c) => {
      const pins = pins_of(view.level, view.classes, c);
      return (fits.side === 'out' ? pins.inputs : pins.outputs).some((p) => types_fit(p.type, type));
    });
  } else all.push({ type: 'note', doc: 'A comment on the canvas.', category: 'comment', kind: 'note' });
  const words = query.toLowerCase().split(/\s+/).filter(Boolean);
  const scored: { candidate: Candidate; score: number }[] = [];
  for (const candidate of all) {
    const name = candidate.type.toLowerCase();
    const text = `${name} ${candidate.category.toLowerCase()} ${candidate.doc.toLowerCase()}`;
    if (!words.every((w) => text.includes(w))) continue;
    const first = words[0] ?? '';
    const score = name === query.toLowerCase().trim() ? -1 : name.startsWith(first) ? 0 : name.split(/[\s-]/).some((part) => part.startsWith(first)) ? 1 : words.every((w) => name.includes(w)) ? 2 : 3;
    scored.push({ candidate, score });
  }
  return scored.sort((a, b) => a.score - b.score || a.candidate.type.localeCompare(b.candidate.type)).map((s) => s.candidate);
}
