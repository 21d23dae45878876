import { useEffect, useRef, useState, type DragEvent, type ReactElement } from 'react';
import * as THREE from 'three';
import { assist_of_cap, CharacterState } from '../core/frames';
import { format_gap, format_percent } from '../core/format';
import { bar_fraction, grade, measures, shown_value } from '../core/judge';
import { show_key } from '../core/keymap';
import { selected_character, type ViewOptions } from '../core/state';
import { PointerControl } from '../view/pointer';
import { PoseView } from '../view/pose_view';
import { Viewport } from '../view/viewport';
import { add_character, append_motion, run, set_view } from './actions';
import { comparer, gaits, page, parts, poser, registry, session, useControls, usePage, useStudio } from './app';
import { FilmFrame, ThroughChoice } from './film/ThroughBar';
import { Icon, type IconName } from './icons';
import { CorrectionCard } from './motion/CorrectionCard';
import { EventArrow } from './EventArrow';
import { PathOverlay } from './motion/PathOverlay';
import { PlayControlsBar } from './PlayControlsBar';
import { PullBar } from './PullBar';
import { PoseHandles, PoseLabels, PoseTools, ToolChoice } from './posing/PoseOverlay';
import { VariableBoard } from './rules/Variables';
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
      made = new Viewport(canvas.current, session, (character_states) => page.setState({ character_states }));
    } catch (error) {
      set_failed((error as Error).message);
      return;
    }
    made.before = () => {
      const { comparison, on } = comparer.state;
      return on && session.state.transport.mode === 'edit' ? comparison : null;
    };
    const stop_comparing = comparer.store.subscribe(() => made.invalidate());
    const pointer = new PointerControl(made);
    const posing = new PoseView(made, poser);
    pointer.posing = posing;
    pointer.on_floor = (x, y) => gaits.add([x, y]);
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
    parts.posing = posing;
    set_viewport(made);
    return () => {
      observer.disconnect();
      stop_comparing();
      pointer.dispose();
      posing.dispose();
      made.dispose();
      parts.viewport = null;
      parts.pointer = null;
      parts.posing = null;
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
      void add_character(entry.id, at && at.length() < 100 ? { x: at.x, y: at.y } : undefined);
      return;
    }
    const target = viewport.pick(event.clientX, event.clientY)?.character ?? session.state.document?.characters.find((c) => c.mechanism === entry.mechanism)?.id;
    if (target) append_motion(target, entry.id);
    else if (entry.mechanism) void add_character(entry.mechanism, undefined, entry.id);
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
      <canvas ref={canvas} tabIndex={0} aria-label="Viewport: the characters of the scenario" role="img" />
      <div ref={label} className="link-label" aria-hidden="true" />
      {failed && (
        <div className="viewport-failed" role="alert">
          <strong>The 3D view cannot be drawn.</strong>
          <span>{failed}</span>
          <span>Enable WebGL (hardware acceleration) in the browser’s settings, then reload the page.</span>
        </div>
      )}
      {empty && !failed && (
        <div className="viewport-empty">
          <strong>No characters yet</strong>
          <span>Drag a mechanism from the library onto the floor, or drop a motion file here (BVH, FBX, glTF, C3D, ASF with AMC and others).</span>
        </div>
      )}
      {viewport && <FilmFrame viewport={viewport} />}
      <div className="viewport-top">
        <ViewOptionsBar />
        <ToolChoice />
      </div>
      {viewport && <ViewCube viewport={viewport} />}
      {viewport && <PathOverlay viewport={viewport} />}
      {viewport && <EventArrow viewport={viewport} />}
      {viewport && <PoseHandles viewport={viewport} />}
      {viewport && <PoseLabels viewport={viewport} />}
      <PoseTools />
      {viewport && <Badges viewport={viewport} />}
      {viewport && <Distances viewport={viewport} />}
      <VariableBoard />
      <AssistCard />
      {running && !controls && <p className="viewport-hint">Drag a character to pull it</p>}
      <CorrectionCard />
      <PullBar />
      <PlayControlsBar host={host} />
    </div>
  );
}

/** Options of the view; a narrow viewport shows their icons only. */
const view_options: { option: keyof ViewOptions; name: string; command: string; icon: IconName }[] = [
  { option: 'shapes', name: 'Shapes', command: 'view.shapes', icon: 'capsule' },
  { option: 'ghosts', name: 'Ghosts', command: 'view.ghosts', icon: 'ghosts' },
  { option: 'contacts', name: 'Contacts', command: 'view.contacts', icon: 'contact' },
  { option: 'closest', name: 'Distances', command: 'view.closest', icon: 'distance' },
  { option: 'trail', name: 'Centre of mass', command: 'view.trail', icon: 'mass' },
  { option: 'follow', name: 'Follow', command: 'view.follow', icon: 'follow' },
];

