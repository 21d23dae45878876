// Soak of the studio: node benchmarks/studio/soak.mjs [MINUTES [LEAK]]. An hour of work with three humans: each minute the scenario is changed, the
// change is undone, the scenario is simulated again and played in a loop. Page and programs may grow by 5 MB; the growth is that of a straight
// line through the memory after each minute. Prints one line for each test. With LEAK, the page keeps so many MB more each minute, to see the
// test fail. Environment: see web/e2e/service.mjs; with UGOKI_SOAK_SAMPLES=1 the memory after each minute is printed.
import { fileURLToPath } from 'node:url';
import { document_of, set_mode, step_history, until } from '../../web/e2e/browser.mjs';
import { rise } from './growth.mjs';
import { load_of, play, walkers, with_studio } from './measured_studio.mjs';

export const growth_limit_mb = 5;
const duration = 20; // of the scenario, s

/** One minute of work. Ends with the whole scenario recorded, so that the memory can be compared with that of another minute. */
async function work(page) {
  const start = Date.now();
  await set_mode(page, 'Edit');
  const before = JSON.stringify(await document_of(page));
  await page.locator('.clip').first().click();
  await page.keyboard.press('Delete');
  await until(page, async () => JSON.stringify(await document_of(page)) !== before, 'the removed clip');
  await step_history(page, 'Control+z');
  if (JSON.stringify(await document_of(page)) !== before) throw new Error('undo does not restore the removed clip');
  await set_mode(page, 'Simulate');
  await page.keyboard.press('Control+Home');
  const recorded = () => page.evaluate(() => window.ugoki.transport().simulated);
  await play(page);
  await until(page, async () => (await recorded()) >= duration - 0.1, `the recorded scenario of ${duration} s`, 300000);
  await page.waitForTimeout(Math.max(0, 60000 - (Date.now() - start)));
}

/** @param leak memory that the page keeps more each minute, MB @return growth of page and programs in `minutes` of work, MB, and the memory after each minute, MB */
export const soak = (minutes, leak = 0) =>
  with_studio(walkers(3, duration), async ({ page, service, heap }) => {
    const sample = async () => {
      await page.evaluate(() => (window.work.length = 0)); // of the measurement, not of the studio
      return { page_mb: await heap(), server_mb: load_of(service.pid()).memory };
    };
    for (let minute = 0; minute < 3; minute++) await work(page); // until all caches are full
    const samples = [await sample()];
    for (let minute = 0; minute < minutes; minute++) {
      await work(page);
      if (leak > 0) await page.evaluate((mb) => void (window.leaked ??= []).push(new Float64Array((mb * 1024 * 1024) / 8)), leak);
      samples.push(await sample());
      if (process.env.UGOKI_SOAK_SAMPLES) console.log(JSON.stringify(samples.at(-1)));
    }
    return { minutes, page_mb: rise(samples.map((s) => s.page_mb)), server_mb: rise(samples.map((s) => s.server_mb)), samples };
  }, { 'ugoki.draft': 'on' }); // Chromium composites with the processor; drafts leave it half of the time

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const minutes = Number(process.argv[2] ?? 60);
  const growth = await soak(minutes, Number(process.argv[3] ?? 0));
  const verdicts = [['page', growth.page_mb], ['programs', growth.server_mb]].map(([name, mb]) => {
    console.log(`${mb < growth_limit_mb ? 'ok' : 'not ok'} the ${name} of the studio grew by ${mb.toFixed(1)} MB in ${minutes} minutes (limit ${growth_limit_mb} MB)`);
    return mb < growth_limit_mb;
  });
  process.exitCode = verdicts.every(Boolean) ? 0 : 1;
}
