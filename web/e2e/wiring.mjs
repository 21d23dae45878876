// Helpers for journeys in the wiring editor. They act by mouse and keyboard only; `window.ugoki` is only read.
import assert from 'node:assert/strict';

export const state = (page) => page.evaluate(() => (window.ugoki?.connected ? window.ugoki.circuit() : null));
export const undo = (page) => page.evaluate(() => window.ugoki.undo());
export const ids = async (page) => (await state(page)).lsis.map((l) => l.id);

/** Waits until `ask` accepts the state of the wiring editor, and returns the state. */
export async function until(page, ask, description, timeout = 20000) {
  const end = Date.now() + timeout;
  for (;;) {
    const now = await state(page);
    if (now && ask(now)) return now;
    if (Date.now() > end) throw new Error(`waited ${timeout / 1000} s in vain for: ${description}; the editor has ${JSON.stringify(now)?.slice(0, 600)}`);
    await page.waitForTimeout(60);
  }
}
/** Waits until the label of the next undo matches: the service has executed the command. */
export async function wait_for_undo_label(page, label) {
  const end = Date.now() + 30000;
  while (!label.test((await undo(page)).undo_label)) {
    assert.ok(Date.now() < end, `${label}: ${(await undo(page)).undo_label}`);
    await page.waitForTimeout(60);
  }
}
export const middle = (box) => ({ x: box.x + box.width / 2, y: box.y + box.height / 2 });
export async function pin(page, node, name, side) {
  const box = await page.locator(`[data-lsi="${node}"] [data-pin="${node}.${name}"][data-side="${side}"] .react-flow__handle`).boundingBox();
  assert.ok(box, `the pin ${node}.${name} is on screen`);
  return middle(box);
}
export async function drag(page, from, to) {
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.mouse.move((from.x + to.x) / 2, (from.y + to.y) / 2 + 6, { steps: 4 });
  await page.mouse.move(to.x, to.y, { steps: 6 });
  await page.waitForTimeout(120);
  await page.mouse.up();
}
export const head = async (page, node) => {
  const box = await page.locator(`[data-lsi="${node}"] .lsi-head`).boundingBox();
  return { x: box.x + 20, y: box.y + box.height / 2 };
};
/** A point of the canvas, px, at fractions of its width and height. */
export async function spot(page, x, y) {
  const box = await page.locator('.circuit[role=application]').boundingBox();
  return { x: box.x + box.width * x, y: box.y + box.height * y };
}
/** Adds the LSI that the search finds first for `words`, at the point `at` (px). */
export async function add(page, words, at) {
  await page.mouse.dblclick(at.x, at.y);
  await page.locator('.circuit-search input').waitFor();
  await page.keyboard.type(words);
  await page.keyboard.press('Enter');
}

/** Maximises or restores the circuit panel. */
export const large = async (page, wanted) => {
  const tab = page.locator('.tab', { hasText: 'Circuit' });
  await tab.click();
  const box = await page.locator('.circuit[role=application]').boundingBox();
  const is_large = box.height > 600;
  if (is_large !== wanted) await tab.dblclick();
  await page.waitForTimeout(500);
};
