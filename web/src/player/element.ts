/**
 * The element <ugoki-player> shows and plays content. Attributes: `src` (address of a *.ugx file; without `src`, the content inside the page
 * is played), `autoplay`, `theme` (dark, light), `tool` (pull, push), `controls="none"`. docs/export.md describes its methods and events.
 */
import { format_time } from '../core/format';
import { assist_force, body_weight, CharacterState, state_of } from '../core/frames';
import { describe_devices, PlayControls, reads_anything } from '../core/play_controls';
import type { Vec3 } from '../core/protocol';
import { show_assist, show_variables } from './cards';
import type { Engine, RecordedInput, Scene } from './engine';
import { Gestures, type GestureHost, type Tool } from './gestures';
import css from './player.css?inline';
import { in_range, vector } from './ranges';
import { SceneView } from './scene_view';

const max_push = 1e5; // N, as in the studio
const max_distance = 1e4; // m

/** Opens the engine of a page. @param src address of the content; null: the content inside the page */
export type OpenEngine = (src: string | null) => Promise<Engine>;
let open_engine: OpenEngine = () => Promise.reject(new Error('This page has no engine.'));
let open_still: () => Promise<Engine | null> = () => Promise.resolve(null);
/** @param still opens an engine that only has the first frame of the content inside the page, in a fraction of the time; null: there is none */
export function set_engine_source(open: OpenEngine, still = open_still): void {
  open_engine = open;
  open_still = still;
}

const icon = (path: string): string => `<svg viewBox="0 0 16 16" aria-hidden="true">${path}</svg>`;
const icons = {
  play: icon('<path class="solid" d="M4 2.5v11l9.5-5.5z"/>'),
  pause: icon('<path class="solid" d="M4 2.5h3v11H4zM9.5 2.5h3v11h-3z"/>'),
  again: icon('<path d="M3.2 8a4.8 4.8 0 1 0 1.6-3.6L3 6"/><path d="M3 2.6V6h3.4"/>'),
  pull: icon('<path d="M2.5 13.5 6 10"/><path d="M6 10c1.5 1.5 3.5 1.4 4.8.1s1.4-3.3-.1-4.8"/><circle cx="12" cy="4" r="1.6"/>'),
  push: icon('<path d="M2 8h9"/><path d="m7.5 4.5 3.5 3.5-3.5 3.5"/><path d="M13.5 3v10"/>'),
  follow: icon('<circle cx="8" cy="8" r="3"/><path d="M8 1.5v2.6M8 11.9v2.6M1.5 8h2.6M11.9 8h2.6"/>'),
  all: icon('<path d="M2.5 5.5v-3h3M10.5 2.5h3v3M13.5 10.5v3h-3M5.5 13.5h-3v-3"/>'),
};

const surface_budget = 4; // ms: time for refining the surfaces of bodies for each picture
const step_budget = 13; // ms: time of the engine for each picture; the rest of 16.7 ms is for drawing
const max_backlog = 0.1; // s: maximum delay of the content; if the delay is larger, the content runs slower than real time

export class UgokiPlayer extends HTMLElement implements GestureHost {
  static observedAttributes = ['src', 'theme', 'tool'];
  private parts!: Record<'canvas' | 'name' | 'assist' | 'board' | 'play' | 'again' | 'time' | 'progress' | 'line' | 'rate' | 'pull' | 'push' | 'follow' | 'all' | 'speed' | 'label' | 'hint' | 'start' | 'message', HTMLElement>;
  /** Present from the first picture on. */
  private opened: { engine: Engine; view: SceneView; gestures: Gestures; controls: PlayControls } | null = null;
  /** True: the engine can run the content. */
  private ready = false;
  private play_when_ready = false;
  private waiting: (() => void)[] = [];
  private running = false;
  private finished = false;
  private rate = 1;
  private backlog = 0;
  private last = 0;
  private handle = 0;
  private dirty = true;
  private drawn_still = false;
  private still_since = 0;
  private generation = 0;
  private real_time = 1; // smoothed speed of the content, 1: real time
  private last_text = 0;
  private resizer: ResizeObserver | null = null;
  private readonly released = new AbortController();
  /** Number of pictures drawn so far. */
  pictures = 0;
  /** ms: time from the start of loading to the first picture; 0 before the first picture. */
  first_picture = 0;
  private began = 0;

