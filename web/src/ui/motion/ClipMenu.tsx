/** The context menu of a clip, and the inspector's buttons for the same operations. */
import { useMemo, type ReactElement } from 'react';
import { find_clip, type Clip } from '../../core/document';
import { asks, operations, refusal, type Operation, type OperationGroup } from '../../core/motion/operations';
import type { ClipTarget } from '../../core/motion/desk';
import { run } from '../actions';
import { desk, session, useDesk, useStudio } from '../app';
import { Menu, type MenuItem } from '../Menu';

/** Runs an operation, or opens its dialog if it has options. */
export function begin(operation: Operation, target: ClipTarget): void {
  if (asks(operation)) desk.open(operation.id, target);
  else void desk.run(operation.id, target);
}

/** An ellipsis after names of operations that open a dialog. */
const dots = (operation: Operation): string => (asks(operation) ? '…' : '');

/** Name of an operation's button for screen readers; it contains the visible text of the button. */
const spoken = (operation: Operation): string => (operation.label.toLowerCase().includes(operation.short.toLowerCase()) ? '' : `${operation.short}: `) + operation.label + dots(operation);

export function ClipMenu(): ReactElement | null {
  const menu = useDesk((s) => s.menu);
  const doc = useStudio((s) => s.document);
  const clip = menu && doc ? find_clip(doc, menu.character, menu.clip) : undefined;
  if (!menu || !doc || !clip) return null;
  let group: OperationGroup | undefined;
  const items: MenuItem[] = operations.map((operation) => {
    const apart = group !== undefined && operation.group !== group;
    group = operation.group;
    const reason = refusal(operation, doc, menu.character, clip);
    return { label: operation.label + dots(operation), title: reason ?? operation.hint, disabled: reason !== null, apart, run: () => begin(operation, menu) };
  });
  const inside = session.now > clip.start && session.now < clip.start + clip.length;
  items.push(
    { label: 'Split at playhead', key: 'S', apart: true, disabled: !inside, run: () => run('edit.split') },
    { label: 'Duplicate', key: 'Ctrl D', run: () => run('edit.duplicate') },
    { label: 'Delete', key: 'Del', run: () => run('edit.remove') },
  );
  return <Menu x={menu.x} y={menu.y} items={items} close={() => desk.close()} over label="Operations on the clip" />;
}

const groups: [OperationGroup, string][] = [
  ['time', 'Time'],
  ['shape', 'Shape and path'],
  ['ground', 'Feet on the ground'],
  ['two', 'With another motion'],
  ['body', 'Another body'],
];

/** The inspector's section of operations on a clip's motion. */
export function MotionOperations({ character, clip }: { character: string; clip: Clip }): ReactElement {
  const doc = useStudio((s) => s.document);
  const busy = useDesk((s) => s.tasks.length > 0);
  const target = useMemo(() => ({ character, clip: clip.id }), [character, clip.id]);
  return (
    <section className="motion-operations" aria-label="Operations on the motion">
      <h4>Motion</h4>
      {groups.map(([group, title]) => (
        <div key={group} className="operation-group" role="group" aria-label={title}>
          {operations
            .filter((o) => o.group === group)
            .map((operation) => {
              const reason = doc ? refusal(operation, doc, character, clip) : null;
              return (
                <button key={operation.id} type="button" aria-label={spoken(operation)} title={`${operation.label}: ${reason ?? operation.hint}`} disabled={busy || reason !== null} onClick={() => begin(operation, target)}>
                  {operation.short}
                </button>
              );
            })}
        </div>
      ))}
    </section>
  );
}
