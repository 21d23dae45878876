import { useEffect, useRef, type ReactElement } from 'react';
import { apply_command, find_character, find_clip, find_event, find_marker, type Character, type Clip, type Command, type Marker, type PushAxes, type ScenarioDocument, type ScenarioEvent } from '../core/document';
import { with_axes } from '../core/event_arrows';
import { find_camera, find_shot } from '../core/film_edits';
import { describe_items, items_span, move_items, type Item } from '../core/items';
import { format_label } from '../core/format';
import { link_position } from '../core/frames';
import { describe_entry, format_length, format_mass } from '../core/library/words';
import { character_choices, find_instance, nameable_characters } from '../core/nested';
import type { LibraryEntry, MechanismData, Vec3 } from '../core/protocol';
import { shown_document } from '../core/state';
import { find_variable } from '../core/variables';
import { run } from './actions';
import { session, usePoser, useStudio } from './app';
import { CircuitSelection } from './circuit/LsiInspector';
import { ColorField } from './ColorField';
import { present_base } from './EventArrow';
import { describe_camera } from './film/CameraTrack';
import { CameraFields, ShotFields } from './film/fields';
import { GroundNotes } from './GroundNotes';
import { MotionOperations } from './motion/ClipMenu';
import { GaitFields } from './motion/GaitFields';
import { InstanceFields, NestedScenarios, TracksFields } from './nested/fields';
import { JointFields } from './posing/JointFields';
import { EntryDetails } from './library/EntryDetails';
import { VariableFields } from './rules/Variables';
import { ChoiceField, NumberField, SegmentsField, SwitchField, TextField } from './NumberField';
import { PlacementFields } from './PlacementFields';
import { PropFields } from './PropFields';

const send = (command: Command): void => void session.edit(command);

/** Shows the document as `command` would change it, without sending the command; null ends the preview. */
const preview = (command: Command | null): void => {
  const { document } = session.state;
  if (document) session.show_preview(command ? apply_command(document, command) : null);
};

export function InspectorPanel(): ReactElement {
  const selection = useStudio((s) => s.selection);
  const doc = useStudio(shown_document);
  useStudio((s) => s.library_revision);
  const posing = usePoser((s) => s.on);
  if (!doc) return <div className="panel empty">No project is open yet.</div>;
  let body: ReactElement | null = null;
  if (selection.kind === 'clip') {
    const clip = find_clip(doc, selection.character, selection.clip);
    if (clip) body = <ClipFieldsView key={clip.id} character={selection.character} clip={clip} entry={session.entry(clip.motion)} />;
  } else if (selection.kind === 'character') {
    const character = find_character(doc, selection.character);
    if (character?.prop) body = <PropFields key={character.id} character={character} prop={character.prop} />;
    else if (character) body = <CharacterFields key={character.id} character={character} link={selection.link} doc={doc} posing={posing} />;
  } else if (selection.kind === 'instance') {
    const instance = find_instance(doc, selection.instance);
    if (instance) body = <InstanceFields key={instance.id} instance={instance} doc={doc} />;
  } else if (selection.kind === 'tracks') {
    body = <TracksFields tracks={selection.tracks} doc={doc} />;
  } else if (selection.kind === 'event') {
    const event = find_event(doc, selection.event);
    if (event) body = <EventFields key={event.id} event={event} doc={doc} />;
  } else if (selection.kind === 'items') {
    body = <ItemsFields doc={doc} items={selection.items} />;
  } else if (selection.kind === 'camera') {
    const camera = find_camera(doc, selection.camera);
    if (camera) body = <CameraFields key={camera.id} camera={camera} doc={doc} />;
  } else if (selection.kind === 'shot') {
    const shot = find_shot(doc, selection.shot);
    if (shot) body = <ShotFields key={shot.id} shot={shot} doc={doc} />;
  } else if (selection.kind === 'variable') {
    const variable = find_variable(doc, selection.variable);
    if (variable) body = <VariableFields key={variable.id} variable={variable} />;
  } else if (selection.kind === 'marker') {
    const marker = find_marker(doc, selection.marker);
    if (marker) body = <MarkerFields key={marker.id} marker={marker} />;
  } else if (selection.kind === 'entry') {
    const entry = session.entry(selection.entry);
    if (entry) body = <EntryDetails entry={entry} doc={doc} />;
  } else if (selection.kind === 'circuit') {
    body = <CircuitSelection />;
  }
  return (
    <div className="panel inspector" role="form" aria-label="Inspector">
      {body ?? <ScenarioFields doc={doc} />}
    </div>
  );
}

