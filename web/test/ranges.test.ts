import { expect, test } from 'vitest';
import { in_range, vector } from '../src/player/ranges';

test('a number in the range is returned; anything else is refused with its name', () => {
  expect(in_range('speed', 2, 0.05, 4)).toBe(2);
  for (const value of [NaN, -1, 1e300, Infinity, '1', null, undefined, {}]) expect(() => in_range('speed', value, 0.05, 4)).toThrow(/^speed is .*from 0.05 to 4/);
});

test('vectors have three finite numbers and a limited length', () => {
  expect(vector('force', [3, 4, 0], 5)).toEqual([3, 4, 0]);
  for (const value of [[1, 2], [1, 2, NaN], [1, 2, '3'], 'abc', null, undefined]) expect(() => vector('force', value, 5)).toThrow(/^force is not a list/);
  for (const value of [[3, 4.1, 0], [1e300, 0, 0], [0, 0, -6]]) expect(() => vector('force', value, 5)).toThrow(/longer than 5/);
});
