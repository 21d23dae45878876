/** Tracks of characters in the timeline, with their clips. */
import { useLayoutEffect, useMemo, useRef, useState, type ReactElement } from 'react';
import { CharacterState } from '../core/frames';
import { apply_command, blend_spans, find_character, fit_blends, is_left_out, type Character, type Clip, type Command, type ScenarioDocument } from '../core/document';
import { format_number, format_time } from '../core/format';
import { ripple_clip } from '../core/ripple';
import { index_beside } from '../core/track_groups';
import { is_selected, items_of, type Item } from '../core/items';
import { changed_fields, drag_clip, ends_moving, loop_to_end, move_clip, snap_delta, time_to_x, type ClipDragKind, type SnapRules, type TimeView } from '../core/timeline';
import { selected_tracks, toggle_track } from '../core/nested';
import { shown_document } from '../core/state';
import { describe_span } from '../core/measures';
import { band_gradient } from '../core/motion/desk';
import { layer_times } from '../core/posing/keys';
import { desk, page, plain_canvas, session, useDesk, usePage, useStudio } from './app';
import { Icon } from './icons';
import { menu_point, TrackMenu } from './nested/InstanceTrack';
import { drag_together, press_item, select_focused, start_drag, snap_rules } from './track_drag';

const edge_px = 7; // width of the zone at a clip's edge in which a drag trims the clip
const longest_blend = 60; // s, maximum cross-fade that the service accepts (content/scenario.cpp)

/** The preview of a dragged clip or library entry on a track. */
export interface DropGhost {
  entry: string;
  /** Character whose track gets the motion; null: a new character is made. */
  character: string | null;
  /** Start of the clip on the track, s. */
  start: number;
  /** Length of the clip, s. */
  length: number;
  /** True: the drop is refused, because the motion is for another mechanism. */
  refused: boolean;
  name: string;
}

/**
 * The result of dropping a library entry at `time` (s) on a character's track or, with null, elsewhere. @return null if the entry is
 * unknown
 */
export function drop_target(entry_id: string, character: string | null, time: number, doc: ScenarioDocument): DropGhost | null {
  const entry = session.entry(entry_id);
  if (!entry) return null;
  if (entry.kind === 'mechanism') return { entry: entry.id, character: null, start: 0, length: 0, refused: false, name: entry.name };
  const target = character ? find_character(doc, character) : undefined;
  const length = entry.duration ?? 1;
  if (!target) return { entry: entry.id, character: null, start: 0, length, refused: !entry.mechanism, name: entry.name };
  const rules: SnapRules = { ...snap_rules(doc, '', 14 / 60), enabled: true };
  const start = Math.max(0, time + snap_delta([time], 0, rules).delta);
  return {
    entry: entry.id,
    character: target.id,
    start: Math.round(start * 1e6) / 1e6,
    length,
    refused: entry.mechanism !== undefined && entry.mechanism !== target.mechanism,
    name: entry.name,
  };
}

/** Buttons in the header of a track: mute, solo, lock. */
function TrackSwitches({ character }: { character: Character }): ReactElement {
  const switches = [
    ['muted', 'M', 'Mute', 'leave this character and its events out of playing'],
    ['solo', 'S', 'Solo', 'play only this character and other solo characters'],
    ['locked', 'L', 'Lock', 'protect the clips of this track against changes'],
  ] as const;
  return (
    <span className="track-switches">
      {switches.map(([key, letter, name, meaning]) => (
        <button
          key={key}
          type="button"
          className={`track-switch ${key}`}
          aria-pressed={Boolean(character[key])}
          aria-label={`${letter}: ${name} ${character.name}`}
          title={`${name}: ${meaning}`}
          onClick={() => void session.edit({ type: 'character.set', id: character.id, [key]: !character[key] })}
        >
          {letter}
        </button>
      ))}
    </span>
  );
}

/** Moves a track before or after the track of `target`. */
function move_track(character: string, target: string, after: boolean): void {
  const { document } = session.state;
  if (!document || character === target) return;
  const at = index_beside(document, character, target, after);
  void session.edit({ type: 'track.move', character, at });
}