function ClipFieldsView({ character, clip, entry }: { character: string; clip: Clip; entry: LibraryEntry | undefined }): ReactElement {
  const set = (fields: Partial<Clip>): Command => ({ type: 'clip.set', character, id: clip.id, ...fields });
  const number = (key: 'start' | 'length' | 'offset' | 'speed' | 'blend') => ({
    on_preview: (value: number | null) => preview(value === null ? null : set({ [key]: value })),
    on_commit: (value: number) => send(set({ [key]: value })),
  });
  const owner = useStudio((s) => s.document?.characters.find((c) => c.id === character)?.name ?? '');
  return (
    <>
      <h3>
        Clip <span className="of">{entry?.name ?? clip.motion}</span>
      </h3>
      <p className="facts">{[owner, entry ? describe_entry(entry) : ''].filter(Boolean).join(' · ')}</p>
      <NumberField label="Start" unit="s" value={clip.start} step={0.01} min={0} title="Time in the scenario at which the clip starts" {...number('start')} />
      <NumberField label="Length" unit="s" value={clip.length} step={0.01} min={0.01} title="Duration of the clip in the scenario" {...number('length')} />
      <NumberField label="Offset" unit="s" value={clip.offset} step={0.01} min={0} title="Time in the motion at which the clip starts" {...number('offset')} />
      <NumberField label="Speed" unit="×" value={clip.speed} step={0.01} min={0.1} max={2} slider title="Playback speed of the motion; 1 is the recorded speed" {...number('speed')} />
      <NumberField label="Blend in" unit="s" value={clip.blend} step={0.01} min={0} max={5} title="Duration of the cross-fade from the previous clip" {...number('blend')} />
      <SwitchField label="Loop" value={clip.loop} title="Repeat the motion until the clip ends; for cyclic motions" on_commit={(loop) => send(set({ loop }))} />
      <div className="actions">
        <button type="button" title="Split the clip at the playhead" onClick={() => run('edit.split')}>Split</button>
        <button type="button" onClick={() => run('edit.duplicate')}>Duplicate</button>
        <button type="button" onClick={() => run('edit.remove')}>Delete</button>
      </div>
      {clip.gait && <GaitFields character={character} clip={clip} gait={clip.gait} />}
      <MotionOperations character={character} clip={clip} />
    </>
  );
}

