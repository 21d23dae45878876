/**
 * Shading of bodies by vertices: the displayed colours with and without the light that casts shadows are computed for each vertex, and a pixel
 * only mixes them by its shadow. Bodies have small triangles, so that the light hardly changes within one; and without a graphics processor, each
 * triangle is shaded in blocks of 4 x 4 pixels, most of which lie outside it.
 */
import * as THREE from 'three';
import { displayed, highlight } from './shading';

/** What the vertex shader of a material computes from: expressions in GLSL. */
export interface VertexLook {
  /** vec3: colour of the surface (linear). */
  color: string;
  /** float: roughness, 0 ... 1. */
  roughness: string;
  /** vec3: light that the surface emits. */
  emission: string;
}

/** GLSL: light that emphasised links emit. */
export const glow_light = 'v_glow.x * vec3(1.0) + v_glow.y * vec3(1.0, 0.254, 0.047)';

const declarations = `
uniform vec3 diffuse, emissive;
uniform float roughness;
varying vec3 v_lit, v_shaded; // displayed colours by all lights, and by all lights except the first, which casts the shadow
${displayed}
${highlight}`;

const light = ({ color, roughness, emission }: VertexLook): string => `
{
  vec3 base = ${color};
  vec3 shaded = ${emission};
  vec3 lit = shaded;
  #ifdef LIGHT_BY_VERTEX
    shaded += RECIPROCAL_PI * 0.96 * base * v_light_around;
    vec3 to_light = directionalLights[0].direction;
    vec3 to_viewer = isOrthographic ? vec3(0.0, 0.0, 1.0) : normalize(-mvPosition.xyz);
    vec2 shine = highlight(to_light, light_normal, to_viewer, max(${roughness}, 0.045));
    float mirrored = mix(0.04, 1.0, shine.x); // share of the light that a non-metal mirrors
    vec3 scattered = RECIPROCAL_PI * saturate(dot(light_normal, to_light)) * directionalLights[0].color;
    lit = shaded + scattered * (base * (1.0 - mirrored) + mirrored * shine.y);
  #endif
  v_shaded = displayed(shaded);
  v_lit = displayed(lit);
}`;

const fragment_shader = `
#include <common>
#include <lights_pars_begin>
#include <shadowmap_pars_fragment>
varying vec3 v_lit, v_shaded;
void main() {
  float shadow = 1.0;
  #if defined(USE_SHADOWMAP) && NUM_DIR_LIGHT_SHADOWS > 0
    DirectionalLightShadow light = directionalLightShadows[0];
    if (receiveShadow) shadow = getShadow(directionalShadowMap[0], light.shadowMapSize, light.shadowIntensity, light.shadowBias, light.shadowRadius, vec4(vDirectionalShadowCoord[0].xyz, 1.0));
  #endif
  gl_FragColor = vec4(mix(v_shaded, v_lit, shadow), 1.0);
}`;

/** Puts text behind a chunk that a shader includes. @throws if it does not, which would be another version of three.js */
function add_behind(shader: string, chunk: string, text: string): string {
  const include = `#include <${chunk}>`;
  if (!shader.includes(include)) throw new Error(`The shader of three.js does not include ${chunk} any more.`);
  return shader.replace(include, (all) => all + text);
}

/**
 * Makes an opaque standard material shade by vertices. To be called by its onBeforeCompile().
 * @return false if the material reflects an environment; it is then shaded by pixels, and nothing is changed
 */
export function shade_by_vertices(shader: THREE.WebGLProgramParametersWithUniforms, look: VertexLook): boolean {
  if ((shader as unknown as { envMap: boolean }).envMap) return false; // @types/three does not declare it
  shader.vertexShader = add_behind(add_behind(shader.vertexShader, 'normal_pars_vertex', declarations), 'shadowmap_vertex', light(look));
  shader.fragmentShader = fragment_shader;
  return true;
}
