/** When bodies are drawn with the coarser of their surfaces. */
import * as THREE from 'three';

const far_pixels = 1; // the coarser surface is drawn if it deviates by less, px

/** Height of a pixel at a distance from the camera, m. An orthographic camera shows all distances alike. */
function pixel_size(renderer: THREE.WebGLRenderer, camera: THREE.Camera, distance: number): number {
  const height = (renderer.getRenderTarget() ?? renderer.domElement).height;
  const depth = camera instanceof THREE.OrthographicCamera ? 1 : distance;
  return (2 * depth) / (camera.projectionMatrix.elements[5]! * Math.max(1, height));
}

/**
 * Whether bodies are so far away that the coarser surface deviates by less than far_pixels. All characters of a surface are drawn alike, so that the
 * studio, which draws them by one call, and pages show the same picture. @param error deviation, m  @param nearest distance of the nearest one, m
 */
export function is_far(renderer: THREE.WebGLRenderer, camera: THREE.Camera, error: number, nearest: number): boolean {
  return error < far_pixels * pixel_size(renderer, camera, nearest);
}
