import * as THREE from 'three';
import { expect, test } from 'vitest';
import type { SkinData } from '../src/core/protocol';
import { SkinView } from '../src/view/skin_view';

const pack = (values: Float32Array | Uint16Array | Uint32Array): string => btoa(String.fromCharCode(...new Uint8Array(values.buffer)));

/** Three vertices: the first follows bone 0 (on link 1), the second bone 1 (on link 0, scaled by 2), the third both by a quarter and three quarters. */
const skin: SkinData = {
  positions: pack(new Float32Array([1, 0, 0, 0, 1, 0, 0, 0, 1])),
  normals: pack(new Float32Array([0, 0, 1, 0, 0, 1, 0, 0, 1])),
  uvs: pack(new Float32Array(6)),
  bones: pack(new Uint16Array([0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0])),
  weights: pack(new Uint16Array([65535, 0, 0, 0, 65535, 0, 0, 0, 16384, 49151, 0, 0])),
  indices: pack(new Uint32Array([0, 1, 2])),
  parts: [{ color: '#ff8000', texture: -1, first: 0, count: 3, cutoff: 0, both_sides: true }],
  textures: [],
  links: [1, 0],
  matrices: [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, -1],
};

test('vertices are at the weighted sum of what their bones give', () => {
  const view = new SkinView(skin);
  const h = Math.SQRT1_2;
  // link 0 at (0, 0, 3); link 1 at (1, 2, 0), turned by 90 degrees about z
  view.place([0, 0, 3, 1, 0, 0, 0, 1, 2, 0, h, 0, 0, h]);
  const at = (i: number): number[] => view.vertex(i, new THREE.Vector3()).toArray();
  const near = (got: number[], wanted: number[]): void => wanted.forEach((w, k) => expect(got[k]).toBeCloseTo(w, 4));
  near(at(0), [1, 3.5, 0]); // (1.5, 0, 0) in link 1
  near(at(1), [0, 2, 2]); // (0, 2, -1) in link 0
  const [a, b] = [[1, 2.5, 1], [0, 0, 4]];
  near(at(2), a.map((x, k) => 0.25 * x + 0.75 * b[k]!));
});

test('a skin through which the body is seen casts no shadow', () => {
  const view = new SkinView(skin);
  view.set_look({ shown: 'both' });
  expect(view.mesh.material[0]!.transparent).toBe(true);
  expect(view.mesh.castShadow).toBe(false);
  view.set_look({ roughness: 0.2 });
  expect(view.mesh.material[0]!.transparent).toBe(false);
  expect(view.mesh.material[0]!.roughness).toBe(0.2);
});

test('the triangles of a mirrored skin are seen from outside', () => {
  const mirrored = { ...skin, matrices: skin.matrices.map((x, i) => (i % 12 >= 4 && i % 12 < 8 ? -x : x)) };
  expect([...new SkinView(mirrored).mesh.geometry.index!.array]).toEqual([1, 0, 2]);
});

test('the spheres of a skin contain its vertices in every pose', () => {
  const view = new SkinView(skin);
  const h = Math.SQRT1_2;
  for (const poses of [[0, 0, 3, 1, 0, 0, 0, 1, 2, 0, h, 0, 0, h], [5, 0, 0, h, 0, h, 0, 4, 4, 4, 1, 0, 0, 0]]) {
    view.place(poses);
    const box = new THREE.Box3();
    for (const { center, radius } of view.spheres) box.expandByPoint(center.clone().addScalar(radius)).expandByPoint(center.clone().subScalar(radius));
    for (let i = 0; i < 3; i++) expect(box.distanceToPoint(view.vertex(i, new THREE.Vector3()))).toBeLessThan(1e-6);
    expect(box.getSize(new THREE.Vector3()).length()).toBeLessThan(20);
  }
});
