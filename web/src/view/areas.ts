/** The areas of a picture in which objects are drawn. Only there does a picture need several samples a pixel for smooth edges. */
import * as THREE from 'three';

/** A rectangle of pixels; x and y count from the lower left corner, as in WebGL. */
export interface Area {
  left: number;
  bottom: number;
  right: number;
  top: number;
}

const margin = 2; // px: rounding of corners to pixels
const nearest = 1e-3; // smallest depth in front of the camera that is drawn, m; smaller than the near distance of every camera

const floor_margin = 1e-3; // m: a body whose lowest point is higher than this is not below the floor
const smallest_tile = 32; // px
const area_cost = 10_000; // px: each area has its own calls of WebGL, which take about the time of this many pixels

const size = (a: Area): number => (a.right - a.left) * (a.top - a.bottom);
/** The smallest area that contains both. */
export const join = (a: Area, b: Area): Area => ({
  left: Math.min(a.left, b.left),
  bottom: Math.min(a.bottom, b.bottom),
  right: Math.max(a.right, b.right),
  top: Math.max(a.top, b.top),
});

/** The vertices of a skinned surface that the same bones move: their box in the coordinates of the rest pose. */
interface Part {
  bones: number[];
  box: THREE.Box3;
}
const parts_of_surfaces = new WeakMap<THREE.BufferGeometry, Part[]>();

function parts_of(geometry: THREE.BufferGeometry): Part[] {
  const known = parts_of_surfaces.get(geometry);
  if (known) return known;
  const parts = new Map<string, Part>();
  const { position, skinIndex, skinWeight } = geometry.attributes as Record<string, THREE.BufferAttribute>;
  const point = new THREE.Vector3();
  for (let i = 0; i < position!.count; i++) {
    const bones = [0, 1, 2, 3].filter((k) => skinWeight!.getComponent(i, k) > 0).map((k) => skinIndex!.getComponent(i, k));
    const name = bones.sort((one, other) => one - other).join();
    let part = parts.get(name);
    if (!part) parts.set(name, (part = { bones, box: new THREE.Box3() }));
    part.box.expandByPoint(point.fromBufferAttribute(position!, i));
  }
  const out = [...parts.values()];
  parts_of_surfaces.set(geometry, out);
  return out;
}

/** Returns true if a box reaches below the floor (z = 0), or almost. */
function sinks({ min, max }: THREE.Box3, { elements: e }: THREE.Matrix4): boolean {
  const along = (row: number, low: number, high: number): number => Math.min(e[row]! * low, e[row]! * high);
  return e[14]! + along(2, min.x, max.x) + along(6, min.y, max.y) + along(10, min.z, max.z) < floor_margin;
}

/** Boxes whose convex hull contains a part of an object, and the matrix from each box to the world. */
type Hull = readonly (readonly [box: THREE.Box3, to_world: THREE.Matrix4])[];

/** Hulls that contain the object together; null if no bounds are known. */
function hulls_of(object: THREE.Object3D): Hull[] | null {
  const { geometry } = object as THREE.Mesh;
  if (object instanceof THREE.SkinnedMesh) {
    // A vertex lies in the convex hull of the positions that its bones give it.
    const { bones, boneInverses } = object.skeleton;
    const to_world = bones.map((bone, i) => new THREE.Matrix4().multiplyMatrices(bone.matrixWorld, boneInverses[i]!).multiply(object.bindMatrix));
    return object.bindMode === THREE.DetachedBindMode ? parts_of(geometry).map((part) => part.bones.map((bone) => [part.box, to_world[bone]!])) : null;
  }
  if (object instanceof THREE.InstancedMesh) return object.count === 0 ? [] : null;
  if (!object.frustumCulled) return null;
  if (!geometry.boundingBox) geometry.computeBoundingBox();
  return [[[geometry.boundingBox!, object.matrixWorld]]];
}

/**
 * Areas that contain every visible mesh, line and point of a scene. World matrices must be up to date.
 * @param without objects that are left out, with everything in them  @param width, height size of the picture, px
 * @param sunken true: the areas contain only what is below the floor (z = 0)
 * @return areas within the picture, which may overlap; the whole picture if the bounds of an object are not known
 */
