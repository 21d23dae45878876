/**
 * The JSON form of circuits (docs/circuit.md) and changes to it (docs/scenario.md, circuit.edit). No function here modifies its arguments.
 */

export type Value = number | boolean | string | number[];
export type Point = [number, number];

export interface Lsi {
  id: string;
  /** Name of an LSI class or of a circuit. */
  type: string;
  label?: string;
  note?: string;
  /** Upper left corner in the circuit's plane, px. */
  at?: Point;
  /** The LSI runs every n-th tick; absent: every tick; 0: on demand. */
  every?: number;
  parameters?: Record<string, Value>;
  /** Values of inputs that are not wired. */
  values?: Record<string, Value>;
}

/** A wire; its ends are "id.pin". */
export interface Wire {
  from: string;
  to: string;
}

/** A pin of the circuit itself. An input feeds the pins `to` inside the circuit; an output takes its value `from` a pin inside. */
export interface OwnPin {
  name: string;
  type: string;
  unit?: string;
  doc?: string;
  to?: string | string[];
  from?: string | string[];
}

/** A parameter of the circuit itself; it sets the parameters `to` ("id.name") of LSIs inside. */
export interface OwnParameter {
  name: string;
  doc?: string;
  to: string | string[];
}

export interface Note {
  id: string;
  text: string;
  at: Point;
  size?: Point;
}

export interface Probe {
  pin: string;
  at: Point;
  components?: number[];
}

export interface Circuit {
  version?: number;
  name: string;
  doc?: string;
  inputs_at?: Point;
  outputs_at?: Point;
  inputs?: OwnPin[];
  outputs?: OwnPin[];
  parameters?: OwnParameter[];
  lsis?: Lsi[];
  wires?: Wire[];
  notes?: Note[];
  probes?: Probe[];
  circuits?: Circuit[];
}

interface Items {
  inputs: OwnPin;
  outputs: OwnPin;
  parameters: OwnParameter;
  lsis: Lsi;
  wires: Wire;
  notes: Note;
  probes: Probe;
  circuits: Circuit;
}
export type ListName = keyof Items;

export type Settings = { name?: string; doc?: string | null; inputs_at?: Point | null; outputs_at?: Point | null };

/** One change of a circuit: put or take an item of a list, or set fields. `in`: names of the nested circuits down to the changed one. */
export type Change = { in?: string[] } & (
  | { [L in ListName]: { list: L; put: Items[L] } }[ListName]
  | { list: Exclude<ListName, 'wires'>; take: string }
  | { list: 'wires'; take: Wire }
  | { set: Settings }
);

/** Key that identifies an item within `list`: an id, a name, a pin, or both ends of a wire. */
export function key_of(list: ListName, item: unknown): string {
  if (typeof item === 'string') return item;
  const fields = item as Record<string, string>;
  if (list === 'wires') return `${fields.from}\n${fields.to}`;
  if (list === 'lsis' || list === 'notes') return fields.id!;
  return list === 'probes' ? fields.pin! : fields.name!;
}

/** Splits "id.pin" into [id, pin]. */
export function split_end(end: string): [string, string] {
  const dot = end.indexOf('.');
  return dot < 0 ? [end, ''] : [end.slice(0, dot), end.slice(dot + 1)];
}

export const ends_of = (ends: string | string[] | undefined): string[] => (ends === undefined ? [] : Array.isArray(ends) ? ends : [ends]);

/** Wire ends in the JSON form of circuits: one end as text, several ends as a list. */
export const write_ends = (ends: string[]): string | string[] => (ends.length === 1 ? ends[0]! : ends);

/** A copy of the LSI with its fields in the order of the JSON form, without fields that equal their default. */
export function tidy_lsi(lsi: Lsi): Lsi {
  const out: Lsi = { id: lsi.id, type: lsi.type };
  if (lsi.label) out.label = lsi.label;
  if (lsi.note) out.note = lsi.note;
  if (lsi.at && (lsi.at[0] !== 0 || lsi.at[1] !== 0)) out.at = lsi.at;
  if (lsi.every !== undefined && lsi.every !== 1) out.every = lsi.every;
  if (lsi.parameters && Object.keys(lsi.parameters).length > 0) out.parameters = lsi.parameters;
  if (lsi.values && Object.keys(lsi.values).length > 0) out.values = lsi.values;
  return out;
}

const same_path = (a: string[], b: string[]): boolean => a.length === b.length && a.every((name, i) => name === b[i]);

/** If a list has more changes than this number, it is indexed by key; otherwise it is scanned for each change. */
const max_scans = 12;

/** A list while changes are applied to it; removed items become null. */
class OpenList {
  readonly items: (unknown | null)[];
  /** Index of each item by key; null: the list is scanned. */
  private readonly index_of: Map<string, number> | null;
  constructor(
    private readonly list: ListName,
    items: readonly unknown[],
    indexed: boolean,
  ) {
    this.items = [...items];
    this.index_of = indexed ? new Map(items.map((item, i) => [key_of(list, item), i])) : null;
  }
  private find(item: unknown): number {
    if (this.index_of) return this.index_of.get(key_of(this.list, item)) ?? -1;
    if (this.list === 'wires') {
      const { from, to } = item as Wire;
      return this.items.findIndex((w) => w !== null && (w as Wire).from === from && (w as Wire).to === to);
    }
    const key = key_of(this.list, item);
    return this.items.findIndex((other) => other !== null && key_of(this.list, other) === key);
  }
  put(item: unknown): void {
    const at = this.find(item);
    if (at >= 0) this.items[at] = item;
    else {
      this.index_of?.set(key_of(this.list, item), this.items.length);
      this.items.push(item);
    }
  }
  take(item: unknown): void {
    const at = this.find(item);
    if (at < 0) return;
    this.items[at] = null;
    this.index_of?.delete(key_of(this.list, item));
  }
}

