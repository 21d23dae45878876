/** The engine as WebAssembly, in this page. The module is built from apps/player_wasm. */
import { decode_frame, type Frame } from '../core/frames';
import { read_devices, type Devices, type InputMessage } from '../core/play_controls';
import type { Vec3 } from '../core/protocol';
import type { Engine, RecordedInput, Scene } from './engine';

interface Exports {
  memory: WebAssembly.Memory;
  _initialize(): void;
  ugoki_allocate(size: number): number;
  ugoki_release(address: number): void;
  ugoki_open(address: number, size: number): number;
  ugoki_step(count: number): number;
  ugoki_reset(): void;
  ugoki_time(): number;
  ugoki_steps(): number;
  ugoki_hash_low(): number;
  ugoki_hash_high(): number;
  ugoki_frame(number: number, flags: number): number;
  ugoki_frame_size(): number;
  ugoki_push(character: number, link: number, x: number, y: number, z: number, duration: number): void;
  ugoki_grab(character: number, link: number, px: number, py: number, pz: number, tx: number, ty: number, tz: number): void;
  ugoki_drag(x: number, y: number, z: number): void;
  ugoki_drop(): void;
  ugoki_input(address: number, size: number): number;
  ugoki_devices(): number;
  ugoki_scene(): number;
  ugoki_variables(): number;
  ugoki_schedule(address: number, size: number): number;
  ugoki_inputs(): number;
  ugoki_message(): number;
  ugoki_message_size(): number;
}

const simulate_flag = 2; // bit of the frame's flags: the frame comes from the simulation

/** An error of the engine or of the content, with the engine's message. */
export class EngineError extends Error {}

export class WasmEngine implements Engine {
  readonly scene: Scene;
  readonly devices: Devices;
  stopped = '';
  private readonly decoder = new TextDecoder();
  private readonly encoder = new TextEncoder();
  private current: Frame | null = null;
  private stale = true;

  /** @param content executable data (*.ugx). Throws an EngineError if they are refused. */
  constructor(private readonly wasm: Exports, content: Uint8Array) {
    const opened = this.with_bytes(content, (address, size) => wasm.ugoki_open(address, size));
    if (opened !== 1) throw new EngineError(this.message());
    wasm.ugoki_scene();
    this.scene = JSON.parse(this.message()) as Scene;
    wasm.ugoki_devices();
    this.devices = read_devices(JSON.parse(this.message()));
  }

  get steps(): number {
    return this.wasm.ugoki_steps();
  }
  get time(): number {
    return this.wasm.ugoki_time();
  }
  get frame(): Frame | null {
    if (this.stale) {
      const number = Math.round(this.time * this.scene.frame_rate);
      const address = this.wasm.ugoki_frame(number, simulate_flag);
      const bytes = new Uint8Array(this.wasm.memory.buffer, address, this.wasm.ugoki_frame_size()).slice();
      const decoded = decode_frame(bytes.buffer);
      if (typeof decoded === 'string') throw new EngineError(decoded);
      this.current = decoded;
      this.stale = false;
    }
    return this.current;
  }

  get variables(): number[] {
    const count = this.scene.variables?.length ?? 0;
    return count === 0 ? [] : [...new Float64Array(this.wasm.memory.buffer, this.wasm.ugoki_variables(), count)];
  }

  advance(seconds: number, budget: number): number {
    const { step } = this.scene;
    const deadline = performance.now() + budget;
    let left = Math.floor(seconds / step + 1e-6);
    let done = 0;
    let together = 1; // number of steps between two readings of the clock; one step takes between 0.02 ms and hundreds of ms
    while (left > 0 && this.stopped === '') {
      const before = performance.now();
      const count = this.step(Math.min(left, together));
      done += count;
      left -= count;
      const now = performance.now();
      if (now > deadline) break;
      together = now - before < 1 ? 4 : 1;
    }
    return done * step;
  }

