// Journeys for the look of bodies: the smooth surface, and the collision shapes.
import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { document_of, set_mode, until } from './browser.mjs';
import { mock } from './service.mjs';

const skip = mock && 'the mock service has no bodies';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));

export const body_journeys = [
  {
    name: 'bodies: characters have a smooth surface, and B shows their collision shapes',
    async run({ page }) {
      await set_mode(page, 'Edit');
      const human = (await document_of(page)).characters.find((c) => c.track.length > 0);
      const viewport = page.locator('.viewport canvas').first();
      const box = await viewport.boundingBox();
      const shot = async (name) => {
        const before = await page.evaluate(() => window.ugoki.pictures);
        await until(page, () => page.evaluate((n) => window.ugoki.pictures > n, before).then((done) => done || page.waitForTimeout(700).then(() => true)), 'a picture');
        // a still view is drawn finer after a moment, and the smooth surface is rough at first
        let picture = Buffer.alloc(0);
        for (let tries = 0, last = null; tries < 20 && !(last && picture.equals(last)); tries++) {
          last = picture;
          await page.waitForTimeout(1000);
          picture = await page.screenshot({ path: `${pictures}${name}.png`, clip: box });
        }
        return picture;
      };
      const shapes = page.getByRole('button', { name: 'Shapes', exact: true });
      assert.equal(await shapes.getAttribute('aria-pressed'), 'false');
      await page.mouse.move(box.x + 5, box.y + box.height - 5);
      const smooth = await shot('bodies-smooth');
      await page.locator('.ruler').focus();
      await page.keyboard.press('b');
      assert.equal(await shapes.getAttribute('aria-pressed'), 'true');
      const plain = await shot('bodies-shapes');
      assert.notEqual(Buffer.compare(smooth, plain), 0, 'the pictures are equal');
      await page.keyboard.press('b');
      assert.equal(await shapes.getAttribute('aria-pressed'), 'false');
      assert.equal(Buffer.compare(await shot('bodies-smooth'), smooth), 0, 'the surface is drawn again');
      // a link under the pointer is found and highlighted although its mesh is not drawn
      const link = await page.evaluate((id) => window.ugoki.link_index(id, 'chest'), human.id);
      const at = await page.evaluate(([id, i]) => window.ugoki.link_on_screen(id, i), [human.id, link]);
      await page.mouse.move(at.x, at.y);
      await page.locator('.link-label').filter({ hasText: /chest/i }).waitFor({ state: 'visible' });
      assert.notEqual(Buffer.compare(await shot('bodies-hover'), smooth), 0, 'the link is not highlighted');
      await page.mouse.move(box.x + 5, box.y + box.height - 5);
    },
  },
].map((journey) => ({ ...journey, skip }));
