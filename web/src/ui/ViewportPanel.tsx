import { useEffect, useRef, useState, type DragEvent, type ReactElement } from 'react';
import * as THREE from 'three';
import { assist_force, assist_over_cap, body_weight, FigureState } from '../core/frames';
import { format_gap, format_percent } from '../core/format';
import { bar_fraction, grade, measures, shown_value } from '../core/judge';
import { show_key } from '../core/keymap';
import { selected_character } from '../core/state';
import { PointerControl } from '../view/pointer';
import { Viewport } from '../view/viewport';
import { add_character, append_motion, run, set_view } from './actions';
import { page, parts, registry, session, useControls, usePage, useStudio } from './app';
import { PlayControlsBar } from './PlayControlsBar';
import { ViewCube } from './ViewCube';

export function ViewportPanel(): ReactElement {
  const host = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const label = useRef<HTMLDivElement>(null);
  const [viewport, set_viewport] = useState<Viewport | null>(null);
  const [failed, set_failed] = useState<string | null>(null);
  const dragging = usePage((s) => s.dragged_entry !== null);
  const empty = useStudio((s) => s.document !== null && s.document.characters.length === 0);
  const running = useStudio((s) => s.transport.mode === 'simulate' && s.transport.playing);
  const controls = useControls((s) => s.on);

  useEffect(() => {
    if (!canvas.current || !host.current) return;
    let made: Viewport;
    try {
      made = new Viewport(canvas.current, session, (figure_states) => page.setState({ figure_states }));
    } catch (error) {
      set_failed((error as Error).message);
      return;
    }
    const pointer = new PointerControl(made);
    pointer.on_label = (text, x, y) => {
      const element = label.current;
      const box = host.current?.getBoundingClientRect();
      if (!element || !box) return;
      element.textContent = text;
      element.style.visibility = text ? 'visible' : 'hidden';
      element.style.transform = `translate(${x - box.left + 14}px, ${y - box.top + 16}px)`;
    };
    const observer = new ResizeObserver(() => made.resize());
    observer.observe(host.current);
    made.resize();
    parts.viewport = made;
    parts.pointer = pointer;
    set_viewport(made);
    return () => {
      observer.disconnect();
      pointer.dispose();
      made.dispose();
      parts.viewport = null;
      parts.pointer = null;
    };
  }, []);

  const drop = (event: DragEvent): void => {
    const id = page.getState().dragged_entry;
    page.setState({ dragged_entry: null });
    const entry = id ? session.entry(id) : undefined;
    if (!entry || !viewport) return;
    event.preventDefault();
    if (entry.kind === 'mechanism') {
      const at = viewport.on_plane(event.clientX, event.clientY, new THREE.Plane(new THREE.Vector3(0, 0, 1), 0));
      add_character(entry.id, at && at.length() < 100 ? { x: at.x, y: at.y } : undefined);
      return;
    }
    const target = viewport.pick(event.clientX, event.clientY)?.character ?? session.state.document?.characters.find((c) => c.mechanism === entry.mechanism)?.id;
    if (target) append_motion(target, entry.id);
    else if (entry.mechanism) add_character(entry.mechanism, undefined, entry.id);
  };

  return (
    <div
      ref={host}
      className={dragging ? 'viewport drop-here' : controls ? 'viewport controlled' : 'viewport'}
      onDragOver={(e) => {
        if (page.getState().dragged_entry) e.preventDefault();
      }}
      onDrop={drop}
    >
      <canvas ref={canvas} tabIndex={0} aria-label="Viewport: the figures of the scenario" role="img" />
      <div ref={label} className="link-label" aria-hidden="true" />
      {failed && (
        <div className="viewport-failed" role="alert">
          <strong>The picture cannot be drawn.</strong>
          <span>{failed}</span>
          <span>Switch on WebGL (hardware acceleration) in this browser’s settings, then load the page again.</span>
        </div>
      )}
      {empty && !failed && (
        <div className="viewport-empty">
          <strong>An empty floor</strong>
          <span>Drag a mechanism from the library onto it, or import a motion file (BVH, ASF with AMC).</span>
        </div>
      )}
      <ViewOptionsBar />
      {viewport && <ViewCube viewport={viewport} />}
      {viewport && <Badges viewport={viewport} />}
      {viewport && <Distances viewport={viewport} />}
      <AssistCard />
      {running && !controls && <p className="viewport-hint">Press on a figure and pull</p>}
      <PlayControlsBar host={host} />
    </div>
  );
}

