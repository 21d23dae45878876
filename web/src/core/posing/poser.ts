/**
 * Posing of characters: edits of the pose at the playhead, which the service computes, and the keys that store them in a layer of the clip.
 * Framework-free.
 */
import { createStore, type StoreApi } from 'zustand/vanilla';
import { find_character, find_clip, type Clip, type Command, type ScenarioDocument } from '../document';
import type { JointFacts, PoseEdit, PoseReply, PoseRequest, Request } from '../protocol';
import type { Session } from '../session';
import { selected_character } from '../state';
import { find_joint, key_command, key_times, part_of, same_key, type KeyedLayer, type KeyName, type KeyPut } from './keys';

/** The clip and the time (s, in the scenario) that are posed. */
export interface PoseTarget {
  character: string;
  clip: string;
  time: number;
}

export type Moves = 'limb' | 'body' | 'physics';

export interface PoserState {
  /** True: presses in the viewport pose characters. */
  on: boolean;
  /** The parts that move while a link is dragged: its limb; the whole body, with pinned links held; or the body as a body, by dynamics. */
  moves: Moves;
  /** True: every change of a pose sets keys at once. */
  auto_key: boolean;
  /** The layer of each clip that gets the keys; absent: the last one. */
  layers: Readonly<Record<string, string>>;
  /** Indices of the links that the user pinned, by character; absent: the links that touch the ground. */
  pins: Readonly<Record<string, readonly number[]>>;
  target: PoseTarget | null;
  /** The pose of the target; null: not known yet. */
  reply: PoseReply | null;
  /** True: `reply` differs from the document, and its keys are not set. */
  pending: boolean;
  dragging: boolean;
  /** Poses to draw instead of those of the frames; null: draw the frames. */
  shown: { character: string; links: readonly number[] } | null;
  /** Poses shortly before and after the target's time, for ghosts; null: none. */
  ghosts: { character: string; poses: readonly (readonly number[])[] } | null;
  /** Facts about the joints of each mechanism, by its id. */
  joints: Readonly<Record<string, readonly JointFacts[]>>;
}

const frame_wait = 700; // ms after which the frames are drawn again, if the service sends no new frame
const ghost_distance = 0.26; // s, between the posed time and its ghosts
const ready_wait = 2500; // ms, maximum time until the pose of a new target is known
const live_wait = 12; // ms between two requests of a drag with dynamics while the mouse rests
const max_drag_step = 0.05; // s that one request simulates, so that a slow computer slows the body down instead of the answers
const page_id = Math.random().toString(36).slice(2, 12);
const default_ease = 0.3; // s, fade of a new layer

/** The clip of a character that plays at `time`: the last one that has begun and has not ended. In a cross-fade this is the later clip. */
export function clip_at(doc: ScenarioDocument, character: string, time: number): Clip | null {
  const clips = find_character(doc, character)?.track ?? [];
  let found: Clip | null = null;
  for (const clip of clips) if (clip.start <= time + 1e-6 && time <= clip.start + clip.length + 1e-6) found = clip;
  return found;
}

/** The clip with which the target's clip is mixed at the target's time; null: it plays alone. */
export function cross_fade_at(doc: ScenarioDocument | null, { character, clip, time }: PoseTarget): Clip | null {
  const track = (doc && find_character(doc, character)?.track) ?? [];
  const into = track.findIndex((k, i) => i > 0 && k.blend > 0 && time >= k.start - 1e-6 && time < k.start + Math.min(k.blend, k.length) - 1e-6);
  const pair = into > 0 ? [track[into - 1]!, track[into]!] : [];
  return pair.some((k) => k.id === clip) ? (pair.find((k) => k.id !== clip) ?? null) : null;
}

export class Poser {
  readonly store: StoreApi<PoserState> = createStore<PoserState>(() => ({
    on: false, moves: 'limb', auto_key: true, layers: {}, pins: {}, target: null, reply: null, pending: false, dragging: false, shown: null, ghosts: null, joints: {},
  }));
  /** Joints that were changed and not keyed when the present drag began. */
  private base: PoseReply['changed'] = [];
  private before_drag: PoseReply | null = null;
  private next: { edit: PoseEdit; free: boolean } | null = null;
  /** The last edit of a drag with dynamics: the body goes on moving while the mouse rests. */
  private live: { edit: PoseEdit; free: boolean } | null = null;
  private drag_id = '';
  private drags = 0;
  private running: Promise<void> | null = null;
  /** Increases with every target, so that late answers for older targets are ignored. */
  private round = 0;
  /** The target and the revision for which `reply` was requested. */
  private asked = '';
  /** The pose that is drawn because its clip is mixed with another one; null: none. */
  private alone: PoserState['shown'] = null;

