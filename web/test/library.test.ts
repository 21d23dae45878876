import { describe, expect, it, vi } from 'vitest';
import { LibraryBrowser } from '../src/core/library/browser';
import { ImportQueue } from '../src/core/library/imports';
import { format_bytes, format_length, from_service, key_of, split_tags } from '../src/core/library/words';
import { format_gap } from '../src/core/format';
import { decode_frame } from '../src/core/frames';
import type { LibraryEntry } from '../src/core/protocol';

type Answer = { status?: number; body: unknown };
const reply = ({ status = 200, body }: Answer): Response => new Response(JSON.stringify(body), { status });

/** A fake service with `count` entries that replies in pages as specified in docs/studio-protocol.md. */
function service(count: number) {
  const all: LibraryEntry[] = Array.from({ length: count }, (_, i) => ({ id: `n-${i}`, kind: 'motion', name: `walk ${i}`, version: 1, tags: [] }));
  const asked: string[] = [];
  const post = vi.fn((_path: string, _body: Record<string, unknown>): Answer => ({ body: {} }));
  const host = {
    fetch: async (path: string, init?: RequestInit): Promise<Response> => {
      asked.push(path);
      const url = new URL(path, 'http://x/');
      if (init?.method === 'POST') return reply(post(url.pathname, JSON.parse(String(init.body)) as Record<string, unknown>));
      if (url.pathname === '/api/library/tags') return reply({ body: { tags: [{ name: 'slow', count: 3 }] } });
      const q = url.searchParams.get('q') ?? '';
      const found = all.filter((e) => e.name.includes(q));
      const from = Number(url.searchParams.get('after') ?? 0);
      const limit = Number(url.searchParams.get('limit'));
      return reply({ body: { entries: found.slice(from, from + limit), next: from + limit < found.length ? String(from + limit) : null, total: found.length, total_exact: true } });
    },
    cache_entries: vi.fn(),
    fail: vi.fn(),
  };
  return { host, asked, post, all };
}

describe('the library browser', () => {
  it('loads page after page, each entry once', async () => {
    const { host } = service(250);
    const browser = new LibraryBrowser(host);
    await browser.load();
    expect(browser.state.entries.length).toBe(100);
    expect([browser.state.total, browser.state.more]).toEqual([250, true]);
    await Promise.all([browser.load_more(), browser.load_more()]);
    expect(browser.state.entries.length).toBe(200);
    await browser.load_more();
    await browser.load_more();
    expect(browser.state.entries.map((e) => e.name)).toEqual(Array.from({ length: 250 }, (_, i) => `walk ${i}`));
    expect(browser.state.more).toBe(false);
  });
  it('sends one request for fast typing', async () => {
    vi.useFakeTimers();
    const { host, asked } = service(30);
    const browser = new LibraryBrowser(host);
    for (const q of ['w', 'wa', 'walk 1']) browser.search(q);
    await vi.advanceTimersByTimeAsync(200);
    vi.useRealTimers();
    await vi.waitFor(() => expect(browser.state.status).toBe('ready'));
    expect(asked.filter((p) => p.startsWith('api/library?'))).toEqual(['api/library?q=walk+1&limit=100']);
    expect(browser.state.entries.length).toBe(11);
  });
  it('keeps the entries while the library does not respond, and recovers', async () => {
    const { host } = service(30);
    const browser = new LibraryBrowser(host);
    await browser.load();
    const ready = host.fetch;
    const problem = { code: 'io', location: 'library', message: 'The library does not respond.', remedy: 'Try again.' };
    host.fetch = async () => reply({ status: 503, body: { error: { problems: [problem] } } });
    await browser.load();
    expect([browser.state.status, browser.state.away, browser.state.entries.length]).toEqual(['failed', true, 30]);
    expect(browser.state.failure).toBe('The library does not respond. Try again.');
    host.fetch = ready;
    await browser.load();
    expect([browser.state.status, browser.state.away]).toEqual(['ready', false]);
  });
  it('undoes a rename', async () => {
    const { host, post } = service(3);
    const browser = new LibraryBrowser(host);
    await browser.load();
    const entry = browser.state.entries[1]!;
    post.mockImplementation((_path, body) => ({ body: { entry: { ...entry, id: 'n-1', version: Number(body.base) + 1, name: body.name } } }));
    await browser.rename(entry, ' run ');
    expect(post).toHaveBeenLastCalledWith('/api/entry/n-1', { base: 1, name: 'run' });
    expect(browser.state.done?.label).toBe('Renamed “walk 1” to “run”');
    await browser.undo();
    expect(post).toHaveBeenLastCalledWith('/api/entry/n-1', { base: 2, name: 'walk 1' });
    expect(browser.state.done).toBeNull();
    await browser.undo();
    expect(post).toHaveBeenCalledTimes(2);
  });
  it('reports a conflict, and saves over it if the user chooses so', async () => {
    const { host, post } = service(2);
    const browser = new LibraryBrowser(host);
    await browser.load();
    const entry = browser.state.entries[0]!;
    post.mockReturnValueOnce({ status: 409, body: { error: { problems: [{ code: 'conflict', message: 'x' }] }, entry: { ...entry, id: 'n-0', version: 5, name: 'theirs', by: 'Ada' } } });
    await browser.rename(entry, 'mine');
    expect(browser.state.conflict?.theirs).toMatchObject({ name: 'theirs', by: 'Ada', version: 5 });
    expect(browser.state.done).toBeNull();
    expect(host.fail).not.toHaveBeenCalled();
    browser.answer_conflict(true);
    await vi.waitFor(() => expect(post).toHaveBeenLastCalledWith('/api/entry/n-0', { base: 5, name: 'mine' }));
    expect(browser.state.conflict).toBeNull();
  });
});

