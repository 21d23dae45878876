/** Drawing of the skin of a character file: a textured surface whose vertices follow the links. */
import * as THREE from 'three';
import type { SkinData } from '../core/protocol';
import type { Material } from '../core/look';
import { hidden_layer } from './body_view';
import { LinkSkeleton } from './skinning';
import { unpack as bytes_of } from './surfaces';

const clear = 0.45; // opacity of a skin through which the body is seen

/** What all characters of a mechanism share. */
interface Shared {
  geometry: THREE.BufferGeometry;
  /** The pictures as soon as they are decoded; null: a damaged picture. */
  textures: Promise<THREE.Texture | null>[];
  /** Those that are decoded. */
  decoded: (THREE.Texture | null)[];
  /** Matrix of each bone: from the vertices to the frame of its link. */
  matrices: THREE.Matrix4[];
  /** Sphere of each bone around the vertices that it moves, in the frame of its link, m; null: it moves none. */
  spheres: (THREE.Sphere | null)[];
}

const shared = new WeakMap<SkinData, Shared>();
const listeners = new Set<() => void>();

/** Calls `changed` when a texture was decoded, so that the picture has to be drawn again. @return ends this */
export function on_texture(changed: () => void): () => void {
  listeners.add(changed);
  return () => listeners.delete(changed);
}

/** The values of a packed list. */
function unpack<T>(text: string, of: new (buffer: ArrayBuffer) => T): T {
  return new of(bytes_of(text));
}

/** Sphere of each bone around the vertices that it moves, in the frame of its link, m; null: it moves none. */
function spheres_of({ attributes }: THREE.BufferGeometry, matrices: readonly THREE.Matrix4[]): (THREE.Sphere | null)[] {
  const { position: at, skinIndex, skinWeight } = attributes as Record<string, THREE.BufferAttribute>;
  const boxes = matrices.map(() => new THREE.Box3());
  const point = new THREE.Vector3();
  for (let v = 0; v < at!.count; v++)
    for (let k = 0; k < 4; k++) {
      const bone = skinIndex!.getComponent(v, k);
      if (skinWeight!.getComponent(v, k) > 0) boxes[bone]?.expandByPoint(point.fromBufferAttribute(at!, v).applyMatrix4(matrices[bone]!));
    }
  return boxes.map((box) => (box.isEmpty() ? null : box.getBoundingSphere(new THREE.Sphere())));
}

function make_shared(skin: SkinData): Shared {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(unpack(skin.positions, Float32Array), 3));
  geometry.setAttribute('normal', new THREE.BufferAttribute(unpack(skin.normals, Float32Array), 3));
  geometry.setAttribute('uv', new THREE.BufferAttribute(unpack(skin.uvs, Float32Array), 2));
  if (skin.colors) geometry.setAttribute('color', new THREE.BufferAttribute(unpack(skin.colors, Uint16Array), 3, true));
  geometry.setAttribute('skinIndex', new THREE.BufferAttribute(unpack(skin.bones, Uint16Array), 4));
  geometry.setAttribute('skinWeight', new THREE.BufferAttribute(unpack(skin.weights, Uint16Array), 4, true));
  const matrices = skin.links.map((_, b) => new THREE.Matrix4().set(...(skin.matrices.slice(12 * b, 12 * b + 12) as Twelve), 0, 0, 0, 1));
  const indices = unpack(skin.indices, Uint32Array);
  const mirrored = matrices.length > 0 && matrices[0]!.determinant() < 0;
  if (mirrored) for (let i = 0; i < indices.length; i += 3) [indices[i], indices[i + 1]] = [indices[i + 1]!, indices[i]!];
  geometry.setIndex(new THREE.BufferAttribute(indices, 1));
  skin.parts.forEach((part, i) => geometry.addGroup(part.first, part.count, i));
  const decoded: (THREE.Texture | null)[] = skin.textures.map(() => null);
  const textures = skin.textures.map(async (texture, i) => (decoded[i] = await load_texture(texture)));
  for (const texture of textures) loading.add(texture);
  return { geometry, textures, decoded, matrices, spheres: spheres_of(geometry, matrices) };
}
type Twelve = [number, number, number, number, number, number, number, number, number, number, number, number];

const loading = new Set<Promise<unknown>>();

/** Waits until the textures of all skins are decoded. */
export async function textures_ready(): Promise<void> {
  await Promise.all(loading);
  loading.clear();
}

