/** The stage: renderer, lights, floor and background. Adapts the resolution to the machine and draws at full resolution while nothing moves. */
import * as THREE from 'three';
import { Floor } from './floor';
import { floor_layer, SmoothAreas } from './smooth_areas';

export interface StageLook {
  theme: 'dark' | 'light';
  /** Floor colour that the document specifies, as a CSS colour. */
  floor: string;
  /** Brightness that the document specifies, 0 ... 2. */
  light: number;
}

/** How pictures are drawn. The default is for a page that a user looks at. */
export interface StageOptions {
  /** True: every picture is drawn at its full resolution with smooth edges, and can be read back; for files, not for a live view. */
  pictures?: boolean;
  /** True: no floor and no background, so that the picture's background is transparent. */
  transparent?: boolean;
}

const default_floor = '#2a2c31';

export class Stage {
  readonly renderer: THREE.WebGLRenderer;
  readonly scene = new THREE.Scene();
  readonly floor = new Floor();
  private readonly key = new THREE.DirectionalLight(0xfff3e4, 2.5);
  private readonly fill = new THREE.DirectionalLight(0xa9c4ff, 0.55);
  private readonly sky = new THREE.HemisphereLight(0xdfe8f7, 0x2d2b2a, 1.15);
  private readonly background = new THREE.Color();
  private readonly software: boolean;
  /** Draws pictures; null for a live view. */
  private readonly smooth: SmoothAreas | null;
  /** Resolution of frames drawn while something moves, relative to the full resolution, 0.4 ... 1. */
  private quality = 1;
  private width = 1;
  private height = 1;
  /** WebGL sync object that is signalled when the graphics processor has finished the last frame; null: none is pending. */
  private fence: WebGLSync | null = null;
  private slow_frames = 0;
  private fast_frames = 0;

