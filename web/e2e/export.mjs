// Tests of exported pages, programs and files: node e2e/export.mjs [--slow]. Prints one line for each test. UGOKI_BIN is the path of `ugoki`.
// Every form of the content must reach the same state, bit by bit, after the same recorded inputs.
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { copyFileSync, existsSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { createSocket } from 'node:dgram';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { validateBytes } from 'gltf-validator';
import { AnimationMixer, LoopOnce, Matrix4, Quaternion, Vector3 } from 'three';
import WebSocket from 'ws';
import { USDLoader } from 'three/examples/jsm/loaders/USDLoader.js';
import { USDAParser } from 'three/examples/jsm/loaders/usd/USDAParser.js';
import { launch } from './browser.mjs';

const slow = process.argv.includes('--slow');
const here = dirname(fileURLToPath(import.meta.url));
const ugoki = process.env.UGOKI_BIN ?? join(here, '../../build/release/bin/ugoki');
const folder = mkdtempSync(join(tmpdir(), 'ugoki-export-'));
const at = (name) => join(folder, name);
const examples = join(here, '../../examples/content');
let failed = 0;

async function test(name, body) {
  try {
    const skip = await body();
    console.log(skip ? `skip ${name}: ${skip}` : `ok ${name}`);
  } catch (error) {
    failed++;
    console.log(`not ok ${name}\n  ${String(error.stack ?? error).split('\n').join('\n  ')}`);
  }
}
function expect(condition, message) {
  if (!condition) throw new Error(message);
}
const run = (...words) => execFileSync(ugoki, words, { encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] });
const refused = (...words) => {
  const done = spawnSync(ugoki, words, { encoding: 'utf8' });
  expect(done.status === 1 || done.status === 2, `status ${done.status}: ${done.stdout}${done.stderr}`);
  return done.stderr;
};

/** Starts the studio with a project. @return its address, port, token, and a function that ends it */
async function start_studio(project, ...words) {
  const studio = spawn(ugoki, ['studio', project, '--no-open', '--json', '--library', at('library.db'), ...words], { stdio: ['ignore', 'pipe', 'inherit'] });
  const text = await new Promise((done, fail) => {
    let all = '';
    studio.stdout.on('data', (d) => (all += d).includes('}') && done(all));
    studio.on('exit', () => fail(new Error('the studio ended')));
  });
  return { ...JSON.parse(text), stop: () => studio.kill() };
}

/** A connection to the studio's WebSocket. `ask` sends a request and returns its reply; `transport` is the latest event of this name. */
async function connect({ port, token }) {
  const socket = new WebSocket(`ws://127.0.0.1:${port}/ws`, ['ugoki', `ugoki.token.${token}`]);
  const waiting = new Map();
  const client = { transport: null, close: () => socket.close() };
  socket.on('message', (data, binary) => {
    const message = binary ? {} : JSON.parse(data);
    if (message.event === 'transport') client.transport = message;
    waiting.get(message.reply)?.(message);
  });
  await new Promise((done, fail) => socket.on('open', done).on('error', fail));
  let last = 0;
  client.post = (request) => socket.send(JSON.stringify({ id: ++last, ...request }));
  client.ask = async (request) => {
    const reply = new Promise((done) => waiting.set(last + 1, done));
    client.post(request);
    const answer = await reply;
    expect(answer.ok, `${JSON.stringify(request)}: ${JSON.stringify(answer)}`);
    return answer;
  };
  return client;
}

/** State hash of a project after `count` steps with recorded inputs in the studio. */
async function hash_in_studio(project, inputs_here, count) {
  const studio = await start_studio(project);
  try {
    const client = await connect(studio);
    await client.ask({ op: 'hello' });
    await client.ask({ op: 'mode', mode: 'simulate' });
    for (let step = 0; step < count; step++) {
      for (const { step: from, type, ...words } of inputs_here) {
        if (from !== step) continue;
        if (type === 'drag') client.post({ op: type, ...words }); // the studio answers only if it refuses the drag
        else await client.ask({ op: type, ...words });
      }
      await client.ask({ op: 'step', ticks: 1 });
    }
    while (client.transport?.steps !== count) await new Promise((done) => setTimeout(done, 10));
    client.close();
    return client.transport.state_hash;
  } finally {
    studio.stop();
  }
}

const steps = 600;
const inputs = [
  { step: 40, type: 'push', character: 'human', link: 'chest', force: [60, 25, 0], duration: 0.2 },
  { step: 150, type: 'grab', character: 'dog', link: 0, point: [0.02, 0, 0.01], target: [0.1, 0.9, 0.7] },
  { step: 190, type: 'drag', target: [0.3, 1.0, 0.75] },
  { step: 260, type: 'release' },
  { step: 300, type: 'throw', character: 'ball', from: [2, 0, 1.2], velocity: [-6, 0, 2.5], spin: [0, 5, 0] },
  { step: 420, type: 'input', keyboard: ['KeyW'], mouse: { x: 0.25, y: 0.5, left: true, wheel: 0.3 } },
];
writeFileSync(at('inputs.json'), JSON.stringify({ inputs }));
run('new', at('park.ugoki'));
const written = JSON.parse(run('export', at('park.ugoki'), '--html', at('park.html'), '--native', at('park'), '--ugx', at('park.ugx'), '--embed', at('embed'), '--json'));
const plain = JSON.parse(run('run', at('park.ugx'), '--steps', String(steps), '--json')).state_hash;
const wanted = JSON.parse(run('run', at('park.ugoki'), '--steps', String(steps), '--inputs', at('inputs.json'), '--json')).state_hash;

await test('`ugoki export` lists the files that it wrote', () => {
  expect(written.files.map((f) => f.kind).join() === 'html,native,script,ugx,page,ugx' || written.files.length === 6, JSON.stringify(written));
  for (const f of written.files) expect(statSync(f.file).size === f.bytes, f.file);
});

