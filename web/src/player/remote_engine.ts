/**
 * The engine in a native program that serves this page (docs/export.md, "A native program"). The page is the clock: it requests the time that
 * has passed since the last picture, and the program answers with a frame. At most one such request waits for its answer.
 */
import { Access } from '../core/access';
import { decode_frame, type Frame } from '../core/frames';
import { read_devices, type Devices, type InputMessage } from '../core/play_controls';
import type { Vec3 } from '../core/protocol';
import type { Engine, RecordedInput, Scene } from './engine';

interface Answer {
  event?: 'scene' | 'done' | 'stopped' | 'variables';
  scene?: Scene;
  devices?: unknown;
  id?: number;
  result?: unknown;
  error?: string;
  reason?: string;
  values?: number[];
}

export class RemoteEngine implements Engine {
  stopped = '';
  frame: Frame | null = null;
  variables: number[] = [];
  private asked = false;
  private reported = 0; // s: sum of the times that advance() has returned
  private returning = 0; // resets that the program has not answered; until then frames can be of the time before
  private last_id = 0;
  private readonly waiting = new Map<number, { done: (value: unknown) => void; failed: (error: Error) => void }>();

  constructor(private readonly socket: WebSocket, readonly scene: Scene, readonly devices: Devices) {
    socket.addEventListener('message', (event: MessageEvent<string | ArrayBuffer>) => this.receive(event.data));
    socket.addEventListener('close', () => {
      if (this.stopped === '') this.stopped = 'The program that runs this content has ended. Start the program again.';
      for (const { failed } of this.waiting.values()) failed(new Error(this.stopped));
      this.waiting.clear();
    });
  }

  get time(): number {
    return this.returning > 0 ? 0 : (this.frame?.time ?? 0);
  }
  get steps(): number {
    return Math.round(this.time / this.scene.step);
  }

  advance(seconds: number, budget: number): number {
    if (this.returning > 0) return 0;
    const passed = Math.max(0, this.time - this.reported);
    this.reported = this.time;
    if (!this.asked && seconds - passed >= this.scene.step && this.stopped === '') {
      this.asked = true;
      this.send({ op: 'advance', seconds: seconds - passed, budget: budget / 1000 });
    }
    return passed;
  }
  async step(count: number): Promise<number> {
    return Number(await this.ask({ op: 'step', count }));
  }
  reset(): void {
    this.stopped = '';
    this.reported = 0;
    this.returning++;
    const answered = (): void => void this.returning--;
    this.ask({ op: 'reset' }).then(answered, answered);
  }
  push(character: number, link: number, force: Vec3, duration: number): void {
    this.send({ op: 'push', character, link, force, duration });
  }
  grab(character: number, link: number, point: Vec3, target: Vec3): void {
    this.send({ op: 'grab', character, link, point, target });
  }
  drag(target: Vec3): void {
    this.send({ op: 'drag', target });
  }
  release(): void {
    this.send({ op: 'release' });
  }
  input(message: InputMessage): void {
    this.send({ op: 'input', ...message });
  }
  async schedule(inputs: RecordedInput[]): Promise<void> {
    await this.ask({ op: 'schedule', inputs });
  }
  async recorded(): Promise<RecordedInput[]> {
    return (await this.ask({ op: 'recorded' })) as RecordedInput[];
  }
  async state_hash(): Promise<string> {
    return String(await this.ask({ op: 'hash' }));
  }
  dispose(): void {
    this.socket.close();
  }

  private send(message: object): void {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }
  private ask(message: object): Promise<unknown> {
    const id = ++this.last_id;
    return new Promise((done, failed) => {
      this.waiting.set(id, { done, failed });
      this.send({ ...message, id });
    });
  }
  private receive(data: string | ArrayBuffer): void {
    if (typeof data !== 'string') {
      const frame = decode_frame(data);
      if (typeof frame === 'string') {
        this.stopped = frame;
        return;
      }
      if (frame.time < this.reported) this.reported = frame.time; // another page reset the program
      this.frame = frame;
      this.asked = false;
      return;
    }
    const answer = JSON.parse(data) as Answer;
    if (answer.event === 'stopped') {
      this.asked = false;
      if (this.returning === 0) this.stopped = answer.reason ?? 'The run stopped.';
    }
    if (answer.event === 'variables') this.variables = answer.values ?? [];
    const asker = this.waiting.get(answer.id ?? -1);
    if (!asker) return;
    this.waiting.delete(answer.id!);
    if (answer.error !== undefined) asker.failed(new Error(answer.error));
    else asker.done(answer.result);
  }
}

/** Connects to the program that served this page. */
export async function open_remote_engine(): Promise<RemoteEngine> {
  const access = new Access({
    fragment: () => location.hash,
    clear_fragment: () => history.replaceState(null, '', location.pathname + location.search),
    storage: sessionStorage,
    fetch: (path, init) => fetch(path, init),
  });
  if ((await access.enter()) === 'refused') throw new Error('This page has no access to the program. Open the complete address that the program printed.');
  const socket = new WebSocket(`${location.origin.replace(/^http/, 'ws')}/ws`, access.subprotocols);
  socket.binaryType = 'arraybuffer';
  return new Promise((done, failed) => {
    let engine: RemoteEngine | null = null;
    const lost = (): void => failed(new Error('The program does not answer. Start the program again.'));
    socket.addEventListener('error', lost);
    socket.addEventListener('close', lost);
    socket.addEventListener('message', (event: MessageEvent<string | ArrayBuffer>) => {
      if (typeof event.data === 'string') {
        const first = JSON.parse(event.data) as Answer;
        if (!engine && first.event === 'scene' && first.scene) engine = new RemoteEngine(socket, first.scene, read_devices(first.devices));
      } else if (engine) {
        done(engine); // the program sends the scene, then the first frame
      }
    });
    socket.addEventListener('open', () => socket.send(JSON.stringify({ op: 'hello' })));
  });
}
