import { describe, expect, it } from 'vitest';
import type { ScenarioEvent } from '../src/core/document';
import { arrow_tip, arrow_vector, with_tip } from '../src/core/event_arrows';

const push: ScenarioEvent = { id: 'e', type: 'push', time: 1, force: [150, 0, -25] };
const thrown: ScenarioEvent = { id: 't', type: 'throw', time: 1, velocity: [2, 0, 4] };

describe('arrows of events', () => {
  it('have the direction of force or velocity, and a length in proportion', () => {
    expect(arrow_tip(push, [1, 2, 3])).toEqual([1.6, 2, 2.9]);
    expect(arrow_tip({ ...push, force: [300, 0, -50] }, [0, 0, 0])![0]).toBeCloseTo(1.2, 12);
    expect(arrow_tip(thrown, [0, 0, 1])![2]).toBeCloseTo(1.6, 12);
    expect(arrow_vector({ id: 'g', type: 'grab', time: 0 })).toBeNull();
  });

  it('change the event by their tip, in whole newtons and within the limits', () => {
    expect(with_tip(push, [1, 2, 3], [1.6, 2, 2.9])).toEqual({ force: [150, 0, -25] });
    expect(with_tip(push, [0, 0, 0], [0.0499, -0.001, 0])).toEqual({ force: [12, 0, 0] });
    expect(with_tip(push, [0, 0, 0], [9e9, 0, 0])).toEqual({ force: [100000, 0, 0] });
    expect(with_tip(thrown, [0, 0, 1], [0.31, 0, 1])).toEqual({ velocity: [2.05, 0, 0] });
  });
});