await test('an FMU of the whole content passes the checks of FMI 2.0 and 3.0', () => {
  const checker = join(dirname(ugoki), 'ugoki_fmi_checker');
  if (!existsSync(checker)) return 'the checker of FMUs is not built (target ugoki_fmi_checker)';
  for (const version of ['2', '3']) {
    const file = at(`park${version}.fmu`);
    run('export', at('park.ugoki'), '--fmu', file, '--fmi', version);
    const done = spawnSync('python3', [join(here, '../../tests/fmi/check_fmu.py'), checker, file, '0.01'], { encoding: 'utf8' });
    expect(done.status === 0 && / 0 wrong/.test(done.stdout), done.stdout + done.stderr);
  }
  return undefined;
});

await test('a page without motion data is smaller than 1.5 MB', () => {
  const share = join(dirname(ugoki), '../share/ugoki');
  const bytes = statSync(join(share, 'player.html')).size;
  console.log(`# player.html ${bytes} bytes, park.html ${statSync(at('park.html')).size} bytes, park (native) ${statSync(at('park')).size} bytes`);
  expect(bytes < 1_500_000, `${bytes} bytes`);
});

await test('recorded inputs change the run', () => expect(plain !== wanted, `both runs end with ${plain}`));

await test('the native program in an empty folder without environment variables reaches the same state', () => {
  mkdirSync(at('bare'));
  copyFileSync(at('park'), at('bare/park'));
  copyFileSync(at('inputs.json'), at('bare/inputs.json'));
  const words = ['--headless', '--steps', String(steps), '--inputs', 'inputs.json', '--json'];
  const done = JSON.parse(execFileSync('./park', words, { cwd: at('bare'), env: {}, encoding: 'utf8' }));
  expect(done.state_hash === wanted && done.steps === steps, `${done.state_hash}, wanted ${wanted}`);
  // A root folder that contains the program only: no /proc, no libraries. Only root may change the root folder, and not in every container.
  const alone = spawnSync('/usr/sbin/chroot', [at('bare'), '/park', ...words], { env: {}, encoding: 'utf8' });
  if (alone.error || alone.status === 125) console.log('# not tried without /proc: the root folder cannot be changed here');
  else expect(JSON.parse(alone.stdout).state_hash === wanted, `without /proc: ${alone.stdout}${alone.stderr}`);
  const needs = spawnSync('ldd', [at('park')], { encoding: 'utf8' });
  expect(/not a dynamic executable|statically linked/.test(needs.stdout + needs.stderr), needs.stdout);
});

await test('the native program writes the frames that `ugoki run` writes', () => {
  run('run', at('park.ugx'), '--duration', '0.5', '--frames', at('run.frames'));
  execFileSync(at('park'), ['--headless', '--frames', '30', '--out', at('native.frames')]);
  expect(Buffer.compare(readFileSync(at('run.frames')), readFileSync(at('native.frames'))) === 0, 'the files differ');
});

await test('the native program refuses damaged content and wrong inputs', () => {
  const bytes = readFileSync(at('park'));
  bytes[bytes.length - 5000] ^= 1;
  writeFileSync(at('damaged'), bytes, { mode: 0o755 });
  const done = spawnSync(at('damaged'), ['--headless'], { encoding: 'utf8' });
  expect(done.status === 1 && /damaged \(checksum\)/.test(done.stderr), done.stderr);
  writeFileSync(at('wrong.json'), JSON.stringify({ inputs: [{ step: 3, type: 'push', character: 'nobody', link: 0, force: [1, 0, 0], duration: 1 }] }));
  for (const own of ['wrong.json', 'park']) {
    const before = readFileSync(at(own));
    const none = spawnSync(at('park'), ['--headless', '--frames', '2', '--inputs', at('wrong.json'), '--out', at(own)], { encoding: 'utf8' });
    expect(none.status === 1 && /Name another file/.test(none.stderr) && readFileSync(at(own)).equals(before), none.stderr);
  }
  const wrong = spawnSync(at('park'), ['--headless', '--inputs', at('wrong.json')], { encoding: 'utf8' });
  expect(wrong.status === 1 && /inputs\/0\/character.*nobody/.test(wrong.stderr), wrong.stderr);
});

await test('`ugoki export` refuses wrong targets and missing outputs with a message', () => {
  expect(/does not exist|unknown/i.test(refused('export', at('none.ugoki'), '--html', at('x.html'))), 'missing project');
  expect(/Name at/.test(refused('export', at('park.ugoki'))), 'no output');
  expect(/header specifies/.test((writeFileSync(at('bad.ugx'), readFileSync(at('park.ugx')).subarray(0, 5000)), refused('export', at('bad.ugx'), '--html', at('x.html')))), 'truncated');
  expect(!existsSync(at('x.html')), 'a file was left');
});

// ---- in the browser ----

const browser = await launch();
const errors = [];
async function open(address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 900, height: 560 }, ...options });
  const page = await context.newPage();
  page.on('pageerror', (e) => errors.push(e.message));
  page.on('console', (m) => m.type() === 'error' && errors.push(m.text()));
  page.on('request', (r) => /^https?:/.test(r.url()) && !r.url().startsWith('http://127.0.0.1') && errors.push(`request of ${r.url()}`));
  await page.goto(address);
  await page.waitForFunction(() => document.querySelector('ugoki-player')?.first_picture > 0, undefined, { timeout: 60000 });
  return page;
}
const repeat = (page, count) =>
  page.evaluate(
    async ([list, n]) => {
      const player = document.querySelector('ugoki-player');
      player.pause();
      await player.schedule(list);
      player.reset();
      const done = await player.step(n);
      return { done, hash: await player.state_hash(), recorded: await player.recorded() };
    },
    [inputs, count],
  );

const page = await open(`file://${at('park.html')}`);

