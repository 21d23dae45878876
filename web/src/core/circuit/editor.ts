/** The wiring editor: what is looked at, selected and being done, and every edit as one command. Framework-free; React only draws it. */
import { createStore, type StoreApi } from 'zustand/vanilla';
import type { Problem } from '../protocol';
import { can_stop_at } from './breakpoints';
import type { ClassList } from './classes';
import * as edits from './edits';
import type { CircuitCommand, Clip } from './edits';
import { pins_that_fit, same_pin, why_not, type PinAt } from './fits';
import { reconcile, split_end, type Circuit, type Point, type Value } from './form';
import { describe_node, describe_pin, first_pin, next_node, next_pin, type Direction } from './navigate';
import { place_problems, place_stops, problems_at, split_flat, type CircuitProblem } from './problems';
import { enter, find_circuit, grid, inputs_node, note_id, outputs_node, View, type Level, type ViewWire } from './view';

export interface EditorState {
  view: View | null;
  /** The project has a circuit of its own; false: what is shown is generated. */
  edited: boolean;
  path: readonly string[];
  nodes: ReadonlySet<string>;
  wires: ReadonlySet<string>;
  /** Where the keyboard is. */
  cursor: string | null;
  pin: PinAt | null;
  /** The pin that a wire is being drawn from, and where it would end. */
  connecting: PinAt | null;
  target: PinAt | null;
  search: { at: Point; screen: { x: number; y: number }; fits?: PinAt } | null;
  /** The output ("arm/elbow.out") whose condition for stopping is being asked for. */
  stopping: { flat: string; type: string; unit: string; screen: { x: number; y: number } } | null;
  /** Why a wire was refused. */
  refusal: { text: string; screen: { x: number; y: number } } | null;
  problems: readonly CircuitProblem[];
  /** Whose title or text is being typed. */
  typing: string | null;
  /** For screen readers. */
  said: string;
}

export interface EditorHost {
  edit(command: CircuitCommand | { type: 'circuit.set'; circuit: Circuit | null }): Promise<boolean>;
  notify(text: string): void;
}

const none: ReadonlySet<string> = new Set();

export class CircuitEditor {
  readonly store: StoreApi<EditorState>;
  private circuit: Circuit | null = null;
  private raw: Circuit | null = null;
  private classes: ClassList | null = null;
  private told: readonly Problem[] = [];
  private stops: readonly Problem[] = [];
  /** Places while nodes are dragged; what draws wires looks here first. */
  drag: ReadonlyMap<string, Point> | null = null;
  private clip: Clip | null = null;

  constructor(private readonly host: EditorHost) {
    this.store = createStore<EditorState>(() => ({
      view: null, edited: false, path: [], nodes: none, wires: none, cursor: null, pin: null, connecting: null, target: null, search: null, stopping: null, refusal: null, problems: [], typing: null, said: '',
    }));
  }

  get state(): EditorState {
    return this.store.getState();
  }
  get view(): View | null {
    return this.state.view;
  }
  private set(part: Partial<EditorState>): void {
    this.store.setState(part);
  }

  // ---- what is shown ----

  /** The circuit as the project has it, or as it is generated. */
  show(circuit: Circuit | null, edited: boolean, classes: ClassList, problems: readonly Problem[], stops: readonly Problem[] = []): void {
    if (circuit === this.raw && classes === this.classes && problems === this.told && stops === this.stops && edited === this.state.edited) return;
    const next = circuit && reconcile(this.circuit, circuit);
    const same = next === this.circuit && classes === this.classes && this.state.view !== null;
    this.raw = circuit;
    this.classes = classes;
    this.circuit = next;
    this.told = problems;
    this.stops = stops;
    if (problems.length + stops.length + this.state.problems.length > 0) this.set({ problems: next ? [...place_problems(next, problems), ...place_stops(next, stops)] : [] });
    if (edited !== this.state.edited) this.set({ edited });
    if (!same) this.look(this.state.path);
  }

  private look(path: readonly string[]): void {
    if (!this.circuit || !this.classes) return this.set({ view: null });
    const level = enter(this.circuit, path);
    const before = this.state.view;
    const same_place = before && before.level.path.join('/') === level.path.join('/');
    const view = new View(level, this.classes, same_place ? before : undefined);
    const exists = (id: string): boolean => view.node(id) !== undefined || view.notes.some((n) => note_id(n.id) === id) || view.probes.some((p) => `probe:${p.pin}` === id);
    const keys = new Set(this.state.wires.size > 0 ? view.wires.map((w) => w.key) : []);
    this.set({
      view,
      path: level.path,
      nodes: same_place ? filter(this.state.nodes, exists) : none,
      wires: same_place ? filter(this.state.wires, (k) => keys.has(k)) : none,
      cursor: same_place && this.state.cursor && view.node(this.state.cursor) ? this.state.cursor : null,
      pin: same_place && this.state.pin && view.pin(this.state.pin.node, this.state.pin.side, this.state.pin.pin) ? this.state.pin : null,
      ...(same_place ? {} : { connecting: null, target: null, search: null, stopping: null, refusal: null, typing: null }),
    });
  }

