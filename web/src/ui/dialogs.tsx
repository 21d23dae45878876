/** Overlays of the page: command palette, keyboard shortcuts, save-as, toasts and banners. */
import { useEffect, useLayoutEffect, useRef, useState, type ReactElement } from 'react';
import { show_key } from '../core/keymap';
import { code_in } from '../core/access';
import { access, registry, session, useStudio } from './app';
import { CarryDialog } from './CarryDialog';
import { NewDialog, OpenDialog } from './files';
import { Icon } from './icons';
import { KeyEditor } from './KeyEditor';
import { SweepDialog } from './SweepDialog';

const close = (): void => session.set({ dialog: 'none' });

export function Dialogs(): ReactElement | null {
  const dialog = useStudio((s) => s.dialog);
  if (dialog === 'palette') return <Palette />;
  if (dialog === 'keys') return <Keys />;
  if (dialog === 'edit_keys') return <KeyEditor />;
  if (dialog === 'save_as') return <SaveAs />;
  if (dialog === 'open') return <OpenDialog />;
  if (dialog === 'new') return <NewDialog />;
  if (dialog === 'sweep') return <SweepDialog />;
  if (dialog === 'carry') return <CarryDialog />;
  return null;
}

export function Backdrop({ children, label, top, close: leave = close }: { children: ReactElement; label: string; top?: boolean; close?: () => void }): ReactElement {
  const before = useRef<Element | null>(null);
  useEffect(() => {
    before.current = document.activeElement;
    return () => (before.current as HTMLElement | null)?.focus?.();
  }, []);
  return (
    <div
      className={top ? 'backdrop top' : 'backdrop'}
      onPointerDown={(e) => e.target === e.currentTarget && leave()}
      onKeyDown={(e) => {
        if (e.key !== 'Escape') return;
        e.preventDefault(); // so that the page's own key handler ignores this Escape
        e.stopPropagation();
        leave();
      }}
    >
      <div className="dialog" role="dialog" aria-modal="true" aria-label={label}>
        {children}
      </div>
    </div>
  );
}

function Palette(): ReactElement {
  const [query, set_query] = useState('');
  const [chosen, set_chosen] = useState(0);
  const keymap = useStudio((s) => s.keymap);
  const list = useRef<HTMLUListElement>(null);
  const found = registry.search(query).filter((c) => c.id !== 'page.palette' && c.id !== 'page.escape');
  const at = Math.min(chosen, Math.max(0, found.length - 1));
  useEffect(() => {
    list.current?.children[at]?.scrollIntoView({ block: 'nearest' });
  }, [at, query]);
  const start = (index: number): void => {
    const command = found[index];
    if (!command || command.enabled?.() === false) return;
    close();
    command.run();
  };
  return (
    <Backdrop label="All commands" top>
      <div className="palette">
        <input
          autoFocus
          type="text"
          role="combobox"
          aria-expanded="true"
          aria-controls="palette-list"
          aria-activedescendant={found[at] ? `command-${found[at].id}` : undefined}
          aria-label="Search commands"
          placeholder="Search commands"
          value={query}
          onChange={(e) => {
            set_query(e.target.value);
            set_chosen(0);
          }}
          onKeyDown={(e) => {
            if (e.key === 'ArrowDown') set_chosen(Math.min(at + 1, found.length - 1));
            else if (e.key === 'ArrowUp') set_chosen(Math.max(at - 1, 0));
            else if (e.key === 'Enter') start(at);
            else if (e.key === 'Escape') close();
            else return;
            e.preventDefault();
            e.stopPropagation();
          }}
        />
        <ul ref={list} id="palette-list" role="listbox" aria-label="Commands">
          {found.map((command, i) => (
            <li
              key={command.id}
              id={`command-${command.id}`}
              role="option"
              aria-selected={i === at}
              aria-disabled={command.enabled?.() === false}
              onPointerMove={() => set_chosen(i)}
              onClick={() => start(i)}
            >
              <span className="command-group">{command.group}</span>
              <span className="command-label">{command.label}</span>
              {registry.keys_of(command, keymap).slice(0, 2).map((key) => (
                <kbd key={key}>{show_key(key)}</kbd>
              ))}
            </li>
          ))}
          {found.length === 0 && <li className="none">No command matches “{query}”.</li>}
        </ul>
      </div>
    </Backdrop>
  );
}

