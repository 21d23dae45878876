/** Drawing of a character: one shaded mesh for each link, posed from the values of a frame. */
import * as THREE from 'three';
import { RoundedBoxGeometry } from 'three/examples/jsm/geometries/RoundedBoxGeometry.js';
import { mergeGeometries, mergeVertices } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import type { Frame, CharacterFrame } from '../core/frames';
import type { Material } from '../core/look';
import type { LinkData, MechanismData, ShapeData } from '../core/protocol';
import { is_whole_body, parts_of_body } from './body_field';
import { BodySkin, body_surface, hidden_layer, LinkBones, type Glow } from './body_view';
import type { BodySurface } from './body_surface';
import { complete_relief, draw_relief, relief_attribute } from './relief';
import { shadow_material } from './shadow_region';
import { shade_by_vertices } from './vertex_shading';
import { SkinView } from './skin_view';
import { surface_geometry, type Surfaces } from './surfaces';

const pose_position = new THREE.Vector3();
const pose_rotation = new THREE.Quaternion();
const pose_matrix = new THREE.Matrix4();
const unit_scale = new THREE.Vector3(1, 1, 1);

/** Number of segments around a round shape of radius `r` (m): 14 ... 40, so that its outline looks round in close view. */
const around = (r: number): number => Math.round(Math.min(40, Math.max(14, 12 + 110 * r)));

function shape_geometry(shape: ShapeData, surfaces: Surfaces): THREE.BufferGeometry {
  const r = Math.max(shape.radius ?? 0.05, 1e-3);
  const n = around(r);
  let geometry: THREE.BufferGeometry;
  if (shape.type === 'sphere') {
    geometry = new THREE.SphereGeometry(r, n, Math.round(0.7 * n));
  } else if (shape.type === 'capsule') {
    geometry = new THREE.CapsuleGeometry(r, 2 * (shape.half_length ?? 0), Math.round(n / 3), n).rotateX(Math.PI / 2);
  } else if (shape.type === 'cylinder') {
    geometry = new THREE.CylinderGeometry(r, r, 2 * (shape.half_length ?? 0.05), Math.max(24, n), 1).rotateX(Math.PI / 2);
  } else if (shape.type === 'ellipsoid') {
    const [x, y, z] = shape.half_extents ?? [0.05, 0.05, 0.05];
    const m = around(Math.max(x, y, z));
    geometry = new THREE.SphereGeometry(1, m, Math.round(0.7 * m)).scale(x, y, z);
  } else if (shape.surface !== undefined) {
    geometry = surface_geometry(surfaces, shape.surface);
  } else {
    const [x, y, z] = shape.half_extents ?? [0.05, 0.05, 0.05];
    // slightly rounded edges, at most 20 mm, so that the drawn box stays close to the collision box
    geometry = new RoundedBoxGeometry(2 * x, 2 * y, 2 * z, 4, Math.min(0.02, 0.42 * Math.min(x, y, z)));
  }
  const [x = 0, y = 0, z = 0, qw = 1, qx = 0, qy = 0, qz = 0] = shape.pose;
  geometry.applyMatrix4(new THREE.Matrix4().compose(new THREE.Vector3(x, y, z), new THREE.Quaternion(qx, qy, qz, qw), unit_scale));
  geometry.deleteAttribute('uv');
  return geometry.index ? geometry : mergeVertices(geometry);
}

/** Number of vertices of each shape in the geometry of a link. Stored in the geometry's `userData`. */
export interface ShapeCounts {
  counts: number[];
}

/**
 * Colours of the vertices of links, 4 values each: r g b (linear), and 1 for a colour of the shape, 0 for that of the link.
 * @param colors [visible shapes of all links] '#rrggbb'; '': the colour of the link  @param ignored links that have a colour of their own
 */
export function shape_colors(geometries: readonly (THREE.BufferGeometry | null)[], colors: readonly string[], ignored: (link: number) => boolean): (Float32Array | null)[] {
  let shape = 0;
  return geometries.map((geometry, link) => {
    if (!geometry) return null;
    const { counts } = geometry.userData as ShapeCounts;
    const out = new Float32Array(4 * geometry.getAttribute('position').count);
    let vertex = 0;
    for (const count of counts) {
      const color = colors[shape++];
      if (color && !ignored(link)) {
        const { r, g, b } = paint.set(color);
        for (let v = vertex; v < vertex + count; v++) out.set([r, g, b, 1], 4 * v);
      }
      vertex += count;
    }
    return out;
  });
}
const paint = new THREE.Color();

