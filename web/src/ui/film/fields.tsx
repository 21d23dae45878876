/** Inspector of cameras and shots. */
import type { ReactElement } from 'react';
import { apply_command, type Command, type ScenarioDocument } from '../../core/document';
import { view_of, type FilmCamera, type FilmKey, type FilmShot, type FilmView } from '../../core/film';
import { field_of_focal_length, find_camera, focal_length, key_camera } from '../../core/film_edits';
import { format_time } from '../../core/format';
import { run } from '../actions';
import { session, useStudio } from '../app';
import { ChoiceField, NumberField, TextField } from '../NumberField';

const send = (command: Command): void => void session.edit(command);
const preview = (command: Command | null): void => {
  const { document } = session.state;
  if (document) session.show_preview(command ? apply_command(document, command) : null);
};
const degrees = 180 / Math.PI;

export function CameraFields({ camera, doc }: { camera: FilmCamera; doc: ScenarioDocument }): ReactElement {
  const time = useStudio((s) => s.transport.time);
  const through = useStudio((s) => s.through);
  const keys = camera.keys ?? [];
  const view = view_of(camera, time);
  const edit = (fields: Partial<Omit<FilmCamera, 'id'>>): Command => ({ type: 'camera.set', id: camera.id, camera: fields });
  /** With keys, the change is keyed at the playhead. */
  const change = (fields: Partial<FilmView>): Command => edit(keys.length > 0 ? { keys: key_camera(camera, time, { ...view, ...fields }) } : fields);
  const number = (make: (value: number) => Partial<FilmView>) => ({
    on_preview: (value: number | null) => preview(value === null ? null : change(make(value))),
    on_commit: (value: number) => send(change(make(value))),
  });
  const [x, y, z] = view.target;
  const origin = camera.follow ? 'from the centre of mass of the followed character' : 'in the world';
  return (
    <>
      <h3>
        Camera <span className="of">{camera.name}</span>
      </h3>
      <TextField label="Name" value={camera.name} on_commit={(name) => send(edit({ name }))} />
      <ChoiceField
        label="Follow"
        value={camera.follow ?? ''}
        choices={[['', 'Nothing'], ...doc.characters.map((c): [string, string] => [c.id, c.name])]}
        title="The camera moves along with the centre of mass of the character over the ground"
        on_commit={(id) => send(edit({ follow: id || null, ...follow_target(camera, id) }))}
      />
      <h4>View{keys.length > 0 && <span className="of"> at the playhead, keyed</span>}</h4>
      <NumberField label="Lens" unit="mm" value={focal_length(view.field_of_view)} step={0.25} digits={0} min={8} max={300} title="Focal length for a picture 36 mm wide" {...number((mm) => ({ field_of_view: field_of_focal_length(mm) }))} />
      <NumberField label="Azimuth" unit="°" value={view.azimuth * degrees} step={0.5} digits={1} title="Direction from the target to the camera, about the vertical axis" {...number((v) => ({ azimuth: v / degrees }))} />
      <NumberField label="Elevation" unit="°" value={view.elevation * degrees} step={0.5} digits={1} min={-85} max={89} title="Angle of the camera above the target" {...number((v) => ({ elevation: v / degrees }))} />
      <NumberField label="Distance" unit="m" value={view.distance} step={0.02} min={0.1} max={1000} title="Distance of the camera from the target" {...number((distance) => ({ distance }))} />
      <NumberField label="Target X" unit="m" value={x} step={0.01} title={`Point that the camera looks at, ${origin}`} {...number((v) => ({ target: [v, y, z] }))} />
      <NumberField label="Target Y" unit="m" value={y} step={0.01} title={`Point that the camera looks at, ${origin}`} {...number((v) => ({ target: [x, v, z] }))} />
      <NumberField label="Target Z" unit="m" value={z} step={0.01} title="Height of the point that the camera looks at, above the ground" {...number((v) => ({ target: [x, y, v] }))} />
      <div className="actions">
        <button type="button" aria-pressed={through === camera.id} title="Look through this camera  (Ctrl 0)" onClick={() => session.set({ through: through === camera.id ? 'free' : camera.id })}>
          {through === camera.id ? 'Leave the camera' : 'Look through'}
        </button>
        <button type="button" title="Move the camera to the view of the viewport" onClick={() => run('camera.place')}>Set to view</button>
        <button type="button" title="Key the view of the viewport at the playhead  (K)" onClick={() => run('camera.key')}>Key the view</button>
        <button type="button" title="Show this camera from the playhead on  (X)" onClick={() => run('camera.cut')}>Shot from here</button>
        <button type="button" onClick={() => run('edit.remove')}>Delete</button>
      </div>
      {keys.length > 0 && (
        <>
          <h4>Keys</h4>
          <ul className="camera-keys" aria-label="Keys of the camera">
            {keys.map((key) => (
              <KeyRow key={key.time} camera={camera} item={key} now={Math.abs(key.time - time) < 1e-3} />
            ))}
          </ul>
        </>
      )}
    </>
  );
}

