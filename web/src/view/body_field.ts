/** The distance field of a body: the shapes of its links, blended smoothly where links are connected, and apart elsewhere. */
import * as THREE from 'three';
import type { LinkData, MechanismData, ShapeData } from '../core/protocol';

/** Length of a vector. Math.hypot() takes ten times as long. */
const length = (x: number, y: number, z: number): number => Math.sqrt(x * x + y * y + z * z);

const no_scale = new THREE.Vector3(1, 1, 1);

/** Pose packed as x y z qw qx qy qz (m). */
function pose_matrix(p: readonly number[] | undefined): THREE.Matrix4 {
  const [x = 0, y = 0, z = 0, qw = 1, qx = 0, qy = 0, qz = 0] = p ?? [];
  return new THREE.Matrix4().compose(new THREE.Vector3(x, y, z), new THREE.Quaternion(qx, qy, qz, qw), no_scale);
}

const farthest = 0.1; // m: distance() skips links that are farther away
const blend_of_radius = 0.8; // width of a blend per radius of the thinner link: a joint becomes up to 0.2 radii thicker

/** One shape: its kind and sizes, and the transform from the world of the bind pose into its own frame. */
interface Part {
  kind: 'round' | 'ellipsoid' | 'box';
  /** Half of the length of the axis of a round shape, along z; half extents of the others; m. */
  sizes: readonly [number, number, number];
  /** Radius of a round shape and of the edges of a box, m. */
  round: number;
  /** Half extents of a box that contains the shape, m. */
  extents: readonly [number, number, number];
  /** Width of the blend with the other shapes of the link, m. */
  blend: number;
  /** The first three rows of the transform, row by row. */
  into: Float64Array;
  centre: THREE.Vector3;
  /** Radius of a sphere around the shape's origin that contains the shape, m. */
  reach: number;
  /** Half of the shape's smallest width, m. */
  radius: number;
}

function part_of(shape: ShapeData, bind: THREE.Matrix4): Part | null {
  const inverse = bind.clone().multiply(pose_matrix(shape.pose)).invert();
  const e = inverse.elements;
  const into = Float64Array.of(e[0]!, e[4]!, e[8]!, e[12]!, e[1]!, e[5]!, e[9]!, e[13]!, e[2]!, e[6]!, e[10]!, e[14]!);
  const centre = new THREE.Vector3().setFromMatrixPosition(inverse.clone().invert());
  const r = shape.radius ?? 0.05;
  if (shape.type === 'sphere') return { kind: 'round', sizes: [0, 0, 0], round: r, extents: [r, r, r], blend: 0.5 * r, into, centre, reach: r, radius: r };
  if (shape.type === 'capsule' || shape.type === 'cylinder') {
    const half = Math.max(0, (shape.half_length ?? 0) - (shape.type === 'cylinder' ? r : 0));
    return { kind: 'round', sizes: [0, 0, half], round: r, extents: [r, r, half + r], blend: 0.5 * r, into, centre, reach: half + r, radius: r };
  }
  const [a, b, c] = shape.half_extents ?? [0.05, 0.05, 0.05];
  const smallest = Math.min(a, b, c);
  if (shape.type === 'ellipsoid') return { kind: 'ellipsoid', sizes: [a, b, c], round: 0, extents: [a, b, c], blend: 0.5 * smallest, into, centre, reach: Math.max(a, b, c), radius: smallest };
  if (shape.type !== 'box') return null;
  // a foot or a hand is round, its collision box is not
  return { kind: 'box', sizes: [a, b, c], round: 0.7 * smallest, extents: [a, b, c], blend: 0.5 * smallest, into, centre, reach: length(a, b, c), radius: smallest };
}

/** Signed distance of a point of the world from a shape, m. */
function part_distance(part: Part, px: number, py: number, pz: number): number {
  const { into: m, sizes, round } = part;
  const x = m[0]! * px + m[1]! * py + m[2]! * pz + m[3]!;
  const y = m[4]! * px + m[5]! * py + m[6]! * pz + m[7]!;
  const z = m[8]! * px + m[9]! * py + m[10]! * pz + m[11]!;
  const c = sizes[2];
  if (part.kind === 'round') return length(x, y, z - Math.max(-c, Math.min(c, z))) - round;
  const a = sizes[0];
  const b = sizes[1];
  if (part.kind === 'ellipsoid') {
    // the usual first-order bound of the distance to an ellipsoid: exact on its surface
    const k0 = length(x / a, y / b, z / c);
    const k1 = length(x / (a * a), y / (b * b), z / (c * c));
    return k1 < 1e-9 ? -part.radius : (k0 * (k0 - 1)) / k1;
  }
  const u = Math.abs(x) - a + round;
  const v = Math.abs(y) - b + round;
  const w = Math.abs(z) - c + round;
  return length(Math.max(u, 0), Math.max(v, 0), Math.max(w, 0)) + Math.min(0, Math.max(u, v, w)) - round;
}

