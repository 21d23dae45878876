import * as THREE from 'three';
import { describe, expect, it } from 'vitest';

await import('../src/view/shading');

describe('the shading of bodies', () => {
  it('takes a shadow at four points whose distances across and along the map are equal', () => {
    const chunk = THREE.ShaderChunk.shadowmap_pars_fragment;
    const points = [...chunk.matchAll(/radius \* vec2\(([-\d.]+), ([-\d.]+)\)/g)].map(([, x, y]) => [Number(x), Number(y)] as const);
    for (const axis of [0, 1] as const) expect(points.map((point) => point[axis]).sort((a, b) => a - b)).toEqual([-0.75, -0.25, 0.25, 0.75]);
    expect(points.reduce((sum, [x, y]) => sum + x * y, 0)).toBe(0); // on no common diagonal
  });

  it('computes the light of the first light by pixels and the rest by vertices', () => {
    const { lights_fragment_begin: pixel, normal_vertex: vertex } = THREE.ShaderChunk;
    expect(pixel).toMatch(/#if !defined\(LIGHT_BY_VERTEX\) \|\| UNROLLED_LOOP_INDEX < 1[^\n]*\n\s*directionalLight = [^]*?RE_Direct\([^;]*;\n#endif/);
    expect(pixel).toMatch(/#ifdef LIGHT_BY_VERTEX\nirradiance \+= v_light_around;\n#elif NUM_HEMI_LIGHTS > 0/);
    expect(vertex).toContain('for (int k = max(1, NUM_DIR_LIGHT_SHADOWS)');
  });

  it('leaves materials that reflect an environment as they are', () => {
    expect(THREE.ShaderChunk.lights_physical_pars_fragment).toMatch(/^#ifdef USE_ENVMAP[^]*dfgLUT[^]*#else[^]*#endif\s*$/);
    expect(THREE.ShaderChunk.lights_fragment_begin).not.toContain('#ifdef STANDARD\n');
  });
});
