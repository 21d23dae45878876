import { execFileSync, spawnSync } from 'node:child_process';
import { describe, expect, it } from 'vitest';
import { from_lzma } from '../src/player/lzma';

/** Packs with xz-utils, as player/build.mjs does. The size in the header is that of the data. */
function packed(data, ...options) {
  const out = new Uint8Array(execFileSync('xz', ['--format=lzma', '-6', '-c', ...options], { input: data, maxBuffer: 1 << 28 }));
  new DataView(out.buffer, out.byteOffset).setBigUint64(5, BigInt(data.length), true);
  return out;
}
/** Bytes with repetitions at many distances, from a linear congruence of Knuth. */
function sample(count, seed) {
  const out = new Uint8Array(count);
  let s = seed;
  const next = () => (s = (s * 1664525 + 1013904223) % 2 ** 32) / 2 ** 32;
  for (let at = 0; at < count; ) {
    const length = Math.min(count - at, 1 + Math.floor(300 * next() ** 4));
    const distance = 1 + Math.floor(at * next() ** 6);
    if (at > 8 && next() < 0.6) for (let k = 0; k < length; k++, at++) out[at] = out[at - distance];
    else for (let k = 0; k < length; k++) out[at++] = Math.floor(256 * next() ** 2);
  }
  return out;
}

describe.skipIf(spawnSync('xz', ['--version']).status !== 0)('from_lzma', () => {
  it('unpacks what xz has packed', () => {
    for (const [i, size] of [0, 1, 2, 300, 70_000, 200_000].entries()) expect(Buffer.compare(from_lzma(packed(sample(size, i + 1))), sample(size, i + 1)), `${size} bytes`).toBe(0);
  });
  it('obeys the settings of the header', () => {
    const data = sample(20_000, 9);
    for (const settings of ['lc=0,lp=0,pb=0', 'lc=0,lp=4,pb=4', 'lc=4,lp=0,pb=1', 'lc=2,lp=2,pb=3']) expect(Buffer.compare(from_lzma(packed(data, `--lzma1=preset=6,${settings}`)), data), settings).toBe(0);
  });
  it('refuses damaged data, or returns other bytes', () => {
    const good = packed(sample(20_000, 3));
    let refused = 0;
    for (let at = 0; at < good.length; at += 397) {
      const bad = good.slice();
      bad[at] = bad[at] ^ 0x55;
      if (at >= 5 && at < 13) continue; // the size
      try {
        from_lzma(bad);
      } catch (error) {
        refused++;
        expect(error.message).toMatch(/damaged/);
      }
    }
    expect(refused).toBeGreaterThan(10);
    expect(() => from_lzma(good.slice(0, 10))).toThrow(/damaged|bounds/);
  });
});
