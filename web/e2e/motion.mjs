// Journeys (end-to-end tests) through the operations on motions: context menu of a clip, inspector, dialogs, undo.
import assert from 'node:assert/strict';

const hook = (page, expression) => page.evaluate(expression);
async function until(page, expression, description, timeout = 60000) {
  const end = Date.now() + timeout;
  while (!(await page.evaluate(expression))) {
    if (Date.now() > end) throw new Error(`waited ${timeout / 1000} s in vain for: ${description}`);
    await page.waitForTimeout(50);
  }
}
const document_of = (page) => hook(page, 'window.ugoki.document()');
const human_of = (doc) => doc.characters.find((c) => c.id === 'human') ?? doc.characters[0];

/** Waits until the document differs from `before` and no operation is running. @return the new document */
async function changed(page, before, description) {
  await until(page, `JSON.stringify(window.ugoki.document()) !== ${JSON.stringify(JSON.stringify(before))}`, description);
  await until(page, 'document.querySelectorAll(".task").length === 0', 'all operations to end');
  return document_of(page);
}

async function menu(page, clip) {
  const box = await page.locator(`[data-clip="${clip}"]`).boundingBox();
  await page.mouse.click(box.x + Math.min(40, box.width / 2), box.y + 8, { button: 'right' });
  return page.getByRole('menu', { name: 'Operations on the clip' });
}

/** Chooses an operation in the clip's menu. */
async function choose(page, clip, name) {
  await (await menu(page, clip)).getByRole('menuitem', { name }).click();
}

async function undo(page, wanted, label) {
  assert.equal((await hook(page, 'window.ugoki.undo()')).undo_label, label);
  await page.getByRole('button', { name: `Undo: ${label}` }).click();
  await until(page, `JSON.stringify(window.ugoki.document()) === ${JSON.stringify(JSON.stringify(wanted))}`, `${label} undone`);
}

