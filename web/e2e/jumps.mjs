// A journey of an animator: a jump is posed by hand, keyed, and its physics are corrected.
import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { blur, camera_rests, document_of, painted, rested, steady, toggle_theme, text_of, undo_to, until } from './browser.mjs';
import { mock } from './service.mjs';

const skip = mock && 'the mock service has no library';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const hook = (page, expression) => page.evaluate(`window.ugoki.${expression}`);
const card = (page, name) => page.locator('#library-list [role=option]', { has: page.locator('.entry-name', { hasText: name }) }).first();

export const jump_journeys = [
  {
    name: 'jump: a jump is posed and keyed on a standing human, and its physics are corrected',
    async run({ page }) {
      const before = await text_of(page);
      const count = JSON.parse(before).characters.length;
      await card(page, 'Human').dblclick();
      const { id } = await until(page, async () => (await document_of(page)).characters[count], 'a human');
      await card(page, 'Stand at ease').dragTo(page.locator(`[data-character="${id}"] .lane`), { targetPosition: { x: 4, y: 12 } });
      const clip_now = async () => (await document_of(page)).characters[count].track[0];
      const clip = await until(page, clip_now, 'its standing');
      await page.locator(`[data-character="${id}"] .track-name`).click();
      await blur(page);
      const go_to = async (frame) => {
        await page.keyboard.press('Shift+ArrowLeft');
        await until(page, async () => (await hook(page, 'transport()')).time < 1e-6, 'the start');
        for (let i = 0; i < frame; i++) await page.keyboard.press('ArrowRight');
        await until(page, async () => Math.abs((await hook(page, 'frame()')).time - frame / 60) < 1e-3, `frame ${frame}`);
        await until(page, async () => (await hook(page, 'posing()'))?.ready && !(await hook(page, 'posing()')).pending, 'the pose');
        await page.waitForTimeout(150);
      };
      await page.keyboard.press('e');
      await page.keyboard.press('g'); // drags move the whole body
      await page.keyboard.press('1');
      await page.keyboard.press('f');
      await camera_rests(page);
      const keys = async () => ((await clip_now()).layers ?? []).flatMap((l) => l.joints.flatMap((j) => j.keys.map((k) => ({ ...k, part: j.part }))));
      const times = async () => new Set((await keys()).map((k) => k.time.toFixed(2)));
      for (const [i, frame] of [30, 48, 60, 75, 90].entries()) {
        await go_to(frame);
        await page.keyboard.press('Shift+S');
        await until(page, async () => (await times()).size === i + 1, `keys at frame ${frame}`);
      }
      const pelvis = page.locator('.pose-handles button').first();
      const drag_pelvis = async (dy) => {
        const box = await steady(page, () => pelvis.boundingBox(), 'the handle of the pelvis');
        const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
        const { revision } = await hook(page, 'undo()');
        await page.mouse.move(x, y);
        await page.mouse.down();
        await page.mouse.move(x, y + dy / 2, { steps: 4 });
        await page.mouse.move(x, y + dy, { steps: 4 });
        await page.waitForTimeout(250);
        await page.mouse.up();
        await until(page, async () => (await hook(page, 'undo()')).revision !== revision, 'the dragged pelvis');
      };
      await go_to(48); // the crouch: the feet are pinned
      await drag_pelvis(45);
      await page.screenshot({ path: `${pictures}jump-crouch.png` });
      await go_to(75); // the flight: nothing is pinned
      for (const side of ['left', 'right']) {
        const foot = await hook(page, `link_index(${JSON.stringify(id)}, 'foot ${side}')`);
        const at = await hook(page, `link_on_screen(${JSON.stringify(id)}, ${foot})`);
        await page.mouse.click(at.x, at.y);
        await until(page, async () => (await hook(page, 'selection()')).link === foot, `the ${side} foot`);
        await blur(page);
        await page.keyboard.press('p');
      }
      await drag_pelvis(-90);
      await rested(page);
      await page.screenshot({ path: `${pictures}jump-posed.png` });
      await page.keyboard.press('e');
      await page.keyboard.press('g');

      await page.locator(`[data-clip="${clip.id}"]`).click({ position: { x: 20, y: 8 } });
      const keyed = await text_of(page);
      await page.locator('.inspector').getByRole('button', { name: 'Correct the physics…' }).click();
      await page.getByRole('dialog', { name: 'Correct the physics' }).getByRole('button', { name: 'Apply' }).click();
      await until(page, async () => (await text_of(page)) !== keyed, 'the corrected motion', 120000);
      const corrected = await clip_now();

      // the ghost of the motion before, and how far it changed
      const compared = page.getByRole('group', { name: 'Physics correction' });
      await compared.waitFor();
      assert.match(await compared.textContent(), /Largest change\d+\.\d° · .* at \d\.\d\d s/);
      assert.ok((await compared.locator('tbody tr').count()) >= 3, 'measures before and after');
      await compared.getByRole('button', { name: /^Centre of mass/ }).click();
      await rested(page);
      const shown = await page.screenshot({ path: `${pictures}jump-ghost.png` });
      await page.keyboard.press('Shift+C');
      await until(page, async () => (await compared.getByRole('button', { name: 'Ghost of before' }).getAttribute('aria-pressed')) === 'false', 'the switch');
      await rested(page);
      assert.ok(!shown.equals(await page.screenshot({ path: `${pictures}jump-no-ghost.png` })), 'the ghost is drawn');
      await page.keyboard.press('Shift+C');
      await toggle_theme(page);
      await rested(page);
      await page.screenshot({ path: `${pictures}jump-ghost-light.png` });
      await toggle_theme(page);
      assert.ok(corrected.motion !== clip.motion && (corrected.layers ?? []).length === 0, 'the keys are part of the corrected motion');
      const lines = (await hook(page, 'log()')).filter((line) => /Correct the physics —/.test(line));
      const change = (what) => lines.map((line) => line.match(new RegExp(`${what}: (-?[0-9.]+) .+ before, (-?[0-9.]+) .+ after`))).find(Boolean)?.slice(1).map(Number);
      const flight = change('Error of gravity in flights');
      assert.ok(flight && flight[1] < 0.2 * flight[0], `the flight is a parabola: ${flight}`);
      const force = change('Force that the ground cannot supply');
      assert.ok(force[1] < force[0], `the ground can supply the force: ${force}`);
      await page.locator('.clip').first().click();
      await blur(page);
      await rested(page);
      await page.screenshot({ path: `${pictures}jump-corrected.png` });
      await undo_to(page, before);
    },
  },
].map((journey) => ({ ...journey, skip }));
