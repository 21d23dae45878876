/** The smooth surface of a body: the zero level of its distance field as one mesh, bound to the links with weights (linear blend skinning). */
import { MeshoptSimplifier } from 'meshoptimizer/simplifier';
import * as THREE from 'three';
import type { MechanismData } from '../core/protocol';
import { BodyField, bind_poses, is_body, type FieldLink } from './body_field';
import { thin_shapes } from './thin_links';

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

const cells_over_height = 100; // 18 mm for a person of 1.8 m
const thinnest = 0.7; // radius in cells: thinner links, for example fingers, are drawn as their shapes
const thin_segments = 10; // around a thin shape
const coarse_thin_segments = 5; // from afar and for shadows: a finger of 8 mm radius deviates by 1.5 mm
const rough_cells_over_height = 45; // a fifth of the work
// Where the surface is flat, its triangles are joined. The bounds are in cells: an arm of 50 mm radius deviates by as much between its vertices.
const shown_error = 0.055; // 1 mm for a person of 1.8 m
const coarser_errors = [0.14, 0.2, 0.28, 0.4, 0.57]; // 2.5 ... 10 mm, in steps of the square root of 2
const shadow_error = 0.22; // 4 mm, less than a texel of the shadow map
const normal_weight = 28; // a normal that is wrong by 1/500 counts as 1 mm, because light shows it
const bend_weight = 2.8; // a wrong part of 1/50 between two links counts as 1 mm: a bent limb moves by about its radius
const block = 4; // edge of a block of cells that is skipped if it is far from the surface, cells
const smoothing = 1.2e-3; // m: normals are those of differences over this distance, so that the creases between links that are not connected are smooth
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
    set_details(rough, yield* details_of(field_of(mechanism, bind_poses(mechanism)), false));
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

/** The field of all links that its grid can show. */
function field_of(mechanism: MechanismData, bind: readonly THREE.Matrix4[]): BodyField {
  const whole = new BodyField(mechanism, bind);
  const size = whole.box().getSize(new THREE.Vector3());
  const field = new BodyField(mechanism, bind, (thinnest * Math.max(size.x, size.y, size.z)) / cells_over_height);
  return field.links.length > 0 ? field : whole;
}

function surface_of(mechanism: MechanismData, details: (field: BodyField) => Details): BodySurface | null {
  if (!is_body(mechanism) || mechanism.links.length > max_links) return null;
  const bind = bind_poses(mechanism);
  const made = details(field_of(mechanism, bind));
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
  const { normals, ...skin } = yield* settle(field, positions, cell);
  if (rough || indices.length === 0) {
    const made = with_thin_links(field, { positions, normals, ...skin }, [indices]);
    return { ...made, shown: made.ranges[0]!, coarser: [], shadow: made.ranges[0]! };
  }
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
  const vertices = { positions: kept(positions, 3), normals: kept(normals, 3), links: kept(skin.links, 4), weights: kept(skin.weights, 4) };
  const { ranges, ...made } = with_thin_links(field, vertices, [shown, ...lists]);
  return { ...made, shown: ranges[0]!, coarser: coarser_errors.map((error, i) => ({ ...ranges[i + 1]!, error: error * cell })), shadow: ranges.at(-1)! };
}

type Vertices = Pick<Details, 'positions' | 'normals' | 'links' | 'weights'>;

