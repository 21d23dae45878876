/** The camera track of the scenario panel: the shots, which can be moved and trimmed, and the keys of the selected camera. */
import type { ReactElement } from 'react';
import { apply_command, type Command, type ScenarioDocument } from '../../core/document';
import { view_of, type FilmCamera, type FilmShot } from '../../core/film';
import { find_camera, find_shot, focal_length } from '../../core/film_edits';
import { format_number, format_time } from '../../core/format';
import { snap_delta, time_to_x, type TimeView } from '../../core/timeline';
import { run } from '../actions';
import { session, useStudio } from '../app';
import { drag_ends, start_drag } from '../track_drag';

interface TrackProps {
  doc: ScenarioDocument;
  view: TimeView;
  on_guide: (time: number | null) => void;
}

const edge_px = 7; // width of the zone at the edge of a shot in which a drag trims it
const shortest = 0.1; // s

const clean = (time: number): number => Math.round(time * 1e6) / 1e6;

/** "follows Anna · moves", for the label of a shot. */
export function describe_camera(doc: ScenarioDocument, camera: FilmCamera): string {
  const followed = doc.characters.find((c) => c.id === camera.follow);
  const parts = [`${Math.round(focal_length(view_of(camera, 0).field_of_view))} mm`];
  if (followed) parts.push(`follows ${followed.name}`);
  if ((camera.keys?.length ?? 0) > 1) parts.push('moves');
  return parts.join(' · ');
}

export function CameraTrack({ doc, view, on_guide }: TrackProps): ReactElement | null {
  const selection = useStudio((s) => s.selection);
  if ((doc.cameras?.length ?? 0) === 0) return null;
  const selected = selection.kind === 'shot' ? selection.shot : null;
  const camera = selection.kind === 'camera' ? find_camera(doc, selection.camera) : selection.kind === 'shot' ? find_camera(doc, find_shot(doc, selection.shot)?.camera ?? '') : undefined;
  return (
    <div className="track cameras">
      <div className="track-name plain">
        <span className="dot" style={{ background: 'var(--pin-scalar)' }} />
        <span className="label">Camera</span>
        <button type="button" className="quiet" title="Show another camera from the playhead on  (X)" onClick={() => run('camera.cut')}>
          + Shot
        </button>
      </div>
      <div className="lane">
        <div className="items" role="list" aria-label="Shots">
          {doc.shots?.map((shot, i) => (
            <ShotBox key={shot.id} shot={shot} number={i + 1} doc={doc} view={view} on_guide={on_guide} selected={shot.id === selected} />
          ))}
        </div>
        {camera?.keys?.map((key) => (
          <span key={key.time} className="camera-key" style={{ left: time_to_x(view, key.time) }} title={`Key of ${camera.name} at ${format_time(key.time)}`} />
        ))}
        {(doc.shots?.length ?? 0) === 0 && <span className="hint">+ Shot shows a camera from the playhead on</span>}
      </div>
    </div>
  );
}

function ShotBox({ shot, number, doc, view, on_guide, selected }: TrackProps & { shot: FilmShot; number: number; selected: boolean }): ReactElement {
  const camera = find_camera(doc, shot.camera);
  const name = camera?.name ?? shot.camera;
  const select = (): void => session.select({ kind: 'shot', shot: shot.id });
  const part_at = (event: React.PointerEvent<HTMLElement>): 'start' | 'end' | 'all' => {
    const box = event.currentTarget.getBoundingClientRect();
    const edge = Math.min(edge_px, box.width / 4);
    return event.clientX - box.left < edge ? 'start' : box.right - event.clientX < edge ? 'end' : 'all';
  };
  const down = (event: React.PointerEvent<HTMLElement>): void => {
    const { document } = session.state;
    const origin = document && find_shot(document, shot.id);
    if (event.button !== 0 || !document || !origin) return;
    event.stopPropagation();
    select();
    const part = part_at(event);
    const end = origin.start + origin.length;
    const edges = part === 'all' ? [origin.start, end] : [part === 'start' ? origin.start : end];
    let command: Command | null = null;
    start_drag({
      event,
      scale: view.scale,
      click: select,
      move: (delta, rules) => {
        const snapped = snap_delta(edges, delta, rules(document, shot.id));
        on_guide(snapped.at);
        const start = clean(part === 'end' ? origin.start : Math.max(0, part === 'start' ? Math.min(origin.start + snapped.delta, end - shortest) : origin.start + snapped.delta));
        const length = clean(part === 'all' ? origin.length : part === 'start' ? end - start : Math.max(shortest, origin.length + snapped.delta));
        const same = start === origin.start && length === origin.length;
        command = same ? null : { type: 'shot.set', id: shot.id, shot: part === 'all' ? { start } : { start, length } };
        session.show_preview(command && apply_command(document, command));
      },
      ...drag_ends(on_guide, () => command),
    });
  };
  return (
    <div
      role="listitem"
      tabIndex={0}
      data-shot={shot.id}
      className={selected ? 'clip shot selected' : 'clip shot'}
      aria-label={`Shot ${number}, ${name}, from ${format_time(shot.start)} for ${format_number(shot.length)} seconds${selected ? ', selected' : ''}`}
      title={`Shot ${number}: ${name}\n${format_number(shot.start)} s … ${format_number(shot.start + shot.length)} s\nDouble-click to look through the shots`}
      style={{ left: time_to_x(view, shot.start), width: Math.max(4, shot.length * view.scale) }}
      onPointerDown={down}
      onPointerMove={(e) => {
        if (e.buttons === 0) e.currentTarget.style.cursor = part_at(e) === 'all' ? 'grab' : 'ew-resize';
      }}
      onFocus={(e) => e.currentTarget.matches(':focus-visible') && !selected && select()}
      onDoubleClick={() => session.set({ through: 'shots' })}
    >
      <span className="clip-name">
        <strong>{number}</strong> {name}
        {camera && <span className="clip-details"> {describe_camera(doc, camera)}</span>}
      </span>
    </div>
  );
}
