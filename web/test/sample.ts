import type { ScenarioDocument } from '../src/core/document';

export function sample_document(): ScenarioDocument {
  const control = { mode: 'track' as const, tracking: 1, balance: 1, assist_limit: 0.5, beyond: 'release' };
  const clip = (id: string, start: number, length: number) => ({ id, motion: 'n-1', start, length, offset: 0, speed: 1, blend: 0.3, loop: false });
  return {
    version: 1,
    name: 'park',
    duration: 20,
    frame_rate: 60,
    step: 0.002,
    gravity: [0, 0, -9.81],
    ground: { height: 0, friction: 0.9, restitution: 0 },
    characters: [
      { id: 'human', name: 'Human', mechanism: 'm-1', color: '#e6e6ea', place: { x: 0, y: 0, z: 0, heading: 0 }, control, track: [clip('k1', 1, 2.2), clip('k2', 3, 2)] },
      { id: 'dog', name: 'Dog', mechanism: 'm-2', place: { x: 0, y: 1, z: 0, heading: 0 }, control, track: [] },
    ],
    events: [{ id: 'e1', type: 'push', time: 3.4, duration: 0.2, character: 'human', link: 'Chest', force: [150, 0, 0] }],
    camera: { follow: 'human', distance: 5, azimuth: 0.7, elevation: 0.25 },
    look: { light: 0.9, floor: '#2a2c31' },
    circuit: null,
  };
}
