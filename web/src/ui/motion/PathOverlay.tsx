/** The path of a gait over the floor: its line, handles that move its points, and the hint while a path is drawn. */
import { useEffect, useLayoutEffect, useRef, useState, type PointerEvent, type ReactElement } from 'react';
import * as THREE from 'three';
import { find_clip } from '../../core/document';
import { from_world, path_length, smooth_path, to_world, with_lead, type Point, type Start } from '../../core/motion/gait';
import type { Viewport } from '../../view/viewport';
import { gaits, useGaits, useStudio } from '../app';

const floor = new THREE.Plane(new THREE.Vector3(0, 0, 1), 0);
const above = 0.01; // m: the line is drawn this far above the floor

/** The start of a clip in the world; null until the service has answered. */
function useStart(character: string | null, clip: string | null, revision: unknown): Start | null {
  const [start, set_start] = useState<Start | null>(null);
  useEffect(() => {
    if (!character || !clip) {
      set_start(null);
      return;
    }
    let valid = true;
    gaits.about(character, clip).then((found) => valid && set_start(found.start ?? null), () => valid && set_start(null));
    return () => {
      valid = false;
    };
  }, [character, clip, revision]);
  return start;
}

export function PathOverlay({ viewport }: { viewport: Viewport }): ReactElement | null {
  const drawing = useGaits((s) => s.drawing);
  const doc = useStudio((s) => s.document);
  const selection = useStudio((s) => s.selection);
  const chosen = selection.kind === 'clip' && doc ? find_clip(doc, selection.character, selection.clip) : undefined;
  const path = chosen?.gait?.path;
  const shown = !drawing && selection.kind === 'clip' && path && path.length > 0 ? selection : null;
  const start = useStart(shown?.character ?? null, shown?.clip ?? null, doc);
  const [moved, set_moved] = useState<{ index: number; point: Point } | null>(null);
  const line = useRef<SVGPolylineElement>(null);
  const host = useRef<HTMLDivElement>(null);
  useEffect(() => set_moved(null), [path]);

  const base = drawing ? drawing.start : start;
  let points: Point[] = drawing ? drawing.points : base && path ? path.map((p) => to_world(base, p)) : [];
  if (moved) points = points.map((p, i) => (i === moved.index ? moved.point : p));
  const all: Point[] = base ? [to_world(base, [0, 0]), ...points] : [];
  const line_through = base ? smooth_path(with_lead(points.map((p) => from_world(base, p))).map((p) => to_world(base, p))) : [];
  const key = JSON.stringify([all, line_through]);

  // a layout effect: a picture that is drawn after new handles appear must not place them by the corners of the former path
  useLayoutEffect(() => {
    const [corners, curve] = JSON.parse(key) as [Point[], Point[]];
    const place = (): void => {
      const box = viewport.canvas.getBoundingClientRect();
      const on_page = ([x, y]: Point): { x: number; y: number } | null => {
        const at = viewport.to_client(new THREE.Vector3(x, y, above));
        return at && { x: at.x - box.left, y: at.y - box.top };
      };
      line.current?.setAttribute('points', curve.flatMap((p) => on_page(p) ?? []).map((p) => `${p.x.toFixed(1)},${p.y.toFixed(1)}`).join(' '));
      for (const child of host.current?.querySelectorAll<HTMLElement>('.path-handle') ?? []) {
        const at = on_page(corners[Number(child.dataset.point)]!);
        child.style.visibility = at ? 'visible' : 'hidden';
        if (at) child.style.transform = `translate(${at.x}px, ${at.y}px) translate(-50%, -50%)`;
      }
    };
    place();
    return viewport.on_draw(place);
  }, [viewport, key]);

  useEffect(() => {
    if (!drawing) return;
    const press = (event: KeyboardEvent): void => {
      if (event.target instanceof HTMLInputElement) return;
      if (event.key === 'Enter') void gaits.finish();
      else if (event.key === 'Escape') gaits.cancel();
      else if (event.key === 'Backspace') gaits.remove_last();
      else return;
      event.preventDefault();
      event.stopPropagation();
    };
    window.addEventListener('keydown', press, true);
    return () => window.removeEventListener('keydown', press, true);
  }, [drawing]);

  if (!base || (points.length === 0 && !drawing)) return null;
  const to_floor = (event: PointerEvent): Point | null => {
    const at = viewport.on_plane(event.clientX, event.clientY, floor);
    return at && at.length() < 500 ? [at.x, at.y] : null;
  };
  const commit = (): void => {
    if (!moved || !shown || !path) return;
    void gaits.change(shown, { path: path.map((p, i) => (i === moved.index ? from_world(base, moved.point) : p)) }).then((ok) => ok || set_moved(null));
  };
  return (
    <div ref={host} className="path-overlay">
      <svg aria-hidden="true">
        <polyline ref={line} />
      </svg>
      {all.map((_p, i) => (
        <span
          key={i}
          className={i === 0 ? 'path-handle path-start' : 'path-handle'}
          data-point={i}
          title={i === 0 ? 'The path begins where the clip starts' : 'Drag to move this point of the path'}
          onPointerDown={(e) => {
            if (i === 0 || drawing) return;
            e.preventDefault();
            e.currentTarget.setPointerCapture(e.pointerId);
            set_moved({ index: i - 1, point: all[i]! });
          }}
          onPointerMove={(e) => {
            const at = moved && e.currentTarget.hasPointerCapture(e.pointerId) ? to_floor(e) : null;
            if (at) set_moved({ index: i - 1, point: at });
          }}
          onPointerUp={commit}
          onPointerCancel={() => set_moved(null)}
        />
      ))}
      {drawing && (
        <div className="path-bar" role="toolbar" aria-label="Path">
          <span role="status">{points.length === 0 ? 'Click on the floor where the path leads' : `${points.length} ${points.length === 1 ? 'point' : 'points'}, ${path_length(line_through).toFixed(1)} m`}</span>
          <button type="button" disabled={points.length === 0} title="Make the motion along this path  (Enter)" onClick={() => void gaits.finish()}>Done</button>
          <button type="button" disabled={points.length === 0} title="Remove the last point  (Backspace)" onClick={() => gaits.remove_last()}>Back</button>
          <button type="button" title="Keep the motion as it was  (Esc)" onClick={() => gaits.cancel()}>Cancel</button>
        </div>
      )}
    </div>
  );
}
