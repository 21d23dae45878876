import * as THREE from 'three';
import { describe, expect, it, vi } from 'vitest';
import { apply_command, type ScenarioDocument } from '../src/core/document';
import { ImportQueue } from '../src/core/library/imports';
import { add_mesh_prop, mesh_volume } from '../src/core/props';
import type { MechanismData } from '../src/core/protocol';
import { CharacterView, mechanism_geometries, shape_colors } from '../src/view/character_view';
import { Crowd } from '../src/view/crowd';

const at = (x: number): number[] => [x, 0, 0, 1, 0, 0, 0];
/** Two links: one with two boxes, one with a sphere. */
const table = {
  id: 'm-table', name: 'Table', mass: 250,
  links: [
    { name: 'body', parent: -1, joint: 'fixed', dofs: 0, neutral: at(0), shapes: [{ type: 'box', half_extents: [1, 1, 0.1], pose: at(0) }, { type: 'box', half_extents: [0.1, 0.1, 1], pose: at(1) }] },
    { name: 'knob', parent: 0, joint: 'fixed', dofs: 0, neutral: at(2), shapes: [{ type: 'sphere', radius: 0.1, pose: at(0) }] },
  ],
} as unknown as MechanismData;
const geometries = mechanism_geometries(table);
const counts = geometries.map((g) => g!.getAttribute('position').count);
const linear = (color: string): number[] => new THREE.Color(color).toArray();
const near = (values: ArrayLike<number>, wanted: number[]): void => wanted.forEach((w, i) => expect(values[i]).toBeCloseTo(w, 5));

describe('props from meshes', () => {
  it('are added with the colours of their file, in the group of props', () => {
    const doc = { characters: [], ground: { height: 0.5 } } as unknown as ScenarioDocument;
    const entry = { id: 'm-1', name: 'Chair', mesh: { colors: ['#112233', ''] } };
    const command = add_mesh_prop(doc, entry, { x: 1.234, y: 2 }, 'p1');
    expect(command).toMatchObject({ type: 'character.add', name: 'Chair', group: 'Props', place: { x: 1.23, y: 2, z: 0.5 }, prop: { shape: 'mesh', mesh: 'm-1' }, shape_colors: ['#112233', ''] });
    expect(add_mesh_prop(doc, { id: 'm-1', name: 'Chair', mesh: { colors: [''] } }, { x: 0, y: 0 }, 'p1')).not.toHaveProperty('shape_colors');
    expect(mesh_volume(table)).toBe(0.25);
  });

  it('keep scale and collision when one field changes', () => {
    const prop = { shape: 'mesh' as const, mesh: 'm-1', scale: [1, 2, 3] as [number, number, number], collision: 'parts' as const, mass: 0, friction: 1, restitution: 0 };
    const doc = { characters: [{ id: 'p1', name: 'Chair', mechanism: '', place: { x: 0, y: 0, z: 0, heading: 0 }, control: {}, track: [], prop }] } as unknown as ScenarioDocument;
    const changed = apply_command(doc, { type: 'character.set', id: 'p1', prop: { mass: 4 } });
    expect(changed!.characters[0]!.prop).toEqual({ ...prop, mass: 4 });
  });

  it('have a colour for each shape, and that of the link where there is none', () => {
    const [body, knob] = shape_colors(geometries, ['#ff8000', '', '#0000ff'], () => false);
    const box = counts[0]! / 2;
    near(body!.subarray(0, 4), [...linear('#ff8000'), 1]);
    near(body!.subarray(4 * (box - 1), 4 * box), [...linear('#ff8000'), 1]);
    near(body!.subarray(4 * box, 4 * box + 4), [0, 0, 0, 0]);
    near(knob!, [...linear('#0000ff'), 1]);
    expect(shape_colors(geometries, ['#ff8000'], (link) => link === 0)[0]!.every((v) => v === 0)).toBe(true);
  });

  it('are drawn by a crowd with one call for each set of colours', () => {
    const crowd = new Crowd();
    const [a, b] = [crowd.add('a', table, geometries, '#ffffff'), crowd.add('b', table, geometries, '#ffffff')];
    const painted = (): number => crowd.group.children.filter((m) => m.visible && (m as THREE.Mesh).geometry.hasAttribute('own_color')).length;
    crowd.update();
    expect(painted()).toBe(0);
    crowd.set_look(a, '#ffffff', { shape_colors: ['#ff0000'] }, null);
    crowd.set_look(b, '#ffffff', { shape_colors: ['#ff0000'] }, null);
    crowd.update();
    expect(painted()).toBe(1);
    const values = (crowd.group.children.find((m) => (m as THREE.Mesh).geometry.hasAttribute('own_color')) as THREE.Mesh).geometry.getAttribute('own_color');
    expect(values.count).toBe(counts[0]! + counts[1]!);
    // many colours one after the other leave no drawn objects behind
    for (let i = 0; i < 40; i++) {
      crowd.set_look(a, '#ffffff', { shape_colors: [`#0000${(16 + i).toString(16)}`] }, null);
      crowd.update();
    }
    expect(painted()).toBe(2);
    expect(crowd.group.children.length).toBeLessThanOrEqual(6);
    crowd.set_look(a, '#ffffff', {}, null);
    crowd.set_look(b, '#ffffff', { shape_colors: ['#ff0000'], link_colors: { body: '#00ff00', knob: '#00ff00' } }, null);
    crowd.update();
    expect(painted()).toBe(1);
    crowd.dispose();
  });

  it('are drawn in pages with vertex colours that other characters do not share', () => {
    const view = new CharacterView('a', table, geometries, '#808080', null);
    view.set_look('#808080', { shape_colors: ['#ff0000'] });
    const body = view.links[0]!;
    expect((body.material as THREE.MeshStandardMaterial).vertexColors).toBe(true);
    expect(geometries[0]!.hasAttribute('color')).toBe(false);
    const colors = body.geometry.getAttribute('color');
    near([colors.getX(0), colors.getY(0)], linear('#ff0000').slice(0, 2));
    near([colors.getX(colors.count - 1)], linear('#808080').slice(0, 1)); // the second box has none
    view.set_look('#808080', {});
    expect((body.material as THREE.MeshStandardMaterial).vertexColors).toBe(false);
    expect((body.material as THREE.MeshStandardMaterial).color.getHexString()).toBe('808080');
  });
});

