// Makes a character file: a person with a skin of boxes, whose halves follow two joints, with a striped texture, and two seconds of motion.
import { Glb, png } from './made_files.mjs';

// name, parent, place in the world at rest (m, Y up, Z forward), end of the bone, half width of its box
const bones = [
  ['Hips', null, [0, 0.95, 0], [0, 1.07, 0], 0.14],
  ['Spine', 'Hips', [0, 1.07, 0], [0, 1.22, 0], 0.13],
  ['Chest', 'Spine', [0, 1.22, 0], [0, 1.46, 0], 0.16],
  ['Neck', 'Chest', [0, 1.46, 0], [0, 1.56, 0], 0.055],
  ['Head', 'Neck', [0, 1.56, 0], [0, 1.78, 0.01], 0.09],
  ...[['Left', 1], ['Right', -1]].flatMap(([side, s]) => [
    [`${side}Shoulder`, 'Chest', [0.04 * s, 1.42, 0], [0.18 * s, 1.43, 0], 0.06],
    [`${side}Arm`, `${side}Shoulder`, [0.18 * s, 1.43, 0], [0.46 * s, 1.43, 0], 0.05],
    [`${side}ForeArm`, `${side}Arm`, [0.46 * s, 1.43, 0], [0.71 * s, 1.43, 0], 0.042],
    [`${side}Hand`, `${side}ForeArm`, [0.71 * s, 1.43, 0], [0.88 * s, 1.43, 0], 0.04],
    [`${side}UpLeg`, 'Hips', [0.09 * s, 0.92, 0], [0.09 * s, 0.5, 0], 0.08],
    [`${side}Leg`, `${side}UpLeg`, [0.09 * s, 0.5, 0], [0.09 * s, 0.09, 0], 0.06],
    [`${side}Foot`, `${side}Leg`, [0.09 * s, 0.09, 0], [0.09 * s, 0.03, 0.13], 0.045],
    [`${side}ToeBase`, `${side}Foot`, [0.09 * s, 0.03, 0.13], [0.09 * s, 0.02, 0.21], 0.04],
  ]),
];
const index_of = new Map(bones.map(([name], i) => [name, i]));
const sub = (a, b) => a.map((x, k) => x - b[k]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / Math.hypot(...a));

/** The vertices of a box around each bone. */
function surface() {
  const out = { positions: [], normals: [], uvs: [], joints: [], weights: [], indices: [] };
  bones.forEach(([, parent, from, to, half], b) => {
    const along = unit(sub(to, from));
    const u = unit(cross(along, Math.abs(along[2]) > 0.7 ? [0, 1, 0] : [0, 0, 1]));
    const v = cross(along, u);
    for (const [n, a, c] of [[u, v, along], [v, along, u], [along, u, v]].flatMap(([n, a, c]) => [[n, a, c], [n.map((x) => -x), c, a]])) {
      const first = out.positions.length / 3;
      for (const [s, t] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
        const d = n.map((x, k) => x + s * a[k] + t * c[k]);
        const length = d.reduce((sum, x, k) => sum + x * along[k], 0); // -1: beginning of the bone, 1: its end
        const p = from.map((x, k) => x + (0.5 + 0.5 * length) * (to[k] - x) + half * (d[k] - length * along[k]));
        out.positions.push(...p);
        out.normals.push(...n);
        out.uvs.push(0.5 + 0.5 * s, 0.5 + 0.5 * t);
        const shared = length < 0 && parent !== null ? 0.35 : 0;
        out.joints.push(b, parent === null ? 0 : index_of.get(parent), 0, 0);
        out.weights.push(1 - shared, shared, 0, 0);
      }
      out.indices.push(first, first + 1, first + 2, first, first + 2, first + 3);
    }
  });
  return out;
}

/** The GLB file: arms swing, knees bend a little. */
export function skinned_person() {
  const glb = new Glb();
  const { root } = glb;
  const [view, add, floats] = [glb.view, glb.add, glb.floats].map((f) => f.bind(glb));
  const s = surface();
  const stripes = png(64, 64, (x, y) => (((x >> 3) + (y >> 3)) % 2 ? [236, 196, 120] : [52, 96, 130]));
  root.images = [{ bufferView: view(stripes), mimeType: 'image/png' }];
  root.textures = [{ source: 0 }];
  root.materials = [{ name: 'suit', pbrMetallicRoughness: { baseColorTexture: { index: 0 }, metallicFactor: 0 } }];
  const attributes = { POSITION: floats(s.positions, 3, 'VEC3'), NORMAL: floats(s.normals, 3, 'VEC3'), TEXCOORD_0: floats(s.uvs, 2, 'VEC2'), JOINTS_0: add(s.joints, 4, 'VEC4', 5123, Uint16Array), WEIGHTS_0: floats(s.weights, 4, 'VEC4') };
  root.meshes = [{ primitives: [{ attributes, indices: add(s.indices, 1, 'SCALAR', 5123, Uint16Array), material: 0 }] }];
  root.nodes = bones.map(([name, parent, from], b) => {
    const children = bones.flatMap(([, p], i) => (p === name ? [i] : []));
    return { name, translation: parent === null ? from : sub(from, bones[index_of.get(parent)][2]), ...(children.length > 0 ? { children } : {}) };
  });
  root.nodes.push({ name: 'person', mesh: 0, skin: 0 });
  root.scenes = [{ nodes: [0, bones.length] }];
  const binds = bones.flatMap(([, , [x, y, z]]) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1]);
  root.skins = [{ joints: bones.map((_, i) => i), inverseBindMatrices: floats(binds, 16, 'MAT4') }];
  const times = Array.from({ length: 61 }, (_, i) => i / 30);
  const input = floats(times, 1, 'SCALAR');
  const turns = { LeftArm: [0, 0, -1.2, 0.35], RightArm: [0, 0, 1.2, -0.35], LeftForeArm: [0, -0.3, 0, 0.2], RightForeArm: [0, 0.3, 0, -0.2], Chest: [0, 0, 0, 0.08], Head: [0, 0, 0, 0.2] };
  root.animations = [{ name: 'sway', channels: [], samplers: [] }];
  for (const [name, [x, y, z, swing]] of Object.entries(turns)) {
    const axis = name === 'Chest' || name === 'Head' ? [0, 1, 0] : unit([x, y, z]);
    const values = times.flatMap((t) => {
      const half = 0.5 * (Math.hypot(x, y, z) + Math.abs(swing) * Math.sin(Math.PI * t));
      return [...axis.map((a) => a * Math.sin(half)), Math.cos(half)];
    });
    root.animations[0].samplers.push({ input, output: floats(values, 4, 'VEC4') });
    root.animations[0].channels.push({ sampler: root.animations[0].samplers.length - 1, target: { node: index_of.get(name), path: 'rotation' } });
  }
  return glb.file();
}