  connectedCallback(): void {
    if (!this.shadowRoot) this.build();
    void this.load();
  }

  disconnectedCallback(): void {
    this.close();
    this.resizer?.disconnect();
  }

  attributeChangedCallback(name: string, before: string | null, now: string | null): void {
    if (!this.shadowRoot || before === now) return;
    if (name === 'src') void this.load();
    if (name === 'theme') {
      this.opened?.view.set_theme(this.theme);
      this.invalidate();
    }
    if (name === 'tool') this.show_state();
  }

  // ---- the documented interface ----

  /** The content: name, duration, characters. Null until it is shown. */
  get scene(): Scene | null {
    return this.opened?.engine.scene ?? null;
  }
  /** Time since the beginning of the content, s. */
  get time(): number {
    return this.opened?.engine.time ?? 0;
  }
  get steps(): number {
    return this.opened?.engine.steps ?? 0;
  }
  get duration(): number {
    return this.scene?.duration ?? 0;
  }
  get paused(): boolean {
    return !this.running;
  }
  get ended(): boolean {
    return this.finished;
  }
  /** Playback speed; 1 is real time. */
  get speed(): number {
    return this.rate;
  }
  set speed(value: number) {
    this.rate = Math.min(4, Math.max(0.05, Number(value) || 1));
    (this.parts.speed as HTMLSelectElement).value = String(this.rate);
  }
  get tool(): Tool {
    return this.getAttribute('tool') === 'push' ? 'push' : 'pull';
  }
  set tool(value: Tool) {
    this.setAttribute('tool', value);
  }

  play(): void {
    if (!this.opened || this.running) return;
    if (!this.ready) {
      this.play_when_ready = true;
      return;
    }
    if (this.finished) this.reset();
    this.running = true;
    this.backlog = 0;
    this.opened.controls.enter();
    this.show_state();
    this.notify('play');
  }

  pause(): void {
    this.play_when_ready = false;
    if (!this.running) return;
    this.running = false;
    this.opened?.gestures.abandon();
    this.opened?.controls.leave();
    this.show_state();
    this.notify('pause');
  }

  /** Returns to time 0. */
  reset(): void {
    if (!this.opened || !this.ready) return;
    this.opened.gestures.abandon();
    this.opened.engine.reset();
    this.opened.view.directed = true;
    this.finished = false;
    this.backlog = 0;
    this.message('');
    this.show_state();
    this.invalidate();
    this.notify('reset');
  }

  /** Runs `count` steps at once, without waiting for real time. @return steps done */
  async step(count: number): Promise<number> {
    in_range('count', count, 0, 1e9);
    await this.until_ready();
    const done = (await this.opened?.engine.step(count)) ?? 0;
    this.check_end();
    this.invalidate();
    return done;
  }

