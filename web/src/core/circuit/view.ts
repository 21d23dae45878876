/**
 * The view of one level of a circuit: nodes with their pins and sizes, wires with their end points. A view is made from the previous one:
 * unchanged nodes and wires stay the same objects, so they are neither computed nor drawn again.
 */
import type { ClassList } from './classes';
import { ends_of, split_end, type Circuit, type Lsi, type Note, type Point, type Probe } from './form';
import { grid, note_size, pin_point, probe_size, size_of } from './geometry';
import { find_circuit, same_types, type Level } from './level';
import { circuit_pins, class_pins, own_info, same_pins, type PinInfo, type Pins } from './pins';
import { SpatialIndex, type Box } from './spatial';

export * from './geometry';
export { enter, find_circuit, flat_pin, type Level } from './level';
export type { PinInfo } from './pins';

/** Ids of the nodes that show the circuit's own pins. No LSI can have these ids, because ids have only letters, digits, `_` and `-`. */
export const inputs_node = '<inputs>';
export const outputs_node = '<outputs>';
/** Name of the extra pin of the nodes `inputs_node` and `outputs_node`; a wire to it adds a pin to the circuit. */
export const new_pin = '<new>';
export const note_id = (id: string): string => `note:${id}`;
export const probe_id = (pin: string): string => `probe:${pin}`;

export type NodeKind = 'class' | 'circuit' | 'missing' | 'inputs' | 'outputs';

export interface ViewNode extends Pins {
  id: string;
  kind: NodeKind;
  title: string;
  /** The LSI's type, if the title differs from it; otherwise empty. */
  subtitle: string;
  doc: string;
  note: string;
  /** The LSI that the node shows; null for the nodes of the circuit's own pins. */
  lsi: Lsi | null;
  /** Upper left corner and size, px of the circuit's plane. */
  x: number;
  y: number;
  width: number;
  height: number;
}

export interface ViewWire {
  key: string;
  /** Node id and pin name of the output, then of the input. */
  from: string;
  from_pin: string;
  to: string;
  to_pin: string;
  type: string;
  /** True: the consumer sees the value from the next tick on. */
  delayed: boolean;
  /** True: one of the wire's two pins does not exist. */
  broken: boolean;
  /** Start and end point, px of the circuit's plane. */
  a: Point;
  b: Point;
}

/** Kind and pins of a type of LSI, with no pin marked as wired. */
interface Template extends Pins {
  kind: NodeKind;
  doc: string;
}

const nothing: Template = { kind: 'missing', doc: '', inputs: [], outputs: [] };

/**
 * Compares two lists by object identity.
 * @return for each item of `next` its index in `old`, or -1; and the indices of `old` missing in `next`
 */
function match<T extends object>(old: readonly T[], next: readonly T[]): { from: Int32Array; removed: number[] } {
  const from = new Int32Array(next.length).fill(-1);
  const seen = new Uint8Array(old.length);
  let where: Map<T, number> | null = null;
  let j = 0;
  next.forEach((item, i) => {
    let k: number | undefined = old[j] === item ? j : undefined;
    if (k === undefined && j < old.length) k = (where ??= new Map(old.map((o, at) => [o, at]))).get(item);
    if (k === undefined) return;
    from[i] = k;
    seen[k] = 1;
    j = k + 1;
  });
  const removed: number[] = [];
  seen.forEach((s, at) => s || removed.push(at));
  return { from, removed };
}

export class View {
  readonly nodes: ViewNode[] = [];
  readonly wires: ViewWire[] = [];
  readonly index: SpatialIndex<ViewNode>;
  private readonly by_id: Map<string, ViewNode>;
  private readonly by_node: Map<string, readonly ViewWire[]>;
  private readonly templates: Map<string, Template>;
  /** Bounding box of all nodes, notes and probes; null until it is needed. */
  private whole: Box | null = null;

