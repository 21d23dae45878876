/**
 * Overlays in the viewport: force arrows, the root-assist arrow, trails, the spring of a pull, contact discs, and the ring under the
 * selected character.
 */
import * as THREE from 'three';
import { Line2 } from 'three/examples/jsm/lines/Line2.js';
import { LineGeometry } from 'three/examples/jsm/lines/LineGeometry.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';

const up = new THREE.Vector3(0, 1, 0);

const good = new THREE.Color(0x34d399);
const warn = new THREE.Color(0xfbbf24);
const bad = new THREE.Color(0xf87171);

/** Colour of the root assist: green up to 30 % of its cap, amber at 70 %, red at 100 %. @param over_cap assist / cap */
export function assist_color(over_cap: number, out = new THREE.Color()): THREE.Color {
  if (over_cap <= 0.3) return out.copy(good);
  if (over_cap <= 0.7) return out.lerpColors(good, warn, (over_cap - 0.3) / 0.4);
  return out.lerpColors(warn, bad, Math.min(1, (over_cap - 0.7) / 0.3));
}

/** An arrow made of a shaft and a head. */
export class Arrow {
  readonly group = new THREE.Group();
  private readonly shaft: THREE.Mesh;
  private readonly head: THREE.Mesh;
  readonly material: THREE.MeshBasicMaterial;

  /** @param thickness radius of the shaft, m  @param on_top draw over everything else */
  constructor(color: THREE.ColorRepresentation, private readonly thickness: number, on_top = false) {
    this.material = new THREE.MeshBasicMaterial({ color, depthTest: !on_top, transparent: on_top, opacity: 0.95 });
    this.shaft = new THREE.Mesh(shaft_geometry, this.material);
    this.head = new THREE.Mesh(head_geometry, this.material);
    this.group.add(this.shaft, this.head);
    if (on_top) this.shaft.renderOrder = this.head.renderOrder = 50;
    this.group.visible = false;
  }

  /** @param from start point, m  @param along vector of the arrow, m; an arrow shorter than 0.1 mm is hidden */
  show(from: THREE.Vector3, along: THREE.Vector3): void {
    const length = along.length();
    if (length < 1e-4) {
      this.group.visible = false;
      return;
    }
    const head = Math.min(this.thickness * 5.5, length * 0.5);
    this.group.position.copy(from);
    this.group.quaternion.setFromUnitVectors(up, along.clone().divideScalar(length));
    this.shaft.scale.set(this.thickness, length - head, this.thickness);
    this.head.scale.set(this.thickness * 2.6, head, this.thickness * 2.6);
    this.head.position.y = length - head;
    this.group.visible = true;
  }

  hide(): void {
    this.group.visible = false;
  }
}

const shaft_geometry = new THREE.CylinderGeometry(1, 1, 1, 12).translate(0, 0.5, 0);
const head_geometry = new THREE.ConeGeometry(1, 1, 16).translate(0, 0.5, 0);

/** A line of constant pixel width through points that change. */
export class Polyline {
  readonly line: Line2;
  private geometry = new LineGeometry();
  readonly material: LineMaterial;

  constructor(color: THREE.ColorRepresentation, width: number, opacity = 1, on_top = false) {
    this.material = new LineMaterial({ color: new THREE.Color(color).getHex(), linewidth: width, transparent: true, opacity, depthTest: !on_top });
    this.line = new Line2(this.geometry, this.material);
    this.line.frustumCulled = false;
    this.line.visible = false;
    if (on_top) this.line.renderOrder = 60;
  }

  /** @param points x y z of each point, m; fewer than two points hide the line */
  show(points: number[]): void {
    if (points.length < 6) {
      this.line.visible = false;
      return;
    }
    // the buffers of a line geometry cannot grow, so a new geometry is made
    this.geometry.dispose();
    this.geometry = new LineGeometry();
    this.geometry.setPositions(points);
    this.line.geometry = this.geometry;
    this.line.visible = true;
  }

  hide(): void {
    this.line.visible = false;
  }
}

/** Many separate lines with a bead at both ends, drawn over the bodies. */
export class Segments {
  readonly lines = new THREE.Group();
  private readonly segments: LineSegments2;
  private readonly beads: THREE.InstancedMesh;
  private positions: number[] = [];
  private readonly matrix = new THREE.Matrix4();

  /** @param width px  @param bead radius of the beads, m  @param max_beads further beads are not drawn */
  constructor(color: number, width: number, private readonly bead = 0.009, max_beads = 128) {
    const material = new LineMaterial({ color, linewidth: width, transparent: true, opacity: 0.95, depthTest: false });
    this.segments = new LineSegments2(new LineSegmentsGeometry(), material);
    this.segments.frustumCulled = false;
    this.segments.renderOrder = 55;
    this.beads = new THREE.InstancedMesh(new THREE.SphereGeometry(1, 10, 8), new THREE.MeshBasicMaterial({ color, depthTest: false, transparent: true }), max_beads);
    this.beads.frustumCulled = false;
    this.beads.renderOrder = 56;
    this.lines.add(this.segments, this.beads);
    this.lines.visible = false;
  }

