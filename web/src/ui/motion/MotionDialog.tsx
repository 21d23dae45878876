/**
 * The dialog for the options of an operation on a motion, with a picker for the second motion or the other body if the operation needs one.
 */
import { useEffect, useState, type ReactElement } from 'react';
import { find_character, find_clip, type Clip } from '../../core/document';
import { format_label } from '../../core/format';
import type { With } from '../../core/motion/desk';
import { find_operation, first_values, options_of, type Field, type Operation, type Value } from '../../core/motion/operations';
import { describe_entry, from_service } from '../../core/library/words';
import type { LibraryEntry, MechanismData } from '../../core/protocol';
import { desk, service_fetch, session, useDesk, useStudio } from '../app';
import { Backdrop } from '../dialogs';
import { Icon } from '../icons';
import { ChoiceField, NumberField, SwitchField } from '../NumberField';

export function MotionDialog(): ReactElement | null {
  const dialog = useDesk((s) => s.dialog);
  const doc = useStudio((s) => s.document);
  const operation = dialog && find_operation(dialog.operation);
  const clip = dialog && doc ? find_clip(doc, dialog.character, dialog.clip) : undefined;
  if (!dialog || !operation || !doc || !clip) return null;
  return <Form key={`${dialog.operation} ${dialog.clip}`} operation={operation} character={dialog.character} clip={clip} mechanism_id={find_character(doc, dialog.character)?.mechanism ?? ''} />;
}

function Form({ operation, character, clip, mechanism_id }: { operation: Operation; character: string; clip: Clip; mechanism_id: string }): ReactElement {
  const [values, set_values] = useState(() => first_values(operation));
  const [other, set_other] = useState<{ pick: With; name: string } | null>(null);
  const mechanism = useStudio((s) => s.mechanisms[mechanism_id]);
  const needs_other = operation.needs === 'motion' || operation.needs === 'body';
  const name = session.entry(clip.motion)?.name ?? 'this motion';
  const set = (key: string) => (value: Value) => set_values((v) => ({ ...v, [key]: value }));
  const apply = (): void => {
    if (needs_other && !other) return;
    desk.close();
    void desk.run(operation.id, { character, clip: clip.id }, options_of(operation, values), other?.pick ?? {});
  };
  return (
    <Backdrop label={operation.label} close={() => desk.close()}>
      <form
        className="motion-dialog"
        onSubmit={(e) => {
          e.preventDefault();
          apply();
        }}
      >
        <div className="dialog-head">
          <h2>{operation.label}</h2>
          <button type="button" className="tool" aria-label="Close" title="Close  (Esc)" onClick={() => desk.close()}>
            <Icon name="close" />
          </button>
        </div>
        <p className="about">{operation.hint}</p>
        {operation.needs === 'motion' && <MotionPicker exclude={clip.motion} mechanism={mechanism_id} chosen={other?.name ?? null} choose={(id, label) => set_other({ pick: { motion: id }, name: label })} />}
        {operation.needs === 'body' && <BodyPicker exclude={mechanism_id} chosen={other?.name ?? null} choose={(pick, label) => set_other({ pick, name: label })} />}
        {operation.between ? (
          <Between from={name} to={other?.name ?? 'the other motion'} value={values[operation.between] as number} on_change={set(operation.between)} />
        ) : (
          operation.fields.filter((f) => !f.when || f.when(values)).map((field) => <FieldView key={field.key} field={field} value={values[field.key]!} set={set(field.key)} mechanism={mechanism} />)
        )}
        <div className="actions">
          <button type="button" onClick={() => desk.close()}>Cancel</button>
          <button type="submit" className="primary" disabled={needs_other && !other} autoFocus={!needs_other}>
            {operation.needs === 'body' ? 'Make character' : 'Apply'}
          </button>
        </div>
      </form>
    </Backdrop>
  );
}

function FieldView({ field, value, set, mechanism }: { field: Field; value: Value; set: (value: Value) => void; mechanism: MechanismData | undefined }): ReactElement {
  switch (field.kind) {
    case 'number':
      return <NumberField label={field.label} title={field.title} unit={field.unit} value={value as number} min={field.min} max={field.max} step={field.step} digits={field.digits} slider={field.slider} on_preview={(v) => v !== null && set(v)} on_commit={set} />;
    case 'switch':
      return <SwitchField label={field.label} title={field.title} value={value as boolean} on_commit={set} />;
    case 'choice':
      return <ChoiceField label={field.label} title={field.title} value={value as string} choices={field.choices} on_commit={set} />;
    case 'links':
      return <LinkList field={field} chosen={value as string[]} set={set} mechanism={mechanism} />;
  }
}

/** Slider for the share of the second motion in a blend, 0 to 100 %. */
function Between({ from, to, value, on_change }: { from: string; to: string; value: number; on_change: (value: number) => void }): ReactElement {
  return (
    <div className="between">
      <div className="between-ends">
        <span title={from}>{from}</span>
        <output>{Math.round(value)} %</output>
        <span title={to}>{to}</span>
      </div>
      <input type="range" aria-label="Share of the other motion" min={0} max={100} step={1} value={value} style={{ '--fill': `${value}%` } as React.CSSProperties} onChange={(e) => on_change(Number(e.target.value))} />
    </div>
  );
}

/** Depth of each link in the mechanism's tree (root: 0), for the indent. */
function depths(mechanism: MechanismData): number[] {
  const out: number[] = [];
  for (const link of mechanism.links) out.push(link.parent >= 0 ? (out[link.parent] ?? 0) + 1 : 0);
  return out;
}

