/**
 * Small pictures of figures, still and moving, for lists: one renderer off the screen draws them all, one after the other, and copies
 * each onto the plain canvas that asked for it.
 */
import * as THREE from 'three';
import type { MechanismData } from '../core/protocol';
import { Figure, mechanism_geometries } from './figure';

/** Poses of all links of a motion: [count][links][7], x y z qw qx qy qz. */
export interface Poses {
  count: number;
  links: number;
  /** s from the first to the last */
  duration: number;
  values: Float32Array;
}

export const picture_size = { width: 192, height: 144 };
const most_figures = 12;

interface Kept {
  figure: Figure;
  box: THREE.Box3;
}

export class PreviewRenderer {
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(24, picture_size.width / picture_size.height, 0.01, 400);
  private readonly kept = new Map<string, Kept>();

  constructor() {
    this.renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setSize(picture_size.width, picture_size.height, false);
    this.renderer.setClearColor(0x000000, 0);
    const key = new THREE.DirectionalLight(0xfff3e4, 2.7);
    key.position.set(3, 2.5, 5);
    this.scene.add(key, new THREE.HemisphereLight(0xdfe8f7, 0x3a3836, 1.6));
    this.camera.up.set(0, 0, 1);
  }

  /** Draws a mechanism in its neutral position, or in a pose of a motion, onto `target`. False: it has nothing to see. */
  draw(mechanism: MechanismData, color: string, target: CanvasRenderingContext2D, motion?: Poses, share = 0): boolean {
    const kept = this.figure_of(mechanism, color);
    if (!kept) return false;
    const { figure } = kept;
    if (motion) {
      const at = Math.min(motion.count - 1, Math.max(0, Math.round(share * (motion.count - 1))));
      figure.place_poses(motion.values, at * motion.links * 7, motion.links);
    } else {
      figure.place_neutral();
    }
    figure.group.updateMatrixWorld(true);
    this.look_at(kept, motion !== undefined);
    this.scene.add(figure.group);
    this.renderer.render(this.scene, this.camera);
    this.scene.remove(figure.group);
    const { width, height } = target.canvas;
    target.clearRect(0, 0, width, height);
    target.drawImage(this.renderer.domElement, 0, 0, width, height);
    return true;
  }

  private figure_of(mechanism: MechanismData, color: string): Kept | null {
    const key = `${mechanism.id} ${color}`;
    const known = this.kept.get(key);
    if (known) {
      this.kept.delete(key); // the newest come last
      this.kept.set(key, known);
      return known;
    }
    if (!mechanism.links.some((l) => l.shapes.length > 0)) return null;
    if (this.kept.size >= most_figures) {
      const [oldest] = this.kept;
      if (oldest) this.forget(oldest[0], oldest[1]);
    }
    const figure = new Figure('', mechanism, mechanism_geometries(mechanism), color);
    for (const mesh of figure.links) if (mesh) mesh.frustumCulled = false;
    figure.group.updateMatrixWorld(true);
    const kept = { figure, box: bounds_of(figure) };
    this.kept.set(key, kept);
    return kept;
  }

  private forget(key: string, kept: Kept): void {
    for (const mesh of kept.figure.links) mesh?.geometry.dispose();
    kept.figure.dispose();
    this.kept.delete(key);
  }

  /** One size for all poses of a figure, so that it does not swell and shrink while it moves. */
  private look_at(kept: Kept, moving: boolean): void {
    const box = bounds_of(kept.figure);
    if (box.isEmpty()) return;
    const own = kept.box.getSize(new THREE.Vector3());
    const size = box.getSize(new THREE.Vector3());
    const centre = box.getCenter(new THREE.Vector3());
    const long = own.x > 1.2 * own.z; // what is longer than tall is seen from its side
    const aspect = picture_size.width / picture_size.height;
    const wide = Math.max(long ? size.x : Math.max(0.75 * size.x, 0.75 * size.y), 1e-3);
    let need = 0.5 * Math.max(size.z, wide / aspect) * 1.12;
    if (moving) {
      need = Math.max(need, 0.56 * Math.max(own.z, long ? own.x / aspect : 0));
      if (own.z > size.z) centre.z = Math.max(centre.z, box.min.z + 0.5 * own.z);
    }
    const azimuth = long ? 1.15 : 0.55;
    const distance = need / Math.tan((12 * Math.PI) / 180) + 0.3 * Math.max(size.x, size.y);
    this.camera.near = distance * 0.02;
    this.camera.far = distance * 8;
    this.camera.position.set(centre.x + distance * Math.cos(azimuth), centre.y + distance * Math.sin(azimuth), centre.z + 0.14 * distance);
    this.camera.lookAt(centre);
    this.camera.updateProjectionMatrix();
  }
}

const sphere = new THREE.Sphere();

function bounds_of(figure: Figure): THREE.Box3 {
  const box = new THREE.Box3();
  for (const mesh of figure.links) {
    if (!mesh) continue;
    if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
    const own = mesh.geometry.boundingBox;
    if (own) box.union(own.clone().applyMatrix4(mesh.matrixWorld));
    else if (mesh.geometry.boundingSphere) box.union(sphere.copy(mesh.geometry.boundingSphere).applyMatrix4(mesh.matrixWorld).getBoundingBox(new THREE.Box3()));
  }
  return box;
}
