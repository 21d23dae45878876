import * as THREE from 'three';
import { describe, expect, it } from 'vitest';
import { shadow_rectangle, sphere_of } from '../src/view/floor';

describe('shadow_rectangle', () => {
  it('contains the shadows of all bodies and little more', () => {
    const to_light = new THREE.Vector3(2.6, 3.4, 6.8).normalize();
    const bodies = [0, 1, 2, 3].map((i) => {
      const body = new THREE.Mesh(i % 2 ? new THREE.BoxGeometry(0.2, 0.5, 0.1) : new THREE.CapsuleGeometry(0.06, 0.4));
      body.position.set(-2 + i, 0.7 * i - 1.5, 0.4 * i + 0.3);
      body.rotation.set(i, 2 * i, 0.3);
      body.updateMatrixWorld();
      return body;
    });
    const box = new THREE.Box2();
    const point = new THREE.Vector3();
    for (const body of bodies) {
      const at = body.geometry.getAttribute('position');
      for (let i = 0; i < at.count; i++) {
        point.fromBufferAttribute(at, i).applyMatrix4(body.matrixWorld);
        point.addScaledVector(to_light, -point.z / to_light.z); // along the ray of light onto the floor
        box.expandByPoint(new THREE.Vector2(point.x, point.y));
      }
    }
    const { left, right, front, back } = shadow_rectangle(bodies.map(sphere_of), to_light, 0.01);
    const margins = [box.min.x - left, right - box.max.x, box.min.y - front, back - box.max.y];
    // 0.01 m is the given softness; 0.4 m: bounding spheres are larger than bodies
    for (const margin of margins) expect(margin).toBeGreaterThan(0.01);
    for (const margin of margins) expect(margin).toBeLessThan(0.4);
  });
});
