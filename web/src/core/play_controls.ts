/**
 * Play controls: while they are on, what the user holds in hand goes to the content (docs/studio-protocol.md, `input`): only the devices
 * that the content reads, only on change, at most 60 times a second. Framework-free; the page brings the events.
 */
import { createStore, type StoreApi } from 'zustand/vanilla';

/** What the running circuit reads. */
export interface Devices {
  /** KeyboardEvent.code */
  keyboard: string[];
  mouse: boolean;
  gamepads: number[];
}
export const no_devices: Devices = { keyboard: [], mouse: false, gamepads: [] };

export const reads_anything = (d: Devices): boolean => d.keyboard.length > 0 || d.mouse || d.gamepads.length > 0;

export interface MouseState {
  x: number;
  y: number;
  left: boolean;
  middle: boolean;
  right: boolean;
  /** Notches since the message before, towards the user positive. */
  wheel: number;
}
export type PadState = { axes: number[]; buttons: number[] } | null;

/** The whole state of each device that it names. */
export interface InputMessage {
  keyboard?: string[];
  mouse?: MouseState;
  gamepads?: PadState[];
}

/** The part of a Gamepad that counts. */
export interface PadLike {
  axes: readonly number[];
  buttons: readonly { value: number }[];
}

export const least_ms = 1000 / 60;
const most_keys = 64;
const most_pads = 4;
const round = (v: number): number => Math.round(v * 1e4) / 1e4;

export interface Clock {
  now(): number;
  later(task: () => void, ms: number): unknown;
}

export class PlayControls {
  readonly store: StoreApi<{ on: boolean; devices: Devices; held: string[] }> = createStore(() => ({ on: false, devices: no_devices, held: [] as string[] }));
  private keys = new Set<string>();
  private mouse: MouseState = { x: 0.5, y: 0.5, left: false, middle: false, right: false, wheel: 0 };
  private pads: PadState[] = [];
  /** What the service knows, as text, by device. */
  private readonly told: Record<string, string> = {};
  private last = -Infinity;
  private waiting = false;

  constructor(
    private readonly send: (message: InputMessage) => void,
    private readonly clock: Clock = { now: () => performance.now(), later: (task, ms) => setTimeout(task, ms) },
  ) {}

  get on(): boolean {
    return this.store.getState().on;
  }
  get devices(): Devices {
    return this.store.getState().devices;
  }

  /** The content reads other devices from now on. */
  set_devices(devices: Devices): void {
    this.store.setState({ devices });
    if (this.on && !reads_anything(devices)) this.leave();
    else this.changed();
  }

  enter(): void {
    if (this.on || !reads_anything(this.devices)) return;
    for (const key of Object.keys(this.told)) delete this.told[key]; // another page may have spoken since
    this.store.setState({ on: true });
    this.changed();
  }

  /** Everything is let go. */
  leave(): void {
    if (!this.on) return;
    this.let_go();
    this.flush();
    this.store.setState({ on: false });
  }

  /** The connection is a new one: the service let go of everything. */
  forget(): void {
    for (const key of Object.keys(this.told)) delete this.told[key];
    this.store.setState({ on: false, held: [] });
    this.keys.clear();
  }

  /** Nothing is held any more: the window lost the keyboard. */
  let_go(): void {
    this.keys.clear();
    this.mouse = { ...this.mouse, left: false, middle: false, right: false, wheel: 0 };
    this.pads = this.pads.map((pad) => pad && { axes: pad.axes.map(() => 0), buttons: pad.buttons.map(() => 0) });
    this.changed();
  }

  key(code: string, down: boolean): void {
    if (!/^[A-Za-z0-9]{1,32}$/.test(code) || this.keys.has(code) === down) return;
    if (!down) this.keys.delete(code);
    else if (this.keys.size < most_keys) this.keys.add(code);
    this.changed();
  }

  /** @param x, y 0 ... 1 over the viewport  @param buttons PointerEvent.buttons */
  pointer(x: number, y: number, buttons: number): void {
    const clamp = (v: number): number => round(Math.min(1, Math.max(0, v)));
    this.mouse = { ...this.mouse, x: clamp(x), y: clamp(y), left: (buttons & 1) !== 0, right: (buttons & 2) !== 0, middle: (buttons & 4) !== 0 };
    this.changed();
  }

