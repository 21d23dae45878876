// ./bench studio: what the page and the programs of the studio need for 1, 20 and 100 walking characters, and how long a jump of the playhead takes.
//   node benchmarks/studio/run.mjs [--soak MINUTES] [--seconds S] [--json FILE] [counts]
// Drawing calls are counted and dropped, because Chromium would rasterise with the processor: the page computes, uploads and sends everything
// else as with a graphics processor. Times of the page are processor time of its main thread, so they are also valid on a busy machine.
import { writeFileSync } from 'node:fs';
import { load_of, play, walkers, with_studio } from './measured_studio.mjs';
import { quantile, scrub } from './scrub.mjs';
import { growth_limit_mb, soak } from './soak.mjs';

const words = process.argv.slice(2);
const option = (name, usual) => {
  const at = words.indexOf(name);
  return at < 0 ? usual : words.splice(at, 2)[1];
};
const soak_minutes = Number(option('--soak', 0));
const seconds = Number(option('--seconds', 6));
const json = option('--json', '');
const counts = words.length > 0 ? words.map(Number) : [1, 20, 100];

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

const jumps = await scrub();
const scrub_ms = { p50: quantile(jumps.times, 0.5), p99: quantile(jumps.times, 0.99), longest_task: jumps.longest_task_ms, programs: jumps.programs_ms };
console.log(`jump of the playhead in 10 minutes, until the frame is here: p50 ${scrub_ms.p50.toFixed(1)} ms, p99 ${scrub_ms.p99.toFixed(1)} ms; processor time: longest task of the page ${scrub_ms.longest_task.toFixed(1)} ms, programs ${scrub_ms.programs.toFixed(2)} ms a jump`);

let growth = null;
if (soak_minutes > 0) {
  growth = await soak(soak_minutes);
  console.log(`${soak_minutes} minutes of work: page grew by ${growth.page_mb.toFixed(1)} MB, programs by ${growth.server_mb.toFixed(1)} MB`);
  if (growth.page_mb > growth_limit_mb || growth.server_mb > growth_limit_mb) process.exitCode = 1;
}
if (json) writeFileSync(json, `${JSON.stringify({ rows, scrub_ms, growth }, null, 1)}\n`);
