// Test of the WebAssembly player: the sample and the golden contents must give the same states, bit by bit, as in the native player.
//   node run.mjs FOLDER_OF_WASM FOLDER_OF_NATIVE_PROGRAMS
// Prints `ok ...` or `not ok ...` for each test. Exit status 1 if a test failed.
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { WasmPlayer } from "./player.mjs";

const [wasmFolder, nativeFolder] = process.argv.slice(2);
const steps = 600;
const every = 60;
let failures = 0;

function test(name, body) {
  try {
    body();
    console.log(`ok ${name}`);
  } catch (error) {
    failures += 1;
    console.log(`not ok ${name}\n${error.stack ?? error}`);
  }
}

function expect(condition, message) {
  if (!condition) throw new Error(message);
}

const folder = mkdtempSync(join(tmpdir(), "ugoki-wasm-"));
const file = join(folder, "sample.ugx");
const native = spawnSync(join(nativeFolder, "ugoki_wasm_reference"), [file, steps, every], { encoding: "utf8" });
if (native.status !== 0) {
  console.log(`not ok the native player runs the sample\n${native.error ?? ""}${native.stderr ?? ""}`);
  process.exit(1);
}
const checkpoints = native.stdout
  .trim()
  .split("\n")
  .map((line) => line.split(" "))
  .map(([step, hash]) => ({ step: Number(step), hash }));
const content = readFileSync(file);
rmSync(folder, { recursive: true });

const player = new WasmPlayer(join(wasmFolder, "ugoki_player.wasm"));

function run() {
  player.exports.ugoki_reset();
  let done = 0;
  return checkpoints.map(({ step }) => {
    const wanted = step - done;
    const stepped = player.exports.ugoki_step(wanted);
    expect(stepped === wanted, `stopped at step ${done + stepped}: ${player.message}`);
    done = step;
    return { step, hash: player.hash };
  });
}

test("imports only the WASI functions that player.mjs provides", () => {
  const wanted = WebAssembly.Module.imports(player.module).map(({ module, name }) => `${module}.${name}`);
  const offered = Object.keys(player.offered).map((name) => `wasi_snapshot_preview1.${name}`);
  const missing = wanted.filter((name) => !offered.includes(name));
  expect(missing.length === 0, `imports ${missing.join(", ")}`);
});

test("opens the sample content", () => {
  expect(player.open(content), player.message);
  expect(player.exports.ugoki_duration() > 0 && player.exports.ugoki_step_size() > 0, "no duration or step");
});

test(`${steps} steps give the native hashes`, () => {
  expect(checkpoints.length === steps / every, `the native run printed ${checkpoints.length} checkpoints`);
  const began = performance.now();
  for (const [i, { step, hash }] of run().entries()) {
    expect(hash === checkpoints[i].hash, `step ${step}: WebAssembly ${hash}, native ${checkpoints[i].hash}`);
  }
  console.log(`# ${((performance.now() - began) / steps).toFixed(3)} ms a step in WebAssembly`);
});

test("every checkpoint has a different state", () => {
  expect(new Set(checkpoints.map(({ hash }) => hash)).size === checkpoints.length, "the characters do not move");
});

test("a second run gives the same hashes", () => {
  for (const [i, { step, hash }] of run().entries()) expect(hash === checkpoints[i].hash, `step ${step}: ${hash}`);
});

test("a push changes the states", () => {
  player.exports.ugoki_reset();
  player.exports.ugoki_push(0, 0, 150, 0, 0, 0.2);
  expect(player.exports.ugoki_step(every) === every, player.message);
  expect(player.hash !== checkpoints[0].hash, "the push had no effect");
});

test("accepts device input and refuses unknown keys", () => {
  const { keyboard, mouse, gamepads } = player.devices;
  expect(keyboard.length === 0 && mouse === false && gamepads.length === 0, "the sample reads no devices");
  player.exports.ugoki_reset();
  expect(player.input('{"keyboard": ["KeyW"], "mouse": {"x": 0.5, "left": true}}'), player.message);
  expect(player.exports.ugoki_step(every) === every, player.message);
  expect(player.hash === checkpoints[0].hash, "a key that the content does not read changed the states");
  expect(!player.input('{"keyboard": ["no key"]}') && player.message.includes("KeyboardEvent.code"), player.message);
  player.exports.ugoki_reset();
});