  constructor(private readonly session: Session) {
    session.store.subscribe((state, before) => {
      if (state.document !== before.document || state.selection !== before.selection || state.transport !== before.transport || state.view.ghosts !== before.view.ghosts || state.connection !== before.connection) this.update();
    });
  }

  get state(): PoserState {
    return this.store.getState();
  }
  private set(part: Partial<PoserState>): void {
    this.store.setState(part);
  }

  switch_on(on: boolean): void {
    if (on === this.state.on) return;
    if (!on) this.restore();
    this.set({ on });
    if (on) {
      const { state } = this.session;
      if (state.transport.playing) this.session.pause();
      if (state.transport.mode !== 'edit') this.session.set_mode('edit');
      const first = state.document?.characters.find((c) => c.track.length > 0);
      if (!selected_character(state) && first) this.session.select({ kind: 'character', character: first.id });
    }
    this.update();
  }
  set_moves(moves: Moves): void {
    this.set({ moves });
  }
  set_auto_key(auto_key: boolean): void {
    this.set({ auto_key });
    if (auto_key && this.state.pending) void this.key_changes();
  }

  /** The target at the playhead, for the selected character; null while nothing can be posed. */
  private find_target(): PoseTarget | null {
    const { state } = this.session;
    const character = selected_character(state);
    if (!this.state.on || !state.document || !character || state.transport.mode !== 'edit' || state.transport.playing || state.connection !== 'open') return null;
    const { time } = state.transport;
    const { selection } = state;
    // of the two clips of a cross-fade, the selected one is posed
    const chosen = selection.kind === 'clip' ? find_clip(state.document, character, selection.clip) : undefined;
    const inside = chosen && chosen.start <= time + 1e-6 && time <= chosen.start + chosen.length + 1e-6;
    const clip = inside ? chosen : clip_at(state.document, character, time);
    return clip && { character, clip: clip.id, time };
  }

  /** Requests the pose of the target, if it changed. */
  update(): void {
    const target = this.find_target();
    const { ghosts: with_ghosts } = this.session.state.view;
    const asked = target ? `${JSON.stringify(target)} ${this.session.state.revision} ${this.layer_of(target)?.id ?? ''} ${with_ghosts}` : '';
    if (asked === this.asked || (this.state.dragging && target)) return;
    this.asked = asked;
    const round = ++this.round;
    this.next = null;
    this.base = [];
    this.set({ target, pending: false, dragging: false, ...(target ? {} : { reply: null, shown: null, ghosts: null }) });
    if (!target) return;
    const moved = this.state.shown;
    void this.need_joints(target.character);
    const ghosts = with_ghosts ? { ghosts: [Math.max(0, target.time - ghost_distance), target.time + ghost_distance] } : {};
    void this.ask({ ...this.request(target), ...ghosts }).then((answer) => {
      const reply = answer as unknown as PoseReply | null;
      if (round !== this.round || !reply) return;
      // the frames show the mixture of both clips of a cross-fade, so the posed clip is drawn alone
      const alone = cross_fade_at(this.session.state.document, target) ? { character: target.character, links: reply.links } : null;
      const was_alone = this.alone !== null && this.alone === this.state.shown;
      this.alone = alone;
      this.set({ reply, ...(alone ? { shown: alone } : was_alone ? { shown: null } : {}), ghosts: reply.ghosts ? { character: target.character, poses: reply.ghosts } : null, ...(moved && moved === this.state.shown && moved.character !== target.character ? { shown: null } : {}) });
    });
  }

  private request(target: PoseTarget): PoseRequest {
    const layer = this.layer_of(target);
    return { op: 'pose', ...target, ...(layer ? { layer: layer.id } : {}), pins: [...this.pins(target.character)] };
  }

  private async ask(request: Request): Promise<Record<string, unknown> | null> {
    try {
      return await this.session.ask(request);
    } catch (error) {
      this.session.fail(error as Error);
      return null;
    }
  }

  /** Loads facts about the joints of a character's mechanism, if necessary. */
  async need_joints(character: string): Promise<void> {
    const mechanism = this.session.state.document && find_character(this.session.state.document, character)?.mechanism;
    if (!mechanism || this.state.joints[mechanism]) return;
    const reply = await this.ask({ op: 'joints', mechanism });
    if (reply) this.set({ joints: { ...this.state.joints, [mechanism]: reply.joints as JointFacts[] } });
  }

