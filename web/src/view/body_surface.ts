/** The smooth surface of a body: the zero level of its distance field as one mesh, bound to the links with weights (linear blend skinning). */
import { MeshoptSimplifier } from 'meshoptimizer/simplifier';
import * as THREE from 'three';
import type { MechanismData } from '../core/protocol';
import { BodyField, bind_poses, is_body } from './body_field';

export interface BodySurface {
  /** Attributes position and normal (bind pose), skinIndex (links) and skinWeight. The draw range is the surface that is shown. */
  geometry: THREE.BufferGeometry;
  /** Ranges of the index: of the surface that is shown, of coarser ones that are drawn from afar, the finest first, and of the one that casts its shadow. */
  shown: IndexRange;
  coarser: Level[];
  shadow: IndexRange;
  /** Inverse of the bind pose of every link. */
  inverses: THREE.Matrix4[];
}

export interface IndexRange {
  start: number;
  count: number;
}

/** A coarser form of a surface. */
export interface Level extends IndexRange {
  /** Deviation from the surface that is shown, m. */
  error: number;
}

const cells_over_height = 100; // 18 mm for a person of 1.8 m: fingers and toes of the samples have no shapes of their own
const rough_cells_over_height = 45; // a fifth of the work
// Where the surface is flat, its triangles are joined. The bounds are in cells: an arm of 50 mm radius deviates by as much between its vertices.
const shown_error = 0.055; // 1 mm for a person of 1.8 m
const coarser_errors = [0.14, 0.2, 0.28, 0.4, 0.57]; // 2.5 ... 10 mm, in steps of the square root of 2
const shadow_error = 0.22; // 4 mm, less than a texel of the shadow map
const normal_weight = 28; // a normal that is wrong by 1/500 counts as 1 mm, because light shows it
const bend_weight = 2.8; // a wrong part of 1/50 between two links counts as 1 mm: a bent limb moves by about its radius
const block = 4; // edge of a block of cells that is skipped if it is far from the surface, cells
const vertices_at_once = 128; // work between two pauses
/** Maximum number of links of a body; sets the size of a uniform array of the shader, of which WebGL 2 guarantees 256 vectors. */
export const max_links = 96;

/** Surfaces can be made after this. */
export const surfaces_ready = MeshoptSimplifier.ready;

/** Work in parts of about a millisecond; joining flat triangles takes about 20 ms. */
export type Work<T> = Generator<undefined, T>;

/** Does all of the work at once. */
export function finish<T>(work: Work<T>): T {
  for (;;) {
    const next = work.next();
    if (next.done) return next.value;
  }
}

/** Makes the surface of a mechanism in about 0.2 s; null if the mechanism is no body (robots, balls, boxes). */
export function make_body_surface(mechanism: MechanismData): BodySurface | null {
  return surface_of(mechanism, (field) => finish(details_of(field, false)));
}

/**
 * Makes a rough surface of a mechanism in a fifth of the time; null if the mechanism is no body.
 * @return the surface, and the work after which the same objects are the surface of make_body_surface()
 */
export function make_rough_surface(mechanism: MechanismData): { surface: BodySurface; refine: Work<void> } | null {
  const surface = surface_of(mechanism, (field) => finish(details_of(field, true)));
  if (!surface) return null;
  function* refine(rough: BodySurface): Work<void> {
    set_details(rough, yield* details_of(new BodyField(mechanism, bind_poses(mechanism)), false));
  }
  return { surface, refine: refine(surface) };
}

/** What a surface consists of. */
interface Details {
  positions: Float32Array;
  normals: Float32Array;
  links: Uint16Array;
  weights: Float32Array;
  /** First the triangles that are shown, then those that cast the shadow if these are others. */
  indices: Uint32Array;
  shown: IndexRange;
  coarser: Level[];
  shadow: IndexRange;
}

function surface_of(mechanism: MechanismData, details: (field: BodyField) => Details): BodySurface | null {
  if (!is_body(mechanism) || mechanism.links.length > max_links) return null;
  const bind = bind_poses(mechanism);
  const made = details(new BodyField(mechanism, bind));
  if (made.shown.count === 0) return null;
  const empty = { start: 0, count: 0 };
  const inverses = bind.map((m) => m.clone().invert());
  const surface: BodySurface = { geometry: new THREE.BufferGeometry(), shown: { ...empty }, coarser: [], shadow: { ...empty }, inverses };
  set_details(surface, made);
  return surface;
}

