/** Reads a drawn picture as planar YCbCr 4:2:0, the input form of video coders (1.5 bytes a pixel). The graphics processor converts it. */
import * as THREE from 'three';

// Bytes of the output: luma, then Cb, then Cr, each row by row from the top of the picture. Each output pixel contains four of these bytes.
const fragment_shader = `
precision highp float;
precision highp int;
uniform sampler2D u_picture;
uniform ivec2 u_size;
out vec4 bytes;

vec3 pixel(int x, int y) { return texelFetch(u_picture, ivec2(x, u_size.y - 1 - y), 0).rgb; }
float luma(vec3 c) { return dot(c, vec3(0.2126, 0.7152, 0.0722)); }
float value(int at) {
  int pixels = u_size.x * u_size.y;
  if (at < pixels) return (16.0 + 219.0 * luma(pixel(at % u_size.x, at / u_size.x))) / 255.0;
  int c = at - pixels, plane = pixels / 4, width = u_size.x / 2;
  bool red = c >= plane;
  c = red ? c - plane : c;
  int x = 2 * (c % width), y = 2 * (c / width);
  vec3 mean = 0.25 * (pixel(x, y) + pixel(x + 1, y) + pixel(x, y + 1) + pixel(x + 1, y + 1));
  float difference = red ? (mean.r - luma(mean)) / 1.5748 : (mean.b - luma(mean)) / 1.8556;
  return (128.0 + 224.0 * difference) / 255.0;
}
void main() {
  int at = int(gl_FragCoord.y) * u_size.x + 4 * int(gl_FragCoord.x);
  bytes = vec4(value(at), value(at + 1), value(at + 2), value(at + 3));
}`;

/** Returns true if pictures of this size can be read: the width is a multiple of 8, and the height is even. */
export const fits_planar = (width: number, height: number): boolean => width % 8 === 0 && height % 2 === 0;

/** Converter by the matrix of ITU-R BT.709 with limited range (luma 16 ... 235). Chroma is the mean of 2 x 2 pixels, at their centre. */
export class PlanarReader {
  private readonly picture: THREE.FramebufferTexture;
  private readonly target: THREE.WebGLRenderTarget;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.Camera();

  /** @param width, height size of the renderer's canvas in px; fits_planar() must be true */
  constructor(private readonly renderer: THREE.WebGLRenderer, private readonly width: number, private readonly height: number) {
    this.picture = new THREE.FramebufferTexture(width, height);
    this.target = new THREE.WebGLRenderTarget(width / 4, (3 * height) / 2, { depthBuffer: false, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter });
    const material = new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: 'in vec3 position; void main() { gl_Position = vec4(position, 1.0); }',
      fragmentShader: fragment_shader,
      uniforms: { u_picture: { value: this.picture }, u_size: { value: new THREE.Vector2(width, height) } },
      depthTest: false,
      depthWrite: false,
    });
    const quad = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material);
    quad.frustumCulled = false;
    this.scene.add(quad);
  }

  /** Number of bytes of a picture. */
  get size(): number {
    return (3 * this.width * this.height) / 2;
  }

  /** Reads the picture that was drawn last into a buffer of `size` bytes. Further pictures may be drawn before the promise is fulfilled. */
  read(into: Uint8Array<ArrayBuffer>): Promise<Uint8Array<ArrayBuffer>> {
    const { renderer, target } = this;
    renderer.copyFramebufferToTexture(this.picture);
    const shadows = renderer.shadowMap.autoUpdate;
    renderer.shadowMap.autoUpdate = false;
    renderer.setRenderTarget(target);
    renderer.render(this.scene, this.camera);
    renderer.setRenderTarget(null);
    renderer.shadowMap.autoUpdate = shadows;
    return renderer.readRenderTargetPixelsAsync(target, 0, 0, target.width, target.height, into) as Promise<Uint8Array<ArrayBuffer>>;
  }
}
