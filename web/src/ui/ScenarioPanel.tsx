import { useCallback, useEffect, useLayoutEffect, useRef, useState, type DragEvent, type KeyboardEvent, type ReactElement } from 'react';
import { createPortal } from 'react-dom';
import { find_marker } from '../core/document';
import { add_items, items_of, move_items, selection_of, type Item } from '../core/items';
import { format_ruler, format_time } from '../core/format';
import { find_instance } from '../core/nested';
import { fit_view, pan_by, round_to_frame, ruler_steps, time_to_x, x_to_time, zoom_at, type TimeView } from '../core/timeline';
import { prop_kinds, prop_shapes } from '../core/props';
import { shown_document } from '../core/state';
import { track_rows } from '../core/track_groups';
import { add_character, add_motion, run } from './actions';
import { page, parts, plain_canvas, session, usePage, useStudio } from './app';
import { Icon } from './icons';
import { MarkerFlags, RangeBar } from './markers';
import { Menu } from './Menu';
import { insert_mesh_file, insert_prop } from './prop_actions';
import { CameraTrack } from './film/CameraTrack';
import { EventTrack } from './EventTrack';
import { Breadcrumb } from './nested/Breadcrumb';
import { InstanceTrack } from './nested/InstanceTrack';
import { drop_target, GroupRow, Track, type DropGhost } from './tracks';

