/** Plots panel: joints of the recorded simulation and outputs of the running circuit over time, drawn with uPlot, and their export as CSV. */
import { useEffect, useMemo, useRef, useState, type ReactElement } from 'react';
import uPlot from 'uplot';
import { find_character } from '../core/document';
import { align, index_at, plot_csv, type PlotCurve } from '../core/plots';
import { download, file_stem } from './actions';
import { session, useCircuit, useStudio } from './app';
import { Icon } from './icons';

/** A joint of a character, or an output of the circuit. */
type Chosen = { kind: 'joint'; character: string; link: string } | { kind: 'pin'; pin: string };
const id_of = (c: Chosen): string => (c.kind === 'joint' ? `joint ${c.character} ${c.link}` : `pin ${c.pin}`);

const colors = ['#4f8ef7', '#e0a030', '#4cb86f', '#d9607c', '#9b7de8', '#3fb5c4', '#c8763a', '#8a94a6'];
const max_components = 6; // components of one output that are drawn
const record_wait = 1000; // ms between two requests for the recorded joints while the simulation runs

/** Samples of joints in the recorded simulation by character and link; they are kept until the recording changes. */
function use_joints(chosen: readonly Chosen[]): Map<string, { step: number; values: number[][] }> {
  const recorded = useStudio((s) => s.recorded);
  const simulated = useStudio((s) => s.transport.simulated);
  const known = useRef(new Map<string, { step: number; values: number[][] }>());
  const asked = useRef(0);
  const key = chosen.map(id_of).join('\n');
  useEffect(() => {
    if (simulated <= 0) {
      known.current.clear();
      return undefined;
    }
    const timer = setTimeout(() => {
      asked.current = Date.now();
      const by_character = new Map<string, string[]>();
      for (const c of chosen) if (c.kind === 'joint') by_character.set(c.character, [...(by_character.get(c.character) ?? []), c.link]);
      for (const [character, links] of by_character) session.ask({ op: 'recorded', character, links }).catch(() => undefined); // the next change asks again
    }, Math.max(0, asked.current + record_wait - Date.now()));
    return () => clearTimeout(timer);
    // eslint-disable-next-line react-hooks/exhaustive-deps -- `key` has the content of `chosen`
  }, [key, simulated]);
  return useMemo(() => {
    if (recorded) for (const { link, values } of recorded.curves) known.current.set(`joint ${recorded.character} ${link}`, { step: recorded.step, values });
    return new Map(known.current);
  }, [recorded, simulated]); // eslint-disable-line react-hooks/exhaustive-deps -- the recording may have been removed
}

