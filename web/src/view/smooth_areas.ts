/** Draws pictures with smooth edges in less time: four samples a pixel only in the areas in which objects other than floor and sky are drawn. */
import * as THREE from 'three';
import { areas_outside, drawn_areas, type Area } from './areas';

/** Layer of the floor, the sky and the lights. Objects on it are drawn outside the areas too. */
export const floor_layer = 3;

const samples = 4;
const max_part = 0.8; // if the areas are a larger part of the picture, it is drawn in one pass

export class SmoothAreas {
  private target: THREE.WebGLRenderTarget | null = null;

  constructor(private readonly renderer: THREE.WebGLRenderer) {}

  /** Draws the scene into the canvas. World matrices must be up to date. @param backdrop the objects outside the areas, on floor_layer */
  render(scene: THREE.Scene, camera: THREE.Camera, backdrop: readonly THREE.Object3D[]): void {
    const { renderer } = this;
    const { x: width, y: height } = renderer.getDrawingBufferSize(new THREE.Vector2());
    const whole: Area = { left: 0, bottom: 0, right: width, top: height };
    let areas = drawn_areas(scene, backdrop, camera, width, height) ?? [whole];
    if (areas.reduce((sum, a) => sum + (a.right - a.left) * (a.top - a.bottom), 0) > max_part * width * height) areas = [whole];
    const target = this.sized(width, height);
    target.scissorTest = true;
    renderer.setRenderTarget(target);
    for (const area of areas) {
      scissor(target.scissor, area);
      renderer.setRenderTarget(target);
      renderer.render(scene, camera);
      renderer.shadowMap.autoUpdate = false; // the shadows are the same in every area
    }
    renderer.setRenderTarget(null);
    const { mask } = camera.layers;
    camera.layers.set(floor_layer);
    renderer.setScissorTest(true);
    for (const area of areas_outside(areas, width, height)) {
      const ratio = renderer.getPixelRatio();
      renderer.setScissor(area.left / ratio, area.bottom / ratio, (area.right - area.left) / ratio, (area.top - area.bottom) / ratio);
      renderer.render(scene, camera);
    }
    renderer.setScissorTest(false);
    renderer.shadowMap.autoUpdate = true;
    camera.layers.mask = mask;
    this.copy(areas);
  }

  dispose(): void {
    this.target?.dispose();
  }

  private sized(width: number, height: number): THREE.WebGLRenderTarget {
    if (this.target?.width === width && this.target.height === height) return this.target;
    this.target?.dispose();
    this.target = new THREE.WebGLRenderTarget(width, height, { samples, colorSpace: THREE.SRGBColorSpace, internalFormat: 'RGBA8', resolveDepthBuffer: false, generateMipmaps: false });
    // Colours are written as into the canvas (sRGB) instead of linearly.
    (this.target as THREE.WebGLRenderTarget & { isXRRenderTarget: boolean }).isXRRenderTarget = true;
    return this.target;
  }

  /** Copies areas of the target into the canvas. */
  private copy(areas: readonly Area[]): void {
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    const { __webglFramebuffer: from } = this.renderer.properties.get(this.target) as { __webglFramebuffer: WebGLFramebuffer };
    this.renderer.state.bindFramebuffer(gl.READ_FRAMEBUFFER, from);
    this.renderer.state.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null as unknown as WebGLFramebuffer);
    for (const { left, bottom, right, top } of areas) gl.blitFramebuffer(left, bottom, right, top, left, bottom, right, top, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    this.renderer.state.bindFramebuffer(gl.READ_FRAMEBUFFER, null as unknown as WebGLFramebuffer); // whoever reads the picture reads the canvas
  }
}

const scissor = (out: THREE.Vector4, a: Area): void => {
  out.set(a.left, a.bottom, a.right - a.left, a.top - a.bottom);
};
