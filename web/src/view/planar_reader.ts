/** Reads a drawn picture as planar YCbCr 4:2:0, the input form of video coders (1.5 bytes a pixel). */

/** Returns true if pictures of this size can be read: width and height are even. */
export const fits_planar = (width: number, height: number): boolean => width % 2 === 0 && height % 2 === 0;

const poll_time = 2; // time between two questions whether the picture is drawn, ms
const one = 1 << 16; // fixed-point numbers have 16 bits behind the point

/** Coefficient of a colour difference to a colour value, for the matrix and limited range of ITU-R BT.709 (luma 16 ... 235, chroma 16 ... 240). */
const fixed = (value: number): number => Math.round(value * one);
const [luma_r, luma_g, luma_b] = [0.2126, 0.7152, 0.0722].map((k) => fixed((k * 219) / 255)) as [number, number, number];
// The chroma values are computed from the sum of 2 x 2 pixels, hence the factor 1/4.
const chroma = (scale: number, r: number, g: number, b: number): [number, number, number] => [r, g, b].map((k) => fixed((k * 224) / 255 / scale / 4)) as [number, number, number];
const [cb_r, cb_g, cb_b] = chroma(1.8556, -0.2126, -0.7152, 1 - 0.0722);
const [cr_r, cr_g, cr_b] = chroma(1.5748, 1 - 0.2126, -0.7152, -0.0722);

/**
 * Converts a picture by the matrix of ITU-R BT.709 with limited range. Chroma is the mean of 2 x 2 pixels, at their centre.
 * @param rgba rows from the bottom to the top, as WebGL reads them
 * @param out luma, then Cb, then Cr, each row by row from the top; (3 * width * height) / 2 bytes
 */
export function to_planar(rgba: Uint8Array, width: number, height: number, out: Uint8Array): void {
  const pixels = new Uint32Array(rgba.buffer, rgba.byteOffset, width * height); // little-endian: red is the lowest byte
  const half = width >> 1;
  let cb = width * height;
  let cr = cb + (cb >> 2);
  for (let y = 0; y < height; y += 2) {
    let upper = (height - 1 - y) * width;
    let lower = upper - width;
    let at = y * width;
    for (let x = 0; x < half; x++, at += 2) {
      const a = pixels[upper++]!;
      const b = pixels[upper++]!;
      const c = pixels[lower++]!;
      const d = pixels[lower++]!;
      out[at] = luma(a);
      out[at + 1] = luma(b);
      out[at + width] = luma(c);
      out[at + width + 1] = luma(d);
      const red = (a & 255) + (b & 255) + (c & 255) + (d & 255);
      const green = ((a >>> 8) & 255) + ((b >>> 8) & 255) + ((c >>> 8) & 255) + ((d >>> 8) & 255);
      const blue = ((a >>> 16) & 255) + ((b >>> 16) & 255) + ((c >>> 16) & 255) + ((d >>> 16) & 255);
      out[cb++] = (cb_r * red + cb_g * green + cb_b * blue + 128.5 * one) >> 16;
      out[cr++] = (cr_r * red + cr_g * green + cr_b * blue + 128.5 * one) >> 16;
    }
  }
}
const luma = (p: number): number => (luma_r * (p & 255) + luma_g * ((p >>> 8) & 255) + luma_b * ((p >>> 16) & 255) + 16.5 * one) >> 16;

/** A copy of a drawn picture that waits to be read. */
interface Kept {
  frame: WebGLFramebuffer;
  color: WebGLRenderbuffer;
}

/**
 * Reads pictures from the canvas of a WebGL context. Reading a picture waits until it is drawn, and Mesa can then not prepare the next one.
 * A picture is therefore kept as a copy and read after the next one has been passed to the graphics processor.
 */
export class PlanarReader {
  private readonly spare: WebGLBuffer[] = [];
  private readonly spare_frames: Kept[] = [];
  private readonly spare_outputs: Uint8Array<ArrayBuffer>[] = [];
  private readonly rgba: Uint8Array<ArrayBuffer>;
  /** Starts reading the picture that was kept last. */
  private start: (() => void) | null = null;

  /** @param width, height size of the context's canvas in px; fits_planar() must be true */
  constructor(private readonly gl: WebGL2RenderingContext, private readonly width: number, private readonly height: number) {
    this.rgba = new Uint8Array(4 * width * height);
  }

  /**
   * Returns the picture that was drawn last, in the form of to_planar(). Further pictures may be drawn at once. The promise is fulfilled only
   * after the next call of read() or finish(). Give the array back by reuse() when it is no longer needed.
   */
  read(): Promise<Uint8Array<ArrayBuffer>> {
    const kept = this.keep();
    this.finish();
    return new Promise<void>((begin) => (this.start = begin)).then(() => this.take(kept));
  }

  /** Starts to read the last picture. */
  finish(): void {
    this.start?.();
    this.start = null;
  }

  reuse(out: Uint8Array<ArrayBuffer>): void {
    this.spare_outputs.push(out);
  }

  private keep(): Kept {
    const { gl, width, height } = this;
    const kept = this.spare_frames.pop() ?? this.make_frame();
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, kept.frame);
    gl.disable(gl.SCISSOR_TEST);
    gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    gl.flush();
    return kept;
  }

  private async take(kept: Kept): Promise<Uint8Array<ArrayBuffer>> {
    const { gl, width, height } = this;
    const buffer = this.spare.pop() ?? this.make_buffer();
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, kept.frame);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, 0);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
    this.spare_frames.push(kept);
    const drawn = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0)!;
    gl.flush();
    while (gl.clientWaitSync(drawn, 0, 0) === gl.TIMEOUT_EXPIRED) await new Promise((done) => setTimeout(done, poll_time));
    gl.deleteSync(drawn);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
    gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, this.rgba);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    this.spare.push(buffer);
    const out = this.spare_outputs.pop() ?? new Uint8Array((3 * width * height) / 2);
    to_planar(this.rgba, width, height, out);
    return out;
  }

  private make_frame(): Kept {
    const { gl, width, height } = this;
    const kept = { frame: gl.createFramebuffer(), color: gl.createRenderbuffer() };
    gl.bindRenderbuffer(gl.RENDERBUFFER, kept.color);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.RGB8, width, height); // the format of the canvas
    gl.bindRenderbuffer(gl.RENDERBUFFER, null);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, kept.frame);
    gl.framebufferRenderbuffer(gl.DRAW_FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, kept.color);
    return kept;
  }

  private make_buffer(): WebGLBuffer {
    const { gl } = this;
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
    gl.bufferData(gl.PIXEL_PACK_BUFFER, this.rgba.length, gl.STREAM_READ);
    return buffer;
  }
}
