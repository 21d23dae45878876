import { describe, expect, it } from 'vitest';
import type { ScenarioEvent } from '../src/core/document';
import { event_rows, max_rows, next_time } from '../src/core/event_rows';

const event = (id: string, time: number, duration?: number): ScenarioEvent => ({ id, type: 'push', time, ...(duration === undefined ? {} : { duration }) }) as ScenarioEvent;

describe('rows of events', () => {
  it('puts events at the same time below each other, and events after each other in one row', () => {
    const rows = event_rows([event('late', 2, 0.2), event('a', 0.5, 0.2), event('b', 0.5, 0.2), event('during', 0.6, 1), event('after', 1, 0.1)]);
    expect(Object.fromEntries(rows)).toEqual({ a: 0, b: 1, during: 2, after: 0, late: 0 });
  });

  it('separates events without duration at the same time', () => {
    expect([...event_rows([event('a', 1), event('b', 1), event('c', 1.1)]).values()]).toEqual([0, 1, 0]);
  });

  it('has a last row that more events share, without room for the text of the earlier one', () => {
    const many = Array.from({ length: max_rows + 2 }, (_, i) => event(`e${i}`, 1, 0.2));
    const rows = event_rows(many);
    expect(Math.max(...rows.values())).toBe(max_rows - 1);
    const last = many.filter((e) => rows.get(e.id) === max_rows - 1);
    expect(last.map((e) => next_time(last, e))).toEqual([1, 1, Infinity]);
  });
});
