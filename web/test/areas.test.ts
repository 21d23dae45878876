import * as THREE from 'three';
import { describe, expect, it } from 'vitest';
import { drawn_areas, join_areas, tile_areas, type Area } from '../src/view/areas';

const width = 800;
const height = 600;

/** Pseudo-random numbers in 0 ... 1 (linear congruence of Knuth). */
function* random(seed: number): Generator<number, never> {
  for (let s = seed; ; ) {
    s = (s * 1664525 + 1013904223) % 2 ** 32;
    yield s / 2 ** 32;
  }
}
const inside = (areas: readonly Area[], x: number, y: number): number => areas.filter((a) => x >= a.left && x < a.right && y >= a.bottom && y < a.top).length;

function camera_at(x: number, y: number, z: number): THREE.PerspectiveCamera {
  const camera = new THREE.PerspectiveCamera(40, width / height, 0.01, 100);
  camera.up.set(0, 0, 1);
  camera.position.set(x, y, z);
  camera.lookAt(0, 0, 1);
  camera.updateMatrixWorld();
  return camera;
}
/** Pixels in which the surface points of a mesh lie. */
function* pixels(mesh: THREE.Mesh, camera: THREE.Camera): Generator<[number, number]> {
  const at = mesh.geometry.getAttribute('position');
  const point = new THREE.Vector3();
  for (let i = 0; i < at.count; i++) {
    if (mesh instanceof THREE.SkinnedMesh) mesh.getVertexPosition(i, point).applyMatrix4(mesh.matrixWorld);
    else point.fromBufferAttribute(at, i).applyMatrix4(mesh.matrixWorld);
    if (point.clone().applyMatrix4(camera.matrixWorldInverse).z > -0.01) continue; // behind the camera
    point.project(camera);
    const [x, y] = [(0.5 + 0.5 * point.x) * width, (0.5 + 0.5 * point.y) * height];
    if (x >= 0 && y >= 0 && x < width && y < height) yield [x, y];
  }
}
function box_at(x: number, y: number, z: number, length = 0.4): THREE.Mesh {
  const mesh = new THREE.Mesh(new THREE.BoxGeometry(length, 0.3, 0.2, 6, 6, 6));
  mesh.position.set(x, y, z);
  mesh.rotation.set(x, y, z);
  return mesh;
}

describe('drawn_areas', () => {
  it('contains every pixel of meshes, also of those that reach behind the camera', () => {
    const scene = new THREE.Scene();
    const floor = new THREE.Group();
    floor.add(box_at(0, 0, 0, 50));
    const meshes = [box_at(0, 0, 1), box_at(0.9, 0.4, 1.5), box_at(2.9, -2.7, 1.1, 9)];
    scene.add(floor, ...meshes);
    scene.updateMatrixWorld();
    const camera = camera_at(3, -3, 1.6);
    const areas = drawn_areas(scene, [floor], camera, width, height);
    let seen = 0;
    for (const mesh of meshes) for (const [x, y] of pixels(mesh, camera)) expect(inside(areas, x, y), `pixel ${x}, ${y} (${++seen})`).toBeGreaterThan(0);
    expect(seen).toBeGreaterThan(100);
  });
  it('follows the bones of a surface', () => {
    const geometry = new THREE.BoxGeometry(0.2, 0.2, 2, 2, 2, 20);
    const { position } = geometry.attributes;
    const weights: number[] = [];
    for (let i = 0; i < position!.count; i++) weights.push(0.5 - 0.5 * position!.getZ(i), 0.5 + 0.5 * position!.getZ(i), 0, 0);
    geometry.setAttribute('skinIndex', new THREE.Uint16BufferAttribute(weights.map((_, i) => (i % 4 === 1 ? 1 : 0)), 4));
    geometry.setAttribute('skinWeight', new THREE.Float32BufferAttribute(weights, 4));
    const bones = [new THREE.Bone(), new THREE.Bone()];
    const mesh = new THREE.SkinnedMesh(geometry, new THREE.MeshBasicMaterial());
    mesh.bindMode = THREE.DetachedBindMode;
    mesh.bind(new THREE.Skeleton(bones, bones.map(() => new THREE.Matrix4())), new THREE.Matrix4());
    bones[0]!.matrixWorld.makeTranslation(-0.5, 0.3, 1);
    bones[1]!.matrixWorld.makeRotationX(1.2).setPosition(0.6, 0, 1);
    const scene = new THREE.Scene();
    scene.add(mesh);
    const camera = camera_at(2, -4, 1.5);
    const areas = drawn_areas(scene, [], camera, width, height);
    for (const [x, y] of pixels(mesh, camera)) expect(inside(areas, x, y)).toBeGreaterThan(0);
    const covered = areas.reduce((sum, a) => sum + (a.right - a.left) * (a.top - a.bottom), 0);
    expect(covered).toBeLessThan(0.5 * width * height);
  });
  it('is the whole picture if bounds are unknown, and empty if nothing is drawn', () => {
    const scene = new THREE.Scene();
    const mesh = box_at(0, 0, 1);
    mesh.frustumCulled = false;
    scene.add(mesh);
    expect(drawn_areas(scene, [], camera_at(3, 0, 1), width, height)).toEqual([{ left: 0, bottom: 0, right: width, top: height }]);
    mesh.visible = false;
    expect(drawn_areas(scene, [], camera_at(3, 0, 1), width, height)).toEqual([]);
  });
});

