/**
 * Shading of bodies with fewer operations than that of three.js, because without a graphics processor the bodies take most of the time of a
 * picture. Importing this module changes the chunks of three.js's shaders, for pages, pictures and the studio alike.
 */
import * as THREE from 'three';

const taps = 5; // of a soft shadow

/** Point `index` of a spiral (Vogel) that covers the unit disc evenly with `taps` points. */
const tap = (index: number): [number, number] => {
  const radius = Math.sqrt((index + 0.5) / taps);
  const angle = index * 2.399963229728653; // golden angle, rad
  return [radius * Math.cos(angle), radius * Math.sin(angle)];
};

/** Replaces `from` in a chunk. @throws if the chunk does not contain it, which would be another version of three.js */
function change(chunk: keyof typeof THREE.ShaderChunk, from: string | RegExp, to: (...found: string[]) => string): void {
  const before = THREE.ShaderChunk[chunk];
  const after = before.replace(from, to);
  if (after === before) throw new Error(`The shader chunk ${chunk} of three.js has changed.`);
  (THREE.ShaderChunk as Record<string, string>)[chunk] = after;
}

// Shadows: one rotation of fixed points for each pixel instead of a sine and a cosine for each point. The result is the same.
change('shadowmap_pars_fragment', /float phi = interleavedGradientNoise\( gl_FragCoord\.xy \) \* PI2;/g, (phi) => `${phi}\nmat2 turn = mat2(cos(phi), sin(phi), -sin(phi), cos(phi));`);
change('shadowmap_pars_fragment', /vogelDiskSample\( (\d), 5, phi \)/g, (_all, index) => `(turn * vec2(${tap(Number(index)).map((v) => v.toFixed(7)).join(', ')}))`);

// Light on materials that reflect no environment: diffuse (Lambert) and specular (GGX, with the Smith visibility in the linear form of
// Hammon, 2017). Left out are the tables by which three.js corrects the energy of light that is reflected several times within the surface,
// which is less than 1 % for non-metals.
const light = `
struct PhysicalMaterial {
  vec3 diffuseColor, diffuseContribution, specularColor, specularColorBlended;
  float roughness, metalness, specularF90;
};
void light_directly(const in IncidentLight light, const in vec3 position, const in vec3 normal, const in vec3 view, const in vec3 coat, const in PhysicalMaterial material, inout ReflectedLight reflected) {
  float to_light = saturate(dot(normal, light.direction));
  vec3 irradiance = RECIPROCAL_PI * to_light * light.color;
  vec3 between = light.direction + view;
  between *= inversesqrt(max(dot(between, between), 1e-6));
  float facing = saturate(dot(normal, between));
  float to_view = saturate(dot(normal, view));
  float away = 1.0 - saturate(dot(view, between));
  float away_squared = away * away;
  vec3 mirrored = mix(material.specularColorBlended, vec3(1.0), away_squared * away_squared * away);
  float alpha = material.roughness * material.roughness;
  float spread = facing * facing * (alpha * alpha - 1.0) + 1.0;
  float hidden = mix(2.0 * to_light * to_view, to_light + to_view, alpha);
  reflected.directSpecular += irradiance * mirrored * (0.5 * alpha * alpha / max(spread * spread * hidden, 1e-6));
  reflected.directDiffuse += irradiance * material.diffuseContribution * (1.0 - mirrored);
}
void light_around(const in vec3 irradiance, const in vec3 position, const in vec3 normal, const in vec3 view, const in vec3 coat, const in PhysicalMaterial material, inout ReflectedLight reflected) {
  reflected.indirectDiffuse += RECIPROCAL_PI * irradiance * material.diffuseContribution * (1.0 - material.specularColor);
}
#define RE_Direct light_directly
#define RE_IndirectDiffuse light_around`;
change('lights_physical_pars_fragment', /^[^]*$/, (all) => `#ifdef USE_ENVMAP\n${all}\n#else\n${light}\n#endif\n`);
change('lights_fragment_begin', '#ifdef STANDARD', () => '#if defined(STANDARD) && defined(USE_ENVMAP)');
