import * as THREE from 'three';
import { describe, expect, it } from 'vitest';

const before = THREE.ShaderChunk.shadowmap_pars_fragment;
await import('../src/view/shading');

describe('the shading of bodies', () => {
  it('takes shadows at the points of three.js', () => {
    const chunk = THREE.ShaderChunk.shadowmap_pars_fragment;
    const points = [...chunk.matchAll(/turn \* vec2\(([-\d.]+), ([-\d.]+)\)/g)].map(([, x, y]) => [Number(x), Number(y)]);
    expect(points.length).toBe(before.match(/vogelDiskSample\( \d/g)!.length);
    points.slice(0, 5).forEach(([x, y], index) => {
      // the formula of vogelDiskSample() for phi = 0
      const r = Math.sqrt((index + 0.5) / 5);
      expect(x).toBeCloseTo(Math.cos(index * 2.399963229728653) * r, 6);
      expect(y).toBeCloseTo(Math.sin(index * 2.399963229728653) * r, 6);
    });
    expect(chunk).not.toMatch(/vogelDiskSample\( \d/);
  });

  it('leaves materials that reflect an environment as they are', () => {
    expect(THREE.ShaderChunk.lights_physical_pars_fragment).toMatch(/^#ifdef USE_ENVMAP[^]*dfgLUT[^]*#else[^]*#endif\s*$/);
    expect(THREE.ShaderChunk.lights_fragment_begin).not.toContain('#ifdef STANDARD\n');
  });
});
