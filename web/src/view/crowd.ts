/**
 * Draws the characters of the viewport with one drawing call (and one for shadows) for all characters of a mechanism. The poses of the links
 * are in a texture that all instances share; the vertex shader applies them with linear blend skinning.
 */
import * as THREE from 'three';
import type { Material } from '../core/look';
import type { MechanismData } from '../core/protocol';
import type { IndexRange } from './body_surface';
import { body_surface } from './body_view';
import { CrowdMember } from './crowd_member';
import { crowd_depth, crowd_material, texel_row } from './crowd_shader';
import { body_and_machine, rigid_surface, with_shape_colors, type CrowdSurface } from './crowd_surface';
import { surface_at } from './far_surface';
import { relief_attribute } from './relief';

const first_capacity = 8;
const max_painted = 16; // surfaces of a mechanism with different colours of its shapes

/** A texture of `values`, four floats a texel, in rows of texel_row texels. */
function data_texture(values: Float32Array<ArrayBuffer>): THREE.DataTexture {
  const texture = new THREE.DataTexture(values, texel_row, values.length / (4 * texel_row), THREE.RGBAFormat, THREE.FloatType);
  texture.needsUpdate = true;
  return texture;
}

/** A geometry without instances that shares the attributes of `surface`. */
function instanced(surface: THREE.BufferGeometry): THREE.InstancedBufferGeometry {
  const geometry = new THREE.InstancedBufferGeometry();
  for (const [name, attribute] of Object.entries(surface.attributes)) geometry.setAttribute(name, attribute);
  geometry.setIndex(surface.index);
  geometry.instanceCount = 0;
  return geometry;
}

/** Frees what `geometry` has on the graphics processor, except the attributes and the index, which it shares with `surface`. */
function dispose_instanced(geometry: THREE.InstancedBufferGeometry, surface: THREE.BufferGeometry): void {
  for (const name of Object.keys(surface.attributes)) geometry.deleteAttribute(name);
  geometry.setIndex(null);
  geometry.dispose();
}

/** All characters that are drawn by one call: those of one surface that reflect, or do not reflect, an environment. */
class Batch {
  readonly mesh: THREE.Mesh<THREE.InstancedBufferGeometry, THREE.MeshStandardMaterial>;
  private readonly uniforms: { u_links: { value: number }; u_poses: { value: THREE.DataTexture | null }; u_marks: { value: THREE.DataTexture | null } };
  private members: CrowdMember[] = [];
  private capacity = 0;
  private poses = new Float32Array(0);
  private marks = new Float32Array(0);
  private colors = new THREE.InstancedBufferAttribute(new Float32Array(0), 3);
  private surfaces = new THREE.InstancedBufferAttribute(new Float32Array(0), 3);

  constructor(private readonly surface: CrowdSurface) {
    this.uniforms = { u_links: { value: surface.links }, u_poses: { value: null }, u_marks: { value: null } };
    this.mesh = new THREE.Mesh(instanced(surface.geometry), crowd_material(this.uniforms, { own_colors: surface.geometry.hasAttribute('own_color'), by_vertices: surface.inverses !== null, relief: surface.geometry.hasAttribute(relief_attribute), whole_body: surface.whole_body }));
    this.mesh.customDepthMaterial = crowd_depth(this.uniforms);
    this.mesh.matrixAutoUpdate = false;
    this.mesh.frustumCulled = false; // the instances are anywhere
    this.mesh.castShadow = this.mesh.receiveShadow = true;
    this.mesh.raycast = () => undefined; // rays hit the shapes of the links
    const { shown, shadow } = surface;
    const show = ({ start, count }: IndexRange): void => this.mesh.geometry.setDrawRange(start, count);
    const eye = new THREE.Vector3();
    show(shown);
    this.mesh.onBeforeShadow = () => show(shadow);
    this.mesh.onBeforeRender = (renderer, _scene, camera) => {
      eye.setFromMatrixPosition(camera.matrixWorld);
      const nearest = Math.min(...this.members.map((member) => member.distance(eye)));
      show(surface_at(renderer, camera, surface, nearest));
    };
  }

