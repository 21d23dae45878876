/** The floor: a metre grid that fades into the background with the distance from the camera's target. */
import * as THREE from 'three';
import { FloorLines } from './floor_lines';
import { displayed } from './shading';
import { outline_corners, outline_vertices, shadow_outline } from './shadow_outline';

// The floor is flat and its lights are directional, so that its lighting without shadow is the same everywhere. The vertex shader therefore
// computes the displayed (sRGB) colours with and without shadow, and the fragment shader mixes displayed colours: three powers a pixel less.
const inner = 0.12; // distance from the focus, relative to the visible radius, from which the floor fades into the background
const fade = `vec3 faded(vec3 color, vec2 at) { return mix(color, u_background, smoothstep(${inner} * u_reach, u_reach, length(at - u_focus))); }`;
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
  #if defined(INNER) && PATTERN < 2
    gl_FragColor = vec4(v_lit, 1.0);
  #elif !defined(SHADOW) && PATTERN < 2
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
// The disc's colour is exact at the edges of its rings and sectors and linear between them, which is at most 0.4 % of the way into the background off.
const ring_count = 14;
const sectors = 40;
const max_patches = 256; // if more bodies cast shadows, one patch covers all of them

/** `whole`: colours and depth. `depth`: depth only, before the bodies, so that it hides the parts of bodies below it. `flat`: colours without depth. */
export type FloorMode = 'whole' | 'depth' | 'flat';

/** Bounding sphere of a mesh in the world, m. */
export function sphere_of(mesh: THREE.Mesh): THREE.Sphere {
  if (!mesh.geometry.boundingSphere) mesh.geometry.computeBoundingSphere();
  return mesh.geometry.boundingSphere!.clone().applyMatrix4(mesh.matrixWorld);
}

/** A disc of radius 1: a circle up to the radius `inner` (group 0), and rings around it (group 1). */
function rings(): THREE.BufferGeometry {
  const at = [0, 0, 0];
  const triangles: number[] = [];
  for (let ring = 0; ring <= ring_count; ring++) {
    const radius = inner + ((1 - inner) * ring) / ring_count;
    for (let k = 0; k < sectors; k++) {
      const [here, next] = [1 + ring * sectors + k, 1 + ring * sectors + ((k + 1) % sectors)];
      const turn = (2 * Math.PI * k) / sectors;
      at.push(radius * Math.cos(turn), radius * Math.sin(turn), 0);
      if (ring === 0) triangles.push(0, here, next);
      else triangles.push(here - sectors, here, next, here - sectors, next, next - sectors);
    }
  }
  const out = new THREE.BufferGeometry().setAttribute('position', new THREE.Float32BufferAttribute(at, 3)).setIndex(triangles);
  out.addGroup(0, 3 * sectors, 0);
  out.addGroup(3 * sectors, triangles.length - 3 * sectors, 1);
  return out;
}

/**
 * The floor consists of a disc without shadows, and of one patch with shadows for each group of bodies. The shader of a patch
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
  /** Materials: of the inner circle, which has one colour, and of the rings, whose colour is interpolated for each pixel. */
  private readonly disc: THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial[]>;
  private readonly patches: THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial>;
  private readonly rings = rings();
  private readonly whole = new THREE.CircleGeometry(1, sectors);
  private has_lines = true;
  private readonly corners = new THREE.BufferAttribute(new Float32Array(3 * outline_vertices * max_patches), 3).setUsage(THREE.DynamicDrawUsage);

  private readonly lines = new FloorLines(this.uniforms);

  constructor() {
    const material = (more: THREE.ShaderMaterialParameters): THREE.ShaderMaterial =>
      new THREE.ShaderMaterial({ uniforms: this.uniforms, vertexShader: vertex_shader, fragmentShader: fragment_shader, lights: true, ...more, defines: { PATTERN: 0, ...more.defines } });
    // The patches are drawn first. The disc is moved back by the smallest visible depth, so that it does not cover them.
    this.patches = new THREE.Mesh(new THREE.BufferGeometry().setAttribute('position', this.corners), material({ defines: { PATCH: '' } }));
    const back = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 4 };
    this.disc = new THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial[]>(this.rings, [material({ ...back, defines: { INNER: '' } }), material(back)]);
    this.whole.addGroup(0, Infinity, 0);
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
      const outline = shadow_outline(spheres, to_light, soft);
      let at = i * outline_vertices;
      for (let k = 2; k < outline_corners; k++)
        for (const corner of [0, k - 1, k]) this.corners.setXY(at++, outline[2 * corner]!, outline[2 * corner + 1]!);
    });
    this.corners.needsUpdate = true;
    this.patches.geometry.setDrawRange(0, outline_vertices * lists.length);
    return every;
  }

  /** @param strength opacity of the grid lines, 0 ... 1 */
  set_colors(floor: THREE.Color, line: THREE.Color, background: THREE.Color, strength: number, pattern: string): void {
    const index = Math.max(0, ground_patterns.indexOf(pattern));
    this.lines.mesh.visible = this.has_lines = index === 0;
    for (const material of this.materials) {
      material.defines.PATTERN = index;
      material.needsUpdate = true;
    }
    this.uniforms.u_floor.value.copy(floor);
    this.uniforms.u_line.value.copyLinearToSRGB(line);
    this.uniforms.u_background.value.copyLinearToSRGB(background);
    this.uniforms.u_strength.value = strength;
  }

  private get materials(): THREE.ShaderMaterial[] {
    return [this.patches.material, ...this.disc.material];
  }

  /** Selects how the floor is drawn from now on. */
  draw_as(mode: FloorMode): void {
    const hidden = mode === 'depth';
    // With depth, the patches are drawn first and hide the disc there; without, they are drawn over it.
    const orders = { whole: [1, 2], depth: [-2, -1], flat: [2, 1] }[mode];
    for (const material of this.materials) {
      material.colorWrite = !hidden;
      material.depthTest = material.depthWrite = mode !== 'flat';
    }
    for (const [i, mesh] of [this.patches, this.disc].entries()) mesh.renderOrder = orders[i]!;
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
