/** Drawing of a body's smooth surface: a mesh that follows the links, and highlights single links. */
import * as THREE from 'three';
import type { MechanismData } from '../core/protocol';
import { make_body_surface, make_rough_surface, max_links, type BodySurface, type IndexRange, type Work } from './body_surface';
import { surface_at } from './far_surface';
import { shadow_material } from './shadow_region';
import { LinkSkeleton } from './skinning';
import { glow_light, shade_by_vertices } from './vertex_shading';

const place = new THREE.Vector3();
const surfaces = new WeakMap<MechanismData, BodySurface | null>();

/** The surface of a mechanism, made at the first call; null if the mechanism is no body. All characters of the mechanism share it. */
export function body_surface(mechanism: MechanismData): BodySurface | null {
  let surface = surfaces.get(mechanism);
  if (surface === undefined) {
    surface = make_body_surface(mechanism);
    surfaces.set(mechanism, surface);
  }
  return surface;
}

/** A surface of one triangle and one link, whose shaders are those of every surface. */
export function sample_surface(): BodySurface {
  const geometry = new THREE.BufferGeometry();
  for (const [name, size] of [['position', 3], ['normal', 3], ['skinWeight', 4]] as const) geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * size), size));
  geometry.setAttribute('skinIndex', new THREE.BufferAttribute(new Uint16Array(12), 4));
  geometry.setIndex([0, 1, 2]);
  const range = { start: 0, count: 3 };
  return { geometry, shown: range, coarser: [], shadow: range, inverses: [new THREE.Matrix4()] };
}

/** Makes the surfaces of bodies: first rough ones, which become the same as those of body_surface() while pictures are drawn. */
export class GradualSurfaces {
  private readonly made = new Map<MechanismData, BodySurface | null>();
  private readonly work: Work<void>[] = [];

  /** The surface of a mechanism; null if the mechanism is no body. */
  of(mechanism: MechanismData): BodySurface | null {
    let surface = this.made.get(mechanism);
    if (surface === undefined) {
      const rough = make_rough_surface(mechanism);
      surface = rough?.surface ?? null;
      if (rough) this.work.push(rough.refine);
      this.made.set(mechanism, surface);
    }
    return surface;
  }

  /** Works for about `milliseconds`. @return true if a surface was finished, so that the picture changes */
  refine(milliseconds: number): boolean {
    const begin = performance.now();
    let finished = false;
    while (this.work.length > 0 && performance.now() - begin < milliseconds) {
      if (!this.work[0]!.next().done) continue;
      this.work.shift();
      finished = true;
    }
    return finished;
  }
}

/** Bones of all characters that are drawn with a surface. */
const followers = new WeakMap<BodySurface, Set<LinkBones>>();

function followers_of(surface: BodySurface): Set<LinkBones> {
  let all = followers.get(surface);
  if (!all) followers.set(surface, (all = new Set()));
  return all;
}

/** Link meshes that only receive rays and determine the place of shadows, because a surface is drawn instead of them. */
export const hidden_layer = 1;

/** Bones with the world poses of the links. */
export class LinkBones {
  readonly skeleton: LinkSkeleton;

  constructor(surface: BodySurface) {
    const bones = surface.inverses.map(() => {
      const bone = new THREE.Bone();
      bone.matrixAutoUpdate = bone.matrixWorldAutoUpdate = false;
      return bone;
    });
    this.skeleton = new LinkSkeleton(bones, surface.inverses);
  }

  set(link: number, pose: THREE.Matrix4): void {
    this.skeleton.bones[link]?.matrixWorld.copy(pose);
  }

  /** Distance of the first link from a point, m. */
  distance(point: THREE.Vector3): number {
    return place.setFromMatrixPosition(this.skeleton.bones[0]!.matrixWorld).distanceTo(point);
  }

  /** A mesh of the surface that follows these bones. */
  mesh(surface: BodySurface, material: THREE.Material): THREE.SkinnedMesh {
    const mesh = new THREE.SkinnedMesh(surface.geometry, material);
    mesh.bindMode = THREE.DetachedBindMode;
    mesh.bind(this.skeleton, new THREE.Matrix4());
    mesh.frustumCulled = false; // the bounding sphere is that of the bind pose
    mesh.raycast = () => undefined; // rays hit the shapes of the links
    return mesh;
  }
}

/** Highlight of a link: amount of white and of the accent colour that it emits. */
export type Glow = readonly [white: number, accent: number];

