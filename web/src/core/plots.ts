/** Curves of joints and pins over time, and their table as CSV. */

/** A curve with its own time axis. */
export interface PlotCurve {
  /** Unique name, for example "Human: shank left.1" or "dynamics.substeps[0]". */
  name: string;
  /** Times of the samples, s, ascending. */
  times: readonly number[];
  /** Values; null or NaN: none. */
  values: readonly (number | null)[];
}

/** All curves over one time axis: the sorted times of all samples (s), and for each curve its value at each time, null where it has none. */
export function align(curves: readonly PlotCurve[]): { times: number[]; values: (number | null)[][] } {
  const times: number[] = [];
  const sorted = [...new Set(curves.flatMap((c) => c.times))].sort((a, b) => a - b);
  for (const t of sorted) if (times.length === 0 || t - times[times.length - 1]! > 1e-7) times.push(t);
  const values = curves.map((c) => {
    let i = 0;
    return times.map((t) => {
      while (i < c.times.length && c.times[i]! < t - 1e-7) i++;
      const value = i < c.times.length && Math.abs(c.times[i]! - t) <= 1e-7 ? c.values[i] : null;
      return value === undefined || value === null || !Number.isFinite(value) ? null : value;
    });
  });
  return { times, values };
}

/** A table with the column time_s and one column for each curve; empty cells where a curve has no value. */
export function plot_csv(curves: readonly PlotCurve[]): string {
  const { times, values } = align(curves);
  const quoted = (text: string): string => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const rows = times.map((t, i) => [Math.round(t * 1e6) / 1e6, ...values.map((list) => list[i] ?? '')].join(','));
  return [['time_s', ...curves.map((c) => quoted(c.name))].join(','), ...rows].join('\r\n') + '\r\n';
}

/** Index of the value at or just before `time` (s) in a sorted list; -1: none. */
export function index_at(times: readonly number[], time: number): number {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle]! <= time + 1e-7) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}
