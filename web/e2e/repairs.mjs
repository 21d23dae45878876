// Journeys (end-to-end tests) for faults that users reported. Each journey failed before the repair of its fault.
import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { camera_rests, document_of, painted, ready, set_mode, steady, text_of, undo_while, until } from './browser.mjs';
import { mock } from './service.mjs';

const skip = mock && 'the mock service has no library and no simulation';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));

const undo_to = async (page, wanted) => {
  await page.locator('.scenario').click({ position: { x: 400, y: 6 } });
  await undo_while(page, async () => (await text_of(page)) !== JSON.stringify(wanted));
};

export const repair_journeys = [
  {
    name: 'repair: a file dropped on viewport, timeline, inspector or top bar opens the import',
    async run({ page }) {
      for (const place of ['.viewport > canvas', '.tracks', '.inspector', '.topbar', '.library']) {
        const accepted = await page.evaluate((selector) => {
          const element = document.querySelector(selector);
          const box = element.getBoundingClientRect();
          const dataTransfer = new DataTransfer();
          dataTransfer.items.add(new File(['HIERARCHY\nROOT Hips\n{\n'], 'broken.bvh'));
          const init = { bubbles: true, cancelable: true, dataTransfer, clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 };
          element.dispatchEvent(new DragEvent('dragenter', init));
          const over = !element.dispatchEvent(new DragEvent('dragover', init));
          element.dispatchEvent(new DragEvent('drop', init));
          return over;
        }, place);
        assert.ok(accepted, `${place} takes the file`);
        const dialog = page.getByRole('dialog', { name: 'Import' });
        await dialog.waitFor({ timeout: 10000 }).catch(() => assert.fail(`nothing happened after a drop on ${place}`));
        await page.keyboard.press('Escape');
        await dialog.waitFor({ state: 'detached' });
      }
    },
  },
  {
    name: 'repair: new characters stand on the floor, and stay there with their first motion',
    async run({ page }) {
      const before = await document_of(page);
      const lowest = (id) => page.evaluate((c) => {
        let low = Infinity;
        for (let i = 0; ; i++) {
          const p = window.ugoki.link_position(c, i);
          if (!p) return low;
          low = Math.min(low, p[2]);
        }
      }, id);
      for (const name of ['Human', 'Ball', 'Dog']) {
        const count = (await document_of(page)).characters.length;
        await page.locator('#library-list [role=option]', { has: page.locator('.entry-name', { hasText: name }) }).first().dblclick();
        const id = await until(page, async () => (await document_of(page)).characters[count]?.id, `the new ${name}`);
        const low = await until(page, async () => Number.isFinite(await lowest(id)) && (await lowest(id)) > -5 && [await lowest(id)], `the character ${name}`);
        assert.ok(low[0] > 0 && low[0] < 0.2, `the lowest joint of ${name} is ${low[0].toFixed(3)} m above the floor`);
        if (name !== 'Human') continue;
        await page.screenshot({ path: `${pictures}on-the-floor.png` });
        await page.locator('#library-list [role=option]', { has: page.locator('.entry-name', { hasText: 'Stand at ease' }) }).first().dragTo(page.locator(`[data-character="${id}"] .lane`), { targetPosition: { x: 4, y: 12 } });
        await until(page, async () => (await document_of(page)).characters[count].track.length === 1, 'its motion');
        await page.waitForTimeout(500);
        const standing = await lowest(id);
        assert.ok(standing > 0 && standing < 0.15, `with a motion its lowest joint is ${standing.toFixed(3)} m above the floor`);
      }
      await undo_to(page, before);
    },
  },
  {
    name: 'repair: three copies made in place can be simulated',
    async run({ page }) {
      const before = await document_of(page);
      await page.locator('.track-name').first().click();
      for (let i = 1; i <= 3; i++) {
        await page.keyboard.press('Control+d');
        await until(page, async () => (await document_of(page)).characters.length === before.characters.length + i, `copy ${i}`);
      }
      await set_mode(page, 'Simulate');
      await page.keyboard.press('Control+Home');
      await page.getByRole('button', { name: 'Play', exact: true }).click();
      await until(page, () => page.evaluate(() => window.ugoki.frame()?.simulate && window.ugoki.frame().time > 1), 'a second of simulation', 60000);
      await page.getByRole('button', { name: 'Pause' }).click();
      assert.equal(await page.locator('.banner').count(), 0);
      assert.deepEqual((await page.evaluate(() => window.ugoki.summary().characters)).filter((c) => c.fell), []);
      await set_mode(page, 'Edit');
      await undo_to(page, before);
    },
  },
  {
    name: 'repair: measures are kept from Simulate to Edit and back',
    async run({ page }) {
      await set_mode(page, 'Simulate');
      await page.getByRole('button', { name: 'Play', exact: true }).click();
      const measures = () => page.evaluate(() => window.ugoki.summary().characters.length);
      await until(page, () => page.evaluate(() => window.ugoki.summary().characters.length > 0 && window.ugoki.frame().time > 0.5), 'measures', 60000);
      await page.getByRole('button', { name: 'Pause' }).click();
      await set_mode(page, 'Edit');
      await page.waitForTimeout(600);
      await set_mode(page, 'Simulate');
      await page.waitForTimeout(600);
      assert.ok((await measures()) > 0, 'the measures of the recorded simulation are shown');
      await page.locator('.tab', { hasText: 'Naturalness' }).click();
      await page.locator('.nat-row .value').first().waitFor();
      await page.locator('.tab', { hasText: 'Scenario' }).click();
      await page.keyboard.press('Control+Home');
      await set_mode(page, 'Edit');
    },
  },
  {
    name: 'repair: a clip duplicated past the end makes the scenario longer and is visible',
    async run({ page }) {
      const before = await document_of(page);
      await page.locator('.clip').first().click();
      await page.keyboard.press('Control+d');
      const after = await until(page, async () => {
        const doc = await document_of(page);
        return doc.characters[0].track.length === before.characters[0].track.length + 1 && doc;
      }, 'the copy');
      const copy = after.characters[0].track.at(-1);
      assert.ok(after.duration >= copy.start + copy.length - 1e-6, `the scenario of ${after.duration} s contains the copy up to ${copy.start + copy.length} s`);
      await painted(page);
      const box = await page.locator(`[data-clip="${copy.id}"]`).boundingBox();
      const lane = await page.locator('.lane').first().boundingBox();
      assert.ok(box.x >= lane.x && box.x + box.width <= lane.x + lane.width + 1, 'the copy is inside the timeline');
      await page.screenshot({ path: `${pictures}longer.png` });
      await page.keyboard.press('Control+z');
      await until(page, async () => (await document_of(page)).duration === before.duration, 'one undo step');
    },
  },
  {
    name: 'repair: an overlap of two clips is their cross-fade, which a handle changes',
    async run({ page }) {
      const before = await document_of(page);
      const first = before.characters[0].track[0];
      const track = async () => (await document_of(page)).characters[0].track;
      await page.locator('.clip').first().click();
      await page.keyboard.press('Control+d');
      const copy = (await until(page, async () => (await track()).length === 2 && (await track()), 'the copy'))[1];
      await page.waitForTimeout(400);
      const box = await page.locator(`[data-clip="${copy.id}"]`).boundingBox();
      const scale = box.width / copy.length;
      await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
      await page.mouse.down();
      await page.mouse.move(box.x + box.width / 2 - 3 * scale, box.y + box.height / 2, { steps: 8 });
      await page.mouse.up();
      const moved = await until(page, async () => (await track())[1].start < copy.start - 1 && (await track())[1], 'the overlap');
      const overlap = first.start + first.length - moved.start;
      assert.ok(Math.abs(moved.blend - overlap) < 1e-5, `cross-fade ${moved.blend} s, overlap ${overlap} s`);
      const shown = (await page.locator('svg.blend').first().boundingBox()).width / scale;
      assert.ok(Math.abs(shown - overlap) < 0.1, `the shown cross-fade has ${shown} s`);
      await page.screenshot({ path: `${pictures}overlap.png` });
      const handle = await page.locator(`[data-clip="${copy.id}"] .fade-handle`).boundingBox();
      await page.mouse.move(handle.x + 4, handle.y + 4);
      await page.mouse.down();
      await page.mouse.move(handle.x + 4 - scale, handle.y + 4, { steps: 6 });
      await page.mouse.up();
      const shorter = await until(page, async () => (await track())[1].blend < overlap - 0.5 && (await track())[1].blend, 'the shorter cross-fade');
      assert.ok(Math.abs(shorter - (overlap - 1)) < 0.3, `${shorter} s`);
      await undo_to(page, before);
    },
  },
  {
    name: 'repair: a number out of range reports what was set',
    async run({ page }) {
      const before = await document_of(page);
      await page.locator('.clip').first().click();
      const field = page.locator('.inspector').getByRole('textbox', { name: 'Speed' });
      await field.fill('9');
      await field.press('Enter');
      await page.locator('.toast', { hasText: 'Speed: 9 × is out of range. The value is now 2 ×, the largest possible.' }).waitFor({ timeout: 5000 });
      const toast = await page.locator('.toast').first().boundingBox();
      const timeline = await page.locator('.scenario').boundingBox();
      assert.ok(toast.y + toast.height <= timeline.y, 'the message does not cover the timeline');
      await undo_to(page, before);
    },
  },
  {
    name: 'repair: the pill of an event is as long as the event',
    async run({ page }) {
      const before = await document_of(page);
      await page.locator('.track-name').first().click();
      await page.keyboard.press('Shift+P');
      const push = await until(page, async () => (await document_of(page)).events.find((e) => !before.events.some((b) => b.id === e.id)), 'the push');
      const field = page.locator('.inspector').getByRole('textbox', { name: 'Duration' });
      await field.fill('3');
      await field.press('Enter');
      await until(page, async () => (await document_of(page)).events.find((e) => e.id === push.id).duration === 3, 'three seconds');
      await painted(page);
      const pill = await page.locator('.pill.push').first().boundingBox();
      const clip = await page.locator('.clip').first().boundingBox();
      const scale = clip.width / before.characters[0].track[0].length;
      assert.ok(Math.abs(pill.width - 3 * scale) < 2, `${pill.width} px for 3 s at ${scale.toFixed(1)} px per s`);
      await undo_to(page, before);
    },
  },
  {
    name: 'repair: the camera stays above the floor, and keys turn, move and zoom it',
    async run({ page }) {
      const canvas = await page.locator('.viewport > canvas').boundingBox();
      const floor = () => page.evaluate(() => window.ugoki.camera());
      await page.mouse.move(canvas.x + 30, canvas.y + canvas.height - 40);
      await page.mouse.down();
      await page.mouse.move(canvas.x + 30, canvas.y + 20, { steps: 10 });
      await page.mouse.up();
      await camera_rests(page);
      assert.ok((await floor()).height > 0, `the camera is ${(await floor()).height} m above the floor`);
      await page.keyboard.press('7');
      await camera_rests(page);
      const before = await steady(page, floor, 'the view from above');
      for (let i = 0; i < 4; i++) await page.keyboard.press('Control+ArrowDown');
      for (let i = 0; i < 4; i++) await page.keyboard.press('Control+ArrowLeft');
      await page.keyboard.press('+');
      await camera_rests(page);
      const after = await steady(page, floor, 'the nearer view');
      assert.ok(after.distance < before.distance * 0.95 && after.azimuth !== before.azimuth);
      await page.keyboard.press('a');
      await page.keyboard.press('1');
    },
  },
  {
    name: 'repair: after a restart of the studio the page resumes, and with another key asks for the new address',
    async run({ page, service, seen }) {
      const quiet = seen.errors.length; // failed connections are logged as errors by the browser
      await page.locator('.clip').first().click();
      await page.keyboard.press('Control+d');
      const changed = await until(page, async () => {
        const doc = await document_of(page);
        return doc.characters[0].track.length > 1 && doc;
      }, 'an unsaved edit');
      await service.restart(false, 1500);
      await until(page, () => page.evaluate(() => window.ugoki.connected), 'the page to resume', 60000);
      assert.equal(JSON.stringify((await document_of(page)).characters), JSON.stringify(changed.characters));
      const address = await service.restart(true, 1500);
      const field = page.getByRole('textbox', { name: 'Address that ugoki studio printed last' });
      await field.waitFor({ timeout: 60000 });
      await page.screenshot({ path: `${pictures}refused.png` });
      await field.fill('http://127.0.0.1/#code=wrong');
      await page.getByRole('button', { name: 'Connect' }).click();
      await page.locator('.banner', { hasText: 'does not accept this address' }).waitFor();
      await field.fill(address);
      await page.getByRole('button', { name: 'Connect' }).click();
      await until(page, () => page.evaluate(() => window.ugoki.connected), 'the page to be connected', 30000);
      service.address = address;
      await ready(page);
      assert.equal(JSON.stringify((await document_of(page)).characters), JSON.stringify(changed.characters));
      seen.errors.length = quiet;
      await page.locator('.scenario').click({ position: { x: 400, y: 6 } });
      await page.locator('[data-clip]').nth(1).click();
      await page.keyboard.press('Delete');
      await until(page, async () => (await document_of(page)).characters[0].track.length === 1, 'the copy to be removed');
    },
  },
].map((journey) => ({ ...journey, skip }));
