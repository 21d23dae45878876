// Journeys (end-to-end tests) through library, imports, distances and contacts. Each starts with the page as the previous journey left it.
// All names begin with "library" or "collision".
import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { mock } from './service.mjs';

const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const skip = mock && 'the mock service has no library';
const patience = 120000; // time limit, ms; enough for a busy machine

/** Repeats `ask` until its result is truthy, and returns it. */
async function until(page, ask, description, timeout = patience) {
  const end = Date.now() + timeout;
  let now;
  for (;;) {
    now = await ask();
    if (now) return now;
    if (Date.now() > end) throw new Error(`waited ${timeout / 1000} s in vain for: ${description}; the page has ${JSON.stringify(await page.evaluate(() => [window.ugoki.library(), window.ugoki.imports()])).slice(0, 700)}`);
    await page.waitForTimeout(80);
  }
}
const library_state = (page) => page.evaluate(() => window.ugoki.library());
/** Number of entries once it no longer changes: the undo of the previous journey may still be running. */
async function settled_total(page) {
  for (let before = -1; ; await page.waitForTimeout(600)) {
    const { total } = await library_state(page);
    if (total === before) return total;
    before = total;
  }
}
const files = (page) => page.evaluate(() => window.ugoki.imports());
const card = (page, name) => page.locator('#library-list [role=option]', { has: page.locator('.entry-name', { hasText: name }) }).first();

/** A BVH file of a person who swings the legs. @param unit units per metre; @param z_up the file's up axis is Z instead of Y */
export function leg_swing_bvh({ unit = 100, z_up = false, frames = 60 } = {}) {
  const at = (x, y, z) => (z_up ? [z, x, y] : [x, y, z]).map((v) => (v * unit).toFixed(4)).join(' '); // from axes Y up, Z forward, X left
  const swing = z_up ? 'Y' : 'X';
  const rest = ['X', 'Y', 'Z'].filter((a) => a !== swing);
  const channels = `CHANNELS 3 ${swing}rotation ${rest[0]}rotation ${rest[1]}rotation`;
  const chain = (names, offsets, end) => (names.length === 0 ? `End Site\n{\nOFFSET ${end}\n}\n` : `JOINT ${names[0]}\n{\nOFFSET ${offsets[0]}\n${channels}\n${chain(names.slice(1), offsets.slice(1), end)}}\n`);
  const leg = (side, s) => chain([`${side}UpLeg`, `${side}Leg`, `${side}Foot`], [at(0.1 * s, -0.05, 0), at(0, -0.42, 0), at(0, -0.42, 0)], at(0, -0.07, 0.16));
  const arm = (side, s) => chain([`${side}Arm`, `${side}ForeArm`, `${side}Hand`], [at(0.2 * s, 0.24, 0), at(0.28 * s, 0, 0), at(0.26 * s, 0, 0)], at(0.18 * s, 0, 0));
  const trunk = `JOINT Spine\n{\nOFFSET ${at(0, 0.12, 0)}\n${channels}\n${chain(['Neck', 'Head'], [at(0, 0.36, 0), at(0, 0.1, 0.01)], at(0, 0.18, 0))}${arm('Left', 1)}${arm('Right', -1)}}\n`;
  const text = `HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition ${swing}rotation ${rest[0]}rotation ${rest[1]}rotation\n${leg('Left', 1)}${leg('Right', -1)}${trunk}}\n`;
  const rows = [];
  for (let f = 0; f < frames; f++) {
    const a = 25 * Math.sin((2 * Math.PI * f) / 30);
    const joint = (v) => `${v.toFixed(3)} 0 0`;
    const legs = [joint(a), joint(20), joint(-10), joint(-a), joint(20), joint(-10)];
    rows.push([at(0, 0.96, 0), joint(0), ...legs, ...Array.from({ length: 9 }, () => joint(0))].join(' '));
  }
  return Buffer.from(`${text}MOTION\nFrames: ${frames}\nFrame Time: 0.0333333\n${rows.join('\n')}\n`);
}

