import { describe, expect, it, vi } from 'vitest';
import { ClassList, type LsiClass } from '../src/core/circuit/classes';
import * as edits from '../src/core/circuit/edits';
import { CircuitEditor, flat_source } from '../src/core/circuit/editor';
import { pins_that_fit, why_not } from '../src/core/circuit/fits';
import { apply_changes, fresh_id, reconcile, tidy_lsi, type Change, type Circuit } from '../src/core/circuit/form';
import { elk_graph, read_layout } from '../src/core/circuit/layout';
import { LiveValues, short_number, short_value } from '../src/core/circuit/live';
import { next_node, next_pin } from '../src/core/circuit/navigate';
import { loop_wires, locate_problems, problems_at, read_loop } from '../src/core/circuit/problems';
import { search } from '../src/core/circuit/search';
import { SpatialIndex } from '../src/core/circuit/spatial';
import { enter, inputs_node, new_pin, outputs_node, View } from '../src/core/circuit/view';

const scalar = (name: string, more = {}) => ({ name, type: 'scalar', ...more });
const lsi_class = (name: string, inputs: string[], outputs: string[], more: Partial<LsiClass> = {}): LsiClass => ({
  name, doc: `The ${name}.`, inputs: inputs.map((n) => scalar(n)), outputs: outputs.map((n) => scalar(n)), parameters: [], ...more,
});
const classes = new ClassList([
  lsi_class('add', ['a', 'b'], ['out']),
  lsi_class('gain', ['in'], ['out'], { parameters: [{ name: 'gain', kind: 'number', initial: 1 }] }),
  lsi_class('constant', [], ['out']),
  { ...lsi_class('sum', [], ['out']), inputs: [scalar('in', { multiple: true, required: false })] },
  { ...lsi_class('delay', [], []), inputs: [scalar('in', { direct: false })], outputs: [scalar('out', { delayed: true })] },
  { ...lsi_class('split vector', [], ['x', 'y', 'z']), inputs: [{ name: 'in', type: 'vector' }] },
  { ...lsi_class('make vector', ['x', 'y', 'z'], []), outputs: [{ name: 'out', type: 'vector' }] },
]);

const sample = (): Circuit => ({
  version: 2,
  name: 'top',
  inputs: [{ name: 'live', type: 'scalar', to: 'g.in' }],
  outputs: [{ name: 'y', type: 'scalar', from: 's.out' }],
  lsis: [
    { id: 'c', type: 'constant', at: [0, 0] },
    { id: 'g', type: 'gain', at: [240, 0], parameters: { gain: 2 } },
    { id: 's', type: 'add', at: [480, 0], label: 'Sum of both' },
    { id: 'v', type: 'split vector', at: [0, 200] },
    { id: 'lost', type: 'not installed', at: [0, 400], parameters: { word: 'kept' } },
  ],
  wires: [
    { from: 'c.out', to: 's.a' },
    { from: 'g.out', to: 's.b' },
    { from: 'lost.value', to: 'v.in' },
  ],
});
const view_of = (circuit: Circuit, path: string[] = []): View => new View(enter(circuit, path), classes);
const done = (circuit: Circuit, command: edits.CircuitCommand | null | undefined): Circuit => {
  expect(command).toBeTruthy();
  // every command must survive serialisation
  expect(JSON.parse(JSON.stringify(command))).toEqual(command);
  return apply_changes(circuit, command!.changes);
};
const wires = (c: Circuit): string[] => (c.wires ?? []).map((w) => `${w.from} > ${w.to}`).sort();

