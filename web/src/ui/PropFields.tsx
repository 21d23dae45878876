/** The inspector's fields of a prop. */
import { useEffect, type ReactElement } from 'react';
import type { Character } from '../core/document';
import { format_number } from '../core/format';
import { collision_words, mesh_volume, prop_kinds, type MeshCollision, type PlainShape, type Prop } from '../core/props';
import type { MechanismData, Vec3 } from '../core/protocol';
import { run } from './actions';
import { session, useStudio } from './app';
import { ColorField } from './ColorField';
import { GroundNotes } from './GroundNotes';
import { ChoiceField, NumberField, SwitchField, TextField } from './NumberField';
import { PlacementFields } from './PlacementFields';

const axes = ['X', 'Y', 'Z'] as const;
const usual_mass = 10; // kg, of a prop that is made movable
const usual_density = 600; // kg/m³, of a mesh that is made movable: wood

type SetProp = (fields: Partial<Prop>) => void;
const replaced = (vector: Vec3, i: number, value: number): Vec3 => vector.map((old, j) => (j === i ? value : old)) as Vec3;

export function PropFields({ character, prop }: { character: Character; prop: Prop }): ReactElement {
  const set: SetProp = (fields) => void session.edit({ type: 'character.set', id: character.id, prop: fields });
  const mesh = useStudio((s) => (prop.mesh ? s.mechanisms[prop.mesh] : undefined));
  useEffect(() => {
    if (prop.mesh) void session.need_mechanism(prop.mesh);
  }, [prop.mesh]);
  const [sx, sy, sz] = prop.scale ?? [1, 1, 1];
  const volume = mesh ? mesh_volume(mesh) * sx * sy * sz : 0;
  const kind = prop.shape === 'mesh' ? 'Mesh' : prop_kinds[prop.shape].name;
  return (
    <>
      <h3>
        Prop <span className="of">{character.name}</span>
      </h3>
      <p className="facts">{kind} · {prop.mass > 0 ? `moves, ${format_number(prop.mass, 4)} kg` : 'fixed in the world'}</p>
      <GroundNotes about={character.id} />
      <TextField label="Name" value={character.name} on_commit={(name) => void session.edit({ type: 'character.set', id: character.id, name })} />
      <TextField label="Group" value={character.group ?? ''} optional placeholder="none" title="Tracks with the same group are shown together in the timeline and can be folded" on_commit={(group) => void session.edit({ type: 'character.set', id: character.id, group })} />
      <Colors character={character} />
      <h4>Shape</h4>
      {prop.shape === 'mesh' ? <MeshShape prop={prop} mesh={mesh} set={set} /> : <PlainFields prop={prop} shape={prop.shape} set={set} />}
      <PlacementFields character={character} height="Height of the bottom" />
      {prop.shape !== 'sphere' && prop.shape !== 'terrain' && axes.slice(0, prop.shape === 'mesh' ? 3 : 2).map((axis, i) => (
        <NumberField key={axis} label={`Tilt ${axis}`} unit="°" value={prop.tilt?.[i] ?? 0} step={1} digits={1} min={-180} max={180} title={`Rotation about the prop's own ${axis} axis`} on_commit={(v) => set({ tilt: replaced(prop.tilt ?? [0, 0, 0], i, v) })} />
      ))}
      <h4>Contact</h4>
      {prop.shape !== 'terrain' && <SwitchField label="Moves" value={prop.mass > 0} title="Off: fixed in the world. On: a body with a mass, which can be pushed, thrown and carried" on_commit={(on) => set({ mass: !on ? 0 : volume > 0 ? Number(Math.min(1e6, Math.max(0.001, usual_density * volume)).toPrecision(4)) : usual_mass })} />}
      {prop.mass > 0 && <NumberField label="Mass" unit="kg" value={prop.mass} step={0.1} min={0.001} max={1e6} on_commit={(mass) => set({ mass })} />}
      {prop.mass > 0 && volume > 0 && (
        <NumberField label="Density" unit="kg/m³" value={prop.mass / volume} step={10} digits={1} min={0.01} max={1e5} title="Mass divided by volume. Wood 600, water 1000, concrete 2400, steel 7850" on_commit={(density) => set({ mass: Number((density * volume).toPrecision(6)) })} />
      )}
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

function PlainFields({ prop, shape, set }: { prop: Prop; shape: PlainShape; set: SetProp }): ReactElement {
  const kind = prop_kinds[shape];
  const size = prop.size ?? [1, 1, 1];
  return (
    <>
      {axes.map((axis, i) => kind.size[i] && (
        <NumberField key={axis} label={kind.size[i]!} unit="m" value={size[i]!} step={0.01} digits={size[i]! < 0.1 ? 3 : 2} min={0.005} max={1000} on_commit={(v) => set({ size: replaced(size, i, v) })} />
      ))}
      {shape === 'terrain' && (
        <>
          <NumberField label="Grain" unit="m" value={prop.grain ?? 2} step={0.05} min={0.05} max={100} title="About the distance from a hill to the next hollow" on_commit={(grain) => set({ grain })} />
          <NumberField label="Seed" unit="" value={prop.seed ?? 1} step={0.2} digits={0} min={0} max={999999} title="Each seed gives other hills" on_commit={(seed) => set({ seed: Math.round(seed) })} />
        </>
      )}
      {shape === 'stairs' && <NumberField label="Steps" unit="" value={prop.steps ?? 5} step={1} digits={0} min={1} max={200} title="Number of steps; all have the same height" on_commit={(steps) => set({ steps: Math.round(steps) })} />}
    </>
  );
}

/** Scale and collision of a mesh. */
function MeshShape({ prop, mesh, set }: { prop: Prop; mesh: MechanismData | undefined; set: SetProp }): ReactElement {
  const scale = prop.scale ?? [1, 1, 1];
  const even = scale.every((s) => s === scale[0]);
  const collision = prop.collision ?? 'hull';
  const words = Object.entries(collision_words) as [MeshCollision, [string, string]][];
  return (
    <>
      <p className="facts">{mesh ? `${mesh.name}${mesh.height ? ` · ${format_number(mesh.height * scale[2], 3)} m high` : ''}` : 'The mesh is being loaded…'}</p>
      <NumberField label="Scale" unit="" value={even ? scale[0] : Math.cbrt(scale[0] * scale[1] * scale[2])} step={0.01} digits={3} min={1e-4} max={1e4} title="Factor on all lengths" on_commit={(v) => {
        const factor = even ? v / scale[0] : v / Math.cbrt(scale[0] * scale[1] * scale[2]);
        set({ scale: scale.map((s) => (even ? v : Number((s * factor).toPrecision(6)))) as Vec3 });
      }} />
      {axes.map((axis, i) => (
        <NumberField key={axis} label={`Scale ${axis}`} unit="" value={scale[i]!} step={0.01} digits={3} min={1e-4} max={1e4} title={`Factor on the lengths along the mesh's own ${axis} axis`} on_commit={(v) => set({ scale: replaced(scale, i, v) })} />
      ))}
      <ChoiceField label="Collides as" value={collision} choices={words.map(([value, [name]]) => [value, name])} on_commit={(v) => set({ collision: v as MeshCollision })} />
      <p className="hint">{collision_words[collision][1]}</p>
    </>
  );
}

const max_shown_colors = 12;

/** The colour of a prop; of a mesh with colours of its own, those of its materials. */
function Colors({ character }: { character: Character }): ReactElement {
  const color = character.color ?? '#e6e6ea';
  const own = character.shape_colors ?? [];
  const textured = useStudio((s) => s.mechanisms[character.mechanism]?.skin !== undefined) && (character.shown ?? 'skin') !== 'body';
  const set = (shape_colors: string[]): void => void session.edit({ type: 'character.set', id: character.id, shape_colors });
  const plain = <ColorField label="Colour" value={color} on_commit={(v) => void session.edit({ type: 'character.set', id: character.id, color: v })} />;
  if (textured) return <p className="facts">Drawn with the textures of its file. <em>Colours</em> in the tab Look shows the colours of its materials.</p>;
  if (own.length === 0) return plain;
  return (
    <>
      {own.some((c) => !c) && plain}
      {own.slice(0, max_shown_colors).map((c, i) => c && (
        <ColorField key={i} label={`Material ${i + 1}`} value={c} on_commit={(v) => set(own.map((old, j) => (j === i ? v : old)))} />
      ))}
      {own.length > max_shown_colors && <p className="hint">{own.length - max_shown_colors} further materials have colours of the file.</p>}
      <div className="actions">
        <button type="button" title="Draw the whole mesh in the colour of the prop" onClick={() => set([])}>One colour</button>
      </div>
    </>
  );
}