  /** Pushes a link. @param character id or index; link: name or index; force: N, world; duration: s */
  push(character: string | number, link: string | number, force: Vec3, duration = 0.2): void {
    const [c, l] = this.find(character, link);
    this.opened?.engine.push(c, l, vector('force', force, max_push), in_range('duration', duration, 0.0001, 10));
  }
  /** Begins to pull a point of a link towards a target. @param point m, in the frame of the link; target: m, world */
  grab(character: string | number, link: string | number, point: Vec3, target: Vec3): void {
    const [c, l] = this.find(character, link);
    this.opened?.engine.grab(c, l, vector('point', point, max_distance), vector('target', target, max_distance));
  }
  drag(target: Vec3): void {
    this.opened?.engine.drag(vector('target', target, max_distance));
  }
  release(): void {
    this.opened?.engine.release();
  }
  /** Sets the inputs of a recorded run; they act after the next reset(). */
  async schedule(inputs: RecordedInput[]): Promise<void> {
    await this.until_ready();
    await this.opened?.engine.schedule(inputs);
  }
  /** Returns the inputs since the last reset(). */
  async recorded(): Promise<RecordedInput[]> {
    await this.until_ready();
    return (await this.opened?.engine.recorded()) ?? [];
  }
  /** Returns the hash of all positions and velocities; equal hashes mean equal bits. */
  async state_hash(): Promise<string> {
    await this.until_ready();
    return (await this.opened?.engine.state_hash()) ?? '';
  }
  /** Moves the camera so that everything is in view. */
  frame_all(): void {
    this.opened?.view.frame_all();
    this.invalidate();
  }
  /** Follows a character with the camera. @param character id or index; null: the camera stays */
  follow(character: string | number | null): void {
    if (!this.opened) return;
    this.opened.view.directed = false;
    this.opened.view.followed = character === null ? -1 : this.find(character, 0)[0];
    if (this.opened.view.followed < 0) this.opened.view.rig.follow(null);
    this.show_state();
    this.invalidate();
  }
  /** Places the camera around its target: azimuth and elevation in rad, distance in m. */
  look(azimuth: number, elevation: number, distance?: number): void {
    const rig = this.opened?.view.rig;
    if (!rig) return;
    rig.look_from(in_range('azimuth', azimuth, -100, 100), in_range('elevation', elevation, -100, 100));
    if (distance !== undefined) rig.set({ distance: in_range('distance', distance, 0.01, 1e4) }, false);
    this.invalidate();
  }
  /** Values of the variables that the content shows. A switch is 0 or 1. */
  get variables(): { id: string; name: string; value: number }[] {
    const values = this.opened?.engine.variables ?? [];
    return (this.scene?.variables ?? []).map((v, i) => ({ id: v.id, name: v.name, value: values[i] ?? v.initial }));
  }
  /** Centre of mass [m], root assist [body weights] and state of each character. */
  get characters(): { id: string; name: string; centre_of_mass: Vec3; assist: number; state: 'tracking' | 'released' | 'passive' }[] {
    const frame = this.opened?.engine.frame;
    if (!frame || !this.scene) return [];
    return this.scene.characters.map((c, i) => {
      const at = frame.characters[i]!;
      const weight = body_weight(frame, at);
      const f = frame.floats;
      return {
        id: c.id,
        name: c.name,
        centre_of_mass: [f[at.data + 8]!, f[at.data + 9]!, f[at.data + 10]!],
        assist: weight > 0 ? Math.hypot(...assist_force(frame, at)) / weight : 0,
        state: state_of(frame, at) === CharacterState.tracking ? 'tracking' : state_of(frame, at) === CharacterState.released ? 'released' : 'passive',
      };
    });
  }

  // ---- for Gestures ----

  get view(): SceneView {
    return this.opened!.view;
  }
  get engine(): Engine {
    return this.opened!.engine;
  }
  get live(): boolean {
    return this.running;
  }
  weight(character: number): number {
    const frame = this.opened?.engine.frame;
    const at = frame?.characters[character];
    return frame && at ? body_weight(frame, at) : 0;
  }
  invalidate(): void {
    this.dirty = true;
  }
  label(text: string, x: number, y: number): void {
    const { label } = this.parts;
    label.textContent = text;
    label.style.visibility = text ? 'visible' : 'hidden';
    label.style.transform = `translate(${x + 14}px, ${y + 12}px)`;
  }

  // ---- opening and closing of the content ----

  private get theme(): 'dark' | 'light' {
    return this.getAttribute('theme') === 'light' ? 'light' : 'dark';
  }

  private async load(): Promise<void> {
    const generation = ++this.generation;
    this.close();
    this.began = performance.now();
    this.first_picture = 0;
    this.message('Loading …', 'busy');
    this.play_when_ready = this.hasAttribute('autoplay') && !matchMedia('(prefers-reduced-motion: reduce)').matches;
    const stale = (): boolean => generation !== this.generation || !this.isConnected;
    try {
      const src = this.getAttribute('src');
      const still = src === null ? await open_still() : null;
      if (stale()) return;
      if (still) {
        this.open(still);
        await this.first_drawn();
        if (stale()) return;
      }
      const engine = await open_engine(src);
      if (stale()) return engine.dispose();
      if (this.opened) this.opened.view.add_skins((this.opened.engine = engine).scene);
      else this.open(engine);
      this.begin();
    } catch (error) {
      if (generation !== this.generation) return;
      const text = (error as Error).message;
      this.message(text);
      for (const go_on of this.waiting.splice(0)) go_on();
      this.notify('error', { message: text });
    }
  }

  /** Waits until the engine can run the content that is shown. */
  private until_ready(): Promise<void> | undefined {
    return this.opened && !this.ready ? new Promise((done) => this.waiting.push(done)) : undefined;
  }

