/** The camera rig: smoothed orbit, pan, zoom and follow around a target; perspective or orthographic. Z is up. */
import * as THREE from 'three';
import { film_aspect, type FilmView } from '../core/film';

const free_field = (36 * Math.PI) / 180; // vertical angle of view without a camera of the document, rad
const smooth_time = 0.09; // time constant of the camera's motion, s
const border = 0.09; // margin on each side of framed objects, as a fraction of the view's width and height
const min_height = 0.05; // minimum height of the camera above the floor while the view is turned, m
const follow_time = 0.28; // time constant with which the camera follows a character, s

/** Position of the camera in spherical coordinates around a target. */
export interface Eye {
  /** Position in the world, m. */
  target: THREE.Vector3;
  /** Angle about the z axis, rad. */
  azimuth: number;
  /** Angle above the horizontal, rad. */
  elevation: number;
  /** Distance from the target, m. */
  distance: number;
}

const copy_eye = (eye: Eye): Eye => ({ ...eye, target: eye.target.clone() });

export class CameraRig {
  readonly perspective = new THREE.PerspectiveCamera(36, 1, 0.02, 600);
  readonly orthographic = new THREE.OrthographicCamera(-1, 1, 1, -1, -200, 600);
  use_perspective = true;
  /** Height of the view divided by the height of the camera's picture, at least; above 1, a border around the picture is visible. */
  film_border = 1;
  /** Called when the user moves the view away from the camera of the document through which it looks. */
  on_leave: () => void = () => undefined;
  private eye: Eye = { target: new THREE.Vector3(0, 0, 0.9), azimuth: 0.7, elevation: 0.22, distance: 5 };
  private goal: Eye = copy_eye(this.eye);
  private aspect = 1;
  /** Vertical angle of view in a picture of 16:9, rad. */
  private field = free_field;
  /** True: the view is that of a camera of the document. */
  private filmed = false;
  /** The view to which the user returns from the camera of the document. */
  private before_film: Eye | null = null;
  /** Smoothed position of the followed point; null: no point is followed. */
  private followed: THREE.Vector3 | null = null;
  /** Id of the object to which the followed point belongs; null: none. */
  private followed_object: unknown = null;
  private readonly follow_goal = new THREE.Vector3();

  constructor() {
    this.perspective.up.set(0, 0, 1);
    this.orthographic.up.set(0, 0, 1);
    this.apply();
  }

  get camera(): THREE.PerspectiveCamera | THREE.OrthographicCamera {
    return this.use_perspective || this.filmed ? this.perspective : this.orthographic;
  }

  get current(): Readonly<Eye> {
    return this.eye;
  }

  /** Vertical angle of view in a picture of 16:9, rad. */
  get field_of_view(): number {
    return this.field;
  }

  /** Half of the vertical angle of view as drawn, as a tangent. A view through a camera shows at least the camera's whole picture. */
  private get half_height(): number {
    const half = Math.tan(this.field / 2);
    return this.filmed ? half * Math.max(1, film_aspect / this.aspect) * this.film_border : half;
  }

  /** Size of the camera's picture within the view, as fractions of the view's width and height; null: no camera of the document. */
  get film_frame(): { width: number; height: number } | null {
    if (!this.filmed) return null;
    const height = Math.tan(this.field / 2) / this.half_height;
    return { width: (height * film_aspect) / this.aspect, height };
  }

  /**
   * Looks through a camera of the document, without smoothing; null: back to the view of the user.
   * @param offset centre of mass of the followed character, m; only x and y are used
   */
  look_through(view: FilmView | null, offset: { x: number; y: number } | null = null): void {
    if (!view) {
      if (!this.filmed) return;
      this.filmed = false;
      this.field = free_field;
      if (this.before_film) this.eye = copy_eye((this.goal = this.before_film));
      this.before_film = null;
      return this.apply();
    }
    if (!this.filmed) this.before_film = copy_eye(this.goal);
    this.filmed = true;
    this.followed = null;
    this.field = view.field_of_view;
    const [x, y, z] = view.target;
    this.goal = { target: new THREE.Vector3(x + (offset?.x ?? 0), y + (offset?.y ?? 0), z), azimuth: view.azimuth, elevation: view.elevation, distance: view.distance };
    this.eye = copy_eye(this.goal);
    this.apply();
  }

