// Journey for looks, lights, camera shots and the export of pictures.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { document_of, set_mode, undo_to, until } from './browser.mjs';
import { violations } from './accessibility.mjs';
import { mock } from './service.mjs';

const skip = mock && 'the mock service has no cameras';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const hook = (page, expression) => page.evaluate(`window.ugoki.${expression}`);
const tab = (page, name) => page.getByRole('tab', { name, exact: true }).click();
const look = (page) => page.getByRole('form', { name: 'Look' });
const inspector = (page) => page.getByRole('form', { name: 'Inspector' });
const through = (page) => page.getByLabel('Camera of the view');
/** Lets the view draw the last change at full resolution. */
const drawn = (page) => page.waitForTimeout(900);

/** Mean colour (0 ... 255) of a part of a PNG picture, given in fractions of its size. */
const mean_color = (page, png, [left, top, right, bottom]) =>
  page.evaluate(async ([data, l, t, r, b]) => {
    const bytes = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = canvas.getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const { data: p } = context.getImageData(l * bitmap.width, t * bitmap.height, Math.max(1, (r - l) * bitmap.width), Math.max(1, (b - t) * bitmap.height));
    const sum = [0, 0, 0];
    for (let i = 0; i < p.length; i += 4) for (let k = 0; k < 3; k++) sum[k] += p[i + k];
    return { color: sum.map((s) => (4 * s) / p.length), width: bitmap.width, height: bitmap.height };
  }, [png.toString('base64'), left, top, right, bottom]);

async function drag(page, from, to) {
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.mouse.move(to.x, to.y, { steps: 6 });
  await page.mouse.up();
}

/** Moves the playhead to a time, s. */
async function go_to(page, time) {
  await page.evaluate('document.activeElement?.blur?.()');
  await page.keyboard.press('Home');
  await page.waitForTimeout(200);
  const ruler = await page.locator('.ruler').boundingBox();
  const { duration } = await document_of(page);
  await page.mouse.click(ruler.x + 12 + (time * (ruler.width - 32)) / duration, ruler.y + ruler.height / 2);
  await until(page, async () => Math.abs((await hook(page, 'frame()')).time - time) < 0.15, `the frame at ${time} s`);
}