/** One merged geometry of all shapes of a link, in the link's frame; null if the link has no shapes. */
export function link_geometry(link: LinkData, surfaces: Surfaces): THREE.BufferGeometry | null {
  if (link.shapes.length === 0) return null;
  const parts = link.shapes.map((shape) => shape_geometry(shape, surfaces));
  complete_relief(parts);
  const geometry = mergeGeometries(parts);
  geometry.userData = { counts: parts.map((part) => part.getAttribute('position').count) } satisfies ShapeCounts;
  geometry.computeBoundingSphere();
  return geometry;
}

/** Geometries of a mechanism's links. All characters and ghosts of the mechanism share them. */
export function mechanism_geometries(mechanism: MechanismData): (THREE.BufferGeometry | null)[] {
  const geometries = mechanism.links.map((link) => link_geometry(link, mechanism.surfaces ?? {}));
  complete_relief(geometries);
  return geometries;
}

/** Identifies a link of a character. Stored in each mesh's `userData`. */
export interface LinkTag {
  character: string;
  link: number;
}

export type Emphasis = 'none' | 'hover' | 'selected' | 'pulled';

const shade_link = (shader: THREE.WebGLProgramParametersWithUniforms): void => {
  const color = '\n#if defined(USE_COLOR) || defined(USE_COLOR_ALPHA)\nvColor.rgb * diffuse\n#else\ndiffuse\n#endif\n';
  shade_by_vertices(shader, { color, roughness: 'roughness', emission: 'emissive' });
};

/** Light that an emphasised link emits. */
export const glows: Record<Emphasis, Glow> = { none: [0, 0], hover: [0.09, 0], selected: [0, 0.34], pulled: [0, 0.5] };

/**
 * The three.js object that shows a character: a group with one mesh for each link, and for a body its smooth surface, which is drawn instead
 * of the meshes of the links that are parts of the body. Geometries are shared and not owned.
 */
export class CharacterView {
  readonly group = new THREE.Group();
  /** Mesh of each link; null for links without shapes. */
  readonly links: (THREE.Mesh | null)[];
  private readonly plain: THREE.MeshStandardMaterial;
  /** Whether the links have a relief. */
  private readonly relief: boolean;
  /** World poses of the links as drawn: x y z (m) qw qx qy qz of each. */
  private readonly poses: Float32Array;
  private readonly emphasised: Record<Exclude<Emphasis, 'none'>, THREE.MeshStandardMaterial>;
  private readonly shown: Emphasis[];
  /** The smooth surface; null if the mechanism is no body, or the surface is not wanted. */
  private readonly skin: BodySkin | null;
  /** The skin of the character's file; null if it has none. */
  private own_skin: SkinView | null = null;
  private shapes_only = false;
  private material: Material = {};
  /** Colour and surface as last set, as JSON. */
  private shown_look = '';
  /** Material of each link without emphasis; `plain` where absent. */
  private readonly base: THREE.MeshStandardMaterial[] = [];
  /** Materials of single links (color_links). */
  private readonly own: THREE.MeshStandardMaterial[] = [];

  constructor(
    readonly character: string,
    readonly mechanism: MechanismData,
    geometries: (THREE.BufferGeometry | null)[],
    color: string,
    /** Makes the smooth surface; null: the links are always drawn one by one. */
    surface_of: ((mechanism: MechanismData) => BodySurface | null) | null = body_surface,
  ) {
    this.poses = new Float32Array(7 * mechanism.links.length);
    for (let i = 0; i < mechanism.links.length; i++) this.poses[7 * i + 3] = 1;
    const surface = surface_of && surface_of(mechanism);
    this.skin = surface && new BodySkin(surface, color, is_whole_body(mechanism));
    this.relief = geometries.some((geometry) => geometry?.hasAttribute(relief_attribute));
    this.plain = this.material_of(color);
    const tinted = (emissive: number, emissiveIntensity: number): THREE.MeshStandardMaterial => this.material_of(color, { emissive, emissiveIntensity });
    this.emphasised = { hover: tinted(0xffffff, 0.09), selected: tinted(0xff8a3d, 0.34), pulled: tinted(0xff8a3d, 0.5) };
    this.shown = mechanism.links.map(() => 'none');
    this.links = mechanism.links.map((link, index) => {
      const geometry = geometries[index];
      if (!geometry) return null;
      const mesh = new THREE.Mesh(geometry, this.plain);
      mesh.matrixAutoUpdate = false;
      mesh.castShadow = true;
      mesh.customDepthMaterial = shadow_material;
      mesh.receiveShadow = true;
      mesh.name = link.name;
      mesh.userData = { character, link: index } satisfies LinkTag;
      this.group.add(mesh);
      return mesh;
    });
    if (this.skin) this.group.add(this.skin.mesh);
    this.hide_links(this.skin !== null);
    this.place_neutral();
    this.add_skin(mechanism);
  }

