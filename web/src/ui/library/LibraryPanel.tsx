/** The library panel: search, filters, the list of entries, the trash; files dropped on it are imported. */
import { useEffect, useLayoutEffect, useMemo, useRef, useState, type KeyboardEvent, type ReactElement } from 'react';
import type { KindFilter, LibraryOrder } from '../../core/library/browser';
import { key_of } from '../../core/library/words';
import type { LibraryEntry } from '../../core/protocol';
import { imports, library, parts, session, useLibrary, useStudio } from '../app';
import { Icon } from '../icons';
import { Card, entry_actions, use_entry } from './cards';

const kinds: [KindFilter, string][] = [['all', 'All'], ['mechanism', 'Mechanisms'], ['motion', 'Motions']];
const orders: [LibraryOrder, string][] = [['newest', 'Newest'], ['oldest', 'Oldest'], ['longest', 'Longest'], ['shortest', 'Shortest']];
export const importable = '.bvh,.asf,.amc,.c3d,.trc,.csv,.glb,.gltf,.fbx,.dae,.usda,.usd,.mvnx,.npz,.mot,.sto,.osim,.txt,.json,.urdf,.sdf,.xml,.stl,.obj,.ply,.mtl,.bin';
const look_key = 'ugoki.library.look';

function stored_look(): 'list' | 'grid' {
  try {
    return localStorage.getItem(look_key) === 'grid' ? 'grid' : 'list';
  } catch {
    return 'list';
  }
}

export function LibraryPanel(): ReactElement {
  const query = useLibrary((s) => s.query);
  const kind = useLibrary((s) => s.kind);
  const trash = useLibrary((s) => s.trash);
  const [look, set_look] = useState(stored_look);
  const files = useRef<HTMLInputElement>(null);
  const search = useRef<HTMLInputElement>(null);
  useEffect(() => {
    parts.choose_files = () => files.current?.click();
    parts.search_library = () => {
      parts.show_panel('library');
      // the browser gives the focus to an element of a hidden panel only after the panel is shown
      requestAnimationFrame(() => search.current?.focus());
    };
    void library.load();
  }, []);

  const change_look = (): void => {
    const next = look === 'list' ? 'grid' : 'list';
    set_look(next);
    try {
      localStorage.setItem(look_key, next);
    } catch {
      // without local storage the choice is lost when the page closes
    }
  };
  return (
    <div
      className="panel library"
      onKeyDown={(e) => {
        if ((e.ctrlKey || e.metaKey) && e.key.toLowerCase() === 'z' && !e.shiftKey && (e.target as HTMLElement).tagName !== 'INPUT' && library.state.done) {
          e.preventDefault();
          e.stopPropagation();
          void library.undo();
        }
      }}
    >
      <div className="library-head">
        <div className="search">
          <Icon name="search" />
          <input
            ref={search}
            type="search"
            placeholder={trash ? 'Search the trash' : 'Search the library'}
            title="Search the library  (/)"
            aria-label="Search the library"
            aria-controls="library-list"
            value={query}
            onChange={(e) => library.search(e.target.value)}
            onKeyDown={(e) => {
              if (e.key === 'Escape' && query) library.search('');
              if (e.key !== 'ArrowDown' && e.key !== 'Enter') return;
              e.preventDefault();
              document.getElementById('library-list')?.focus();
            }}
          />
        </div>
        <button type="button" className="tool" title="Import motions, mechanisms and meshes  (Ctrl I)" aria-label="Import a file" onClick={() => files.current?.click()}>
          <Icon name="import" />
        </button>
        <input
          ref={files}
          type="file"
          hidden
          multiple
          accept={importable}
          onChange={(e) => {
            const chosen = [...(e.target.files ?? [])];
            e.target.value = '';
            void imports.add(chosen);
          }}
        />
      </div>
      <div className="library-filter" role="toolbar" aria-label="Filter">
        <div className="kinds" role="radiogroup" aria-label="Kind">
          {kinds.map(([value, name]) => (
            <button key={value} type="button" role="radio" aria-checked={kind === value} onClick={() => library.filter({ kind: value })}>
              {name}
            </button>
          ))}
        </div>
        <button type="button" className="tool small look" aria-label={look === 'list' ? 'Show as tiles' : 'Show as a list'} title={look === 'list' ? 'Show as tiles' : 'Show as a list'} onClick={change_look}>
          <Icon name={look === 'list' ? 'tiles' : 'rows'} />
        </button>
      </div>
      <Tags />
      <Away />
      <Entries look={look} import_files={() => files.current?.click()} to_search={() => search.current?.focus()} />
      <Foot />
      <ConflictQuestion />
    </div>
  );
}

