// npm run frames [-- LSIs]: measures panning, zooming and editing a large circuit, in a Chromium that renders on the CPU without a GPU
// (a lower bound of what users get). For each action it prints:
//   fps, worst   frame rate and longest frame by wall time (requestAnimationFrame): valid only on an otherwise idle machine
//   cpu          CPU time of the page's main thread per frame, ms: valid on a busy machine too; 30 fps need less than 33
import { chromium } from 'playwright-core';
import { browser_program } from './browser.mjs';
import { start_service } from './service.mjs';

const lsis = Number(process.argv[2] ?? 10000);
const service = await start_service();
const browser = await chromium.launch({
  executablePath: browser_program,
  args: ['--headless', '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-gpu-compositing', '--disable-gpu-rasterization', '--disable-accelerated-2d-canvas', '--no-first-run', '--disable-background-networking'],
});
const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
await page.addInitScript(() => {
  // pages without an address of their own have no storage
  if (location.protocol.startsWith('http')) localStorage.setItem('ugoki.tour', 'done');
});
const devtools = await page.context().newCDPSession(page);
await devtools.send('Performance.enable', { timeDomain: 'threadTicks' });
const cpu = async () => 1000 * (await devtools.send('Performance.getMetrics')).metrics.find((m) => m.name === 'TaskDuration').value;

/** Sets the generated circuit with `n` more LSIs below it: rows of a clock followed by 99 gains in series. */
const set_circuit = (n) => new Promise((resolve) => {
  const socket = new WebSocket(`${location.origin.replace('http', 'ws')}/ws`, ['ugoki', `ugoki.token.${sessionStorage.getItem('ugoki_token')}`]);
  socket.onopen = () => socket.send('{"id":1,"op":"hello"}');
  socket.onmessage = (message) => {
    const reply = typeof message.data === 'string' ? JSON.parse(message.data) : {};
    if (reply.reply === 2) resolve(reply.ok);
    if (reply.reply !== 1) return;
    const circuit = structuredClone(reply.generated_circuit);
    for (let i = 0; i < n; i++) {
      const column = i % 100;
      circuit.lsis.push({ id: `g${i}`, type: column === 0 ? 'clock' : 'gain', at: [column * 240, 1600 + Math.floor(i / 100) * 110] });
      if (column > 0) circuit.wires.push({ from: column === 1 ? `g${i - 1}.time` : `g${i - 1}.out`, to: `g${i}.in` });
    }
    socket.send(JSON.stringify({ id: 2, op: 'command', command: { type: 'circuit.set', circuit } }));
  };
});

/** Prints frame rate and CPU time of an action. */
async function measure(name, act) {
  await page.evaluate(() => {
    const times = (window.frame_times = []);
    const record = (now) => {
      times.push(now);
      if (window.frame_times === times) requestAnimationFrame(record);
    };
    requestAnimationFrame(record);
  });
  const before = await cpu();
  await act();
  const after = await cpu();
  const gaps = await page.evaluate(() => {
    const times = window.frame_times;
    window.frame_times = null;
    return times.slice(1).map((t, i) => t - times[i]);
  });
  const { far, near, viewport } = await page.evaluate(() => window.ugoki.circuit().facts);
  const sum = gaps.reduce((a, b) => a + b, 0);
  console.log(`${name.padEnd(22)} ${String(gaps.length).padStart(4)} frames  ${(1000 * gaps.length / sum).toFixed(0).padStart(3)} fps  worst ${Math.max(...gaps).toFixed(0).padStart(5)} ms  cpu ${((after - before) / gaps.length).toFixed(1).padStart(5)} ms  ${near} LSIs in view at zoom ${viewport.zoom.toFixed(3)}${far ? '' : ', as elements'}`);
}

try {
  await page.goto(service.address, { waitUntil: 'load' });
  while (!(await page.evaluate(() => window.ugoki?.connected))) await page.waitForTimeout(100);
  await page.evaluate(set_circuit, lsis);
  const tab = page.locator('.tab', { hasText: 'Circuit' });
  await tab.click();
  await tab.dblclick();
  await page.waitForTimeout(3000);
  await page.locator('.circuit[role=application]').focus();
  const box = await page.locator('.circuit[role=application]').boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height * 0.6];
  const pan = async () => {
    await page.mouse.move(x, y);
    await page.mouse.down({ button: 'middle' });
    for (let i = 1; i <= 60; i++) await page.mouse.move(x + 350 * Math.sin(i / 9), y + 200 * Math.sin(i / 13));
    await page.mouse.up({ button: 'middle' });
  };
  const zoom = async (steps) => {
    await page.mouse.move(x, y);
    for (let i = 0; i < Math.abs(steps); i++) {
      await page.mouse.wheel(0, steps > 0 ? -120 : 120);
      await page.waitForTimeout(16);
    }
  };
  await page.keyboard.press('a');
  await page.waitForTimeout(1500);
  await measure('pan, all in view', pan);
  await measure('zoom in', () => zoom(12));
  await measure('pan, small zoom', pan);
  await measure('zoom in to elements', () => zoom(10));
  await measure('pan, elements', pan);
  await measure('zoom out', () => zoom(-30));
  const count = await page.evaluate(() => window.ugoki.circuit().lsis.length);
  const wait = 1000;
  const during = async (act) => {
    const before = await cpu();
    await act();
    await page.waitForTimeout(wait);
    return (await cpu()) - before;
  };
  const idle = Math.min(await during(async () => {}), await during(async () => {}));
  for (let i = 0; i < 6; i++) {
    await page.keyboard.press('ArrowRight');
    await page.waitForTimeout(300);
    const spent = await during(() => page.keyboard.press('Shift+ArrowRight'));
    console.log(`one edit of ${count} LSIs  cpu ${(spent - idle).toFixed(1)} ms, from the key press to the last update by the service (without the ${idle.toFixed(1)} ms that an idle page uses in ${wait} ms)`);
  }
} finally {
  await browser.close();
  await service.stop();
}
