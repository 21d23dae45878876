import { useEffect, useMemo, useRef, useState, type DragEvent, type ReactElement } from 'react';
import { describe_entry, search_library } from '../core/library';
import type { LibraryEntry } from '../core/protocol';
import { mechanism_picture } from '../view/thumbnails';
import { add_character, append_motion } from './actions';
import { page, parts, session, usePage, useStudio } from './app';
import { Icon } from './icons';

export function LibraryPanel(): ReactElement {
  const entries = useStudio((s) => s.library);
  const state = useStudio((s) => s.library_state);
  const report = useStudio((s) => s.import_report);
  const [query, set_query] = useState('');
  const [file_over, set_file_over] = useState(false);
  const files = useRef<HTMLInputElement>(null);
  const found = useMemo(() => search_library(entries, query), [entries, query]);
  useEffect(() => {
    parts.choose_files = () => files.current?.click();
  }, []);

  const has_files = (event: DragEvent): boolean => event.dataTransfer.types.includes('Files');
  const sections: [string, LibraryEntry[]][] = [
    ['Mechanisms', found.filter((e) => e.kind === 'mechanism')],
    ['Motions', found.filter((e) => e.kind === 'motion')],
  ];
  return (
    <div
      className={file_over ? 'panel library file-over' : 'panel library'}
      onDragOver={(e) => {
        if (!has_files(e)) return;
        e.preventDefault();
        set_file_over(true);
      }}
      onDragLeave={() => set_file_over(false)}
      onDrop={(e) => {
        set_file_over(false);
        if (!has_files(e)) return;
        e.preventDefault();
        void session.import_files([...e.dataTransfer.files]);
      }}
    >
      <div className="library-head">
        <div className="search">
          <Icon name="search" />
          <input type="search" placeholder="Search the library" aria-label="Search the library" value={query} onChange={(e) => set_query(e.target.value)} onKeyDown={(e) => e.key === 'Escape' && set_query('')} />
        </div>
        <button type="button" className="tool" title="Import a BVH, ASF with AMC, or mechanism file  (Ctrl I)" aria-label="Import a file" onClick={() => files.current?.click()}>
          <Icon name="import" />
        </button>
        <input
          ref={files}
          type="file"
          hidden
          multiple
          accept=".bvh,.asf,.amc,.c3d,.trc,.glb,.gltf,.json,.urdf,.sdf,.xml"
          onChange={(e) => {
            void session.import_files([...(e.target.files ?? [])]);
            e.target.value = '';
          }}
        />
      </div>
      {report && (
        <div className="report" role="status">
          <div className="report-head">
            <strong>{report.file}</strong>
            <button type="button" className="tool small" aria-label="Close the report" onClick={() => session.set({ import_report: null })}>
              <Icon name="close" />
            </button>
          </div>
          {report.lines.map((line, i) => (
            <p key={i}>{line}</p>
          ))}
        </div>
      )}
      <div className="entries">
        {sections.map(([title, list]) =>
          list.length === 0 ? null : (
            <section key={title} aria-label={title}>
              <h4>{title}</h4>
              <ul>
                {list.map((entry) => (
                  <EntryRow key={entry.id} entry={entry} />
                ))}
              </ul>
            </section>
          ),
        )}
        {state === 'ready' && entries.length === 0 && <p className="hint">The library is empty. Drop a BVH file here, or press the import button.</p>}
        {state === 'ready' && entries.length > 0 && found.length === 0 && <p className="hint">Nothing in the library matches “{query}”.</p>}
        {state === 'failed' && (
          <p className="hint">
            The library could not be read. <button type="button" className="quiet" onClick={() => void session.load_library()}>Try again</button>
          </p>
        )}
      </div>
    </div>
  );
}

function EntryRow({ entry }: { entry: LibraryEntry }): ReactElement {
  const selected = useStudio((s) => s.selection.kind === 'entry' && s.selection.entry === entry.id);
  const in_use = useStudio((s) => entry.kind === 'mechanism' && (s.document?.characters.some((c) => c.mechanism === entry.id) ?? false));
  const use = (): void => {
    if (entry.kind === 'mechanism') return add_character(entry.id);
    const { selection, document } = session.state;
    const chosen = selection.kind === 'character' || selection.kind === 'clip' ? selection.character : undefined;
    const fits = document?.characters.filter((c) => !entry.mechanism || c.mechanism === entry.mechanism) ?? [];
    const target = fits.find((c) => c.id === chosen) ?? fits[0];
    if (target) append_motion(target.id, entry.id);
    else if (entry.mechanism) add_character(entry.mechanism, undefined, entry.id);
  };
  return (
    <li>
      <button
        type="button"
        className={selected ? 'entry selected' : 'entry'}
        draggable
        data-entry={entry.id}
        title={`${entry.name}${entry.summary ? `\n${entry.summary}` : ''}\nDrag it onto ${entry.kind === 'motion' ? 'a track or a figure' : 'the floor or the scenario'}, or double-click to add it`}
        onClick={() => session.select({ kind: 'entry', entry: entry.id })}
        onDoubleClick={use}
        onDragStart={(e) => {
          e.dataTransfer.setData('application/x-ugoki-entry', entry.id);
          e.dataTransfer.effectAllowed = 'copy';
          page.setState({ dragged_entry: entry.id });
        }}
        onDragEnd={() => page.setState({ dragged_entry: null })}
      >
        <span className="thumb">{entry.kind === 'mechanism' ? <MechanismThumb id={entry.id} /> : <MotionThumb entry={entry} />}</span>
        <span className="entry-text">
          <span className="entry-name">{entry.name}</span>
          <span className="entry-facts">{describe_entry(entry)}</span>
        </span>
        {in_use && <span className="in-use" title="In this scenario" aria-label="in this scenario" />}
      </button>
    </li>
  );
}

function MechanismThumb({ id }: { id: string }): ReactElement {
  const mechanism = useStudio((s) => s.mechanisms[id]);
  const color = useStudio((s) => s.document?.characters.find((c) => c.mechanism === id)?.color ?? '#c9ccd4');
  const dragging = usePage((s) => s.dragged_entry === id);
  const [picture, set_picture] = useState<string | null>(null);
  useEffect(() => {
    if (!mechanism) return;
    // after the first pictures of the viewport
    const timer = setTimeout(() => {
      try {
        set_picture(mechanism_picture(mechanism, color));
      } catch {
        set_picture(null); // no WebGL: the icon stands in
      }
    }, 300);
    return () => clearTimeout(timer);
  }, [mechanism, color]);
  return picture ? <img src={picture} alt="" draggable={false} style={{ opacity: dragging ? 0.5 : 1 }} /> : <Icon name="figure" />;
}

function MotionThumb({ entry }: { entry: LibraryEntry }): ReactElement {
  const curve = entry.curve;
  if (!curve || curve.length < 2) return <Icon name="wave" />;
  const points = curve.map((v, i) => `${(4 + (44 * i) / (curve.length - 1)).toFixed(1)},${(30 - 24 * Math.min(1, Math.max(0, v))).toFixed(1)}`).join(' ');
  return (
    <svg className="curve" viewBox="0 0 52 36" aria-hidden="true">
      <polyline points={points} />
    </svg>
  );
}