/** Reports a library that does not respond while older entries are still shown. */
function Away(): ReactElement | null {
  const failed = useLibrary((s) => s.status === 'failed' && s.entries.length > 0);
  const failure = useLibrary((s) => s.failure);
  const away = useLibrary((s) => s.away);
  if (!failed) return null;
  return (
    <div className="nothing away" role="alert">
      <strong>{failure_title(away)}</strong>
      <p>{failure}</p>
      <button type="button" onClick={() => void library.load()}>Retry</button>
    </div>
  );
}

const failure_title = (away: boolean): string => (away ? 'The library does not respond' : 'The library could not be read');

/** The tag filter. It shows the chosen tags, then other tags, up to six in all; "more" shows the rest. */
function Tags(): ReactElement | null {
  const all = useLibrary((s) => s.all_tags);
  const chosen = useLibrary((s) => s.tags);
  const [more, set_more] = useState(false);
  if (all.length === 0 && chosen.length === 0) return null;
  const rest = all.filter((t) => !chosen.includes(t.name));
  const shown = [...chosen.map((name) => ({ name, count: all.find((t) => t.name === name)?.count })), ...(more ? rest : rest.slice(0, Math.max(0, 6 - chosen.length)))];
  return (
    <div className="library-tags" role="group" aria-label="Tags">
      {shown.map((tag) => (
        <button key={tag.name} type="button" className="tag" aria-pressed={chosen.includes(tag.name)} onClick={() => library.toggle_tag(tag.name)}>
          {tag.name}
          {tag.count !== undefined && <span className="count">{tag.count}</span>}
        </button>
      ))}
      {rest.length > 6 && (
        <button type="button" className="quiet" aria-expanded={more} onClick={() => set_more(!more)}>
          {more ? 'fewer' : `${rest.length - Math.max(0, 6 - chosen.length)} more`}
        </button>
      )}
    </div>
  );
}

interface Menu {
  entry: LibraryEntry;
  x: number;
  y: number;
}

