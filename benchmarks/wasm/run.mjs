// Runs content in the WebAssembly player of a page, and prints the minimum processor time of a run, in s, and the state hash at its end.
//   node run.mjs PLAYER.wasm CONTENT.ugx STEPS RUNS
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { launch } from "../../web/e2e/browser.mjs";

const [module, content, steps, runs] = process.argv.slice(2);
const script = readFileSync(new URL("../../tests/wasm/player.mjs", import.meta.url), "utf8");
const files = {
  "/": ["text/html", ""],
  "/player.mjs": ["text/javascript", script.replace(/^import .*$/m, "const readFileSync = (bytes) => bytes;")],
  "/player.wasm": ["application/wasm", readFileSync(module)],
  "/content.ugx": ["application/octet-stream", readFileSync(content)],
};
const server = createServer(({ url }, answer) => {
  const [type, body] = files[url] ?? ["text/plain", ""];
  answer.setHeader("Content-Type", type).end(body);
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const browser = await launch();
try {
  const page = await browser.newPage();
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  await page.evaluate(async () => {
    const { WasmPlayer } = await import("/player.mjs");
    const bytes = async (file) => new Uint8Array(await (await fetch(file)).arrayBuffer());
    window.player = new WasmPlayer(await bytes("/player.wasm"));
    if (!player.open(await bytes("/content.ugx"))) throw new Error(player.message);
  });
  const metrics = await page.context().newCDPSession(page);
  await metrics.send("Performance.enable", { timeDomain: "threadTicks" });
  const processor_time = async () => (await metrics.send("Performance.getMetrics")).metrics.find((m) => m.name === "TaskDuration").value;
  let best = Infinity;
  for (let i = 0; i <= Number(runs); ++i) { // the first run is not measured, because the compiler of the browser optimises during this run
    const before = await processor_time();
    await page.evaluate((count) => {
      player.exports.ugoki_reset();
      if (player.exports.ugoki_step(count) !== count) throw new Error(player.message);
    }, Number(steps));
    if (i > 0) best = Math.min(best, (await processor_time()) - before);
  }
  console.log(`${best} ${await page.evaluate(() => player.hash)}`);
} finally {
  await browser.close();
  server.close();
}
