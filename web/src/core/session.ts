/**
 * The session of one page with the service: the page's state, the requests that change it, and the events that update it. Framework-free.
 */
import { createStore, type StoreApi } from 'zustand/vanilla';
import { ClassList } from './circuit/classes';
import { condition_alone, type Breakpoint } from './circuit/breakpoints';
import { LiveValues } from './circuit/live';
import { PlayControls, read_devices } from './play_controls';
import { Client, LatestOnly, type SocketLike } from './client';
import { apply_command, frame_after, type Command, type ScenarioDocument } from './document';
import { fetch_json } from './fetch_json';
import { FrameRing } from './frames';
import {
  RequestError,
  type DocumentState,
  type HelloReply,
  type LibraryEntry,
  type LsisEvent,
  type MechanismData,
  type Mode,
  type Problem,
  type Request,
  type ServiceEvent,
  type Vec3,
} from './protocol';
import { UnconfirmedMoves } from './unconfirmed_moves';
import { Watches } from './watches';
import { is_pull } from './pulls';
import { initial_state, read_choices, valid_selection, type Selection, type StudioState, type Toast } from './state';

const log_capacity = 500; // maximum number of lines in the log; older lines are dropped

export interface SessionOptions {
  make_socket: () => SocketLike;
  fetch: (path: string, init?: RequestInit) => Promise<Response>;
}

export class Session {
  readonly store: StoreApi<StudioState>;
  readonly frames = new FrameRing();
  /** Live values of the running circuit, for the outputs requested by `watch`. */
  readonly live = new LiveValues();
  /** Sends keyboard, mouse and gamepad input to the content. */
  readonly controls = new PlayControls((input) => this.client.post({ op: 'input', ...input }, (error) => this.fail(error)));
  private readonly watches = new Watches();
  private readonly client: Client;
  private readonly seeks: LatestOnly<number>;
  private readonly drags: LatestOnly<Vec3>;
  /** Playback speed chosen while paused; sent to the service by the next `play`. */
  private wanted_speed: number | null = null;
  private pending_edits = 0;
  /** The document expected after the newest circuit edit. If the service confirms the same changes, it is used without applying them again. */
  private expected_edit: { from: number; changes: string; document: ScenarioDocument } | null = null;
  private next_id = 1;
  private readonly moves = new UnconfirmedMoves(() => this.seeks.waiting, (time) => this.move_to(time));
  private preview_timer: ReturnType<typeof setTimeout> | null = null;
  private readonly fetching = new Map<string, Promise<void>>();

  constructor(private readonly options: SessionOptions) {
    this.store = createStore<StudioState>(() => initial_state);
    this.client = new Client(options.make_socket, {
      connected: (hello) => this.connected(hello),
      disconnected: (retry_ms) => this.set({ connection: this.state.connection === 'refused' ? 'refused' : 'lost', retry_at: Date.now() + retry_ms }),
      event: (event) => this.event(event),
      frame: (frame) => this.frames.push(frame),
      protocol_error: (message) => this.log('error', message),
    });
    this.store.subscribe((state, before) => {
      if (state.view.closest !== before.view.closest || (state.connection === 'open' && before.connection !== 'open' && state.view.closest)) this.send_watch();
    });
    this.seeks = new LatestOnly(
      (time) => this.moves.add(this.client.request({ op: 'seek', time })),
      (error) => this.fail(error),
    );
    this.drags = new LatestOnly(
      // the service answers a drag only when it fails, so the page limits the rate to one request in 16 ms (one display frame)
      (target) =>
        new Promise<void>((resolve, reject) => {
          this.client.post({ op: 'drag', target }, reject);
          setTimeout(resolve, 16);
        }),
      (error) => this.fail(error),
    );
  }

  get state(): StudioState { return this.store.getState(); }

  set(part: Partial<StudioState>): void {
    this.store.setState(part);
  }

  start(): void {
    this.client.connect();
  }

  retry(): void {
    if (this.state.connection === 'refused') this.set({ connection: 'lost', retry_at: Date.now() });
    this.client.retry();
  }

  /** Ends the attempts to connect, because the service does not accept this page's token. The user must enter the new address. */
  refuse(): void {
    this.set({ connection: 'refused' });
    this.client.close();
  }

  // ---- edits ----