/** The list of entries. Only rows in view are rendered (virtual scrolling). */
function Entries({ look, import_files, to_search }: { look: 'list' | 'grid'; import_files: () => void; to_search: () => void }): ReactElement {
  const entries = useLibrary((s) => s.entries);
  const more = useLibrary((s) => s.more);
  const total = useLibrary((s) => s.total);
  const status = useLibrary((s) => s.status);
  const chosen = useStudio((s) => (s.selection.kind === 'entry' ? s.selection.entry : null));
  const list = useRef<HTMLDivElement>(null);
  const [box, set_box] = useState({ width: 240, height: 400, unit: 4 });
  const [top, set_top] = useState(0);
  const [renaming, set_renaming] = useState<string | null>(null);
  const [menu, set_menu] = useState<Menu | null>(null);

  useLayoutEffect(() => {
    const element = list.current;
    if (!element) return;
    const measure = (): void => set_box({ width: element.clientWidth, height: element.clientHeight, unit: (4 * parseFloat(getComputedStyle(document.documentElement).fontSize)) / 13 });
    const observer = new ResizeObserver(measure);
    observer.observe(element);
    measure();
    return () => observer.disconnect();
  }, []);

  const grid = look === 'grid';
  const columns = grid ? Math.max(1, Math.floor(box.width / (27 * box.unit))) : 1;
  const row = grid ? Math.round((box.width / columns) * 0.75 + 11 * box.unit) : Math.round(15 * box.unit);
  const rows = Math.ceil(entries.length / columns);
  const first = Math.max(0, Math.floor(top / row) - 3);
  const last = Math.min(rows, Math.ceil((top + box.height) / row) + 3);
  const shown = useMemo(() => entries.slice(first * columns, last * columns), [entries, first, last, columns]);
  useEffect(() => {
    if (more && last >= rows - 6) void library.load_more();
  }, [more, last, rows]);

  const at = entries.findIndex((e) => key_of(e) === chosen);
  const reveal = (index: number): void => {
    const element = list.current;
    if (!element) return;
    const y = Math.floor(index / columns) * row;
    if (y < element.scrollTop) element.scrollTop = y;
    else if (y + row > element.scrollTop + element.clientHeight) element.scrollTop = y + row - element.clientHeight;
  };
  const choose = (index: number): void => {
    const entry = entries[Math.min(entries.length - 1, Math.max(0, index))];
    if (!entry) return;
    session.select({ kind: 'entry', entry: key_of(entry) });
    reveal(entries.indexOf(entry));
  };
  useEffect(() => {
    if (at >= 0) reveal(at); // show an entry that was selected outside of this list, by an import or a copy
  }, [chosen, entries.length]);

  const keys = (event: KeyboardEvent): void => {
    if (renaming !== null) return;
    const entry = entries[at];
    const page = Math.max(1, Math.floor(box.height / row)) * columns;
    const command = event.ctrlKey || event.metaKey;
    const steps: Record<string, number> = { ArrowDown: columns, ArrowUp: -columns, PageDown: page, PageUp: -page, ...(grid ? { ArrowRight: 1, ArrowLeft: -1 } : {}) };
    const step = steps[event.key];
    if (step !== undefined && !command) choose(at < 0 ? 0 : at + step);
    else if (event.key === 'Home') choose(0);
    else if (event.key === 'End') choose(entries.length - 1);
    else if (event.key === 'Enter' && entry) use_entry(entry);
    else if (event.key === 'F2' && entry?.entry) set_renaming(key_of(entry));
    else if ((event.key === 'Delete' || event.key === 'Backspace') && entry) {
      void library.remove(entry);
      choose(at + 1 < entries.length ? at + 1 : at - 1);
    } else if (command && event.key.toLowerCase() === 'd' && entry) {
      void library.duplicate(entry).then((made) => made && session.select({ kind: 'entry', entry: key_of(made) }));
    } else if (event.key === '/') to_search();
    else if ((event.key === 'ContextMenu' || (event.shiftKey && event.key === 'F10')) && entry) {
      const card = document.getElementById(`entry-${key_of(entry)}`)?.getBoundingClientRect();
      if (card) set_menu({ entry, x: card.left + 40, y: card.top + 20 });
    } else return;
    event.preventDefault();
    event.stopPropagation();
  };

  return (
    <>
      <div
        ref={list}
        id="library-list"
        className={grid ? 'entries tiles' : 'entries'}
        role={entries.length > 0 ? 'listbox' : 'group'}
        tabIndex={0}
        aria-label={`Library, ${total} ${total === 1 ? 'entry' : 'entries'}`}
        aria-activedescendant={at >= 0 && at >= first * columns && at < last * columns ? `entry-${key_of(entries[at]!)}` : undefined}
        aria-busy={status === 'loading'}
        onScroll={(e) => set_top(e.currentTarget.scrollTop)}
        onKeyDown={keys}
        onContextMenu={(e) => {
          const id = (e.target as HTMLElement).closest<HTMLElement>('[data-entry]')?.dataset.entry;
          const entry = entries.find((x) => key_of(x) === id);
          if (!entry) return;
          e.preventDefault();
          session.select({ kind: 'entry', entry: key_of(entry) });
          set_menu({ entry, x: e.clientX, y: e.clientY });
        }}
      >
        <div className="rows" style={{ height: rows * row }}>
          <div className="window" style={{ transform: `translateY(${first * row}px)`, gridTemplateColumns: `repeat(${columns}, minmax(0, 1fr))`, gridAutoRows: row }}>
            {shown.map((entry, i) => (
              <Card
                key={key_of(entry)}
                entry={entry}
                index={first * columns + i}
                total={total}
                grid={grid}
                selected={key_of(entry) === chosen}
                renaming={key_of(entry) === renaming}
                on_select={() => session.select({ kind: 'entry', entry: key_of(entry) })}
                on_renamed={(name) => {
                  set_renaming(null);
                  if (name !== null) void library.rename(entry, name);
                  list.current?.focus();
                }}
              />
            ))}
          </div>
        </div>
        {entries.length === 0 && <Empty import_files={import_files} />}
      </div>
      {menu && <EntryMenu menu={menu} rename={() => set_renaming(key_of(menu.entry))} close={() => set_menu(null)} />}
    </>
  );
}

