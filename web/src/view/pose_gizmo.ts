/**
 * The rotation gizmo of a posed joint: for each rotational DOF an arc that ends at the limits of the joint, with the present angle. Drawn over
 * the bodies.
 */
import * as THREE from 'three';
import type { JointFacts } from '../core/protocol';
import { Polyline } from './overlays';

const axis_colors = [0xef6a6a, 0x63c174, 0x6ea8fe]; // x, y, z
const accent = 0xff8a3d;
const free_color = 0x34d399; // the part of the arc above the present angle, of the DOF under the pointer
const limit_color = 0xf87171;
const arc_step = Math.PI / 48;

/** The joint that the gizmo shows. */
export interface GizmoJoint {
  facts: JointFacts;
  /** Displacement of each DOF, rad; empty for floating joints. */
  angles: readonly number[];
  /** World position of the joint, m, and orientation of its link. */
  origin: THREE.Vector3;
  rotation: THREE.Quaternion;
  /** World direction from the joint along its link; any length above 0. */
  bone: THREE.Vector3;
}

interface Ring {
  dof: number;
  /** Unit vectors in the world: axis, direction of the present angle, and the direction 90 degrees farther. */
  axis: THREE.Vector3;
  u: THREE.Vector3;
  v: THREE.Vector3;
  /** Ends of the arc relative to the present angle, rad. */
  from: number;
  to: number;
  limited: boolean;
  below: Polyline;
  above: Polyline;
  ends: Polyline;
}

/** A text at a point of the gizmo. */
export interface GizmoLabel {
  text: string;
  at: THREE.Vector3;
  strong: boolean;
}

const degrees = (radians: number): string => `${((radians * 180) / Math.PI).toFixed(1).replace(/\.0$/, '').replace('-', '−')}°`;

export class PoseGizmo {
  readonly group = new THREE.Group();
  private rings: Ring[] = [];
  private joint: GizmoJoint | null = null;
  private readonly sector: THREE.Mesh<THREE.BufferGeometry, THREE.MeshBasicMaterial>;
  private readonly handle: THREE.Mesh<THREE.SphereGeometry, THREE.MeshBasicMaterial>;
  private radius = 1;
  /** DOF under the pointer or being dragged; null: none. */
  active: number | null = null;

