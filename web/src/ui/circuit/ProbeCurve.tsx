/** The curve of a probed output over the last seconds, drawn with uPlot as values arrive. */
import { useEffect, useRef, type ReactElement } from 'react';
import uPlot from 'uplot';
import { hue_of } from '../../core/circuit/classes';
import { split_end, type Probe } from '../../core/circuit/form';
import { short_number } from '../../core/circuit/live';
import { probe_size } from '../../core/circuit/view';
import { circuit, session, useCircuit } from '../app';
import { Icon } from '../icons';

const seconds = 4; // length of the time axis, s
const max_drawn = 6; // maximum number of components that are drawn if the probe does not select any
const shades = [1, 0.55, 0.8, 0.35, 0.7, 0.45];

export function ProbeCurve({ probe }: { probe: Probe }): ReactElement {
  const box = useRef<HTMLDivElement>(null);
  const value = useRef<HTMLSpanElement>(null);
  const [id, pin_name] = split_end(probe.pin);
  const pin = useCircuit((s) => s.view?.pin(id, 'out', pin_name));
  const title = useCircuit((s) => s.view?.node(id)?.title ?? id);
  const hue = hue_of(pin?.type ?? 'any');
  const components = probe.components?.join(',') ?? '';

  useEffect(() => {
    const element = box.current;
    if (!element) return;
    const style = getComputedStyle(element);
    const color = style.getPropertyValue(`--pin-${hue}`).trim();
    let plot: uPlot | null = null;
    let drawn = -1;
    const make = (count: number): uPlot => {
      drawn = count;
      return new uPlot(
        {
          width: probe_size[0] - 20, height: probe_size[1] - 40, legend: { show: false }, cursor: { show: false }, padding: [3, 0, 3, 0],
          axes: [{ show: false }, { show: false }],
          scales: { x: { time: false } },
          series: [{}, ...Array.from({ length: count }, (_, i) => ({ stroke: color, alpha: shades[i % shades.length]!, width: 1.4, points: { show: false } }))],
        },
        [[], ...Array.from({ length: count }, () => [])] as unknown as uPlot.AlignedData,
        element,
      );
    };
    let revision = -1;
    const draw = (): void => {
      if (session.live.revision === revision) return;
      revision = session.live.revision;
      const flat = circuit.flat_output(id, pin_name);
      const curve = flat ? session.live.curve(flat) : undefined;
      if (!curve || curve.times.length === 0) {
        if (value.current) value.current.textContent = '–';
        return;
      }
      const chosen = components === '' ? curve.values.map((_, i) => i).slice(0, max_drawn) : components.split(',').map(Number).filter((i) => i < curve.values.length);
      if (!plot || drawn !== chosen.length) {
        plot?.destroy();
        plot = make(chosen.length);
      }
      const end = curve.times.at(-1)!;
      let first = curve.times.length - 1;
      while (first > 0 && curve.times[first - 1]! > end - seconds) first--;
      plot.setData([curve.times.slice(first), ...chosen.map((c) => curve.values[c]!.slice(first))] as uPlot.AlignedData);
      if (value.current) {
        const last = chosen.map((c) => curve.values[c]!.at(-1) ?? NaN);
        value.current.textContent = `${last.slice(0, 3).map(short_number).join('  ')}${pin?.unit ? ` ${pin.unit}` : ''}`;
      }
    };
    draw();
    const timer = setInterval(draw, 70);
    return () => {
      clearInterval(timer);
      plot?.destroy();
    };
  }, [id, pin_name, hue, components, pin?.unit]);

  return (
    <>
      <div className="probe-head">
        <span className="probe-name" title={probe.pin}>{title} · {pin_name}</span>
        <span ref={value} className="probe-value">–</span>
        <button type="button" className="tool small nodrag" aria-label={`Remove the probe of ${probe.pin}`} title="Remove the probe" onClick={(e) => { e.stopPropagation(); circuit.toggle_probe({ node: id, side: 'out', pin: pin_name }); }}>
          <Icon name="close" />
        </button>
      </div>
      <div ref={box} className="probe-plot" />
    </>
  );
}