describe('areas below the floor', () => {
  it('contain every pixel of what is below the floor, and little more', () => {
    const scene = new THREE.Scene();
    const meshes = [box_at(0, 0, 1), box_at(0.9, 0.4, 0.05), box_at(-0.8, 0.6, -0.3)];
    scene.add(...meshes);
    scene.updateMatrixWorld();
    const camera = camera_at(3, -3, 1.6);
    const areas = drawn_areas(scene, [], camera, width, height, true);
    const point = new THREE.Vector3();
    let seen = 0;
    for (const mesh of meshes) {
      const at = mesh.geometry.getAttribute('position');
      for (let i = 0; i < at.count; i++) {
        if (point.fromBufferAttribute(at, i).applyMatrix4(mesh.matrixWorld).z > 0) continue;
        point.project(camera);
        expect(inside(areas, (0.5 + 0.5 * point.x) * width, (0.5 + 0.5 * point.y) * height)).toBeGreaterThan(0);
        seen++;
      }
    }
    expect(seen).toBeGreaterThan(100);
    for (const [x, y] of pixels(meshes[0]!, camera)) expect(inside(areas, x, y)).toBe(0);
  });
  it('contain the part of a surface between a bone below the floor and one above it', () => {
    const geometry = new THREE.BoxGeometry(0.1, 0.1, 0.1);
    const { count } = geometry.getAttribute('position');
    geometry.setAttribute('skinIndex', new THREE.Uint16BufferAttribute(Array.from({ length: 4 * count }, (_, i) => (i % 4 === 1 ? 1 : 0)), 4));
    geometry.setAttribute('skinWeight', new THREE.Float32BufferAttribute(Array.from({ length: 4 * count }, (_, i) => (i % 4 < 2 ? 0.5 : 0)), 4));
    const bones = [new THREE.Bone(), new THREE.Bone()];
    const mesh = new THREE.SkinnedMesh(geometry, new THREE.MeshBasicMaterial());
    mesh.bindMode = THREE.DetachedBindMode;
    mesh.bind(new THREE.Skeleton(bones, bones.map(() => new THREE.Matrix4())), new THREE.Matrix4());
    bones[0]!.matrixWorld.makeTranslation(-0.5, 0, 0.2);
    bones[1]!.matrixWorld.makeTranslation(0.5, 0, -0.4);
    const scene = new THREE.Scene();
    scene.add(mesh);
    const camera = camera_at(2, -4, 1.5);
    for (const [x, y] of pixels(mesh, camera)) expect(inside(drawn_areas(scene, [], camera, width, height, true), x, y)).toBeGreaterThan(0);
    bones[1]!.matrixWorld.makeTranslation(0.5, 0, 0.4);
    expect(drawn_areas(scene, [], camera, width, height, true)).toEqual([]);
  });
});

describe('tile_areas', () => {
  it('contains each pixel of the given areas exactly once, in at most the given number of rectangles', () => {
    const next = random(5);
    for (const max_count of [1, 6, 64, 1000]) {
      const given = Array.from({ length: 12 }, () => {
        const [left, bottom] = [Math.floor(next.next().value * width), Math.floor(next.next().value * height)];
        return { left, bottom, right: Math.min(width, left + 1 + Math.floor(next.next().value * 90)), top: Math.min(height, bottom + 1 + Math.floor(next.next().value * 90)) };
      });
      const tiles = tile_areas(given, width, height, max_count);
      expect(tiles.length).toBeLessThanOrEqual(max_count);
      for (let y = 0; y < height; y += 3)
        for (let x = 0; x < width; x += 3) {
          const count = inside(tiles, x, y);
          if (inside(given, x, y) > 0) expect(count).toBe(1);
          else if (count > 1) throw new Error(`pixel ${x}, ${y} is in ${count} rectangles`);
        }
      for (const { left, bottom, right, top } of tiles) expect(left >= 0 && bottom >= 0 && right <= width && top <= height && left < right && bottom < top).toBe(true);
    }
  });
  it('leaves out what is far from the areas', () => {
    const [one, other] = [{ left: 100, bottom: 100, right: 120, top: 400 }, { left: 120, bottom: 380, right: 500, top: 400 }];
    const tiles = tile_areas([one, other], width, height, 64);
    const covered = tiles.reduce((sum, a) => sum + (a.right - a.left) * (a.top - a.bottom), 0);
    expect(covered).toBeLessThan(40_000); // the common rectangle has 120,000 pixels
    expect(tile_areas([], width, height, 64)).toEqual([]);
  });
});

describe('join_areas', () => {
  it('contains each pixel of the given areas exactly once', () => {
    const next = random(3);
    for (let round = 0; round < 40; round++) {
      const given = Array.from({ length: 5 }, () => {
        const [left, bottom] = [Math.floor(next.next().value * width), Math.floor(next.next().value * height)];
        return { left, bottom, right: Math.min(width, left + 1 + Math.floor(next.next().value * 300)), top: Math.min(height, bottom + 1 + Math.floor(next.next().value * 200)) };
      });
      const joined = join_areas(given);
      for (let k = 0; k < 400; k++) {
        const [x, y] = [Math.floor(next.next().value * width), Math.floor(next.next().value * height)];
        if (inside(given, x, y) > 0) expect(inside(joined, x, y)).toBe(1);
        else expect(inside(joined, x, y)).toBeLessThan(2);
      }
    }
  });
  it('joins areas only where that costs less', () => {
    const far = [{ left: 0, bottom: 0, right: 100, top: 100 }, { left: 700, bottom: 500, right: 800, top: 600 }];
    expect(join_areas(far)).toHaveLength(2);
    expect(join_areas([far[0]!, { left: 90, bottom: 20, right: 190, top: 120 }])).toEqual([{ left: 0, bottom: 0, right: 190, top: 120 }]);
  });
});
