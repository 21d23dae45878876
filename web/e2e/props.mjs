// A journey: props are added by mouse, changed in the inspector, moved in the viewport, simulated, and undone.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { blur, camera_rests, document_of, set_mode, text_of, toggle_theme, undo_to, until } from './browser.mjs';
import { png, textured_crate } from './made_files.mjs';
import { mock } from './service.mjs';

const skip = mock && 'the mock service makes no props';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const hook = (page, expression) => page.evaluate(`window.ugoki.${expression}`);

/** A box as text of an OBJ file. @param first number of the first vertex */
function box_obj([x0, y0, z0], [x1, y1, z1], first) {
  const corner = (i) => `v ${i & 1 ? x1 : x0} ${i & 2 ? y1 : y0} ${i & 4 ? z1 : z0}`;
  const faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
  return [...Array.from({ length: 8 }, (_, i) => corner(i)), ...faces.map((f) => `f ${f.map((k) => first + k).join(' ')}`)].join('\n');
}

/** A table of 1.2 m x 0.6 m x 0.72 m, Y up: a wooden top on four steel legs. */
export function table_files() {
  const legs = [[-0.55, -0.25], [0.5, -0.25], [-0.55, 0.2], [0.5, 0.2]];
  const text = ['mtllib table.mtl', 'usemtl wood', box_obj([-0.6, 0.68, -0.3], [0.6, 0.72, 0.3], 1), 'usemtl steel', ...legs.map(([x, z], i) => box_obj([x, 0, z], [x + 0.05, 0.68, z + 0.05], 9 + 8 * i))].join('\n');
  const file = (name, content) => ({ name, mimeType: 'application/octet-stream', buffer: Buffer.from(content) });
  return [file('table.obj', text), file('table.mtl', 'newmtl wood\nKd 0.72 0.5 0.3\nnewmtl steel\nKd 0.35 0.38 0.42\n')];
}

/** Adds the table by "+ Prop", "Mesh file…". */
export async function add_table(page, files = table_files()) {
  await page.getByRole('button', { name: '+ Prop' }).click();
  const [chooser] = await Promise.all([page.waitForEvent('filechooser'), page.getByRole('menu', { name: 'Add a prop' }).getByRole('menuitem', { name: 'Mesh file…' }).click()]);
  await chooser.setFiles(files);
}

/** Simulates the content from its start for a second or little more. */
async function simulate_second(page) {
  await set_mode(page, 'Simulate');
  await blur(page);
  await page.keyboard.press('Control+Home');
  await page.keyboard.press('Space');
  await until(page, async () => (await hook(page, 'transport()')).simulated > 1, 'a second of simulation');
  await page.keyboard.press('Space');
}

