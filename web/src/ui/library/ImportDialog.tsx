/**
 * The import dialog: before files are stored, it shows the character of each file moving next to a 1.8 m human, lets the user correct
 * unit, axes and frame rate, and lists the reader's report.
 */
import { useEffect, useRef, useState, type ReactElement } from 'react';
import { format_number } from '../../core/format';
import { mapping_of, unpack_floats, type Anatomy, type AnatomyLimb, type ImportItem, type ImportSettings, type StagedFile } from '../../core/library/imports';
import { format_bytes, format_length } from '../../core/library/words';
import type { MechanismData } from '../../core/protocol';
import { ImportView, type Markers } from '../../view/import_view';
import { imports, parts, service_fetch, useImports, useStudio } from '../app';
import { Icon } from '../icons';
import { NumberField, SwitchField } from '../NumberField';
import { poses_of } from './pictures';

export function ImportDialog(): ReactElement | null {
  const open = useImports((s) => s.open);
  return open ? <Dialog /> : null;
}

function Dialog(): ReactElement {
  const items = useImports((s) => s.items);
  const shown = useImports((s) => s.shown);
  const item = items.find((i) => i.id === shown) ?? items[0];
  const dialog = useRef<HTMLDivElement>(null);
  const before = useRef<Element | null>(document.activeElement);
  useEffect(() => {
    dialog.current?.focus();
    return () => (before.current as HTMLElement | null)?.focus?.();
  }, []);
  const busy = items.filter((i) => i.status === 'waiting' || i.status === 'reading' || i.status === 'storing').length;
  const ready = items.filter((i) => i.status === 'ready').length;
  const finished = items.length - busy;
  return (
    <div
      className="backdrop import-backdrop"
      onKeyDown={(e) => {
        if (e.key === 'Escape') {
          e.preventDefault();
          imports.close();
        }
        // while the dialog is open, the page's own key handler must not see any key
        e.stopPropagation();
        if (e.key === 'Tab') keep_inside(e.nativeEvent, dialog.current);
      }}
    >
      <div ref={dialog} className="dialog import" role="dialog" aria-modal="true" aria-label="Import" tabIndex={-1}>
        <div className="import-head">
          <h2>Import</h2>
          {items.length > 1 && (
            <div className="import-progress" role="progressbar" aria-label="Files read" aria-valuemin={0} aria-valuemax={items.length} aria-valuenow={finished}>
              <div className="bar"><div style={{ transform: `scaleX(${items.length > 0 ? finished / items.length : 0})` }} /></div>
              <span>{finished} of {items.length} read</span>
            </div>
          )}
          <button type="button" className="tool" aria-label="Close without storing" title="Close without storing  (Esc)" onClick={() => imports.close()}>
            <Icon name="close" />
          </button>
        </div>
        <div className={items.length > 1 ? 'import-body with-list' : 'import-body'}>
          {items.length > 1 && <FileList items={items} shown={item?.id ?? null} />}
          {item && <FileView key={item.id} item={item} />}
        </div>
        <footer>
          <button type="button" onClick={() => imports.close()}>{items.some((i) => i.status === 'stored') ? 'Close' : 'Cancel'}</button>
          {items.length > 1 && (
            <button type="button" title="Store all files that were read without errors" disabled={ready === 0 || busy > 0} onClick={() => void imports.store_all()}>
              {`Store all ${ready}`}
            </button>
          )}
          <button
            type="button"
            className="primary"
            disabled={item?.status !== 'ready' || item.rereading}
            onClick={() => {
              if (!item) return;
              void imports.store_one(item.id).then(() => {
                const left = imports.state.items.filter((i) => i.status !== 'stored');
                if (left.length === 0) imports.close();
                else if (left[0]) imports.show((left.find((i) => i.status === 'ready') ?? left[0]).id);
              });
            }}
          >
            {item?.status === 'storing' ? 'Storing…' : item?.prop_at && item.staged?.mesh ? 'Add as a prop' : 'Store in the library'}
          </button>
        </footer>
      </div>
    </div>
  );
}