function ViewOptionsBar(): ReactElement {
  const view = useStudio((s) => s.view);
  const keymap = useStudio((s) => s.keymap);
  const options: [keyof typeof view, string, string][] = [
    ['ghosts', 'Ghosts', 'view.ghosts'],
    ['contacts', 'Contacts', 'view.contacts'],
    ['nearest', 'Distances', 'view.nearest'],
    ['trail', 'Centre of mass', 'view.trail'],
    ['follow', 'Follow', 'view.follow'],
  ];
  const key = (id: string): string => {
    const command = registry.get(id);
    const found = command && registry.keys_of(command, keymap)[0];
    return found ? `  (${show_key(found)})` : '';
  };
  return (
    <div className="view-options" role="toolbar" aria-label="View">
      <button type="button" title={`Perspective or orthographic${key('view.perspective')}`} onClick={() => set_view({ perspective: !view.perspective })}>
        {view.perspective ? 'Perspective' : 'Orthographic'}
      </button>
      {options.map(([option, name, id]) => (
        <button key={option} type="button" aria-pressed={view[option]} title={`${registry.get(id)?.label ?? name}${key(id)}`} onClick={() => run(id)}>
          {name}
        </button>
      ))}
    </div>
  );
}

const most_labels = 12;
/** px */
const label_room = { width: 64, height: 22 };

/** The distances of nearest points in mm (m when far), written at the middle of their lines without React. */
function Distances({ viewport }: { viewport: Viewport }): ReactElement | null {
  const on = useStudio((s) => s.view.nearest);
  const host = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (!on) return;
    const place = (): void => {
      const labels = host.current?.children;
      if (!labels) return;
      const box = viewport.canvas.getBoundingClientRect();
      const taken: { x: number; y: number }[] = [];
      for (let i = 0; i < labels.length; i++) {
        const label = labels[i] as HTMLElement;
        const pair = viewport.nearest_pairs[i];
        const at = pair && viewport.to_client(pair.middle);
        // the nearest come first; a label that would cover one of them waits until there is room
        const free = at && !taken.some((t) => Math.abs(t.x - at.x) < label_room.width && Math.abs(t.y - at.y) < label_room.height);
        label.style.visibility = free ? 'visible' : 'hidden';
        if (!pair || !at || !free) continue;
        taken.push(at);
        label.textContent = format_gap(pair.distance);
        label.dataset.overlap = String(pair.distance < 0);
        label.style.transform = `translate(${at.x - box.left}px, ${at.y - box.top}px) translate(-50%, -50%)`;
      }
    };
    place();
    return viewport.on_draw(place);
  }, [viewport, on]);
  if (!on) return null;
  return (
    <div ref={host} className="distances" aria-hidden="true">
      {Array.from({ length: most_labels }, (_, i) => (
        <span key={i} className="distance" style={{ visibility: 'hidden' }} />
      ))}
    </div>
  );
}

