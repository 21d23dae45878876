/** Props: bodies made from a few numbers, fixed in the world or moving as passive bodies. docs/scenario.md describes the fields. */
import { free_name, free_place, type Command, type ScenarioDocument } from './document';
import type { Vec3 } from './protocol';

export type PropShape = 'box' | 'ramp' | 'stairs' | 'cylinder' | 'sphere' | 'bar';

export interface Prop {
  shape: PropShape;
  /** m; props that do not use a component ignore it. */
  size: Vec3;
  /** Number of steps of stairs. Absent: 5. */
  steps?: number;
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

export const prop_kinds: Record<PropShape, Kind> = {
  box: { name: 'Box', size: ['Length', 'Width', 'Height'], start: [0.5, 0.5, 0.5], color: '#b08d63' },
  ramp: { name: 'Ramp', size: ['Length', 'Width', 'Height'], start: [3, 2, 0.4], color: '#8f9aa8' },
  stairs: { name: 'Stairs', size: ['Length', 'Width', 'Height'], start: [1.5, 2, 0.75], color: '#8f9aa8' },
  cylinder: { name: 'Cylinder', size: ['Diameter', '', 'Height'], start: [0.6, 0.6, 0.9], color: '#6f9a8d' },
  sphere: { name: 'Sphere', size: ['Diameter', '', ''], start: [0.4, 0.4, 0.4], color: '#c4706a' },
  bar: { name: 'Bar', size: ['Thickness', 'Width', 'Height'], start: [0.034, 1.6, 2.2], color: '#c9ccd2' },
};

export const prop_shapes = Object.keys(prop_kinds) as PropShape[];

/** Name of the group of tracks into which new props come, so that they can be folded together. */
export const props_group = 'Props';

/** The command that adds a prop near `at` (m), where it is clear of the characters. */
export function add_prop(doc: ScenarioDocument, shape: PropShape, at: { x: number; y: number }, id: string): Command {
  const kind = prop_kinds[shape];
  const round = (v: number): number => Math.round(v * 100) / 100;
  const place = free_place(doc, at);
  return {
    type: 'character.add', id, name: free_name(doc, kind.name), color: kind.color, group: props_group,
    place: { x: round(place.x), y: round(place.y), z: doc.ground?.height ?? 0 },
    prop: { shape, size: kind.start },
  };
}