function move_track_by_key(element: HTMLElement, character: string, down: boolean): void {
  const rows = [...(element.closest('.tracks')?.querySelectorAll<HTMLElement>('.track[data-character]') ?? [])];
  const target = rows[rows.findIndex((row) => row.dataset.character === character) + (down ? 1 : -1)];
  if (target) move_track(character, target.dataset.character!, down);
}

/** Drags the header of a track up or down; a line shows where the track will be. Escape ends the drag. */
function drag_track(event: React.PointerEvent<HTMLElement>, character: string): void {
  const list = event.currentTarget.closest<HTMLElement>('.tracks');
  if (event.button !== 0 || !list) return;
  const head = event.currentTarget;
  const from = event.clientY;
  let line: HTMLElement | null = null;
  let drop: { target: string; after: boolean } | null = null;
  const move = (e: PointerEvent): void => {
    if (!line && Math.abs(e.clientY - from) < 5) return;
    if (!line) {
      head.setPointerCapture(event.pointerId);
      line = document.createElement('div');
      line.className = 'track-drop';
      list.append(line);
    }
    const rows = [...list.querySelectorAll<HTMLElement>('.track[data-character]')];
    const over = rows.find((row) => e.clientY < row.getBoundingClientRect().bottom) ?? rows[rows.length - 1];
    if (!over) return;
    const box = over.getBoundingClientRect();
    drop = { target: over.dataset.character!, after: e.clientY > box.top + box.height / 2 };
    line.style.top = `${(drop.after ? box.bottom : box.top) - list.getBoundingClientRect().top + list.scrollTop - 1}px`;
  };
  const stop = (): void => {
    line?.remove();
    head.removeEventListener('pointermove', move);
    head.removeEventListener('pointerup', up);
    head.removeEventListener('pointercancel', stop);
    window.removeEventListener('keydown', key, true);
  };
  const up = (): void => {
    stop();
    if (drop) move_track(character, drop.target, drop.after);
  };
  const key = (e: KeyboardEvent): void => {
    if (e.key !== 'Escape' || !line) return;
    e.preventDefault();
    e.stopPropagation();
    stop();
  };
  head.addEventListener('pointermove', move);
  head.addEventListener('pointerup', up);
  head.addEventListener('pointercancel', stop);
  window.addEventListener('keydown', key, true);
}

/** The row above a group of tracks. While the group is folded, it shows the clips of all members in small. */
export function GroupRow({ name, members, folded, view }: { name: string; members: readonly Character[]; folded: boolean; view: TimeView }): ReactElement {
  const fold = (): void => {
    const now = new Set(page.getState().folded);
    if (!now.delete(name)) now.add(name);
    page.setState({ folded: now });
  };
  return (
    <div className="track group">
      <button type="button" className="track-name plain" aria-expanded={!folded} title={folded ? 'Show the tracks of the group' : 'Hide the tracks of the group'} onClick={fold}>
        <span className="fold" data-folded={folded}><Icon name="down" /></span>
        <span className="label">{name}</span>
        <span className="group-count">{members.length}</span>
      </button>
      <div className="lane" aria-hidden="true">
        {folded && members.flatMap((c, i) => c.track.map((k) => (
          <span key={`${c.id} ${k.id}`} className="group-clip" style={{ left: time_to_x(view, k.start), width: Math.max(2, k.length * view.scale), top: `${10 + (80 * i) / members.length}%`, height: `${Math.max(8, 64 / members.length)}%`, background: c.color ?? '#e6e6ea' }} />
        )))}
      </div>
    </div>
  );
}

interface TrackProps {
  character: Character;
  view: TimeView;
  on_guide: (time: number | null) => void;
  ghost: DropGhost | null;
  /** Called with the preview while a clip of this track is dragged over another track, with null when it no longer is. */
  on_ghost: (ghost: DropGhost | null) => void;
}

