/** Circuits in circuits: which one is looked at, and what a type is called from there. */
import type { Circuit } from './form';

/** A circuit as it is looked at: by the ids of the LSIs that were entered, and by the names under which it is stored. */
export interface Level {
  circuit: Circuit;
  /** Ids of the entered LSIs, from the outermost circuit inwards: prefix of flat ids. */
  path: string[];
  /** Names of circuits: where changes go. */
  names: string[];
  /** Enclosing circuits from the outermost to this one: where types are looked up. */
  scope: { circuit: Circuit; names: string[] }[];
}

export function find_circuit(level: Level, type: string): { circuit: Circuit; names: string[] } | null {
  for (let i = level.scope.length - 1; i >= 0; i--) {
    const at = level.scope[i]!;
    const found = at.circuit.circuits?.find((c) => c.name === type);
    if (found) return { circuit: found, names: [...at.names, type] };
  }
  return null;
}

/** The level that `path` leads to, or the deepest one on the way that exists. */
export function enter(top: Circuit, path: readonly string[]): Level {
  let level: Level = { circuit: top, path: [], names: [], scope: [{ circuit: top, names: [] }] };
  for (const id of path) {
    const lsi = level.circuit.lsis?.find((l) => l.id === id);
    const inner = lsi && find_circuit(level, lsi.type);
    if (!inner || level.scope.some((s) => s.circuit === inner.circuit)) break;
    level = { circuit: inner.circuit, path: [...level.path, id], names: inner.names, scope: [...level.scope, inner] };
  }
  return level;
}

/** True if types mean the same at both: the circuits that can be named there are the same objects. */
export const same_types = (a: Level, b: Level): boolean =>
  a.scope.length === b.scope.length && a.path.every((id, i) => id === b.path[i]) && a.scope.every((s, i) => s.circuit.circuits === b.scope[i]!.circuit.circuits);

/** Name of an output of this level as the running circuit knows it: "arm/elbow.out". */
export const flat_pin = (level: Level, pin: string): string => [...level.path, pin].join('/');