/** The surface of one character. */
export class BodySkin {
  readonly mesh: THREE.SkinnedMesh;
  readonly bones: LinkBones;
  readonly material: THREE.MeshStandardMaterial;
  private readonly tints = { value: Array.from({ length: max_links }, () => new THREE.Color()) };
  private readonly glow = { value: Array.from({ length: max_links }, () => new THREE.Vector2()) };

  /** @param whole whether the surface is all that is drawn of the mechanism; shadows beside other shapes are drawn as on these (vertex_shading.ts) */
  constructor(private readonly surface: BodySurface, color: THREE.ColorRepresentation, whole: boolean) {
    this.material = new THREE.MeshStandardMaterial({ color, roughness: 0.6, metalness: 0 });
    if (!whole) this.material.defines = { ...this.material.defines, LARGE_TRIANGLES: '' };
    this.material.onBeforeCompile = (shader) => {
      shader.uniforms.u_glow = this.glow;
      shader.uniforms.u_tints = this.tints;
      shader.vertexShader = shader.vertexShader
        .replace('#include <skinning_pars_vertex>', `#include <skinning_pars_vertex>\nuniform vec2 u_glow[${max_links}];\nvarying vec2 v_glow;\n#ifdef TINTS\nuniform vec3 u_tints[${max_links}];\nvarying vec3 v_tint;\n#define TINT v_tint\n#else\n#define TINT diffuse\n#endif`)
        .replace('#include <skinning_vertex>', '#include <skinning_vertex>\nv_glow = skinWeight.x * u_glow[int(skinIndex.x)] + skinWeight.y * u_glow[int(skinIndex.y)] + skinWeight.z * u_glow[int(skinIndex.z)] + skinWeight.w * u_glow[int(skinIndex.w)];\n#ifdef TINTS\n{ vec4 w = pow(skinWeight, vec4(6.0)); v_tint = (w.x * u_tints[int(skinIndex.x)] + w.y * u_tints[int(skinIndex.y)] + w.z * u_tints[int(skinIndex.z)] + w.w * u_tints[int(skinIndex.w)]) / (w.x + w.y + w.z + w.w); }\n#endif');
      if (shade_by_vertices(shader, { color: 'TINT', roughness: 'roughness', emission: glow_light })) return;
      shader.fragmentShader = shader.fragmentShader
        .replace('#include <common>', '#include <common>\nvarying vec2 v_glow;\n#ifdef TINTS\nvarying vec3 v_tint;\n#endif')
        .replace('#include <color_fragment>', '#include <color_fragment>\n#ifdef TINTS\ndiffuseColor.rgb = v_tint;\n#endif')
        .replace('#include <emissivemap_fragment>', `#include <emissivemap_fragment>\ntotalEmissiveRadiance += ${glow_light};`);
    };
    this.bones = new LinkBones(surface);
    this.mesh = this.bones.mesh(surface, this.material);
    this.mesh.castShadow = this.mesh.receiveShadow = true;
    this.mesh.customDepthMaterial = shadow_material;
    const { geometry, shown, shadow } = surface;
    const show = ({ start, count }: IndexRange): void => geometry.setDrawRange(start, count);
    const all = followers_of(surface).add(this.bones);
    const eye = new THREE.Vector3();
    this.mesh.onBeforeShadow = () => show(shadow);
    this.mesh.onBeforeRender = (renderer, _scene, camera) => {
      eye.setFromMatrixPosition(camera.matrixWorld);
      const nearest = Math.min(...[...all].map((bones) => bones.distance(eye)));
      show(surface_at(renderer, camera, surface, nearest));
    };
    this.mesh.onAfterShadow = this.mesh.onAfterRender = () => show(shown); // others draw the same geometry
  }

  /** Colours of all links; null: all have the colour of the material. Colours change over a short distance around a joint. */
  set_tints(colors: readonly THREE.ColorRepresentation[] | null): void {
    colors?.forEach((color, link) => this.tints.value[link]?.set(color));
    const { material } = this;
    if (Boolean(material.defines?.TINTS) === Boolean(colors)) return;
    material.defines = { ...material.defines };
    if (colors) material.defines.TINTS = '1';
    else delete material.defines.TINTS;
    material.needsUpdate = true;
  }

  dispose(): void {
    followers_of(this.surface).delete(this.bones);
    this.material.dispose();
    this.bones.skeleton.dispose();
  }

  set_glow(link: number, [white, accent]: Glow): void {
    this.glow.value[link]?.set(white, accent);
  }
}