await test('the page opens from a disk, starts to play, and sends no request to the network', async () => {
  await page.waitForFunction(() => document.querySelector('ugoki-player').time > 0.05, undefined, { timeout: 30000 });
  const { first, name } = await page.evaluate(() => ({ first: document.querySelector('ugoki-player').first_picture, name: document.title }));
  console.log(`# first picture ${first.toFixed(0)} ms after the page began to load the content (software rendering)`);
  expect(name === 'park', name);
  expect(errors.length === 0, errors.join('; '));
});

await test('the page draws its first picture before its engine is unpacked, from what the engine returns too', async () => {
  const context = await browser.newContext();
  const early = await context.newPage();
  await early.addInitScript(() => {
    window.seen = [];
    for (const type of ['picture', 'ready', 'play']) document.addEventListener(type, () => window.seen.push(type));
  });
  await early.goto(`file://${at('park.html')}`);
  await early.waitForFunction(() => window.seen.includes('play'), undefined, { timeout: 30000 });
  const { seen, inside, engine } = await early.evaluate(async () => {
    const packed = Uint8Array.from(atob(document.getElementById('ugoki-first').textContent), (c) => c.charCodeAt(0));
    const text = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'))).text();
    return { seen: window.seen, inside: JSON.stringify(JSON.parse(text).scene), engine: JSON.stringify(document.querySelector('ugoki-player').scene) };
  });
  expect(seen.join() === 'picture,ready,play', seen.join());
  expect(inside === engine, 'the scene inside the page differs from that of the engine');
  await context.close();
});

await test('the page reaches the same state as `ugoki run` after the recorded inputs', async () => {
  const { done, hash } = await repeat(page, steps);
  expect(done === steps && hash === wanted, `${done} steps, ${hash}, wanted ${wanted}`);
});

await test('inputs recorded in the page repeat the run in `ugoki run`', async () => {
  const { recorded } = await repeat(page, steps);
  writeFileSync(at('again.json'), JSON.stringify({ inputs: recorded }));
  const again = JSON.parse(run('run', at('park.ugx'), '--steps', String(steps), '--inputs', at('again.json'), '--json')).state_hash;
  expect(again === wanted, `${again}, wanted ${wanted}`);
});

/** Starts the content again, so slowly that a character can be hit, and waits until the page shows its beginning and the view rests. @param tool null: as it is. @return position of a character on the page, px */
async function find_character(p, index, tool = null) {
  await p.evaluate(async (t) => {
    const player = document.querySelector('ugoki-player');
    if (t) player.tool = t;
    player.pause();
    await player.schedule([]); // the inputs of an earlier run would push and grab beside the mouse
    player.reset();
    player.follow(null);
    player.speed = 0.05;
    player.play();
  }, tool);
  const look = () =>
    p.evaluate(async (i) => {
      await new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)));
      const player = document.querySelector('ugoki-player');
      const [x, y, z] = player.characters[i].centre_of_mass;
      const { camera } = player.view.rig;
      const v = camera.position.clone().set(x, y, z + 0.1).project(camera);
      const box = player.getBoundingClientRect();
      return { time: player.time, x: box.left + (0.5 + 0.5 * v.x) * box.width, y: box.top + (0.5 - 0.5 * v.y) * box.height };
    }, index);
  for (let before = await look(), tries = 0; ; tries++) {
    await p.waitForTimeout(100);
    const now = await look();
    if (now.time > 0 && now.time < 1 && Math.hypot(now.x - before.x, now.y - before.y) < 1.5) return now;
    expect(tries < 100, `the view does not rest: ${JSON.stringify([before, now])}`);
    before = now;
  }
}

/** Waits until the recorded inputs are as wanted; the engine takes them at its next step. @return their types */
async function recorded_types(p, wanted) {
  for (let tries = 0; ; tries++) {
    const types = await p.evaluate(async () => (await document.querySelector('ugoki-player').recorded()).map((i) => i.type));
    if (wanted(types) || tries === 50) return types;
    await p.waitForTimeout(100);
  }
}

await test('a drag pulls a character with the tool pull, and pushes it with the tool push', async () => {
  for (const tool of ['pull', 'push']) {
    const from = await find_character(page, 0, tool);
    await page.mouse.move(from.x, from.y);
    await page.mouse.down();
    for (let i = 1; i <= 4; i++) await page.mouse.move(from.x + 20 * i, from.y - 4 * i);
    await page.mouse.up();
    const wanted = (types) => types.includes(tool === 'pull' ? 'grab' : 'push') && types.includes('release') === (tool === 'pull');
    const types = await recorded_types(page, wanted);
    expect(wanted(types), `${tool}: ${types}`);
  }
});

await test('a drag on the background turns the view, and the wheel zooms', async () => {
  const eye = () => page.evaluate(() => ({ ...document.querySelector('ugoki-player').view.rig.goal }));
  const before = await eye();
  await page.mouse.move(60, 120);
  await page.mouse.down();
  await page.mouse.move(160, 150, { steps: 4 });
  await page.mouse.up();
  await page.mouse.wheel(0, 300);
  await page.waitForTimeout(200);
  const after = await eye();
  expect(Math.abs(after.azimuth - before.azimuth) > 0.2 && after.distance > before.distance * 1.1, JSON.stringify([before, after]));
});

await test('Space, R and the buttons play, pause and restart', async () => {
  const state = () => page.evaluate(() => ({ paused: document.querySelector('ugoki-player').paused, time: document.querySelector('ugoki-player').time }));
  await page.evaluate(() => {
    const player = document.querySelector('ugoki-player');
    player.pause();
    player.speed = 1;
    player.shadowRoot.querySelector('canvas').focus();
  });
  await page.keyboard.press('KeyR');
  expect((await state()).time === 0, 'R did not restart');
  await page.keyboard.press('Space');
  expect(!(await state()).paused, 'Space did not play');
  await page.getByRole('button', { name: 'Pause' }).click();
  expect((await state()).paused, 'the button did not pause');
});

