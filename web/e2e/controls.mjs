// Play controls: a key held in the page changes a value on a wire of the running circuit.
import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { undo_while } from './browser.mjs';
import { mock } from './service.mjs';
import { add, large, spot, state, until } from './wiring.mjs';

const skip = mock && 'the mock service has no circuit runtime';
const value = (page) => page.evaluate(() => window.ugoki.pin_value('keyboard', 'pressed')?.[0]);
/** Waits until the pin has the value `wanted`. */
async function wait_for_value(page, wanted, description) {
  const end = Date.now() + 20000;
  while ((await value(page)) !== wanted) {
    assert.ok(Date.now() < end, `${description}: the pin is ${await value(page)}`);
    await page.waitForTimeout(50);
  }
}

/** True if the service reports the devices that the content reads; programs of earlier versions do not. */
const reports_devices = (page) =>
  page.evaluate(() => new Promise((resolve) => {
    const socket = new WebSocket(`${location.origin.replace('http', 'ws')}/ws`, ['ugoki', `ugoki.token.${sessionStorage.getItem('ugoki_token')}`]);
    socket.onopen = () => socket.send('{"id":1,"op":"hello"}');
    socket.onmessage = (message) => {
      const reply = typeof message.data === 'string' ? JSON.parse(message.data) : {};
      if (reply.reply !== 1) return;
      socket.close();
      resolve('devices' in reply);
    };
  }));

export const control_journeys = [
  {
    unless: async ({ page }) => !(await reports_devices(page)) && 'this program does not support input from the page',
    name: 'controls: a key held during play controls changes a value on a wire',
    async run({ page }) {
      await large(page, false); // restore the panel's size, so that the viewport with the button is visible
      await page.locator('.circuit[role=application]').focus();
      const before = (await state(page)).lsis.length;
      await add(page, 'keyboard', await spot(page, 0.5, 0.85));
      await until(page, (c) => c.lsis.some((l) => l.id === 'keyboard'), 'the keyboard');
      await page.locator('.circuit[role=application]').focus();
      await page.keyboard.press('f'); // fit the selection: only at a large zoom does the canvas show values
      const enter = page.getByRole('button', { name: /^Play controls/ });
      await enter.waitFor({ timeout: 20000 });
      assert.match(await enter.textContent(), /Space/);
      await enter.click();
      const bar = page.locator('.controls-bar.on');
      await bar.waitFor();
      await page.waitForFunction(() => window.ugoki.transport().mode === 'simulate' && window.ugoki.transport().playing);
      await wait_for_value(page, 0, 'no key is held');
      await page.keyboard.down('Space');
      await wait_for_value(page, 1, 'the key is held');
      assert.equal(await bar.locator('kbd[data-held=true]').textContent(), 'Space');
      await page.screenshot({ path: fileURLToPath(new URL('./out/controls.png', import.meta.url)) });
      assert.ok((await page.evaluate(() => window.ugoki.transport())).playing, 'Space goes to the content, not to the transport');
      await page.keyboard.up('Space');
      await wait_for_value(page, 0, 'the key was released');

      await page.keyboard.down('Space');
      await wait_for_value(page, 1, 'held again');
      await page.keyboard.press('Escape');
      await bar.waitFor({ state: 'detached' });
      await wait_for_value(page, 0, 'Escape releases all keys');
      await page.keyboard.up('Space');

      await page.getByRole('radio', { name: 'Edit' }).click();
      await undo_while(page, async () => (await state(page)).lsis.length > before);
    },
  },
].map((journey) => ({ ...journey, skip }));