async function choose(page, list) {
  await page.locator('.library input[type=file]').setInputFiles(list.map(([name, buffer]) => ({ name, mimeType: 'application/octet-stream', buffer })));
  await page.getByRole('dialog', { name: 'Import' }).waitFor({ timeout: patience });
}
const all_read = (page) => until(page, async () => (await files(page)).every((f) => f.status === 'ready' || f.status === 'refused'), 'all files to be read');
const import_closed = (page) => page.getByRole('dialog', { name: 'Import' }).waitFor({ state: 'detached', timeout: patience });

const journeys = [
  {
    name: 'library: a file is previewed next to a 1.8 m human with a report, and cancelling stores nothing',
    async run({ page }) {
      await until(page, async () => (await library_state(page)).status === 'ready', 'the list');
      const before = await settled_total(page);
      await choose(page, [['waver.bvh', leg_swing_bvh()]]);
      await all_read(page);
      const seen = await until(page, () => page.evaluate(() => (window.ugoki.import_view()?.pictures > 2 ? window.ugoki.import_view() : null)), 'the preview');
      assert.ok(Math.abs(seen.reference - 1.8) < 0.03, `the reference human is ${seen.reference} m high`);
      assert.ok(seen.character > 1.55 && seen.character < 2, `the character is ${seen.character} m high`);
      const [file] = await files(page);
      assert.equal(file.settings.unit, 0.01);
      assert.ok(file.report.read.some((l) => /60 frames at 30 Hz, 1\.97 s/.test(l)), file.report.read.join());
      assert.ok(file.report.read.some((l) => /joints: Hips/.test(l)) && file.report.guessed.length > 0);
      await until(page, async () => (await page.evaluate(() => window.ugoki.import_view().time)) !== seen.time, 'the character to move');
      await page.screenshot({ path: `${pictures}import.png` });
      await page.keyboard.press('Escape');
      await import_closed(page);
      await page.waitForTimeout(400);
      assert.equal((await library_state(page)).total, before);
    },
  },
  {
    name: 'library: the up axis is guessed, a lying character is reported, and corrected up axis, unit and frame rate are applied',
    async run({ page }) {
      await choose(page, [['lying.bvh', leg_swing_bvh({ z_up: true })]]);
      await all_read(page);
      assert.equal((await files(page))[0].settings.up, 'z'); // the up axis was guessed from the posture
      await page.getByLabel('Up axis').selectOption('y');
      await page.locator('.import-check', { hasText: 'another axis points up' }).waitFor({ timeout: patience });
      await page.screenshot({ path: `${pictures}import-lying.png` });
      await page.getByLabel('Up axis').selectOption('z');
      const height = () => page.evaluate(() => window.ugoki.import_view()?.character ?? 0);
      await until(page, async () => (await files(page))[0].settings.up === 'z' && !(await files(page))[0].rereading && (await height()) > 1.55, 'the character to stand upright');
      assert.ok(!(await files(page))[0].report.check.some((l) => /another axis/.test(l)));
      await page.getByLabel('Unit of length').selectOption('0.001');
      await until(page, async () => !(await files(page))[0].rereading && (await height()) < 0.25 && (await height()) > 0.1, 'a tenth of its height');
      assert.ok((await files(page))[0].report.check.some((l) => /unit of length/.test(l)));
      await page.getByLabel('Unit of length').selectOption('0.01');
      await until(page, async () => !(await files(page))[0].rereading && (await height()) > 1.5, 'the original height');
      await page.locator('.import').getByRole('textbox', { name: 'Frame rate' }).fill('60');
      await page.keyboard.press('Enter');
      await until(page, async () => !(await files(page))[0].rereading && (await files(page))[0].settings.rate === 60, 'the rate');
      await page.locator('.import').getByLabel('Name', { exact: true }).fill('Standing waver');
      await page.locator('.import').getByLabel('Tags', { exact: true }).fill('test, legs');
      await page.getByRole('button', { name: 'Store in the library' }).click();
      await import_closed(page);
      await until(page, async () => (await library_state(page)).names.filter((n) => n === 'Standing waver').length === 2, 'body and motion in the list');
    },
  },
  {
    name: 'library: the import colours the limbs, shows their confidence, and a joint, the plan and a mapping file can be changed by mouse',
    async run({ page }) {
      await choose(page, [['waver.bvh', leg_swing_bvh()]]);
      await all_read(page);
      const anatomy = async () => (await files(page))[0].anatomy;
      const ready = async () => !(await files(page))[0].rereading;
      const found = await anatomy();
      assert.equal(found.plan, 'human');
      assert.deepEqual(found.limbs.map((l) => l.limb).sort(), ['head', 'left arm', 'left leg', 'right arm', 'right leg']);
      assert.ok(found.limbs.every((l) => l.confidence > 0 && l.confidence <= 1 && l.links.length > 0), JSON.stringify(found.limbs));
      assert.deepEqual(found.limbs.find((l) => l.limb === 'left leg').sections.map((s) => s.joint), ['LeftUpLeg', 'LeftLeg', 'LeftFoot', '']);
      await until(page, () => page.evaluate(() => window.ugoki.import_view()?.pictures > 2), 'the preview');
      const colors = () => page.evaluate(() => window.ugoki.import_view().colors);
      const before = await colors();
      assert.ok(new Set(before.filter(Boolean)).size >= 5, `colours of the limbs: ${before}`);
      await page.screenshot({ path: `${pictures}import-anatomy.png` });
      // A click on the limb in the list opens its joints; the other limbs lose their colour.
      await page.locator('.limb', { hasText: 'left leg' }).click();
      await until(page, async () => new Set((await colors()).filter(Boolean)).size === 2, 'one coloured limb');
      await page.screenshot({ path: `${pictures}import-limb.png` });
      const hand = page.getByLabel('Joint of left leg, foot');
      await hand.selectOption('');
      await until(page, async () => ((await ready()) && (await page.locator('.import-check.bad').count()) > 0), 'the refusal of a leg without foot');
      assert.match(await page.locator('.import-check.bad').textContent(), /without thigh, shank or foot/);
      // The body plan.
      await page.getByLabel('Body plan').selectOption('other');
      await until(page, async () => (await ready()) && (await anatomy()).plan === 'other', 'the other plan');
      await page.getByRole('button', { name: 'As recognised' }).click();
      await until(page, async () => (await ready()) && (await anatomy()).plan === 'human', 'the recognised plan');
      // A mapping file exchanges left and right.
      const swapped = { format: 'ugoki anatomy mapping', version: 1, limbs: ['left', 'right'].map((side) => ({ limb: `${side} leg`, sections: [['thigh', 'UpLeg'], ['shank', 'Leg'], ['foot', 'Foot']].map(([section, joint]) => ({ section, joint: `${side === 'left' ? 'Right' : 'Left'}${joint}` })) })) };
      await page.locator('.mapping-buttons input[type=file]').setInputFiles([{ name: 'swapped.json', mimeType: 'application/json', buffer: Buffer.from(JSON.stringify(swapped)) }]);
      await until(page, async () => (await ready()) && (await anatomy()).limbs.find((l) => l.limb === 'left leg').sections[0].joint === 'RightUpLeg', 'the exchanged legs');
      await page.keyboard.press('Escape');
      await import_closed(page);
    },
  },
  {
    name: 'library: of several files a damaged one is refused with location, reason and remedy',
    async run({ page }) {
      const before = (await library_state(page)).total;
      await choose(page, [['one.bvh', leg_swing_bvh({ frames: 40 })], ['broken.bvh', Buffer.from('HIERARCHY\nROOT Hips\n{\n  OFFSET 0 0\n')], ['two.bvh', leg_swing_bvh({ frames: 50 })]]);
      await all_read(page);
      assert.deepEqual((await files(page)).map((f) => f.status), ['ready', 'refused', 'ready']);
      await page.locator('.import-file', { hasText: 'broken.bvh' }).click();
      const refusal = page.locator('.import-refused');
      await refusal.waitFor();
      assert.match(await refusal.locator('code').first().textContent(), /broken\.bvh/);
      assert.ok((await refusal.locator('.remedy').first().textContent()).length > 8);
      await page.screenshot({ path: `${pictures}import-refused.png` });
      await page.getByRole('button', { name: 'Store all 2' }).click();
      await until(page, async () => (await files(page)).filter((f) => f.status === 'stored').length === 2, 'both to be stored');
      await page.getByRole('button', { name: 'Close', exact: true }).click();
      await import_closed(page);
      await until(page, async () => (await library_state(page)).total >= before + 3, 'the new entries'); // both motions may share one mechanism
      assert.ok(!(await library_state(page)).names.includes('broken'));
    },
  },
  {
    name: 'library: entries have pictures, and a motion plays under the pointer',
    async run({ page }) {
      await page.getByRole('searchbox', { name: 'Search the library' }).fill('standing');
      await until(page, async () => (await library_state(page)).names.every((n) => n === 'Standing waver') && (await library_state(page)).total === 2, 'the search');
      await until(page, async () => (await page.locator('#library-list .thumb img').count()) === 2, 'two pictures');
      await page.getByRole('radio', { name: 'Motions' }).click();
      await until(page, async () => (await library_state(page)).total === 1, 'only the motion');
      await card(page, 'Standing waver').hover();
      const time = () => page.locator('canvas.moves').first().getAttribute('data-time', { timeout: 500 }).catch(() => null);
      const first = await until(page, time, 'the playing picture');
      await until(page, async () => (await time()) !== first, 'the motion to continue');
      await page.screenshot({ path: `${pictures}library-moving.png` });
      await page.mouse.move(700, 300);
      const [id] = (await library_state(page)).ids;
      await until(page, () => page.evaluate(async (i) => (await fetch(`api/thumbnail/${i}`, { headers: { Authorization: `Bearer ${sessionStorage.getItem('ugoki_token')}` } })).ok, id), 'the picture to be stored');
    },
  },
  {
    name: 'library: rename, tag, duplicate and delete with the keyboard, with undo',
    async run({ page }) {
      await page.locator('#library-list').focus();
      await page.keyboard.press('Home');
      await page.keyboard.press('F2');
      await page.locator('.entry-rename').waitFor();
      await page.keyboard.type('Leg waver');
      await page.keyboard.press('Enter');
      await page.getByRole('searchbox', { name: 'Search the library' }).fill('waver');
      await until(page, async () => (await library_state(page)).names.includes('Leg waver'), 'the new name');
      await page.locator('#library-list').focus();
      await page.keyboard.press('Control+z');
      await until(page, async () => !(await library_state(page)).names.includes('Leg waver'), 'the old name');
      await card(page, 'Standing waver').click();
      const tag = page.getByRole('textbox', { name: 'Add a tag' }).or(page.getByRole('combobox', { name: 'Add a tag' }));
      await tag.fill('by hand');
      await page.keyboard.press('Enter');
      await page.locator('.library-tags .tag', { hasText: 'by hand' }).waitFor({ timeout: patience });
      const count = (await library_state(page)).total;
      await page.locator('#library-list').focus();
      await page.keyboard.press('Control+d');
      await until(page, async () => (await library_state(page)).total === count + 1, 'the copy');
      await page.locator('#library-list').focus();
      await page.keyboard.press('Delete');
      await until(page, async () => (await library_state(page)).total === count, 'the copy to be deleted');
      await page.getByRole('button', { name: 'Undo', exact: true }).last().click();
      await until(page, async () => (await library_state(page)).total === count + 1, 'the copy to be restored');
      await page.locator('.library-tags .tag', { hasText: 'by hand' }).click();
      await until(page, async () => (await library_state(page)).total === 2, 'the entries with the tag');
      await page.locator('.library-tags .tag', { hasText: 'by hand' }).click();
      await page.screenshot({ path: `${pictures}library-details.png` });
    },
  },
  {
    name: 'library: a conflicting change of the same entry is reported, and both versions are kept',
    async run({ page }) {
      await card(page, 'Standing waver').click();
      let once = true;
      await page.route('**/api/entry/*', async (route) => {
        if (once && route.request().method() === 'POST') {
          once = false;
          const body = JSON.parse(route.request().postData());
          const { authorization } = route.request().headers();
          await page.request.post(route.request().url(), { headers: { authorization }, data: { base: body.base, name: 'Their name' } });
        }
        await route.continue();
      });
      await page.locator('#library-list').focus();
      await page.keyboard.press('F2');
      await page.locator('.entry-rename').fill('My name');
      await page.keyboard.press('Enter');
      const question = page.getByRole('alertdialog');
      await question.waitFor({ timeout: patience });
      assert.match(await question.textContent(), /saved version \d+ of “Their name” while you were changing it/);
      await page.screenshot({ path: `${pictures}library-conflict.png` });
      await question.getByRole('button', { name: /Save the name “My name” as newest/ }).click();
      await page.unroute('**/api/entry/*');
      await page.getByRole('searchbox', { name: 'Search the library' }).fill('my name');
      await until(page, async () => (await library_state(page)).names[0] === 'My name', 'my name');
      await card(page, 'My name').click();
      await page.locator('.versions li', { hasText: 'Their name' }).waitFor({ timeout: patience });
      await page.locator('.versions li', { hasText: 'Standing waver' }).first().getByRole('button', { name: 'Restore' }).click();
      await page.getByRole('searchbox', { name: 'Search the library' }).fill('');
      await until(page, async () => !(await library_state(page)).names.includes('My name'), 'the restored version');
    },
  },
  {
    name: 'library: dragging an entry onto the floor adds a character',
    async run({ page }) {
      await page.getByRole('radio', { name: 'Mechanisms' }).click();
      await until(page, async () => (await library_state(page)).names.every((n) => n !== 'Walk, relaxed'), 'only mechanisms');
      const before = await page.evaluate(() => window.ugoki.document().characters.length);
      const floor = await page.locator('.viewport').boundingBox();
      await card(page, 'Standing waver').dragTo(page.locator('.viewport > canvas'), { targetPosition: { x: floor.width * 0.7, y: floor.height * 0.8 } });
      await until(page, () => page.evaluate((n) => window.ugoki.document().characters.length === n + 1, before), 'the new character');
      await page.keyboard.press('Control+z');
      await until(page, () => page.evaluate((n) => window.ugoki.document().characters.length === n, before), 'the character to be removed');
      await page.getByRole('radio', { name: 'All' }).click();
    },
  },
  {
    name: 'collision: a key shows lines between closest points with their distances',
    async run({ page }) {
      await page.locator('.viewport > canvas').focus();
      await page.keyboard.press('n');
      const pairs = await until(page, () => page.evaluate(() => (window.ugoki.closest_pairs().length > 0 ? window.ugoki.closest_pairs() : null)), 'the pairs');
      assert.ok(pairs.every((p, i) => p.a !== p.b && p.distance <= 3 && (i === 0 || p.distance >= pairs[i - 1].distance)), JSON.stringify(pairs));
      await until(page, async () => /^\d+(\.\d+)? (mm|m)/.test(await page.locator('.distance').first().textContent()), 'the label with the distance');
      await page.screenshot({ path: `${pictures}distances.png` });
      await page.keyboard.press('n');
      await until(page, () => page.evaluate(() => window.ugoki.closest_pairs().length === 0), 'the lines to be hidden');
    },
  },
  {
    name: 'collision: touches are logged, and contacts have unit normals',
    async run({ page }) {
      await page.getByRole('radio', { name: 'Simulate' }).click();
      await until(page, () => page.evaluate(() => window.ugoki.transport().mode === 'simulate'), 'the mode');
      await page.getByRole('button', { name: 'Play' }).click();
      await until(page, () => page.evaluate(() => window.ugoki.log().find((l) => /touched .*N s in/.test(l))), 'a touch in the log', 240000);
      await page.getByRole('button', { name: 'Pause' }).click();
      const normals = await page.evaluate(() => window.ugoki.normals());
      assert.ok(normals.every((n) => Math.abs(Math.hypot(...n) - 1) < 1e-5), JSON.stringify(normals));
      await page.locator('.tab', { hasText: 'Log' }).click();
      await page.screenshot({ path: `${pictures}touches.png` });
      await page.locator('.tab', { hasText: 'Scenario' }).click();
      await page.getByRole('radio', { name: 'Edit' }).click();
    },
  },
];

export const library_journeys = journeys.map((journey) => ({ ...journey, skip }));
