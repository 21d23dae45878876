/** The cameras of the document in the free view: a frustum for each, and the path of the selected one. */
import * as THREE from 'three';
import { film_aspect, view_of, type FilmCamera, type FilmView } from '../core/film';

const size = 0.4; // m, depth of a drawn frustum
const path_steps = 64; // lines of the path of a camera with keys

/** Position of a camera, m. @param offset centre of mass of the followed character, m */
function position_of({ target: [x, y, z], azimuth, elevation, distance }: FilmView, offset: { x: number; y: number }): THREE.Vector3 {
  const flat = distance * Math.cos(elevation);
  return new THREE.Vector3(x + offset.x + flat * Math.cos(azimuth), y + offset.y + flat * Math.sin(azimuth), z + distance * Math.sin(elevation));
}

export class CameraOutlines {
  readonly lines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, opacity: 0.9 }));
  private positions: number[] = [];
  private colors: number[] = [];
  private readonly color = new THREE.Color();

  constructor() {
    this.lines.frustumCulled = this.lines.visible = false;
    this.lines.renderOrder = 50;
  }

  begin(): void {
    this.positions = [];
    this.colors = [];
  }

  /** @param time of the frame, s  @param offset centre of mass of the followed character, m */
  add(camera: FilmCamera, time: number, offset: { x: number; y: number }, selected: boolean): void {
    this.color.set(selected ? 0xff8a3d : 0x5aa9cf);
    const view = view_of(camera, time);
    const at = position_of(view, offset);
    const back = position_of({ ...view, target: [0, 0, 0], distance: 1 }, { x: 0, y: 0 });
    const right = new THREE.Vector3(-Math.sin(view.azimuth), Math.cos(view.azimuth), 0);
    const up = back.clone().cross(right);
    const half = size * Math.tan(view.field_of_view / 2);
    const corner = (x: number, y: number): THREE.Vector3 =>
      at.clone().addScaledVector(back, -size).addScaledVector(right, x * half * film_aspect).addScaledVector(up, y * half);
    const corners = [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)];
    corners.forEach((c, i) => {
      this.line(at, c);
      this.line(c, corners[(i + 1) % 4]!);
    });
    this.line(corner(-0.35, 1.15), corner(0, 1.6));
    this.line(corner(0, 1.6), corner(0.35, 1.15));
    const keys = camera.keys ?? [];
    if (!selected || keys.length < 2) return;
    const [first, last] = [keys[0]!.time, keys.at(-1)!.time];
    let before = position_of(keys[0]!, offset);
    for (let i = 1; i <= path_steps; i++) {
      const next = position_of(view_of(camera, first + ((last - first) * i) / path_steps), offset);
      this.line(before, next);
      before = next;
    }
  }

  end(): void {
    this.lines.visible = this.positions.length > 0;
    if (!this.lines.visible) return;
    this.lines.geometry.dispose();
    this.lines.geometry = new THREE.BufferGeometry();
    this.lines.geometry.setAttribute('position', new THREE.Float32BufferAttribute(this.positions, 3));
    this.lines.geometry.setAttribute('color', new THREE.Float32BufferAttribute(this.colors, 3));
  }

  private line(a: THREE.Vector3, b: THREE.Vector3): void {
    for (const p of [a, b]) {
      this.positions.push(p.x, p.y, p.z);
      this.colors.push(this.color.r, this.color.g, this.color.b);
    }
  }
}
