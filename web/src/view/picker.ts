/** Rays from the pointer into the scene, and positions of world points on the page. */
import * as THREE from 'three';
import type { CameraRig } from './camera';
import type { LinkTag } from './character_view';

const reach = 10; // maximum distance between the pointer and a link that is picked, px

/** The link under the pointer, and the hit point in the world, m. */
export interface Pick extends LinkTag {
  point: THREE.Vector3;
}

export class Picker {
  private readonly raycaster = new THREE.Raycaster();

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly rig: CameraRig,
  ) {}

  /**
   * The link at a point of the page; else a link within about `reach` px of the point; else null.
   * @param client_x, client_y px  @param groups meshes of links, with a LinkTag as their `userData`
   */
  pick(client_x: number, client_y: number, groups: THREE.Object3D[]): Pick | null {
    const look = (dx: number, dy: number): Pick | null => {
      this.aim(client_x + dx, client_y + dy);
      const hit = this.raycaster.intersectObjects(groups, true)[0];
      return hit ? { ...(hit.object.userData as LinkTag), point: hit.point.clone() } : null;
    };
    const exact = look(0, 0);
    if (exact) return exact;
    for (const radius of [reach / 2, reach]) {
      for (let i = 0; i < 8; i++) {
        const near = look(radius * Math.cos((i * Math.PI) / 4), radius * Math.sin((i * Math.PI) / 4));
        if (near) return near;
      }
    }
    return null;
  }

  /** Intersection of the ray under the pointer with a plane, m; null if the ray does not meet it. */
  on_plane(client_x: number, client_y: number, plane: THREE.Plane): THREE.Vector3 | null {
    this.aim(client_x, client_y);
    return this.raycaster.ray.intersectPlane(plane, new THREE.Vector3());
  }

  /** Plane through `point` that faces the camera. */
  facing_plane(point: THREE.Vector3): THREE.Plane {
    return new THREE.Plane().setFromNormalAndCoplanarPoint(this.rig.camera.getWorldDirection(new THREE.Vector3()).negate(), point);
  }

  /** Position on the page of a world point, px; null if the point is behind the camera. */
  to_client(point: THREE.Vector3): { x: number; y: number } | null {
    const p = point.clone().project(this.rig.camera);
    if (p.z > 1) return null;
    const rect = this.canvas.getBoundingClientRect();
    return { x: rect.left + (0.5 + 0.5 * p.x) * rect.width, y: rect.top + (0.5 - 0.5 * p.y) * rect.height };
  }

  private aim(client_x: number, client_y: number): void {
    const rect = this.canvas.getBoundingClientRect();
    const x = ((client_x - rect.left) / rect.width) * 2 - 1;
    const y = 1 - ((client_y - rect.top) / rect.height) * 2;
    this.raycaster.setFromCamera(new THREE.Vector2(x, y), this.rig.camera);
  }
}