  constructor(
    readonly level: Level,
    readonly classes: ClassList,
    before?: View,
  ) {
    const old = before?.classes === classes && same_types(before.level, level) ? before : undefined;
    this.templates = old?.templates ?? new Map();
    this.by_id = new Map(old?.by_id);
    this.by_node = new Map(old?.by_node);
    const lsis = level.circuit.lsis ?? [];

    // LSIs that are the same objects as before keep their nodes, unless a wire at them changed
    const kept = match(old?.level.circuit.lsis ?? [], lsis);
    const touched = new Set<string>(); // ids of the nodes that must be made again
    const retyped = new Set<string>(); // ids whose type changed or that were removed
    const changed = new Map<string, Lsi>(); // LSIs that are new or changed objects
    for (const at of kept.removed) retyped.add(old!.nodes[at]!.id);
    lsis.forEach((lsi, i) => {
      if (kept.from[i]! >= 0) return;
      touched.add(lsi.id);
      changed.set(lsi.id, lsi);
      if (old?.by_id.get(lsi.id)?.lsi?.type === lsi.type) retyped.delete(lsi.id);
      else retyped.add(lsi.id);
    });
    for (const at of kept.removed) {
      const { id } = old!.nodes[at]!;
      if (!changed.has(id)) this.by_id.delete(id);
    }
    const own = this.own_templates(level.circuit);
    const template = (id: string): Template | undefined => {
      const side = own.get(id);
      if (side) return side;
      const lsi = changed.get(id) ?? this.by_id.get(id)?.lsi;
      return lsi ? this.template(lsi.type) : undefined;
    };

    const added: ViewWire[] = [];
    const removed = this.make_wires(old, retyped, template, added);
    for (const list of [removed, added]) for (const w of list) touched.add(w.from).add(w.to);
    this.relist(removed, added);

    // make the nodes, and record which changed, for the spatial index and the wires' end points
    const moved = new Set<string>();
    const removed_nodes: ViewNode[] = [];
    const added_nodes: ViewNode[] = [];
    const put = (node: Omit<ViewNode, 'width' | 'height'>): ViewNode => {
      const sized: ViewNode = { ...node, ...size_of(node) };
      const twin = before?.node(node.id);
      const same = twin && same_node(twin, sized) ? twin : sized;
      this.by_id.set(same.id, same);
      const previous = old?.by_id.get(same.id);
      if (previous === same) return same;
      moved.add(same.id);
      if (previous) removed_nodes.push(previous);
      added_nodes.push(same);
      return same;
    };
    for (const at of kept.removed) if (!changed.has(old!.nodes[at]!.id)) removed_nodes.push(old!.nodes[at]!);
    lsis.forEach((lsi, i) => {
      if (kept.from[i]! >= 0 && !touched.has(lsi.id)) this.nodes.push(old!.nodes[kept.from[i]!]!);
      else this.nodes.push(put({ id: lsi.id, ...this.wired_pins(lsi.id, this.template(lsi.type)), ...texts_of(lsi), lsi, x: lsi.at?.[0] ?? 0, y: lsi.at?.[1] ?? 0 }));
    });
    this.put_own(own, put);
    for (const id of [inputs_node, outputs_node]) {
      const previous = old?.by_id.get(id);
      if (previous && !own.has(id)) {
        removed_nodes.push(previous);
        this.by_id.delete(id);
      }
    }
    this.index = old ? old.index.replaced(removed_nodes, added_nodes) : new SpatialIndex(this.nodes);
    this.set_wire_ends(moved, new Set(added));
  }

