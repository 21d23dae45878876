/**
 * Small still and moving pictures of characters for lists. One off-screen renderer draws all pictures, one after the other, and copies each
 * to a 2D canvas.
 */
import * as THREE from 'three';
import type { MechanismData } from '../core/protocol';
import { CharacterView, mechanism_geometries } from './character_view';

/** Sampled poses of all links of a motion. */
export interface Poses {
  count: number;
  links: number;
  /** Time from the first to the last sample, s. */
  duration: number;
  /** World poses [count][links][7]: x y z (m) qw qx qy qz. */
  values: Float32Array;
}

export const picture_size = { width: 192, height: 144 };
const max_characters = 12; // characters kept for reuse; the least recently used one is dropped

/** A character kept for reuse, with its bounds in the neutral position, m. */
interface Kept {
  character_view: CharacterView;
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

  /**
   * Draws a mechanism in its neutral position, or in a pose of a motion, onto `target`.
   * @param share time within the motion, 0 ... 1  @param shape_colors of a mesh  @return false if the mechanism has no shapes
   */
  draw(mechanism: MechanismData, color: string, target: CanvasRenderingContext2D, motion?: Poses, share = 0, shape_colors: readonly string[] = []): boolean {
    const kept = this.character_view_of(mechanism, color);
    if (!kept) return false;
    const { character_view } = kept;
    if (shape_colors.length > 0) character_view.set_look(color, { shape_colors: [...shape_colors] });
    if (motion) {
      const at = Math.min(motion.count - 1, Math.max(0, Math.round(share * (motion.count - 1))));
      character_view.place_poses(motion.values, at * motion.links * 7, motion.links);
    } else {
      character_view.place_neutral();
    }
    character_view.group.updateMatrixWorld(true);
    this.look_at(kept, motion !== undefined);
    this.scene.add(character_view.group);
    this.renderer.render(this.scene, this.camera);
    this.scene.remove(character_view.group);
    const { width, height } = target.canvas;
    target.clearRect(0, 0, width, height);
    target.drawImage(this.renderer.domElement, 0, 0, width, height);
    return true;
  }

  private character_view_of(mechanism: MechanismData, color: string): Kept | null {
    const key = `${mechanism.id} ${color}`;
    const known = this.kept.get(key);
    if (known) {
      this.kept.delete(key); // moves the entry to the end: the map is in the order of use
      this.kept.set(key, known);
      return known;
    }
    if (!mechanism.links.some((l) => l.shapes.length > 0)) return null;
    if (this.kept.size >= max_characters) {
      const [oldest] = this.kept;
      if (oldest) this.forget(oldest[0], oldest[1]);
    }
    const character_view = new CharacterView('', mechanism, mechanism_geometries(mechanism), color);
    for (const mesh of character_view.links) if (mesh) mesh.frustumCulled = false;
    character_view.group.updateMatrixWorld(true);
    const kept = { character_view, box: bounds_of(character_view) };
    this.kept.set(key, kept);
    return kept;
  }

  private forget(key: string, kept: Kept): void {
    for (const mesh of kept.character_view.links) mesh?.geometry.dispose();
    kept.character_view.dispose();
    this.kept.delete(key);
  }

  /** Points the camera at the character. A moving character is shown at one scale in all poses. */
  private look_at(kept: Kept, moving: boolean): void {
    const box = bounds_of(kept.character_view);
    if (box.isEmpty()) return;
    const own = kept.box.getSize(new THREE.Vector3());
    const size = box.getSize(new THREE.Vector3());
    const centre = box.getCenter(new THREE.Vector3());
    const long = own.x > 1.2 * own.z; // true: an animal, for example, which is longer than tall and is shown from the side
    const aspect = picture_size.width / picture_size.height;
    const azimuth = long ? 1.15 : 0.55;
    const object = kept.character_view.links.length === 1; // a prop, which fills its box
    const wide = Math.max(object ? size.x * Math.sin(azimuth) + size.y * Math.cos(azimuth) : long ? size.x : Math.max(0.75 * size.x, 0.75 * size.y), 1e-3);
    let need = 0.5 * Math.max(size.z, wide / aspect) * 1.12;
    if (moving) {
      need = Math.max(need, 0.56 * Math.max(own.z, long ? own.x / aspect : 0));
      if (own.z > size.z) centre.z = Math.max(centre.z, box.min.z + 0.5 * own.z);
    }
    const distance = need / Math.tan((12 * Math.PI) / 180) + 0.3 * Math.max(size.x, size.y);
    this.camera.near = distance * 0.02;
    this.camera.far = distance * 8;
    this.camera.position.set(centre.x + distance * Math.cos(azimuth), centre.y + distance * Math.sin(azimuth), centre.z + 0.14 * distance);
    this.camera.lookAt(centre);
    this.camera.updateProjectionMatrix();
  }
}

const sphere = new THREE.Sphere();

/** Bounding box of a character as posed now, m. */
function bounds_of(character_view: CharacterView): THREE.Box3 {
  const box = new THREE.Box3();
  for (const mesh of character_view.links) {
    if (!mesh) continue;
    if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
    const own = mesh.geometry.boundingBox;
    if (own) box.union(own.clone().applyMatrix4(mesh.matrixWorld));
    else if (mesh.geometry.boundingSphere) box.union(sphere.copy(mesh.geometry.boundingSphere).applyMatrix4(mesh.matrixWorld).getBoundingBox(new THREE.Box3()));
  }
  return box;
}
