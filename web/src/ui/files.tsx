/** The menu of the project, the dialog that opens a project, and the gallery for new projects. */
import { useState, type KeyboardEvent, type ReactElement } from 'react';
import { gallery, type GalleryEntry } from '../core/gallery';
import { session, useStudio } from './app';
import { command_item } from './command_item';
import { Backdrop } from './dialogs';
import { Icon } from './icons';
import { Menu, type MenuItem } from './Menu';

const close = (): void => session.set({ dialog: 'none' });

/** The project's name in the top bar; it opens the menu of the project. */
export function ProjectMenu(): ReactElement {
  const project = useStudio((s) => s.project);
  const name = useStudio((s) => s.document?.name);
  const recent = useStudio((s) => s.recent);
  const keymap = useStudio((s) => s.keymap);
  const [at, set_at] = useState<{ x: number; y: number } | null>(null);
  const command = (id: string, apart = false): MenuItem => command_item(id, keymap, { apart });
  const others = recent.filter((r) => r.path !== project?.path).slice(0, 6);
  const items: MenuItem[] = [
    command('file.new'),
    command('file.open'),
    ...others.map((r, i): MenuItem => ({ label: `Open ${r.name}`, title: r.path, apart: i === 0, run: () => void session.open(r.path) })),
    command('file.save', true),
    command('file.save_as'),
    command('file.import', true),
    command('file.sweep', true),
  ];
  return (
    <>
      <button
        type="button"
        className="project"
        aria-haspopup="menu"
        aria-expanded={at !== null}
        title={project ? `${project.path || 'not saved yet'}${project.unsaved ? ' — unsaved changes' : ''}` : ''}
        onClick={(e) => {
          const box = e.currentTarget.getBoundingClientRect();
          set_at({ x: box.left, y: box.bottom + 4 });
        }}
      >
        <span className="project-name">{project?.name || name || ''}</span>
        {project?.unsaved && <span className="unsaved" role="img" aria-label="unsaved changes">•</span>}
        <Icon name="down" />
      </button>
      {at && <Menu x={at.x} y={at.y} items={items} close={() => set_at(null)} over label="Project" />}
    </>
  );
}

export function OpenDialog(): ReactElement {
  const recent = useStudio((s) => s.recent);
  const open_path = useStudio((s) => s.project?.path ?? '');
  const [path, set_path] = useState('');
  const open = async (wanted: string): Promise<void> => {
    if (await session.open(wanted)) close();
  };
  return (
    <Backdrop label="Open project" top>
      <form
        className="save-as open-project"
        onSubmit={(e) => {
          e.preventDefault();
          void open(path.trim());
        }}
      >
        <h2>Open project</h2>
        {recent.length > 1 ? (
          <ul aria-label="Recent projects">
            {recent.filter((r) => r.path !== open_path).map((r) => (
              <li key={r.path}>
                <button type="button" onClick={() => void open(r.path)}>
                  <strong>{r.name}</strong>
                  <span><bdi>{r.path}</bdi></span>
                </button>
              </li>
            ))}
          </ul>
        ) : (
          <p className="taken">Projects that you open appear here.</p>
        )}
        <label htmlFor="open-path">Or enter the path of a project</label>
        <input id="open-path" autoFocus value={path} placeholder="folder/name.ugoki" spellCheck={false} onChange={(e) => set_path(e.target.value)} />
        <div className="actions">
          <button type="button" onClick={close}>Cancel</button>
          <button type="submit" className="primary" disabled={!path.trim()}>Open</button>
        </div>
      </form>
    </Backdrop>
  );
}

export function NewDialog(): ReactElement {
  const [chosen, set_chosen] = useState<GalleryEntry>(gallery[0]!);
  const [name, set_name] = useState('');
  const [busy, set_busy] = useState(false);
  const create = async (entry: GalleryEntry): Promise<void> => {
    if (busy) return;
    set_busy(true);
    const from = typeof entry.from === 'function' ? await entry.from() : entry.from;
    if (await session.create(name.trim() || (entry.id === 'empty' ? 'untitled' : entry.id), from)) close();
    set_busy(false);
  };
  /** Left and right choose the previous or the next content, up and down the one in the row above or below; Home and End the first and the last. */
  const choose_by_arrow = (event: KeyboardEvent<HTMLDivElement>): void => {
    const cards = [...event.currentTarget.querySelectorAll<HTMLElement>('.gallery-card')];
    const columns = Math.max(1, cards.filter((c) => c.offsetTop === cards[0]?.offsetTop).length);
    const now = gallery.indexOf(chosen);
    const to = { ArrowRight: now + 1, ArrowLeft: now - 1, ArrowDown: now + columns, ArrowUp: now - columns, Home: 0, End: gallery.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    const entry = gallery[to];
    if (!entry) return;
    set_chosen(entry);
    cards[to]?.focus();
  };
  return (
    <Backdrop label="New project">
      <form
        className="gallery"
        onSubmit={(e) => {
          e.preventDefault();
          void create(chosen);
        }}
      >
        <h2>New project</h2>
        <div className="gallery-cards" role="radiogroup" aria-label="Begin with" onKeyDown={choose_by_arrow}>
          {gallery.map((entry) => (
            <button
              key={entry.id}
              type="button"
              role="radio"
              aria-checked={entry === chosen}
              tabIndex={entry === chosen ? 0 : -1}
              className="gallery-card"
              data-entry={entry.id}
              onClick={() => set_chosen(entry)}
              onDoubleClick={() => void create(entry)}
            >
              <img className="gallery-picture" src={`gallery/${entry.id}.webp`} alt="" width="320" height="180" />
              <strong>{entry.title}</strong>
              <span>{entry.teaches}</span>
            </button>
          ))}
        </div>
        <div className="gallery-foot">
          <label htmlFor="new-name">Name</label>
          <input id="new-name" autoFocus value={name} placeholder={chosen.id === 'empty' ? 'untitled' : chosen.id} spellCheck={false} onChange={(e) => set_name(e.target.value)} />
          <span className="taken">The file is written to the folder of the open project.</span>
          <div className="actions">
            <button type="button" onClick={close}>Cancel</button>
            <button type="submit" className="primary" disabled={busy}>{busy ? 'Creating…' : 'Create'}</button>
          </div>
        </div>
      </form>
    </Backdrop>
  );
}
