/** Choice of the camera of the viewport, and the frame of the picture while the view is that of a camera of the document. */
import { useEffect, useRef, type ReactElement } from 'react';
import { focal_length } from '../../core/film_edits';
import { shown_document } from '../../core/state';
import type { Viewport } from '../../view/viewport';
import { run } from '../actions';
import { parts, session, useStudio } from '../app';

export function ThroughChoice(): ReactElement {
  const through = useStudio((s) => s.through);
  const cameras = useStudio((s) => shown_document(s)?.cameras);
  const shots = useStudio((s) => shown_document(s)?.shots?.length ?? 0);
  const safe = useStudio((s) => s.view.safe);
  const selected = useStudio((s) => s.selection.kind === 'camera');
  const pressed = useRef(false);
  return (
    <>
      <select
        className="through"
        aria-label="Camera of the view"
        title="Camera of the view  (Ctrl 0)"
        value={cameras?.some((c) => c.id === through) || through === 'shots' ? through : 'free'}
        onPointerDown={() => (pressed.current = true)}
        onKeyDown={() => (pressed.current = false)}
        onChange={(e) => {
          // after a choice with the mouse, keys belong to the viewport; a focused list would take them as the begin of a name
          if (pressed.current) parts.viewport?.canvas.focus();
          pressed.current = false;
          if (e.target.value === 'new') run('camera.add');
          else session.set({ through: e.target.value });
        }}
      >
        <option value="free">Free view</option>
        {shots > 0 && <option value="shots">Shots</option>}
        {cameras?.map((c) => (
          <option key={c.id} value={c.id}>
            {c.name}
          </option>
        ))}
        <option value="new">New camera from this view</option>
      </select>
      {through !== 'free' && (
        <button type="button" aria-pressed={safe} title="Show or hide the safe areas of the picture" onClick={() => run('view.safe')}>
          Safe frames
        </button>
      )}
      {through === 'free' && selected && (
        <button type="button" title="Move the selected camera to this view" onClick={() => run('camera.place')}>
          Set camera to view
        </button>
      )}
    </>
  );
}

/** Positions are written to the DOM after each drawn frame, without React. */
export function FilmFrame({ viewport }: { viewport: Viewport }): ReactElement | null {
  const on = useStudio((s) => s.through !== 'free');
  const safe = useStudio((s) => s.view.safe);
  const host = useRef<HTMLDivElement>(null);
  const label = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (!on) return;
    const place = (): void => {
      const frame = viewport.rig.film_frame;
      const element = host.current;
      if (!element || !label.current) return;
      element.style.visibility = frame ? 'visible' : 'hidden';
      if (!frame) return;
      element.style.width = `${100 * frame.width}%`;
      element.style.height = `${100 * frame.height}%`;
      const text = `${viewport.film_camera?.name ?? ''}   ${Math.round(focal_length(viewport.rig.field_of_view))} mm   height ${viewport.rig.camera.position.z.toFixed(2)} m   ${viewport.rig.current.distance.toFixed(2)} m to the target`;
      if (label.current.textContent !== text) label.current.textContent = text;
    };
    place();
    viewport.invalidate();
    return viewport.on_draw(place);
  }, [viewport, on]);
  if (!on) return null;
  return (
    <div ref={host} className={safe ? 'film-frame safe' : 'film-frame'} aria-hidden="true">
      <div ref={label} className="film-label" />
    </div>
  );
}