async function load_texture({ type, data }: SkinData['textures'][number]): Promise<THREE.Texture | null> {
  try {
    const image = await createImageBitmap(new Blob([bytes_of(data)], { type }), { colorSpaceConversion: 'none', premultiplyAlpha: 'none' });
    const texture = new THREE.Texture(image);
    texture.colorSpace = THREE.SRGBColorSpace;
    texture.flipY = false;
    texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
    texture.anisotropy = 4;
    texture.needsUpdate = true;
    return texture;
  } catch {
    return null; // the base colour is shown
  }
}

export class SkinView {
  readonly mesh: THREE.SkinnedMesh<THREE.BufferGeometry, THREE.MeshStandardMaterial[]>;
  /** Spheres in the world whose convex hull contains the skin, m. */
  readonly spheres: THREE.Sphere[] = [];
  private readonly bones: THREE.Bone[];
  /** Sphere of each bone in the frame of its link; null: the bone moves no vertex. */
  private readonly of_bones: readonly (THREE.Sphere | null)[];

  constructor(private readonly skin: SkinData) {
    let known = shared.get(skin);
    if (!known) {
      known = make_shared(skin);
      shared.set(skin, known);
    }
    const { geometry, textures, decoded, matrices } = known;
    this.of_bones = known.spheres;
    for (const sphere of this.of_bones) if (sphere) this.spheres.push(sphere.clone());
    const materials = skin.parts.map((part) => {
      const material = new THREE.MeshStandardMaterial({ color: part.color, vertexColors: skin.colors !== undefined, map: decoded[part.texture] ?? null, alphaTest: part.texture >= 0 ? part.cutoff : 0, side: part.both_sides ? THREE.DoubleSide : THREE.FrontSide, roughness: 0.75, metalness: 0 });
      void textures[part.texture]?.then((map) => {
        if (material.map === map) return;
        material.map = map;
        material.needsUpdate = true;
        for (const changed of listeners) changed();
      });
      return material;
    });
    this.mesh = new THREE.SkinnedMesh(geometry, materials);
    this.bones = skin.links.map(() => {
      const bone = new THREE.Bone();
      bone.matrixAutoUpdate = bone.matrixWorldAutoUpdate = false;
      return bone;
    });
    this.mesh.bindMode = THREE.DetachedBindMode;
    this.mesh.bind(new LinkSkeleton(this.bones, matrices), new THREE.Matrix4());
    this.mesh.frustumCulled = false;
    this.mesh.castShadow = this.mesh.receiveShadow = true;
    this.mesh.raycast = () => undefined; // rays hit the shapes of the links
    this.mesh.name = 'skin';
  }

  /** Sets the pose of a link. */
  set(link: number, pose: THREE.Matrix4): void {
    this.skin.links.forEach((of, b) => {
      if (of === link) this.bones[b]!.matrixWorld.copy(pose);
    });
  }

  /** Poses all links. @param values x y z (m) qw qx qy qz of each link */
  place(values: ArrayLike<number>): void {
    this.skin.links.forEach((link, b) => {
      const at = 7 * link;
      position.set(values[at]!, values[at + 1]!, values[at + 2]!);
      rotation.set(values[at + 4]!, values[at + 5]!, values[at + 6]!, values[at + 3]!);
      this.bones[b]!.matrixWorld.compose(position, rotation, one);
    });
    let next = 0;
    this.of_bones.forEach((sphere, b) => {
      if (sphere) this.spheres[next++]!.center.copy(sphere.center).applyMatrix4(this.bones[b]!.matrixWorld);
    });
  }

  /** @param glow light that the whole skin emits, 0 ... 1: of a selected character */
  set_look({ roughness = 0.75, metalness = 0, shown = 'skin' }: Material, glow = 0): void {
    const transparent = shown === 'both';
    for (const material of this.mesh.material) {
      material.roughness = roughness;
      material.metalness = metalness;
      material.emissive.set(0xff8a3d);
      material.emissiveIntensity = glow;
      if (material.transparent === transparent) continue;
      material.transparent = transparent;
      material.opacity = transparent ? clear : 1;
      material.depthWrite = !transparent;
      material.needsUpdate = true;
    }
    this.mesh.castShadow = !transparent;
  }

  /** Shows the skin, or hides it. */
  set visible(on: boolean) {
    this.mesh.layers.set(on ? 0 : hidden_layer);
  }

  /** World position of a vertex, m. */
  vertex(index: number, out: THREE.Vector3): THREE.Vector3 {
    this.mesh.skeleton.update();
    return this.mesh.applyBoneTransform(index, out.fromBufferAttribute(this.mesh.geometry.getAttribute('position'), index));
  }

  dispose(): void {
    this.mesh.skeleton.dispose();
    for (const material of this.mesh.material) material.dispose();
  }
}

const position = new THREE.Vector3();
const rotation = new THREE.Quaternion();
const one = new THREE.Vector3(1, 1, 1);