  /** A WheelEvent's deltaY and deltaMode. */
  wheel(delta: number, mode: number): void {
    this.mouse = { ...this.mouse, wheel: round(this.mouse.wheel + delta / (mode === 1 ? 3 : mode === 2 ? 1 : 100)) };
    this.changed();
  }

  /** As navigator.getGamepads() has them; to be called for each picture while they are read. */
  gamepads(found: readonly (PadLike | null)[]): void {
    this.pads = Array.from({ length: Math.min(most_pads, found.length) }, (_, i) => {
      const pad = found[i];
      return pad ? { axes: pad.axes.map(round), buttons: pad.buttons.map((b) => round(b.value)) } : null;
    });
    this.changed();
  }

  private changed(): void {
    if (!this.on) return;
    const held = this.devices.keyboard.filter((code) => this.keys.has(code));
    if (held.join() !== this.store.getState().held.join()) this.store.setState({ held });
    if (this.waiting) return;
    const rest = this.last + least_ms - this.clock.now();
    if (rest <= 0) return this.flush();
    this.waiting = true;
    this.clock.later(() => {
      this.waiting = false;
      this.flush();
    }, rest);
  }

  /** Sends what changed of what the content reads. */
  private flush(): void {
    if (!this.on) return;
    const { keyboard, mouse, gamepads } = this.devices;
    const message: InputMessage = {};
    const differs = (device: string, state: unknown): boolean => {
      const text = JSON.stringify(state);
      if (this.told[device] === text) return false;
      this.told[device] = text;
      return true;
    };
    const keys = keyboard.filter((code) => this.keys.has(code));
    if (keyboard.length > 0 && differs('keyboard', keys)) message.keyboard = keys;
    if (mouse) {
      const turned = this.mouse.wheel !== 0;
      const { wheel: _wheel, ...place } = this.mouse;
      if (differs('mouse', place) || turned) message.mouse = this.mouse;
      this.mouse = { ...this.mouse, wheel: 0 };
    }
    const pads = this.pads.map((pad, i) => (gamepads.includes(i) ? pad : null));
    if (gamepads.length > 0 && differs('gamepads', pads)) message.gamepads = pads;
    if (Object.keys(message).length === 0) return;
    this.last = this.clock.now();
    this.send(message);
  }
}

const names: Record<string, string> = {
  ArrowLeft: '←', ArrowRight: '→', ArrowUp: '↑', ArrowDown: '↓', ShiftLeft: 'Shift', ShiftRight: 'right Shift', ControlLeft: 'Ctrl', ControlRight: 'right Ctrl',
};

/** "W", "5", "Space" of a KeyboardEvent.code. */
export const name_key = (code: string): string => names[code] ?? code.replace(/^Key(?=[A-Z]$)/, '').replace(/^Digit(?=\d$)/, '');

/** What the content reads, in words. */
export function describe_devices(devices: Devices): string {
  const keys = devices.keyboard.slice(0, 10).map(name_key).join('  ');
  const more = devices.keyboard.length > 10 ? ' …' : '';
  const pads = devices.gamepads.length === 0 ? '' : devices.gamepads.length === 1 ? 'gamepad' : `${devices.gamepads.length} gamepads`;
  return [keys && keys + more, devices.mouse && 'mouse', pads].filter(Boolean).join(' · ');
}

/** Of an event or `hello`; whatever it is, only what has the right form counts. */
export function read_devices(value: unknown): Devices {
  const { keyboard, mouse, gamepads } = (typeof value === 'object' && value !== null ? value : {}) as Record<string, unknown>;
  return {
    keyboard: Array.isArray(keyboard) ? keyboard.filter((k): k is string => typeof k === 'string') : [],
    mouse: mouse === true,
    gamepads: Array.isArray(gamepads) ? gamepads.filter((g): g is number => Number.isInteger(g) && g >= 0 && g < most_pads) : [],
  };
}
