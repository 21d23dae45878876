// Journeys for stored poses, keys on clips, the simulated curve, ripple, order and groups of tracks, and grips.
import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { blur, camera_rests, document_of, painted, rested, set_mode, steady, toggle_theme, undo_to, until } from './browser.mjs';
import { mock } from './service.mjs';

const skip = mock && 'the mock service has no poses';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const hook = (page, expression) => page.evaluate(`window.ugoki.${expression}`);
const label_of = async (page) => (await hook(page, 'undo()')).undo_label;
const human_of = (doc) => doc.characters.find((c) => c.track.length > 0 && /human/i.test(c.name)) ?? doc.characters.find((c) => c.track.length > 0);
const keys_of = (clip) => (clip.layers ?? []).flatMap((l) => l.joints.flatMap((j) => j.keys.map((k) => ({ link: j.link, ...k }))));
/** Switches the posing tool on, whatever the journey before left. */
const pose = async (page) => {
  if (!(await hook(page, 'posing()'))) await page.keyboard.press('e');
};
const select_link = async (page, character, name) => {
  const link = await hook(page, `link_index(${JSON.stringify(character)}, ${JSON.stringify(name)})`);
  assert.ok(link >= 0, `the link ${name}`);
  await until(page, async () => {
    const at = await hook(page, `link_on_screen(${JSON.stringify(character)}, ${link})`); // moves while the camera moves
    await page.mouse.click(at.x, at.y);
    await page.waitForTimeout(100);
    return (await hook(page, 'selection()')).link === link;
  }, `the selected link ${name}`);
  return link;
};

async function both_themes(page, name) {
  await rested(page);
  await page.screenshot({ path: `${pictures}${name}.png` });
  await toggle_theme(page);
  await rested(page);
  await page.screenshot({ path: `${pictures}${name}-light.png` });
  await toggle_theme(page);
}

