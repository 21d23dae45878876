/** What is seen of one level of a circuit: nodes with their pins and sizes, wires with their curves. Framework-free; pixels of the circuit's plane. */
import { type ClassList, type LsiClass } from './classes';
import { ends_of, split_end, type Circuit, type Lsi, type Note, type OwnPin, type Point, type Probe } from './form';

export const grid = 10;
export const head_height = 34;
export const row_height = 22;
const foot = 8;
const least_width = 160;
const most_width = 280;

/** Ids of the nodes that stand for the circuit's own pins; no LSI can be called so. */
export const inputs_node = '<inputs>';
export const outputs_node = '<outputs>';
/** The pin of those nodes from which a new own pin is drawn. */
export const new_pin = '<new>';

export interface PinInfo {
  name: string;
  type: string;
  side: 'in' | 'out';
  unit: string;
  doc: string;
  /** inputs */
  required: boolean;
  multiple: boolean;
  direct: boolean;
  /** outputs */
  delayed: boolean;
  wired: boolean;
  count: number;
}

export type NodeKind = 'class' | 'circuit' | 'missing' | 'inputs' | 'outputs';

export interface ViewNode {
  id: string;
  kind: NodeKind;
  title: string;
  /** What it is, where the title is a name of its own. */
  subtitle: string;
  doc: string;
  note: string;
  lsi: Lsi | null;
  inputs: PinInfo[];
  outputs: PinInfo[];
  x: number;
  y: number;
  width: number;
  height: number;
}

export interface ViewWire {
  key: string;
  from: string;
  from_pin: string;
  to: string;
  to_pin: string;
  type: string;
  /** Seen by its consumer from the next tick on. */
  delayed: boolean;
  /** One of its ends is not there. */
  broken: boolean;
}

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

const input_info = (pin: LsiClass['inputs'][number]): PinInfo => ({
  name: pin.name, type: pin.type, side: 'in', unit: pin.unit ?? '', doc: pin.doc ?? '',
  required: pin.required ?? true, multiple: pin.multiple ?? false, direct: pin.direct ?? true, delayed: false, wired: false, count: pin.count ?? 0,
});
const output_info = (pin: LsiClass['outputs'][number]): PinInfo => ({
  name: pin.name, type: pin.type, side: 'out', unit: pin.unit ?? '', doc: pin.doc ?? '',
  required: false, multiple: true, direct: true, delayed: pin.delayed ?? false, wired: false, count: pin.count ?? 0,
});
const own_info = (pin: OwnPin, side: 'in' | 'out'): PinInfo => ({
  name: pin.name, type: pin.type, side, unit: pin.unit ?? '', doc: pin.doc ?? '',
  required: false, multiple: side === 'out', direct: true, delayed: false, wired: false, count: 0,
});

/** Pins of an LSI class as a node has them. */
export const class_pins = (c: LsiClass): { inputs: PinInfo[]; outputs: PinInfo[] } => ({ inputs: c.inputs.map(input_info), outputs: c.outputs.map(output_info) });
/** Pins that a circuit has when it is used as an LSI. */
export const circuit_pins = (c: Circuit): { inputs: PinInfo[]; outputs: PinInfo[] } => ({
  inputs: (c.inputs ?? []).map((p) => ({ ...own_info(p, 'in'), required: true })),
  outputs: (c.outputs ?? []).map((p) => own_info(p, 'out')),
});

/** About the width of a text in the page's font at 13 px. */
const text_width = (text: string, size = 13): number => text.length * size * 0.56;

const up = (value: number): number => Math.ceil(value / grid) * grid;

function size_of(node: Pick<ViewNode, 'title' | 'inputs' | 'outputs' | 'kind'>): { width: number; height: number } {
  const rows = Math.max(node.inputs.length, node.outputs.length);
  let widest = text_width(node.title) + (node.kind === 'class' || node.kind === 'circuit' ? 74 : 28);
  for (let i = 0; i < rows; i++) widest = Math.max(widest, text_width(node.inputs[i]?.name ?? '', 12) + text_width(node.outputs[i]?.name ?? '', 12) + 48);
  return { width: up(Math.min(most_width, Math.max(least_width, widest))), height: head_height + Math.max(1, rows) * row_height + foot };
}

/** Middle of pin `index` of a side, from the node's corner. */
export const pin_offset = (node: ViewNode, side: 'in' | 'out', index: number): Point => [side === 'in' ? 0 : node.width, head_height + row_height * (index + 0.5) + foot / 2];

export class View {
  readonly nodes: ViewNode[] = [];
  readonly wires: ViewWire[] = [];
  private readonly by_id = new Map<string, ViewNode>();
  private readonly by_pin = new Map<string, ViewWire[]>();

