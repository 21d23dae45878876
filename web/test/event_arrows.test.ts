import { describe, expect, it } from 'vitest';
import * as THREE from 'three';
import type { ScenarioDocument, ScenarioEvent } from '../src/core/document';
import { arrow_base, arrow_tip, arrow_vector, label_corner, rotated, with_axes, with_tip, type ArrowBase, type Rotation } from '../src/core/event_arrows';
import type { Frame } from '../src/core/frames';
import type { MechanismData } from '../src/core/protocol';

const push: ScenarioEvent = { id: 'e', type: 'push', time: 1, force: [150, 0, -25] };
const thrown: ScenarioEvent = { id: 't', type: 'throw', time: 1, velocity: [2, 0, 4] };
const still = (x: number, y: number, z: number): ArrowBase => ({ from: [x, y, z], rotation: [1, 0, 0, 0] });
/** A link that is turned by 90 degrees about the vertical axis: its x axis is the y axis of the world. */
const turned: ArrowBase = { from: [1, 2, 3], rotation: [Math.SQRT1_2, 0, 0, Math.SQRT1_2] };

describe('arrows of events', () => {
  it('have the direction of force or velocity, and a length in proportion', () => {
    expect(arrow_tip(push, still(1, 2, 3))).toEqual([1.6, 2, 2.9]);
    expect(arrow_tip({ ...push, force: [300, 0, -50] }, still(0, 0, 0))![0]).toBeCloseTo(1.2, 12);
    expect(arrow_tip(thrown, still(0, 0, 1))![2]).toBeCloseTo(1.6, 12);
    expect(arrow_vector({ id: 'g', type: 'grab', time: 0 })).toBeNull();
  });

  it('change the event by their tip, in whole newtons and within the limits', () => {
    expect(with_tip(push, still(1, 2, 3), [1.6, 2, 2.9])).toEqual({ force: [150, 0, -25] });
    expect(with_tip(push, still(0, 0, 0), [0.0499, -0.001, 0])).toEqual({ force: [12, 0, 0] });
    expect(with_tip(push, still(0, 0, 0), [9e9, 0, 0])).toEqual({ force: [100000, 0, 0] });
    expect(with_tip(thrown, still(0, 0, 1), [0.31, 0, 1])).toEqual({ velocity: [2.05, 0, 0] });
  });

  it('turn with the link if the force is in its axes', () => {
    const body: ScenarioEvent = { ...push, axes: 'body', force: [100, 0, 0] };
    const tip = arrow_tip(body, turned)!;
    [1, 2.4, 3].forEach((x, i) => expect(tip[i]).toBeCloseTo(x, 12));
    expect(with_tip(body, turned, [1, 2, 3.4])).toEqual({ force: [0, 0, 100] });
    expect(with_tip(body, turned, [1.4, 2, 3])).toEqual({ force: [0, -100, 0] });
    expect(arrow_tip({ ...body, axes: 'world' }, turned)).toEqual([1.4, 2, 3]);
  });

  it('stay where they are when the axes change', () => {
    const tilted: ArrowBase = { from: [0, 0, 1], rotation: [0.8, 0.1, -0.4, 0.3].map((x) => x / Math.hypot(0.8, 0.1, 0.4, 0.3)) as unknown as Rotation };
    const body = { ...push, ...with_axes(push, 'body', tilted) };
    expect(body.axes).toBe('body');
    expect(body.force).not.toEqual(push.force);
    const [before, after] = [arrow_tip(push, tilted)!, arrow_tip(body, tilted)!];
    before.forEach((x, i) => expect(after[i]).toBeCloseTo(x, 2));
    const back = { ...body, ...with_axes(body, 'world', tilted) };
    back.force!.forEach((x, i) => expect(Math.abs(x - push.force![i]!)).toBeLessThan(0.2));
    expect(with_axes(push, 'body', null)).toEqual({ axes: 'body' });
    expect(with_axes(push, 'world', tilted)).toEqual({ axes: 'world' });
  });

  it('rotate like three.js', () => {
    const q = new THREE.Quaternion(0.3, 0.5, -0.7, 0.2).normalize();
    const expected = new THREE.Vector3(1, 2, 3).applyQuaternion(q).toArray();
    rotated([q.w, q.x, q.y, q.z], [1, 2, 3]).forEach((x, i) => expect(x).toBeCloseTo(expected[i]!, 12));
  });

  it('begin at the pushed link, which the event names by its name or label', () => {
    const doc = { characters: [{ id: 'a', mechanism: 'm' }] } as unknown as ScenarioDocument;
    const mechanisms = { m: { links: [{ name: 'root', label: '' }, { name: 'l1', label: 'chest' }] } } as unknown as Record<string, MechanismData>;
    const frame = { floats: Float32Array.from([0, 0, 0, 1, 0, 0, 0, 4, 5, 6, 0, 0, 0, 1]), characters: [{ links: 2, poses: 0 }] } as unknown as Frame;
    for (const link of ['l1', 'chest']) expect(arrow_base({ ...push, character: 'a', link }, doc, mechanisms, [{ id: 'a' }], frame)).toEqual({ from: [4, 5, 6], rotation: [0, 0, 0, 1] });
    expect(arrow_base({ ...push, character: 'a', link: 'none' }, doc, mechanisms, [{ id: 'a' }], frame)).toBeNull();
    expect(arrow_base({ ...push, character: 'a', link: 'l1' }, doc, mechanisms, [{ id: 'a' }], null)).toBeNull();
  });
});

describe('the label of an arrow', () => {
  const box = { width: 800, height: 500 };
  const label = { width: 120, height: 20 };

  it('is beyond the tip if there is room', () => {
    expect(label_corner({ x: 400, y: 200 }, label, box, false)).toEqual({ x: 415, y: 190 });
    expect(label_corner({ x: 400, y: 200 }, label, box, true)).toEqual({ x: 265, y: 190 });
  });

  it('changes its side at an edge, and never leaves the viewport', () => {
    expect(label_corner({ x: 760, y: 200 }, label, box, false).x).toBe(625);
    expect(label_corner({ x: 40, y: 200 }, label, box, true).x).toBe(55);
    for (const left of [false, true])
      for (const x of [-300, 0, 60, 400, 790, 1200])
        for (const y of [-50, 3, 250, 499, 700]) {
          const corner = label_corner({ x, y }, label, box, left);
          expect(corner.x).toBeGreaterThanOrEqual(4);
          expect(corner.x + label.width).toBeLessThanOrEqual(796);
          expect(corner.y).toBeGreaterThanOrEqual(4);
          expect(corner.y + label.height).toBeLessThanOrEqual(496);
        }
  });
});
