// Journeys (end-to-end tests) with LSIs from a user's C file: build, wire, run, reload while running, and faults. They use the real studio
// and its child processes.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { chmodSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { violations } from './accessibility.mjs';
import { mock } from './service.mjs';
import { add, drag, head, large, pin, spot, state, wait_for_undo_label, until } from './wiring.mjs';

const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const skip = mock && 'the mock service has no circuit runtime';

const tools = (factor) => `/// @library tools
/// Three ordinary C functions.

struct count_state { double n; };
/// Counts its ticks.
double count(struct count_state* s) { s->n += 1; return s->n; }
/// A multiple of x.
double scale(double x) { return ${factor} * x; }
/// x plus one.
double shift(double x) { return x + 1; }
`;

const faulty = `#include <math.h>
/// @library faulty
int quotient(double t, int b) { return t > 0.25 ? 7 / b : 7; }
double null(double t) { return t > 0.25 ? *(volatile double*)0 : t; }
double forever(double t) { while (t > 0.25) { __asm__ volatile(""); } return t; }
double invalid(double t) { return t > 0.25 ? NAN : t; }
double good(double t) { return 2 * t; }
`;
/** A library that was built for a later version of the LSI interface. */
const other_interface = `#include <ugoki/lsi.h>
static const ugoki_library l = {sizeof l, UGOKI_LSI_ABI + 1, "later", "1"};
UGOKI_EXPORT const ugoki_library* ugoki_lsi_library(void) { return &l; }
`;


/** Selects an LSI. @return a function that reads the text of its first output in the inspector */
async function read_outputs(page, node) {
  const at = await head(page, node);
  await page.mouse.click(at.x, at.y);
  await page.locator('.inspector h4', { hasText: 'Outputs' }).waitFor();
  return () => page.locator('.inspector .lsi-value output').first().textContent();
}
const number_of = (text) => Number(text.replace('–', 'NaN').replace('…', '').trim().split(/\s+/)[0]);

async function simulate(page) {
  await page.getByRole('radio', { name: 'Simulate' }).click();
  await page.waitForTimeout(300);
  const restart = page.getByRole('button', { name: 'Restart' });
  if (await restart.count()) await restart.first().click();
}
const transport = (page) => page.evaluate(() => window.ugoki.transport());
/** Repeats `ask` until its result is truthy, and returns it. */
async function wait_for(page, ask, description, timeout = 30000) {
  const end = Date.now() + timeout;
  for (;;) {
    const result = await ask();
    if (result) return result;
    assert.ok(Date.now() < end, `waited ${timeout / 1000} s in vain for: ${description}`);
    await page.waitForTimeout(60);
  }
}
/** Shows the whole generated circuit, with free space for a few LSIs below it. */
async function reset_circuit(page) {
  await page.locator('.circuit[role=application]').focus();
  if ((await state(page)).edited) {
    await page.getByRole('button', { name: 'Reset to generated' }).click();
    await until(page, (c) => !c.edited, 'the generated circuit');
  }
  await page.keyboard.press('Escape');
  await page.keyboard.press('a');
  await page.waitForTimeout(300);
}

