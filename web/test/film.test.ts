import { describe, expect, it } from 'vitest';
import { apply_command, type ScenarioDocument } from '../src/core/document';
import { shot_at, view_of, type FilmCamera } from '../src/core/film';
import { cut_shot, key_camera } from '../src/core/film_edits';
import { CameraRig } from '../src/view/camera';
import { sample_document } from './sample';

const view = { target: [0, 0, 0.9] as [number, number, number], azimuth: 0.7, elevation: 0.25, distance: 5, field_of_view: 0.6 };
const camera = (fields: Partial<FilmCamera> = {}): FilmCamera => ({ id: 'v1', name: 'Camera 1', ...view, ...fields });
const keyed = camera({ keys: [[1, 0, 5], [2, 1, 3], [4, 2.5, 2.5], [5, 2, 1]].map(([time, azimuth, distance]) => ({ ...view, time: time!, azimuth: azimuth!, distance: distance! })) });

describe('view_of', () => {
  it('is the view of the camera without keys', () => expect(view_of(camera(), 3)).toMatchObject(view));

  it('follows the monotone cubic between keys', () => {
    // the same values as in tests/content/film_test.cpp
    const azimuths = [0, 0.115423387097, 1.0, 1.479334677419, 2.347278225806, 2.25, 2.0];
    const distances = [5, 4.710304054054, 3.0, 2.828692917055, 2.66344361603, 1.691810344828, 1.0];
    [0.5, 1.25, 2, 2.5, 3.5, 4.5, 6].forEach((time, i) => {
      expect(view_of(keyed, time).azimuth).toBeCloseTo(azimuths[i]!, 10);
      expect(view_of(keyed, time).distance).toBeCloseTo(distances[i]!, 10);
    });
  });
});

describe('shots', () => {
  const doc: ScenarioDocument = { ...sample_document(), cameras: [camera(), camera({ id: 'v2' })], shots: [{ id: 'h1', camera: 'v1', start: 0, length: 3 }, { id: 'h2', camera: 'v2', start: 2, length: 4 }] };

  it('shows the shot that starts last', () => {
    expect([0, 1.99, 2, 5.99, 6].map((t) => shot_at(doc.shots, t)?.id)).toEqual(['h1', 'h1', 'h2', 'h2', undefined]);
  });

  it('cuts the shot at the playhead', () => {
    const after = apply_command(doc, cut_shot(doc, 4, 'v1', 'h3')!);
    expect(after.shots).toEqual([doc.shots![0], { id: 'h2', camera: 'v2', start: 2, length: 2 }, { id: 'h3', camera: 'v1', start: 4, length: 2 }]);
    expect(cut_shot(doc, 2, 'v1', 'h3')).toMatchObject({ type: 'shot.set', id: 'h2', shot: { camera: 'v1' } });
  });

  it('makes a shot to the next one or to the end where there is none', () => {
    const empty = { ...doc, shots: [{ id: 'h1', camera: 'v1', start: 5, length: 1 }] };
    expect(cut_shot(empty, 2, 'v2', 'h2')).toMatchObject({ type: 'shot.add', shot: { start: 2, length: 3 } });
    expect(cut_shot(empty, 7, 'v2', 'h2')).toMatchObject({ shot: { start: 7, length: doc.duration - 7 } });
  });
});

describe('key_camera', () => {
  it('keys the view, by the smaller turn from the key before', () => {
    const keys = key_camera(keyed, 6, { ...view, azimuth: 2 - 2 * Math.PI + 0.5 });
    expect(keys).toHaveLength(5);
    expect(keys[4]!.azimuth).toBeCloseTo(2.5, 9);
  });
  it('replaces the key at the same time', () => {
    const keys = key_camera(keyed, 2, { ...view, azimuth: 1.2 });
    expect(keys.map((k) => k.time)).toEqual([1, 2, 4, 5]);
    expect(keys[1]!.azimuth).toBeCloseTo(1.2, 9);
  });
});

describe('looking through a camera', () => {
  it('places the view at the camera and returns', () => {
    const rig = new CameraRig();
    rig.resize(16 / 9);
    const before = { ...rig.current };
    rig.look_through({ ...view, target: [1, 2, 1], azimuth: 0, elevation: 0, distance: 2 }, { x: 10, y: 0 });
    expect(rig.camera.position.toArray().map((v) => Math.round(v * 1e6) / 1e6)).toEqual([13, 2, 1]);
    expect(rig.perspective.fov).toBeCloseTo((0.6 * 180) / Math.PI, 6);
    rig.look_through(null);
    expect(rig.current.distance).toBe(before.distance);
    expect(rig.perspective.fov).toBeCloseTo(36, 6);
  });

  it('shows the whole picture in a narrow view', () => {
    const rig = new CameraRig();
    rig.resize(1);
    rig.look_through(view);
    expect(rig.film_frame!.width).toBeCloseTo(1, 9);
    expect(rig.film_frame!.height).toBeCloseTo(9 / 16, 9);
    rig.resize(3);
    rig.film_border = 1.25;
    rig.look_through(view);
    expect(rig.film_frame!.height).toBeCloseTo(0.8, 9);
  });

  it('leaves the camera when the user moves the view', () => {
    const rig = new CameraRig();
    let left = 0;
    rig.on_leave = () => left++;
    rig.look_through(view);
    rig.turn(0.1, 0);
    rig.zoom(1.1);
    expect(left).toBe(1);
    expect(rig.film_frame).toBeNull();
    expect(rig.field_of_view).toBe(0.6);
  });
});