export const timeline_journeys = [
  {
    name: 'poses: a pose is stored under a name, applied whole, mirrored and in part at another time, and undone',
    async run({ page }) {
      await set_mode(page, 'Edit');
      await page.keyboard.press('Escape');
      const before = await document_of(page);
      const human = human_of(before);
      const clip = async () => (await document_of(page)).characters.find((c) => c.id === human.id).track[0];
      await page.getByRole('tab', { name: 'Poses' }).click();
      await page.locator('.poses-empty').first().waitFor();
      await page.locator(`[data-character="${human.id}"] .track-name`).click();
      await blur(page);
      await page.keyboard.press('Shift+ArrowLeft');
      for (let i = 0; i < 30; i++) await page.keyboard.press('ArrowRight');
      await page.keyboard.press('3');
      await page.keyboard.press('f');
      await camera_rests(page);
      await page.screenshot({ path: `${pictures}poses-empty.png` });

      // two poses of the walk, each named at once
      for (const [name, frames] of [['Step', 0], ['Stride', 22]]) {
        await blur(page);
        for (let i = 0; i < frames; i++) await page.keyboard.press('ArrowRight');
        if (frames) await page.waitForTimeout(400);
        await page.getByRole('button', { name: 'Store pose', exact: true }).click();
        const field = page.getByRole('textbox', { name: 'Name of the pose' });
        await field.waitFor();
        await field.fill(name);
        await field.press('Enter');
        await page.waitForFunction((n) => document.activeElement?.getAttribute('aria-label') === n, name); // the named pose gets the focus
      }
      const poses = await until(page, async () => {
        const { poses: stored } = await document_of(page);
        return stored?.length === 2 && stored[1].name === 'Stride' && stored;
      }, 'two named poses');
      assert.equal(poses[0].name, 'Step');
      assert.ok(poses[0].joints.length > 15, 'all joints');
      await painted(page);

      // the other pose, whole, with auto-key; the place of the character stays
      const step = page.getByRole('option', { name: 'Step' });
      await step.click();
      const hand = await hook(page, `link_index(${JSON.stringify(human.id)}, 'hand right')`);
      const at = await hook(page, `link_position(${JSON.stringify(human.id)}, ${hand})`);
      const root = await hook(page, `link_position(${JSON.stringify(human.id)}, 0)`);
      await page.getByRole('button', { name: 'Apply', exact: true }).click();
      await until(page, async () => keys_of(await clip()).length > 10, 'keys of the applied pose');
      assert.equal(await label_of(page), 'Apply pose Step');
      await until(page, async () => {
        const now = await hook(page, `link_position(${JSON.stringify(human.id)}, ${hand})`);
        return Math.hypot(now[0] - at[0], now[2] - at[2]) > 0.05;
      }, 'the hand moved in the frames of the service');
      const root_now = await hook(page, `link_position(${JSON.stringify(human.id)}, 0)`);
      assert.ok(Math.hypot(root_now[0] - root[0], root_now[1] - root[1]) < 1e-3, 'the character stays where it is');
      await both_themes(page, 'poses');
      await page.keyboard.press('Control+z');
      await until(page, async () => keys_of(await clip()).length === 0, 'one undo removes the keys');

      // only a limb, mirrored, half of it
      await until(page, async () => (await hook(page, 'posing()'))?.ready, 'the pose of the playhead');
      await select_link(page, human.id, 'upper arm left');
      await step.click();
      await page.getByRole('combobox', { name: 'Joints that the pose sets' }).selectOption('limb');
      await page.getByRole('group', { name: 'Poses' }).getByRole('button', { name: 'Mirror' }).click();
      await page.getByRole('slider', { name: 'Share of the pose, percent' }).fill('50');
      await page.screenshot({ path: `${pictures}poses-limb.png` });
      await step.focus();
      await page.keyboard.press('Enter');
      await until(page, async () => keys_of(await clip()).length > 0, 'keys of the arm');
      const links = [...new Set(keys_of(await clip()).map((k) => k.link))];
      assert.ok(links.every((l) => /arm|hand/i.test(l)), `only the arm: ${links}`);

      // marks of the keys on the clip
      await page.getByRole('tab', { name: 'Scenario' }).click();
      await page.locator('.clip .key-marks').first().waitFor();
      await page.screenshot({ path: `${pictures}key-marks.png` });

      // keyboard: the list, rename, remove
      await page.getByRole('tab', { name: 'Poses' }).click();
      await step.focus();
      await page.keyboard.press('ArrowRight');
      await page.keyboard.press('F2');
      await page.getByRole('textbox', { name: 'Name of the pose' }).fill('Long stride');
      await page.keyboard.press('Enter');
      await page.getByRole('option', { name: 'Long stride' }).waitFor();
      await page.getByRole('option', { name: 'Long stride' }).focus();
      await page.keyboard.press('Delete');
      await until(page, async () => (await document_of(page)).poses?.length === 1, 'a removed pose');
      await undo_to(page, JSON.stringify(before));
      await page.keyboard.press('Escape');
      await page.keyboard.press('Escape');
      await page.getByRole('tab', { name: 'Library' }).click();
    },
  },
  {
    name: 'posing without a clip states why not and goes to the clip; in a cross-fade, the posed clip can be chosen',
    async run({ page }) {
      await set_mode(page, 'Edit');
      const before = await document_of(page);
      const human = human_of(before);
      const last = human.track[human.track.length - 1];
      const first = human.track[0];
      await page.locator(`[data-clip="${first.id}"]`).click();
      // a gap at the start, and a second clip that overlaps the first one by 1 s
      await page.getByRole('textbox', { name: 'Start' }).fill('1');
      await page.keyboard.press('Enter');
      await until(page, async () => human_of(await document_of(page)).track.find((k) => k.id === first.id)?.start === 1, 'the gap');
      await page.locator(`[data-character="${human.id}"] .track-name`).click();
      await blur(page);
      await page.keyboard.press('Shift+ArrowLeft');
      await pose(page);
      const note = page.locator('.pose-note');
      await note.getByText('has none here').waitFor();
      await page.screenshot({ path: `${pictures}pose-no-clip.png` });
      await note.getByRole('button', { name: /^Go to/ }).click();
      await until(page, async () => (await hook(page, 'posing()'))?.ready, 'the pose at the start of the clip');
      if (last === first) {
        await page.locator(`[data-clip="${first.id}"]`).click();
        await blur(page);
        await page.keyboard.press('Control+d');
        await until(page, async () => human_of(await document_of(page)).track.length === 2, 'a second clip');
        await page.getByRole('textbox', { name: 'Start' }).fill(String(first.length));
        await page.keyboard.press('Enter');
        await until(page, async () => human_of(await document_of(page)).track[1].start === first.length, 'the place of the second clip');
      }
      const track = human_of(await document_of(page)).track;
      const into = track[1];
      const blend = into.blend > 0 ? into.blend : 0.3;
      if (!(into.blend > 0)) {
        await page.locator(`[data-clip="${into.id}"]`).click();
        await page.getByRole('textbox', { name: 'Blend in' }).fill('0.3');
        await page.keyboard.press('Enter');
        await until(page, async () => human_of(await document_of(page)).track[1].blend === 0.3, 'the blend');
      }
      await page.locator(`[data-character="${human.id}"] .track-name`).click();
      const ruler = page.locator('.ruler');
      await page.getByRole('button', { name: 'Fit', exact: true }).click();
      await steady(page, () => page.locator(`[data-clip="${into.id}"]`).boundingBox(), 'the clip in the timeline');
      const box = await ruler.boundingBox();
      const doc = await document_of(page);
      const scale = (box.width - 32) / doc.duration;
      await page.mouse.click(box.x + 12 + (into.start + blend / 2) * scale, box.y + box.height / 2);
      await note.getByText('Cross-fade').waitFor();
      await until(page, async () => (await hook(page, 'posing()'))?.ready, 'the pose in the cross-fade');
      await rested(page);
      await page.screenshot({ path: `${pictures}pose-cross-fade.png` });
      await note.getByRole('button').click();
      await until(page, async () => (await hook(page, 'selection()')).clip === track[0].id, 'the other clip is posed');
      await until(page, async () => (await hook(page, 'posing()'))?.ready, 'the pose of the other clip');
      await page.keyboard.press('Shift+S');
      await until(page, async () => keys_of(human_of(await document_of(page)).track[0]).length > 0, 'keys in the other clip');
      await undo_to(page, JSON.stringify(before));
      await page.keyboard.press('Escape');
      await page.keyboard.press('Escape');
    },
  },
  {
    name: 'curves: the simulated curve of a joint is beside the keyed one',
    async run({ page }) {
      const before = await document_of(page);
      const human = human_of(before);
      await set_mode(page, 'Simulate');
      await page.keyboard.press('Shift+ArrowLeft');
      await page.keyboard.press('Space');
      await until(page, async () => (await hook(page, 'transport()')).simulated > 1.2, '1.2 s of simulation', 120000);
      await page.keyboard.press('Space');
      await set_mode(page, 'Edit');
      await page.keyboard.press('f');
      await camera_rests(page);
      await page.locator(`[data-character="${human.id}"] .track-name`).click();
      await pose(page);
      await until(page, async () => (await hook(page, 'posing()'))?.ready, 'the pose of the playhead');
      await select_link(page, human.id, 'shank right');
      await page.getByRole('tab', { name: 'Curves' }).click();
      await page.locator('.curves-legend').getByText('simulated', { exact: true }).waitFor();
      await page.locator('.curve-plot canvas').waitFor();
      const drawn = await page.waitForFunction(() => {
        const canvas = document.querySelector('.curve-plot canvas');
        if (canvas.width === 0 || canvas.height === 0) return false; // before the first layout of the panel
        const [r, g, b] = getComputedStyle(canvas).getPropertyValue('--simulated').match(/\w\w/g).map((x) => parseInt(x, 16));
        const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
        let count = 0;
        for (let i = 0; i < data.length; i += 4) if (Math.abs(data[i] - r) + Math.abs(data[i + 1] - g) + Math.abs(data[i + 2] - b) < 60) count++;
        return count > 100 && count;
      });
      assert.ok((await drawn.jsonValue()) > 100, 'the simulated curve is drawn');
      await both_themes(page, 'curves-simulated');
      await page.getByRole('tab', { name: 'Scenario' }).click();
      await page.keyboard.press('Escape');
      await page.keyboard.press('Escape');
      assert.equal(JSON.stringify(await document_of(page)), JSON.stringify(before));
    },
  },
  {
    name: 'timeline: ripple moves everything later, tracks are ordered by drag and keys, groups fold',
    async run({ page }) {
      await set_mode(page, 'Edit');
      const before = await document_of(page);
      const human = human_of(before);
      const clip = human.track[0];
      await page.locator('.scenario').click({ position: { x: 420, y: 6 } });
      await page.keyboard.press('Escape'); // several selected clips would move together
      await page.getByRole('button', { name: 'Ripple', exact: true }).click();
      const later = before.events.filter((e) => e.time >= clip.start).map((e) => e.time);
      await page.keyboard.press('Home');
      await painted(page);
      const box = await page.locator(`[data-clip="${clip.id}"]`).boundingBox();
      await page.mouse.move(box.x + 30, box.y + 8);
      await page.mouse.down();
      await page.mouse.move(box.x + 75, box.y + 8, { steps: 6 });
      await page.mouse.up();
      await until(page, async () => human_of(await document_of(page)).track[0].start > 0.1, 'the moved clip');
      assert.equal(await label_of(page), 'Ripple move');
      const moved = await document_of(page);
      const by = human_of(moved).track[0].start - clip.start;
      for (const c of moved.characters) c.track.forEach((k, i) => assert.ok(Math.abs(k.start - before.characters.find((b) => b.id === c.id).track[i].start - by) < 2e-6, 'all clips moved alike'));
      moved.events.filter((e) => e.time >= clip.start + by).forEach((e, i) => assert.ok(Math.abs(e.time - later[i] - by) < 2e-6, 'all events moved alike'));
      await page.screenshot({ path: `${pictures}ripple.png` });
      await page.keyboard.press('Control+z');
      await until(page, async () => human_of(await document_of(page)).track[0].start === clip.start, 'one undo step');
      await page.getByRole('button', { name: 'Ripple', exact: true }).click();

      // order: drag the last track to the top, then down again by a key
      const order = () => page.locator('.track[data-character]').evaluateAll((rows) => rows.map((r) => r.dataset.character));
      const shown = await order();
      assert.ok(shown.length >= 2);
      const name = (id) => page.locator(`[data-character="${id}"] .track-name`);
      const moved_id = shown[shown.length - 1];
      const from = await name(moved_id).boundingBox();
      const to = await name(shown[0]).boundingBox();
      await page.mouse.move(from.x + 40, from.y + from.height / 2);
      await page.mouse.down();
      await page.mouse.move(to.x + 40, to.y + 8, { steps: 8 });
      await page.screenshot({ path: `${pictures}track-drag.png` });
      await page.mouse.move(to.x + 40, to.y + 3, { steps: 3 });
      await page.mouse.up();
      await until(page, async () => (await order())[0] === moved_id, 'the moved track');
      assert.deepEqual((await document_of(page)).characters.map((c) => c.id), before.characters.map((c) => c.id), 'the order of the characters stays');
      await name(moved_id).focus();
      await page.keyboard.press('Alt+ArrowDown');
      await until(page, async () => (await order())[1] === moved_id, 'the track is one lower');

      // groups
      for (const id of shown.slice(0, 2)) {
        await name(id).click();
        const field = page.getByRole('textbox', { name: 'Group' });
        await field.fill('Walkers');
        await field.press('Enter');
        await until(page, async () => (await document_of(page)).characters.find((c) => c.id === id).group === 'Walkers', 'the group');
      }
      const group = page.locator('.track.group .track-name');
      await page.screenshot({ path: `${pictures}track-group.png` });
      await group.click();
      await until(page, async () => (await order()).length === shown.length - 2, 'the folded group');
      assert.equal(await group.getAttribute('aria-expanded'), 'false');
      await both_themes(page, 'track-folded');
      await group.click();
      await undo_to(page, JSON.stringify(before));
    },
  },
  {
    name: 'grips: a two-hand grab is made by keys, held while the content is simulated, edited in the inspector, and released',
    async run({ page }) {
      await set_mode(page, 'Edit');
      const before = await document_of(page);
      const human = human_of(before);
      await page.locator(`[data-character="${human.id}"] .track-name`).click();
      await blur(page);
      await page.keyboard.press('Shift+ArrowLeft');
      for (let i = 0; i < 12; i++) await page.keyboard.press('ArrowRight');
      await page.keyboard.press('1');
      await page.keyboard.press('f');
      await rested(page);
      const grabs = async () => (await document_of(page)).events.filter((e) => e.type === 'grab');
      const hands = [];
      for (const side of ['left', 'right']) {
        hands.push(await select_link(page, human.id, `hand ${side}`));
        await blur(page);
        await page.keyboard.press('Shift+G');
        await until(page, async () => (await grabs()).length === hands.length, `the grab of the ${side} hand`);
        // both hands grip the world where they are, as a bar that does not move
        await page.getByRole('combobox', { name: 'Grips' }).selectOption('');
        await until(page, async () => (await grabs()).filter((e) => e.other === '').length === hands.length, 'a grip on the world');
        await page.getByRole('textbox', { name: 'Opens above' }).fill('5000');
        await page.keyboard.press('Enter');
        await until(page, async () => (await grabs()).filter((e) => e.limit === 5000).length === hands.length, 'the limit of the grip');
      }
      assert.equal(await page.locator('.track.holds .pill.grab').count(), 2);
      await both_themes(page, 'grips');
      const held = await Promise.all(hands.map((l) => hook(page, `link_position(${JSON.stringify(human.id)}, ${l})`)));
      await blur(page);

      // the release of the right hand, 0.5 s later
      for (let i = 0; i < 30; i++) await page.keyboard.press('ArrowRight');
      await page.getByRole('button', { name: 'Release here' }).click();
      await until(page, async () => (await document_of(page)).events.some((e) => e.type === 'release'), 'the release');
      assert.equal(await label_of(page), 'Add release');

      await set_mode(page, 'Simulate');
      await page.keyboard.press('Shift+ArrowLeft');
      await page.keyboard.press('Space');
      await until(page, async () => (await hook(page, 'transport()')).simulated > 1.2, '1.2 s of simulation', 120000);
      await page.keyboard.press('Space');
      await page.waitForTimeout(300);
      const now = await Promise.all(hands.map((l) => hook(page, `link_position(${JSON.stringify(human.id)}, ${l})`)));
      const moved = now.map((p, i) => Math.hypot(p[0] - held[i][0], p[1] - held[i][1], p[2] - held[i][2]));
      assert.ok(moved[0] < 0.15, `the left hand holds: ${moved[0].toFixed(3)} m`);
      assert.ok(moved[1] > moved[0], `the right hand was released: ${moved[1].toFixed(3)} m`);
      await page.screenshot({ path: `${pictures}grips-simulated.png` });
      await set_mode(page, 'Edit');
      await undo_to(page, JSON.stringify(before));
    },
  },
  {
    name: 'the tour is shown at the first start, is led by keys, names parts that exist, and ends for good',
    async run({ page, service }) {
      const other = await page.context().browser().newPage({ viewport: { width: 1280, height: 720 } });
      await other.goto(service.address);
      const card = other.locator('.tour');
      await card.waitFor();
      await painted(other);
      await other.screenshot({ path: `${pictures}tour.png` });
      const titles = [];
      for (let i = 0; i < 6; i++) {
        titles.push(await card.locator('strong').textContent());
        await other.locator('.tour-part').waitFor();
        const [a, b] = [await card.boundingBox(), other.viewportSize()];
        assert.ok(a.x >= 0 && a.y >= 0 && a.x + a.width <= b.width && a.y + a.height <= b.height, `the card of “${titles[i]}” is inside of the window`);
        if (i === 2) await other.screenshot({ path: `${pictures}tour-3.png` });
        if (i < 5) await other.keyboard.press('ArrowRight');
      }
      assert.equal(new Set(titles).size, 6);
      await other.keyboard.press('ArrowLeft');
      assert.equal(await card.locator('strong').textContent(), titles[4]);
      await other.keyboard.press('Escape');
      await card.waitFor({ state: 'detached' });
      await other.reload();
      await other.waitForFunction(() => window.ugoki?.connected);
      await other.waitForTimeout(500);
      assert.equal(await card.count(), 0, 'the tour is not shown again');
      await other.keyboard.press('F1');
      await other.getByRole('button', { name: 'Take the tour' }).click();
      await card.waitFor();
      await other.getByRole('button', { name: 'End the tour' }).click();
      await card.waitFor({ state: 'detached' });
      await other.close();
    },
  },
].map((journey) => ({ ...journey, skip }));