function CharacterFields({ character, link, doc, posing }: { character: Character; link: number | undefined; doc: ScenarioDocument; posing: boolean }): ReactElement {
  const mechanism = useStudio((s) => s.mechanisms[character.mechanism]);
  const { control } = character;
  const set_control = (fields: Partial<typeof control>): void => send({ type: 'character.set', id: character.id, control: fields });
  const active = control.mode === 'track';
  const shown_link = link !== undefined ? mechanism?.links[link] : undefined;
  const label = format_label(shown_link?.label || shown_link?.name || '');
  const joint = shown_link && link !== undefined && (
    <>
      <LinkReadout character={character.id} link={link} label={label} joint={shown_link.joint} dofs={shown_link.dofs} />
      <JointFields character={character.id} link={link} label={label} />
    </>
  );
  return (
    <>
      <h3>
        Character <span className="of">{character.name}</span>
      </h3>
      {mechanism && (
        <p className="facts">
          {format_length(session.entry(character.mechanism)?.height || mechanism.height)} · {format_mass(mechanism.mass)} · {mechanism.dofs} DOF
        </p>
      )}
      {posing && joint}
      <TextField label="Name" value={character.name} on_commit={(name) => send({ type: 'character.set', id: character.id, name })} />
      <TextField label="Group" value={character.group ?? ''} optional placeholder="none" title="Tracks of characters with the same group are shown together in the timeline and can be folded" on_commit={(group) => send({ type: 'character.set', id: character.id, group })} />
      <ColorField label="Colour" value={character.color ?? '#e6e6ea'} on_commit={(color) => send({ type: 'character.set', id: character.id, color })} />
      <PlacementFields character={character} />
      <GroundNotes about={character.id} />
      <h4>Motion control</h4>
      <ChoiceField
        label="Drive"
        value={control.mode}
        choices={[['track', 'Follow the track'], ['passive', 'Passive body'], ['path', 'Follow exactly'], ['torque', 'Torques of the motion']]}
        title="Follow the track: motion control drives the joints. Passive body: no control forces. Follow exactly: high gains and as much root assist as needed. Torques of the motion: the clip's own torques, without control"
        on_commit={(mode) => set_control({ mode: mode as typeof control.mode })}
      />
      {active && (
        <>
          <NumberField label="Tracking" unit="×" value={control.tracking} step={0.01} min={0} max={2} slider title="Factor on the joint gains of motion control; 1 is the default" on_commit={(tracking) => set_control({ tracking })} />
          <NumberField label="Balance" unit="×" value={control.balance} step={0.01} min={0} max={2} slider title="Factor on the root gains of motion control; 1 is the default" on_commit={(balance) => set_control({ balance })} />
          <NumberField label="Assist limit" unit="% of weight" value={control.assist_limit * 100} step={1} digits={0} min={0} max={500} title="Maximum assist force on the root, in percent of body weight; a character that needs more is released and falls" on_commit={(v) => set_control({ assist_limit: v / 100 })} />
          {control.assist_limit === 0 && (
            <NumberField label="Swing" unit="°" value={control.swing ?? 0} step={1} digits={0} min={0} max={90} title="Amplitude to which the character swings with its legs while its hands hold something fixed; 0: it only hangs" on_commit={(swing) => set_control({ swing })} />
          )}
          <div className="field">
            <span>Above the limit</span>
            <output>released</output>
          </div>
        </>
      )}
      {!posing && joint}
      <div className="actions">
        <button type="button" title="Move the camera to show the character" onClick={() => run('view.frame')}>Frame</button>
        <button type="button" title="Let the character walk or trot after its last clip, without measured data" onClick={() => run('edit.gait')}>Add gait</button>
        <button type="button" title="Add a push event at the playhead" onClick={() => run('edit.push')} disabled={doc.characters.length === 0}>Add push</button>
        <button type="button" onClick={() => run('edit.remove')}>Delete</button>
      </div>
    </>
  );
}

/** Joint and world position (m) of a link. The position is written to the DOM ten times a second, without rendering in React. */
function LinkReadout({ character, link, label, joint, dofs }: { character: string; link: number; label: string; joint: string; dofs: number }): ReactElement {
  const position = useRef<HTMLOutputElement>(null);
  useEffect(() => {
    const timer = setInterval(() => {
      const frame = session.frames.latest;
      const character_frame = frame?.characters[session.state.characters.findIndex((c) => c.id === character)];
      if (!frame || !character_frame || !position.current || link >= character_frame.links) return;
      position.current.textContent = link_position(frame, character_frame, link).map((v) => v.toFixed(2)).join('  ');
    }, 100);
    return () => clearInterval(timer);
  }, [character, link]);
  return (
    <>
      <h4>
        Link <span className="of">{label}</span>
      </h4>
      <div className="field">
        <span>Joint</span>
        <output>{dofs > 0 ? `${joint}, ${dofs} DOF` : joint}</output>
      </div>
      <div className="field">
        <span>Position</span>
        <output className="wide-number">
          <output ref={position} />
          <span className="unit">m</span>
        </output>
      </div>
    </>
  );
}

function VectorFields({ label, value, unit, step, on_commit }: { label: string; value: Vec3; unit: string; step: number; on_commit: (value: Vec3) => void }): ReactElement {
  return (
    <>
      {(['X', 'Y', 'Z'] as const).map((axis, i) => (
        <NumberField key={axis} label={`${label} ${axis}`} unit={unit} value={value[i]!} step={step} on_commit={(v) => on_commit(value.map((old, j) => (j === i ? v : old)) as Vec3)} />
      ))}
    </>
  );
}

