// Journeys for posing, keys and curves.
import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { camera_rests, document_of, set_mode, steady, step_history, toggle_theme, undo_to, until } from './browser.mjs';
import { resize } from './windows.mjs';
import { mock } from './service.mjs';

const skip = mock && 'the mock service has no poses';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const hook = (page, expression) => page.evaluate(`window.ugoki.${expression}`);
const layers_of = async (page, character) => (await document_of(page)).characters.find((c) => c.id === character).track[0].layers ?? [];
const keys_of = (layers) => layers.flatMap((l) => l.joints.flatMap((j) => j.keys.map((k) => ({ layer: l.id, link: j.link, part: j.part ?? 'joint', ...k }))));

/** Drags with the mouse along points of the page. */
async function drag(page, from, ...to) {
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  for (const p of to) {
    await page.mouse.move(p.x, p.y, { steps: 6 });
    await page.waitForTimeout(120);
  }
  await page.mouse.up();
}

/** Waits until the pose of the playhead is known and no answer is pending. */
const pose_shown = (page) => until(page, async () => {
  const posing = await hook(page, 'posing()');
  return posing?.ready && !posing.pending;
}, 'the pose of the playhead');

export const posing_journeys = [
  {
    name: 'posing: a hand is dragged, joints are turned and keyed, keys are edited as curves, and all is undone and redone',
    async run({ page }) {
      await set_mode(page, 'Edit');
      await page.keyboard.press('Escape');
      const before = await document_of(page);
      const human = before.characters.find((c) => c.track.length > 0 && /human/i.test(c.name)) ?? before.characters.find((c) => c.track.length > 0);
      await page.locator(`[data-character="${human.id}"] .track-name`).click();
      await page.evaluate('document.activeElement?.blur?.()');
      await page.keyboard.press('Shift+ArrowLeft');
      for (let i = 0; i < 30; i++) await page.keyboard.press('ArrowRight');
      await page.keyboard.press('3');
      await page.keyboard.press('f');
      await camera_rests(page);

      // the tool, handles, limits
      await page.keyboard.press('e');
      const handle = (name) => page.locator('.pose-handles').getByRole('button', { name });
      await handle(/Right hand|hand right/i).waitFor();
      await page.locator('.pose-bar').getByRole('button', { name: 'Limb' }).click(); // another journey may have chosen the body
      await pose_shown(page);
      await page.screenshot({ path: `${pictures}pose-handles.png` });

      // a hand is dragged upwards: one undo step, the keys of the arm only
      const hand = await hook(page, `link_index(${JSON.stringify(human.id)}, 'hand right')`);
      const at = await hook(page, `link_position(${JSON.stringify(human.id)}, ${hand})`);
      const box = await steady(page, () => handle(/Right hand/i).boundingBox(), 'the handle of the hand');
      const center = { x: box.x + box.width / 2, y: box.y + box.height / 2 };
      await page.mouse.move(center.x, center.y);
      await page.mouse.down();
      await page.mouse.move(center.x + 40, center.y - 60, { steps: 5 });
      await page.mouse.move(center.x + 60, center.y - 120, { steps: 5 });
      await steady(page, () => handle(/Right hand/i).boundingBox(), 'the dragged hand');
      await page.screenshot({ path: `${pictures}pose-drag.png` });
      assert.equal(keys_of(await layers_of(page, human.id)).length, 0, 'nothing is keyed during the drag');
      await page.mouse.up();
      await until(page, async () => keys_of(await layers_of(page, human.id)).length >= 2, 'the keys of the arm');
      await until(page, async () => (await hook(page, `link_position(${JSON.stringify(human.id)}, ${hand})`))[2] > at[2] + 0.15, 'the hand is higher in the frames of the service');
      assert.match((await hook(page, 'undo()')).undo_label, /Move Right hand/i);
      const first = keys_of(await layers_of(page, human.id));
      assert.ok(first.every((k) => !/leg|thigh|foot|shank/i.test(k.link)), `only the arm: ${first.map((k) => k.link)}`);

      // a joint is turned by its arc; it stops at its limit
      const shank = await hook(page, `link_index(${JSON.stringify(human.id)}, 'shank right')`);
      await pose_shown(page);
      const knee = await hook(page, `link_on_screen(${JSON.stringify(human.id)}, ${shank})`);
      await page.mouse.click(knee.x, knee.y);
      await until(page, async () => (await hook(page, 'selection()')).link !== undefined, 'a selected link');
      await until(page, async () => (await hook(page, 'posing()')).arc.length > 0, 'the arc of the joint');
      const arc = await steady(page, async () => (await hook(page, 'posing()')).arc, 'the place of the arc');
      const start = arc.find((p) => p.handle) ?? arc[0];
      await page.mouse.move(start.x, start.y);
      await page.waitForTimeout(150);
      await page.screenshot({ path: `${pictures}pose-arc.png` });
      const far = arc[arc.length - 1];
      const count = keys_of(await layers_of(page, human.id)).length;
      await drag(page, start, { x: (start.x + far.x) / 2 + 4, y: (start.y + far.y) / 2 + 4 }, far);
      await until(page, async () => keys_of(await layers_of(page, human.id)).length > count, 'the keys of the turned joint');
      assert.match((await hook(page, 'undo()')).undo_label, /^Rotate /);
      await page.screenshot({ path: `${pictures}pose-turned.png` });

      // a number typed while a joint is turned sets its angle; Escape restores
      const revision = JSON.stringify(await document_of(page));
      await pose_shown(page);
      const now = (await steady(page, async () => (await hook(page, 'posing()')).arc, 'the place of the arc')).find((p) => p.handle);
      await page.mouse.move(now.x, now.y);
      await page.mouse.down();
      await page.mouse.move(now.x + 6, now.y + 6, { steps: 3 });
      await page.keyboard.press('Escape');
      await page.mouse.up();
      await page.waitForTimeout(300);
      assert.equal(JSON.stringify(await document_of(page)), revision, 'Escape restores the pose');

      // a second pose, later: the angle in the inspector
      for (let i = 0; i < 24; i++) await page.keyboard.press('ArrowRight');
      await pose_shown(page);
      const angle = page.locator('.inspector').getByRole('textbox', { name: /^(Angle|Rotation X)/ }).first();
      await angle.fill('25');
      await angle.press('Enter');
      await until(page, async () => new Set(keys_of(await layers_of(page, human.id)).map((k) => k.time.toFixed(3))).size >= 2, 'keys at two times');

      // onion skin, body mode with pinned feet, mirror
      await page.evaluate('document.activeElement?.blur?.()');
      await page.keyboard.press('o');
      await page.keyboard.press('g');
      await until(page, async () => (await hook(page, 'posing()')).ghosts === 2, 'two ghosts');
      const pelvis = page.locator('.pose-handles button').first();
      const p = await steady(page, () => pelvis.boundingBox(), 'the handle of the pelvis');
      await drag(page, { x: p.x + p.width / 2, y: p.y + p.height / 2 }, { x: p.x + p.width / 2 - 6, y: p.y + p.height / 2 + 22 });
      await until(page, async () => keys_of(await layers_of(page, human.id)).some((k) => k.part === 'position'), 'the keys of the pelvis');
      await page.screenshot({ path: `${pictures}pose-onion.png` });
      await page.keyboard.press('Shift+M');
      await until(page, async () => (await hook(page, 'undo()')).undo_label === 'Mirror pose', 'the mirrored pose');
      await page.screenshot({ path: `${pictures}pose-mirror.png` });
      await page.keyboard.press('Control+z');
      await until(page, async () => (await hook(page, 'undo()')).undo_label !== 'Mirror pose', 'the mirror is undone');
      await page.keyboard.press('o');

      // a drag with dynamics: the trunk follows the hand, the planted foot stays; one undo step
      await page.keyboard.press('g');
      await page.getByRole('button', { name: 'Physics', pressed: true }).waitFor();
      const by_hand = JSON.stringify(await document_of(page));
      await pose_shown(page);
      const from = await steady(page, () => hook(page, `link_on_screen(${JSON.stringify(human.id)}, ${hand})`), 'the hand before the drag');
      const links = new Set(keys_of(await layers_of(page, human.id)).map((k) => k.link));
      await page.mouse.move(from.x, from.y);
      await page.mouse.down();
      await page.mouse.move(from.x + 70, from.y + 20, { steps: 6 });
      await page.waitForTimeout(1200);
      await page.screenshot({ path: `${pictures}pose-physics.png` });
      await page.mouse.up();
      await until(page, async () => JSON.stringify(await document_of(page)) !== by_hand, 'the keys of the drag with dynamics');
      assert.ok(keys_of(await layers_of(page, human.id)).filter((k) => !links.has(k.link)).length >= 3, 'the trunk is keyed too');
      await page.keyboard.press('Control+z');
      await until(page, async () => JSON.stringify(await document_of(page)) === by_hand, 'one undo step');

      // the curves: a key is dragged, tangents, keys are removed
      await page.getByRole('tab', { name: 'Curves' }).click();
      const plot = page.locator('.curve-plot canvas');
      await plot.waitFor();
      await page.locator('.curve-row').first().waitFor();
      const area = await steady(page, () => plot.boundingBox(), 'the size of the drawing');
      const keys = await steady(page, async () => (await hook(page, 'posing()')).drawn_keys, 'the drawn keys');
      await page.screenshot({ path: `${pictures}pose-curves.png` });
      assert.ok(keys.length >= 2, 'drawn keys');
      // a key of a hinge or a rotation that is inside of the drawing
      const key = keys.find((k) => k.x > 20 && k.x < area.width - 60 && k.y > 70 && k.y < area.height - 10);
      assert.ok(key, 'a key inside of the drawing');
      const value = JSON.stringify(await layers_of(page, human.id));
      await drag(page, { x: area.x + key.x, y: area.y + key.y }, { x: area.x + key.x, y: area.y + key.y - 24 });
      await until(page, async () => JSON.stringify(await layers_of(page, human.id)) !== value, 'the dragged key');
      assert.equal((await hook(page, 'undo()')).undo_label, 'Change keys');
      await page.getByRole('button', { name: 'Flat tangents' }).click();
      await until(page, async () => keys_of(await layers_of(page, human.id)).some((k) => k.tangent === 'free'), 'a flat tangent');
      await page.waitForTimeout(400);
      await page.screenshot({ path: `${pictures}pose-tangent.png` });
      await plot.focus();
      const all = keys_of(await layers_of(page, human.id)).length;
      await page.keyboard.press('Delete');
      await until(page, async () => keys_of(await layers_of(page, human.id)).length === all - 1, 'a removed key');

      // sizes and the light theme
      for (const [width, height] of [[1280, 720], [1024, 640]]) {
        await resize(page, [width, height]);
        await page.screenshot({ path: `${pictures}pose-${width}.png` });
      }
      await resize(page, [1440, 900]);
      await toggle_theme(page);
      await page.screenshot({ path: `${pictures}pose-light.png` });
      await toggle_theme(page);

      // undo to the start, redo to the end: equal each time
      const after = JSON.stringify(await document_of(page));
      const steps = await undo_to(page, JSON.stringify(before));
      for (let i = 0; i < steps; i++) await step_history(page, 'Control+Shift+z');
      assert.equal(JSON.stringify(await document_of(page)), after, 'redone to the end');
      assert.equal(await undo_to(page, JSON.stringify(before)), steps);
      await page.keyboard.press('e');
      await page.keyboard.press('g');
      await page.getByRole('tab', { name: 'Scenario' }).click();
    },
  },
].map((journey) => ({ ...journey, skip }));
