import { describe, expect, it } from 'vitest';
import { first_choice, measured, plot_of, query_of, ticks, tick_text, varied, type SweepRows } from '../src/core/sweep';

const columns = ['number', 'target', 'push', 'push-angle', 'status', 'message', 'steps', 'processor_s', 'state_hash', 'tracking_rms_deg', 'assist_max_bw', 'fell'];
const table: SweepRows = {
  columns,
  rows: [
    [0, 'walk.bvh', 0, 0, 'done', null, 100, 0.1, '00a1', 2, 0.1, 0],
    [1, 'walk.bvh', 0, 90, 'done', null, 100, 0.1, '00a2', 2.2, 0.1, 0],
    [2, 'walk.bvh', 200, 0, 'done', null, 100, 0.1, '00a3', 4, 0.2, 0],
    [3, 'walk.bvh', 200, 90, 'timeout', 'too slow', null, null, null, null, null, null],
    [4, 'walk.bvh', 400, 0, 'done', null, 100, 0.1, '00a5', 9, 0.6, 1],
    [5, 'walk.bvh', 400, 90, 'done', null, 100, 0.1, '00a6', 11, 0.8, 1],
  ],
};

/** The row with another value in one column. */
const replaced = (row: SweepRows['rows'][number], column: number, value: string | number) => row.map((v, i) => (i === column ? value : v));

describe('columns of a sweep', () => {
  it('are varied quantities or measures', () => {
    expect(varied(table)).toEqual(['push', 'push-angle']);
    expect(measured(table)).toEqual(['tracking_rms_deg', 'assist_max_bw', 'fell', 'steps', 'processor_s']);
  });
  it('include the target if it varies', () => {
    const two = { ...table, rows: table.rows.map((row, i) => (i < 2 ? replaced(row, 1, 'run.bvh') : row)) };
    expect(varied(two)).toContain('target');
  });
  it('give the first plot', () => expect(first_choice(table)).toEqual({ x: 'push', y: 'fell', by: 'push-angle' }));
  it('give no plot without measures', () => expect(first_choice({ columns: columns.slice(0, 6), rows: [] })).toBeNull());
});

describe('plot of a sweep', () => {
  it('has a point for each finished run, and the mean of each series at each x', () => {
    const plot = plot_of(table, { x: 'push', y: 'tracking_rms_deg', by: '' });
    if (typeof plot === 'string') throw new Error(plot);
    expect(plot.points.map((p) => p.row)).toEqual([0, 1, 2, 4, 5]);
    expect(plot.means).toEqual([[{ x: 0, y: 2.1 }, { x: 200, y: 4 }, { x: 400, y: 10 }]]);
    expect(plot.x).toEqual([0, 400]);
    expect(plot.y).toEqual([0, 11]); // zero is shown
  });
  it('spaces words evenly', () => {
    const plot = plot_of({ ...table, rows: table.rows.map((row) => replaced(row, 2, row[2] === 0 ? 'none' : `push ${String(row[2])}`)) }, { x: 'push', y: 'fell', by: 'push-angle' });
    if (typeof plot === 'string') throw new Error(plot);
    expect(plot.words).toEqual(['none', 'push 200', 'push 400']);
    expect(plot.series).toEqual(['0', '90']);
    expect(plot.means[1]).toEqual([{ x: 0, y: 0 }, { x: 2, y: 1 }]);
  });
  it('widens the range of equal values', () => {
    const plot = plot_of(table, { x: 'push', y: 'steps', by: '' });
    expect(typeof plot === 'string' ? plot : plot.y).toEqual([90, 110]);
  });
  it('is refused without values, and with too many series', () => {
    expect(plot_of(table, { x: 'push', y: 'message', by: '' })).toMatch(/No run/);
    const many = { columns, rows: Array.from({ length: 20 }, (_, i) => replaced(table.rows[0]!, 3, i)) };
    expect(plot_of(many, { x: 'push', y: 'fell', by: 'push-angle' })).toMatch(/20 values/);
  });
});

describe('ticks', () => {
  it('have distances of 1, 2 or 5', () => {
    expect(ticks(0, 1, 5).map(tick_text)).toEqual(['0', '0.2', '0.4', '0.6', '0.8', '1']);
    expect(ticks(-3, 420, 8).map(tick_text)).toEqual(['0', '50', '100', '150', '200', '250', '300', '350', '400']);
  });
});

it('the query of a table names file or sweep', () => {
  expect(query_of({ table: 'a b.db', name: 'a b.db', runs: 1 })).toBe('table=a%20b.db');
  expect(query_of({ sweep: 'walk', name: 'walk', runs: 1 })).toBe('sweep=walk');
});
