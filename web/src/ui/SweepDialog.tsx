/** The dialog that draws the results of a sweep (`ugoki bake`): a measure over a varied quantity. */
import { useEffect, useLayoutEffect, useMemo, useRef, useState, type ReactElement } from 'react';
import { first_choice, measured, plot_of, query_of, tick_text, ticks, varied, type Cell, type PlotChoice, type SweepEntry, type SweepPlot, type SweepRows } from '../core/sweep';
import { download } from './actions';
import { access, plain_canvas, session, useStudio } from './app';
import { Backdrop } from './dialogs';
import { Icon } from './icons';

const close = (): void => session.set({ dialog: 'none' });
const height = 380; // px of the plot
const margin = { left: 64, right: 16, top: 14, bottom: 46 }; // px around the plotted area
const near = 12; // px: distance of the pointer from a dot that it shows

/** Sends a request. Errors of the service become messages for the user. */
async function ask(path: string): Promise<Response> {
  const answer = await access.fetch(path);
  if (answer.ok) return answer;
  const body = (await answer.json().catch(() => null)) as { error?: { problems?: { message: string; remedy?: string }[] } } | null;
  const problem = body?.error?.problems?.[0];
  throw new Error(problem ? [problem.message, problem.remedy].filter(Boolean).join(' ') : `The studio answered with the status ${answer.status}.`);
}

export function SweepDialog(): ReactElement {
  const [list, set_list] = useState<{ folder: string; tables: SweepEntry[] } | null>(null);
  const [entry, set_entry] = useState<SweepEntry | null>(null);
  const [path, set_path] = useState('');
  const [table, set_table] = useState<SweepRows | null>(null);
  const [choice, set_choice] = useState<PlotChoice | null>(null);
  const [error, set_error] = useState('');
  const report = (e: unknown): void => set_error((e as Error).message);
  const load_list = (): void => {
    ask('api/sweeps').then(async (answer) => {
      const found = (await answer.json()) as { folder: string; tables: SweepEntry[] };
      set_list(found);
      set_entry((old) => old ?? found.tables[0] ?? null);
    }).catch(report);
  };
  useEffect(load_list, []);
  const load = (wanted: SweepEntry): void => {
    set_error('');
    ask(`api/sweeps/rows?${query_of(wanted)}`).then(async (answer) => {
      const rows = (await answer.json()) as SweepRows;
      set_table(rows);
      const known = (c: PlotChoice | null): boolean => c !== null && [c.x, c.y, ...(c.by ? [c.by] : [])].every((name) => rows.columns.includes(name));
      set_choice((old) => (known(old) ? old : first_choice(rows)));
    }).catch((e) => {
      set_table(null);
      report(e);
    });
  };
  useEffect(() => {
    if (entry) load(entry);
  }, [entry]);
  const plot = useMemo(() => (table && choice ? plot_of(table, choice) : null), [table, choice]);
  const stem = entry?.name.replace(/\.db$/, '').split('/').pop() ?? 'sweep';
  const save = (form: 'plot' | 'csv', name: string): void => {
    if (!entry) return;
    const columns = choice ? `&x=${encodeURIComponent(choice.x)}&y=${encodeURIComponent(choice.y)}&by=${encodeURIComponent(choice.by)}` : '';
    ask(`api/sweeps/${form}?${query_of(entry)}${form === 'plot' ? columns : ''}`).then(async (answer) => download(await answer.blob(), name)).catch(report);
  };
  const tables = list ? (entry && !list.tables.some((t) => query_of(t) === query_of(entry)) ? [entry, ...list.tables] : list.tables) : [];
  const failed = table ? table.rows.filter((row) => row[table.columns.indexOf('status')] !== 'done').length : 0;
  return (
    <Backdrop label="Results of sweeps">
      <div className="sweep">
        <div className="keys-head">
          <h2>Results of sweeps</h2>
          <button type="button" className="tool" aria-label="Read the table again" title="Read the table again" disabled={!entry} onClick={() => { load_list(); if (entry) load(entry); }}>
            <Icon name="loop" />
          </button>
          <button type="button" className="tool" aria-label="Close" title="Close  (Esc)" onClick={close}>
            <Icon name="close" />
          </button>
        </div>
        <form className="sweep-choice" onSubmit={(e) => { e.preventDefault(); if (path.trim()) set_entry({ table: path.trim(), name: path.trim(), runs: 0 }); }}>
          <label>
            Table
            <select autoFocus value={entry ? query_of(entry) : ''} disabled={tables.length === 0} onChange={(e) => set_entry(tables.find((t) => query_of(t) === e.target.value) ?? null)}>
              {tables.length === 0 && <option value="">none</option>}
              {tables.map((t) => (
                <option key={query_of(t)} value={query_of(t)}>{t.name}{t.runs > 0 ? ` – ${t.runs} runs` : ''}{t.sweep ? ' (library)' : ''}</option>
              ))}
            </select>
          </label>
          <label className="sweep-path">
            Other file
            <input value={path} placeholder="folder/table.db, then Enter" spellCheck={false} onChange={(e) => set_path(e.target.value)} />
          </label>
          {table && choice && (
            <>
              <Choice label="Measure" value={choice.y} names={measured(table)} change={(y) => set_choice({ ...choice, y })} />
              <Choice label="Over" value={choice.x} names={[...varied(table), 'number', ...measured(table)]} change={(x) => set_choice({ ...choice, x, by: choice.by === x ? '' : choice.by })} />
              <Choice label="Series" value={choice.by} names={['', ...varied(table).filter((c) => c !== choice.x)]} change={(by) => set_choice({ ...choice, by })} />
            </>
          )}
        </form>
        {error ? (
          <p className="sweep-none" role="alert">{error}</p>
        ) : list && !entry ? (
          <p className="sweep-none">
            There is no table of results in {list.folder}. Compute one with <code>ugoki bake PROJECT --vary push=0:400:9 --table push.db</code>, or name another file.
          </p>
        ) : typeof plot === 'string' ? (
          <p className="sweep-none">{plot}</p>
        ) : plot && table && choice ? (
          <Plot plot={plot} table={table} choice={choice} />
        ) : (
          <p className="sweep-none">{table ? 'The table has no measures.' : 'Loading…'}</p>
        )}
        <div className="actions">
          {table && <span className="sweep-count">{table.rows.length} runs{failed > 0 ? `, of which ${failed} without result` : ''}</span>}
          <button type="button" disabled={!entry || !table} onClick={() => save('csv', `${stem}.csv`)}>Save CSV</button>
          <button type="button" className="primary" disabled={!plot || typeof plot === 'string'} onClick={() => save('plot', `${stem} ${choice?.y}.svg`)}>Save SVG</button>
        </div>
      </div>
    </Backdrop>
  );
}

