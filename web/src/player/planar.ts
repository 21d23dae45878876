/** Pictures as planar YCbCr 4:2:0, the input form of video coders (1.5 bytes a pixel). */

/** Converts pictures from RGBA to planar YCbCr 4:2:0 by the matrix of ITU-R BT.709 with limited range. */
export interface PlanarConverter {
  /** Where convert() finds a picture: rows from the bottom to the top, as WebGL reads them. */
  readonly input: Uint8Array<ArrayBuffer>;
  /** Converts the picture in `input`. @param out luma, then Cb, then Cr, each row by row from the top; (3 * width * height) / 2 bytes */
  convert(out: Uint8Array<ArrayBuffer>): void;
}

/** A converter for pictures of this size (px, even). @param module bytes of ugoki_planar.wasm, which is built from apps/player_wasm */
export async function open_planar_converter(module: BufferSource, width: number, height: number): Promise<PlanarConverter> {
  const { instance } = await WebAssembly.instantiate(module);
  const { memory, ugoki_planar: convert } = instance.exports as { memory: WebAssembly.Memory; ugoki_planar(rgba: number, width: number, height: number, out: number): void };
  const page = 65536; // bytes
  const rgba = memory.buffer.byteLength;
  const planes = rgba + 4 * width * height;
  const size = (3 * width * height) / 2;
  memory.grow(Math.ceil((planes + size - rgba) / page));
  const result = new Uint8Array(memory.buffer, planes, size);
  return {
    input: new Uint8Array(memory.buffer, rgba, 4 * width * height),
    convert: (out) => {
      convert(rgba, width, height, planes);
      out.set(result);
    },
  };
}

/** Reads pictures from the canvas of a WebGL context. */
export class PlanarPictures {
  private readonly spare: Uint8Array<ArrayBuffer>[] = [];

  /** @param width, height size of the pictures in px, both even */
  constructor(private readonly converter: PlanarConverter, private readonly width: number, private readonly height: number) {}

  /**
   * Waits until the canvas is drawn, and returns its picture. It is read directly into the memory of the converter: a pixel buffer object would
   * need new memory of the size of a picture each time. Give the array back by reuse().
   */
  read(gl: WebGL2RenderingContext): Uint8Array<ArrayBuffer> {
    const { width, height } = this;
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, this.converter.input);
    const out = this.spare.pop() ?? new Uint8Array((3 * width * height) / 2);
    this.converter.convert(out);
    return out;
  }

  reuse(out: Uint8Array<ArrayBuffer>): void {
    this.spare.push(out);
  }
}
