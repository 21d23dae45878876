/** What a page shows before its engine is unpacked: the first frame. Nothing runs, and inputs have no effect. */
import { decode_frame, type Frame } from '../core/frames';
import { read_devices, type Devices } from '../core/play_controls';
import type { Engine, RecordedInput, Scene } from './engine';
import { from_base64 } from './payload';

export class StillEngine implements Engine {
  readonly steps = 0;
  readonly time = 0;
  readonly stopped = '';
  readonly variables: readonly number[];

  constructor(readonly scene: Scene, readonly devices: Devices, readonly frame: Frame) {
    this.variables = (scene.variables ?? []).map((v) => v.initial);
  }

  advance(): number {
    return 0;
  }
  step(): number {
    return 0;
  }
  reset(): void {}
  push(): void {}
  grab(): void {}
  drag(): void {}
  release(): void {}
  input(): void {}
  schedule(): void {}
  recorded(): RecordedInput[] {
    return [];
  }
  state_hash(): string {
    return '';
  }
  dispose(): void {}
}

/** @param data what publish::first_picture() has written, unpacked */
export function read_still(data: Uint8Array<ArrayBuffer>): StillEngine {
  const { scene, devices, frame } = JSON.parse(new TextDecoder().decode(data)) as { scene: Scene; devices: unknown; frame: string };
  const decoded = decode_frame(from_base64(frame).buffer);
  if (typeof decoded === 'string') throw new Error(decoded);
  return new StillEngine(scene, read_devices(devices), decoded);
}