  /**
   * Fills `wires`, reusing wires of `old` whose ends did not change. New wires are also appended to `added`.
   * @return the wires of `old` that were removed
   */
  private make_wires(old: View | undefined, retyped: ReadonlySet<string>, template: (id: string) => Template | undefined, added: ViewWire[]): ViewWire[] {
    const { circuit } = this.level;
    const plain = circuit.wires ?? [];
    const previous = old?.level.circuit.wires ?? [];
    const kept = match(previous, plain);
    const removed = kept.removed.map((at) => old!.wires[at]!);
    const make = (from: string, from_pin: string, to: string, to_pin: string): void => {
      const source = pin_in(template(from), 'out', from_pin);
      const target = pin_in(template(to), 'in', to_pin);
      const wire: ViewWire = {
        key: `${from}.${from_pin}\n${to}.${to_pin}`, from, from_pin, to, to_pin,
        type: source?.type ?? target?.type ?? 'any', delayed: source?.delayed ?? false, broken: !source || !target, a: [0, 0], b: [0, 0],
      };
      added.push(wire);
      this.wires.push(wire);
    };
    plain.forEach((wire, i) => {
      const twin = kept.from[i]! >= 0 ? old!.wires[kept.from[i]!]! : undefined;
      if (twin && (retyped.size === 0 || (!retyped.has(twin.from) && !retyped.has(twin.to)))) return void this.wires.push(twin);
      if (twin) removed.push(twin);
      make(...split_end(wire.from), ...split_end(wire.to));
    });
    // a circuit has few own pins, so their wires are always made again
    removed.push(...(old?.wires.slice(previous.length) ?? []));
    for (const pin of circuit.inputs ?? []) for (const end of ends_of(pin.to)) make(inputs_node, pin.name, ...split_end(end));
    for (const pin of circuit.outputs ?? []) for (const end of ends_of(pin.from)) make(...split_end(end), outputs_node, pin.name);
    return removed;
  }

  /** Sets the end points of added wires, and replaces wires at moved nodes by copies with new end points. */
  private set_wire_ends(moved: ReadonlySet<string>, added: ReadonlySet<ViewWire>): void {
    const ends = (w: ViewWire): { a: Point; b: Point } => {
      const [from, to] = [this.by_id.get(w.from), this.by_id.get(w.to)];
      return { a: from ? pin_point(from, 'out', w.from_pin) : [0, 0], b: to ? pin_point(to, 'in', w.to_pin) : [0, 0] };
    };
    const old_wires: ViewWire[] = [];
    const new_wires: ViewWire[] = [];
    if (moved.size > 0 || added.size > 0) this.wires.forEach((w, i) => {
      if (added.has(w)) return void Object.assign(w, ends(w));
      if (!moved.has(w.from) && !moved.has(w.to)) return;
      old_wires.push(w);
      new_wires.push((this.wires[i] = { ...w, ...ends(w) }));
    });
    this.relist(old_wires, new_wires);
  }

  /** Updates `by_node` for removed and added wires. */
  private relist(removed: readonly ViewWire[], added: readonly ViewWire[]): void {
    const dropped = new Set(removed);
    const lists = new Map<string, ViewWire[]>();
    const at = (id: string): ViewWire[] => {
      let list = lists.get(id);
      if (!list) lists.set(id, (list = (this.by_node.get(id) ?? []).filter((w) => !dropped.has(w))));
      return list;
    };
    for (const w of removed) at(w.from), at(w.to);
    for (const w of added) {
      at(w.from).push(w);
      if (w.to !== w.from) at(w.to).push(w);
    }
    for (const [id, list] of lists) list.length > 0 ? this.by_node.set(id, list) : this.by_node.delete(id);
  }

  /** The template of a type; made once for each type. */
  private template(type: string): Template {
    let found = this.templates.get(type);
    if (!found) {
      const inner = find_circuit(this.level, type)?.circuit;
      const declared = inner ? undefined : this.classes.find(type);
      if (inner) found = { kind: 'circuit', doc: inner.doc ?? '', ...circuit_pins(inner) };
      else found = declared ? { kind: 'class', doc: declared.doc ?? '', ...class_pins(declared) } : nothing;
      this.templates.set(type, found);
    }
    return found;
  }

  /** Templates of the nodes of the circuit's own pins. In a nested circuit each node has the extra pin `new_pin`. */
  private own_templates(circuit: Circuit): Map<string, Template> {
    const inside = this.level.path.length > 0;
    const out = new Map<string, Template>();
    const extra = (side: 'in' | 'out'): PinInfo[] => (inside ? [own_info({ name: new_pin, type: 'any' }, side)] : []);
    if (circuit.inputs?.length || inside) out.set(inputs_node, { kind: 'inputs', doc: '', inputs: [], outputs: [...(circuit.inputs ?? []).map((p) => own_info(p, 'out')), ...extra('out')] });
    if (circuit.outputs?.length || inside) out.set(outputs_node, { kind: 'outputs', doc: '', inputs: [...(circuit.outputs ?? []).map((p) => own_info(p, 'in')), ...extra('in')], outputs: [] });
    return out;
  }

