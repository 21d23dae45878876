import { describe, expect, it, vi } from 'vitest';
import { frame_magic, frame_version } from '../src/core/frames';
import { no_devices } from '../src/core/play_controls';
import type { Scene } from '../src/player/engine';
import { RemoteEngine } from '../src/player/remote_engine';

/** A connection whose other end the test plays. */
class Connection extends EventTarget {
  readyState = 1; // WebSocket.OPEN
  readonly sent: { op: string; id?: number; seconds?: number }[] = [];
  send(text: string): void {
    this.sent.push(JSON.parse(text));
  }
  close(): void {}
  receive(data: string | ArrayBuffer): void {
    this.dispatchEvent(new MessageEvent('message', { data }));
  }
  frame(time: number): void {
    const view = new DataView(new ArrayBuffer(64));
    view.setUint32(0, frame_magic, true);
    view.setUint32(4, frame_version, true);
    view.setFloat64(8, time, true);
    this.receive(view.buffer);
  }
  /** Answers the latest request, and lets the page take notice. */
  async answer(): Promise<void> {
    this.receive(JSON.stringify({ event: 'done', id: this.sent.at(-1)!.id }));
    await Promise.resolve();
    await Promise.resolve();
  }
}

vi.stubGlobal('WebSocket', { OPEN: 1 }); // Node.js 18 has none

function connected(): { connection: Connection; engine: RemoteEngine } {
  const connection = new Connection();
  const engine = new RemoteEngine(connection as unknown as WebSocket, { step: 0.01, duration: 10 } as Scene, no_devices);
  return { connection, engine };
}

describe('RemoteEngine', () => {
  it('returns the time that the program has passed, once', () => {
    const { connection, engine } = connected();
    connection.frame(0);
    expect(engine.advance(0.05, 10)).toBe(0);
    expect(connection.sent).toEqual([{ op: 'advance', seconds: 0.05, budget: 0.01 }]);
    connection.frame(0.05);
    expect(engine.advance(0.05, 10)).toBeCloseTo(0.05);
    expect(engine.advance(0, 10)).toBe(0);
    expect(engine.time).toBeCloseTo(0.05);
  });

  it('is at time 0 from a reset on; frames from before it do not count as time that has passed', async () => {
    const { connection, engine } = connected();
    connection.frame(0);
    engine.advance(5, 10);
    connection.frame(5);
    expect(engine.advance(0.02, 10)).toBeCloseTo(5);
    engine.reset();
    expect(engine.time).toBe(0);
    expect(engine.advance(0.02, 10)).toBe(0);
    connection.frame(5.02); // answers the request that was sent before the reset
    expect(engine.time).toBe(0);
    expect(engine.advance(0.02, 10)).toBe(0);
    connection.frame(0);
    await connection.answer();
    expect(engine.advance(0.02, 10)).toBe(0);
    expect(connection.sent.at(-1)).toMatchObject({ op: 'advance', seconds: 0.02 });
    connection.frame(0.02);
    expect(engine.advance(0.02, 10)).toBeCloseTo(0.02);
  });

  it('does not stop a run that was reset for what happened before', async () => {
    const { connection, engine } = connected();
    engine.reset();
    connection.receive(JSON.stringify({ event: 'stopped', reason: 'The velocity has blown up.' }));
    connection.frame(0);
    await connection.answer();
    expect(engine.stopped).toBe('');
    connection.receive(JSON.stringify({ event: 'stopped', reason: 'The velocity has blown up.' }));
    expect(engine.stopped).toBe('The velocity has blown up.');
  });
});