  /** The user moves the view: it leaves the camera of the document, and continues from there with the camera's angle of view. */
  private leave_film(): void {
    if (!this.filmed) return;
    this.filmed = false;
    this.before_film = null;
    this.apply();
    this.on_leave();
  }

  resize(aspect: number): void {
    this.aspect = aspect;
    this.apply();
  }

  /** Turns the view as a drag does. @param dx, dy movement of the pointer, px */
  orbit(dx: number, dy: number): void {
    this.turn(-dx * 0.0075, dy * 0.0065);
  }

  /** Turns the view. The camera stays above the floor, unless it is already below the floor. @param azimuth, elevation change, rad */
  turn(azimuth: number, elevation: number): void {
    this.leave_film();
    const { goal } = this;
    goal.azimuth += azimuth;
    const lowest = Math.asin(clamp((min_height - goal.target.z) / goal.distance, -0.99, 0.99));
    goal.elevation = clamp(goal.elevation + elevation, goal.elevation >= lowest - 1e-9 ? Math.max(-1.45, lowest) : -1.45, 1.55);
  }

  /**
   * Moves the target so that the point under the cursor stays under it.
   * @param dx, dy movement of the pointer, px
   * @param height height of the view, px
   */
  pan(dx: number, dy: number, height: number): void {
    this.leave_film();
    const per_px = (2 * this.goal.distance * this.half_height) / Math.max(height, 1);
    const m = this.camera.matrixWorld.elements;
    const right = new THREE.Vector3(m[0], m[1], m[2]);
    const up = new THREE.Vector3(m[4], m[5], m[6]);
    this.goal.target.addScaledVector(right, -dx * per_px).addScaledVector(up, dy * per_px);
    this.goal.target.z = clamp(this.goal.target.z, -2, 50);
  }

  zoom(factor: number): void {
    this.leave_film();
    this.goal.distance = clamp(this.goal.distance * factor, 0.02, 2000);
  }

  /** Turns the camera to a direction by the smaller of the two possible angles. @param azimuth, elevation rad */
  look_from(azimuth: number, elevation: number): void {
    this.leave_film();
    const turn = Math.round((this.goal.azimuth - azimuth) / (2 * Math.PI)) * 2 * Math.PI;
    this.goal.azimuth = azimuth + turn;
    this.goal.elevation = elevation;
  }

  /** Keeps the viewing direction and moves as close as possible so that all spheres are in the view with a border. */
  frame(spheres: readonly THREE.Sphere[]): void {
    if (spheres.length === 0) return;
    this.leave_film();
    const { azimuth, elevation } = this.goal;
    const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
    const towards = new THREE.Vector3(ce * ca, ce * sa, se);
    const sideways = [new THREE.Vector3(-sa, ca, 0), new THREE.Vector3(-se * ca, -se * sa, ce)];
    const upright = this.half_height;
    const tangents = [upright * this.aspect, upright]; // tangents of half the horizontal and half the vertical angle of view
    const target = new THREE.Vector3();
    let distance = 0;
    // each of the two planes that bound the view along an axis touches the outermost sphere on its side
    sideways.forEach((axis, i) => {
      const slope = tangents[i]! * (1 - 2 * border);
      const slant = Math.hypot(1, slope);
      let right = -Infinity;
      let left = -Infinity;
      for (const { center, radius } of spheres) {
        const along = center.dot(axis);
        const near = center.dot(towards) * slope + radius * slant;
        right = Math.max(right, near + along);
        left = Math.max(left, near - along);
      }
      distance = Math.max(distance, (right + left) / (2 * slope));
      target.addScaledVector(axis, (right - left) / 2);
    });
    // so far `distance` is measured from the plane through the origin; move the target to the mean depth of the spheres
    const middle = spheres.reduce((sum, s) => sum + s.center.dot(towards), 0) / spheres.length;
    this.goal.target.copy(target.addScaledVector(towards, middle));
    this.goal.distance = clamp(distance - middle, 0.04, 2000);
  }

