/** Rows of the event track: events at the same time are drawn below each other, so that their pills and texts do not cover each other. */
import type { ScenarioEvent } from './document';

export const max_rows = 4; // more events at one time share the last row

/** Row of each event, by its id: the first row whose last event has ended when the event begins. */
export function event_rows(events: readonly ScenarioEvent[]): Map<string, number> {
  const rows = new Map<string, number>();
  const ends: number[] = []; // of the last event of each row, s
  for (const event of [...events].sort((a, b) => a.time - b.time)) {
    let row = ends.findIndex((end) => end <= event.time);
    if (row < 0) row = Math.min(ends.length, max_rows - 1);
    // an event without duration still takes its moment
    ends[row] = Math.max(ends[row] ?? 0, event.time + Math.max(event.duration ?? 0, 1e-6));
    rows.set(event.id, row);
  }
  return rows;
}

/** Time of the next event of a row after `event`, s; infinite if it is the last one. Of events at the same time, the later in the list is next. */
export function next_time(row: readonly ScenarioEvent[], event: ScenarioEvent): number {
  const at = row.indexOf(event);
  return Math.min(...row.map((e, i) => (e.time > event.time || (e.time === event.time && i > at) ? e.time : Infinity)));
}