  /** Goes inside the circuit that LSI `id` is. */
  go_inside(id: string): boolean {
    const node = this.view?.node(id);
    if (node?.kind !== 'circuit') return false;
    this.look([...this.state.path, id]);
    this.say(`Inside ${node.title}`);
    return true;
  }

  go_out(levels = 1): void {
    if (this.state.path.length === 0) return;
    const left = this.state.path[this.state.path.length - levels];
    this.look(this.state.path.slice(0, this.state.path.length - levels));
    if (left !== undefined && this.view?.node(left)) this.set({ nodes: new Set([left]), cursor: left });
    this.say(this.state.path.length === 0 ? 'The outermost circuit' : `Inside ${this.state.path.at(-1)}`);
  }

  /** Goes to where the LSI of these ids is, and selects it. */
  go_to(ids: readonly string[]): void {
    this.look(ids.slice(0, -1));
    const last = ids.at(-1);
    if (last !== undefined && this.view?.node(last)) this.select([last]);
  }

  /** Names for the way in: what is shown above the canvas. */
  get crumbs(): string[] {
    const out: string[] = [];
    let level: Level | null = this.circuit && enter(this.circuit, []);
    for (const id of this.state.path) {
      const lsi = level?.circuit.lsis?.find((l) => l.id === id);
      out.push(lsi?.label || lsi?.id || id);
      level = this.circuit && enter(this.circuit, this.state.path.slice(0, out.length));
    }
    return out;
  }

  get outermost(): Circuit | null {
    return this.circuit;
  }

  // ---- selection ----

  select(nodes: Iterable<string>, wires: Iterable<string> = []): void {
    const next = new Set(nodes);
    const next_wires = new Set(wires);
    if (same_set(next, this.state.nodes) && same_set(next_wires, this.state.wires)) return;
    const last = [...next].at(-1);
    this.set({ nodes: next, wires: next_wires, pin: null, cursor: last && this.view?.node(last) ? last : this.state.cursor });
  }
  toggle(id: string): void {
    const next = new Set(this.state.nodes);
    if (!next.delete(id)) next.add(id);
    this.select(next, this.state.wires);
  }
  select_all(): void {
    const { view } = this;
    if (view) this.select([...view.nodes.filter((n) => n.lsi).map((n) => n.id), ...view.notes.map((n) => note_id(n.id))]);
  }
  /** The one selected LSI, or null. */
  get chosen(): string | null {
    const [only] = this.state.nodes;
    return this.state.nodes.size === 1 && only !== undefined && this.view?.node(only)?.lsi ? only : null;
  }

  // ---- edits ----

  private do(command: CircuitCommand | null): boolean {
    if (!command) return false;
    void this.host.edit(command);
    return true;
  }
  private with<T>(edit: (view: View) => T): T | null {
    return this.view ? edit(this.view) : null;
  }