  /**
   * Sends one command. Its effect is shown at once as a preview, and the preview is removed if the service refuses the command.
   * @return whether the service accepted it
   */
  async edit(command: Command): Promise<boolean> {
    const { document, preview, revision, generated } = this.state;
    if (!document) return false;
    const base = (this.pending_edits > 0 && preview) || document;
    const shown = apply_command(base, command, generated);
    this.set({ preview: shown === base ? preview : shown });
    this.expected_edit = command.type === 'circuit.edit' && base === document ? { from: revision, changes: JSON.stringify(command.changes), document: shown } : null;
    this.pending_edits++;
    try {
      const { open } = this.state; // inner scenarios
      await this.client.request({ op: 'command', command, ...(open.length > 0 ? { scenario: open.at(-1)! } : {}) });
      this.pending_edits--;
      if (this.state.revision !== revision) this.drop_preview();
      else this.drop_preview_soon();
      return true;
    } catch (error) {
      this.pending_edits--;
      this.drop_preview();
      this.fail(error as Error);
      return false;
    }
  }

  /** Shows `document` during a drag; null ends the preview. Nothing is sent to the service. */
  show_preview(document: ScenarioDocument | null): void {
    this.set({ preview: document });
  }

  undo(): void {
    this.send({ op: 'undo' });
  }

  redo(): void {
    this.send({ op: 'redo' });
  }

  save(): void {
    void this.request({ op: 'save' }).then((reply) => reply && this.saved(reply));
  }

  /**
   * Saves the project to `path`. A file is written only if the result is `saved`. The result `exists` means that a file of this name
   * already exists and `overwrite` is false.
   */
  async save_as(path: string, overwrite: boolean): Promise<'saved' | 'exists' | 'failed'> {
    try {
      this.saved(await this.client.request({ op: 'save', path, overwrite }));
      return 'saved';
    } catch (error) {
      if (!overwrite && error instanceof RequestError && error.problems[0]?.code === 'conflict') return 'exists';
      this.fail(error as Error);
      return 'failed';
    }
  }

  private saved(reply: Record<string, unknown>): void {
    const { project } = this.state;
    if (!project) return;
    const path = typeof reply.path === 'string' ? reply.path : project.path;
    const name = path.split('/').pop() || project.name;
    this.set({ project: { ...project, path, name, unsaved: false } });
    this.notify(`Saved ${name}`);
  }

  /** Opens another project. @return whether it is open now */
  async open(path: string): Promise<boolean> {
    return (await this.request({ op: 'open', path })) !== null;
  }

  /**
   * Creates a project and opens it. An existing file is not replaced: the service appends a number to the name.
   * @return whether the new project is open
   */
  async create(path: string, from: 'empty' | 'sample' | object): Promise<boolean> {
    const reply = await this.request({ op: 'new', path, from });
    if (!reply) return false;
    this.notify(`Created ${String(reply.path).split('/').pop()}`);
    return true;
  }

  private drop_preview(): void {
    if (this.preview_timer) clearTimeout(this.preview_timer);
    this.preview_timer = null;
    if (this.pending_edits === 0) this.set({ preview: null });
  }

  /** Keeps the preview until the service's `document` event arrives, but at most 600 ms. */
  private drop_preview_soon(): void {
    if (this.preview_timer) clearTimeout(this.preview_timer);
    this.preview_timer = setTimeout(() => this.drop_preview(), 600);
  }

  // ---- transport ----

  set_mode(mode: Mode): void {
    if (mode === this.state.transport.mode) return;
    this.send({ op: 'mode', mode });
  }

  play(): void {
    this.set({ stopped: null });
    this.send({ op: 'play', speed: this.state.transport.speed });
  }

  pause(): void {
    this.send({ op: 'pause' });
  }

  toggle_play(): void {
    if (this.state.transport.playing) this.pause();
    else this.play();
  }

  /** @param on true: playing repeats the range, or the whole scenario if the document has no range */
  set_loop(on: boolean): void {
    this.send({ op: 'loop', on });
  }

  set_speed(speed: number): void {
    const { transport } = this.state;
    this.wanted_speed = speed;
    this.set({ transport: { ...transport, speed } });
    if (transport.playing) this.send({ op: 'play', speed });
  }

  /** Moves one display frame forwards or backwards. */
  step(frames: 1 | -1): void {
    const { transport, document } = this.state;
    if (transport.mode === 'edit' && !transport.playing && document) this.move_to(frame_after(document, transport.time, frames));
    void this.moves.add(this.request({ op: 'step', frames }));
  }

  /** Advances the simulation by one step of dynamics (one tick) and pauses. */
  step_tick(): void {
    this.send({ op: 'step', ticks: 1 });
  }

  restart(): void {
    this.send({ op: 'restart' });
  }