/** Adds the shapes of the thin links to all lists of triangles, in less detail to all but the first, and puts the lists one behind the other. */
function with_thin_links(field: BodyField, vertices: Vertices, lists: readonly Uint32Array[]): Vertices & { indices: Uint32Array; ranges: IndexRange[] } {
  const count = vertices.positions.length / 3;
  const fine = thin_shapes(field.thin, thin_segments, count);
  const coarse = thin_shapes(lists.length > 1 ? field.thin : [], coarse_thin_segments, count + fine.positions.length / 3);
  const indices: number[] = [];
  const ranges = lists.map((list, i): IndexRange => {
    const start = indices.length;
    for (const part of [list, (i === 0 ? fine : coarse).indices]) for (const index of part) indices.push(index);
    return { start, count: indices.length - start };
  });
  const joined = <A extends Float32Array | Uint16Array>(make: new (length: number) => A, key: 'positions' | 'normals' | 'links' | 'weights'): A => {
    const own = vertices[key];
    const out = new make(own.length + fine[key].length + coarse[key].length);
    out.set(own);
    out.set(fine[key], own.length);
    out.set(coarse[key], own.length + fine[key].length);
    return out;
  };
  return { positions: joined(Float32Array, 'positions'), normals: joined(Float32Array, 'normals'), links: joined(Uint16Array, 'links'), weights: joined(Float32Array, 'weights'), indices: new Uint32Array(indices), ranges };
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

const edges_of_cell = [0, 1, 2, 3, 4, 5, 6, 7, 0, 2, 1, 3, 4, 6, 5, 7, 0, 4, 1, 5, 2, 6, 3, 7]; // pairs of corners; bit 0 of a corner is x, bit 1 y, bit 2 z

/** A grid of values of the field near the zero level. Each function computes a small part, so that browsers optimise it after a few calls. */
class Grid {
  readonly h: number;
  readonly origin: THREE.Vector3;
  readonly nx: number;
  readonly ny: number;
  readonly nz: number;
  readonly positions: number[] = [];
  readonly indices: number[] = [];
  private readonly values: Float32Array;
  /** Range of the cells that are evaluated in each row along x; the level is nowhere else. */
  private readonly begin: Int32Array;
  private readonly end: Int32Array;
  /** Index of the vertex in each cell; -1: none. */
  private readonly vertex: Int32Array;
  private readonly corners: number[];
  private readonly steps: [number, number, number];

  constructor(private readonly field: BodyField, cells: number) {
    const box = field.box();
    const size = box.getSize(new THREE.Vector3());
    const h = (this.h = Math.max(size.x, size.y, size.z) / cells);
    const nx = (this.nx = Math.ceil(size.x / h) + 3);
    const ny = (this.ny = Math.ceil(size.y / h) + 3);
    const nz = (this.nz = Math.ceil(size.z / h) + 3);
    this.origin = box.min.clone().subScalar(h);
    this.values = new Float32Array(nx * ny * nz).fill(1);
    this.begin = new Int32Array(ny * nz).fill(nx);
    this.end = new Int32Array(ny * nz);
    this.vertex = new Int32Array(nx * ny * nz).fill(-1);
    this.corners = [0, 1, nx, nx + 1, nx * ny, nx * ny + 1, nx * ny + nx, nx * ny + nx + 1];
    this.steps = [1, nx, nx * ny];
  }

  /** Ranges of the cells near a link: i0, i1, j0, j1, k0, k1. */
  range_of(link: FieldLink): [number, number, number, number, number, number] {
    const { origin, h, nx, ny, nz } = this;
    const reach = link.reach + link.blend;
    const low = link.centre.clone().subScalar(reach).sub(origin).divideScalar(h).floor();
    const high = link.centre.clone().addScalar(reach).sub(origin).divideScalar(h).ceil();
    return [Math.max(0, low.x), Math.min(nx - 1, high.x), Math.max(0, low.y), Math.min(ny - 1, high.y), Math.max(0, low.z), Math.min(nz - 1, high.z)];
  }

  /** Evaluates the pair of a link in the cells of a block, if the level may be there. @param i1, j1, k1 last cells of the link's range */
  evaluate(link: FieldLink, ib: number, jb: number, kb: number, i1: number, j1: number, k1: number): void {
    const { field, origin, h, nx, ny, begin, end, values } = this;
    const middle = 0.5 * h * (block - 1);
    // from the middle of a block to its corners, and two cells more: values beside the zero level are needed
    const away = link.blend + Math.sqrt(3) * middle + 2 * h;
    if (field.min_distance(link, origin.x + h * ib + middle, origin.y + h * jb + middle, origin.z + h * kb + middle) > away) return;
    const last = Math.min(ib + block - 1, i1);
    for (let k = kb; k < kb + block && k <= k1; k++)
      for (let j = jb; j < jb + block && j <= j1; j++) {
        const row = j + ny * k;
        begin[row] = Math.min(begin[row]!, ib);
        end[row] = Math.max(end[row]!, last + 1);
        for (let i = ib; i <= last; i++) {
          const value = field.pair_distance(link, origin.x + h * i, origin.y + h * j, origin.z + h * k);
          const cell = i + nx * row;
          if (value < values[cell]!) values[cell] = value;
        }
      }
  }

  /** Makes the vertices of a row: one for each cell that the level crosses. */
  add_vertices(j: number, k: number): void {
    const { nx, ny, begin, end, values, corners } = this;
    const row = j + ny * k;
    for (let i = begin[row]!, last = Math.min(end[row]!, nx - 1); i < last; i++) {
      const base = i + nx * row;
      const inside = values[base]! < 0;
      let c = 1;
      while (c < 8 && values[base + corners[c]!]! < 0 === inside) c++;
      if (c < 8) this.add_vertex(i, j, k, base);
    }
  }

  private add_vertex(i: number, j: number, k: number, base: number): void {
    const { origin, h, values, corners, positions } = this;
    let x = 0;
    let y = 0;
    let z = 0;
    let count = 0;
    for (let edge = 0; edge < edges_of_cell.length; edge += 2) {
      const a = edges_of_cell[edge]!;
      const b = edges_of_cell[edge + 1]!;
      const va = values[base + corners[a]!]!;
      const vb = values[base + corners[b]!]!;
      if (va < 0 === vb < 0) continue;
      const t = va / (va - vb);
      x += (a & 1) + t * ((b & 1) - (a & 1));
      y += ((a >> 1) & 1) + t * (((b >> 1) & 1) - ((a >> 1) & 1));
      z += (a >> 2) + t * ((b >> 2) - (a >> 2));
      count++;
    }
    this.vertex[base] = positions.length / 3;
    positions.push(origin.x + h * (i + x / count), origin.y + h * (j + y / count), origin.z + h * (k + z / count));
  }

  /** Makes the triangles of a row: two for each edge that the level crosses. */
  add_triangles(j: number, k: number): void {
    const { nx, ny, begin, end, values, steps } = this;
    const row = j + ny * k;
    for (let i = Math.max(1, begin[row]!), last = Math.min(end[row]!, nx - 1); i < last; i++) {
      const base = i + nx * row;
      const inside = values[base]! < 0;
      for (let axis = 0; axis < 3; axis++)
        if (inside !== values[base + steps[axis]!]! < 0) this.add_square(base, steps[(axis + 1) % 3]!, steps[(axis + 2) % 3]!, inside);
    }
  }

  private add_square(base: number, u: number, v: number, inside: boolean): void {
    const { vertex, indices } = this;
    const a = vertex[base]!;
    const b = vertex[base - u]!;
    const c = vertex[base - u - v]!;
    const d = vertex[base - v]!;
    if (inside) indices.push(a, b, c, a, c, d);
    else indices.push(a, c, b, a, d, c);
  }
}

/** The zero level as a mesh by surface nets: one vertex for each cell that the level crosses, one quad for each crossed edge. */
function* mesh_of(field: BodyField, cells: number): Work<Mesh> {
  const grid = new Grid(field, cells);
  const { ny, nz } = grid;
  // each pair of links is evaluated only near its own link, block by block
  for (const link of field.links) {
    const [i0, i1, j0, j1, k0, k1] = grid.range_of(link);
    for (let k = k0; k <= k1; k += block) {
      yield;
      for (let j = j0; j <= j1; j += block) for (let i = i0; i <= i1; i += block) grid.evaluate(link, i, j, k, i1, j1, k1);
    }
  }
  for (let k = 0; k < nz - 1; k++) {
    yield;
    for (let j = 0; j < ny - 1; j++) grid.add_vertices(j, k);
  }
  for (let k = 1; k < nz - 1; k++) {
    yield;
    for (let j = 1; j < ny - 1; j++) grid.add_triangles(j, k);
  }
  return { positions: new Float32Array(grid.positions), indices: new Uint32Array(grid.indices), cell: grid.h };
}

/** Edges of a tetrahedron's corners from its centre: four values give a gradient whose error is of second order, as six values along the axes do. */
const corners_around = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]] as const;
const gradient = new THREE.Vector3();

