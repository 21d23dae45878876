/** One character of a crowd: poses, colours and highlights of its links, and meshes that rays can hit. */
import * as THREE from 'three';
import type { CharacterFrame, Frame } from '../core/frames';
import type { Material } from '../core/look';
import type { MechanismData } from '../core/protocol';
import { glows, type Emphasis, type LinkTag } from './character_view';
import type { CrowdSurface } from './crowd_surface';
import { SkinView } from './skin_view';

const position = new THREE.Vector3();
const rotation = new THREE.Quaternion();
const part_rotation = new THREE.Quaternion();
const part_position = new THREE.Vector3();
const tint = new THREE.Color();
const unit_scale = new THREE.Vector3(1, 1, 1);
const unseen = new THREE.MeshBasicMaterial(); // of meshes that only rays meet

export class CrowdMember {
  /** World poses of the links as drawn, 7 values each: x y z (m) qw qx qy qz. */
  private readonly poses: Float32Array;
  /** Motion of each link from the rest pose of the surface, 8 values each: x y z (m) 0 qx qy qz qw. */
  readonly packed: Float32Array;
  /** Colour and glow of each link, 8 values each: r g b 0 white accent 0 0. */
  readonly marks: Float32Array;
  /** Bounding spheres of the links with shapes, followed by those of the skin, in the world, m. */
  readonly spheres: THREE.Sphere[] = [];
  /** True: poses, or colours, were changed after the crowd has read them. */
  posed = true;
  marked = true;
  /** True: some links have a colour of their own, or a glow. */
  has_marks = false;
  readonly color = new THREE.Color();
  roughness = 0.6;
  metalness = 0;
  /** Displacement from the poses that are placed, m. */
  readonly offset = new THREE.Vector3();
  /** The skin of the character's file; null if it has none. */
  readonly skin: SkinView | null;
  /** True: the skin is drawn; and the body is not drawn. */
  skinned = false;
  bare = false;
  private material: Material = {};
  private readonly shaped: number[] = [];
  private readonly shown: Emphasis[];
  private colors: readonly (string | null)[] | null = null;
  /** Colours of the visible shapes, link by link; '': that of the link. Empty: none has one. */
  shape_colors: readonly string[] = [];
  private shown_look = '';
  private target: { group: THREE.Group; meshes: (THREE.Mesh | null)[] } | null = null;
  private target_is_old = true;
  private drawn_surface: CrowdSurface | null = null;

  constructor(
    readonly character: string,
    readonly mechanism: MechanismData,
    readonly geometries: readonly (THREE.BufferGeometry | null)[],
    color: string,
  ) {
    const count = mechanism.links.length;
    this.poses = new Float32Array(7 * count);
    for (let i = 0; i < count; i++) this.poses[7 * i + 3] = 1;
    this.packed = new Float32Array(8 * count);
    this.marks = new Float32Array(8 * count);
    this.shown = mechanism.links.map(() => 'none');
    this.color.set(color);
    this.skin = mechanism.skin ? new SkinView(mechanism.skin) : null;
    if (this.skin) this.skin.mesh.userData.casters = [this.spheres];
    geometries.forEach((geometry, link) => {
      if (!geometry?.boundingSphere) return;
      this.shaped.push(link);
      this.spheres.push(geometry.boundingSphere.clone());
    });
    if (this.skin) this.spheres.push(...this.skin.spheres);
    this.fill_marks();
  }

  /** The surface that is drawn; a change applies the present poses to it. */
  get surface(): CrowdSurface | null {
    return this.drawn_surface;
  }
  set surface(surface: CrowdSurface | null) {
    this.drawn_surface = surface;
    this.pack();
  }

  set_look(color: string, material: Material): void {
    const { roughness = 0.6, metalness = 0, link_colors, shape_colors = [] } = material;
    const text = JSON.stringify([color, roughness, metalness, link_colors, shape_colors, material.shown]);
    this.material = material;
    if (text === this.shown_look) return;
    this.shown_look = text;
    this.color.set(color);
    this.roughness = roughness;
    this.metalness = metalness;
    this.colors = link_colors && Object.keys(link_colors).length > 0 ? this.mechanism.links.map((link) => link_colors[link.name] ?? null) : null;
    this.shape_colors = shape_colors.some(Boolean) ? shape_colors : [];
    this.fill_marks();
  }

  /** Whether a link has a colour of its own. */
  has_color(link: number): boolean {
    return Boolean(this.colors?.[link]);
  }

  /** Highlights a link. */
  emphasise(link: number, emphasis: Emphasis): void {
    if (this.shown[link] === emphasis) return;
    this.shown[link] = emphasis;
    this.fill_marks();
  }

  /** Shows the skin, or the body, or both. @param shapes true: the collision shapes are shown instead of skins */
  show_skin(shapes: boolean): void {
    if (!this.skin) return;
    const { shown = 'skin' } = this.material;
    this.skinned = !shapes && shown !== 'body';
    this.bare = this.skinned && shown === 'skin';
    const glow = Math.max(...this.shown.map((e) => glows[e][1]));
    this.skin.set_look(this.material, this.shown.every((e) => e !== 'none') ? 0.12 * glow : 0);
    this.skin.visible = this.skinned;
  }