  /** Copies what changed since the last call to the textures and attributes. @param environment what metal reflects; null: nothing */
  update(members: CrowdMember[], environment: THREE.Texture | null): void {
    const moved = members.length !== this.members.length || members.some((m, i) => m !== this.members[i]);
    if (members.length > this.capacity) this.grow(members.length);
    this.members = members;
    const { geometry, material } = this.mesh;
    geometry.instanceCount = members.length;
    this.mesh.visible = members.length > 0;
    const floats = 8 * this.surface.links;
    let [posed, marked] = [false, false];
    members.forEach((member, i) => {
      if (moved || member.posed) {
        this.poses.set(member.packed, floats * i);
        posed = true;
      }
      if (moved || member.marked) {
        this.marks.set(member.marks, floats * i);
        this.colors.setXYZ(i, member.color.r, member.color.g, member.color.b);
        this.surfaces.setXYZ(i, member.roughness, member.metalness, member.has_marks ? 1 : 0);
        marked = true;
      }
      member.posed = member.marked = false;
    });
    if (posed && this.uniforms.u_poses.value) this.uniforms.u_poses.value.needsUpdate = true;
    if (marked) {
      if (this.uniforms.u_marks.value) this.uniforms.u_marks.value.needsUpdate = true;
      this.colors.needsUpdate = this.surfaces.needsUpdate = true;
    }
    this.mesh.userData.casters = members.map((m) => m.spheres);
    if (material.envMap === environment) return;
    material.envMap = environment;
    material.envMapRotation.set(Math.PI / 2, 0, 0); // up is y in the map, and z here
    material.needsUpdate = true;
  }

  private grow(wanted: number): void {
    this.capacity = Math.max(first_capacity, 2 ** Math.ceil(Math.log2(wanted)));
    const rows = Math.ceil((2 * this.surface.links * this.capacity) / texel_row);
    this.poses = new Float32Array(4 * texel_row * rows);
    this.marks = new Float32Array(4 * texel_row * rows);
    this.uniforms.u_poses.value?.dispose();
    this.uniforms.u_marks.value?.dispose();
    this.uniforms.u_poses.value = data_texture(this.poses);
    this.uniforms.u_marks.value = data_texture(this.marks);
    this.colors = new THREE.InstancedBufferAttribute(new Float32Array(3 * this.capacity), 3);
    this.surfaces = new THREE.InstancedBufferAttribute(new Float32Array(3 * this.capacity), 3);
    // a new geometry, because three.js keeps the number of instances for which a geometry had space when it was first drawn
    const former = this.mesh.geometry;
    this.mesh.geometry = instanced(this.surface.geometry);
    this.mesh.geometry.setAttribute('a_color', this.colors);
    this.mesh.geometry.setAttribute('a_surface', this.surfaces);
    dispose_instanced(former, this.surface.geometry);
    this.members = [];
  }

  dispose(): void {
    dispose_instanced(this.mesh.geometry, this.surface.geometry);
    this.uniforms.u_poses.value?.dispose();
    this.uniforms.u_marks.value?.dispose();
    this.mesh.material.dispose();
    this.mesh.customDepthMaterial?.dispose();
  }
}

/** The surfaces of a mechanism: of its smooth body if it is one, and of its collision shapes. */
interface Surfaces {
  body: CrowdSurface | null;
  shapes: CrowdSurface;
  /** The shapes with colours of their own, by the colours. */
  painted: Map<string, CrowdSurface>;
}

export class Crowd {
  readonly group = new THREE.Group();
  private readonly members = new Set<CrowdMember>();
  private readonly surfaces = new WeakMap<MechanismData, Surfaces>();
  private readonly batches = new Map<CrowdSurface, [plain: Batch, metal: Batch]>();
  private environment: THREE.Texture | null = null;
  private shapes = false;
  /** True: a member was added, removed, or drawn by another batch. */
  private changed = true;

