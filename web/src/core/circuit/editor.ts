/** The wiring editor: the shown level, selection, gestures, and every edit as one command. Framework-free; React only draws its state. */
import { createStore, type StoreApi } from 'zustand/vanilla';
import type { Problem } from '../protocol';
import { can_stop_at } from './breakpoints';
import type { ClassList } from './classes';
import * as edits from './edits';
import type { CircuitCommand, Clip } from './edits';
import { pins_that_fit, same_pin, why_not, type PinAt } from './fits';
import { reconcile, split_end, type Circuit, type Point, type Value } from './form';
import { describe_node, describe_pin, first_pin, next_node, next_pin, type Direction } from './navigate';
import { locate_problems, locate_stops, problems_at, split_flat, type CircuitProblem } from './problems';
import { enter, find_circuit, grid, inputs_node, note_id, outputs_node, View, type Level, type ViewWire } from './view';

export interface EditorState {
  view: View | null;
  /** True: the project has a circuit of its own. False: the generated circuit is shown. */
  edited: boolean;
  /** Ids of the entered LSIs, from the outermost circuit inwards. */
  path: readonly string[];
  /** Ids of the selected nodes. */
  nodes: ReadonlySet<string>;
  /** Keys of the selected wires. */
  wires: ReadonlySet<string>;
  /** Id of the node that has the keyboard cursor. */
  cursor: string | null;
  /** The pin with the keyboard cursor; null: the cursor is on a node. */
  pin: PinAt | null;
  /** The pin at which a wire was started, and the pin at which it would end. */
  connecting: PinAt | null;
  target: PinAt | null;
  /** The open search: where to add the result in the circuit's plane, and where to show the search on the page, px. */
  search: { at: Point; screen: { x: number; y: number }; fits?: PinAt } | null;
  /** The output, with its path ("arm/elbow.out"), for which the breakpoint dialog is open. */
  stopping: { flat: string; type: string; unit: string; screen: { x: number; y: number } } | null;
  /** Reason why a wire was refused, and where to show it on the page, px. */
  refusal: { text: string; screen: { x: number; y: number } } | null;
  problems: readonly CircuitProblem[];
  /** Id of the node or note whose text is being typed. */
  typing: string | null;
  /** The text that screen readers read aloud. */
  announcement: string;
}

export interface EditorHost {
  edit(command: CircuitCommand | { type: 'circuit.set'; circuit: Circuit | null }): Promise<boolean>;
  notify(text: string): void;
}

const none: ReadonlySet<string> = new Set();

export class CircuitEditor {
  readonly store: StoreApi<EditorState>;
  /** The outermost circuit. Items that did not change are the same objects as in the previous version. */
  private circuit: Circuit | null = null;
  /** The outermost circuit, exactly as it was passed to show(). */
  private raw: Circuit | null = null;
  private classes: ClassList | null = null;
  /** The problems that were passed to the last show(). */
  private shown_problems: readonly Problem[] = [];
  private stops: readonly Problem[] = [];
  /** Positions of dragged nodes by id. Wires are drawn to these positions instead of the nodes' own. Null: no drag. */
  drag: ReadonlyMap<string, Point> | null = null;
  /** The selection that was copied last; null: none. */
  private clip: Clip | null = null;