/** The scenario panel: ruler, tracks, events and contact bars. Clips and their drags are in tracks.tsx. */
export function ScenarioPanel(): ReactElement {
  const doc = useStudio(shown_document);
  const rate = doc?.frame_rate ?? 60;
  const [view, set_view] = useState<TimeView>({ origin: -0.1, scale: 60 });
  const view_ref = useRef(view);
  view_ref.current = view;
  const lanes = useRef<HTMLDivElement>(null);
  const root = useRef<HTMLDivElement>(null);
  const [width, set_width] = useState(800);
  const [ghost, set_ghost] = useState<DropGhost | null>(null);
  const [props_menu, set_props_menu] = useState<{ x: number; y: number } | null>(null);
  const [guide, set_guide] = useState<number | null>(null);
  /** True until the user zooms or pans. While true, the whole scenario is fitted to the panel whenever the panel's size changes. */
  const fitted = useRef(true);
  const duration = doc?.duration ?? 10;
  const folded = usePage((s) => s.folded);
  const ripple = usePage((s) => s.ripple);

  useLayoutEffect(() => {
    const element = lanes.current;
    if (!element) return;
    const observer = new ResizeObserver(() => set_width(element.clientWidth));
    observer.observe(element);
    set_width(element.clientWidth);
    return () => observer.disconnect();
  }, [doc !== null]);

  const fit = useCallback(() => {
    const element = lanes.current;
    const now = shown_document(session.state);
    fitted.current = true;
    if (element && now) set_view(fit_view(now.duration, element.clientWidth));
  }, []);
  const change_view = useCallback((change: (v: TimeView) => TimeView) => {
    fitted.current = false;
    set_view(change);
  }, []);
  useEffect(() => {
    parts.fit_timeline = fit;
  }, [fit]);
  const open = doc !== null;
  useEffect(() => {
    if (open && fitted.current && width > 120) fit();
  }, [open, width, duration, fit]);

  // the listener calls preventDefault, so that the wheel does not scroll the page; a passive listener could not
  useEffect(() => {
    const element = root.current;
    if (!element) return;
    const wheel = (event: WheelEvent): void => {
      const box = lanes.current?.getBoundingClientRect();
      if (!box || event.clientX < box.left) return;
      event.preventDefault();
      const amount = event.deltaY || event.deltaX;
      if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) change_view((v) => pan_by(v, event.deltaX || amount));
      else change_view((v) => zoom_at(v, event.clientX - box.left, Math.exp(-Math.max(-150, Math.min(150, amount)) * 0.0022)));
    };
    element.addEventListener('wheel', wheel, { passive: false });
    return () => element.removeEventListener('wheel', wheel);
  }, [open, change_view]);

  const time_at = (client_x: number): number => {
    const box = lanes.current?.getBoundingClientRect();
    return box ? x_to_time(view_ref.current, client_x - box.left) : 0;
  };

  const pan_with_middle = (event: React.PointerEvent<HTMLDivElement>): void => {
    if (event.button !== 1) return;
    event.preventDefault();
    const target = event.currentTarget;
    let last = event.clientX;
    const move = (e: PointerEvent): void => {
      change_view((v) => pan_by(v, last - e.clientX));
      last = e.clientX;
    };
    const up = (): void => {
      target.removeEventListener('pointermove', move);
      target.removeEventListener('pointerup', up);
    };
    target.setPointerCapture(event.pointerId);
    target.addEventListener('pointermove', move);
    target.addEventListener('pointerup', up);
  };

  const nudge = (event: KeyboardEvent): void => {
    if (event.key !== 'ArrowLeft' && event.key !== 'ArrowRight') return;
    const { selection, document } = session.state;
    if (!document || event.ctrlKey || event.metaKey) return;
    if (event.altKey) return;
    const by = ((event.key === 'ArrowRight' ? 1 : -1) * (event.shiftKey ? 10 : 1)) / document.frame_rate;
    const instance = selection.kind === 'instance' ? find_instance(document, selection.instance) : undefined;
    if (instance) {
      void session.edit({ type: 'instance.set', id: instance.id, start: Math.max(0, round_to_frame(instance.start + by, document.frame_rate)) });
      event.preventDefault();
      return event.stopPropagation();
    }
    const items = items_of(selection);
    const marker = selection.kind === 'marker' ? find_marker(document, selection.marker) : undefined;
    const command = marker
      ? ({ type: 'marker.set', id: marker.id, time: Math.max(0, round_to_frame(marker.time + by, document.frame_rate)) } as const)
      : move_items(document, items, by);
    if (!marker && items.length === 0) return;
    if (command) void session.edit(command);
    event.preventDefault();
    event.stopPropagation();
  };

  // ---- marquee: a rectangle that selects the clips and events that it touches ----

  const [marquee, set_marquee] = useState<{ left: number; top: number; width: number; height: number } | null>(null);
  const begin_marquee = (event: React.PointerEvent<HTMLDivElement>): void => {
    const target = event.target as Element;
    if (event.button !== 0 || target.closest('[role=listitem], button, .track-head')) return;
    const area = event.currentTarget;
    const character = target.closest('.lane')?.closest<HTMLElement>('[data-character]')?.dataset.character;
    const adds = event.shiftKey || event.ctrlKey || event.metaKey;
    const from = { x: event.clientX, y: event.clientY };
    let box: DOMRect | null = null;
    area.setPointerCapture(event.pointerId);
    const move = (e: PointerEvent): void => {
      if (!box && Math.hypot(e.clientX - from.x, e.clientY - from.y) < 4) return;
      box = new DOMRect(Math.min(from.x, e.clientX), Math.min(from.y, e.clientY), Math.abs(e.clientX - from.x), Math.abs(e.clientY - from.y));
      const origin = area.getBoundingClientRect();
      set_marquee({ left: box.left - origin.left, top: box.top - origin.top + area.scrollTop, width: box.width, height: box.height });
    };
    const stop = (): void => {
      area.removeEventListener('pointermove', move);
      area.removeEventListener('pointerup', up);
      area.removeEventListener('pointercancel', stop);
      window.removeEventListener('keydown', key, true);
      set_marquee(null);
    };
    const up = (): void => {
      stop();
      if (!box) {
        if (!adds) session.select(character ? { kind: 'character', character } : { kind: 'none' });
        return;
      }
      const { left, right, top, bottom } = box;
      const touched = [...area.querySelectorAll<HTMLElement>('[data-clip], [data-event]')].filter((element) => {
        const b = element.getBoundingClientRect();
        return b.right > left && b.left < right && b.bottom > top && b.top < bottom;
      });
      const items = touched.map((element): Item => {
        const { clip, event: id } = element.dataset;
        return clip ? { kind: 'clip', character: element.closest<HTMLElement>('[data-character]')!.dataset.character!, clip } : { kind: 'event', event: id! };
      });
      session.select(adds ? add_items(session.state.selection, items) : selection_of(items));
    };
    const key = (e: globalThis.KeyboardEvent): void => {
      if (e.key !== 'Escape') return;
      e.preventDefault();
      e.stopPropagation();
      stop();
    };
    area.addEventListener('pointermove', move);
    area.addEventListener('pointerup', up);
    area.addEventListener('pointercancel', stop);
    window.addEventListener('keydown', key, true);
  };

  // ---- dropping from the library ----

  const drag_over = (event: DragEvent, character: string | null): void => {
    const id = page.getState().dragged_entry;
    if (!id || !doc) return;
    const target = drop_target(id, character, time_at(event.clientX), doc);
    set_ghost(target);
    if (target && !target.refused) {
      event.preventDefault();
      event.dataTransfer.dropEffect = 'copy';
    }
    event.stopPropagation();
  };
  const drop = (event: DragEvent): void => {
    event.preventDefault();
    event.stopPropagation();
    const target = ghost;
    set_ghost(null);
    page.setState({ dragged_entry: null });
    if (!target || target.refused) return;
    const entry = session.entry(target.entry);
    if (!entry) return;
    if (target.character) add_motion(target.character, entry.id, target.start);
    else if (entry.kind === 'mechanism') void add_character(entry.id);
    else if (entry.mechanism) void add_character(entry.mechanism, undefined, entry.id);
  };

  if (!doc) return <div className="panel empty">Waiting for the project from the studio…</div>;
  return (
    <div
      ref={root}
      className="scenario"
      role="region"
      aria-label="Scenario"
      onKeyDown={nudge}
      onPointerDown={pan_with_middle}
      onDragOver={(e) => drag_over(e, null)}
      onDragLeave={(e) => {
        if (!e.currentTarget.contains(e.relatedTarget as Node | null)) set_ghost(null);
      }}
      onDrop={drop}
    >
      <Breadcrumb />
      <div className="scenario-head">
        <div className="corner">
          <button type="button" className="quiet" aria-label="Fit" title="Show the whole scenario  (Home)" onClick={fit}>
            <Icon name="fit" />
          </button>
          <button type="button" className="quiet insert" title="Add a push at the playhead  (Shift P)" disabled={doc.characters.length === 0} onClick={() => run('edit.push')}>
            + Push
          </button>
          <button
            type="button" className="quiet insert" aria-haspopup="menu" title="Add a prop: a box, ramp, stairs and others, or a mesh file; fixed or moving"
            onClick={(e) => {
              const box = e.currentTarget.getBoundingClientRect();
              set_props_menu({ x: box.left, y: box.bottom + 4 });
            }}
          >
            + Prop
          </button>
          {props_menu && createPortal(<Menu x={props_menu.x} y={props_menu.y} over label="Add a prop" close={() => set_props_menu(null)} items={[...prop_shapes.map((shape) => ({ label: prop_kinds[shape].name, run: () => insert_prop(shape) })), { label: 'Mesh file…', apart: true, run: insert_mesh_file }]} />, document.querySelector('main') ?? document.body)}
          <button type="button" className="quiet insert" title="Add a marker at the playhead  (M)" onClick={() => run('marker.add')}>
            + Marker
          </button>
          <button type="button" className="quiet ripple" aria-pressed={ripple} aria-label="Ripple" title="Ripple: moving, trimming or deleting a clip moves everything after it  (Shift E)" onClick={() => run('edit.ripple')}>
            <Icon name="ripple" />
          </button>
        </div>
        <div className="ruler-box">
          <Ruler view={view} width={width} rate={rate} duration={duration} time_at={time_at} />
          <RangeBar doc={doc} view={view} on_guide={set_guide} />
          <MarkerFlags doc={doc} view={view} on_guide={set_guide} />
        </div>
      </div>
      <div className="tracks" onPointerDown={begin_marquee}>
        <div className="lane-size" ref={lanes} />
        {track_rows(doc, folded).map((row) => row.kind === 'group' ? <GroupRow key={`group ${row.name}`} name={row.name} members={row.members} folded={row.folded} view={view} /> : (
          <div key={row.character.id} className={row.grouped ? 'grouped' : undefined} onDragOver={(e) => drag_over(e, row.character.id)}>
            <Track character={row.character} view={view} on_guide={set_guide} ghost={ghost?.character === row.character.id ? ghost : null} on_ghost={set_ghost} />
          </div>
        ))}
        {doc.instances?.map((instance) => <InstanceTrack key={instance.id} instance={instance} doc={doc} view={view} on_guide={set_guide} />)}
        <EventTrack doc={doc} view={view} on_guide={set_guide} />
        <CameraTrack doc={doc} view={view} on_guide={set_guide} />
        {marquee && <div className="marquee" style={marquee} />}
        {doc.characters.length === 0 && !doc.instances?.length && <p className="hint lane-hint">To begin, drag a mechanism from the library here or onto the floor.</p>}
        {doc.characters.length > 0 && !doc.instances?.length && doc.characters.every((c) => c.track.length === 0) && <p className="hint lane-hint">Drag a motion from the library onto a track.</p>}
        {ghost && !ghost.character && !ghost.refused && <p className="hint lane-hint drop-hint">Drop to add a new character{session.entry(ghost.entry)?.kind === 'motion' ? ' with this motion' : ''}</p>}
      </div>
      <div className="overlay" aria-hidden="true">
        {doc.range && <div className="outside" style={{ left: 0, width: Math.max(0, time_to_x(view, doc.range.from)) }} />}
        {doc.range && <div className="outside" style={{ left: Math.max(0, time_to_x(view, doc.range.to)), right: 0 }} />}
        {doc.markers?.map((marker) => <div key={marker.id} className="marker-line" style={{ left: time_to_x(view, marker.time) }} />)}
        <div className="beyond" style={{ left: Math.max(0, time_to_x(view, duration)) }} />
        {guide !== null && <div className="guide" style={{ left: time_to_x(view, guide) }} />}
        <Playhead view={view_ref} set_view={change_view} width={width} />
      </div>
    </div>
  );
}

