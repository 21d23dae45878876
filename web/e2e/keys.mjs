// Journeys for the editable key maps.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { until } from './browser.mjs';

const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const dialog = (page) => page.getByRole('dialog', { name: 'Change keys' });
const row = (page, id) => page.locator(`.key-editor-row[data-command="${id}"]`);
const keys_of = (page, id) => row(page, id).locator('kbd').allTextContents();
const selected_theme = (page) => page.evaluate('document.documentElement.dataset.theme');

async function open_editor(page) {
  await page.keyboard.press('Control+k');
  await page.keyboard.type('change keys');
  await page.keyboard.press('Enter');
  await dialog(page).waitFor();
}

export const key_journeys = [
  {
    name: 'keys: a key is recorded, a conflict is named and taken over, kept after a reload, exported, reset and imported',
    async run({ page, service }) {
      await open_editor(page);
      await dialog(page).getByLabel('Search commands').fill('theme');
      await row(page, 'page.theme').getByRole('button', { name: /^Add a key/ }).click();
      await page.keyboard.press('Control+Alt+T');
      await until(page, async () => (await keys_of(page, 'page.theme')).includes('Ctrl Alt T'), 'the recorded key');
      await page.screenshot({ path: `${pictures}keys-recorded.png` });

      // a modifier and keys of the browser are refused with a reason
      await row(page, 'page.theme').getByRole('button', { name: /^Add a key/ }).click();
      await page.keyboard.press('Control+t');
      await row(page, 'page.theme').getByText('The browser keeps Ctrl T for itself.').waitFor();

      // R adds a rule; another command takes it over
      await row(page, 'page.theme').getByRole('button', { name: /^Add a key/ }).click();
      await page.keyboard.press('r');
      await row(page, 'page.theme').getByText('Add a rule for the selected character').waitFor();
      await page.screenshot({ path: `${pictures}keys-conflict.png` });
      await page.getByRole('button', { name: 'Take it over' }).click();
      await dialog(page).getByLabel('Search commands').fill('add a rule');
      await until(page, async () => (await keys_of(page, 'rule.add')).length === 0, 'the rule has no key any more');
      await dialog(page).getByLabel('Search commands').fill('');
      await dialog(page).getByLabel('Changed only').check();
      assert.equal(await page.locator('.key-editor-row').count(), 2);
      await page.getByRole('button', { name: 'Close', exact: true }).click();
      for (const key of ['r', 'Control+Alt+t']) {
        const before = await selected_theme(page);
        await page.keyboard.press(key);
        await until(page, async () => (await selected_theme(page)) !== before, `${key} switches the theme`);
      }

      // the keys are kept by the studio
      await page.reload();
      await until(page, () => page.evaluate('Boolean(window.ugoki?.connected && window.ugoki.document())'), 'the page is back');
      await open_editor(page);
      await until(page, async () => (await keys_of(page, 'page.theme')).join() === 'Ctrl Alt T,R', 'the keys after a reload');
      for (const [width, height] of [[1440, 900], [1024, 640]]) {
        await page.setViewportSize({ width, height });
        await page.waitForTimeout(300);
        await page.screenshot({ path: `${pictures}keys-${width}.png` });
      }
      await page.setViewportSize({ width: 1440, height: 900 });
      const saved = Promise.all([page.waitForEvent('download'), dialog(page).getByRole('button', { name: 'Export', exact: true }).click()]);
      const text = readFileSync(await (await saved)[0].path(), 'utf8');
      assert.deepEqual(JSON.parse(text).industry, { 'page.theme': ['Ctrl+Alt+T', 'R'], 'rule.add': [] });
      await page.getByRole('button', { name: 'Reset all' }).click();
      await until(page, async () => (await keys_of(page, 'rule.add')).join() === 'R', 'the keys of the keymap');
      const file = join(service.folder, 'keys.json');
      writeFileSync(file, text.replace('"rule.add": []', '"rule.add": ["Q"], "no.such": ["A"]'));
      await page.getByLabel('File with keys').setInputFiles(file);
      await until(page, async () => (await keys_of(page, 'rule.add')).join() === 'Q', 'the keys of the file');
      await page.getByText('industry/no.such: there is no such command').waitFor();
      await row(page, 'rule.add').getByRole('button', { name: /^Reset/ }).click();
      await until(page, async () => (await keys_of(page, 'rule.add')).join() === 'R', 'the key of one command');
      await page.getByRole('button', { name: 'Reset all' }).click();
      await page.keyboard.press('Escape');
      await dialog(page).waitFor({ state: 'detached' });
      if ((await selected_theme(page)) === 'light') await page.getByRole('button', { name: 'Switch between dark and light theme' }).click();
    },
  },
];
