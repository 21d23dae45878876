/** The command that an edit of a circuit produces, the batch that collects its changes, and helpers shared by all edits. */
import { tidy_lsi, type Change, type Circuit, type Lsi, type Point } from '../form';
import { grid, type View } from '../view';

export interface CircuitCommand {
  type: 'circuit.edit';
  label: string;
  changes: Change[];
}

/** A command, or null if there are no changes. */
export const command = (label: string, changes: Change[]): CircuitCommand | null => (changes.length > 0 ? { type: 'circuit.edit', label, changes } : null);

const round = (v: number): number => Math.round(v * 100) / 100;
/** Rounds a point to the grid, or to 0.01 px if `on` is false. */
export const snap = (p: Point, on: boolean): Point => (on ? [Math.round(p[0] / grid) * grid + 0, Math.round(p[1] / grid) * grid + 0] : [round(p[0]) + 0, round(p[1]) + 0]); // + 0: JSON cannot keep -0

/** Collects changes to the circuit of a view's level. */
export class Batch {
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

export const ids_of = (view: View): Set<string> => new Set((view.level.circuit.lsis ?? []).map((l) => l.id));
export const quote = (name: string): string => `“${name}”`;
/** A noun with its count: "item" for one, "3 items" for several. */
export const count_of = (n: number, one: string): string => (n === 1 ? one : `${n} ${one}s`);
export const title_of = (view: View, id: string): string => view.node(id)?.title ?? id;

/** The `in` field of a change to the circuit stored under `names`. */
export const within = (names: string[]): { in?: string[] } => (names.length > 0 ? { in: names } : {});

/** Circuits that use the circuit stored under `names`, each with the ids of its LSIs that are instances of that circuit. */
export function users_of(view: View, names: readonly string[]): { circuit: Circuit; names: string[]; ids: Set<string> }[] {
  const found: { circuit: Circuit; names: string[]; ids: Set<string> }[] = [];
  const type = names.at(-1);
  if (type === undefined) return found;
  const visit = (circuit: Circuit, at: string[], scope: string[]): void => {
    // a type name refers to the definition in the innermost enclosing circuit that has one
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
