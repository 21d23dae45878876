/** Pictures as planar YCbCr 4:2:0, the input form of video coders (1.5 bytes a pixel), packed for the way to the program. */

/** Converts pictures from RGBA to planar YCbCr 4:2:0 by the matrix of ITU-R BT.709 with limited range, and packs them. */
export interface PlanarConverter {
  /** Where convert() finds a picture: rows from the bottom to the top, as WebGL reads them. */
  readonly input: Uint8Array<ArrayBuffer>;
  /** Converts and packs the picture in `input`. @return packed picture (apps/ugoki/packed_picture.h), valid until the next call */
  convert(): Uint8Array<ArrayBuffer>;
}

interface Module {
  memory: WebAssembly.Memory;
  ugoki_planar(rgba: number, width: number, height: number, out: number): void;
  ugoki_pack(picture: number, row: number, size: number, out: number): number;
}

/** A converter for pictures of this size (px, even). @param module bytes of ugoki_planar.wasm, which is built from apps/player_wasm */
export async function open_planar_converter(module: BufferSource, width: number, height: number): Promise<PlanarConverter> {
  const { instance } = await WebAssembly.instantiate(module);
  const { memory, ugoki_planar, ugoki_pack } = instance.exports as unknown as Module;
  const page = 65536; // bytes
  const size = (3 * width * height) / 2;
  const rgba = memory.buffer.byteLength;
  const planes = rgba + 4 * width * height;
  const packed = planes + size;
  const end = packed + Math.ceil(1.00001 * size) + 16;
  memory.grow(Math.ceil((end - rgba) / page));
  return {
    input: new Uint8Array(memory.buffer, rgba, 4 * width * height),
    convert: () => {
      ugoki_planar(rgba, width, height, planes);
      return new Uint8Array(memory.buffer, packed, ugoki_pack(planes, width, size, packed));
    },
  };
}

/**
 * Waits until the canvas of `gl` is drawn, and returns its picture as PlanarConverter does. It is read directly into the memory of the
 * converter: a pixel buffer object would need new memory of the size of a picture each time.
 */
export function read_planar(gl: WebGL2RenderingContext, converter: PlanarConverter, width: number, height: number): Uint8Array<ArrayBuffer> {
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, converter.input);
  return converter.convert();
}
