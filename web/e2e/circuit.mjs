// Journeys (end-to-end tests) through the wiring editor by mouse and keyboard. Each starts with the page as the previous journey left it.
// All names begin with "circuit".
import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { painted } from './browser.mjs';
import { mock } from './service.mjs';
import { add, drag, head, ids, pin, spot, state, wait_for_undo_label, undo, until } from './wiring.mjs';

const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const skip = mock && 'the mock service has no circuit runtime';
const journeys = [
  {
    name: 'circuit: the generated execution circuit is shown with its LSIs, pins and wires',
    async run({ page, memory }) {
      await page.locator('.tab', { hasText: 'Circuit' }).click();
      await page.locator('.tab', { hasText: 'Circuit' }).dblclick(); // maximises the panel
      const shown = await until(page, (c) => c.lsis.length > 5 && c.facts?.near > 5, 'the circuit');
      assert.equal(shown.edited, false);
      assert.ok(shown.lsis.some((l) => l.type === 'dynamics') && shown.wires.includes('status.state > dynamics.state'));
      await painted(page);
      memory.circuit = shown.lsis.length;
      await page.waitForFunction(() => document.querySelectorAll('.lsi').length >= 5); // LSIs are DOM elements, not drawn on the canvas
      await page.screenshot({ path: `${pictures}circuit-generated.png` });
    },
  },
  {
    name: 'circuit: the search adds LSIs, opened with Tab or a double click',
    async run({ page }) {
      await page.locator('.circuit[role=application]').focus();
      const at = await spot(page, 0.1, 0.72);
      await page.mouse.move(at.x, at.y);
      await page.keyboard.press('Tab');
      await page.locator('.circuit-search input').waitFor();
      await page.keyboard.type('clock');
      await page.screenshot({ path: `${pictures}circuit-search.png` });
      await page.keyboard.press('Enter');
      await until(page, (c) => c.edited && c.lsis.some((l) => l.id === 'clock'), 'the clock');
      await add(page, 'gain', await spot(page, 0.3, 0.72));
      await until(page, (c) => c.lsis.some((l) => l.id === 'gain'), 'the gain');
      await wait_for_undo_label(page, /^Add gain$/);
    },
  },
  {
    name: 'circuit: dragging from pin to pin adds a wire; matching pins are highlighted',
    async run({ page }) {
      const from = await pin(page, 'clock', 'time', 'out');
      const to = await pin(page, 'gain', 'in', 'in');
      await page.mouse.move(from.x, from.y);
      await page.mouse.down();
      await page.mouse.move(from.x + 40, from.y + 10, { steps: 3 });
      await page.locator('.pin-row.fits').first().waitFor();
      assert.ok((await page.locator('.pin-row.fits').count()) > 0, 'some pins fit');
      assert.ok((await page.locator('.pin-row.unfit').count()) > 10, 'others do not');
      await page.screenshot({ path: `${pictures}circuit-wiring.png` });
      await page.mouse.move(to.x, to.y, { steps: 6 });
      await page.mouse.up();
      await until(page, (c) => c.wires.includes('clock.time > gain.in'), 'the wire');
      await wait_for_undo_label(page, /^Wire$/);
    },
  },
  {
    name: 'circuit: a wire dropped on the empty canvas offers matching LSIs and connects the chosen one',
    async run({ page }) {
      await drag(page, await pin(page, 'gain', 'out', 'out'), await spot(page, 0.5, 0.72));
      await page.locator('.circuit-search .fits-line').waitFor();
      assert.match(await page.locator('.fits-line').textContent(), /fits scalar/);
      const offered = await page.locator('.candidate-name').allTextContents();
      assert.ok(offered.includes('low-pass') && !offered.includes('constant') && !offered.includes('split vector'), offered.join());
      await page.keyboard.type('low-pass');
      await page.screenshot({ path: `${pictures}circuit-drop.png` });
      await page.keyboard.press('Enter');
      await until(page, (c) => c.wires.includes('gain.out > low-pass.in'), 'the wired filter');
    },
  },
  {
    name: 'circuit: a wire between different types is refused with the reason',
    async run({ page }) {
      const before = (await state(page)).wires.length;
      await add(page, 'split vector', await spot(page, 0.25, 0.94));
      await until(page, (c) => c.lsis.some((l) => l.id === 'split-vector'), 'the splitter');
      await painted(page);
      await drag(page, await pin(page, 'gain', 'out', 'out'), await pin(page, 'split-vector', 'in', 'in'));
      await page.locator('.refusal').waitFor();
      assert.match(await page.locator('.refusal').textContent(), /carries scalar.*takes vector/);
      await page.screenshot({ path: `${pictures}circuit-refused.png` });
      assert.equal((await state(page)).wires.length, before);
      await page.locator('.circuit[role=application]').focus();
      await page.keyboard.press('Delete');
      await until(page, (c) => !c.lsis.some((l) => l.id === 'split-vector'), 'the splitter to be deleted');
    },
  },
  {
    name: 'circuit: moving an LSI is one command that can be undone and redone',
    async run({ page }) {
      const before = (await state(page)).lsis.find((l) => l.id === 'gain').at;
      await page.locator('.circuit[role=application]').focus();
      await page.keyboard.press('Control+k'); // the palette takes the focus while Ctrl is down; the drag below must snap all the same
      await page.keyboard.press('Escape');
      const from = await head(page, 'gain');
      await drag(page, from, { x: from.x + 60, y: from.y + 50 });
      const after = await until(page, (c) => String(c.lsis.find((l) => l.id === 'gain').at) !== String(before), 'the new position');
      const at = after.lsis.find((l) => l.id === 'gain').at;
      assert.ok(at[0] > before[0] + 20 && at.every((v) => v % 10 === 0), `on the grid: ${at}`);
      await wait_for_undo_label(page, /Move “gain”/);
      await page.keyboard.press('Control+z');
      await until(page, (c) => String(c.lsis.find((l) => l.id === 'gain').at) === String(before), 'undo');
      await page.keyboard.press('Control+Shift+z');
      await until(page, (c) => String(c.lsis.find((l) => l.id === 'gain').at) === String(at), 'redo');
    },
  },
  {
    name: 'circuit: values update while playing, and a probe draws a curve',
    async run({ page }) {
      const at = await pin(page, 'low-pass', 'out', 'out');
      await page.mouse.click(at.x, at.y, { button: 'right' });
      await page.getByRole('menuitem', { name: 'Add probe' }).click();
      await until(page, (c) => c.probes.length === 1 && c.probes[0].pin === 'low-pass.out', 'the probe');
      await page.getByRole('radio', { name: 'Simulate' }).click();
      await page.waitForFunction(() => window.ugoki.transport().mode === 'simulate');
      await page.getByRole('button', { name: 'Play' }).click();
      const value = () => page.evaluate(() => window.ugoki.pin_value('clock', 'time')?.[0]);
      const end = Date.now() + 30000;
      while (!((await value()) > 0.2)) {
        assert.ok(Date.now() < end, `the clock's pin shows the time: ${await value()}`);
        await page.waitForTimeout(80);
      }
      const first = await value();
      await page.waitForFunction((at) => window.ugoki.pin_value('clock', 'time')?.[0] > at, first); // the value keeps growing
      assert.ok((await state(page)).facts.values >= 3, 'the values in view are drawn');
      assert.match(await page.locator('.fact .tick').textContent(), /(µs|ms|ns) per tick/);
      assert.match(await page.locator('.probe-value').textContent(), /\d/);
      assert.ok((await page.locator('.probe canvas').count()) === 1, 'the curve');
      await page.screenshot({ path: `${pictures}circuit-playing.png` });
      await page.getByRole('button', { name: 'Pause' }).click();
    },
  },
  {
    name: 'circuit: a run stops at a breakpoint, continues by single ticks, and ignores it when switched off',
    async run({ page }) {
      const transport = () => page.evaluate(() => window.ugoki.transport());
      const menu = async (name) => {
        const at = await pin(page, 'clock', 'time', 'out');
        await page.mouse.click(at.x, at.y, { button: 'right' });
        await page.getByRole('menuitem', { name }).click();
      };
      const edits = (await undo(page)).undo_label;
      await menu('Add breakpoint…');
      await page.getByRole('textbox', { name: 'Value' }).fill('0.5');
      await page.screenshot({ path: `${pictures}circuit-stop-form.png` });
      await page.keyboard.press('Enter');
      const mark = page.locator('[data-pin="clock.time"] .stop-dot');
      await mark.waitFor();
      assert.equal((await undo(page)).undo_label, edits, 'a breakpoint is not an edit of the circuit');
      await page.getByRole('button', { name: 'Go to start' }).click();
      await page.getByRole('button', { name: 'Play' }).click();
      await page.locator('.stop-notice').waitFor({ timeout: 30000 });
      const { step } = await page.evaluate(() => window.ugoki.document());
      const stopped = await transport();
      const first = Math.floor(0.5 / step + 1e-6) + 1; // index of the first tick after 0.5 s
      assert.equal(stopped.playing, false);
      assert.ok(Math.abs(stopped.time - (first + 1) * step) < 1e-9, `the time is that after this tick: ${stopped.time}`);
      assert.match(await page.locator('.stop-notice').textContent(), new RegExp(`clock · time > 0\\.5is 0\\.50\\d* at 0\\.50\\d s, tick ${first}`));
      assert.equal(await page.locator('[data-pin="clock.time"].stop-hit').count(), 1, 'the pin is highlighted');
      await painted(page);
      await page.screenshot({ path: `${pictures}circuit-stopped.png` });
      await page.getByRole('button', { name: 'One tick' }).click();
      await page.locator('.stop-notice').waitFor({ state: 'detached' });
      assert.ok(Math.abs((await transport()).time - (first + 2) * step) < 1e-9, 'one tick later');
      await page.getByRole('button', { name: '1 breakpoint' }).click();
      await page.screenshot({ path: `${pictures}circuit-stop-list.png` });
      await page.locator('.stop-list input[type=checkbox]').click();
      await page.locator('[data-pin="clock.time"] .stop-dot.off').waitFor();
      await page.getByRole('button', { name: '1 breakpoint' }).click();
      await page.getByRole('button', { name: 'Go to start' }).click();
      await page.getByRole('button', { name: 'Play' }).click();
      const end = Date.now() + 30000;
      while (!((await transport()).time > 0.8)) {
        assert.ok(Date.now() < end, 'the run passes the breakpoint that is switched off');
        await page.waitForTimeout(60);
      }
      await page.getByRole('button', { name: 'Pause' }).click();
      await menu('Remove breakpoint');
      await mark.waitFor({ state: 'detached' });
    },
  },
  {
    name: 'circuit: the inspector sets declared parameters',
    async run({ page }) {
      const at = await head(page, 'gain');
      await page.mouse.click(at.x, at.y);
      await page.locator('.tab', { hasText: 'Circuit' }).dblclick(); // restores the panel's size, so that the inspector is visible
      const field = page.locator('.inspector').getByRole('textbox', { name: 'gain' });
      await field.fill('2.5');
      await page.keyboard.press('Enter');
      await until(page, (c) => c.lsis.find((l) => l.id === 'gain').parameters?.gain === 2.5, 'the parameter');
      await page.screenshot({ path: `${pictures}circuit-inspector.png` });
      await page.locator('.tab', { hasText: 'Circuit' }).dblclick();
      await page.waitForTimeout(300);
    },
  },
  {
    name: 'circuit: a selection is grouped, opened, left and ungrouped',
    async run({ page }) {
      const before = (await state(page)).wires.slice().sort();
      const from = await head(page, 'gain');
      await page.mouse.click(from.x, from.y);
      const other = await head(page, 'low-pass');
      await page.keyboard.down('Shift');
      await page.mouse.click(other.x, other.y);
      await page.keyboard.up('Shift');
      await until(page, (c) => c.selected.length === 2, 'both selected');
      await page.keyboard.press('Control+g');
      const grouped = await until(page, (c) => c.lsis.some((l) => l.id === 'group') && !c.lsis.some((l) => l.id === 'gain'), 'the group');
      assert.ok(grouped.wires.includes('clock.time > group.in') && grouped.circuits.includes('group'));
      await painted(page);
      const at = await head(page, 'group');
      await page.mouse.dblclick(at.x, at.y);
      await until(page, (c) => c.path.join() === 'group' && c.lsis.length === 2, 'the inside of the group');
      await painted(page);
      await page.screenshot({ path: `${pictures}circuit-inside.png` });
      await page.locator('.crumbs button').first().click();
      await until(page, (c) => c.path.length === 0 && c.selected.join() === 'group', 'the outer level');
      await page.locator('.circuit[role=application]').focus();
      await page.keyboard.press('Control+Shift+g');
      const flat = await until(page, (c) => c.lsis.some((l) => l.id === 'low-pass'), 'the ungrouped LSIs');
      assert.deepEqual(flat.wires.slice().sort(), before);
    },
  },
  {
    name: 'circuit: an algebraic loop is marked at its LSIs, and Insert delay removes it',
    async run({ page }) {
      await page.locator('.circuit[role=application]').focus();
      await page.keyboard.press('a');
      await page.waitForTimeout(300);
      await page.mouse.click((await spot(page, 0.5, 0.97)).x, (await spot(page, 0.5, 0.97)).y);
      await add(page, 'add', await spot(page, 0.62, 0.93));
      await until(page, (c) => c.lsis.some((l) => l.id === 'add'), 'the adder');
      await page.waitForTimeout(250);
      await drag(page, await pin(page, 'low-pass', 'out', 'out'), await pin(page, 'add', 'a', 'in'));
      await drag(page, await pin(page, 'add', 'out', 'out'), await pin(page, 'add', 'b', 'in'));
      await until(page, (c) => c.problems.some((p) => /within one tick/.test(p)), 'the problem');
      await page.locator('.problem-bubble', { hasText: /within one tick/ }).waitFor();
      await page.getByRole('button', { name: 'Play' }).click();
      await page.locator('.toast.error', { hasText: /within one tick/ }).first().waitFor();
      await page.screenshot({ path: `${pictures}circuit-loop.png` });
      await page.locator('.toast.error').first().getByRole('button', { name: 'Dismiss' }).click();
      await page.locator('.problem-bubble button', { hasText: 'Insert delay' }).click();
      await until(page, (c) => c.problems.length === 0 && c.wires.includes('delay.out > add.b'), 'the loop to be removed');
    },
  },
  {
    name: 'circuit: copy, paste and delete',
    async run({ page }) {
      const at = await head(page, 'gain');
      await page.mouse.click(at.x, at.y);
      await page.keyboard.press('Control+c');
      const to = await spot(page, 0.8, 0.85);
      await page.mouse.move(to.x, to.y);
      await page.keyboard.press('Control+v');
      await until(page, (c) => c.lsis.some((l) => l.id === 'gain-2' && l.parameters.gain === 2.5), 'the copy');
      await page.keyboard.press('Control+d');
      await until(page, (c) => c.lsis.some((l) => l.id === 'gain-3'), 'the duplicate');
      await page.keyboard.press('Delete');
      await until(page, (c) => !c.lsis.some((l) => l.id === 'gain-3'), 'the duplicate to be deleted');
      await page.keyboard.press('Control+z');
      await page.keyboard.press('Control+z');
      await until(page, (c) => !c.lsis.some((l) => l.id === 'gain-3') && c.lsis.some((l) => l.id === 'gain-2'), 'two undone');
      await page.keyboard.press('Control+z');
      await until(page, (c) => !c.lsis.some((l) => l.id === 'gain-2') && c.problems.length === 0, 'the paste undone');
    },
  },
  {
    name: 'circuit: the keyboard alone adds and wires an LSI',
    async run({ page }) {
      await page.locator('.circuit[role=application]').focus();
      await page.mouse.move(5, 5);
      await page.keyboard.press('Tab');
      await page.keyboard.type('constant');
      await page.keyboard.press('Enter');
      await until(page, (c) => c.selected.join() === 'constant', 'the constant');
      await page.keyboard.press('Enter');
      await page.keyboard.press('Enter');
      await page.locator('.pin-row.target').waitFor();
      const target = await page.locator('.pin-row.target').getAttribute('data-pin');
      await page.keyboard.press('Enter');
      await until(page, (c) => c.wires.includes(`constant.out > ${target}`), `the wire to ${target}`);
      await page.keyboard.press('Escape');
      await page.keyboard.press('Control+z');
      await page.keyboard.press('Control+z');
      await until(page, (c) => !c.lsis.some((l) => l.id === 'constant'), 'both undone');
      assert.match(await page.locator('.circuit [role=status]').textContent(), /./);
    },
  },
  {
    name: 'circuit: automatic layout, and a note',
    async run({ page }) {
      await page.locator('.circuit[role=application]').focus();
      await page.keyboard.press('Escape');
      await page.keyboard.press('Escape');
      await page.keyboard.press('Shift+l');
      await wait_for_undo_label(page, /^Lay out$/);
      await page.waitForTimeout(500);
      const to = await spot(page, 0.06, 0.86);
      await page.mouse.move(to.x, to.y);
      await page.keyboard.press('n');
      await page.locator('.note textarea').waitFor();
      await page.keyboard.type('Filtered time, to see that the circuit is alive.');
      await page.keyboard.press('Control+Enter');
      await until(page, (c) => /alive/.test(c.notes[0]?.text ?? ''), 'the note');
      await page.screenshot({ path: `${pictures}circuit-layout.png` });
    },
  },
  {
    name: 'circuit: a saved circuit is unchanged after a reload of the page',
    async run({ page }) {
      await page.keyboard.press('Control+s');
      await page.waitForTimeout(500);
      const before = await state(page);
      await page.locator('.tab', { hasText: 'Circuit' }).dblclick(); // restores the panel's size, so that the viewport is visible
      await page.waitForTimeout(700);
      await page.reload({ waitUntil: 'load' });
      const after = await until(page, (c) => c.lsis.length === before.lsis.length, 'the circuit');
      for (const key of ['lsis', 'wires', 'notes', 'probes', 'circuits', 'edited']) assert.deepEqual(after[key], before[key], key);
    },
  },
  {
    name: 'circuit: Reset to generated is one command',
    async run({ page, memory }) {
      await page.locator('.tab', { hasText: 'Circuit' }).click();
      await until(page, (c) => c.facts !== null, 'the canvas');
      await page.getByRole('button', { name: 'Reset to generated' }).click();
      await until(page, (c) => !c.edited && c.lsis.length === memory.circuit, 'the generated circuit');
      await wait_for_undo_label(page, /^Use default circuit$/);
      await page.locator('.tab', { hasText: 'Scenario' }).click();
      assert.ok(!(await ids(page)).includes('gain'));
    },
  },
];

export const circuit_journeys = journeys.map((journey) => ({ ...journey, skip }));