  constructor(private readonly host: EditorHost) {
    this.store = createStore<EditorState>(() => ({
      view: null, edited: false, path: [], nodes: none, wires: none, cursor: null, pin: null, connecting: null, target: null, search: null, stopping: null, refusal: null, problems: [], typing: null, announcement: '',
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

  // ---- the shown level ----

  /** Sets the circuit to show. @param edited true: the circuit is the project's own, not the generated one  @param stops problems that stopped the run */
  show(circuit: Circuit | null, edited: boolean, classes: ClassList, problems: readonly Problem[], stops: readonly Problem[] = []): void {
    if (circuit === this.raw && classes === this.classes && problems === this.shown_problems && stops === this.stops && edited === this.state.edited) return;
    const next = circuit && reconcile(this.circuit, circuit);
    const same = next === this.circuit && classes === this.classes && this.state.view !== null;
    this.raw = circuit;
    this.classes = classes;
    this.circuit = next;
    this.shown_problems = problems;
    this.stops = stops;
    if (problems.length + stops.length + this.state.problems.length > 0) this.set({ problems: next ? [...locate_problems(next, problems), ...locate_stops(next, stops)] : [] });
    if (edited !== this.state.edited) this.set({ edited });
    if (!same) this.look(this.state.path);
  }

  /** Shows the circuit at `path` (empty: the outermost circuit). The selection is kept if this circuit is already shown. */
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

  /** Shows the circuit inside the LSI `id`. @return false if this LSI is not a circuit */
  go_inside(id: string): boolean {
    const node = this.view?.node(id);
    if (node?.kind !== 'circuit') return false;
    this.look([...this.state.path, id]);
    this.announce(`Inside ${node.title}`);
    return true;
  }

  /** Shows the circuit that is `levels` levels further out, and selects the node that was left. */
  go_out(levels = 1): void {
    if (this.state.path.length === 0) return;
    const left = this.state.path[this.state.path.length - levels];
    this.look(this.state.path.slice(0, this.state.path.length - levels));
    if (left !== undefined && this.view?.node(left)) this.set({ nodes: new Set([left]), cursor: left });
    this.announce(this.state.path.length === 0 ? 'The outermost circuit' : `Inside ${this.state.path.at(-1)}`);
  }

  /** Shows the level of an LSI and selects it. @param ids ids of the LSI and of its enclosing LSIs, from the outermost circuit inwards */
  go_to(ids: readonly string[]): void {
    this.look(ids.slice(0, -1));
    const last = ids.at(-1);
    if (last !== undefined && this.view?.node(last)) this.select([last]);
  }

  /** Titles of the entered LSIs, shown as breadcrumbs above the canvas. */
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
  /** The selected LSI if exactly one is selected, otherwise null. */
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

  /** Adds an LSI, wired to the pin `wire_to` if one of its pins fits. @return its id */
  add(type: string, at: Point, wire_to?: PinAt): string | null {
    const made = this.with((view) => edits.add_lsi(view, type, at, wire_to));
    if (!made) return null;
    this.do(made.command);
    this.select([made.id]);
    this.announce(`Added ${type}`);
    return made.id;
  }
  add_note(at: Point): void {
    const made = this.with((view) => edits.add_note(view, at));
    if (!made) return;
    this.do(made.command);
    this.select([note_id(made.id)]);
    this.set({ typing: note_id(made.id) });
  }
  /**
   * Closes the search and adds the chosen class, circuit or note at the position where the search was opened.
   * A class or circuit is also wired to the pin from which the search was opened, if there is one.
   */
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
  /** Moves the selection. @param dx, dy grid steps */
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
  /** Upper left corner of a node, note or probe, ignoring a drag; null if it does not exist. */
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
  /** @param every the LSI runs every n-th tick; 0: on demand */
  set_every(id: string, every: number): void {
    this.with((view) => this.do(edits.set_lsi(view, id, { every }, `Set rate of “${view.node(id)?.title}”`)));
  }
  /** The output that feeds an input; an output is returned unchanged. */
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
    if (!made) return this.host.notify('Select LSIs to group. Missing LSIs cannot be grouped.');
    this.do(made.command);
    this.select([made.id]);
    this.announce('Grouped');
  }
  ungroup(): void {
    const { chosen } = this;
    const made = chosen ? this.with((view) => edits.ungroup(view, chosen)) : null;
    if (!made) return this.host.notify('Select one circuit to ungroup.');
    this.do(made.command);
    this.select(made.nodes);
    this.announce('Ungrouped');
  }
  /** Copies the selection. @return text for the clipboard, or null if nothing is selected */
  copy(): string | null {
    this.clip = this.with((view) => edits.copy(view, this.state.nodes));
    return this.clip && JSON.stringify(this.clip);
  }
  /** Pastes `text`, or the last copied selection if `text` is not a circuit clip. */
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
  /** Why the started wire may not end at `to`, as a sentence; null if it may. */
  wire_refusal(to: PinAt): string | null {
    const { connecting } = this.state;
    return connecting && this.view ? why_not(this.view, connecting, to) : null;
  }
  refuse(text: string, screen: { x: number; y: number }): void {
    this.set({ refusal: { text, screen } });
    this.announce(text);
  }
  forget_refusal(): void {
    if (this.state.refusal) this.set({ refusal: null });
  }
  /** Ends a wire at a pin. @param instead existing wire whose end is moved  @return reason of a refusal, or null */
  end_wire(from: PinAt, to: PinAt, instead?: ViewWire): string | null {
    const { view } = this;
    this.set({ connecting: null, target: null });
    if (!view) return null;
    if (instead && same_pin(to, from.side === 'out' ? { node: instead.to, side: 'in', pin: instead.to_pin } : { node: instead.from, side: 'out', pin: instead.from_pin })) return null;
    const reason = why_not(view, from, to);
    if (reason === null) {
      this.do(edits.connect(view, from, to, instead));
      this.announce('Wired');
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
  /** The output that a breakpoint at this pin would watch; null if its type cannot be compared. */
  stop_source(pin: PinAt): { flat: string; type: string; unit: string } | null {
    const at = this.source_of(pin);
    const info = at.side === 'out' ? this.view?.pin(at.node, 'out', at.pin) : undefined;
    const flat = info && can_stop_at(info.type) ? this.flat_output(at.node, at.pin) : null;
    return info && flat ? { flat, type: info.type, unit: info.unit ?? '' } : null;
  }
  /** Opens the breakpoint dialog for a pin. */
  ask_stop(pin: PinAt, screen: { x: number; y: number }): void {
    const source = this.stop_source(pin);
    if (source) this.set({ stopping: { ...source, screen } });
    else this.host.notify('Breakpoints are possible only at outputs with numeric values.');
  }
  close_stop(): void {
    this.set({ stopping: null });
  }
  /** Title of an output given with its path: "Gain · out" for "arm/gain.out". */
  name_of(flat: string): string {
    const [ids, pin] = split_flat(flat);
    const path = ids.split('/');
    const lsi = this.circuit && enter(this.circuit, path.slice(0, -1)).circuit.lsis?.find((l) => l.id === path.at(-1));
    return `${lsi?.label || ids} · ${pin}`;
  }
  /** Starts typing the text of a node or note; null ends it. */
  type_in(id: string | null): void {
    this.set({ typing: id });
  }

  // ---- problems ----

  problems_of(id: string): CircuitProblem[] {
    return problems_at(this.state.problems, this.state.path, id);
  }
  /** Inserts a delay into the last wire of the algebraic loop of `problem`, and shows the level of that wire. */
  insert_delay(problem: CircuitProblem): void {
    const step = problem.loop.at(-1);
    if (!step || !this.circuit || !this.classes) return;
    // depth of the level that contains both ends
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
    if (!made) return this.host.notify('There is no delay LSI for this type. Break the loop by removing one of its wires.');
    this.do(made.command);
    this.select([made.id]);
  }

  // ---- keyboard ----

  /** Sets the text for screen readers. */
  announce(text: string): void {
    this.set({ announcement: text });
  }

  /** Arrow key: moves the cursor from node to node or from pin to pin, or through the pins at which the started wire may end. */
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
      return this.announce(describe_pin(view, target));
    }
    if (state.pin) {
      const pin = next_pin(view, state.pin, direction);
      if (!pin) return;
      this.set({ pin, cursor: pin.node });
      return this.announce(describe_pin(view, pin));
    }
    const [only] = state.nodes;
    const id = next_node(view, state.cursor ?? only ?? null, direction);
    if (id === null) return;
    this.set({ cursor: id, nodes: new Set([id]), wires: none });
    this.announce(describe_node(view.node(id)!));
  }

  /** Enter key: moves the cursor from a node to its pins, starts a wire at a pin, or ends the started wire. */
  enter_key(): void {
    const { view, state } = this;
    if (!view) return;
    if (state.connecting) {
      if (!state.target) return;
      const from = state.connecting;
      const to = state.target;
      const reason = this.end_wire(from, to);
      this.set({ pin: to, cursor: to.node });
      if (reason) this.announce(reason);
      return;
    }
    if (state.pin) {
      const fits = pins_that_fit(view, state.pin);
      this.begin_wire(state.pin);
      if (fits[0]) this.set({ target: fits[0] });
      return this.announce(fits[0] ? `Wire to: ${describe_pin(view, fits[0])}` : 'No pin here fits; press Tab to add an LSI that does');
    }
    const [only] = state.nodes;
    const node = state.cursor ?? only;
    const pin = node ? first_pin(view, node) : null;
    if (!pin) return;
    this.set({ pin, cursor: pin.node });
    this.announce(describe_pin(view, pin));
  }

  /** Escape key: closes the innermost open state. @return false if nothing was open or selected */
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

  /** Name with path ("arm/elbow.out") of the LSI output behind an output of this level, for requests to the service; null: none. */
  flat_output(id: string, pin: string): string | null {
    return this.circuit && this.view ? flat_source(this.circuit, this.view.level, id, pin) : null;
  }
}

/**
 * Name with path ("arm/elbow.out") of the LSI output that provides output `pin` of node `id`, found through nested circuits; null if there
 * is none.
 */
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