function Empty({ import_files }: { import_files: () => void }): ReactElement | null {
  const status = useLibrary((s) => s.status);
  const failure = useLibrary((s) => s.failure);
  const away = useLibrary((s) => s.away);
  const query = useLibrary((s) => s.query);
  const tags = useLibrary((s) => s.tags);
  const kind = useLibrary((s) => s.kind);
  const trash = useLibrary((s) => s.trash);
  if (status === 'loading') return null;
  if (status === 'failed') {
    return (
      <div className="nothing" role="alert">
        <strong>{failure_title(away)}</strong>
        <p>{failure}</p>
        <button type="button" onClick={() => void library.load()}>Retry</button>
      </div>
    );
  }
  if (trash) {
    return (
      <div className="nothing">
        <strong>The trash is empty</strong>
        <button type="button" onClick={() => library.filter({ trash: false })}>Back to the library</button>
      </div>
    );
  }
  if (query.trim() || tags.length > 0 || kind !== 'all') {
    return (
      <div className="nothing">
        <strong>No matching entries</strong>
        <p>{[query.trim() && `“${query.trim()}”`, tags.length > 0 && `tagged ${tags.join(' and ')}`, kind !== 'all' && `only ${kind}s`].filter(Boolean).join(', ')}</p>
        <button type="button" onClick={() => { library.search(''); library.filter({ tags: [], kind: 'all' }); }}>Clear all filters</button>
      </div>
    );
  }
  return (
    <div className="nothing">
      <strong>The library is empty</strong>
      <p>Drop files here: recordings (BVH, AMC with its ASF, C3D, TRC, glTF) and mechanisms (URDF, SDF, MJCF). Each file is previewed next to a 1.8 m human before anything is stored.</p>
      <button type="button" onClick={import_files}>Import files…</button>
    </div>
  );
}