describe('mesh files', () => {
  const file = (name: string): File => Object.assign(new Blob(['x']), { name, lastModified: 0, webkitRelativePath: '' });
  const make = () => {
    const asked: string[] = [];
    const answer = (path: string) => (path.includes('store') ? { entries: [{ id: 'm-1', kind: 'mechanism', name: 'Chair' }] } : { stage: 'i1', mesh: { colors: [] }, settings: {}, can: {}, entries: [], report: {} });
    const host = { fetch: async (path: string) => { asked.push(path); return new Response(JSON.stringify(answer(path))); }, log: vi.fn(), stored: vi.fn() };
    return { queue: new ImportQueue(host), asked, host };
  };

  it('are read on their own, with their materials, but belong to a robot description beside them', async () => {
    const { queue, asked } = make();
    await queue.add([file('chair.obj'), file('chair.mtl')], { x: 1, y: 2 });
    expect(asked).toEqual(['api/import/file?name=chair.mtl', 'api/import/stage?name=chair.obj']);
    expect(queue.state.items[0]).toMatchObject({ prop_at: { x: 1, y: 2 }, status: 'ready' });
    const other = make();
    await other.queue.add([file('arm.urdf'), file('link.stl')]);
    expect(other.asked).toEqual(['api/import/file?name=link.stl', 'api/import/stage?name=arm.urdf']);
  });

  it('report where they become props when they are stored', async () => {
    const { queue, host } = make();
    await queue.add([file('chair.glb')], { x: 3, y: 0 });
    await queue.store_one(queue.state.items[0]!.id);
    expect(host.stored).toHaveBeenCalledWith(expect.objectContaining({ prop_at: { x: 3, y: 0 }, staged: expect.objectContaining({ mesh: { colors: [] } }) }));
  });
});
