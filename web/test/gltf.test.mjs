// glTF files written by `ugoki convert` have no errors and no warnings in the Khronos glTF validator.
import { execFile } from 'node:child_process';
import { existsSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { validateBytes } from 'gltf-validator';
import { afterAll, describe, expect, it } from 'vitest';

const run = promisify(execFile);
const program = process.env.UGOKI_BIN ?? '';
const data = fileURLToPath(new URL('../../../shared/data', import.meta.url));
const folder = mkdtempSync(join(tmpdir(), 'ugoki-gltf-'));
afterAll(() => rmSync(folder, { recursive: true, force: true }));

const arm = `HIERARCHY
ROOT shoulder
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT elbow
  {
    OFFSET 0 -0.3 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 -0.28 0
    }
  }
}
MOTION
Frames: 3
Frame Time: 0.04
0 1.4 0 0 0 0 0 0 0
0 1.41 0 20 5 -3 40 0 0
0 1.42 0.1 35 9 -7 95 0 0
`;

/// Paths of motion files of the shared data. The program first solves marker recordings for joint angles.
function clips() {
  const list = (sub, endings) =>
    existsSync(join(data, sub)) ? readdirSync(join(data, sub)).filter((f) => endings.some((e) => f.endsWith(e))).map((f) => join(data, sub, f)) : [];
  return [
    ...list('human/bvh', ['.bvh']),
    ...list('human/asf_amc', ['.amc']),
    ...list('human/c3d', ['02_01.c3d']),
    ...list('animal', ['.glb', '.trc']).filter(canMove),
    ...list('gltf', ['.glb', '.gltf']).filter(isWhole).filter(canMove),
  ];
}

/// Whether all buffer files that a .gltf file names exist.
function isWhole(path) {
  if (!path.endsWith('.gltf')) return true;
  const { buffers = [] } = JSON.parse(readFileSync(path, 'utf8'));
  return buffers.every(({ uri = '' }) => uri === '' || uri.startsWith('data:') || existsSync(join(dirname(path), uri)));
}

/// Whether a file has more than meshes, which are no motion: a skin or an animation.
function canMove(path) {
  if (!/\.gl(b|tf)$/.test(path)) return true;
  const bytes = readFileSync(path);
  const text = path.endsWith('.glb') ? bytes.subarray(20, 20 + bytes.readUInt32LE(12)) : bytes;
  const { skins = [], animations = [] } = JSON.parse(text.toString());
  return skins.length + animations.length > 0;
}

/// Errors and warnings of the validator for the file that the program writes from `input`.
async function faults(input, verb = ['convert', input]) {
  const output = join(folder, `${basename(input)}.glb`);
  await run(program, verb[0] === 'convert' ? [...verb, output] : [...verb, '-o', output]);
  const report = await validateBytes(new Uint8Array(readFileSync(output)), { maxIssues: 1000 });
  rmSync(output);
  expect(report.info.animationCount).toBe(1);
  expect(report.info.hasSkins).toBe(true);
  expect(report.issues.truncated).toBe(false);
  return report.issues.messages.filter((m) => m.severity < 2).map((m) => `${m.code} ${m.pointer}: ${m.message}`);
}

describe.skipIf(!existsSync(program))('written glTF', () => {
  it('is valid for a small motion', async () => {
    writeFileSync(join(folder, 'arm.bvh'), arm);
    expect(await faults(join(folder, 'arm.bvh'))).toEqual([]);
  });

  const walk = join(data, 'human/bvh/cmu_12_01_walk.bvh');
  it.skipIf(!existsSync(walk))('is valid for motions of mechanisms', async () => {
    expect(await faults(walk, ['retarget', walk, '--to', 'dog'])).toEqual([]);
    expect(await faults(walk, ['motion', 'reverse', walk])).toEqual([]);
  }, 60_000);

  it.each(clips().map((path) => [basename(path), path]))('is valid for %s', async (_, path) => {
    expect(await faults(path)).toEqual([]);
  }, 60_000);
});
