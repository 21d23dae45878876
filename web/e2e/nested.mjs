// Journeys for nested scenarios: nest, place, move, open, edit inside, leave, unnest.
import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { violations } from './accessibility.mjs';
import { blur, camera_rests, document_of, rested, set_mode, text_of, toggle_theme, undo_to, until } from './browser.mjs';
import { mock } from './service.mjs';

const skip = mock && 'the mock service has no nested scenarios';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const hook = (page, expression) => page.evaluate(`window.ugoki.${expression}`);
const head = (page, id) => page.locator(`[data-character="${id}"] .track-name`);
const instances = async (page) => (await document_of(page)).instances ?? [];
const field = (page, name) => page.getByRole('form', { name: 'Inspector' }).getByLabel(name, { exact: true });

/** Begins at the scenario panel in Edit, at time 0, without a selection. @return the text of the document */
async function begin(page) {
  await set_mode(page, 'Edit');
  await page.getByRole('tab', { name: 'Scenario' }).click();
  await blur(page);
  await page.keyboard.press('Escape');
  await page.keyboard.press('Shift+ArrowLeft');
  await page.keyboard.press('Home');
  return text_of(page);
}

/** Nests the first two characters with clips by Ctrl-click and Shift+N. @return their ids */
async function nest_two(page) {
  const [first, second] = (await document_of(page)).characters.filter((c) => c.track.length > 0).map((c) => c.id);
  await head(page, first).click();
  await head(page, second).click({ modifiers: ['Control'] });
  await page.getByText('2 tracks', { exact: true }).waitFor();
  await blur(page);
  await page.keyboard.press('Shift+N');
  await until(page, async () => (await instances(page)).length === 1, 'one instance');
  await page.locator('.clip.nested').waitFor();
  return [first, second];
}

async function clean_in_both_themes(page, name) {
  await rested(page);
  await page.screenshot({ path: `${pictures}${name}.png` });
  const found = await violations(page);
  await toggle_theme(page);
  await rested(page);
  await page.screenshot({ path: `${pictures}${name}-light.png` });
  found.push(...(await violations(page)));
  await toggle_theme(page);
  assert.deepEqual(found, [], `accessibility of ${name}`);
}

