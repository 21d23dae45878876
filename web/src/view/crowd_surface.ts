/** Surfaces of which a crowd draws many instances. */
import * as THREE from 'three';
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import type { MechanismData } from '../core/protocol';
import { parts_of_body } from './body_field';
import type { BodySurface, IndexRange, Level } from './body_surface';
import { shape_colors } from './character_view';
import { relief_attribute } from './relief';

export interface CrowdSurface {
  /** Attributes position and normal (rest pose), skinIndex (links) and skinWeight. */
  geometry: THREE.BufferGeometry;
  links: number;
  /** Inverse of the rest pose of every link; null: the surface of each link is in its own frame. */
  inverses: { position: THREE.Vector3; rotation: THREE.Quaternion }[] | null;
  /** Ranges of the index that are drawn, that are drawn from afar, the finest first, and that cast shadows. */
  shown: IndexRange;
  coarser: Level[];
  shadow: IndexRange;
  /** Whether it is the smooth surface of a body, and nothing else. */
  whole_body: boolean;
}

/** The smooth surface of a body. */
function skinned_surface({ geometry, shown, coarser, shadow, inverses }: BodySurface): CrowdSurface {
  const parts = inverses.map((matrix) => {
    const [position, rotation] = [new THREE.Vector3(), new THREE.Quaternion()];
    matrix.decompose(position, rotation, new THREE.Vector3());
    return { position, rotation };
  });
  return { geometry, links: inverses.length, inverses: parts, shown, coarser, shadow, whole_body: true };
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
  const all: number[] = [];
  const range = (surface: IndexRange): IndexRange => {
    const start = all.length;
    for (const index of [...smooth_index(surface), ...shapes]) all.push(index);
    return { start, count: all.length - start };
  };
  const ranges = { shown: range(body.shown), coarser: body.coarser.map((level) => ({ ...range(level), error: level.error })), shadow: range(body.shadow) };
  geometry.setIndex(all);
  return { ...skinned, ...ranges, whole_body: false, geometry };
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
  return { geometry, links: mechanism.links.length, inverses: null, shown: all, coarser: [], shadow: all, whole_body: false };
}
