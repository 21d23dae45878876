/**
 * What is seen of one level of a circuit: nodes with their pins and sizes, wires with their ends. A view is made from the one before:
 * what did not change stays the same object and costs nothing.
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

/** Ids of the nodes that stand for the circuit's own pins; no LSI can be called so. */
export const inputs_node = '<inputs>';
export const outputs_node = '<outputs>';
/** The pin of those nodes from which a new own pin is drawn. */
export const new_pin = '<new>';
export const note_id = (id: string): string => `note:${id}`;
export const probe_id = (pin: string): string => `probe:${pin}`;

export type NodeKind = 'class' | 'circuit' | 'missing' | 'inputs' | 'outputs';

export interface ViewNode extends Pins {
  id: string;
  kind: NodeKind;
  title: string;
  /** What it is, where the title is a name of its own. */
  subtitle: string;
  doc: string;
  note: string;
  lsi: Lsi | null;
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
  /** Where it begins and ends. */
  a: Point;
  b: Point;
}

/** What a type of LSI looks like, before it is wired. */
interface Template extends Pins {
  kind: NodeKind;
  doc: string;
}

const nothing: Template = { kind: 'missing', doc: '', inputs: [], outputs: [] };

/** For each item of `next` the index of the same object in `old`, or -1; and which of `old` are gone. */
function match<T extends object>(old: readonly T[], next: readonly T[]): { from: Int32Array; gone: number[] } {
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
  const gone: number[] = [];
  seen.forEach((s, at) => s || gone.push(at));
  return { from, gone };
}

export class View {
  readonly nodes: ViewNode[] = [];
  readonly wires: ViewWire[] = [];
  readonly index: SpatialIndex<ViewNode>;
  private readonly by_id: Map<string, ViewNode>;
  private readonly by_node: Map<string, readonly ViewWire[]>;
  private readonly templates: Map<string, Template>;
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

    // LSIs: those that are the very same objects keep their nodes, unless a wire at them changed
    const kept = match(old?.level.circuit.lsis ?? [], lsis);
    const touched = new Set<string>();
    const retyped = new Set<string>();
    const given = new Map<string, Lsi>();
    for (const at of kept.gone) retyped.add(old!.nodes[at]!.id);
    lsis.forEach((lsi, i) => {
      if (kept.from[i]! >= 0) return;
      touched.add(lsi.id);
      given.set(lsi.id, lsi);
      if (old?.by_id.get(lsi.id)?.lsi?.type === lsi.type) retyped.delete(lsi.id);
      else retyped.add(lsi.id);
    });
    for (const at of kept.gone) {
      const { id } = old!.nodes[at]!;
      if (!given.has(id)) this.by_id.delete(id);
    }
    const own = this.own_templates(level.circuit);
    const template = (id: string): Template | undefined => {
      const side = own.get(id);
      if (side) return side;
      const lsi = given.get(id) ?? this.by_id.get(id)?.lsi;
      return lsi ? this.template(lsi.type) : undefined;
    };

    // wires
    const born: ViewWire[] = [];
    const gone = this.take_wires(old, retyped, template, born);
    for (const list of [gone, born]) for (const w of list) touched.add(w.from).add(w.to);
    this.relist(gone, born);

