/** The bar over the canvas: path in the circuit, problems, breakpoints, layout buttons, time per tick. */
import { useState, type ReactElement, type RefObject } from 'react';
import { circuit, parts, useCircuit, useStudio } from '../app';
import { Icon } from '../icons';
import { BreakpointCount, OneTick } from './Breakpoints';

const max_listed = 40;

export function Bar({ tick, fit, arrange }: { tick: RefObject<HTMLSpanElement | null>; fit: () => void; arrange: () => void }): ReactElement {
  const edited = useCircuit((s) => s.edited);
  const lsis = useCircuit((s) => s.view?.level.circuit.lsis?.length ?? 0);
  const problems = useCircuit((s) => s.problems);
  const step = useStudio((s) => s.document?.step ?? 0.002);
  const [listed, set_listed] = useState(false);
  const rate = 1 / step;
  return (
    <div className="circuit-bar">
      <Crumbs />
      <div className="circuit-facts">
        {problems.length > 0 && (
          <button type="button" className="problem-count" aria-expanded={listed} title="Show or hide the list of problems" onClick={() => set_listed(!listed)}>
            {problems.every((p) => p.stopped) ? 'Stopped' : 'Cannot run'}: {problems.length === 1 ? '1 problem' : `${problems.length} problems`}
          </button>
        )}
        <BreakpointCount />
        <OneTick />
        {edited && (
          <button type="button" title="Replace the edited circuit by the one generated from the scenario (can be undone)" onClick={() => circuit.reset_to_generated()}>Reset to generated</button>
        )}
        <button type="button" title="Lay out the circuit automatically  (Shift L)" onClick={arrange}>Lay out</button>
        <button type="button" title="Show the whole circuit  (A or Home)" onClick={fit}>Fit</button>
        <span className="fact">{lsis} {lsis === 1 ? 'LSI' : 'LSIs'}<span ref={tick} className="tick" /></span>
        <span className="fact">{rate >= 1000 ? `${+(rate / 1000).toFixed(2)} kHz` : `${Math.round(rate)} Hz`}</span>
      </div>
      {listed && problems.length > 0 && <ProblemList close={() => set_listed(false)} />}
    </div>
  );
}

function Crumbs(): ReactElement {
  const path = useCircuit((s) => s.path);
  const names = circuit.crumbs;
  return (
    <nav className="crumbs" aria-label="Path in the circuit">
      <button type="button" aria-current={path.length === 0 ? 'page' : undefined} onClick={() => circuit.go_out(path.length)}>Execution circuit</button>
      {names.map((name, i) => (
        <span key={i}>
          <span className="crumb-arrow" aria-hidden="true">›</span>
          <button type="button" aria-current={i === names.length - 1 ? 'page' : undefined} onClick={() => circuit.go_out(names.length - 1 - i)}>{name}</button>
        </span>
      ))}
    </nav>
  );
}

function ProblemList({ close }: { close: () => void }): ReactElement {
  const problems = useCircuit((s) => s.problems);
  const go_to = (flat: string): void => {
    if (!flat) return;
    const ids = flat.split('/');
    circuit.go_to(ids);
    parts.circuit?.fit(new Set([ids.at(-1)!]));
  };
  return (
    <ul className="problem-list" role="list">
      {problems.slice(0, max_listed).map((p, i) => (
        <li key={i}>
          <button type="button" title="Show the LSI in the circuit" onClick={() => go_to(p.lsi)}>
            {p.lsi && <code>{p.lsi}</code>} {p.message} <span className="remedy">{p.remedy}</span>
          </button>
          {p.loop.length > 0 && <button type="button" title="Insert a delay LSI that breaks the algebraic loop" onClick={() => circuit.insert_delay(p)}>Insert delay</button>}
        </li>
      ))}
      <li><button type="button" className="tool small" aria-label="Close" title="Close the list" onClick={close}><Icon name="close" /></button></li>
    </ul>
  );
}
