// npm run e2e [-- [--slow] words[|words]]: runs the journeys whose names contain the words (one of the groups of words); prints one line for each and
// the counts. With --slow also those that take minutes.
// All journeys use one service and one page: two browsers at a time are not faster on two cores, and journeys then miss time limits.
// A journey that fails runs a second time in the restored studio, because a busy machine can miss a time limit; its line names the first failure.
// The viewport is drawn at a low resolution, because Chromium draws with the processor; with UGOKI_PICTURES=1 at full resolution, for people
// who look at the pictures in out/.
// Environment: UGOKI_BIN, UGOKI_CHROMIUM, UGOKI_MOCK=1, UGOKI_PICTURES=1.
import { blur, launch, ready, set_mode } from './browser.mjs';
import { closing, groups, opening } from './journeys.mjs';
import { available, program, start_service } from './service.mjs';

const slow = process.argv.includes('--slow');
const choices = process.argv.slice(2).filter((word) => !word.startsWith('--')).join(' ').split('|').map((words) => words.trim());
const chosen = (journey) => (slow || !journey.slow) && choices.some((words) => journey.name.includes(words));
const chosen_groups = groups.map((group) => group.filter(chosen)).filter((group) => group.length > 0);

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
  // pulls and keys of the failed journey stay in the recording of the simulation
  await set_mode(page, 'Simulate');
  await blur(page);
  await page.keyboard.press('Shift+R');
  await set_mode(page, 'Edit');
  await tidy(page); // the journey may have left another panel on top, which a reload keeps
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
    await page.screenshot({ path: new URL(`./out/failed-${failed + 1}-${journey.name.replaceAll(/\W+/g, '-').slice(0, 40)}.png`, import.meta.url).pathname }).catch(() => undefined);
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

/** Runs one journey and prints its line; the closing journey, which follows each group, has one only if it fails. */
async function run(journey, context) {
  const { page, service } = context;
  const skip = journey.skip || (await journey.unless?.({ page }));
  if (skip) {
    console.log(`skip ${journey.name}: ${skip}`);
    skipped++;
    return;
  }
  const before = journey === opening ? null : await document_of(page).catch(() => null);
  const began = Date.now();
  try {
    const first = await attempt(journey, context, before);
    if (journey === closing) return;
    console.log(`ok ${journey.name} (${((Date.now() - began) / 1000).toFixed(1)} s)${first ? ` at the second attempt; the first: ${String(first.message ?? first).split('\n').filter((line, i, lines) => i === 0 || i === lines.length - 1).join(' ')}` : ''}`);
    passed++;
  } catch (error) {
    console.log(`not ok ${journey.name}\n  ${indented(error)}`);
    failed++;
    if (journey === opening || service.ended()) throw error;
    if (before) await recover(page, before, service.folder).catch((e) => console.log(`  the studio was not restored: ${e.message}`));
  }
}

/**
 * Brings the page into the state in which each group begins: no messages, inspector and scenario on top. Loads the page again with its first
 * layout if another panel is over the whole window.
 */
async function tidy(page) {
  const messages = page.locator('.toast').getByRole('button', { name: 'Dismiss' });
  for (let i = 0; i < 20 && (await messages.count()) > 0; i++) await messages.first().click({ timeout: 2000 }).catch(() => undefined);
  if (!(await page.evaluate("document.querySelector('.viewport > canvas')?.clientWidth > 0"))) {
    await page.evaluate("Object.keys(localStorage).filter((key) => key.startsWith('ugoki.layout')).forEach((key) => localStorage.removeItem(key))");
    await page.reload();
    await ready(page);
  }
  for (const name of ['Inspector', 'Scenario']) {
    const tab = page.getByRole('tab', { name, exact: true });
    if ((await tab.count()) > 0) await tab.first().click({ timeout: 2000 }).catch(() => undefined);
  }
}

/** Runs all chosen journeys. */
async function run_all() {
  const service = await start_service();
  const browser = await launch();
  const context = { service, seen: { requests: [], errors: [] }, memory: {} };
  try {
    const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
    context.page = page;
    await page.addInitScript((draft) => {
      // pages without an address of their own have no storage
      if (!location.protocol.startsWith('http')) return;
      localStorage.setItem('ugoki.tour', 'done');
      if (draft) localStorage.setItem('ugoki.draft', 'on');
    }, process.env.UGOKI_PICTURES !== '1');
    const { seen } = context;
    page.on('request', (r) => seen.requests.push(r.url()));
    page.on('pageerror', (e) => seen.errors.push(e.stack ?? e.message));
    page.on('console', (m) => {
      // a refused import is answered with status 4xx, which the browser logs as an error
      if (m.type() === 'error' && !/status of 4\d\d/.test(m.text())) seen.errors.push(m.text());
    });
    await run(opening, context);
    for (const group of chosen_groups) {
      const failed_before = failed;
      for (const journey of group) await run(journey, context);
      await run(closing, context);
      if (failed > failed_before) console.log(`  output of the service: ${service.output().slice(-1500)}`);
      seen.errors.length = 0;
      await tidy(page);
    }
  } catch (error) {
    if (failed === 0) console.log(`not ok the studio runs\n  ${indented(error)}\n  output of the service: ${service.output().slice(-1500)}`);
    failed = Math.max(1, failed);
  } finally {
    await browser.close();
    await service.stop();
  }
}

if (available) {
  await run_all();
} else {
  for (const journey of chosen_groups.flat()) console.log(`skip ${journey.name}: there is no program at ${program}; build it, or set UGOKI_BIN to its path`);
  skipped = chosen_groups.flat().length;
}
console.log(`${passed} passed, ${failed} failed${skipped ? `, ${skipped} skipped` : ''}`);
process.exit(failed > 0 ? 1 : 0);