/** Sets `gradient` at a point. @param e distance of the values from the point along each axis, m */
function compute_gradient(field: BodyField, x: number, y: number, z: number, e: number): void {
  gradient.set(0, 0, 0);
  for (const [i, j, k] of corners_around) {
    const d = field.distance(x + e * i, y + e * j, z + e * k);
    gradient.x += i * d;
    gradient.y += j * d;
    gradient.z += k * d;
  }
  gradient.multiplyScalar(0.25 / e);
}

/** Moves vertices onto the zero level along the gradient, so that the cells' size is not visible on the surface. @return normals and weights of the links */
function* settle(field: BodyField, positions: Float32Array, h: number): Work<Pick<Details, 'normals' | 'links' | 'weights'>> {
  const count = positions.length / 3;
  const out = { normals: new Float32Array(positions.length), links: new Uint16Array(4 * count), weights: new Float32Array(4 * count) };
  const binding = new Binding(field);
  for (let i = 0; i < count; i++) {
    if (i % vertices_at_once === 0) yield;
    settle_vertex(field, binding, positions, h, i, out);
  }
  return out;
}

function settle_vertex(field: BodyField, binding: Binding, positions: Float32Array, h: number, i: number, { normals, links, weights }: Pick<Details, 'normals' | 'links' | 'weights'>): void {
  let x = positions[3 * i]!;
  let y = positions[3 * i + 1]!;
  let z = positions[3 * i + 2]!;
  field.look_near(x, y, z, h + 2 * smoothing);
  compute_gradient(field, x, y, z, 0.1 * h);
  const g2 = gradient.lengthSq();
  for (let round = 0; round < 2 && g2 >= 1e-4; round++) {
    const step = Math.max(-0.5 * h, Math.min(0.5 * h, field.distance(x, y, z))) / g2;
    x -= step * gradient.x;
    y -= step * gradient.y;
    z -= step * gradient.z;
  }
  positions[3 * i] = x;
  positions[3 * i + 1] = y;
  positions[3 * i + 2] = z;
  compute_gradient(field, x, y, z, smoothing);
  gradient.normalize().toArray(normals, 3 * i);
  binding.bind(x, y, z, 4 * i, links, weights);
}

