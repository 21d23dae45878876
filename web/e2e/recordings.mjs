// A journey from raw material to motion: a damaged recording of markers for a dog.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { blur, document_of, set_mode, text_of, undo_to, until } from './browser.mjs';
import { mock } from './service.mjs';

const skip = mock && 'the mock service has no library';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const hook = (page, expression) => page.evaluate(`window.ugoki.${expression}`);
const card = (page, name) => page.locator('#library-list [role=option]', { has: page.locator('.entry-name', { hasText: name }) }).first();

/**
 * Markers on the skin of a walking person of 1.75 m, as CSV: x forward, y left, z up, m. One marker is hidden for 0.2 s, another jumps by
 * 40 cm for one frame.
 */
function walking_markers() {
  const rate = 100;
  const frames = 240;
  const [thigh, shank, ankle] = [0.43, 0.43, 0.09]; // lengths and height, m
  const rows = [];
  let labels = [];
  for (let f = 0; f < frames; f++) {
    const t = f / rate;
    const leg = (side) => {
      const phase = (2 * Math.PI * t) / 1.1 + (side > 0 ? 0 : Math.PI);
      const hip = 0.38 * Math.sin(phase);
      const knee = 0.12 + 0.45 * Math.max(0, Math.cos(phase)) ** 2;
      const k = [thigh * Math.sin(hip), -thigh * Math.cos(hip)];
      return { k, a: [k[0] + shank * Math.sin(hip - knee), k[1] - shank * Math.cos(hip - knee)], hip };
    };
    const [left, right] = [leg(1), leg(-1)];
    const z = ankle - Math.min(left.a[1], right.a[1]);
    const x = 1.15 * t;
    const at = {};
    const put = (name, px, py, pz) => (at[name] = [x + px, py, pz]);
    for (const [s, l, side] of [['L', left, 1], ['R', right, -1]]) {
      const arm = -0.5 * l.hip;
      const shoulder = [0, 0.19 * side, z + 0.47];
      const elbow = [shoulder[0] + 0.29 * Math.sin(arm), 0.21 * side, shoulder[2] - 0.29 * Math.cos(arm)];
      const wrist = [elbow[0] + 0.26 * Math.sin(arm + 0.3), 0.22 * side, elbow[2] - 0.26 * Math.cos(arm + 0.3)];
      put(`${s}ASI`, 0.1, 0.12 * side, z + 0.08);
      put(`${s}PSI`, -0.12, 0.05 * side, z + 0.09);
      put(`${s}FHD`, 0.09, 0.07 * side, z + 0.78);
      put(`${s}BHD`, -0.09, 0.07 * side, z + 0.77);
      put(`${s}SHO`, 0, 0.17 * side, z + 0.51);
      put(`${s}ELB`, elbow[0], elbow[1] + 0.04 * side, elbow[2]);
      put(`${s}WRA`, wrist[0] + 0.03, wrist[1], wrist[2]);
      put(`${s}WRB`, wrist[0] - 0.03, wrist[1], wrist[2]);
      put(`${s}FIN`, wrist[0] + 0.02, wrist[1] + 0.01 * side, wrist[2] - 0.08);
      put(`${s}THI`, l.k[0] / 2, 0.17 * side, z + l.k[1] / 2);
      put(`${s}KNE`, l.k[0], 0.15 * side, z + l.k[1]);
      put(`${s}SHN`, (l.k[0] + l.a[0]) / 2, 0.14 * side, z + (l.k[1] + l.a[1]) / 2);
      put(`${s}ANK`, l.a[0], 0.14 * side, z + l.a[1]);
      put(`${s}HEE`, l.a[0] - 0.06, 0.1 * side, z + l.a[1] - 0.05);
      put(`${s}TOE`, l.a[0] + 0.16, 0.1 * side, z + l.a[1] - 0.05);
    }
    put('C7', -0.08, 0, z + 0.56);
    put('T10', -0.13, 0, z + 0.32);
    put('CLAV', 0.08, 0, z + 0.49);
    put('STRN', 0.12, 0, z + 0.32);
    if (t >= 0.8 && t < 1) at.RKNE = null;
    if (f === 150) at.LWRA[2] += 0.4;
    labels = Object.keys(at);
    rows.push([t.toFixed(4), ...labels.map((name) => (at[name] ? at[name].map((v) => v.toFixed(5)).join(',') : ',,'))].join(','));
  }
  return `# markers of walker\n# rate: ${rate}\n# up: z\ntime[s],${labels.map((name) => ['x', 'y', 'z'].map((axis) => `${name}.${axis}[m]`).join(',')).join(',')}\n${rows.join('\n')}\n`;
}

