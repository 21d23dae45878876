// Journeys with events of the timeline: the arrow of a push in the viewport, and events at the same time.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { blur, document_of, painted, rested, set_mode, text_of, undo_to, until } from './browser.mjs';
import { mock } from './service.mjs';

const skip = mock && 'the mock service has no history';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const middle = async (locator) => {
  const box = await locator.boundingBox();
  return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
};

export const push_journeys = [
  {
    name: 'push: the arrow of a push is dragged in the viewport as one undo step; Escape restores it; body axes turn it with the link',
    async run({ page, service }) {
      await set_mode(page, 'Edit');
      const before = await text_of(page);
      const count = JSON.parse(before).events.length;
      const transport = () => page.evaluate(() => window.ugoki.transport());
      const to_start = async () => {
        await blur(page);
        await page.keyboard.press('Control+Home');
        await until(page, async () => (await transport()).time === 0, 'the playhead at the start');
      };
      await page.locator('.track-name').first().click();
      await to_start();
      await page.keyboard.press('0'); // not flat: a flat view drags in another plane
      await page.keyboard.press('f');
      await page.keyboard.press('Shift+P');
      const push = await until(page, async () => (await document_of(page)).events.length > count && (await document_of(page)).events.find((e) => e.type === 'push'), 'the push');
      const added = await text_of(page);
      await rested(page);
      const tip = page.locator('.arrow-tip');
      const drag = async (dx, dy) => {
        const from = await middle(tip);
        await page.mouse.move(from.x, from.y);
        await page.mouse.down();
        await page.mouse.move(from.x + dx, from.y + dy, { steps: 4 });
        await painted(page);
        const shown = await middle(tip);
        assert.ok(Math.hypot(shown.x - from.x - dx, shown.y - from.y - dy) < 4, `the tip is under the pointer: ${JSON.stringify([from, shown])}`);
      };
      await page.screenshot({ path: `${pictures}push-arrow.png` });
      await drag(60, 20);
      assert.equal(await text_of(page), added, 'nothing is sent during the drag');
      await page.keyboard.press('Escape');
      await page.mouse.up();
      await painted(page);
      assert.equal(await text_of(page), added, 'Escape restores the force');
      const value = page.locator('.arrow-value');
      const view = await page.locator('.viewport').boundingBox();
      const from = await middle(tip);
      await page.mouse.move(from.x, from.y);
      await page.mouse.down();
      for (const x of [view.x + 6, view.x + view.width - 6]) {
        await page.mouse.move(x, from.y + 12, { steps: 4 });
        await painted(page);
        const label = await value.boundingBox();
        assert.ok(label.x >= view.x && label.x + label.width <= view.x + view.width, `the label is inside the viewport: ${JSON.stringify([label, view])}`);
      }
      await page.keyboard.press('Escape');
      await page.mouse.up();
      await painted(page);
      await drag(70, 24);
      await page.mouse.up();
      const changed = await until(page, async () => (await text_of(page)) !== added && (await document_of(page)).events.find((e) => e.id === push.id), 'the changed push');
      assert.ok(Math.hypot(...changed.force.map((f, i) => f - push.force[i])) > 20 && Math.abs(changed.force[2] - push.force[2]) < 1e-9, `the force changed over the floor: ${push.force} to ${changed.force}`);
      await page.keyboard.press('Control+z');
      await until(page, async () => (await text_of(page)) === added, 'one undo step');

      // body axes: the arrow stays when the axes change, and then turns with the link
      const now = async () => (await document_of(page)).events.find((e) => e.id === push.id);
      const axes = page.getByRole('group', { name: 'Axes' });
      const direction = async () => {
        await rested(page);
        const [a, b] = await page.locator('.event-arrow path').evaluate((path) => path.getAttribute('d').match(/^M([\d.-]+) ([\d.-]+)L([\d.-]+) ([\d.-]+)/).slice(1).map(Number)).then(([x, y, u, v]) => [[x, y], [u, v]]);
        return [b[0] - a[0], b[1] - a[1]];
      };
      const world = await direction();
      await axes.getByRole('button', { name: 'Body' }).click();
      const body = await until(page, async () => { const e = await now(); return e.axes === 'body' && e; }, 'body axes');
      assert.ok(Math.abs(Math.hypot(...body.force) - Math.hypot(...push.force)) < 0.3, `the force has the same size: ${body.force}`);
      const kept = await direction();
      assert.ok(Math.hypot(kept[0] - world[0], kept[1] - world[1]) < 3, `the arrow stays: ${world} and ${kept}`);
      assert.match(await page.locator('.arrow-value').innerText(), /150 N, body axes/);
      await page.screenshot({ path: `${pictures}push-body.png` });
      // what is simulated in the studio is what `ugoki run` computes, and differs from a push in world axes
      const project = join(service.folder, 'sample.ugoki');
      const hash = async (steps) => {
        await page.keyboard.press('Control+s');
        await page.waitForTimeout(500);
        return JSON.parse(service.run(['run', project, '--steps', String(steps), '--json']).stdout).state_hash;
      };
      await set_mode(page, 'Simulate');
      await blur(page);
      await page.keyboard.press('Shift+R'); // the simulation of the journey before may contain pulls
      await to_start();
      await page.keyboard.press('Space');
      await until(page, async () => (await transport()).simulated > push.time + 0.5, 'the push', 120000);
      await page.keyboard.press('Space');
      const simulated = await until(page, async () => { const t = await transport(); return !t.playing && t; }, 'the end of playing');
      const of_body = simulated.state_hash;
      assert.equal(await hash(simulated.steps), of_body, 'the studio and `ugoki run` reach the same state');
      await set_mode(page, 'Edit');
      await page.locator('.pill.push').first().click();
      await axes.getByRole('button', { name: 'World' }).click();
      await until(page, async () => (await now()).axes === undefined, 'world axes');
      assert.notEqual(await hash(simulated.steps), of_body, 'the axes change the motion');
      await page.keyboard.press('Control+z');
      await page.keyboard.press('Control+z');
      await until(page, async () => (await text_of(page)) === added, 'two undo steps');

      // pushes of two characters at the same time: below each other
      await page.locator('.track-name').nth(1).click();
      await to_start();
      await page.keyboard.press('Shift+P');
      await until(page, async () => (await document_of(page)).events.length === count + 2, 'the second push');
      await painted(page);
      const boxes = await page.locator('.pill.push .pill-text').evaluateAll((texts) => texts.map((t) => t.getBoundingClientRect()).map((b) => ({ left: b.left, right: b.right, top: b.top, bottom: b.bottom })));
      assert.ok(boxes.length >= 2, 'both texts are shown');
      for (const [i, a] of boxes.entries()) for (const b of boxes.slice(0, i)) assert.ok(a.right <= b.left || b.right <= a.left || a.bottom <= b.top + 1 || b.bottom <= a.top + 1, `the texts do not overlap: ${JSON.stringify([a, b])}`);
      await page.screenshot({ path: `${pictures}push-rows.png` });
      await undo_to(page, before);
    },
  },
].map((journey) => ({ ...journey, skip }));