function set_details(surface: BodySurface, made: Details): void {
  const { geometry, shown, coarser, shadow } = surface;
  geometry.dispose(); // frees the buffers of the former details
  geometry.setAttribute('position', new THREE.BufferAttribute(made.positions, 3));
  geometry.setAttribute('normal', new THREE.BufferAttribute(made.normals, 3));
  geometry.setAttribute('skinIndex', new THREE.BufferAttribute(made.links, 4));
  geometry.setAttribute('skinWeight', new THREE.BufferAttribute(made.weights, 4));
  geometry.setIndex(new THREE.BufferAttribute(made.indices, 1));
  geometry.computeBoundingSphere();
  Object.assign(shown, made.shown);
  coarser.splice(0, Infinity, ...made.coarser);
  Object.assign(shadow, made.shadow);
  geometry.setDrawRange(shown.start, shown.count);
}

function* details_of(field: BodyField, rough: boolean): Work<Details> {
  const { positions, indices, cell } = yield* mesh_of(field, rough ? rough_cells_over_height : cells_over_height);
  const normals = yield* normals_of(field, positions);
  const skin = yield* weights_of(field, positions);
  const range = { start: 0, count: indices.length };
  if (rough || indices.length === 0) return { positions, normals, ...skin, indices, shown: range, coarser: [], shadow: range };
  yield;
  const shown = join_flat(field, { positions, normals, ...skin, indices }, shown_error, cell);
  yield;
  const levels: Uint32Array[] = [];
  for (const error of coarser_errors) {
    levels.push(join_flat(field, { positions, normals, ...skin, indices: shown }, error, cell));
    yield;
  }
  const [shadow] = MeshoptSimplifier.simplify(shown, positions, 3, 0, shadow_error * cell, ['ErrorAbsolute']);
  const [places, count] = MeshoptSimplifier.compactMesh(shown); // changes `shown` to the places
  const kept = <A extends Float32Array | Uint16Array>(values: A, size: number): A => {
    const out = values.slice(0, size * count) as A;
    places.forEach((place, i) => {
      if (place < count) for (let k = 0; k < size; k++) out[size * place + k] = values[size * i + k]!;
    });
    return out;
  };
  const lists = [...levels, shadow].map((list) => list.map((i) => places[i]!));
  const all = new Uint32Array([shown, ...lists].reduce((sum, list) => sum + list.length, 0));
  let end = 0;
  const [shown_range, ...ranges] = [shown, ...lists].map((list): IndexRange => {
    all.set(list, end);
    end += list.length;
    return { start: end - list.length, count: list.length };
  });
  return {
    positions: kept(positions, 3),
    normals: kept(normals, 3),
    links: kept(skin.links, 4),
    weights: kept(skin.weights, 4),
    indices: all,
    shown: shown_range!,
    coarser: coarser_errors.map((error, i) => ({ ...ranges[i]!, error: error * cell })),
    shadow: ranges.at(-1)!,
  };
}

/** Joins triangles where the surface is flat and where all vertices follow the links alike. @param error in cells @param cell edge of a cell, m */
function join_flat(field: BodyField, { positions, normals, links, weights, indices }: Pick<Details, 'positions' | 'normals' | 'links' | 'weights' | 'indices'>, error: number, cell: number): Uint32Array {
  // distance of the followed links from the root, in links: it changes evenly where a vertex moves from one link to the next
  const depths: number[] = [];
  for (const link of field.links) {
    depths[link.index] = 0;
    for (let up = link.parent; up; up = up.parent) depths[link.index]!++;
  }
  const attributes = new Float32Array((4 * positions.length) / 3);
  for (let i = 0; i < positions.length / 3; i++) {
    for (let k = 0; k < 3; k++) attributes[4 * i + k] = normals[3 * i + k]!;
    for (let k = 0; k < 4; k++) attributes[4 * i + 3]! += weights[4 * i + k]! * (depths[links[4 * i + k]!] ?? 0);
  }
  const factors = [normal_weight, normal_weight, normal_weight, bend_weight].map((w) => w * cell);
  return MeshoptSimplifier.simplifyWithAttributes(indices, positions, 3, attributes, 4, factors, null, 0, error * cell, ['ErrorAbsolute'])[0];
}

interface Mesh {
  positions: Float32Array;
  indices: Uint32Array;
  /** Edge of a cell, m. */
  cell: number;
}

