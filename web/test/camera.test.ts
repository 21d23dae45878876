import * as THREE from 'three';
import { describe, expect, it } from 'vitest';
import { CameraRig } from '../src/view/camera';

/** Bounding box of the spheres' outlines in the picture, -1 ... 1, from 4000 points on each sphere. */
function extent(rig: CameraRig, spheres: THREE.Sphere[]): THREE.Box2 {
  const box = new THREE.Box2();
  for (const { center, radius } of spheres)
    for (let i = 0; i < 4000; ++i) {
      const z = 1 - (2 * i + 1) / 4000;
      const turn = i * 2.399963;
      const p = new THREE.Vector3(Math.sqrt(1 - z * z) * Math.cos(turn), Math.sqrt(1 - z * z) * Math.sin(turn), z)
        .multiplyScalar(radius)
        .add(center)
        .project(rig.perspective);
      box.expandByPoint(new THREE.Vector2(p.x, p.y));
    }
  return box;
}

describe('framing', () => {
  const scenes: THREE.Sphere[][] = [
    [new THREE.Sphere(new THREE.Vector3(0, 0, 1), 1)],
    [0, 3, 6, 9].map((x) => new THREE.Sphere(new THREE.Vector3(x, 0, 0.9), 0.4)),
    [new THREE.Sphere(new THREE.Vector3(-4, 5, 1), 0.1), new THREE.Sphere(new THREE.Vector3(6, -2, 3), 1.5)],
  ];
  for (const aspect of [0.6, 1.8, 2.6])
    for (const [azimuth, elevation] of [[0, 0.2], [0.7, 0.22], [2.5, 1.2]] as const)
      scenes.forEach((spheres, i) =>
        it(`scene ${i}, aspect ${aspect}, from ${azimuth}, ${elevation}: everything is in the picture and fills it`, () => {
          const rig = new CameraRig();
          rig.resize(aspect);
          rig.look_from(azimuth, elevation);
          rig.frame(spheres);
          rig.set({}, true);
          const { min, max } = extent(rig, spheres);
          for (const value of [-min.x, -min.y, max.x, max.y]) expect(value).toBeLessThan(0.83);
          // in the tighter direction the spheres fill the picture up to the border, and are centred
          const [wide, high] = [max.x - min.x, max.y - min.y];
          expect(Math.max(wide, high)).toBeGreaterThan(1.6);
          const middle = wide > high ? max.x + min.x : max.y + min.y;
          expect(Math.abs(middle)).toBeLessThan(0.02);
        }),
      );
  it('does not move the camera without spheres', () => {
    const rig = new CameraRig();
    rig.frame([]);
    rig.set({}, true);
    expect(rig.current.distance).toBe(5);
  });
});

describe('orbiting', () => {
  const settle = (rig: CameraRig): void => {
    for (let i = 0; i < 200; i++) rig.update(0.05);
  };
  it('keeps the camera above the floor', () => {
    const rig = new CameraRig();
    for (let i = 0; i < 400; i++) rig.orbit(0, -10);
    settle(rig);
    expect(rig.perspective.position.z).toBeCloseTo(0.05, 2);
  });
  it('leaves a camera below the floor where a view from below put it', () => {
    const rig = new CameraRig();
    rig.look_from(0, -1.4);
    settle(rig);
    rig.orbit(40, 0);
    settle(rig);
    expect(rig.current.elevation).toBeCloseTo(-1.4, 3);
  });
});

describe('following', () => {
  it('does not move the view when another character is followed, and then moves along with it', () => {
    const rig = new CameraRig();
    rig.set({}, true);
    rig.follow(new THREE.Vector3(0, 0, 1), 'a');
    rig.update(0.05);
    const before = rig.current.target.x;
    rig.follow(new THREE.Vector3(5, 0, 1), 'b');
    for (let i = 0; i < 100; i++) rig.update(0.05);
    expect(rig.current.target.x).toBeCloseTo(before, 6);
    rig.follow(new THREE.Vector3(6, 0, 1), 'b');
    for (let i = 0; i < 100; i++) rig.update(0.05);
    expect(rig.current.target.x).toBeCloseTo(before + 1, 2);
  });
});