  begin(): void {
    this.positions = [];
  }

  add(from: THREE.Vector3, to: THREE.Vector3): void {
    this.positions.push(from.x, from.y, from.z, to.x, to.y, to.z);
  }

  end(): void {
    const count = this.positions.length / 6;
    this.lines.visible = count > 0;
    this.beads.count = 0;
    if (count === 0) return;
    // the buffers of a line geometry cannot grow, so a new geometry is made
    this.segments.geometry.dispose();
    this.segments.geometry = new LineSegmentsGeometry().setPositions(this.positions);
    for (let i = 0; i < this.positions.length && this.beads.count < this.beads.instanceMatrix.count; i += 3) {
      this.matrix.makeScale(this.bead, this.bead, this.bead).setPosition(this.positions[i]!, this.positions[i + 1]!, this.positions[i + 2]!);
      this.beads.setMatrixAt(this.beads.count++, this.matrix);
    }
    this.beads.instanceMatrix.needsUpdate = true;
  }
}

/** The spring of a pull, from the grabbed point to the target under the cursor, with a bead at both ends. */
export class Spring {
  readonly group = new THREE.Group();
  private readonly coil = new Polyline(0xff8a3d, 2, 0.95, true);
  private readonly beads: THREE.Mesh[];

  constructor() {
    const material = new THREE.MeshBasicMaterial({ color: 0xff8a3d, depthTest: false, transparent: true });
    const geometry = new THREE.SphereGeometry(1, 16, 12);
    this.beads = [new THREE.Mesh(geometry, material), new THREE.Mesh(geometry, material)];
    for (const bead of this.beads) bead.renderOrder = 61;
    this.group.add(this.coil.line, ...this.beads);
    this.group.visible = false;
  }

  /** @param size radius of a bead, m; the caller scales it with the view */
  show(from: THREE.Vector3, to: THREE.Vector3, camera: THREE.Camera, size: number): void {
    const along = to.clone().sub(from);
    const length = along.length();
    this.beads[0]!.position.copy(from);
    this.beads[0]!.scale.setScalar(size);
    this.beads[1]!.position.copy(to);
    this.beads[1]!.scale.setScalar(size * 1.25);
    const view = camera.getWorldDirection(new THREE.Vector3());
    const side = along.clone().cross(view);
    const points: number[] = [from.x, from.y, from.z];
    if (side.lengthSq() > 1e-12 && length > size * 4) {
      side.normalize();
      const turns = 8;
      const amplitude = Math.min(size * 1.3, length * 0.05);
      for (let i = 0; i <= turns * 2; i++) {
        const t = 0.12 + (0.76 * i) / (turns * 2);
        const a = i === 0 || i === turns * 2 ? 0 : i % 2 === 0 ? amplitude : -amplitude;
        points.push(from.x + along.x * t + side.x * a, from.y + along.y * t + side.y * a, from.z + along.z * t + side.z * a);
      }
    }
    points.push(to.x, to.y, to.z);
    this.coil.show(points);
    this.group.visible = true;
  }

  hide(): void {
    this.group.visible = false;
  }
}

/** Small discs at contact points, perpendicular to the contact normal. */
export class ContactDiscs {
  readonly mesh: THREE.InstancedMesh;
  private readonly dummy = new THREE.Object3D();

  constructor(private readonly max_count: number) {
    const geometry = new THREE.CircleGeometry(1, 28);
    const material = new THREE.MeshBasicMaterial({ color: 0xfdba74, side: THREE.DoubleSide, transparent: true, opacity: 0.9, depthWrite: false });
    this.mesh = new THREE.InstancedMesh(geometry, material, max_count);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 40;
    this.mesh.count = 0;
  }

  begin(): void {
    this.mesh.count = 0;
  }

  /** @param at contact point, m  @param along normal direction, any length  @param radius m */
  add(at: THREE.Vector3, along: THREE.Vector3, radius: number): void {
    if (this.mesh.count >= this.max_count) return;
    const n = along.clone().normalize();
    this.dummy.position.copy(at).addScaledVector(n, 0.002);
    this.dummy.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), n);
    this.dummy.scale.setScalar(radius);
    this.dummy.updateMatrix();
    this.mesh.setMatrixAt(this.mesh.count++, this.dummy.matrix);
    this.mesh.instanceMatrix.needsUpdate = true;
  }
}

/** A thin ring on the floor under the selected character. */
export function make_ring(): THREE.Mesh {
  const ring = new THREE.Mesh(
    new THREE.RingGeometry(0.965, 1, 96),
    new THREE.MeshBasicMaterial({ color: 0xff8a3d, transparent: true, opacity: 0.7, depthWrite: false }),
  );
  ring.renderOrder = 1;
  ring.visible = false;
  return ring;
}
