/** The text form of circuits (docs/circuit.md) and changes of it (docs/scenario.md, circuit.edit). Nothing here alters what it is given. */

export type Value = number | boolean | string | number[];
export type Point = [number, number];

export interface Lsi {
  id: string;
  type: string;
  label?: string;
  note?: string;
  at?: Point;
  every?: number;
  parameters?: Record<string, Value>;
  values?: Record<string, Value>;
}

export interface Wire {
  from: string;
  to: string;
}

/** A pin of the circuit itself: inputs lead `to` pins inside, outputs come `from` one. */
export interface OwnPin {
  name: string;
  type: string;
  unit?: string;
  doc?: string;
  to?: string | string[];
  from?: string | string[];
}

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

/** `in`: names of circuits from the outermost one inwards. */
export type Change = { in?: string[] } & (
  | { [L in ListName]: { list: L; put: Items[L] } }[ListName]
  | { list: Exclude<ListName, 'wires'>; take: string }
  | { list: 'wires'; take: Wire }
  | { set: Settings }
);

/** What makes an item of `list` itself. */
export function key_of(list: ListName, item: unknown): string {
  if (typeof item === 'string') return item;
  const fields = item as Record<string, string>;
  if (list === 'wires') return `${fields.from}\n${fields.to}`;
  if (list === 'lsis' || list === 'notes') return fields.id!;
  return list === 'probes' ? fields.pin! : fields.name!;
}

/** [id, pin] of "id.pin". */
export function split_end(end: string): [string, string] {
  const dot = end.indexOf('.');
  return dot < 0 ? [end, ''] : [end.slice(0, dot), end.slice(dot + 1)];
}

export const ends_of = (ends: string | string[] | undefined): string[] => (ends === undefined ? [] : Array.isArray(ends) ? ends : [ends]);

/** One end as itself, several as a list: how the form writes them. */
export const write_ends = (ends: string[]): string | string[] => (ends.length === 1 ? ends[0]! : ends);

/** The LSI with its fields in the form's order and without those that say nothing. */
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

/** More changes of a list than this are worth an index of it. */
const most_scans = 12;

/** A list while it is changed. */
class OpenList {
  readonly items: (unknown | null)[];
  private readonly places: Map<string, number> | null;
  constructor(
    private readonly list: ListName,
    items: readonly unknown[],
    indexed: boolean,
  ) {
    this.items = [...items];
    this.places = indexed ? new Map(items.map((item, i) => [key_of(list, item), i])) : null;
  }
  private find(item: unknown): number {
    if (this.places) return this.places.get(key_of(this.list, item)) ?? -1;
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
      this.places?.set(key_of(this.list, item), this.items.length);
      this.items.push(item);
    }
  }
  take(item: unknown): void {
    const at = this.find(item);
    if (at < 0) return;
    this.items[at] = null;
    this.places?.delete(key_of(this.list, item));
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
      list = new OpenList(change.list, (out[change.list] as unknown[] | undefined) ?? [], counts.get(change.list)! > most_scans);
      open.set(change.list, list);
    }
    if ('put' in change) list.put(change.put);
    else list.take(change.take);
  }
  for (const [name, list] of open) out[name] = list.items.filter((item) => item !== null);
  return out as unknown as Circuit;
}

/** The circuit after `changes`, as the service will have it. What cannot be found is left out: the service refuses it. */
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

/** Equal as data, in any order of fields. */
function equal(a: unknown, b: unknown): boolean {
  if (a === b) return true;
  if (typeof a !== 'object' || typeof b !== 'object' || a === null || b === null || Array.isArray(a) !== Array.isArray(b)) return false;
  const [x, y] = [a as Record<string, unknown>, b as Record<string, unknown>];
  const keys = Object.keys(x);
  return keys.length === Object.keys(y).length && keys.every((k) => k in y && equal(x[k], y[k]));
}

/** `next`, with every item that is equal to one of `before` being that very object: what did not change need not be drawn again. */
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
      if (item === old[i] || equal(item, old[i])) return old[i]; // in its place, as nearly always
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

/** An id that `taken` does not have, from a name: "low-pass", "low-pass-2". */
export function fresh_id(name: string, taken: { has(id: string): boolean }): string {
  const base = name.replace(/[^A-Za-z0-9_-]+/g, '-').replace(/^-+|-+$/g, '').slice(0, 48) || 'lsi';
  let id = base;
  for (let n = 2; taken.has(id); n++) id = `${base}-${n}`;
  return id;
}

export function fresh_name(name: string, taken: { has(name: string): boolean }): string {
  let free = name;
  for (let n = 2; taken.has(free); n++) free = `${name} ${n}`;
  return free;
}