describe('changes', () => {
  it('have no negative zero, which JSON cannot keep', () => {
    const circuit = sample();
    const moved = done(circuit, edits.move(view_of(circuit), new Map([['g', [-0, 450]]])));
    expect(moved.lsis!.find((l) => l.id === 'g')!.at).toEqual([0, 450]);
    expect(edits.snap([-1, -1], true)).toEqual([0, 0]);
  });

  it('replace, append, remove, and apply to nested circuits', () => {
    const top: Circuit = { name: 't', lsis: [{ id: 'a', type: 'x' }, { id: 'b', type: 'x' }], circuits: [{ name: 'arm', lsis: [{ id: 'q', type: 'x' }], circuits: [{ name: 'elbow' }] }] };
    const before = structuredClone(top);
    const changes: Change[] = [
      { list: 'lsis', put: { id: 'a', type: 'y' } },
      { list: 'lsis', put: { id: 'c', type: 'z' } },
      { list: 'lsis', take: 'b' },
      { in: ['arm'], list: 'lsis', take: 'q' },
      { in: ['arm', 'elbow'], set: { doc: 'bends' } },
      { set: { inputs_at: [1, 2] } },
    ];
    const after = apply_changes(top, changes);
    expect(after.lsis).toEqual([{ id: 'a', type: 'y' }, { id: 'c', type: 'z' }]);
    expect(after.circuits![0]!.lsis).toEqual([]);
    expect(after.circuits![0]!.circuits![0]!.doc).toBe('bends');
    expect(after.inputs_at).toEqual([1, 2]);
    expect(top).toEqual(before);
  });
  it('keep objects that are equal', () => {
    const a = sample();
    const b = structuredClone(a);
    b.lsis![1]!.at = [250, 0];
    const c = reconcile(a, b);
    expect(c).toEqual(b);
    expect(c.lsis![0]).toBe(a.lsis![0]);
    expect(c.lsis![1]).not.toBe(a.lsis![1]);
    expect(c.wires).toBe(a.wires);
  });
  it('omit default fields of LSIs', () => {
    expect(JSON.stringify(tidy_lsi({ values: {}, at: [0, 0], label: '', every: 1, type: 'gain', id: 'g', parameters: { gain: 1 } }))).toBe('{"id":"g","type":"gain","parameters":{"gain":1}}');
    expect(fresh_id('low-pass filter', new Set(['low-pass-filter']))).toBe('low-pass-filter-2');
  });
});

describe('a view', () => {
  it('has nodes for own pins, and missing LSIs with the pins that their wires name', () => {
    const view = view_of(sample());
    expect(view.node('s')!.title).toBe('Sum of both');
    expect(view.node('s')!.subtitle).toBe('add');
    expect(view.node('lost')!.kind).toBe('missing');
    expect(view.node('lost')!.outputs.map((p) => p.name)).toEqual(['value']);
    expect(view.node(inputs_node)!.outputs[0]!.name).toBe('live');
    expect(view.wires.length).toBe(5);
    expect(view.at_pin('s', 'in', 'a').length).toBe(1);
  });
  it('keeps unchanged nodes of the previous view', () => {
    const circuit = sample();
    const before = view_of(circuit);
    const after = new View(enter(done(circuit, edits.move(before, new Map([['g', [250, 20]]]))), []), classes, before);
    expect(after.node('c')).toBe(before.node('c'));
    expect(after.node('g')).not.toBe(before.node('g'));
  });
});

describe('rules for wires', () => {
  const view = view_of(sample());
  it('gives the reason why pins may not be wired', () => {
    expect(why_not(view, { node: 'v', side: 'out', pin: 'x' }, { node: 'g', side: 'in', pin: 'in' })).toBeNull();
    expect(why_not(view, { node: 'c', side: 'out', pin: 'out' }, { node: 'v', side: 'in', pin: 'in' })).toMatch(/carries scalar.*takes vector.*make vector/);
    expect(why_not(view, { node: 'c', side: 'out', pin: 'out' }, { node: 'g', side: 'out', pin: 'out' })).toMatch(/outputs/);
    expect(why_not(view, { node: 'c', side: 'out', pin: 'out' }, { node: 's', side: 'in', pin: 'a' })).toMatch(/already/);
  });
  it('lists the pins at which a wire may end', () => {
    const fits = pins_that_fit(view, { node: 'v', side: 'out', pin: 'x' });
    expect(fits.map((p) => `${p.node}.${p.pin}`).sort()).toEqual([`${outputs_node}.y`, 'g.in', 's.a', 's.b']);
  });
  it('searches, optionally only for what fits a pin', () => {
    expect(search(view, 'vec').map((c) => c.type)).toEqual(['make vector', 'split vector']);
    expect(search(view, 'add')[0]!.type).toBe('add');
    expect(search(view, '', { node: 'lost', side: 'out', pin: 'value' }).length).toBeGreaterThan(4);
    const wanted = search(view, '', { node: 'c', side: 'out', pin: 'out' }).map((c) => c.type);
    expect(wanted).toContain('gain');
    expect(wanted).not.toContain('constant');
    expect(wanted).not.toContain('split vector');
    expect(wanted).not.toContain('note');
  });
});