export const nested_journeys = [
  {
    name: 'nested: two tracks become one row, which is moved, placed twice, selected in the viewport, and unnested',
    async run({ page }) {
      const before = await begin(page);
      const [first] = await nest_two(page);
      const [made] = await instances(page);
      assert.equal(made.name, 'Duet 1');
      assert.equal((await hook(page, 'selection()')).instance, made.id);
      assert.equal(await page.locator(`[data-character="${first}"]`).count(), 0, 'the tracks are inside');
      await clean_in_both_themes(page, 'nested-row');

      // the block moves in time
      const box = await page.locator('.clip.nested').boundingBox();
      await page.mouse.move(box.x + 60, box.y + box.height / 2);
      await page.mouse.down();
      await page.mouse.move(box.x + 160, box.y + box.height / 2, { steps: 5 });
      await page.mouse.up();
      await until(page, async () => (await instances(page))[0].start > 0.2, 'a later start');
      await page.keyboard.press('Control+z');
      await until(page, async () => (await instances(page))[0].start === 0, 'the undone start');

      // inspector
      await field(page, 'Name').fill('Left pair');
      await field(page, 'Name').press('Enter');
      await until(page, async () => (await instances(page))[0].name === 'Left pair', 'the new name');
      await field(page, 'Y').fill('2');
      await field(page, 'Y').press('Enter');
      await until(page, async () => (await instances(page))[0].place.y === 2, 'the new place');

      // a copy, with characters of its own in the viewport
      await blur(page);
      await page.keyboard.press('Control+d');
      await until(page, async () => (await instances(page)).length === 2, 'two instances');
      const copy = (await instances(page))[1];
      assert.equal((await hook(page, 'selection()')).instance, copy.id);
      await page.keyboard.press('a');
      const nested = `${made.id}/${first}`;
      await until(page, async () => hook(page, `link_on_screen(${JSON.stringify(nested)}, 0)`), 'the nested character in the viewport');
      await camera_rests(page);
      await until(page, async () => {
        const at = await hook(page, `link_on_screen(${JSON.stringify(nested)}, 0)`);
        await page.mouse.click(at.x, at.y);
        await page.waitForTimeout(100);
        return (await hook(page, 'selection()')).instance === made.id;
      }, 'the instance selected by a click on its character');
      await rested(page);
      await page.screenshot({ path: `${pictures}nested-twice.png` });

      // the context menu
      await page.locator(`[data-instance="${copy.id}"] .track-name`).click({ button: 'right' });
      await page.getByRole('menuitem', { name: 'Unnest' }).waitFor();
      await page.screenshot({ path: `${pictures}nested-menu.png` });
      await page.getByRole('menuitem', { name: 'Unnest' }).click();
      await until(page, async () => (await instances(page)).length === 1, 'the copy unnested');
      assert.equal((await document_of(page)).characters.length, JSON.parse(before).characters.length, 'its two characters are tracks again');

      // the last instance: the scenario stays in the list, and can be placed again
      await page.locator(`[data-instance="${made.id}"] .track-name`).click();
      await page.keyboard.press('Delete');
      await page.locator('.toast', { hasText: 'stays in the list' }).waitFor();
      await blur(page);
      await page.keyboard.press('Escape');
      await page.getByRole('list', { name: 'Nested scenarios' }).getByText('not placed').waitFor();
      await clean_in_both_themes(page, 'nested-list');
      await page.getByRole('button', { name: 'Place Duet' }).click();
      await until(page, async () => (await instances(page)).length === 1, 'placed again');
      await undo_to(page, before);
    },
    skip,
  },
  {
    name: 'nested: a scenario is opened, edited and simulated alone; the change acts in all its places, and Escape leads back',
    async run({ page }) {
      const before = await begin(page);
      const [first, second] = await nest_two(page);
      await page.keyboard.press('Control+d');
      await until(page, async () => (await instances(page)).length === 2, 'two instances');
      await page.locator('.clip.nested').first().dblclick();
      await page.getByRole('navigation', { name: 'Open scenario' }).waitFor();
      await until(page, async () => (await document_of(page)).characters.length === 2, 'the inside');
      assert.deepEqual((await document_of(page)).characters.map((c) => c.id).sort(), [first, second].sort());
      await page.getByText('Changes act wherever it is placed').waitFor();
      await until(page, () => hook(page, `link_on_screen(${JSON.stringify(first)}, 0)`), 'the character inside');
      await clean_in_both_themes(page, 'nested-inside');

      const length = (doc) => doc.characters.find((c) => c.id === first).track[0].length;
      const old = length(await document_of(page));
      await page.locator(`[data-character="${first}"] .clip`).first().click();
      await field(page, 'Length').fill(String(old - 0.5));
      await field(page, 'Length').press('Enter');
      await until(page, async () => Math.abs(length(await document_of(page)) - old + 0.5) < 1e-6, 'the shorter clip');

      await set_mode(page, 'Simulate');
      await blur(page);
      await page.keyboard.press('Space');
      await until(page, async () => (await hook(page, 'frame()'))?.time > 0.2, 'simulated frames');
      await page.keyboard.press('Space');
      assert.ok(await hook(page, `character(${JSON.stringify(first)})`), 'frames have the characters of the inside only');
      await set_mode(page, 'Edit');

      await blur(page);
      await page.keyboard.press('Escape'); // deselects
      await page.keyboard.press('Escape');
      await until(page, async () => (await hook(page, 'open()')).length === 0, 'the outermost scenario');
      assert.equal(await page.getByRole('navigation', { name: 'Open scenario' }).count(), 0);
      const doc = await document_of(page);
      assert.equal(doc.instances.length, 2);
      assert.ok(Math.abs(length(doc.scenarios[0]) - old + 0.5) < 1e-6, 'the edit is in the scenario');
      await undo_to(page, before);
    },
    skip,
  },
  {
    name: 'nested: a rule names a character of an instance, and acts on it',
    async run({ page }) {
      const before = await begin(page);
      const [first] = await nest_two(page);
      const [{ id: instance }] = await instances(page);
      const body = `${instance}/${first}`;
      await page.getByRole('tab', { name: 'Rules' }).click();
      await page.getByRole('button', { name: 'While a key is held, play…' }).click();
      const rule = await until(page, async () => (await document_of(page)).rules?.[0], 'the rule');
      assert.equal(rule.do.character.split('/')[0], instance, 'the rule acts on the selected instance');
      const who = page.locator('.rule').first().getByLabel('Character of the action', { exact: true });
      const offered = await who.locator('option').allTextContents();
      assert.equal(offered.filter((name) => name.startsWith('Duet 1 / ')).length, 2, `the characters of the instance: ${offered}`);
      await page.locator('.rule').first().getByRole('button', { name: /^Key / }).click();
      await page.keyboard.press('j');
      await until(page, async () => (await document_of(page)).rules[0].if[0].key === 'KeyJ', 'the key');
      if (rule.do.character !== body) {
        await who.selectOption(body);
        await until(page, async () => (await document_of(page)).rules[0].do.character === body, 'the other character');
      }
      await clean_in_both_themes(page, 'nested-rule');

      await set_mode(page, 'Simulate');
      await page.getByRole('button', { name: /^Play controls/ }).click({ timeout: 20000 });
      const active = (wanted) => until(page, async () => (await page.locator('.rule').first().getAttribute('data-active')) === wanted, `an active rule: ${wanted}`);
      await active('false');
      await page.keyboard.down('j');
      await active('true');
      await page.keyboard.up('j');
      await active('false');
      await page.keyboard.press('Escape');
      await set_mode(page, 'Edit');
      await undo_to(page, before);
    },
    skip,
  },
];