await test('on a phone one finger pulls and two fingers zoom', async () => {
  const phone = await open(`file://${at('park.html')}`, { viewport: { width: 390, height: 760 }, hasTouch: true, isMobile: true, deviceScaleFactor: 1 });
  const client = await phone.context().newCDPSession(phone);
  const touch = (type, points) => client.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  const from = await find_character(phone, 0);
  await touch('touchStart', [[from.x, from.y]]);
  await touch('touchMove', [[from.x + 30, from.y - 10]]);
  await touch('touchEnd', []);
  const pulled = (types) => types.includes('grab') && types.includes('release');
  const types = await recorded_types(phone, pulled);
  expect(pulled(types), types.join());
  const distance = () => phone.evaluate(() => document.querySelector('ugoki-player').view.rig.goal.distance);
  const before = await distance();
  await touch('touchStart', [[60, 150], [330, 150]]);
  await touch('touchMove', [[120, 150], [270, 150]]);
  await touch('touchMove', [[150, 150], [240, 150]]);
  await touch('touchEnd', []);
  expect((await distance()) > before * 1.5, `${before} ${await distance()}`);
  const overflow = await phone.evaluate(() => document.documentElement.scrollWidth > innerWidth);
  expect(!overflow, 'the page is wider than the phone');
  if (process.env.UGOKI_PICTURES) await phone.screenshot({ path: join(process.env.UGOKI_PICTURES, 'phone.png') });
  await phone.context().close();
});

/** Starts a native program. @return its address, and a function that ends it */
async function serve(name) {
  const program = spawn(at(name), ['--no-open', '--json'], { stdio: ['ignore', 'pipe', 'inherit'] });
  const text = await new Promise((done, fail) => {
    let all = '';
    program.stdout.on('data', (d) => (all += d).includes('}') && done(all));
    program.on('exit', () => fail(new Error('the program ended')));
  });
  return { ...JSON.parse(text), stop: () => program.kill() };
}

await test('the native program serves its page, runs the content, and reaches the same state', async () => {
  const program = await serve('park');
  try {
    const served = await open(program.address);
    await served.waitForFunction(() => document.querySelector('ugoki-player').time > 0.2, undefined, { timeout: 30000 });
    const { done, hash } = await repeat(served, steps);
    expect(done === steps && hash === wanted, `${done} steps, ${hash}, wanted ${wanted}`);
    const from = await find_character(served, 0);
    await served.mouse.move(from.x, from.y);
    await served.mouse.down();
    await served.mouse.move(from.x + 40, from.y);
    await served.mouse.up();
    expect((await recorded_types(served, (types) => types.includes('grab'))).includes('grab'), 'no grab');
    await served.context().close();
  } finally {
    program.stop();
  }
});

await test('the page and the native program show the variables of rules', async () => {
  const content = JSON.parse(readFileSync(join(examples, 'chain.json'), 'utf8'));
  content.scenario.variables = [
    { id: 'score', name: 'Score', kind: 'number', initial: 10, unit: 'points' },
    { id: 'alarm', name: 'Alarm', kind: 'switch', initial: 0 },
    { id: 'secret', name: 'Secret', kind: 'number', initial: 0, shown: false },
  ];
  const key = [{ type: 'key', key: 'KeyH' }];
  content.scenario.rules = [
    { id: 'count', if: key, do: { type: 'set', variable: 'score', change: 'add', value: 5 } },
    { id: 'ring', if: key, do: { type: 'set', variable: 'alarm', change: 'toggle' } },
  ];
  writeFileSync(at('score.json'), JSON.stringify(content));
  run('new', at('score.ugoki'), '--from', at('score.json'));
  run('export', at('score.ugoki'), '--html', at('score.html'), '--native', at('score'));
  const program = await serve('score');
  try {
    for (const address of [`file://${at('score.html')}`, program.address]) {
      const game = await open(address);
      const shown = () =>
        game.evaluate(() => {
          const player = document.querySelector('ugoki-player');
          const rows = [...player.shadowRoot.querySelectorAll('.board div')].map((row) => [...row.children].map((c) => c.textContent).join(' '));
          return [...player.variables.map((v) => `${v.id} ${v.value}`), ...rows].join(', ');
        });
      const wait = async (wanted) => {
        for (let tries = 0; tries < 100 && (await shown()) !== wanted; tries++) await game.waitForTimeout(100);
        expect((await shown()) === wanted, `${await shown()}, wanted ${wanted}`);
      };
      await game.evaluate(() => document.querySelector('ugoki-player').play());
      await wait('score 10, alarm 0, Score 10 points, Alarm off');
      await game.locator('ugoki-player canvas').focus();
      await game.keyboard.press('h', { delay: 500 });
      await wait('score 15, alarm 1, Score 15 points, Alarm on');
      if (process.env.UGOKI_PICTURES) await game.screenshot({ path: join(process.env.UGOKI_PICTURES, 'variables.png') });
      await game.context().close();
    }
  } finally {
    program.stop();
  }
});

await test('the native program opens a port for OSC only if it is asked to', async () => {
  for (const more of [[], ['--osc', '0']]) {
    const program = spawn(at('park'), ['--no-open', '--json', ...more], { stdio: ['ignore', 'pipe', 'inherit'] });
    try {
      const report = await new Promise((done, fail) => {
        let all = '';
        program.stdout.on('data', (d) => (all += d).includes('}') && done(JSON.parse(all)));
        program.on('exit', () => fail(new Error('the program ended')));
      });
      expect((report.osc > 0) === more.length > 0, JSON.stringify(report));
      if (more.length === 0) continue;
      const taken = createSocket('udp4');
      const refused_port = await new Promise((done) => taken.once('error', () => done(true)).bind(report.osc, '127.0.0.1', () => done(false)));
      if (!refused_port) taken.close();
      expect(refused_port, 'the port is free');
    } finally {
      program.kill();
    }
  }
});

