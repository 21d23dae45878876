/** Preview of an import: the character moves on a metre grid beside a reference human of 1.8 m, so that a wrong unit or axis is visible. */
import * as THREE from 'three';
import type { MechanismData } from '../core/protocol';
import { CameraRig } from './camera';
import { CharacterView, mechanism_geometries } from './character_view';
import type { Poses } from './preview';
import { Stage } from './stage';

/** Marker positions of an imported motion, for all frames of the preview. */
export interface Markers {
  count: number;
  markers: number;
  /** Positions [count][markers][3], m; NaN where a marker was not visible. */
  values: Float32Array;
  /** Pose of the markers' coordinate frame in the character's world: x y z (m) qw qx qy qz. Absent: identity. */
  pose?: number[];
}

export interface Shown {
  mechanism: MechanismData;
  motion?: Poses;
  markers?: Markers;
  /** Colour of each link; null: the usual one. */
  colors?: readonly (string | null)[];
}

const marker_max = 400; // maximum number of markers that are drawn

export class ImportView {
  readonly rig = new CameraRig();
  private readonly stage: Stage;
  private character_view: CharacterView | null = null;
  private shown: Shown | null = null;
  private readonly reference: CharacterView;
  private readonly spots: THREE.InstancedMesh;
  private readonly marks = new THREE.Group();
  private handle = 0;
  private last = 0;
  /** Time within the motion that is shown, s. */
  time = 0;
  playing = true;
  /** Number of frames drawn; read by browser tests. */
  pictures = 0;
  on_time: (time: number) => void = () => undefined;
  /** Called when the user clicks a link of the character (without dragging). */
  on_link: (link: number) => void = () => undefined;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    reference: MechanismData,
    theme: 'dark' | 'light',
  ) {
    this.stage = new Stage(canvas);
    this.stage.set_look({}, theme);
    this.reference = new CharacterView('', reference, mechanism_geometries(reference), '#7f8894');
    this.stage.scene.add(this.reference.group);
    const spot = new THREE.MeshBasicMaterial({ color: 0x7dd3fc });
    this.spots = new THREE.InstancedMesh(new THREE.SphereGeometry(1, 10, 8), spot, marker_max);
    this.spots.frustumCulled = false;
    this.spots.count = 0;
    this.stage.scene.add(this.spots, this.marks);
    canvas.addEventListener('pointerdown', this.down);
    canvas.addEventListener('wheel', this.wheel, { passive: false });
    this.handle = requestAnimationFrame(this.tick);
  }

  dispose(): void {
    cancelAnimationFrame(this.handle);
    this.canvas.removeEventListener('pointerdown', this.down);
    this.canvas.removeEventListener('wheel', this.wheel);
    for (const mesh of this.reference.links) mesh?.geometry.dispose();
    this.reference.dispose();
    this.clear();
    this.stage.dispose();
  }

  resize(width: number, height: number): void {
    this.stage.resize(width, height);
    this.rig.resize(width / Math.max(1, height));
  }

  /**
   * Shows another import.
   * @param frame true: move the camera so that everything is in the view; false after a correction of the same import
   */
  show(shown: Shown | null, frame: boolean): void {
    this.clear();
    this.shown = shown;
    if (!shown) return;
    this.character_view = new CharacterView('', shown.mechanism, mechanism_geometries(shown.mechanism), '#e2b08a', null);
    if (shown.mechanism.skin) this.character_view.set_look('#e2b08a', { shown: 'both' }); // the anatomy stays visible
    for (const mesh of this.character_view.links) if (mesh) mesh.frustumCulled = false;
    if (shown.colors) this.character_view.color_links(shown.colors);
    this.stage.scene.add(this.character_view.group);
    if (this.time > this.duration) this.time = 0;
    this.place();
    this.put_reference();
    if (frame) this.frame();
  }

  /** Colours the links of the character. */
  color(colors: readonly (string | null)[]): void {
    this.character_view?.color_links(colors);
    if (this.shown) this.shown.colors = colors;
  }

  /** Colours the shapes of a mesh. @param colors [shapes] '#rrggbb'; '': the usual colour */
  color_shapes(colors: readonly string[]): void {
    this.character_view?.set_look('#b9bdc6', { shape_colors: [...colors] });
  }

  /** Colour of each link as shown. */
  get colors(): readonly (string | null)[] {
    return this.shown?.colors ?? [];
  }

  /** Index of the link at a point of the canvas (CSS pixels from its upper left corner); -1: none. */
  link_at(x: number, y: number): number {
    if (!this.character_view) return -1;
    const point = new THREE.Vector2((2 * x) / this.canvas.clientWidth - 1, 1 - (2 * y) / this.canvas.clientHeight);
    const ray = new THREE.Raycaster();
    this.character_view.group.updateMatrixWorld(true);
    ray.setFromCamera(point, this.rig.camera);
    const hit = ray.intersectObjects(this.character_view.links.filter((m) => m !== null), false)[0];
    return hit ? (hit.object.userData as { link: number }).link : -1;
  }

  get duration(): number {
    return this.shown?.motion?.duration ?? 0;
  }

  /** Moves the camera so that the character and the reference human are in the view. */
  frame(): void {
    const shown = [this.reference, ...(this.character_view ? [this.character_view] : [])];
    this.rig.look_from(0.75, 0.18);
    this.rig.frame(shown.map((view) => this.box_of(view).getBoundingSphere(new THREE.Sphere())));
    this.rig.set({}, true);
  }

  /** Heights of the imported character and of the reference human as drawn now, m. */
  get heights(): { character: number; reference: number } {
    const of = (view: CharacterView | null): number => (view ? this.box_of(view).getSize(new THREE.Vector3()).z : 0);
    return { character: of(this.character_view), reference: of(this.reference) };
  }

  private clear(): void {
    if (this.character_view) {
      this.stage.scene.remove(this.character_view.group);
      for (const mesh of this.character_view.links) mesh?.geometry.dispose();
      this.character_view.dispose();
    }
    this.character_view = null;
    this.spots.count = 0;
  }

  private box_of(view: CharacterView): THREE.Box3 {
    view.group.updateMatrixWorld(true);
    const box = new THREE.Box3();
    for (const mesh of view.links) {
      if (!mesh) continue;
      if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
      box.union(mesh.geometry.boundingBox!.clone().applyMatrix4(mesh.matrixWorld));
    }
    return box;
  }

  /** Places the reference human 0.35 m to the right of the character. */
  private put_reference(): void {
    if (!this.character_view) return;
    const box = this.box_of(this.character_view);
    const own = this.box_of(this.reference).getSize(new THREE.Vector3());
    const centre = box.getCenter(new THREE.Vector3());
    this.reference.group.position.set(Math.max(-50, Math.min(50, centre.x)), box.min.y - 0.5 * own.y - 0.35, 0);
  }

  /** Poses the character and the markers for the current time. */
  private place(): void {
    const { shown, character_view } = this;
    if (!shown || !character_view) return;
    const motion = shown.motion;
    let at = 0;
    if (motion && motion.count > 0) {
      at = motion.duration > 0 ? Math.min(motion.count - 1, Math.floor((this.time / motion.duration) * (motion.count - 1) + 0.5)) : 0;
      character_view.place_poses(motion.values, at * motion.links * 7, motion.links);
    } else {
      character_view.place_neutral();
    }
    this.place_markers(shown.markers, at);
  }

  private place_markers(markers: Markers | undefined, at: number): void {
    if (!markers) return;
    const world = new THREE.Matrix4();
    const [x = 0, y = 0, z = 0, qw = 1, qx = 0, qy = 0, qz = 0] = markers.pose ?? [];
    world.compose(new THREE.Vector3(x, y, z), new THREE.Quaternion(qx, qy, qz, qw), new THREE.Vector3(1, 1, 1));
    const size = Math.max(0.003, 0.011 * Math.min(1.5, this.heights.character / 1.7));
    const matrix = new THREE.Matrix4();
    const p = new THREE.Vector3();
    const frame = Math.min(at, markers.count - 1);
    let n = 0;
    for (let i = 0; i < markers.markers && n < marker_max; i++) {
      const k = 3 * (frame * markers.markers + i);
      p.set(markers.values[k]!, markers.values[k + 1]!, markers.values[k + 2]!);
      if (!Number.isFinite(p.x)) continue;
      p.applyMatrix4(world);
      this.spots.setMatrixAt(n++, matrix.makeScale(size, size, size).setPosition(p));
    }
    this.spots.count = n;
    this.spots.instanceMatrix.needsUpdate = true;
  }

  private readonly tick = (now: number): void => {
    this.handle = requestAnimationFrame(this.tick);
    if (!this.stage.free) return;
    const dt = Math.min(0.25, Math.max(0, (now - this.last) / 1000));
    this.last = now;
    const moves = this.playing && this.duration > 0;
    if (moves) {
      this.time = (this.time + dt) % this.duration;
      this.on_time(this.time);
    }
    this.place();
    const turned = this.rig.update(Math.max(0.001, dt));
    const { target, distance } = this.rig.current;
    this.stage.focus(target, Math.max(2.6, distance * 0.7), distance);
    this.stage.render(this.rig.camera, !moves && !turned);
    this.pictures++;
  };

  private readonly down = (event: PointerEvent): void => {
    let last = { x: event.clientX, y: event.clientY };
    const first = last;
    this.canvas.setPointerCapture(event.pointerId);
    const move = (e: PointerEvent): void => {
      if (event.button === 1 || event.shiftKey) this.rig.pan(e.clientX - last.x, e.clientY - last.y, this.canvas.clientHeight);
      else this.rig.orbit(e.clientX - last.x, e.clientY - last.y);
      last = { x: e.clientX, y: e.clientY };
    };
    const up = (e: PointerEvent): void => {
      const still = Math.hypot(e.clientX - first.x, e.clientY - first.y) < 4; // CSS pixels; a longer way is a drag of the camera
      if (still && e.type === 'pointerup') {
        const box = this.canvas.getBoundingClientRect();
        this.on_link(this.link_at(e.clientX - box.left, e.clientY - box.top));
      }
      this.canvas.removeEventListener('pointermove', move);
      this.canvas.removeEventListener('pointerup', up);
      this.canvas.removeEventListener('pointercancel', up);
    };
    this.canvas.addEventListener('pointermove', move);
    this.canvas.addEventListener('pointerup', up);
    this.canvas.addEventListener('pointercancel', up);
  };

  private readonly wheel = (event: WheelEvent): void => {
    event.preventDefault();
    this.rig.zoom(Math.exp(Math.max(-120, Math.min(120, event.deltaY)) * 0.0016));
  };
}