/** The zero level as a mesh by surface nets: one vertex for each cell that the level crosses, one quad for each crossed edge. */
function* mesh_of(field: BodyField, cells: number): Work<Mesh> {
  const box = new THREE.Box3();
  for (const link of field.links) box.union(new THREE.Box3().setFromCenterAndSize(link.centre, new THREE.Vector3().setScalar(2 * (link.reach + link.blend))));
  const size = box.getSize(new THREE.Vector3());
  const h = Math.max(size.x, size.y, size.z) / cells;
  const [nx, ny, nz] = [Math.ceil(size.x / h) + 3, Math.ceil(size.y / h) + 3, Math.ceil(size.z / h) + 3];
  const origin = box.min.clone().subScalar(h);
  const values = new Float32Array(nx * ny * nz).fill(1);
  const at = (i: number, j: number, k: number): number => i + nx * (j + ny * k);
  // range of the cells that are evaluated in each row along x; the level is nowhere else
  const begin = new Int32Array(ny * nz).fill(nx);
  const end = new Int32Array(ny * nz);
  // each pair of links is evaluated only near its own link, block by block
  for (const link of field.links) {
    const reach = link.reach + link.blend;
    const low = link.centre.clone().subScalar(reach).sub(origin).divideScalar(h).floor();
    const high = link.centre.clone().addScalar(reach).sub(origin).divideScalar(h).ceil();
    const [i0, j0, k0] = [Math.max(0, low.x), Math.max(0, low.y), Math.max(0, low.z)];
    const [i1, j1, k1] = [Math.min(nx - 1, high.x), Math.min(ny - 1, high.y), Math.min(nz - 1, high.z)];
    const middle = 0.5 * h * (block - 1);
    // from the middle of a block to its corners, and two cells more: values beside the zero level are needed
    const away = link.blend + Math.sqrt(3) * middle + 2 * h;
    for (let kb = k0; kb <= k1; kb += block) {
      yield;
      for (let jb = j0; jb <= j1; jb += block)
        for (let ib = i0; ib <= i1; ib += block) {
          if (field.min_distance(link, origin.x + h * ib + middle, origin.y + h * jb + middle, origin.z + h * kb + middle) > away) continue;
          for (let k = kb; k < kb + block && k <= k1; k++)
            for (let j = jb; j < jb + block && j <= j1; j++) {
              const row = j + ny * k;
              begin[row] = Math.min(begin[row]!, ib);
              end[row] = Math.max(end[row]!, Math.min(ib + block - 1, i1) + 1);
              for (let i = ib; i < ib + block && i <= i1; i++) {
                const value = field.pair_distance(link, origin.x + h * i, origin.y + h * j, origin.z + h * k);
                const cell = at(i, j, k);
                if (value < values[cell]!) values[cell] = value;
              }
            }
        }
    }
  }
  const vertex = new Int32Array(values.length).fill(-1);
  const positions: number[] = [];
  const corners = [0, 1, nx, nx + 1, nx * ny, nx * ny + 1, nx * ny + nx, nx * ny + nx + 1];
  const edges = [0, 1, 2, 3, 4, 5, 6, 7, 0, 2, 1, 3, 4, 6, 5, 7, 0, 4, 1, 5, 2, 6, 3, 7]; // pairs of corners
  for (let k = 0; k < nz - 1; k++) {
    yield;
    for (let j = 0; j < ny - 1; j++)
      for (let i = begin[j + ny * k]!, last = Math.min(end[j + ny * k]!, nx - 1); i < last; i++) {
        const base = at(i, j, k);
        const inside = values[base]! < 0;
        let c = 1;
        while (c < 8 && values[base + corners[c]!]! < 0 === inside) c++;
        if (c === 8) continue;
        let x = 0;
        let y = 0;
        let z = 0;
        let count = 0;
        for (let edge = 0; edge < edges.length; edge += 2) {
          const a = edges[edge]!;
          const b = edges[edge + 1]!;
          const va = values[base + corners[a]!]!;
          const vb = values[base + corners[b]!]!;
          if (va < 0 === vb < 0) continue;
          const t = va / (va - vb);
          x += (a & 1) + t * ((b & 1) - (a & 1));
          y += ((a >> 1) & 1) + t * (((b >> 1) & 1) - ((a >> 1) & 1));
          z += (a >> 2) + t * ((b >> 2) - (a >> 2));
          count++;
        }
        vertex[base] = positions.length / 3;
        positions.push(origin.x + h * (i + x / count), origin.y + h * (j + y / count), origin.z + h * (k + z / count));
      }
  }
  const indices: number[] = [];
  const steps = [1, nx, nx * ny];
  for (let k = 1; k < nz - 1; k++) {
    yield;
    for (let j = 1; j < ny - 1; j++)
      for (let i = Math.max(1, begin[j + ny * k]!), last = Math.min(end[j + ny * k]!, nx - 1); i < last; i++) {
        const base = at(i, j, k);
        const inside = values[base]! < 0;
        for (let axis = 0; axis < 3; axis++) {
          if (inside === values[base + steps[axis]!]! < 0) continue;
          const [u, v] = [steps[(axis + 1) % 3]!, steps[(axis + 2) % 3]!];
          const [a, b, c, d] = [vertex[base]!, vertex[base - u]!, vertex[base - u - v]!, vertex[base - v]!];
          if (inside) indices.push(a, b, c, a, c, d);
          else indices.push(a, c, b, a, d, c);
        }
      }
  }
  return { positions: yield* settle(field, new Float32Array(positions), h), indices: new Uint32Array(indices), cell: h };
}

