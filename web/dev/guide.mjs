// Makes the pictures of docs/guide (docs/guide/images/NAME.webp): shows every panel of the studio with the sample content.
// Run after `npm run build`, with the program `ugoki` in UGOKI_BIN: node dev/guide.mjs [names]
import { mkdirSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { launch, ready } from '../e2e/browser.mjs';
import { leg_swing_bvh } from '../e2e/library.mjs';
import { add_table } from '../e2e/props.mjs';
import { textured_crate } from '../e2e/made_files.mjs';
import { skinned_person } from '../e2e/skinned_file.mjs';
import { start_service } from '../e2e/service.mjs';

const wanted = process.argv.slice(2);
const folder = fileURLToPath(new URL('../../docs/guide/images/', import.meta.url));
const window_size = { width: 1280, height: 800 };
const picture_width = 1000; // px, of a picture of the whole page; a panel keeps its size
mkdirSync(folder, { recursive: true });

const service = await start_service();
const browser = await launch();
const page = await browser.newPage({ viewport: window_size });

/** Stores a picture of an element of a page, or of the whole page, as WebP. */
async function picture(name, selector, from = page) {
  if (wanted.length > 0 && !wanted.includes(name)) return;
  await page.waitForTimeout(600);
  const png = await (selector ? from.locator(selector).first() : from).screenshot();
  const webp = await page.evaluate(
    async ([data, limit]) => {
      const bitmap = await createImageBitmap(new Blob([Uint8Array.from(atob(data), (c) => c.charCodeAt(0))], { type: 'image/png' }));
      const width = Math.min(bitmap.width, limit);
      const height = Math.round((bitmap.height * width) / bitmap.width);
      const canvas = new OffscreenCanvas(width, height);
      const context = canvas.getContext('2d');
      context.imageSmoothingQuality = 'high';
      context.drawImage(bitmap, 0, 0, width, height);
      const bytes = new Uint8Array(await (await canvas.convertToBlob({ type: 'image/webp', quality: 0.82 })).arrayBuffer());
      let text = '';
      for (let i = 0; i < bytes.length; i += 4096) text += String.fromCharCode(...bytes.subarray(i, i + 4096));
      return btoa(text);
    },
    [png.toString('base64'), picture_width],
  );
  const bytes = Buffer.from(webp, 'base64');
  writeFileSync(`${folder}${name}.webp`, bytes);
  console.log(`${name}.webp ${(bytes.length / 1024).toFixed(0)} KB`);
}

const tab = (name) => page.getByRole('tab', { name }).click();
const blur = () => page.evaluate('document.activeElement?.blur?.()');
const mode = async (name) => {
  await page.getByRole('radio', { name }).click();
  await page.waitForFunction((m) => window.ugoki.transport().mode === m, name.toLowerCase());
};
/** Moves the playhead forward by frames, and waits until it is there. */
const forward = async (frames) => {
  const start = await page.evaluate('window.ugoki.transport().time');
  for (let i = 0; i < frames; i++) await page.keyboard.press('ArrowRight');
  await page.waitForFunction((end) => Math.abs(window.ugoki.frame().time - end) < 0.005, start + frames / 60, { timeout: 60000 });
};
/** Undoes commands while `left()` is true in the page. */
const undo_while = async (left) => {
  for (let i = 0; i < 40 && (await page.evaluate(left)); i++) {
    const before = await page.evaluate('window.ugoki.undo().revision');
    await page.keyboard.press('Control+z');
    await page.waitForFunction((r) => window.ugoki.undo().revision !== r, before);
  }
};
const posed = () => page.waitForFunction(() => window.ugoki.posing()?.ready);

try {
  await page.addInitScript(() => localStorage.setItem('ugoki.tour', 'done'));
  await page.goto(service.address, { timeout: 60000 });
  await ready(page);
  await page.keyboard.press('a');
  await page.waitForTimeout(1500);
  await page.waitForFunction(() => [...document.querySelectorAll('#library-list [role=option]')].every((entry) => entry.querySelector('img')), undefined, { timeout: 60000 }).catch(() => undefined);
  await picture('studio');
  await picture('library', '.library');
  await picture('timeline', '.scenario');

  // props, and without them again
  if (wanted.length === 0 || wanted.includes('props')) {
    const revision = () => page.evaluate('window.ugoki.undo().revision');
    const prop = async (kind, fields) => {
      await page.getByRole('button', { name: '+ Prop' }).click();
      await page.getByRole('menuitem', { name: kind, exact: true }).click();
      await page.locator('.inspector h3', { hasText: `Prop ${kind}` }).waitFor();
      for (const [label, value] of Object.entries(fields)) {
        const field = page.locator('.inspector').getByLabel(label, { exact: true });
        if (value === true) await field.click();
        else await field.fill(String(value)).then(() => field.press('Enter'));
        await page.waitForTimeout(400);
      }
    };
    await prop('Ramp', { Length: 2.4, Width: 1.2, Height: 0.35, X: 3, Y: -1.3, Heading: 180 });
    await prop('Box', { Moves: true, Length: 0.4, Width: 0.4, Height: 0.4, X: 1.07, Y: 1.7, Z: 0.75, Heading: 20 });
    await prop('Stairs', { Width: 1.4, X: 0.5, Y: 1.7 });
    await blur();
    await page.keyboard.press('a');
    await page.waitForTimeout(2500);
    await picture('props');
    for (let i = 0; i < 60 && (await page.evaluate('window.ugoki.undo().can_undo')) && (await page.evaluate('window.ugoki.document().characters.some((c) => c.prop)')); i++) {
      const before = await revision();
      await page.keyboard.press('Control+z');
      await page.waitForFunction((r) => window.ugoki.undo().revision !== r, before);
    }
    await page.keyboard.press('a');
    await page.waitForTimeout(1000);
  }

  // a nested scenario, three times, and without it again
  if (wanted.length === 0 || wanted.includes('nested')) {
    const tracks = page.locator('.track[data-character] .track-name');
    await tracks.nth(0).click();
    await tracks.nth(1).click({ modifiers: ['Control'] });
    await blur();
    await page.keyboard.press('Shift+N');
    await page.locator('.clip.nested').waitFor();
    for (const [start, y] of [[1, -2.5], [2, 3]]) {
      await blur();
      const count = await page.locator('.clip.nested').count();
      await page.keyboard.press('Control+d');
      await page.waitForFunction((n) => document.querySelectorAll('.clip.nested').length > n, count);
      for (const [label, value] of [['Start', start], ['Y', y]]) await page.locator('.inspector').getByLabel(label, { exact: true }).fill(String(value)).then(() => page.keyboard.press('Enter')).then(() => page.waitForTimeout(400));
    }
    await blur();
    await page.keyboard.press('Home');
    await page.keyboard.press('a');
    await page.waitForTimeout(2500);
    await picture('nested');
    await undo_while('window.ugoki.document().scenarios !== undefined');
    await page.keyboard.press('a');
    await page.waitForTimeout(1000);
  }

  if (wanted.length === 0 || wanted.includes('terrain')) {
    await page.getByRole('button', { name: '+ Prop' }).click();
    await page.getByRole('menuitem', { name: 'Terrain', exact: true }).click();
    await page.locator('.inspector h3', { hasText: 'Prop Terrain' }).waitFor();
    for (const [label, value] of [['Height', 0.5], ['Seed', 7], ['X', 1.5], ['Y', 0]]) await page.locator('.inspector').getByLabel(label, { exact: true }).fill(String(value)).then(() => page.keyboard.press('Enter')).then(() => page.waitForTimeout(400));
    await page.getByRole('button', { name: 'Place on the ground' }).click();
    await page.waitForFunction(() => window.ugoki.document().characters[0].place.z > 0);
    await blur();
    await page.keyboard.press('f');
    await page.waitForTimeout(2500);
    await page.mouse.move(640, 300);
    for (let i = 0; i < 3; i++) await page.mouse.wheel(0, -120);
    await page.waitForTimeout(2500);
    await page.mouse.move(640, 20); // no link is under the pointer
    await picture('terrain');
    await undo_while("window.ugoki.document().characters.some((c) => c.prop || c.place.z > 0.2)");
    await page.keyboard.press('a');
    await page.waitForTimeout(1000);
  }

  if (wanted.length === 0 || wanted.includes('mesh-prop')) {
    await add_table(page);
    await page.getByRole('button', { name: 'Add as a prop' }).click();
    await page.locator('.inspector').getByLabel('Collides as').selectOption('parts');
    await page.waitForTimeout(500);
    for (const [label, value] of [['X', 1.2], ['Y', 1.5], ['Heading', 30]]) await page.locator('.inspector').getByLabel(label, { exact: true }).fill(String(value)).then(() => page.keyboard.press('Enter')).then(() => page.waitForTimeout(400));
    await blur();
    await page.keyboard.press('f');
    await page.waitForTimeout(2500);
    await picture('mesh-prop');
    while (await page.evaluate('window.ugoki.document().characters.some((c) => c.prop)')) {
      await page.keyboard.press('Control+z');
      await page.waitForTimeout(300);
    }
    await page.keyboard.press('a');
    await page.waitForTimeout(1000);
  }

  if (wanted.length === 0 || wanted.includes('textured-prop')) {
    await add_table(page, [{ name: 'crate.glb', mimeType: 'application/octet-stream', buffer: textured_crate() }]);
    await page.getByRole('button', { name: 'Add as a prop' }).click();
    await page.locator('.inspector').getByLabel('Collides as').waitFor();
    for (const [label, value] of [['X', 1.2], ['Y', 1.5], ['Heading', 25]]) await page.locator('.inspector').getByLabel(label, { exact: true }).fill(String(value)).then(() => page.keyboard.press('Enter')).then(() => page.waitForTimeout(400));
    await page.getByRole('tab', { name: 'Look', exact: true }).click();
    await page.getByLabel('Pattern').selectOption('boards');
    await blur();
    await page.keyboard.press('f');
    await page.waitForTimeout(2500);
    await picture('textured-prop');
    while (await page.evaluate('window.ugoki.document().characters.some((c) => c.prop)')) {
      await page.keyboard.press('Control+z');
      await page.waitForTimeout(300);
    }
    await page.getByRole('tab', { name: 'Inspector', exact: true }).click();
    await page.keyboard.press('a');
    await page.waitForTimeout(1000);
  }

  if (wanted.length === 0 || wanted.includes('skin')) {
    const revision = await page.evaluate('window.ugoki.undo().revision');
    await page.locator('.library input[type=file]').setInputFiles([{ name: 'stripes.glb', mimeType: 'application/octet-stream', buffer: skinned_person() }]);
    await page.waitForFunction(() => window.ugoki.imports().some((f) => f.status === 'ready'), undefined, { timeout: 120000 });
    await page.getByRole('button', { name: 'Store in the library' }).click();
    await page.getByRole('button', { name: 'Add a new character with this motion' }).click();
    await page.waitForFunction((r) => window.ugoki.undo().revision > r, revision);
    await page.getByRole('tab', { name: 'Look' }).click();
    await blur();
    await page.keyboard.press('f');
    await page.waitForTimeout(2500);
    await picture('skin');
    await page.getByRole('tab', { name: 'Inspector' }).click();
    await page.keyboard.press('Control+z');
    await page.waitForFunction(() => window.ugoki.document().characters.length === 3);
    await page.keyboard.press('a');
    await page.waitForTimeout(1000);
  }

  // a selected character, posing, stored poses, curves
  await page.locator('[data-character="human"] .track-name').click();
  await picture('inspector', '.inspector');
  await blur();
  await forward(30);
  await page.keyboard.press('3');
  await page.keyboard.press('f');
  await page.keyboard.press('e');
  await posed();
  await page.waitForTimeout(900);
  for (const [name, frames] of [['Contact', 0], ['Mid stance', 14], ['Stride', 16]]) {
    await blur();
    await forward(frames);
    await posed();
    await tab('Poses');
    await page.getByRole('button', { name: 'Store pose', exact: true }).click();
    await page.getByRole('textbox', { name: 'Name of the pose' }).fill(name);
    await page.keyboard.press('Enter');
    await page.getByRole('option', { name }).waitFor();
    await page.waitForTimeout(500); // the card takes the focus
  }
  await page.getByRole('option', { name: 'Contact' }).click();
  await picture('poses', '.poses');
  await page.getByRole('button', { name: 'Apply', exact: true }).click();
  await page.waitForFunction(() => window.ugoki.undo().undo_label === 'Apply pose Contact');
  const arm = await page.evaluate("window.ugoki.link_on_screen('human', window.ugoki.link_index('human', 'forearm right'))");
  await page.mouse.click(arm.x, arm.y);
  await picture('posing');
  await tab('Curves');
  await picture('curves', '.curves');
  await blur();
  await page.keyboard.press('e');

  await tab('Library');

  // look, a gait
  await tab('Scenario');
  await page.locator('[data-character="human"] .track-name').click();
  await page.getByRole('tab', { name: 'Look' }).click();
  await picture('look', '.look-panel');
  await page.getByRole('tab', { name: 'Inspector' }).click();
  await tab('Scenario');
  await page.locator('[data-character="human"] .track-name').click();
  await page.getByRole('button', { name: 'Add gait', exact: true }).click();
  await page.locator('.gait-fields[aria-busy="false"]').waitFor({ timeout: 120000 });
  await picture('gait', '.inspector');
  await blur();
  await page.keyboard.press('Control+z');
  await page.waitForTimeout(800);

  // rules
  await tab('Rules');
  await page.getByRole('button', { name: 'While a key is held, play…' }).click();
  await page.locator('.rule').waitFor();
  await picture('rules', '.rules');
  await page.getByRole('button', { name: '+ Rule' }).click();
  await page.getByRole('menuitem', { name: 'When something touches, count…' }).click();
  await page.locator('.rule').nth(1).waitFor();
  await picture('variables', '.rules');
  await blur();
  await undo_while("(window.ugoki.document().rules ?? []).length > 0 || window.ugoki.document().characters.some((c) => c.track.some((k) => (k.layers ?? []).length > 0))"); // the simulation shows the plain walk

  // the circuit, in a higher panel
  await tab('Circuit');
  await page.locator('.circuit[role=application]').waitFor();
  const panel = await page.locator('.circuit[role=application]').boundingBox();
  const edge = panel.y - 34; // px: the upper edge of the panel, above its tabs
  const drag_edge = async (from, to) => {
    await page.mouse.move(640, from);
    await page.mouse.down();
    await page.mouse.move(640, to, { steps: 8 });
    await page.mouse.up();
    await page.waitForTimeout(800);
  };
  await drag_edge(edge, 200);
  await page.getByRole('button', { name: 'Fit', exact: true }).last().click();
  await page.waitForTimeout(1500);
  await picture('circuit', '.circuit[role=application]');
  const raised = (await page.locator('.circuit[role=application]').boundingBox()).y - 34;
  await drag_edge(raised, edge);

  // simulation, naturalness
  await tab('Scenario');
  await mode('Simulate');
  await page.locator('.transport').getByRole('button', { name: 'Play' }).click();
  await page.waitForFunction(() => window.ugoki.transport().simulated > 3, undefined, { timeout: 240000 });
  await page.locator('.transport').getByRole('button', { name: 'Pause' }).click();
  await page.locator('[data-character="human"] .track-name').click();
  await picture('simulate');
  await tab('Naturalness');
  await picture('naturalness', '.naturalness');
  await tab('Plots');
  for (const side of ['left', 'right']) {
    const joints = page.getByRole('combobox', { name: 'Add a joint' });
    const value = await joints.locator('option').evaluateAll((options, wanted) => options.find((o) => o.textContent.toLowerCase().includes(`shank ${wanted}`) || o.textContent.toLowerCase().includes(`${wanted}leg`))?.value, side);
    await joints.selectOption(value);
  }
  await picture('plots', '.plots');
  await tab('Log');
  await picture('log', '.log, .panel.empty');
  await tab('Scenario');
  await mode('Edit');

  if (wanted.length === 0 || wanted.includes('cameras')) {
    await page.locator('.viewport canvas').first().hover();
    const through = page.locator('select', { has: page.locator('option[value=free]') }).first();
    for (const [key, time] of [['3', 0], ['1', 60]]) {
      await forward(time);
      await page.keyboard.press(key);
      await page.keyboard.press('f');
      await page.waitForTimeout(1200);
      await through.selectOption('new');
      await page.locator('.film-frame').waitFor();
      await blur();
    }
    await page.keyboard.press('x');
    await page.mouse.move(640, 20); // no link is under the pointer
    await page.waitForTimeout(800);
    await picture('cameras');
    await through.selectOption('free');
  }

  // dialogs
  await page.getByRole('button', { name: 'Export', exact: true }).click();
  await picture('export', '.menu');
  await page.keyboard.press('Escape');
  await page.keyboard.press('Control+k');
  await picture('commands', '.palette');
  await page.getByLabel('Search commands').fill('change keys');
  await page.keyboard.press('Enter');
  const keys = page.getByRole('dialog', { name: 'Change keys' });
  await keys.getByLabel('Search commands').fill('theme');
  await page.locator('.key-editor-row[data-command="page.theme"]').getByRole('button', { name: /^Add a key/ }).click();
  await page.keyboard.press('r'); // the key of another command
  await keys.getByText('Add a rule for the selected character').waitFor();
  await picture('keys', '[role=dialog]');
  await page.keyboard.press('Escape');
  await page.keyboard.press('Escape');
  await keys.waitFor({ state: 'detached' });
  service.run(['bake', 'sample.ugoki', '--vary', 'push=0:300:3', '--vary', 'push-angle=0,90', '--vary', 'push-time=0.05', '--duration', '0.3', '--table', 'push.db']);
  await page.keyboard.press('Control+k');
  await page.getByLabel('Search commands').fill('results of a sweep');
  await page.keyboard.press('Enter');
  await page.getByRole('dialog', { name: 'Results of sweeps' }).getByRole('img').waitFor();
  await picture('sweep', '[role=dialog]');
  await page.keyboard.press('Escape');
  await page.locator('button.project').click();
  await page.getByRole('menuitem', { name: 'New project…' }).click();
  await picture('gallery', '.gallery');
  await page.keyboard.press('Escape');
  await page.locator('.library input[type=file]').setInputFiles([{ name: 'waver.bvh', mimeType: 'application/octet-stream', buffer: leg_swing_bvh() }]);
  await page.waitForFunction(() => window.ugoki.imports().some((f) => f.status === 'ready'), undefined, { timeout: 120000 });
  await page.waitForTimeout(1500);
  await picture('import', '[role=dialog]');

  if (wanted.length === 0 || wanted.includes('correction')) await correct_capture();
} finally {
  await browser.close();
  await service.stop();
}

/** A capture with noise, sliding feet and a tilted floor is made physical; the motion before is a ghost. */
async function correct_capture() {
  const measured = await start_service(fileURLToPath(new URL('../../examples/content/natural.json', import.meta.url)));
  try {
    const view = await browser.newPage({ viewport: window_size });
    await view.addInitScript(() => localStorage.setItem('ugoki.tour', 'done'));
    await view.goto(measured.address, { timeout: 60000 });
    await ready(view);
    await view.locator('[data-character="measured"] .clip').first().click({ position: { x: 20, y: 8 } });
    await view.locator('.inspector').getByRole('button', { name: 'Correct the physics…' }).click();
    await view.getByRole('dialog', { name: 'Correct the physics' }).getByRole('button', { name: 'Apply' }).click();
    await view.getByRole('group', { name: 'Physics correction' }).waitFor({ timeout: 240000 });
    await view.locator('.toast').first().waitFor({ state: 'detached', timeout: 60000 }).catch(() => undefined);
    await view.evaluate('document.activeElement?.blur?.()');
    for (let frame = 0; frame < 75; frame++) await view.keyboard.press('ArrowRight');
    await view.keyboard.press('3');
    await view.keyboard.press('f');
    await view.waitForTimeout(2500);
    await picture('correction', '.viewport', view);
  } finally {
    await measured.stop();
  }
}