/** Keeps the focus in the dialog: Tab on the last element moves to the first, Shift Tab on the first to the last. */
function keep_inside(event: globalThis.KeyboardEvent, dialog: HTMLElement | null): void {
  const stops = [...(dialog?.querySelectorAll<HTMLElement>('button:not(:disabled), input, select, [tabindex="0"]') ?? [])].filter((e) => e.offsetParent !== null);
  const first = stops[0];
  const last = stops[stops.length - 1];
  if (!first || !last) return;
  if (event.shiftKey && (document.activeElement === first || document.activeElement === dialog)) {
    last.focus();
    event.preventDefault();
  } else if (!event.shiftKey && document.activeElement === last) {
    first.focus();
    event.preventDefault();
  }
}

const status_words: Record<ImportItem['status'], string> = {
  waiting: 'waiting', reading: 'reading…', ready: 'ready', storing: 'storing…', stored: 'stored', refused: 'refused', cancelled: 'skipped',
};

function FileList({ items, shown }: { items: ImportItem[]; shown: number | null }): ReactElement {
  return (
    <ul className="import-files" aria-label="Files">
      {items.map((item) => {
        const warns = item.status === 'ready' && (item.staged?.report.check.length ?? 0) > 0;
        return (
          <li key={item.id} className={item.id === shown ? 'chosen' : ''} data-status={item.status}>
            <button type="button" className="import-file" aria-pressed={item.id === shown} onClick={() => imports.show(item.id)}>
              <span className="file-name">{item.file}</span>
              <span className="file-status" data-grade={item.status === 'refused' ? 'bad' : warns ? 'fair' : item.status === 'stored' ? 'good' : undefined}>
                {warns ? 'check' : status_words[item.status]}
              </span>
            </button>
            {item.status !== 'stored' && (
              <button type="button" className="tool small" aria-label={`Skip ${item.file}`} title="Do not import this file" onClick={() => imports.cancel(item.id)}>
                <Icon name="close" />
              </button>
            )}
          </li>
        );
      })}
    </ul>
  );
}

function FileView({ item }: { item: ImportItem }): ReactElement {
  const { staged } = item;
  const [limb, set_limb] = useState<string | null>(null);
  if (item.status === 'refused') {
    return (
      <div className="import-refused" role="alert">
        <strong>{item.file} was not imported</strong>
        {item.problems.map((p, i) => (
          <div key={i} className="problem">
            {p.location && <code>{p.location}</code>}
            <p>{p.message}</p>
            {p.remedy && <p className="remedy">{p.remedy}</p>}
          </div>
        ))}
        <p className="hint">Nothing from this file was stored.</p>
      </div>
    );
  }
  if (!staged) {
    return (
      <div className="import-waiting" role="status">
        <strong>{item.file}</strong>
        <p>{item.status === 'reading' ? `Reading ${format_bytes(item.size)}…` : 'Waiting for the previous files.'}</p>
        <button type="button" onClick={() => imports.cancel(item.id)}>Cancel</button>
      </div>
    );
  }
  return (
    <>
      <Preview staged={staged} busy={item.rereading} chosen={limb} choose={set_limb} />
      <div className="import-side">
        <div className="import-title">
          <h3>{item.file}</h3>
          <span className="facts">{staged.format} · {format_bytes(item.size)}</span>
        </div>
        {item.status === 'stored' && <p className="stored-note" role="status">Stored as {item.stored.map((e) => `${e.kind} “${e.name}”`).join(' and ')}.</p>}
        {staged.report.check.length > 0 && item.status !== 'stored' && (
          <div className="import-check" role="note">
            {staged.report.check.map((line) => (
              <p key={line}>{line}</p>
            ))}
          </div>
        )}
        {item.problems.length > 0 && (
          <div className="import-check bad" role="alert">
            {item.problems.map((p, i) => (
              <p key={i}>{[p.message, p.remedy].filter(Boolean).join(' ')}</p>
            ))}
          </div>
        )}
        {item.status !== 'stored' && <Corrections item={item} staged={staged} />}
        {staged.anatomy && item.status !== 'stored' && (
          <AnatomyPanel item={item} staged={staged} anatomy={staged.anatomy} chosen={limb} choose={set_limb} />
        )}
        <Report staged={staged} />
      </div>
    </>
  );
}

