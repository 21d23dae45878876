// Journeys for the simulated curve, grips, and the tour.
import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { document_of, set_mode, until } from './browser.mjs';
import { mock } from './service.mjs';

const skip = mock && 'the mock service has no poses';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const hook = (page, expression) => page.evaluate(`window.ugoki.${expression}`);
const label_of = async (page) => (await hook(page, 'undo()')).undo_label;
const human_of = (doc) => doc.characters.find((c) => c.track.length > 0 && /human/i.test(c.name)) ?? doc.characters.find((c) => c.track.length > 0);
const blur = (page) => page.evaluate('document.activeElement?.blur?.()');
const select_link = async (page, character, name) => {
  const link = await hook(page, `link_index(${JSON.stringify(character)}, ${JSON.stringify(name)})`);
  assert.ok(link >= 0, `the link ${name}`);
  const at = await hook(page, `link_on_screen(${JSON.stringify(character)}, ${link})`);
  await page.mouse.click(at.x, at.y);
  await until(page, async () => (await hook(page, 'selection()')).link === link, `the selected link ${name}`);
  return link;
};

/** Undoes until the document equals `before`. */
async function undo_to(page, before) {
  await blur(page);
  for (let i = 0; i < 60 && JSON.stringify(await document_of(page)) !== JSON.stringify(before); i++) {
    assert.ok((await hook(page, 'undo()')).can_undo, 'undo to the start');
    await page.keyboard.press('Control+z');
    await page.waitForTimeout(200);
  }
  assert.equal(JSON.stringify(await document_of(page)), JSON.stringify(before), 'undone to the start');
}

async function both_themes(page, name) {
  await page.waitForTimeout(400);
  await page.screenshot({ path: `${pictures}${name}.png` });
  await page.getByRole('button', { name: 'Switch between dark and light theme' }).click();
  await page.waitForTimeout(400);
  await page.screenshot({ path: `${pictures}${name}-light.png` });
  await page.getByRole('button', { name: 'Switch between dark and light theme' }).click();
}