function apply_here(circuit: Circuit, changes: readonly Change[]): Circuit {
  const out = { ...circuit } as unknown as Record<string, unknown>;
  const open = new Map<ListName, OpenList>();
  const counts = new Map<ListName, number>();
  for (const change of changes) if ('list' in change) counts.set(change.list, (counts.get(change.list) ?? 0) + 1);
  for (const change of changes) {
    if ('set' in change) {
      for (const [field, value] of Object.entries(change.set)) {
        if (value === null) delete out[field];
        else out[field] = value;
      }
      continue;
    }
    let list = open.get(change.list);
    if (!list) {
      list = new OpenList(change.list, (out[change.list] as unknown[] | undefined) ?? [], counts.get(change.list)! > max_scans);
      open.set(change.list, list);
    }
    if ('put' in change) list.put(change.put);
    else list.take(change.take);
  }
  for (const [name, list] of open) out[name] = list.items.filter((item) => item !== null);
  return out as unknown as Circuit;
}

/** The circuit after `changes`. A change whose item or circuit does not exist has no effect here; the service refuses it. */
export function apply_changes(circuit: Circuit, changes: readonly Change[]): Circuit {
  let out = circuit;
  for (let i = 0; i < changes.length; ) {
    const path = changes[i]!.in ?? [];
    let end = i + 1;
    while (end < changes.length && same_path(changes[end]!.in ?? [], path)) end++;
    const part = changes.slice(i, end);
    const descend = (at: Circuit, names: string[]): Circuit => {
      if (names.length === 0) return apply_here(at, part);
      return { ...at, circuits: (at.circuits ?? []).map((c) => (c.name === names[0] ? descend(c, names.slice(1)) : c)) };
    };
    out = descend(out, path);
    i = end;
  }
  return out;
}

/** Deep equality; the order of an object's fields does not matter. */
function equal(a: unknown, b: unknown): boolean {
  if (a === b) return true;
  if (typeof a !== 'object' || typeof b !== 'object' || a === null || b === null || Array.isArray(a) !== Array.isArray(b)) return false;
  const [x, y] = [a as Record<string, unknown>, b as Record<string, unknown>];
  const keys = Object.keys(x);
  return keys.length === Object.keys(y).length && keys.every((k) => k in y && equal(x[k], y[k]));
}

/** Returns `next` with each item that equals an item of `before` replaced by that object, so that unchanged items are not drawn again. */
export function reconcile(before: Circuit | null, next: Circuit): Circuit {
  if (!before || before === next) return next;
  const out = { ...next } as unknown as Record<string, unknown>;
  for (const list of ['inputs', 'outputs', 'parameters', 'lsis', 'wires', 'notes', 'probes'] as const) {
    const items = next[list] as unknown[] | undefined;
    const old = before[list] as unknown[] | undefined;
    if (!items || !old) continue;
    if (items === old) continue;
    let by_key: Map<string, unknown> | null = null;
    let all = items.length === old.length;
    const kept = items.map((item, i) => {
      if (item === old[i] || equal(item, old[i])) return old[i]; // usual case: the equal item has the same index in both lists
      const twin = (by_key ??= new Map(old.map((o) => [key_of(list, o), o]))).get(key_of(list, item));
      all = false;
      return twin !== undefined && equal(twin, item) ? twin : item;
    });
    out[list] = all ? old : kept;
  }
  if (next.circuits && before.circuits) {
    const by_name = new Map(before.circuits.map((c) => [c.name, c]));
    const inner = next.circuits.map((c) => reconcile(by_name.get(c.name) ?? null, c));
    const all = inner.length === before.circuits.length && inner.every((c, i) => c === before.circuits![i]);
    out.circuits = all ? before.circuits : inner;
  }
  const fields = before as unknown as Record<string, unknown>;
  const names = Object.keys(out);
  const same = names.length === Object.keys(fields).length && names.every((name) => out[name] === fields[name] || (name.endsWith('_at') && equal(out[name], fields[name])));
  return same ? before : (out as unknown as Circuit);
}

/** An unused id made from a name: "low-pass", "low-pass-2". @param taken the ids in use */
export function fresh_id(name: string, taken: { has(id: string): boolean }): string {
  const base = name.replace(/[^A-Za-z0-9_-]+/g, '-').replace(/^-+|-+$/g, '').slice(0, 48) || 'lsi';
  let id = base;
  for (let n = 2; taken.has(id); n++) id = `${base}-${n}`;
  return id;
}

/** An unused name: "group", "group 2". @param taken the names in use */
export function fresh_name(name: string, taken: { has(name: string): boolean }): string {
  let free = name;
  for (let n = 2; taken.has(free); n++) free = `${name} ${n}`;
  return free;
}
