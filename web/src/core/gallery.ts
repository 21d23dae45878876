/** The gallery of contents with which a new project can begin: name, one sentence, and how the content is made. */
import type { Command } from './document';

export interface GalleryEntry {
  /** Name of the picture in public/gallery and of the new file. */
  id: string;
  title: string;
  /** One sentence: what the content shows or teaches. */
  teaches: string;
  /** Content of the new project; a function loads it from the page's files. */
  from: 'empty' | 'sample' | (() => Promise<object>);
  /** Changes of the new project, applied as one undo step. */
  commands?: () => Command[];
}

const group = (label: string, commands: Command[]): Command[] => [{ type: 'group', label, commands }];

/** Leaves only the human of the sample content. */
const human_only: Command[] = [
  { type: 'character.remove', id: 'ball' },
  { type: 'character.remove', id: 'dog' },
];

function parade(): Command[] {
  const commands: Command[] = [...human_only];
  const colors = ['#e6e6ea', '#9fb7c9', '#c9a57b', '#8fb08c'];
  for (let i = 0; i < 12; i++) {
    const [row, column] = [Math.floor(i / 4), i % 4];
    const id = `walker${i + 1}`;
    const place = { x: -1.6 * row, y: 1.2 * (column - 1.5), z: 0, heading: 0 };
    commands.push({ type: 'character.add', id, name: `Walker ${i + 1}`, mechanism: 'human', color: colors[column]!, place });
    // rows start a quarter of a stride apart, so that not all step at once
    commands.push({ type: 'clip.add', character: id, id: `walk${i + 1}`, motion: 'human-walk', start: 0, length: 8, offset: 0.25 * row, speed: 1, blend: 0, loop: true });
  }
  commands.push({ type: 'character.remove', id: 'human' }, { type: 'scenario.set', name: 'parade', duration: 8, camera: { follow: 'walker6', distance: 9, azimuth: 0.6, elevation: 0.35 } });
  return group('Make parade', commands);
}

function pushes(): Command[] {
  const forces = [60, 120, 240];
  return group('Make push test', [
    ...human_only,
    ...forces.map((force, i): Command => ({ type: 'event.add', event: { id: `push${i + 1}`, type: 'push', time: 2 + 3 * i, duration: 0.2, character: 'human', link: 'chest', force: [0, force, 0] } })),
    ...forces.map((force, i): Command => ({ type: 'marker.add', id: `m${i + 1}`, time: 2 + 3 * i, name: `${force} N` })),
    { type: 'scenario.set', name: 'push test', duration: 12 },
  ]);
}

function rag_dolls(): Command[] {
  return group('Make rag dolls', [
    ...human_only,
    { type: 'character.remove', id: 'human' },
    ...[0, 1, 2].map((i): Command => ({
      type: 'character.add', id: `doll${i + 1}`, name: `Doll ${i + 1}`, mechanism: 'human', color: ['#e6e6ea', '#c9a57b', '#9fb7c9'][i]!,
      place: { x: 0.2 * i, y: 1.1 * (i - 1), z: 1.3 + 0.35 * i, heading: 60 * i }, control: { mode: 'passive' },
    })),
    { type: 'scenario.set', name: 'rag dolls', duration: 5, camera: { follow: 'doll2', distance: 5, azimuth: 0.8, elevation: 0.3 } },
  ]);
}

export const gallery: readonly GalleryEntry[] = [
  { id: 'empty', title: 'Empty', teaches: 'A floor and nothing else: drag characters and motions from the library.', from: 'empty' },
  { id: 'park', title: 'Walk in the park', teaches: 'A human walks, a dog trots, and a ball hits the human: clips, a throw, and balance.', from: 'sample' },
  { id: 'push-test', title: 'Push test', teaches: 'Three pushes of growing force, marked on the timeline: how much does the walk withstand?', from: 'sample', commands: pushes },
  { id: 'parade', title: 'Parade', teaches: 'Twelve walkers in formation: many characters, solo and mute of tracks.', from: 'sample', commands: parade },
  { id: 'rag-dolls', title: 'Rag dolls', teaches: 'Three bodies without control fall on the floor: passive drive, contacts and joint limits.', from: 'sample', commands: rag_dolls },
  { id: 'dominoes', title: 'Dominoes', teaches: 'One push tips a row of twenty stones: events and contacts between many bodies.', from: async () => (await import('../../../examples/content/dominoes.json')).default },
  { id: 'tower', title: 'Tower', teaches: 'A thrown ball knocks over a stack of blocks: resting contact and friction.', from: async () => (await import('../../../examples/content/tower.json')).default },
  { id: 'chain', title: 'Chain', teaches: 'A ball hits a hanging chain: a mechanism that is fixed to the world.', from: async () => (await import('../../../examples/content/chain.json')).default },
];