  constructor() {
    this.sector = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshBasicMaterial({ color: accent, transparent: true, opacity: 0.2, side: THREE.DoubleSide, depthTest: false }));
    this.sector.renderOrder = 58;
    this.sector.frustumCulled = false;
    this.handle = new THREE.Mesh(new THREE.SphereGeometry(1, 16, 12), new THREE.MeshBasicMaterial({ color: accent, depthTest: false, transparent: true }));
    this.handle.renderOrder = 62;
    this.group.add(this.sector, this.handle);
    this.group.visible = false;
  }

  /** @param radius of the arcs, m */
  show(joint: GizmoJoint | null, radius: number): void {
    this.joint = joint;
    this.radius = radius;
    const dofs = joint?.facts.dofs.map((dof, i) => ({ dof, i })).filter(({ dof }) => dof.turns) ?? [];
    this.group.visible = dofs.length > 0;
    if (!joint || dofs.length === 0) {
      this.use_rings(0);
      return;
    }
    this.use_rings(dofs.length);
    dofs.forEach(({ dof, i }, k) => {
      const ring = this.rings[k]!;
      const angle = joint.angles[i] ?? 0;
      ring.dof = i;
      ring.axis.set(...dof.axis).applyQuaternion(joint.rotation).normalize();
      ring.u.copy(joint.bone).addScaledVector(ring.axis, -joint.bone.dot(ring.axis));
      if (ring.u.lengthSq() < 0.02 * joint.bone.lengthSq()) {
        ring.u.set(1, 0, 0).applyQuaternion(joint.rotation);
        if (Math.abs(ring.u.dot(ring.axis)) > 0.9) ring.u.set(0, 1, 0).applyQuaternion(joint.rotation);
        ring.u.addScaledVector(ring.axis, -ring.u.dot(ring.axis));
      }
      ring.u.normalize();
      ring.v.crossVectors(ring.axis, ring.u);
      ring.limited = dof.lower !== null && dof.upper !== null && dof.upper - dof.lower < 2 * Math.PI - 0.01;
      ring.from = ring.limited ? Math.min(0, dof.lower! - angle) : -Math.PI;
      ring.to = ring.limited ? Math.max(0, dof.upper! - angle) : Math.PI;
      this.draw_ring(ring, dofs.length === 1);
    });
    this.draw_active(dofs.length === 1);
  }

  private use_rings(count: number): void {
    while (this.rings.length < count) {
      const made = (width: number, color: number): Polyline => {
        const line = new Polyline(color, width, 1, true);
        this.group.add(line.line);
        return line;
      };
      this.rings.push({ dof: 0, axis: new THREE.Vector3(), u: new THREE.Vector3(), v: new THREE.Vector3(), from: 0, to: 0, limited: false, below: made(3, accent), above: made(2.2, free_color), ends: made(1.4, limit_color) });
    }
    this.rings.forEach((ring, i) => {
      if (i < count) return;
      ring.dof = -1;
      for (const line of [ring.below, ring.above, ring.ends]) line.hide();
    });
  }

  private shown_rings(): Ring[] {
    return this.group.visible ? this.rings.filter((r) => r.dof >= 0) : [];
  }

  /** Point of a ring at an angle relative to the present one. */
  private point(ring: Ring, angle: number, share = 1): THREE.Vector3 {
    return this.joint!.origin.clone().addScaledVector(ring.u, Math.cos(angle) * this.radius * share).addScaledVector(ring.v, Math.sin(angle) * this.radius * share);
  }
  private arc(ring: Ring, from: number, to: number): number[] {
    const count = Math.max(1, Math.ceil((to - from) / arc_step));
    return Array.from({ length: count + 1 }, (_, i) => this.point(ring, from + ((to - from) * i) / count).toArray()).flat();
  }

  private draw_ring(ring: Ring, single: boolean): void {
    const active = single || this.active === ring.dof;
    const plain = axis_colors[ring.dof % 3]!;
    ring.below.material.color.set(active ? accent : plain);
    ring.above.material.color.set(active ? (ring.limited ? free_color : accent) : plain);
    const opacity = active || this.active === null ? 1 : 0.35;
    for (const line of [ring.below, ring.above]) line.material.opacity = opacity;
    ring.below.material.linewidth = ring.above.material.linewidth = active ? 3 : 2;
    ring.below.show(ring.from < -1e-4 ? this.arc(ring, ring.from, 0) : []);
    ring.above.show(ring.to > 1e-4 ? this.arc(ring, 0, ring.to) : []);
    if (active && ring.limited) ring.ends.show([this.point(ring, ring.from), this.joint!.origin, this.point(ring, ring.to)].flatMap((p) => p.toArray()));
    else ring.ends.hide();
    ring.ends.material.opacity = 0.7;
  }

  private draw_active(single: boolean): void {
    const ring = this.shown_rings().find((r) => single || r.dof === this.active);
    this.sector.visible = this.handle.visible = ring !== undefined;
    if (!ring) return;
    const from = ring.limited ? ring.from : Math.max(ring.from, -(this.joint!.angles[ring.dof] ?? 0));
    const rim = this.arc(ring, Math.min(from, 0), Math.max(0, Math.min(from, 0)));
    const vertices: number[] = [];
    const origin = this.joint!.origin;
    for (let i = 0; i + 3 < rim.length; i += 3) vertices.push(origin.x, origin.y, origin.z, rim[i]!, rim[i + 1]!, rim[i + 2]!, rim[i + 3]!, rim[i + 4]!, rim[i + 5]!);
    this.sector.geometry.dispose();
    this.sector.geometry = new THREE.BufferGeometry().setAttribute('position', new THREE.Float32BufferAttribute(vertices, 3));
    this.handle.position.copy(this.point(ring, 0));
    this.handle.scale.setScalar(this.radius * 0.055);
  }

  /** The DOF whose arc is within `reach` px of a point of the page, the nearest one; null: none. */
  pick(x: number, y: number, reach: number, to_client: (p: THREE.Vector3) => { x: number; y: number } | null): number | null {
    let best = reach;
    let found: number | null = null;
    for (const ring of this.shown_rings()) {
      const points = this.arc(ring, ring.from, ring.to);
      for (let i = 0; i < points.length; i += 3) {
        const at = to_client(new THREE.Vector3(points[i], points[i + 1], points[i + 2]));
        const distance = at ? Math.hypot(at.x - x, at.y - y) : Infinity;
        if (distance < best) {
          best = distance;
          found = ring.dof;
        }
      }
    }
    return found;
  }

  /** Points of the first arc, for tests; `handle` marks the present angle. */
  first_arc(): { point: THREE.Vector3; handle: boolean }[] {
    const ring = this.shown_rings()[0];
    if (!ring) return [];
    const ends = [ring.from + 0.04, ring.to - 0.04].map((angle) => ({ point: this.point(ring, angle), handle: false }));
    return [ends[0]!, { point: this.point(ring, 0), handle: true }, ends[1]!];
  }

  /** Axis and plane of a DOF in the world, for a drag; null: the DOF is not shown. */
  ring_of(dof: number): { axis: THREE.Vector3; origin: THREE.Vector3; u: THREE.Vector3; v: THREE.Vector3; radius: number } | null {
    const ring = this.shown_rings().find((r) => r.dof === dof);
    return ring && this.joint ? { axis: ring.axis.clone(), origin: this.joint.origin.clone(), u: ring.u.clone(), v: ring.v.clone(), radius: this.radius } : null;
  }

  /** Angle and limits of the DOF under the pointer, as texts beside its arc. */
  labels(): GizmoLabel[] {
    const rings = this.shown_rings();
    const ring = rings.length === 1 ? rings[0] : rings.find((r) => r.dof === this.active);
    const dof = ring && this.joint?.facts.dofs[ring.dof];
    if (!ring || !dof || !this.joint) return [];
    const angle = this.joint.angles[ring.dof];
    const out: GizmoLabel[] = [];
    if (angle !== undefined) out.push({ text: dof.upper !== null && ring.limited ? `${degrees(angle)} of ${degrees(angle < 0 && dof.lower !== null && dof.lower < 0 ? dof.lower : dof.upper)}` : degrees(angle), at: this.point(ring, 0, 1.22), strong: true });
    if (ring.limited && ring.to - ring.from > 0.5) {
      if (ring.from < -0.35) out.push({ text: degrees(dof.lower!), at: this.point(ring, ring.from, 1.2), strong: false });
      if (ring.to > 0.35) out.push({ text: degrees(dof.upper!), at: this.point(ring, ring.to, 1.2), strong: false });
    }
    return out;
  }

  dispose(): void {
    this.sector.geometry.dispose();
    this.handle.geometry.dispose();
  }
}
