/** The stage: renderer, lights, floor and background. Adapts the resolution to the machine and draws at full resolution while nothing moves. */
import * as THREE from 'three';
import { plain_look, type Look } from '../core/look';
import { Floor } from './floor';
import './shading';
import { floor_layer, SmoothAreas } from './smooth_areas';
import { ShadowRegion } from './shadow_region';
import { Sky } from './sky';

/** How pictures are drawn. The default is for a page that a user looks at. */
export interface StageOptions {
  /** True: every picture is drawn at its full resolution with smooth edges, and can be read back; for files, not for a live view. */
  pictures?: boolean;
  /** True: no floor and no background, so that the picture's background is transparent. */
  transparent?: boolean;
}

const draft_ratio = 0.5; // resolution of drafts, relative to that of the screen
const light_distance = 8; // m, of the light that casts shadows from its target
const deepest = 12.5; // m: the shadow map reaches from the light to this depth, and further if the light is low
const shadow_bias = 0.013; // m: a surface casts no shadow on what is nearer than this behind it

export class Stage {
  readonly renderer: THREE.WebGLRenderer;
  readonly scene = new THREE.Scene();
  readonly floor = new Floor();
  private readonly dome = new Sky();
  private readonly shadow_region = new ShadowRegion();
  private readonly key = new THREE.DirectionalLight(0xfff3e4, 2.5);
  private readonly fill = new THREE.DirectionalLight(0xa9c4ff, 0.55);
  private readonly sky = new THREE.HemisphereLight(0xdfe8f7, 0x2d2b2a, 1.15);
  private readonly background = new THREE.Color();
  private shown_look: { sky: { zenith: string; horizon: string } | null; floor: THREE.Color } = { sky: null, floor: new THREE.Color() };
  private reflected: THREE.Texture | null = null;
  private readonly to_key = new THREE.Vector3(0, 0, 1);
  private readonly software: boolean;
  /** Draws pictures; null for a live view. */
  private readonly smooth: SmoothAreas | null;
  /** Resolution of frames drawn while something moves, relative to the full resolution, 0.4 ... 1. */
  private quality = 1;
  private width = 1;
  private height = 1;
  /** WebGL sync object that is signalled when the graphics processor has finished the last frame; null: none is pending. */
  private fence: WebGLSync | null = null;
  private began = 0; // time of the last render(), ms
  private drawn_in = 0; // ms from the last render() to the first look at `free` that found its frame finished
  private slow_frames = 0;
  private fast_frames = 0;

