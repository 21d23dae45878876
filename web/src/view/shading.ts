/**
 * Shading of bodies with fewer operations than that of three.js, because without a graphics processor the bodies take most of the time of a
 * picture. Importing this module changes the chunks of three.js's shaders, for pages, pictures and the studio alike.
 */
import * as THREE from 'three';

/** Replaces `from` in a chunk. @throws if the chunk does not contain it, which would be another version of three.js */
function change(chunk: keyof typeof THREE.ShaderChunk, from: string | RegExp, to: (...found: string[]) => string): void {
  const before = THREE.ShaderChunk[chunk];
  const after = before.replace(from, to);
  if (after === before) throw new Error(`The shader chunk ${chunk} of three.js has changed.`);
  (THREE.ShaderChunk as Record<string, string>)[chunk] = after;
}

// Soft shadows: four points on a rotated grid, whose distances across and along the shadow map are equal. Each reads four texels, so that an edge
// fades evenly and without noise over `shadowRadius` texels on each side. Points that are turned differently in each pixel, as in three.js, need
// one point more, sine and cosine.
const offsets = [[1, 3], [3, -1], [-1, -3], [-3, 1]].map(([x, y]) => `vec2(${(x! / 4).toFixed(2)}, ${(y! / 4).toFixed(2)})`);
const sum = offsets.map((offset) => `texture(shadowMap, vec3(shadowCoord.xy + radius * ${offset}, shadowCoord.z))`).join(' + ');
/** GLSL: share of the light that reaches `shadowCoord` in `shadowMap`. @param radius vec2, of the soft edge, relative to the size of the map */
export const soft_shadow = `0.25 * (${sum})`;
change('shadowmap_pars_fragment', /if \( frustumTest \) \{[^]*?\* 0\.2;\s*\}/, () => `vec2 radius = shadowRadius / shadowMapSize;\nif (frustumTest) shadow = ${soft_shadow};`);

/** GLSL: the displayed (sRGB) colour of a linear one. */
export const displayed = 'vec3 displayed(vec3 c) { return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)); }';

/**
 * GLSL: how light is mirrored by a surface without reflections of an environment: share of the way from the mirrored colour to white (Fresnel's law
 * after Schlick), and the ratio of the highlight to the light that a white surface scatters (GGX, with the Smith visibility in the linear form of
 * Hammon, 2017).
 */
export const highlight = `
vec2 highlight(vec3 to_light, vec3 normal, vec3 to_viewer, float roughness) {
  vec3 between = to_light + to_viewer;
  between *= inversesqrt(max(dot(between, between), 1e-6));
  float facing = saturate(dot(normal, between));
  float facing_light = saturate(dot(normal, to_light));
  float facing_viewer = saturate(dot(normal, to_viewer));
  float away = 1.0 - saturate(dot(to_viewer, between));
  float away_squared = away * away;
  float alpha = roughness * roughness;
  float spread = facing * facing * (alpha * alpha - 1.0) + 1.0;
  float hidden = mix(2.0 * facing_light * facing_viewer, facing_light + facing_viewer, alpha);
  return vec2(away_squared * away_squared * away, 0.5 * alpha * alpha / max(spread * spread * hidden, 1e-6));
}`;

// Light on materials that reflect no environment: scattered (Lambert) and mirrored. Left out are the tables by which three.js corrects the energy
// of light that is reflected several times within the surface, which is less than 1 % for non-metals.
const light = `
struct PhysicalMaterial {
  vec3 diffuseColor, diffuseContribution, specularColor, specularColorBlended;
  float roughness, metalness, specularF90;
};
${highlight}
void light_directly(const in IncidentLight light, const in vec3 position, const in vec3 normal, const in vec3 view, const in vec3 coat, const in PhysicalMaterial material, inout ReflectedLight reflected) {
  vec3 scattered = RECIPROCAL_PI * saturate(dot(normal, light.direction)) * light.color;
  vec2 shine = highlight(light.direction, normal, view, material.roughness);
  vec3 mirrored = mix(material.specularColorBlended, vec3(1.0), shine.x);
  reflected.directSpecular += scattered * mirrored * shine.y;
  reflected.directDiffuse += scattered * material.diffuseContribution * (1.0 - mirrored);
}
void light_around(const in vec3 irradiance, const in vec3 position, const in vec3 normal, const in vec3 view, const in vec3 coat, const in PhysicalMaterial material, inout ReflectedLight reflected) {
  reflected.indirectDiffuse += RECIPROCAL_PI * irradiance * material.diffuseContribution * (1.0 - material.specularColor);
}
#define RE_Direct light_directly
#define RE_IndirectDiffuse light_around`;
change('lights_physical_pars_fragment', /^[^]*$/, (all) => `#ifdef USE_ENVMAP\n${all}\n#else\n${light}\n#endif\n`);
change('lights_fragment_begin', '#ifdef STANDARD', () => '#if defined(STANDARD) && defined(USE_ENVMAP)');

// The light of the sky and of further lights changes slowly over a surface, so that it is computed for each vertex and not for each pixel. Only the
// first light, and lights with shadows, make highlights on such materials.
const by_vertex = '#if defined(STANDARD) && !defined(USE_ENVMAP) && !defined(USE_NORMALMAP) && !defined(FLAT_SHADED) && !defined(DOUBLE_SIDED) && NUM_DIR_LIGHTS > 0 && NUM_HEMI_LIGHTS > 0';
change('normal_pars_vertex', /$/, () => `\n${by_vertex}\n#define LIGHT_BY_VERTEX\nvarying vec3 v_light_around;\n#include <lights_pars_begin>\n#endif\n`);
change('normal_vertex', /$/, () => `
#ifdef LIGHT_BY_VERTEX
  v_light_around = vec3(0.0);
  vec3 light_normal = normalize(transformedNormal);
  #pragma unroll_loop_start
  for ( int i = 0; i < NUM_HEMI_LIGHTS; i ++ ) {
    v_light_around += getHemisphereLightIrradiance(hemisphereLights[ i ], light_normal);
  }
  #pragma unroll_loop_end
  for (int k = max(1, NUM_DIR_LIGHT_SHADOWS); k < NUM_DIR_LIGHTS; k++) v_light_around += max(0.0, dot(light_normal, directionalLights[k].direction)) * directionalLights[k].color;
#endif
`);
change('normal_pars_fragment', /$/, () => `\n${by_vertex}\n#define LIGHT_BY_VERTEX\nvarying vec3 v_light_around;\n#endif\n`);
change('lights_fragment_begin', /directionalLight = directionalLights\[ i \];[^]*?RE_Direct\([^;]*;/, (all) => `#if !defined(LIGHT_BY_VERTEX) || UNROLLED_LOOP_INDEX < 1 || UNROLLED_LOOP_INDEX < NUM_DIR_LIGHT_SHADOWS\n${all}\n#endif`);
change('lights_fragment_begin', '#if ( NUM_HEMI_LIGHTS > 0 )', () => `#ifdef LIGHT_BY_VERTEX\nirradiance += v_light_around;\n#elif NUM_HEMI_LIGHTS > 0`);

// The shadow coordinate of a light without perspective needs no division.
change('lights_fragment_begin', 'vDirectionalShadowCoord[ i ]', () => 'vec4(vDirectionalShadowCoord[ i ].xyz, 1.0)');
