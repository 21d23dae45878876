import * as THREE from 'three';
import { describe, expect, it } from 'vitest';
import { ShadowRegion } from '../src/view/shadow_region';

const size = 512;
function light_at(x: number, y: number, z: number): THREE.DirectionalLight {
  const light = new THREE.DirectionalLight();
  light.position.set(x, y, z);
  Object.assign(light.shadow.camera, { left: -3, right: 3, top: 3, bottom: -3, near: 0.5, far: 20 });
  light.shadow.camera.updateProjectionMatrix();
  light.shadow.mapSize.setScalar(size);
  light.updateMatrixWorld();
  light.target.updateMatrixWorld();
  return light;
}

describe('the region of a shadow map', () => {
  it('contains the bodies of this frame and of the last, and little more', () => {
    const light = light_at(2, 3, 6);
    const region = new ShadowRegion();
    const frames = [[new THREE.Sphere(new THREE.Vector3(0.4, 0.2, 1), 0.3)], [new THREE.Sphere(new THREE.Vector3(-0.9, 0.3, 0.5), 0.2)], []];
    region.limit(light, frames[0]!); // three.js makes the map in this frame, and clears all of it
    const map = (light.shadow.map = new THREE.WebGLRenderTarget(size, size));
    region.limit(light, frames[0]!);
    expect(map.scissorTest).toBe(false);
    for (const spheres of frames.slice(1)) {
      region.limit(light, spheres);
      const last = frames[frames.indexOf(spheres) - 1]!;
      const { x, y, z: width, w: height } = map.scissor;
      expect(map.scissorTest).toBe(true);
      for (const { center, radius } of [...spheres, ...last])
        for (let k = 0; k < 200; k++) {
          // points of the sphere, through the projection of the light
          const way = new THREE.Vector3(Math.sin(k), Math.cos(3.1 * k), Math.sin(1.7 * k)).normalize().multiplyScalar(radius).add(center).project(light.shadow.camera);
          const [u, v] = [(0.5 + 0.5 * way.x) * size, (0.5 + 0.5 * way.y) * size];
          expect(u >= x && u <= x + width && v >= y && v <= y + height).toBe(true);
        }
      expect(width * height).toBeLessThan(0.15 * size * size);
    }
    region.limit(light, []);
    expect(map.scissor.z * map.scissor.w).toBe(0);
  });
  it('is the whole map after a reset', () => {
    const light = light_at(1, 1, 5);
    const region = new ShadowRegion();
    light.shadow.map = new THREE.WebGLRenderTarget(size, size);
    region.limit(light, []);
    region.limit(light, []);
    expect(light.shadow.map.scissorTest).toBe(true);
    region.reset();
    region.limit(light, []);
    expect(light.shadow.map.scissorTest).toBe(false);
  });
});
