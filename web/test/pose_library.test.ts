import { describe, expect, it } from 'vitest';
import { apply_command } from '../src/core/document';
import { find_poses, fits, new_pose_name, scope_links, store_pose, type StoredPose } from '../src/core/posing/pose_library';
import type { LinkData, MechanismData } from '../src/core/protocol';
import { sample_document } from './sample';

const link = (name: string, parent: number): LinkData => ({ name, parent, joint: 'revolute', dofs: 1, shapes: [] });
const body: MechanismData = { id: 'm-1', name: 'body', dofs: 5, mass: 1, height: 1, links: [link('hips', -1), link('chest', 0), link('arm', 1), link('hand', 2), link('leg', 0)] };
const pose = (id: string, name: string, more: Partial<StoredPose> = {}): StoredPose => ({ id, name, mechanism: 'm-1', joints: [{ link: 'arm', q: [1] }], ...more });

describe('stored poses', () => {
  it('fit their own mechanism and those that have all their links', () => {
    expect(fits(pose('p1', 'Guard'), body)).toBe(true);
    expect(fits(pose('p1', 'Guard'), { ...body, id: 'm-2' })).toBe(true);
    expect(fits(pose('p1', 'Guard'), { ...body, id: 'm-2', links: body.links.filter((l) => l.name !== 'arm') })).toBe(false);
  });
  it('are found by all words of their name', () => {
    const doc = { ...sample_document(), poses: [pose('p1', 'Kick, high'), pose('p2', 'Kick, low'), pose('p3', 'Other', { mechanism: 'm-9', joints: [{ link: 'wing', q: [0] }] })] };
    expect(find_poses(doc, body, 'high kick').map((p) => p.id)).toEqual(['p1']);
    expect(find_poses(doc, body, '').map((p) => p.id)).toEqual(['p1', 'p2']);
    expect(new_pose_name(doc)).toBe('Pose 4');
    expect(new_pose_name({ ...doc, poses: [pose('p1', 'Pose 2')] })).toBe('Pose 3');
  });
  it('set the joints of their scope', () => {
    expect(scope_links(body, 'all', 2)).toBeUndefined();
    expect(scope_links(body, 'joints', undefined)).toEqual(['chest', 'arm', 'hand', 'leg']);
    expect(scope_links(body, 'limb', 2)).toEqual(['arm', 'hand']);
    expect(scope_links(body, 'limb', 0)).toHaveLength(5);
  });
  it('are stored, renamed and removed by commands', () => {
    let doc = apply_command(sample_document(), store_pose('p1', 'Guard', 'm-1', [{ link: 'arm', q: [1] }]));
    doc = apply_command(doc, { type: 'pose.add', pose: pose('p0', 'First'), at: 0 });
    doc = apply_command(doc, { type: 'pose.set', id: 'p1', pose: { name: 'Block' } });
    expect(doc.poses!.map((p) => p.name)).toEqual(['First', 'Block']);
    expect(apply_command(doc, { type: 'pose.remove', id: 'p0' }).poses!.map((p) => p.id)).toEqual(['p1']);
  });
});
