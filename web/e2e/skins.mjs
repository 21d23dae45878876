// A journey: a character file with a skin is dropped on the view, wears its skin, is shown in three ways, simulated, exported, and undone.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { blur, document_of, rested, set_mode, text_of, undo_to, until } from './browser.mjs';
import { mock } from './service.mjs';
import { skinned_person } from './skinned_file.mjs';

const skip = mock && 'the mock service imports no files';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const hook = (page, expression) => page.evaluate(`window.ugoki.${expression}`);
const card = (page, name) => page.locator('#library-list [role=option]', { has: page.locator('.entry-name', { hasText: name }) }).first();

/** Drops a file on the view. */
async function drop(page, name, bytes) {
  await page.evaluate(([file, data]) => {
    const element = document.querySelector('.viewport > canvas');
    const box = element.getBoundingClientRect();
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([Uint8Array.from(atob(data), (c) => c.charCodeAt(0))], file));
    const init = { bubbles: true, cancelable: true, dataTransfer, clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 };
    for (const type of ['dragenter', 'dragover', 'drop']) element.dispatchEvent(new DragEvent(type, init));
  }, [name, bytes.toString('base64')]);
}

export const skin_journeys = [
  {
    name: 'skins: a dropped character wears the skin of its file, also when it is simulated; skin, body or both are shown; all is undone',
    skip,
    async run({ page, service }) {
      await set_mode(page, 'Edit');
      await page.keyboard.press('Escape');
      const before = await text_of(page);
      const count = JSON.parse(before).characters.length;
      await drop(page, 'stripes.glb', skinned_person());
      const dialog = page.getByRole('dialog', { name: 'Import' });
      await dialog.waitFor();
      const [file] = await until(page, async () => ((await hook(page, 'imports()'))[0]?.status === 'ready' ? hook(page, 'imports()') : null), 'the file to be read', 120000);
      const report = Object.values(file.report).flat().join('\n');
      assert.equal(file.anatomy.plan, 'human', report);
      assert.match(report, /A skin of 504 vertices and 252 triangles, with 1 texture/, report);
      await until(page, () => page.evaluate(() => window.ugoki.import_view()?.pictures > 2), 'the preview');
      await page.waitForTimeout(600);
      await page.screenshot({ path: `${pictures}skin-import.png` });
      await page.getByRole('button', { name: 'Store in the library' }).click();
      await dialog.waitFor({ state: 'detached', timeout: 60000 });
      await page.getByRole('radio', { name: 'Motions' }).click();
      await page.getByRole('searchbox', { name: 'Search the library' }).fill('stripes');
      await card(page, 'sway').dblclick();
      const person = await until(page, async () => (await document_of(page)).characters[count], 'the character');
      await page.getByRole('searchbox', { name: 'Search the library' }).fill('');
      await page.getByRole('radio', { name: 'All' }).click();
      const own = async () => (await document_of(page)).characters.find((c) => c.id === person.id);

      // three ways to show it
      await page.getByRole('tab', { name: 'Look', exact: true }).click();
      const shown = page.getByRole('group', { name: 'Shown' });
      await blur(page);
      await page.keyboard.press('1'); // from the front: an arm may cover the chest in the view of the journey before
      await page.keyboard.press('f');
      await rested(page);
      const box = await page.locator('.viewport canvas').first().boundingBox();
      const shot = async (name) => {
        await page.waitForTimeout(900);
        return page.screenshot({ path: `${pictures}${name}.png`, clip: box });
      };
      const skin = await shot('skin');
      for (const [name, value] of [['Body', 'body'], ['Both', 'both']]) {
        await shown.getByRole('button', { name }).click();
        await until(page, async () => (await own()).shown === value, name);
        assert.notEqual(Buffer.compare(await shot(`skin-${value}`), skin), 0, `${name} gives the same picture as the skin`);
      }
      await shown.getByRole('button', { name: 'Skin' }).click();
      await until(page, async () => ((await own()).shown ?? 'skin') === 'skin', 'the skin');
      await page.getByRole('button', { name: 'Switch between dark and light theme' }).click();
      await shot('skin-light');
      await page.screenshot({ path: `${pictures}skin-look-light.png` });
      await page.getByRole('button', { name: 'Switch between dark and light theme' }).click();
      await page.screenshot({ path: `${pictures}skin-look.png` });

      // picked by the pointer although the body under the skin is not drawn
      const at = await page.evaluate(([id, i]) => window.ugoki.link_on_screen(id, i), [person.id, await page.evaluate((id) => window.ugoki.link_index(id, 'chest'), person.id)]);
      await page.mouse.move(at.x, at.y);
      await page.locator('.link-label').filter({ hasText: /chest/i }).waitFor({ state: 'visible' });

      // simulated
      await set_mode(page, 'Simulate');
      await blur(page);
      await page.keyboard.press('Control+Home');
      await page.keyboard.press('Space');
      await until(page, async () => (await hook(page, 'transport()')).simulated > 1, 'a second of simulation', 120000);
      await page.keyboard.press('Space');
      await shot('skin-simulated');
      await set_mode(page, 'Edit');

      // the executable data of the saved project contain it
      await page.keyboard.press('Control+s');
      const out = join(service.folder, 'skin.ugx');
      let baked;
      await until(page, () => {
        baked = service.run(['export', join(service.folder, 'sample.ugoki'), '--ugx', out]);
        return baked.status === 0 && readFileSync(out).includes('"positions": "');
      }, 'executable data with the skin').catch((error) => {
        throw new Error(`${error.message}: ${baked.stderr}${baked.stdout}`);
      });

      await undo_to(page, before);
    },
  },
];
