import { describe, expect, it } from 'vitest';
import { can_stop_at, components_of, condition_alone, relations, takes_value, write_condition } from '../src/core/circuit/breakpoints';

describe('conditions of breakpoints', () => {
  it('are written in the format of the service', () => {
    expect(write_condition('g.out', 0, '>', 0.5)).toBe('g.out > 0.5');
    expect(write_condition('arm/elbow.out', 2, '<', -1e-7)).toBe('arm/elbow.out[2] < -1e-7');
    expect(write_condition('key.pressed', 0, 'becomes true', 3)).toBe('key.pressed becomes true');
    expect(write_condition('g.out', 1, 'changes', 3)).toBe('g.out[1] changes');
    expect(relations.filter(([sign]) => !takes_value(sign)).map(([sign]) => sign)).toEqual(['becomes true', 'changes']);
  });
  it('are shown without the pin', () => {
    expect(condition_alone({ condition: 'arm/elbow.out[2] < 3', pin: 'arm/elbow.out' })).toBe('[2] < 3');
    expect(condition_alone({ condition: ' g.out>3', pin: 'g.out' })).toBe('g.out>3');
  });
  it('are possible only for numeric pin types', () => {
    expect(['scalar', 'pose', 'contacts', 'event'].map(can_stop_at)).toEqual([true, true, false, false]);
    expect(components_of('pose')).toHaveLength(7);
    expect(components_of('joint values')).toBeNull();
  });
});