const mouse: Record<'industry' | 'blender', [string, string][]> = {
  industry: [
    ['Orbit', 'drag the empty floor, or Alt + left drag'],
    ['Pan', 'middle or right drag, or Shift + left drag'],
    ['Zoom', 'wheel, or Alt + right drag'],
  ],
  blender: [
    ['Orbit', 'middle drag'],
    ['Pan', 'Shift + middle drag'],
    ['Zoom', 'wheel, or Ctrl + middle drag'],
  ],
};
const mouse_both: [string, string][] = [
  ['Pull a character', 'drag it while simulating'],
  ['Place a character', 'select it and drag it, in Edit'],
  ['Move a clip', 'drag it, also onto another track'],
  ['Trim a clip', 'drag its edge; Alt stretches it'],
  ['Slip the motion in a clip', 'Alt + drag the clip'],
  ['Mirror, blend, turn …', 'right-click a clip'],
  ['Select several clips and events', 'Shift or Ctrl + click, or drag a rectangle'],
  ['Move a marker, in or out', 'drag it in the ruler'],
  ['Fine steps · no snapping', 'Shift · Ctrl while dragging'],
  ['Timeline', 'wheel zooms, Shift + wheel pans'],
];

function Keys(): ReactElement {
  const keymap = useStudio((s) => s.keymap);
  useStudio((s) => s.key_edits);
  const groups = [...new Set(registry.all().map((c) => c.group))];
  return (
    <Backdrop label="Keyboard and mouse">
      <div className="keys">
        <div className="keys-head">
          <h2>Keyboard and mouse</h2>
          <div className="segmented" role="radiogroup" aria-label="Keymap">
            {(['industry', 'blender'] as const).map((name) => (
              <button
                key={name}
                type="button"
                role="radio"
                aria-checked={keymap === name}
                onClick={() => {
                  session.set({ keymap: name });
                  session.remember();
                }}
              >
                {name === 'industry' ? 'Industry' : 'Blender-like'}
              </button>
            ))}
          </div>
          <button type="button" className="quiet" onClick={() => registry.run('page.edit_keys')}>Change keys…</button>
          <button type="button" className="quiet" onClick={() => registry.run('page.tour')}>Take the tour</button>
          <button type="button" className="tool" aria-label="Close" title="Close  (Esc)" autoFocus onClick={close}>
            <Icon name="close" />
          </button>
        </div>
        <div className="keys-columns">
          <section>
            <h3>Mouse</h3>
            {[...mouse[keymap], ...mouse_both].map(([action, gesture]) => (
              <div key={action} className="key-row">
                <span>{action}</span>
                <span className="how">{gesture}</span>
              </div>
            ))}
          </section>
          {groups.map((group) => {
            const rows = registry.all().filter((c) => c.group === group && registry.keys_of(c, keymap).length > 0);
            return rows.length === 0 ? null : (
              <section key={group}>
                <h3>{group}</h3>
                {rows.map((command) => (
                  <div key={command.id} className="key-row">
                    <span>{command.label}</span>
                    <span>
                      {registry.keys_of(command, keymap).slice(0, 2).map((key) => (
                        <kbd key={key}>{show_key(key)}</kbd>
                      ))}
                    </span>
                  </div>
                ))}
              </section>
            );
          })}
        </div>
      </div>
    </Backdrop>
  );
}

function SaveAs(): ReactElement {
  const path = useStudio((s) => s.project?.path ?? '');
  const [text, set_text] = useState(path);
  /** Path of an existing file that saving would replace; null again when the path is edited. */
  const [existing, set_existing] = useState<string | null>(null);
  const save = async (): Promise<void> => {
    const name = text.trim();
    if (!name) return;
    const to = /\.ugoki$/.test(name) ? name : `${name}.ugoki`;
    // saving over the open project's own file needs no confirmation
    const outcome = await session.save_as(to, to === existing || to === path);
    if (outcome === 'saved') close();
    if (outcome === 'exists') set_existing(to);
  };
  return (
    <Backdrop label="Save as" top>
      <form
        className="save-as"
        onSubmit={(e) => {
          e.preventDefault();
          void save();
        }}
      >
        <label htmlFor="save-path">Save the project as</label>
        <input
          id="save-path"
          autoFocus
          value={text}
          placeholder="folder/name.ugoki"
          spellCheck={false}
          aria-describedby={existing ? 'save-taken' : undefined}
          onFocus={(e) => e.target.select()}
          onChange={(e) => {
            set_text(e.target.value);
            set_existing(null);
          }}
        />
        {existing && (
          <p id="save-taken" className="taken" role="alert">
            <strong>{existing.split('/').pop()}</strong> already exists. Replacing it deletes its contents.
          </p>
        )}
        <div className="actions">
          <button type="button" onClick={close}>Cancel</button>
          <button type="submit" className="primary" disabled={!text.trim()}>{existing ? 'Replace' : 'Save'}</button>
        </div>
      </form>
    </Backdrop>
  );
}

