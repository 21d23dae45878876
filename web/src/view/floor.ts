/** The floor: a metre grid that fades into the background with the distance from the camera's target. */
import * as THREE from 'three';

const cells = 64; // cells of the shadow map in each direction, in which shadows are looked for

// The floor is flat and its lights are directional, so that its lighting without shadow is the same everywhere.
const vertex_shader = `
#include <common>
#include <lights_pars_begin>
#include <shadowmap_pars_vertex>
uniform vec3 u_floor;
varying vec2 v_world;
flat varying vec3 v_shaded, v_key; // colours by all lights except the first, and by the first light, which casts the shadow
vec3 light(int i, vec3 normal) { return max(0.0, dot(normal, directionalLights[i].direction)) * directionalLights[i].color; }
void main() {
  vec4 world = modelMatrix * vec4(position, 1.0);
  v_world = world.xy;
  vec3 normal = normalize((viewMatrix * vec4(0.0, 0.0, 1.0, 0.0)).xyz);
  vec3 reflected = BRDF_Lambert(u_floor);
  v_shaded = (getHemisphereLightIrradiance(hemisphereLights[0], normal) + light(1, normal)) * reflected;
  v_key = light(0, normal) * reflected;
  #if defined(USE_SHADOWMAP) && NUM_DIR_LIGHT_SHADOWS > 0
    vDirectionalShadowCoord[0] = directionalShadowMatrix[0] * (world + vec4(0.0, 0.0, directionalLightShadows[0].shadowNormalBias, 0.0));
  #endif
  gl_Position = projectionMatrix * viewMatrix * world;
}`;

const fragment_shader = `
#include <common>
#include <lights_pars_begin>
#include <shadowmap_pars_fragment>
varying vec2 v_world;
flat varying vec3 v_shaded, v_key;
uniform vec3 u_background, u_line;
uniform vec2 u_focus;
uniform sampler2D u_casters;
uniform float u_reach, u_strength;

// Part of a pixel that lines with a distance of 1 / 'per_m' cover.
float grid_line(vec2 p, vec2 p_width, float per_m, float pixels) {
  vec2 w = p_width * per_m;
  vec2 d = abs(fract(p * per_m - 0.5) - 0.5) / max(w, vec2(1e-6));
  vec2 l = 1.0 - smoothstep(pixels - 0.5, pixels + 0.5, d);
  // fade out lines that are only a few pixels apart, because they flicker
  l *= 1.0 - smoothstep(0.12, 0.35, w);
  return max(l.x, l.y);
}
#if defined(USE_SHADOWMAP) && NUM_DIR_LIGHT_SHADOWS > 0
// As getShadow() of three.js, which the characters use, but with two trigonometric functions instead of ten.
float soft_shadow(vec3 at) {
  DirectionalLightShadow light = directionalLightShadows[0];
  float phi = interleavedGradientNoise(gl_FragCoord.xy) * PI2;
  vec2 turn = vec2(cos(phi), sin(phi)) * light.shadowRadius / light.shadowMapSize;
  mat2 rotation = mat2(turn.x, turn.y, -turn.y, turn.x);
  at.z += light.shadowBias;
  float sum = 0.0;
  for (int i = 0; i < 5; i++) sum += texture(directionalShadowMap[0], vec3(at.xy + rotation * vogelDiskSample(i, 5, 0.0), at.z));
  return mix(1.0, 0.2 * sum, light.shadowIntensity);
}
#endif
void main() {
  vec2 p = v_world;
  vec2 w = fwidth(p);
  float away = length(p - u_focus);
  float shadow = 1.0;
  #if defined(USE_SHADOWMAP) && NUM_DIR_LIGHT_SHADOWS > 0
    vec3 s = vDirectionalShadowCoord[0].xyz;
    ivec2 cell = ivec2(floor(s.xy * float(CELLS)));
    bool inside = min(cell.x, cell.y) >= 0 && max(cell.x, cell.y) < CELLS;
    // A loop, because software renderers execute both sides of a branch for all pixels, but can leave a loop.
    int count = inside && texelFetch(u_casters, cell, 0).r > 0.0 ? 1 : 0;
    for (int i = 0; i < count; i++) shadow = soft_shadow(s);
  #endif
  vec3 color = v_shaded + v_key * shadow;
  float near_fade = 1.0 - smoothstep(0.15 * u_reach, 0.6 * u_reach, away);
  float lines = 0.6 * grid_line(p, w, 1.0, 0.55) + 0.4 * grid_line(p, w, 0.2, 0.75);
  color = mix(color, u_line, clamp(lines, 0.0, 1.0) * u_strength * near_fade);
  vec2 axes = 1.0 - smoothstep(0.4, 1.4, abs(p) / max(w, vec2(1e-6)));
  color = mix(color, vec3(0.52, 0.13, 0.13), axes.y * 0.45 * near_fade);
  color = mix(color, vec3(0.13, 0.34, 0.15), axes.x * 0.45 * near_fade);
  gl_FragColor = vec4(mix(color, u_background, smoothstep(0.12 * u_reach, u_reach, away)), 1.0);
  #include <colorspace_fragment>
}`;