export const prop_journeys = [
  {
    name: 'mesh props: a table from a file with colours is sized, made to move, a box lies on it; all is undone; a damaged file is refused',
    async run({ page }) {
      await set_mode(page, 'Edit');
      await page.keyboard.press('Escape');
      const before = await text_of(page);
      const dialog = page.getByRole('dialog', { name: 'Import' });
      const props = async () => (await document_of(page)).characters.filter((c) => c.prop);
      const set = async (label, value, done) => {
        const field = page.locator('.inspector').getByLabel(label, { exact: true });
        await field.fill(String(value));
        await field.press('Enter');
        await until(page, done, `${label} = ${value}`);
      };
      // a damaged file
      await add_table(page, [{ name: 'torn.glb', mimeType: 'application/octet-stream', buffer: Buffer.from('glTF torn') }]);
      await dialog.getByText('torn.glb was not imported').waitFor();
      assert.match(await dialog.locator('.problem').first().innerText(), /torn\.glb[\s\S]*Export/);
      await page.keyboard.press('Escape');
      await dialog.waitFor({ state: 'detached' });

      await add_table(page);
      await dialog.getByRole('button', { name: 'Add as a prop' }).waitFor();
      await until(page, async () => (await hook(page, 'import_view()?.pictures ?? 0')) > 2, 'the preview').catch(() => undefined);
      await page.waitForTimeout(600);
      assert.match(await dialog.innerText(), /0\.60 x 1\.20 x 0\.72 m/);
      assert.match(await dialog.innerText(), /assumed to be in metres/);
      await page.screenshot({ path: `${pictures}mesh-import.png` });
      await dialog.getByRole('button', { name: 'Add as a prop' }).click();
      const table = (await until(page, async () => (await props()).find((c) => c.prop.shape === 'mesh'), 'the table')).id;
      const prop = async () => (await props()).find((c) => c.id === table);
      assert.deepEqual((await prop()).shape_colors.length, 2);
      await page.locator('.inspector h3', { hasText: 'Prop' }).waitFor();
      await page.locator('.inspector').getByLabel('Collides as').waitFor();
      await set('X', 3, async () => (await prop()).place.x === 3);
      await set('Y', 2.5, async () => (await prop()).place.y === 2.5);
      await set('Scale', 1.25, async () => (await prop()).prop.scale.every((s) => s === 1.25));
      await page.locator('.inspector').getByLabel('Collides as').selectOption('parts');
      await until(page, async () => (await prop()).prop.collision === 'parts', 'hulls of parts');
      await blur(page);
      await page.keyboard.press('f');
      await camera_rests(page);
      await page.screenshot({ path: `${pictures}mesh-prop.png` });
      await toggle_theme(page);
      await page.screenshot({ path: `${pictures}mesh-prop-light.png` });
      await toggle_theme(page);

      // with a mass: that of wood, and the density that the field shows
      await page.locator('.inspector').getByRole('switch', { name: 'Moves' }).or(page.locator('.inspector').getByLabel('Moves')).first().click();
      const volume = (1.2 * 0.04 * 0.6 + 4 * 0.05 * 0.05 * 0.68) * 1.25 ** 3;
      await until(page, async () => Math.abs((await prop()).prop.mass - 600 * volume) < 0.02, 'the mass of wood');
      await set('Density', 1000, async () => Math.abs((await prop()).prop.mass - 1000 * volume) < 0.01);
      await page.locator('.inspector').getByRole('switch', { name: 'Moves' }).or(page.locator('.inspector').getByLabel('Moves')).first().click();
      await until(page, async () => (await prop()).prop.mass === 0, 'a fixed table');

      // a box above the top comes to rest on it
      await page.getByRole('button', { name: '+ Prop' }).click();
      await page.getByRole('menu', { name: 'Add a prop' }).getByRole('menuitem', { name: 'Box', exact: true }).click();
      const box = (await until(page, async () => (await props()).find((c) => c.prop.shape === 'box'), 'the box')).id;
      const crate = async () => (await props()).find((c) => c.id === box);
      await page.locator('.inspector').getByRole('switch', { name: 'Moves' }).or(page.locator('.inspector').getByLabel('Moves')).first().click();
      await until(page, async () => (await crate()).prop.mass === 10, 'a mass');
      for (const [i, label] of ['Length', 'Width', 'Height'].entries()) await set(label, 0.3, async () => (await crate()).prop.size[i] === 0.3);
      await set('X', 3, async () => (await crate()).place.x === 3);
      await set('Y', 2.5, async () => (await crate()).place.y === 2.5);
      await set('Z', 1.1, async () => (await crate()).place.z === 1.1);
      await simulate_second(page);
      const height = (await hook(page, `character(${JSON.stringify(box)})`)).com[2] - 0.15;
      assert.ok(Math.abs(height - 0.9) < 0.005, `the box lies on the table: its bottom is at ${height} m`);
      await page.screenshot({ path: `${pictures}mesh-prop-simulated.png` });
      await set_mode(page, 'Edit');
      await undo_to(page, before);
    },
  },
  {
    name: 'mesh props: a crate with a texture shows it, falls and turns with it; an OBJ file finds its picture; exports contain textures; all is undone',
    async run({ page, service }) {
      await set_mode(page, 'Edit');
      await page.keyboard.press('Escape');
      const before = await text_of(page);
      const dialog = page.getByRole('dialog', { name: 'Import' });
      const props = async () => (await document_of(page)).characters.filter((c) => c.prop);
      const set = async (label, value, done) => {
        const field = page.locator('.inspector').getByLabel(label, { exact: true });
        await field.fill(String(value));
        await field.press('Enter');
        await until(page, done, `${label} = ${value}`);
      };
      await add_table(page, [{ name: 'crate.glb', mimeType: 'application/octet-stream', buffer: textured_crate() }]);
      await dialog.getByRole('button', { name: 'Add as a prop' }).waitFor();
      await until(page, async () => (await hook(page, 'import_view()?.pictures ?? 0')) > 2, 'the preview').catch(() => undefined);
      await page.waitForTimeout(600);
      assert.match(await dialog.innerText(), /The surface has 1 texture of [\d.]+ KB/);
      await page.screenshot({ path: `${pictures}textured-import.png` });
      await dialog.getByRole('button', { name: 'Add as a prop' }).click();
      const crate = (await until(page, async () => (await props()).find((c) => c.prop.shape === 'mesh'), 'the crate')).id;
      const prop = async () => (await props()).find((c) => c.id === crate);
      await page.locator('.inspector h3', { hasText: 'Prop' }).waitFor();
      await set('X', 1.6, async () => (await prop()).place.x === 1.6);
      await set('Y', 1.4, async () => (await prop()).place.y === 1.4);
      await set('Heading', 25, async () => Math.abs((await prop()).place.heading - 25) < 1e-6);
      assert.match(await page.locator('.inspector').innerText(), /Drawn with the textures of its file/);
      await blur(page);
      await page.keyboard.press('0');
      await page.keyboard.press('f');
      await camera_rests(page);
      const box = await page.locator('.viewport canvas').first().boundingBox();
      const shot = async (name) => {
        await page.waitForTimeout(900);
        return page.screenshot({ path: `${pictures}${name}.png`, clip: box });
      };
      const textured = await shot('textured-prop');
      await page.getByRole('tab', { name: 'Look', exact: true }).click();
      const shown = page.getByRole('group', { name: 'Shown' });
      await page.getByText('Drawn with the textures of its file').waitFor(); // and no colour without effect
      await shown.getByRole('button', { name: 'Colours' }).click();
      await until(page, async () => (await prop()).shown === 'body', 'the colours');
      assert.notEqual(Buffer.compare(await shot('textured-prop-colours'), textured), 0, 'the colours give the same picture as the textures');
      await shown.getByRole('button', { name: 'Textures' }).click();
      await until(page, async () => ((await prop()).shown ?? 'skin') === 'skin', 'the textures');
      await page.screenshot({ path: `${pictures}textured-look.png` });
      await page.getByRole('tab', { name: 'Inspector', exact: true }).click();

      // scaled unevenly, tilted, with a mass: it falls on its edge and turns over
      await set('Scale X', 1.4, async () => (await prop()).prop.scale[0] === 1.4);
      await set('Tilt Y', 30, async () => (await prop()).prop.tilt?.[1] === 30);
      await set('Z', 0.9, async () => (await prop()).place.z === 0.9);
      await page.locator('.inspector').getByRole('switch', { name: 'Moves' }).or(page.locator('.inspector').getByLabel('Moves')).first().click();
      await until(page, async () => (await prop()).prop.mass > 0, 'a mass');
      await shot('textured-prop-tilted');
      await simulate_second(page);
      await shot('textured-prop-simulated');
      await set_mode(page, 'Edit');

      // an OBJ file beside its materials and its picture
      const obj = ['mtllib sign.mtl', 'usemtl paint', 'v -0.4 0 0', 'v 0.4 0 0', 'v 0.4 0.8 0', 'v -0.4 0.8 0', 'v -0.4 0 -0.03', 'v 0.4 0 -0.03', 'v 0.4 0.8 -0.03', 'v -0.4 0.8 -0.03', 'vt 0 0', 'vt 1 0', 'vt 1 1', 'vt 0 1',
        'f 1/1 2/2 3/3 4/4', 'f 6/1 5/2 8/3 7/4', 'f 2/1 6/1 7/1 3/1', 'f 5/1 1/1 4/1 8/1', 'f 4/1 3/1 7/1 8/1', 'f 5/1 6/1 2/1 1/1'].join('\n');
      const picture = png(64, 64, (x, y) => { const r = Math.hypot(x - 31.5, y - 31.5); return r > 29 ? [240, 240, 240] : r > 20 ? [200, 40, 40] : Math.abs(y - 31.5) < 5 ? [30, 30, 30] : [246, 246, 246]; });
      const file = (name, content) => ({ name, mimeType: 'application/octet-stream', buffer: Buffer.from(content) });
      await add_table(page, [file('sign.obj', obj), file('sign.mtl', 'newmtl paint\nKd 0.8 0.8 0.8\nmap_Kd maps/sign.png\n'), file('sign.png', picture)]);
      await dialog.getByRole('button', { name: 'Add as a prop' }).waitFor();
      assert.match(await dialog.innerText(), /The surface has 1 texture/);
      await dialog.getByRole('button', { name: 'Add as a prop' }).click();
      const sign = (await until(page, async () => (await props()).find((c) => c.id !== crate && c.prop.shape === 'mesh'), 'the sign')).id;
      await page.locator('.inspector h3', { hasText: 'Prop' }).waitFor();
      await page.waitForTimeout(500);
      await blur(page);
      await page.keyboard.press('f');
      await camera_rests(page);
      await shot('textured-sign');
      assert.ok(sign);

      // executable data and glTF contain the pictures
      await page.keyboard.press('Control+s');
      const out = join(service.folder, 'textures');
      await until(page, () => {
        const baked = service.run(['export', join(service.folder, 'sample.ugoki'), '--ugx', `${out}.ugx`, '--glb', `${out}.glb`]);
        if (baked.status !== 0) throw new Error(baked.stderr + baked.stdout);
        const scene = readFileSync(`${out}.glb`);
        const length = scene.readUInt32LE(12);
        const { images = [] } = JSON.parse(scene.subarray(20, 20 + length).toString());
        return images.length >= 2 && readFileSync(`${out}.ugx`).includes('image/png');
      }, 'exports with both textures');
      await undo_to(page, before);
    },
  },
  {
    name: 'props: hills of a terrain are sized and reseeded; a character inside them is placed on them; a box lies on them; all is undone',
    async run({ page }) {
      await set_mode(page, 'Edit');
      await page.keyboard.press('Escape');
      const before = await text_of(page);
      const props = async () => (await document_of(page)).characters.filter((c) => c.prop);
      const set = async (label, value, done) => {
        const field = page.locator('.inspector').getByLabel(label, { exact: true });
        await field.fill(String(value));
        await field.press('Enter');
        await until(page, done, `${label} = ${value}`);
      };
      const add = async (kind) => {
        const known = (await props()).map((c) => c.id);
        await page.getByRole('button', { name: '+ Prop' }).click();
        await page.getByRole('menu', { name: 'Add a prop' }).getByRole('menuitem', { name: kind, exact: true }).click();
        const made = await until(page, async () => (await props()).find((c) => !known.includes(c.id)), `the ${kind}`);
        await page.locator('.inspector h3', { hasText: `Prop ${kind}` }).waitFor();
        return made.id;
      };
      const terrain = await add('Terrain');
      const prop = async () => (await props()).find((c) => c.id === terrain).prop;
      const place = async () => (await props()).find((c) => c.id === terrain).place;
      await set('Height', 0.5, async () => (await prop()).size[2] === 0.5);
      await set('Grain', 1.5, async () => (await prop()).grain === 1.5);
      await set('Seed', 7, async () => (await prop()).seed === 7);
      await set('X', 3, async () => (await place()).x === 3);
      await set('Y', 0, async () => (await place()).y === 0);
      assert.equal(await page.locator('.inspector').getByLabel('Moves').count(), 0, 'a terrain does not move');

      // the human stands in the hills; both inspectors report it, and one click places it on them
      const human = async () => (await document_of(page)).characters.find((c) => c.id === 'human');
      const notes = page.locator('.inspector .ground-notes');
      await notes.getByText(/Human is \d+ cm inside Terrain/).waitFor();
      await page.locator('[data-character="human"] .track-name').click();
      await page.locator('.inspector h3', { hasText: 'Character Human' }).waitFor();
      // the note is renewed with the pictures: it is read when it stays
      let read = '';
      await until(page, async () => {
        const before = read;
        await page.waitForTimeout(700);
        read = await notes.innerText();
        return read === before;
      }, 'the note stays');
      const depth = Number(read.match(/Human is (\d+) cm inside Terrain/)[1]) / 100;
      assert.ok(depth > 0.03 && depth <= 0.5, `the human is ${depth} m inside`);
      await notes.getByRole('button', { name: 'Place on the ground' }).click();
      await until(page, async () => Math.abs((await human()).place.z - depth) < 0.006, `the human ${depth} m higher`);
      await notes.waitFor({ state: 'detached' });
      await page.locator(`[data-character="${terrain}"] .track-name`).click();
      await page.locator('.inspector h3', { hasText: 'Prop Terrain' }).waitFor();
      await blur(page);
      await page.keyboard.press('0');
      await page.keyboard.press('f');
      await camera_rests(page);
      await page.screenshot({ path: `${pictures}terrain.png` });
      await toggle_theme(page);
      await page.screenshot({ path: `${pictures}terrain-light.png` });
      await toggle_theme(page);
      const ball = await add('Box');
      await page.locator('.inspector').getByRole('switch', { name: 'Moves' }).or(page.locator('.inspector').getByLabel('Moves')).first().click();
      for (const [i, label] of ['Length', 'Width', 'Height'].entries()) await set(label, 0.3, async () => (await props()).find((c) => c.id === ball).prop.size[i] === 0.3);
      await set('X', 3.2, async () => (await props()).find((c) => c.id === ball).place.x === 3.2);
      await set('Y', 0.3, async () => (await props()).find((c) => c.id === ball).place.y === 0.3);
      await set('Z', 0.9, async () => (await props()).find((c) => c.id === ball).place.z === 0.9);
      await simulate_second(page);
      const { com } = await hook(page, `character(${JSON.stringify(ball)})`);
      assert.ok(com[2] > 0.16 && com[2] < 0.75, `the box lies on a hill: its centre is at ${com[2]} m`);
      await page.screenshot({ path: `${pictures}terrain-simulated.png` });
      await set_mode(page, 'Edit');
      await undo_to(page, before);
    },
  },
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
      await camera_rests(page);
      await page.screenshot({ path: `${pictures}props.png` });

      // a drag in the viewport moves the ramp over the floor
      const from = (await prop(ramp)).place;
      await blur(page);
      await page.keyboard.press('Control+Home');
      await until(page, async () => (await hook(page, 'frame()')).time < 1e-6, 'the start');
      await page.keyboard.press('a'); // the ramp is in view
      await camera_rests(page);
      const at = await hook(page, `to_screen([${from.x}, ${from.y}, 0.2])`);
      await page.mouse.click(at.x, at.y);
      await until(page, async () => (await page.locator('.inspector h3').textContent()).includes('Ramp'), 'the selected ramp');
      await page.mouse.move(at.x, at.y);
      await page.mouse.down();
      await page.mouse.move(at.x + 60, at.y + 4, { steps: 6 });
      await page.mouse.up();
      await until(page, async () => { const { place } = await prop(ramp); return Math.hypot(place.x - from.x, place.y - from.y) > 0.1; }, 'the moved ramp');

      await simulate_second(page);
      const height = (await hook(page, `character(${JSON.stringify(crate)})`)).com[2] - 0.25;
      assert.ok(Math.abs(height - 0.8) < 0.005, `the crate lies on the highest step: its bottom is at ${height} m`);
      await page.screenshot({ path: `${pictures}props-simulated.png` });
      await set_mode(page, 'Edit');
      await undo_to(page, before);
    },
  },
].map((journey) => ({ ...journey, skip }));
