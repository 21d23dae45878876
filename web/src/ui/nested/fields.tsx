/** The inspector's fields for a placed inner scenario, for several tracks, and the list of inner scenarios. */
import type { ReactElement } from 'react';
import { apply_command, type Command, type Place, type ScenarioDocument, type ScenarioInstance } from '../../core/document';
import { characters_of, count_instances, find_instance, find_scenario } from '../../core/nested';
import { run } from '../actions';
import { session, useStudio } from '../app';
import { NumberField, TextField } from '../NumberField';
import { duplicate_instance, nest_selection, open_instance, open_scenario, place_scenario } from './actions';

const send = (command: Command): void => void session.edit(command);

export function InstanceFields({ instance, doc }: { instance: ScenarioInstance; doc: ScenarioDocument }): ReactElement {
  const inner = find_scenario(doc, instance.scenario);
  const characters = characters_of(doc, instance.scenario);
  const { id, place } = instance;
  const number = (make: (value: number) => Command) => ({
    on_preview: (value: number | null): void => {
      const { document } = session.state;
      if (document) session.show_preview(value === null ? null : apply_command(document, make(value)));
    },
    on_commit: (value: number): void => send(make(value)),
  });
  const placed = (key: keyof Place) => number((value) => ({ type: 'instance.set', id, place: { [key]: value } }));
  return (
    <>
      <h3>
        Nested scenario <span className="of">{instance.name}</span>
      </h3>
      <p className="facts">
        {inner?.name ?? instance.scenario} · {(inner?.duration ?? 0).toFixed(2)} s · {characters.length === 1 ? '1 character' : `${characters.length} characters`}
      </p>
      <TextField label="Name" value={instance.name} on_commit={(name) => send({ type: 'instance.set', id, name })} />
      <NumberField label="Start" unit="s" value={instance.start} step={0.01} min={0} title="Time in this scenario at which the nested scenario begins" {...number((start) => ({ type: 'instance.set', id, start }))} />
      <h4>Placement</h4>
      <NumberField label="X" unit="m" value={place.x} step={0.01} title="Place of the nested scenario's origin" {...placed('x')} />
      <NumberField label="Y" unit="m" value={place.y} step={0.01} {...placed('y')} />
      <NumberField label="Z" unit="m" value={place.z} step={0.01} {...placed('z')} />
      <NumberField label="Heading" unit="°" value={place.heading} step={1} digits={1} title="Rotation about the vertical axis, positive to the left" {...placed('heading')} />
      <h4>Characters</h4>
      {characters.length === 0 && <p className="facts">This scenario is empty. Open it to add characters.</p>}
      <ul className="member-list" aria-label="Characters">
        {characters.map((c, i) => (
          <li key={i}>
            <span className="dot" style={{ background: c.color ?? '#e6e6ea' }} />
            {c.name}
          </li>
        ))}
      </ul>
      <div className="actions">
        <button type="button" title="Edit the scenario; this changes all its instances  (Enter)" onClick={() => open_instance(instance)}>Open</button>
        <button type="button" title="Return its tracks to this scenario" onClick={() => send({ type: 'instance.unnest', id })}>Unnest</button>
        <button type="button" title="Place the scenario again, beside this one" onClick={() => void duplicate_instance(instance)}>Duplicate</button>
        <button type="button" title="Remove this instance; the scenario stays in the list of nested scenarios" onClick={() => run('edit.remove')}>Delete</button>
      </div>
    </>
  );
}

/** Several selected tracks. */
export function TracksFields({ tracks, doc }: { tracks: readonly string[]; doc: ScenarioDocument }): ReactElement {
  const names = tracks.map((t) => doc.characters.find((c) => c.id === t)?.name ?? find_instance(doc, t)?.name ?? t);
  return (
    <>
      <h3>
        Selection <span className="of">{tracks.length} tracks</span>
      </h3>
      <p className="facts">{names.join(', ')}</p>
      <div className="actions">
        <button type="button" title="The tracks become one row, which you can place several times  (Shift N)" onClick={() => void nest_selection()}>Nest in a scenario</button>
      </div>
    </>
  );
}

/** The inner scenarios of the document, for the inspector of the scenario. */
export function NestedScenarios({ doc }: { doc: ScenarioDocument }): ReactElement | null {
  const open = useStudio((s) => s.open);
  const others = (doc.scenarios ?? []).filter((s) => !open.includes(s.id));
  if (others.length === 0) return null;
  return (
    <>
      <h4>Nested scenarios</h4>
      <ul className="nested-list" aria-label="Nested scenarios">
        {others.map((s) => {
          const count = count_instances(doc, s.id, open);
          const placed = open.length > 0 ? '' : count === 0 ? 'not placed' : count === 1 ? 'placed once' : `placed ${count} times`;
          return (
            <li key={s.id}>
              <span className="nested-name">{s.name} <span className="of">{placed}</span></span>
              <span className="actions">
              <button type="button" aria-label={`Open ${s.name}`} onClick={() => open_scenario(s.id)}>Open</button>
              <button type="button" aria-label={`Place ${s.name}`} title="Place the scenario at the playhead" onClick={() => place_scenario(s.id)}>Place</button>
              {count === 0 && open.length === 0 && <button type="button" aria-label={`Delete ${s.name}`} title="Remove the scenario with its characters from the project" onClick={() => send({ type: 'scenario.remove', id: s.id })}>Delete</button>}
              </span>
            </li>
          );
        })}
      </ul>
    </>
  );
}