describe('edits', () => {
  it('wire, replacing the wire of a single input', () => {
    const circuit = sample();
    const after = done(circuit, edits.connect(view_of(circuit), { node: 'v', side: 'out', pin: 'x' }, { node: 's', side: 'in', pin: 'a' }));
    expect(wires(after)).toEqual(['g.out > s.b', 'lost.value > v.in', 'v.x > s.a']);
    expect(after.lsis![4]).toEqual(circuit.lsis![4]);
  });
  it('wire own inputs and outputs of the circuit', () => {
    const circuit = sample();
    let after = done(circuit, edits.connect(view_of(circuit), { node: inputs_node, side: 'out', pin: 'live' }, { node: 's', side: 'in', pin: 'a' }));
    expect(after.inputs![0]!.to).toEqual(['g.in', 's.a']);
    expect(wires(after)).not.toContain('c.out > s.a');
    after = done(after, edits.connect(view_of(after), { node: 'g', side: 'out', pin: 'out' }, { node: outputs_node, side: 'in', pin: 'y' }));
    expect(after.outputs![0]!.from).toBe('g.out');
    after = done(after, edits.disconnect(view_of(after), view_of(after).wires.filter((w) => w.to === outputs_node || w.from === inputs_node)));
    expect(after.outputs![0]!.from).toEqual([]);
    expect(after.inputs![0]!.to).toEqual([]);
  });
  it('remove several wires of one own input at once', () => {
    const circuit = sample();
    circuit.inputs![0]!.to = ['g.in', 's.a', 's.b'];
    circuit.wires = [];
    const view = view_of(circuit);
    const after = done(circuit, edits.disconnect(view, view.wires.filter((w) => w.to === 's')));
    expect(after.inputs![0]!.to).toEqual('g.in');
  });
  it('add an LSI wired to the pin that the wire was drawn from', () => {
    const circuit = sample();
    const made = edits.add_lsi(view_of(circuit), 'gain', [333, 77], { node: 'c', side: 'out', pin: 'out' });
    const after = done(circuit, made.command);
    expect(after.lsis!.at(-1)).toEqual({ id: 'gain', type: 'gain', at: [330, 80] });
    expect(wires(after)).toContain('c.out > gain.in');
    const backwards = edits.add_lsi(view_of(after), 'constant', [0, 0], { node: 'v', side: 'in', pin: 'in' });
    expect(wires(done(after, backwards.command)).length).toBe(wires(after).length); // no pin fits, so no wire is added
  });
  it('delete LSIs with their wires and probes, and keep own outputs unwired', () => {
    const circuit = sample();
    circuit.probes = [{ pin: 's.out', at: [0, 0] }];
    const after = done(circuit, edits.remove(view_of(circuit), { nodes: new Set(['s']), wires: new Set() }));
    expect(after.lsis!.map((l) => l.id)).toEqual(['c', 'g', 'v', 'lost']);
    expect(wires(after)).toEqual(['lost.value > v.in']);
    expect(after.outputs![0]!.from).toEqual([]);
    expect(after.probes).toEqual([]);
  });
  it('rename without changing the id; set and reset parameters', () => {
    const circuit = sample();
    let after = done(circuit, edits.rename(view_of(circuit), 'g', 'Twice'));
    expect(after.lsis![1]).toEqual({ id: 'g', type: 'gain', label: 'Twice', at: [240, 0], parameters: { gain: 2 } });
    after = done(after, edits.set_parameter(view_of(after), 'g', 'gain', undefined));
    expect(after.lsis![1]).toEqual({ id: 'g', type: 'gain', label: 'Twice', at: [240, 0] });
  });
  it('copy and paste keep inner wires, use fresh ids, and include nested circuits', () => {
    const circuit = sample();
    const clip = edits.copy(view_of(circuit), new Set(['c', 's', 'g']))!;
    expect(clip.wires.length).toBe(2);
    const pasted = edits.paste(view_of(circuit), edits.read_clip(JSON.stringify(clip))!, [500, 500])!;
    const after = done(circuit, pasted.command);
    expect(pasted.nodes).toEqual(['c-2', 'g-2', 's-2']);
    expect(wires(after)).toContain('c-2.out > s-2.a');
    expect(after.lsis!.find((l) => l.id === 'g-2')!.at).toEqual([740, 500]);
    const grouped = edits.group(view_of(circuit), new Set(['g', 's']))!;
    const with_group = done(circuit, grouped.command);
    const elsewhere = done({ name: 'empty' }, edits.paste(view_of({ name: 'empty' }), edits.copy(view_of(with_group), new Set([grouped.id]))!, [0, 0])!.command);
    expect(elsewhere.circuits![0]!.lsis!.length).toBe(2);
    expect(edits.read_clip('{"ugoki": "circuit", "lsis": [3]}')).toBeNull();
    expect(edits.read_clip('hello')).toBeNull();
  });
  it('group and then ungroup restore the same wires', () => {
    const circuit = sample();
    circuit.parameters = [{ name: 'factor', to: 'g.gain' }];
    const made = edits.group(view_of(circuit), new Set(['g', 's']))!;
    const grouped = done(circuit, made.command);
    expect(grouped.lsis!.map((l) => l.id)).toEqual(['c', 'v', 'lost', 'group']);
    const inner = grouped.circuits![0]!;
    expect(inner.inputs!.map((p) => p.to)).toEqual(expect.arrayContaining(['g.in', 's.a']));
    expect(inner.outputs).toEqual([{ name: 'out', type: 'scalar', from: 's.out' }]);
    expect(inner.wires).toEqual([{ from: 'g.out', to: 's.b' }]);
    expect(grouped.outputs![0]!.from).toBe('group.out');
    expect(grouped.parameters![0]!.to).toBe('group.factor');
    expect(grouped.inputs![0]!.to).toMatch(/^group\./);
    const back = edits.ungroup(view_of(grouped), 'group')!;
    const flat = done(grouped, back.command);
    expect(flat.circuits).toEqual([]);
    expect(wires(flat)).toEqual(wires(circuit));
    expect(flat.inputs).toEqual(circuit.inputs);
    expect(flat.outputs).toEqual(circuit.outputs);
    expect(flat.parameters).toEqual(circuit.parameters);
    expect(flat.lsis!.map((l) => l.id).sort()).toEqual(circuit.lsis!.map((l) => l.id).sort());
  });
  it('group two LSIs that share a source with one pin', () => {
    const circuit: Circuit = { name: 't', lsis: [{ id: 'c', type: 'constant' }, { id: 'a', type: 'gain' }, { id: 'b', type: 'gain' }], wires: [{ from: 'c.out', to: 'a.in' }, { from: 'c.out', to: 'b.in' }] };
    const grouped = done(circuit, edits.group(view_of(circuit), new Set(['a', 'b']))!.command);
    expect(grouped.circuits![0]!.inputs).toEqual([{ name: 'in', type: 'scalar', to: ['a.in', 'b.in'] }]);
    expect(wires(grouped)).toEqual(['c.out > group.in']);
  });
  it('rename an own pin and the wires at every use', () => {
    const circuit = done(sample(), edits.group(view_of(sample()), new Set(['g', 's']))!.command);
    const after = done(circuit, edits.rename_own_pin(view_of(circuit, ['group']), 'inputs', 'a', 'first'));
    expect(after.circuits![0]!.inputs!.map((p) => p.name)).toContain('first');
    expect(wires(after)).toContain('c.out > group.first');
    const gone = done(after, edits.remove_own_pin(view_of(after, ['group']), 'inputs', 'first'));
    expect(wires(gone)).not.toContain('c.out > group.first');
  });
  it('add an own pin by wiring to the extra pin', () => {
    const circuit = done(sample(), edits.group(view_of(sample()), new Set(['g', 's']))!.command);
    const view = view_of(circuit, ['group']);
    const after = done(circuit, edits.connect(view, { node: 'g', side: 'out', pin: 'out' }, { node: outputs_node, side: 'in', pin: new_pin }));
    expect(after.circuits![0]!.outputs!.at(-1)).toEqual({ name: 'out 2', type: 'scalar', from: 'g.out' });
  });
  it('insert a delay into a wire', () => {
    const circuit = sample();
    const view = view_of(circuit);
    const after = done(circuit, edits.insert_delay(view, view.wires.find((w) => w.from === 'g')!, classes)!.command);
    expect(wires(after)).toEqual(expect.arrayContaining(['g.out > delay.in', 'delay.out > s.b']));
    expect(wires(after)).not.toContain('g.out > s.b');
  });
});

