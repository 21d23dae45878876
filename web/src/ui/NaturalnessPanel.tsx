/** The naturalness panel: the measures of the simulation over time, and the time spans in which they are bad. */
import { useLayoutEffect, useMemo, useRef, useState, type ReactElement } from 'react';
import type { Character, ScenarioDocument } from '../core/document';
import { format_ruler } from '../core/format';
import { describe_span, grade_run, limit_text, with_unit, type BadSpan, type MeasureHistory, type Timed } from '../core/measures';
import { ruler_steps } from '../core/timeline';
import { all_bad_spans, run } from './actions';
import { plain_canvas, session, useStudio } from './app';
import { Icon } from './icons';

/** Shows the simulated frame at `time` (s). */
function go_to(time: number): void {
  if (session.state.transport.mode === 'edit') session.set_mode('simulate');
  session.seek(time);
}

export function NaturalnessPanel(): ReactElement {
  const doc = useStudio((s) => s.document);
  const measures = useStudio((s) => s.measures);
  const mode = useStudio((s) => s.transport.mode);
  const spans = useMemo(all_bad_spans, [measures, doc]);
  const driven = doc?.characters.filter((c) => c.control.mode === 'track' && measures.has(c.id)) ?? [];
  if (!doc || measures.frames < 2 || driven.length === 0) {
    return (
      <div className="panel empty">
        <p>{measures.frames >= 2 ? 'No character follows a track, so there is nothing to compare with.' : 'Naturalness is measured while the scenario is simulated.'}</p>
        {mode === 'edit' ? (
          <button type="button" onClick={() => { session.set_mode('simulate'); session.play(); }}>Simulate</button>
        ) : (
          <button type="button" onClick={() => run('play.toggle')}>Play</button>
        )}
      </div>
    );
  }
  return (
    <div className="panel naturalness">
      <div className="nat-row nat-head">
        <div className="nat-tools">
          <span className="nat-count" data-grade={spans.length > 0 ? 'bad' : 'good'}>
            {spans.length === 0 ? 'No problem' : spans.length === 1 ? '1 problem' : `${spans.length} problems`}
          </span>
          <button type="button" className="tool small" aria-label="Go to the previous naturalness problem" title="Go to the previous problem  (Shift PageUp)" disabled={spans.length === 0} onClick={() => run('measure.previous')}>
            <Icon name="back" />
          </button>
          <button type="button" className="tool small" aria-label="Go to the next naturalness problem" title="Go to the next problem  (Shift PageDown)" disabled={spans.length === 0} onClick={() => run('measure.next')}>
            <Icon name="on" />
          </button>
          <button type="button" className="quiet" title="Save a table with all measures of each recorded frame" onClick={() => run('file.export_measures')}>
            Export CSV
          </button>
        </div>
        <span title="Value of the whole run, which ugoki judge compares with the limit">Run</span>
        <span>Limit</span>
        <span title="Maximum at one instant; click to go there">Worst</span>
        <span title="Value at the playhead">Now</span>
        <TimeLabels duration={doc.duration} />
      </div>
      {driven.map((character) => (
        <section key={character.id} aria-label={`Naturalness of ${character.name}`}>
          <h4 className="nat-character">
            <span className="dot" style={{ background: character.color ?? '#e6e6ea' }} />
            {character.name}
          </h4>
          {measures.list.filter((measure) => measures.values(character.id, measure.key).length > 0).map((measure) => (
            <MeasureRow key={measure.key} doc={doc} character={character} measure={measure} measures={measures} spans={spans.filter((s) => s.character === character.id && s.measure === measure)} />
          ))}
          <Absent character={character.id} measures={measures} />
        </section>
      ))}
    </div>
  );
}

interface RowProps {
  doc: ScenarioDocument;
  character: Character;
  measure: Timed;
  measures: MeasureHistory;
  spans: readonly BadSpan[];
}

/** The measures that have no values, by reason. */
function Absent({ character, measures }: { character: string; measures: MeasureHistory }): ReactElement | null {
  const by_reason = new Map<string, string[]>();
  for (const measure of measures.list)
    if (measures.values(character, measure.key).length === 0) {
      const reason = measures.reason(character, measure) || 'no value yet';
      by_reason.set(reason, [...(by_reason.get(reason) ?? []), measure.name]);
    }
  if (by_reason.size === 0) return null;
  return (
    <p className="nat-absent">
      Not measured: {[...by_reason].map(([reason, names]) => `${names.join(', ')} (${reason})`).join('; ')}
    </p>
  );
}

