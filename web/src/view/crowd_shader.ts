/** Materials of a crowd: three.js's materials with instances whose links are posed from a texture. */
import * as THREE from 'three';
import { draw_relief } from './relief';
import { glow_light, shade_by_vertices } from './vertex_shading';

/** Texels in a row of the textures of a crowd; every WebGL 2 has textures of this width. */
export const texel_row = 1024;

export interface CrowdUniforms {
  /** Number of links of a character. */
  u_links: { value: number };
  /** Two texels for each link of each instance: position (m) and quaternion (xyzw) of the motion from the rest pose. */
  u_poses: { value: THREE.Texture | null };
  /** Two texels for each link of each instance: colour (linear), and the amounts of white and of the accent colour that it emits. */
  u_marks: { value: THREE.Texture | null };
}

const common = `
uniform int u_links;
uniform highp sampler2D u_poses;
attribute vec4 skinIndex;
attribute vec4 skinWeight;
vec4 crowd_texel(highp sampler2D from, int index) { return texelFetch(from, ivec2(index % ${texel_row}, index / ${texel_row}), 0); }
vec3 crowd_turn(vec4 q, vec3 v) { return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }
int crowd_link(float link) { return 2 * (u_links * gl_InstanceID + int(link)); }
void crowd_pose(inout vec3 at, inout vec3 along) {
  vec3 point = vec3(0.0), direction = vec3(0.0);
  for (int k = 0; k < 4; k++) {
    if (skinWeight[k] == 0.0) continue;
    int i = crowd_link(skinIndex[k]);
    vec4 q = crowd_texel(u_poses, i + 1);
    point += skinWeight[k] * (crowd_turn(q, at) + crowd_texel(u_poses, i).xyz);
    direction += skinWeight[k] * crowd_turn(q, along);
  }
  at = point;
  along = direction;
}`;

const looks = `
uniform highp sampler2D u_marks;
attribute vec3 a_color;
attribute vec3 a_surface;
#ifdef OWN_COLORS
attribute vec4 own_color;
#endif
varying vec3 v_tint;
varying vec2 v_glow;
varying vec2 v_surface;
void crowd_own() {
#ifdef OWN_COLORS
  v_tint = mix(v_tint, own_color.rgb, own_color.a);
#endif
}
void crowd_look() {
  v_surface = a_surface.xy;
  v_tint = a_color;
  v_glow = vec2(0.0);
  if (a_surface.z < 0.5) return;
  v_tint = vec3(0.0);
  float sum = 0.0;
  for (int k = 0; k < 4; k++) {
    if (skinWeight[k] == 0.0) continue;
    int i = crowd_link(skinIndex[k]);
    float share = pow(skinWeight[k], 6.0); // colours change over a short distance around a joint
    v_tint += share * crowd_texel(u_marks, i).rgb;
    v_glow += skinWeight[k] * crowd_texel(u_marks, i + 1).xy;
    sum += share;
  }
  v_tint /= sum;
}`;

/**
 * The shaded material. Colour, roughness and metalness are attributes of the instances.
 * @param options own_colors: the vertices have the attribute `own_color`: r g b (linear) and the share of it in the colour; by_vertices: bodies are
 * shaded by vertices (shade_by_vertices()); relief: the vertices have a relief, which is drawn unless they are shaded by vertices; whole_body: nothing but the smooth surface of a body is drawn
 */
export function crowd_material(uniforms: CrowdUniforms, { own_colors, by_vertices, relief, whole_body }: { own_colors: boolean; by_vertices: boolean; relief: boolean; whole_body: boolean }): THREE.MeshStandardMaterial {
  const material = new THREE.MeshStandardMaterial();
  if (own_colors) material.defines = { ...material.defines, OWN_COLORS: '' };
  if (by_vertices) material.defines = { ...material.defines, BY_VERTICES: '', ...(whole_body ? {} : { LARGE_TRIANGLES: '' }) };
  if (relief && !by_vertices) material.defines = { ...material.defines, RELIEF: '' };
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', `#include <common>${common}${looks}`)
      .replace('#include <beginnormal_vertex>', 'vec3 crowd_position = position;\nvec3 objectNormal = normal;\ncrowd_pose(crowd_position, objectNormal);\ncrowd_look();\ncrowd_own();')
      .replace('#include <begin_vertex>', 'vec3 transformed = crowd_position;');
    if (by_vertices && shade_by_vertices(shader, { color: 'v_tint', roughness: 'v_surface.x', emission: glow_light })) return;
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', '#include <common>\nvarying vec3 v_tint;\nvarying vec2 v_glow;\nvarying vec2 v_surface;')
      .replace('#include <color_fragment>', 'diffuseColor.rgb = v_tint;')
      .replace('#include <roughnessmap_fragment>', 'float roughnessFactor = v_surface.x;')
      .replace('#include <metalnessmap_fragment>', 'float metalnessFactor = v_surface.y;')
      .replace('#include <emissivemap_fragment>', `totalEmissiveRadiance += ${glow_light};`);
    if (relief) draw_relief(shader);
  };
  return material;
}

/** The material with which shadows are drawn. */
export function crowd_depth(uniforms: CrowdUniforms): THREE.MeshDepthMaterial {
  const material = new THREE.MeshDepthMaterial({ colorWrite: false });
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', `#include <common>${common}`)
      .replace('#include <begin_vertex>', 'vec3 transformed = position;\nvec3 crowd_normal = vec3(0.0);\ncrowd_pose(transformed, crowd_normal);');
  };
  return material;
}
