/** The floor: a metre grid that fades into the background with the distance from the camera's target. */
import * as THREE from 'three';
import { FloorLines } from './floor_lines';
import { displayed } from './shading';

// The floor is flat and its lights are directional, so that its lighting without shadow is the same everywhere. The vertex shader therefore
// computes the displayed (sRGB) colours with and without shadow, and the fragment shader mixes displayed colours: three powers a pixel less.
const fade = 'vec3 faded(vec3 color, vec2 at) { return mix(color, u_background, smoothstep(0.12 * u_reach, u_reach, length(at - u_focus))); }';
const vertex_shader = `
#include <common>
#include <lights_pars_begin>
#include <shadowmap_pars_vertex>
#if defined(PATCH) && defined(USE_SHADOWMAP) && NUM_DIR_LIGHT_SHADOWS > 0
  #define SHADOW
#endif
uniform vec3 u_floor, u_background;
uniform vec2 u_focus;
uniform float u_reach;
varying vec2 v_world;
flat varying vec3 v_lit, v_shaded; // displayed colours by all lights, and by all lights except the first, which casts the shadow
varying vec3 v_faded; // displayed colour of a floor without pattern and shadow
${displayed}
${fade}
vec3 light(int i, vec3 normal) { return max(0.0, dot(normal, directionalLights[i].direction)) * directionalLights[i].color; }
void main() {
  vec4 world = modelMatrix * vec4(position, 1.0);
  v_world = world.xy;
  vec3 normal = normalize((viewMatrix * vec4(0.0, 0.0, 1.0, 0.0)).xyz);
  vec3 reflected = BRDF_Lambert(u_floor);
  vec3 shaded = (getHemisphereLightIrradiance(hemisphereLights[0], normal) + light(1, normal)) * reflected;
  v_shaded = displayed(shaded);
  v_lit = displayed(shaded + light(0, normal) * reflected);
  v_faded = faded(v_lit, world.xy);
  #ifdef SHADOW
    vDirectionalShadowCoord[0] = directionalShadowMatrix[0] * (world + vec4(0.0, 0.0, directionalLightShadows[0].shadowNormalBias, 0.0));
  #endif
  gl_Position = projectionMatrix * viewMatrix * world;
}`;

const fragment_shader = `
#include <common>
#include <lights_pars_begin>
#include <shadowmap_pars_fragment>
varying vec2 v_world;
flat varying vec3 v_lit, v_shaded;
varying vec3 v_faded;
uniform vec3 u_background;
uniform vec2 u_focus;
uniform float u_reach;
${fade}

// Random number of a cell, 0 ... 1.
float random_of(vec2 cell) { return fract(sin(dot(cell, vec2(12.9898, 78.233))) * 43758.5453); }

// Factor on the colour of a floor of boards, 0.16 m wide and 2.4 m long, at p (m). w is the width of a pixel, m.
float boards(vec2 p, vec2 w) {
  float row = floor(p.y / 0.16);
  vec2 at = vec2(p.x + 2.4 * random_of(vec2(row, 7.0)), p.y);
  vec2 cell = vec2(floor(at.x / 2.4), row);
  vec2 to_edge = min(fract(at / vec2(2.4, 0.16)), 1.0 - fract(at / vec2(2.4, 0.16))) * vec2(2.4, 0.16);
  vec2 seam = 1.0 - smoothstep(vec2(0.0015), vec2(0.0015) + 1.5 * w, to_edge);
  seam *= 1.0 - smoothstep(vec2(0.5, 0.04), vec2(2.0, 0.16), w); // seams nearer than a few pixels flicker
  float grain = sin(at.y * 260.0 + 3.0 * sin(at.x * 3.0 + 40.0 * random_of(cell)) + 30.0 * random_of(cell.yx));
  float fine = 1.0 - smoothstep(0.002, 0.01, max(w.x, w.y));
  return (0.86 + 0.28 * random_of(cell) * (1.0 - smoothstep(0.05, 0.3, w.y)) + 0.05 * grain * fine) * (1.0 - 0.55 * max(seam.x, seam.y));
}

// Share of the dark squares of 1 m of a checkered floor in a pixel.
float checker(vec2 p, vec2 w) {
  vec2 sum = 2.0 * (abs(fract((p - 0.5 * w) * 0.5) - 0.5) - abs(fract((p + 0.5 * w) * 0.5) - 0.5)) / max(w, vec2(1e-6));
  return 0.5 - 0.5 * sum.x * sum.y;
}

#if defined(PATCH) && defined(USE_SHADOWMAP) && NUM_DIR_LIGHT_SHADOWS > 0
#define SHADOW
#endif
// PATTERN is the index into ground_patterns. Without a graphics processor, all branches of an 'if' would be computed for every pixel.
void main() {
  #if !defined(SHADOW) && PATTERN < 2
    gl_FragColor = vec4(v_faded, 1.0);
  #else
    vec2 p = v_world;
    float shadow = 1.0;
    #ifdef SHADOW
      DirectionalLightShadow light = directionalLightShadows[0];
      shadow = getShadow(directionalShadowMap[0], light.shadowMapSize, light.shadowIntensity, light.shadowBias, light.shadowRadius, vec4(vDirectionalShadowCoord[0].xyz, 1.0));
    #endif
    vec3 color = mix(v_shaded, v_lit, shadow);
    #if PATTERN == 2
      color *= 1.0 - 0.14 * checker(p, fwidth(p));
    #elif PATTERN == 3
      color *= pow(boards(p, fwidth(p)), 0.42); // a factor on light as a factor on displayed colours
    #endif
    gl_FragColor = vec4(faded(color, p), 1.0);
  #endif
}`;