describe('imports', () => {
  const file = (name: string): File => Object.assign(new Blob(['x']), { name, lastModified: 0, webkitRelativePath: '' }); // Node.js 18 has no global File
  const staged = (stage: string) => ({ stage, file: 'a.bvh', format: 'BVH', settings: { unit: 1, unit_guessed: true, up: 'y', forward: 'z', rate: 30, rate_specified: true }, can: { unit: true, axes: true, rate: true }, entries: [], report: { read: [], guessed: [], changed: [], left_out: [], check: [] } });
  const make = (answer: (path: string) => Answer) => {
    const asked: string[] = [];
    const host = { fetch: async (path: string) => { asked.push(path); return reply(answer(path)); }, log: vi.fn(), stored: vi.fn() };
    return { queue: new ImportQueue(host), asked, host };
  };
  it('sends companion files first, and continues after a refused file', async () => {
    const { queue, asked } = make((path) => (path.includes('bad') ? { status: 400, body: { error: { problems: [{ location: 'bad.bvh:4', message: 'It ends.' }] } } } : { body: staged('i1') }));
    await queue.add([file('1_1.amc'), file('bad.bvh'), file('1.asf')]);
    expect(asked).toEqual(['api/import/file?name=1.asf', 'api/import/stage?name=1_1.amc', 'api/import/stage?name=bad.bvh']);
    expect(queue.state.items.map((i) => i.status)).toEqual(['ready', 'refused']);
    expect(queue.state.items[1]!.problems[0]!.message).toBe('It ends.');
  });
  it('merges quick corrections, and keeps the previous stage if one fails', async () => {
    let fail = false;
    const { queue, asked } = make((path) => (fail && path.includes('stage/') ? { status: 400, body: { error: { problems: [{ message: 'no' }] } } } : { body: staged('i1') }));
    await queue.add([file('a.bvh')]);
    const { id } = queue.state.items[0]!;
    void queue.correct(id, { unit: 2 });
    void queue.correct(id, { unit: 3 });
    await queue.correct(id, { unit: 4 });
    await vi.waitFor(() => expect(queue.state.items[0]!.rereading).toBe(false));
    const rereads = asked.filter((p) => p.includes('stage/i1'));
    expect(rereads[rereads.length - 1]).toBe('api/import/stage/i1?up=y&forward=z&unit=4&rate=30');
    expect(rereads.length).toBeLessThanOrEqual(2);
    fail = true;
    await queue.correct(id, { rate: 60 });
    expect(queue.state.items[0]).toMatchObject({ status: 'ready', problems: [{ message: 'no' }] });
    expect(queue.state.items[0]!.staged?.stage).toBe('i1');
  });
  it('drops stages that are not stored when it is closed', async () => {
    const { queue, asked } = make(() => ({ body: staged('i7') }));
    await queue.add([file('a.bvh')]);
    queue.close();
    expect(asked[asked.length - 1]).toBe('api/import/drop/i7');
    expect(queue.state).toEqual({ open: false, items: [], shown: null });
  });
});

describe('texts and identities', () => {
  it('format lengths, sizes and distances', () => {
    expect([0.004, 0.0256, 0.35, 1.75, 12.4].map(format_length)).toEqual(['4 mm', '2.6 cm', '35 cm', '1.75 m', '12 m']);
    expect([900, 4300, 52_000, 3.2e6].map(format_bytes)).toEqual(['900 B', '4.3 kB', '52 kB', '3.2 MB']);
    expect([0.0042, 0.412, 1.254, -0.003].map(format_gap)).toEqual(['4.2 mm', '412 mm', '1.25 m', '3.0 mm deep']);
  });
  it('split tags at commas', () => expect(split_tags(' slow,  on  grass, slow,,')).toEqual(['slow', 'on grass']));
  it('keep entry id and data id of an entry', () => {
    expect(from_service({ id: 'n-1', kind: 'motion', name: 'a', version: 2, content: 'n-9' })).toMatchObject({ id: 'n-9', entry: 'n-1' });
    const copy = from_service({ id: 'n-2', kind: 'motion', name: 'a copy', version: 1, content: 'n-9' });
    expect([key_of(copy), copy.id]).toEqual(['n-2', 'n-9']);
    expect(from_service({ id: 'human', kind: 'mechanism', name: 'a' }).entry).toBeUndefined();
  });
});

describe('frames with normals and closest pairs', () => {
  it('are decoded, and refused if truncated', () => {
    const buffer = new ArrayBuffer(64 + 2 * (8 + 3) * 4 + 8 * 4);
    const view = new DataView(buffer);
    const words: [number, number][] = [[0, 0x46474b55], [4, 1], [28, 2], [56, 1], [60, 1]];
    for (const [at, value] of words) view.setUint32(at, value, true);
    view.setFloat32(64 + 2 * 32 + 12 + 8, 1, true); // second normal, z
    view.setFloat32(64 + 2 * 44 + 24, 0.25, true);
    view.setUint32(64 + 2 * 44 + 28, (3 << 16) | 5, true);
    const frame = decode_frame(buffer);
    if (typeof frame === 'string') throw new Error(frame);
    expect(frame.floats[frame.normals + 5]).toBe(1);
    expect([frame.closest_count, frame.floats[frame.closest + 6], frame.words[frame.closest + 7]]).toEqual([1, 0.25, (3 << 16) | 5]);
    expect(decode_frame(buffer.slice(0, buffer.byteLength - 4))).toMatch(/closest pairs/);
  });
});