  /** A material of links. Beside the surface of a body, links are shaded as it is. */
  private material_of(color: THREE.ColorRepresentation, more: THREE.MeshStandardMaterialParameters = {}): THREE.MeshStandardMaterial {
    const material = new THREE.MeshStandardMaterial({ color, roughness: 0.6, metalness: 0, ...more });
    if (this.skin) Object.assign(material, { onBeforeCompile: shade_link, defines: { ...material.defines, LARGE_TRIANGLES: '' } });
    else if (this.relief) material.onBeforeCompile = draw_relief;
    return material;
  }

  /** Draws the skin of a mechanism with the same links from now on. Without a skin, nothing changes. */
  add_skin({ skin }: MechanismData): void {
    if (!skin || this.own_skin) return;
    this.own_skin = new SkinView(skin);
    this.group.add(this.own_skin.mesh);
    this.own_skin.place(this.poses);
    this.show_parts();
  }

  /** Shows skin, body or shapes as the material and show_shapes() specify. */
  private show_parts(): void {
    const { shown = 'skin' } = this.material;
    const skinned = this.own_skin !== null && !this.shapes_only && shown !== 'body';
    this.own_skin?.set_look(this.material);
    if (this.own_skin) this.own_skin.visible = skinned;
    const bare = this.own_skin !== null && skinned && shown === 'skin';
    const smooth = this.skin !== null && !this.shapes_only && !bare;
    if (this.skin) this.skin.mesh.visible = smooth;
    const of_body = parts_of_body(this.mechanism);
    this.links.forEach((mesh, i) => mesh?.layers.set(bare || (smooth && of_body[i]) ? hidden_layer : 0));
  }

  /** Draws the collision shapes of the links instead of the smooth surface, or the other way round. */
  show_shapes(on: boolean): void {
    if (this.shapes_only === on) return;
    this.shapes_only = on;
    this.show_parts();
  }

  /** Hides the links that the smooth surface shows, or shows them again. */
  private hide_links(on: boolean): void {
    const of_body = parts_of_body(this.mechanism);
    this.links.forEach((mesh, i) => mesh?.layers.set(on && of_body[i] ? hidden_layer : 0));
  }

  /** Colour and surface of the character. @param environment what metal reflects; null: nothing */
  set_look(color: string, material: Material, environment: THREE.Texture | null = null): void {
    const { roughness = 0.6, metalness = 0, link_colors, shape_colors: painted = [] } = material;
    const text = JSON.stringify([color, roughness, metalness, link_colors, painted, material.shown, environment?.uuid]);
    if (text === this.shown_look) return;
    this.shown_look = text;
    this.material = material;
    if (this.own_skin) this.show_parts();
    const names = Object.keys(link_colors ?? {});
    const colors = names.length > 0 ? this.mechanism.links.map((link) => link_colors![link.name] ?? null) : null;
    this.color_links(colors ?? []);
    this.skin?.set_tints(colors && colors.map((c) => c ?? color));
    const { plain, own, emphasised, skin } = this;
    for (const material of [plain, ...Object.values(emphasised), ...(skin ? [skin.material] : [])]) material.color.set(color);
    this.paint_shapes(painted, color, colors);
    for (const material of [plain, ...Object.values(emphasised), ...own, ...(skin ? [skin.material] : [])]) {
      material.roughness = roughness;
      material.metalness = metalness;
      const map = metalness > 0 ? environment : null;
      if (material.envMap !== map) {
        material.envMap = map;
        material.envMapRotation.set(Math.PI / 2, 0, 0); // up is y in the map, and z here
        material.needsUpdate = true;
      }
    }
  }