export function PlotsPanel(): ReactElement {
  const doc = useStudio((s) => s.document);
  const mechanisms = useStudio((s) => s.mechanisms);
  const lsis = useCircuit((s) => s.view?.nodes);
  const [chosen, set_chosen] = useState<readonly Chosen[]>([]);
  const joints = use_joints(chosen);
  const [revision, set_revision] = useState(0); // of the live values
  const pins = chosen.flatMap((c) => (c.kind === 'pin' ? [c.pin] : []));
  const pin_key = pins.join('\n');
  useEffect(() => {
    session.watch_plots(pin_key === '' ? [] : pin_key.split('\n'));
    if (pin_key === '') return undefined;
    const timer = setInterval(() => set_revision(session.live.revision), 150);
    return () => {
      clearInterval(timer);
      session.watch_plots([]);
    };
  }, [pin_key]);

  const curves = useMemo((): PlotCurve[] => {
    const out: PlotCurve[] = [];
    for (const c of chosen) {
      if (c.kind === 'joint') {
        const found = joints.get(id_of(c));
        const character = doc ? find_character(doc, c.character)?.name : undefined;
        found?.values.forEach((values, k) => out.push({ name: `${character ?? c.character}: ${c.link}${found.values.length > 1 ? `[${k}]` : ''}`, times: values.map((_, i) => i * found.step), values }));
      } else {
        const curve = session.live.curve(c.pin);
        curve?.values.slice(0, max_components).forEach((values, k, all) => out.push({ name: `${c.pin}${all.length > 1 ? `[${k}]` : ''}`, times: [...curve.times], values: [...values] }));
      }
    }
    return out;
    // eslint-disable-next-line react-hooks/exhaustive-deps -- the live values are no React state; `revision` stands for them
  }, [chosen, joints, doc, revision]);

  const add = (c: Chosen): void => set_chosen((list) => (list.some((o) => id_of(o) === id_of(c)) ? list : [...list, c]));
  const outputs = (lsis ?? []).flatMap((node) => node.outputs.map((pin) => `${node.id}.${pin.name}`));
  return (
    <div className="panel plots">
      <div className="plots-tools">
        <select aria-label="Add a joint" value="" onChange={(e) => { const [character, link] = JSON.parse(e.target.value) as [string, string]; add({ kind: 'joint', character, link }); }}>
          <option value="" disabled>Add a joint…</option>
          {doc?.characters.map((c) => (
            <optgroup key={c.id} label={c.name}>
              {mechanisms[c.mechanism]?.links.slice(1).map((l) => <option key={l.name} value={JSON.stringify([c.id, l.name])}>{l.label ? `${l.label} (${l.name})` : l.name}</option>)}
            </optgroup>
          ))}
        </select>
        <select aria-label="Add an output of the circuit" value="" onChange={(e) => add({ kind: 'pin', pin: e.target.value })}>
          <option value="" disabled>Add an output…</option>
          {outputs.map((pin) => <option key={pin} value={pin}>{pin}</option>)}
        </select>
        {chosen.map((c) => (
          <button key={id_of(c)} type="button" className="quiet" title="Remove this plot" onClick={() => set_chosen((list) => list.filter((o) => id_of(o) !== id_of(c)))}>
            {c.kind === 'joint' ? c.link : c.pin} <Icon name="close" />
          </button>
        ))}
        <span className="spacer" />
        <button type="button" className="quiet" disabled={curves.length === 0} title="Save a table with all plotted curves" onClick={() => download(new Blob([plot_csv(curves)], { type: 'text/csv' }), `${file_stem()} plots.csv`)}>
          Export CSV
        </button>
      </div>
      {curves.length > 0 ? <Chart curves={curves} /> : (
        <p className="plots-empty">{chosen.length === 0 ? 'Add joints or outputs of the circuit to see them over time.' : 'The values appear while the scenario is simulated.'}</p>
      )}
    </div>
  );
}

/** The chart. A click moves the playhead. */
function Chart({ curves }: { curves: readonly PlotCurve[] }): ReactElement {
  const box = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const theme = useStudio((s) => s.theme);
  const time = useStudio((s) => s.transport.time);
  const names = curves.map((c) => c.name).join('\n');
  const data = useMemo(() => align(curves), [curves]);
  useEffect(() => {
    const element = box.current;
    if (!element) return undefined;
    const style = getComputedStyle(element);
    const text = style.getPropertyValue('--text-dim').trim();
    const grid = { stroke: style.getPropertyValue('--line').trim(), width: 1 };
    const axis = { stroke: text, grid, ticks: grid, font: `11px ${style.fontFamily}` };
    const made = new uPlot(
      {
        width: Math.max(50, element.clientWidth), height: Math.max(50, element.clientHeight - 28), legend: { live: true },
        scales: { x: { time: false } },
        axes: [{ ...axis }, { ...axis, size: 60 }],
        cursor: { drag: { x: true, y: false } },
        series: [{ label: 'time (s)', value: (_, v) => (v === null ? '–' : v.toFixed(3)) }, ...names.split('\n').map((label, i) => ({ label, stroke: colors[i % colors.length]!, width: 1.4, points: { show: false }, spanGaps: true }))],
      },
      [[], ...names.split('\n').map(() => [])] as unknown as uPlot.AlignedData,
      element,
    );
    const seek = (): void => {
      const left = made.cursor.left ?? -1;
      if (left >= 0 && made.select.width === 0) session.seek(Math.max(0, made.posToVal(left, 'x')));
    };
    made.over.addEventListener('click', seek);
    const observer = new ResizeObserver(() => made.setSize({ width: Math.max(50, element.clientWidth), height: Math.max(50, element.clientHeight - 28) }));
    observer.observe(element);
    plot.current = made;
    return () => {
      observer.disconnect();
      made.destroy();
      plot.current = null;
    };
  }, [names, theme]);
  useEffect(() => plot.current?.setData([data.times, ...data.values] as uPlot.AlignedData), [data, names, theme]);
  const at = index_at(data.times, time);
  return (
    <div ref={box} className="plots-chart" role="img" aria-label={`Plot of ${curves.map((c, k) => `${c.name}: ${data.values[k]?.[at]?.toFixed(3) ?? 'no value'}`).join(', ')} at ${time.toFixed(2)} s`} />
  );
}
