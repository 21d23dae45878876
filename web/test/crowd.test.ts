import * as THREE from 'three';
import { describe, expect, it } from 'vitest';
import type { Frame } from '../src/core/frames';
import type { MechanismData } from '../src/core/protocol';
import { mechanism_geometries } from '../src/view/character_view';
import { Crowd } from '../src/view/crowd';
import { CrowdMember } from '../src/view/crowd_member';
import { make_body_surface } from '../src/view/body_surface';
import { body_and_machine, rigid_surface } from '../src/view/crowd_surface';

const sphere = { type: 'sphere', radius: 0.1, pose: [0.2, 0, 0, 1, 0, 0, 0] };
const robot = {
  id: 'm', name: 'Arm', dofs: 2, mass: 1, height: 1,
  links: [0, 1, 2].map((i) => ({ name: `link ${i}`, label: '', parent: i - 1, joint: 'revolute', dofs: 1, neutral: [i, 0, 0, 1, 0, 0, 0], shapes: i === 1 ? [] : [sphere] })),
} as unknown as MechanismData;
const geometries = mechanism_geometries(robot);
const quarter = Math.SQRT1_2; // a quarter turn about z
const poses = new Float32Array([1, 2, 3, quarter, 0, 0, quarter, 4, 5, 6, 1, 0, 0, 0, 7, 8, 9, 0, 1, 0, 0]);

/** Position of a point of a link by the packed motion, as the shader computes it. */
function moved(packed: Float32Array, link: number, point: THREE.Vector3): THREE.Vector3 {
  const at = 8 * link;
  return point.clone().applyQuaternion(new THREE.Quaternion(packed[at + 4], packed[at + 5], packed[at + 6], packed[at + 7])).add(new THREE.Vector3(packed[at], packed[at + 1], packed[at + 2]));
}

