/** The lines of the floor's grid: one every metre, stronger ones every 5 m, and the axes x (red) and y (green). */
import * as THREE from 'three';

// Each line is a strip of quads that is little wider than the line. On machines without a graphics processor, a shader that computes the lines for
// every pixel of the floor takes about a twentieth of the time of a video.
const quads = 16; // of a line
const max_lines = 1000; // in each direction from the focus: lines further away are thinner than a pixel
/** Radius within which lines are visible, relative to the radius within which the floor is visible. */
const visible = 0.6;

const is_strong = 'bool is_strong(float at) { return abs(at - 5.0 * floor(at / 5.0 + 0.5)) < 0.5; }';

const vertex_shader = `
uniform vec2 u_focus;
uniform vec4 u_viewport; // left, bottom, width and height, px
uniform float u_reach;
uniform int u_lines;
flat varying mat3 v_to_floor; // from a point (x, y, 1) of the picture, px, to the floor relative to the focus, homogeneous
flat varying int v_axis; // 0: lines of equal x, 1: lines of equal y
flat varying float v_at; // that x or y, m

${is_strong}
// Width of a pixel along x and along y at the point p (m) of the floor with the clip coordinates c, m: sums of the absolute derivatives, as fwidth().
vec2 pixel_width(vec4 c, mat4 to_clip) {
  vec2 along_x = 0.5 * u_viewport.zw * (to_clip[0].xy * c.w - c.xy * to_clip[0].w);
  vec2 along_y = 0.5 * u_viewport.zw * (to_clip[1].xy * c.w - c.xy * to_clip[1].w);
  float area = abs(along_x.x * along_y.y - along_x.y * along_y.x);
  vec2 sums = vec2(abs(along_y.x) + abs(along_y.y), abs(along_x.x) + abs(along_x.y));
  return sums * (c.w * c.w / max(area, 1e-12));
}

void main() {
  int per_axis = 2 * u_lines + 1;
  v_axis = gl_InstanceID / per_axis;
  vec2 focus = v_axis == 0 ? u_focus : u_focus.yx;
  v_at = floor(focus.x + 0.5) + float(gl_InstanceID - v_axis * per_axis - u_lines);
  float away = v_at - focus.x;
  float radius = ${visible} * u_reach;
  vec2 p = vec2(v_at, focus.y + position.x * sqrt(max(0.0, radius * radius - away * away)));
  if (v_axis == 1) p = p.yx;
  mat4 to_clip = projectionMatrix * viewMatrix;
  vec2 widths = pixel_width(to_clip * vec4(p, 0.0, 1.0), to_clip);
  // Half a pixel wider than the line, so that the strip covers all samples of its pixels. Lines fade out where a pixel is wider than their
  // distance allows, so their strips need not be wider.
  float pixel = v_axis == 0 ? widths.x : widths.y;
  float reach = v_at == 0.0 ? 2.0 * min(pixel, 20.0) : is_strong(v_at) ? 1.8 * min(pixel, 1.75) : 1.6 * min(pixel, 0.35);
  if (v_axis == 0) p.x += reach * position.y;
  else p.y += reach * position.y;
  mat3 to_picture = mat3(to_clip[0].xyw, to_clip[1].xyw, to_clip[0].xyw * u_focus.x + to_clip[1].xyw * u_focus.y + to_clip[3].xyw);
  vec2 scale = 2.0 / u_viewport.zw;
  v_to_floor = inverse(to_picture) * mat3(scale.x, 0.0, 0.0, 0.0, scale.y, 0.0, -1.0 - scale * u_viewport.xy, 1.0);
  gl_Position = to_clip * vec4(p, 0.0, 1.0);
}`;

