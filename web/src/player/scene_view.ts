/** Draws the frames of an engine: characters, floor, root assist, contacts, and the user's pull or push. Contains no buttons. */
import * as THREE from 'three';
import { shot_at, view_of } from '../core/film';
import { assist_force, assist_over_cap, body_weight, centre_of_mass, type Frame } from '../core/frames';
import type { MechanismData } from '../core/protocol';
import { CameraRig } from '../view/camera';
import { is_body, is_whole_body } from '../view/body_field';
import { BodySkin, body_surface, GradualSurfaces, hidden_layer, sample_surface } from '../view/body_view';
import { CharacterView, mechanism_geometries, type LinkTag } from '../view/character_view';
import { on_texture } from '../view/skin_view';
import { Arrow, assist_color, ContactDiscs, Spring } from '../view/overlays';
import { shadow_reach, Stage, type StageOptions } from '../view/stage';
import type { Scene } from './engine';

const max_contacts = 48; // further contacts are not drawn

/** The link under a pointer: indices into the scene, and the point in the world, m. */
export interface Hit {
  character: number;
  link: number;
  point: THREE.Vector3;
}

export interface SceneOptions extends StageOptions {
  theme: 'dark' | 'light';
}

export class SceneView {
  readonly stage: Stage;
  readonly rig = new CameraRig();
  readonly characters: CharacterView[];
  /** True: contact forces are drawn. */
  contacts = false;
  /** True: the root-assist arrow is drawn. */
  assist = true;
  /** Index of the character that the camera follows; -1: none. */
  followed = -1;
  /** True: the view is that of the shots; false after the user has moved it. */
  directed = true;
  private readonly surfaces = new GradualSurfaces();
  /** True: skins or their textures have come since the last call of refine(). */
  private new_pictures = false;
  private readonly end_textures = on_texture(() => (this.new_pictures = true));
  /** Bodies whose shaders are compiled before the first picture; empty afterwards. */
  private samples: BodySkin[] = [];
  private readonly assist_arrows: Arrow[];
  private readonly contact_arrows: Arrow[] = [];
  private readonly discs = new ContactDiscs(max_contacts);
  private readonly spring = new Spring();
  private readonly push_arrow = new Arrow(0xff8a3d, 0.013, true);
  private readonly raycaster = new THREE.Raycaster();
  private shown: Frame | null = null;
  private size = { width: 1, height: 1 };
  /** The user's pull: a point of a link and its target in the world, m. */
  pull: { hit: Hit; local: THREE.Vector3; target: THREE.Vector3 } | null = null;
  /** The push being aimed: from a point of a link, along a vector, m. */
  aim: { hit: Hit; local: THREE.Vector3; along: THREE.Vector3 } | null = null;

  constructor(readonly canvas: HTMLCanvasElement, readonly scene: Scene, options: SceneOptions) {
    this.stage = new Stage(canvas, options);
    this.raycaster.layers.enable(hidden_layer);
    if (!options.pictures) this.samples = this.begin_compiling(options.theme);
    const geometries = scene.mechanisms.map(mechanism_geometries);
    const surface_of = options.pictures ? body_surface : (mechanism: MechanismData) => this.surfaces.of(mechanism);
    this.characters = scene.characters.map((c, index) => {
      const view = new CharacterView(String(index), scene.mechanisms[c.mechanism]!, geometries[c.mechanism]!, c.color || '#e6e6ea', surface_of);
      this.stage.scene.add(view.group);
      return view;
    });
    this.assist_arrows = scene.characters.map(() => {
      const arrow = new Arrow(0x34d399, 0.011, true);
      this.stage.scene.add(arrow.group);
      return arrow;
    });
    for (let i = 0; i < max_contacts; i++) {
      const arrow = new Arrow(0xfdba74, 0.009);
      this.contact_arrows.push(arrow);
      this.stage.scene.add(arrow.group);
    }
    this.stage.scene.add(this.discs.mesh, this.spring.group, this.push_arrow.group);
    this.rig.on_leave = () => (this.directed = false);
    this.set_theme(options.theme);
    this.followed = scene.characters.findIndex((c) => c.id === scene.camera.follow);
  }

  /** Lets the graphics processor compile the shaders while the surfaces of the bodies are made. @return bodies that keep these shaders */
  private begin_compiling(theme: 'dark' | 'light'): BodySkin[] {
    const { scene, stage } = this;
    stage.set_look(scene.look, theme);
    const bodies = scene.characters.filter((c) => !c.metalness && is_body(scene.mechanisms[c.mechanism]!));
    const kinds = new Map(bodies.map((c) => {
      const kind = { tinted: Object.keys(c.link_colors ?? {}).length > 0, whole: is_whole_body(scene.mechanisms[c.mechanism]!) };
      return [JSON.stringify(kind), kind];
    }));
    const samples = [...kinds.values()].map(({ tinted, whole }) => {
      const skin = new BodySkin(sample_surface(), '#e6e6ea', whole);
      skin.set_tints(tinted ? ['#e6e6ea'] : null);
      return skin;
    });
    stage.begin_compiling(new THREE.Group().add(...samples.map((skin) => skin.mesh)));
    return samples;
  }