  /** Waits until the browser has the first picture, because unpacking the engine would delay it. */
  private async first_drawn(): Promise<void> {
    const next = (): Promise<unknown> => new Promise((done) => requestAnimationFrame(done));
    while (this.opened && this.first_picture === 0 && !document.hidden) await next();
    if (!document.hidden) await next();
  }

  /** Shows the content of an engine. */
  private open(engine: Engine): void {
    let view: SceneView;
    try {
      view = new SceneView(this.parts.canvas as HTMLCanvasElement, engine.scene, { theme: this.theme });
    } catch (error) {
      engine.dispose();
      throw new Error(`The 3D picture cannot be drawn: ${(error as Error).message}. Enable WebGL (hardware acceleration) in the browser, then reload the page.`);
    }
    const controls = new PlayControls((message) => this.opened?.engine.input(message));
    controls.set_devices(engine.devices);
    this.opened = { engine, view, gestures: new Gestures(view.canvas, this), controls };
    this.parts.name.textContent = engine.scene.name;
    this.parts.name.title = engine.scene.name;
    this.finished = false;
    this.message('');
    this.resize();
    const frame = engine.frame;
    if (frame) view.place(frame);
    view.first_view();
    this.show_state();
    this.last = performance.now();
    cancelAnimationFrame(this.handle);
    this.handle = requestAnimationFrame(this.tick);
  }

  /** The engine is complete: the content can run. */
  private begin(): void {
    this.ready = true;
    this.last = performance.now();
    this.hint();
    this.show_state();
    this.notify('ready');
    if (this.play_when_ready) this.play();
    for (const go_on of this.waiting.splice(0)) go_on();
  }

  private close(): void {
    cancelAnimationFrame(this.handle);
    this.ready = this.play_when_ready = this.running = false;
    for (const go_on of this.waiting.splice(0)) go_on();
    this.opened?.engine.dispose();
    this.opened?.view.dispose();
    if (this.opened) {
      // Replace the canvas: it would keep its WebGL context and the listeners of the closed content.
      const fresh = this.parts.canvas.cloneNode() as HTMLElement;
      this.parts.canvas.replaceWith(fresh);
      this.parts.canvas = fresh;
    }
    this.opened = null;
  }

  private readonly tick = (now: number): void => {
    this.handle = requestAnimationFrame(this.tick);
    const opened = this.opened;
    if (!opened) return;
    const { engine, view, gestures, controls } = opened;
    const dt = Math.min(0.25, Math.max(0.0001, (now - this.last) / 1000));
    this.last = now;
    if (engine.devices.gamepads.length > 0 && this.running) controls.gamepads(navigator.getGamepads());
    if (this.running) {
      this.backlog = Math.min(this.backlog + dt * this.rate, Math.max(max_backlog, dt * this.rate));
      const left = engine.scene.duration - engine.time;
      const passed = engine.advance(Math.min(this.backlog, left), step_budget);
      this.backlog -= passed;
      this.real_time += (passed / dt - this.real_time) * Math.min(1, dt / 0.5);
      if (passed > 0) this.dirty = true;
      this.check_end();
    }
    if (this.first_picture > 0 && view.refine(surface_budget)) this.dirty = true;
    if (!view.stage.free) return;
    const frame = engine.frame;
    if (this.dirty && frame && frame !== view.frame) view.place(frame);
    if (view.update_camera(dt)) this.dirty = true;
    gestures.follow();
    if (this.dirty) {
      if (this.still_since > 0 && now - this.still_since < 200) view.stage.note_frame_time(dt * 1000);
      this.still_since = now;
      this.dirty = this.drawn_still = false;
      view.draw(false);
    } else if (!this.drawn_still && now - this.still_since > 180) {
      this.drawn_still = true;
      view.draw(true);
    } else {
      return;
    }
    this.pictures++;
    if (this.first_picture === 0) {
      this.first_picture = performance.now() - this.began;
      this.notify('picture');
    }
    if (now - this.last_text > 100) this.show_values(now);
  };

  private check_end(): void {
    const engine = this.opened?.engine;
    if (!engine || this.finished) return;
    if (engine.stopped !== '') {
      this.finished = true;
      this.pause();
      this.message(engine.stopped);
      this.notify('error', { message: engine.stopped });
    } else if (engine.time >= engine.scene.duration - 0.5 * engine.scene.step) {
      this.finished = true;
      this.pause();
      this.notify('ended');
    }
    if (this.finished) this.show_state();
  }

  // ---- display of the state ----