  add(type: string, at: Point, wire_to?: PinAt): string | null {
    const made = this.with((view) => edits.add_lsi(view, type, at, wire_to));
    if (!made) return null;
    this.do(made.command);
    this.select([made.id]);
    this.say(`Added ${type}`);
    return made.id;
  }
  add_note(at: Point): void {
    const made = this.with((view) => edits.add_note(view, at));
    if (!made) return;
    this.do(made.command);
    this.select([note_id(made.id)]);
    this.set({ typing: note_id(made.id) });
  }
  /** What the search found, at the place where the search was opened. */
  choose(type: string, kind: 'class' | 'circuit' | 'note'): void {
    const { search } = this.state;
    this.set({ search: null });
    if (!search) return;
    if (kind === 'note') this.add_note(search.at);
    else this.add(type, search.at, search.fits);
  }
  move(places: ReadonlyMap<string, Point>): void {
    this.with((view) => this.do(edits.move(view, places)));
  }
  /** Moves the selection by steps of the grid. */
  nudge(dx: number, dy: number): void {
    const { view } = this;
    if (!view) return;
    const places = new Map<string, Point>();
    for (const id of this.state.nodes) {
      const at = this.place_of(id);
      if (at) places.set(id, [at[0] + dx * grid, at[1] + dy * grid]);
    }
    this.do(edits.move(view, places));
  }
  /** Corner of a node, note or probe as the circuit has it. */
  place_of(id: string): Point | null {
    const { view } = this;
    const node = view?.node(id);
    if (node) return [node.x, node.y];
    return view?.notes.find((n) => note_id(n.id) === id)?.at ?? view?.probes.find((p) => `probe:${p.pin}` === id)?.at ?? null;
  }
  remove(): void {
    const { nodes, wires } = this.state;
    this.with((view) => this.do(edits.remove(view, { nodes, wires })));
  }
  disconnect(wires: readonly ViewWire[]): void {
    this.with((view) => this.do(edits.disconnect(view, wires)));
  }
  rename(id: string, label: string): void {
    this.with((view) => label.trim() !== view.node(id)?.title && this.do(edits.rename(view, id, label.trim())));
  }
  comment(id: string, note: string): void {
    this.with((view) => note !== view.node(id)?.note && this.do(edits.set_lsi(view, id, { note }, note ? `Comment on “${view.node(id)?.title}”` : 'Remove comment')));
  }
  write_note(id: string, text: string): void {
    this.with((view) => view.notes.find((n) => n.id === id)?.text !== text && this.do(edits.set_note(view, id, { text })));
  }
  size_note(id: string, at: Point, size: Point): void {
    this.with((view) => this.do(edits.set_note(view, id, { at: edits.snap(at, true), size: edits.snap(size, true) }, 'Resize note')));
  }
  set_parameter(id: string, name: string, value: Value | undefined): void {
    this.with((view) => this.do(edits.set_parameter(view, id, name, value)));
  }
  set_value(id: string, pin: string, value: Value | undefined): void {
    this.with((view) => this.do(edits.set_value(view, id, pin, value)));
  }
  set_every(id: string, every: number): void {
    this.with((view) => this.do(edits.set_lsi(view, id, { every }, `Set rate of “${view.node(id)?.title}”`)));
  }
  /** The output that an input gets its values from; an output is its own. */
  private source_of(pin: PinAt): PinAt {
    const wire = pin.side === 'in' ? this.view?.at_pin(pin.node, 'in', pin.pin)[0] : undefined;
    return wire ? { node: wire.from, side: 'out', pin: wire.from_pin } : pin;
  }
  toggle_probe(pin: PinAt): void {
    const { view } = this;
    const at = this.source_of(pin);
    const node = view?.node(at.node);
    if (!view || !node?.lsi || at.side === 'in') return;
    this.do(edits.toggle_probe(view, `${at.node}.${at.pin}`, [node.x + node.width + 40, node.y - 120]));
  }
  set_probe(pin: string, components: number[] | undefined): void {
    this.with((view) => this.do(edits.set_probe(view, pin, { components })));
  }
  rename_pin(side: 'inputs' | 'outputs', name: string, to: string): void {
    this.with((view) => this.do(edits.rename_own_pin(view, side, name, to.trim())));
  }
  remove_pin(side: 'inputs' | 'outputs', name: string): void {
    this.with((view) => this.do(edits.remove_own_pin(view, side, name)));
  }
  group(): void {
    const made = this.with((view) => edits.group(view, this.state.nodes));
    if (!made) return this.host.notify('Select LSIs to group; those that are missing cannot be grouped.');
    this.do(made.command);
    this.select([made.id]);
    this.say('Grouped');
  }
  ungroup(): void {
    const { chosen } = this;
    const made = chosen ? this.with((view) => edits.ungroup(view, chosen)) : null;
    if (!made) return this.host.notify('Select one circuit to ungroup.');
    this.do(made.command);
    this.select(made.nodes);
    this.say('Ungrouped');
  }
  /** What the clipboard gets, or null. */
  copy(): string | null {
    this.clip = this.with((view) => edits.copy(view, this.state.nodes));
    return this.clip && JSON.stringify(this.clip);
  }
  paste(at: Point, text?: string): void {
    const clip = (text && edits.read_clip(text)) || this.clip;
    if (clip) this.put(clip, at, 'Paste');
  }
  duplicate(): void {
    const clip = this.with((view) => edits.copy(view, this.state.nodes));
    if (!clip || !this.view) return;
    const places = [...clip.lsis.map((l) => l.at ?? [0, 0]), ...clip.notes.map((n) => n.at)];
    this.put(clip, [Math.min(...places.map((p) => p[0]!)) + 40, Math.min(...places.map((p) => p[1]!)) + 40], 'Duplicate');
  }
  private put(clip: Clip, at: Point, label: string): void {
    const made = this.with((view) => edits.paste(view, clip, at, label));
    if (!made) return;
    this.do(made.command);
    this.select(made.nodes);
  }
  lay_out(places: ReadonlyMap<string, Point>): void {
    this.with((view) => this.do(edits.move(view, places, 'Lay out')));
  }
  reset_to_generated(): void {
    if (this.state.edited) void this.host.edit({ type: 'circuit.set', circuit: null });
  }