  constructor(canvas: HTMLCanvasElement, private readonly options: StageOptions = {}) {
    this.software = !options.pictures && draws_in_software();
    // with software rendering, antialiasing of every frame is too slow; while nothing moves, frames are drawn at a higher resolution instead
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !this.software && !options.pictures, alpha: options.transparent === true, preserveDrawingBuffer: options.pictures === true, powerPreference: 'high-performance' });
    this.smooth = options.pictures ? new SmoothAreas(this.renderer) : null;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.scene.background = options.transparent ? null : this.background;
    this.floor.object.visible = !options.transparent;
    this.key.castShadow = true;
    this.key.shadow.mapSize.setScalar(this.software ? 1024 : 2048);
    this.key.shadow.bias = -0.0006;
    this.key.shadow.normalBias = 0.012;
    this.key.shadow.radius = 5;
    this.scene.add(this.floor.object, this.key, this.key.target, this.fill, this.fill.target, this.sky);
    this.floor.object.traverse((o) => o.layers.enable(floor_layer));
    for (const light of [this.key, this.fill, this.sky]) light.layers.enable(floor_layer);
    this.quality = this.software ? 0.5 : 1;
  }

  set_look(look: StageLook): void {
    const dark = look.theme === 'dark';
    const own = look.floor.toLowerCase() !== default_floor;
    this.background.set(dark ? 0x101318 : 0xe3e6ea);
    const floor = new THREE.Color(dark || own ? look.floor : '#c3c7cd');
    this.floor.set_colors(floor, new THREE.Color(dark ? 0x8b93a1 : 0x6b7280), this.background, dark ? 0.31 : 0.23);
    const light = Math.max(0.05, look.light / 0.9);
    this.key.intensity = 2.5 * light;
    this.fill.intensity = 0.55 * light;
    this.sky.intensity = (dark ? 1.15 : 1.5) * light;
  }

  resize(width: number, height: number): void {
    this.width = Math.max(1, width);
    this.height = Math.max(1, height);
    this.set_ratio(true);
  }

  /** Centres lights and floor on the camera's target. @param reach half width of the shadowed area, m  @param view_distance m */
  focus(centre: THREE.Vector3, reach: number, view_distance: number): void {
    const half = Math.max(2.2, Math.min(reach, 14));
    // moving the light in steps of one shadow texel keeps the shadow's edges from flickering
    const texel = (2 * half) / this.key.shadow.mapSize.x;
    const x = Math.round(centre.x / texel) * texel;
    const y = Math.round(centre.y / texel) * texel;
    this.key.target.position.set(x, y, 0.6);
    this.key.position.set(x + 2.6, y + 3.4, 7.4);
    this.fill.target.position.set(x, y, 0.8);
    this.fill.position.set(x - 5, y - 4, 3);
    const camera = this.key.shadow.camera;
    if (camera.right !== half) {
      Object.assign(camera, { left: -half, right: half, top: half, bottom: -half, near: 0.5, far: 22 });
      camera.updateProjectionMatrix();
    }
    this.key.shadow.normalBias = Math.max(0.01, 1.6 * texel);
    this.floor.set_focus(centre.x, centre.y, Math.max(14, view_distance * 4.2));
  }

  /** False while the graphics processor still draws the last frame; drawing another frame would block the page. */
  get free(): boolean {
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    if (this.fence) {
      if (!gl.isContextLost() && gl.getSyncParameter(this.fence, gl.SYNC_STATUS) !== gl.SIGNALED) return false;
      gl.deleteSync(this.fence);
      this.fence = null;
    }
    return true;
  }

  /** Draws a frame. @param still true: nothing moves, so the frame is drawn at full resolution */
  render(camera: THREE.Camera, still: boolean): void {
    this.set_ratio(still);
    this.scene.updateMatrixWorld();
    if (this.floor.object.visible) this.floor.place_patches(this.scene, this.key);
    if (this.smooth) this.smooth.render(this.scene, camera, this.floor.object);
    else this.renderer.render(this.scene, camera);
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
  }

  /**
   * Adapts the resolution to the time of a moving frame, ms. Counted since the last change, more than 6 frames above 40 ms (25 a second)
   * lower it, and more than 120 frames below 22 ms (45 a second) raise it.
   */
  note_frame_time(ms: number): void {
    if (ms > 40) this.slow_frames++;
    else if (ms < 22) this.fast_frames++;
    if (this.slow_frames > 6) {
      this.quality = Math.max(0.4, this.quality * 0.8);
      this.slow_frames = this.fast_frames = 0;
    } else if (this.fast_frames > 120) {
      this.quality = Math.min(1, this.quality * 1.25);
      this.slow_frames = this.fast_frames = 0;
    }
  }

  private set_ratio(still: boolean): void {
    const full = this.options.pictures ? 1 : Math.min(window.devicePixelRatio || 1, 2);
    const finest = this.software ? Math.min(2, full * 1.6) : full;
    const ratio = still || this.options.pictures ? finest : full * this.quality;
    const size = this.renderer.getSize(new THREE.Vector2());
    if (this.renderer.getPixelRatio() !== ratio) this.renderer.setPixelRatio(ratio);
    if (size.x !== this.width || size.y !== this.height) this.renderer.setSize(this.width, this.height, false);
  }

  dispose(): void {
    this.smooth?.dispose();
    this.renderer.dispose();
  }
}

/**
 * Half width of the area around the camera's target in which shadows are drawn, m. @param spheres bounding spheres of all links
 * @param view_distance distance of the camera from its target, m
 */
export function shadow_reach(spheres: readonly THREE.Sphere[], target: THREE.Vector3, view_distance: number): number {
  const farthest = spheres.length > 0 ? Math.max(...spheres.map((s) => Math.hypot(s.center.x - target.x, s.center.y - target.y) + s.radius)) : 2.5;
  return Math.min(farthest + 0.5, Math.max(2.6, view_distance * 0.85));
}

/** Whether WebGL is rendered in software, without a graphics processor. */
function draws_in_software(): boolean {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) return false;
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const name = info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : '';
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}
