/** Running operations on motions: name, elapsed time and a Cancel button. Shown after 300 ms. */
import { useEffect, useState, type ReactElement } from 'react';
import { desk, useDesk } from '../app';

const patience_ms = 300; // operations shorter than this are not shown

export function Tasks(): ReactElement | null {
  const tasks = useDesk((s) => s.tasks);
  const [now, set_now] = useState(0);
  useEffect(() => {
    if (tasks.length === 0) return;
    const timer = setInterval(() => set_now(performance.now()), 100);
    return () => clearInterval(timer);
  }, [tasks.length]);
  const slow = tasks.filter((t) => now - t.since > patience_ms);
  if (slow.length === 0) return null;
  return (
    <div className="tasks" role="region" aria-label="Running operations">
      {slow.map((task) => (
        <div key={task.id} className="task" role="status">
          <span className="task-bar" aria-hidden="true" />
          <span>{task.label}</span>
          <span className="facts">{((now - task.since) / 1000).toFixed(1)} s</span>
          <button type="button" title="Cancel the operation" onClick={() => desk.cancel(task.id)}>Cancel</button>
        </div>
      ))}
    </div>
  );
}
