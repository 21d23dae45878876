import * as THREE from 'three';
import { describe, expect, it } from 'vitest';
import { Floor, sphere_of } from '../src/view/floor';
import { FloorLines, line_count } from '../src/view/floor_lines';
import { outline_corners, shadow_outline } from '../src/view/shadow_outline';

describe('shadow_outline', () => {
  it('contains the shadows of all bodies and little more', () => {
    const to_light = new THREE.Vector3(2.6, 3.4, 6.8).normalize();
    const bodies = [0, 1, 2, 3].map((i) => {
      const body = new THREE.Mesh(i % 2 ? new THREE.BoxGeometry(0.2, 0.5, 0.1) : new THREE.CapsuleGeometry(0.06, 0.4));
      body.position.set(-2 + i, 0.7 * i - 1.5, 0.4 * i + 0.3);
      body.rotation.set(i, 2 * i, 0.3);
      body.updateMatrixWorld();
      return body;
    });
    const shadows: THREE.Vector2[] = [];
    const point = new THREE.Vector3();
    for (const body of bodies) {
      const at = body.geometry.getAttribute('position');
      for (let i = 0; i < at.count; i++) {
        point.fromBufferAttribute(at, i).applyMatrix4(body.matrixWorld);
        point.addScaledVector(to_light, -point.z / to_light.z); // along the ray of light onto the floor
        shadows.push(new THREE.Vector2(point.x, point.y));
      }
    }
    const outline = shadow_outline(bodies.map(sphere_of), to_light, 0.01);
    const corners = Array.from({ length: outline_corners }, (_, i) => new THREE.Vector2(outline[2 * i], outline[2 * i + 1]));
    corners.forEach((corner, i) => {
      const next = corners[(i + 1) % outline_corners]!;
      const outward = new THREE.Vector2(next.y - corner.y, corner.x - next.x).normalize();
      const margin = Math.min(...shadows.map((shadow) => corner.clone().sub(shadow).dot(outward)));
      expect(margin, `side ${i}`).toBeGreaterThan(0.01); // the given softness
      expect(margin, `side ${i}`).toBeLessThan(0.4); // bounding spheres are larger than bodies
    });
    // the bodies are in a row: the smallest rectangle along x and y is much larger
    const area = corners.reduce((sum, corner, i) => sum + 0.5 * corner.cross(corners[(i + 1) % outline_corners]!), 0);
    const box = new THREE.Box2().setFromPoints(corners);
    const size = box.getSize(new THREE.Vector2());
    expect(area).toBeGreaterThan(0);
    expect(area).toBeLessThan(0.7 * size.x * size.y);
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
