import { describe, expect, it } from 'vitest';
import { align, index_at, plot_csv } from '../src/core/plots';

const a = { name: 'Ann, "A": knee', times: [0, 0.1, 0.2], values: [1, 2, NaN] };
const b = { name: 'dynamics.substeps', times: [0.1, 0.15], values: [5, null] };

describe('plots', () => {
  it('put curves of different rates on one time axis', () => {
    expect(align([a, b])).toEqual({ times: [0, 0.1, 0.15, 0.2], values: [[1, 2, null, null], [null, 5, null, null]] });
    expect(align([])).toEqual({ times: [], values: [] });
  });
  it('are written as a table', () => {
    expect(plot_csv([a, b]).split('\r\n')).toEqual(['time_s,"Ann, ""A"": knee",dynamics.substeps', '0,1,', '0.1,2,5', '0.15,,', '0.2,,', '']);
  });
  it('find the value at a time', () => {
    expect([-1, 0, 0.14, 9].map((t) => index_at([0, 0.1, 0.2], t))).toEqual([-1, 0, 1, 2]);
  });
});
