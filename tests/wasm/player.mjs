// Runs the WebAssembly player in Node.js and provides the WASI functions that it imports.
import { readFileSync } from "node:fs";

const decoder = new TextDecoder();

export class WasmPlayer {
  constructor(file) {
    this.module = new WebAssembly.Module(readFileSync(file));
    this.output = "";
    const fdWrite = (fd, vectors, count, written) => {
      const view = new DataView(this.memory.buffer);
      let total = 0;
      for (let i = 0; i < count; ++i) {
        const address = view.getUint32(vectors + 8 * i, true);
        const size = view.getUint32(vectors + 8 * i + 4, true);
        this.output += decoder.decode(new Uint8Array(this.memory.buffer, address, size));
        total += size;
      }
      view.setUint32(written, total, true);
      return 0;
    };
    const badDescriptor = () => 8; // WASI error code EBADF
    this.offered = {
      fd_write: fdWrite,
      fd_close: badDescriptor,
      fd_seek: badDescriptor,
      fd_fdstat_get: badDescriptor,
      proc_exit: (status) => {
        throw new Error(`the player exited with status ${status}: ${this.output}`);
      },
    };
    this.exports = new WebAssembly.Instance(this.module, { wasi_snapshot_preview1: this.offered }).exports;
    this.exports._initialize();
  }

  get memory() {
    return this.exports.memory;
  }

  /** Opens executable data. Returns true on success; otherwise `message` contains the error. */
  open(bytes) {
    const address = this.exports.ugoki_allocate(Math.max(bytes.length, 1));
    new Uint8Array(this.memory.buffer, address, bytes.length).set(bytes);
    const opened = this.exports.ugoki_open(address, bytes.length) === 1;
    this.exports.ugoki_release(address);
    return opened;
  }

  /** Sets the state of keyboard, mouse and gamepads, as JSON with the fields of the protocol's message `input`. Returns true on success. */
  input(text) {
    const bytes = new TextEncoder().encode(text);
    const address = this.exports.ugoki_allocate(Math.max(bytes.length, 1));
    new Uint8Array(this.memory.buffer, address, bytes.length).set(bytes);
    const accepted = this.exports.ugoki_input(address, bytes.length) === 1;
    this.exports.ugoki_release(address);
    return accepted;
  }

  /** The keys, mouse and gamepads that the content reads. */
  get devices() {
    this.exports.ugoki_devices();
    return JSON.parse(this.message);
  }

  /** Text of the last function that returns a text, for example an error message. */
  get message() {
    const address = this.exports.ugoki_message();
    return decoder.decode(new Uint8Array(this.memory.buffer, address, this.exports.ugoki_message_size()));
  }

  /** State hash as 16 hexadecimal digits. */
  get hash() {
    const half = (value) => (value >>> 0).toString(16).padStart(8, "0");
    return half(this.exports.ugoki_hash_high()) + half(this.exports.ugoki_hash_low());
  }

  /** A copy of the display frame's bytes. */
  frame(number) {
    const address = this.exports.ugoki_frame(number, 0);
    return new Uint8Array(this.memory.buffer, address, this.exports.ugoki_frame_size()).slice();
  }
}