describe('problems', () => {
  const grouped = done(sample(), edits.group(view_of(sample()), new Set(['g', 's']))!.command);
  it('are assigned to LSIs by JSON path and by flat id, at every depth', () => {
    const placed = locate_problems(grouped, [
      { location: 'circuit/lsis/2/type', message: 'The LSI is missing.' },
      { location: 'circuit/lsis/3(group)/lsis/1', message: 'Nothing is wired.' },
      { location: 'circuit/lsis/3(group)/wires/0/to', message: 'x' },
      { location: 'content, section circuit', message: 'y' },
      { location: 'group/s', message: 'z' },
    ]);
    expect(placed.map((p) => p.lsi)).toEqual(['lost', 'group/s', 'group/s', '', 'group/s']);
    expect(problems_at(placed, [], 'group').length).toBe(3);
    expect(problems_at(placed, ['group'], 's').length).toBe(3);
    expect(problems_at(placed, [], 'c').length).toBe(0);
  });
  it('mark the wires of an algebraic loop named in the message', () => {
    const message = 'Values form a cycle within one tick: group/g.out -> group/s.b, group/s.out -> group/g.in.';
    expect(read_loop(message)).toEqual([{ from: 'group/g.out', to: 'group/s.b' }, { from: 'group/s.out', to: 'group/g.in' }]);
    const placed = locate_problems(grouped, [{ location: 'circuit', message }]);
    const view = view_of(grouped, ['group']);
    expect([...loop_wires(placed, ['group'], view.wires)]).toEqual(['g.out\ns.b']);
    expect(problems_at(placed, ['group'], 'g').length).toBe(1);
  });
});