  /**
   * Moves the playhead. At most one `seek` request is unanswered at a time. Of the calls made meanwhile, only the time of the last is sent,
   * after the answer.
   * @param time s, limited to the duration of the document
   */
  seek(time: number): void {
    const { transport, document } = this.state;
    const clamped = Math.min(Math.max(0, time), document?.duration ?? transport.duration);
    this.move_to(clamped);
    this.seeks.offer(clamped);
  }

  private move_to(time: number): void { this.set({ transport: { ...this.state.transport, time } }); }

  /** Time of the latest frame while playing, otherwise time of the playhead, s. */
  get now(): number {
    const { transport } = this.state;
    return transport.playing && this.frames.latest ? this.frames.latest.time : transport.time;
  }

  // ---- pulling ----

  /** Starts a pull. @param point grabbed point in the link's frame, m  @param target world position, m */
  grab(character: string, link: number, point: Vec3, target: Vec3): void {
    this.send({ op: 'grab', character, link, point, target });
  }

  /** @param target new world position of the pull's target, m */
  drag(target: Vec3): void {
    this.drags.offer(target);
  }

  release(): void {
    this.drags.drop();
    this.send({ op: 'release' });
  }

  /** Pushes a link. @param force world frame, N  @param duration s */
  push(character: string, link: number, force: Vec3, duration: number): void {
    this.send({ op: 'push', character, link, force, duration });
  }

  // ---- circuit ----

  /**
   * Selects the live data of the running circuit that the page shows; a request is sent only on change.
   * @param pins outputs with their paths ("arm/elbow.out")  @param probes outputs recorded as curves  @param timing also times of LSIs
   */
  watch(pins: string[], probes: string[], timing: boolean): void {
    this.watches.circuit = { pins, probes, timing };
    this.send_watch();
  }

  /** Selects outputs whose live values the rules panel shows, in addition to those of watch(). */
  watch_rules(pins: string[]): void {
    this.watches.rules = pins;
    this.send_watch();
  }

  /** Selects the values of variables that the viewport shows, in addition to those of watch(). */
  watch_variables(pins: string[]): void {
    this.watches.variables = pins;
    this.send_watch();
  }

  /** Selects outputs whose curves the plots panel shows, in addition to those of watch(). */
  watch_plots(probes: string[]): void {
    this.watches.plots = probes;
    this.send_watch();
  }

  private send_watch(): void {
    if (this.state.connection !== 'open') return;
    const request = this.watches.change(this.state.view.closest);
    if (request) this.client.request(request).catch(() => this.watches.forget());
  }

  // ---- breakpoints: the service owns the list; each change sends the whole list ----

  private set_breakpoints(list: readonly Breakpoint[]): void {
    this.send({ op: 'breakpoints', list: list.map(({ condition, on }) => ({ condition, on })) });
  }
  add_breakpoint(condition: string): void {
    const others = this.state.breakpoints.filter((b) => b.condition !== condition);
    this.set_breakpoints([...others, { condition, pin: '', component: 0, on: true }]);
  }
  remove_breakpoints(which: (b: Breakpoint) => boolean): void {
    this.set_breakpoints(this.state.breakpoints.filter((b) => !which(b)));
  }
  switch_breakpoints(which: (b: Breakpoint) => boolean, on: boolean): void {
    this.set_breakpoints(this.state.breakpoints.map((b) => (which(b) ? { ...b, on } : b)));
  }

  private take_lsis(lsis: LsisEvent): void {
    this.set({ classes: new ClassList(lsis.classes ?? [], lsis.pin_types ?? []) });
  }

  // ---- library ----

  /** Called when another project was opened. */
  on_opened: () => void = () => undefined;
  /** Called when the service reports that the library changed. */
  on_library: () => void = () => undefined;
  private readonly entries = new Map<string, LibraryEntry>();

  /** Stores entries that a reply contained, so that entry() finds them. */
  cache_entries(entries: readonly LibraryEntry[]): void {
    for (const entry of entries) {
      if (entry.entry) this.entries.set(entry.entry, entry);
      const known = this.entries.get(entry.id);
      // a copy shares the data id of its original; the original's entry takes precedence
      if (!known || known.entry === entry.entry || entry.entry === entry.id) this.entries.set(entry.id, entry);
    }
    if (entries.length > 0) this.set({ library_revision: this.state.library_revision + 1 });
  }