/** "Let go" above a figure that has become a ragdoll. */
function Badges({ viewport }: { viewport: Viewport }): ReactElement {
  const states = usePage((s) => s.figure_states);
  const characters = useStudio((s) => s.characters);
  const simulate = useStudio((s) => s.transport.mode === 'simulate');
  const fallen = simulate ? characters.filter((c) => states[c.id] === FigureState.let_go) : [];
  const elements = useRef(new Map<string, HTMLDivElement>());
  const ids = fallen.map((c) => c.id).join(' ');
  useEffect(() => {
    const place = (): void => {
      const box = viewport.canvas.getBoundingClientRect();
      const placed: { x: number; y: number; width: number }[] = [];
      for (const [id, element] of elements.current) {
        const head = viewport.head(id);
        const at = head && viewport.to_client(head);
        element.style.visibility = at ? 'visible' : 'hidden';
        if (!at) continue;
        const { offsetWidth: width, offsetHeight: height } = element;
        let y = at.y;
        // figures that lie close together: one badge above the other
        for (let hit = true; hit; ) {
          const under = placed.find((p) => Math.abs(p.x - at.x) < (p.width + width) / 2 + 4 && Math.abs(p.y - y) < height + 2);
          hit = under !== undefined;
          if (under) y = under.y - height - 2;
        }
        placed.push({ x: at.x, y, width });
        element.style.transform = `translate(${at.x - box.left}px, ${y - box.top}px) translate(-50%, -100%)`;
      }
    };
    place();
    return ids ? viewport.on_draw(place) : undefined;
  }, [viewport, ids]);
  return (
    <>
      {fallen.map((c) => (
        <div
          key={c.id}
          className="badge"
          role="status"
          ref={(element) => {
            if (element) elements.current.set(c.id, element);
            else elements.current.delete(c.id);
          }}
        >
          {fallen.length > 1 || characters.length > 1 ? `${c.name} let go` : 'let go'}
        </div>
      ))}
    </>
  );
}

/** Root assist as it is now, written ten times a second without React; skate and tracking from the summary. */
function AssistCard(): ReactElement | null {
  const simulate = useStudio((s) => s.transport.mode === 'simulate');
  const doc = useStudio((s) => s.document);
  const chosen = useStudio(selected_character);
  const driven = doc?.characters.filter((c) => c.control.mode === 'track') ?? [];
  const character = driven.find((c) => c.id === chosen) ?? driven[0];
  const summary = useStudio((s) => s.summary.characters.find((c) => c.id === character?.id));
  const state = usePage((s) => (character ? s.figure_states[character.id] : undefined));
  const value = useRef<HTMLSpanElement>(null);
  const bar = useRef<HTMLDivElement>(null);
  const id = character?.id;
  useEffect(() => {
    if (!simulate || !id) return;
    let smooth = 0;
    const timer = setInterval(() => {
      const frame = session.frames.latest;
      const figure = frame?.figures[session.state.characters.findIndex((c) => c.id === id)];
      if (!frame || !figure || !value.current || !bar.current) return;
      const weight = body_weight(frame, figure);
      const share = weight > 0 ? Math.hypot(...assist_force(frame, figure)) / weight : 0;
      smooth += (share - smooth) * 0.5;
      const over = assist_over_cap(frame, figure);
      value.current.textContent = format_percent(smooth);
      bar.current.style.transform = `scaleX(${Math.min(1, Math.max(over, 0))})`;
      bar.current.dataset.grade = over > 0.7 ? 'bad' : over > 0.3 ? 'fair' : 'good';
    }, 100);
    return () => clearInterval(timer);
  }, [simulate, id]);
  if (!simulate || !character) return null;
  const rest = measures.filter((m) => m.key === 'foot_skate_cm' || m.key === 'tracking_rms_deg');
  return (
    <div className="card" role="group" aria-label={`Naturalness of ${character.name}`}>
      {driven.length > 1 && (
        <div className="card-title">
          <span className="dot" style={{ background: character.color ?? '#e6e6ea' }} />
          {character.name}
          {state === FigureState.let_go && <span className="let-go">let go</span>}
        </div>
      )}
      <div className="measure" title="Invisible help on the root now, of body weight; the bar: of its cap">
        <span>Root assist</span>
        <span ref={value} className="value">0.0 %</span>
        <div className="bar"><div ref={bar} data-grade="good" /></div>
      </div>
      {rest.map((measure) => {
        const shown = shown_value(measure, summary);
        if (!Number.isFinite(shown)) return null;
        return (
          <div key={measure.key} className="measure" title={measure.meaning}>
            <span>{measure.name}</span>
            <span className="value">{`${shown.toFixed(measure.digits)} ${measure.unit}`.replace(' °', '°')}</span>
            <div className="bar"><div data-grade={grade(measure, shown)} style={{ transform: `scaleX(${bar_fraction(measure, shown)})` }} /></div>
          </div>
        );
      })}
    </div>
  );
}