const ground_patterns = ['grid', 'plain', 'checker', 'boards'];
const ring_count = 24; // of the disc: its colour is exact at their edges and linear between them
const max_patches = 256; // if more bodies cast shadows, one patch covers all of them

/** `whole`: colours and depth. `depth`: depth only, before the bodies, so that it hides the parts of bodies below it. `flat`: colours without depth. */
export type FloorMode = 'whole' | 'depth' | 'flat';

/** A rectangle of the floor, m. */
interface Rectangle {
  left: number;
  right: number;
  front: number;
  back: number;
}

/**
 * The part of the floor (z = 0) on which bodies within `spheres` (m) can cast shadows.
 * @param to_light unit vector  @param soft distance by which the edge of a shadow is softened, m
 */
export function shadow_rectangle(spheres: readonly THREE.Sphere[], to_light: THREE.Vector3, soft: number): Rectangle {
  const out = { left: Infinity, right: -Infinity, front: Infinity, back: -Infinity };
  const [slope_x, slope_y] = [to_light.x / to_light.z, to_light.y / to_light.z];
  for (const sphere of spheres) {
    // the shadow of a sphere is an ellipse
    const x = sphere.center.x - slope_x * sphere.center.z;
    const y = sphere.center.y - slope_y * sphere.center.z;
    const half_x = sphere.radius * Math.hypot(1, slope_x) + soft;
    const half_y = sphere.radius * Math.hypot(1, slope_y) + soft;
    out.left = Math.min(out.left, x - half_x);
    out.right = Math.max(out.right, x + half_x);
    out.front = Math.min(out.front, y - half_y);
    out.back = Math.max(out.back, y + half_y);
  }
  return out;
}

/** Bounding sphere of a mesh in the world, m. */
export function sphere_of(mesh: THREE.Mesh): THREE.Sphere {
  if (!mesh.geometry.boundingSphere) mesh.geometry.computeBoundingSphere();
  return mesh.geometry.boundingSphere!.clone().applyMatrix4(mesh.matrixWorld);
}

/**
 * The floor consists of a disc without shadows, and of one rectangular patch with shadows for each group of bodies. The shader of a patch
 * takes twice the time of the disc's shader, which matters on machines without a graphics processor.
 */
export class Floor {
  readonly object = new THREE.Group();
  private readonly uniforms = {
    ...THREE.UniformsUtils.clone(THREE.UniformsLib.lights),
    receiveShadow: { value: true },
    u_floor: { value: new THREE.Color(0x2a2c31) },
    u_background: { value: new THREE.Color() },
    u_line: { value: new THREE.Color() },
    u_focus: { value: new THREE.Vector2() },
    u_reach: { value: 20 },
    u_strength: { value: 0.5 },
  };
  private readonly disc: THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial>;
  private readonly patches: THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial>;
  private readonly rings = new THREE.RingGeometry(0, 1, 48, ring_count);
  private readonly whole = new THREE.CircleGeometry(1, 48);
  private has_lines = true;
  private readonly corners = new THREE.BufferAttribute(new Float32Array(18 * max_patches), 3).setUsage(THREE.DynamicDrawUsage);

  private readonly lines = new FloorLines(this.uniforms);

