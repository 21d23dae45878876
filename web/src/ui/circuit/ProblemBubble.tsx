/** Problems of an LSI with their remedies, shown in a bubble at the LSI. */
import type { ReactElement } from 'react';
import { circuit, useCircuit } from '../app';

export function ProblemBubble({ id }: { id: string }): ReactElement | null {
  const problems = useCircuit((s) => s.problems);
  const open = useCircuit((s) => s.nodes.has(id) || s.problems.length <= 3);
  const path = useCircuit((s) => s.path);
  const problems_here = circuit.problems_of(id);
  if (problems_here.length === 0) return null;
  // an algebraic loop is shown only once: at its first LSI in the shown circuit
  const shown_here = (p: (typeof problems_here)[number]): boolean => p.loop.length === 0 || circuit.view?.nodes.find((n) => circuit.problems_of(n.id).includes(p))?.id === id;
  const listed = problems_here.filter(shown_here);
  const hidden = problems.length > 0 && listed.length > 3 ? listed.length - 3 : 0;
  return (
    <>
      <span className="bad-mark" title={problems_here.map((p) => `${p.message} ${p.remedy ?? ''}`).join('\n')}>!</span>
      {open && listed.length > 0 && (
        <div className="problem-bubble nodrag nopan" role="alert" key={path.join('/')}>
          {listed.slice(0, 3).map((p, i) => (
            <div key={i}>
              <p>{p.message}</p>
              {p.loop.length > 0 ? (
                <button type="button" title="Insert a delay LSI that breaks the algebraic loop" onClick={(e) => { e.stopPropagation(); circuit.insert_delay(p); }}>Insert delay</button>
              ) : p.remedy && <p className="remedy">{p.remedy}</p>}
            </div>
          ))}
          {hidden > 0 && <p className="remedy">and {hidden} more</p>}
        </div>
      )}
    </>
  );
}
