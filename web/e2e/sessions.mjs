// Journeys through whole working sessions: the studio is killed, two windows, the keyboard alone, many copies, and everything undone and redone.
import assert from 'node:assert/strict';
import { rmSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { blur, document_of, ready, set_mode, text_of, undo_to, until } from './browser.mjs';
import { mock } from './service.mjs';

const skip = mock && 'the mock service has no history';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const hook = (page, expression) => page.evaluate(`window.ugoki.${expression}`);
const focused = (page, read) => page.evaluate(read);

/** Presses `keys` of undo or redo until the document has no more of them. @return texts of the document, after each step */
async function walk_history(page, keys, possible) {
  const texts = [await text_of(page)];
  while ((await hook(page, 'undo()'))[possible]) {
    const { revision } = await hook(page, 'undo()');
    await page.keyboard.press(keys);
    await until(page, async () => (await hook(page, 'undo()')).revision !== revision, `step ${texts.length} of ${keys}`, 20000);
    texts.push(await text_of(page));
    assert.ok(texts.length < 3000, 'the history ends');
  }
  return texts;
}

/** Opens a project by keys, and waits until the page shows its document, whose text is `wanted`. */
async function open_by_keys(page, path, wanted) {
  await page.keyboard.press('Control+o');
  await page.getByRole('dialog', { name: 'Open project' }).waitFor();
  await page.keyboard.type(path);
  await page.keyboard.press('Enter');
  await until(page, async () => path.endsWith(`/${await page.locator('.project-name').textContent()}`), `the project ${path}`);
  await until(page, async () => (await text_of(page)) === wanted, 'its content');
}

export const session_journeys = [
  {
    name: 'session: the studio is killed while a clip is dragged; the page reports it, resumes, and has every confirmed edit and its history',
    async run({ page, service, seen }) {
      const quiet = seen.errors.length; // failed connections are logged as errors by the browser
      await set_mode(page, 'Edit');
      await page.getByRole('tab', { name: 'Scenario' }).click();
      await page.keyboard.press('Home');
      const before = await text_of(page);
      await page.locator('.clip').first().click();
      await page.keyboard.press('Control+d');
      const confirmed = await until(page, async () => (await text_of(page)) !== before && text_of(page), 'a confirmed edit');
      await page.waitForTimeout(300);
      const clip = JSON.parse(confirmed).characters[0].track.at(-1);
      const box = await page.locator(`[data-clip="${clip.id}"]`).boundingBox();
      await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
      await page.mouse.down();
      await page.mouse.move(box.x + box.width / 2 + 40, box.y + box.height / 2, { steps: 4 });
      const restarted = service.restart(false, 2500);
      await page.locator('.banner', { hasText: 'connection to the studio is lost' }).waitFor({ timeout: 20000 });
      await page.mouse.move(box.x + box.width / 2 + 60, box.y + box.height / 2, { steps: 4 });
      await page.mouse.up(); // the edit cannot be sent
      await page.locator('.toast.error', { hasText: 'nothing was changed' }).waitFor({ timeout: 10000 });
      await page.screenshot({ path: `${pictures}killed.png` });
      service.address = await restarted;
      await until(page, () => page.evaluate(() => window.ugoki.connected), 'the page to resume', 60000);
      await page.locator('.banner').waitFor({ state: 'detached' });
      assert.equal(await text_of(page), confirmed, 'every confirmed edit is there');
      const number = await hook(page, 'frames_received');
      await blur(page);
      await page.keyboard.press('ArrowRight');
      await until(page, async () => (await hook(page, 'frames_received')) > number, 'frames again');
      await page.keyboard.press('Control+z');
      await until(page, async () => (await text_of(page)) === before, 'the history of before the kill');
      await page.keyboard.press('Control+Shift+z');
      await until(page, async () => (await text_of(page)) === confirmed, 'the redone edit');
      await undo_to(page, before);
      for (const toast of await page.locator('.toast.error').getByRole('button', { name: 'Dismiss' }).all()) await toast.click().catch(() => undefined);
      seen.errors.length = quiet;
    },
  },
  {
    name: 'session: two windows on one project show the edits, the undo and the playhead of each other',
    async run({ page, service }) {
      const before = await text_of(page);
      const other = await page.context().browser().newPage({ viewport: { width: 1280, height: 720 } });
      await other.addInitScript(() => location.protocol.startsWith('http') && (localStorage.setItem('ugoki.tour', 'done'), localStorage.setItem('ugoki.draft', 'on')));
      const errors = [];
      other.on('pageerror', (e) => errors.push(e.message));
      await other.goto(service.address);
      await ready(other);
      const same = async () => (await text_of(page)) === (await text_of(other));
      assert.ok(await same(), 'both show the same content');
      // an edit in each window
      await page.locator('.track-name').first().click();
      await page.keyboard.press('Shift+P');
      await until(page, async () => (await text_of(page)) !== before && (await same()), 'the push in both windows');
      const pushed = await text_of(page);
      await other.locator('.track-name').nth(1).click();
      await other.keyboard.press('Control+d');
      await until(other, async () => (await text_of(other)) !== pushed && (await same()), 'the copy in both windows');
      const copied = await text_of(page);
      // both at once: each edit is executed, in one order
      await Promise.all([page.keyboard.press('m'), other.keyboard.press('Shift+P')]);
      await until(page, async () => (await document_of(page)).events.length > JSON.parse(copied).events.length && ((await document_of(page)).markers ?? []).length > (JSON.parse(copied).markers ?? []).length && (await same()), 'both edits in both windows');
      // the playhead
      await blur(page);
      await page.keyboard.press('Shift+ArrowLeft');
      for (let i = 0; i < 7; i++) await page.keyboard.press('ArrowRight');
      const time = await until(page, async () => (await hook(page, 'frame()')).time > 0.05 && (await hook(page, 'frame()')).time, 'the playhead');
      await until(other, async () => Math.abs((await hook(other, 'frame()')).time - (await hook(page, 'frame()')).time) < 1e-6 && (await hook(other, 'frame()')).time >= time, 'the playhead in the other window');
      await page.bringToFront();
      await page.screenshot({ path: `${pictures}window-one.png` });
      await other.screenshot({ path: `${pictures}window-two.png` });
      // the other window undoes the edits of both
      await undo_to(other, before);
      await until(page, async () => (await text_of(page)) === before, 'undone in both windows');
      assert.deepEqual(errors, []);
      await other.context().close();
    },
  },
  {
    name: 'session: the keyboard alone makes an empty project, adds a human and a motion, pushes it and plays the simulation',
    async run({ page, service }) {
      const before = await text_of(page);
      const first = await page.locator('.project-name').textContent();
      await page.evaluate(() => (window.clicks = 0) || window.addEventListener('pointerdown', () => window.clicks++, true));
      const command = async (words) => {
        await page.keyboard.press('Control+k');
        await page.getByRole('dialog', { name: /command/i }).waitFor();
        await page.keyboard.type(words);
        await page.keyboard.press('Enter');
      };
      await blur(page);
      await command('new project');
      await page.getByRole('dialog', { name: 'New project' }).waitFor();
      const name = `by-keys-${Date.now()}`; // a second attempt cannot make the same project again
      await page.keyboard.type(name);
      await page.keyboard.press('Shift+Tab');
      for (let i = 0; (await focused(page, 'document.activeElement.dataset.entry')) !== 'empty'; i++) {
        assert.ok(i < 40, 'arrow keys reach the empty project');
        await page.keyboard.press('ArrowRight');
      }
      await page.screenshot({ path: `${pictures}keys-new.png` });
      await page.keyboard.press('Tab');
      await page.keyboard.press('Enter');
      await until(page, async () => (await page.locator('.project-name').textContent()) === `${name}.ugoki` && (await document_of(page)).characters.length === 0, 'the empty project');

      const add = async (words, name) => {
        await page.keyboard.press('/');
        await until(page, () => focused(page, 'document.activeElement.type === "search"'), 'the search of the library');
        await page.keyboard.press('Control+a');
        await page.keyboard.type(words);
        await until(page, async () => (await hook(page, 'library()')).names.includes(name), `${name} in the library`);
        await page.keyboard.press('ArrowDown');
        for (let i = 0; ; i++) {
          await page.keyboard.press('ArrowDown');
          await page.waitForTimeout(60);
          if ((await focused(page, 'document.querySelector("#library-list [aria-selected=true] .entry-name")?.textContent')) === name) break;
          assert.ok(i < 30, `arrow keys reach ${name}`);
        }
        await page.keyboard.press('Enter');
      };
      await add('human', 'Human 1.75 m');
      await until(page, async () => (await document_of(page)).characters.length === 1, 'the human');
      await add('walk', 'Walk, relaxed');
      await until(page, async () => (await document_of(page)).characters[0].track.length === 1, 'the motion');
      await page.keyboard.press('/');
      await page.keyboard.press('Escape'); // clears the search
      await blur(page);
      for (let i = 0; i < 9; i++) await page.keyboard.press('ArrowRight');
      await page.keyboard.press('Shift+P');
      const [push] = await until(page, async () => (await document_of(page)).events.length === 1 && (await document_of(page)).events, 'the push');
      assert.ok(Math.abs(push.time - 9 / 60) < 1e-3, `the push is at the frame to which the keys moved the playhead: ${push.time} s`);
      await page.keyboard.press('`');
      await until(page, async () => (await hook(page, 'transport()')).mode === 'simulate', 'Simulate');
      await page.keyboard.press('Shift+ArrowLeft');
      await page.keyboard.press('Space');
      await until(page, async () => (await hook(page, 'transport()')).simulated > 0.8, 'a played simulation', 60000);
      await page.keyboard.press('Space');
      await until(page, async () => !(await hook(page, 'transport()')).playing, 'Pause');
      await page.screenshot({ path: `${pictures}keys-played.png` });
      const box = await page.locator('.viewport > canvas').boundingBox();
      const { id } = (await document_of(page)).characters[0];
      for (const part of ['head', 'foot left', 'foot right']) {
        const at = await hook(page, `link_on_screen('${id}', window.ugoki.link_index('${id}', '${part}'))`);
        assert.ok(at && at.x > box.x && at.x < box.x + box.width && at.y > box.y && at.y < box.y + box.height, `the camera shows the ${part}: ${JSON.stringify([at, box])}`);
      }
      await page.keyboard.press('Control+s');
      await page.keyboard.press('`');
      await open_by_keys(page, `${service.folder}/${first}`, before);
      assert.equal(await page.evaluate('window.clicks'), 0, 'no mouse was used');
      await ready(page);
    },
  },
  {
    name: 'session: the mouse alone makes a first content in ten actions: a human walks, is pushed, and is simulated',
    async run({ page, service }) {
      const before = await text_of(page);
      const first = await page.locator('.project-name').textContent();
      rmSync(`${service.folder}/untitled.ugoki`, { force: true }); // an empty project of another journey
      await page.evaluate(() => (window.pressed = 0) || window.addEventListener('keydown', () => window.pressed++, true));
      let actions = 0;
      const act = async (action) => {
        actions++;
        await action;
      };
      const entry = (name) => page.locator('#library-list [role=option]', { has: page.locator('.entry-name', { hasText: name }) }).first();
      await act(page.locator('button.project').click());
      await act(page.getByRole('menuitem', { name: 'New project…' }).click());
      await act(page.locator('[data-entry="empty"]').click());
      await act(page.getByRole('button', { name: 'Create' }).click());
      await until(page, async () => (await document_of(page)).characters.length === 0, 'the empty project');
      await page.screenshot({ path: `${pictures}first-empty.png` });
      const floor = await page.locator('.viewport > canvas').boundingBox();
      await act(entry('Human 1.75 m').dragTo(page.locator('.viewport > canvas'), { targetPosition: { x: floor.width * 0.5, y: floor.height * 0.75 } }));
      const { id } = await until(page, async () => (await document_of(page)).characters[0], 'the human');
      await act(entry('Walk, relaxed').dragTo(page.locator(`[data-character="${id}"] .lane`), { targetPosition: { x: 4, y: 12 } }));
      await until(page, async () => (await document_of(page)).characters[0].track.length === 1, 'the motion');
      await act(page.getByRole('button', { name: 'Loop to the end' }).click());
      await until(page, async () => (await document_of(page)).characters[0].track[0].length === 10, 'the looped motion');
      await act(page.getByRole('button', { name: '+ Push' }).click());
      await until(page, async () => (await document_of(page)).events.length === 1, 'the push');
      await act(page.getByRole('radio', { name: 'Simulate' }).click());
      await act(page.locator('.transport').getByRole('button', { name: 'Play' }).click());
      await until(page, async () => (await hook(page, 'transport()')).simulated > 0.8, 'a played simulation');
      await page.locator('.transport').getByRole('button', { name: 'Pause' }).click();
      await until(page, async () => !(await hook(page, 'transport()')).playing, 'Pause');
      await page.screenshot({ path: `${pictures}first-played.png` });
      assert.equal(await page.evaluate('window.pressed'), 0, 'no key was used');
      assert.ok(actions <= 10, `${actions} actions`);
      await set_mode(page, 'Edit');
      await open_by_keys(page, `${service.folder}/${first}`, before);
      rmSync(`${service.folder}/untitled.ugoki`);
      await ready(page);
    },
  },
  {
    name: 'session: a character is duplicated 20 times as fast as keys can be pressed, and all are simulated',
    async run({ page }) {
      const before = await text_of(page);
      const count = JSON.parse(before).characters.length;
      await page.locator('.track-name').first().click();
      for (let i = 0; i < 20; i++) await page.keyboard.press('Control+d');
      const { characters } = await until(page, async () => (await document_of(page)).characters.length === count + 20 && document_of(page), '20 copies', 30000);
      assert.equal(new Set(characters.map((c) => c.name)).size, characters.length, 'every copy has a name of its own');
      for (const [i, a] of characters.entries())
        for (const b of characters.slice(0, i)) assert.ok(Math.hypot(a.place.x - b.place.x, a.place.y - b.place.y) > 0.5, `${a.name} and ${b.name} stand apart`);
      await set_mode(page, 'Simulate');
      await blur(page);
      await page.keyboard.press('Shift+ArrowLeft');
      await page.keyboard.press('a');
      const drawn = await page.evaluate(() => {
        const { prototype } = WebGL2RenderingContext;
        const draw = prototype.drawElementsInstanced;
        return new Promise((done) => {
          let instances = 0;
          prototype.drawElementsInstanced = function (...values) {
            if (values[1] > 300) instances = Math.max(instances, values[4]); // indices of a body; instanced lines have few
            return draw.apply(this, values);
          };
          setTimeout(() => ((prototype.drawElementsInstanced = draw), done(instances)), 1500);
        });
      });
      assert.ok(drawn >= 21, `one call draws all copies: ${drawn}`);
      await page.keyboard.press('Space');
      await until(page, async () => (await hook(page, 'transport()')).simulated > 0.5, 'half a second of simulation', 60000);
      await page.keyboard.press('Space');
      assert.equal(await page.locator('.banner').count(), 0);
      assert.deepEqual((await hook(page, 'summary()')).characters.filter((c) => c.fell), []);
      await page.screenshot({ path: `${pictures}twenty.png` });
      await set_mode(page, 'Edit');
      await undo_to(page, before);
    },
  },
  {
    name: 'session: everything is undone to the start and redone to the end, with equal bytes at every step',
    async run({ page }) {
      await set_mode(page, 'Edit');
      await page.keyboard.press('Escape');
      await page.locator('.scenario').click({ position: { x: 400, y: 6 } });
      await blur(page);
      // commands of many kinds, also such that earlier journeys left in the history
      await page.locator('.track-name').first().click();
      for (const keys of ['Control+d', 'Shift+P', 'm']) {
        const { revision } = await hook(page, 'undo()');
        await page.keyboard.press(keys);
        await until(page, async () => (await hook(page, 'undo()')).revision !== revision, keys, 20000);
      }
      const end = await text_of(page);
      const back = await walk_history(page, 'Control+z', 'can_undo');
      assert.ok(back.length > 3, `${back.length - 1} commands`);
      const forth = await walk_history(page, 'Control+Shift+z', 'can_redo');
      assert.deepEqual(forth, [...back].reverse(), 'the same text of the document at every step');
      assert.equal(await text_of(page), end);
      for (let i = 0; i < 3; i++) {
        const { revision } = await hook(page, 'undo()');
        await page.keyboard.press('Control+z');
        await until(page, async () => (await hook(page, 'undo()')).revision !== revision, 'the commands of this journey to be undone', 20000);
      }
    },
  },
].map((journey) => ({ ...journey, skip }));