const units: [number, string][] = [[1, 'metres'], [0.1, 'decimetres'], [0.01, 'centimetres'], [0.001, 'millimetres'], [0.0254, 'inches'], [0.3048, 'feet']];
const axes: [string, string][] = [['x', 'X'], ['-x', '−X'], ['y', 'Y'], ['-y', '−Y'], ['z', 'Z'], ['-z', '−Z']];

function Corrections({ item, staged }: { item: ImportItem; staged: StagedFile }): ReactElement {
  const { settings, can } = staged;
  const [read] = useState<ImportSettings>(settings); // settings when the dialog showed the file first, for the reset button
  const correct = (part: Partial<ImportSettings>): void => void imports.correct(item.id, part);
  const named = units.find(([metres]) => Math.abs(metres - settings.unit) < 1e-6 * metres);
  const choose_axis = (part: 'up' | 'forward', value: string): void => {
    const other = part === 'up' ? settings.forward : settings.up;
    if (value.replace('-', '') !== other.replace('-', '')) return correct({ [part]: value });
    // up and forward need different axes: if the chosen axis belongs to the other direction, swap the two axes
    correct(part === 'up' ? { up: value, forward: settings.up } : { forward: value, up: settings.forward });
  };
  const changed = settings.unit !== read.unit || settings.up !== read.up || settings.forward !== read.forward || settings.rate !== read.rate;
  return (
    <section className="import-settings" aria-label="Import settings">
      <div className="field">
        <label htmlFor={`name-${item.id}`}>Name</label>
        <input id={`name-${item.id}`} className="text" value={item.name} placeholder={staged.entries[0]?.name ?? ''} maxLength={200} onChange={(e) => imports.name(item.id, { name: e.target.value })} />
      </div>
      <div className="field">
        <label htmlFor={`tags-${item.id}`}>Tags</label>
        <input id={`tags-${item.id}`} className="text" value={item.tags} placeholder="walk, slow" onChange={(e) => imports.name(item.id, { tags: e.target.value })} />
      </div>
      {can.unit && (
        <div className="field">
          <label htmlFor={`unit-${item.id}`}>
            Unit{settings.unit_guessed && <span className="guessed">guessed</span>}
          </label>
          <select id={`unit-${item.id}`} aria-label="Unit of length" title="Unit of length in the file" value={named ? String(named[0]) : 'other'} onChange={(e) => e.target.value !== 'other' && correct({ unit: Number(e.target.value) })}>
            {units.map(([metres, name]) => (
              <option key={name} value={String(metres)}>{name}</option>
            ))}
            {!named && <option value="other">{`${format_number(1000 * settings.unit, 4)} mm`}</option>}
          </select>
        </div>
      )}
      {can.unit && <NumberField label="Scale" unit="m/unit" value={settings.unit} digits={6} step={0.001} min={1e-6} max={1000} title="Metres per unit of length in the file" on_commit={(unit) => correct({ unit })} />}
      {can.axes && (
        <>
          <div className="field">
            <label htmlFor={`up-${item.id}`}>Up axis</label>
            <select id={`up-${item.id}`} title="Axis of the file that points up" value={settings.up} onChange={(e) => choose_axis('up', e.target.value)}>
              {axes.map(([value, name]) => (
                <option key={value} value={value}>{name}</option>
              ))}
            </select>
          </div>
          <div className="field">
            <label htmlFor={`forward-${item.id}`}>Forward axis</label>
            <select id={`forward-${item.id}`} title={staged.mesh ? 'Axis of the file that becomes the front of the prop' : 'Axis of the file along which the character looks'} value={settings.forward} onChange={(e) => choose_axis('forward', e.target.value)}>
              {axes.map(([value, name]) => (
                <option key={value} value={value}>{name}</option>
              ))}
            </select>
          </div>
        </>
      )}
      {can.rate && <NumberField label={settings.rate_specified ? 'Frame rate' : 'Frame rate (not in the file)'} unit="1/s" value={settings.rate} digits={3} step={1} min={1} max={10000} on_commit={(rate) => correct({ rate })} />}
      {can.travel && <SwitchField label="Add travel" value={settings.travel ?? false} title="The character walks in place. Move it over the floor as its steps require" on_commit={(travel) => correct({ travel })} />}
      {changed && (
        <button type="button" className="quiet" onClick={() => correct(read)}>
          Reset to the settings as read
        </button>
      )}
      {!can.unit && <p className="hint">Mechanism formats use metres.</p>}
    </section>
  );
}

