/** Geometries of meshes and height fields, with smooth shading except at sharp edges. */
import * as THREE from 'three';
import { mergeVertices, toCreasedNormals } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import type { HeightFieldSurface, MechanismData, MeshSurface } from '../core/protocol';
import { add_relief } from './relief';

export type Surfaces = NonNullable<MechanismData['surfaces']>;

const crease = (32 * Math.PI) / 180; // maximum angle between faces that are shaded as one smooth surface, rad

/** The bytes of a Base64 text. */
export function unpack(text: string): ArrayBuffer {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes.buffer;
}

function mesh_geometry(mesh: MeshSurface): THREE.BufferGeometry {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(unpack(mesh.vertices)), 3));
  geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(unpack(mesh.triangles)), 1));
  return mergeVertices(toCreasedNormals(geometry, crease));
}

/** The surface of a height field, with walls down to its base. */
function field_geometry(field: HeightFieldSurface): THREE.BufferGeometry {
  const { columns, rows } = field;
  const heights = new Float32Array(unpack(field.heights));
  const x = (c: number): number => field.half_x * ((2 * c) / (columns - 1) - 1);
  const y = (r: number): number => field.half_y * ((2 * r) / (rows - 1) - 1);
  const points: number[] = [];
  const index: number[] = [];
  for (let r = 0; r < rows; r++) for (let c = 0; c < columns; c++) points.push(x(c), y(r), heights[r * columns + c] ?? 0);
  for (let r = 0; r + 1 < rows; r++) {
    for (let c = 0; c + 1 < columns; c++) {
      const a = r * columns + c;
      index.push(a, a + 1, a + columns + 1, a, a + columns + 1, a + columns);
    }
  }
  const wall = (border: [number, number][]): void => {
    const first = points.length / 3;
    for (const [c, r] of border) points.push(x(c), y(r), heights[r * columns + c] ?? 0, x(c), y(r), -field.base);
    for (let i = 0; i + 1 < border.length; i++) {
      const a = first + 2 * i;
      index.push(a, a + 1, a + 2, a + 1, a + 3, a + 2);
    }
  };
  const along = (n: number, point: (i: number) => [number, number]): [number, number][] => Array.from({ length: n }, (_, i) => point(i));
  wall(along(columns, (i) => [i, 0]));
  wall(along(rows, (i) => [columns - 1, i]));
  wall(along(columns, (i) => [columns - 1 - i, rows - 1]));
  wall(along(rows, (i) => [0, rows - 1 - i]));
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(points, 3));
  geometry.setIndex(index);
  geometry.computeVertexNormals();
  let [lowest, highest] = [Infinity, -Infinity];
  for (const height of heights) [lowest, highest] = [Math.min(lowest, height), Math.max(highest, height)];
  add_relief(geometry, lowest, highest);
  return geometry;
}

/** Geometry of the surface `name`; empty if the mechanism has no such surface. */
export function surface_geometry(surfaces: Surfaces, name: string): THREE.BufferGeometry {
  const surface = surfaces[name];
  if (!surface) {
    const empty = new THREE.BufferGeometry();
    for (const attribute of ['position', 'normal']) empty.setAttribute(attribute, new THREE.Float32BufferAttribute([], 3));
    return empty.setIndex([]);
  }
  return 'vertices' in surface ? mesh_geometry(surface) : field_geometry(surface);
}
