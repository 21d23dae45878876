import * as THREE from 'three';
import { describe, expect, it } from 'vitest';
import { LinkSkeleton } from '../src/view/skinning';

describe('LinkSkeleton', () => {
  it('stores three rows of the matrix of each bone, in several rows of the texture if there are many bones', () => {
    for (const count of [1, 22, 341, 342, 700]) {
      const matrix = (seed: number) => new THREE.Matrix4().compose(new THREE.Vector3(seed, 2, -seed), new THREE.Quaternion(1, seed, 2, 3).normalize(), new THREE.Vector3(1, 1, 1));
      const bones = Array.from({ length: count }, (_, i) => {
        const bone = new THREE.Bone();
        bone.matrixWorld.copy(matrix(i));
        return bone;
      });
      const skeleton = new LinkSkeleton(bones, bones.map((_, i) => matrix(i + 0.5).invert()));
      skeleton.update();
      const { image } = skeleton.boneTexture!;
      expect(image.width).toBeLessThanOrEqual(1024);
      expect(image.data!.length).toBe(4 * image.width * image.height);
      for (const bone of [0, count - 1]) {
        const texel = (i: number): THREE.Vector4 => {
          const at = 4 * ((i % 1024) + image.width * Math.floor(i / 1024));
          return new THREE.Vector4(...(image.data!.slice(at, at + 4) as unknown as [number, number, number, number]));
        };
        const point = new THREE.Vector3(0.1, 0.2, 0.3);
        const moved = [0, 1, 2].map((row) => texel(3 * bone + row).dot(new THREE.Vector4(point.x, point.y, point.z, 1)));
        const wanted = point.clone().applyMatrix4(matrix(bone + 0.5).invert()).applyMatrix4(matrix(bone));
        expect(new THREE.Vector3(...(moved as [number, number, number])).distanceTo(wanted)).toBeLessThan(1e-4);
      }
    }
  });
});