  /** Gives the vertices of shapes their colours. @param colors [shapes]  @param of_links colours of links; null: none */
  private paint_shapes(colors: readonly string[], color: string, of_links: readonly (string | null)[] | null): void {
    const on = colors.some(Boolean);
    const materials = [this.plain, ...Object.values(this.emphasised)];
    if (!on && !this.plain.vertexColors) return;
    for (const material of materials) {
      material.vertexColors = on;
      if (on) material.color.set(0xffffff);
      material.needsUpdate = true;
    }
    const painted = shape_colors(this.links.map((mesh) => mesh?.geometry ?? null), colors, (link) => Boolean(of_links?.[link]));
    const { r, g, b } = paint.set(color);
    this.links.forEach((mesh, link) => {
      const values = painted[link];
      if (!mesh || !values) return;
      for (let i = 0; i < values.length; i += 4) if (values[i + 3] === 0) values.set([r, g, b, 1], i);
      if (!mesh.userData.own_geometry) {
        const shared = mesh.geometry; // other characters have other colours
        mesh.geometry = new THREE.BufferGeometry().copy(shared);
        mesh.geometry.userData = shared.userData;
        mesh.userData.own_geometry = true;
      }
      mesh.geometry.setAttribute('color', new THREE.BufferAttribute(values, 4));
    });
  }

  /** Colours links one by one. @param colors [links] colour; null: the character's own. Materials are owned by this view. */
  color_links(colors: readonly (string | null)[]): void {
    for (const material of this.own) material.dispose();
    this.own.length = 0;
    const by_color = new Map<string, THREE.MeshStandardMaterial>();
    this.links.forEach((mesh, index) => {
      if (!mesh) return;
      const color = colors[index];
      let material = color ? by_color.get(color) : this.plain;
      if (!material) {
        material = this.material_of(color!);
        by_color.set(color!, material);
        this.own.push(material);
      }
      this.base[index] = material;
      if (this.shown[index] === 'none') mesh.material = material;
    });
  }

  /** Highlights a link. */
  emphasise(link: number, emphasis: Emphasis): void {
    const mesh = this.links[link];
    if (!mesh || this.shown[link] === emphasis) return;
    this.shown[link] = emphasis;
    mesh.material = emphasis === 'none' ? (this.base[link] ?? this.plain) : this.emphasised[emphasis];
    this.skin?.set_glow(link, glows[emphasis]);
  }

  /** Poses all links as in the neutral position. */
  place_neutral(): void {
    this.mechanism.links.forEach((link, index) => {
      const p = link.neutral;
      if (p) this.set_pose(index, p, 0);
    });
    this.own_skin?.place(this.poses);
  }

  /** Poses all links as in a frame. */
  place(frame: Frame, character: CharacterFrame): void {
    const count = Math.min(character.links, this.links.length);
    for (let i = 0; i < count; i++) this.set_pose(i, frame.floats, character.poses + 7 * i);
    this.own_skin?.place(this.poses);
  }

  private set_pose(link: number, values: ArrayLike<number>, at: number): void {
    const pose = read_pose(values, at);
    for (let i = 0; i < 7; i++) this.poses[7 * link + i] = values[at + i]!;
    place_mesh(this.links[link], pose);
    this.skin?.bones.set(link, pose);
  }

  /** Poses all links from packed values of a preview: x y z (m) qw qx qy qz for each link, starting at index `at`. */
  place_poses(values: Float32Array, at: number, links: number): void {
    const count = Math.min(links, this.links.length);
    for (let i = 0; i < count; i++) this.set_pose(i, values, at + 7 * i);
    this.own_skin?.place(this.poses);
  }

  dispose(): void {
    this.skin?.dispose();
    this.own_skin?.dispose();
    this.plain.dispose();
    for (const material of this.own) material.dispose();
    for (const material of Object.values(this.emphasised)) material.dispose();
  }
}

/** The packed pose as a matrix, which the next call changes. */
function read_pose(values: ArrayLike<number>, at: number): THREE.Matrix4 {
  pose_position.set(values[at]!, values[at + 1]!, values[at + 2]!);
  pose_rotation.set(values[at + 4]!, values[at + 5]!, values[at + 6]!, values[at + 3]!);
  return pose_matrix.compose(pose_position, pose_rotation, unit_scale);
}

function place_mesh(mesh: THREE.Mesh | null | undefined, pose: THREE.Matrix4): void {
  if (!mesh) return;
  mesh.matrix.copy(pose);
  mesh.matrixWorldNeedsUpdate = true;
}

