/** Locates the problems that the service reports for a circuit: finds the LSI, the level and the wires of each problem. */
import type { Problem } from '../protocol';
import { ends_of, split_end, type Circuit } from './form';
import { enter, find_circuit, type Level } from './view';

export interface CircuitProblem extends Problem {
  /** Id with path of the LSI at fault: "arm/elbow"; empty: the circuit itself. */
  lsi: string;
  /** Wires of an algebraic loop, as pins with their paths: "arm/a.out" → "arm/b.in"; empty for other problems. */
  loop: { from: string; to: string }[];
  /** True: the problem stopped the running circuit. Otherwise it keeps the circuit from starting. */
  stopped?: boolean;
  /** The output at fault, if the problem stopped the circuit. */
  pin?: string;
}

/**
 * Id, with its path ("arm/elbow"), of the LSI that a JSON path names ("circuit/lsis/3(arm)/lsis/0/type", "circuit/wires/2/to"); null if
 * `location` is not a JSON path into the circuit.
 */
function lsi_of_path(top: Circuit, location: string): string | null {
  const start = location.indexOf('circuit/');
  if (start < 0) return null;
  let rest = location.slice(start + 'circuit'.length);
  let level: Level = enter(top, []);
  for (;;) {
    const lsi = /^\/lsis\/(\d+)(\([^)]*\))?/.exec(rest);
    if (lsi) {
      const found = level.circuit.lsis?.[Number(lsi[1])];
      if (!found) return level.path.join('/');
      rest = rest.slice(lsi[0].length);
      const inner = lsi[2] ? find_circuit(level, found.type) : null;
      if (!inner) return [...level.path, found.id].join('/');
      level = { circuit: inner.circuit, path: [...level.path, found.id], names: inner.names, scope: [...level.scope, inner] };
      continue;
    }
    const wire = /^\/wires\/(\d+)(\/from)?/.exec(rest);
    if (wire) {
      const found = level.circuit.wires?.[Number(wire[1])];
      if (found) return [...level.path, split_end(wire[2] ? found.from : found.to)[0]].join('/');
    }
    const output = /^\/outputs\/(\d+)/.exec(rest);
    const own = output && level.circuit.outputs?.[Number(output[1])];
    if (own && ends_of(own.from).length === 0 && level.path.length > 0) return level.path.join('/');
    return level.path.join('/');
  }
}

/** Reads the wires "a.out -> b.in, b.out -> a.in" from the service's message about an algebraic loop; empty for other messages. */
export function read_loop(message: string): { from: string; to: string }[] {
  const list = /within one tick: (.*)\.$/.exec(message)?.[1];
  if (!list) return [];
  return list.split(', ').flatMap((step) => {
    const [from, to] = step.split(' -> ');
    return from && to ? [{ from, to }] : [];
  });
}

/** Finds the LSI at fault, and the wires of an algebraic loop, for each problem that keeps the circuit `top` from running. */
export function locate_problems(top: Circuit, problems: readonly Problem[]): CircuitProblem[] {
  return problems.map((p) => {
    const loop = read_loop(p.message);
    const location = p.location ?? '';
    const by_path = lsi_of_path(top, location);
    // a location that is not a JSON path is an LSI's id with its path, possibly followed by a pin
    const flat = by_path ?? (location === 'circuit' ? '' : split_end(location)[0]);
    const known = by_path !== null || enter(top, flat.split('/').slice(0, -1)).circuit.lsis?.some((l) => l.id === flat.split('/').at(-1));
    return { ...p, lsi: known ? flat : '', loop };
  });
}

/** Returns those problems whose location is an LSI. @param problems problems that stopped the running circuit */
export function locate_stops(top: Circuit, problems: readonly Problem[]): CircuitProblem[] {
  return problems.flatMap((p) => {
    const [flat, pin] = split_flat(p.location ?? '');
    const ids = flat.split('/');
    const known = enter(top, ids.slice(0, -1)).circuit.lsis?.some((l) => l.id === ids.at(-1));
    return known ? [{ ...p, lsi: flat, loop: [], stopped: true, ...(pin ? { pin } : {}) }] : [];
  });
}

/** Problems to show at node `id` of the level `path`: its own, those inside it, and algebraic loops through it. */
export function problems_at(problems: readonly CircuitProblem[], path: readonly string[], id: string): CircuitProblem[] {
  const flat = [...path, id].join('/');
  const here = (end: string): boolean => end === flat || end.startsWith(`${flat}/`);
  return problems.filter((p) => (p.lsi !== '' && here(p.lsi)) || p.loop.some((s) => here(split_flat(s.from)[0]) || here(split_flat(s.to)[0])));
}

/** Splits "arm/elbow.out" into [flat id, pin]. */
export function split_flat(end: string): [string, string] {
  const slash = end.lastIndexOf('/');
  const dot = end.indexOf('.', slash + 1);
  return dot < 0 ? [end, ''] : [end.slice(0, dot), end.slice(dot + 1)];
}

/**
 * Keys of those wires of a level that are part of an algebraic loop. A loop through a nested circuit includes the wires into and out of it.
 */
export function loop_wires(problems: readonly CircuitProblem[], path: readonly string[], wires: readonly { key: string; from: string; from_pin: string; to: string; to_pin: string }[]): Set<string> {
  const out = new Set<string>();
  const prefix = path.length > 0 ? `${path.join('/')}/` : '';
  for (const problem of problems) {
    for (const step of problem.loop) {
      if (!step.from.startsWith(prefix) || !step.to.startsWith(prefix)) continue;
      const [from, from_pin] = split_flat(step.from.slice(prefix.length));
      const [to, to_pin] = split_flat(step.to.slice(prefix.length));
      const [a, b] = [from.split('/')[0]!, to.split('/')[0]!];
      for (const w of wires) {
        if (w.from !== a || w.to !== b) continue;
        if ((from === a ? w.from_pin === from_pin : true) && (to === b ? w.to_pin === to_pin : true)) out.add(w.key);
      }
    }
  }
  return out;
}