function KeyRow({ camera, item, now }: { camera: FilmCamera; item: FilmKey; now: boolean }): ReactElement {
  const remove = (): void => {
    const keys = camera.keys!.filter((k) => k.time !== item.time);
    const { time: _time, ...view } = item;
    send({ type: 'camera.set', id: camera.id, camera: { keys, ...(keys.length === 0 ? view : {}) } }); // the last key remains as the view
  };
  return (
    <li>
      <button type="button" className="key-time" aria-current={now} title="Move the playhead to the key" onClick={() => session.seek(item.time)}>
        {format_time(item.time)}
      </button>
      <span>{`${Math.round(focal_length(item.field_of_view))} mm, ${item.distance.toFixed(2)} m, ${Math.round(item.azimuth * degrees)}°`}</span>
      <button type="button" className="quiet" aria-label={`Delete the key at ${format_time(item.time)}`} onClick={remove}>
        Delete
      </button>
    </li>
  );
}

/** Fields that keep the view of a camera when it begins or ends to follow a character, as far as the playhead's frame is concerned. */
function follow_target(camera: FilmCamera, follow: string): Partial<FilmCamera> {
  const centre = (id: string | null | undefined): [number, number] => {
    const frame = session.frames.latest;
    const index = session.state.characters.findIndex((c) => c.id === id);
    const data = frame?.characters[index]?.data;
    return frame && data !== undefined ? [frame.floats[data + 8]!, frame.floats[data + 9]!] : [0, 0];
  };
  const [x0, y0] = centre(camera.follow);
  const [x1, y1] = centre(follow);
  const round = (value: number): number => Math.round(value * 1e4) / 1e4;
  const moved = <T extends FilmView>(view: T): T => ({ ...view, target: [round(view.target[0] + x0 - x1), round(view.target[1] + y0 - y1), view.target[2]] });
  return { target: moved(camera).target, ...(camera.keys ? { keys: camera.keys.map(moved) } : {}) };
}

export function ShotFields({ shot, doc }: { shot: FilmShot; doc: ScenarioDocument }): ReactElement {
  const camera = find_camera(doc, shot.camera);
  const edit = (fields: Partial<Omit<FilmShot, 'id'>>): Command => ({ type: 'shot.set', id: shot.id, shot: fields });
  const number = (key: 'start' | 'length') => ({
    on_preview: (value: number | null) => preview(value === null ? null : edit({ [key]: value })),
    on_commit: (value: number) => send(edit({ [key]: value })),
  });
  return (
    <>
      <h3>
        Shot <span className="of">{camera?.name}</span>
      </h3>
      <ChoiceField label="Camera" value={shot.camera} choices={(doc.cameras ?? []).map((c) => [c.id, c.name])} on_commit={(id) => send(edit({ camera: id }))} />
      <NumberField label="Start" unit="s" value={shot.start} step={0.01} min={0} {...number('start')} />
      <NumberField label="Length" unit="s" value={shot.length} step={0.01} min={0.1} {...number('length')} />
      <p className="facts">Where shots overlap, the later one is shown. Exported pictures, videos and pages show the shots.</p>
      <div className="actions">
        <button type="button" onClick={() => session.seek(shot.start)}>Go to shot</button>
        <button type="button" onClick={() => session.set({ through: 'shots' })}>Look through the shots</button>
        {camera && <button type="button" onClick={() => session.select({ kind: 'camera', camera: camera.id })}>Edit the camera</button>}
        <button type="button" onClick={() => run('edit.remove')}>Delete</button>
      </div>
    </>
  );
}