  /** Adds a character in its neutral pose. @param geometries of the links; they are shared and not owned */
  add(character: string, mechanism: MechanismData, geometries: readonly (THREE.BufferGeometry | null)[], color: string): CrowdMember {
    const member = new CrowdMember(character, mechanism, geometries, color);
    member.surface = this.surface_of(member);
    member.place_neutral();
    member.show_skin(this.shapes);
    if (member.skin) this.group.add(member.skin.mesh);
    this.members.add(member);
    this.changed = true;
    return member;
  }

  remove(member: CrowdMember): void {
    this.members.delete(member);
    if (member.skin) this.group.remove(member.skin.mesh);
    member.skin?.dispose();
    this.changed = true;
  }

  /** Draws the collision shapes of the links instead of the smooth surfaces, or the other way round. */
  show_shapes(on: boolean): void {
    if (this.shapes === on) return;
    this.shapes = on;
    this.changed = true;
    for (const member of this.members) {
      member.surface = this.surface_of(member);
      member.show_skin(on);
    }
  }

  /** Colour and surface of a character. @param environment what metal reflects; null: nothing */
  set_look(member: CrowdMember, color: string, material: Material, environment: THREE.Texture | null): void {
    const metal = member.metalness > 0;
    const { bare } = member;
    member.set_look(color, material);
    member.show_skin(this.shapes);
    this.changed ||= bare !== member.bare;
    if (environment && environment !== this.environment) this.environment = environment;
    this.changed ||= metal !== member.metalness > 0;
    const surface = this.surface_of(member);
    if (surface === member.surface) return;
    member.surface = surface;
    this.changed = true;
  }

  private surface_of(member: CrowdMember): CrowdSurface {
    const { mechanism } = member;
    let surfaces = this.surfaces.get(mechanism);
    if (!surfaces) {
      const body = body_surface(mechanism);
      surfaces = { body: body && body_and_machine(body, mechanism, member.geometries), shapes: rigid_surface(mechanism, member.geometries), painted: new Map() };
      this.surfaces.set(mechanism, surfaces);
    }
    if (surfaces.body && !this.shapes) return surfaces.body;
    if (member.shape_colors.length === 0) return surfaces.shapes;
    const links = mechanism.links.map((_, link) => member.has_color(link));
    const key = JSON.stringify([member.shape_colors, links]);
    let painted = surfaces.painted.get(key);
    if (!painted) {
      if (surfaces.painted.size >= max_painted) surfaces.painted.clear(); // a slider of a colour leaves many behind
      painted = with_shape_colors(surfaces.shapes, member.geometries, member.shape_colors, (link) => links[link]!);
      surfaces.painted.set(key, painted);
    }
    return painted;
  }

  /** Brings the drawn objects up to date; called before each picture. */
  update(): void {
    if (this.changed) {
      for (const member of this.members)
        if (!this.batches.has(member.surface!)) {
          const pair: [Batch, Batch] = [new Batch(member.surface!), new Batch(member.surface!)];
          this.batches.set(member.surface!, pair);
          this.group.add(pair[0].mesh, pair[1].mesh);
        }
      const drawn = new Set([...this.members].map((m) => m.surface!));
      for (const [surface, pair] of this.batches) {
        if (drawn.has(surface) || !surface.geometry.hasAttribute('own_color')) continue;
        for (const batch of pair) {
          this.group.remove(batch.mesh);
          batch.dispose();
        }
        this.batches.delete(surface);
      }
      this.lists.clear();
      for (const pair of this.batches.values()) for (const batch of pair) this.lists.set(batch, []);
      for (const member of this.members) if (!member.bare) this.lists.get(this.batches.get(member.surface!)![member.metalness > 0 ? 1 : 0])!.push(member);
      this.changed = false;
    }
    for (const [plain, metal] of this.batches.values()) {
      plain.update(this.lists.get(plain)!, null);
      metal.update(this.lists.get(metal)!, this.environment);
    }
  }
  private readonly lists = new Map<Batch, CrowdMember[]>();

  dispose(): void {
    for (const member of this.members) member.skin?.dispose();
    for (const pair of this.batches.values()) for (const batch of pair) batch.dispose();
  }
}
