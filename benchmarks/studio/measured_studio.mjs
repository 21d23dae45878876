// The studio in Chromium with walking characters, and what its page and its programs need: for ./bench studio and for the soak of the slow tests.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { launch, ready } from '../../web/e2e/browser.mjs';
import { start_service } from '../../web/e2e/service.mjs';

/** A scenario with `n` humans that walk in rows of ten. */
export const walkers = (n, duration) => ({
  scenario: {
    version: 1, name: 'walkers', duration,
    characters: Array.from({ length: n }, (_, i) => ({
      id: `c${i}`, name: `Walker ${i + 1}`, mechanism: 'human', color: '#e6e6ea', place: { x: -1.7 * Math.floor(i / 10), y: 1.3 * (i % 10) },
      track: [{ id: `k${i}`, motion: 'human-walk', start: 0, length: duration, loop: true, offset: 0.03 * (i % 30) }],
    })),
    camera: { follow: 'c0', distance: 14, azimuth: 0.8, elevation: 0.35 },
  },
});

/** Clock ticks of processor time, and resident memory (MB), of a process and its descendants. */
export function load_of(pid) {
  const rows = execFileSync('ps', ['-eo', 'pid=,ppid=,rss=']).toString().trim().split('\n').map((line) => line.trim().split(/\s+/).map(Number));
  const family = new Set([pid]);
  for (let grew = true; grew; ) {
    grew = false;
    for (const [child, parent] of rows) if (family.has(parent) && !family.has(child)) grew = Boolean(family.add(child));
  }
  let ticks = 0;
  let memory = 0;
  for (const [process_id, , rss] of rows) {
    if (!family.has(process_id)) continue;
    memory += rss / 1024;
    try {
      const fields = readFileSync(`/proc/${process_id}/stat`, 'latin1').replace(/^.*\) /, '').split(' ');
      ticks += Number(fields[11]) + Number(fields[12]);
    } catch {
      // it ended meanwhile
    }
  }
  return { ticks, memory };
}

/** Opens the studio with `content`, and calls `act`. @param stored entries of the page's local storage, such as preferences */
export async function with_studio(content, act, stored = {}) {
  const folder = mkdtempSync(join(tmpdir(), 'ugoki-bench-'));
  const file = join(folder, 'content.json');
  writeFileSync(file, JSON.stringify(content));
  const service = await start_service(file);
  const browser = await launch();
  try {
    const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
    page.setDefaultTimeout(300000);
    await page.addInitScript((entries) => {
      for (const [key, value] of Object.entries(entries)) localStorage.setItem(key, value);
      window.draws = 0;
      const { prototype } = WebGL2RenderingContext;
      for (const name of ['drawElements', 'drawArrays', 'drawElementsInstanced', 'drawArraysInstanced']) prototype[name] = () => void window.draws++;
      prototype.getSyncParameter = () => prototype.SIGNALED;
      // durations of the work in animation frames, ms; only frames that drew a picture
      window.work = [];
      const ask = window.requestAnimationFrame.bind(window);
      window.requestAnimationFrame = (callback) =>
        ask((now) => {
          const before = window.ugoki?.pictures ?? 0;
          const start = performance.now();
          callback(now);
          if ((window.ugoki?.pictures ?? 0) > before) window.work.push(performance.now() - start);
        });
    }, { 'ugoki.tour': 'done', ...stored });
    await page.goto(service.address, { timeout: 300000 });
    await ready(page, 300000);
    const devtools = await page.context().newCDPSession(page);
    await devtools.send('Performance.enable', { timeDomain: 'threadTicks' });
    const metrics = async () => Object.fromEntries((await devtools.send('Performance.getMetrics')).metrics.map((m) => [m.name, m.value]));
    // memory of the page after garbage collection, MB: objects of scripts, objects of the DOM, and buffers of typed arrays
    const heap = async () => {
      for (let i = 0; i < 3; i++) await devtools.send('HeapProfiler.collectGarbage');
      const { usedSize, embedderHeapUsedSize = 0, backingStorageSize = 0 } = await devtools.send('Runtime.getHeapUsage');
      return (usedSize + embedderHeapUsedSize + backingStorageSize) / 1024 / 1024;
    };
    return await act({ page, service, metrics, heap });
  } finally {
    await browser.close();
    await service.stop();
    rmSync(folder, { recursive: true, force: true });
  }
}

/** Plays in a loop. */
export async function play(page) {
  const { loop, playing } = await page.evaluate(() => window.ugoki.transport());
  if (!loop) await page.getByRole('button', { name: 'Loop between in and out' }).click();
  if (!playing) await page.locator('.transport').getByRole('button', { name: 'Play', exact: true }).click();
}
