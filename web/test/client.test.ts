import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { Client, LatestOnly, retry_delay, type ClientHandlers, type SocketLike } from '../src/core/client';
import { RequestError } from '../src/core/protocol';
import { Session } from '../src/core/session';
import { initial_state, read_choices } from '../src/core/state';
import { sample_document } from './sample';

class FakeSocket implements SocketLike {
  binaryType = '';
  readyState = 0;
  sent: Record<string, unknown>[] = [];
  onopen: SocketLike['onopen'] = null;
  onclose: SocketLike['onclose'] = null;
  onerror: SocketLike['onerror'] = null;
  onmessage: SocketLike['onmessage'] = null;
  send(data: string): void {
    this.sent.push(JSON.parse(data) as Record<string, unknown>);
  }
  close(): void {
    this.lose();
  }
  open(): void {
    this.readyState = 1;
    this.onopen?.({});
  }
  lose(): void {
    this.readyState = 3;
    this.onclose?.({ code: 1006 });
  }
  deliver(message: unknown): void {
    this.onmessage?.({ data: typeof message === 'string' || message instanceof ArrayBuffer ? message : JSON.stringify(message) });
  }
  answer(more: Record<string, unknown> = {}): void {
    const last = this.sent.at(-1)!;
    this.deliver({ reply: last.id, ok: true, ...more });
  }
}

const sockets: FakeSocket[] = [];
const make_socket = (): FakeSocket => {
  const socket = new FakeSocket();
  sockets.push(socket);
  return socket;
};
const handlers = () => ({ connected: vi.fn(), disconnected: vi.fn(), event: vi.fn(), frame: vi.fn(), protocol_error: vi.fn() }) satisfies ClientHandlers;

beforeEach(() => {
  vi.useFakeTimers();
  sockets.length = 0;
});
afterEach(() => vi.useRealTimers());

const hello = () => ({
  project: { path: 'p.ugoki', name: 'p', unsaved: false },
  document: sample_document(),
  revision: 1,
  can_undo: false,
  can_redo: false,
  undo_label: '',
  redo_label: '',
  characters: [],
  transport: { mode: 'edit', playing: false, speed: 1, time: 0, duration: 20, simulated: 0, steps_per_s: 0, realtime_factor: 0, status: '' },
});

describe('Client', () => {
  it('sends hello when it connects and when it reconnects', async () => {
    const h = handlers();
    const client = new Client(make_socket, h);
    client.connect();
    sockets[0]!.open();
    expect(sockets[0]!.sent[0]).toMatchObject({ op: 'hello' });
    sockets[0]!.answer(hello());
    await vi.advanceTimersByTimeAsync(0);
    expect(h.connected).toHaveBeenCalledOnce();
    sockets[0]!.lose();
    expect(h.disconnected).toHaveBeenCalledWith(250);
    await vi.advanceTimersByTimeAsync(250);
    sockets[1]!.open();
    sockets[1]!.answer(hello());
    await vi.advanceTimersByTimeAsync(0);
    expect(h.connected).toHaveBeenCalledTimes(2);
  });

  it('doubles the delay after each failure, up to four seconds', () => {
    expect([0, 1, 2, 4, 30].map(retry_delay)).toEqual([250, 500, 1000, 4000, 4000]);
  });

  it('matches replies to requests in any order, and passes on the problems of a refusal', async () => {
    const client = new Client(make_socket, handlers());
    client.connect();
    const socket = sockets[0]!;
    socket.open();
    const first = client.request({ op: 'undo' });
    const second = client.request({ op: 'redo' });
    const [a, b] = socket.sent.slice(-2);
    socket.deliver({ reply: b!.id, ok: false, error: { problems: [{ location: 'track/k1', message: 'No.', remedy: 'Do else.' }] } });
    socket.deliver({ reply: a!.id, ok: true, mark: 7 });
    await expect(first).resolves.toMatchObject({ mark: 7 });
    await expect(second).rejects.toMatchObject({ problems: [{ location: 'track/k1', message: 'No.', remedy: 'Do else.' }] });
  });

  it('rejects unanswered requests when the connection is lost, and requests without a connection', async () => {
    const client = new Client(make_socket, handlers());
    client.connect();
    sockets[0]!.open();
    const asked = client.request({ op: 'undo' });
    sockets[0]!.lose();
    await expect(asked).rejects.toBeInstanceOf(RequestError);
    await expect(client.request({ op: 'undo' })).rejects.toThrow(/not connected/);
    client.close();
  });

  it('reports invalid messages and keeps working', () => {
    const h = handlers();
    const client = new Client(make_socket, h);
    client.connect();
    sockets[0]!.open();
    sockets[0]!.deliver('{not json');
    sockets[0]!.deliver(new ArrayBuffer(12));
    sockets[0]!.deliver({ reply: 999, ok: true });
    sockets[0]!.deliver({ event: 'log', level: 'info', text: 'x' });
    expect(h.protocol_error).toHaveBeenCalledTimes(2);
    expect(h.event).toHaveBeenCalledOnce();
  });
});

