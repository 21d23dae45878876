import * as THREE from 'three';
import { describe, expect, it } from 'vitest';
import { surface_at } from '../src/view/far_surface';

const renderer = (height: number): THREE.WebGLRenderer => ({ getRenderTarget: () => null, getSize: (out: THREE.Vector2) => out.set(2 * height, height) }) as unknown as THREE.WebGLRenderer;
const shown = { start: 0, count: 30 };
const coarser = [0.005, 0.01, 0.02].map((error, i) => ({ start: 30 + 3 * i, count: 3, error }));
/** Deviation of the surface that is drawn, m; 0: the finest. */
const error_at = (height: number, camera: THREE.Camera, distance: number): number => (surface_at(renderer(height), camera, { shown, coarser }, distance) as { error?: number }).error ?? 0;

describe('the coarser surfaces of bodies', () => {
  it('are drawn if they deviate by less than a pixel at the nearest body', () => {
    const camera = new THREE.PerspectiveCamera(90, 1, 0.1, 100); // at 5 m, 10 m are visible: 10 mm a pixel of 1000
    expect(error_at(1000, camera, 2.4)).toBe(0);
    expect(error_at(1000, camera, 2.6)).toBe(0.005);
    expect(error_at(1000, camera, 4.9)).toBe(0.005);
    expect(error_at(1000, camera, 5.1)).toBe(0.01);
    expect(error_at(1000, camera, 100)).toBe(0.02);
    expect(error_at(2000, camera, 5.1)).toBe(0.005);
  });

  it('do not depend on the distance for an orthographic camera, whose zoom counts', () => {
    const camera = new THREE.OrthographicCamera(-5.1, 5.1, 5.1, -5.1);
    for (const distance of [0.1, 50]) expect(error_at(1000, camera, distance)).toBe(0.01);
    camera.zoom = 2;
    camera.updateProjectionMatrix();
    expect(error_at(1000, camera, 5)).toBe(0.005);
  });

  it('are not drawn if there are none', () => {
    expect(surface_at(renderer(1000), new THREE.PerspectiveCamera(), { shown, coarser: [] }, 100)).toBe(shown);
  });
});
