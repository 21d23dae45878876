import { expect, test } from 'vitest';
import type { MechanismData, SkinData } from '../src/core/protocol';
import { bytes_of_skins, skin_bytes } from '../src/core/skins';

const skin: SkinData = { positions: btoa('x'.repeat(36)), normals: btoa('x'.repeat(36)), uvs: btoa('x'.repeat(24)), bones: btoa('x'.repeat(25)), weights: '', indices: btoa('x'.repeat(12)), parts: [], textures: [{ type: 'image/png', data: btoa('x'.repeat(1000)) }], links: [], matrices: [] };

test('the size of a skin is that of its lists and textures, and characters share it', () => {
  expect(skin_bytes(skin)).toBe(36 + 36 + 24 + 25 + 12 + 1000);
  const mechanisms = { a: { skin }, b: {} } as unknown as Record<string, MechanismData>;
  expect(bytes_of_skins([{ mechanism: 'a' }, { mechanism: 'b' }, { mechanism: 'a' }, { mechanism: 'not loaded' }], mechanisms)).toBe(skin_bytes(skin));
});
