/** A card of the library's list: picture, name and facts of an entry. The picture of a motion plays while the pointer is over it. */
import { useEffect, useRef, useState, type ReactElement } from 'react';
import { describe_entry, key_of, tags_of } from '../../core/library/words';
import type { LibraryEntry } from '../../core/protocol';
import { picture_size } from '../../view/preview';
import { add_character, append_motion } from '../actions';
import { library, page, plain_canvas, session, usePage, useStudio } from '../app';
import { Icon } from '../icons';
import { character_color, drawn_picture, moving, preview_renderer, stored_path, stored_picture, want_picture } from './pictures';

/** Adds an entry to the scenario, as a double click does: a mechanism as a character, a motion at the end of a track with its mechanism. */
export function use_entry(entry: LibraryEntry): void {
  library.forget_done(); // the next Undo applies to this command, not to the last change of the library
  if (entry.kind === 'mechanism') return void add_character(entry.id);
  const { selection, document } = session.state;
  const chosen = selection.kind === 'character' || selection.kind === 'clip' ? selection.character : undefined;
  const fits = document?.characters.filter((c) => !entry.mechanism || c.mechanism === entry.mechanism) ?? [];
  const target = fits.find((c) => c.id === chosen) ?? fits[0];
  if (target) append_motion(target.id, entry.id);
  else if (entry.mechanism) void add_character(entry.mechanism, undefined, entry.id);
}

interface CardProps {
  entry: LibraryEntry;
  index: number;
  total: number;
  grid: boolean;
  selected: boolean;
  renaming: boolean;
  on_select: () => void;
  on_renamed: (name: string | null) => void;
}

export function Card({ entry, index, total, grid, selected, renaming, on_select, on_renamed }: CardProps): ReactElement {
  const in_use = useStudio((s) => s.document?.characters.some((c) => (entry.kind === 'mechanism' ? c.mechanism === entry.id : c.track.some((k) => k.motion === entry.id))) ?? false);
  const dragging = usePage((s) => s.dragged_entry === key_of(entry));
  const [over, set_over] = useState(false);
  const tags = tags_of(entry);
  return (
    <div
      id={`entry-${key_of(entry)}`}
      role="option"
      aria-selected={selected}
      aria-setsize={total}
      aria-posinset={index + 1}
      className={`entry${grid ? ' tile' : ''}${selected ? ' selected' : ''}${dragging ? ' dragging' : ''}`}
      draggable={!renaming}
      data-entry={key_of(entry)}
      title={renaming ? undefined : `${entry.name}\nDrag it onto ${entry.kind === 'motion' ? 'a track or a character' : 'the floor or the scenario'}, or double-click to add it`}
      onPointerEnter={() => set_over(true)}
      onPointerLeave={() => set_over(false)}
      onPointerDown={on_select}
      onDoubleClick={() => !renaming && use_entry(entry)}
      onDragStart={(e) => {
        e.dataTransfer.setData('application/x-ugoki-entry', key_of(entry));
        e.dataTransfer.effectAllowed = 'copy';
        page.setState({ dragged_entry: key_of(entry) });
        set_over(false);
      }}
      onDragEnd={(e) => {
        page.setState({ dragged_entry: null });
        if (e.dataTransfer.dropEffect !== 'none') library.forget_done();
      }}
    >
      <span className="thumb">
        <StillPicture entry={entry} />
        {entry.kind === 'motion' && (over || (selected && grid)) && <MovingPicture entry={entry} on={over} />}
      </span>
      <span className="entry-text">
        {renaming ? <NameField entry={entry} on_done={on_renamed} /> : <span className="entry-name">{entry.name}</span>}
        <span className="entry-facts">
          <Icon name={entry.kind === 'motion' ? 'wave' : entry.mesh ? 'box' : 'character'} />
          <span>{describe_entry(entry)}</span>
        </span>
        {!grid && tags.length > 0 && <span className="entry-tags">{tags.join(' · ')}</span>}
      </span>
      {in_use && <span className="in-use" role="img" aria-label="in this scenario" title="In this scenario" />}
    </div>
  );
}