  private fill_marks(): void {
    this.marked = true;
    this.has_marks = this.colors !== null || this.shown.some((e) => e !== 'none');
    if (!this.has_marks) return;
    this.shown.forEach((emphasis, link) => {
      const own = this.colors?.[link];
      (own ? tint.set(own) : tint.copy(this.color)).toArray(this.marks, 8 * link);
      [this.marks[8 * link + 4], this.marks[8 * link + 5]] = glows[emphasis];
    });
  }

  /** Poses all links as in the neutral position. */
  place_neutral(): void {
    this.mechanism.links.forEach((link, i) => {
      if (link.neutral) this.poses.set(link.neutral, 7 * i);
    });
    this.pack();
  }

  /** Poses all links as in a frame, displaced by `offset`. */
  place(frame: Frame, character: CharacterFrame): void {
    this.place_poses(frame.floats, character.poses, character.links);
  }

  /** Poses all links from packed values: x y z (m) qw qx qy qz for each link, starting at index `at`; displaced by `offset`. */
  place_poses(values: ArrayLike<number>, at: number, links: number): void {
    const { poses, offset } = this;
    const count = 7 * Math.min(links, this.mechanism.links.length);
    for (let i = 0; i < count; i++) poses[i] = values[at + i]!;
    if (offset.x !== 0 || offset.y !== 0 || offset.z !== 0)
      for (let i = 0; i < count; i += 7) {
        poses[i]! += offset.x;
        poses[i + 1]! += offset.y;
        poses[i + 2]! += offset.z;
      }
    this.pack();
  }

  private pack(): void {
    const { poses, packed } = this;
    const inverses = this.drawn_surface?.inverses;
    const count = this.mechanism.links.length;
    for (let link = 0; link < count; link++) {
      read_pose(poses, 7 * link);
      const inverse = inverses?.[link];
      if (inverse) {
        // pose * inverse of the rest pose
        position.add(part_position.copy(inverse.position).applyQuaternion(rotation));
        rotation.multiply(inverse.rotation);
      }
      position.toArray(packed, 8 * link);
      rotation.toArray(packed, 8 * link + 4);
    }
    for (let i = 0; i < this.shaped.length; i++) {
      const link = this.shaped[i]!;
      const at = 7 * link;
      part_rotation.set(poses[at + 4]!, poses[at + 5]!, poses[at + 6]!, poses[at + 3]!);
      const { center } = this.spheres[i]!;
      center.copy(this.geometries[link]!.boundingSphere!.center).applyQuaternion(part_rotation);
      center.x += poses[at]!;
      center.y += poses[at + 1]!;
      center.z += poses[at + 2]!;
    }
    this.skin?.place(poses);
    this.posed = true;
    this.target_is_old = true;
  }

  /** Origin of the first link that has shapes, m. @return false: no link has shapes */
  root(out: THREE.Vector3): boolean {
    const link = this.shaped[0];
    if (link === undefined) return false;
    out.fromArray(this.poses, 7 * link);
    return true;
  }

  /** Distance of the first link from a point, m. */
  distance(point: THREE.Vector3): number {
    return position.fromArray(this.poses).distanceTo(point);
  }

  /** Meshes of the links as drawn now, with world matrices; null for links without shapes. They are made when they are needed first. */
  get links(): (THREE.Mesh | null)[] {
    return this.targets().meshes;
  }
  /** The group of these meshes. */
  get group(): THREE.Group {
    return this.targets().group;
  }

  private targets(): { group: THREE.Group; meshes: (THREE.Mesh | null)[] } {
    this.target ??= this.make_targets();
    if (!this.target_is_old) return this.target;
    this.target_is_old = false;
    this.target.meshes.forEach((mesh, link) => {
      if (!mesh) return;
      read_pose(this.poses, 7 * link);
      mesh.matrixWorld.compose(position, rotation, unit_scale);
    });
    return this.target;
  }

  private make_targets(): { group: THREE.Group; meshes: (THREE.Mesh | null)[] } {
    const group = new THREE.Group();
    const meshes = this.mechanism.links.map(({ name }, link) => {
      const geometry = this.geometries[link];
      if (!geometry) return null;
      const mesh = new THREE.Mesh(geometry, unseen);
      mesh.matrixAutoUpdate = mesh.matrixWorldAutoUpdate = false;
      mesh.name = name;
      mesh.userData = { character: this.character, link } satisfies LinkTag;
      group.add(mesh);
      return mesh;
    });
    return { group, meshes };
  }
}

function read_pose(values: ArrayLike<number>, at: number): void {
  position.set(values[at]!, values[at + 1]!, values[at + 2]!);
  rotation.set(values[at + 4]!, values[at + 5]!, values[at + 6]!, values[at + 3]!);
}