export const look_journeys = [
  {
    name: 'looks: materials, sky and ground, cameras with keys, shots, and an exported picture like that of the studio',
    skip,
    async run({ page, service }) {
      await set_mode(page, 'Edit');
      await page.keyboard.press('Escape');
      const before = JSON.stringify(await document_of(page));
      const human = (await document_of(page)).characters.find((c) => /human/i.test(c.name));

      // materials and clothes of a character
      await page.locator(`[data-character="${human.id}"] .track-name`).click();
      await tab(page, 'Look');
      await look(page).getByRole('button', { name: 'Skin' }).click();
      await until(page, async () => (await document_of(page)).characters.find((c) => c.id === human.id).roughness === 0.55, 'the material');
      for (const [part, color] of [['Shirt', '#c8553a'], ['Trousers', '#33405a'], ['Shoes', '#ece7dc']]) {
        await look(page).getByLabel(part, { exact: true }).fill(color);
        await until(page, async () => Object.values((await document_of(page)).characters.find((c) => c.id === human.id).link_colors ?? {}).includes(color), `the colour of the ${part}`);
      }
      assert.equal((await hook(page, 'undo()')).undo_label, 'Change material');
      const roughness = look(page).getByRole('slider', { name: 'Roughness' });
      await roughness.focus();
      await page.keyboard.press('ArrowRight');
      await until(page, async () => (await document_of(page)).characters.find((c) => c.id === human.id).roughness === 0.56, 'the keyed slider');

      // the simulated frames remain, because a look does not change the motion
      await set_mode(page, 'Simulate');
      await page.evaluate('document.activeElement?.blur?.()');
      await page.keyboard.press('Space');
      await until(page, async () => (await hook(page, 'transport()')).simulated > 0.4, 'simulated frames');
      await page.keyboard.press('Space');
      await until(page, async () => !(await hook(page, 'transport()')).playing, 'the pause');
      const { simulated } = await hook(page, 'transport()');
      await look(page).getByRole('button', { name: 'Night' }).click();
      await until(page, async () => (await document_of(page)).look.sky?.zenith === '#0a1020', 'the night');
      await drawn(page);
      assert.ok((await hook(page, 'transport()')).simulated >= simulated, 'the simulation continues');
      await page.screenshot({ path: `${pictures}looks-night.png` });
      await set_mode(page, 'Edit');

      // sky, sun, ground
      await look(page).getByRole('button', { name: 'Evening' }).click();
      await look(page).getByLabel('Pattern').selectOption('boards');
      await look(page).getByLabel('Colour', { exact: true }).last().fill('#8a6a4a');
      await until(page, async () => (await document_of(page)).look.floor === '#8a6a4a', 'the ground');
      await page.keyboard.press('Escape');
      await drawn(page);
      await page.screenshot({ path: `${pictures}looks-evening.png` });
      assert.deepEqual(await violations(page), []);

      // a camera from the view, with a shot of the whole scenario
      await page.locator('.viewport canvas').first().hover();
      await page.keyboard.press('3');
      await page.keyboard.press('f');
      await drawn(page);
      await through(page).selectOption('new');
      await until(page, async () => (await document_of(page)).cameras?.length === 1, 'the camera');
      await tab(page, 'Inspector');
      const [camera] = (await document_of(page)).cameras;
      const { duration } = await document_of(page);
      assert.deepEqual((await document_of(page)).shots.map(({ camera: c, start, length }) => [c, start, length]), [[camera.id, 0, duration]]);
      await page.locator('.film-frame').waitFor();
      await inspector(page).getByLabel('Name').fill('Wide');
      await page.keyboard.press('Enter');
      await until(page, async () => (await document_of(page)).cameras[0].name === 'Wide', 'the name');

      // a second camera that follows the human; the view stays when it begins to follow
      await through(page).selectOption('free');
      await page.evaluate('document.activeElement?.blur?.()');
      await page.keyboard.press('1');
      await page.keyboard.press('f');
      await drawn(page);
      await through(page).selectOption('new');
      await until(page, async () => (await document_of(page)).cameras?.length === 2, 'the second camera');
      await page.locator('.film-frame').waitFor();
      await drawn(page);
      const placed = await hook(page, 'camera()');
      await inspector(page).getByLabel('Follow').selectOption(human.id);
      await until(page, async () => (await document_of(page)).cameras[1].follow === human.id, 'the followed character');
      await drawn(page);
      const followed = await hook(page, 'camera()');
      assert.ok(Math.abs(followed.distance - placed.distance) < 1e-3 && Math.abs(followed.height - placed.height) < 2e-3, JSON.stringify([placed, followed]));

      // keys: an orbit and a dolly between two views
      await go_to(page, 0);
      await page.evaluate('document.activeElement?.blur?.()');
      await page.keyboard.press('k');
      await until(page, async () => (await document_of(page)).cameras[1].keys?.length === 1, 'the first key');
      await go_to(page, 3);
      await drawn(page);
      await page.keyboard.press('6');
      await page.keyboard.press('6');
      await page.keyboard.press('+');
      await until(page, async () => (await through(page).inputValue()) === 'free', 'the free view: the user has moved it');
      await drawn(page);
      await page.keyboard.press('k');
      await until(page, async () => (await document_of(page)).cameras[1].keys?.length === 2, 'the second key');
      const { keys } = (await document_of(page)).cameras[1];
      assert.ok(Math.abs(Math.abs(keys[1].azimuth - keys[0].azimuth) - Math.PI / 6) < 0.01, `30 degrees: ${keys.map((k) => k.azimuth)}`);
      assert.ok(keys[1].distance < keys[0].distance);
      await go_to(page, 1.5);
      await drawn(page);
      const middle = await hook(page, 'camera()');
      assert.ok(middle.distance < keys[0].distance && middle.distance > keys[1].distance, 'the camera moves between its keys');
      await page.screenshot({ path: `${pictures}looks-camera.png` });
      assert.deepEqual(await violations(page), []);

      // a cut, and a shot that is trimmed with the mouse
      await go_to(page, 2);
      await page.keyboard.press('x');
      await until(page, async () => (await document_of(page)).shots.length === 2, 'the cut');
      assert.deepEqual((await document_of(page)).shots.map((s) => s.camera), [camera.id, (await document_of(page)).cameras[1].id]);
      await page.keyboard.press('Escape');
      const box = await page.locator('[data-shot]').nth(1).boundingBox();
      const length = (await document_of(page)).shots[1].length;
      await drag(page, { x: box.x + box.width - 3, y: box.y + box.height / 2 }, { x: box.x + box.width - 63, y: box.y + box.height / 2 });
      await until(page, async () => (await document_of(page)).shots[1].length < length - 0.1, 'the trimmed shot');
      await page.screenshot({ path: `${pictures}looks-shots.png` });
      await through(page).selectOption('shots');
      for (const [time, name] of [[1, 'Wide'], [2.5, 'Camera 2']]) {
        await go_to(page, time);
        await until(page, async () => (await page.locator('.film-label').textContent()).startsWith(name), `the picture of ${name}`);
      }
      await drawn(page);
      await page.screenshot({ path: `${pictures}looks-through.png` });

      // the light theme
      await page.keyboard.press('Control+k');
      await page.getByRole('combobox', { name: 'Search commands' }).fill('light theme');
      await page.keyboard.press('Enter');
      await tab(page, 'Look');
      await drawn(page);
      await page.screenshot({ path: `${pictures}looks-light.png` });
      assert.deepEqual(await violations(page), []);
      await page.keyboard.press('Control+k');
      await page.getByRole('combobox', { name: 'Search commands' }).fill('light theme');
      await page.keyboard.press('Enter');
      await tab(page, 'Inspector');

      // the picture of the studio and the exported picture show the same
      const download = page.waitForEvent('download');
      await page.keyboard.press('F2');
      const saved = readFileSync(await (await download).path());
      const [path] = await hook(page, 'recent()');
      const file = join(service.folder, 'shot.png');
      const time = (await hook(page, 'frame()')).time;
      const exported = service.run(['export', path, '--png', file, '--from', String(time), '--size', '960x540']);
      assert.equal(exported.status, 0, exported.stderr + exported.stdout);
      for (const part of [[0, 0, 1, 0.2], [0.42, 0.35, 0.58, 0.6], [0, 0.85, 1, 1]]) {
        const a = await mean_color(page, saved, part);
        const b = await mean_color(page, readFileSync(file), part);
        assert.ok(Math.abs(a.width / a.height - 16 / 9) < 0.01, `the studio's picture has ${a.width} x ${a.height} px`);
        assert.ok(a.color.every((v, i) => Math.abs(v - b.color[i]) < 9), `${part}: ${a.color} and ${b.color}`);
      }

      // all is undone
      await through(page).selectOption('free');
      await page.evaluate('document.activeElement?.blur?.()');
      await undo_to(page, before);
      assert.equal(JSON.stringify(await document_of(page)), before);
    },
  },
];