function LinkList({ field, chosen, set, mechanism }: { field: Field; chosen: string[]; set: (value: string[]) => void; mechanism: MechanismData | undefined }): ReactElement {
  const indent = mechanism ? depths(mechanism) : [];
  return (
    <fieldset className="link-list" title={field.title}>
      <legend>{field.label}</legend>
      <div role="group">
        {mechanism?.links.map((link, i) => (
          <label key={link.name} style={{ paddingLeft: `calc(${Math.min(indent[i] ?? 0, 8)} * 2.5 * var(--u))` }}>
            <input type="checkbox" checked={chosen.includes(link.name)} onChange={(e) => set(e.target.checked ? [...chosen, link.name] : chosen.filter((n) => n !== link.name))} />
            {format_label(link.label || link.name)}
          </label>
        ))}
      </div>
    </fieldset>
  );
}

/** Up to 50 entries of a kind that match a query, from the library and the open project. */
function useEntries(kind: LibraryEntry['kind'], query: string): { entries: LibraryEntry[]; more: boolean; failed: boolean } {
  const [found, set_found] = useState<{ entries: LibraryEntry[]; more: boolean; failed: boolean }>({ entries: [], more: false, failed: false });
  useEffect(() => {
    const stop = new AbortController();
    const timer = setTimeout(() => {
      service_fetch(`api/library?kind=${kind}&limit=50&q=${encodeURIComponent(query.trim())}`, { signal: stop.signal })
        .then(async (response) => {
          if (!response.ok) throw new Error();
          const body = (await response.json()) as { entries: LibraryEntry[]; next: string | null };
          const entries = body.entries.map(from_service);
          session.cache_entries(entries);
          set_found({ entries, more: body.next !== null, failed: false });
        })
        .catch(() => stop.signal.aborted || set_found({ entries: [], more: false, failed: true }));
    }, query ? 150 : 0);
    return () => {
      clearTimeout(timer);
      stop.abort();
    };
  }, [kind, query]);
  return found;
}

function Choices({ label, query, set_query, children, empty }: { label: string; query: string; set_query: (q: string) => void; children: ReactElement[]; empty: string }): ReactElement {
  return (
    <div className="picker">
      <input className="text" type="search" autoFocus aria-label={label} placeholder={label} value={query} spellCheck={false} onChange={(e) => set_query(e.target.value)} />
      <div className="choice-list" role="radiogroup" aria-label={label}>
        {children.length > 0 ? children : <p className="about">{empty}</p>}
      </div>
    </div>
  );
}

function Choice({ name, facts, chosen, choose }: { name: string; facts: string; chosen: boolean; choose: () => void }): ReactElement {
  return (
    <button type="button" role="radio" aria-checked={chosen} onClick={choose}>
      <span>{name}</span>
      <span className="facts">{facts}</span>
    </button>
  );
}

function MotionPicker({ exclude, mechanism, chosen, choose }: { exclude: string; mechanism: string; chosen: string | null; choose: (id: string, name: string) => void }): ReactElement {
  const [query, set_query] = useState('');
  const [picked, set_picked] = useState('');
  const { entries, more, failed } = useEntries('motion', query);
  // motions of the same mechanism first: they need no retargeting
  const sorted = entries.filter((e) => e.id !== exclude).sort((a, b) => Number(b.mechanism === mechanism) - Number(a.mechanism === mechanism));
  const rows = sorted.map((entry) => (
    <Choice
      key={entry.id}
      name={entry.name}
      facts={entry.mechanism === mechanism ? describe_entry(entry) : `${describe_entry(entry)} · other body`}
      chosen={chosen !== null && picked === entry.id}
      choose={() => {
        set_picked(entry.id);
        choose(entry.id, entry.name);
      }}
    />
  ));
  if (more) rows.push(<p key="more" className="about">More motions match; refine the search by name or tag.</p>);
  return <Choices label="Search for the other motion" query={query} set_query={set_query} empty={failed ? 'The library did not respond.' : query ? `No motion matches “${query}”.` : 'There is no other motion. Import one first.'}>{rows}</Choices>;
}

function BodyPicker({ exclude, chosen, choose }: { exclude: string; chosen: string | null; choose: (pick: With, name: string) => void }): ReactElement {
  const [query, set_query] = useState('');
  const [picked, set_picked] = useState('');
  const [height, set_height] = useState(1.1);
  const { entries, failed } = useEntries('mechanism', query);
  const pick_body = (key: string, pick: With, name: string): void => {
    set_picked(key);
    choose(pick, name);
  };
  const is_picked = (key: string): boolean => chosen !== null && picked === key;
  const rows = [
    <Choice key="height" name={`Human, ${height} m`} facts="child proportions below 1.6 m" chosen={is_picked('height')} choose={() => pick_body('height', { height }, 'a human')} />,
    <Choice key="dog" name="Dog" facts="shepherd, 32 kg" chosen={is_picked('dog')} choose={() => pick_body('dog', { sample: 'dog' }, 'a dog')} />,
    ...entries.filter((e) => e.id !== exclude).map((entry) => <Choice key={entry.id} name={entry.name} facts={describe_entry(entry)} chosen={is_picked(entry.id)} choose={() => pick_body(entry.id, { mechanism: entry.id }, entry.name)} />),
  ];
  return (
    <>
      <Choices label="Search for the body" query={query} set_query={set_query} empty={failed ? 'The library did not respond.' : ''}>{rows}</Choices>
      {is_picked('height') && (
        <NumberField
          label="Height"
          unit="m"
          value={height}
          min={0.8}
          max={2.6}
          step={0.01}
          slider
          on_preview={(v) => v !== null && set_height(v)}
          on_commit={(v) => {
            set_height(v);
            pick_body('height', { height: v }, 'a human');
          }}
        />
      )}
    </>
  );
}
