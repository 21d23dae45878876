/** Tables of results of `ugoki bake`: which columns can be drawn, and the points of a plot. */

/** A table in the list of the service. `table` is a file, `sweep` a sweep in a shared library. */
export interface SweepEntry {
  table?: string;
  sweep?: string;
  name: string;
  runs: number;
}

export type Cell = number | string | null;
export interface SweepRows {
  columns: string[];
  rows: Cell[][];
}

/** Columns that describe a run instead of measuring it. */
const about = new Set(['number', 'target', 'status', 'message', 'state_hash']);
const first_measure = 'tracking_rms_deg'; // the columns of measures begin here
const best_measures = ['fell', 'assist_max_bw', 'tracking_rms_deg'];

const of_runs = (table: SweepRows, name: string): Cell[] => {
  const at = table.columns.indexOf(name);
  return at < 0 ? [] : table.rows.map((row) => row[at] ?? null);
};

/** Different values of a column, in the order of their first occurrence. */
const values_of = (table: SweepRows, name: string): Cell[] => [...new Set(of_runs(table, name).filter((v) => v !== null))];

/** Varied quantities of a sweep: the columns between `target` and `status`, and `target` if there are several. */
export function varied(table: SweepRows): string[] {
  const own = table.columns.slice(table.columns.indexOf('target') + 1, table.columns.indexOf('status'));
  return values_of(table, 'target').length > 1 ? [...own, 'target'] : own;
}

/** Columns with numbers that measure a run: the measures of `ugoki run`, then steps and processor time. */
export function measured(table: SweepRows): string[] {
  const inputs = new Set(varied(table));
  const numeric = table.columns.filter((c) => !about.has(c) && !inputs.has(c) && of_runs(table, c).some((v) => typeof v === 'number'));
  const begin = table.columns.indexOf(first_measure);
  return [...numeric.filter((c) => table.columns.indexOf(c) >= begin), ...numeric.filter((c) => table.columns.indexOf(c) < begin)];
}

export interface PlotChoice {
  x: string;
  y: string;
  /** Column whose values become series; '' for one series. */
  by: string;
}

export const max_series = 12;

/** The first plot of a table: the measure that differs most clearly, over the varied quantity with the most values. */
export function first_choice(table: SweepRows): PlotChoice | null {
  const inputs = [...varied(table)].sort((a, b) => values_of(table, b).length - values_of(table, a).length);
  const measures = measured(table);
  if (measures.length === 0) return null;
  const y = best_measures.find((m) => measures.includes(m) && values_of(table, m).length > 1) ?? measures[0]!;
  const by = inputs.slice(1).find((c) => values_of(table, c).length > 1 && values_of(table, c).length <= max_series) ?? '';
  return { x: inputs[0] ?? 'number', y, by };
}

export interface PlotPoint {
  x: number;
  y: number;
  series: number;
  /** Index of the run in the table. */
  row: number;
}
export interface SweepPlot {
  points: PlotPoint[];
  /** Texts at x = 0, 1, 2 ... if the horizontal axis has words; null if it has numbers. */
  words: string[] | null;
  series: string[];
  /** Mean y of each series at each x, ascending. */
  means: { x: number; y: number }[][];
  /** Ranges of the axes. */
  x: [number, number];
  y: [number, number];
}

const widened = (low: number, high: number): [number, number] => {
  if (high > low) return [low, high];
  const margin = low === 0 ? 1 : 0.1 * Math.abs(low);
  return [low - margin, high + margin];
};

/** The points of a plot. A text states why there is none. */
export function plot_of(table: SweepRows, { x, y, by }: PlotChoice): SweepPlot | string {
  const [at_x, at_y, at_by, status] = [x, y, by, 'status'].map((name) => table.columns.indexOf(name)) as [number, number, number, number];
  const done = table.rows.map((row, i) => ({ row, i })).filter(({ row }) => row[status] === 'done' && row[at_x] !== null && typeof row[at_y] === 'number');
  if (done.length === 0) return 'No run has a value of both columns.';
  const numeric = done.every(({ row }) => typeof row[at_x] === 'number');
  const words = numeric ? null : [...new Set(done.map(({ row }) => String(row[at_x])))];
  const series = at_by < 0 ? [''] : [...new Set(done.map(({ row }) => String(row[at_by] ?? '')))];
  if (series.length > max_series) return `“${by}” has ${series.length} values; at most ${max_series} can be drawn as series.`;
  const points = done.map(({ row, i }) => ({
    x: words ? words.indexOf(String(row[at_x])) : (row[at_x] as number),
    y: row[at_y] as number,
    series: at_by < 0 ? 0 : series.indexOf(String(row[at_by] ?? '')),
    row: i,
  }));
  const means = series.map((_, s) => {
    const sums = new Map<number, [number, number]>();
    for (const p of points) {
      if (p.series !== s) continue;
      const [sum, count] = sums.get(p.x) ?? [0, 0];
      sums.set(p.x, [sum + p.y, count + 1]);
    }
    return [...sums].sort(([a], [b]) => a - b).map(([at, [sum, count]]) => ({ x: at, y: sum / count }));
  });
  const range = (key: 'x' | 'y'): [number, number] => points.reduce(([low, high], p) => [Math.min(low, p[key]), Math.max(high, p[key])], [Infinity, -Infinity] as [number, number]);
  let [low, high] = range('y');
  if (low > 0 && low < 0.5 * high) low = 0; // show zero if the points then fill at least half of the axis
  return { points, words, series, means, x: widened(...range('x')), y: widened(low, high) };
}

/** About `count` ticks between two numbers; their distance is 1, 2 or 5 times a power of ten. */
export function ticks(low: number, high: number, count: number): number[] {
  const raw = (high - low) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(raw));
  const unit = raw / power;
  const step = power * (unit < 1.5 ? 1 : unit < 3.5 ? 2 : unit < 7.5 ? 5 : 10);
  const out: number[] = [];
  const slack = 1e-9; // part of the distance: keeps a tick at the end of the axis in spite of rounding
  for (let k = Math.ceil(low / step - slack); k * step <= high + slack * step; k++) out.push(k * step);
  return out;
}

/** A value of a tick without superfluous digits. */
export const tick_text = (value: number): string => (Math.abs(value) < 1e-12 ? '0' : String(Number(value.toPrecision(6))));

/** Query of a table for the service. */
export const query_of = (entry: SweepEntry): string => (entry.sweep ? `sweep=${encodeURIComponent(entry.sweep)}` : `table=${encodeURIComponent(entry.table ?? '')}`);