/** Height of the lowest point of a mechanism in its neutral pose, m; 0 without shapes. */
export function lowest_point(mechanism: MechanismData): number {
  const box = new THREE.Box3();
  mechanism_geometries(mechanism).forEach((geometry, i) => {
    if (!geometry) return;
    const [x = 0, y = 0, z = 0, qw = 1, qx = 0, qy = 0, qz = 0] = mechanism.links[i]!.neutral ?? [];
    const pose = new THREE.Matrix4().compose(new THREE.Vector3(x, y, z), new THREE.Quaternion(qx, qy, qz, qw), new THREE.Vector3(1, 1, 1));
    const points = geometry.getAttribute('position');
    const point = new THREE.Vector3();
    for (let k = 0; k < points.count; k++) box.expandByPoint(point.fromBufferAttribute(points, k).applyMatrix4(pose));
    geometry.dispose();
  });
  return box.isEmpty() ? 0 : box.min.z;
}

const ghost_color = 0x8fb3c4;

/** A ghost: the character at another time as an even, transparent silhouette. Depth is drawn first, so that inner surfaces stay hidden. */
/** Makes a transparent material opaque where its surface is seen edge-on, and almost clear where it faces the viewer. */
function light_rim(material: THREE.MeshStandardMaterial): void {
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace(
      '#include <dithering_fragment>',
      '#include <dithering_fragment>\n  gl_FragColor.a *= mix(0.12, 1.0, pow(1.0 - abs(dot(normalize(vViewPosition), normal)), 1.6));',
    );
  };
}

export class Ghost {
  readonly group = new THREE.Group();
  /** Meshes of each link; empty if the surface is drawn. */
  private readonly pairs: ([THREE.Mesh, THREE.Mesh] | null)[] = [];
  private readonly bones: LinkBones | null = null;
  private readonly color_material: THREE.MeshStandardMaterial;
  private readonly depth_material: THREE.MeshBasicMaterial;

  /**
   * @param order index of the ghost of its character; fixes the draw order  @param surface smooth surface; null: the links are drawn
   * @param rim true: the ghost is opaque at its silhouette and almost clear inside
   */
  constructor(geometries: (THREE.BufferGeometry | null)[], order: number, surface: BodySurface | null, rim = false) {
    this.depth_material = new THREE.MeshBasicMaterial({ colorWrite: false });
    this.color_material = new THREE.MeshStandardMaterial({
      color: ghost_color,
      roughness: 0.9,
      transparent: true,
      opacity: 0.2,
      depthFunc: THREE.EqualDepth,
      depthWrite: false,
    });
    if (rim) light_rim(this.color_material);
    this.depth_material.transparent = true; // so that the depth is drawn after the solid bodies, before the ghost's colour
    this.group.visible = false;
    if (surface) {
      this.bones = new LinkBones(surface);
      [this.depth_material, this.color_material].forEach((material, i) => {
        const mesh = this.bones!.mesh(surface, material);
        mesh.renderOrder = 10 + i + 2 * order;
        this.group.add(mesh);
      });
      return;
    }
    this.pairs = geometries.map((geometry) => {
      if (!geometry) return null;
      const make = (material: THREE.Material, render_order: number): THREE.Mesh => {
        const mesh = new THREE.Mesh(geometry, material);
        mesh.matrixAutoUpdate = false;
        mesh.renderOrder = render_order;
        this.group.add(mesh);
        return mesh;
      };
      return [make(this.depth_material, 10 + 2 * order), make(this.color_material, 11 + 2 * order)];
    });
  }

  /** Shows the character as in `frame`. @param opacity 0 ... 1 */
  show(frame: Frame, character: CharacterFrame, opacity: number): void {
    this.place(frame.floats, character.poses, character.links, opacity, ghost_color);
  }

  /** Shows the character in packed poses of all links, 7 values each. */
  show_poses(poses: ArrayLike<number>, opacity: number, color: number): void {
    this.place(poses, 0, poses.length / 7, opacity, color);
  }

  private place(values: ArrayLike<number>, at: number, links: number, opacity: number, color: number): void {
    this.color_material.opacity = opacity;
    this.color_material.color.set(color);
    for (let i = 0; i < links; i++) {
      const pose = read_pose(values, at + 7 * i);
      this.bones?.set(i, pose);
      for (const mesh of this.pairs[i] ?? []) place_mesh(mesh, pose);
    }
    this.group.visible = true;
  }

  hide(): void {
    this.group.visible = false;
  }

  dispose(): void {
    this.color_material.dispose();
    this.depth_material.dispose();
  }
}