await test('the element and the frame obey another page', async () => {
  copyFileSync(at('park.html'), at('embed/park.html'));
  writeFileSync(at('embed/frame.html'), '<!doctype html><iframe src="park.html" style="width: 700px; height: 400px"></iframe>');
  const server = createServer((request, reply) => {
    const file = join(at('embed'), decodeURIComponent(new URL(request.url, 'http://x').pathname));
    if (!existsSync(file)) return reply.writeHead(404).end();
    reply.writeHead(200, { 'Content-Type': file.endsWith('.html') ? 'text/html' : file.endsWith('.js') ? 'text/javascript' : 'application/octet-stream' });
    return reply.end(readFileSync(file));
  });
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  const base = `http://127.0.0.1:${server.address().port}`;
  try {
    const own = await open(`${base}/index.html`);
    const { hash } = await repeat(own, steps);
    expect(hash === wanted, `${hash}, wanted ${wanted}`);
    await own.context().close();
    const outer = await (await browser.newContext()).newPage();
    await outer.goto(`${base}/frame.html`);
    const hash_in_frame = await outer.evaluate(
      async ([list, n]) => {
        const frame = document.querySelector('iframe').contentWindow;
        let last = 0;
        const ask = (command, ...words) =>
          new Promise((done, fail) => {
            const id = ++last;
            addEventListener('message', function hear({ data }) {
              if (data?.ugoki !== 'done' || data.id !== id) return;
              removeEventListener('message', hear);
              if (data.error) fail(new Error(data.error));
              else done(data.result);
            });
            frame.postMessage({ ugoki: command, id, arguments: words }, '*');
          });
        await new Promise((done) => addEventListener('message', ({ data }) => data?.ugoki === 'ready' && done()));
        await ask('pause');
        await ask('schedule', list);
        await ask('reset');
        await ask('step', n);
        return ask('state_hash');
      },
      [inputs, steps],
    );
    expect(hash_in_frame === wanted, `${hash_in_frame}, wanted ${wanted}`);
    await outer.context().close();
  } finally {
    server.close();
  }
});

await test('a page with damaged content shows a message', async () => {
  const html = readFileSync(at('park.html'), 'utf8');
  const bytes = readFileSync(at('park.ugx'));
  bytes[bytes.length >> 1] ^= 1;
  writeFileSync(at('broken.html'), html.replace(/(id="ugoki-content">)[^<]*/, (_, tag) => tag + bytes.toString('base64')));
  const context = await browser.newContext();
  const broken = await context.newPage();
  await broken.goto(`file://${at('broken.html')}`);
  await broken.waitForFunction(() => /checksum/.test(document.querySelector('ugoki-player')?.shadowRoot?.querySelector('.message')?.textContent ?? ''));
  await context.close();
});

// ---- example contents: studio, `ugoki run`, native program and page ----

for (const name of ['park', ...readdirSync(examples).filter((f) => f.endsWith('.json')).map((f) => f.slice(0, -5))])
  await test(`the content ${name} reaches the same state in the studio, \`ugoki run\`, native program and page`, async () => {
    const project = at(`example-${name}.ugoki`);
    run('new', project, ...(name === 'park' ? [] : ['--from', join(examples, `${name}.json`)]));
    const character = JSON.parse(run('info', project, '--json')).characters[0].id;
    const list = [
      { step: 50, type: 'push', character, link: 0, force: [4, 3, 0], duration: 0.2 },
      { step: 150, type: 'grab', character, link: 0, point: [0.01, 0, 0.02], target: [0.2, 0.1, 0.8] },
      { step: 200, type: 'drag', target: [0.3, 0.1, 0.9] },
      { step: 300, type: 'release' },
    ];
    writeFileSync(at('example.json'), JSON.stringify({ inputs: list }));
    const html = at(`example-${name}.html`);
    const native = at(`example-${name}`);
    run('export', project, '--html', html, '--native', native);
    const wanted_here = JSON.parse(run('run', project, '--steps', String(steps), '--inputs', at('example.json'), '--json')).state_hash;
    const words = ['--headless', '--steps', String(steps), '--inputs', at('example.json'), '--json'];
    const in_native = JSON.parse(execFileSync(native, words, { env: {}, encoding: 'utf8' })).state_hash;
    const served = await open(`file://${html}`);
    const in_page = await served.evaluate(
      async ([inputs_here, n]) => {
        const player = document.querySelector('ugoki-player');
        player.pause();
        await player.schedule(inputs_here);
        player.reset();
        await player.step(n);
        return player.state_hash();
      },
      [list, steps],
    );
    await served.context().close();
    const in_studio = await hash_in_studio(project, list, steps);
    const all = `run ${wanted_here}, native ${in_native}, page ${in_page}, studio ${in_studio}`;
    expect([in_native, in_page, in_studio].every((hash) => hash === wanted_here), all);
    console.log(`# ${name}.html ${statSync(html).size} bytes`);
  });

if (process.env.UGOKI_PICTURES) await page.screenshot({ path: join(process.env.UGOKI_PICTURES, 'page.png') });
await browser.close();

// ---- files for other tools ----

await test('pictures have the wanted size and differ', () => {
  run('export', at('park.ugoki'), '--png', at('p%02d.png'), '--size', '160x90', '--rate', '4', '--from', '0.5', '--duration', '1.25');
  const files = readdirSync(folder).filter((f) => /^p\d\d\.png$/.test(f)).sort();
  expect(files.join() === 'p00.png,p01.png,p02.png', files.join());
  const [a, b] = files.map((f) => readFileSync(at(f)));
  expect(a.readUInt32BE(16) === 160 && a.readUInt32BE(20) === 90, 'size');
  expect(Buffer.compare(a, b) !== 0, 'the pictures are equal');
});

