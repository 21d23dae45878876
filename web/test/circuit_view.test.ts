/** A view made incrementally from the previous view equals a view made from scratch. */
import { describe, expect, it } from 'vitest';
import { ClassList, type LsiClass } from '../src/core/circuit/classes';
import * as edits from '../src/core/circuit/edits';
import { why_not } from '../src/core/circuit/fits';
import { apply_changes, reconcile, type Circuit } from '../src/core/circuit/form';
import { enter, View, type ViewWire } from '../src/core/circuit/view';

const pin = (name: string, type = 'scalar', more = {}) => ({ name, type, ...more });
const lsi_class = (name: string, inputs: LsiClass['inputs'], outputs: LsiClass['outputs']): LsiClass => ({ name, inputs, outputs, parameters: [] });
const classes = new ClassList([
  lsi_class('constant', [], [pin('out')]),
  lsi_class('gain', [pin('in')], [pin('out')]),
  lsi_class('add', [pin('a'), pin('b')], [pin('out')]),
  lsi_class('sum', [pin('in', 'scalar', { multiple: true })], [pin('out')]),
  lsi_class('make vector', [pin('x'), pin('y'), pin('z')], [pin('out', 'vector')]),
  lsi_class('delay', [pin('in')], [pin('out', 'scalar', { delayed: true })]),
]);
const types = ['constant', 'gain', 'add', 'sum', 'make vector', 'delay', 'not installed'];

/** Seeded pseudorandom generator (mulberry32) of values in 0 ... 1, so that a failure can be reproduced. */
function random(seed: number): () => number {
  let a = seed;
  return () => {
    a = (a + 0x6d2b79f5) | 0;
    let t = Math.imul(a ^ (a >>> 15), 1 | a);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

const sorted = (wires: readonly ViewWire[]): ViewWire[] => [...wires].sort((p, q) => (p.key < q.key ? -1 : 1));
const bare = (view: View) => ({
  nodes: view.nodes.map((n) => ({ ...n, inputs: n.kind === 'missing' ? new Set(n.inputs.map((p) => p.name)) : n.inputs, outputs: n.kind === 'missing' ? new Set(n.outputs.map((p) => p.name)) : n.outputs })),
  wires: sorted(view.wires),
});

function expect_same(view: View, fresh: View): void {
  expect(bare(view)).toEqual(bare(fresh));
  for (const node of fresh.nodes) {
    expect(view.node(node.id)).toBe(view.nodes.find((n) => n.id === node.id));
    expect(sorted(view.at_node(node.id))).toEqual(sorted(fresh.at_node(node.id)));
    for (const wire of view.at_node(node.id)) expect(view.wires).toContain(wire);
    const box = { x: node.x, y: node.y, width: 1, height: 1 };
    expect(new Set(view.index.find(box))).toEqual(new Set(view.nodes.filter((n) => n.x < box.x + 1 && n.x + n.width > box.x && n.y < box.y + 1 && n.y + n.height > box.y)));
  }
}

/** One random edit of the kinds that a user makes; null if it is not possible. */
function edit(view: View, pick: () => number): edits.CircuitCommand | null {
  const any = <T>(list: readonly T[]): T | undefined => list[Math.floor(pick() * list.length)];
  const node = any(view.nodes);
  const kind = Math.floor(pick() * 10);
  if (kind <= 2 || !node) return edits.add_lsi(view, any(types)!, [Math.round(pick() * 300) * 10, Math.round(pick() * 300) * 10]).command;
  if (kind === 3) return edits.move(view, new Map([[node.id, [Math.round(pick() * 300) * 10, Math.round(pick() * 300) * 10]]]));
  if (kind === 4) return edits.remove(view, { nodes: new Set([node.id]), wires: new Set() });
  if (kind === 5) return edits.rename(view, node.id, `called ${Math.floor(pick() * 100)}`);
  if (kind === 9) return edits.set_lsi(view, node.id, { type: any(types)! }, 'Replace');
  if (kind === 6) {
    const wire = any(view.wires);
    return wire ? edits.disconnect(view, [wire]) : null;
  }
  const other = any(view.nodes)!;
  const [out, into] = [any(node.outputs), any(other.inputs)];
  if (!out || !into) return null;
  const [a, b] = [{ node: node.id, side: 'out', pin: out.name } as const, { node: other.id, side: 'in', pin: into.name } as const];
  return why_not(view, a, b) === null ? edits.connect(view, a, b) : null;
}

describe('an incremental view', () => {
  for (const seed of [1, 2, 3, 4]) {
    it(`equals a view made from scratch after each of many edits (seed ${seed})`, () => {
      const pick = random(seed);
      let circuit: Circuit = { version: 1, name: 'top', inputs: [{ name: 'live', type: 'scalar' }], outputs: [{ name: 'y', type: 'scalar', from: [] }], lsis: [], wires: [] };
      let view = new View(enter(circuit, []), classes);
      let done = 0;
      for (let i = 0; i < 70; i++) {
        const command = edit(view, pick);
        if (!command) continue;
        const next = apply_changes(circuit, command.changes);
        // in 30 % of the steps the circuit arrives from the service as new objects
        circuit = pick() < 0.3 ? reconcile(circuit, JSON.parse(JSON.stringify(next)) as Circuit) : next;
        view = new View(enter(circuit, []), classes, view);
        expect_same(view, new View(enter(circuit, []), classes));
        done++;
      }
      expect(done).toBeGreaterThan(35);
    }, 60_000);
  }

  it('remakes only the moved node and its wires among 10,000 LSIs', () => {
    const n = 10_000;
    const circuit: Circuit = {
      version: 1, name: 'big',
      lsis: Array.from({ length: n }, (_, i) => ({ id: `g${i}`, type: 'gain', at: [(i % 100) * 240, Math.floor(i / 100) * 110] as [number, number] })),
      wires: Array.from({ length: n - 1 }, (_, i) => ({ from: `g${i}.out`, to: `g${i + 1}.in` })),
    };
    const before = new View(enter(circuit, []), classes);
    const next = apply_changes(circuit, edits.move(before, new Map([['g500', [7, 7]]]))!.changes);
    const view = new View(enter(next, []), classes, before);
    expect(view.nodes.filter((node, i) => node !== before.nodes[i]).map((node) => node.id)).toEqual(['g500']);
    expect(view.wires.filter((wire, i) => wire !== before.wires[i]).map((wire) => wire.key)).toEqual(['g499.out\ng500.in', 'g500.out\ng501.in']);
    expect(view.node('g500')).toMatchObject({ x: 7, y: 7 });
    expect(before.node('g500')).toMatchObject({ x: 0, y: 550 });
    expect(view.index.find({ x: 7, y: 7, width: 1, height: 1 }).map((node) => node.id)).toContain('g500');
    // an equal circuit from the service gives the same object
    expect(reconcile(next, JSON.parse(JSON.stringify(next)) as Circuit)).toBe(next);
  }, 60_000);
});