  private show_values(now: number): void {
    const opened = this.opened;
    if (!opened) return;
    this.last_text = now;
    const { engine } = opened;
    const frame = engine.frame;
    this.parts.time.innerHTML = `${format_time(engine.time)}<small> / ${format_time(engine.scene.duration)}</small>`;
    const done = `scaleX(${Math.min(1, engine.time / Math.max(engine.scene.duration, 1e-9))})`;
    for (const bar of [this.parts.progress, this.parts.line]) (bar.firstElementChild as HTMLElement).style.transform = done;
    const slow = this.running && this.real_time < 0.9 * this.rate;
    this.parts.rate.textContent = slow ? `${this.real_time.toFixed(2)}× real time` : '';
    show_variables(this.parts.board, engine);
    if (!frame) return;
    show_assist(this.parts.assist, engine.scene, frame);
  }

  private show_state(): void {
    const { play, pull, push, follow, start } = this.parts;
    play.innerHTML = this.running ? icons.pause : this.finished ? icons.again : icons.play;
    const word = this.running ? 'Pause' : this.finished ? 'Play again' : 'Play';
    play.title = `${word} (Space)`;
    play.setAttribute('aria-label', word);
    pull.setAttribute('aria-pressed', String(this.tool === 'pull'));
    push.setAttribute('aria-pressed', String(this.tool === 'push'));
    follow.setAttribute('aria-pressed', String((this.opened?.view.followed ?? -1) >= 0));
    start.hidden = !this.ready || this.running || this.time > 0 || this.getAttribute('controls') === 'none';
    this.show_values(performance.now());
  }

  private hint(): void {
    const devices = this.opened?.engine.devices;
    const reads = devices && reads_anything(devices) ? `Play with ${describe_devices(devices)}. ` : '';
    this.parts.hint.textContent = `${reads}Drag a character to ${this.tool} it, drag beside it to turn the view.`;
    delete this.parts.hint.dataset.off;
    setTimeout(() => (this.parts.hint.dataset.off = ''), 6000);
  }

  private message(text: string, kind: 'busy' | 'error' = 'error'): void {
    this.parts.message.hidden = text === '';
    this.parts.message.textContent = text;
    this.parts.message.dataset.kind = kind;
  }

  private notify(type: string, detail: object = {}): void {
    this.dispatchEvent(new CustomEvent(type, { detail: { time: this.time, ...detail }, bubbles: true }));
  }

  private resize(): void {
    const box = this.getBoundingClientRect();
    this.opened?.view.resize(box.width, box.height);
    this.invalidate();
  }

  private find(character: string | number, link: string | number): [number, number] {
    const scene = this.scene;
    const c = typeof character === 'number' ? character : (scene?.characters.findIndex((one) => one.id === character || one.name === character) ?? -1);
    const mechanism = scene?.mechanisms[scene.characters[c]?.mechanism ?? -1];
    if (!mechanism) throw new RangeError(`The content has no character ${character}.`);
    const l = typeof link === 'number' ? link : mechanism.links.findIndex((one) => one.name === link || one.label === link);
    if (!mechanism.links[l]) throw new RangeError(`The character has no link ${link}.`);
    return [c, l];
  }

