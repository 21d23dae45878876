/** Links that are thinner than the cells of a body's grid, for example fingers: their shapes are drawn as they are, each bound to its link. */
import type { FieldLink } from './body_field';

/** Vertices and triangles of shapes in the bind pose, like those of a body's surface. */
export interface ThinShapes {
  positions: number[];
  normals: number[];
  links: number[];
  weights: number[];
  indices: number[];
}

/**
 * Round surfaces of all shapes of the links. A part is the sum of a box or a line and a sphere, or an ellipsoid, so that its surface is that of a sphere
 * whose octants are moved apart.
 * @param segments around each shape; there are half as many rings from pole to pole
 * @param first index of the first vertex
 */
export function thin_shapes(links: readonly FieldLink[], segments: number, first: number): ThinShapes {
  const out: ThinShapes = { positions: [], normals: [], links: [], weights: [], indices: [] };
  const rings = 2 * Math.ceil(segments / 4); // even: no ring lies on the equator, where the halves of the sphere are moved apart
  for (const { index, parts } of links)
    for (const { kind, sizes, round, into } of parts) {
      const [a, b, c] = sizes;
      const core = kind === 'box' ? [a - round, b - round, c - round] : kind === 'round' ? [0, 0, c] : [0, 0, 0];
      const size = kind === 'ellipsoid' ? [a, b, c] : [round, round, round];
      const start = first + out.positions.length / 3;
      const add = (x: number, y: number, z: number): void => {
        const unit = [x, y, z];
        // the transform from the world into the part's frame is a rotation and a translation
        const p = unit.map((u, k) => Math.sign(u) * core[k]! + size[k]! * u - into[4 * k + 3]!);
        const n = unit.map((u, k) => u / size[k]!);
        const length = Math.hypot(n[0]!, n[1]!, n[2]!);
        for (let i = 0; i < 3; i++) {
          out.positions.push(into[i]! * p[0]! + into[4 + i]! * p[1]! + into[8 + i]! * p[2]!);
          out.normals.push((into[i]! * n[0]! + into[4 + i]! * n[1]! + into[8 + i]! * n[2]!) / length);
        }
        out.links.push(index, 0, 0, 0);
        out.weights.push(1, 0, 0, 0);
      };
      add(0, 0, -1);
      for (let ring = 0; ring < rings; ring++) {
        const latitude = Math.PI * ((ring + 0.5) / rings - 0.5);
        for (let s = 0; s < segments; s++) {
          const angle = (2 * Math.PI * (s + 0.5)) / segments;
          add(Math.cos(latitude) * Math.cos(angle), Math.cos(latitude) * Math.sin(angle), Math.sin(latitude));
        }
      }
      add(0, 0, 1);
      const at = (ring: number, s: number): number => start + 1 + segments * ring + (s % segments);
      const last = start + 1 + segments * rings;
      for (let s = 0; s < segments; s++) {
        out.indices.push(start, at(0, s + 1), at(0, s));
        for (let ring = 0; ring + 1 < rings; ring++) {
          out.indices.push(at(ring, s), at(ring, s + 1), at(ring + 1, s + 1));
          out.indices.push(at(ring, s), at(ring + 1, s + 1), at(ring + 1, s));
        }
        out.indices.push(last, at(rings - 1, s), at(rings - 1, s + 1));
      }
    }
  return out;
}