  /** Loads a mechanism into `mechanisms` if necessary. The promise is fulfilled when the mechanism is loaded or an error was reported. */
  need_mechanism(id: string): Promise<void> {
    if (this.state.mechanisms[id]) return Promise.resolve();
    let running = this.fetching.get(id);
    if (!running) {
      running = this.fetch_mechanism(id);
      this.fetching.set(id, running);
    }
    return running;
  }

  private async fetch_mechanism(id: string): Promise<void> {
    try {
      const mechanism = await fetch_json<MechanismData>(this.options.fetch, `api/mechanism/${encodeURIComponent(id)}`);
      this.set({ mechanisms: { ...this.state.mechanisms, [id]: mechanism } });
    } catch (error) {
      this.fail(error as Error);
    } finally {
      this.fetching.delete(id);
    }
  }

  /** A library entry by its entry id or data id, if a reply contained it. */
  entry(id: string): LibraryEntry | undefined {
    return this.entries.get(id);
  }

  /** A new id for an object that the page adds. The service refuses an id that is in use. */
  fresh_id(prefix: string): string {
    return prefix + Math.floor((Date.now() % 1e9) * 36 + Math.random() * 36).toString(36);
  }

  // ---- messages ----

  select(selection: Selection): void {
    this.set({ selection });
  }

  notify(message: string, level: Toast['level'] = 'info'): void {
    this.toast(level, [{ message }]);
  }

  /** Reports what an operation did, one sentence for each line: as a toast and in the log. */
  report(title: string, lines: readonly string[]): void {
    this.toast('info', [{ location: title, message: lines[0] ?? 'Done.' }, ...lines.slice(1).map((message) => ({ message }))]);
    this.log_report(title, lines);
  }

  log_report(title: string, lines: readonly string[]): void {
    for (const line of lines) this.log('info', `${title} — ${line}`);
  }

  /** Sends a request whose failure the caller handles. */
  ask(request: Request): Promise<Record<string, unknown>> {
    return this.client.request(request);
  }

  /** Shows an error as a toast and in the log. @param location used for problems without a location */
  fail(error: Error, location?: string): void {
    const problems: Problem[] = error instanceof RequestError ? error.problems : [{ message: error.message }];
    const shown = location ? problems.map((p) => ({ ...p, location: p.location || location })) : problems;
    this.toast('error', shown);
    for (const p of shown) this.log('error', [p.location, p.message, p.remedy].filter(Boolean).join(' — '));
  }

  dismiss(id: number): void {
    this.set({ toasts: this.state.toasts.filter((t) => t.id !== id) });
  }

  /** Notices that were shown as toasts: the service repeats them when the page connects again. */
  private readonly noticed = new Set<string>();

  log(level: 'info' | 'warning' | 'error', text: string): void {
    const line = { id: this.next_id++, at: new Date(), level, text };
    this.set({ log: [...this.state.log.slice(-log_capacity + 1), line] });
  }

  /** Stores keymap, changed keys, theme and view options for other pages and the next start of the studio. */
  remember(): void {
    const { keymap, key_edits: keys, theme, view } = this.state;
    this.client.request({ op: 'remember', choices: { keymap, keys, theme, view } }).catch(() => undefined); // on failure the choices are not stored
  }

  private toast(level: Toast['level'], problems: Problem[]): void {
    const toast = { id: this.next_id++, level, problems };
    this.set({ toasts: [...this.state.toasts.slice(-3), toast] });
    if (level === 'info') setTimeout(() => this.dismiss(toast.id), 3500 + 1500 * (problems.length - 1));
  }

  private request(request: Request): Promise<Record<string, unknown> | null> {
    return this.client.request(request).catch((error: Error) => {
      this.fail(error);
      return null;
    });
  }

  private send(request: Request): void {
    void this.request(request);
  }

  private connected(hello: HelloReply): void {
    this.watches.forget();
    this.controls.forget();
    this.controls.set_devices(read_devices(hello.devices));
    if (hello.lsis) this.take_lsis(hello.lsis);
    this.take_document(hello);
    const first = this.state.connection === 'connecting';
    if (first) this.set(read_choices(hello.choices));
    const view = { ...this.state.view };
    if (first && (hello.document.camera?.follow || hello.document.characters.length === 0)) view.follow = true;
    this.set({
      connection: 'open',
      project: hello.project,
      recent: Array.isArray(hello.recent) ? hello.recent : [],
      transport: { ...this.state.transport, ...hello.transport },
      circuit_problems: hello.circuit_problems ?? [],
      breakpoints: hello.breakpoints ?? [],
      view,
      stopped: hello.stopped?.reason ?? null,
      stop_problems: hello.stopped?.problems ?? [],
    });
  }