function NameField({ entry, on_done }: { entry: LibraryEntry; on_done: (name: string | null) => void }): ReactElement {
  const [text, set_text] = useState(entry.name);
  const finished = useRef(false);
  const finish = (name: string | null): void => {
    if (finished.current) return;
    finished.current = true;
    on_done(name);
  };
  return (
    <input
      className="entry-rename"
      aria-label={`New name of ${entry.name}`}
      autoFocus
      value={text}
      maxLength={200}
      onFocus={(e) => e.target.select()}
      onChange={(e) => set_text(e.target.value)}
      onPointerDown={(e) => e.stopPropagation()}
      onKeyDown={(e) => {
        e.stopPropagation();
        if (e.key === 'Enter') finish(text);
        if (e.key === 'Escape') finish(null);
      }}
      onBlur={() => finish(text)}
    />
  );
}

/** Still picture of an entry. If the library has none, it is drawn after the card has been in view for 140 ms. */
function StillPicture({ entry }: { entry: LibraryEntry }): ReactElement {
  const [shown, set_shown] = useState<{ id: string; address: string | null } | null>(null);
  const [broken, set_broken] = useState(false);
  const drawn = drawn_picture(entry);
  const path = broken ? null : stored_path(entry);
  useEffect(() => {
    if (drawn) return;
    let mounted = true;
    let cancel = (): void => undefined;
    const show = (address: string | null): void => {
      if (mounted) set_shown({ id: entry.id, address });
    };
    if (path) stored_picture(path).then(show, () => mounted && set_broken(true));
    const timer = path ? undefined : setTimeout(() => (cancel = want_picture(entry, show)), 140);
    return () => {
      mounted = false;
      clearTimeout(timer);
      cancel();
    };
  }, [entry.id, drawn, path]);
  const address = drawn ?? (shown?.id === entry.id ? shown.address : null);
  return address ? <img src={address} alt="" draggable={false} onError={() => set_broken(true)} /> : <Icon name={entry.kind === 'motion' ? 'wave' : 'character'} />;
}

/** Plays the motion in a loop; a thin bar shows the progress. */
function MovingPicture({ entry, on }: { entry: LibraryEntry; on: boolean }): ReactElement {
  const canvas = useRef<HTMLCanvasElement>(null);
  const bar = useRef<HTMLSpanElement>(null);
  const [shown, set_shown] = useState(false);
  useEffect(() => {
    if (!on) {
      set_shown(false);
      return;
    }
    let handle = 0;
    let ended = false;
    const timer = setTimeout(() => {
      moving(entry.id)
        .then(({ mechanism, poses }) => {
          const context = canvas.current?.getContext('2d', plain_canvas);
          const renderer = preview_renderer();
          if (ended || !context || !renderer) return;
          const start = performance.now();
          let last = -1000;
          const tick = (now: number): void => {
            handle = requestAnimationFrame(tick);
            if (now - last < 30) return;
            last = now;
            const time = poses.duration > 0 ? ((now - start) / 1000) % poses.duration : 0;
            const share = poses.duration > 0 ? time / poses.duration : 0;
            if (renderer.draw(mechanism, character_color, context, poses, share)) set_shown(true);
            if (bar.current) bar.current.style.transform = `scaleX(${share.toFixed(3)})`;
            if (canvas.current) canvas.current.dataset.time = time.toFixed(2);
          };
          handle = requestAnimationFrame(tick);
        })
        .catch(() => undefined); // on an error, keep the still picture
    }, 160);
    return () => {
      ended = true;
      clearTimeout(timer);
      cancelAnimationFrame(handle);
    };
  }, [entry.id, on]);
  return (
    <>
      <canvas ref={canvas} className="moves" width={picture_size.width} height={picture_size.height} aria-hidden="true" style={{ visibility: shown ? 'visible' : 'hidden' }} />
      <span ref={bar} className="moves-bar" aria-hidden="true" style={{ visibility: shown ? 'visible' : 'hidden' }} />
    </>
  );
}

/** Actions on an entry for its context menu. */
export function entry_actions(entry: LibraryEntry, start_rename: () => void): { label: string; key?: string; run: () => void; possible: boolean }[] {
  const in_library = entry.entry !== undefined;
  return [
    { label: entry.kind === 'mechanism' ? 'Add to the scenario' : 'Add to a track', key: 'Enter', run: () => use_entry(entry), possible: true },
    { label: 'Rename', key: 'F2', run: start_rename, possible: in_library },
    { label: 'Duplicate', key: 'Ctrl D', run: () => void library.duplicate(entry).then((made) => made && session.select({ kind: 'entry', entry: key_of(made) })), possible: in_library },
    { label: 'Delete', key: 'Del', run: () => void library.remove(entry), possible: in_library },
  ];
}