  constructor(
    readonly level: Level,
    readonly classes: ClassList,
    before?: View,
  ) {
    const { circuit } = level;
    const pins = new Map<string, { kind: NodeKind; doc: string; inputs: PinInfo[]; outputs: PinInfo[] }>();
    for (const lsi of circuit.lsis ?? []) {
      const inner = find_circuit(level, lsi.type);
      const found = inner ? null : classes.find(lsi.type);
      if (inner) pins.set(lsi.id, { kind: 'circuit', doc: inner.circuit.doc ?? '', ...circuit_pins(inner.circuit) });
      else if (found) pins.set(lsi.id, { kind: 'class', doc: found.doc ?? '', ...class_pins(found) });
      else pins.set(lsi.id, { kind: 'missing', doc: '', inputs: [], outputs: [] });
    }
    if (circuit.inputs?.length || level.path.length > 0) pins.set(inputs_node, { kind: 'inputs', doc: '', inputs: [], outputs: (circuit.inputs ?? []).map((p) => own_info(p, 'out')) });
    if (circuit.outputs?.length || level.path.length > 0) pins.set(outputs_node, { kind: 'outputs', doc: '', inputs: (circuit.outputs ?? []).map((p) => own_info(p, 'in')), outputs: [] });
    if (level.path.length > 0) {
      pins.get(inputs_node)!.outputs.push({ ...own_info({ name: new_pin, type: 'any' }, 'out') });
      pins.get(outputs_node)!.inputs.push({ ...own_info({ name: new_pin, type: 'any' }, 'in') });
    }

    const add_wire = (from: string, from_pin: string, to: string, to_pin: string): void => {
      const source = this.pin_in(pins.get(from), 'out', from_pin);
      const target = this.pin_in(pins.get(to), 'in', to_pin);
      if (source) source.wired = true;
      if (target) target.wired = true;
      const wire: ViewWire = {
        key: `${from}.${from_pin}\n${to}.${to_pin}`, from, from_pin, to, to_pin,
        type: source?.type ?? target?.type ?? 'any', delayed: source?.delayed ?? false, broken: !source || !target,
      };
      this.wires.push(wire);
      this.index(`out ${from}.${from_pin}`, wire);
      this.index(`in ${to}.${to_pin}`, wire);
    };
    for (const wire of circuit.wires ?? []) add_wire(...split_end(wire.from), ...split_end(wire.to));
    for (const pin of circuit.inputs ?? []) for (const end of ends_of(pin.to)) add_wire(inputs_node, pin.name, ...split_end(end));
    for (const pin of circuit.outputs ?? []) for (const end of ends_of(pin.from)) add_wire(...split_end(end), outputs_node, pin.name);

    const add = (node: Omit<ViewNode, 'width' | 'height'>): void => {
      const sized: ViewNode = { ...node, ...size_of(node) };
      const old = before?.node(node.id);
      const kept = old && same_node(old, sized) ? old : sized;
      this.nodes.push(kept);
      this.by_id.set(kept.id, kept);
    };
    for (const lsi of circuit.lsis ?? []) {
      const { kind, doc, inputs, outputs } = pins.get(lsi.id)!;
      const title = lsi.label || lsi.id;
      add({ id: lsi.id, kind, title, subtitle: lsi.type === title ? '' : lsi.type, doc, note: lsi.note ?? '', lsi, inputs, outputs, x: lsi.at?.[0] ?? 0, y: lsi.at?.[1] ?? 0 });
    }
    const box = this.bounds();
    const own = (id: string, kind: NodeKind, title: string, at: Point | undefined, side: 'left' | 'right'): void => {
      const has = pins.get(id);
      if (!has) return;
      const node = { id, kind, title, subtitle: '', doc: has.doc, note: '', lsi: null, inputs: has.inputs, outputs: has.outputs, x: 0, y: 0 };
      const { width, height } = size_of(node);
      const x = at?.[0] ?? (side === 'left' ? box.x - width - 80 : box.x + box.width + 80);
      const y = at?.[1] ?? Math.round((box.y + (box.height - height) / 2) / grid) * grid;
      add({ ...node, x, y });
    };
    own(inputs_node, 'inputs', 'Inputs', circuit.inputs_at, 'left');
    own(outputs_node, 'outputs', 'Outputs', circuit.outputs_at, 'right');
  }

