// A journey: props are added by mouse, changed in the inspector, moved in the viewport, simulated, and undone.
import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { blur, document_of, set_mode, text_of, undo_to, until } from './browser.mjs';
import { mock } from './service.mjs';

const skip = mock && 'the mock service makes no props';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const hook = (page, expression) => page.evaluate(`window.ugoki.${expression}`);

export const prop_journeys = [
  {
    name: 'props: stairs, a ramp and a crate are added by mouse, sized and moved; the crate falls onto the stairs; all is undone',
    async run({ page }) {
      await set_mode(page, 'Edit');
      await page.keyboard.press('Escape');
      const before = await text_of(page);
      const props = async () => (await document_of(page)).characters.filter((c) => c.prop);
      const add = async (kind) => {
        const known = (await props()).map((c) => c.id);
        await page.getByRole('button', { name: '+ Prop' }).click();
        await page.getByRole('menu', { name: 'Add a prop' }).getByRole('menuitem', { name: kind, exact: true }).click();
        const made = await until(page, async () => (await props()).find((c) => !known.includes(c.id)), `the ${kind}`);
        await page.locator('.inspector h3', { hasText: 'Prop' }).waitFor();
        return made.id;
      };
      const prop = async (id) => (await props()).find((c) => c.id === id);
      const set = async (label, value, done) => {
        const field = page.locator('.inspector').getByLabel(label, { exact: true });
        await field.fill(String(value));
        await field.press('Enter');
        await until(page, done, `${label} = ${value}`);
      };
      const stairs = await add('Stairs');
      await set('Steps', 4, async () => (await prop(stairs)).prop.steps === 4);
      await set('Height', 0.8, async () => (await prop(stairs)).prop.size[2] === 0.8);
      await set('X', 4, async () => (await prop(stairs)).place.x === 4);
      await set('Y', 3, async () => (await prop(stairs)).place.y === 3);
      const ramp = await add('Ramp');
      assert.equal((await prop(ramp)).group, 'Props');
      await set('Y', -2.5, async () => (await prop(ramp)).place.y === -2.5);
      const crate = await add('Box');
      await page.locator('.inspector').getByRole('switch', { name: 'Moves' }).or(page.locator('.inspector').getByLabel('Moves')).first().click();
      await until(page, async () => (await prop(crate)).prop.mass === 10, 'a mass');
      await set('Length', 0.3, async () => (await prop(crate)).prop.size[0] === 0.3);
      await set('Width', 0.3, async () => (await prop(crate)).prop.size[1] === 0.3);
      // over the highest step, whose top is at 0.8 m and 0.375 m long
      await set('X', 4.55, async () => (await prop(crate)).place.x === 4.55);
      await set('Y', 3, async () => (await prop(crate)).place.y === 3);
      await set('Z', 1.3, async () => (await prop(crate)).place.z === 1.3);
      await page.waitForTimeout(500);
      await page.screenshot({ path: `${pictures}props.png` });

      // a drag in the viewport moves the ramp over the floor
      const from = (await prop(ramp)).place;
      const at = await hook(page, `to_screen([${from.x}, ${from.y}, 0.2])`);
      await page.mouse.click(at.x, at.y);
      await until(page, async () => (await page.locator('.inspector h3').textContent()).includes('Ramp'), 'the selected ramp');
      await page.mouse.move(at.x, at.y);
      await page.mouse.down();
      await page.mouse.move(at.x + 60, at.y + 4, { steps: 6 });
      await page.mouse.up();
      await until(page, async () => { const { place } = await prop(ramp); return Math.hypot(place.x - from.x, place.y - from.y) > 0.1; }, 'the moved ramp');

      await set_mode(page, 'Simulate');
      await blur(page);
      await page.keyboard.press('Control+Home');
      await page.keyboard.press('Space');
      await until(page, async () => (await hook(page, 'transport()')).simulated > 1, 'a second of simulation');
      await page.keyboard.press('Space');
      const height = (await hook(page, `character(${JSON.stringify(crate)})`)).com[2] - 0.25;
      assert.ok(Math.abs(height - 0.8) < 0.005, `the crate lies on the highest step: its bottom is at ${height} m`);
      await page.screenshot({ path: `${pictures}props-simulated.png` });
      await set_mode(page, 'Edit');
      await undo_to(page, before);
    },
  },
].map((journey) => ({ ...journey, skip }));