function MeasureRow({ doc, character, measure, measures, spans }: RowProps): ReactElement {
  const peak = measures.peak(character.id, measure);
  const value = measures.total(character.id, measure);
  return (
    <div className="nat-row">
      <span className="nat-name" title={measure.meaning}>{measure.name}</span>
      <span className="value" data-grade={grade_run(measure, value)} title={measures.reason(character.id, measure) || undefined}>
        {with_unit(value, measure)}
        {measure.key !== 'fell' && Number.isFinite(value) && <span className="limit"> {measure.kind}</span>}
      </span>
      <span className="limit">{limit_text(measure)}</span>
      {measure.key === 'fell' || !peak ? (
        <span className="limit">{spans[0] ? `at ${spans[0].from.toFixed(2)} s` : '–'}</span>
      ) : (
        <button type="button" className="quiet nat-worst" title={`Go to ${peak.at.toFixed(2)} s`} aria-label={`Worst ${measure.name.toLowerCase()} of ${character.name}: ${with_unit(peak.value, measure)} at ${peak.at.toFixed(2)} s`} onClick={() => go_to(peak.at)}>
          {with_unit(peak.value, measure)}
        </button>
      )}
      <Now character={character.id} measure={measure} measures={measures} />
      <Lane doc={doc} character={character} measure={measure} measures={measures} spans={spans} />
    </div>
  );
}

function Now({ character, measure, measures }: { character: string; measure: Timed; measures: MeasureHistory }): ReactElement {
  const time = useStudio((s) => s.transport.time);
  return <span className="limit">{with_unit(measures.value_at(character, measure, time), measure)}</span>;
}

/** Width of an element in px, kept up to date. */
function use_width<E extends HTMLElement>(): [React.RefObject<E | null>, number] {
  const element = useRef<E>(null);
  const [width, set_width] = useState(0);
  useLayoutEffect(() => {
    if (!element.current) return;
    const observer = new ResizeObserver(() => set_width(element.current?.clientWidth ?? 0));
    observer.observe(element.current);
    return () => observer.disconnect();
  }, []);
  return [element, width];
}

function TimeLabels({ duration }: { duration: number }): ReactElement {
  const [element, width] = use_width<HTMLDivElement>();
  const { label } = ruler_steps(width / Math.max(duration, 0.01), 60, 56);
  const count = width > 0 ? Math.floor(duration / label + 1e-9) + 1 : 0;
  return (
    <div ref={element} className="nat-times" aria-hidden="true">
      {Array.from({ length: count }, (_, i) => i * label)
        .filter((time) => (time / duration) * width < width - 20)
        .map((time) => (
          <span key={time} style={{ left: `${(100 * time) / duration}%` }}>{format_ruler(time, label)}</span>
        ))}
    </div>
  );
}

/** The measure over time: a curve up to twice the limit, and a bar, which goes there when clicked, at each span in which it is bad. */
function Lane({ doc, character, measure, measures, spans }: RowProps): ReactElement {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [lane, width] = use_width<HTMLDivElement>();
  const theme = useStudio((s) => s.theme);
  const time = useStudio((s) => s.transport.time);
  const { duration } = doc;
  useLayoutEffect(() => {
    const element = canvas.current;
    const context = element?.getContext('2d', plain_canvas);
    if (!element || !context || width === 0 || measure.key === 'fell') return;
    const ratio = window.devicePixelRatio || 1;
    const height = element.clientHeight;
    element.width = Math.round(width * ratio);
    element.height = Math.round(height * ratio);
    context.scale(ratio, ratio);
    const style = getComputedStyle(element);
    const y = (value: number): number => height - 1 - (height - 3) * Math.min(1, value / (2 * measure.bad));
    context.fillStyle = style.getPropertyValue('--line-strong');
    for (const limit of [measure.low, measure.bad]) if (limit > 0) context.fillRect(0, Math.round(y(limit)), width, 1);
    // the maximum of the frames in each pixel column, so that no peak is lost
    const values = measures.shown(character.id, measure);
    const frames_per_px = (duration * measures.rate) / width;
    context.beginPath();
    let gap = true; // the curve is interrupted where there is no value
    for (let x = 0; x < width; x++) {
      const from = Math.floor(x * frames_per_px);
      if (from >= values.length) break;
      let maximum = -1;
      for (let i = from; i < Math.max(from + 1, (x + 1) * frames_per_px) && i < values.length; i++) if (values[i]! > maximum) maximum = values[i]!;
      if (maximum < 0) gap = true;
      else if (gap) context.moveTo(x + 0.5, y(maximum));
      else context.lineTo(x + 0.5, y(maximum));
      gap = maximum < 0;
    }
    context.strokeStyle = style.getPropertyValue('--text-dim');
    context.lineWidth = 1.2;
    context.stroke();
  }, [measures, measure, character.id, width, duration, theme]);
  const percent = (t: number): string => `${(100 * t) / duration}%`;
  return (
    <div
      ref={lane}
      className="nat-lane"
      data-measure={measure.key}
      onPointerDown={(e) => {
        if (e.button === 0 && e.target === e.currentTarget) go_to(((e.clientX - e.currentTarget.getBoundingClientRect().left) / Math.max(1, width)) * duration);
      }}
    >
      <canvas ref={canvas} aria-hidden="true" />
      {spans.map((span) => (
        <button
          key={span.from}
          type="button"
          className="bad-span"
          aria-label={`${character.name}: ${describe_span(span)}`}
          title={`${describe_span(span)}: click to go to the worst frame`}
          style={{ left: percent(span.from), width: `max(5px, ${percent(span.to - span.from)})` }}
          onClick={() => go_to(span.at)}
        />
      ))}
      <span className="nat-playhead" style={{ left: percent(Math.min(time, duration)) }} />
    </div>
  );
}
