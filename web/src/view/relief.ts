/** Relief of height fields: contour lines, and a tint that is darker in hollows, so that low hills are visible under any light and from any direction. */
import * as THREE from 'three';

const wanted_lines = 9; // contour lines between the lowest and the highest point
const tint_range: [low: number, high: number] = [-0.3, 0.2]; // change of the brightness at the lowest and at the highest point

/** Name of the attribute of vertices, two values: height in distances of contour lines, and change of the brightness. */
export const relief_attribute = 'relief';

/** Vertical distance of contour lines, m: 1, 2 or 5 times a power of ten. @param height difference between the highest and the lowest point, m */
export function contour_distance(height: number): number {
  if (!(height > 0)) return 1;
  const wanted = height / wanted_lines;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const factor = [1, 2, 5, 10].find((f) => f * power >= 0.8 * wanted)!;
  return factor * power;
}

/** Adds the relief of a height field to its geometry. @param lowest, highest of its points, m */
export function add_relief(geometry: THREE.BufferGeometry, lowest: number, highest: number): void {
  const points = geometry.getAttribute('position');
  const distance = contour_distance(highest - lowest);
  const values = new Float32Array(2 * points.count);
  for (let i = 0; i < points.count; i++) {
    const z = points.getZ(i);
    const share = highest > lowest ? Math.max(0, (z - lowest) / (highest - lowest)) : 0;
    values[2 * i] = z / distance;
    values[2 * i + 1] = highest > lowest ? tint_range[0] + (tint_range[1] - tint_range[0]) * share : 0;
  }
  geometry.setAttribute(relief_attribute, new THREE.BufferAttribute(values, 2));
}

/** Gives all geometries the attribute if one has it, so that they can be merged. Values of 0 draw nothing. */
export function complete_relief(geometries: readonly (THREE.BufferGeometry | null)[]): void {
  if (!geometries.some((geometry) => geometry?.hasAttribute(relief_attribute))) return;
  for (const geometry of geometries)
    if (geometry && !geometry.hasAttribute(relief_attribute)) geometry.setAttribute(relief_attribute, new THREE.BufferAttribute(new Float32Array(2 * geometry.getAttribute('position').count), 2));
}

// Lines are at (k + 0.5) distances, so that the border of a terrain, at height 0, has none. Each fifth line is stronger. Where lines are closer together
// than a few pixels they fade out, because they would flicker.
const draw = `
{
  float pixel = fwidth(v_relief.x);
  float weak = abs(fract(v_relief.x) - 0.5), strong = 5.0 * abs(fract(0.2 * v_relief.x) - 0.5);
  float clear = step(1e-6, pixel) * (1.0 - smoothstep(0.15, 0.4, pixel));
  float clear_strong = step(1e-6, pixel) * (1.0 - smoothstep(0.6, 1.6, pixel));
  float line = clear * 0.34 * (1.0 - smoothstep(0.3, 1.2, weak / max(pixel, 1e-6)));
  line = max(line, clear_strong * 0.55 * (1.0 - smoothstep(0.5, 1.5, strong / max(pixel, 1e-6))));
  diffuseColor.rgb *= (1.0 + v_relief.y) * (1.0 - line);
}
`;

/** Puts text before a part of a shader. @throws if the shader does not contain it, which would be another version of three.js */
function put_before(shader: string, part: string, text: string): string {
  if (!shader.includes(part)) throw new Error(`The shader of three.js does not include ${part} any more.`);
  return shader.replace(part, () => text + part);
}

/** Makes a standard material draw the relief of its vertices. To be called by its onBeforeCompile(), after other changes of the shader. */
export function draw_relief(shader: THREE.WebGLProgramParametersWithUniforms): void {
  shader.vertexShader = put_before(shader.vertexShader, 'void main() {', `attribute vec2 ${relief_attribute};\nvarying vec2 v_relief;\n`);
  shader.vertexShader = put_before(shader.vertexShader, '#include <project_vertex>', `v_relief = ${relief_attribute};\n`);
  shader.fragmentShader = put_before(shader.fragmentShader, 'void main() {', 'varying vec2 v_relief;\n');
  shader.fragmentShader = put_before(shader.fragmentShader, '#include <alphatest_fragment>', draw);
}