/** Binds points to at most four links: the nearest one and those connected to it, with weights that fall with the distance. */
class Binding {
  /** Of each link: it and the links that are connected to it. */
  private readonly connected: FieldLink[][];
  /** The links of the present point, the nearest first. */
  private readonly chosen: { link: FieldLink; d: number }[] = [];

  constructor(private readonly field: BodyField) {
    this.connected = field.links.map((a) => field.links.filter((b) => a === b || a.parent === b || b.parent === a));
  }

  /** The point must be within the reach of the last look_near(). @param at index of the first of the four values that are written */
  bind(x: number, y: number, z: number, at: number, links: Uint16Array, weights: Float32Array): void {
    const { field } = this;
    const nearest = field.nearest_link(x, y, z);
    const { chosen } = this;
    chosen.length = 0;
    for (const link of this.connected[nearest.number]!) {
      const d = field.link_distance(link, x, y, z);
      let place = chosen.length;
      while (place > 0 && chosen[place - 1]!.d > d) place--;
      chosen.splice(place, 0, { link, d });
    }
    chosen.length = Math.min(chosen.length, 4);
    const first = chosen[0]!;
    let sum = 0;
    chosen.forEach((n, k) => {
      const width = 0.5 * Math.min(first.link.radius, n.link.radius);
      const w = Math.max(0, 1 - (n.d - first.d) / width) ** 2;
      links[at + k] = n.link.index;
      weights[at + k] = w;
      sum += w;
    });
    for (let k = 0; k < 4; k++) weights[at + k]! /= sum;
  }
}