/** Colours of the limbs on the character, in the list and in the legend. Left is blue, right is red, as on ships' charts of anatomy. */
const limb_colors: Record<string, string> = {
  'left leg': '#4aa3df', 'left arm': '#7dcaf5', 'right leg': '#e06c6c', 'right arm': '#f4a3a3', head: '#b39bf0', tail: '#c9a26b', trunk: '#7fd1ae',
};
const unsure_color = '#f2c744';
const sure = 0.8; // the service reports limbs below this confidence as uncertain

const color_of = (limb: AnatomyLimb): string => (limb.confidence < sure ? unsure_color : (limb_colors[limb.limb] ?? '#9aa1ad'));

/** Colour of each link: that of its limb, or the trunk's. The other links are darker while a limb is chosen. */
function link_colors(anatomy: Anatomy | undefined, links: number, chosen: string | null): (string | null)[] {
  const colors: (string | null)[] = Array.from({ length: links }, () => null);
  if (!anatomy || anatomy.limbs.length === 0) return colors;
  colors.fill(chosen ? '#3c434d' : limb_colors.trunk!);
  for (const limb of anatomy.limbs)
    for (const link of limb.links) if (!chosen || chosen === limb.limb) colors[link] = color_of(limb);
  return colors;
}

const plans: [Anatomy['plan'], string][] = [['human', 'Human'], ['four legs', 'Four-legged animal'], ['other', 'Other']];

/** Takes and characters of the file, and the recognised limbs with their confidence. Each guess can be changed. */
function AnatomyPanel({ item, staged, anatomy, chosen, choose }: {
  item: ImportItem; staged: StagedFile; anatomy: Anatomy; chosen: string | null; choose: (limb: string | null) => void;
}): ReactElement {
  const correct = (mapping: string): void => void imports.correct(item.id, { mapping });
  const open_mapping = (file: File | undefined): void => void file?.text().then(correct);
  const save_mapping = (): void => {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(new Blob([mapping_of(anatomy) + '\n'], { type: 'application/json' }));
    link.download = `${staged.file.replace(/\.[^.]*$/, '')}.mapping.json`;
    link.click();
    URL.revokeObjectURL(link.href);
  };
  return (
    <section className="import-anatomy" aria-label="Anatomy">
      {(staged.characters?.length ?? 0) > 1 && (
        <div className="field">
          <label htmlFor={`character-${item.id}`}>Character</label>
          <select id={`character-${item.id}`} value={staged.settings.character ?? ''} onChange={(e) => void imports.correct(item.id, { character: e.target.value, mapping: '' })}>
            <option value="">as recognised</option>
            {staged.characters!.map((name, k) => <option key={name} value={String(k + 1)}>{name}</option>)}
          </select>
        </div>
      )}
      {(staged.takes?.length ?? 0) > 1 && (
        <div className="field">
          <label htmlFor={`take-${item.id}`}>Take</label>
          <select id={`take-${item.id}`} value={staged.settings.take ?? ''} onChange={(e) => void imports.correct(item.id, { take: e.target.value })}>
            <option value="">all {staged.takes!.length}</option>
            {staged.takes!.map((name, k) => <option key={k} value={String(k + 1)}>{name}</option>)}
          </select>
        </div>
      )}
      <h4>Anatomy, {anatomy.joints.length} joints</h4>
      <div className="field">
        <label htmlFor={`plan-${item.id}`}>Body plan</label>
        <select id={`plan-${item.id}`} value={anatomy.plan} onChange={(e) => correct(mapping_of(anatomy, { plan: e.target.value as Anatomy['plan'] }))}>
          {plans.map(([value, name]) => <option key={value} value={value}>{name}</option>)}
        </select>
        <Confidence value={anatomy.confidence} />
      </div>
      <ul className="limbs">
        {anatomy.limbs.map((limb) => (
          <li key={limb.limb} className={chosen === limb.limb ? 'chosen' : ''} data-unsure={limb.confidence < sure || undefined}>
            <button type="button" className="quiet limb" aria-expanded={chosen === limb.limb} title={limb.evidence} onClick={() => choose(chosen === limb.limb ? null : limb.limb)}>
              <i className="swatch" style={{ background: color_of(limb) }} />
              <span className="limb-name">{limb.limb}</span>
              <span className="limb-joints">{limb.sections.map((s) => s.joint).filter(Boolean).join(', ')}</span>
              <Confidence value={limb.confidence} />
            </button>
            {chosen === limb.limb && (
              <div className="limb-sections">
                <p className="hint">{limb.evidence}</p>
                {limb.sections.map((s) => (
                  <div key={s.section} className="field">
                    <label htmlFor={`${item.id}-${limb.limb}-${s.section}`}>{s.section}</label>
                    <select
                      id={`${item.id}-${limb.limb}-${s.section}`}
                      aria-label={`Joint of ${limb.limb}, ${s.section}`}
                      value={s.joint}
                      onChange={(e) => correct(mapping_of(anatomy, { limb: limb.limb, section: s.section, joint: e.target.value }))}
                    >
                      <option value="">none</option>
                      {anatomy.joints.map((name) => <option key={name} value={name}>{name}</option>)}
                    </select>
                  </div>
                ))}
              </div>
            )}
          </li>
        ))}
      </ul>
      {anatomy.limbs.length === 0 && <p className="hint">No limbs were recognised. The body is made of capsules along the bones.</p>}
      <div className="mapping-buttons">
        {staged.settings.mapping && <button type="button" className="quiet" onClick={() => correct('')}>As recognised</button>}
        <button type="button" className="quiet" title="Save the anatomy as a file that corrects other files with the same joints" onClick={save_mapping}>Save the mapping</button>
        <label className="quiet">
          Use a mapping…
          <input type="file" accept=".json,application/json" className="hidden-file" onChange={(e) => open_mapping(e.target.files?.[0])} />
        </label>
      </div>
    </section>
  );
}