  /** Facts about the joints of a character's mechanism; null while they are loaded. */
  joints_of(character: string): readonly JointFacts[] | null {
    const mechanism = this.session.state.document && find_character(this.session.state.document, character)?.mechanism;
    return (mechanism && this.state.joints[mechanism]) || null;
  }

  // ---- layers and pins ----

  /** The layer that gets the keys of a clip; null: the clip has none. */
  layer_of(target: { character: string; clip: string }): KeyedLayer | null {
    const { document } = this.session.state;
    const clip = document && find_clip(document, target.character, target.clip);
    const usable = clip?.layers?.filter((l) => l.on !== false && l.weight > 0) ?? [];
    return usable.find((l) => l.id === this.state.layers[target.clip]) ?? usable[usable.length - 1] ?? null;
  }
  choose_layer(clip: string, layer: string): void {
    this.set({ layers: { ...this.state.layers, [clip]: layer } });
    this.update();
  }

  pins(character: string): readonly number[] {
    const { pins, reply, target } = this.state;
    return pins[character] ?? (target?.character === character ? (reply?.planted ?? []) : []);
  }
  /** Pins a link, or removes its pin. */
  toggle_pin(character: string, link: number): void {
    const now = this.pins(character);
    this.set({ pins: { ...this.state.pins, [character]: now.includes(link) ? now.filter((l) => l !== link) : [...now, link] } });
  }

  // ---- edits ----

  /** Begins a drag. @return false if nothing can be posed; then a message gives the reason */
  begin(): boolean {
    const { target, reply } = this.state;
    if (!target || !reply) {
      this.session.notify(this.why_not());
      return false;
    }
    this.base = this.state.pending ? reply.changed : [];
    this.before_drag = reply;
    this.live = null;
    this.drag_id = `${page_id}-${++this.drags}`;
    this.set({ dragging: true });
    return true;
  }

  /** Why nothing can be posed now, and what to do. */
  why_not(): string {
    const { state } = this.session;
    const character = selected_character(state);
    if (!character) return 'Select a character to pose it.';
    if (state.transport.mode !== 'edit') return 'Poses are edited in the mode Edit.';
    if (state.transport.playing) return 'Pause to edit the pose.';
    const posed = state.document && find_character(state.document, character);
    const name = posed?.name;
    if (posed?.track.length === 0) return `${name} has no clip. Poses are keys over a clip: drag a motion onto its track first.`;
    if (state.document && !clip_at(state.document, character, state.transport.time)) return `${name} has no clip at the playhead. Move the playhead onto a clip, or drag a motion there.`;
    return 'The pose is being loaded.';
  }

  /** Changes the pose, relative to that at the beginning of the drag. Of calls that come faster than answers, only the last is computed. */
  drag(edit: PoseEdit, free = false): void {
    this.next = { edit, free };
    if (edit.type === 'reach' && edit.moves === 'physics') this.live = this.next;
    this.running ??= this.run().finally(() => (this.running = null));
  }

  private async run(): Promise<void> {
    let last = performance.now();
    for (let job = this.next; job && this.state.target; job = this.next ?? this.live) {
      const { target } = this.state;
      this.next = null;
      const round = this.round;
      const now = performance.now();
      const { free } = job;
      const seconds = Math.min(max_drag_step, (now - last) / 1000);
      last = now;
      const edit: PoseEdit = job.edit.type === 'reach' && job.edit.moves === 'physics' ? { ...job.edit, drag: this.drag_id, seconds } : job.edit;
      const reply = (await this.ask({ ...this.request(target), from: this.base, edit, free })) as unknown as PoseReply | null;
      if (round !== this.round || !this.state.dragging) return;
      if (!reply) this.live = null;
      else this.set({ reply, pending: reply.changed.length > 0, shown: { character: target.character, links: reply.links } });
      if (this.live && !this.next) await new Promise((resolve) => setTimeout(resolve, live_wait));
    }
  }

  /** Ends a drag: sets keys, or without auto-key keeps the pose until it is keyed or the playhead moves. */
  async finish(label: string): Promise<void> {
    this.live = null;
    while (this.running) await this.running;
    if (!this.state.dragging) return;
    this.set({ dragging: false });
    if (this.state.auto_key && this.state.pending) await this.key_changes(label);
  }

  /** Ends a drag and restores the pose at its beginning. */
  cancel(): void {
    const { dragging, target } = this.state;
    if (!dragging || !target) return;
    this.next = this.live = null;
    const reply = this.before_drag;
    this.set({ dragging: false, reply, pending: this.base.length > 0, shown: reply && this.base.length > 0 ? { character: target.character, links: reply.links } : null });
  }