function EventFields({ event, doc }: { event: ScenarioEvent; doc: ScenarioDocument }): ReactElement {
  const set = (fields: Partial<Omit<ScenarioEvent, 'id' | 'type'>>): Command => ({ type: 'event.set', id: event.id, event: fields });
  const character = event.character ? nameable_characters(doc).find((c) => c.id === event.character) : undefined;
  const mechanism = useStudio((s) => (character ? s.mechanisms[character.mechanism] : undefined));
  return (
    <>
      <h3>
        Event <span className="of">{event.type}</span>
      </h3>
      <NumberField label="Time" unit="s" value={event.time} step={0.01} min={0} title="Time in the scenario at which the event starts" on_preview={(v) => preview(v === null ? null : set({ time: v }))} on_commit={(time) => send(set({ time }))} />
      <ChoiceField label="Character" value={event.character ?? ''} choices={character_choices(doc)} on_commit={(id) => send(set({ character: id }))} />
      {event.type === 'push' && (
        <>
          <NumberField label="Duration" unit="s" value={event.duration ?? 0.2} step={0.01} min={0.001} title="Time for which the force acts" on_commit={(duration) => send(set({ duration }))} />
          {mechanism && <ChoiceField label="Link" value={event.link ?? ''} choices={mechanism.links.map((l) => [l.name, format_label(l.label || l.name)])} on_commit={(link) => send(set({ link }))} />}
          <SegmentsField label="Axes" value={event.axes ?? 'world'} choices={push_axes} on_commit={(axes) => send(set(with_axes(event, axes, present_base(event))))} />
          <VectorFields label="Force" unit="N" step={1} value={event.force ?? [0, 0, 0]} on_commit={(force) => send(set({ force }))} />
        </>
      )}
      {event.type === 'pull' && (
        <>
          <NumberField label="Duration" unit="s" value={event.duration ?? 0} step={0.01} min={0.001} title="Time for which the link is pulled" on_commit={(duration) => send(set({ duration }))} />
          {mechanism && <ChoiceField label="Link" value={event.link ?? ''} choices={link_choices(mechanism)} title="The pulled link" on_commit={(link) => send(set({ link }))} />}
          <VectorFields label="Point" unit="m" step={0.01} value={event.point ?? [0, 0, 0]} on_commit={(point) => send(set({ point }))} />
          <p className="facts">{describe_pull(event)}</p>
        </>
      )}
      {event.type === 'throw' && (
        <>
          <VectorFields label="From" unit="m" step={0.01} value={event.from ?? [0, 0, 0]} on_commit={(from) => send(set({ from }))} />
          <VectorFields label="Velocity" unit="m/s" step={0.05} value={event.velocity ?? [0, 0, 0]} on_commit={(velocity) => send(set({ velocity }))} />
          <VectorFields label="Spin" unit="rad/s" step={0.05} value={event.spin ?? [0, 0, 0]} on_commit={(spin) => send(set({ spin }))} />
        </>
      )}
      {(event.type === 'grab' || event.type === 'release') && mechanism && (
        <ChoiceField label="Link" value={event.link ?? ''} choices={link_choices(mechanism)} title={event.type === 'grab' ? 'The link that grips' : 'The link that releases what it grips'} on_commit={(link) => send(set({ link }))} />
      )}
      {event.type === 'grab' && <GrabFields event={event} doc={doc} set={set} />}
      <div className="actions">
        {event.type === 'grab' && <button type="button" title="Add an event at the playhead at which the link releases what it grips" onClick={() => run('edit.release')}>Release here</button>}
        <button type="button" title="Move the playhead to 0.2 s before the event" onClick={() => session.seek(Math.max(0, event.time - 0.2))}>Go to event</button>
        <button type="button" onClick={() => run('edit.duplicate')}>Duplicate</button>
        <button type="button" onClick={() => run('edit.remove')}>Delete</button>
      </div>
    </>
  );
}

