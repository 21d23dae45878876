import { describe, expect, it } from 'vitest';
import { assist_force, assist_over_cap, body_weight, centre_of_mass, decode_frame, FrameRing, frame_magic, link_position, state_of, type Frame } from '../src/core/frames';

/** Bytes of a frame, written according to the table in docs/studio-protocol.md, independently of the decoder. */
function make_bytes(options: { time?: number; number?: number; flags?: number; links?: number[]; contacts?: number; version?: number; magic?: number } = {}): ArrayBuffer {
  const links = options.links ?? [2, 1];
  const contacts = options.contacts ?? 1;
  const size = 64 + links.reduce((sum, l) => sum + 56 + 28 * l, 0) + 32 * contacts;
  const view = new DataView(new ArrayBuffer(size));
  view.setUint32(0, options.magic ?? frame_magic, true);
  view.setUint32(4, options.version ?? 1, true);
  view.setFloat64(8, options.time ?? 1.5, true);
  view.setUint32(16, options.number ?? 90, true);
  view.setUint32(20, options.flags ?? 3, true);
  view.setUint32(24, links.length, true);
  view.setUint32(28, contacts, true);
  for (let i = 0; i < 6; i++) view.setFloat32(32 + 4 * i, 100 + i, true);
  let at = 64;
  links.forEach((count, c) => {
    view.setUint32(at, count, true);
    view.setUint32(at + 4, c, true);
    for (let i = 0; i < 12; i++) view.setFloat32(at + 8 + 4 * i, 10 * (c + 1) + i, true);
    at += 56;
    for (let i = 0; i < 7 * count; i++) view.setFloat32(at + 4 * i, 1000 * (c + 1) + i, true);
    at += 28 * count;
  });
  for (let k = 0; k < contacts; k++) {
    for (let i = 0; i < 6; i++) view.setFloat32(at + 4 * i, 7 + i, true);
    view.setUint32(at + 24, 1, true);
    view.setUint32(at + 28, 0, true);
    at += 32;
  }
  return view.buffer as ArrayBuffer;
}

const decode = (bytes: ArrayBuffer): Frame => {
  const frame = decode_frame(bytes);
  if (typeof frame === 'string') throw new Error(frame);
  return frame;
};

describe('decode_frame', () => {
  it('reads every field', () => {
    const frame = decode(make_bytes({ flags: 1 | 2 | 8 }));
    expect(frame).toMatchObject({ time: 1.5, number: 90, playing: true, simulate: true, live: false, grabbing: true, contact_count: 1 });
    expect(frame.characters.map((f) => [f.links, state_of(frame, f)])).toEqual([[2, 0], [1, 1]]);
    const second = frame.characters[1]!;
    expect(assist_force(frame, second)).toEqual([20, 21, 22]);
    expect(assist_over_cap(frame, second)).toBe(26);
    expect(body_weight(frame, second)).toBe(27);
    expect(centre_of_mass(frame, second)).toEqual([28, 29, 30]);
    expect(link_position(frame, frame.characters[0]!, 1)).toEqual([1007, 1008, 1009]);
    expect([...frame.floats.slice(frame.grab, frame.grab + 3)]).toEqual([100, 101, 102]);
    expect([...frame.floats.slice(frame.contacts, frame.contacts + 6)]).toEqual([7, 8, 9, 10, 11, 12]);
    expect(frame.words[frame.contacts + 6]).toBe(1);
  });

  it('frames with equal numbers of links share their layout, others do not', () => {
    const first = decode(make_bytes());
    expect(decode(make_bytes({ contacts: 3 })).characters).toBe(first.characters);
    const other = decode(make_bytes({ links: [1, 2] }));
    expect(other.characters.map((f) => f.links)).toEqual([1, 2]);
    expect(centre_of_mass(other, other.characters[1]!)).toEqual([28, 29, 30]);
    expect(first.characters.map((f) => f.links)).toEqual([2, 1]);
    expect(decode_frame(make_bytes({ links: [1, 2] }).slice(0, 200))).toMatch(/ends in/);
  });

  it('reads a frame without characters', () => {
    expect(decode(make_bytes({ links: [], contacts: 0 })).characters).toEqual([]);
  });

  it('reports an error for every truncated message', () => {
    const whole = make_bytes();
    for (let size = 0; size < whole.byteLength; size++) expect(typeof decode_frame(whole.slice(0, size))).toBe('string');
  });

  it('refuses counts that exceed the message', () => {
    const bytes = make_bytes();
    new DataView(bytes).setUint32(24, 0xffffffff, true);
    expect(decode_frame(bytes)).toMatch(/ends in/);
    const links = make_bytes();
    new DataView(links).setUint32(64, 0x7fffffff, true);
    expect(decode_frame(links)).toMatch(/poses of character 0/);
  });

  it('refuses another version and another magic number', () => {
    expect(decode_frame(make_bytes({ version: 2 }))).toMatch(/version 2/);
    expect(decode_frame(make_bytes({ magic: 1 }))).toMatch(/UKGF/);
  });
});

describe('FrameRing', () => {
  it('finds frames by number and drops the oldest', () => {
    const ring = new FrameRing(3);
    for (const number of [1, 2, 3, 4]) ring.push(decode(make_bytes({ number })));
    expect(ring.numbers()).toEqual([2, 3, 4]);
    expect(ring.at(1)).toBeUndefined();
    expect(ring.latest?.number).toBe(4);
    expect(ring.near(6, 2)?.number).toBe(4);
    expect(ring.near(8, 2)).toBeUndefined();
  });

  it('keeps the last received frame of each number', () => {
    const ring = new FrameRing(3);
    ring.push(decode(make_bytes({ number: 5, time: 1 })));
    ring.push(decode(make_bytes({ number: 5, time: 2 })));
    expect(ring.numbers()).toEqual([5]);
    expect(ring.at(5)?.time).toBe(2);
  });

  it('is cleared when the mode changes', () => {
    const ring = new FrameRing();
    ring.push(decode(make_bytes({ number: 1, flags: 0 })));
    ring.push(decode(make_bytes({ number: 2, flags: 2 })));
    expect(ring.numbers()).toEqual([2]);
  });

  it('keeps the latest frame when cleared, and calls listeners until they are removed', () => {
    const ring = new FrameRing();
    const seen: number[] = [];
    const leave = ring.on_frame((f) => seen.push(f.number));
    ring.push(decode(make_bytes({ number: 1 })));
    ring.push(decode(make_bytes({ number: 2 })));
    leave();
    ring.push(decode(make_bytes({ number: 3 })));
    ring.clear();
    expect(ring.numbers()).toEqual([3]);
    expect(seen).toEqual([1, 2]);
  });
});