const fragment_shader = `
uniform vec2 u_focus;
uniform vec3 u_background, u_line;
uniform float u_reach, u_strength;
flat varying mat3 v_to_floor;
flat varying int v_axis;
flat varying float v_at;
${is_strong}
// Part of a pixel that lines of equal x, and of equal y, with a distance of 1 / 'per_m' cover.
vec2 covered(vec2 p, vec2 p_width, float per_m, float pixels) {
  vec2 w = p_width * per_m;
  vec2 d = abs(fract(p * per_m - 0.5) - 0.5) / max(w, vec2(1e-6));
  vec2 l = 1.0 - smoothstep(pixels - 0.5, pixels + 0.5, d);
  return l * (1.0 - smoothstep(0.12, 0.35, w)); // fade out lines that are only a few pixels apart, because they flicker
}

void main() {
  // not interpolated between the corners: these are rounded to a fraction of a pixel, which would shift the lines visibly
  vec3 point = v_to_floor * vec3(gl_FragCoord.xy, 1.0);
  vec2 from_focus = point.xy / point.z;
  vec2 p = u_focus + from_focus;
  vec2 w = fwidth(from_focus);
  float away = length(from_focus);
  float strength = u_strength * (1.0 - smoothstep(0.15 * u_reach, ${visible} * u_reach, away));
  vec2 weak = covered(p, w, 1.0, 0.55);
  vec2 strong = covered(p, w, 0.2, 0.75);
  // of the lines of this direction only the own one, because strips can overlap
  float across = v_axis == 0 ? p.x : p.y;
  float own_weak = abs(across - v_at) < 0.5 ? (v_axis == 0 ? weak.x : weak.y) : 0.0;
  float own_strong = is_strong(v_at) && abs(across - v_at) < 2.5 ? (v_axis == 0 ? strong.x : strong.y) : 0.0;
  float lines = strength * (0.6 * own_weak + 0.4 * own_strong);
  if (v_axis == 1) { // a crossing is as bright as the brighter line: only what the lines of equal x have not drawn
    float drawn = strength * (0.6 * weak.x + 0.4 * strong.x);
    lines = (strength * (0.6 * max(weak.x, own_weak) + 0.4 * max(strong.x, own_strong)) - drawn) / (1.0 - drawn);
  }
  float to_axis = abs(across) / max(v_axis == 0 ? w.x : w.y, 1e-6);
  float axis = v_at == 0.0 ? 2.0 * strength * (1.0 - smoothstep(0.4, 1.4, to_axis)) : 0.0;
  vec3 axis_color = v_axis == 0 ? vec3(0.4, 0.62, 0.42) : vec3(0.75, 0.4, 0.4);
  float fade = smoothstep(0.12 * u_reach, u_reach, away);
  vec3 color = mix(lines * u_line, axis_color, axis);
  float alpha = mix(lines, 1.0, axis);
  gl_FragColor = vec4(mix(color, alpha * u_background, fade), alpha);
}`;

/** Number of lines on each side of the focus, in each direction, of a floor that is visible up to `reach` (m). */
export const line_count = (reach: number): number => Math.min(max_lines, Math.ceil(visible * reach));

/** Positions along the line and across it, both -1 ... 1, of the corners of a strip. */
function strip(): THREE.InstancedBufferGeometry {
  const corners: number[] = [];
  const triangles: number[] = [];
  for (let i = 0; i <= quads; i++) {
    corners.push((2 * i) / quads - 1, -1, 0, (2 * i) / quads - 1, 1, 0);
    const k = 2 * i;
    if (i < quads) triangles.push(k, k + 1, k + 2, k + 2, k + 1, k + 3);
  }
  const out = new THREE.InstancedBufferGeometry();
  out.setAttribute('position', new THREE.Float32BufferAttribute(corners, 3));
  out.setIndex(triangles);
  return out;
}

export class FloorLines {
  readonly mesh: THREE.Mesh<THREE.InstancedBufferGeometry, THREE.ShaderMaterial>;

  /** @param uniforms of the floor, which the lines share: u_focus, u_reach, u_strength, u_line, u_background */
  constructor(uniforms: Record<string, THREE.IUniform>) {
    const own = { u_viewport: { value: new THREE.Vector4(0, 0, 1, 1) }, u_lines: { value: 0 } };
    const material = new THREE.ShaderMaterial({
      uniforms: Object.assign(own, uniforms),
      vertexShader: vertex_shader,
      fragmentShader: fragment_shader,
      transparent: true,
      blending: THREE.CustomBlending,
      blendSrc: THREE.OneFactor,
      blendDst: THREE.OneMinusSrcAlphaFactor,
      blendSrcAlpha: THREE.ZeroFactor,
      blendDstAlpha: THREE.OneFactor,
      side: THREE.DoubleSide,
      depthWrite: false,
      // the smallest visible depth before the floor, so that the floor does not cover them
      polygonOffset: true,
      polygonOffsetFactor: -1,
      polygonOffsetUnits: -4,
    });
    this.mesh = new THREE.Mesh(strip(), material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = -1; // before everything else that is transparent
    this.mesh.onBeforeRender = (renderer) => {
      renderer.getCurrentViewport(own.u_viewport.value);
      material.uniformsNeedUpdate = true;
    };
  }

  /** @param reach radius within which the floor is visible, m */
  set_reach(reach: number): void {
    const lines = line_count(reach);
    this.mesh.material.uniforms.u_lines!.value = lines;
    this.mesh.geometry.instanceCount = 2 * (2 * lines + 1);
  }
}
