/** Reads a drawn picture as planar YCbCr 4:2:0, the input form of video coders (1.5 bytes a pixel). */

/** Returns true if pictures of this size can be read: width and height are even. */
export const fits_planar = (width: number, height: number): boolean => width % 2 === 0 && height % 2 === 0;

const poll_time = 2; // time between two questions whether the picture is drawn, ms
/** Converts pictures from RGBA to planar YCbCr 4:2:0 by the matrix of ITU-R BT.709 with limited range. */
export interface PlanarConverter {
  /** Where convert() finds a picture: rows from the bottom to the top, as WebGL reads them. Valid until the next call of another method. */
  input(): Uint8Array<ArrayBuffer>;
  /** Converts the picture in input(). @param out luma, then Cb, then Cr, each row by row from the top; (3 * width * height) / 2 bytes */
  convert(out: Uint8Array<ArrayBuffer>): void;
}

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
  /** Starts reading the picture that was kept last. */
  private start: (() => void) | null = null;

  /** @param width, height size of the context's canvas in px; fits_planar() must be true  @param converter for pictures of this size */
  constructor(private readonly gl: WebGL2RenderingContext, private readonly width: number, private readonly height: number, private readonly converter: PlanarConverter) {}

  /**
   * Returns the picture that was drawn last, as PlanarConverter.convert() writes it. Further pictures may be drawn at once. The promise is fulfilled only
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
    gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, this.converter.input());
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    this.spare.push(buffer);
    const out = this.spare_outputs.pop() ?? new Uint8Array((3 * width * height) / 2);
    this.converter.convert(out);
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
    gl.bufferData(gl.PIXEL_PACK_BUFFER, 4 * this.width * this.height, gl.STREAM_READ);
    return buffer;
  }
}
