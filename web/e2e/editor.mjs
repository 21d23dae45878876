// Journeys (end-to-end tests) for the scenario editor, the naturalness panel, projects, and pictures of the viewport.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { document_of, painted, set_mode, toggle_theme, undo_to, until } from './browser.mjs';
import { resize } from './windows.mjs';
import { mock } from './service.mjs';

const skip = mock && 'the mock service has no simulation and one project';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));

const hook = (page, expression) => page.evaluate(`window.ugoki.${expression}`);
const document_becomes = (page, fits, description) => until(page, async () => fits(await document_of(page)), description);
const focus_scenario = (page) => page.locator('.ruler').focus();
const undo = async (page, label) => {
  await until(page, async () => (await hook(page, 'undo()')).undo_label === label, `the undo of “${label}”`);
  await focus_scenario(page);
  await page.keyboard.press('Control+z');
};
/** Moves the playhead to `time` (s) by the ruler and the frame keys, so that it is exact. */
async function seek(page, time) {
  await page.keyboard.press('Home');
  await page.keyboard.press('Control+Home');
  await until(page, async () => (await hook(page, 'transport()')).time === 0, 'the start');
  const box = await page.locator('.ruler').boundingBox();
  const { duration, frame_rate } = await document_of(page);
  const scale = (Math.max(box.width, 80) - 32) / Math.max(duration, 0.5);
  let x = box.x + 12 + time * scale;
  for (const flag of await page.locator('.marker').all()) { // a click on a marker would select it
    const at = await flag.boundingBox();
    if (Math.abs(x - at.x - at.width / 2) < 10) x = at.x - 8;
  }
  await page.mouse.click(x, box.y + box.height / 2);
  await focus_scenario(page);
  const frame = Math.round(time * frame_rate);
  /** Number of the shown frame once playhead and picture agree: events of earlier seeks may arrive late. */
  const settled = () => until(page, async () => {
    const at = Math.round((await hook(page, 'transport()')).time * frame_rate);
    await page.waitForTimeout(120);
    return at === Math.round((await hook(page, 'transport()')).time * frame_rate) && at === Math.round((await hook(page, 'frame()')).time * frame_rate) && { at };
  }, 'the frame at the playhead');
  for (let i = 0; i < 60; i++) {
    const { at } = await settled();
    if (at === frame) return;
    await page.keyboard.press(at < frame ? '.' : ',');
    await until(page, async () => Math.round((await hook(page, 'transport()')).time * frame_rate) !== at, 'the next frame');
  }
  throw new Error(`the playhead does not reach ${time} s`);
}
const picture_of = async (page, name) => {
  for (const [width, height] of [[1440, 900], [1280, 720]]) {
    await resize(page, [width, height]);
    await page.screenshot({ path: `${pictures}${name}-${width}.png` });
  }
  await resize(page, [1440, 900]);
};

/**
 * Creates contents of the gallery, simulates each for a moment, and opens the first project again.
 * @param wanted whether the i-th content is created
 */
async function create_contents({ page }, wanted) {
  const name = () => page.locator('.project-name').textContent();
  const first = await name();
  const before = await document_of(page);
  const ids = [];
  await page.keyboard.press('Control+k');
  await page.keyboard.type('new project');
  await page.keyboard.press('Enter');
  for (const [i, card] of (await page.locator('.gallery-card').all()).entries()) if (wanted(i)) ids.push(await card.getAttribute('data-entry'));
  await painted(page);
  await picture_of(page, 'gallery-dark');
  await page.keyboard.press('Escape');
  await toggle_theme(page);
  for (const [i, id] of ids.entries()) {
    await page.locator('button.project').click();
    await page.getByRole('menuitem', { name: 'New project…' }).click();
    await page.locator(`[data-entry="${id}"]`).click();
    if (i === 1) await picture_of(page, 'gallery-light');
    await page.getByRole('button', { name: 'Create' }).click();
    await page.locator('.gallery').waitFor({ state: 'detached', timeout: 60000 });
    await until(page, async () => (await name()) === `${id === 'empty' ? 'untitled' : id}.ugoki`, `the project ${id}`);
    await until(page, async () => (await hook(page, 'frame()')) !== null, `a frame of ${id}`);
    if (id === 'empty') continue;
    const { characters, instances = [] } = await document_of(page);
    assert.ok(characters.length + instances.length > 0, id);
    await set_mode(page, 'Simulate');
    await page.keyboard.press('Space');
    await until(page, async () => (await hook(page, 'transport()')).simulated > (id === 'band' ? 0.01 : 0.1), `the simulation of ${id}`, 180000);
    await page.getByRole('button', { name: 'Pause' }).click();
    assert.equal(await page.locator('.banner').count(), 0, `${id} runs`);
  }
  await toggle_theme(page);
  await page.keyboard.press('Control+o');
  await page.getByRole('dialog', { name: 'Open project' }).waitFor();
  await page.screenshot({ path: `${pictures}open.png` });
  await page.locator('#open-path').fill('nothing there');
  await page.keyboard.press('Enter');
  const missing = page.locator('.toast.error', { hasText: 'nothing there' });
  await missing.getByRole('button', { name: 'Dismiss' }).click();
  await missing.waitFor({ state: 'detached' });
  const recent = await hook(page, 'recent()');
  for (const id of ids) assert.ok(recent.some((path) => path.endsWith(`/${id === 'empty' ? 'untitled' : id}.ugoki`)), `${id} is a recent project: ${recent}`);
  await page.locator('.open-project li button', { hasText: `/${first}` }).click();
  await until(page, async () => (await name()) === first, 'the first project');
  assert.deepEqual(await document_of(page), before);
  await until(page, async () => (await hook(page, 'frame()')) !== null, 'a frame');
  assert.equal((await hook(page, 'transport()')).mode, 'edit');
}

