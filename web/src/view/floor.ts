/** The floor: a metre grid that fades into the background with the distance from the camera's target. */
import * as THREE from 'three';

export class Floor {
  readonly mesh: THREE.Mesh;
  private readonly uniforms = {
    u_background: { value: new THREE.Color() },
    u_line: { value: new THREE.Color() },
    u_focus: { value: new THREE.Vector3() },
    u_reach: { value: 20 },
    u_strength: { value: 0.5 },
  };
  private readonly material: THREE.MeshLambertMaterial;

  constructor() {
    this.material = new THREE.MeshLambertMaterial({ color: 0x2a2c31 });
    this.material.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, this.uniforms);
      shader.vertexShader = shader.vertexShader
        .replace('#include <common>', '#include <common>\nvarying vec3 v_world;')
        .replace('#include <begin_vertex>', '#include <begin_vertex>\nv_world = (modelMatrix * vec4(position, 1.0)).xyz;');
      shader.fragmentShader = shader.fragmentShader
        .replace(
          '#include <common>',
          `#include <common>
          varying vec3 v_world;
          uniform vec3 u_background; uniform vec3 u_line; uniform vec3 u_focus;
          uniform float u_reach; uniform float u_strength;
          float grid_line(vec2 p, float period, float pixels) {
            vec2 w = fwidth(p / period);
            vec2 d = abs(fract(p / period - 0.5) - 0.5) / max(w, vec2(1e-6));
            vec2 l = 1.0 - smoothstep(pixels - 0.5, pixels + 0.5, d);
            // fade out lines that are only a few pixels apart, because they flicker
            l *= 1.0 - smoothstep(0.12, 0.35, w);
            return max(l.x, l.y);
          }`,
        )
        .replace(
          '#include <tonemapping_fragment>',
          `vec2 p = v_world.xy;
          float away = length(p - u_focus.xy);
          float near_fade = 1.0 - smoothstep(0.15 * u_reach, 0.6 * u_reach, away);
          float lines = 0.6 * grid_line(p, 1.0, 0.55) + 0.4 * grid_line(p, 5.0, 0.75);
          gl_FragColor.rgb = mix(gl_FragColor.rgb, u_line, clamp(lines, 0.0, 1.0) * u_strength * near_fade);
          vec2 axis_w = fwidth(p);
          float x_axis = 1.0 - smoothstep(0.4, 1.4, abs(p.y) / max(axis_w.y, 1e-6));
          float y_axis = 1.0 - smoothstep(0.4, 1.4, abs(p.x) / max(axis_w.x, 1e-6));
          gl_FragColor.rgb = mix(gl_FragColor.rgb, vec3(0.52, 0.13, 0.13), x_axis * 0.45 * near_fade);
          gl_FragColor.rgb = mix(gl_FragColor.rgb, vec3(0.13, 0.34, 0.15), y_axis * 0.45 * near_fade);
          gl_FragColor.rgb = mix(gl_FragColor.rgb, u_background, smoothstep(0.12 * u_reach, u_reach, away));
          #include <tonemapping_fragment>`,
        );
    };
    this.mesh = new THREE.Mesh(new THREE.PlaneGeometry(1200, 1200), this.material);
    this.mesh.receiveShadow = true;
    this.mesh.name = 'floor';
  }

  /** @param strength opacity of the grid lines, 0 ... 1 */
  set_colors(floor: THREE.Color, line: THREE.Color, background: THREE.Color, strength: number): void {
    this.material.color.copy(floor);
    this.uniforms.u_line.value.copy(line);
    this.uniforms.u_background.value.copy(background);
    this.uniforms.u_strength.value = strength;
  }

  /** Centres the visible floor. @param x, y m  @param reach radius beyond which only the background is visible, m */
  set_focus(x: number, y: number, reach: number): void {
    this.uniforms.u_focus.value.set(x, y, 0);
    this.uniforms.u_reach.value = reach;
  }
}