await test('a picture of an export equals the picture of the studio', async () => {
  const web = join(here, '../dist');
  if (!existsSync(join(web, 'index.html'))) return 'the page of the studio is not built';
  const time = 1.5;
  const own = await launch('gl-egl');
  const context = await own.newContext({ viewport: { width: 1400, height: 900 }, deviceScaleFactor: 1 });
  // The studio draws as with a graphics processor (smooth edges, no reduced resolution), and keeps its picture, so that it can be read.
  await context.addInitScript(() => {
    const get = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, options) {
      const found = get.call(this, kind, { ...options, preserveDrawingBuffer: true });
      if (kind !== 'webgl2' || !found) return found;
      const extension = found.getExtension.bind(found);
      found.getExtension = (name) => (name === 'WEBGL_debug_renderer_info' ? null : extension(name));
      return found;
    };
  });
  run('new', at('still.ugoki'));
  const studio = await start_studio(at('still.ugoki'), '--web', web);
  try {
    const client = await connect(studio);
    await client.ask({ op: 'hello' });
    // a camera that does not move, because a following camera moves smoothly in real time
    await client.ask({ op: 'command', command: { type: 'scenario.set', camera: { follow: '', azimuth: 0.7, elevation: 0.2 } } });
    await client.ask({ op: 'mode', mode: 'simulate' }); // before the page opens, because the page frames the first poses that it receives
    const shown = await context.newPage();
    await shown.goto(studio.address);
    await shown.waitForFunction(() => window.ugoki?.connected && window.ugoki.pictures > 1 && window.ugoki.frames_received > 0, undefined, { timeout: 60000 });
    const content = await fetch(`http://127.0.0.1:${studio.port}/api/export/ugx`, { headers: { Authorization: `Bearer ${studio.token}` } });
    writeFileSync(at('still.ugx'), Buffer.from(await content.arrayBuffer()));
    await client.ask({ op: 'seek', time });
    await shown.waitForFunction((t) => Math.abs((window.ugoki.frame()?.time ?? 0) - t) < 1e-9 && window.ugoki.frame().simulate, time, { timeout: 60000 });
    const draw = () =>
      shown.evaluate(() => {
        const canvas = document.querySelector('canvas[aria-label^="Viewport"]');
        return [canvas.toDataURL('image/png'), canvas.width, canvas.height];
      });
    await shown.waitForTimeout(1500);
    let [picture, width, height] = await draw();
    for (let tries = 0, before = ''; tries < 20 && picture !== before; tries++) {
      before = picture; // the camera may still move, and the last picture of a still view is drawn finer
      await shown.waitForTimeout(1000);
      [picture, width, height] = await draw();
    }
    writeFileSync(at('studio.png'), Buffer.from(picture.split(',')[1], 'base64'));
    run('export', at('still.ugx'), '--png', at('still.png'), '--from', String(time), '--size', `${width}x${height}`, '--assist');
    const difference = await (await context.newPage()).evaluate(
      async ([a, b]) => {
        const bytes_of = async (text) => {
          const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${text}`)).blob());
          const flat = new OffscreenCanvas(image.width, image.height).getContext('2d');
          flat.drawImage(image, 0, 0);
          return flat.getImageData(0, 0, image.width, image.height).data;
        };
        const [p, q] = [await bytes_of(a), await bytes_of(b)];
        let worst = p.length === q.length ? 0 : 256;
        let other = 0;
        const levels = new Set();
        for (let i = 0; i < p.length; i++) {
          const d = Math.abs(p[i] - q[i]);
          if (d > 0) other++;
          worst = Math.max(worst, d);
          levels.add(p[i]);
        }
        return { worst, other, levels: levels.size };
      },
      [readFileSync(at('studio.png')).toString('base64'), readFileSync(at('still.png')).toString('base64')],
    );
    console.log(`# studio and export, ${width} x ${height}: largest difference ${difference.worst} of 255, in ${difference.other} values`);
    expect(difference.worst <= 1 && difference.levels > 100, JSON.stringify(difference));
    client.close();
  } finally {
    studio.stop();
    await own.close();
  }
  return undefined;
});

await test('an export whose page fails at once ends with its error', () => {
  const broken = at('broken-player');
  mkdirSync(broken);
  const share = join(dirname(ugoki), '../share/ugoki');
  for (const part of readdirSync(share)) if (/^(player\.html|ugoki_)/.test(part)) copyFileSync(join(share, part), join(broken, part));
  const page = readFileSync(join(broken, 'player.html'), 'utf8');
  const wrong = page.replace('script.textContent = text', 'script.textContent = "throw new Error(1234)"');
  expect(wrong !== page, 'the page does not set the text of its script');
  writeFileSync(join(broken, 'player.html'), wrong);
  const error = refused('export', at('park.ugoki'), '--png', at('broken.png'), '--player', broken);
  expect(/has ended: .*1234/.test(error), error);
});

await test('videos have the wanted length', () => {
  const probe = spawnSync('ffprobe', ['-version']);
  if (probe.status !== 0) return 'ffmpeg is not installed';
  run('export', at('park.ugoki'), '--mp4', at('v.mp4'), '--webm', at('v.webm'), '--gif', at('v.gif'), '--size', '160x90', '--rate', '10', '--duration', '1');
  for (const name of ['v.mp4', 'v.webm', 'v.gif']) {
    const facts = JSON.parse(execFileSync('ffprobe', ['-v', 'error', '-count_frames', '-show_streams', '-of', 'json', at(name)], { encoding: 'utf8' })).streams[0];
    expect(facts.width === 160 && facts.height === 90 && Number(facts.nb_read_frames) === 10, `${name}: ${JSON.stringify(facts)}`);
  }
  return undefined;
});

await test('three.js reads the joints of USD files where the simulation had them', () => {
  run('export', at('park.ugoki'), '--usda', at('park.usda'), '--csv', at('park.csv'), '--duration', '1', '--rate', '20');
  const group = new USDLoader().parse(readFileSync(at('park.usda'), 'utf8'));
  const rows = rows_of(readFileSync(at('park.csv'), 'utf8'));
  const meshes = [];
  group.traverse((o) => o.isSkinnedMesh && meshes.push(o));
  expect(meshes.length === 3 && group.animations.length === 3, `${meshes.length} meshes, ${group.animations.length} animations`);
  let worst = 0;
  let compared = 0;
  for (const mesh of meshes) {
    const { bones } = mesh.skeleton;
    const clip = group.animations.find((a) => a.tracks.some((t) => t.name.startsWith(`${bones[0].name}.`)));
    const mixer = new AnimationMixer(mesh);
    mixer.clipAction(clip).setLoop(LoopOnce, 1).play().clampWhenFinished = true;
    const id = mesh.parent.name.toLowerCase();
    rows.forEach((row, f) => {
      mixer.setTime(f / 20);
      group.updateMatrixWorld(true);
      for (const bone of bones) {
        const p = group.worldToLocal(bone.getWorldPosition(new Vector3())); // undoes the loader's rotation from z up to y up
        const wanted_here = ['x', 'y', 'z'].map((k) => Number(row[`${id}/${bone.name} ${k}`]));
        worst = Math.max(worst, Math.hypot(p.x - wanted_here[0], p.y - wanted_here[1], p.z - wanted_here[2]));
        compared++;
      }
    });
  }
  expect(compared > 500 && worst < 1e-4, `${worst} m in ${compared} positions`);
});

await test('the joints of UsdPhysics meet: their frames in both bodies are at one place, and their axes agree', () => {
  run('new', at('chain.ugoki'), '--from', join(examples, 'chain.json'));
  let joints = 0;
  let bodies = 0;
  for (const name of ['park', 'chain']) {
    run('export', at(`${name}.ugoki`), '--usda', at('physics.usda'), '--duration', '0.1');
    const { specsByPath: specs } = new USDAParser().parseData(readFileSync(at('physics.usda'), 'utf8'));
    const value = (path, attribute) => specs[`${path}.${attribute}`]?.fields.default;
    const matrix = (p, q) => new Matrix4().compose(new Vector3(...p), new Quaternion(...q), new Vector3(1, 1, 1));
    for (const [path, { fields }] of Object.entries(specs)) {
      if (value(path, 'physics:mass') !== undefined) {
        bodies++;
        const moments = value(path, 'physics:diagonalInertia');
        // The moments of inertia of a body are positive and satisfy the triangle inequality.
        expect(Math.min(...moments) > 0 && 2 * Math.max(...moments) <= 1.0001 * moments.reduce((a, b) => a + b, 0), `${path} ${moments}`);
      }
      if (!/^Physics.*Joint$/.test(fields.typeName ?? '')) continue;
      joints++;
      const [a, b] = [0, 1].map((k) => {
        const body = specs[`${path}.physics:body${k}`]?.fields.targetPaths[0];
        if (body) expect(specs[body]?.fields.typeName === 'Xform', `${path}: body ${body}`);
        const X = body ? matrix(value(body, 'xformOp:translate'), value(body, 'xformOp:orient')) : new Matrix4();
        return X.multiply(matrix(value(path, `physics:localPos${k}`), value(path, `physics:localRot${k}`)));
      });
      const gap = new Vector3().setFromMatrixPosition(a).distanceTo(new Vector3().setFromMatrixPosition(b));
      expect(gap < 1e-5, `${path}: ${gap} m`);
      if (fields.typeName !== 'PhysicsRevoluteJoint') continue;
      const axis = (m) => new Vector3().setFromMatrixColumn(m, 2);
      expect(axis(a).distanceTo(axis(b)) < 1e-5, `${path}: axes`);
    }
  }
  expect(joints > 50 && bodies > 60, `${joints} joints, ${bodies} bodies`);
});

await test('a video shows the pictures of the PNG files in their colours', () => {
  if (spawnSync('ffmpeg', ['-version']).status !== 0) return 'ffmpeg is not installed';
  const size = ['--size', '320x176', '--rate', '5', '--duration', '1'];
  run('export', at('park.ugoki'), '--png', at('c%d.png'), ...size);
  for (const more of [[], ['--gif', at('c.gif')]]) { // with a GIF, the video is made from RGBA pictures, otherwise from planar YCbCr
    run('export', at('park.ugoki'), '--mp4', at('c.mp4'), ...more, ...size);
    const done = spawnSync('ffmpeg', ['-hide_banner', '-i', at('c.mp4'), '-start_number', '0', '-framerate', '5', '-i', at('c%d.png'), '-lavfi', '[0:v]scale=in_color_matrix=bt709:in_range=tv,format=gbrp[a];[1:v]format=gbrp[b];[a][b]psnr', '-f', 'null', '-'], { encoding: 'utf8' });
    const psnr = Number(/min:([\d.]+)/.exec(done.stderr)?.[1]);
    // Limit of the PSNR of the worst picture, dB: encoding alone gives 42, and a wrong colour matrix gives less than 34.
    expect(psnr > 38, `${psnr} dB\n${done.stderr.slice(-600)}`);
  }
  return undefined;
});

await test('glTF has no errors and no warnings in the validator', async () => {
  run('export', at('park.ugoki'), '--glb', at('park.glb'), '--duration', '1');
  const report = await validateBytes(new Uint8Array(readFileSync(at('park.glb'))), { maxIssues: 1000 });
  const faults = report.issues.messages.filter((m) => m.severity < 2).map((m) => `${m.code} ${m.pointer}: ${m.message}`);
  expect(faults.length === 0, faults.slice(0, 5).join('\n'));
  expect(report.info.hasSkins && report.info.animationCount === 1, JSON.stringify(report.info));
});

await test('the studio exports the files that `ugoki export` writes', async () => {
  const web = join(here, '../dist');
  if (!existsSync(join(web, 'index.html'))) return 'the page of the studio is not built';
  const studio = await start_studio(at('park.ugoki'), '--web', web);
  try {
    const { port, token } = studio;
    const get = (form) => fetch(`http://127.0.0.1:${port}/api/export/${form}`, { headers: { Authorization: `Bearer ${token}` } });
    for (const [form, file] of [['html', 'park.html'], ['native', 'park'], ['ugx', 'park.ugx']]) {
      const answer = await get(form);
      expect(answer.status === 200 && answer.headers.get('content-type') === 'application/octet-stream', `${form}: ${answer.status}`);
      expect(Buffer.compare(Buffer.from(await answer.arrayBuffer()), readFileSync(at(file))) === 0, `${form} differs`);
    }
    const wrong = await get('docx');
    expect(wrong.status >= 400 && /html, native/.test(await wrong.text()), 'an unknown form');
  } finally {
    studio.stop();
  }
  return undefined;
});

// ---- sweeps ----

/** Rows of a CSV without quotes, as objects. */
function rows_of(text) {
  const [head, ...lines] = text.trim().split('\n').map((line) => line.split(','));
  return lines.map((cells) => Object.fromEntries(cells.map((c, i) => [head[i], c])));
}
const sweep = (count, table, ...more) => ['bake', at('park.ugoki'), '--vary', `push=0:400:${count / 4}`, '--vary', 'push-angle=0,90,180,270', '--vary', 'push-time=0.05', '--duration', '0.2', '--table', at(table), ...more];

await test('a sweep that is killed several times gives the complete table and repeats no finished run', async () => {
  const [count, kills] = slow ? [1000, 5] : [80, 3];
  const began = Date.now();
  run(...sweep(count, 'whole.db', '--csv', at('whole.csv')));
  const part = (Date.now() - began) / (kills + 1); // ms after which a sweep is killed: each one computes a part of the runs
  const whole = rows_of(readFileSync(at('whole.csv'), 'utf8'));
  expect(whole.length === count && whole.every((r) => r.status === 'done'), `${whole.length} rows`);
  expect(new Set(whole.map((r) => r.state_hash)).size > count / 2, 'the variations have no effect');
  for (let i = 0; i < kills; i++) {
    const killed = spawn(ugoki, sweep(count, 'killed.db', '--json'), { stdio: 'ignore' });
    const ended = new Promise((done) => killed.on('exit', (code, signal) => done(signal)));
    await new Promise((done) => setTimeout(done, part));
    killed.kill('SIGKILL');
    if ((await ended) !== 'SIGKILL') break; // the sweep ended before it could be killed
  }
  const last = JSON.parse(run(...sweep(count, 'killed.db', '--json', '--csv', at('killed.csv'))));
  const before = count - last.added;
  console.log(`# ${kills} kills, ${before} of ${count} runs were kept from before the last call`);
  expect(before > 0, 'the killed sweeps have kept nothing');
  const strip = (rows) => rows.map(({ processor_s, ...rest }) => JSON.stringify(rest)).join('\n');
  expect(strip(rows_of(readFileSync(at('killed.csv'), 'utf8'))) === strip(whole), 'the tables differ');
  const again = JSON.parse(run(...sweep(count, 'killed.db', '--json')));
  expect(again.added === 0 && again.runs === count, JSON.stringify(again));
});

await test('parts of a sweep are merged to the same table, and another sweep is refused', () => {
  for (const part of [0, 1, 2]) run(...sweep(24, `part${part}.db`, '--part', `${part}/3`));
  run(...sweep(24, 'merged.db', '--merge', at('part0.db'), '--merge', at('part1.db')));
  const merged = JSON.parse(run(...sweep(24, 'merged.db', '--merge', at('part2.db'), '--json')));
  expect(merged.runs === 24 && merged.added === 0, JSON.stringify(merged));
  expect(/another sweep/.test(refused(...sweep(28, 'merged.db'))), 'another sweep in the same table');
  expect(/cannot be varied|not a quantity/.test(refused('bake', at('park.ugoki'), '--table', at('x.db'), '--vary', 'pushh=1')), 'unknown quantity');
});

await test('the scripts of --slurm compute the parts and merge them', () => {
  run(...sweep(12, 'cluster.db', '--slurm', '2', '--dry-run'));
  // Replaces Slurm: runs each task of the array, then the merge.
  for (const task of ['0', '1']) execFileSync('bash', [at('cluster.slurm')], { env: { ...process.env, SLURM_ARRAY_TASK_ID: task, SLURM_CPUS_PER_TASK: '1' } });
  execFileSync('bash', [at('cluster.merge.slurm')]);
  const done = JSON.parse(run(...sweep(12, 'cluster.db', '--json')));
  expect(done.runs === 12 && done.added === 0, JSON.stringify(done));
});

await test('random variations depend on the seed only', () => {
  const words = (table, seed) => ['bake', at('park.ugoki'), '--random', '6', '--seed', seed, '--vary', 'friction=0.2:1', '--vary', '/gravity/2=-9.81,-1.62', '--duration', '0.1', '--table', at(table), '--csv', at(`${table}.csv`)];
  run(...words('r1', '7'), '--jobs', '1');
  run(...words('r2', '7'), '--jobs', '2');
  run(...words('r3', '8'));
  const of = (name) => rows_of(readFileSync(at(`${name}.csv`), 'utf8')).map((r) => `${r.friction} ${r['/gravity/2']} ${r.state_hash}`).join('\n');
  expect(of('r1') === of('r2') && of('r1') !== of('r3'), `${of('r1')}\n\n${of('r2')}`);
});

rmSync(folder, { recursive: true, force: true });
process.exit(failed > 0 ? 1 : 0);