    // nodes, and where they went
    const moved = new Set<string>();
    const left: ViewNode[] = [];
    const come: ViewNode[] = [];
    const put = (node: Omit<ViewNode, 'width' | 'height'>): ViewNode => {
      const sized: ViewNode = { ...node, ...size_of(node) };
      const twin = before?.node(node.id);
      const same = twin && same_node(twin, sized) ? twin : sized;
      this.by_id.set(same.id, same);
      const was = old?.by_id.get(same.id);
      if (was === same) return same;
      moved.add(same.id);
      if (was) left.push(was);
      come.push(same);
      return same;
    };
    for (const at of kept.gone) if (!given.has(old!.nodes[at]!.id)) left.push(old!.nodes[at]!);
    lsis.forEach((lsi, i) => {
      if (kept.from[i]! >= 0 && !touched.has(lsi.id)) this.nodes.push(old!.nodes[kept.from[i]!]!);
      else this.nodes.push(put({ id: lsi.id, ...this.wired_pins(lsi.id, this.template(lsi.type)), ...words_of(lsi), lsi, x: lsi.at?.[0] ?? 0, y: lsi.at?.[1] ?? 0 }));
    });
    this.put_own(own, put);
    for (const id of [inputs_node, outputs_node]) {
      const was = old?.by_id.get(id);
      if (was && !own.has(id)) {
        left.push(was);
        this.by_id.delete(id);
      }
    }
    this.index = old ? old.index.replaced(left, come) : new SpatialIndex(this.nodes);
    this.lay_wires(moved, new Set(born));
  }

  /** Fills `wires`: those of before where nothing at them changed. @return the ones of before that are no more */
  private take_wires(old: View | undefined, retyped: ReadonlySet<string>, template: (id: string) => Template | undefined, born: ViewWire[]): ViewWire[] {
    const { circuit } = this.level;
    const plain = circuit.wires ?? [];
    const was = old?.level.circuit.wires ?? [];
    const kept = match(was, plain);
    const gone = kept.gone.map((at) => old!.wires[at]!);
    const make = (from: string, from_pin: string, to: string, to_pin: string): void => {
      const source = pin_in(template(from), 'out', from_pin);
      const target = pin_in(template(to), 'in', to_pin);
      const wire: ViewWire = {
        key: `${from}.${from_pin}\n${to}.${to_pin}`, from, from_pin, to, to_pin,
        type: source?.type ?? target?.type ?? 'any', delayed: source?.delayed ?? false, broken: !source || !target, a: [0, 0], b: [0, 0],
      };
      born.push(wire);
      this.wires.push(wire);
    };
    plain.forEach((wire, i) => {
      const twin = kept.from[i]! >= 0 ? old!.wires[kept.from[i]!]! : undefined;
      if (twin && (retyped.size === 0 || (!retyped.has(twin.from) && !retyped.has(twin.to)))) return void this.wires.push(twin);
      if (twin) gone.push(twin);
      make(...split_end(wire.from), ...split_end(wire.to));
    });
    // of the circuit's own pins there are few
    gone.push(...(old?.wires.slice(was.length) ?? []));
    for (const pin of circuit.inputs ?? []) for (const end of ends_of(pin.to)) make(inputs_node, pin.name, ...split_end(end));
    for (const pin of circuit.outputs ?? []) for (const end of ends_of(pin.from)) make(...split_end(end), outputs_node, pin.name);
    return gone;
  }

  /** Gives wires their ends: the new ones, and anew those at nodes that moved. */
  private lay_wires(moved: ReadonlySet<string>, born: ReadonlySet<ViewWire>): void {
    const ends = (w: ViewWire): { a: Point; b: Point } => {
      const [from, to] = [this.by_id.get(w.from), this.by_id.get(w.to)];
      return { a: from ? pin_point(from, 'out', w.from_pin) : [0, 0], b: to ? pin_point(to, 'in', w.to_pin) : [0, 0] };
    };
    const gone: ViewWire[] = [];
    const again: ViewWire[] = [];
    if (moved.size > 0 || born.size > 0) this.wires.forEach((w, i) => {
      if (born.has(w)) return void Object.assign(w, ends(w));
      if (!moved.has(w.from) && !moved.has(w.to)) return;
      gone.push(w);
      again.push((this.wires[i] = { ...w, ...ends(w) }));
    });
    this.relist(gone, again);
  }

  private relist(gone: readonly ViewWire[], born: readonly ViewWire[]): void {
    const no_more = new Set(gone);
    const more = new Map<string, ViewWire[]>();
    const at = (id: string): ViewWire[] => {
      let list = more.get(id);
      if (!list) more.set(id, (list = (this.by_node.get(id) ?? []).filter((w) => !no_more.has(w))));
      return list;
    };
    for (const w of gone) at(w.from), at(w.to);
    for (const w of born) {
      at(w.from).push(w);
      if (w.to !== w.from) at(w.to).push(w);
    }
    for (const [id, list] of more) list.length > 0 ? this.by_node.set(id, list) : this.by_node.delete(id);
  }

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

  /** The nodes of the circuit's own pins; inside of a circuit each has a pin more, from which a new one is drawn. */
  private own_templates(circuit: Circuit): Map<string, Template> {
    const inside = this.level.path.length > 0;
    const out = new Map<string, Template>();
    const more = (side: 'in' | 'out'): PinInfo[] => (inside ? [own_info({ name: new_pin, type: 'any' }, side)] : []);
    if (circuit.inputs?.length || inside) out.set(inputs_node, { kind: 'inputs', doc: '', inputs: [], outputs: [...(circuit.inputs ?? []).map((p) => own_info(p, 'out')), ...more('out')] });
    if (circuit.outputs?.length || inside) out.set(outputs_node, { kind: 'outputs', doc: '', inputs: [...(circuit.outputs ?? []).map((p) => own_info(p, 'in')), ...more('in')], outputs: [] });
    return out;
  }

  private put_own(own: ReadonlyMap<string, Template>, put: (node: Omit<ViewNode, 'width' | 'height'>) => ViewNode): void {
    const { circuit } = this.level;
    const box = own.size > 0 ? this.bounds() : null;
    for (const [id, title, at] of [[inputs_node, 'Inputs', circuit.inputs_at], [outputs_node, 'Outputs', circuit.outputs_at]] as const) {
      const template = own.get(id);
      if (!template || !box) continue;
      const node = { id, title, subtitle: '', note: '', lsi: null, x: 0, y: 0, ...this.wired_pins(id, template) };
      const { width, height } = size_of(node);
      const x = at?.[0] ?? (id === inputs_node ? box.x - width - 80 : box.x + box.width + 80);
      const y = at?.[1] ?? Math.round((box.y + (box.height - height) / 2) / grid) * grid;
      this.nodes.push(put({ ...node, x, y }));
    }
  }

  /** Pins of node `id` with what is wired marked; those of a missing LSI are the ones that its wires name. */
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
  /** Wires at a node. */
  at_node(id: string): readonly ViewWire[] {
    return this.by_node.get(id) ?? [];
  }
  /** Wires at a pin. */
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

  /** Box around what is called `ids`; without them around everything. */
  bounds(ids?: ReadonlySet<string>): Box {
    if (!ids && this.whole) return this.whole;
    const box = this.find_bounds(ids);
    if (!ids && this.index) this.whole = box; // while it is made, its own pins are missing
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

/** A pin of a missing LSI is what its wires say. */
function pin_in(template: Template | undefined, side: 'in' | 'out', name: string): PinInfo | undefined {
  if (!template) return undefined;
  if (template.kind === 'missing') return own_info({ name, type: 'any' }, side);
  return (side === 'in' ? template.inputs : template.outputs).find((p) => p.name === name);
}

function words_of(lsi: Lsi): { title: string; subtitle: string; note: string } {
  const title = lsi.label || lsi.id;
  return { title, subtitle: lsi.type === title ? '' : lsi.type, note: lsi.note ?? '' };
}

const same_node = (a: ViewNode, b: ViewNode): boolean =>
  a.lsi === b.lsi && a.kind === b.kind && a.title === b.title && a.subtitle === b.subtitle && a.doc === b.doc && a.x === b.x && a.y === b.y && same_pins(a.inputs, b.inputs) && same_pins(a.outputs, b.outputs);