/** Connects a clock to a faulty LSI, plays, and checks the problem shown at the LSI; then undoes the edits and plays again. */
async function fault(page, { lsi, output = false, pattern, zeros = [] }) {
  await large(page, true);
  await reset_circuit(page);
  await add(page, 'clock', await spot(page, 0.3, 0.9));
  await until(page, (c) => c.lsis.some((l) => l.id === 'clock'), 'the clock');
  await add(page, `faulty/${lsi}`, await spot(page, 0.55, 0.9));
  const id = `faulty-${lsi}`;
  await until(page, (c) => c.lsis.some((l) => l.id === id), 'the LSI');
  await page.waitForTimeout(250);
  await drag(page, await pin(page, 'clock', 'time', 'out'), await pin(page, id, 't', 'in'));
  await until(page, (c) => c.wires.includes(`clock.time > ${id}.t`), 'the wire');
  for (const name of zeros) {
    await add(page, 'constant', await spot(page, 0.3, 0.97));
    await until(page, (c) => c.lsis.some((l) => l.id === 'constant'), 'a zero');
    await page.waitForTimeout(250);
    await drag(page, await pin(page, 'constant', 'out', 'out'), await pin(page, id, name, 'in'));
    await until(page, (c) => c.wires.includes(`constant.out > ${id}.${name}`), 'its wire');
  }
  await wait_for_undo_label(page, /^Wire$/);
  await simulate(page);
  await page.getByRole('button', { name: 'Play' }).click();
  const bubble = page.locator(`[data-lsi="${id}"] .problem-bubble`);
  await bubble.waitFor({ timeout: 30000 });
  const text = await bubble.textContent();
  assert.match(text, new RegExp(`'${id}'.*library 'faulty'`), text);
  assert.match(text, pattern);
  assert.match(text, / at 0\.2\d\d s \(tick \d+\)/, text);
  assert.match(text, /Its inputs were 't' = 0\.2/, text);
  if (output) await page.locator(`[data-lsi="${id}"] .pin-row.out.bad-pin`).waitFor();
  await page.locator(`[data-lsi="${id}"].bad`).waitFor();
  await page.locator('.problem-count', { hasText: 'Stopped' }).waitFor();
  assert.ok((await page.evaluate(() => window.ugoki.log())).some((line) => /^error: .*library 'faulty'/s.test(line)), 'the fault is in the log');
  await page.screenshot({ path: `${pictures}plugin-${lsi}.png` });
  // the studio is still connected, the unsaved edit is kept, undo works
  const after = await page.evaluate(() => ({ connected: window.ugoki.connected, ...window.ugoki.undo() }));
  assert.ok(after.connected && after.can_undo);
  assert.equal(after.undo_label, 'Wire');
  await page.locator('.circuit[role=application]').focus();
  for (let i = 0; i < 3 + 2 * zeros.length; i++) {
    const before = (await page.evaluate(() => window.ugoki.undo())).undo_label;
    await page.keyboard.press('Control+z');
    await wait_for(page, async () => (await page.evaluate(() => window.ugoki.undo())).undo_label !== before, 'undo');
  }
  await until(page, (c) => !c.lsis.some((l) => l.id === id || l.id === 'clock'), 'all edits to be undone');
  await simulate(page);
  await page.getByRole('button', { name: 'Play' }).click();
  await wait_for(page, async () => (await transport(page)).simulated > 0.4, 'the content to run again');
  await page.getByRole('button', { name: 'Pause' }).click();
}

