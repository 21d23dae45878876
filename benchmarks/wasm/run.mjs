// Runs content in the WebAssembly player and prints the minimum processor time of a run, in s, and the state hash at its end.
//   node run.mjs PLAYER.wasm CONTENT.ugx STEPS RUNS
import { readFileSync } from "node:fs";
import { WasmPlayer } from "../../tests/wasm/player.mjs";

const [module, content, steps, runs] = process.argv.slice(2);
const player = new WasmPlayer(module);
if (!player.open(readFileSync(content))) throw new Error(player.message);
let best = Infinity;
for (let i = 0; i <= Number(runs); ++i) { // the first run is not measured, because the compiler of the engine optimises during this run
  player.exports.ugoki_reset();
  const before = process.cpuUsage();
  if (player.exports.ugoki_step(Number(steps)) !== Number(steps)) throw new Error(player.message);
  const { user, system } = process.cpuUsage(before);
  if (i > 0) best = Math.min(best, (user + system) / 1e6);
}
console.log(`${best} ${player.hash}`);