function Choice({ label, value, names, change }: { label: string; value: string; names: string[]; change: (name: string) => void }): ReactElement {
  return (
    <label>
      {label}
      <select value={value} onChange={(e) => change(e.target.value)}>
        {names.map((name) => (
          <option key={name} value={name}>{name || 'none'}</option>
        ))}
      </select>
    </label>
  );
}

/** A dot for each run and a line through the means of each series. The dot at the pointer shows its run. */
function Plot({ plot, table, choice }: { plot: SweepPlot; table: SweepRows; choice: PlotChoice }): ReactElement {
  const box = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const [width, set_width] = useState(0);
  const [shown, set_shown] = useState<number | null>(null); // index of a point
  const theme = useStudio((s) => s.theme);
  useLayoutEffect(() => {
    if (!box.current) return;
    const observer = new ResizeObserver(() => set_width(box.current?.clientWidth ?? 0));
    observer.observe(box.current);
    return () => observer.disconnect();
  }, []);
  useEffect(() => set_shown(null), [plot]);
  const px = (x: number): number => margin.left + 8 + ((x - plot.x[0]) / (plot.x[1] - plot.x[0])) * (width - margin.left - margin.right - 16);
  const py = (y: number): number => height - margin.bottom - 6 - ((y - plot.y[0]) / (plot.y[1] - plot.y[0])) * (height - margin.top - margin.bottom - 12);
  const colors = series_colors(theme);
  useLayoutEffect(() => {
    const element = canvas.current;
    const context = element?.getContext('2d', plain_canvas);
    if (!element || !context || width === 0) return;
    const ratio = window.devicePixelRatio || 1;
    element.width = Math.round(width * ratio);
    element.height = Math.round(height * ratio);
    context.scale(ratio, ratio);
    const style = getComputedStyle(element);
    const color = (name: string): string => style.getPropertyValue(name);
    context.font = `${style.fontSize} ${style.fontFamily}`;
    context.fillStyle = color('--text-dim');
    context.strokeStyle = color('--line');
    context.lineWidth = 1;
    context.textAlign = 'right';
    context.textBaseline = 'middle';
    for (const y of ticks(...plot.y, 6)) {
      context.strokeRect(margin.left, Math.round(py(y)) + 0.5, width - margin.left - margin.right, 0);
      context.fillText(tick_text(y), margin.left - 8, py(y));
    }
    context.textAlign = 'center';
    context.textBaseline = 'top';
    const every = plot.words ? Math.ceil(plot.words.length / Math.max(1, Math.floor(width / 90))) : 1;
    const labels = plot.words ? plot.words.map((text, i) => ({ at: i, text })).filter(({ at }) => at % every === 0) : ticks(...plot.x, 8).map((at) => ({ at, text: tick_text(at) }));
    for (const { at, text } of labels) {
      context.strokeRect(Math.round(px(at)) + 0.5, height - margin.bottom, 0, 4);
      context.fillText(text, px(at), height - margin.bottom + 8);
    }
    context.fillStyle = color('--text');
    context.fillText(choice.x, (margin.left + width - margin.right) / 2, height - 18);
    plot.series.forEach((_, s) => {
      context.fillStyle = context.strokeStyle = colors[s % colors.length]!;
      context.globalAlpha = 0.55;
      for (const p of plot.points) {
        if (p.series !== s) continue;
        context.beginPath();
        context.arc(px(p.x), py(p.y), 3.2, 0, 2 * Math.PI);
        context.fill();
      }
      context.globalAlpha = 1;
      context.lineWidth = 1.6;
      context.beginPath();
      for (const m of plot.means[s]!) context.lineTo(px(m.x), py(m.y));
      context.stroke();
    });
  }, [plot, width, theme, choice.x]);
  const at_pointer = (e: React.PointerEvent): void => {
    const bounds = canvas.current!.getBoundingClientRect();
    const [x, y] = [e.clientX - bounds.left, e.clientY - bounds.top];
    let best = near;
    let found: number | null = null;
    plot.points.forEach((p, i) => {
      const distance = Math.hypot(px(p.x) - x, py(p.y) - y);
      if (distance >= best) return;
      best = distance;
      found = i;
    });
    set_shown(found);
  };
  const point = shown === null ? null : plot.points[shown];
  const row = point && table.rows[point.row];
  const described = [...new Set([...varied(table), choice.x, choice.y])].filter((c) => c !== 'number');
  return (
    <div ref={box} className="sweep-plot">
      <canvas
        ref={canvas}
        role="img"
        aria-label={`${choice.y} over ${choice.x}: ${plot.points.length} runs, from ${tick_text(plot.y[0])} to ${tick_text(plot.y[1])}`}
        style={{ width: '100%', height }}
        onPointerMove={at_pointer}
        onPointerLeave={() => set_shown(null)}
      />
      {point && row && (
        <div className="sweep-tip" role="status" style={{ left: Math.min(px(point.x) + 10, width - 190), ...(py(point.y) < height / 2 ? { top: py(point.y) + 10 } : { bottom: `calc(100% - ${py(point.y) - 10}px)` }) }}>
          <strong>Run {String(row[table.columns.indexOf('number')])}</strong>
          {described.map((c) => (
            <span key={c}>{c} {shown_cell(row[table.columns.indexOf(c)] ?? null)}</span>
          ))}
        </div>
      )}
      {plot.series.length > 1 && (
        <ul className="sweep-legend" aria-label={choice.by}>
          <li>{choice.by}</li>
          {plot.series.map((name, s) => (
            <li key={name}><span className="dot" style={{ background: colors[s % colors.length] }} />{name || '–'}</li>
          ))}
        </ul>
      )}
    </div>
  );
}

const shown_cell = (value: Cell): string => (typeof value === 'number' ? tick_text(value) : (value ?? '–'));

/** Colours of series, distinguishable on the panel of the theme. */
function series_colors(theme: string): string[] {
  return theme === 'light'
    ? ['#2563eb', '#c2410c', '#047857', '#7c3aed', '#be185d', '#0e7490', '#92400e', '#4d7c0f', '#475569', '#1e40af', '#9f1239', '#5b21b6']
    : ['#6ea8fe', '#ff8a3d', '#34d399', '#c4b5fd', '#f472b6', '#22d3ee', '#fbbf24', '#a3e635', '#9aa1ad', '#93c5fd', '#fb7185', '#a78bfa'];
}