export const editor_journeys = [
  {
    name: 'editor: several clips and events are selected, moved, duplicated and deleted, each as one command',
    async run({ page }) {
      await set_mode(page, 'Edit');
      await page.getByRole('tab', { name: 'Scenario' }).click();
      const before = await document_of(page);
      const human = before.characters.find((c) => c.track.length > 0);
      const track = (doc) => doc.characters.find((c) => c.id === human.id).track;
      const clip = (id) => page.locator(`[data-clip="${id}"]`);
      // three clips: split at 6 s and 12 s
      for (const time of [6, 12]) {
        await seek(page, time);
        const at = track(await document_of(page)).find((k) => k.start < time && k.start + k.length > time);
        await clip(at.id).click({ position: { x: 60, y: 12 } });
        await page.keyboard.press('s');
        await document_becomes(page, (d) => track(d).some((k) => Math.abs(k.start - time) < 1e-6), `the split at ${time} s`);
      }
      const [first, second, third] = track(await document_of(page));
      const event = before.events[0];
      const selected = () => hook(page, 'selection()');

      // Shift + click adds and removes
      await clip(second.id).click({ position: { x: 60, y: 12 } });
      await clip(third.id).click({ position: { x: 60, y: 12 }, modifiers: ['Shift'] });
      assert.deepEqual((await selected()).items.map((i) => i.clip), [second.id, third.id]);
      await clip(first.id).click({ position: { x: 60, y: 12 }, modifiers: ['Control'] });
      await clip(first.id).click({ position: { x: 60, y: 12 }, modifiers: ['Control'] });
      assert.equal((await selected()).items.length, 2);
      assert.match(await page.locator('.inspector h3').textContent(), /2 clips/);

      // a drag of one moves both
      const box = await clip(second.id).boundingBox();
      await page.mouse.move(box.x + 60, box.y + 12);
      await page.mouse.down();
      await page.mouse.move(box.x + 90, box.y + 12, { steps: 4 });
      await page.mouse.move(box.x + 130, box.y + 12, { steps: 4 });
      await page.mouse.up();
      await document_becomes(page, (d) => track(d)[1].start > 6.2, 'the later clips');
      const moved = track(await document_of(page));
      const shift = moved[1].start - second.start;
      assert.ok(Math.abs(moved[2].start - third.start - shift) < 1e-6, 'both moved by the same time');
      assert.equal(moved[0].start, first.start);
      await undo(page, 'Move 2 clips');
      await document_becomes(page, (d) => track(d)[1].start === second.start && track(d)[2].start === third.start, 'one undo for both');

      // a rectangle selects what it touches: the last clip of the first track, and everything of the tracks below
      const lane = await page.locator(`[data-character="${human.id}"] .lane`).boundingBox();
      const end = await clip(third.id).boundingBox();
      await page.mouse.move(lane.x + lane.width - 4, lane.y + 3);
      await page.mouse.down();
      await page.mouse.move(end.x + end.width - 20, lane.y + 20, { steps: 5 });
      await page.locator('.marquee').waitFor();
      await page.screenshot({ path: `${pictures}marquee.png` });
      await page.mouse.up();
      assert.deepEqual(await selected(), { kind: 'clip', character: human.id, clip: third.id });
      await page.locator(`[data-event="${event.id}"]`).click({ modifiers: ['Control'] });
      assert.deepEqual((await selected()).items.map((i) => i.kind), ['clip', 'event']);
      await picture_of(page, 'several-dark');
      await toggle_theme(page);
      await picture_of(page, 'several-light');
      await toggle_theme(page);

      // duplicate and delete
      await focus_scenario(page);
      await page.keyboard.press('Control+d');
      await document_becomes(page, (d) => track(d).length === 4 && d.events.length === before.events.length + 1 && d.duration >= before.duration, 'the copies');
      assert.equal((await selected()).items.length, 2, 'the copies are selected');
      await page.keyboard.press('Delete');
      await document_becomes(page, (d) => track(d).length === 3 && d.events.length === before.events.length, 'the copies to be removed');
      await undo(page, 'Remove 1 clip, 1 event');
      await undo(page, 'Duplicate 1 clip, 1 event');
      await document_becomes(page, (d) => track(d).length === 3 && d.duration === before.duration, 'the document before the copies');
      await focus_scenario(page);
      await page.keyboard.press('Control+a');
      assert.equal((await selected()).items.length, before.characters.reduce((n, c) => n + c.track.length, 0) + 2 + before.events.length);
      await page.keyboard.press('Control+z');
      await page.keyboard.press('Control+z');
      await document_becomes(page, (d) => JSON.stringify(d) === JSON.stringify(before), 'the document as before');
    },
  },
  {
    name: 'editor: markers, in and out, and looped playing',
    async run({ page }) {
      await set_mode(page, 'Edit');
      const before = await document_of(page);
      await seek(page, 2);
      await page.keyboard.press('m');
      const { markers } = await document_becomes(page, (d) => d.markers?.length === 1 && d, 'the marker');
      assert.equal(markers[0].time, 2);
      const field = page.locator('.inspector').getByLabel('Name');
      await field.fill('Jump');
      await field.press('Enter');
      await document_becomes(page, (d) => d.markers[0].name === 'Jump', 'the name');
      const flag = page.locator('.marker');
      const box = await flag.boundingBox();
      await page.mouse.move(box.x + 4, box.y + 6);
      await page.mouse.down();
      await page.mouse.move(box.x + 40, box.y + 6, { steps: 5 });
      await page.mouse.up();
      await document_becomes(page, (d) => d.markers[0].time > 2.3, 'the later marker');
      const { time } = (await document_of(page)).markers[0];
      await page.keyboard.press('Control+Home');
      await focus_scenario(page);
      await page.keyboard.press('PageDown');
      await until(page, async () => Math.abs((await hook(page, 'transport()')).time - time) < 1e-3, 'the playhead at the marker');

      await seek(page, 3);
      await page.keyboard.press('i');
      await seek(page, 3.5);
      await page.keyboard.press('Shift+I');
      await document_becomes(page, (d) => d.range?.from === 3 && d.range.to === 3.5, 'in and out').catch(async () => assert.fail(JSON.stringify([(await document_of(page)).range, await hook(page, 'transport()')])));
      await page.getByRole('button', { name: 'Loop between in and out' }).click();
      await until(page, async () => (await hook(page, 'transport()')).loop, 'the loop');
      for (const mode of ['Edit', 'Simulate']) {
        await set_mode(page, mode);
        if (mode === 'Simulate') await seek(page, 3.2);
        await page.keyboard.press('Space');
        let last = 0;
        let returned = false;
        await until(page, async () => {
          const frame = await hook(page, 'frame()');
          if (frame.playing) {
            returned ||= frame.time < last - 0.1;
            last = frame.time;
          }
          return returned && frame.time > 3.1;
        }, `playing to return to the in point in ${mode}`);
        assert.ok(last < 3.52, `${last} s is not after the out point`);
        await page.getByRole('button', { name: 'Pause' }).click();
        await until(page, async () => !(await hook(page, 'transport()')).playing, 'the pause');
      }
      await picture_of(page, 'markers-dark');
      await toggle_theme(page);
      await picture_of(page, 'markers-light');
      await toggle_theme(page);
      await page.getByRole('button', { name: 'Loop between in and out' }).click();
      await set_mode(page, 'Edit');
      await flag.click({ position: { x: 3, y: 5 } });
      await page.keyboard.press('Delete');
      await document_becomes(page, (d) => !d.markers, 'the marker to be removed');
      await focus_scenario(page);
      await undo_to(page, JSON.stringify(before));
      assert.deepEqual(await document_of(page), before);
    },
  },
  {
    name: 'editor: tracks are muted, soloed and locked',
    async run({ page }) {
      await set_mode(page, 'Edit');
      const before = await document_of(page);
      const [first, second] = before.characters.filter((c) => c.track.length > 0);
      const shown = (id) => hook(page, `character('${id}') !== null`);
      const press = (name) => page.getByRole('button', { name }).click();
      await page.locator(`[data-character="${second.id}"]`).hover();
      await press(`M: Mute ${second.name}`);
      await until(page, async () => (await shown(first.id)) && !(await shown(second.id)), 'the muted character to disappear');
      await set_mode(page, 'Simulate');
      await page.keyboard.press('Space');
      await until(page, async () => (await hook(page, 'frame()')).time > 0.1, 'the simulation of the others');
      await press('Pause');
      await set_mode(page, 'Edit');
      await page.screenshot({ path: `${pictures}muted.png` });
      await undo(page, 'Mute track');
      await until(page, () => shown(second.id), 'the character again');
      await page.locator(`[data-character="${second.id}"]`).hover();
      await press(`S: Solo ${second.name}`);
      await until(page, async () => (await shown(second.id)) && !(await shown(first.id)), 'the other characters to disappear');
      await undo(page, 'Solo track');
      await page.locator(`[data-character="${first.id}"]`).hover();
      await press(`L: Lock ${first.name}`);
      await document_becomes(page, (d) => d.characters.find((c) => c.id === first.id).locked, 'the lock');
      const clip = page.locator(`[data-clip="${first.track[0].id}"]`);
      const box = await clip.boundingBox();
      await page.mouse.move(box.x + 80, box.y + 10);
      await page.mouse.down();
      await page.mouse.move(box.x + 160, box.y + 10, { steps: 4 });
      assert.deepEqual(await clip.boundingBox(), box, 'the clip does not move');
      await page.mouse.up();
      await clip.click({ position: { x: 80, y: 10 } });
      await page.keyboard.press('Delete');
      await page.locator('.toast.error', { hasText: 'locked' }).waitFor();
      await page.getByRole('button', { name: 'Dismiss' }).first().click();
      await undo(page, 'Lock track');
      await document_becomes(page, (d) => JSON.stringify(d) === JSON.stringify(before), 'the document as before');
    },
  },
  {
    name: 'naturalness: all measures over time, a click goes to a problem, and the table is exported',
    async run({ page }) {
      const before = await document_of(page);
      const human = before.characters.find((c) => c.track.length > 0);
      await page.getByRole('tab', { name: 'Scenario' }).click();
      await set_mode(page, 'Edit');
      await seek(page, 1);
      await page.locator(`[data-character="${human.id}"] .track-name`).click();
      await page.keyboard.press('Shift+P');
      await document_becomes(page, (d) => d.events.length === before.events.length + 1, 'the push');
      const force = page.locator('.inspector').getByLabel('Force X').or(page.locator('.inspector input[aria-label^="Force"]')).first();
      await force.fill('3000');
      await force.press('Enter');
      await document_becomes(page, (d) => d.events.some((e) => Math.abs(e.force?.[0]) === 3000), 'the force');
      await set_mode(page, 'Simulate');
      await page.getByRole('tab', { name: 'Naturalness' }).click();
      await page.locator('.naturalness, .panel.empty:visible').first().waitFor();
      await page.keyboard.press('Shift+R');
      await page.locator('.transport').getByRole('button', { name: 'Play' }).click();
      await until(page, async () => (await hook(page, 'measures()')).frames > 190, '3 s of measures', 120000);
      await page.getByRole('button', { name: 'Pause' }).click();
      await until(page, async () => !(await hook(page, 'transport()')).playing, 'the pause');
      await page.waitForTimeout(700); // the measures of the last frames
      const { frames, rate, bad } = await hook(page, 'measures()');
      assert.equal(rate, 60);
      assert.ok(bad.some((s) => s.character === human.id && s.measure === 'fell'), `the push makes the character fall: ${JSON.stringify(bad)}`);
      assert.deepEqual(bad.filter((s) => s.measure === 'fell' && s.to < 1), [], 'no fall before the push');
      assert.ok((await page.locator('.naturalness section').first().locator('.nat-row').count()) > 15, 'the measures of ugoki judge');
      await picture_of(page, 'naturalness-dark');
      await toggle_theme(page);
      await picture_of(page, 'naturalness-light');
      await toggle_theme(page);
      const bar = page.locator('.bad-span').first();
      const wanted = bad.find((s) => s.character === human.id);
      await bar.click();
      await until(page, async () => Math.abs((await hook(page, 'transport()')).time - wanted.at) < 0.02, `the playhead at ${wanted.at} s`);
      await page.keyboard.press('Control+Home');
      await until(page, async () => (await hook(page, 'transport()')).time === 0, 'the start');
      await page.keyboard.press('Shift+PageDown');
      const first = Math.min(...bad.map((s) => s.at).filter((t) => t > 0.01));
      await until(page, async () => Math.abs((await hook(page, 'transport()')).time - first) < 0.02, 'the first problem');
      const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Export CSV' }).click()]);
      const rows = readFileSync(await file.path(), 'utf8').trim().split('\r\n');
      assert.equal(rows.length, frames + 1);
      assert.match(rows[0], /^time_s,Human: tracking_deg,Human: root_assist_bw,Human: fell,Human: foot_slip_cm,Human: penetration_mm,/);
      assert.ok(rows.slice(1).every((row) => row.split(',').length === rows[0].split(',').length && row.split(',').every((cell) => Number.isFinite(Number(cell)))));
      assert.ok(rows.at(-1).split(',')[3] === '1', 'the last row reports the fall');
      await page.getByRole('tab', { name: 'Scenario' }).click();
      assert.ok((await page.locator(`[data-character="${human.id}"] .problem-mark`).count()) > 0, 'the timeline marks the problems');
      await set_mode(page, 'Edit');
      await focus_scenario(page);
      await undo_to(page, JSON.stringify(before));
      assert.deepEqual(await document_of(page), before);
    },
  },
  {
    name: 'projects: contents of the gallery are created and simulated, and a recent project is opened again',
    run: (context) => create_contents(context, (i) => i % 4 === 0),
  },
  {
    name: 'projects: the other contents of the gallery are created and simulated',
    slow: true,
    run: (context) => create_contents(context, (i) => i % 4 !== 0),
  },
  {
    name: 'camera: number keys turn the view, and a picture of the viewport is saved',
    async run({ page }) {
      await focus_scenario(page);
      const azimuth = async () => (await hook(page, 'camera()')).azimuth;
      const turned_to = (wanted, description) => until(page, async () => Math.abs(Math.atan2(Math.sin((await azimuth()) - wanted), Math.cos((await azimuth()) - wanted))) < 0.01, description);
      // a project that was just opened turns to its stored view, perhaps after the key
      await until(page, async () => {
        await page.keyboard.press('1');
        await page.waitForTimeout(1000);
        return Math.abs(await azimuth()) < 0.01;
      }, 'the view from the front');
      await page.keyboard.press('9');
      await turned_to(Math.PI, 'the view from the back');
      await page.keyboard.press('4');
      await page.keyboard.press('4');
      await turned_to(Math.PI - Math.PI / 6, '30 degrees to the left');
      await page.keyboard.press('3');
      await turned_to(Math.PI / 2, 'the view from the left');
      const height = (await hook(page, 'camera()')).height;
      await page.keyboard.press('8');
      await until(page, async () => (await hook(page, 'camera()')).height > height + 0.2, 'the view from higher');
      await page.keyboard.press('0');
      const stored = (await document_of(page)).camera;
      await turned_to(stored.azimuth, 'the stored view');
      await until(page, async () => Math.abs((await hook(page, 'camera()')).distance - stored.distance) < 0.01, 'the stored distance');
      const [file] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('F2')]);
      assert.match(file.suggestedFilename(), /\.png$/);
      const png = readFileSync(await file.path());
      const [width, shown_height] = [png.readUInt32BE(16), png.readUInt32BE(20)];
      const box = await page.locator('.viewport > canvas').boundingBox();
      assert.ok(width >= Math.floor(box.width) && Math.abs(width / shown_height - box.width / box.height) < 0.02, `${width} x ${shown_height}`);
      const shades = await page.evaluate(async (data) => {
        const bitmap = await createImageBitmap(new Blob([Uint8Array.from(atob(data), (c) => c.charCodeAt(0))], { type: 'image/png' }));
        const canvas = new OffscreenCanvas(64, 48);
        const context = canvas.getContext('2d');
        context.drawImage(bitmap, 0, 0, 64, 48);
        return new Set(context.getImageData(0, 0, 64, 48).data).size;
      }, png.toString('base64'));
      assert.ok(shades > 20, `the picture shows the scene: ${shades} shades`);
    },
  },
].map((journey) => ({ ...journey, skip }));