test("returns display frames", () => {
  const first = player.frame(1);
  expect(player.exports.ugoki_step(every) === every, player.message);
  const second = player.frame(2);
  expect(first.length > 64 && second.length > 64, `frames of ${first.length} and ${second.length} bytes`);
  expect(Buffer.compare(first, second) !== 0, "two frames at different times are equal");
});

// The golden contents must give the hashes of tests/golden/hashes.txt up to this step, as the native programs do with every SIMD width.
const goldenSteps = 500;
const golden = readFileSync(new URL("../golden/hashes.txt", import.meta.url), "utf8")
  .split("\n")
  .filter((line) => line && !line.startsWith("#"))
  .map((line) => line.split(" "))
  .map(([name, step, hash]) => ({ name, step: Number(step), hash }))
  .filter(({ step }) => step <= goldenSteps);
const goldenFolder = mkdtempSync(join(tmpdir(), "ugoki-golden-"));
const written = spawnSync(join(nativeFolder, "ugoki_golden_hashes"), ["contents", goldenFolder], { encoding: "utf8" });
for (const name of new Set(golden.map((line) => line.name))) {
  test(`${goldenSteps} steps of the golden content ${name} give the kept hashes`, () => {
    expect(written.status === 0, `ugoki_golden_hashes failed: ${written.error ?? ""}${written.stderr ?? ""}`);
    expect(player.open(readFileSync(join(goldenFolder, `${name}.ugx`))), player.message);
    let done = 0;
    for (const { step, hash } of golden.filter((line) => line.name === name)) {
      expect(player.exports.ugoki_step(step - done) === step - done, player.message);
      done = step;
      expect(player.hash === hash, `step ${step}: WebAssembly ${player.hash}, kept ${hash}`);
    }
    expect(done === goldenSteps, `hashes end at step ${done}`);
  });
}
rmSync(goldenFolder, { recursive: true });

test("converts pictures to the levels of ITU-R BT.709 in limited range", () => {
  const module = new WebAssembly.Module(readFileSync(join(wasmFolder, "ugoki_planar.wasm")));
  const { memory, ugoki_planar } = new WebAssembly.Instance(module).exports;
  const [width, height] = [38, 6]; // no multiple of the number of pixels that are converted at once
  const count = width * height;
  const rgba = memory.buffer.byteLength;
  memory.grow(1);
  const pixels = new Uint8Array(memory.buffer, rgba, 4 * count);
  for (let i = 0, random = 1; i < pixels.length; ++i) {
    random = (Math.imul(random, 1664525) + 1013904223) >>> 0;
    pixels[i] = [0, 255, random >>> 24][(random >>> 16) % 3];
  }
  ugoki_planar(rgba, width, height, rgba + 4 * count);
  const out = new Uint8Array(memory.buffer, rgba + 4 * count, (3 * count) / 2);
  const color = (x, y) => [0, 1, 2].map((k) => pixels[4 * ((height - 1 - y) * width + x) + k] / 255);
  const luma = ([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;
  const check = (at, wanted) => expect(Math.abs(out[at] - wanted) < 0.51, `byte ${at} is ${out[at]}, wanted ${wanted}`);
  for (let y = 0; y < height; ++y) for (let x = 0; x < width; ++x) check(y * width + x, 16 + 219 * luma(color(x, y)));
  for (let y = 0; y < height; y += 2)
    for (let x = 0; x < width; x += 2) {
      const block = [color(x, y), color(x + 1, y), color(x, y + 1), color(x + 1, y + 1)];
      const mean = [0, 1, 2].map((k) => block.reduce((sum, c) => sum + c[k] / 4, 0));
      const at = count + (y * width) / 4 + x / 2;
      check(at, 128 + (224 * (mean[2] - luma(mean))) / 1.8556);
      check(at + count / 4, 128 + (224 * (mean[0] - luma(mean))) / 1.5748);
    }
});

test("refuses damaged executable data with a message", () => {
  const sizes = [0, 1, 8, 31, 32, 100, 1000, content.length >> 1, content.length - 1];
  for (const size of sizes) {
    expect(!player.open(content.subarray(0, size)), `accepted the first ${size} bytes`);
    expect(player.message.length > 20, `no message for the first ${size} bytes`);
  }
  const damaged = Uint8Array.from(content);
  damaged[damaged.length >> 1] ^= 1;
  expect(!player.open(damaged), "accepted a flipped bit");
  expect(player.exports.ugoki_step(1) === 0, "steps without content");
  expect(player.open(content), player.message);
});

process.exit(failures ? 1 : 0);