const sphere = new THREE.Sphere();

/** Marks the cells that the bounding sphere of a mesh covers in the shadow map of a directional light. */
function mark(marks: Uint8Array, mesh: THREE.Mesh, shadow: THREE.DirectionalLightShadow): void {
  const { elements } = shadow.matrix;
  if (!mesh.geometry.boundingSphere) mesh.geometry.computeBoundingSphere();
  sphere.copy(mesh.geometry.boundingSphere!).applyMatrix4(mesh.matrixWorld);
  // The edge of a shadow is softened over `radius` texels, and each texel is interpolated with its neighbours.
  const r = sphere.radius * Math.hypot(elements[0]!, elements[4]!, elements[8]!) + (shadow.radius + 2) / shadow.mapSize.x;
  const { x, y } = sphere.center.applyMatrix4(shadow.matrix);
  const [left, right, bottom, top] = [x - r, x + r, y - r, y + r].map((v) => Math.floor(v * cells));
  for (let j = Math.max(0, bottom!); j <= Math.min(cells - 1, top!); j++)
    for (let i = Math.max(0, left!); i <= Math.min(cells - 1, right!); i++) marks[j * cells + i] = 255;
}

export class Floor {
  readonly mesh: THREE.Mesh;
  private readonly casters = new THREE.DataTexture(new Uint8Array(cells * cells), cells, cells, THREE.RedFormat);
  private readonly uniforms = {
    ...THREE.UniformsUtils.clone(THREE.UniformsLib.lights),
    u_floor: { value: new THREE.Color(0x2a2c31) },
    u_background: { value: new THREE.Color() },
    u_line: { value: new THREE.Color() },
    u_focus: { value: new THREE.Vector2() },
    u_casters: { value: this.casters },
    u_reach: { value: 20 },
    u_strength: { value: 0.5 },
  };

  constructor() {
    const material = new THREE.ShaderMaterial({ uniforms: this.uniforms, vertexShader: vertex_shader, fragmentShader: fragment_shader, lights: true, defines: { CELLS: cells } });
    this.mesh = new THREE.Mesh(new THREE.CircleGeometry(1, 128), material);
    this.mesh.receiveShadow = true;
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 1;
    this.mesh.name = 'floor';
    this.mesh.onBeforeRender = (_renderer, scene) => this.find_casters(scene as THREE.Scene);
  }

  /** Marks the cells of the shadow map that are not empty, because the shader reads shadows only there. */
  private find_casters(scene: THREE.Scene): void {
    const marks = this.casters.image.data as Uint8Array;
    marks.fill(0);
    let shadow: THREE.DirectionalLightShadow | null = null;
    const meshes: THREE.Mesh[] = [];
    scene.traverseVisible((o) => {
      if (o instanceof THREE.DirectionalLight && o.castShadow) shadow ??= o.shadow;
      else if (o instanceof THREE.Mesh && o.castShadow) meshes.push(o);
    });
    this.casters.needsUpdate = true;
    if (shadow) for (const mesh of meshes) mark(marks, mesh, shadow);
  }

  /** @param strength opacity of the grid lines, 0 ... 1 */
  set_colors(floor: THREE.Color, line: THREE.Color, background: THREE.Color, strength: number): void {
    this.uniforms.u_floor.value.copy(floor);
    this.uniforms.u_line.value.copy(line);
    this.uniforms.u_background.value.copy(background);
    this.uniforms.u_strength.value = strength;
  }

  /** Centres the visible floor. @param x, y m  @param reach radius beyond which only the background is visible, m */
  set_focus(x: number, y: number, reach: number): void {
    this.uniforms.u_focus.value.set(x, y);
    this.uniforms.u_reach.value = reach;
    this.mesh.position.set(x, y, 0);
    this.mesh.scale.set(reach, reach, 1);
  }
}
