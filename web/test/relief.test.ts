import * as THREE from 'three';
import { describe, expect, it } from 'vitest';
import type { HeightFieldSurface, MechanismData } from '../src/core/protocol';
import { CharacterView, mechanism_geometries } from '../src/view/character_view';
import { rigid_surface } from '../src/view/crowd_surface';
import { field_height, standing, type DrawnBody } from '../src/view/ground';
import { contour_distance, draw_relief, relief_attribute } from '../src/view/relief';

const packed = (values: number[]): string => btoa(String.fromCharCode(...new Uint8Array(new Float32Array(values).buffer)));
/** 2 m x 2 m; the middle is 0.5 m high, and the corner at the largest x and y 0.2 m. */
const field: HeightFieldSurface = { columns: 3, rows: 3, half_x: 1, half_y: 1, base: 0.2, heights: packed([0, 0, 0, 0, 0.5, 0, 0, 0, 0.2]) };
const at = (x: number, y: number, z: number): number[] => [x, y, z, 1, 0, 0, 0];
const hills = { id: 'hills', name: 'Hills', links: [{ name: 'body', parent: -1, joint: 'fixed', dofs: 0, neutral: at(0, 0, 0), shapes: [{ type: 'height_field', surface: 's', pose: at(0, 0, 0) }] }], surfaces: { s: field } } as unknown as MechanismData;
const box = (size: number, pose = at(0, 0, 0)): MechanismData => ({ id: 'box', name: 'Box', links: [{ name: 'body', parent: -1, joint: 'fixed', dofs: 0, neutral: at(0, 0, 0), shapes: [{ type: 'box', half_extents: [size, size, size], pose }] }] }) as unknown as MechanismData;

function drawn(mechanism: MechanismData, x: number, y: number, z: number): DrawnBody {
  const links = mechanism_geometries(mechanism).map((geometry) => {
    const mesh = new THREE.Mesh(geometry!, new THREE.MeshBasicMaterial());
    mesh.matrixWorld.makeTranslation(x, y, z);
    return mesh;
  });
  return { mechanism, links };
}

describe('the relief of height fields', () => {
  it('has about nine contour lines at round distances', () => {
    for (const height of [0.005, 0.03, 0.3, 1.2, 7, 40, 1000]) {
      const distance = contour_distance(height);
      expect(height / distance).toBeGreaterThan(3.5);
      expect(height / distance).toBeLessThan(12);
      expect([1, 2, 5, 10]).toContain(Math.round(distance / 10 ** Math.floor(Math.log10(distance) + 1e-9)));
    }
    expect(contour_distance(0)).toBe(1);
  });

  it('is drawn by the materials of the studio and of pages alike, and by no others', () => {
    const geometries = mechanism_geometries(hills);
    const relief = geometries[0]!.getAttribute(relief_attribute);
    const top = 4; // the point in the middle
    expect(relief.getX(top) * contour_distance(0.5)).toBeCloseTo(0.5, 5);
    expect(relief.getY(top)).toBeGreaterThan(relief.getY(0));
    expect(rigid_surface(hills, geometries).geometry.hasAttribute(relief_attribute)).toBe(true);
    const material = (m: MechanismData): THREE.Material => new CharacterView('c', m, mechanism_geometries(m), '#808080').links[0]!.material as THREE.Material;
    expect(material(hills).onBeforeCompile).toBe(draw_relief);
    expect(material(box(1)).onBeforeCompile).not.toBe(draw_relief);
    const { vertexShader, fragmentShader } = THREE.ShaderLib.standard!;
    const shader = { vertexShader, fragmentShader } as THREE.WebGLProgramParametersWithUniforms;
    draw_relief(shader); // throws if three.js has changed
    expect(shader.fragmentShader).toContain('v_relief.y');
  });

  it('is kept beside links without one', () => {
    const both = { ...hills, links: [...hills.links, box(1).links[0]!] } as MechanismData;
    const geometries = mechanism_geometries(both);
    expect([...geometries[1]!.getAttribute(relief_attribute).array].every((value) => value === 0)).toBe(true);
    expect(rigid_surface(both, geometries).geometry.getAttribute(relief_attribute).count).toBe(geometries[0]!.getAttribute('position').count + geometries[1]!.getAttribute('position').count);
  });
});

describe('standing on the ground', () => {
  const ball = box(0.1);
  const props = (...list: [string, DrawnBody][]): Map<string, DrawnBody> => new Map(list);

  it('finds the height of a field in its triangles', () => {
    expect(field_height(field, 0, 0)).toBeCloseTo(0.5, 6);
    expect(field_height(field, 0.5, 0.5)).toBeCloseTo(0.35, 6); // on the diagonal from 0.5 to 0.2
    expect(field_height(field, 0.75, 0.5)).toBeCloseTo(0.225, 6); // right of it: 0.5 - 0.75 * 0.5 + 0.5 * 0.2 in the cell
    expect(field_height(field, 0.5, 0.75)).toBeCloseTo(0.225, 6);
    expect(field_height(field, 1, 1)).toBeCloseTo(0.2, 6);
    expect(field_height(field, 1.01, 0)).toBeNull();
    // independent: a ray to the drawn surface
    const mesh = drawn(hills, 0, 0, 0).links[0]!;
    for (const [x, y] of [[0.3, 0.1], [-0.7, 0.4], [0.6, 0.9], [-0.2, -0.35]] as const) {
      const hit = new THREE.Raycaster(new THREE.Vector3(x, y, 5), new THREE.Vector3(0, 0, -1)).intersectObject(mesh)[0]!;
      expect(field_height(field, x, y)).toBeCloseTo(hit.point.z, 5);
    }
  });

  it('is on the floor without props, and on hills where they are higher', () => {
    expect(standing(drawn(ball, 0, 0, 0.05), props(), 0)!.lift).toBeCloseTo(0.05, 6);
    const on_hill = standing(drawn(ball, 3, 2, 0.1), props(['h', drawn(hills, 3, 2, 1)]), 0)!;
    expect(on_hill.prop).toBe('h');
    expect(on_hill.lift).toBeGreaterThan(1.4); // the drawn edges are round, so that the bottom is a little smaller than 0.2 m
    expect(on_hill.lift).toBeLessThanOrEqual(1.5 + 1e-6);
    expect(standing(drawn(ball, 3, 2, 2), props(['h', drawn(hills, 3, 2, 1)]), 0)!.lift).toBeLessThan(-0.3);
    expect(standing(drawn(ball, 9, 9, 0.1), props(['h', drawn(hills, 3, 2, 1)]), 0)!.prop).toBeNull();
  });

  it('is on a platform that it has entered, but not on a roof above it', () => {
    const platform = standing(drawn(box(0.5), 0, 0, 0.5), props(['p', drawn(box(1, at(0, 0, -0.7)), 0, 0, 0)]), 0)!;
    expect(platform.prop).toBe('p');
    expect(platform.lift).toBeCloseTo(0.3, 3);
    expect(standing(drawn(box(0.5), 0, 0, 0.5), props(['p', drawn(box(1, at(0, 0, 4)), 0, 0, 0)]), 0)!.prop).toBeNull();
  });
});