export function Track({ character, view, on_guide, ghost, on_ghost }: TrackProps): ReactElement {
  const selection = useStudio((s) => s.selection);
  const blends = blend_spans(character.track);
  const state = usePage((s) => s.character_states[character.id]);
  useStudio((s) => s.library_revision);
  const end_speed = useStudio((s) => s.characters.find((c) => c.id === character.id)?.end_speed);
  const duration = useStudio((s) => shown_document(s)?.duration ?? 0);
  const unfinished = ends_moving(character, end_speed, duration);
  const loop = unfinished && loop_to_end(character, (motion) => session.entry(motion)?.cyclic ?? false, duration);
  const [menu, set_menu] = useState<{ x: number; y: number } | null>(null);
  const chosen = (selection.kind === 'character' && selection.character === character.id) || (selection.kind === 'tracks' && selection.tracks.includes(character.id));
  const active = chosen || items_of(selection).some((item) => item.kind === 'clip' && item.character === character.id);
  const left_out = useStudio((s) => {
    const doc = shown_document(s);
    return doc !== null && is_left_out(doc, character);
  });
  const name = ['track', active && 'active', left_out && 'left-out', character.locked && 'locked'].filter(Boolean).join(' ');
  return (
    <div className={name} data-character={character.id}>
      <div className="track-head">
      <button
        type="button"
        className="track-name"
        aria-pressed={chosen}
        title={`Select ${character.name}\nDrag up or down, or press Alt with an arrow key, to change the order of the tracks. Ctrl-click selects several tracks`}
        onClick={(e) => {
          const { document: doc, selection: now } = session.state;
          session.select(doc && (e.ctrlKey || e.metaKey || e.shiftKey) ? toggle_track(doc, now, character.id) : { kind: 'character', character: character.id });
        }}
        onContextMenu={(e) => {
          if (!selected_tracks(session.state.selection).includes(character.id)) session.select({ kind: 'character', character: character.id });
          set_menu(menu_point(e));
        }}
        onPointerDown={(event) => drag_track(event, character.id)}
        onKeyDown={(event) => {
          if (!event.altKey || (event.key !== 'ArrowUp' && event.key !== 'ArrowDown')) return;
          event.preventDefault();
          event.stopPropagation();
          move_track_by_key(event.currentTarget, character.id, event.key === 'ArrowDown');
        }}
      >
        <span className="dot" style={{ background: character.color ?? '#e6e6ea' }} />
        <span className="label">{character.name}</span>
        {state === CharacterState.released && <span className="released">released</span>}
        {character.control.mode === 'passive' && state !== CharacterState.released && <span className="passive">{character.prop ? (character.prop.mass > 0 ? 'prop' : 'fixed') : 'passive'}</span>}
      </button>
      <TrackSwitches character={character} />
      {menu && <TrackMenu at={menu} close={() => set_menu(null)} />}
      </div>
      <div className="lane">
        <BadMarks character={character.id} view={view} />
        <div className="items" role="list" aria-label={`Clips of ${character.name}`}>
          {character.track.map((clip) => {
            const entry = session.entry(clip.motion);
            return (
              <ClipBox
                key={clip.id}
                character={character.id}
                clip={clip}
                name={entry?.name ?? clip.motion}
                motion_duration={entry?.duration}
                view={view}
                blended={character.track.some((other) => other.id !== clip.id && other.start < clip.start)}
                covered={Math.max(0, ...blends.filter((b) => b.into === clip.id).map((b) => b.to - b.from))}
                selected={is_selected(selection, { kind: 'clip', character: character.id, clip: clip.id })}
                locked={Boolean(character.locked)}
                on_guide={on_guide}
                on_ghost={on_ghost}
              />
            );
          })}
        </div>
        {blends.map((span) => (
          <svg
            key={span.into}
            className="blend"
            aria-hidden="true"
            preserveAspectRatio="none"
            viewBox="0 0 10 10"
            style={{ left: time_to_x(view, span.from), width: Math.max(1, (span.to - span.from) * view.scale) }}
          >
            <path d="M0 0L10 10M0 10L10 0" vectorEffect="non-scaling-stroke" />
          </svg>
        ))}
        {unfinished && (
          <span
            className="unfinished"
            role="note"
            style={{ left: time_to_x(view, unfinished.time) }}
            title="The track ends during a movement; the character then holds the last pose. End the track with a motion that stands still, or loop the last clip to the end."
          >
            ends at {format_number(unfinished.speed, 1)} m/s: the character may fall
            {loop && (
              <button type="button" className="quiet insert" title="Repeat the last clip until the end of the scenario" onPointerDown={(e) => e.stopPropagation()} onClick={() => void session.edit(loop)}>
                Loop to the end
              </button>
            )}
          </span>
        )}
        {ghost && (
          <div className={ghost.refused ? 'clip drop refused' : 'clip drop'} style={{ left: time_to_x(view, ghost.start), width: Math.max(8, ghost.length * view.scale) }}>
            <span className="clip-name">{ghost.refused ? `${ghost.name}: for another mechanism` : ghost.name}</span>
          </div>
        )}
        <ContactBar character={character.id} view={view} />
      </div>
    </div>
  );
}

