/** Limits the work on a shadow map to the part in which something casts shadows: clearing the whole map takes longer than drawing one body. */
import * as THREE from 'three';

/** Draws what casts shadows. Only the depth is used. */
export const shadow_material = new THREE.MeshDepthMaterial({ colorWrite: false });

const bulge = 0.05; // m: a smooth surface may reach beyond the bounds of its links by this much

/** A rectangle of texels of the shadow map. */
interface Texels {
  left: number;
  bottom: number;
  right: number;
  top: number;
}
const none: Texels = { left: Infinity, bottom: Infinity, right: -Infinity, top: -Infinity };
const join = (a: Texels, b: Texels): Texels => ({ left: Math.min(a.left, b.left), bottom: Math.min(a.bottom, b.bottom), right: Math.max(a.right, b.right), top: Math.max(a.top, b.top) });

/** The texels that bodies within `spheres` (m) can cover. @param to_map from the world to the map, 0 ... 1  @param per_m size of 1 m in the map, texels */
export function shadow_texels(spheres: readonly THREE.Sphere[], to_map: THREE.Matrix4, size: number, per_m: number): Texels {
  const at = new THREE.Vector3();
  return spheres.reduce((area, sphere) => {
    const { x, y } = at.copy(sphere.center).applyMatrix4(to_map).multiplyScalar(size);
    const reach = (sphere.radius + bulge) * per_m + 1;
    return join(area, { left: Math.floor(x - reach), bottom: Math.floor(y - reach), right: Math.ceil(x + reach), top: Math.ceil(y + reach) });
  }, none);
}

export class ShadowRegion {
  private drawn: Texels | null = null;

  /** The map is empty or new: the next frame clears all of it. */
  reset(): void {
    this.drawn = null;
  }

  /** Prepares the map of a light for the next frame. World matrices must be up to date. @param spheres that contain all bodies that cast shadows, m */
  limit(light: THREE.DirectionalLight, spheres: readonly THREE.Sphere[]): void {
    const { shadow } = light;
    shadow.updateMatrices(light);
    const { x: size } = shadow.mapSize;
    const area = shadow_texels(spheres, shadow.matrix, size, size / (shadow.camera.right - shadow.camera.left));
    if (shadow.map) {
      const { map } = shadow;
      map.scissorTest = this.drawn !== null;
      if (this.drawn) {
        const both = join(area, this.drawn);
        const [left, bottom] = [Math.max(0, both.left), Math.max(0, both.bottom)];
        const [width, height] = [Math.min(size, both.right) - left, Math.min(size, both.top) - bottom];
        if (width > 0 && height > 0) map.scissor.set(left, bottom, width, height);
        else map.scissor.set(0, 0, 0, 0);
      }
      this.drawn = area;
    }
  }
}