  /** Sets some values of the camera's goal position. @param at_once true: jump there without smoothing */
  set(eye: Partial<Eye>, at_once: boolean): void {
    this.leave_film();
    Object.assign(this.goal, eye);
    this.goal.target = this.goal.target.clone();
    if (at_once) {
      this.eye = copy_eye(this.goal);
      this.apply();
    }
  }

  /**
   * Moves the view along with `point` (m); null stops following. The offset of the view from the point is kept.
   * @param object id of the object to which the point belongs; if it changes, the view does not jump to the new point, but follows it from then on
   */
  follow(point: THREE.Vector3 | null, object: unknown = null): void {
    if (!point || this.filmed) {
      this.followed = null;
      return;
    }
    this.follow_goal.copy(point);
    if (!this.followed || this.followed_object !== object) this.followed = point.clone();
    this.followed_object = object;
  }

  /** Distance of the drawn view from the wanted one: of target and distance in parts of the wanted distance, of angles in rad; 0: the camera rests. */
  private get error(): number {
    const { eye, goal } = this;
    return (
      eye.target.distanceTo(goal.target) / goal.distance +
      Math.abs(eye.azimuth - goal.azimuth) +
      Math.abs(eye.elevation - goal.elevation) +
      Math.abs(eye.distance - goal.distance) / goal.distance
    );
  }

  /** Whether the camera still moves to its place, or after the followed point. */
  get moving(): boolean {
    return this.error > 0 || (this.followed !== null && this.followed.distanceTo(this.follow_goal) > 0.01);
  }

  /** Advances the smoothed motion by `dt` s. @return whether the camera moved */
  update(dt: number): boolean {
    let moving = false;
    if (this.followed) {
      const k = 1 - Math.exp(-dt / follow_time);
      const step = this.follow_goal.clone().sub(this.followed).multiplyScalar(k);
      step.z *= 0.35;
      if (step.lengthSq() > 1e-7) {
        this.followed.add(step);
        this.goal.target.add(step);
        this.eye.target.add(step);
        moving = true;
      }
    }
    const k = 1 - Math.exp(-dt / smooth_time);
    const { eye, goal, error } = this;
    if (error > 0 && error <= 5e-4) {
      this.eye = copy_eye(goal);
      moving = true;
    } else if (error > 0) {
      eye.target.lerp(goal.target, k);
      eye.azimuth += (goal.azimuth - eye.azimuth) * k;
      eye.elevation += (goal.elevation - eye.elevation) * k;
      eye.distance += (goal.distance - eye.distance) * k;
      moving = true;
    }
    if (moving) this.apply();
    return moving;
  }

  /** Sets both cameras from `eye`. */
  apply(): void {
    const { target, azimuth, elevation, distance } = this.eye;
    const direction = new THREE.Vector3(
      Math.cos(elevation) * Math.cos(azimuth),
      Math.cos(elevation) * Math.sin(azimuth),
      Math.sin(elevation),
    );
    const position = target.clone().addScaledVector(direction, distance);
    if (elevation > 0 && position.z < 0.03) position.z = 0.03;
    for (const camera of [this.perspective, this.orthographic]) {
      camera.position.copy(position);
      // looking vertically down, z is no valid up direction: use the direction opposite to the azimuth
      if (Math.cos(elevation) < 0.03) camera.up.set(-Math.cos(azimuth), -Math.sin(azimuth), 0);
      else camera.up.set(0, 0, 1);
      camera.lookAt(target);
    }
    this.perspective.aspect = this.aspect;
    this.perspective.fov = (360 / Math.PI) * Math.atan(this.half_height);
    this.perspective.near = Math.max(0.002, distance * 0.01);
    this.perspective.far = Math.max(600, distance * 6);
    this.perspective.updateProjectionMatrix();
    const half = distance * this.half_height;
    Object.assign(this.orthographic, { left: -half * this.aspect, right: half * this.aspect, top: half, bottom: -half });
    this.orthographic.updateProjectionMatrix();
    this.perspective.updateMatrixWorld();
    this.orthographic.updateMatrixWorld();
  }
}

const clamp = (value: number, low: number, high: number): number => Math.min(high, Math.max(low, value));
