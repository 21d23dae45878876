// npm run e2e [-- [--slow] words[|words]]: runs the first journey and those whose names contain the words (one of the groups of words); prints one
// line for each and the counts. With --slow also those that take minutes.
// A journey that fails runs a second time in the restored studio, because a busy machine can miss a time limit; its line names the first failure.
// The viewport is drawn at a low resolution, because Chromium draws with the processor; with UGOKI_PICTURES=1 at full resolution, for people
// who look at the pictures in out/.
// Environment: UGOKI_BIN, UGOKI_CHROMIUM, UGOKI_MOCK=1, UGOKI_PICTURES=1.
import { launch } from './browser.mjs';
import { journeys as all } from './journeys.mjs';
import { available, program, start_service } from './service.mjs';

const slow = process.argv.includes('--slow');
const choices = process.argv.slice(2).filter((word) => word !== '--slow').join(' ').split('|').map((words) => words.trim());
const journeys = all.filter((journey, i) => (slow || !journey.slow) && (i === 0 || choices.some((words) => journey.name.includes(words))));

let passed = 0;
let failed = 0;
let skipped = 0;

/** JSON text of the scenario and of the name of the last command: edits of a circuit do not change the scenario. */
const document_of = (page) => page.evaluate('JSON.stringify([window.ugoki?.document?.() ?? null, window.ugoki?.undo?.().undo_label ?? null])');

/**
 * Restores the studio after a failed journey: loads the page again, opens the project of the journeys if another is open, and undoes commands until document_of() equals `before`, its value at the
 * beginning of the journey. Otherwise an open dialog or a changed document would let the following journeys fail too.
 */
async function recover(page, before, folder) {
  await page.unrouteAll({ behavior: 'ignoreErrors' });
  await page.reload();
  // not ready(): while the circuit fills the window, no picture is drawn
  await page.waitForFunction(() => window.ugoki?.connected, undefined, { timeout: 60000 });
  await page.waitForTimeout(1000);
  await page.getByRole('radio', { name: 'Edit' }).click();
  const project = 'sample.ugoki'; // of start_service()
  if ((await page.locator('.project-name').textContent()) !== project) {
    await page.keyboard.press('Control+o');
    await page.getByRole('dialog', { name: 'Open project' }).waitFor();
    await page.keyboard.type(`${folder}/${project}`);
    await page.keyboard.press('Enter');
    await page.locator('.project-name', { hasText: project }).waitFor({ timeout: 30000 });
    await page.waitForTimeout(1000);
  }
  const scenario = page.getByRole('tab', { name: 'Scenario' });
  if ((await scenario.count()) > 0) await scenario.click(); // the journey may have left another panel on top, which a reload keeps
  for (let undone = 0; undone < 50 && (await document_of(page)) !== before; undone++) {
    if (!(await page.evaluate('window.ugoki.undo().can_undo'))) break;
    await page.keyboard.press('Control+z');
    await page.waitForTimeout(200);
  }
}

const indented = (error) => String(error.message ?? error).split('\n').join('\n  ');

/** What the page shows, for the message of a failed journey: focus, mode and the panels in sight. */
const situation = (page) => page.evaluate(() => {
  const focus = document.activeElement;
  const panels = [...document.querySelectorAll('.tab')].filter((tab) => tab.checkVisibility()).map((tab) => tab.textContent);
  return `focus: ${focus?.tagName}.${String(focus?.className ?? '')}; hidden: ${document.hidden}; transport: ${JSON.stringify(window.ugoki?.transport?.())}; tabs: ${panels.join(', ')}; ` +
    `viewport: ${document.querySelector('.viewport > canvas')?.clientWidth}; dialogs: ${document.querySelectorAll('[role=dialog]').length}`;
}).catch((e) => `unknown: ${e.message}`);

/** Runs a journey, after a failure a second time; returns the error of the first attempt, or undefined. Throws what the second attempt throws. */
async function attempt(journey, context, before) {
  const { page, service, seen } = context;
  const memory = { ...context.memory };
  const errors = seen.errors.length;
  try {
    await journey.run(context);
    return undefined;
  } catch (error) {
    error.message += `\n(${await situation(page)})`;
    await page.screenshot({ path: new URL(`./out/failed-${passed + failed + 1}.png`, import.meta.url).pathname }).catch(() => undefined);
    if (service.ended()) throw new Error(`the service ended during the journey '${journey.name}': ${service.output().slice(-1500)}`, { cause: error });
    if (!before) throw error;
    await recover(page, before, service.folder).catch((second) => {
      throw new Error(`${error.message ?? error}\nand the studio was not restored: ${second.message ?? second}`);
    });
    seen.errors.length = errors;
    Object.assign(context.memory, memory);
    await journey.run(context).catch((second) => {
      throw new Error(`${error.message ?? error}\nand at the second attempt: ${second.message ?? second}`);
    });
    return error;
  }
}

async function main() {
  if (!available) {
    for (const journey of journeys) console.log(`skip ${journey.name}: there is no program at ${program}; build it, or set UGOKI_BIN to its path`);
    skipped = journeys.length;
    return;
  }
  const service = await start_service();
  const browser = await launch();
  try {
    const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
    await page.addInitScript((draft) => {
      // pages without an address of their own have no storage
      if (!location.protocol.startsWith('http')) return;
      localStorage.setItem('ugoki.tour', 'done');
      if (draft) localStorage.setItem('ugoki.draft', 'on');
    }, process.env.UGOKI_PICTURES !== '1');
    const seen = { requests: [], errors: [] };
    page.on('request', (r) => seen.requests.push(r.url()));
    page.on('pageerror', (e) => seen.errors.push(e.message));
    page.on('console', (m) => {
      // a refused import is answered with status 4xx, which the browser logs as an error
      if (m.type() === 'error' && !/status of 4\d\d/.test(m.text())) seen.errors.push(m.text());
    });
    const memory = {};
    for (const journey of journeys) {
      const skip = journey.skip || (await journey.unless?.({ page }));
      if (skip) {
        console.log(`skip ${journey.name}: ${skip}`);
        skipped++;
        continue;
      }
      const before = passed + failed > 0 ? await document_of(page).catch(() => null) : null;
      const began = Date.now();
      try {
        const first = await attempt(journey, { page, service, seen, memory }, before);
        console.log(`ok ${journey.name} (${((Date.now() - began) / 1000).toFixed(1)} s)${first ? ` at the second attempt; the first: ${String(first.message ?? first).split('\n').filter((line, i, lines) => i === 0 || i === lines.length - 1).join(' ')}` : ''}`);
        passed++;
      } catch (error) {
        console.log(`not ok ${journey.name}\n  ${indented(error)}`);
        failed++;
        if (service.ended()) throw error;
        if (before) await recover(page, before, service.folder).catch((e) => console.log(`  the studio was not restored: ${e.message}`));
      }
    }
    if (failed > 0) console.log(`  output of the service: ${service.output().slice(-1500)}`);
  } finally {
    await browser.close();
    await service.stop();
  }
}

try {
  await main();
} catch (error) {
  console.log(`not ok the studio starts\n  ${error.message}`);
  failed++;
}
console.log(`${passed} passed, ${failed} failed${skipped ? `, ${skipped} skipped` : ''}`);
process.exit(failed > 0 ? 1 : 0);
