/** The naturalness and log panels: tabs next to the scenario. */
import { useEffect, useLayoutEffect, useRef, type ReactElement } from 'react';
import { assist_force, body_weight } from '../core/frames';
import { bar_fraction, grade, measures, shown_value } from '../core/judge';
import { run } from './actions';
import { plain_canvas, session, useStudio } from './app';

export function NaturalnessPanel(): ReactElement {
  const doc = useStudio((s) => s.document);
  const summary = useStudio((s) => s.summary);
  const mode = useStudio((s) => s.transport.mode);
  const driven = doc?.characters.filter((c) => c.control.mode === 'track') ?? [];
  if (mode !== 'simulate' || summary.characters.length === 0) {
    return (
      <div className="panel empty">
        <p>Naturalness is measured while the scenario is simulated.</p>
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
      <table>
        <thead>
          <tr>
            <th scope="col">Character</th>
            {measures.map((m) => (
              <th key={m.key} scope="col" title={m.meaning}>
                {m.name} <span className="limit">good below {m.good}, bad above {m.bad} {m.unit}</span>
              </th>
            ))}
            <th scope="col">Root assist over time <span className="limit">% of weight</span></th>
          </tr>
        </thead>
        <tbody>
          {driven.map((character) => {
            const row = summary.characters.find((c) => c.id === character.id);
            return (
              <tr key={character.id}>
                <th scope="row">
                  <span className="dot" style={{ background: character.color ?? '#e6e6ea' }} />
                  {character.name}
                  {row?.fell && <span className="released">fell</span>}
                </th>
                {measures.map((measure) => {
                  const shown = shown_value(measure, row);
                  const known = Number.isFinite(shown);
                  return (
                    <td key={measure.key}>
                      <div className="measure">
                        <span className="value" data-grade={grade(measure, shown)}>{known ? `${shown.toFixed(measure.digits)} ${measure.unit}`.replace(' °', '°') : '–'}</span>
                        <div className="bar">{known && <div data-grade={grade(measure, shown)} style={{ transform: `scaleX(${bar_fraction(measure, shown)})` }} />}</div>
                      </div>
                    </td>
                  );
                })}
                <td className="curve-cell">
                  <AssistCurve character={character.id} />
                </td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </div>
  );
}

/** Root assist over time, in body weights, from the frames in the ring buffer; redrawn four times a second. */
function AssistCurve({ character }: { character: string }): ReactElement {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const draw = (): void => {
      const element = canvas.current;
      const context = element?.getContext('2d', plain_canvas);
      const doc = session.state.document;
      if (!element || !context || !doc) return;
      const ratio = window.devicePixelRatio || 1;
      const { clientWidth: width, clientHeight: height } = element;
      element.width = Math.round(width * ratio);
      element.height = Math.round(height * ratio);
      context.scale(ratio, ratio);
      const style = getComputedStyle(element);
      const index = session.state.characters.findIndex((c) => c.id === character);
      const cap = Math.max(0.05, doc.characters.find((c) => c.id === character)?.control.assist_limit ?? 0.5);
      const top = Math.max(0.2, cap * 1.1);
      const y = (share: number): number => height - 2 - (height - 6) * Math.min(1, share / top);
      context.fillStyle = style.getPropertyValue('--line-strong');
      context.fillRect(0, y(0.15), width, 1);
      context.fillStyle = style.getPropertyValue('--bad');
      context.globalAlpha = 0.6;
      context.fillRect(0, y(cap), width, 1);
      context.globalAlpha = 1;
      context.beginPath();
      let before = -10;
      for (const number of session.frames.numbers()) {
        const frame = session.frames.at(number);
        const character_frame = frame?.simulate ? frame.characters[index] : undefined;
        if (!frame || !character_frame) continue;
        const weight = body_weight(frame, character_frame);
        const x = (frame.time / Math.max(doc.duration, 1e-3)) * width;
        const share = weight > 0 ? Math.hypot(...assist_force(frame, character_frame)) / weight : 0;
        if (number - before > 6) context.moveTo(x, y(share));
        else context.lineTo(x, y(share));
        before = number;
      }
      context.strokeStyle = style.getPropertyValue('--good');
      context.lineWidth = 1.4;
      context.stroke();
    };
    draw();
    const timer = setInterval(draw, 250);
    return () => clearInterval(timer);
  }, [character]);
  return <canvas ref={canvas} className="assist-curve" role="img" aria-label="Root assist over time; the red line is the assist limit" title="Grey line: 15 % of body weight; red line: the assist limit" />;
}

export function LogPanel(): ReactElement {
  const log = useStudio((s) => s.log);
  const end = useRef<HTMLDivElement>(null);
  useLayoutEffect(() => {
    end.current?.scrollIntoView({ block: 'nearest' }); // in braces: newer browsers return a promise, which an effect must not return
  }, [log]);
  if (log.length === 0) return <div className="panel empty">The log is empty. Errors and reports of the service appear here.</div>;
  return (
    <div className="panel log" role="log" aria-label="Log">
      {log.map((line) => (
        <div key={line.id} className={`log-line ${line.level}`}>
          <time>{line.at.toLocaleTimeString([], { hour12: false })}</time>
          <span className="level">{line.level}</span>
          <span>{line.text}</span>
        </div>
      ))}
      <div ref={end} />
    </div>
  );
}