export const motion_journeys = [
  {
    name: 'the context menu mirrors a clip, and undo restores it',
    async run({ page }) {
      await page.getByRole('radio', { name: 'Edit' }).click();
      await until(page, 'window.ugoki.transport().mode === "edit"', 'Edit');
      await page.locator('.tab', { hasText: 'Scenario' }).first().click();
      await page.keyboard.press('Home');
      const before = await document_of(page);
      const human = human_of(before);
      const clip = human.track[0];
      const bands = page.locator(`[data-clip="${clip.id}"] .contact-bands`);
      await bands.waitFor({ state: 'attached', timeout: 30000 });
      assert.match(await bands.evaluate((e) => e.style.backgroundImage), /--one/, 'a walk has phases with one foot in contact');
      await choose(page, clip.id, 'Mirror');
      const after = await changed(page, before, 'the mirrored motion');
      assert.notEqual(human_of(after).track[0].motion, clip.motion);
      await until(page, `document.querySelector('[data-clip="${clip.id}"] .clip-name').textContent.includes('mirrored')`, 'the new name of the clip');
      await undo(page, before, 'Mirror motion');
    },
  },
  {
    name: 'the inspector trims a motion and turns its path',
    async run({ page }) {
      const before = await document_of(page);
      const clip = human_of(before).track[0];
      await page.locator(`[data-clip="${clip.id}"]`).click({ position: { x: 30, y: 8 } });
      // trimming makes one motion of all repetitions in the clip; a single stride is too short to turn its path
      await page.getByRole('button', { name: 'Trim to what the clip shows' }).click();
      const trimmed = await changed(page, before, 'the trimmed motion');
      assert.equal(human_of(trimmed).track[0].loop, false);
      await page.getByRole('button', { name: 'Change path over the ground…' }).click();
      const dialog = page.getByRole('dialog', { name: 'Change path over the ground' });
      await dialog.getByLabel('Turn', { exact: true }).fill('120');
      await dialog.getByLabel('Turn', { exact: true }).press('Tab');
      await page.screenshot({ path: new URL('./out/motion-path.png', import.meta.url).pathname });
      await dialog.getByRole('button', { name: 'Apply' }).click();
      const turned = await changed(page, trimmed, 'the turned path');
      assert.ok(Math.abs(human_of(turned).track[0].length - human_of(trimmed).track[0].length) < 0.2);
      await undo(page, trimmed, 'Change path of motion');
      await undo(page, before, 'Cut motion to clip');
    },
  },
  {
    name: 'two clips are joined, and the speed at the end is changed',
    async run({ page }) {
      const before = await document_of(page);
      const human = human_of(before);
      const clip = human.track[0];
      await page.locator(`[data-clip="${clip.id}"]`).click({ position: { x: 30, y: 8 } });
      await page.getByRole('button', { name: 'Duplicate' }).click();
      let now = await changed(page, before, 'a second clip');
      const count = human_of(now).track.length;
      const first = human_of(now).track[0];
      await page.keyboard.press('Home');
      await choose(page, first.id, 'Join with next clip');
      const two = now;
      now = await changed(page, two, 'the joined clip');
      assert.equal(human_of(now).track.length, count - 1);
      assert.ok(human_of(now).track[0].length > first.length * 1.5);
      await choose(page, first.id, 'Change speed…');
      const dialog = page.getByRole('dialog', { name: 'Change speed' });
      const end = dialog.getByRole('textbox', { name: 'At the end' });
      await end.fill('50');
      await end.press('Tab');
      await dialog.getByRole('button', { name: 'Apply' }).click();
      const slow = await changed(page, now, 'the slower end');
      assert.ok(human_of(slow).track[0].length > human_of(now).track[0].length * 1.1);
      await undo(page, now, 'Change speed of motion');
      await undo(page, two, 'Join clips');
      await page.keyboard.press('Control+z');
      await until(page, `JSON.stringify(window.ugoki.document()) === ${JSON.stringify(JSON.stringify(before))}`, 'as before');
    },
  },
  {
    name: 'a blend has a slider, and a motion is retargeted to another body',
    async run({ page }) {
      const before = await document_of(page);
      const human = human_of(before);
      const clip = human.track[0];
      await choose(page, clip.id, 'Blend with another motion…');
      const dialog = page.getByRole('dialog', { name: 'Blend with another motion' });
      const apply = dialog.getByRole('button', { name: 'Apply' });
      assert.ok(await apply.isDisabled(), 'Apply needs the other motion');
      await dialog.getByRole('radio').first().click();
      const slider = dialog.getByRole('slider', { name: 'Share of the other motion' });
      await slider.focus();
      for (let i = 0; i < 5; i++) await page.keyboard.press('ArrowLeft');
      assert.equal(await slider.inputValue(), '45');
      await page.screenshot({ path: new URL('./out/motion-blend.png', import.meta.url).pathname });
      await page.keyboard.press('Escape');
      await until(page, 'document.querySelectorAll(".motion-dialog").length === 0', 'closed by Escape');
      assert.deepEqual(await document_of(page), before);

      await choose(page, clip.id, 'For another body…');
      const body = page.getByRole('dialog', { name: 'For another body' });
      await body.getByRole('radio', { name: /Human, / }).click();
      await body.getByRole('button', { name: 'Make character' }).click();
      const after = await changed(page, before, 'the child');
      assert.equal(after.characters.length, before.characters.length + 1);
      const child = after.characters.at(-1);
      assert.equal(child.track[0].length, clip.length);
      await until(page, `(window.ugoki.character('${child.id}')?.com[2] ?? 0) > 0.3`, 'the child to stand upright');
      assert.ok((await hook(page, 'window.ugoki.log()')).some((line) => /For another body — Lengths were scaled by 0\.\d+/.test(line)), 'the report is in the log');
      await undo(page, before, 'Motion for another body');
    },
  },
  {
    name: 'a long operation can be cancelled',
    async run({ page }) {
      const looped = await document_of(page);
      const clip = human_of(looped).track[0];
      // ten minutes of motion: the page shows an operation only after 300 ms, and retargeting 20 s of motion takes less than that
      await page.locator(`[data-clip="${clip.id}"]`).click({ position: { x: 30, y: 8 } });
      const length = page.locator('.inspector').getByRole('textbox', { name: 'Length' });
      await length.fill('600');
      await length.press('Enter');
      const stretched = await changed(page, looped, 'the long clip');
      await page.getByRole('button', { name: 'Trim to what the clip shows' }).click();
      const before = await changed(page, stretched, 'the long motion');
      await choose(page, clip.id, 'For another body…');
      const body = page.getByRole('dialog', { name: 'For another body' });
      await body.getByRole('radio', { name: /^Dog/ }).first().click(); // the dog of the scenario; the library may list another
      // Click Cancel from within the page as soon as it appears: a click by the driver may come too late while the page is busy.
      await page.evaluate(() => {
        const watch = new MutationObserver(() => {
          const cancel = [...document.querySelectorAll('.task button')].find((b) => b.textContent.trim() === 'Cancel');
          if (!cancel || window.cancelled) return;
          watch.disconnect();
          window.cancelled = true;
          cancel.click();
        });
        watch.observe(document.body, { childList: true, subtree: true });
      });
      await body.getByRole('button', { name: 'Make character' }).click();
      await until(page, 'window.cancelled === true', 'the Cancel button');
      await until(page, 'document.querySelectorAll(".task").length === 0', 'the operation to end');
      await page.waitForTimeout(500);
      assert.deepEqual(await document_of(page), before);
      await undo(page, stretched, 'Cut motion to clip');
      await page.keyboard.press('Control+z');
      await until(page, `JSON.stringify(window.ugoki.document()) === ${JSON.stringify(JSON.stringify(looped))}`, 'the clip to have its former length');
    },
  },
];
