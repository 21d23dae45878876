// Parts of files that journeys make: PNG pictures and GLB files.
import { deflateSync, gzipSync } from 'node:zlib';

/** CRC-32, as the trailer of gzip has it: Node.js 18 has no function of its own for it. */
const crc32 = (bytes) => gzipSync(bytes).subarray(-8).readUInt32LE(0);

/** A PNG picture. @param color r g b of a pixel, 0 ... 255 */
export function png(width, height, color) {
  const rows = Buffer.alloc(height * (1 + 3 * width));
  for (let y = 0; y < height; y++) for (let x = 0; x < width; x++) rows.set(color(x, y), y * (1 + 3 * width) + 1 + 3 * x);
  const chunk = (type, data) => {
    const body = Buffer.concat([Buffer.from(type), data]);
    const out = Buffer.alloc(body.length + 8);
    out.writeUInt32BE(data.length, 0);
    body.copy(out, 4);
    out.writeUInt32BE(crc32(body), body.length + 4);
    return out;
  };
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, 2, 0, 0, 0], 8);
  return Buffer.concat([Buffer.from([0x89, 0x50, 0x4e, 0x47, 13, 10, 26, 10]), chunk('IHDR', head), chunk('IDAT', deflateSync(rows)), chunk('IEND', Buffer.alloc(0))]);
}

/** A GLB file whose lists are added one by one. */
export class Glb {
  bytes = [];
  length = 0;
  root = { asset: { version: '2.0' }, scene: 0, bufferViews: [], accessors: [] };

  /** Index of a new buffer view. */
  view(data) {
    const rest = (4 - (data.length % 4)) % 4;
    this.bytes.push(data, Buffer.alloc(rest));
    this.root.bufferViews.push({ buffer: 0, byteOffset: this.length, byteLength: data.length });
    this.length += data.length + rest;
    return this.root.bufferViews.length - 1;
  }

  /** Index of a new accessor. @param of typed array of its component type */
  add(values, width, type, componentType, of) {
    const list = new of(values);
    const bound = (pick) => Array.from({ length: width }, (_, k) => pick(...values.filter((_, i) => i % width === k)));
    const bounds = type === 'VEC3' || type === 'SCALAR' ? { min: bound(Math.min), max: bound(Math.max) } : {};
    this.root.accessors.push({ bufferView: this.view(Buffer.from(list.buffer)), componentType, count: values.length / width, type, ...bounds });
    return this.root.accessors.length - 1;
  }

  floats(values, width, type) {
    return this.add(values, width, type, 5126, Float32Array);
  }

  /** The bytes of the file. */
  file() {
    this.root.buffers = [{ byteLength: this.length }];
    let json = Buffer.from(JSON.stringify(this.root));
    json = Buffer.concat([json, Buffer.alloc((4 - (json.length % 4)) % 4, 0x20)]);
    const head = Buffer.alloc(20);
    head.write('glTF');
    [2, 28 + json.length + this.length, json.length, 0x4e4f534a].forEach((n, i) => head.writeUInt32LE(n, 4 + 4 * i));
    const chunk = Buffer.alloc(8);
    chunk.writeUInt32LE(this.length, 0);
    chunk.writeUInt32LE(0x004e4942, 4);
    return Buffer.concat([head, json, chunk, ...this.bytes]);
  }
}

/** The planks of a crate: boards with gaps, a frame, nails. */
const planks = (x, y) => {
  const border = Math.min(x, y, 127 - x, 127 - y);
  const gap = border < 14 ? border === 13 : y % 20 < 1.5;
  const grain = 10 * Math.sin(0.9 * (border < 14 ? x + y : y) + 3 * Math.sin(0.05 * x)) + 6 * Math.sin(0.37 * x);
  const nail = border < 14 && Math.hypot((x % 113) - 7, (y % 113) - 7) < 2.6;
  const light = gap ? 0.45 : border < 14 ? 0.88 : 1;
  return nail ? [70, 66, 62] : [light * (190 + grain), light * (140 + grain), light * (86 + 0.6 * grain)].map((v) => Math.round(Math.max(0, Math.min(255, v))));
};

/** A crate of 0.6 m with a wooden texture; Y up. */
export function textured_crate() {
  const glb = new Glb();
  const lists = { positions: [], normals: [], uvs: [], indices: [] };
  const h = 0.3;
  for (const axis of [0, 1, 2])
    for (const sign of [-1, 1]) {
      const first = lists.positions.length / 3;
      const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
      for (const [s, t] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
        const p = [0, 0, 0];
        p[axis] = sign * h;
        p[u] = s * sign * h;
        p[v] = t * h;
        const n = [0, 0, 0];
        n[axis] = sign;
        lists.positions.push(p[0], p[1] + h, p[2]);
        lists.normals.push(...n);
        lists.uvs.push(0.5 + 0.5 * s, 0.5 - 0.5 * t);
      }
      lists.indices.push(first, first + 1, first + 2, first, first + 2, first + 3);
    }
  const { root } = glb;
  root.images = [{ bufferView: glb.view(png(128, 128, planks)), mimeType: 'image/png' }];
  root.textures = [{ source: 0 }];
  root.materials = [{ name: 'wood', pbrMetallicRoughness: { baseColorTexture: { index: 0 }, metallicFactor: 0 } }];
  const attributes = { POSITION: glb.floats(lists.positions, 3, 'VEC3'), NORMAL: glb.floats(lists.normals, 3, 'VEC3'), TEXCOORD_0: glb.floats(lists.uvs, 2, 'VEC2') };
  root.meshes = [{ primitives: [{ attributes, indices: glb.add(lists.indices, 1, 'SCALAR', 5123, Uint16Array), material: 0 }] }];
  root.nodes = [{ name: 'crate', mesh: 0 }];
  root.scenes = [{ nodes: [0] }];
  return glb.file();
}
