/**
 * Draws pictures with smooth edges in less time. Floor and sky have no edges within the picture, so they are drawn with one sample a pixel.
 * The other objects are drawn with four samples a pixel on a transparent ground, in the part of the picture that contains them, and put over
 * floor and sky. The result is that of four samples a pixel everywhere, except for rounding: all samples of the floor in a pixel have the
 * colour at the centre of the pixel.
 */
import * as THREE from 'three';
import type { FloorMode } from './floor';
import { drawn_areas, join, join_areas, tile_areas, type Area } from './areas';

/** Layer of the floor, the sky and the lights: the objects that are drawn with one sample a pixel. */
export const floor_layer = 3;

const samples = 4;
const max_areas = 64;
const max_sunken = 8; // areas of bodies that reach below the floor; if there are more, their common rectangle is drawn

/** Objects with one sample a pixel. */
export interface Backdrop {
  floor: THREE.Object3D;
  sky: THREE.Object3D;
  /** How the floor is drawn from now on. */
  draw_as(mode: FloorMode): void;
}

export class SmoothAreas {
  private readonly gl: WebGL2RenderingContext;
  private target: THREE.WebGLRenderTarget | null = null;
  private resolved: THREE.WebGLRenderTarget | null = null;
  /** Framebuffer of `target`: colour and depth with several samples. */
  private buffers: { frame: WebGLFramebuffer; color: WebGLRenderbuffer; depth: WebGLRenderbuffer } | null = null;
  private readonly cover: THREE.Mesh<THREE.BufferGeometry, THREE.RawShaderMaterial>;
  private readonly cover_scene = new THREE.Scene();
  /** Two triangles for each area, in the coordinates of the picture (-1 ... 1). */
  private readonly corners = new THREE.BufferAttribute(new Float32Array(18 * max_areas), 3).setUsage(THREE.DynamicDrawUsage);