/** A bar and the confidence in per cent. */
function Confidence({ value }: { value: number }): ReactElement {
  const percent = Math.round(100 * value);
  return (
    <span className="confidence" data-unsure={value < sure || undefined} aria-label={`confidence ${percent} %`}>
      <i><b style={{ width: `${percent}%` }} /></i>{percent} %
    </span>
  );
}

const report_sections: [keyof StagedFile['report'], string][] = [
  ['read', 'Read'],
  ['guessed', 'Guessed'],
  ['changed', 'Changed'],
  ['left_out', 'Left out'],
];

function Report({ staged }: { staged: StagedFile }): ReactElement {
  return (
    <section className="import-report" aria-label="Report">
      {report_sections.map(([part, title]) =>
        staged.report[part].length === 0 ? null : (
          <div key={part}>
            <h4>{title}</h4>
            <ul>
              {staged.report[part].map((line) => (
                <li key={line}>{line}</li>
              ))}
            </ul>
          </div>
        ),
      )}
      <p className="hint">
        Will be stored: {staged.entries.map((e) => `${e.kind} “${e.name}”`).join(' and ')}.
      </p>
    </section>
  );
}

let reference: Promise<MechanismData> | null = null;
const reference_character = (): Promise<MechanismData> => {
  reference ??= service_fetch('api/reference-character?height=1.8').then((r) => r.json() as Promise<MechanismData>);
  reference.catch(() => (reference = null));
  return reference;
};

function markers_of(staged: StagedFile): Markers | undefined {
  const m = staged.markers;
  return m && { count: m.count, markers: m.labels.length, values: unpack_floats(m.points), ...(m.pose ? { pose: m.pose } : {}) };
}