  private take_document(state: DocumentState): void {
    this.frames.clear();
    this.set({
      document: state.document,
      open: state.open ?? this.state.open,
      outermost: state.outermost ?? this.state.outermost,
      revision: state.revision,
      can_undo: state.can_undo,
      can_redo: state.can_redo,
      undo_label: state.undo_label ?? '',
      redo_label: state.redo_label ?? '',
      characters: state.characters,
      generated: state.generated_circuit ?? this.state.generated,
      selection: valid_selection(this.state.selection, state.document),
    });
    for (const character of state.characters) void this.need_mechanism(character.mechanism);
    this.drop_preview();
  }

  private event(event: ServiceEvent): void {
    switch (event.event) {
      case 'document': {
        this.take_document(event);
        const { project } = this.state;
        if (project) this.set({ project: { ...project, unsaved: event.unsaved } });
        break;
      }
      case 'edited': {
        // the event has only the changes of the circuit; a page that missed an event requests the whole document
        if (event.from === this.state.revision && this.state.document) {
          const command = { type: 'circuit.edit', label: '', changes: event.changes } as const;
          const { expected_edit } = this;
          const known = expected_edit?.from === event.from && expected_edit.changes === JSON.stringify(event.changes);
          this.take_document({ ...event, document: known ? expected_edit.document : apply_command(this.state.document, command, this.state.generated) });
          const { project } = this.state;
          if (project) this.set({ project: { ...project, unsaved: event.unsaved } });
        } else if (event.revision !== this.state.revision) void this.request({ op: 'hello' }).then((hello) => hello && this.connected(hello as unknown as HelloReply));
        break;
      }
      case 'transport': {
        const { event: _name, ...transport } = event;
        if (transport.simulated === 0 && this.state.transport.simulated > 0) this.set({ summary: initial_state.summary }); // the recording was discarded
        if ((transport.playing || transport.status === 'ready') && this.state.stop_problems.length > 0) this.set({ stopped: null, stop_problems: [] });
        const { breakpoint_hit } = this.state;
        if (breakpoint_hit && (transport.playing || Math.abs(transport.time - breakpoint_hit.time) > 1e-9)) this.set({ breakpoint_hit: null });
        if (transport.playing) this.wanted_speed = null;
        else if (this.wanted_speed !== null) transport.speed = this.wanted_speed;
        if (transport.playing || transport.mode !== this.state.transport.mode) this.moves.forget();
        else if (this.moves.hides(transport.time)) transport.time = this.state.transport.time;
        this.set({ transport: { ...this.state.transport, ...transport } });
        break;
      }
      case 'summary':
        this.set({ summary: { characters: event.characters ?? [], contacts: event.contacts ?? [] } });
        break;
      case 'measures':
        this.set({ measures: this.state.measures.after(event) });
        break;
      case 'opened':
        this.frames.reset();
        this.set({ opened: this.state.opened + 1, summary: initial_state.summary, measures: initial_state.measures, recorded: null, pulled: null, selection: { kind: 'none' }, dialog: 'none' });
        this.on_opened();
        void this.request({ op: 'hello' }).then((hello) => hello && this.connected(hello as unknown as HelloReply));
        break;
      case 'library':
        this.on_library();
        break;
      case 'lsis':
        this.take_lsis(event);
        break;
      case 'devices':
        this.controls.set_devices(read_devices(event));
        break;
      case 'breakpoints':
        this.set({ breakpoints: event.list });
        break;
      case 'breakpoint': {
        const { event: _name, ...hit } = event;
        this.set({ breakpoint_hit: hit });
        this.log('info', `Stopped at t = ${hit.time.toFixed(3)} s (tick ${hit.tick}): ${hit.pin} ${condition_alone(hit)}; its value is ${hit.value}`);
        break;
      }
      case 'circuit':
        this.set({ circuit_problems: event.problems });
        break;
      case 'pulled':
        this.set({ pulled: is_pull(event) ? event : null });
        break;
      case 'recorded':
        this.set({ recorded: event });
        break;
      case 'values':
        this.live.take(event, performance.now());
        break;
      case 'log':
        this.log(event.level, event.text);
        if (event.notice && !this.noticed.has(event.text)) {
          this.noticed.add(event.text);
          this.toast(event.level === 'info' ? 'info' : 'error', [{ message: event.text }]);
        }
        break;
      case 'stopped':
        this.set({ stopped: event.reason, stop_problems: event.problems ?? [] });
        this.log('error', event.reason);
        break;
    }
  }
}