  constructor(private readonly renderer: THREE.WebGLRenderer) {
    this.gl = renderer.getContext() as WebGL2RenderingContext;
    const material = new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3,
      uniforms: { u_picture: { value: null } },
      vertexShader: 'in vec3 position;\nvoid main() { gl_Position = vec4(position, 1.0); }',
      fragmentShader: 'precision highp float;\nuniform sampler2D u_picture;\nout vec4 color;\nvoid main() { color = texelFetch(u_picture, ivec2(gl_FragCoord.xy), 0); }',
      blending: THREE.CustomBlending,
      blendSrc: THREE.OneFactor,
      blendDst: THREE.OneMinusSrcAlphaFactor,
      transparent: true,
      depthTest: false,
      depthWrite: false,
    });
    this.cover = new THREE.Mesh(new THREE.BufferGeometry().setAttribute('position', this.corners), material);
    this.cover.frustumCulled = false;
    this.cover_scene.add(this.cover);
  }

  /** Draws the scene into the canvas. World matrices must be up to date. The objects of the backdrop, and the lights, are on floor_layer. */
  render(scene: THREE.Scene, camera: THREE.Camera, backdrop: Backdrop): void {
    const { renderer } = this;
    const { x: width, y: height } = renderer.getDrawingBufferSize(new THREE.Vector2());
    const areas = tile_areas(drawn_areas(scene, [backdrop.floor, backdrop.sky], camera, width, height), width, height, max_areas);
    this.draw_objects(scene, camera, backdrop, areas, width, height);
    renderer.setRenderTarget(null);
    // Nothing is before or behind floor and sky, so that they need no depth. Clearing, testing and writing it takes a thirtieth of a video's time.
    renderer.autoClearDepth = renderer.autoClearStencil = false;
    backdrop.draw_as('flat');
    this.draw_backdrop(scene, camera);
    backdrop.draw_as('whole');
    renderer.autoClearDepth = renderer.autoClearStencil = true;
    if (areas.length === 0) return;
    areas.forEach(({ left, bottom, right, top }, i) => {
      const [l, b, r, t] = [(2 * left) / width - 1, (2 * bottom) / height - 1, (2 * right) / width - 1, (2 * top) / height - 1];
      this.corners.array.set([l, b, 0, r, b, 0, r, t, 0, l, b, 0, r, t, 0, l, t, 0], 18 * i);
    });
    this.corners.needsUpdate = true;
    this.cover.geometry.setDrawRange(0, 6 * areas.length);
    renderer.autoClear = false;
    this.cover.material.uniforms.u_picture!.value = this.resolved!.texture;
    renderer.render(this.cover_scene, camera);
    renderer.autoClear = true;
  }

  dispose(): void {
    this.free();
    this.cover.geometry.dispose();
    this.cover.material.dispose();
  }

  /** Draws what is on floor_layer, with the shadows that were drawn last. */
  private draw_backdrop(scene: THREE.Scene, camera: THREE.Camera): void {
    const { renderer } = this;
    renderer.shadowMap.autoUpdate = false;
    const { mask } = camera.layers;
    camera.layers.set(floor_layer);
    renderer.render(scene, camera);
    camera.layers.mask = mask;
    renderer.shadowMap.autoUpdate = true;
  }

  /** Draws the objects within the areas into `resolved`: colours multiplied by the covered part of the pixel, which is alpha. */
  private draw_objects(scene: THREE.Scene, camera: THREE.Camera, backdrop: Backdrop, areas: readonly Area[], width: number, height: number): void {
    const { renderer, gl } = this;
    this.allocate(width, height);
    const { background } = scene;
    const { visible: sky_shown } = backdrop.sky;
    const { visible: floor_shown } = backdrop.floor;
    const alpha = renderer.getClearAlpha();
    scene.background = null;
    backdrop.sky.visible = false;
    renderer.setClearAlpha(0);
    renderer.setRenderTarget(this.target);
    for (const area of areas) {
      scissor(this.target!.scissor, area);
      renderer.setRenderTarget(this.target);
      renderer.clear();
    }
    renderer.autoClear = false;
    if (floor_shown) {
      backdrop.draw_as('depth');
      const sunken = join_areas(drawn_areas(scene, [backdrop.floor, backdrop.sky], camera, width, height, true));
      for (const area of sunken.length > max_sunken ? [sunken.reduce(join)] : sunken) {
        scissor(this.target!.scissor, area);
        renderer.setRenderTarget(this.target);
        this.draw_backdrop(scene, camera);
      }
      backdrop.draw_as('whole');
    }
    backdrop.floor.visible = false;
    scissor(this.target!.scissor, areas.length > 0 ? areas.reduce(join) : { left: 0, bottom: 0, right: 0, top: 0 });
    renderer.setRenderTarget(this.target);
    renderer.render(scene, camera);
    renderer.autoClear = true;
    renderer.setClearAlpha(alpha);
    backdrop.floor.visible = floor_shown;
    backdrop.sky.visible = sky_shown;
    scene.background = background;
    const { __webglFramebuffer: to } = renderer.properties.get(this.resolved) as { __webglFramebuffer: WebGLFramebuffer };
    renderer.state.bindFramebuffer(gl.READ_FRAMEBUFFER, this.buffers!.frame);
    renderer.state.bindFramebuffer(gl.DRAW_FRAMEBUFFER, to);
    gl.disable(gl.SCISSOR_TEST);
    for (const { left, bottom, right, top } of areas) gl.blitFramebuffer(left, bottom, right, top, left, bottom, right, top, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.enable(gl.SCISSOR_TEST); // as three.js has left it
    renderer.state.bindFramebuffer(gl.READ_FRAMEBUFFER, null as unknown as WebGLFramebuffer); // whoever reads the picture reads the canvas
  }

  private allocate(width: number, height: number): void {
    if (this.target?.width === width && this.target.height === height) return;
    this.free();
    const { renderer, gl } = this;
    this.resolved = new THREE.WebGLRenderTarget(width, height, { depthBuffer: false, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter });
    renderer.initRenderTarget(this.resolved);
    // three.js would resolve the whole picture after each pass, so this framebuffer is made and resolved here.
    const make = (format: number): WebGLRenderbuffer => {
      const buffer = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, width, height);
      return buffer;
    };
    this.buffers = { frame: gl.createFramebuffer(), color: make(gl.RGBA8), depth: make(gl.DEPTH_COMPONENT24) };
    gl.bindRenderbuffer(gl.RENDERBUFFER, null);
    renderer.state.bindFramebuffer(gl.FRAMEBUFFER, this.buffers.frame);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, this.buffers.color);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, this.buffers.depth);
    this.target = new THREE.WebGLRenderTarget(width, height, { colorSpace: THREE.SRGBColorSpace });
    this.target.scissorTest = true;
    // Colours are written as into the canvas (sRGB) instead of linearly.
    (this.target as THREE.WebGLRenderTarget & { isXRRenderTarget: boolean }).isXRRenderTarget = true;
    // @types/three does not declare this function.
    (renderer as unknown as { setRenderTargetFramebuffer(target: THREE.WebGLRenderTarget, frame: WebGLFramebuffer): void }).setRenderTargetFramebuffer(this.target, this.buffers.frame);
  }

  private free(): void {
    const { gl } = this;
    this.resolved?.dispose();
    if (!this.buffers) return;
    gl.deleteFramebuffer(this.buffers.frame);
    gl.deleteRenderbuffer(this.buffers.color);
    gl.deleteRenderbuffer(this.buffers.depth);
    this.buffers = this.target = this.resolved = null;
  }
}

const scissor = (out: THREE.Vector4, a: Area): void => {
  out.set(a.left, a.bottom, a.right - a.left, a.top - a.bottom);
};
