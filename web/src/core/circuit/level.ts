/** Levels of nested circuits: the circuit that is shown, and the lookup of circuit types from there. */
import type { Circuit } from './form';

/** A shown circuit, with the ids of the LSIs that were entered and the names under which it is stored. */
export interface Level {
  circuit: Circuit;
  /** Ids of the entered LSIs, from the outermost circuit inwards: the path in front of ids, "arm" in "arm/elbow". */
  path: string[];
  /** Names of the nested circuits down to this one: the `in` of changes. */
  names: string[];
  /** Enclosing circuits, from the outermost to this one. Type names are looked up from the last to the first. */
  scope: { circuit: Circuit; names: string[] }[];
}

/** The circuit that the type name `type` refers to at a level of nested circuits; null if there is none. */
export function find_circuit(level: Level, type: string): { circuit: Circuit; names: string[] } | null {
  for (let i = level.scope.length - 1; i >= 0; i--) {
    const at = level.scope[i]!;
    const found = at.circuit.circuits?.find((c) => c.name === type);
    if (found) return { circuit: found, names: [...at.names, type] };
  }
  return null;
}

/** The level at `path`, or the deepest existing level along it. */
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

/** Whether type names refer to the same circuit objects at both levels. */
export const same_types = (a: Level, b: Level): boolean =>
  a.scope.length === b.scope.length && a.path.every((id, i) => id === b.path[i]) && a.scope.every((s, i) => s.circuit.circuits === b.scope[i]!.circuit.circuits);

/** Name with path of an output of this level, as the running circuit uses it: "arm/elbow.out". */
export const flat_pin = (level: Level, pin: string): string => [...level.path, pin].join('/');