/** Moves vertices onto the zero level along the gradient: the cells' size is not visible on the surface. */
function* settle(field: BodyField, positions: Float32Array, h: number): Work<Float32Array> {
  const e = 0.1 * h;
  for (let round = 0; round < 2; round++)
    for (let i = 0; i < positions.length; i += 3) {
      if (i % (3 * vertices_at_once) === 0) yield;
      const [x, y, z] = [positions[i]!, positions[i + 1]!, positions[i + 2]!];
      field.look_near(x, y, z, e);
      const d = field.distance(x, y, z);
      const gx = (field.distance(x + e, y, z) - d) / e;
      const gy = (field.distance(x, y + e, z) - d) / e;
      const gz = (field.distance(x, y, z + e) - d) / e;
      const g2 = gx * gx + gy * gy + gz * gz;
      if (g2 < 1e-4) continue;
      const step = Math.max(-0.5 * h, Math.min(0.5 * h, d)) / g2;
      positions[i] = x - step * gx;
      positions[i + 1] = y - step * gy;
      positions[i + 2] = z - step * gz;
    }
  return positions;
}

function* normals_of(field: BodyField, positions: Float32Array): Work<Float32Array> {
  const out = new Float32Array(positions.length);
  const e = 2e-3; // m: smooths the creases between links that are not connected
  const n = new THREE.Vector3();
  for (let i = 0; i < positions.length; i += 3) {
    if (i % (3 * vertices_at_once) === 0) yield;
    const [x, y, z] = [positions[i]!, positions[i + 1]!, positions[i + 2]!];
    field.look_near(x, y, z, e);
    n.set(field.distance(x + e, y, z) - field.distance(x - e, y, z), field.distance(x, y + e, z) - field.distance(x, y - e, z), field.distance(x, y, z + e) - field.distance(x, y, z - e)).normalize();
    n.toArray(out, i);
  }
  return out;
}

/** Weights of at most four links for each vertex: of the nearest link and of those connected to it, falling with the distance. */
function* weights_of(field: BodyField, positions: Float32Array): Work<Pick<Details, 'links' | 'weights'>> {
  const count = positions.length / 3;
  const links = new Uint16Array(4 * count);
  const weights = new Float32Array(4 * count);
  const connected = field.links.map((a) => field.links.filter((b) => a === b || a.parent === b || b.parent === a));
  for (let i = 0; i < count; i++) {
    if (i % vertices_at_once === 0) yield;
    const [x, y, z] = [positions[3 * i]!, positions[3 * i + 1]!, positions[3 * i + 2]!];
    let nearest = 0;
    let smallest = Infinity;
    for (const link of field.links) {
      const d = field.link_distance(link, x, y, z);
      if (d < smallest) [smallest, nearest] = [d, link.number];
    }
    const chosen = connected[nearest]!.map((link) => ({ link, d: field.link_distance(link, x, y, z) })).sort((a, b) => a.d - b.d).slice(0, 4);
    const first = chosen[0]!;
    let sum = 0;
    chosen.forEach((n, k) => {
      const width = 0.5 * Math.min(first.link.radius, n.link.radius);
      const w = Math.max(0, 1 - (n.d - first.d) / width) ** 2;
      links[4 * i + k] = n.link.index;
      weights[4 * i + k] = w;
      sum += w;
    });
    for (let k = 0; k < 4; k++) weights[4 * i + k]! /= sum;
  }
  return { links, weights };
}
