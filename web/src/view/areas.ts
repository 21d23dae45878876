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

const area_cost = 10_000; // px: each area has its own calls of WebGL, which take about the time of this many pixels

const size = (a: Area): number => (a.right - a.left) * (a.top - a.bottom);
/** The smallest area that contains both. */
export const join = (a: Area, b: Area): Area => ({
  left: Math.min(a.left, b.left),
  bottom: Math.min(a.bottom, b.bottom),
  right: Math.max(a.right, b.right),
  top: Math.max(a.top, b.top),
});

/** Boxes of a skinned surface, one for each bone: the vertices that the bone moves, in the coordinates of the rest pose. */
const bone_boxes = new WeakMap<THREE.BufferGeometry, THREE.Box3[]>();

function boxes_of_bones(geometry: THREE.BufferGeometry, bones: number): THREE.Box3[] {
  const known = bone_boxes.get(geometry);
  if (known) return known;
  const boxes = Array.from({ length: bones }, () => new THREE.Box3());
  const { position, skinIndex, skinWeight } = geometry.attributes as Record<string, THREE.BufferAttribute>;
  const point = new THREE.Vector3();
  for (let i = 0; i < position!.count; i++) {
    point.fromBufferAttribute(position!, i);
    for (let k = 0; k < 4; k++) if (skinWeight!.getComponent(i, k) > 0) boxes[skinIndex!.getComponent(i, k)]?.expandByPoint(point);
  }
  bone_boxes.set(geometry, boxes);
  return boxes;
}

/** Calls `take` with boxes that contain the object, and with the matrix from the box to the world. @return false if no bounds are known */
function each_box(object: THREE.Object3D, take: (box: THREE.Box3, to_world: THREE.Matrix4) => void): boolean {
  const { geometry } = object as THREE.Mesh;
  if (object instanceof THREE.SkinnedMesh) {
    // A vertex lies in the convex hull of the positions that its bones give it.
    const { bones, boneInverses } = object.skeleton;
    const matrix = new THREE.Matrix4();
    boxes_of_bones(geometry, bones.length).forEach((box, i) => {
      if (!box.isEmpty()) take(box, matrix.multiplyMatrices(bones[i]!.matrixWorld, boneInverses[i]!).multiply(object.bindMatrix));
    });
    return object.bindMode === THREE.DetachedBindMode;
  }
  if (object instanceof THREE.InstancedMesh) return object.count === 0;
  if (!object.frustumCulled) return false;
  if (!geometry.boundingBox) geometry.computeBoundingBox();
  take(geometry.boundingBox!, object.matrixWorld);
  return true;
}

/**
 * Areas that contain every visible mesh, line and point of a scene. World matrices must be up to date.
 * @param without objects that are left out, with everything in them  @param width, height size of the picture, px
 * @return disjoint areas within the picture; the whole picture if the bounds of an object are not known
 */
export function drawn_areas(scene: THREE.Object3D, without: readonly THREE.Object3D[], camera: THREE.Camera, width: number, height: number): Area[] {
  const areas: Area[] = [];
  const to_clip = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  const matrix = new THREE.Matrix4();
  const corners = Array.from({ length: 8 }, () => new THREE.Vector4());
  const at = new THREE.Vector4();
  // The bounds of one object. Vertices that follow several bones lie between the boxes of these bones.
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
      area = { left: Infinity, bottom: Infinity, right: -Infinity, top: -Infinity };
      if (!each_box(object, take)) known = false;
      keep(area);
    }
    for (const child of object.children) visit(child);
  };
  visit(scene);
  return known ? join_areas(areas) : [{ left: 0, bottom: 0, right: width, top: height }];
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