  step(count: number): number {
    if (this.stopped !== '') return 0;
    let done = 0;
    try {
      done = this.wasm.ugoki_step(count);
      if (done < count) this.stopped = this.message();
    } catch (error) {
      this.stopped = `The engine ended: ${(error as Error).message}. The content needs more memory than the player allows.`;
    }
    this.stale = true;
    return done;
  }

  reset(): void {
    this.wasm.ugoki_reset();
    this.stopped = '';
    this.stale = true;
  }

  push(character: number, link: number, force: Vec3, duration: number): void {
    this.wasm.ugoki_push(character, link, ...force, duration);
  }
  grab(character: number, link: number, point: Vec3, target: Vec3): void {
    this.wasm.ugoki_grab(character, link, ...point, ...target);
  }
  drag(target: Vec3): void {
    this.wasm.ugoki_drag(...target);
  }
  release(): void {
    this.wasm.ugoki_drop();
  }
  input(message: InputMessage): void {
    if (this.with_text(JSON.stringify(message), (address, size) => this.wasm.ugoki_input(address, size)) !== 1) throw new EngineError(this.message());
  }

  schedule(inputs: RecordedInput[]): void {
    if (this.with_text(JSON.stringify({ inputs }), (address, size) => this.wasm.ugoki_schedule(address, size)) !== 1) throw new EngineError(this.message());
  }
  recorded(): RecordedInput[] {
    this.wasm.ugoki_inputs();
    return (JSON.parse(this.message()) as { inputs: RecordedInput[] }).inputs;
  }
  state_hash(): string {
    const half = (value: number): string => (value >>> 0).toString(16).padStart(8, '0');
    return half(this.wasm.ugoki_hash_high()) + half(this.wasm.ugoki_hash_low());
  }
  dispose(): void {
    // The browser frees the memory of the module with the instance.
  }

  private message(): string {
    const address = this.wasm.ugoki_message();
    return this.decoder.decode(new Uint8Array(this.wasm.memory.buffer, address, this.wasm.ugoki_message_size()));
  }
  private with_text(text: string, call: (address: number, size: number) => number): number {
    return this.with_bytes(this.encoder.encode(text), call);
  }
  private with_bytes(bytes: Uint8Array, call: (address: number, size: number) => number): number {
    const address = this.wasm.ugoki_allocate(Math.max(bytes.length, 1));
    if (address === 0) throw new EngineError('The content does not fit into the memory of the player.');
    new Uint8Array(this.wasm.memory.buffer, address, bytes.length).set(bytes);
    try {
      return call(address, bytes.length);
    } finally {
      this.wasm.ugoki_release(address);
    }
  }
}

/** Compiles the module and opens content. @param module bytes of ugoki_player.wasm */
export async function open_wasm_engine(module: Uint8Array<ArrayBuffer>, content: Uint8Array): Promise<WasmEngine> {
  let output = '';
  let exports: Exports | null = null;
  const write = (_file: number, vectors: number, count: number, written: number): number => {
    const buffer = exports!.memory.buffer;
    const view = new DataView(buffer);
    let total = 0;
    for (let i = 0; i < count; i++) {
      const size = view.getUint32(vectors + 8 * i + 4, true);
      output += new TextDecoder().decode(new Uint8Array(buffer, view.getUint32(vectors + 8 * i, true), size));
      total += size;
    }
    view.setUint32(written, total, true);
    return 0;
  };
  const bad_descriptor = (): number => 8; // WASI error code EBADF
  const { instance } = await WebAssembly.instantiate(module, {
    wasi_snapshot_preview1: {
      fd_write: write,
      fd_close: bad_descriptor,
      fd_seek: bad_descriptor,
      fd_fdstat_get: bad_descriptor,
      proc_exit: (status: number) => {
        throw new EngineError(`The engine ended with status ${status}. ${output}`);
      },
    },
  });
  exports = instance.exports as unknown as Exports;
  exports._initialize();
  return new WasmEngine(exports, content);
}