  private build(): void {
    const root = this.attachShadow({ mode: 'open' });
    root.innerHTML = `<style>${css}</style>
      <canvas data-part="canvas" tabindex="0" role="application" aria-label="Content: drag a character to act on it, drag beside it to turn the view. Space plays, R restarts."></canvas>
      <div class="top"><div class="name" data-part="name"></div><div class="assist" data-part="assist" hidden title="External force on the root that acts in addition to the ground forces, in percent of the body weight"></div></div>
      <dl class="board" data-part="board" aria-label="Variables" hidden></dl>
      <div class="hint" data-part="hint" data-off></div>
      <button type="button" class="start" data-part="start" aria-label="Play" hidden>${icons.play}</button>
      <div class="bar" role="toolbar" aria-label="Player">
        <button type="button" class="icon" data-part="play"></button>
        <button type="button" class="icon" data-part="again" title="Restart (R)" aria-label="Restart">${icons.again}</button>
        <span class="time" data-part="time"></span>
        <span class="progress" data-part="progress"><i></i></span>
        <span class="progress line" data-part="line"><i></i></span>
        <span class="rate" data-part="rate"></span>
        <span class="divider"></span>
        <span class="tools" role="group" aria-label="Drag a character to">
          <button type="button" data-part="pull" title="Drag a character to pull it (Shift: push)">${icons.pull}<span class="wide">Pull</span></button>
          <button type="button" data-part="push" title="Drag a character to push it (Shift: pull)">${icons.push}<span class="wide">Push</span></button>
        </span>
        <span class="divider"></span>
        <button type="button" class="icon" data-part="follow" title="Follow with the camera (L)" aria-label="Follow with the camera">${icons.follow}</button>
        <button type="button" class="icon" data-part="all" title="Show everything (A)" aria-label="Show everything">${icons.all}</button>
        <select class="speed" data-part="speed" title="Speed" aria-label="Speed"><option value="0.1">0.1×</option><option value="0.25">0.25×</option><option value="0.5">0.5×</option><option value="1" selected>1×</option><option value="2">2×</option></select>
      </div>
      <div class="label" data-part="label" aria-hidden="true"></div>
      <div class="message" data-part="message" role="alert" hidden></div>`;
    this.parts = Object.fromEntries([...root.querySelectorAll<HTMLElement>('[data-part]')].map((e) => [e.dataset.part!, e])) as typeof this.parts;
    const { parts } = this;
    const toggle = (): void => (this.running ? this.pause() : this.play());
    parts.play.addEventListener('click', toggle);
    parts.start.addEventListener('click', toggle);
    parts.again.addEventListener('click', () => {
      this.reset();
      this.play();
    });
    parts.pull.addEventListener('click', () => this.choose('pull'));
    parts.push.addEventListener('click', () => this.choose('push'));
    parts.follow.addEventListener('click', () => this.toggle_follow());
    parts.all.addEventListener('click', () => this.frame_all());
    parts.speed.addEventListener('change', () => (this.speed = Number((parts.speed as HTMLSelectElement).value)));
    this.listen_to_devices();
    this.resizer = new ResizeObserver(() => this.resize());
    this.resizer.observe(this);
  }

  private choose(tool: Tool): void {
    this.tool = tool;
    this.hint();
  }

  private toggle_follow(): void {
    const view = this.opened?.view;
    if (!view) return;
    const stored = this.scene?.characters.findIndex((c) => c.id === this.scene?.camera.follow) ?? -1;
    this.follow(view.followed >= 0 ? null : Math.max(0, stored));
  }

  /** Passes keys, pointer and wheel to the content if the content reads them, otherwise to the player. */
  private listen_to_devices(): void {
    const { signal } = this.released;
    const key = (event: KeyboardEvent): void => {
      const controls = this.opened?.controls;
      if (!controls) return;
      if (controls.devices.keyboard.includes(event.code) && this.running && !event.ctrlKey && !event.metaKey) {
        event.preventDefault();
        return controls.key(event.code, event.type === 'keydown');
      }
      if (event.type !== 'keydown' || event.ctrlKey || event.metaKey || event.altKey) return;
      const on_button = event.composedPath()[0] instanceof HTMLButtonElement || event.composedPath()[0] instanceof HTMLSelectElement;
      const actions: Record<string, () => void> = {
        Space: () => (this.running ? this.pause() : this.play()),
        KeyR: () => this.reset(),
        KeyL: () => this.toggle_follow(),
        KeyA: () => this.frame_all(),
        Escape: () => this.opened?.gestures.abandon(),
      };
      const action = actions[event.code];
      if (!action || (on_button && event.code === 'Space')) return;
      event.preventDefault();
      action();
    };
    this.addEventListener('keydown', key, { signal });
    this.addEventListener('keyup', key, { signal });
    this.addEventListener('blur', () => this.opened?.controls.release(), { signal });
    document.addEventListener('visibilitychange', () => document.hidden && this.opened?.controls.release(), { signal });
    const pointer = (event: PointerEvent): void => {
      const controls = this.opened?.controls;
      if (!controls?.devices.mouse || !this.running) return;
      const box = this.getBoundingClientRect();
      controls.pointer((event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height, event.buttons);
    };
    for (const type of ['pointerdown', 'pointermove', 'pointerup'] as const) this.addEventListener(type, pointer, { signal });
    this.addEventListener('wheel', (event) => this.running && this.opened?.controls.devices.mouse && this.opened.controls.wheel(event.deltaY, event.deltaMode), { signal, passive: true });
  }
}
