/** Dialog in which the keys of all commands are changed: recorded, removed, reset, and written to or read from a file. */
import { useEffect, useRef, useState, type ReactElement } from 'react';
import type { AppCommand } from '../core/commands';
import { conflicts, count_edits, edited_keys, give_key, no_key_edits, parse_key_file, reserved, set_keys, write_key_edits, type KeyEdits } from '../core/key_edits';
import { key_of, show_key } from '../core/keymap';
import { download } from './actions';
import { registry, session, useStudio } from './app';
import { Backdrop } from './dialogs';
import { Icon } from './icons';

function store(edits: KeyEdits): void {
  session.set({ key_edits: edits });
  session.remember();
}

/** A key that was pressed for a command, and the reasons against it. */
interface Wish {
  command: AppCommand;
  key: string;
  /** Other commands that have the key. */
  taken: AppCommand[];
  /** Sentence why the key is not possible. */
  refused: string | null;
}

const is_fixed = (command: AppCommand): boolean => command.id === 'page.escape';

export function KeyEditor(): ReactElement {
  const keymap = useStudio((s) => s.keymap);
  const edits = useStudio((s) => s.key_edits);
  const [query, set_query] = useState('');
  const [changed_only, set_changed_only] = useState(false);
  const [recording, set_recording] = useState<AppCommand | null>(null);
  const [wish, set_wish] = useState<Wish | null>(null);
  const [report, set_report] = useState('');
  const file = useRef<HTMLInputElement>(null);
  const close = (): void => session.set({ dialog: 'none' });

  const take = (command: AppCommand, key: string): void => {
    const { key_edits } = session.state;
    const taken = conflicts(registry.all(), command, key, keymap, key_edits);
    const refused = reserved(key);
    if (refused || taken.length > 0) return set_wish({ command, key, taken, refused });
    set_wish(null);
    set_report(`${show_key(key)} now runs “${command.label}”.`);
    store(give_key(key_edits, registry.all(), command, key, keymap));
  };

  useEffect(() => {
    if (!recording) return;
    const down = (event: KeyboardEvent): void => {
      event.preventDefault();
      event.stopPropagation();
      if (['Control', 'Shift', 'Alt', 'Meta', 'AltGraph'].includes(event.key)) return; // wait for the key itself
      set_recording(null);
      if (event.key !== 'Escape') take(recording, key_of(event));
    };
    const leave = (): void => set_recording(null);
    window.addEventListener('keydown', down, true);
    window.addEventListener('pointerdown', leave, true);
    return () => {
      window.removeEventListener('keydown', down, true);
      window.removeEventListener('pointerdown', leave, true);
    };
  }, [recording, keymap]);

  const read = async (chosen: File | undefined): Promise<void> => {
    if (!chosen) return;
    try {
      const found = parse_key_file(await chosen.text(), (id) => registry.get(id) !== undefined);
      store(found.edits);
      set_report([`Read ${count_edits(found.edits, 'industry') + count_edits(found.edits, 'blender')} changed commands from ${chosen.name}.`, ...found.problems].join(' '));
    } catch (error) {
      set_report(`${chosen.name}: ${(error as Error).message}`);
    }
  };

  const found = registry.search(query).filter((c) => !is_fixed(c) && (!changed_only || edits[keymap][c.id] !== undefined));
  const groups = [...new Set(found.map((c) => c.group))];
  const changed = count_edits(edits, keymap);
  return (
    <Backdrop label="Change keys" top>
      <div className="key-editor">
        <div className="keys-head">
          <h2>Keys</h2>
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
          <button type="button" className="tool" aria-label="Close" title="Close  (Esc)" onClick={close}>
            <Icon name="close" />
          </button>
        </div>
        <div className="key-editor-tools">
          <input className="text" type="search" autoFocus aria-label="Search commands" placeholder="Search commands" value={query} onChange={(e) => set_query(e.target.value)} />
          <label className="key-editor-filter">
            <input type="checkbox" checked={changed_only} onChange={(e) => set_changed_only(e.target.checked)} /> Changed only
          </label>
          <span className="spacer" />
          <button type="button" className="quiet" title="Read keys from a file" onClick={() => file.current?.click()}>Import…</button>
          <button type="button" className="quiet" title="Save the changed keys of both keymaps to a file" onClick={() => download(new Blob([write_key_edits(edits)], { type: 'application/json' }), 'ugoki keys.json')}>Export</button>
          <button type="button" className="quiet" disabled={changed === 0} title={`Give all commands the keys of the keymap${changed > 0 ? ` (${changed} changed)` : ''}`} onClick={() => store({ ...edits, [keymap]: no_key_edits[keymap] })}>Reset all</button>
          <input
            ref={file}
            type="file"
            accept=".json,application/json"
            hidden
            aria-label="File with keys"
            onChange={(e) => {
              void read(e.target.files?.[0]);
              e.target.value = '';
            }}
          />
        </div>
        <div className="key-editor-list" tabIndex={0} role="region" aria-label="Commands and their keys">
          {groups.map((group) => (
            <section key={group} aria-label={group}>
              <h3>{group}</h3>
              <ul>
                {found.filter((c) => c.group === group).map((command) => (
                  <Row
                    key={command.id}
                    command={command}
                    keys={edited_keys(command, keymap, edits)}
                    changed={edits[keymap][command.id] !== undefined}
                    recording={recording === command}
                    wish={wish?.command === command ? wish : null}
                    record={() => {
                      set_wish(null);
                      set_recording(command);
                    }}
                    set={(keys) => store(set_keys(edits, keymap, command, keys))}
                    reset={() => store({ ...edits, [keymap]: Object.fromEntries(Object.entries(edits[keymap]).filter(([id]) => id !== command.id)) })}
                    accept={(accepted) => {
                      set_wish(null);
                      if (!accepted) return;
                      store(give_key(edits, registry.all(), accepted.command, accepted.key, keymap));
                      set_report(`${show_key(accepted.key)} now runs “${accepted.command.label}”.`);
                    }}
                  />
                ))}
              </ul>
            </section>
          ))}
          {found.length === 0 && <p className="facts">{changed_only && !query ? 'No key of this keymap is changed.' : `No command matches “${query}”.`}</p>}
        </div>
        <p className="key-editor-report" role="status">{report}</p>
      </div>
    </Backdrop>
  );
}

