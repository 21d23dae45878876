/** Props: bodies made from a few numbers or from a mesh file, fixed in the world or moving as passive bodies. docs/scenario.md describes the fields. */
import { free_name, free_place, type Command, type ScenarioDocument } from './document';
import type { Vec3 } from './protocol';

export type PropShape = 'box' | 'ramp' | 'stairs' | 'cylinder' | 'sphere' | 'bar' | 'terrain' | 'mesh';

/** What of a mesh collides: its convex hull, the hulls of its connected parts, or its triangles. */
export type MeshCollision = 'hull' | 'parts' | 'surface';

export interface Prop {
  shape: PropShape;
  /** m; props that do not use a component ignore it. Absent: a mesh. */
  size?: Vec3;
  /** Number of steps of stairs. Absent: 5. */
  steps?: number;
  /** About the distance from a hill of a terrain to the next hollow, m. Absent: 2. */
  grain?: number;
  /** Another seed gives other hills. Absent: 1. */
  seed?: number;
  /** Id of the mechanism with the mesh. */
  mesh?: string;
  /** Factors on the lengths of the mesh. */
  scale?: Vec3;
  collision?: MeshCollision;
  /** Rotations about x, y, z, °. Absent: none. */
  tilt?: Vec3;
  /** kg; 0: fixed in the world. */
  mass: number;
  friction: number;
  restitution: number;
}

interface Kind {
  name: string;
  /** Names of the used components of the size; '' for unused ones. */
  size: [string, string, string];
  start: Vec3;
  color: string;
}

/** A shape that is made from numbers alone. */
export type PlainShape = Exclude<PropShape, 'mesh'>;

export const prop_kinds: Record<PlainShape, Kind> = {
  box: { name: 'Box', size: ['Length', 'Width', 'Height'], start: [0.5, 0.5, 0.5], color: '#b08d63' },
  ramp: { name: 'Ramp', size: ['Length', 'Width', 'Height'], start: [3, 2, 0.4], color: '#8f9aa8' },
  stairs: { name: 'Stairs', size: ['Length', 'Width', 'Height'], start: [1.5, 2, 0.75], color: '#8f9aa8' },
  cylinder: { name: 'Cylinder', size: ['Diameter', '', 'Height'], start: [0.6, 0.6, 0.9], color: '#6f9a8d' },
  sphere: { name: 'Sphere', size: ['Diameter', '', ''], start: [0.4, 0.4, 0.4], color: '#c4706a' },
  bar: { name: 'Bar', size: ['Thickness', 'Width', 'Height'], start: [0.034, 1.6, 2.2], color: '#c9ccd2' },
  terrain: { name: 'Terrain', size: ['Length', 'Width', 'Height'], start: [8, 6, 0.3], color: '#7f8a6b' },
};

export const prop_shapes = Object.keys(prop_kinds) as PlainShape[];

/** Name of the group of tracks into which new props come, so that they can be folded together. */
export const props_group = 'Props';

/** The command that adds a prop near `at` (m), where it is clear of the characters. */
export function add_prop(doc: ScenarioDocument, shape: PlainShape, at: { x: number; y: number }, id: string): Command {
  const kind = prop_kinds[shape];
  return adding(doc, kind.name, kind.color, { shape, size: kind.start }, at, id);
}

/** Facts about a mesh in the library. */
export interface MeshFacts {
  /** Colour of each visible shape, '#rrggbb'; '': the file gives none. */
  colors?: string[];
  /** m */
  size?: Vec3;
  triangles?: number;
}

/** The command that adds a prop with the mesh of a library entry near `at` (m). */
export function add_mesh_prop(doc: ScenarioDocument, entry: { id: string; name: string; mesh?: MeshFacts }, at: { x: number; y: number }, id: string): Command {
  const colors = entry.mesh?.colors ?? [];
  const command = adding(doc, entry.name, '#b9bdc6', { shape: 'mesh', mesh: entry.id }, at, id);
  return colors.some(Boolean) ? { ...command, shape_colors: colors } : command;
}

type Adding = Extract<Command, { type: 'character.add' }>;

function adding(doc: ScenarioDocument, name: string, color: string, prop: Partial<Prop>, at: { x: number; y: number }, id: string): Adding {
  const round = (v: number): number => Math.round(v * 100) / 100;
  const place = free_place(doc, at);
  return {
    type: 'character.add', id, name: free_name(doc, name), color, group: props_group,
    place: { x: round(place.x), y: round(place.y), z: doc.ground?.height ?? 0 }, prop,
  };
}

/** Volume of a mesh body at its own scale, m³: its mass is that of its volume in water. */
export const mesh_volume = (body: { mass?: number }): number => (body.mass ?? 0) / 1000;

/** What a choice of the collision of a mesh means. */
export const collision_words: Record<MeshCollision, [name: string, meaning: string]> = {
  hull: ['Convex hull', 'Collides as if a skin were stretched over it: fast, but holes and hollows are filled.'],
  parts: ['Hull of each part', 'Each connected part of the mesh collides as its convex hull: legs of a table, steps of a ladder.'],
  surface: ['Exact surface', 'All triangles collide, from both sides: for floors, walls, bowls. Slower.'],
};
