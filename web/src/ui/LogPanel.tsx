/** The log: reports and errors of the service and the page. */
import { useLayoutEffect, useRef, type ReactElement } from 'react';
import { useStudio } from './app';

export function LogPanel(): ReactElement {
  const log = useStudio((s) => s.log);
  const end = useRef<HTMLDivElement>(null);
  useLayoutEffect(() => {
    end.current?.scrollIntoView({ block: 'nearest' }); // in braces: newer browsers return a promise, which an effect must not return
  }, [log]);
  if (log.length === 0) return <div className="panel empty">The log is empty. Errors and reports of the service appear here.</div>;
  return (
    <div className="panel log" role="log" aria-label="Log" tabIndex={0}>
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