interface RowProps {
  command: AppCommand;
  keys: readonly string[];
  changed: boolean;
  recording: boolean;
  wish: Wish | null;
  record: () => void;
  set: (keys: string[]) => void;
  reset: () => void;
  /** @param wish the key to give to the command; null: leave everything as it is */
  accept: (wish: Wish | null) => void;
}

function Row({ command, keys, changed, recording, wish, record, set, reset, accept }: RowProps): ReactElement {
  return (
    <li className="key-editor-row" data-command={command.id} data-changed={changed}>
      <span className="key-editor-label">{command.label}</span>
      <span className="key-editor-keys">
        {keys.map((key) => (
          <span key={key} className="key-editor-key">
            <kbd>{show_key(key)}</kbd>
            <button type="button" aria-label={`Remove ${show_key(key)} from ${command.label}`} title="Remove this key" onClick={() => set(keys.filter((k) => k !== key))}>
              <Icon name="close" />
            </button>
          </span>
        ))}
        <button type="button" className="key-editor-add" data-recording={recording} aria-label={recording ? 'Press the new key; Escape keeps the keys as they are' : `Add a key to ${command.label}`} title="Click, then press the key" onClick={record}>
          {recording ? 'press a key' : '+ key'}
        </button>
        {changed && (
          <button type="button" className="key-editor-reset" aria-label={`Reset the keys of ${command.label}`} title="Give the command the keys of the keymap" onClick={reset}>Reset</button>
        )}
      </span>
      {wish && (
        <span className="key-editor-conflict" role="alert">
          {wish.refused ?? (
            <>
              <kbd>{show_key(wish.key)}</kbd> runs {wish.taken.map((c) => `“${c.label}”`).join(' and ')}.
            </>
          )}
          {!wish.refused && <button type="button" className="quiet" onClick={() => accept(wish)}>Take it over</button>}
          <button type="button" className="quiet" onClick={() => accept(null)}>{wish.refused ? 'Close' : 'Keep it there'}</button>
        </span>
      )}
    </li>
  );
}