const push_axes: [PushAxes, string, string][] = [
  ['world', 'World', 'The force keeps its direction'],
  ['body', 'Body', 'The force is given in the axes of the link and turns with it'],
];

/** How far and how long the target of a pull moves. */
function describe_pull(event: ScenarioEvent): string {
  const path = event.path ?? [];
  const length = path.slice(1).reduce((sum, p, i) => sum + Math.hypot(p[1] - path[i]![1], p[2] - path[i]![2], p[3] - path[i]![3]), 0);
  return `The target moves ${length.toFixed(2)} m, as you moved it in the simulation (${path.length} ${path.length === 1 ? 'position' : 'positions'}).`;
}

const link_choices = (mechanism: MechanismData): [string, string][] => mechanism.links.map((l) => [l.name, format_label(l.label || l.name)]);

/** What a grab grips, where, and when it opens. */
function GrabFields({ event, doc, set }: { event: ScenarioEvent; doc: ScenarioDocument; set: (fields: Partial<Omit<ScenarioEvent, 'id' | 'type'>>) => Command }): ReactElement {
  const find = (id: string): Character | undefined => nameable_characters(doc).find((c) => c.id === id);
  const other = event.other ? find(event.other) : undefined;
  const mechanism = useStudio((s) => (other ? s.mechanisms[other.mechanism] : undefined));
  const grip = (id: string): void => {
    const body = id ? find(id) : undefined;
    const first = body && session.state.mechanisms[body.mechanism]?.links.find((l) => body.id !== event.character || l.name !== event.link);
    send(set({ other: id, other_link: first?.name ?? '', at: null }));
  };
  return (
    <>
      <h4>Grip</h4>
      <ChoiceField label="Grips" value={event.other ?? ''} choices={[['', 'the world'], ...character_choices(doc)]} title="What the link grips" on_commit={grip} />
      {mechanism && <ChoiceField label="Its link" value={event.other_link ?? ''} choices={link_choices(mechanism)} on_commit={(other_link) => send(set({ other_link }))} />}
      <ChoiceField
        label="Where"
        value={event.at ? 'point' : 'here'}
        choices={[['here', 'where it is'], ['point', 'at a point']]}
        title="Where it is: the link grips at its place at the time of the event. At a point: a point of the other link, or of the world; the two points are pulled together"
        on_commit={(where) => send(set({ at: where === 'point' ? [0, 0, 0] : null }))}
      />
      {event.at && <VectorFields label="At" unit="m" step={0.01} value={event.at} on_commit={(at) => send(set({ at }))} />}
      <VectorFields label="Point" unit="m" step={0.01} value={event.point ?? [0, 0, 0]} on_commit={(point) => send(set({ point }))} />
      <SwitchField label="Hold orientation" value={event.rigid ?? false} title="On: the link keeps its orientation to what it grips. Off: it can turn about the point" on_commit={(rigid) => send(set({ rigid }))} />
      <NumberField label="Opens above" unit="N" value={event.limit ?? 450} step={10} min={1} title="A larger force for more than 0.05 s opens the grip; 400 to 500 N is the strength of a human hand" on_commit={(limit) => send(set({ limit }))} />
      <NumberField label="Reach" unit="m" value={event.reach ?? 0.15} step={0.01} min={0} max={10} title="If the points are further apart at the time of the event, nothing is gripped" on_commit={(reach) => send(set({ reach }))} />
    </>
  );
}

function MarkerFields({ marker }: { marker: Marker }): ReactElement {
  const set = (fields: { time?: number; name?: string }): Command => ({ type: 'marker.set', id: marker.id, ...fields });
  return (
    <>
      <h3>
        Marker <span className="of">{marker.name}</span>
      </h3>
      <TextField label="Name" value={marker.name} on_commit={(name) => send(set({ name }))} />
      <NumberField label="Time" unit="s" value={marker.time} step={0.01} min={0} title="Time of the marker in the scenario" on_preview={(v) => preview(v === null ? null : set({ time: v }))} on_commit={(time) => send(set({ time }))} />
      <div className="actions">
        <button type="button" onClick={() => session.seek(marker.time)}>Go to marker</button>
        <button type="button" onClick={() => run('edit.remove')}>Delete</button>
      </div>
    </>
  );
}

