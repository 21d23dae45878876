// A journey: a pull in the simulation becomes an event of the scenario.
import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { blur, document_of, painted, set_mode, text_of, until } from './browser.mjs';
import { mock } from './service.mjs';

const skip = mock && 'the mock service has no simulation';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const hook = (page, expression) => page.evaluate(`window.ugoki.${expression}`);

export const pull_journeys = [
  {
    name: 'pull: a pull in the simulation is kept as an event with the same motion, and undone',
    async run({ page }) {
      await set_mode(page, 'Edit');
      const before = await text_of(page);
      const human = JSON.parse(before).characters.find((c) => c.track.length > 0 && c.control.mode === 'track');
      await set_mode(page, 'Simulate');
      await blur(page);
      await page.keyboard.press('Shift+R'); // the simulation of the journey before may contain pulls
      await page.getByRole('combobox', { name: 'Playback speed' }).selectOption('0.1');
      await page.keyboard.press('Control+Home');
      await until(page, async () => (await hook(page, 'frame()')).time < 0.05, 'the start');
      await page.locator('.transport').getByRole('button', { name: 'Play' }).click();
      await until(page, async () => (await hook(page, 'frame()')).simulate && (await hook(page, 'frame()')).time > 0.2, 'the simulation to run');
      await page.locator('.viewport > canvas').hover();
      const hand = await hook(page, `link_index(${JSON.stringify(human.id)}, 'hand right')`);
      const label = page.locator('.link-label').filter({ hasText: /^right hand$/i });
      // a view in which nothing covers the hand
      const views = ['a', '0', '1', '9', '3', '9'];
      let point;
      for (let attempt = 0; ; attempt++) {
        assert.ok(attempt < 24, 'a press grabs the hand');
        await page.keyboard.press(views[attempt % views.length]);
        await page.waitForTimeout(900); // the camera never rests while it follows the character
        point = await hook(page, `link_on_screen(${JSON.stringify(human.id)}, ${hand})`);
        if (!point) continue;
        await page.mouse.move(point.x, point.y);
        await painted(page);
        if (!(await label.isVisible())) continue;
        await page.mouse.down();
        let grabbed = false;
        for (let tries = 0; tries < 40 && !grabbed; tries++) {
          await page.waitForTimeout(50);
          grabbed = (await hook(page, 'frame()')).grabbing;
        }
        if (grabbed) break;
        await page.mouse.up();
      }
      for (let i = 1; i <= 8; i++) {
        await page.mouse.move(point.x + 14 * i, point.y - 18 * i);
        await page.waitForTimeout(120);
      }
      await page.mouse.up();
      const bar = page.locator('.pull-bar');
      await bar.waitFor();
      assert.match(await bar.textContent(), new RegExp(`Pulled ${human.name}, .* for \\d\\.\\d\\d s`));
      await page.screenshot({ path: `${pictures}pull-offer.png` });
      await page.waitForTimeout(600);
      await page.getByRole('button', { name: 'Pause' }).click();
      await until(page, async () => !(await hook(page, 'transport()')).playing, 'the pause');
      await page.waitForTimeout(300);
      const place = async () => (await hook(page, `character(${JSON.stringify(human.id)})`)).com;
      const time = (await hook(page, 'frame()')).time;
      const pulled = await place();

      // Enter keeps it: the event gives the same motion
      await page.evaluate('document.activeElement?.blur?.()');
      await page.keyboard.press('Enter');
      const event = await until(page, async () => (await document_of(page)).events.find((e) => e.type === 'pull'), 'the event');
      assert.ok(event.path.length > 3 && event.duration > 0.03 && event.path[0][0] === 0, JSON.stringify(event));
      await bar.waitFor({ state: 'detached' });
      await page.locator(`.pill.pull[data-event="${event.id}"]`).waitFor();
      await page.getByRole('form', { name: 'Inspector' }).getByText('The target moves').waitFor();
      const settled = async () => {
        await until(page, async () => {
          if (Math.abs((await hook(page, 'transport()')).time - time) > 1e-6) return false;
          const a = await place();
          await page.waitForTimeout(500);
          return JSON.stringify(a) === JSON.stringify(await place());
        }, 'the simulation up to the same time');
        return place();
      };
      await page.waitForTimeout(500);
      assert.deepEqual(await settled(), pulled, 'the event repeats the pull with the same bits');
      await page.screenshot({ path: `${pictures}pull-event.png` });

      // one undo removes it
      await page.keyboard.press('Control+z');
      await until(page, async () => (await text_of(page)) === before, 'the document before');
      await page.waitForTimeout(500);
      assert.notDeepEqual(await settled(), pulled, 'without the event nothing pulls');
      await page.getByRole('combobox', { name: 'Playback speed' }).selectOption('1');
      await set_mode(page, 'Edit');
    },
  },
].map((journey) => ({ ...journey, skip }));