  /** Draws the skins that `scene` has, the same scene with them. */
  add_skins(scene: Scene): void {
    this.characters.forEach((view, i) => view.add_skin(scene.mechanisms[scene.characters[i]!.mechanism]!));
    this.new_pictures = true;
  }

  /** Works on the smooth surfaces, which are rough at first. @return true if the picture changes */
  refine(milliseconds: number): boolean {
    const changed = this.new_pictures;
    this.new_pictures = false;
    return this.surfaces.refine(milliseconds) || changed;
  }

  set_theme(theme: 'dark' | 'light'): void {
    this.stage.set_look(this.scene.look, theme);
    this.scene.characters.forEach((c, i) => this.characters[i]!.set_look(c.color || '#e6e6ea', c, c.metalness ? this.stage.environment : null));
  }

  /** @param width, height of the picture, px of the page */
  resize(width: number, height: number): void {
    this.size = { width: Math.max(1, width), height: Math.max(1, height) };
    this.stage.resize(width, height);
    this.rig.resize(this.size.width / this.size.height);
  }

  get view_height(): number {
    return this.size.height;
  }

  /** Poses everything as in `frame`. */
  place(frame: Frame): void {
    this.watch(frame);
    this.characters.forEach((view, i) => {
      const character = frame.characters[i];
      if (!character) return;
      view.place(frame, character);
      view.group.updateMatrixWorld(true);
    });
    this.place_overlays(frame);
  }

  /** Directs the camera as in `frame`, and poses nothing: for frames that are not drawn. */
  watch(frame: Frame): void {
    this.shown = frame;
    if (!this.film(frame)) this.follow(frame);
  }

  /** Looks through the camera of the shot at the frame's time. @return false: there is no shot, or the user has moved the view */
  private film(frame: Frame): boolean {
    const shot = this.directed && shot_at(this.scene.shots, frame.time);
    const camera = shot && this.scene.cameras?.find((c) => c.id === shot.camera);
    const followed = camera && frame.characters[this.scene.characters.findIndex((c) => c.id === camera.follow)];
    const [x, y] = followed ? centre_of_mass(frame, followed) : [0, 0];
    this.rig.look_through(camera ? view_of(camera, frame.time) : null, { x, y });
    return Boolean(camera);
  }

  private follow(frame: Frame): void {
    const character = frame.characters[this.followed];
    if (!character) return this.rig.follow(null);
    this.rig.follow(new THREE.Vector3(...centre_of_mass(frame, character)));
  }

  private place_overlays(frame: Frame): void {
    frame.characters.forEach((character, i) => {
      const weight = body_weight(frame, character);
      const force = new THREE.Vector3(...assist_force(frame, character));
      const share = weight > 0 ? force.length() / weight : 0;
      const arrow = this.assist_arrows[i];
      if (!arrow) return;
      if (!this.assist || share <= 0.004) return arrow.hide();
      const root = this.characters[i]!.links.find((m) => m)?.matrixWorld ?? new THREE.Matrix4();
      arrow.material.color.copy(assist_color(assist_over_cap(frame, character)));
      // The length grows with the square root of the force: 1 % of the weight is visible (0.19 m), 100 % fits into the view (1.9 m).
      arrow.show(new THREE.Vector3().setFromMatrixPosition(root), force.setLength(1.9 * Math.sqrt(Math.min(share, 1))));
    });
    this.discs.begin();
    let arrows = 0;
    if (this.contacts) {
      const largest = Math.max(1, ...frame.characters.map((c) => body_weight(frame, c)));
      const f = frame.floats;
      for (let i = 0; i < frame.contact_count && arrows < max_contacts; i++) {
        const at = frame.contacts + 8 * i;
        const force = new THREE.Vector3(f[at + 3], f[at + 4], f[at + 5]).multiplyScalar(0.9 / largest).clampLength(0, 1.6);
        if (force.lengthSq() < 1e-6) continue;
        const point = new THREE.Vector3(f[at], f[at + 1], f[at + 2]);
        const n = frame.normals + 3 * i;
        this.discs.add(point, frame.normals < 0 ? force : new THREE.Vector3(f[n], f[n + 1], f[n + 2]), 0.028);
        this.contact_arrows[arrows++]!.show(point, force);
      }
    }
    for (let i = arrows; i < max_contacts; i++) this.contact_arrows[i]!.hide();
  }