/** A link with its shapes in the bind pose. */
export interface FieldLink {
  index: number;
  /** Index into BodyField.links; -1: the link is too thin. */
  number: number;
  parts: Part[];
  /** The nearest ancestor with shapes; null: none. */
  parent: FieldLink | null;
  centre: THREE.Vector3;
  reach: number;
  radius: number;
  /** Width of the blend with the parent, m. */
  blend: number;
}

const has_shape = (link: LinkData): boolean => link.shapes.length > 0;

/** Whether a mechanism is a body: most of its links have the label of a part of the anatomy, and no link is a mesh. */
export function is_body(mechanism: MechanismData): boolean {
  const solid = mechanism.links.filter(has_shape);
  const named = solid.filter((l) => l.label).length;
  return solid.length >= 8 && 2 * named >= solid.length && solid.every((l) => l.shapes.every((s) => s.type !== 'mesh' && s.type !== 'height_field'));
}

/**
 * For each link, whether it is a part of a body: it or a link that carries it has the label of a part of the anatomy. A bicycle that carries
 * a person is no part of a body; a sword in a hand is.
 */
export function parts_of_body(mechanism: MechanismData): boolean[] {
  const parts: boolean[] = [];
  for (const { label, parent } of mechanism.links) parts.push(Boolean(label) || (parts[parent] ?? false));
  return parts;
}

/** Whether all shapes of a mechanism are parts of a body. */
export function is_whole_body(mechanism: MechanismData): boolean {
  const of_body = parts_of_body(mechanism);
  return mechanism.links.every(({ shapes }, i) => of_body[i] || shapes.length === 0);
}

const spread_leg = 0.16; // rad, 9 degrees: thighs of the bind pose do not touch each other
const spread_arm = 0.7; // rad, 40 degrees: hanging arms of the bind pose do not touch the trunk

/**
 * Poses of all links in which the surface is made: the neutral pose, with legs and hanging arms turned outwards, so that only connected links
 * are near each other.
 */
export function bind_poses(mechanism: MechanismData): THREE.Matrix4[] {
  const poses = mechanism.links.map((l) => pose_matrix(l.neutral));
  const inside = (link: number, root: number): boolean => {
    for (let i = link; i >= 0; i = mechanism.links[i]!.parent) if (i === root) return true;
    return false;
  };
  const middle = new THREE.Vector3().setFromMatrixPosition(poses[0] ?? new THREE.Matrix4());
  mechanism.links.forEach((link, root) => {
    const leg = /^thigh/.test(link.label ?? '');
    if (!leg && !/^upper arm/.test(link.label ?? '')) return;
    const origin = new THREE.Vector3().setFromMatrixPosition(poses[root]!);
    const members = mechanism.links.map((_, i) => i).filter((i) => inside(i, root));
    const end = new THREE.Vector3().setFromMatrixPosition(poses[members[members.length - 1]!]!).sub(origin);
    const hangs = end.z < -0.8 * end.length();
    if (end.length() < 1e-3 || !hangs) return;
    const outwards = Math.sign(origin.y - middle.y);
    const turn = new THREE.Matrix4().makeTranslation(origin).multiply(new THREE.Matrix4().makeRotationX(outwards * (leg ? spread_leg : spread_arm))).multiply(new THREE.Matrix4().makeTranslation(origin.clone().negate()));
    for (const i of members) poses[i]!.premultiply(turn);
  });
  return poses;
}

/** Smooth minimum (polynomial): equals min(a, b) where they differ by more than k. */
const smooth_min = (a: number, b: number, k: number): number => {
  const h = Math.max(k - Math.abs(a - b), 0) / k;
  return Math.min(a, b) - 0.25 * h * h * k;
};

export class BodyField {
  readonly links: FieldLink[] = [];
  /** Links of the body that are too thin for the field. */
  readonly thin: FieldLink[] = [];
  /** Links that distance() considers. */
  private near: FieldLink[];
  /** Distances from the links that distance() has computed at its present point; `known_at` is the number of its point. */
  private readonly known: Float64Array;
  private readonly known_at: Int32Array;
  private point = 0;