describe('a crowd', () => {
  it('moves a smooth surface as skinning with matrices does', () => {
    const rest = new THREE.Matrix4().compose(new THREE.Vector3(0.3, -0.4, 1), new THREE.Quaternion(0.5, 0.5, -0.5, 0.5), new THREE.Vector3(1, 1, 1));
    const inverse = rest.clone().invert();
    const [position, rotation] = [new THREE.Vector3(), new THREE.Quaternion()];
    inverse.decompose(position, rotation, new THREE.Vector3());
    const member = new CrowdMember('c', robot, geometries, '#ffffff');
    member.surface = { ...rigid_surface(robot, geometries), inverses: robot.links.map(() => ({ position, rotation })) };
    member.place_poses(poses, 0, 3);
    const pose = new THREE.Matrix4().compose(new THREE.Vector3(1, 2, 3), new THREE.Quaternion(0, 0, quarter, quarter), new THREE.Vector3(1, 1, 1));
    const point = new THREE.Vector3(0.7, 0.1, -0.2);
    expect(moved(member.packed, 0, point).distanceTo(point.clone().applyMatrix4(inverse).applyMatrix4(pose))).toBeLessThan(1e-6);
  });

  it('draws a machine that carries a body by its shapes, beside the smooth surface', () => {
    const shape = { type: 'sphere', radius: 0.1, pose: [0, 0, 0, 1, 0, 0, 0] };
    const links = Array.from({ length: 10 }, (_, i) => ({ name: `link ${i}`, label: i === 0 ? '' : `part ${i}`, parent: i - 1, joint: 'revolute', dofs: 1, neutral: [i, 0, 0, quarter, 0, 0, quarter], shapes: [shape] }));
    const cyclist = { ...robot, links } as unknown as MechanismData;
    const body = make_body_surface(cyclist)!;
    const shapes = mechanism_geometries(cyclist);
    const surface = body_and_machine(body, cyclist, shapes);
    const index = shapes[0]!.index!.count;
    const ranges = ({ shown, coarser, shadow }: typeof surface | typeof body) => [shown, ...coarser, shadow];
    ranges(surface).forEach((range, i) => expect(range.count).toBe(ranges(body)[i]!.count + index));
    expect(surface.geometry.index!.count).toBe(ranges(surface).reduce((sum, range) => sum + range.count, 0));
    const member = new CrowdMember('c', cyclist, shapes, '#ffffff');
    member.surface = surface;
    member.place_poses(new Float32Array(links.flatMap((_, i) => [5, i, 7, 1, 0, 0, 0])), 0, links.length);
    const last = surface.geometry.index!.getX(surface.shown.count - 1); // a vertex of the machine
    expect(surface.geometry.getAttribute('skinIndex').getX(last)).toBe(0);
    const drawn = moved(member.packed, 0, new THREE.Vector3().fromBufferAttribute(surface.geometry.getAttribute('position'), last));
    expect(drawn.distanceTo(new THREE.Vector3(5, 0, 7))).toBeCloseTo(0.1, 3);
  });

  it('places the targets of rays and the bounds where the links are drawn', () => {
    const member = new CrowdMember('c', robot, geometries, '#ffffff');
    member.surface = rigid_surface(robot, geometries);
    member.offset.set(10, 0, 0);
    member.place_poses(poses, 0, 3);
    const drawn = moved(member.packed, 0, new THREE.Vector3(0.2, 0, 0));
    expect(drawn.distanceTo(new THREE.Vector3(11, 2.2, 3))).toBeLessThan(1e-5);
    expect(member.spheres[0]!.center.distanceTo(drawn)).toBeLessThan(1e-3); // the drawn sphere has facets
    const ray = new THREE.Raycaster(new THREE.Vector3(11, 2.2, 8), new THREE.Vector3(0, 0, -1));
    expect(ray.intersectObject(member.group)[0]!.object.userData).toEqual({ character: 'c', link: 0 });
    member.place_poses(new Float32Array(21).fill(0).map((_, i) => (i % 7 === 3 ? 1 : 0)), 0, 3);
    expect(ray.intersectObject(member.group)).toHaveLength(0);
  });

  it('draws all characters of a mechanism in one call, metal in another', () => {
    const crowd = new Crowd();
    const members = Array.from({ length: 30 }, (_, i) => crowd.add(`c${i}`, robot, geometries, '#804020'));
    const drawn = (): number[] => crowd.group.children.filter((m) => m.visible).map((m) => ((m as THREE.Mesh).geometry as THREE.InstancedBufferGeometry).instanceCount);
    crowd.update();
    expect(drawn()).toEqual([30]);
    crowd.set_look(members[3]!, '#804020', { metalness: 1 }, new THREE.Texture());
    crowd.remove(members[7]!);
    crowd.update();
    expect(drawn()).toEqual([28, 1]);
  });

  it('marks the vertices of single links', () => {
    const member = new CrowdMember('c', robot, geometries, '#ffffff');
    expect(member.has_marks).toBe(false);
    member.emphasise(2, 'selected');
    expect(member.has_marks).toBe(true);
    expect([...member.marks.slice(8 * 2, 8 * 2 + 6)].map((v) => Number(v.toFixed(2)))).toEqual([1, 1, 1, 0, 0, 0.34]);
    member.emphasise(2, 'none');
    member.set_look('#000000', { link_colors: { 'link 0': '#ffffff' } });
    expect([member.marks[0], member.marks[16]]).toEqual([1, 0]);
    const { skinIndex } = rigid_surface(robot, geometries).geometry.attributes as Record<string, THREE.BufferAttribute>;
    expect(new Set(Array.from({ length: skinIndex!.count }, (_, i) => skinIndex!.getX(i)))).toEqual(new Set([0, 2]));
  });

  it('poses characters from a frame', () => {
    const member = new CrowdMember('c', robot, geometries, '#ffffff');
    member.surface = rigid_surface(robot, geometries);
    member.posed = false;
    const floats = new Float32Array(30);
    floats.set(poses, 5);
    member.place({ floats } as unknown as Frame, { links: 3, poses: 5, data: 0 });
    expect(member.posed).toBe(true);
    const root = new THREE.Vector3();
    expect(member.root(root) && root.toArray()).toEqual([1, 2, 3]);
  });
});