export function drawn_areas(scene: THREE.Object3D, without: readonly THREE.Object3D[], camera: THREE.Camera, width: number, height: number, sunken = false): Area[] {
  const areas: Area[] = [];
  const to_clip = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  const matrix = new THREE.Matrix4();
  const corners = Array.from({ length: 8 }, () => new THREE.Vector4());
  const at = new THREE.Vector4();
  let area: Area = { left: 0, bottom: 0, right: 0, top: 0 };
  const take = (box: THREE.Box3, to_world: THREE.Matrix4): void => {
    matrix.multiplyMatrices(to_clip, to_world);
    corners.forEach((c, i) => c.set(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z, 1).applyMatrix4(matrix));
    const contain = ({ x, y, w }: THREE.Vector4): void => {
      area.left = Math.min(area.left, (0.5 + (0.5 * x) / w) * width);
      area.right = Math.max(area.right, (0.5 + (0.5 * x) / w) * width);
      area.bottom = Math.min(area.bottom, (0.5 + (0.5 * y) / w) * height);
      area.top = Math.max(area.top, (0.5 + (0.5 * y) / w) * height);
    };
    for (const [i, c] of corners.entries()) {
      if (c.w >= nearest) contain(c);
      for (const bit of [1, 2, 4]) {
        const d = corners[i | bit]!; // the edge from c to d
        if (c.w < nearest !== d.w < nearest) contain(at.lerpVectors(c, d, (nearest - c.w) / (d.w - c.w)));
      }
    }
  };
  const keep = ({ left, bottom, right, top }: Area): void => {
    const kept = { left: Math.max(0, Math.floor(left) - margin), bottom: Math.max(0, Math.floor(bottom) - margin), right: Math.min(width, Math.ceil(right) + margin), top: Math.min(height, Math.ceil(top) + margin) };
    if (kept.left < kept.right && kept.bottom < kept.top) areas.push(kept);
  };
  let known = true;
  const visit = (object: THREE.Object3D): void => {
    if (!object.visible || without.includes(object)) return;
    const drawable = object instanceof THREE.Mesh || object instanceof THREE.Line || object instanceof THREE.Points;
    if (drawable && object.layers.test(camera.layers)) {
      const hulls = hulls_of(object);
      if (!hulls) known = false;
      for (const hull of hulls ?? []) {
        if (sunken && !hull.some((box) => sinks(...box))) continue;
        area = { left: Infinity, bottom: Infinity, right: -Infinity, top: -Infinity };
        for (const box of hull) take(...box);
        keep(area);
      }
    }
    for (const child of object.children) visit(child);
  };
  visit(scene);
  return known ? areas : [{ left: 0, bottom: 0, right: width, top: height }];
}

/** Disjoint rectangles that contain the areas and little more: tiles in which an area lies, joined to at most `max_count` rectangles. */
export function tile_areas(areas: readonly Area[], width: number, height: number, max_count: number, edge = smallest_tile): Area[] {
  const [columns, rows] = [Math.ceil(width / edge), Math.ceil(height / edge)];
  const used = new Uint8Array(columns * rows);
  for (const { left, bottom, right, top } of areas)
    for (let row = Math.floor(bottom / edge); row * edge < top; row++) used.fill(1, columns * row + Math.floor(left / edge), columns * row + Math.ceil(right / edge));
  const out: Area[] = [];
  let below: Area[] = []; // rectangles that reach to the present row
  for (let row = 0; row < rows; row++) {
    const top = Math.min(height, (row + 1) * edge);
    const reached: Area[] = [];
    for (let begin = 0; begin < columns; begin++) {
      if (!used[columns * row + begin]) continue;
      let end = begin + 1;
      while (end < columns && used[columns * row + end]) end++;
      const [left, right] = [begin * edge, Math.min(width, end * edge)];
      begin = end;
      let area = below.find((a) => a.left === left && a.right === right);
      if (area) area.top = top;
      else out.push((area = { left, bottom: row * edge, right, top }));
      reached.push(area);
    }
    below = reached;
  }
  return out.length <= max_count ? out : tile_areas(areas, width, height, max_count, 2 * edge);
}

/** Joins areas that meet, and areas whose common rectangle is little larger than both. @return disjoint areas */
export function join_areas(areas: readonly Area[]): Area[] {
  const out: Area[] = [];
  for (let next of areas) {
    for (let i = 0; i < out.length; i++) {
      const a = out[i]!;
      const both = join(a, next);
      const apart = a.left >= next.right || a.right <= next.left || a.bottom >= next.top || a.top <= next.bottom;
      if (apart && size(both) > size(a) + size(next) + area_cost) continue;
      next = both;
      out.splice(i, 1);
      i = -1; // the larger area may meet areas that were passed over
    }
    out.push(next);
  }
  return out;
}
