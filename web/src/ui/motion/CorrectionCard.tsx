/** How far a physics correction changed a clip, and the switch of the ghost of the motion before. Shown over the viewport in the mode Edit. */
import type { ReactElement } from 'react';
import { find_character } from '../../core/document';
import { format_label } from '../../core/format';
import { run } from '../actions';
import { comparer, session, useComparer, useStudio } from '../app';
import { Icon } from '../icons';

export function CorrectionCard(): ReactElement | null {
  const { comparison, on } = useComparer((s) => s);
  const edit = useStudio((s) => s.transport.mode === 'edit');
  const character = useStudio((s) => (s.document && comparison ? find_character(s.document, comparison.character) : undefined));
  const mechanism = useStudio((s) => (character ? s.mechanisms[character.mechanism] : undefined));
  if (!edit || !comparison || !character) return null;
  const { reply, changes } = comparison;
  const link = mechanism?.links[reply.link];
  return (
    <div className="correction-card" role="group" aria-label="Physics correction">
      <div className="correction-head">
        <strong>Physics correction</strong>
        <span className="of">{character.name}</span>
        <button type="button" className="tool small" aria-label="Close" title="Close the comparison; the correction stays" onClick={() => comparer.end()}>
          <Icon name="close" />
        </button>
      </div>
      {changes.length > 0 && (
        <table>
          <thead>
            <tr><td /><th scope="col">before</th><th scope="col">after</th></tr>
          </thead>
          <tbody>
            {changes.map((c) => (
              <tr key={c.name}>
                <th scope="row">{c.name} <span className="unit">{c.unit}</span></th>
                <td data-worse={Number(c.before) > Number(c.after)}>{c.before}</td>
                <td data-worse={Number(c.after) > Number(c.before)}>{c.after}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      <button type="button" className="correction-row" disabled={reply.link < 0} title="Move the playhead to the largest change of a joint" onClick={() => session.seek(reply.time)}>
        <span>Largest change</span>
        <span>{reply.link < 0 ? 'none' : `${reply.degrees.toFixed(1)}° · ${format_label(link ? link.label || link.name : '')} at ${reply.time.toFixed(2)} s`}</span>
      </button>
      <button type="button" className="correction-row" disabled={reply.move === 0} title="Move the playhead to the largest change of the centre of mass" onClick={() => session.seek(reply.move_time)}>
        <span>Centre of mass</span>
        <span>{reply.move === 0 ? 'unchanged' : `${(100 * reply.move).toFixed(1)} cm at ${reply.move_time.toFixed(2)} s`}</span>
      </button>
      <div className="correction-actions">
        <button type="button" className="compare" aria-pressed={on} title="Show the motion before as a ghost  (Shift C)" onClick={() => run('view.compare')}>
          <span className="swatch" aria-hidden="true" /> Ghost of before
        </button>
        <button type="button" title="Restore the clip as it was before the correction" onClick={() => run('edit.undo')}>Undo</button>
      </div>
    </div>
  );
}
