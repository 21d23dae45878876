/** The part of the floor on which bodies can cast shadows: the smallest polygon with sides in given directions. */
import * as THREE from 'three';

const sides = 12;
/** Number of corners of an outline, and of the corners of the triangles that fill it. */
export const outline_corners = sides;
export const outline_vertices = 3 * (sides - 2);
const directions = Array.from({ length: sides }, (_, i) => [Math.cos((2 * Math.PI * i) / sides), Math.sin((2 * Math.PI * i) / sides)] as const);
const [turn_cos, turn_sin] = directions[1]!;

/**
 * Polygon on the floor (z = 0) that contains the shadows of bodies within `spheres` (m), the corners counter-clockwise.
 * @param to_light unit vector  @param soft distance by which the edge of a shadow is softened, m
 * @return x and y of each corner, m; [2 * outline_corners]
 */
export function shadow_outline(spheres: readonly THREE.Sphere[], to_light: THREE.Vector3, soft: number): Float64Array {
  const [slope_x, slope_y] = [to_light.x / to_light.z, to_light.y / to_light.z];
  const distances = directions.map(([x, y]) => {
    // The shadow of a sphere of radius 1 is an ellipse. It reaches so far in this direction:
    const reach = Math.hypot(1, slope_x * x + slope_y * y);
    let farthest = -Infinity;
    for (const { center, radius } of spheres)
      farthest = Math.max(farthest, x * (center.x - slope_x * center.z) + y * (center.y - slope_y * center.z) + radius * reach);
    return farthest + soft;
  });
  const out = new Float64Array(2 * sides);
  directions.forEach(([x, y], i) => {
    // the corner of this side and the next one, which is turned by the angle between two directions
    const along = (distances[(i + 1) % sides]! - distances[i]! * turn_cos) / turn_sin;
    out[2 * i] = x * distances[i]! - y * along;
    out[2 * i + 1] = y * distances[i]! + x * along;
  });
  return out;
}