describe('live values', () => {
  it('keep curves in order when the simulation is set back', () => {
    const live = new LiveValues();
    live.take({ time: 1, pins: [['a.out', 1, [2]]], probes: [['a.out', [0, 0.5, 1], [[1, 2, 3]]]] }, 0);
    live.take({ time: 0.6, pins: [['a.out', 1, [2]]], probes: [['a.out', [0.6], [[9]]]] }, 5);
    expect(live.curve('a.out')).toEqual({ times: [0, 0.5, 0.6], values: [[1, 2, 9]] });
    expect(live.pin('a.out')!.changed).toBe(0);
    live.take({ time: 0.7, pins: [['a.out', 1, [3]]], times: [['g/a', 1], ['g/b', 2]] }, 9);
    expect(live.pin('a.out')!.changed).toBe(9);
    expect(live.time_of('g')).toBe(3);
    expect(live.time_of('h')).toBeUndefined();
  });
  it('are formatted briefly', () => {
    expect([0, 1, -0.12345, 46.81, 123456, 0.00001, 9.8, NaN].map(short_number)).toEqual(['0', '1', '-0.123', '46.81', '1.2e5', '1.0e-5', '9.8', '–']);
    expect(short_value('vector', { count: 1, numbers: [1, 2, 3], changed: 0 })).toBe('1  2  3');
    expect(short_value('contacts', { count: 8, numbers: [2], changed: 0 })).toBe('2');
  });
});

describe('a large circuit', () => {
  const n = 10_000;
  const big: Circuit = {
    version: 1, name: 'big',
    lsis: Array.from({ length: n }, (_, i) => ({ id: `g${i}`, type: 'gain', at: [(i % 100) * 240, Math.floor(i / 100) * 110] as [number, number] })),
    wires: Array.from({ length: n - 1 }, (_, i) => ({ from: `g${i}.out`, to: `g${i + 1}.in` })),
  };
  it('finds visible nodes, and keeps unchanged objects', () => {
    const view = view_of(big);
    const index = new SpatialIndex(view.nodes);
    const found = index.find({ x: 0, y: 0, width: 1200, height: 600 });
    expect(found.length).toBe(view.nodes.filter((m) => m.x < 1200 && m.y < 600).length);
    const moved = reconcile(big, JSON.parse(JSON.stringify(done(big, edits.move(view, new Map([['g5', [7, 7]]])))))); 
    expect(moved.lsis![4]).toBe(big.lsis![4]);
    expect(JSON.stringify({ ...moved, lsis: undefined })).toBe(JSON.stringify({ ...big, lsis: undefined }));
  });
});