  // ---- wires ----

  begin_wire(pin: PinAt): void {
    this.set({ connecting: pin, target: null, refusal: null });
  }
  /** null: the wire is allowed; otherwise the reason. */
  judge(to: PinAt): string | null {
    const { connecting } = this.state;
    return connecting && this.view ? why_not(this.view, connecting, to) : null;
  }
  refuse(text: string, screen: { x: number; y: number }): void {
    this.set({ refusal: { text, screen } });
    this.say(text);
  }
  forget_refusal(): void {
    if (this.state.refusal) this.set({ refusal: null });
  }
  /** Ends the wire at a pin. @return why it was refused, or null */
  end_wire(from: PinAt, to: PinAt, instead?: ViewWire): string | null {
    const { view } = this;
    this.set({ connecting: null, target: null });
    if (!view) return null;
    if (instead && same_pin(to, from.side === 'out' ? { node: instead.to, side: 'in', pin: instead.to_pin } : { node: instead.from, side: 'out', pin: instead.from_pin })) return null;
    const reason = why_not(view, from, to);
    if (reason === null) {
      this.do(edits.connect(view, from, to, instead));
      this.say('Wired');
    }
    return reason;
  }
  cancel_wire(): void {
    if (this.state.connecting) this.set({ connecting: null, target: null });
  }
  open_search(at: Point, screen: { x: number; y: number }, fits?: PinAt): void {
    this.set({ search: { at, screen, fits }, connecting: null, target: null });
  }
  close_search(): void {
    this.set({ search: null });
  }
  /** What a breakpoint at this pin would look at; null: nothing that can be compared. */
  stop_source(pin: PinAt): { flat: string; type: string; unit: string } | null {
    const at = this.source_of(pin);
    const info = at.side === 'out' ? this.view?.pin(at.node, 'out', at.pin) : undefined;
    const flat = info && can_stop_at(info.type) ? this.flat_output(at.node, at.pin) : null;
    return info && flat ? { flat, type: info.type, unit: info.unit ?? '' } : null;
  }
  ask_stop(pin: PinAt, screen: { x: number; y: number }): void {
    const source = this.stop_source(pin);
    if (source) this.set({ stopping: { ...source, screen } });
    else this.host.notify('A run can be stopped at outputs that carry numbers.');
  }
  close_stop(): void {
    this.set({ stopping: null });
  }
  /** "Gain · out" of "arm/gain.out". */
  name_of(flat: string): string {
    const [ids, pin] = split_flat(flat);
    const path = ids.split('/');
    const lsi = this.circuit && enter(this.circuit, path.slice(0, -1)).circuit.lsis?.find((l) => l.id === path.at(-1));
    return `${lsi?.label || ids} · ${pin}`;
  }
  type_in(id: string | null): void {
    this.set({ typing: id });
  }

  // ---- problems ----

  problems_of(id: string): CircuitProblem[] {
    return problems_at(this.state.problems, this.state.path, id);
  }
  /** Puts a delay into the last wire of the circle that `problem` names, at the level where it is. */
  insert_delay(problem: CircuitProblem): void {
    const step = problem.loop.at(-1);
    if (!step || !this.circuit || !this.classes) return;
    // the level that both ends share
    const [from, from_pin] = split_flat(step.from);
    const [to, to_pin] = split_flat(step.to);
    const a = from.split('/');
    const b = to.split('/');
    let depth = 0;
    while (depth < a.length - 1 && depth < b.length - 1 && a[depth] === b[depth]) depth++;
    const path = a.slice(0, depth);
    if (path.join('/') !== this.state.path.join('/')) this.look(path);
    const { view } = this;
    const wire = view?.wires.find((w) => w.from === a[depth] && w.to === b[depth] && (a.length > depth + 1 || w.from_pin === from_pin) && (b.length > depth + 1 || w.to_pin === to_pin));
    const made = view && wire && edits.insert_delay(view, wire, this.classes);
    if (!made) return this.host.notify('There is no delay for this type; break the circle by hand.');
    this.do(made.command);
    this.select([made.id]);
  }

