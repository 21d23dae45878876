import * as THREE from 'three';
import { describe, expect, it } from 'vitest';
import { Floor } from '../src/view/floor';

describe('Floor', () => {
  it('reads shadows in all cells of the shadow map that contain a body, and not in empty cells', () => {
    const scene = new THREE.Scene();
    const floor = new Floor();
    const light = new THREE.DirectionalLight();
    light.castShadow = true;
    light.position.set(2.6, 3.4, 7.4);
    Object.assign(light.shadow.camera, { left: -4, right: 4, top: 4, bottom: -4, near: 0.5, far: 22 });
    light.shadow.camera.updateProjectionMatrix();
    scene.add(floor.mesh, light, light.target);
    const bodies = [0, 1, 2, 3].map((i) => {
      const body = new THREE.Mesh(i % 2 ? new THREE.BoxGeometry(0.2, 0.5, 0.1) : new THREE.CapsuleGeometry(0.06, 0.4));
      body.position.set(-2 + i, 0.7 * i - 1.5, 0.4 * i);
      body.rotation.set(i, 2 * i, 0.3);
      body.castShadow = i !== 3;
      scene.add(body);
      return body;
    });
    scene.updateMatrixWorld(true);
    light.shadow.updateMatrices(light);
    const draw = floor.mesh.onBeforeRender as unknown as (renderer: null, scene: THREE.Scene) => void;
    draw(null, scene);
    const { image } = (floor.mesh.material as THREE.ShaderMaterial).uniforms.u_casters!.value as THREE.DataTexture;
    const marks = image.data as Uint8Array;
    const inside = (body: THREE.Mesh): number => {
      const at = body.geometry.getAttribute('position');
      const point = new THREE.Vector3();
      let marked = 0;
      for (let i = 0; i < at.count; i++) {
        point.fromBufferAttribute(at, i).applyMatrix4(body.matrixWorld).applyMatrix4(light.shadow.matrix);
        if (marks[Math.floor(point.y * image.height) * image.width + Math.floor(point.x * image.width)]! > 0) marked++;
      }
      return marked / at.count;
    };
    expect(bodies.map(inside)).toEqual([1, 1, 1, 0]); // the last body casts no shadow
    expect(marks.filter((m) => m > 0).length).toBeLessThan(0.1 * marks.length);
  });
});
