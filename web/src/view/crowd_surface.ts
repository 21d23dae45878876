/** Surfaces of which a crowd draws many instances. */
import * as THREE from 'three';
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import type { MechanismData } from '../core/protocol';
import type { BodySurface, IndexRange } from './body_surface';

export interface CrowdSurface {
  /** Attributes position and normal (rest pose), skinIndex (links) and skinWeight. */
  geometry: THREE.BufferGeometry;
  links: number;
  /** Inverse of the rest pose of every link; null: the surface of each link is in its own frame. */
  inverses: { position: THREE.Vector3; rotation: THREE.Quaternion }[] | null;
  /** Ranges of the index that are drawn, and that cast shadows. */
  shown: IndexRange;
  shadow: IndexRange;
}

/** The smooth surface of a body. */
export function skinned_surface({ geometry, shown, shadow, inverses }: BodySurface): CrowdSurface {
  const parts = inverses.map((matrix) => {
    const [position, rotation] = [new THREE.Vector3(), new THREE.Quaternion()];
    matrix.decompose(position, rotation, new THREE.Vector3());
    return { position, rotation };
  });
  return { geometry, links: inverses.length, inverses: parts, shown, shadow };
}

/** The shapes of all links as one geometry, each vertex of which follows its link. @param geometries of the links, in their frames */
export function rigid_surface(mechanism: MechanismData, geometries: readonly (THREE.BufferGeometry | null)[]): CrowdSurface {
  const parts = geometries.flatMap((geometry, link) => {
    if (!geometry) return [];
    const { count } = geometry.getAttribute('position');
    const part = new THREE.BufferGeometry();
    for (const name of ['position', 'normal']) part.setAttribute(name, geometry.getAttribute(name));
    part.setIndex(geometry.index);
    part.setAttribute('skinIndex', new THREE.BufferAttribute(new Uint16Array(4 * count).fill(link), 4));
    part.setAttribute('skinWeight', new THREE.BufferAttribute(Float32Array.from({ length: 4 * count }, (_, i) => (i % 4 === 0 ? 1 : 0)), 4));
    return [part];
  });
  const geometry = parts.length > 0 ? mergeGeometries(parts) : new THREE.BufferGeometry().setAttribute('position', new THREE.BufferAttribute(new Float32Array(0), 3)).setIndex([]);
  const all = { start: 0, count: geometry.index?.count ?? 0 };
  return { geometry, links: mechanism.links.length, inverses: null, shown: all, shadow: all };
}