function ViewOptionsBar(): ReactElement {
  const view = useStudio((s) => s.view);
  const keymap = useStudio((s) => s.keymap);
  const free = useStudio((s) => s.through === 'free'); // the cameras of the document have their own projection, and follow by themselves
  const options = view_options.filter(({ option }) => free || option !== 'follow');
  const projection = view.perspective ? 'Perspective' : 'Orthographic';
  const key = (id: string): string => {
    const command = registry.get(id);
    const found = command && registry.keys_of(command, keymap)[0];
    return found ? `  (${show_key(found)})` : '';
  };
  return (
    <div className="view-options" role="toolbar" aria-label="View">
      <ThroughChoice />
      {free && (
        <button type="button" aria-label={projection} title={`Switch between perspective and orthographic projection${key('view.perspective')}`} onClick={() => set_view({ perspective: !view.perspective })}>
          <Icon name={view.perspective ? 'perspective' : 'orthographic'} />
          <span>{projection}</span>
        </button>
      )}
      {options.map(({ option, name, command, icon }) => (
        <button key={option} type="button" aria-pressed={view[option]} aria-label={name} title={`${registry.get(command)?.label ?? name}${key(command)}`} onClick={() => run(command)}>
          <Icon name={icon} />
          <span>{name}</span>
        </button>
      ))}
    </div>
  );
}

const max_labels = 12;
/** Space that a distance label needs, px. */
const label_room = { width: 64, height: 22 };

/**
 * Labels with the distances of the closest points (mm; m from 1 m on), at the middle of their lines. Written to the DOM without rendering
 * in React.
 */
function Distances({ viewport }: { viewport: Viewport }): ReactElement | null {
  const on = useStudio((s) => s.view.closest);
  const host = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (!on) return;
    const place = (): void => {
      const labels = host.current?.children;
      if (!labels) return;
      const box = viewport.canvas.getBoundingClientRect();
      const placed: { x: number; y: number }[] = [];
      for (let i = 0; i < labels.length; i++) {
        const label = labels[i] as HTMLElement;
        const pair = viewport.closest_pairs[i];
        const at = pair && viewport.to_client(pair.middle);
        // pairs are sorted by distance; a label that would overlap the label of a closer pair is hidden
        const free = at && !placed.some((t) => Math.abs(t.x - at.x) < label_room.width && Math.abs(t.y - at.y) < label_room.height);
        label.style.visibility = free ? 'visible' : 'hidden';
        if (!pair || !at || !free) continue;
        placed.push(at);
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
      {Array.from({ length: max_labels }, (_, i) => (
        <span key={i} className="distance" style={{ visibility: 'hidden' }} />
      ))}
    </div>
  );
}

/** Badges above characters whose motion control was released. */
function Badges({ viewport }: { viewport: Viewport }): ReactElement {
  const states = usePage((s) => s.character_states);
  const characters = useStudio((s) => s.characters);
  const simulate = useStudio((s) => s.transport.mode === 'simulate');
  const fallen = simulate ? characters.filter((c) => states[c.id] === CharacterState.released) : [];
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
        // stack the badges of characters that are close together on the screen
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
          {fallen.length > 1 || characters.length > 1 ? `${c.name} released` : 'released'}
        </div>
      ))}
    </>
  );
}

/**
 * Naturalness of the selected character. Root assist is written to the DOM ten times a second, without React; foot skate and tracking error
 * are from the latest summary.
 */
function AssistCard(): ReactElement | null {
  const simulate = useStudio((s) => s.transport.mode === 'simulate');
  const doc = useStudio((s) => s.document);
  const chosen = useStudio(selected_character);
  const driven = doc?.characters.filter((c) => c.control.mode === 'track') ?? [];
  const character = driven.find((c) => c.id === chosen) ?? driven[0];
  const summary = useStudio((s) => s.summary.characters.find((c) => c.id === character?.id));
  const state = usePage((s) => (character ? s.character_states[character.id] : undefined));
  const value = useRef<HTMLSpanElement>(null);
  const bar = useRef<HTMLDivElement>(null);
  const id = character?.id;
  const limit = character?.control.assist_limit ?? 0;
  useEffect(() => {
    if (!simulate || !id) return;
    let smooth = 0;
    const timer = setInterval(() => {
      const frame = session.frames.latest;
      const character_frame = frame?.characters[session.state.characters.findIndex((c) => c.id === id)];
      if (!frame || !character_frame || !value.current || !bar.current) return;
      smooth += (assist_of_cap(frame, character_frame) - smooth) * 0.5;
      value.current.textContent = format_percent(smooth * limit);
      bar.current.style.transform = `scaleX(${smooth})`;
      bar.current.dataset.grade = smooth > 0.7 ? 'bad' : smooth > 0.3 ? 'fair' : 'good';
    }, 100);
    return () => clearInterval(timer);
  }, [simulate, id, limit]);
  if (!simulate || !character) return null;
  const rest = measures.filter((m) => m.key === 'foot_skate_cm' || m.key === 'tracking_rms_deg');
  return (
    <div className="card" role="group" aria-label={`Naturalness of ${character.name}`}>
      {driven.length > 1 && (
        <div className="card-title">
          <span className="dot" style={{ background: character.color ?? '#e6e6ea' }} />
          {character.name}
          {state === CharacterState.released && <span className="released">released</span>}
        </div>
      )}
      <div className="measure" title="Present assist on the root, force and moment, in percent of body weight. The bar shows its share of the assist limit.">
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