  /** @param thinnest m: links with a smaller radius are not part of the field */
  constructor(mechanism: MechanismData, readonly bind: readonly THREE.Matrix4[], thinnest = 0) {
    const by_index = new Map<number, FieldLink>();
    const of_body = parts_of_body(mechanism);
    mechanism.links.forEach((link, index) => {
      if (!of_body[index]) return;
      const parts = link.shapes.map((s) => part_of(s, bind[index]!)).filter((p) => p !== null);
      if (parts.length === 0) return;
      const centre = parts.reduce((sum, p) => sum.add(p.centre), new THREE.Vector3()).divideScalar(parts.length);
      const reach = Math.max(...parts.map((p) => p.reach + p.centre.distanceTo(centre)));
      let ancestor = link.parent;
      while (ancestor >= 0 && !by_index.has(ancestor)) ancestor = mechanism.links[ancestor]!.parent;
      const parent = by_index.get(ancestor) ?? null;
      const radius = Math.max(...parts.map((p) => p.radius));
      const thin = radius < thinnest;
      const made: FieldLink = { index, number: thin ? -1 : this.links.length, parts, parent, centre, reach, radius, blend: blend_of_radius * Math.min(radius, parent?.radius ?? radius) };
      if (thin) this.thin.push(made);
      else {
        by_index.set(index, made);
        this.links.push(made);
      }
    });
    this.near = [...this.links];
    this.known = new Float64Array(this.links.length);
    this.known_at = new Int32Array(this.links.length);
  }

  /** A box around the field. */
  box(): THREE.Box3 {
    const box = new THREE.Box3();
    for (const link of this.links) box.union(new THREE.Box3().setFromCenterAndSize(link.centre, new THREE.Vector3().setScalar(2 * (link.reach + link.blend))));
    return box;
  }

  /** Signed distance of a point from one link, m. */
  link_distance(link: FieldLink, x: number, y: number, z: number): number {
    const { parts } = link;
    let out = part_distance(parts[0]!, x, y, z);
    for (let i = 1; i < parts.length; i++) out = smooth_min(out, part_distance(parts[i]!, x, y, z), parts[i]!.blend);
    return out;
  }

  /** A lower bound of the distance from the link's surface: the distance from the boxes around its shapes, m. */
  min_distance(link: FieldLink, x: number, y: number, z: number): number {
    let out = Infinity;
    for (const { into: m, extents, blend } of link.parts) {
      const u = Math.abs(m[0]! * x + m[1]! * y + m[2]! * z + m[3]!) - extents[0];
      const v = Math.abs(m[4]! * x + m[5]! * y + m[6]! * z + m[7]!) - extents[1];
      const w = Math.abs(m[8]! * x + m[9]! * y + m[10]! * z + m[11]!) - extents[2];
      out = Math.min(out, length(Math.max(u, 0), Math.max(v, 0), Math.max(w, 0)) - blend);
    }
    return out;
  }

  /** Value of the pair of a link and its parent, m. */
  pair_distance(link: FieldLink, x: number, y: number, z: number): number {
    const own = this.link_distance(link, x, y, z);
    return link.parent ? smooth_min(own, this.link_distance(link.parent, x, y, z), link.blend) : own;
  }

  /** Prepares calls of distance() for points within `reach` (m) of a point: they skip the links that are too far away to matter. */
  look_near(x: number, y: number, z: number, reach: number): void {
    const { near } = this;
    let count = 0;
    for (const l of this.links) if (length(x - l.centre.x, y - l.centre.y, z - l.centre.z) - l.reach - l.blend < farthest + 1.01 * reach) near[count++] = l;
    near.length = count;
  }

  /** Signed distance of a point from the body, m; exact near the surface only. The point must be within the reach of the last look_near(). */
  distance(x: number, y: number, z: number): number {
    this.point++;
    let out = Infinity;
    for (const link of this.near) {
      const { centre, parent } = link;
      const far = length(x - centre.x, y - centre.y, z - centre.z) - link.reach - link.blend;
      if (far >= Math.min(out, farthest)) continue;
      const own = this.distance_here(link, x, y, z);
      out = Math.min(out, parent ? smooth_min(own, this.distance_here(parent, x, y, z), link.blend) : own);
    }
    return out;
  }

  /** The link whose surface is nearest. The point must be within the reach of the last look_near() and near the body. */
  nearest_link(x: number, y: number, z: number): FieldLink {
    let nearest = this.near[0] ?? this.links[0]!;
    let smallest = Infinity;
    for (const link of this.near) {
      const d = this.link_distance(link, x, y, z);
      if (d < smallest) [smallest, nearest] = [d, link];
    }
    return nearest;
  }

  /** link_distance(), computed once for each point. */
  private distance_here(link: FieldLink, x: number, y: number, z: number): number {
    const { number } = link;
    if (this.known_at[number] !== this.point) {
      this.known_at[number] = this.point;
      this.known[number] = this.link_distance(link, x, y, z);
    }
    return this.known[number]!;
  }
}