  constructor(canvas: HTMLCanvasElement, private readonly options: StageOptions = {}) {
    this.software = !options.pictures && draws_in_software();
    // with software rendering, antialiasing of every frame is too slow; while nothing moves, frames are drawn at a higher resolution instead
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !this.software && !options.pictures, alpha: options.transparent === true, preserveDrawingBuffer: options.pictures === true, powerPreference: 'high-performance' });
    this.smooth = options.pictures ? new SmoothAreas(this.renderer) : null;
    canvas.addEventListener('webglcontextrestored', () => this.shadow_region.reset());
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.scene.background = options.transparent ? null : this.background;
    this.floor.object.visible = !options.transparent;
    this.key.castShadow = true;
    this.key.shadow.mapSize.setScalar(1024);
    this.key.shadow.normalBias = 0.012;
    this.key.shadow.radius = 2; // texels: the four points of a soft shadow (shading.ts) are a texel apart; further apart, they would show as steps
    this.scene.add(this.dome.mesh, this.floor.object, this.key, this.key.target, this.fill, this.fill.target, this.sky);
    for (const object of [this.dome.mesh, ...this.floor.object.children, this.key, this.fill, this.sky]) object.layers.enable(floor_layer);
    this.quality = this.software ? 0.5 : 1;
  }

  /** Sets light, sky and ground as the document specifies. The theme selects the colours that the document does not specify. */
  set_look(wanted: Look, theme: 'dark' | 'light'): void {
    const look = { ...plain_look, ...wanted };
    const dark = theme === 'dark';
    const { sun, sky } = look;
    const own = look.floor.toLowerCase() !== plain_look.floor || sky;
    this.background.set(sky ? sky.horizon : dark ? 0x101318 : 0xe3e6ea);
    const floor = new THREE.Color(dark || own ? look.floor : '#c3c7cd');
    const bright = sky ? floor.getHSL({ h: 0, s: 0, l: 0 }).l > 0.35 : !dark;
    this.floor.set_colors(floor, new THREE.Color(bright ? 0x6b7280 : 0x8b93a1), this.background, bright ? 0.23 : 0.31, look.pattern);
    const light = Math.max(0.05, look.light / 0.9);
    this.key.color.set(sun.color);
    this.key.intensity = 2.5 * light * sun.intensity;
    this.fill.intensity = 0.55 * light * look.ambient;
    this.sky.intensity = (dark || sky ? 1.15 : 1.5) * light * look.ambient;
    this.sky.color.set(0xdfe8f7);
    if (sky) this.sky.color.lerp(new THREE.Color(sky.zenith), 0.6);
    this.to_key.set(Math.cos(sun.azimuth) * Math.cos(sun.elevation), Math.sin(sun.azimuth) * Math.cos(sun.elevation), Math.sin(sun.elevation));
    this.dome.mesh.visible = Boolean(sky) && !this.options.transparent;
    if (sky) this.dome.set_colors(sky, this.key, this.to_key);
    this.shown_look = { sky, floor };
    this.reflected?.dispose();
    this.reflected = null;
    const { shadow } = this.key;
    shadow.camera.far = Math.min(60, deepest + light_distance / this.to_key.z);
    shadow.bias = -shadow_bias / shadow.camera.far;
    shadow.camera.right = 0; // focus() updates the projection
  }

  /** What metal reflects under the present look. A change of the look makes a new one. */
  get environment(): THREE.Texture {
    return (this.reflected ??= make_environment(this.shown_look.sky, this.shown_look.floor));
  }

  resize(width: number, height: number): void {
    this.width = Math.max(1, width);
    this.height = Math.max(1, height);
    this.set_ratio(true);
  }

  /** Begins to compile the shaders of the scene as it will be with `object`, and does not wait for the graphics processor. */
  begin_compiling(object: THREE.Object3D): void {
    this.scene.add(object);
    this.renderer.compile(this.scene, new THREE.PerspectiveCamera());
    this.scene.remove(object);
  }

  /** Centres lights and floor on the camera's target. @param reach half width of the shadowed area, m  @param view_distance m */
  focus(centre: THREE.Vector3, reach: number, view_distance: number): void {
    const half = Math.max(2.2, Math.min(reach, 14));
    // moving the light in steps of one shadow texel keeps the shadow's edges from flickering
    const texel = (2 * half) / this.key.shadow.mapSize.x;
    const x = Math.round(centre.x / texel) * texel;
    const y = Math.round(centre.y / texel) * texel;
    this.key.target.position.set(x, y, 0.6);
    this.key.position.copy(this.to_key).multiplyScalar(light_distance).add(this.key.target.position);
    this.fill.target.position.set(x, y, 0.8);
    this.fill.position.set(x - 5, y - 4, 3);
    const camera = this.key.shadow.camera;
    if (camera.right !== half) {
      Object.assign(camera, { left: -half, right: half, top: half, bottom: -half, near: 0.5 });
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
      this.drawn_in = performance.now() - this.began;
    }
    return true;
  }

  /** True until as much time has passed since the last frame was finished as drawing it took, and at most 250 ms. */
  get rests(): boolean {
    return performance.now() - this.began < this.drawn_in + Math.min(this.drawn_in, 250);
  }

  /**
   * Draws a frame. @param still true: nothing moves, so the frame is drawn at full resolution
   * @param draft true: a lower resolution is enough
   */
  render(camera: THREE.Camera, still: boolean, draft = false): void {
    this.began = performance.now();
    this.set_ratio(still, draft);
    this.scene.updateMatrixWorld();
    this.shadow_region.limit(this.key, this.floor.place_patches(this.scene, this.key));
    if (this.smooth) this.smooth.render(this.scene, camera, { floor: this.floor.object, sky: this.dome.mesh, draw_as: (mode) => this.floor.draw_as(mode) });
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

  private set_ratio(still: boolean, draft = false): void {
    const full = this.options.pictures ? 1 : Math.min(window.devicePixelRatio || 1, 2);
    const finest = this.software ? Math.min(2, full * 1.6) : full;
    const sharp = still || this.options.pictures ? finest : full * this.quality;
    const ratio = draft ? Math.min(sharp, draft_ratio * full) : sharp;
    const size = this.renderer.getSize(new THREE.Vector2());
    if (this.renderer.getPixelRatio() !== ratio) this.renderer.setPixelRatio(ratio);
    if (size.x !== this.width || size.y !== this.height) this.renderer.setSize(this.width, this.height, false);
  }

  dispose(): void {
    this.smooth?.dispose();
    this.renderer.dispose();
  }
}

/** A panorama with y up: floor, sky, and two bright panels that give metal its highlights. */
function make_environment(sky: { zenith: string; horizon: string } | null, floor: THREE.Color): THREE.Texture {
  const [width, height] = [64, 32];
  const data = new Uint8Array(4 * width * height);
  const [zenith, horizon, color] = [new THREE.Color(sky?.zenith ?? 0x6f7885), new THREE.Color(sky?.horizon ?? 0xc9ced6), new THREE.Color()];
  for (let i = 0; i < width * height; i++) {
    const up = Math.sin(((Math.floor(i / width) + 0.5) / height - 0.5) * Math.PI);
    color.copy(up < 0 ? floor : horizon);
    if (up > 0) color.lerp(zenith, Math.sqrt(up));
    if (up > 0.15 && up < 0.8 && i % (width / 2) < 7) color.setScalar(1);
    color.convertLinearToSRGB();
    data.set([255 * color.r, 255 * color.g, 255 * color.b, 255], 4 * i);
  }
  const texture = new THREE.DataTexture(data, width, height);
  texture.mapping = THREE.EquirectangularReflectionMapping;
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.needsUpdate = true;
  return texture;
}

/**
 * Half width of the area around the camera's target in which shadows are drawn, m. @param spheres bounding spheres of all links
 * @param view_distance distance of the camera from its target, m
 */
export function shadow_reach(spheres: Iterable<THREE.Sphere>, target: THREE.Vector3, view_distance: number): number {
  let farthest = -1;
  for (const s of spheres) farthest = Math.max(farthest, Math.hypot(s.center.x - target.x, s.center.y - target.y) + s.radius);
  if (farthest < 0) farthest = 2.5;
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