function Ruler({ view, width, rate, duration, time_at }: { view: TimeView; width: number; rate: number; duration: number; time_at: (x: number) => number }): ReactElement {
  const canvas = useRef<HTMLCanvasElement>(null);
  const theme = useStudio((s) => s.theme);
  useLayoutEffect(() => {
    const element = canvas.current;
    const context = element?.getContext('2d', plain_canvas);
    if (!element || !context) return;
    const ratio = window.devicePixelRatio || 1;
    const height = element.clientHeight;
    element.width = Math.round(width * ratio);
    element.height = Math.round(height * ratio);
    const style = getComputedStyle(element);
    context.scale(ratio, ratio);
    context.clearRect(0, 0, width, height);
    context.font = `${parseFloat(style.fontSize)}px ${style.fontFamily}`;
    context.textBaseline = 'middle';
    const { label, tick } = ruler_steps(view.scale, rate);
    const first = Math.max(0, Math.floor(view.origin / tick));
    const last = Math.ceil(x_to_time(view, width) / tick);
    const every = Math.round(label / tick);
    for (let i = first; i <= last; i++) {
      const time = i * tick;
      const x = Math.round(time_to_x(view, time)) + 0.5;
      const major = i % every === 0;
      context.fillStyle = style.getPropertyValue(major ? '--line-strong' : '--line');
      context.fillRect(x - 0.5, height - (major ? 8 : 4), 1, major ? 8 : 4);
      if (major) {
        context.fillStyle = time > duration + 1e-6 ? style.getPropertyValue('--text-faint') : style.color;
        context.fillText(format_ruler(time, label), x + 4, height / 2 - 2);
      }
    }
  }, [view, width, rate, duration, theme]);

  const scrub = (event: React.PointerEvent<HTMLCanvasElement>): void => {
    if (event.button !== 0) return;
    event.currentTarget.setPointerCapture(event.pointerId);
    const seek = (x: number, fine: boolean): void => session.seek(fine ? time_at(x) : round_to_frame(time_at(x), rate));
    if (session.state.transport.playing) session.pause();
    seek(event.clientX, event.ctrlKey);
    const target = event.currentTarget;
    const move = (e: PointerEvent): void => seek(e.clientX, e.ctrlKey);
    const up = (): void => {
      target.removeEventListener('pointermove', move);
      target.removeEventListener('pointerup', up);
      target.removeEventListener('pointercancel', up);
    };
    target.addEventListener('pointermove', move);
    target.addEventListener('pointerup', up);
    target.addEventListener('pointercancel', up);
  };
  const time = useStudio((s) => s.transport.time);
  return (
    <canvas
      ref={canvas}
      className="ruler"
      role="slider"
      tabIndex={0}
      aria-label="Playhead"
      aria-valuemin={0}
      aria-valuemax={duration}
      aria-valuenow={Math.round(time * 100) / 100}
      aria-valuetext={format_time(time)}
      onPointerDown={scrub}
    />
  );
}

