/** What is wrong with an LSI, at the LSI, and what can be done about it. */
import type { ReactElement } from 'react';
import { circuit, useCircuit } from '../app';

export function ProblemBubble({ id }: { id: string }): ReactElement | null {
  const problems = useCircuit((s) => s.problems);
  const open = useCircuit((s) => s.nodes.has(id) || s.problems.length <= 3);
  const path = useCircuit((s) => s.path);
  const mine = circuit.problems_of(id);
  if (mine.length === 0) return null;
  // a circle is told once, at the first LSI of it that is seen here
  const first = (p: (typeof mine)[number]): boolean => p.loop.length === 0 || circuit.view?.nodes.find((n) => circuit.problems_of(n.id).includes(p))?.id === id;
  const told = mine.filter(first);
  const others = problems.length > 0 && told.length > 3 ? told.length - 3 : 0;
  return (
    <>
      <span className="bad-mark" title={mine.map((p) => `${p.message} ${p.remedy ?? ''}`).join('\n')}>!</span>
      {open && told.length > 0 && (
        <div className="problem-bubble nodrag nopan" role="alert" key={path.join('/')}>
          {told.slice(0, 3).map((p, i) => (
            <div key={i}>
              <p>{p.message}</p>
              {p.loop.length > 0 ? (
                <button type="button" onClick={(e) => { e.stopPropagation(); circuit.insert_delay(p); }}>Insert delay</button>
              ) : p.remedy && <p className="remedy">{p.remedy}</p>}
            </div>
          ))}
          {others > 0 && <p className="remedy">and {others} more</p>}
        </div>
      )}
    </>
  );
}