function ItemsFields({ doc, items }: { doc: ScenarioDocument; items: readonly Item[] }): ReactElement {
  const span = items_span(doc, items);
  const shift = (command: Command | null): void => {
    if (command) send(command);
  };
  return (
    <>
      <h3>
        Selection <span className="of">{describe_items(doc, items)}</span>
      </h3>
      <p className="facts">A drag, the arrow keys, Delete and Duplicate change all of them in one step.</p>
      {span && (
        <>
          <NumberField label="Start" unit="s" value={span.from} step={0.01} min={0} title="Start of the first selected clip or event; the others keep their distance" on_preview={(v) => preview(v === null ? null : move_items(doc, items, v - span.from))} on_commit={(v) => shift(move_items(session.state.document ?? doc, items, v - (items_span(session.state.document ?? doc, items)?.from ?? span.from)))} />
          <p className="facts">The selection ends at {span.to.toFixed(2)} s.</p>
        </>
      )}
      <div className="actions">
        <button type="button" onClick={() => run('edit.duplicate')}>Duplicate</button>
        <button type="button" onClick={() => run('edit.remove')}>Delete</button>
      </div>
    </>
  );
}

const rates = [24, 25, 30, 50, 60, 120];

function ScenarioFields({ doc }: { doc: ScenarioDocument }): ReactElement {
  const set = (fields: Partial<ScenarioDocument>): void => send({ type: 'scenario.set', ...fields } as Command);
  return (
    <>
      <h3>
        Scenario <span className="of">{doc.name}</span>
      </h3>
      <p className="facts">Select a character, a clip or an event to edit it.</p>
      <TextField label="Name" value={doc.name} on_commit={(name) => set({ name })} />
      <NumberField label="Duration" unit="s" value={doc.duration} step={0.1} min={0.1} max={3600} title="Length of the scenario" on_preview={(v) => preview(v === null ? null : { type: 'scenario.set', duration: v })} on_commit={(duration) => set({ duration })} />
      <ChoiceField label="Frame rate" value={String(doc.frame_rate)} choices={rates.map((r) => [String(r), `${r} / s`])} title="Frames per second that are recorded and shown" on_commit={(rate) => set({ frame_rate: Number(rate) })} />
      <NestedScenarios doc={doc} />
      <h4>Physics</h4>
      <ChoiceField label="Step" value={String(doc.step)} choices={[...new Set([0.0005, 0.001, 0.002, 0.004, doc.step])].sort().map((s) => [String(s), `${s * 1000} ms · ${Math.round(1 / s)} Hz`])} title="Time step of the simulation" on_commit={(step) => set({ step: Number(step) })} />
      <NumberField label="Gravity" unit="m/s²" value={-doc.gravity[2]} step={0.01} title="Gravitational acceleration, downwards" on_commit={(g) => set({ gravity: [doc.gravity[0], doc.gravity[1], -g] })} />
      <NumberField label="Friction" value={doc.ground.friction} step={0.01} min={0} max={2} slider title="Coefficient of friction of the ground" on_commit={(friction) => set({ ground: { ...doc.ground, friction } })} />
      <NumberField label="Restitution" value={doc.ground.restitution} step={0.01} min={0} max={1} slider title="Coefficient of restitution of the ground: 0 does not bounce, 1 is elastic" on_commit={(restitution) => set({ ground: { ...doc.ground, restitution } })} />
      <h4>Cameras</h4>
      {doc.cameras?.map((camera) => (
        <button key={camera.id} type="button" className="camera-row" onClick={() => session.select({ kind: 'camera', camera: camera.id })}>
          {camera.name} <span>{describe_camera(doc, camera)}</span>
        </button>
      ))}
      <div className="actions">
        <button type="button" title="Add a camera with the present view" onClick={() => run('camera.add')}>New camera from this view</button>
        <button type="button" title="Light, sky, ground and materials" onClick={() => run('page.look')}>Look…</button>
      </div>
    </>
  );
}