function EntryMenu({ menu, rename, close }: { menu: Menu; rename: () => void; close: () => void }): ReactElement {
  const trash = useLibrary((s) => s.trash);
  const element = useRef<HTMLUListElement>(null);
  useEffect(() => {
    (element.current?.querySelector('button:not(:disabled)') as HTMLElement | null)?.focus();
    const outside = (e: PointerEvent): void => {
      if (!element.current?.contains(e.target as Node)) close();
    };
    window.addEventListener('pointerdown', outside, true);
    return () => window.removeEventListener('pointerdown', outside, true);
  }, []);
  const actions = trash ? [{ label: 'Restore', run: () => void library.undelete(menu.entry), possible: true, key: undefined }] : entry_actions(menu.entry, rename);
  const back = (): void => {
    close();
    document.getElementById('library-list')?.focus();
  };
  return (
    <ul
      ref={element}
      className="menu entry-menu"
      role="menu"
      aria-label={menu.entry.name}
      style={{ left: Math.min(menu.x, window.innerWidth - 190), top: Math.min(menu.y, window.innerHeight - 36 * actions.length - 16) }}
      onKeyDown={(e) => {
        e.stopPropagation();
        const items = [...(element.current?.querySelectorAll<HTMLElement>('button:not(:disabled)') ?? [])];
        const now = items.indexOf(document.activeElement as HTMLElement);
        if (e.key === 'Escape') back();
        else if (e.key === 'ArrowDown') items[(now + 1) % items.length]?.focus();
        else if (e.key === 'ArrowUp') items[(now - 1 + items.length) % items.length]?.focus();
        else return;
        e.preventDefault();
      }}
    >
      {actions.map((action) => (
        <li key={action.label} role="none">
          <button
            type="button"
            role="menuitem"
            disabled={!action.possible}
            onClick={() => {
              back();
              action.run();
            }}
          >
            <span>{action.label}</span>
            {action.key && <kbd>{action.key}</kbd>}
          </button>
        </li>
      ))}
    </ul>
  );
}

/** Foot of the panel: the number of entries, the sort order and the trash; after an edit, its description and Undo. */
function Foot(): ReactElement {
  const count = useLibrary((s) => s.total);
  const exact = useLibrary((s) => s.total_exact);
  const status = useLibrary((s) => s.status);
  const done = useLibrary((s) => s.done);
  const trash = useLibrary((s) => s.trash);
  const order = useLibrary((s) => s.order);
  const query = useLibrary((s) => s.query);
  if (done) {
    return (
      <div className="library-foot done" role="status">
        <span className="what">{done.label}</span>
        <button type="button" className="quiet" title="Undo the last change of the library  (Ctrl Z in the list)" onClick={() => void library.undo()}>Undo</button>
        <button type="button" className="tool small" aria-label="Dismiss" onClick={() => library.forget_done()}>
          <Icon name="close" />
        </button>
      </div>
    );
  }
  return (
    <div className="library-foot">
      <span className="what" role="status">
        {status === 'ready' && (count === 1 ? '1 entry' : `${count.toLocaleString('en-US')}${exact ? '' : '+'} entries`)}
        {trash && ' in trash'}
      </span>
      <select aria-label="Sort order" title="Sort order" value={order ?? ''} onChange={(e) => library.filter({ order: (e.target.value || null) as LibraryOrder | null })}>
        <option value="">{query.trim() ? 'Best match' : 'By name'}</option>
        {orders.map(([value, name]) => (
          <option key={value} value={value}>{name}</option>
        ))}
      </select>
      <button type="button" className="quiet" title={trash ? 'Show the library' : 'Show deleted entries'} aria-pressed={trash} onClick={() => library.filter({ trash: !trash })}>
        {trash ? 'Back' : 'Trash'}
      </button>
    </div>
  );
}

function ConflictQuestion(): ReactElement | null {
  const conflict = useLibrary((s) => s.conflict);
  const first = useRef<HTMLButtonElement>(null);
  useEffect(() => first.current?.focus(), [conflict]);
  if (!conflict) return null;
  const { theirs, mine } = conflict;
  return (
    <div className="conflict" role="alertdialog" aria-label="Somebody else changed this entry" aria-describedby="conflict-words">
      <strong>Conflicting change</strong>
      <p id="conflict-words">
        {theirs.by || 'Somebody'} saved version {theirs.version} of “{theirs.name}” while you were changing it. Choose the newest version; the history keeps both.
      </p>
      <div className="actions">
        <button ref={first} type="button" onClick={() => library.answer_conflict(true)}>Save {mine} as newest</button>
        <button type="button" onClick={() => library.answer_conflict(false)}>Discard my change</button>
      </div>
    </div>
  );
}
