/** The ground below a character as drawn: the floor and the props that do not move. */
import * as THREE from 'three';
import type { HeightFieldSurface, MechanismData } from '../core/protocol';
import { unpack } from './surfaces';

/** A drawn body: its mechanism, and the meshes of its links with their world matrices; null for links without shapes. */
export interface DrawnBody {
  mechanism: MechanismData;
  links: readonly (THREE.Mesh | null)[];
}

export interface Standing {
  /** How far the body has to rise so that it touches the ground and is not inside it, m; negative: it is above the ground. */
  lift: number;
  /** Id of the prop that needs this lift; null: the floor. */
  prop: string | null;
}

const heights_of_field = new WeakMap<HeightFieldSurface, Float32Array>();

/** Height of a field at a point of its frame, m; null: beside the field. Its cells have the same triangles as in simulation. */
export function field_height(field: HeightFieldSurface, x: number, y: number): number | null {
  let heights = heights_of_field.get(field);
  if (!heights) {
    heights = new Float32Array(unpack(field.heights));
    heights_of_field.set(field, heights);
  }
  const { columns, rows } = field;
  const [u, v] = [0.5 * (x / field.half_x + 1) * (columns - 1), 0.5 * (y / field.half_y + 1) * (rows - 1)];
  if (!(u >= 0 && u <= columns - 1 && v >= 0 && v <= rows - 1)) return null;
  const [c, r] = [Math.min(Math.floor(u), columns - 2), Math.min(Math.floor(v), rows - 2)];
  const at = (i: number, j: number): number => heights[(r + j) * columns + c + i]!;
  const [du, dv] = [u - c, v - r];
  return du >= dv ? at(0, 0) + du * (at(1, 0) - at(0, 0)) + dv * (at(1, 1) - at(1, 0)) : at(0, 0) + dv * (at(0, 1) - at(0, 0)) + du * (at(1, 1) - at(0, 1));
}

interface UprightField {
  field: HeightFieldSurface;
  inverse: THREE.Matrix4;
  z: number;
}

/** The upright height fields of a body. */
function upright_fields({ mechanism, links }: DrawnBody): UprightField[] {
  const out: UprightField[] = [];
  links.forEach((mesh, i) => {
    for (const shape of (mesh && mechanism.links[i]?.shapes) ?? []) {
      const field = shape.surface === undefined ? undefined : mechanism.surfaces?.[shape.surface];
      if (!field || 'vertices' in field) continue;
      const [x = 0, y = 0, z = 0, qw = 1, qx = 0, qy = 0, qz = 0] = shape.pose;
      const matrix = new THREE.Matrix4().compose(new THREE.Vector3(x, y, z), new THREE.Quaternion(qx, qy, qz, qw), new THREE.Vector3(1, 1, 1)).premultiply(mesh!.matrixWorld);
      if (matrix.elements[10]! < 1 - 1e-9) continue;
      out.push({ field, inverse: matrix.clone().invert(), z: matrix.elements[14]! });
    }
  });
  return out;
}

/**
 * How a body stands on the ground. Upright height fields are compared with all vertices of the body. Of other props, the surfaces below the body's middle
 * are compared with the lowest vertex of each link.
 * @param props the props that do not move, by id  @param floor height of the floor, m
 */
export function standing(body: DrawnBody, props: ReadonlyMap<string, DrawnBody>, floor: number): Standing | null {
  const box = new THREE.Box3();
  const vertices: THREE.Vector3[] = [];
  const lowest: THREE.Vector3[] = [];
  for (const mesh of body.links) {
    if (!mesh) continue;
    const points = mesh.geometry.getAttribute('position');
    let low: THREE.Vector3 | null = null;
    for (let k = 0; k < points.count; k++) {
      const p = new THREE.Vector3().fromBufferAttribute(points, k).applyMatrix4(mesh.matrixWorld);
      vertices.push(p);
      box.expandByPoint(p);
      if (!low || p.z < low.z) low = p;
    }
    if (low) lowest.push(low);
  }
  if (box.isEmpty()) return null;
  const out: Standing = { lift: floor - box.min.z, prop: null };
  const found = (prop: string, lift: number): void => {
    if (lift > out.lift) Object.assign(out, { lift, prop });
  };
  const middle = 0.5 * (box.min.z + box.max.z);
  const ray = new THREE.Raycaster();
  const down = new THREE.Vector3(0, 0, -1);
  const local = new THREE.Vector3();
  for (const [id, prop] of props) {
    const fields = upright_fields(prop);
    for (const { field, inverse, z } of fields)
      for (const p of vertices) {
        local.copy(p).applyMatrix4(inverse);
        const height = field_height(field, local.x, local.y);
        if (height !== null) found(id, z + height - p.z);
      }
    if (fields.length > 0) continue;
    const meshes = prop.links.filter((mesh) => mesh !== null);
    for (const p of lowest) {
      if (p.z > middle) continue;
      ray.set(local.set(p.x, p.y, middle), down);
      const hit = ray.intersectObjects(meshes, false)[0];
      if (hit) found(id, hit.point.z - p.z);
    }
  }
  return out;
}
