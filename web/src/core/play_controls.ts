/**
 * Play controls: while they are on, the state of keyboard, mouse and gamepads is sent to the content (docs/studio-protocol.md, `input`).
 * Only devices that the content reads are sent, only on change, at most 60 times a second. Framework-free; the page passes the events in.
 */
import { createStore, type StoreApi } from 'zustand/vanilla';

/** The devices that the running circuit reads. */
export interface Devices {
  /** Key codes as in KeyboardEvent.code. */
  keyboard: string[];
  mouse: boolean;
  gamepads: number[];
}
export const no_devices: Devices = { keyboard: [], mouse: false, gamepads: [] };

export const reads_anything = (d: Devices): boolean => d.keyboard.length > 0 || d.mouse || d.gamepads.length > 0;

export interface MouseState {
  /** Position over the viewport, 0 (left) ... 1 (right). */
  x: number;
  /** Position over the viewport, 0 (top) ... 1 (bottom). */
  y: number;
  left: boolean;
  middle: boolean;
  right: boolean;
  /** Wheel notches since the previous message; positive towards the user. */
  wheel: number;
}
export type PadState = { axes: number[]; buttons: number[] } | null;

/** A message to the content: the complete state of each device whose state changed. */
export interface InputMessage {
  keyboard?: string[];
  mouse?: MouseState;
  gamepads?: PadState[];
}

/** The part of the DOM's Gamepad that is used. */
export interface PadLike {
  axes: readonly number[];
  buttons: readonly { value: number }[];
}

/** Minimum time between two messages, ms. */
export const min_ms = 1000 / 60;
const max_keys = 64; // maximum number of pressed keys that are tracked; further keys are ignored
const max_pads = 4; // maximum number of gamepads that navigator.getGamepads() returns
const round = (v: number): number => Math.round(v * 1e4) / 1e4;

/** The clock that the controls use, in ms. An interface, so that tests can replace it. */
export interface Clock {
  now(): number;
  later(task: () => void, ms: number): unknown;
}

export class PlayControls {
  readonly store: StoreApi<{ on: boolean; devices: Devices; held: string[] }> = createStore(() => ({ on: false, devices: no_devices, held: [] as string[] }));
  private keys = new Set<string>();
  /** Pressed since the last message. */
  private readonly unsent = new Set<string>();
  private mouse: MouseState = { x: 0.5, y: 0.5, left: false, middle: false, right: false, wheel: 0 };
  private pads: PadState[] = [];
  /** State last sent to the service, as JSON text, by device. */
  private readonly sent: Record<string, string> = {};
  /** Time of the last message, ms. */
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

  /** Sets the devices that the content reads; turns the controls off if it reads none. */
  set_devices(devices: Devices): void {
    this.store.setState({ devices });
    if (this.on && !reads_anything(devices)) this.leave();
    else this.changed();
  }

  /** Turns the controls on; does nothing if the content reads no device. */
  enter(): void {
    if (this.on || !reads_anything(this.devices)) return;
    for (const key of Object.keys(this.sent)) delete this.sent[key]; // send the complete state: another page may have sent input meanwhile
    this.store.setState({ on: true });
    this.changed();
  }

  /** Releases all keys and buttons, sends the released state, and turns the controls off. */
  leave(): void {
    if (!this.on) return;
    this.release();
    this.flush();
    this.store.setState({ on: false });
  }

  /** Turns the controls off without a message: on a new connection the service has already released all devices. */
  forget(): void {
    for (const key of Object.keys(this.sent)) delete this.sent[key];
    this.store.setState({ on: false, held: [] });
    this.keys.clear();
  }

  /** Releases all keys, buttons and axes: the window lost the keyboard focus. */
  release(): void {
    this.keys.clear();
    this.mouse = { ...this.mouse, left: false, middle: false, right: false, wheel: 0 };
    this.pads = this.pads.map((pad) => pad && { axes: pad.axes.map(() => 0), buttons: pad.buttons.map(() => 0) });
    this.changed();
  }

