/**
 * Shading of bodies by vertices, and not by pixels. Without a graphics processor, each triangle is shaded in blocks of 4 x 4 pixels, most of which lie
 * outside it, so that a body has several times fewer vertices than shaded pixels. The vertices of a smooth surface are so close together that light
 * hardly changes between them, and the soft edges of shadows are wider. Materials whose shapes have larger triangles define LARGE_TRIANGLES: a pixel
 * then computes the shadow, and mixes the colours that the vertices have with and without the light that casts it.
 */
import * as THREE from 'three';
import { displayed, highlight, soft_shadow } from './shading';

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
#ifdef LARGE_TRIANGLES
  varying vec3 v_lit, v_shaded; // displayed colours by all lights, and by all lights except the first, which casts the shadow
#else
  varying vec3 v_color; // displayed
  #if defined(USE_SHADOWMAP) && NUM_DIR_LIGHT_SHADOWS > 0
    #define SHADOW
    uniform sampler2DShadow directionalShadowMap[NUM_DIR_LIGHT_SHADOWS];
    float shadow_of(sampler2DShadow shadowMap, vec3 shadowCoord, DirectionalLightShadow light) {
      vec2 radius = light.shadowRadius / light.shadowMapSize;
      shadowCoord.z += light.shadowBias;
      bool outside = any(lessThan(shadowCoord.xy, vec2(0.0))) || any(greaterThan(shadowCoord, vec3(1.0)));
      return outside ? 1.0 : mix(1.0, ${soft_shadow}, light.shadowIntensity);
    }
  #endif
#endif
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
  #ifdef LARGE_TRIANGLES
    v_shaded = displayed(shaded);
    v_lit = displayed(lit);
  #else
    float shadow = 1.0;
    #ifdef SHADOW
      if (receiveShadow) shadow = shadow_of(directionalShadowMap[0], vDirectionalShadowCoord[0].xyz, directionalLightShadows[0]);
    #endif
    v_color = mix(displayed(shaded), displayed(lit), shadow);
  #endif
}`;

const fragment_shader = `
#ifdef LARGE_TRIANGLES
  #include <common>
  #include <lights_pars_begin>
  #include <shadowmap_pars_fragment>
  varying vec3 v_lit, v_shaded;
#else
  varying vec3 v_color;
#endif
void main() {
  #ifdef LARGE_TRIANGLES
    float shadow = 1.0;
    #if defined(USE_SHADOWMAP) && NUM_DIR_LIGHT_SHADOWS > 0
      DirectionalLightShadow light = directionalLightShadows[0];
      if (receiveShadow) shadow = getShadow(directionalShadowMap[0], light.shadowMapSize, light.shadowIntensity, light.shadowBias, light.shadowRadius, vec4(vDirectionalShadowCoord[0].xyz, 1.0));
    #endif
    vec3 v_color = mix(v_shaded, v_lit, shadow);
  #endif
  gl_FragColor = vec4(v_color, 1.0);
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
  shader.vertexShader = add_behind(add_behind(shader.vertexShader, 'shadowmap_pars_vertex', declarations), 'shadowmap_vertex', light(look));
  shader.fragmentShader = fragment_shader;
  return true;
}
