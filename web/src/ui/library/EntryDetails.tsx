/** Inspector of a library entry: actions, name, tags, note, properties and versions. */
import { useEffect, useState, type KeyboardEvent, type ReactElement } from 'react';
import type { EntryVersion } from '../../core/library/browser';
import { describe_entry, format_bytes, format_length, format_mass, format_when, key_of, split_tags, tags_of } from '../../core/library/words';
import { format_number } from '../../core/format';
import type { ScenarioDocument } from '../../core/document';
import type { LibraryEntry } from '../../core/protocol';
import { add_character, append_motion } from '../actions';
import { library, session, useLibrary } from '../app';
import { Icon } from '../icons';

export function EntryDetails({ entry, doc }: { entry: LibraryEntry; doc: ScenarioDocument }): ReactElement {
  const fits = entry.kind === 'motion' ? doc.characters.filter((c) => !entry.mechanism || c.mechanism === entry.mechanism) : [];
  const in_library = entry.entry !== undefined;
  const in_trash = Boolean(entry.removed);
  const body = entry.mechanism ? session.entry(entry.mechanism) : undefined;
  const rows: [string, string][] = [];
  const row = (label: string, value: string | false | undefined): void => void (value && rows.push([label, value]));
  row('Duration', entry.duration !== undefined && `${entry.duration.toFixed(2)} s`);
  row('Frames', entry.frames !== undefined && entry.kind === 'motion' && `${entry.frames}${entry.rate ? ` at ${format_number(entry.rate, 2)} Hz` : ''}`);
  row('Mechanism', entry.kind === 'motion' && body?.name);
  row('DOF', entry.dofs !== undefined && String(entry.dofs));
  row('Height', entry.height !== undefined && entry.height > 0 && format_length(entry.height));
  row('Mass', entry.mass !== undefined && format_mass(entry.mass));
  row('Source', entry.source);
  row('Size', format_bytes(entry.size));
  row('Saved by', [entry.by, format_when(entry.changed ?? entry.created)].filter(Boolean).join(', '));
  return (
    <>
      <h3>
        {entry.kind === 'motion' ? 'Motion' : 'Mechanism'} <span className="of">{entry.name}</span>
      </h3>
      <p className="facts">{describe_entry(entry)}</p>
      <div className="actions column first">
        {in_trash && <button type="button" onClick={() => void library.undelete(entry)}>Restore to the library</button>}
        {entry.kind === 'mechanism' && !in_trash && <button type="button" onClick={() => void add_character(entry.id)}>Add to the scenario</button>}
        {!in_trash && fits.map((c) => (
          <button key={c.id} type="button" onClick={() => append_motion(c.id, entry.id)}>Add to {c.name}’s track</button>
        ))}
        {entry.kind === 'motion' && entry.mechanism && !in_trash && (
          <button type="button" onClick={() => void add_character(entry.mechanism!, undefined, entry.id)}>Add a new character with this motion</button>
        )}
      </div>
      {in_library && !in_trash && <Name key={`${key_of(entry)} ${entry.name}`} entry={entry} />}
      <TagEditor entry={entry} />
      {in_library && !in_trash && <Note key={`${key_of(entry)} ${entry.note ?? ''}`} entry={entry} />}
      <h4>Properties</h4>
      {rows.map(([label, value]) => (
        <div key={label} className="field">
          <span>{label}</span>
          <output title={value}>{value}</output>
        </div>
      ))}
      {!in_library && <p className="hint">Only in the open project; not stored in the library.</p>}
      {in_library && <Versions entry={entry} />}
      {in_library && !in_trash && (
        <div className="actions">
          <button type="button" onClick={() => void library.duplicate(entry).then((made) => made && session.select({ kind: 'entry', entry: key_of(made) }))}>Duplicate</button>
          <button type="button" onClick={() => void library.remove(entry)}>Delete</button>
        </div>
      )}
    </>
  );
}