  /** @param code KeyboardEvent.code  @param down true if pressed */
  key(code: string, down: boolean): void {
    if (!/^[A-Za-z0-9]{1,32}$/.test(code) || this.keys.has(code) === down) return;
    if (down) {
      if (this.keys.size >= max_keys) return;
      this.keys.add(code);
      this.unsent.add(code);
    } else {
      if (this.unsent.has(code)) this.flush(); // a tap shorter than the time between two messages
      this.keys.delete(code);
    }
    this.changed();
  }

  /** @param x, y 0 ... 1 over the viewport  @param buttons PointerEvent.buttons */
  pointer(x: number, y: number, buttons: number): void {
    const clamp = (v: number): number => round(Math.min(1, Math.max(0, v)));
    this.mouse = { ...this.mouse, x: clamp(x), y: clamp(y), left: (buttons & 1) !== 0, right: (buttons & 2) !== 0, middle: (buttons & 4) !== 0 };
    this.changed();
  }

  /** @param delta WheelEvent.deltaY  @param mode WheelEvent.deltaMode */
  wheel(delta: number, mode: number): void {
    this.mouse = { ...this.mouse, wheel: round(this.mouse.wheel + delta / (mode === 1 ? 3 : mode === 2 ? 1 : 100)) };
    this.changed();
  }

  /** Takes the result of navigator.getGamepads(); call it once for each animation frame while gamepads are read. */
  gamepads(found: readonly (PadLike | null)[]): void {
    this.pads = Array.from({ length: Math.min(max_pads, found.length) }, (_, i) => {
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
    const rest = this.last + min_ms - this.clock.now();
    if (rest <= 0) return this.flush();
    this.waiting = true;
    this.clock.later(() => {
      this.waiting = false;
      this.flush();
    }, rest);
  }

  /** Sends the state of the devices that the content reads and whose state changed. */
  private flush(): void {
    this.unsent.clear();
    if (!this.on) return;
    const { keyboard, mouse, gamepads } = this.devices;
    const message: InputMessage = {};
    const differs = (device: string, state: unknown): boolean => {
      const text = JSON.stringify(state);
      if (this.sent[device] === text) return false;
      this.sent[device] = text;
      return true;
    };
    const keys = keyboard.filter((code) => this.keys.has(code));
    if (keyboard.length > 0 && differs('keyboard', keys)) message.keyboard = keys;
    if (mouse) {
      const turned = this.mouse.wheel !== 0;
      const { wheel: _wheel, ...position_and_buttons } = this.mouse;
      if (differs('mouse', position_and_buttons) || turned) message.mouse = this.mouse;
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

/** Short name of a KeyboardEvent.code: "W", "5", "Space". */
export const name_key = (code: string): string => names[code] ?? code.replace(/^Key(?=[A-Z]$)/, '').replace(/^Digit(?=\d$)/, '');

/** The devices that the content reads, as text for the user: "W  A · mouse · gamepad". */
export function describe_devices(devices: Devices): string {
  const keys = devices.keyboard.slice(0, 10).map(name_key).join('  ');
  const more = devices.keyboard.length > 10 ? ' …' : '';
  const pads = devices.gamepads.length === 0 ? '' : devices.gamepads.length === 1 ? 'gamepad' : `${devices.gamepads.length} gamepads`;
  return [keys && keys + more, devices.mouse && 'mouse', pads].filter(Boolean).join(' · ');
}

/** Devices from a `devices` event or `hello`. Values of a wrong type are ignored. */
export function read_devices(value: unknown): Devices {
  const { keyboard, mouse, gamepads } = (typeof value === 'object' && value !== null ? value : {}) as Record<string, unknown>;
  return {
    keyboard: Array.isArray(keyboard) ? keyboard.filter((k): k is string => typeof k === 'string') : [],
    mouse: mouse === true,
    gamepads: Array.isArray(gamepads) ? gamepads.filter((g): g is number => Number.isInteger(g) && g >= 0 && g < max_pads) : [],
  };
}
