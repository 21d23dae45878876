/** Tracks of events and of holds in the timeline. */
import { type ReactElement } from 'react';
import { apply_command, find_character, type ScenarioDocument, type ScenarioEvent } from '../core/document';
import { event_rows, next_time } from '../core/event_rows';
import { format_number, format_time } from '../core/format';
import { describe_grip, grip_end, is_grip } from '../core/grips';
import { is_selected, type Item } from '../core/items';
import { snap_delta, time_to_x, type TimeView } from '../core/timeline';
import { session, useStudio } from './app';
import { drag_ends, drag_together, press_item, select_focused, start_drag } from './track_drag';

const min_text_px = 90; // px: a pill of this width or more contains its text; a narrower pill has the text to its right
const text_gap_px = 10; // px between the end of a pill, its text and the next pill
const min_room_px = 24; // px: a shorter text beside a pill is not readable
const min_pill_px = 8; // px: minimum width of an event's pill, so that events without duration can be dragged

/** Label of a link of a character, or its name. */
function link_label(character: string, link: string): string {
  const { document, mechanisms } = session.state;
  const mechanism = document && find_character(document, character)?.mechanism;
  return (mechanism && mechanisms[mechanism]?.links.find((l) => l.name === link)?.label) || link;
}

export function describe_event(event: ScenarioEvent, doc: ScenarioDocument): string {
  const name = event.character ? (find_character(doc, event.character)?.name ?? session.state.characters.find((c) => c.id === event.character)?.name ?? event.character) : '';
  if (event.type === 'push') return `push ${name}${event.force ? ` ${format_number(Math.hypot(...event.force), 0)} N` : ''}`.trim();
  if (event.type === 'pull') return `pull ${[name, link_label(event.character ?? '', event.link ?? '').toLowerCase()].filter(Boolean).join(' ')}`;
  if (event.type === 'throw') return `throw ${name}`.trim();
  if (is_grip(event)) return describe_grip(event, doc, link_label);
  return [event.type, name].filter(Boolean).join(' ');
}

export function EventTrack({ doc, view, on_guide }: { doc: ScenarioDocument; view: TimeView; on_guide: (time: number | null) => void }): ReactElement {
  const selection = useStudio((s) => s.selection);
  const holds = doc.events.filter(is_grip);
  return (
    <>
      {holds.length > 0 && (
        <div className="track events holds" style={{ ['--rows' as string]: hold_rows(doc, holds) }}>
          <div className="track-name plain">
            <span className="dot" style={{ background: 'var(--pin-contacts)' }} />
            <span className="label">Holds</span>
          </div>
          <div className="lane">
            <div className="items" role="list" aria-label="Holds">
              {holds.map((event) => (
                <EventPill key={event.id} event={event} doc={doc} view={view} on_guide={on_guide} selected={is_selected(selection, { kind: 'event', event: event.id })} next={next_time(holds.filter((e) => hold_row(doc, e) === hold_row(doc, event)), event)} row={hold_row(doc, event)} />
              ))}
            </div>
          </div>
        </div>
      )}
      <EventRow doc={doc} view={view} on_guide={on_guide} />
    </>
  );
}

/** Names of the links that grip, in the order of their first event; each has a row of its own, so that the holds of two hands do not cover each other. */
const gripping = (doc: ScenarioDocument): string[] => [...new Set(doc.events.filter(is_grip).map((e) => `${e.character} ${e.link}`))];
const hold_row = (doc: ScenarioDocument, event: ScenarioEvent): number => gripping(doc).indexOf(`${event.character} ${event.link}`);
const hold_rows = (doc: ScenarioDocument, holds: readonly ScenarioEvent[]): number => Math.max(1, ...holds.map((e) => hold_row(doc, e) + 1));

function EventRow({ doc, view, on_guide }: { doc: ScenarioDocument; view: TimeView; on_guide: (time: number | null) => void }): ReactElement {
  const selection = useStudio((s) => s.selection);
  const events = doc.events.filter((event) => !is_grip(event));
  const rows = event_rows(events);
  const row_of = (event: ScenarioEvent): number => rows.get(event.id) ?? 0;
  return (
    <div className="track events" style={{ ['--rows' as string]: Math.max(1, ...[...rows.values()].map((row) => row + 1)) }}>
      <div className="track-name plain">
        <span className="dot" style={{ background: 'var(--event)' }} />
        <span className="label">Events</span>
      </div>
      <div className="lane">
        <div className="items" role="list" aria-label="Events">
          {events.map((event) => (
            <EventPill key={event.id} event={event} doc={doc} view={view} on_guide={on_guide} selected={is_selected(selection, { kind: 'event', event: event.id })} next={next_time(events.filter((e) => row_of(e) === row_of(event)), event)} row={row_of(event)} />
          ))}
        </div>
        {doc.events.length === 0 && <span className="hint">Shift P adds a push at the playhead, Shift G a grab of the selected link</span>}
      </div>
    </div>
  );
}

function EventPill({ event, doc, view, selected, on_guide, next, row }: { event: ScenarioEvent; doc: ScenarioDocument; view: TimeView; selected: boolean; on_guide: (time: number | null) => void; next: number; row: number }): ReactElement {
  const text = describe_event(event, doc);
  const duration = event.type === 'grab' ? grip_end(doc, event) - event.time : (event.duration ?? 0);
  const width = Math.max(min_pill_px, duration * view.scale);
  const short = duration * view.scale < min_text_px;
  const room = (next - event.time) * view.scale - width - text_gap_px; // px for a text beside its pill
  const down = (pointer: React.PointerEvent<HTMLElement>): void => {
    if (pointer.button !== 0) return;
    pointer.stopPropagation();
    const item: Item = { kind: 'event', event: event.id };
    const { together, click } = press_item(pointer, item);
    if (together) return start_drag({ event: pointer, scale: view.scale, click, ...drag_together(together, on_guide) });
    const document = session.state.document;
    const origin = document?.events.find((e) => e.id === event.id);
    if (!document || !origin) return;
    let time = origin.time;
    start_drag({
      event: pointer,
      scale: view.scale,
      click,
      move: (delta, rules) => {
        session.select(item);
        const snapped = snap_delta([origin.time], delta, rules(document, event.id));
        time = Math.max(0, Math.round((origin.time + snapped.delta) * 1e6) / 1e6);
        on_guide(snapped.at);
        session.show_preview(apply_command(document, { type: 'event.set', id: event.id, event: { time } }));
      },
      ...drag_ends(on_guide, () => (time === origin.time ? null : { type: 'event.set', id: event.id, event: { time } })),
    });
  };
  return (
    <div
      role="listitem"
      tabIndex={0}
      data-event={event.id}
      className={`pill ${event.type}${selected ? ' selected' : ''}${short ? ' short' : ''}`}
      aria-label={`${text}, at ${format_time(event.time)}`}
      title={`${text}\nat ${format_number(event.time)} s`}
      style={{ left: time_to_x(view, event.time), width, ['--row' as string]: row }}
      onPointerDown={down}
      onFocus={(e) => select_focused(e, { kind: 'event', event: event.id })}
    >
      {(!short || room > min_room_px) && <span className="pill-text" style={short && Number.isFinite(room) ? { maxWidth: room, overflow: 'hidden' } : undefined}>{text}</span>}
    </div>
  );
}
