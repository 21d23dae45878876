// The glTF files that `ugoki convert` writes pass the validator of the format's makers: no errors, no warnings.
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

/// Motions of the shared data; recordings of markers are solved first.
function clips() {
  const list = (sub, endings) =>
    existsSync(join(data, sub)) ? readdirSync(join(data, sub)).filter((f) => endings.some((e) => f.endsWith(e))).map((f) => join(data, sub, f)) : [];
  return [
    ...list('human/bvh', ['.bvh']),
    ...list('human/asf_amc', ['.amc']),
    ...list('human/c3d', ['02_01.c3d']),
    ...list('animal', ['.glb', '.trc']),
    ...list('gltf', ['.glb', '.gltf']).filter(isWhole),
  ];
}

/// Whether the buffers that a .gltf file names are beside it.
function isWhole(path) {
  if (!path.endsWith('.gltf')) return true;
  const { buffers = [] } = JSON.parse(readFileSync(path, 'utf8'));
  return buffers.every(({ uri = '' }) => uri === '' || uri.startsWith('data:') || existsSync(join(dirname(path), uri)));
}

/// Everything that the validator says against the file that the program writes, hints and infos apart.
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

describe.skipIf(!existsSync(program))('glTF that is written', () => {
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
