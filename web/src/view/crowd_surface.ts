/** Surfaces of which a crowd draws many instances. */
import * as THREE from 'three';
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import type { MechanismData } from '../core/protocol';
import { parts_of_body } from './body_field';
import type { BodySurface, IndexRange } from './body_surface';
import { shape_colors } from './character_view';
import { relief_attribute } from './relief';

export interface CrowdSurface {
  /** Attributes position and normal (rest pose), skinIndex (links) and skinWeight. */
  geometry: THREE.BufferGeometry;
  links: number;
  /** Inverse of the rest pose of every link; null: the surface of each link is in its own frame. */
  inverses: { position: THREE.Vector3; rotation: THREE.Quaternion }[] | null;
  /** Ranges of the index that are drawn, that are drawn from afar, and that cast shadows. */
  shown: IndexRange;
  far: IndexRange;
  shadow: IndexRange;
  /** Deviation of `far` from `shown`, m. */
  far_error: number;
  /** Whether it is the smooth surface of a body, and nothing else. */
  whole_body: boolean;
}

/** The smooth surface of a body. */
function skinned_surface({ geometry, shown, far, shadow, far_error, inverses }: BodySurface): CrowdSurface {
  const parts = inverses.map((matrix) => {
    const [position, rotation] = [new THREE.Vector3(), new THREE.Quaternion()];
    matrix.decompose(position, rotation, new THREE.Vector3());
    return { position, rotation };
  });
  return { geometry, links: inverses.length, inverses: parts, shown, far, shadow, far_error, whole_body: true };
}

/** The smooth surface of a body, and beside it the shapes of the links that are no parts of the body. @param geometries as in rigid_surface() */
export function body_and_machine(body: BodySurface, mechanism: MechanismData, geometries: readonly (THREE.BufferGeometry | null)[]): CrowdSurface {
  const of_body = parts_of_body(mechanism);
  const skinned = skinned_surface(body);
  const parts = link_parts(geometries.map((geometry, link) => (of_body[link] ? null : geometry)));
  if (parts.length === 0) return skinned;
  for (const part of parts) {
    const bind = body.inverses[part.getAttribute('skinIndex').getX(0)]!.clone().invert();
    part.deleteAttribute(relief_attribute);
    for (const name of ['position', 'normal']) part.setAttribute(name, part.getAttribute(name).clone());
    part.applyMatrix4(bind);
  }
  const smooth = new THREE.BufferGeometry();
  for (const name of ['position', 'normal', 'skinIndex', 'skinWeight']) smooth.setAttribute(name, body.geometry.getAttribute(name));
  smooth.setIndex([]);
  const geometry = mergeGeometries([smooth, ...parts]);
  const shapes = [...geometry.index!.array];
  const smooth_index = ({ start, count }: IndexRange): number[] => [...body.geometry.index!.array.slice(start, start + count)];
  const shown = [...smooth_index(body.shown), ...shapes];
  const far = [...smooth_index(body.far), ...shapes];
  const shadow = [...smooth_index(body.shadow), ...shapes];
  geometry.setIndex([...shown, ...far, ...shadow]);
  const range = (start: number, list: number[]): IndexRange => ({ start, count: list.length });
  return { ...skinned, whole_body: false, geometry, shown: range(0, shown), far: range(shown.length, far), shadow: range(shown.length + far.length, shadow) };
}

/** The shapes of each link as a geometry whose vertices follow the link; null entries are left out. */
function link_parts(geometries: readonly (THREE.BufferGeometry | null)[]): THREE.BufferGeometry[] {
  return geometries.flatMap((geometry, link) => {
    if (!geometry) return [];
    const { count } = geometry.getAttribute('position');
    const part = new THREE.BufferGeometry();
    for (const name of ['position', 'normal', relief_attribute]) if (geometry.hasAttribute(name)) part.setAttribute(name, geometry.getAttribute(name));
    part.setIndex(geometry.index);
    part.setAttribute('skinIndex', new THREE.BufferAttribute(new Uint16Array(4 * count).fill(link), 4));
    part.setAttribute('skinWeight', new THREE.BufferAttribute(Float32Array.from({ length: 4 * count }, (_, i) => (i % 4 === 0 ? 1 : 0)), 4));
    return [part];
  });
}

/** A rigid surface whose vertices have colours of their own where `colors` gives some. @param ignored see shape_colors() */
export function with_shape_colors(surface: CrowdSurface, geometries: readonly (THREE.BufferGeometry | null)[], colors: readonly string[], ignored: (link: number) => boolean): CrowdSurface {
  const lists = shape_colors(geometries, colors, ignored).filter((list) => list !== null);
  const values = new Float32Array(lists.reduce((sum, list) => sum + list.length, 0));
  let at = 0;
  for (const list of lists) {
    values.set(list, at);
    at += list.length;
  }
  const geometry = new THREE.BufferGeometry();
  for (const [name, attribute] of Object.entries(surface.geometry.attributes)) geometry.setAttribute(name, attribute);
  geometry.setIndex(surface.geometry.index);
  geometry.setAttribute('own_color', new THREE.BufferAttribute(values, 4));
  return { ...surface, geometry };
}

/** The shapes of all links as one geometry, each vertex of which follows its link. @param geometries of the links, in their frames */
export function rigid_surface(mechanism: MechanismData, geometries: readonly (THREE.BufferGeometry | null)[]): CrowdSurface {
  const parts = link_parts(geometries);
  const geometry = parts.length > 0 ? mergeGeometries(parts) : new THREE.BufferGeometry().setAttribute('position', new THREE.BufferAttribute(new Float32Array(0), 3)).setIndex([]);
  const all = { start: 0, count: geometry.index?.count ?? 0 };
  return { geometry, links: mechanism.links.length, inverses: null, shown: all, far: all, shadow: all, far_error: 0, whole_body: false };
}