export const recording_journeys = [
  {
    name: 'recording: a damaged C3D recording is repaired by its import, plays as a human, and is retargeted to the dog',
    async run({ page, service }) {
      await set_mode(page, 'Edit');
      await page.keyboard.press('Escape');
      const before = await text_of(page);
      const dog_body = JSON.parse(before).characters.find((c) => /dog/i.test(c.name)).mechanism;
      writeFileSync(join(service.folder, 'walker.csv'), walking_markers());
      const made = service.run(['convert', 'walker.csv', 'walker.c3d']);
      assert.equal(made.status, 0, made.stderr);
      await page.locator('.library input[type=file]').setInputFiles([{ name: 'walker.c3d', mimeType: 'application/octet-stream', buffer: readFileSync(join(service.folder, 'walker.c3d')) }]);
      const dialog = page.getByRole('dialog', { name: 'Import' });
      await dialog.waitFor();
      const [file] = await until(page, async () => ((await hook(page, 'imports()'))[0]?.status === 'ready' ? hook(page, 'imports()') : null), 'the recording to be read', 120000);
      await until(page, () => page.evaluate(() => window.ugoki.import_view()?.pictures > 2), 'the preview');
      await page.screenshot({ path: `${pictures}c3d-import.png` });
      const report = Object.values(file.report).flat().join('\n');
      assert.equal(file.anatomy.plan, 'human', report);
      assert.match(report, /1 spike was removed/, report);
      assert.match(report, /2[01] positions in short gaps were filled/, report);
      assert.match(report, /worst marker is LWRA/, report);
      await page.getByRole('button', { name: 'Store in the library' }).click();
      await dialog.waitFor({ state: 'detached', timeout: 60000 });

      // the person
      const count = JSON.parse(before).characters.length;
      await page.getByRole('radio', { name: 'Motions' }).click();
      await page.getByRole('searchbox', { name: 'Search the library' }).fill('walker');
      await card(page, 'walker').dblclick();
      const person = await until(page, async () => (await document_of(page)).characters[count], 'the person');
      await page.getByRole('searchbox', { name: 'Search the library' }).fill('');
      await page.getByRole('radio', { name: 'All' }).click();
      assert.equal(person.track.length, 1);
      assert.ok(Math.abs(person.track[0].length - 2.39) < 0.1, `the whole recording: ${person.track[0].length} s`);

      // the dog
      await page.locator(`[data-clip="${person.track[0].id}"]`).click({ button: 'right', position: { x: 30, y: 8 } });
      await page.getByRole('menu', { name: 'Operations on the clip' }).getByRole('menuitem', { name: 'For another body…' }).click();
      const body = page.getByRole('dialog', { name: 'For another body' });
      await body.getByRole('radio', { name: /^Dog/ }).first().click();
      await body.getByRole('button', { name: 'Make character' }).click();
      const dog = await until(page, async () => (await document_of(page)).characters[count + 1], 'the dog', 120000);
      assert.equal(dog.mechanism, dog_body);
      assert.equal(dog.track.length, 1);
      await until(page, async () => (await hook(page, `character(${JSON.stringify(dog.id)})`)) !== null, 'the dog in the frames');
      await blur(page);
      await page.keyboard.press('Shift+ArrowLeft');
      const place = async () => (await hook(page, `character(${JSON.stringify(dog.id)})`)).com;
      await until(page, async () => (await hook(page, 'frame()')).time < 1e-6, 'the start');
      const start = await place();
      assert.ok(start[2] > 0.25 && start[2] < 0.8, `the dog stands: its centre of mass is at ${start[2].toFixed(2)} m`);
      for (let i = 0; i < 60; i++) await page.keyboard.press('ArrowRight');
      await until(page, async () => (await hook(page, 'frame()')).time > 0.99, 'the frame at 1 s');
      const end = await place();
      const way = Math.hypot(end[0] - start[0], end[1] - start[1]);
      assert.ok(way > 0.2 && way < 1.5, `in 1 s the dog walked ${way.toFixed(2)} m`);
      assert.ok(Math.abs(end[2] - start[2]) < 0.15, 'it stays on its feet');
      await page.keyboard.press('f');
      await page.waitForTimeout(900);
      await page.screenshot({ path: `${pictures}c3d-dog.png` });
      await undo_to(page, before);
    },
  },
].map((journey) => ({ ...journey, skip }));