  /** Discards changes that are not keyed. @return whether there were any */
  restore(): boolean {
    if (this.state.dragging) {
      this.cancel();
      return true;
    }
    if (!this.state.pending) return false;
    this.asked = '';
    this.set({ pending: false, shown: null });
    this.update();
    return true;
  }

  /**
   * Switches posing on, if necessary, and waits for the pose of the selected character.
   * @return false if nothing can be posed; then a message gives the reason
   */
  async ready(): Promise<boolean> {
    this.switch_on(true);
    const limit = Date.now() + ready_wait;
    while (Date.now() < limit && !(this.state.target && this.state.reply)) await new Promise((resolve) => setTimeout(resolve, 30));
    if (this.state.target && this.state.reply) return true;
    this.session.notify(this.why_not());
    return false;
  }

  /** Coordinates of all joints of the present pose, with changes that are not keyed; null if nothing can be posed. */
  async capture(): Promise<NonNullable<PoseReply['joints']> | null> {
    if (!(await this.ready())) return null;
    const { target, reply, pending } = this.state;
    if (!target || !reply) return null;
    const answer = (await this.ask({ ...this.request(target), from: pending ? reply.changed : [], coordinates: true })) as unknown as PoseReply | null;
    return answer?.joints ?? null;
  }

  /** Applies one edit as a drag of its own. */
  async apply(edit: PoseEdit, label: string): Promise<void> {
    if (!this.begin()) return;
    this.drag(edit);
    await this.finish(label);
  }

  // ---- keys ----

  /** Sets keys for the joints that differ from the document. */
  key_changes(label = 'Pose'): Promise<boolean> {
    return this.set_keys((key) => key.moved, label);
  }
  /** Sets keys for one link (null: for all links) at the present pose. */
  key_links(link: string | null): Promise<boolean> {
    return this.set_keys((key) => link === null || key.link === link || (this.state.pending && key.moved), link === null ? 'Key the character' : 'Key the joint');
  }

  private async set_keys(wanted: (key: PoseReply['keys'][number]) => boolean, label: string): Promise<boolean> {
    const { target, reply } = this.state;
    const { document } = this.session.state;
    if (!target || !reply || !document) {
      this.session.notify(this.why_not());
      return false;
    }
    const layer = this.layer_of(target) ?? { id: this.session.fresh_id('l'), name: 'Pose', mode: 'additive' as const, weight: 1, ease_in: default_ease, ease_out: default_ease, joints: [] };
    const time = Math.round(reply.motion_time * 1e6) / 1e6;
    const put = reply.keys.filter(wanted).flatMap((key) => [...anchors(layer, key, time), { link: key.link, part: key.part, time, value: key.value }]);
    if (put.length === 0) return false;
    return this.send(key_command(document, target.character, target.clip, layer, { put }, label));
  }

  /** Changes keys of a layer of the target's clip. */
  async edit_keys(target: { character: string; clip: string }, layer: KeyedLayer, edit: { put?: KeyPut[]; take?: KeyName[] }, label: string): Promise<boolean> {
    const { document } = this.session.state;
    return document ? this.send(key_command(document, target.character, target.clip, layer, edit, label)) : false;
  }

  /** Sends a command that changes the pose. The pose stays drawn until a frame with the change has arrived. */
  async send(command: Command): Promise<boolean> {
    const { shown } = this.state;
    const { frames } = this.session;
    const received = frames.received;
    this.set({ pending: false });
    const ok = await this.session.edit(command);
    const release = (): void => {
      if (this.state.shown === shown && !this.state.dragging && !this.state.pending) this.set({ shown: null });
    };
    if (!ok) {
      this.asked = '';
      release();
      this.update();
      return false;
    }
    if (!shown || frames.received > received + 1) release();
    else {
      const stop = frames.on_frame(() => {
        stop();
        release();
      });
      setTimeout(() => {
        stop();
        release();
      }, frame_wait);
    }
    return true;
  }
}

/**
 * Keys of value 0 at the neighbouring key times of an additive layer, for a joint that has no key in it yet. Without them, its first key would
 * change the pose at all other keys of the layer too.
 */
function anchors(layer: KeyedLayer, key: { link: string; part: KeyPut['part']; value: number[] }, time: number): KeyPut[] {
  if (layer.mode !== 'additive' || find_joint(layer, key.link, part_of(key))) return [];
  const times = key_times(layer).filter((t) => Math.abs(t - time) >= same_key);
  const before = times.filter((t) => t < time).pop();
  const after = times.find((t) => t > time);
  return [before, after].flatMap((t) => (t === undefined ? [] : [{ link: key.link, part: key.part, time: t, value: key.value.map(() => 0) }]));
}

