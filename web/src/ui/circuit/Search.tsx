/** Search for an LSI to add. After a wire was dropped on the empty canvas, lists only LSIs with a matching pin. */
import { useEffect, useMemo, useRef, useState, type ReactElement } from 'react';
import { hue_of } from '../../core/circuit/classes';
import { search } from '../../core/circuit/search';
import { circuit, useCircuit } from '../app';

const max_shown = 60;

export function Search({ origin }: { origin: () => DOMRect | undefined }): ReactElement | null {
  const open = useCircuit((s) => s.search);
  const view = useCircuit((s) => s.view);
  const [query, set_query] = useState('');
  const [chosen, set_chosen] = useState(0);
  const list = useRef<HTMLUListElement>(null);
  const close_timer = useRef(0);
  useEffect(() => {
    set_query('');
    set_chosen(0);
    return () => clearTimeout(close_timer.current);
  }, [open]);
  const found = useMemo(() => (open && view ? search(view, query, open.fits).slice(0, max_shown) : []), [open, view, query]);
  const at = Math.min(chosen, Math.max(0, found.length - 1));
  useEffect(() => {
    list.current?.children[at]?.scrollIntoView({ block: 'nearest' });
  }, [at, query]);
  if (!open || !view) return null;
  const type = open.fits && view.pin(open.fits.node, open.fits.side, open.fits.pin)?.type;
  const choose = (index: number): void => {
    const candidate = found[index];
    if (candidate) circuit.choose(candidate.type, candidate.kind);
    document.querySelector<HTMLElement>('.circuit[role=application]')?.focus();
  };
  const box = origin();
  const left = Math.min(open.screen.x - (box?.left ?? 0), Math.max(8, (box?.width ?? 400) - 340));
  const top = Math.max(8, Math.min(open.screen.y - (box?.top ?? 0), (box?.height ?? 300) - 310));
  return (
    <div className="circuit-search" style={{ left, top }} role="dialog" aria-label="Add an LSI" onKeyDown={(e) => e.stopPropagation()}>
      {type && <div className="fits-line">fits <span style={{ color: `var(--pin-${hue_of(type)})` }}>{type}</span></div>}
      <input
        autoFocus
        type="text"
        role="combobox"
        aria-expanded="true"
        aria-controls="circuit-search-list"
        aria-activedescendant={found[at] ? `candidate-${at}` : undefined}
        aria-label="Search LSIs"
        placeholder="Add an LSI…"
        value={query}
        spellCheck={false}
        onChange={(e) => {
          set_query(e.target.value);
          set_chosen(0);
        }}
        onBlur={(e) => {
          if (!e.currentTarget.closest('.circuit-search')?.contains(e.relatedTarget)) close_timer.current = window.setTimeout(() => circuit.close_search(), 120);
        }}
        onKeyDown={(e) => {
          if (e.key === 'ArrowDown') set_chosen(Math.min(at + 1, found.length - 1));
          else if (e.key === 'ArrowUp') set_chosen(Math.max(at - 1, 0));
          else if (e.key === 'Enter') choose(at);
          else if (e.key === 'Escape' || e.key === 'Tab') {
            circuit.close_search();
            document.querySelector<HTMLElement>('.circuit[role=application]')?.focus();
          } else return;
          e.preventDefault();
          e.nativeEvent.stopImmediatePropagation();
        }}
      />
      <ul ref={list} id="circuit-search-list" role="listbox" aria-label="LSIs">
        {found.map((candidate, i) => (
          <li key={`${candidate.kind} ${candidate.type}`} id={`candidate-${i}`} role="option" aria-selected={i === at} title={candidate.doc} onPointerMove={() => set_chosen(i)} onPointerDown={(e) => { e.preventDefault(); choose(i); }}>
            <span className="candidate-name">{candidate.type}</span>
            <span className="candidate-category">{candidate.category}</span>
          </li>
        ))}
        {found.length === 0 && <li className="none">{view.classes.known ? (type ? `No LSI with a matching ${type} pin${query ? ` matches “${query}”` : ''}.` : `No LSI matches “${query}”.`) : 'Waiting for the list of LSIs…'}</li>}
      </ul>
      {found[at]?.doc && <p className="candidate-doc">{found[at].doc}</p>}
    </div>
  );
}