describe('LatestOnly', () => {
  it('sends the first and the last value of a burst', async () => {
    const sent: number[] = [];
    const pending: (() => void)[] = [];
    const latest = new LatestOnly<number>((v) => {
      sent.push(v);
      return new Promise<void>((resolve) => pending.push(resolve));
    }, () => undefined);
    for (const v of [1, 2, 3, 4]) latest.offer(v);
    expect(sent).toEqual([1]);
    pending.shift()!();
    await vi.advanceTimersByTimeAsync(0);
    expect(sent).toEqual([1, 4]);
  });
});

describe('Session', () => {
  const start = async () => {
    const session = new Session({ make_socket, fetch: () => Promise.resolve(new Response('{"entries": []}')) });
    session.start();
    const socket = sockets[0]!;
    socket.open();
    socket.answer(hello());
    await vi.advanceTimersByTimeAsync(0);
    return { session, socket };
  };

  it('previews an edit and then uses the service’s document', async () => {
    const { session, socket } = await start();
    const done = session.edit({ type: 'clip.set', character: 'human', id: 'k1', start: 0.5 });
    expect(session.state.preview?.characters[0]?.track[0]?.start).toBe(0.5);
    expect(session.state.document?.characters[0]?.track[0]?.start).toBe(1);
    socket.answer();
    expect(await done).toBe(true);
    const changed = session.state.preview!;
    socket.deliver({ event: 'document', ...hello(), document: changed, revision: 2, unsaved: true, can_undo: true, undo_label: 'Move clip' });
    expect(session.state.preview).toBeNull();
    expect(session.state).toMatchObject({ can_undo: true, undo_label: 'Move clip', document: changed });
    expect(session.state.project?.unsaved).toBe(true);
  });

  it('reverts a refused edit and shows the reason', async () => {
    const { session, socket } = await start();
    const done = session.edit({ type: 'clip.set', character: 'human', id: 'k1', speed: -1 });
    socket.deliver({ reply: socket.sent.at(-1)!.id, ok: false, error: { problems: [{ location: 'characters/0/track/0/speed', message: 'Too slow.', remedy: 'Above 0.' }] } });
    expect(await done).toBe(false);
    expect(session.state.preview).toBeNull();
    expect(session.state.toasts.at(-1)?.problems[0]).toMatchObject({ message: 'Too slow.', remedy: 'Above 0.' });
    expect(session.state.log.at(-1)?.text).toContain('characters/0/track/0/speed');
  });

  it('sends no request for a preview', async () => {
    const { session, socket } = await start();
    const sent = socket.sent.length;
    session.show_preview({ ...sample_document(), duration: 3 });
    session.show_preview(null);
    expect(socket.sent.length).toBe(sent);
  });

  it('sends the next seek of a scrub only after the previous reply', async () => {
    const { session, socket } = await start();
    for (let t = 0; t < 50; t++) session.seek(t / 10);
    const seeks = () => socket.sent.filter((m) => m.op === 'seek').map((m) => m.time);
    expect(seeks()).toEqual([0]);
    socket.answer();
    await vi.advanceTimersByTimeAsync(0);
    expect(seeks()).toEqual([0, 4.9]);
    expect(session.state.transport.time).toBe(4.9);
  });

  it('keeps a speed chosen while paused until the next play', async () => {
    const { session, socket } = await start();
    session.set_speed(0.25);
    socket.deliver({ event: 'transport', ...hello().transport, time: 3 });
    expect(session.state.transport).toMatchObject({ speed: 0.25, time: 3 });
    session.play();
    expect(socket.sent.at(-1)).toMatchObject({ op: 'play', speed: 0.25 });
  });

  it('takes known choices from the first hello only, and stores choices', async () => {
    const session = new Session({ make_socket, fetch: () => Promise.resolve(new Response('{"entries": []}')) });
    session.start();
    const socket = sockets[0]!;
    socket.open();
    socket.answer({ ...hello(), choices: { keymap: 'blender', theme: 'purple', view: { ghosts: true, trail: 'yes', follow: true, nonsense: 1 } } });
    await vi.advanceTimersByTimeAsync(0);
    expect(session.state).toMatchObject({ keymap: 'blender', theme: 'dark' });
    expect(session.state.view).toMatchObject({ ghosts: true, trail: false });
    expect(session.state.view).not.toHaveProperty('nonsense');
    session.set({ theme: 'light' });
    session.remember();
    expect(socket.sent.at(-1)).toMatchObject({ op: 'remember', choices: { keymap: 'blender', theme: 'light', view: { ghosts: true } } });
    socket.answer();
    await vi.advanceTimersByTimeAsync(0);
    socket.lose();
    await vi.advanceTimersByTimeAsync(250);
    sockets[1]!.open();
    sockets[1]!.answer({ ...hello(), choices: { keymap: 'industry' } });
    await vi.advanceTimersByTimeAsync(0);
    expect(session.state.keymap).toBe('blender'); // the choices of this page take precedence after a reconnection
  });

  it('reads the old name of the option for closest pairs', () => {
    expect(read_choices({ view: { nearest: true } }).view).toMatchObject({ closest: true });
    expect(read_choices({ view: { nearest: true, closest: false } }).view).toMatchObject({ closest: false });
  });

  it.each([null, 3, 'x', [], { view: null }, { view: 7, keymap: {} }])('ignores invalid choices: %j', async (choices) => {
    expect(read_choices(choices)).toMatchObject({ keymap: 'industry', theme: 'dark', view: initial_state.view });
  });

  it('does not replace an existing file without permission', async () => {
    const { session, socket } = await start();
    const first = session.save_as('a/b.ugoki', false);
    expect(socket.sent.at(-1)).toMatchObject({ op: 'save', path: 'a/b.ugoki', overwrite: false });
    socket.deliver({ reply: socket.sent.at(-1)!.id, ok: false, error: { problems: [{ code: 'conflict', location: 'a/b.ugoki', message: 'The file exists already.' }] } });
    expect(await first).toBe('exists');
    expect(session.state.toasts).toEqual([]);
    const second = session.save_as('a/b.ugoki', true);
    socket.answer({ path: '/home/x/a/b.ugoki' });
    expect(await second).toBe('saved');
    expect(session.state.project).toMatchObject({ path: '/home/x/a/b.ugoki', name: 'b.ugoki', unsaved: false });
    const third = session.save_as('no/where.ugoki', false);
    socket.deliver({ reply: socket.sent.at(-1)!.id, ok: false, error: { problems: [{ code: 'io', location: 'no', message: 'There is no such folder.' }] } });
    expect(await third).toBe('failed');
    expect(session.state.toasts.at(-1)?.problems[0]?.message).toBe('There is no such folder.');
  });

  it('selects the character if the selected clip was deleted', async () => {
    const { session, socket } = await start();
    session.select({ kind: 'clip', character: 'human', clip: 'k1' });
    const document = sample_document();
    document.characters[0]!.track.shift();
    socket.deliver({ event: 'document', ...hello(), document, revision: 2, unsaved: true });
    expect(session.state.selection).toEqual({ kind: 'character', character: 'human' });
  });

  it('keeps the measures from Simulate to Edit and back, and drops them with the recording', async () => {
    const { session, socket } = await start();
    const transport = (mode: string, simulated: number) => socket.deliver({ event: 'transport', ...hello().transport, mode, simulated });
    transport('simulate', 3);
    socket.deliver({ event: 'summary', characters: [{ id: 'human', fell: false }], contacts: [] });
    transport('edit', 3);
    transport('simulate', 3);
    expect(session.state.summary.characters).toHaveLength(1);
    transport('edit', 0);
    expect(session.state.summary.characters).toHaveLength(0);
  });
  it('keeps the playhead of the newest step or seek until the service has answered it', async () => {
    const { session, socket } = await start();
    const report = (time: number, more = {}) => socket.deliver({ event: 'transport', ...hello().transport, time, ...more });
    const answer = (request: number) => {
      socket.deliver({ reply: request, ok: true });
      return vi.advanceTimersByTimeAsync(0);
    };
    const frame = 1 / session.state.document!.frame_rate;
    for (let i = 0; i < 3; i++) session.step(1);
    const steps = socket.sent.slice(-3).map((request) => request.id as number);
    report(0); // the changed content of an edit before
    expect(session.now).toBeCloseTo(3 * frame, 9);
    for (let i = 0; i < 3; i++) {
      report((i + 1) * frame);
      await answer(steps[i]!);
      expect(session.now).toBeCloseTo(3 * frame, 9);
    }
    // a move by another window is shown, at the latest with the answer
    report(1.25);
    expect(session.now).toBe(1.25);
    session.step(1);
    const last = socket.sent.at(-1)!.id as number;
    report(1.25 + frame);
    report(0.25);
    await answer(last);
    expect(session.now).toBe(0.25);
    // of many seeks, only the last is sent after the first
    session.seek(2);
    session.seek(3);
    const first = socket.sent.at(-1)!.id as number;
    report(2);
    await answer(first);
    expect(session.now).toBe(3);
    // playing and another mode show the reported time at once
    report(0.5, { playing: true });
    expect(session.state.transport.time).toBe(0.5);
  });
  it('follows the first character of a scenario that was empty', async () => {
    const session = new Session({ make_socket, fetch: () => Promise.resolve(new Response('{}')) });
    session.start();
    sockets[0]!.open();
    sockets[0]!.answer({ ...hello(), document: { ...sample_document(), camera: { follow: null }, characters: [] }, characters: [] });
    await vi.advanceTimersByTimeAsync(0);
    expect(session.state.view.follow).toBe(true);
  });
  it('does not connect while the service refuses the page, and connects when asked', async () => {
    const { session, socket } = await start();
    socket.lose();
    session.refuse();
    vi.advanceTimersByTime(60000);
    expect(sockets).toHaveLength(1);
    expect(session.state.connection).toBe('refused');
    session.retry();
    expect(sockets).toHaveLength(2);
  });
  it('reports the lost connection and the time of the next attempt', async () => {
    const { session, socket } = await start();
    socket.lose();
    expect(session.state.connection).toBe('lost');
    expect(session.state.retry_at).toBe(Date.now() + 250);
  });
});
