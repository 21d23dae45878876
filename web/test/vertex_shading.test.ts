import * as THREE from 'three';
import { describe, expect, it } from 'vitest';
import { shade_by_vertices } from '../src/view/vertex_shading';

const look = { color: 'own_color', roughness: 'own_roughness', emission: 'own_light' };
const shader_of = (envMap: boolean): THREE.WebGLProgramParametersWithUniforms => {
  const { vertexShader, fragmentShader } = THREE.ShaderLib.standard;
  return { vertexShader, fragmentShader, envMap } as unknown as THREE.WebGLProgramParametersWithUniforms;
};
const whole = (text: string): string => text.replace(/#include <(\w+)>/g, (_, name: string) => whole((THREE.ShaderChunk as Record<string, string>)[name]!));

describe('shading by vertices', () => {
  it('computes colours in the vertex shader, where normal, place and light are known', () => {
    const shader = shader_of(false);
    expect(shade_by_vertices(shader, look)).toBe(true);
    const vertex = whole(shader.vertexShader);
    const place = vertex.indexOf('vec3 base = own_color');
    for (const known of ['vec4 mvPosition =', 'vec3 light_normal =', 'v_light_around +=']) expect(vertex.slice(0, place)).toContain(known);
    for (const used of ['own_roughness', 'own_light']) expect(vertex.slice(place)).toContain(used);
    const varyings = (text: string): string[] => [...text.matchAll(/varying vec3 (v_lit, v_shaded|v_color);/g)].map(([, names]) => names!);
    expect(varyings(whole(shader.fragmentShader))).toEqual(['v_lit, v_shaded', 'v_color']);
    expect(varyings(vertex)).toEqual(['v_lit, v_shaded', 'v_color']);
    expect(shader.fragmentShader).not.toContain('lights_fragment_begin');
  });

  it('leaves a material that reflects an environment as it is', () => {
    const shader = shader_of(true);
    expect(shade_by_vertices(shader, look)).toBe(false);
    expect(shader).toEqual(shader_of(true));
  });

  it('refuses a shader that it does not know', () => {
    const shader = { ...shader_of(false), vertexShader: '#include <normal_pars_vertex>' } as THREE.WebGLProgramParametersWithUniforms;
    expect(() => shade_by_vertices(shader, look)).toThrow('shadowmap_pars_vertex');
  });
});
