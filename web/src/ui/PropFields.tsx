/** The inspector's fields of a prop. */
import type { ReactElement } from 'react';
import type { Character } from '../core/document';
import { prop_kinds, type Prop } from '../core/props';
import type { Vec3 } from '../core/protocol';
import { run } from './actions';
import { session } from './app';
import { ColorField } from './ColorField';
import { NumberField, SwitchField, TextField } from './NumberField';
import { PlacementFields } from './PlacementFields';

const axes = ['X', 'Y', 'Z'] as const;
const usual_mass = 10; // kg, of a prop that is made movable

export function PropFields({ character, prop }: { character: Character; prop: Prop }): ReactElement {
  const kind = prop_kinds[prop.shape];
  const set = (fields: Partial<Prop>): void => void session.edit({ type: 'character.set', id: character.id, prop: fields });
  const replaced = (vector: Vec3, i: number, value: number): Vec3 => vector.map((old, j) => (j === i ? value : old)) as Vec3;
  return (
    <>
      <h3>
        Prop <span className="of">{character.name}</span>
      </h3>
      <p className="facts">{kind.name} · {prop.mass > 0 ? `moves, ${prop.mass} kg` : 'fixed in the world'}</p>
      <TextField label="Name" value={character.name} on_commit={(name) => void session.edit({ type: 'character.set', id: character.id, name })} />
      <TextField label="Group" value={character.group ?? ''} optional placeholder="none" title="Tracks with the same group are shown together in the timeline and can be folded" on_commit={(group) => void session.edit({ type: 'character.set', id: character.id, group })} />
      <ColorField label="Colour" value={character.color ?? '#e6e6ea'} on_commit={(color) => void session.edit({ type: 'character.set', id: character.id, color })} />
      <h4>Shape</h4>
      {axes.map((axis, i) => kind.size[i] && (
        <NumberField key={axis} label={kind.size[i]!} unit="m" value={prop.size[i]!} step={0.01} digits={prop.size[i]! < 0.1 ? 3 : 2} min={0.005} max={1000} on_commit={(v) => set({ size: replaced(prop.size, i, v) })} />
      ))}
      {prop.shape === 'stairs' && <NumberField label="Steps" unit="" value={prop.steps ?? 5} step={1} digits={0} min={1} max={200} title="Number of steps; all have the same height" on_commit={(steps) => set({ steps: Math.round(steps) })} />}
      <PlacementFields character={character} height="Height of the bottom" />
      {prop.shape !== 'sphere' && axes.slice(0, 2).map((axis, i) => (
        <NumberField key={axis} label={`Tilt ${axis}`} unit="°" value={prop.tilt?.[i] ?? 0} step={1} digits={1} min={-180} max={180} title={`Rotation about the prop's own ${axis} axis`} on_commit={(v) => set({ tilt: replaced(prop.tilt ?? [0, 0, 0], i, v) })} />
      ))}
      <h4>Contact</h4>
      <SwitchField label="Moves" value={prop.mass > 0} title="Off: fixed in the world. On: a body with a mass, which can be pushed, thrown and carried" on_commit={(on) => set({ mass: on ? usual_mass : 0 })} />
      {prop.mass > 0 && <NumberField label="Mass" unit="kg" value={prop.mass} step={0.1} min={0.001} max={1e6} on_commit={(mass) => set({ mass })} />}
      <NumberField label="Friction" unit="" value={prop.friction} step={0.01} min={0} max={10} title="Coulomb's coefficient of friction; two bodies in contact have the geometric mean" on_commit={(friction) => set({ friction })} />
      <NumberField label="Bounce" unit="" value={prop.restitution} step={0.01} min={0} max={1} title="Coefficient of restitution: 0 stays where it falls, 1 bounces back to its height" on_commit={(restitution) => set({ restitution })} />
      <div className="actions">
        <button type="button" title="Move the camera to show the prop" onClick={() => run('view.frame')}>Frame</button>
        <button type="button" onClick={() => run('edit.duplicate')}>Duplicate</button>
        <button type="button" onClick={() => run('edit.remove')}>Delete</button>
      </div>
    </>
  );
}