/** `command` grouped with the commands that adapt cross-fades to the overlaps that `command` changes. */
function with_blends(document: ScenarioDocument, command: Extract<Command, { type: 'clip.set' }>): Command {
  const track = (doc: ScenarioDocument): Clip[] => find_character(doc, command.character)?.track ?? [];
  const blends = fit_blends(command.character, track(document), track(apply_command(document, command)));
  return blends.length > 0 ? { type: 'group', label: 'Move clip', commands: [command, ...blends] } : command;
}

interface ClipBoxProps {
  character: string;
  clip: Clip;
  name: string;
  motion_duration: number | undefined;
  view: TimeView;
  /** True: another clip begins before this clip, so this clip may begin with a cross-fade. */
  blended: boolean;
  /** Duration of the cross-fade at the start of the clip, s; the clip's name is drawn after the cross-fade. */
  covered: number;
  selected: boolean;
  /** True: the track is locked, so the clip can be selected but not changed. */
  locked: boolean;
  on_guide: (time: number | null) => void;
  on_ghost: (ghost: DropGhost | null) => void;
}

function ClipBox({ character, clip, name, motion_duration, view, blended, covered, selected, locked, on_guide, on_ghost }: ClipBoxProps): ReactElement {
  const width = Math.max(4, clip.length * view.scale);

  const kind_at = (event: React.PointerEvent<HTMLElement>): ClipDragKind => {
    const box = event.currentTarget.getBoundingClientRect();
    const edge = Math.min(edge_px, box.width / 4);
    if (event.clientX - box.left < edge) return 'trim_start';
    if (box.right - event.clientX < edge) return event.altKey ? 'stretch' : 'trim_end';
    return event.altKey ? 'slip' : 'move';
  };

  const down = (event: React.PointerEvent<HTMLElement>): void => {
    if (event.button !== 0) return;
    event.stopPropagation();
    const item: Item = { kind: 'clip', character, clip: clip.id };
    const kind = kind_at(event);
    const { together, click } = press_item(event, item);
    const document = session.state.document;
    const origin = document && find_character(document, character)?.track.find((k) => k.id === clip.id);
    if (!document || !origin) return;
    const nothing = (): void => undefined;
    if (locked) return start_drag({ event, scale: view.scale, click, move: nothing, done: nothing, cancel: nothing });
    if (together && kind === 'move') return start_drag({ event, scale: view.scale, click, ...drag_together(together, on_guide) });
    let command: Command | null = null;
    let other: DropGhost | null = null; // preview on another character's track while the clip is over that track
    start_drag({
      event,
      scale: view.scale,
      click,
      move: (delta, rules, over) => {
        session.select(item);
        const result = drag_clip(origin, kind, delta, rules(document, clip.id), motion_duration);
        on_guide(result.at);
        const under = kind === 'move' ? over?.closest<HTMLElement>('[data-character]')?.dataset.character : undefined;
        const target = under !== undefined && under !== character ? find_character(document, under) : undefined;
        const fits = target?.mechanism === find_character(document, character)?.mechanism;
        other = target ? { entry: clip.motion, character: target.id, start: result.fields.start ?? clip.start, length: clip.length, refused: !fits, name } : null;
        on_ghost(other);
        const fields = other ? null : changed_fields(origin, result.fields);
        const ripples = page.getState().ripple && kind !== 'slip';
        command = fields && (ripples ? ripple_clip(document, character, origin, fields) : with_blends(document, { type: 'clip.set', character, id: clip.id, ...fields }));
        session.show_preview(command && apply_command(document, command));
      },
      done: () => {
        on_guide(null);
        on_ghost(null);
        if (other && !other.refused) {
          const { character: to, start } = other;
          void session.edit(move_clip(origin, character, to!, start)).then((ok) => ok && session.select({ kind: 'clip', character: to!, clip: origin.id }));
        } else if (command) void session.edit(command);
        else session.show_preview(null);
      },
      cancel: () => {
        on_guide(null);
        on_ghost(null);
        session.show_preview(null);
      },
    });
  };

  /** Drags the handle at the end of the cross-fade, which changes its duration. */
  const drag_blend = (event: React.PointerEvent<HTMLElement>): void => {
    const document = session.state.document;
    if (event.button !== 0 || !document || locked) return;
    event.stopPropagation();
    session.select({ kind: 'clip', character, clip: clip.id });
    let command: Command | null = null;
    start_drag({
      event,
      scale: view.scale,
      move: (delta, rules) => {
        const end = clip.start + clip.blend;
        const snapped = snap_delta([end], delta, rules(document, clip.id));
        on_guide(snapped.at);
        const blend = Math.round(Math.min(clip.length, longest_blend, Math.max(0, clip.blend + snapped.delta)) * 1e6) / 1e6;
        command = { type: 'clip.set', character, id: clip.id, blend };
        session.show_preview(apply_command(document, command));
      },
      done: () => {
        on_guide(null);
        if (command) void session.edit(command);
      },
      cancel: () => {
        on_guide(null);
        session.show_preview(null);
      },
    });
  };

  const hover = (event: React.PointerEvent<HTMLElement>): void => {
    if (event.buttons !== 0) return;
    const kind = kind_at(event);
    event.currentTarget.style.cursor = locked ? 'not-allowed' : kind === 'move' ? 'grab' : kind === 'slip' ? 'col-resize' : 'ew-resize';
  };

  const loop_marks: number[] = [];
  if (clip.loop && motion_duration && motion_duration > 0) {
    const period = motion_duration / clip.speed;
    let at = (motion_duration - (clip.offset % motion_duration)) / clip.speed;
    for (; at < clip.length - 1e-6 && loop_marks.length < 200; at += period) if (period * view.scale > 6) loop_marks.push(at * view.scale);
  }
  const contacts = useDesk((s) => s.contacts[clip.motion]);
  const menu = (x: number, y: number): void => {
    session.select({ kind: 'clip', character, clip: clip.id });
    desk.open_menu({ character, clip: clip.id, x, y });
  };
  const details = [clip.speed !== 1 && `× ${format_number(clip.speed)}`, clip.loop && '↻'].filter(Boolean).join('  ');
  return (
    <div
      role="listitem"
      tabIndex={0}
      className={selected ? 'clip selected' : 'clip'}
      data-clip={clip.id}
      aria-label={`${name}, from ${format_time(clip.start)} for ${format_number(clip.length)} seconds${selected ? ', selected' : ''}`}
      title={`${name}\n${format_number(clip.start)} s … ${format_number(clip.start + clip.length)} s${clip.offset ? `, from ${format_number(clip.offset)} s of the motion` : ''}`}
      style={{ left: time_to_x(view, clip.start), width }}
      onPointerDown={down}
      onPointerMove={hover}
      onFocus={(e) => select_focused(e, { kind: 'clip', character, clip: clip.id })}
      onContextMenu={(e) => {
        e.preventDefault();
        const box = e.currentTarget.getBoundingClientRect();
        // the menu key gives no pointer position: open the menu below the clip
        if (e.button === 2) menu(e.clientX, e.clientY);
        else menu(Math.max(box.left, 0) + 8, box.bottom);
      }}
    >
      {blended && clip.blend > 0 && <span className="fade" style={{ width: Math.min(width, clip.blend * view.scale) }} />}
      {blended && <span className="fade-handle" title={`Cross-fade of ${format_number(clip.blend)} s: drag to change`} style={{ left: Math.max(edge_px + 5, Math.min(width - edge_px - 5, clip.blend * view.scale)) }} onPointerDown={drag_blend} onPointerMove={(e) => e.stopPropagation()} />}
      {loop_marks.map((x) => (
        <span key={x} className="loop-mark" style={{ left: x }} />
      ))}
      {contacts && contacts.feet.length > 0 && motion_duration !== undefined && motion_duration > 0 && (
        <span
          className="contact-bands"
          role="img"
          aria-label="Feet in contact: green two or more, yellow one, orange none"
          style={{
            backgroundImage: band_gradient(contacts.bands, motion_duration),
            backgroundSize: `${(motion_duration / clip.speed) * view.scale}px 100%`,
            backgroundPositionX: -(clip.offset / clip.speed) * view.scale,
          }}
        />
      )}
      <KeyMarks clip={clip} motion_duration={motion_duration} scale={view.scale} width={width} />
      <span className="clip-name" style={covered > 0 ? { marginLeft: Math.min(covered * view.scale, width / 2) } : undefined}>
        {name}
        {details && <span className="clip-details"> {details}</span>}
      </span>
    </div>
  );
}