  /** Pins of a missing LSI are those that its wires name. */
  private pin_in(node: { kind: NodeKind; inputs: PinInfo[]; outputs: PinInfo[] } | undefined, side: 'in' | 'out', name: string): PinInfo | undefined {
    if (!node) return undefined;
    const list = side === 'in' ? node.inputs : node.outputs;
    const found = list.find((p) => p.name === name);
    if (found || node.kind !== 'missing') return found;
    const pin = own_info({ name, type: 'any' }, side);
    list.push(pin);
    return pin;
  }

  private index(key: string, wire: ViewWire): void {
    const list = this.by_pin.get(key);
    if (list) list.push(wire);
    else this.by_pin.set(key, [wire]);
  }

  node(id: string): ViewNode | undefined {
    return this.by_id.get(id);
  }
  pin(id: string, side: 'in' | 'out', name: string): PinInfo | undefined {
    const node = this.by_id.get(id);
    return (side === 'in' ? node?.inputs : node?.outputs)?.find((p) => p.name === name);
  }
  /** Wires at a pin. */
  at_pin(id: string, side: 'in' | 'out', name: string): readonly ViewWire[] {
    return this.by_pin.get(`${side} ${id}.${name}`) ?? [];
  }
  wire(key: string): ViewWire | undefined {
    return this.wires.find((w) => w.key === key);
  }
  get notes(): readonly Note[] {
    return this.level.circuit.notes ?? [];
  }
  get probes(): readonly Probe[] {
    return this.level.circuit.probes ?? [];
  }

  /** Box around the LSIs (and around notes and probes where `all`). */
  bounds(ids?: ReadonlySet<string>): { x: number; y: number; width: number; height: number } {
    let left = Infinity;
    let top = Infinity;
    let right = -Infinity;
    let bottom = -Infinity;
    const grow = (x: number, y: number, w: number, h: number): void => {
      left = Math.min(left, x);
      top = Math.min(top, y);
      right = Math.max(right, x + w);
      bottom = Math.max(bottom, y + h);
    };
    for (const n of this.nodes) if (!ids || ids.has(n.id)) grow(n.x, n.y, n.width, n.height);
    for (const n of this.notes) if (!ids || ids.has(note_id(n.id))) grow(n.at[0], n.at[1], ...note_size(n));
    for (const p of this.probes) if (!ids || ids.has(probe_id(p.pin))) grow(p.at[0], p.at[1], ...probe_size);
    return right < left ? { x: 0, y: 0, width: 0, height: 0 } : { x: left, y: top, width: right - left, height: bottom - top };
  }
}

function same_pins(a: PinInfo[], b: PinInfo[]): boolean {
  return a.length === b.length && a.every((p, i) => {
    const q = b[i]!;
    return p.name === q.name && p.type === q.type && p.wired === q.wired && p.unit === q.unit && p.doc === q.doc && p.required === q.required && p.multiple === q.multiple && p.delayed === q.delayed;
  });
}

const same_node = (a: ViewNode, b: ViewNode): boolean =>
  a.lsi === b.lsi && a.kind === b.kind && a.title === b.title && a.subtitle === b.subtitle && a.doc === b.doc && a.x === b.x && a.y === b.y && same_pins(a.inputs, b.inputs) && same_pins(a.outputs, b.outputs);

export const note_id = (id: string): string => `note:${id}`;
export const probe_id = (pin: string): string => `probe:${pin}`;
export const probe_size: Point = [216, 96];
export const note_size = (note: Note): Point => note.size ?? [180, 80];

/** Where a wire begins or ends; the node's side where the pin is not there. */
export function pin_point(node: ViewNode, side: 'in' | 'out', name: string): Point {
  const list = side === 'in' ? node.inputs : node.outputs;
  const [x, y] = pin_offset(node, side, Math.max(0, list.findIndex((p) => p.name === name)));
  return [node.x + x, node.y + y];
}

/** Control points of a wire from a to b: level at both ends; a wire that runs back bows out far enough to be seen. */
export function wire_curve(a: Point, b: Point): [Point, Point, Point, Point] {
  const dx = b[0] - a[0];
  const bend = dx >= 0 ? Math.max(24, dx / 2) : Math.min(260, 60 - dx / 3);
  const sag = dx < -40 && Math.abs(b[1] - a[1]) < 60 ? 90 : 0;
  return [a, [a[0] + bend, a[1] + sag], [b[0] - bend, b[1] + sag], b];
}

export function wire_path(a: Point, b: Point): string {
  const [p, q, r, s] = wire_curve(a, b);
  return `M${p[0]} ${p[1]}C${q[0]} ${q[1]} ${r[0]} ${r[1]} ${s[0]} ${s[1]}`;
}

/** Name of an output of this level as the running circuit knows it: "arm/elbow.out". */
export const flat_pin = (level: Level, pin: string): string => [...level.path, pin].join('/');