const journeys = [
  {
    name: 'plug-in: one command builds three LSIs from a C file, only with consent, and the studio lists them without a restart',
    async run({ page, service }) {
      await large(page, true);
      writeFileSync(join(service.folder, 'tools.c'), tools(2));
      const refused = service.run(['lsi', 'build', 'tools.c', '--install']);
      assert.equal(refused.status, 1, refused.stdout);
      assert.match(refused.stderr, /needs your consent/);
      await page.locator('.circuit[role=application]').focus();
      await page.keyboard.press('Tab');
      await page.keyboard.type('tools/');
      await page.waitForTimeout(700);
      assert.equal(await page.locator('.candidate-name', { hasText: 'tools/' }).count(), 0, 'no LSI is installed without consent');
      await page.keyboard.press('Escape');

      const built = service.run(['lsi', 'build', 'tools.c', '--install', '--yes']);
      assert.equal(built.status, 0, built.stderr);
      await page.locator('.circuit[role=application]').focus();
      await page.keyboard.press('Tab');
      await page.keyboard.type('tools/');
      await wait_for(page, async () => (await page.locator('.candidate-name', { hasText: 'tools/' }).count()) === 3, 'three LSIs in the search');
      assert.deepEqual((await page.locator('.candidate-name', { hasText: 'tools/' }).allTextContents()).sort(), ['tools/count', 'tools/scale', 'tools/shift']);
      await page.screenshot({ path: `${pictures}plugin-search.png` });
      await page.keyboard.press('Escape');
    },
  },
  {
    name: 'plug-in: the LSIs are wired by mouse and run, and their values are shown',
    async run({ page, memory }) {
      await reset_circuit(page);
      for (const [i, name] of ['count', 'scale', 'shift'].entries()) {
        await add(page, `tools/${name}`, await spot(page, 0.2 + 0.22 * i, 0.9));
        await until(page, (c) => c.lsis.some((l) => l.id === `tools-${name}`), name);
      }
      await page.waitForTimeout(250);
      await drag(page, await pin(page, 'tools-count', 'out', 'out'), await pin(page, 'tools-scale', 'x', 'in'));
      await drag(page, await pin(page, 'tools-scale', 'out', 'out'), await pin(page, 'tools-shift', 'x', 'in'));
      await until(page, (c) => c.wires.includes('tools-count.out > tools-scale.x') && c.wires.includes('tools-scale.out > tools-shift.x'), 'both wires');
      const at = await pin(page, 'tools-shift', 'out', 'out');
      await page.mouse.click(at.x, at.y, { button: 'right' });
      await page.getByRole('menuitem', { name: 'Add probe' }).click();
      await until(page, (c) => c.probes.length === 1, 'the probe');
      for (const [i, name] of ['count', 'scale', 'shift'].entries()) {
        if (i > 0) await page.keyboard.down('Shift');
        const at = await head(page, `tools-${name}`);
        await page.mouse.click(at.x, at.y);
        if (i > 0) await page.keyboard.up('Shift');
      }
      await until(page, (c) => c.selected.length === 3, 'the three selected');
      await large(page, false); // restore the panel's size, so that the inspector is visible
      await page.locator('.circuit[role=application]').focus();
      await page.keyboard.press('f');
      await page.locator('[data-lsi="tools-scale"] .lsi-head').waitFor();
      await page.waitForTimeout(300);
      memory.read = await read_outputs(page, 'tools-scale');
      await simulate(page);
      await page.getByLabel('Playback speed').selectOption('0.1'); // slow, so that the content is still playing when the new code is loaded
      await page.getByRole('button', { name: 'Play' }).click();
      const first = await wait_for(page, async () => number_of(await memory.read()) > 20 && number_of(await memory.read()), 'the scaled count');
      const later = await wait_for(page, async () => number_of(await memory.read()) > first && number_of(await memory.read()), 'the value to grow');
      assert.ok(later > first);
      const probe = number_of(await page.locator('.probe-value').textContent());
      assert.ok(probe > 20, `the probe of the last one shows ${probe}`);
      await page.screenshot({ path: `${pictures}plugin-running.png` });
    },
  },
  {
    name: 'plug-in: when the file changes, the running circuit continues with the new code and the old state',
    async run({ page, service, memory }) {
      const watch = service.spawn(['lsi', 'watch', 'tools.c']);
      try {
        const before = (await transport(page)).simulated;
        const count = number_of(await memory.read()) / 2;
        assert.ok((await transport(page)).playing, 'the circuit is still playing');
        await page.waitForTimeout(1200); // wait for the first build by `ugoki lsi watch`
        writeFileSync(join(service.folder, 'tools.c'), tools(-10));
        const now = await wait_for(page, async () => number_of(await memory.read()) < -20 && number_of(await memory.read()), 'the new code');
        assert.ok(now / -10 >= count, `the counter kept its state: ${now / -10} after ${count}`);
        await wait_for(page, async () => number_of(await page.locator('.probe-value').textContent()) < -20, 'the probe of the new code');
        const after = await transport(page);
        assert.ok(after.simulated >= before, 'the time did not go back');
        assert.ok((await page.evaluate(() => window.ugoki.log())).some((l) => /continues with the new ones/.test(l)), 'the reload is in the log');
        await page.screenshot({ path: `${pictures}plugin-reloaded.png` });
      } finally {
        watch.kill('SIGINT');
      }
      await page.getByRole('button', { name: 'Pause' }).click();
      await page.getByLabel('Playback speed').selectOption('1');
      await page.getByRole('button', { name: 'Reset to generated' }).click();
      await wait_for_undo_label(page, /^Use default circuit$/);
    },
  },
  {
    name: 'plug-in: a library for another interface version is refused with a message',
    async run({ page, service }) {
      writeFileSync(join(service.folder, 'faulty.c'), faulty);
      const built = service.run(['lsi', 'build', 'faulty.c', '--install', '--yes']);
      assert.equal(built.status, 0, built.stderr);
      writeFileSync(join(service.folder, 'later.c'), other_interface);
      const later = service.run(['lsi', 'build', 'later.c', '--install', '--yes']);
      assert.equal(later.status, 1, later.stdout);
      assert.match(later.stderr, /built for version \d+ of the LSI interface; this program has version \d+/);
      await large(page, true);
      await page.locator('.circuit[role=application]').focus();
      await page.keyboard.press('Tab');
      await page.keyboard.type('faulty/');
      await wait_for(page, async () => (await page.locator('.candidate-name', { hasText: 'faulty/' }).count()) === 5, 'the other library');
      await page.keyboard.press('Escape');
    },
  },
  { name: 'plug-in: a null pointer is reported at the LSI; studio and project survive', run: ({ page }) => fault(page, { lsi: 'null', pattern: /used a null pointer/ }) },
  { name: 'plug-in: an integer division by zero is reported at the LSI', run: ({ page }) => fault(page, { lsi: 'quotient', pattern: /divided an integer by zero/, zeros: ['b'] }) },
  { name: 'plug-in: an endless loop is reported at the LSI', run: ({ page }) => fault(page, { lsi: 'forever', pattern: /did not return within 3\.0 s and was stopped/ }) },
  { name: 'plug-in: a NaN output is reported at the LSI and its pin', run: ({ page }) => fault(page, { lsi: 'invalid', pattern: /of its output 'out' is not finite/, output: true }) },
  {
    name: 'plug-in: a native program carries the library that its content uses, after consent',
    async run({ page, service }) {
      await reset_circuit(page);
      await add(page, 'clock', await spot(page, 0.3, 0.9));
      await add(page, 'faulty/good', await spot(page, 0.55, 0.9));
      await until(page, (c) => c.lsis.some((l) => l.id === 'clock') && c.lsis.some((l) => l.id === 'faulty-good'), 'both LSIs');
      await page.waitForTimeout(250);
      await drag(page, await pin(page, 'clock', 'time', 'out'), await pin(page, 'faulty-good', 't', 'in'));
      await wait_for_undo_label(page, /^Wire$/);
      const export_program = async () => {
        await page.keyboard.press('Control+k');
        await page.getByRole('combobox', { name: 'Search commands' }).fill('native program');
        await page.keyboard.press('Enter');
        await page.getByRole('dialog', { name: 'Carry libraries along' }).waitFor();
      };
      const dialog = page.getByRole('dialog', { name: 'Carry libraries along' });
      await export_program();
      assert.match(await dialog.textContent(), /faulty.*[0-9a-f]{64}/);
      await page.screenshot({ path: `${pictures}plugin-carry.png` });
      assert.deepEqual(await violations(page), []);
      await page.keyboard.press('Escape');
      await dialog.waitFor({ state: 'detached' });
      await export_program();
      const [file] = await Promise.all([page.waitForEvent('download'), dialog.getByRole('button', { name: 'Carry along and export' }).click()]);
      const program = join(service.folder, 'carried');
      await file.saveAs(program);
      chmodSync(program, 0o755);
      const run = spawnSync(program, ['--headless', '--steps', '20'], { encoding: 'utf8', env: { ...process.env, UGOKI_LSI: '/nowhere' } });
      assert.equal(run.status, 0, run.stderr);
      assert.match(run.stdout, /in 20 steps, state [0-9a-f]{16}/);
      await page.getByRole('button', { name: 'Reset to generated' }).click();
      await wait_for_undo_label(page, /^Use default circuit$/);
    },
  },
  {
    name: 'plug-in: LSIs of a removed library are shown as missing, and the circuit is unchanged',
    async run({ page, service }) {
      await reset_circuit(page);
      await add(page, 'faulty/good', await spot(page, 0.5, 0.9));
      await until(page, (c) => c.lsis.some((l) => l.id === 'faulty-good'), 'the LSI');
      assert.equal(service.run(['lsi', 'remove', 'faulty']).status, 0);
      await page.locator('[data-lsi="faulty-good"] .missing-mark').waitFor();
      assert.equal((await state(page)).lsis.find((l) => l.id === 'faulty-good').type, 'faulty/good');
      await page.locator('.circuit[role=application]').focus();
      await page.keyboard.press('Control+z');
      await until(page, (c) => !c.lsis.some((l) => l.id === 'faulty-good'), 'undo');
      await page.locator('.tab', { hasText: 'Circuit' }).dblclick();
      await page.locator('.tab', { hasText: 'Scenario' }).click();
    },
  },
];

export const plugin_journeys = journeys.map((journey) => ({ ...journey, skip }));
