// Journeys for rules: interactive content without wiring.
import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { document_of, set_mode, step_history, toggle_theme, undo_to, until } from './browser.mjs';
import { resize } from './windows.mjs';
import { mock } from './service.mjs';
import { head } from './wiring.mjs';

const skip = mock && 'the mock service has no simulation';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const hook = (page, expression) => page.evaluate(`window.ugoki.${expression}`);
const rules_become = (page, fits, description) => until(page, async () => fits((await document_of(page)).rules ?? []), description);
const chip = (page, row, label) => page.locator('.rule').nth(row).getByLabel(label, { exact: true });

export const rule_journeys = [
  {
    name: 'rules: a game with keys and a touch is made by mouse, plays, and is undone',
    async run({ page }) {
      await set_mode(page, 'Edit');
      const before = await document_of(page);
      const human = before.characters.find((c) => c.track.length > 0);
      const ball = before.characters.find((c) => c.control.mode === 'passive');
      await page.locator(`[data-character="${human.id}"] .track-name`).click();
      await page.getByRole('tab', { name: 'Rules' }).click();
      await page.getByText('Rules make the content interactive').waitFor();
      await page.screenshot({ path: `${pictures}rules-empty.png` });

      // while J is held, stand
      await page.getByRole('button', { name: 'While a key is held, play…' }).click();
      await rules_become(page, (r) => r.length === 1 && r[0].mode === 'while' && r[0].do.loop, 'the first rule');
      await page.locator('.rule').first().getByRole('button', { name: /^Key / }).click();
      await page.keyboard.press('j');
      await rules_become(page, (r) => r[0].if[0].key === 'KeyJ', 'the key');
      assert.equal((await hook(page, 'transport()')).mode, 'edit', 'the key went to the rule');
      const motions = await chip(page, 0, 'Motion').locator('option').allTextContents();
      assert.ok(motions.some((m) => m.includes('Stand')) && motions.every((m) => !m.includes('Trot')), `only motions that fit: ${motions}`);
      await chip(page, 0, 'Motion').selectOption({ label: motions.find((m) => m.includes('Stand')) });
      await rules_become(page, (r) => r[0].do.motion !== human.track[0].motion, 'the motion');

      // when the ball touches the human, push the ball
      await page.getByRole('button', { name: '+ Rule' }).click();
      await page.screenshot({ path: `${pictures}rules-menu.png` });
      await page.getByRole('menuitem', { name: 'When something touches, play…' }).click();
      await rules_become(page, (r) => r.length === 2 && r[1].if[0].character === ball.id && r[1].if[0].other === human.id, 'the second rule');
      await chip(page, 1, 'Action').selectOption('push');
      await chip(page, 1, 'Character of the action').selectOption(ball.id);
      await chip(page, 1, 'What is touched').selectOption('ground');
      const force = page.locator('.rule').nth(1).getByLabel('Force Z');
      await force.fill('60');
      await force.press('Enter');
      await chip(page, 1, 'Force X').fill('0');
      await chip(page, 1, 'Force X').press('Enter');
      await rules_become(page, (r) => r[1].if[0].other === 'ground' && r[1].do.force[2] === 60 && r[1].do.force[0] === 0, 'a ball that jumps from the ground');

      // when K is pressed while it stands, walk once: a transition between two states
      await page.keyboard.press('Escape');
      await page.locator(`.rules-head`).click();
      await page.keyboard.press('r');
      await rules_become(page, (r) => r.length === 3, 'the third rule by the key R');
      await page.getByRole('button', { name: '+ and: add a condition to rule 3' }).click();
      await rules_become(page, (r) => r[2].if.length === 2, 'the second condition');
      await chip(page, 2, 'Kind of condition').nth(1).selectOption('playing');
      await chip(page, 2, 'Motion that plays').selectOption({ index: 1 });
      await rules_become(page, (r) => r[2].if[1].rule === r[0].id, 'the transition');
      await page.getByRole('button', { name: 'Move rule 3 up' }).click();
      await rules_become(page, (r) => r[1].if.length === 2, 'the higher priority');
      for (const [width, height] of [[1440, 900], [1280, 720], [1024, 640]]) {
        await resize(page, [width, height]);
        await page.screenshot({ path: `${pictures}rules-${width}.png` });
      }
      await resize(page, [1440, 900]);
      await toggle_theme(page);
      await page.screenshot({ path: `${pictures}rules-light.png` });
      await toggle_theme(page);

      // the generated circuit has the rules
      await page.getByRole('button', { name: 'Show as circuit' }).click();
      await until(page, async () => (await hook(page, 'circuit()'))?.lsis.some((l) => l.type === 'play rule'), 'the generated circuit');
      await page.getByRole('tab', { name: 'Rules' }).click();

      // play: J is held, the character stands
      await set_mode(page, 'Simulate');
      const enter = page.getByRole('button', { name: /^Play controls/ });
      await enter.waitFor({ timeout: 20000 });
      await enter.click();
      const count = (row) => page.locator('.rule').nth(row).locator('.rule-count').textContent();
      const first = page.locator('.rule').first();
      await until(page, async () => /\d+×|now/.test(await count(2)), 'the ball touches the ground');
      assert.equal(await first.getAttribute('data-active'), 'false');
      await page.keyboard.down('j');
      await until(page, async () => (await first.getAttribute('data-active')) === 'true', 'the rule is active');
      await until(page, async () => (await page.locator('.rule-state[data-active=true] strong').textContent()).includes('Stand'), 'the state is marked');
      await page.screenshot({ path: `${pictures}rules-play.png` });
      // the walk ends: the centre of mass comes to rest
      const place = async () => (await hook(page, `character(${JSON.stringify(human.id)})`)).com;
      await until(page, async () => {
        const [a, at] = [await place(), (await hook(page, 'transport()')).time];
        await page.waitForTimeout(400);
        const [b, later] = [await place(), (await hook(page, 'transport()')).time];
        return later > at && Math.hypot(b[0] - a[0], b[1] - a[1]) / (later - at) < 0.25;
      }, 'the human stands');
      await page.keyboard.up('j');
      await until(page, async () => (await first.getAttribute('data-active')) === 'false', 'the rule ends');
      assert.equal(await count(0), '1×');
      await until(page, async () => {
        const a = await place();
        await page.waitForTimeout(500);
        const b = await place();
        return Math.hypot(b[0] - a[0], b[1] - a[1]) > 0.15;
      }, 'the human walks on');
      await page.keyboard.press('Escape');

      // undo to the start
      await set_mode(page, 'Edit');
      await page.locator(`.rules-head`).click();
      while (JSON.stringify(await document_of(page)) !== JSON.stringify(before)) {
        const { undo_label, can_undo } = await hook(page, 'undo()');
        assert.ok(can_undo && /rule/i.test(undo_label), `undo “${undo_label}”`);
        await step_history(page, 'Control+z');
      }
      await page.getByText('Rules make the content interactive').waitFor();
      await page.getByRole('tab', { name: 'Scenario' }).click();
    },
  },
  {
    name: 'rules: a rule that is changed in the circuit comes back as a sentence, and one without the form of a rule is marked',
    async run({ page }) {
      await set_mode(page, 'Edit');
      const before = JSON.stringify(await document_of(page));
      const human = (await document_of(page)).characters.find((c) => c.track.length > 0);
      await page.locator(`[data-character="${human.id}"] .track-name`).click();
      await page.getByRole('tab', { name: 'Rules' }).click();
      await page.getByRole('button', { name: 'While a key is held, play…' }).click();
      await rules_become(page, (r) => r.length === 1, 'the rule');
      const { id } = (await document_of(page)).rules[0];
      const key = `rule-${id}-1`;

      // another key, set in the circuit
      const maximize = () => page.locator('.tab', { hasText: 'Circuit' }).dblclick(); // or restores the panel's size
      const select_lsi = async () => {
        await maximize();
        await page.waitForTimeout(500);
        await page.locator('.circuit[role=application]').focus();
        await page.keyboard.press('Home');
        await page.locator(`[data-lsi="${key}"]`).waitFor();
        await page.waitForTimeout(600);
        const at = await head(page, key);
        await page.mouse.click(at.x, at.y);
      };
      await page.getByRole('button', { name: 'Show as circuit' }).click();
      await select_lsi();
      await maximize();
      const field = page.locator('.inspector').getByRole('textbox', { name: 'key' });
      await field.fill('KeyU');
      await field.press('Enter');
      await until(page, async () => Boolean((await document_of(page)).circuit), 'a circuit of the project');
      await page.getByRole('tab', { name: 'Rules' }).click();
      const row = page.locator('.rule').first();
      await until(page, async () => /While U is held.*changed in the circuit/.test(await row.getAttribute('aria-label')), 'the sentence of the circuit');
      await page.screenshot({ path: `${pictures}rules-circuit.png` });
      await toggle_theme(page);
      await page.screenshot({ path: `${pictures}rules-circuit-light.png` });
      await toggle_theme(page);

      // its condition is removed: no sentence has this form
      await page.getByRole('button', { name: 'Open the circuit' }).click();
      await select_lsi();
      await page.keyboard.press('Delete');
      await until(page, async () => !(await document_of(page)).circuit.lsis.some((l) => l.id === key), 'the removed LSI');
      await maximize();
      await page.getByRole('tab', { name: 'Rules' }).click();
      await until(page, async () => /edited in the circuit/.test(await row.getAttribute('aria-label')), 'the mark');
      assert.equal(await page.getByRole('button', { name: 'Keep these rules' }).count(), 0);
      await page.screenshot({ path: `${pictures}rules-circuit-own.png` });
      await page.locator('.rules-head').click();
      await page.keyboard.press('Control+z');
      await until(page, async () => /changed in the circuit/.test(await row.getAttribute('aria-label')), 'the undone removal');

      // the sentence becomes the rule
      await page.getByRole('button', { name: 'Keep these rules' }).click();
      await until(page, async () => { const d = await document_of(page); return !d.circuit && d.rules[0].if[0].key === 'KeyU'; }, 'the kept rule');
      await undo_to(page, before);
      await page.getByRole('tab', { name: 'Scenario' }).click();
    },
  },
  {
    name: 'rules: a variable is made by mouse, counts keys, and its value starts a motion',
    async run({ page }) {
      await set_mode(page, 'Edit');
      const before = await document_of(page);
      const human = before.characters.find((c) => c.track.length > 0);
      await page.locator(`[data-character="${human.id}"] .track-name`).click();
      await page.getByRole('tab', { name: 'Rules' }).click();
      await page.getByRole('button', { name: '+ Number' }).click();
      await until(page, async () => (await document_of(page)).variables?.length === 1, 'a variable');
      const inspector = page.getByRole('form', { name: 'Inspector' });
      await inspector.getByLabel('Name').fill('Points');
      await inspector.getByLabel('Name').press('Enter');
      await inspector.getByLabel('Upper bound').click();
      await inspector.getByLabel('Maximum', { exact: true }).fill('4');
      await inspector.getByLabel('Maximum', { exact: true }).press('Enter');
      await until(page, async () => (await document_of(page)).variables[0].maximum === 4, 'the bound');
      await page.screenshot({ path: `${pictures}variables-empty.png` });

      // when K is pressed, change Points by 1
      await page.getByRole('button', { name: '+ Rule' }).click();
      await page.getByRole('menuitem', { name: 'When something touches, count…' }).click();
      await rules_become(page, (r) => r.length === 1 && r[0].do.type === 'set', 'the counting rule');
      await chip(page, 0, 'Kind of condition').selectOption('key');
      await page.locator('.rule').first().getByRole('button', { name: /^Key / }).click();
      await page.keyboard.press('k');
      await rules_become(page, (r) => r[0].if[0].key === 'KeyK', 'the key');
      // when Points reaches 3, play
      await page.getByRole('button', { name: '+ Rule' }).click();
      await page.getByRole('menuitem', { name: 'When a number is reached, play…' }).click();
      await rules_become(page, (r) => r.length === 2 && r[1].if[0].type === 'variable', 'the comparing rule');
      const motions = await chip(page, 1, 'Motion').locator('option').allTextContents();
      await chip(page, 1, 'Motion').selectOption({ label: motions.find((m) => m.includes('Stand')) });
      // while J is held, walk in a loop; a drag from that state to the other one makes a transition
      await page.getByRole('button', { name: '+ Rule' }).click();
      await page.getByRole('menuitem', { name: 'While a key is held, play…' }).click();
      await rules_become(page, (r) => r.length === 3, 'the third rule');
      const center = async (n) => {
        const box = await page.locator('.rule-state').nth(n).boundingBox();
        return [box.x + box.width / 2, box.y + box.height / 2];
      };
      const [from, to] = [await center(2), await center(1)];
      await page.mouse.move(...from);
      await page.mouse.down();
      await page.mouse.move((from[0] + to[0]) / 2, (from[1] + to[1]) / 2, { steps: 4 });
      await page.mouse.move(...to, { steps: 4 });
      await page.screenshot({ path: `${pictures}variables-drag.png` });
      await page.mouse.up();
      await rules_become(page, (r) => r.length === 4 && r[3].if[0].type === 'playing' && r[3].if[0].rule === r[2].id && r[3].do.motion === r[1].do.motion, 'the transition');
      assert.equal(await page.locator('.rule-state').count(), 3, 'the transition leads to the state that exists');
      await chip(page, 3, 'Action').selectOption('grab');
      await rules_become(page, (r) => r[3].do.type === 'grab' && r[3].do.link, 'a hand that grabs');
      for (const [width, height] of [[1440, 900], [1024, 640]]) {
        await resize(page, [width, height]);
        await page.screenshot({ path: `${pictures}variables-${width}.png` });
      }
      await resize(page, [1440, 900]);
      await toggle_theme(page);
      await page.screenshot({ path: `${pictures}variables-light.png` });
      await toggle_theme(page);

      // play: the third press of K starts the motion; the fifth is beyond the bound
      await set_mode(page, 'Simulate');
      const enter = page.getByRole('button', { name: /^Play controls/ });
      await enter.waitFor({ timeout: 20000 });
      await enter.click();
      const value = page.locator('.variable-board dd');
      const second = page.locator('.rule').nth(1);
      await until(page, async () => (await value.textContent()) === '0', 'the value at the start, over the viewport');
      for (let n = 1; n <= 5; n++) {
        await page.keyboard.down('k');
        await until(page, async () => (await page.locator('.rule').first().locator('.rule-count').textContent()) === 'now', `press ${n}`);
        await page.keyboard.up('k');
        await until(page, async () => (await page.locator('.rule').first().locator('.rule-count').textContent()) !== 'now', `release ${n}`);
        await until(page, async () => (await value.textContent()) === String(Math.min(n, 4)), `the count ${n}`);
        await until(page, async () => (await page.locator('.variable strong').textContent()) === String(Math.min(n, 4)), 'the same value above the rules');
        await until(page, async () => /1×|now/.test(await second.locator('.rule-count').textContent()) === n >= 3, `the motion starts with the third press, not with ${n}`);
        if (n === 3) await page.screenshot({ path: `${pictures}variables-play.png` });
      }
      await page.keyboard.press('Escape');
      await set_mode(page, 'Edit');
      await page.locator(`.rules-head`).click();
      // removing the variable removes its rules, in one step
      await page.locator('.variable').click();
      await inspector.getByText('2 rules use it.').waitFor();
      await inspector.getByRole('button', { name: 'Delete' }).click();
      await rules_become(page, (r) => r.length === 2, 'its rules are removed');
      while (JSON.stringify(await document_of(page)) !== JSON.stringify(before)) {
        const { undo_label, can_undo } = await hook(page, 'undo()');
        assert.ok(can_undo && /rule|variable/i.test(undo_label), `undo “${undo_label}”`);
        await step_history(page, 'Control+z');
      }
      await page.getByRole('tab', { name: 'Scenario' }).click();
    },
  },
].map((journey) => ({ ...journey, skip }));
