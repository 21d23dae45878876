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

const blend_of_radius = 0.8; // width of a blend per radius of the thinner link: a joint becomes up to 0.2 radii thicker

/** One shape: its signed distance in its own frame, and the transform from the world of the bind pose into this frame. */
interface Part {
  into: THREE.Matrix4;
  distance: (x: number, y: number, z: number) => number;
  /** Radius of a sphere around the shape's origin that contains the shape, m. */
  reach: number;
  /** Half of the shape's smallest width, m. */
  radius: number;
}

function part_of(shape: ShapeData, bind: THREE.Matrix4): Part | null {
  const into = bind.clone().multiply(pose_matrix(shape.pose)).invert();
  const r = shape.radius ?? 0.05;
  if (shape.type === 'sphere') return { into, distance: (x, y, z) => length(x, y, z) - r, reach: r, radius: r };
  if (shape.type === 'capsule' || shape.type === 'cylinder') {
    const half = Math.max(0, (shape.half_length ?? 0) - (shape.type === 'cylinder' ? r : 0));
    return { into, distance: (x, y, z) => length(x, y, z - Math.max(-half, Math.min(half, z))) - r, reach: half + r, radius: r };
  }
  const [a, b, c] = shape.half_extents ?? [0.05, 0.05, 0.05];
  const smallest = Math.min(a, b, c);
  if (shape.type === 'ellipsoid') {
    // the usual first-order bound of the distance to an ellipsoid: exact on its surface
    const distance = (x: number, y: number, z: number): number => {
      const k0 = length(x / a, y / b, z / c);
      const k1 = length(x / (a * a), y / (b * b), z / (c * c));
      return k1 < 1e-9 ? -smallest : (k0 * (k0 - 1)) / k1;
    };
    return { into, distance, reach: Math.max(a, b, c), radius: smallest };
  }
  if (shape.type !== 'box') return null;
  const round = 0.7 * smallest; // a foot or a hand is round, its collision box is not
  const distance = (x: number, y: number, z: number): number => {
    const [u, v, w] = [Math.abs(x) - a + round, Math.abs(y) - b + round, Math.abs(z) - c + round];
    return length(Math.max(u, 0), Math.max(v, 0), Math.max(w, 0)) + Math.min(0, Math.max(u, v, w)) - round;
  };
  return { into, distance, reach: length(a, b, c), radius: smallest };
}

/** A link with its shapes in the bind pose. */
export interface FieldLink {
  index: number;
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

  constructor(mechanism: MechanismData, readonly bind: readonly THREE.Matrix4[]) {
    const by_index = new Map<number, FieldLink>();
    mechanism.links.forEach((link, index) => {
      const parts = link.shapes.map((s) => part_of(s, bind[index]!)).filter((p) => p !== null);
      if (parts.length === 0) return;
      const centres = parts.map((p) => new THREE.Vector3().setFromMatrixPosition(p.into.clone().invert()));
      const centre = centres.reduce((sum, c) => sum.add(c), new THREE.Vector3()).divideScalar(parts.length);
      const reach = Math.max(...parts.map((p, i) => p.reach + centres[i]!.distanceTo(centre)));
      let ancestor = link.parent;
      while (ancestor >= 0 && !by_index.has(ancestor)) ancestor = mechanism.links[ancestor]!.parent;
      const parent = by_index.get(ancestor) ?? null;
      const radius = Math.max(...parts.map((p) => p.radius));
      const made: FieldLink = { index, parts, parent, centre, reach, radius, blend: blend_of_radius * Math.min(radius, parent?.radius ?? radius) };
      by_index.set(index, made);
      this.links.push(made);
    });
  }

  /** Signed distance of a point from one link, m. */
  link_distance(link: FieldLink, x: number, y: number, z: number): number {
    let out = Infinity;
    for (const part of link.parts) {
      const e = part.into.elements;
      const d = part.distance(e[0]! * x + e[4]! * y + e[8]! * z + e[12]!, e[1]! * x + e[5]! * y + e[9]! * z + e[13]!, e[2]! * x + e[6]! * y + e[10]! * z + e[14]!);
      out = out === Infinity ? d : smooth_min(out, d, 0.5 * part.radius);
    }
    return out;
  }

  /** Value of the pair of a link and its parent, m. */
  pair_distance(link: FieldLink, x: number, y: number, z: number): number {
    const own = this.link_distance(link, x, y, z);
    return link.parent ? smooth_min(own, this.link_distance(link.parent, x, y, z), link.blend) : own;
  }

  /** Signed distance of a point from the body, m; exact near the surface only. */
  distance(x: number, y: number, z: number): number {
    let out = Infinity;
    for (const link of this.links) {
      const far = length(x - link.centre.x, y - link.centre.y, z - link.centre.z) - link.reach - link.blend;
      if (far < Math.min(out, 0.1)) out = Math.min(out, this.pair_distance(link, x, y, z));
    }
    return out;
  }
}