  // ---- keyboard ----

  say(text: string): void {
    this.set({ said: text });
  }

  /** An arrow key: from node to node, or from pin to pin, or among the pins at which a wire may end. */
  go(direction: Direction): void {
    const { view, state } = this;
    if (!view) return;
    if (state.connecting) {
      const fits = pins_that_fit(view, state.connecting);
      if (fits.length === 0) return;
      const index = fits.findIndex((p) => same_pin(p, state.target));
      const step = direction === 'left' || direction === 'up' ? -1 : 1;
      const target = fits[(index + step + fits.length) % fits.length] ?? fits[0]!;
      this.set({ target, cursor: target.node });
      return this.say(describe_pin(view, target));
    }
    if (state.pin) {
      const pin = next_pin(view, state.pin, direction);
      if (!pin) return;
      this.set({ pin, cursor: pin.node });
      return this.say(describe_pin(view, pin));
    }
    const [only] = state.nodes;
    const id = next_node(view, state.cursor ?? only ?? null, direction);
    if (id === null) return;
    this.set({ cursor: id, nodes: new Set([id]), wires: none });
    this.say(describe_node(view.node(id)!));
  }

  /** Enter: into the pins of a node; begins a wire at a pin; ends it. */
  enter_key(): void {
    const { view, state } = this;
    if (!view) return;
    if (state.connecting) {
      if (!state.target) return;
      const from = state.connecting;
      const to = state.target;
      const reason = this.end_wire(from, to);
      this.set({ pin: to, cursor: to.node });
      if (reason) this.say(reason);
      return;
    }
    if (state.pin) {
      const fits = pins_that_fit(view, state.pin);
      this.begin_wire(state.pin);
      if (fits[0]) this.set({ target: fits[0] });
      return this.say(fits[0] ? `Wire to: ${describe_pin(view, fits[0])}` : 'Nothing here fits; press Tab to add what does');
    }
    const [only] = state.nodes;
    const node = state.cursor ?? only;
    const pin = node ? first_pin(view, node) : null;
    if (!pin) return;
    this.set({ pin, cursor: pin.node });
    this.say(describe_pin(view, pin));
  }

  /** @return whether there was something to leave */
  escape(): boolean {
    const { state } = this;
    if (state.search) this.close_search();
    else if (state.typing) this.type_in(null);
    else if (state.connecting) this.cancel_wire();
    else if (state.pin) this.set({ pin: null });
    else if (state.nodes.size + state.wires.size > 0) this.select([]);
    else return false;
    return true;
  }

  /** Names of what runs behind an output of this level: what the service is asked for. */
  flat_output(id: string, pin: string): string | null {
    return this.circuit && this.view ? flat_source(this.circuit, this.view.level, id, pin) : null;
  }
}

/** "arm/elbow.out" behind output `pin` of node `id`: through the circuits that it leads into or out of. */
export function flat_source(top: Circuit, level: Level, id: string, pin: string, depth = 0): string | null {
  if (depth > 64 || id === outputs_node) return null;
  if (id === inputs_node) {
    if (level.path.length === 0) return `input:${pin}.value`;
    const outer = enter(top, level.path.slice(0, -1));
    const own = level.path.at(-1)!;
    const wire = outer.circuit.wires?.find((w) => w.to === `${own}.${pin}`);
    if (wire) return flat_source(top, outer, ...split_end(wire.from), depth + 1);
    const through = outer.circuit.inputs?.find((p) => [p.to ?? []].flat().includes(`${own}.${pin}`));
    return through ? flat_source(top, outer, inputs_node, through.name, depth + 1) : null;
  }
  const lsi = level.circuit.lsis?.find((l) => l.id === id);
  if (!lsi) return null;
  if (!find_circuit(level, lsi.type)) return [...level.path, `${id}.${pin}`].join('/');
  const inner = enter(top, [...level.path, id]);
  const from = [inner.circuit.outputs?.find((p) => p.name === pin)?.from ?? []].flat()[0];
  return from && inner.path.length > level.path.length ? flat_source(top, inner, ...split_end(from), depth + 1) : null;
}

const filter = (set: ReadonlySet<string>, keep: (id: string) => boolean): ReadonlySet<string> => {
  const kept = [...set].filter(keep);
  return kept.length === set.size ? set : new Set(kept);
};
const same_set = (a: ReadonlySet<string>, b: ReadonlySet<string>): boolean => a.size === b.size && [...a].every((id) => b.has(id));
