/** The parts of the ruler that can be dragged: markers, and the in and out points of playing. */
import type { ReactElement } from 'react';
import { apply_command, find_marker, type Command, type ScenarioDocument } from '../core/document';
import { format_time } from '../core/format';
import { snap_delta, time_to_x, type TimeView } from '../core/timeline';
import { session, useStudio } from './app';
import { start_drag } from './track_drag';

interface RulerProps {
  doc: ScenarioDocument;
  view: TimeView;
  on_guide: (time: number | null) => void;
}

const min_range = 0.05; // s, minimum distance of in and out

const clean = (time: number): number => Math.round(time * 1e6) / 1e6;

/** Drags one time: `command` makes the command for the new time, which is previewed during the drag and sent at its end. */
function drag_time(event: React.PointerEvent<HTMLElement>, view: TimeView, id: string, time: number, on_guide: RulerProps['on_guide'], command: (time: number) => Command): void {
  const { document } = session.state;
  if (event.button !== 0 || !document) return;
  event.stopPropagation();
  let wanted: Command | null = null;
  const end = (): void => on_guide(null);
  start_drag({
    event,
    scale: view.scale,
    move: (delta, rules) => {
      const snapped = snap_delta([time], delta, rules(document, id));
      on_guide(snapped.at);
      wanted = command(clean(Math.max(0, time + snapped.delta)));
      session.show_preview(apply_command(document, wanted));
    },
    done: () => {
      end();
      if (wanted) void session.edit(wanted);
    },
    cancel: () => {
      end();
      session.show_preview(null);
    },
  });
}

export function MarkerFlags({ doc, view, on_guide }: RulerProps): ReactElement {
  const selection = useStudio((s) => s.selection);
  return (
    <>
      {doc.markers?.map((marker) => (
        <button
          key={marker.id}
          type="button"
          data-marker={marker.id}
          className="marker"
          aria-pressed={selection.kind === 'marker' && selection.marker === marker.id}
          aria-label={`${marker.name}, marker at ${format_time(marker.time)}`}
          title={`${marker.name}: click to select, double-click to go there, drag to move`}
          style={{ left: time_to_x(view, marker.time) }}
          onPointerDown={(e) => {
            session.select({ kind: 'marker', marker: marker.id });
            const time = find_marker(session.state.document ?? doc, marker.id)?.time ?? marker.time;
            drag_time(e, view, marker.id, time, on_guide, (to) => ({ type: 'marker.set', id: marker.id, time: to }));
          }}
          onFocus={() => session.select({ kind: 'marker', marker: marker.id })}
          onDoubleClick={() => session.seek(marker.time)}
        >
          <span>{marker.name}</span>
        </button>
      ))}
    </>
  );
}

/** The band between in and out in the ruler, with a handle at each end. */
export function RangeBar({ doc, view, on_guide }: RulerProps): ReactElement | null {
  const { range } = doc;
  if (!range) return null;
  const from = time_to_x(view, range.from);
  const to = time_to_x(view, range.to);
  const set = (next: { from: number; to: number }): Command => ({ type: 'scenario.set', range: next });
  return (
    <div className="range" style={{ left: from, width: Math.max(1, to - from) }}>
      <span
        className="range-end in"
        title={`In: ${format_time(range.from)}; drag to change`}
        onPointerDown={(e) => drag_time(e, view, 'range', range.from, on_guide, (time) => set({ from: Math.min(time, clean(range.to - min_range)), to: range.to }))}
      />
      <span
        className="range-end out"
        title={`Out: ${format_time(range.to)}; drag to change`}
        onPointerDown={(e) => drag_time(e, view, 'range', range.to, on_guide, (time) => set({ from: range.from, to: Math.max(time, clean(range.from + min_range)) }))}
      />
    </div>
  );
}