export function Toasts(): ReactElement {
  const toasts = useStudio((s) => s.toasts);
  const region = useRef<HTMLDivElement>(null);
  // messages appear over the viewport, where they hide no controls, or at the lower right of the page if the viewport is not visible
  useLayoutEffect(() => {
    const viewport = document.querySelector('.viewport');
    const element = region.current;
    if (!viewport || !element || toasts.length === 0) return;
    const place = (): void => {
      const box = viewport.getBoundingClientRect();
      const visible = box.width > 200 && box.height > 120;
      element.style.left = visible ? `${box.left}px` : '';
      element.style.right = visible ? 'auto' : '';
      element.style.bottom = visible ? `${window.innerHeight - box.bottom}px` : '';
      element.style.maxWidth = visible ? `${box.width}px` : '';
    };
    place();
    const observer = new ResizeObserver(place);
    observer.observe(viewport);
    return () => observer.disconnect();
  }, [toasts.length > 0]);
  return (
    <div ref={region} className="toasts" role="region" aria-label="Messages">
      {toasts.map((toast) => (
        <div key={toast.id} className={`toast ${toast.level}`} role={toast.level === 'error' ? 'alert' : 'status'}>
          <div>
            {toast.problems.slice(0, 4).map((problem, i) => (
              <div key={i} className="problem">
                {problem.location && <code>{problem.location}</code>}
                <p>{problem.message}</p>
                {problem.remedy && <p className="remedy">{problem.remedy}</p>}
              </div>
            ))}
            {toast.problems.length > 4 && <p className="remedy">and {toast.problems.length - 4} more, listed in the log</p>}
          </div>
          <button type="button" className="tool small" aria-label="Dismiss" title="Dismiss the message" onClick={() => session.dismiss(toast.id)}>
            <Icon name="close" />
          </button>
        </div>
      ))}
    </div>
  );
}

/** Banner that asks for the newly printed address after the studio was restarted with another key. The page keeps its state. */
function EnterAddress(): ReactElement {
  const [text, set_text] = useState('');
  const [wrong, set_wrong] = useState(false);
  const enter = async (): Promise<void> => {
    const entry = await access.enter_code(code_in(text));
    if (entry === 'open') session.retry();
    else set_wrong(true);
  };
  return (
    <form
      className="banner"
      role="alert"
      onSubmit={(e) => {
        e.preventDefault();
        void enter();
      }}
    >
      <span>
        {wrong ? 'The studio does not accept this address.' : 'The studio was restarted and no longer accepts this page. It keeps your project.'} Paste the address that <code>ugoki studio</code> printed last:
      </span>
      <input className="address" aria-label="Address that ugoki studio printed last" value={text} spellCheck={false} autoFocus onChange={(e) => set_text(e.target.value)} />
      <button type="submit" disabled={!text.trim()}>Connect</button>
    </form>
  );
}

export function Banners(): ReactElement | null {
  const connection = useStudio((s) => s.connection);
  const stopped = useStudio((s) => s.stopped);
  const retry_at = useStudio((s) => s.retry_at);
  const [seconds, set_seconds] = useState(0);
  useEffect(() => {
    if (connection !== 'lost') return;
    const tick = (): void => set_seconds(Math.max(0, Math.ceil((retry_at - Date.now()) / 1000)));
    tick();
    const timer = setInterval(tick, 250);
    return () => clearInterval(timer);
  }, [connection, retry_at]);
  if (connection === 'refused') return <EnterAddress />;
  if (connection === 'lost') {
    return (
      <div className="banner" role="alert">
        <span>
          The connection to the studio is lost. The studio keeps your project. {seconds > 0 ? `Next attempt in ${seconds} s.` : 'Connecting…'} If the studio has stopped, restart it with <code>ugoki studio</code>.
        </span>
        <button type="button" title="Connect to the studio now" onClick={() => session.retry()}>Retry now</button>
      </div>
    );
  }
  if (stopped) {
    return (
      <div className="banner" role="alert">
        <span>The simulation stopped: {stopped}</span>
        <button type="button" title="Move the playhead to the start" onClick={() => session.seek(0)}>Go to start</button>
        <button type="button" className="quiet" onClick={() => session.set({ stopped: null })}>Dismiss</button>
      </div>
    );
  }
  return null;
}
