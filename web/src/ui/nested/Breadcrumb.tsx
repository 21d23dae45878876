/** The open inner scenario above the timeline, with the way back. */
import { Fragment, type ReactElement } from 'react';
import { find_scenario } from '../../core/nested';
import { shown_document } from '../../core/state';
import { useStudio } from '../app';
import { leave_to } from './actions';

export function Breadcrumb(): ReactElement | null {
  const open = useStudio((s) => s.open);
  const outermost = useStudio((s) => s.outermost);
  const doc = useStudio(shown_document);
  const last = open.at(-1);
  if (!doc || last === undefined) return null;
  const names = [outermost, ...open.map((id) => find_scenario(doc, id)?.name ?? id)];
  return (
    <nav className="breadcrumb" aria-label="Open scenario">
      <ol>
        {names.map((name, level) => (
          <Fragment key={level}>
            <li>
              {level < open.length ? (
                <button type="button" className="quiet" title={level === open.length - 1 ? `Back to ${name}  (Esc)` : `Back to ${name}`} onClick={() => leave_to(level)}>{name}</button>
              ) : (
                <strong aria-current="page">{doc.name}</strong>
              )}
            </li>
          </Fragment>
        ))}
      </ol>
      <span className="breadcrumb-note">
        You play and simulate only this scenario. Changes act wherever it is placed.
      </span>
    </nav>
  );
}
