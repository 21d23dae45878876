// Makes the pictures of the gallery of new projects (public/gallery/NAME.webp): creates each content, simulates it, and takes a picture.
// Run after `npm run build`, with the program `ugoki` in UGOKI_BIN: node dev/gallery.mjs [ids]
import { readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { launch, ready } from '../e2e/browser.mjs';
import { start_service } from '../e2e/service.mjs';

/** Time (s) of the picture of each content; 0: before it is simulated. */
const times = {
  empty: 0, park: 3.2, 'push-test': 5.25, bar: 10, cyclist: 5, 'box-by-two': 5.3, hill: 5, hills: 4, rider: 1.2, riding: 3, jansen: 1, andrews: 3.2, 'five-bar': 1, band: 0.3, duet: 5, retargeting: 1.2, doll: 2.2, paths: 4.5, natural: 1.5, 'own-lsi': 4.3, fmu: 3.4, game: 0.3,
  'rag-dolls': 0.7, dominoes: 1.6, tower: 1.2, chain: 1.1,
};
/** How often the camera moves nearer than the view of all characters. */
const nearer = { hills: 7 };
const wanted = process.argv.slice(2);

/** Simulates the content up to `time` (s). */
async function simulate(page, time) {
  await page.getByRole('radio', { name: 'Simulate' }).click();
  while ((await page.evaluate('window.ugoki.transport().mode')) !== 'simulate') await page.waitForTimeout(50);
  await page.getByRole('button', { name: 'Play', exact: true }).click();
  while ((await page.evaluate('window.ugoki.frame()?.time ?? 0')) < time) await page.waitForTimeout(20);
  await page.getByRole('button', { name: 'Pause' }).click();
  // a busy machine pauses late
  await page.locator('.ruler').focus();
  await page.keyboard.press('Home');
  await page.waitForTimeout(300);
  const { x, y, width, height } = await page.locator('.ruler').boundingBox();
  const duration = await page.evaluate('window.ugoki.document().duration');
  await page.mouse.click(x + 12 + (time * (width - 32)) / duration, y + height / 2);
  while (Math.abs((await page.evaluate('window.ugoki.frame().time')) - time) > 0.1) await page.waitForTimeout(20);
}

const service = await start_service();
const browser = await launch();
try {
  const page = await browser.newPage({ viewport: { width: 1280, height: 760 } });
  await page.addInitScript(() => {
    localStorage.setItem('ugoki.tour', 'done');
    localStorage.setItem('ugoki.draft', 'on'); // saved pictures are not drafts
  });
  page.setDefaultTimeout(300000);
  await page.goto(service.address, { timeout: 300000 });
  await ready(page, 300000);
  for (const [id, time] of Object.entries(times)) {
    if (wanted.length > 0 && !wanted.includes(id)) continue;
    await page.locator('button.project').click();
    await page.getByRole('menuitem', { name: 'New project…' }).click();
    await page.locator(`[data-entry="${id}"]`).click();
    await page.getByRole('button', { name: 'Create' }).click();
    await page.locator('.gallery').waitFor({ state: 'detached' });
    while ((await page.evaluate('window.ugoki.frame()')) === null) await page.waitForTimeout(50);
    if (time > 0) await simulate(page, time);
    await page.locator('.ruler').focus();
    await page.keyboard.press('Escape');
    const follow = page.getByRole('button', { name: 'Follow' });
    if ((await follow.getAttribute('aria-pressed')) === 'true') await follow.click();
    for (const key of ['0', '8', 'a']) {
      await page.keyboard.press(key);
      await page.waitForTimeout(1500); // the camera moves smoothly
    }
    for (let i = 0; i < (nearer[id] ?? 0); i++) await page.keyboard.press('+');
    if (nearer[id]) await page.waitForTimeout(1500);
    const [file] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('F2')]);
    const png = readFileSync(await file.path()).toString('base64');
    const webp = await page.evaluate(async (data) => {
      const bitmap = await createImageBitmap(new Blob([Uint8Array.from(atob(data), (c) => c.charCodeAt(0))], { type: 'image/png' }));
      const width = Math.min(bitmap.width, (bitmap.height * 16) / 9);
      const height = (width * 9) / 16;
      const canvas = new OffscreenCanvas(480, 270);
      const context = canvas.getContext('2d');
      context.imageSmoothingQuality = 'high';
      context.drawImage(bitmap, (bitmap.width - width) / 2, (bitmap.height - height) / 2, width, height, 0, 0, 480, 270);
      const bytes = new Uint8Array(await (await canvas.convertToBlob({ type: 'image/webp', quality: 0.8 })).arrayBuffer());
      return btoa(String.fromCharCode(...bytes));
    }, png);
    writeFileSync(fileURLToPath(new URL(`../public/gallery/${id}.webp`, import.meta.url)), Buffer.from(webp, 'base64'));
    console.log(id);
  }
} finally {
  await browser.close();
  await service.stop();
}