  /** Adds the nodes of the circuit's own pins, by default left and right of everything else. */
  private put_own(own: ReadonlyMap<string, Template>, put: (node: Omit<ViewNode, 'width' | 'height'>) => ViewNode): void {
    const { circuit } = this.level;
    const box = own.size > 0 ? this.bounds() : null;
    for (const [id, title, at] of [[inputs_node, 'Inputs', circuit.inputs_at], [outputs_node, 'Outputs', circuit.outputs_at]] as const) {
      const template = own.get(id);
      if (!template || !box) continue;
      const node = { id, title, subtitle: '', note: '', lsi: null, x: 0, y: 0, ...this.wired_pins(id, template) };
      const { width, height } = size_of(node);
      const x = at?.[0] ?? (id === inputs_node ? box.x - width - 80 : box.x + box.width + 80);
      const y = at?.[1] ?? Math.round((box.y + (box.height - height) / 2) / grid) * grid + 0;
      this.nodes.push(put({ ...node, x, y }));
    }
  }

  /** Pins of node `id` with the wired ones marked. A missing LSI has the pins that its wires name. */
  private wired_pins(id: string, template: Template): Template {
    const outputs = new Set<string>();
    const inputs = new Set<string>();
    for (const w of this.by_node.get(id) ?? []) {
      if (w.from === id) outputs.add(w.from_pin);
      if (w.to === id) inputs.add(w.to_pin);
    }
    const mark = (pins: readonly PinInfo[], wired: ReadonlySet<string>, side: 'in' | 'out'): PinInfo[] => {
      if (template.kind === 'missing') return [...wired].map((name) => ({ ...own_info({ name, type: 'any' }, side), wired: true }));
      return pins.map((p) => (wired.has(p.name) ? { ...p, wired: true } : p));
    };
    return { kind: template.kind, doc: template.doc, inputs: mark(template.inputs, inputs, 'in'), outputs: mark(template.outputs, outputs, 'out') };
  }

  node(id: string): ViewNode | undefined {
    return this.by_id.get(id);
  }
  pin(id: string, side: 'in' | 'out', name: string): PinInfo | undefined {
    const node = this.by_id.get(id);
    return (side === 'in' ? node?.inputs : node?.outputs)?.find((p) => p.name === name);
  }
  /** All wires at the pins of a node. */
  at_node(id: string): readonly ViewWire[] {
    return this.by_node.get(id) ?? [];
  }
  /** All wires at a pin. */
  at_pin(id: string, side: 'in' | 'out', name: string): readonly ViewWire[] {
    return this.at_node(id).filter((w) => (side === 'in' ? w.to === id && w.to_pin === name : w.from === id && w.from_pin === name));
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

  /** Bounding box of the nodes, notes and probes in `ids`, or of everything. */
  bounds(ids?: ReadonlySet<string>): Box {
    if (!ids && this.whole) return this.whole;
    const box = this.find_bounds(ids);
    if (!ids && this.index) this.whole = box; // not while the constructor runs, because the nodes of the own pins are still missing
    return box;
  }

  private find_bounds(ids?: ReadonlySet<string>): Box {
    let [left, top, right, bottom] = [Infinity, Infinity, -Infinity, -Infinity];
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

/** A pin of a template; a missing LSI has every pin, with the type `any`. */
function pin_in(template: Template | undefined, side: 'in' | 'out', name: string): PinInfo | undefined {
  if (!template) return undefined;
  if (template.kind === 'missing') return own_info({ name, type: 'any' }, side);
  return (side === 'in' ? template.inputs : template.outputs).find((p) => p.name === name);
}

function texts_of(lsi: Lsi): { title: string; subtitle: string; note: string } {
  const title = lsi.label || lsi.id;
  return { title, subtitle: lsi.type === title ? '' : lsi.type, note: lsi.note ?? '' };
}

const same_node = (a: ViewNode, b: ViewNode): boolean =>
  a.lsi === b.lsi && a.kind === b.kind && a.title === b.title && a.subtitle === b.subtitle && a.doc === b.doc && a.x === b.x && a.y === b.y && same_pins(a.inputs, b.inputs) && same_pins(a.outputs, b.outputs);