/** The imported character, moving on a 1 m grid next to a 1.8 m human. */
function Preview({ staged, busy, chosen, choose }: { staged: StagedFile; busy: boolean; chosen: string | null; choose: (limb: string | null) => void }): ReactElement {
  const host = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const clock = useRef<HTMLSpanElement>(null);
  const slider = useRef<HTMLInputElement>(null);
  const view = useRef<ImportView | null>(null);
  const [failed, set_failed] = useState('');
  const [playing, set_playing] = useState(true);
  const [made, set_made] = useState(0);
  const [height, set_height] = useState(0);
  const theme = useStudio((s) => s.theme);
  const seen_stage = useRef('');
  const duration = staged.motion?.duration ?? 0;

  useEffect(() => {
    let ended = false;
    let observer: ResizeObserver | null = null;
    reference_character().then(
      (human) => {
        if (ended || !canvas.current || !host.current) return;
        try {
          view.current = new ImportView(canvas.current, human, theme);
        } catch (error) {
          return set_failed((error as Error).message);
        }
        const resize = (): void => view.current?.resize(host.current?.clientWidth ?? 1, host.current?.clientHeight ?? 1);
        observer = new ResizeObserver(resize);
        observer.observe(host.current);
        resize();
        view.current.on_time = (time) => {
          if (clock.current) clock.current.textContent = `${time.toFixed(2)} s`;
          if (slider.current) slider.current.value = String(time);
        };
        parts.import_view = view.current;
        set_made((n) => n + 1);
      },
      (error: Error) => set_failed(error.message),
    );
    return () => {
      ended = true;
      observer?.disconnect();
      view.current?.dispose();
      view.current = null;
      parts.import_view = null;
    };
  }, [theme]);

  useEffect(() => {
    if (!view.current || !staged.mechanism) return;
    const markers = markers_of(staged);
    view.current.show({ mechanism: staged.mechanism, ...(staged.motion ? { motion: poses_of(staged.motion) } : {}), ...(markers ? { markers } : {}) }, true);
    seen_stage.current = staged.stage;
    set_height(staged.mechanism.height);
  }, [staged, made]);

  useEffect(() => {
    if (!view.current || !staged.mechanism) return;
    if (staged.mesh) view.current.color_shapes(staged.mesh.colors);
    else view.current.color(link_colors(staged.anatomy, staged.mechanism.links.length, chosen));
    view.current.on_link = (link) => choose(staged.anatomy?.limbs.find((l) => l.links.includes(link))?.limb ?? null);
  }, [staged, made, chosen, choose]);

  return (
    <div className="import-preview">
      <div ref={host} className="import-stage" aria-busy={busy}>
        <canvas ref={canvas} role="img" aria-label={`${staged.file} next to a 1.8 m human on a 1 m grid; height with these settings: ${format_length(height)}`} />
        {failed && <div className="viewport-failed" role="alert"><strong>The preview cannot be drawn.</strong><span>{failed}</span></div>}
        <div className="import-legend" aria-hidden="true">
          <span><i className="swatch measure-swatch" />1.8 m human</span>
          <span><i className="swatch own-swatch" />{height > 0 ? `${format_length(height)} high` : staged.file}</span>
          {(staged.anatomy?.limbs.length ?? 0) > 0 && (
            <>
              <span><i className="swatch" style={{ background: limb_colors['left leg'] }} />left</span>
              <span><i className="swatch" style={{ background: limb_colors['right leg'] }} />right</span>
              <span><i className="swatch" style={{ background: unsure_color }} />not sure</span>
              <span>click a limb</span>
            </>
          )}
          {staged.markers && <span><i className="swatch marker-swatch" />{staged.markers.labels.length} markers</span>}
          <span>grid: 1 m</span>
        </div>
        {busy && <p className="import-busy" role="status">Reading the file again…</p>}
      </div>
      {duration > 0 && (
        <div className="import-transport">
          <button
            type="button"
            className="tool"
            aria-label={playing ? 'Pause the preview' : 'Play the preview'}
            title={playing ? 'Pause the preview' : 'Play the preview'}
            onClick={() => {
              if (view.current) view.current.playing = !playing;
              set_playing(!playing);
            }}
          >
            <Icon name={playing ? 'pause' : 'play'} />
          </button>
          <input
            ref={slider}
            type="range"
            aria-label="Preview time"
            min={0}
            max={duration}
            step={0.01}
            defaultValue={0}
            onInput={(e) => {
              if (!view.current) return;
              view.current.playing = false;
              view.current.time = Number(e.currentTarget.value);
              set_playing(false);
              if (clock.current) clock.current.textContent = `${view.current.time.toFixed(2)} s`;
            }}
          />
          <span ref={clock} className="clock-text">0.00 s</span>
          <span className="hint">of {duration.toFixed(2)} s</span>
          <button type="button" className="quiet" title="Move the camera to show the character" onClick={() => view.current?.frame()}>Frame</button>
        </div>
      )}
    </div>
  );
}