function Name({ entry }: { entry: LibraryEntry }): ReactElement {
  const [text, set_text] = useState(entry.name);
  return (
    <div className="field">
      <label htmlFor="entry-name">Name</label>
      <input
        id="entry-name"
        className="text"
        value={text}
        maxLength={200}
        onChange={(e) => set_text(e.target.value)}
        onKeyDown={(e) => {
          if (e.key === 'Enter') e.currentTarget.blur();
          if (e.key === 'Escape') {
            set_text(entry.name);
            e.stopPropagation();
          }
        }}
        onBlur={() => void library.rename(entry, text)}
      />
    </div>
  );
}

function Note({ entry }: { entry: LibraryEntry }): ReactElement {
  const [text, set_text] = useState(entry.note ?? '');
  return (
    <textarea
      className="entry-note"
      aria-label="Note"
      placeholder="Add a note"
      rows={text.includes('\n') || text.length > 40 ? 4 : 2}
      value={text}
      onChange={(e) => set_text(e.target.value)}
      onKeyDown={(e) => {
        if (e.key !== 'Escape') return;
        set_text(entry.note ?? '');
        e.stopPropagation();
      }}
      onBlur={() => void library.set_note(entry, text)}
    />
  );
}

/** Editor of an entry's tags. Enter or a comma adds the typed tag; Backspace in the empty field removes the last one. */
function TagEditor({ entry }: { entry: LibraryEntry }): ReactElement | null {
  const tags = tags_of(entry);
  const known = useLibrary((s) => s.all_tags);
  const [text, set_text] = useState('');
  const editable = entry.entry !== undefined && !entry.removed;
  if (!editable && tags.length === 0) return null;
  const add_typed = (): void => {
    const added = split_tags(text);
    set_text('');
    if (added.length > 0) void library.change_tags(entry, added, []);
  };
  const keys = (event: KeyboardEvent): void => {
    if (event.key === 'Enter' || event.key === ',') {
      add_typed();
      event.preventDefault();
    } else if (event.key === 'Escape') {
      set_text('');
      event.stopPropagation();
    } else if (event.key === 'Backspace' && text === '' && tags.length > 0) {
      void library.change_tags(entry, [], [tags[tags.length - 1]!]);
      event.preventDefault();
    }
  };
  return (
    <div className="tags" role="group" aria-label="Tags of this entry">
      {tags.map((tag) => (
        <span key={tag} className="tag">
          {tag}
          {editable && (
            <button type="button" className="tag-remove" aria-label={`Remove the tag ${tag}`} title={`Remove the tag ${tag}`} onClick={() => void library.change_tags(entry, [], [tag])}>
              <Icon name="close" />
            </button>
          )}
        </span>
      ))}
      {editable && (
        <>
          <input className="tag-add" aria-label="Add a tag" placeholder="Add a tag" list="known-tags" value={text} onChange={(e) => set_text(e.target.value)} onKeyDown={keys} onBlur={add_typed} />
          <datalist id="known-tags">
            {known.filter((t) => !tags.includes(t.name)).slice(0, 50).map((t) => (
              <option key={t.name} value={t.name} />
            ))}
          </datalist>
        </>
      )}
    </div>
  );
}

function Versions({ entry }: { entry: LibraryEntry }): ReactElement | null {
  const [versions, set_versions] = useState<EntryVersion[]>([]);
  useEffect(() => {
    let ended = false;
    library.versions(entry).then(
      (all) => !ended && set_versions(all),
      () => undefined, // on an error, the inspector shows no version list
    );
    return () => {
      ended = true;
    };
  }, [entry.entry, entry.version]);
  if (versions.length === 0) return null;
  return (
    <>
      <h4>Versions</h4>
      <ol className="versions" aria-label="Versions, newest first">
        {versions.map((v, i) => (
          <li key={v.version}>
            <span className="version-number">{v.version}</span>
            <span className="version-words">
              <span>{v.name}</span>
              <span className="entry-facts">{[v.by, format_when(v.when), v.note].filter(Boolean).join(' · ')}</span>
            </span>
            {i === 0 ? <span className="hint">current</span> : <button type="button" className="quiet" title="Save this version as the newest" onClick={() => void library.restore(entry, v.version)}>Restore</button>}
          </li>
        ))}
      </ol>
    </>
  );
}
