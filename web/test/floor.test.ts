import * as THREE from 'three';
import { describe, expect, it } from 'vitest';
import { Floor, shadow_rectangle, sphere_of } from '../src/view/floor';
import { FloorLines, line_count } from '../src/view/floor_lines';

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

describe('FloorLines', () => {
  const strips = (lines: FloorLines): number => lines.mesh.geometry.instanceCount;

  it('draws all lines of the visible part of the floor, and not more than can be distinguished', () => {
    expect(line_count(14)).toBe(9); // visible up to 8.4 m
    expect(line_count(1e6)).toBe(1000);
    const lines = new FloorLines({});
    lines.set_reach(14);
    expect(strips(lines)).toBe(2 * 19);
  });

  it('are shown with the pattern grid only, and not while the floor is drawn into the depth buffer', () => {
    const floor = new Floor();
    const lines = floor.object.children.find((mesh) => (mesh as THREE.Mesh).geometry instanceof THREE.InstancedBufferGeometry)!;
    const color = new THREE.Color();
    for (const [pattern, shown] of [['grid', true], ['boards', false], ['unknown', true]] as const) {
      floor.set_colors(color, color, color, 0.3, pattern);
      floor.draw_as('depth');
      expect(lines.visible).toBe(false);
      floor.draw_as('whole');
      expect(lines.visible).toBe(shown);
    }
  });
});
