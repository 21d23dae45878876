// Journey through gaits: a character walks without measured data, its gait is changed in the inspector, and a path is drawn over the floor.
import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { violations } from './accessibility.mjs';
import { camera_rests, steady, undo_to, until } from './browser.mjs';
import { mock } from './service.mjs';

const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const hook = (page, expression) => page.evaluate(`window.ugoki.${expression}`);
const document_of = (page) => hook(page, 'document()');
const human_of = (doc) => doc.characters.find((c) => c.id === 'human') ?? doc.characters[0];

export const gait_journeys = [
  {
    name: 'gait: a character walks without measured data, changes its speed, follows a drawn path, and all is undone',
    skip: mock && 'the mock service makes no gaits',
    async run({ page }) {
      await page.getByRole('radio', { name: 'Edit' }).click();
      await until(page, async () => (await hook(page, 'transport()')).mode === 'edit', 'Edit');
      const before = await document_of(page);
      const human = human_of(before);
      const count = human.track.length;
      const clip = async () => human_of(await document_of(page)).track.at(-1);
      const gait_becomes = (test, description) => until(page, async () => {
        const { gait } = (await clip()) ?? {};
        return gait && test(gait) && (await page.locator('.task').count()) === 0 && gait;
      }, description);

      await page.locator(`[data-character="${human.id}"] .track-name`).click();
      await page.getByRole('button', { name: 'Add gait', exact: true }).click();
      const first = await gait_becomes((g) => g.kind === 'walk' && g.speed > 0.8, 'the gait');
      assert.equal(human_of(await document_of(page)).track.length, count + 1);
      const fields = page.getByRole('region', { name: 'Gait' });
      await fields.getByRole('textbox', { name: 'Speed' }).fill('0.9');
      await page.keyboard.press('Enter');
      await gait_becomes((g) => g.speed === 0.9, 'the slower gait');
      await fields.getByRole('combobox', { name: 'Style' }).selectOption('proud');
      await gait_becomes((g) => g.style === 'proud', 'the style');

      // a path of two points, relative to the place where the clip starts
      await page.getByRole('button', { name: 'Fit', exact: true }).click();
      const { id } = await clip();
      const on_track = await steady(page, () => page.locator(`[data-clip="${id}"]`).boundingBox(), 'the clip in the timeline');
      const ruler = await page.locator('.ruler').boundingBox();
      await page.mouse.click(on_track.x + 2, ruler.y + ruler.height / 2);
      await until(page, async () => Math.abs((await hook(page, 'frame()')).time - (await clip()).start) < 0.5, 'the start of the clip');
      await page.locator(`[data-clip="${(await clip()).id}"]`).click({ position: { x: 30, y: 8 } });
      await fields.getByRole('button', { name: 'Draw path' }).click();
      await page.getByRole('toolbar', { name: 'Path' }).waitFor();
      await camera_rests(page);
      const box = await page.locator('.viewport > canvas').boundingBox();
      for (const [x, y] of [[0.45, 0.72], [0.6, 0.8]]) await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
      await page.getByText(/^2 points, /).waitFor();
      await page.screenshot({ path: `${pictures}gait-drawing.png` });
      await page.keyboard.press('Enter');
      const drawn = await gait_becomes((g) => g.path?.length === 2, 'the gait along the path');
      assert.ok(drawn.seconds !== first.seconds, 'the duration follows from the path');
      const handles = page.locator('.path-handle');
      await until(page, async () => (await handles.count()) === 3, 'the start and two handles');
      assert.deepEqual(await violations(page), []);
      await page.screenshot({ path: `${pictures}gait-path.png` });

      // a point is dragged
      await camera_rests(page);
      const handle = await steady(page, () => handles.nth(2).boundingBox(), 'the handle');
      await page.mouse.move(handle.x + handle.width / 2, handle.y + handle.height / 2);
      await page.mouse.down();
      await page.mouse.move(handle.x + 60, handle.y - 30, { steps: 5 });
      await page.mouse.up();
      await gait_becomes((g) => Math.hypot(g.path[1][0] - drawn.path[1][0], g.path[1][1] - drawn.path[1][1]) > 0.05, 'the moved point');

      await undo_to(page, JSON.stringify(before));
      await page.keyboard.press('Escape');
    },
  },
];
