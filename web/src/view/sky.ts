/** The sky: colours from the horizon to the zenith behind everything, with a glow around the sun. */
import * as THREE from 'three';

const vertex_shader = `
varying vec3 v_direction;
void main() {
  bool perspective = projectionMatrix[3][3] == 0.0;
  vec2 at = perspective ? position.xy / vec2(projectionMatrix[0][0], projectionMatrix[1][1]) : vec2(0.0);
  v_direction = vec3(at, -1.0) * mat3(viewMatrix);
  gl_Position = vec4(position.xy, 1.0, 1.0);
}`;

// The noise of half a grey level hides the steps of the colours.
const fragment_shader = `
#include <common>
varying vec3 v_direction;
uniform vec3 u_zenith, u_horizon, u_sun, u_glow;
void main() {
  vec3 d = normalize(v_direction);
  gl_FragColor = vec4(mix(u_horizon, u_zenith, sqrt(max(d.z, 0.0))) + u_glow * pow(max(dot(d, u_sun), 0.0), 40.0) * step(0.0, d.z), 1.0);
  #include <colorspace_fragment>
  gl_FragColor.rgb += (rand(gl_FragCoord.xy) - 0.5) / 255.0;
}`;

export class Sky {
  readonly mesh: THREE.Mesh;
  private readonly uniforms = {
    u_zenith: { value: new THREE.Color() },
    u_horizon: { value: new THREE.Color() },
    u_sun: { value: new THREE.Vector3() },
    u_glow: { value: new THREE.Color() },
  };

  constructor() {
    const triangle = new THREE.BufferGeometry().setAttribute('position', new THREE.Float32BufferAttribute([-1, -1, 0, 3, -1, 0, -1, 3, 0], 3));
    this.mesh = new THREE.Mesh(triangle, new THREE.ShaderMaterial({ uniforms: this.uniforms, vertexShader: vertex_shader, fragmentShader: fragment_shader, depthTest: false, depthWrite: false }));
    this.mesh.frustumCulled = this.mesh.visible = false;
    this.mesh.renderOrder = -1;
  }

  /** @param to_sun unit vector */
  set_colors(sky: { zenith: string; horizon: string }, sun: THREE.DirectionalLight, to_sun: THREE.Vector3): void {
    this.uniforms.u_zenith.value.set(sky.zenith);
    this.uniforms.u_horizon.value.set(sky.horizon);
    this.uniforms.u_sun.value.copy(to_sun);
    this.uniforms.u_glow.value.copy(sun.color).multiplyScalar(Math.min(0.4, 0.12 * sun.intensity));
  }
}
