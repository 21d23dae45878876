/** The gallery of contents with which a new project can begin: name, one sentence, and where the content comes from. */

export interface GalleryEntry {
  /** Name of the picture in public/gallery and of the new file. */
  id: string;
  title: string;
  /** One sentence: what the content teaches. */
  teaches: string;
  /** Content of the new project; a function loads it from the page's files. */
  from: 'empty' | 'sample' | (() => Promise<object>);
}

export const gallery: readonly GalleryEntry[] = [
  { id: 'empty', title: 'Empty', teaches: 'An empty floor: drag characters and motions from the library onto it.', from: 'empty' },
  { id: 'park', title: 'Walk in the park', teaches: 'A human walks, a dog trots, and a ball hits the human: clips, a throw, and balance.', from: 'sample' },
  { id: 'push-test', title: 'Walk with pushes', teaches: 'Three pushes of growing force, with markers: how much does a walk withstand?', from: async () => (await import('../../../examples/content/push-test.json')).default },
  { id: 'bar', title: 'Two hands on a bar', teaches: 'A gymnast hangs, swings by the legs alone, releases the bar and lands, without root assist.', from: async () => (await import('../../../examples/content/bar.json')).default },
  { id: 'cyclist', title: 'Cyclist', teaches: 'Feet turn pedals, crank, chain and wheel: closed loops through both legs, moved by the drives of the legs alone.', from: async () => (await import('../../../examples/content/cyclist.json')).default },
  { id: 'box-by-two', title: 'A box carried by two', teaches: 'Two people carry 40 kg without root assist, and one of them is pushed: grips, loads and generated gaits.', from: async () => (await import('../../../examples/content/box-by-two.json')).default },
  { id: 'hill', title: 'Over a hill', teaches: 'A human walks over ramps and a platform without root assist; a ball bounces down the stairs: props, fixed and moving.', from: async () => (await import('../../../examples/content/hill.json')).default },
  { id: 'hills', title: 'Over hills', teaches: 'A human walks over the hills of a terrain without root assist, and is pushed from behind in the axes of the chest; a ball rolls into a hollow.', from: async () => (await import('../../../examples/content/hills.json')).default },
  { id: 'rider', title: 'Rider', teaches: 'Two mechanisms become one: a rider on a dog as large as a horse, posed by a keyed layer.', from: async () => (await import('../../../examples/content/rider.json')).default },
  { id: 'riding', title: 'Rider with reins', teaches: 'A rider without root assist on a walking mount: seat, stirrups and reins are grips that move with it.', from: async () => (await import('../../../examples/content/riding.json')).default },
  { id: 'jansen', title: 'Theo Jansen’s walker', teaches: 'One motor and 24 closed loops walk: hold W or S to change its speed.', from: async () => (await import('../../../examples/content/jansen.json')).default },
  { id: 'andrews', title: 'Andrews’ squeezer', teaches: 'A benchmark of seven bodies and three loops; its spring is a circuit.', from: async () => (await import('../../../examples/content/andrews.json')).default },
  { id: 'five-bar', title: 'Robot of five bars', teaches: 'Two motors lead a tool along an eight; joints without effort are free.', from: async () => (await import('../../../examples/content/five-bar.json')).default },
  { id: 'duet', title: 'One duet, three times', teaches: 'A pair walks in two bows, placed at three times and places: open the nested scenario, and a change acts in all three.', from: async () => (await import('../../../examples/content/duet.json')).default },
  { id: 'band', title: 'Marching band', teaches: 'A hundred players in ranks with phases, and a leader: many characters and groups of tracks.', from: async () => (await import('../../../examples/content/band.json')).default },
  { id: 'retargeting', title: 'Retargeting', teaches: 'One walk on four bodies: a human, a child, a giant and a dog.', from: async () => (await import('../../../examples/content/retargeting.json')).default },
  { id: 'doll', title: 'Dolls with a skin', teaches: 'A glTF file brings a surface that is bound to bones: one doll waves as in its file, the other walks by a computed gait.', from: async () => (await import('../../../examples/content/doll.json')).default },
  { id: 'paths', title: 'Drawn paths', teaches: 'A human, a child and a dog walk without measured data: select a clip and drag the points of its path.', from: async () => (await import('../../../examples/content/paths.json')).default },
  { id: 'natural', title: 'Measured to natural', teaches: 'A noisy capture beside its physics correction: compare both in the panel Naturalness.', from: async () => (await import('../../../examples/content/natural.json')).default },
  { id: 'own-lsi', title: 'Your own LSI', teaches: 'A circuit of your own balances a pole on a cart, and withstands two pushes.', from: async () => (await import('../../../examples/content/own-lsi.json')).default },
  { id: 'fmu', title: 'FMU inside', teaches: 'A component that drives a pendulum; export it as an FMU, and use the FMU in its place.', from: async () => (await import('../../../examples/content/fmu.json')).default },
  { id: 'game', title: 'A game with keys', teaches: 'Rules: W walks, D lets the dog trot, Space kicks the ball at the pins.', from: async () => (await import('../../../examples/content/game.json')).default },
  { id: 'rag-dolls', title: 'Rag dolls', teaches: 'Three bodies without control fall on the floor: passive drive, contacts and joint limits.', from: async () => (await import('../../../examples/content/rag-dolls.json')).default },
  { id: 'dominoes', title: 'Dominoes', teaches: 'One push tips a row of twenty stones: events and contacts between many bodies.', from: async () => (await import('../../../examples/content/dominoes.json')).default },
  { id: 'tower', title: 'Tower', teaches: 'A thrown ball knocks over a stack of blocks: resting contact and friction.', from: async () => (await import('../../../examples/content/tower.json')).default },
  { id: 'chain', title: 'Chain', teaches: 'A ball hits a hanging chain: a mechanism that is fixed to the world.', from: async () => (await import('../../../examples/content/chain.json')).default },
];