/**
 * The playhead and the bar of the simulated time. React renders them once; their positions are then written to the DOM at each animation
 * frame.
 */
function Playhead({ view, set_view, width }: { view: { current: TimeView }; set_view: (change: (v: TimeView) => TimeView) => void; width: number }): ReactElement {
  const line = useRef<HTMLDivElement>(null);
  const played = useRef<HTMLDivElement>(null);
  useEffect(() => {
    let handle = 0;
    let before = '';
    const tick = (): void => {
      handle = requestAnimationFrame(tick);
      const { transport } = session.state;
      const x = time_to_x(view.current, session.now);
      const text = `${x.toFixed(2)} ${view.current.origin} ${view.current.scale} ${transport.simulated} ${transport.mode}`;
      if (text === before) return;
      before = text;
      if (line.current) {
        line.current.style.transform = `translateX(${x.toFixed(2)}px)`;
        line.current.style.visibility = x < -1 || x > width + 1 ? 'hidden' : 'visible';
      }
      if (played.current) {
        const from = Math.max(0, time_to_x(view.current, 0));
        const to = Math.max(from, time_to_x(view.current, transport.mode === 'simulate' ? transport.simulated : 0));
        played.current.style.transform = `translateX(${from}px) scaleX(${Math.max(0, to - from)})`;
      }
      // while playing, scroll by a page when the playhead leaves the visible range
      if (transport.playing && x > width && x < width * 3) set_view((v) => pan_by(v, width * 0.9));
      else if (transport.playing && x < 0 && x > -width * 3) set_view((v) => pan_by(v, x - 24));
    };
    tick();
    return () => cancelAnimationFrame(handle);
  }, [view, set_view, width]);
  return (
    <>
      <div ref={played} className="simulated" />
      <div ref={line} className="playhead">
        <div className="playhead-cap" />
      </div>
    </>
  );
}

