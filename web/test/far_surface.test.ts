import * as THREE from 'three';
import { describe, expect, it } from 'vitest';
import { is_far } from '../src/view/far_surface';

const renderer = (height: number): THREE.WebGLRenderer => ({ getRenderTarget: () => null, domElement: { height } }) as unknown as THREE.WebGLRenderer;

describe('the coarser surface of bodies', () => {
  it('is drawn if it deviates by less than a pixel at the nearest body', () => {
    const camera = new THREE.PerspectiveCamera(90, 1, 0.1, 100); // at 5 m, 10 m are visible: 10 mm a pixel of 1000
    expect(is_far(renderer(1000), camera, 0.0099, 5)).toBe(true);
    expect(is_far(renderer(1000), camera, 0.0101, 5)).toBe(false);
    expect(is_far(renderer(2000), camera, 0.0099, 5)).toBe(false);
    expect(is_far(renderer(1000), camera, 0.0099, 2.5)).toBe(false);
  });

  it('does not depend on the distance for an orthographic camera, whose zoom counts', () => {
    const camera = new THREE.OrthographicCamera(-5, 5, 5, -5);
    for (const distance of [0.1, 50]) {
      expect(is_far(renderer(1000), camera, 0.0099, distance)).toBe(true);
      expect(is_far(renderer(1000), camera, 0.0101, distance)).toBe(false);
    }
    camera.zoom = 2;
    camera.updateProjectionMatrix();
    expect(is_far(renderer(1000), camera, 0.0099, 5)).toBe(false);
  });
});
