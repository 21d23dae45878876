/** Which of the surfaces of bodies is drawn from a distance. */
import * as THREE from 'three';
import type { IndexRange, Level } from './body_surface';

const size = new THREE.Vector2();
const max_deviation = 1; // px of the page or picture, of the surface that is drawn

/**
 * Height of a pixel at a distance from the camera, m. An orthographic camera shows all distances alike. A canvas has the pixels of the page, because
 * its own resolution changes while something moves.
 */
function pixel_size(renderer: THREE.WebGLRenderer, camera: THREE.Camera, distance: number): number {
  const height = renderer.getRenderTarget()?.height ?? renderer.getSize(size).y;
  const depth = camera instanceof THREE.OrthographicCamera ? 1 : distance;
  return (2 * depth) / (camera.projectionMatrix.elements[5]! * Math.max(1, height));
}

/**
 * The coarsest surface that deviates by less than max_deviation. All characters of a surface are drawn alike, so that the studio, which draws them by
 * one call, and pages show the same picture. @param coarser the finest first  @param nearest distance of the nearest one, m
 */
export function surface_at(renderer: THREE.WebGLRenderer, camera: THREE.Camera, { shown, coarser }: { shown: IndexRange; coarser: readonly Level[] }, nearest: number): IndexRange {
  const limit = max_deviation * pixel_size(renderer, camera, nearest);
  return coarser.filter(({ error }) => error < limit).at(-1) ?? shown;
}
