// Journeys: end-to-end tests that use the studio in Chromium as a user does. Each starts with the page as the previous journey left it.
import { request } from 'node:http';
import { mkdirSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import assert from 'node:assert/strict';
import { painted, ready, rested } from './browser.mjs';
import { accessibility_journeys } from './accessibility.mjs';
import { body_journeys } from './bodies.mjs';
import { circuit_journeys } from './circuit.mjs';
import { control_journeys } from './controls.mjs';
import { key_journeys } from './keys.mjs';
import { plugin_journeys } from './plugins.mjs';
import { editor_journeys } from './editor.mjs';
import { recording_journeys } from './recordings.mjs';
import { repair_journeys } from './repairs.mjs';
import { posing_journeys } from './posing.mjs';
import { timeline_journeys } from './timeline.mjs';
import { look_journeys } from './looks.mjs';
import { prop_journeys } from './props.mjs';
import { pull_journeys } from './pulls.mjs';
import { push_journeys } from './pushes.mjs';
import { request_journeys } from './requests.mjs';
import { rule_journeys } from './rules.mjs';
import { session_journeys } from './sessions.mjs';
import { skin_journeys } from './skins.mjs';
import { sweep_journeys } from './sweeps.mjs';
import { gait_journeys } from './gaits.mjs';
import { jump_journeys } from './jumps.mjs';
import { library_journeys } from './library.mjs';
import { motion_journeys } from './motion.mjs';
import { nested_journeys } from './nested.mjs';
import { mock } from './service.mjs';

const pictures = fileURLToPath(new URL('./out/', import.meta.url));
mkdirSync(pictures, { recursive: true });

const hook = (page, expression) => page.evaluate(expression);
/** Evaluates `expression` in the page until it is true. waitForFunction is not used: the page's content security policy forbids eval. */
async function until(page, expression, description, timeout = 30000) {
  const end = Date.now() + timeout;
  while (!(await page.evaluate(expression))) {
    if (Date.now() > end) throw new Error(`waited ${timeout / 1000} s in vain for: ${description}`);
    await page.waitForTimeout(50);
  }
}
const distance = (a, b) => Math.hypot(...a.map((v, i) => v - b[i]));

/** The first character that follows a track, and its longest clip. */
const lead = (page) =>
  hook(page, () => {
    const c = window.ugoki.document().characters.find((x) => x.control.mode === 'track' && x.track.length > 0);
    return { id: c.id, clip: [...c.track].sort((a, b) => b.length - a.length)[0] };
  });

/** Index of the first link whose name or label matches. */
async function find_link(page, character, pattern) {
  const mechanism = await hook(page, `window.ugoki.document().characters.find((c) => c.id === ${JSON.stringify(character)}).mechanism`);
  const links = await page.evaluate(async (id) => (await (await fetch(`api/mechanism/${encodeURIComponent(id)}`, { headers: { Authorization: `Bearer ${sessionStorage.getItem('ugoki_token')}` } })).json()).links, mechanism);
  const index = links.findIndex((l) => pattern.test(`${l.name} ${l.label ?? ''}`) && l.shapes.length > 0);
  assert.ok(index >= 0, `no link matches ${pattern}: ${links.map((l) => l.name)}`);
  return index;
}

const positions = (page, character) =>
  hook(page, `(() => { const out = []; for (let i = 0; ; i++) { const p = window.ugoki.link_position(${JSON.stringify(character)}, i); if (!p) return out; out.push(p); } })()`);

/** Clicks the ruler at `time` (s) and waits for that frame. @return time of the frame, s */
async function show_time(page, time) {
  const before = await hook(page, 'window.ugoki.frames_received');
  const ruler = await page.locator('.ruler').boundingBox();
  await page.keyboard.press('Home');
  await painted(page);
  const duration = await hook(page, 'window.ugoki.document().duration');
  const width = ruler.width;
  const scale = (Math.max(width, 80) - 32) / Math.max(duration, 0.5);
  await page.mouse.click(ruler.x + 12 + time * scale, ruler.y + ruler.height / 2);
  await until(page, `window.ugoki.frames_received > ${before} && Math.abs(window.ugoki.frame().time - ${time}) < 0.1`, `the frame at ${time} s`);
  await painted(page);
  return hook(page, 'window.ugoki.frame().time');
}

async function set_mode(page, mode) {
  await page.getByRole('radio', { name: mode === 'edit' ? 'Edit' : 'Simulate' }).click();
  await until(page, `window.ugoki.transport().mode === '${mode}'`, `mode ${mode}`);
  await painted(page);
}

/** Mean brightness, 0 to 255, of a rectangle of the screen. */
async function pixels(page, clip) {
  const png = (await page.screenshot({ clip })).toString('base64');
  return page.evaluate(async (data) => {
    const bytes = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = canvas.getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const { data: rgba } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    let sum = 0;
    for (let i = 0; i < rgba.length; i += 4) sum += (rgba[i] + rgba[i + 1] + rgba[i + 2]) / 3;
    return { mean: sum / (rgba.length / 4) };
  }, png);
}

/** Status and text of an HTTP request with headers that a browser does not let a page set. */
function ask(address, path, headers = {}) {
  const url = new URL(address);
  return new Promise((resolve, reject) => {
    const r = request({ host: url.hostname, port: url.port, path, headers }, (response) => {
      let text = '';
      response.on('data', (d) => (text += d));
      response.on('end', () => resolve({ status: response.statusCode, text }));
    });
    r.on('error', reject);
    r.end();
  });
}

/** Status of a WebSocket handshake; 101 if it is accepted. */
function shake_hands(address, path, headers = {}) {
  const url = new URL(address);
  return new Promise((resolve, reject) => {
    const r = request({
      host: url.hostname, port: url.port, path,
      headers: { Connection: 'Upgrade', Upgrade: 'websocket', 'Sec-WebSocket-Version': '13', 'Sec-WebSocket-Key': 'dGhlIHNhbXBsZSBub25jZQ==', ...headers },
    });
    r.on('upgrade', (response, socket) => {
      socket.destroy();
      resolve(response.statusCode);
    });
    r.on('response', (response) => {
      response.resume();
      resolve(response.statusCode);
    });
    r.on('error', reject);
    r.end();
  });
}

/** The first journey of run.mjs: opens the studio. */
export const opening = {
  name: 'the page loads from the printed address, without requests to other hosts',
  async run({ page, service, seen }) {
    await page.goto(service.address);
    await ready(page);
    assert.equal(await page.locator('.brand').textContent(), 'Ugoki');
    for (const tab of ['Library', 'Inspector', 'Scenario']) assert.ok(await page.getByRole('tab', { name: tab }).or(page.locator('.tab', { hasText: tab })).first().isVisible(), tab);
    const origin = new URL(service.address).origin;
    const foreign = seen.requests.filter((u) => !u.startsWith(origin) && !u.startsWith(origin.replace('http', 'ws')) && !u.startsWith('data:') && !u.startsWith('blob:'));
    assert.deepEqual(foreign, []);
    assert.deepEqual(seen.errors, []);
  },
};

const first_journeys = [
  {
    name: 'the character is visible',
    async run({ page }) {
      const { id } = await lead(page);
      await rested(page);
      const head = await find_link(page, id, /head/i); // without clothes, which may be dark
      const at = await hook(page, `window.ugoki.link_on_screen(${JSON.stringify(id)}, ${head})`);
      const box = await page.locator('.viewport').boundingBox();
      assert.ok(at && at.x > box.x && at.x < box.x + box.width && at.y > box.y && at.y < box.y + box.height, 'the head is inside the viewport');
      const body = await pixels(page, { x: at.x - 3, y: at.y - 3, width: 6, height: 6 });
      const ground = await pixels(page, { x: box.x + 8, y: box.y + box.height - 70, width: 20, height: 20 });
      assert.ok(body.mean > ground.mean + 40, `brightness of the body (${body.mean.toFixed(0)}) exceeds that of the floor (${ground.mean.toFixed(0)})`);
      await page.screenshot({ path: `${pictures}character.png` });
    },
  },
  {
    name: 'Play moves the character and Pause stops it',
    async run({ page }) {
      const { id } = await lead(page);
      const before = await positions(page, id);
      await page.getByRole('button', { name: 'Play' }).click();
      await until(page, 'window.ugoki.transport().playing && window.ugoki.frame().time > 0.6', 'time to pass');
      await until(page, 'window.ugoki.frame().time > 1.6', 'a second of motion');
      await page.getByRole('button', { name: 'Pause' }).click();
      await until(page, '!window.ugoki.transport().playing', 'the pause');
      const after = await positions(page, id);
      const moved = Math.max(...after.map((p, i) => distance(p, before[i])));
      assert.ok(moved > 0.05, `a link moved by ${moved.toFixed(3)} m`);
      await page.waitForTimeout(300);
      const time = await hook(page, 'window.ugoki.frame().time');
      await page.waitForTimeout(600);
      assert.equal(await hook(page, 'window.ugoki.frame().time'), time, 'paused');
    },
  },
  {
    name: 'a click on the ruler shows the frame at that time',
    async run({ page }) {
      await set_mode(page, 'edit');
      const at = await show_time(page, 2);
      assert.ok(Math.abs(at - 2) < 0.05);
      await until(page, "/^00:0(1[.]9|2[.]0)\\d$/.test(document.querySelector('.clock .time').textContent)", 'the clock to show 2 s');
    },
  },
  {
    name: 'dragging a clip changes the motion, as one command',
    async run({ page, memory }) {
      const { id, clip } = await lead(page);
      memory.id = id;
      memory.clip = clip;
      memory.time = clip.start + Math.min(1, clip.length * 0.4);
      memory.time = await show_time(page, memory.time);
      memory.before = await positions(page, id);
      const box = await page.locator(`[data-clip="${clip.id}"]`).boundingBox();
      const grip = { x: box.x + Math.min(box.width / 2, 120), y: box.y + box.height / 2 };
      await page.mouse.move(grip.x, grip.y);
      await page.mouse.down();
      await page.mouse.move(grip.x + 30, grip.y, { steps: 4 });
      await page.mouse.move(grip.x + 95, grip.y, { steps: 8 });
      const shown = await page.locator(`[data-clip="${clip.id}"]`).boundingBox();
      assert.ok(shown.x > box.x + 40, 'the clip follows the cursor before anything is sent');
      assert.equal(await hook(page, `window.ugoki.document().characters.find((c) => c.id === '${id}').track.find((k) => k.id === '${clip.id}').start`), clip.start);
      await page.mouse.up();
      await until(page, `window.ugoki.document().characters.find((c) => c.id === '${id}').track.find((k) => k.id === '${clip.id}').start > ${clip.start + 0.2}`, 'the new start');
      await page.waitForTimeout(500);
      await show_time(page, memory.time);
      const after = await positions(page, id);
      const changed = Math.max(...after.map((p, i) => distance(p, memory.before[i])));
      assert.ok(changed > 0.02, `at ${memory.time.toFixed(2)} s a link moved by ${changed.toFixed(3)} m`);
      assert.ok((await hook(page, 'window.ugoki.undo()')).can_undo);
    },
  },
  {
    name: 'undo restores the clip and the motion',
    async run({ page, memory }) {
      await page.locator('.scenario').click({ position: { x: 400, y: 6 } });
      await page.keyboard.press('Control+z');
      const { id, clip } = memory;
      await until(page, `window.ugoki.document().characters.find((c) => c.id === '${id}').track.find((k) => k.id === '${clip.id}').start === ${clip.start}`, 'the old start');
      await page.waitForTimeout(400);
      const time = await show_time(page, memory.time);
      const after = await positions(page, id);
      const error = Math.max(...after.map((p, i) => distance(p, memory.before[i])));
      assert.ok(Math.abs(time - memory.time) < 1e-6 && error < 1e-5, `every link has its old position: ${error} m`);
      const undo = await hook(page, 'window.ugoki.undo()');
      assert.ok(undo.can_redo);
    },
  },
  {
    name: 'a clip can be dragged onto another track with the same mechanism only',
    skip: mock && 'the mock service does not duplicate characters',
    async run({ page }) {
      const { id, clip } = await lead(page);
      const tracks = () => hook(page, 'Object.fromEntries(window.ugoki.document().characters.map((c) => [c.id, c.track.length]))');
      const before = await tracks();
      await page.locator(`[data-character="${id}"] .track-name`).click();
      await page.keyboard.press('Control+d');
      await until(page, `window.ugoki.document().characters.length > ${Object.keys(before).length}`, 'the second character');
      const twin = Object.keys(await tracks()).find((c) => !(c in before));
      await page.waitForTimeout(500);
      const start = { ...(await tracks()) };
      const drag_to = async (character, picture) => {
        const box = await page.locator(`[data-clip="${clip.id}"]`).boundingBox();
        const lane = await page.locator(`[data-character="${character}"] .lane`).boundingBox();
        const grip = { x: box.x + Math.min(box.width / 2, 120), y: box.y + box.height / 2 };
        await page.mouse.move(grip.x, grip.y);
        await page.mouse.down();
        await page.mouse.move(grip.x + 20, grip.y + 4, { steps: 3 });
        await page.mouse.move(grip.x + 60, lane.y + lane.height / 2, { steps: 6 });
        await page.waitForTimeout(200);
        await page.screenshot({ path: `${pictures}${picture}.png` });
        await page.mouse.up();
        await page.waitForTimeout(700);
      };
      const other = await hook(page, `window.ugoki.document().characters.find((c) => c.mechanism !== window.ugoki.document().characters.find((d) => d.id === '${id}').mechanism).id`);
      await drag_to(other, 'clip-refused');
      assert.deepEqual(await tracks(), start, 'a motion for another mechanism is refused');
      await drag_to(twin, 'clip-to-track');
      assert.deepEqual(await tracks(), { ...start, [id]: start[id] - 1, [twin]: start[twin] + 1 });
      const moved = await hook(page, `window.ugoki.document().characters.find((c) => c.id === '${twin}').track.find((k) => k.id === '${clip.id}')`);
      assert.ok(moved.start > clip.start + 0.1 && moved.length === clip.length && moved.motion === clip.motion, 'the whole clip, later');
      await page.keyboard.press('Control+z');
      await until(page, `window.ugoki.document().characters.find((c) => c.id === '${id}').track.length === ${start[id]}`, 'one undo to move the clip back');
      await page.keyboard.press('Control+z');
      await until(page, `window.ugoki.document().characters.length === ${Object.keys(before).length}`, 'the second character to be removed');
    },
  },
  {
    name: 'a track that ends during a movement shows a warning',
    skip: mock && 'the mock service has no motion data',
    async run({ page }) {
      const { id, clip } = await lead(page);
      const note = page.locator(`[data-character="${id}"] .unfinished`);
      assert.equal(await note.count(), 0);
      const box = await page.locator(`[data-clip="${clip.id}"]`).boundingBox();
      await page.mouse.move(box.x + box.width - 2, box.y + box.height / 2);
      await page.mouse.down();
      await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2, { steps: 6 });
      await page.mouse.up();
      await note.waitFor();
      assert.match(await note.textContent(), /ends at \d\.\d m\/s/);
      await page.screenshot({ path: `${pictures}unfinished.png` });
      await page.keyboard.press('Control+z');
      await note.waitFor({ state: 'detached' });
    },
  },
  {
    name: 'Save as asks before it replaces a file',
    skip: mock && 'the mock service does not save',
    async run({ page }) {
      const path = () => page.locator('.project').getAttribute('title');
      const save_as = async (name) => {
        await page.keyboard.press('Control+Shift+s');
        await page.locator('#save-path').fill(name);
        await page.keyboard.press('Enter');
      };
      await page.locator('.scenario').click({ position: { x: 400, y: 6 } });
      const first = (await path()).split(' ')[0];
      const second = first.replace(/[^/]+$/, 'second.ugoki');
      await save_as(second);
      await page.locator('.save-as').waitFor({ state: 'detached' });
      assert.ok((await path()).startsWith(second), await path());
      await save_as(first);
      await page.locator('.save-as [role=alert]').waitFor();
      await page.screenshot({ path: `${pictures}save-as.png` });
      await page.keyboard.press('Escape');
      await page.locator('.save-as').waitFor({ state: 'detached' });
      assert.ok((await path()).startsWith(second), 'nothing was replaced');
      await save_as(first);
      await page.getByRole('button', { name: 'Replace' }).click();
      await page.locator('.save-as').waitFor({ state: 'detached' });
      assert.ok((await path()).startsWith(first), await path());
    },
  },
  {
    name: 'the chosen keymap is kept for the next page',
    async run({ page, service }) {
      const chosen = async () => {
        await page.keyboard.press('F1');
        const name = await page.locator('.keys [role=radio][aria-checked=true]').textContent();
        await page.keyboard.press('Escape');
        return name;
      };
      const other = { Industry: 'Blender-like', 'Blender-like': 'Industry' };
      const before = await chosen();
      for (const now of [other[before], before]) {
        await page.keyboard.press('Control+k');
        await page.keyboard.type('switch keymap');
        await page.keyboard.press('Enter');
        await page.waitForTimeout(300);
        await page.goto('about:blank');
        await page.goto(service.address);
        await ready(page);
        assert.equal(await chosen(), now);
      }
    },
  },
  {
    name: 'pulling a hand with the mouse moves the body',
    async run({ page }) {
      const { id } = await lead(page);
      await set_mode(page, 'simulate');
      // at a tenth of the speed: software rendering is slow, and the character walks on while the mouse moves
      await page.getByRole('combobox', { name: 'Playback speed' }).selectOption('0.1');
      await page.keyboard.press('Control+Home');
      await until(page, 'window.ugoki.frame().time < 0.1', 'the start');
      await page.getByRole('button', { name: 'Play' }).click();
      await until(page, 'window.ugoki.frame().simulate && window.ugoki.transport().playing && window.ugoki.frame().time > 0.3', 'the simulation to run');
      const hand = await find_link(page, id, /(left|right|^l|^r).*hand|forearm|radius/i);
      let grabbed = false;
      let point;
      for (let attempt = 0; attempt < 12 && !grabbed; attempt++) {
        point = await hook(page, `window.ugoki.link_on_screen('${id}', ${hand})`);
        await page.mouse.move(point.x, point.y);
        await page.mouse.down();
        grabbed = await until(page, 'window.ugoki.frame().grabbing', 'the grab', 2000).then(() => true, () => false);
        if (!grabbed) await page.mouse.up();
      }
      assert.ok(grabbed, 'the press grabbed the character');
      const link = (await hook(page, 'window.ugoki.selection()')).link;
      const com = (await hook(page, `window.ugoki.character('${id}')`)).com;
      await page.mouse.move(point.x + 60, point.y - 90, { steps: 4 });
      await page.mouse.move(point.x + 110, point.y - 160, { steps: 4 });
      const spring = () => hook(page, '(() => { const p = window.ugoki.pull(); return p && Math.hypot(...p.point.map((v, i) => v - p.target[i])); })()');
      let longest = 0;
      let length = Infinity;
      let picture = false;
      for (const end = Date.now() + 40000; Date.now() < end && !(longest > 0.2 && length < 0.7 * longest); ) {
        length = (await spring()) ?? length;
        longest = Math.max(longest, length);
        if (!picture && longest > 0.2 && length < 0.85 * longest) {
          picture = true;
          await page.screenshot({ path: `${pictures}pull.png` });
        }
        await page.waitForTimeout(60);
      }
      const character = await hook(page, `window.ugoki.character('${id}')`);
      assert.ok(longest > 0.2 && length < 0.7 * longest, `link ${link} followed the mouse: the spring shortened from ${longest.toFixed(2)} to ${length.toFixed(2)} m`);
      assert.ok(distance(character.com, com) > 0.005, 'the body moved too');
      await page.mouse.up();
      await until(page, '!window.ugoki.frame().grabbing', 'the release');
    },
  },
  {
    name: 'root assist and contacts are shown during simulation',
    async run({ page }) {
      await until(page, 'window.ugoki.summary().characters.length > 0', 'a summary');
      assert.match(await page.locator('.card .value').first().textContent(), /^\d+\.\d %$/);
      assert.ok(await hook(page, 'window.ugoki.summary().contacts.length > 0'));
      await page.getByRole('button', { name: 'Contacts', exact: true }).click();
      if (await hook(page, 'window.ugoki.transport().playing')) await page.getByRole('button', { name: 'Pause' }).click();
      await page.getByRole('combobox', { name: 'Playback speed' }).selectOption('1');
      await rested(page);
      await page.screenshot({ path: `${pictures}simulate.png` });
      await page.getByRole('button', { name: 'Contacts', exact: true }).click();
    },
  },
  {
    name: 'the keyboard alone opens the palette, switches the mode and steps a frame',
    async run({ page }) {
      await page.keyboard.press('Control+k');
      await page.keyboard.type('switch edit');
      await page.keyboard.press('Enter');
      await until(page, "window.ugoki.transport().mode === 'edit'", 'edit mode');
      await page.keyboard.press('?');
      await page.getByRole('dialog', { name: 'Keyboard and mouse' }).waitFor();
      await page.keyboard.press('Escape');
      await page.getByRole('dialog', { name: 'Keyboard and mouse' }).waitFor({ state: 'detached' });
      // from the start: the journey before may have ended at the last frame, after which there is none
      await page.keyboard.press('Control+Home');
      await until(page, 'window.ugoki.frame().time === 0', 'the start');
      await page.keyboard.press('ArrowRight');
      await until(page, 'window.ugoki.frame().time > 0', 'the next frame');
    },
  },
  {
    name: 'a wrong token, Host or Origin is refused',
    skip: mock && 'the mock service accepts everybody',
    async run({ page, service }) {
      const token = await page.evaluate(() => sessionStorage.getItem('ugoki_token'));
      const bearer = { Authorization: `Bearer ${token}` };
      assert.equal((await ask(service.address, '/api/library', bearer)).status, 200);
      for (const [label, path, headers, status] of [
        ['no token', '/api/library', {}, 401],
        ['wrong token', '/api/library', { Authorization: 'Bearer wrong' }, 401],
        ['token in the query', `/api/library?token=${token}`, {}, 401],
        ['token in a cookie', '/api/library', { Cookie: `ugoki_${new URL(service.address).port}=${token}` }, 401],
        ['wrong Host', '/api/library', { ...bearer, Host: 'evil.example' }, 403],
        ['wrong Origin', '/api/library', { ...bearer, Origin: 'http://evil.example' }, 403],
      ]) {
        const answer = await ask(service.address, path, headers);
        assert.equal(answer.status, status, label);
        assert.ok(answer.text.length > 10, `${label}: the answer has an explanation`);
      }
      assert.equal(await shake_hands(service.address, '/ws', bearer), 101);
      assert.equal(await shake_hands(service.address, '/ws', { 'Sec-WebSocket-Protocol': `ugoki, ugoki.token.${token}` }), 101);
      assert.equal(await shake_hands(service.address, '/ws', { 'Sec-WebSocket-Protocol': 'ugoki, ugoki.token.wrong' }), 401);
      assert.equal(await shake_hands(service.address, `/ws?token=${token}`), 401);
      assert.equal(await shake_hands(service.address, '/ws', { ...bearer, Origin: 'http://evil.example' }), 403);
      assert.equal(await shake_hands(service.address, '/ws', { ...bearer, Host: 'evil.example:80' }), 403);
    },
  },
  {
    name: 'the address bar, the cookies and a reload: the token stays in the tab',
    skip: mock && 'the mock service accepts everybody',
    async run({ page, service }) {
      assert.equal(page.url(), `${new URL(service.address).origin}/`);
      assert.deepEqual(await page.context().cookies(), []);
      await page.reload();
      await ready(page);
      const other = await page.context().browser().newPage();
      await other.goto(new URL(service.address).origin);
      await other.getByRole('alert').filter({ hasText: 'has no access to the studio' }).waitFor();
      await other.goto(service.address); // changes only the fragment of the address, so that the page is not loaded again
      await ready(other);
      assert.equal(other.url(), `${new URL(service.address).origin}/`);
      await other.close();
    },
  },
];

/** Follows each group of journeys. */
export const closing = {
  name: 'the page reported no errors during the journeys',
  async run({ seen }) {
    assert.deepEqual(seen.errors, []);
  },
};

/** Journeys of one group run in this order on the same page, and each group begins with the sample project. Groups that take long come first. */
export const groups = [
  first_journeys, accessibility_journeys, editor_journeys, session_journeys, plugin_journeys, timeline_journeys, rule_journeys, look_journeys,
  circuit_journeys, repair_journeys, prop_journeys, jump_journeys, library_journeys, posing_journeys, motion_journeys, recording_journeys, gait_journeys,
  skin_journeys, pull_journeys, push_journeys, key_journeys, sweep_journeys, body_journeys, control_journeys, request_journeys, nested_journeys,
];