  /** World position of a point of a link, m. */
  point_of(hit: Hit, local: THREE.Vector3): THREE.Vector3 {
    const mesh = this.characters[hit.character]?.links[hit.link];
    return mesh ? local.clone().applyMatrix4(mesh.matrixWorld) : local.clone();
  }
  /** The hit point in the frame of its link, m. */
  to_link(hit: Hit): THREE.Vector3 {
    const mesh = this.characters[hit.character]?.links[hit.link];
    return mesh ? hit.point.clone().applyMatrix4(mesh.matrixWorld.clone().invert()) : hit.point.clone();
  }

  /**
   * The link at a point of the picture. If the ray misses, links within `reach` px are found too, so that a thin arm or a finger on a
   * phone need not be hit exactly. @param x, y px from the top left corner
   */
  pick(x: number, y: number, reach: number): Hit | null {
    const groups = this.characters.map((c) => c.group);
    const look = (dx: number, dy: number): Hit | null => {
      this.aim_ray(x + dx, y + dy);
      const found = this.raycaster.intersectObjects(groups, true)[0];
      if (!found) return null;
      const tag = found.object.userData as LinkTag;
      return { character: Number(tag.character), link: tag.link, point: found.point.clone() };
    };
    const exact = look(0, 0);
    if (exact || reach <= 0) return exact;
    for (const radius of [reach / 2, reach]) {
      for (let i = 0; i < 8; i++) {
        const hit = look(radius * Math.cos((i * Math.PI) / 4), radius * Math.sin((i * Math.PI) / 4));
        if (hit) return hit;
      }
    }
    return null;
  }

  /** Intersection of the ray at (x, y) with the plane through `point` that faces the camera, m; null if there is none. */
  on_facing_plane(x: number, y: number, point: THREE.Vector3): THREE.Vector3 | null {
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(this.rig.camera.getWorldDirection(new THREE.Vector3()).negate(), point);
    this.aim_ray(x, y);
    return this.raycaster.ray.intersectPlane(plane, new THREE.Vector3());
  }

  private aim_ray(x: number, y: number): void {
    this.raycaster.setFromCamera(new THREE.Vector2((x / this.size.width) * 2 - 1, 1 - (y / this.size.height) * 2), this.rig.camera);
  }

  link_label(hit: Hit): string {
    const link = this.characters[hit.character]?.mechanism.links[hit.link];
    return link?.label || link?.name || '';
  }

  emphasise(hit: Hit | null, emphasis: 'hover' | 'pulled'): void {
    this.characters.forEach((view, c) => view.links.forEach((_mesh, l) => view.emphasise(l, hit?.character === c && hit.link === l ? emphasis : 'none')));
  }

  private spheres(only = -1): THREE.Sphere[] {
    const out: THREE.Sphere[] = [];
    this.characters.forEach((view, i) => {
      if (only >= 0 && i !== only) return;
      view.group.updateMatrixWorld(true);
      for (const mesh of view.links) if (mesh?.geometry.boundingSphere) out.push(mesh.geometry.boundingSphere.clone().applyMatrix4(mesh.matrixWorld));
    });
    return out;
  }

  /** The initial view of the content: its stored direction and distance, or everything. */
  first_view(): void {
    const { camera } = this.scene;
    this.rig.follow(null);
    this.rig.look_from(camera.azimuth, camera.elevation);
    this.frame_all();
    const followed = this.followed >= 0 ? this.spheres(this.followed) : [];
    if (followed.length > 0) {
      this.rig.frame(followed);
      this.rig.set({ distance: camera.distance }, false);
    }
    this.rig.set({}, true);
    this.directed = true;
    if (this.shown) this.film(this.shown);
  }

  frame_all(): void {
    const spheres = this.spheres();
    this.rig.frame(spheres.length > 0 ? spheres : [new THREE.Sphere(new THREE.Vector3(0, 0, 0.9), 1.4)]);
  }

  /** Moves the camera by `dt` s. @return whether it moved */
  update_camera(dt: number): boolean {
    return this.rig.update(dt);
  }

  /** Draws the picture. @param still true: nothing moves, so the picture is drawn at full resolution */
  draw(still: boolean): void {
    const { camera } = this.rig;
    const { target, distance } = this.rig.current;
    const bead = 0.006 * distance;
    if (this.pull) this.spring.show(this.point_of(this.pull.hit, this.pull.local), this.pull.target, camera, Math.min(0.03, bead));
    else this.spring.hide();
    if (this.aim) this.push_arrow.show(this.point_of(this.aim.hit, this.aim.local), this.aim.along);
    else this.push_arrow.hide();
    this.stage.focus(target, shadow_reach(this.spheres(), target, distance), distance);
    this.stage.render(camera, still);
    for (const skin of this.samples) skin.dispose();
    this.samples = [];
  }

  get frame(): Frame | null {
    return this.shown;
  }

  dispose(): void {
    this.end_textures();
    for (const view of this.characters) view.dispose();
    this.stage.dispose();
  }
}