  constructor() {
    const material = (more: THREE.ShaderMaterialParameters): THREE.ShaderMaterial =>
      new THREE.ShaderMaterial({ uniforms: this.uniforms, vertexShader: vertex_shader, fragmentShader: fragment_shader, lights: true, ...more, defines: { PATTERN: 0, ...more.defines } });
    // The patches are drawn first. The disc is moved back by the smallest visible depth, so that it does not cover them.
    this.patches = new THREE.Mesh(new THREE.BufferGeometry().setAttribute('position', this.corners), material({ defines: { PATCH: '' } }));
    this.disc = new THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial>(this.rings, material({ polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 4 }));
    this.patches.receiveShadow = true;
    for (const [order, mesh] of [this.patches, this.disc].entries()) {
      mesh.frustumCulled = false;
      mesh.renderOrder = 1 + order;
      this.object.add(mesh);
    }
    this.object.add(this.lines.mesh);
    this.object.name = 'floor';
  }

  /**
   * Puts the patches where the bodies of a scene cast shadows. The world matrices of the scene must be up to date.
   * @return spheres that contain these bodies, m
   */
  place_patches(scene: THREE.Scene, light: THREE.DirectionalLight): THREE.Sphere[] {
    const groups = new Map<THREE.Object3D | null, THREE.Sphere[]>();
    const crowds: THREE.Sphere[][] = [];
    scene.traverseVisible((o) => {
      // the bounds of a surface that follows links are those of the links, which are in the scene too
      if (!(o instanceof THREE.Mesh) || !o.castShadow || (o instanceof THREE.SkinnedMesh && !o.userData.casters)) return;
      if (o.userData.casters) return void crowds.push(...(o.userData.casters as THREE.Sphere[][]));
      const group = groups.get(o.parent);
      if (group) group.push(sphere_of(o));
      else groups.set(o.parent, [sphere_of(o)]);
    });
    const to_light = light.position.clone().sub(light.target.position).normalize();
    const { shadow } = light;
    const texel = (shadow.camera.right - shadow.camera.left) / shadow.mapSize.x;
    const soft = ((shadow.radius + 2) * texel + shadow.normalBias) / to_light.z;
    const all = [...groups.values(), ...crowds];
    const every = all.flat();
    const lists = all.length <= max_patches ? all : [every];
    lists.forEach((spheres, i) => {
      const { left, right, front, back } = shadow_rectangle(spheres, to_light, soft);
      this.corners.array.set([left, front, 0, right, front, 0, right, back, 0, left, front, 0, right, back, 0, left, back, 0], 18 * i);
    });
    this.corners.needsUpdate = true;
    this.patches.geometry.setDrawRange(0, 6 * lists.length);
    return every;
  }

  /** @param strength opacity of the grid lines, 0 ... 1 */
  set_colors(floor: THREE.Color, line: THREE.Color, background: THREE.Color, strength: number, pattern: string): void {
    const index = Math.max(0, ground_patterns.indexOf(pattern));
    this.lines.mesh.visible = this.has_lines = index === 0;
    for (const mesh of [this.patches, this.disc]) {
      mesh.material.defines.PATTERN = index;
      mesh.material.needsUpdate = true;
    }
    this.uniforms.u_floor.value.copy(floor);
    this.uniforms.u_line.value.copyLinearToSRGB(line);
    this.uniforms.u_background.value.copyLinearToSRGB(background);
    this.uniforms.u_strength.value = strength;
  }

  /** Selects how the floor is drawn from now on. */
  draw_as(mode: FloorMode): void {
    const hidden = mode === 'depth';
    // With depth, the patches are drawn first and hide the disc there; without, they are drawn over it.
    const orders = { whole: [1, 2], depth: [-2, -1], flat: [2, 1] }[mode];
    for (const [i, mesh] of [this.patches, this.disc].entries()) {
      mesh.material.colorWrite = !hidden;
      mesh.material.depthTest = mesh.material.depthWrite = mode !== 'flat';
      mesh.renderOrder = orders[i]!;
    }
    this.lines.mesh.material.depthTest = mode !== 'flat';
    this.disc.geometry = hidden ? this.whole : this.rings; // without colours, no rings are needed
    this.lines.mesh.visible = this.has_lines && !hidden;
  }

  /** Centres the visible floor. @param x, y m  @param reach radius beyond which only the background is visible, m */
  set_focus(x: number, y: number, reach: number): void {
    this.uniforms.u_focus.value.set(x, y);
    this.uniforms.u_reach.value = reach;
    this.lines.set_reach(reach);
    this.disc.position.set(x, y, 0);
    this.disc.scale.set(reach, reach, 1);
  }
}