describe('the keyboard', () => {
  const view = view_of(sample());
  it('moves from node to node and from pin to pin', () => {
    expect(next_node(view, 'c', 'right')).toBe('g');
    expect(next_node(view, 'g', 'right')).toBe('s');
    expect(next_node(view, 'c', 'down')).toBe('v');
    expect(next_pin(view, { node: 's', side: 'in', pin: 'a' }, 'down')).toEqual({ node: 's', side: 'in', pin: 'b' });
    expect(next_pin(view, { node: 's', side: 'in', pin: 'b' }, 'left')).toEqual({ node: 'g', side: 'out', pin: 'out' });
    expect(next_pin(view, { node: 'g', side: 'out', pin: 'out' }, 'right')).toEqual({ node: 's', side: 'in', pin: 'b' });
    expect(next_pin(view, { node: 's', side: 'in', pin: 'a' }, 'right')).toEqual({ node: 's', side: 'out', pin: 'out' });
  });
  it('adds, wires and removes without a mouse', () => {
    let circuit = sample();
    const labels: string[] = [];
    const host = { edit: vi.fn(async (command: edits.CircuitCommand | { type: 'circuit.set' }) => {
      if (command.type !== 'circuit.edit') return true;
      circuit = apply_changes(circuit, command.changes);
      labels.push(command.label);
      editor.show(circuit, true, classes, []);
      return true;
    }), notify: vi.fn() };
    const editor: CircuitEditor = new CircuitEditor(host as never);
    editor.show(circuit, false, classes, []);
    editor.open_search([0, 600], { x: 0, y: 0 });
    editor.choose('constant', 'class');
    expect(editor.chosen).toBe('constant');
    editor.enter_key(); // to its pins
    expect(editor.state.pin).toEqual({ node: 'constant', side: 'out', pin: 'out' });
    editor.enter_key(); // starts a wire
    expect(editor.state.target).not.toBeNull();
    for (let i = 0; i < 8 && editor.state.target?.pin !== 'b'; i++) editor.go('down');
    editor.enter_key();
    expect(wires(circuit)).toContain('constant.out > s.b');
    expect(editor.state.announcement).toMatch(/Wired/);
    expect(editor.escape()).toBe(true);
    editor.select(['constant']);
    editor.remove();
    expect(circuit.lsis!.some((l) => l.id === 'constant')).toBe(false);
    expect(labels).toEqual(['Add constant', 'Wire', 'Delete “constant”']);
    editor.select(['g', 's']);
    editor.group();
    expect(editor.chosen).toBe('group');
    expect(editor.go_inside('group')).toBe(true);
    expect(editor.state.path).toEqual(['group']);
    expect(flat_source(circuit, enter(circuit, ['group']), inputs_node, 'a')).toBe('c.out');
    editor.add('constant', [0, 0]);
    expect(circuit.circuits![0]!.lsis!.at(-1)!.type).toBe('constant');
    editor.go_out();
    expect(editor.chosen).toBe('group');
    expect(editor.flat_output('group', 'out')).toBe('group/s.out');
    expect(editor.flat_output(inputs_node, 'live')).toBe('input:live.value');
    editor.ungroup();
    expect(circuit.lsis!.map((l) => l.id)).toContain('s');
  });
  it('inserts a delay into an algebraic loop', () => {
    let circuit: Circuit = { name: 't', lsis: [{ id: 'p', type: 'gain' }, { id: 'q', type: 'gain', at: [240, 0] }], wires: [{ from: 'p.out', to: 'q.in' }, { from: 'q.out', to: 'p.in' }] };
    const editor: CircuitEditor = new CircuitEditor({ edit: async (c) => { if (c.type === 'circuit.edit') circuit = apply_changes(circuit, c.changes); return true; }, notify: () => undefined });
    editor.show(circuit, true, classes, [{ location: 'circuit', message: 'Values form a cycle within one tick: p.out -> q.in, q.out -> p.in.' }]);
    expect(editor.problems_of('p').length).toBe(1);
    editor.insert_delay(editor.state.problems[0]!);
    expect(wires(circuit)).toEqual(['delay.out > p.in', 'p.out > q.in', 'q.out > delay.in']);
  });
});

describe('auto-layout', () => {
  it('passes every LSI, pin and complete wire to the engine and reads positions on the grid', () => {
    const view = view_of(sample());
    const graph = elk_graph(view);
    expect(graph.children!.length).toBe(view.nodes.length);
    const ports = new Set(graph.children!.flatMap((c) => c.ports!.map((p) => p.id)));
    for (const e of graph.edges!) expect(ports.has(e.sources[0]!) && ports.has(e.targets[0]!)).toBe(true);
    const places = read_layout(view, { id: 'circuit', children: graph.children!.map((c, i) => ({ ...c, x: i * 103, y: 7 })) });
    for (const [x, y] of places.values()) expect([x % 10, y % 10].map(Math.abs)).toEqual([0, 0]);
  });
});