export const timeline_journeys = [
  {
    name: 'curves: the simulated curve of a joint is beside the keyed one',
    async run({ page }) {
      const before = await document_of(page);
      const human = human_of(before);
      await set_mode(page, 'Simulate');
      await page.keyboard.press('Shift+ArrowLeft');
      await page.keyboard.press('Space');
      await until(page, async () => (await hook(page, 'transport()')).simulated > 1.2, '1.2 s of simulation', 120000);
      await page.keyboard.press('Space');
      await set_mode(page, 'Edit');
      await page.keyboard.press('f');
      await page.waitForTimeout(700);
      await page.locator(`[data-character="${human.id}"] .track-name`).click();
      await page.keyboard.press('e');
      await until(page, async () => (await hook(page, 'posing()'))?.ready, 'the pose of the playhead');
      await select_link(page, human.id, 'shank right');
      await page.getByRole('tab', { name: 'Curves' }).click();
      await page.locator('.curves-legend').getByText('simulated', { exact: true }).waitFor();
      await page.locator('.curve-plot canvas').waitFor();
      const drawn = await page.waitForFunction(() => {
        const canvas = document.querySelector('.curve-plot canvas');
        const [r, g, b] = getComputedStyle(canvas).getPropertyValue('--simulated').match(/\w\w/g).map((x) => parseInt(x, 16));
        const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
        let count = 0;
        for (let i = 0; i < data.length; i += 4) if (Math.abs(data[i] - r) + Math.abs(data[i + 1] - g) + Math.abs(data[i + 2] - b) < 60) count++;
        return count > 100 && count;
      });
      assert.ok((await drawn.jsonValue()) > 100, 'the simulated curve is drawn');
      await both_themes(page, 'curves-simulated');
      await page.getByRole('tab', { name: 'Scenario' }).click();
      await page.keyboard.press('Escape');
      await page.keyboard.press('Escape');
      assert.equal(JSON.stringify(await document_of(page)), JSON.stringify(before));
    },
  },
  {
    name: 'grips: a two-hand grab is made by keys, held while the content is simulated, edited in the inspector, and released',
    async run({ page }) {
      await set_mode(page, 'Edit');
      const before = await document_of(page);
      const human = human_of(before);
      await page.locator(`[data-character="${human.id}"] .track-name`).click();
      await blur(page);
      await page.keyboard.press('Shift+ArrowLeft');
      for (let i = 0; i < 12; i++) await page.keyboard.press('ArrowRight');
      await page.keyboard.press('1');
      await page.keyboard.press('f');
      await page.waitForTimeout(900);
      const grabs = async () => (await document_of(page)).events.filter((e) => e.type === 'grab');
      const hands = [];
      for (const side of ['left', 'right']) {
        hands.push(await select_link(page, human.id, `hand ${side}`));
        await blur(page);
        await page.keyboard.press('Shift+G');
        await until(page, async () => (await grabs()).length === hands.length, `the grab of the ${side} hand`);
        // both hands grip the world where they are, as a bar that does not move
        await page.getByRole('combobox', { name: 'Grips' }).selectOption('');
        await until(page, async () => (await grabs()).filter((e) => e.other === '').length === hands.length, 'a grip on the world');
        await page.getByRole('textbox', { name: 'Opens above' }).fill('5000');
        await page.keyboard.press('Enter');
        await until(page, async () => (await grabs()).filter((e) => e.limit === 5000).length === hands.length, 'the limit of the grip');
      }
      assert.equal(await page.locator('.track.holds .pill.grab').count(), 2);
      await both_themes(page, 'grips');
      const held = await Promise.all(hands.map((l) => hook(page, `link_position(${JSON.stringify(human.id)}, ${l})`)));
      await blur(page);

      // the release of the right hand, 0.5 s later
      for (let i = 0; i < 30; i++) await page.keyboard.press('ArrowRight');
      await page.getByRole('button', { name: 'Release here' }).click();
      await until(page, async () => (await document_of(page)).events.some((e) => e.type === 'release'), 'the release');
      assert.equal(await label_of(page), 'Add release');

      await set_mode(page, 'Simulate');
      await page.keyboard.press('Shift+ArrowLeft');
      await page.keyboard.press('Space');
      await until(page, async () => (await hook(page, 'transport()')).simulated > 1.2, '1.2 s of simulation', 120000);
      await page.keyboard.press('Space');
      await page.waitForTimeout(300);
      const now = await Promise.all(hands.map((l) => hook(page, `link_position(${JSON.stringify(human.id)}, ${l})`)));
      const moved = now.map((p, i) => Math.hypot(p[0] - held[i][0], p[1] - held[i][1], p[2] - held[i][2]));
      assert.ok(moved[0] < 0.15, `the left hand holds: ${moved[0].toFixed(3)} m`);
      assert.ok(moved[1] > moved[0], `the right hand was released: ${moved[1].toFixed(3)} m`);
      await page.screenshot({ path: `${pictures}grips-simulated.png` });
      await set_mode(page, 'Edit');
      await undo_to(page, before);
    },
  },
  {
    name: 'the tour is shown at the first start, is led by keys, names parts that exist, and ends for good',
    async run({ page, service }) {
      const other = await page.context().browser().newPage({ viewport: { width: 1280, height: 720 } });
      await other.goto(service.address);
      const card = other.locator('.tour');
      await card.waitFor();
      await other.waitForTimeout(1200);
      await other.screenshot({ path: `${pictures}tour.png` });
      const titles = [];
      for (let i = 0; i < 6; i++) {
        titles.push(await card.locator('strong').textContent());
        await other.locator('.tour-part').waitFor();
        const [a, b] = [await card.boundingBox(), other.viewportSize()];
        assert.ok(a.x >= 0 && a.y >= 0 && a.x + a.width <= b.width && a.y + a.height <= b.height, `the card of “${titles[i]}” is inside of the window`);
        if (i === 2) await other.screenshot({ path: `${pictures}tour-3.png` });
        if (i < 5) await other.keyboard.press('ArrowRight');
      }
      assert.equal(new Set(titles).size, 6);
      await other.keyboard.press('ArrowLeft');
      assert.equal(await card.locator('strong').textContent(), titles[4]);
      await other.keyboard.press('Escape');
      await card.waitFor({ state: 'detached' });
      await other.reload();
      await other.waitForFunction(() => window.ugoki?.connected);
      await other.waitForTimeout(500);
      assert.equal(await card.count(), 0, 'the tour is not shown again');
      await other.keyboard.press('F1');
      await other.getByRole('button', { name: 'Take the tour' }).click();
      await card.waitFor();
      await other.getByRole('button', { name: 'End the tour' }).click();
      await card.waitFor({ state: 'detached' });
      await other.close();
    },
  },
].map((journey) => ({ ...journey, skip }));