/** Diamonds at the times of the keys of the clip's layers; those of layers that are off are not drawn. */
function KeyMarks({ clip, motion_duration, scale, width }: { clip: Clip; motion_duration: number | undefined; scale: number; width: number }): ReactElement | null {
  const { layers } = clip;
  const times = useMemo(() => (layers ? layer_times(clip, motion_duration ?? 0) : []), [clip, layers, motion_duration]);
  if (times.length === 0) return null;
  const size = 3; // px, from the centre of a mark to its corners
  let last = -Infinity;
  const path = times.flatMap((time) => {
    const x = (time - clip.start) * scale;
    if (x - last < 2 * size) return []; // marks that would overlap are drawn as one
    last = x;
    return `M${x.toFixed(1)} 0l${size} ${size}l${-size} ${size}l${-size} ${-size}z`;
  });
  const label = times.length === 1 ? 'Key of a pose' : `${times.length} keys of poses`;
  return <svg className="key-marks" role="img" aria-label={label} width={width} height={2 * size + 1}><path d={path.join('')} /></svg>;
}

/** Feet in contact with the ground over time, from the simulation: green two or more, yellow one, orange none. */
function ContactBar({ character, view }: { character: string; view: TimeView }): ReactElement {
  const canvas = useRef<HTMLCanvasElement>(null);
  const contacts = useStudio((s) => s.summary.contacts);
  const theme = useStudio((s) => s.theme);
  useLayoutEffect(() => {
    const element = canvas.current;
    const context = element?.getContext('2d', plain_canvas);
    if (!element || !context) return;
    const draw = (): void => {
      const ratio = window.devicePixelRatio || 1;
      const { clientWidth: width, clientHeight: height } = element;
      element.width = Math.max(1, Math.round(width * ratio));
      element.height = Math.max(1, Math.round(height * ratio));
      context.scale(ratio, ratio);
      const style = getComputedStyle(element);
      for (const span of contacts) {
        if (span.character !== character) continue;
        const x = time_to_x(view, span.from);
        const w = (span.to - span.from) * view.scale;
        if (x > width || x + w < 0) continue;
        context.fillStyle = style.getPropertyValue(span.feet >= 2 ? '--good' : span.feet === 1 ? '--one' : '--flight');
        const gap = w > 5 ? 1 : 0;
        context.beginPath();
        context.roundRect(x, 0, Math.max(1, w - gap), height, height / 2);
        context.fill();
      }
    };
    draw();
    const observer = new ResizeObserver(draw);
    observer.observe(element);
    return () => observer.disconnect();
  }, [contacts, character, view, theme]);
  return <canvas ref={canvas} className="contacts" role="img" aria-label="Feet in contact with the ground: green two or more, yellow one, orange none" title="Feet in contact with the ground: green two or more, yellow one, orange none" />;
}

/** Red lines above the clips at the times at which a measure of naturalness is bad; the naturalness panel names the measures. */
function BadMarks({ character, view }: { character: string; view: TimeView }): ReactElement {
  const measures = useStudio((s) => s.measures);
  const spans = useMemo(() => measures.list.flatMap((measure) => measures.bad_spans(character, measure)), [measures, character]);
  return (
    <>
      {spans.map((span) => (
        <span
          key={`${span.measure.key} ${span.from}`}
          className="problem-mark"
          title={describe_span(span)}
          style={{ left: time_to_x(view, span.from), width: Math.max(2, (span.to - span.from) * view.scale) }}
        />
      ))}
    </>
  );
}
