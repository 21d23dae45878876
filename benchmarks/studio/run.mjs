// ./bench studio: what the page and the programs of the studio need for 1, 20 and 100 walking characters, and how long a jump of the playhead takes.
//   node benchmarks/studio/run.mjs [--soak MINUTES] [--seconds S] [--json FILE] [counts]
// Drawing calls are counted and dropped, because Chromium would rasterise with the processor: the page computes, uploads and sends everything
// else as with a graphics processor. Times of the page are processor time of its main thread, so they are also valid on a busy machine.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { launch, ready } from '../../web/e2e/browser.mjs';
import { start_service } from '../../web/e2e/service.mjs';

const words = process.argv.slice(2);
const option = (name, usual) => {
  const at = words.indexOf(name);
  return at < 0 ? usual : words.splice(at, 2)[1];
};
const soak = Number(option('--soak', 0)); // minutes
const seconds = Number(option('--seconds', 6));
const json = option('--json', '');
const counts = words.length > 0 ? words.map(Number) : [1, 20, 100];

/** A scenario with `n` humans that walk in rows of ten. */
const walkers = (n, duration) => ({
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
function load_of(pid) {
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

const quantile = (values, q) => [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(q * values.length))] ?? NaN;

/** Opens the studio with `content`, and calls `act`. */
async function with_studio(content, act) {
  const folder = mkdtempSync(join(tmpdir(), 'ugoki-bench-'));
  const file = join(folder, 'content.json');
  writeFileSync(file, JSON.stringify(content));
  const service = await start_service(file);
  const browser = await launch();
  try {
    const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
    page.setDefaultTimeout(300000);
    await page.addInitScript(() => {
      localStorage.setItem('ugoki.tour', 'done');
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
    });
    await page.goto(service.address, { timeout: 300000 });
    await ready(page, 300000);
    const devtools = await page.context().newCDPSession(page);
    await devtools.send('Performance.enable', { timeDomain: 'threadTicks' });
    const metrics = async () => Object.fromEntries((await devtools.send('Performance.getMetrics')).metrics.map((m) => [m.name, m.value]));
    const heap = async () => {
      for (let i = 0; i < 3; i++) await devtools.send('HeapProfiler.collectGarbage');
      return (await metrics()).JSHeapUsedSize / 1024 / 1024;
    };
    return await act({ page, service, metrics, heap });
  } finally {
    await browser.close();
    await service.stop();
    rmSync(folder, { recursive: true, force: true });
  }
}

const play = async (page) => {
  await page.getByRole('button', { name: 'Loop between in and out' }).click();
  await page.locator('.transport').getByRole('button', { name: 'Play', exact: true }).click();
};

const rows = [];
for (const count of counts) {
  const row = await with_studio(walkers(count, 20), async ({ page, service, metrics, heap }) => {
    await play(page);
    await page.waitForTimeout(2000);
    await page.evaluate(() => (window.work.length = 0));
    const ask = () => page.evaluate(() => ({ pictures: window.ugoki.pictures, frames: window.ugoki.frames_received, draws: window.draws }));
    const [start, first, load, begun] = [await metrics(), await ask(), load_of(service.pid()), Date.now()];
    await page.waitForTimeout(1000 * seconds);
    const [end, last, after, now] = [await metrics(), await ask(), load_of(service.pid()), Date.now()];
    const work = await page.evaluate(() => window.work);
    const pictures = last.pictures - first.pictures;
    const idle_heap = await heap();
    return {
      characters: count,
      pictures,
      frames: last.frames - first.frames,
      draws: (last.draws - first.draws) / pictures,
      cpu_ms: (1000 * (end.TaskDuration - start.TaskDuration)) / pictures,
      script_ms: (1000 * (end.ScriptDuration - start.ScriptDuration)) / pictures,
      p50_ms: quantile(work, 0.5),
      p99_ms: quantile(work, 0.99),
      heap_mb: idle_heap,
      server_percent: (100 * (after.ticks - load.ticks)) / 100 / ((now - begun) / 1000),
      server_mb: after.memory,
    };
  });
  rows.push(row);
  console.log(`${String(row.characters).padStart(4)} characters: ${row.cpu_ms.toFixed(1)} ms processor time a picture (script ${row.script_ms.toFixed(1)}), frame callback p50 ${row.p50_ms.toFixed(1)} p99 ${row.p99_ms.toFixed(1)} ms, page ${row.heap_mb.toFixed(1)} MB, server ${row.server_percent.toFixed(0)} % ${row.server_mb.toFixed(0)} MB, ${row.pictures} pictures of ${row.frames} frames, ${row.draws.toFixed(0)} drawing calls each`);
}

const scrub = await with_studio(walkers(1, 600), async ({ page }) =>
  page.evaluate(() =>
    new Promise((resolve) => {
      const socket = new WebSocket(`${location.origin.replace('http', 'ws')}/ws`, ['ugoki', `ugoki.token.${sessionStorage.getItem('ugoki_token')}`]);
      socket.binaryType = 'arraybuffer';
      const times = [];
      let [wanted, sent, seed] = [-1, 0, 1];
      const jump = () => {
        if (times.length === 60) return resolve(times);
        seed = (seed * 48271) % 2147483647;
        wanted = Math.round((600 * 60 * seed) / 2147483647) / 60;
        sent = performance.now();
        socket.send(JSON.stringify({ id: 10 + times.length, op: 'seek', time: wanted }));
      };
      socket.onopen = () => socket.send('{"id":1,"op":"hello"}');
      socket.onmessage = ({ data }) => {
        if (typeof data === 'string') {
          if (JSON.parse(data).reply === 1) jump();
        } else if (wanted >= 0 && Math.abs(new DataView(data).getFloat64(8, true) - wanted) < 1 / 100) {
          times.push(performance.now() - sent);
          wanted = -1;
          setTimeout(jump, 5);
        }
      };
    }),
  ),
);
console.log(`jump of the playhead in 10 minutes, until the frame is here: p50 ${quantile(scrub, 0.5).toFixed(1)} ms, p99 ${quantile(scrub, 0.99).toFixed(1)} ms`);

let growth = null;
if (soak > 0) {
  growth = await with_studio(walkers(3, 20), async ({ page, service, heap }) => {
    await page.getByRole('radio', { name: 'Simulate' }).click();
    await play(page);
    await page.waitForTimeout(Math.min(180000, 20000 * soak)); // until the whole scenario is recorded and all caches are full
    const [page_before, server_before] = [await heap(), load_of(service.pid()).memory];
    const samples = [];
    for (let minute = 0; minute < soak; minute++) {
      await page.waitForTimeout(60000);
      await page.evaluate(() => (window.work.length = 0)); // so that this list does not count as growth
      samples.push([await heap(), load_of(service.pid()).memory]);
    }
    const [page_after, server_after] = samples.at(-1);
    return { minutes: soak, page_mb: page_after - page_before, server_mb: server_after - server_before, samples };
  });
  console.log(`${soak} minutes of simulated play: page grew by ${growth.page_mb.toFixed(1)} MB, programs by ${growth.server_mb.toFixed(1)} MB`);
  if (growth.page_mb > 5 || growth.server_mb > 5) process.exitCode = 1;
}
if (json) writeFileSync(json, `${JSON.stringify({ rows, scrub_ms: { p50: quantile(scrub, 0.5), p99: quantile(scrub, 0.99) }, growth }, null, 1)}\n`);
