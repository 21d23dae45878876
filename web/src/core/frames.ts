/** Binary frames of the service (docs/studio-protocol.md) and the ring that keeps the latest of them. */

export const frame_magic = 0x46474b55;
export const frame_version = 1;
const header_bytes = 64;
const character_floats = 14;
const pose_floats = 7;
const contact_floats = 8;
const normal_floats = 3;
const nearest_floats = 8;

export const enum FigureState {
  tracking = 0,
  let_go = 1,
  passive = 2,
  edit = 3,
}

/** One character of a frame; offsets count floats in `Frame.floats`. */
export interface FigureFrame {
  links: number;
  state: FigureState;
  /** Index of the first pose: 7 floats a link, position xyz m and quaternion wxyz. */
  poses: number;
  /** Index of: assist force xyz, assist moment xyz, assist / cap, body weight, centre of mass xyz. */
  data: number;
}

/** A decoded frame: views into the message's own bytes, nothing copied. */
export interface Frame {
  time: number;
  number: number;
  playing: boolean;
  simulate: boolean;
  live: boolean;
  grabbing: boolean;
  figures: FigureFrame[];
  floats: Float32Array;
  words: Uint32Array;
  /** Index of the grab point xyz, then its target xyz. */
  grab: number;
  /** Index of the first contact, 8 floats each: point xyz, force xyz, character (word), link (word). */
  contacts: number;
  contact_count: number;
  /** Index of the first contact's normal, 3 floats each, towards the link; -1: the frame has none. */
  normals: number;
  /** Index of the first pair of nearest points, 8 floats each: on a xyz, on b xyz (m), distance (m), characters a << 16 | b (word). */
  nearest: number;
  nearest_count: number;
}

/** Decodes one message, or says why it is none of ours. */
export function decode_frame(buffer: ArrayBuffer): Frame | string {
  if (buffer.byteLength < header_bytes) return `a frame of ${buffer.byteLength} bytes is shorter than its header`;
  if (buffer.byteLength % 4 !== 0) return `a frame of ${buffer.byteLength} bytes is not whole words`;
  const view = new DataView(buffer);
  if (view.getUint32(0, true) !== frame_magic) return 'not a frame: its first four bytes are not UKGF';
  const version = view.getUint32(4, true);
  if (version !== frame_version) return `frames of version ${version}, but this page reads version ${frame_version}: reload the page`;
  const flags = view.getUint32(20, true);
  const character_count = view.getUint32(24, true);
  const contact_count = view.getUint32(28, true);
  const words = new Uint32Array(buffer);
  const floats = new Float32Array(buffer);
  const figures: FigureFrame[] = [];
  let at = header_bytes / 4;
  for (let i = 0; i < character_count; i++) {
    if (at + character_floats > floats.length) return `the frame ends in character ${i} of ${character_count}`;
    const links = words[at]!;
    const state = words[at + 1]! as FigureState;
    const poses = at + character_floats;
    const next = poses + links * pose_floats;
    if (next > floats.length) return `the frame ends in the poses of character ${i} of ${character_count}`;
    figures.push({ links, state, data: at + 2, poses });
    at = next;
  }
  const contacts = at;
  const nearest_count = view.getUint32(56, true);
  const has_normals = view.getUint32(60, true) === 1;
  at += contact_count * contact_floats;
  if (at > floats.length) return `the frame ends in its ${contact_count} contacts`;
  const normals = has_normals ? at : -1;
  if (has_normals) at += contact_count * normal_floats;
  if (at + nearest_count * nearest_floats > floats.length) return `the frame ends in its ${nearest_count} nearest pairs`;
  return {
    time: view.getFloat64(8, true),
    number: view.getUint32(16, true),
    playing: (flags & 1) !== 0,
    simulate: (flags & 2) !== 0,
    live: (flags & 4) !== 0,
    grabbing: (flags & 8) !== 0,
    figures,
    floats,
    words,
    grab: 8,
    contacts,
    contact_count,
    normals,
    nearest: at,
    nearest_count,
  };
}

/** What the ring hands out about a figure without the reader knowing the layout. */
export const assist_force = (frame: Frame, figure: FigureFrame): [number, number, number] => [
  frame.floats[figure.data]!,
  frame.floats[figure.data + 1]!,
  frame.floats[figure.data + 2]!,
];
export const assist_over_cap = (frame: Frame, figure: FigureFrame): number => frame.floats[figure.data + 6]!;
export const body_weight = (frame: Frame, figure: FigureFrame): number => frame.floats[figure.data + 7]!;
export const centre_of_mass = (frame: Frame, figure: FigureFrame): [number, number, number] => [
  frame.floats[figure.data + 8]!,
  frame.floats[figure.data + 9]!,
  frame.floats[figure.data + 10]!,
];
export function link_position(frame: Frame, figure: FigureFrame, link: number): [number, number, number] {
  const at = figure.poses + link * pose_floats;
  return [frame.floats[at]!, frame.floats[at + 1]!, frame.floats[at + 2]!];
}

/**
 * The latest frames by frame number: what ghosts, trails and curves read. At most `capacity` frames; the oldest received goes first.
 * Cleared when what it holds is no longer what would play (another document, another mode).
 */
export class FrameRing {
  private readonly by_number = new Map<number, Frame>();
  private readonly listeners = new Set<(frame: Frame) => void>();
  latest: Frame | null = null;
  received = 0;

  constructor(private readonly capacity = 2400) {}

  push(frame: Frame): void {
    if (this.latest && this.latest.simulate !== frame.simulate) this.by_number.clear();
    this.by_number.delete(frame.number);
    this.by_number.set(frame.number, frame);
    if (this.by_number.size > this.capacity) {
      const oldest = this.by_number.keys().next();
      if (!oldest.done) this.by_number.delete(oldest.value);
    }
    this.latest = frame;
    this.received++;
    for (const listener of this.listeners) listener(frame);
  }

  clear(): void {
    this.by_number.clear();
    if (this.latest) this.by_number.set(this.latest.number, this.latest);
  }

  at(number: number): Frame | undefined {
    return this.by_number.get(number);
  }

  /** The frame nearest to `number` within `tolerance` frames. */
  near(number: number, tolerance: number): Frame | undefined {
    for (let d = 0; d <= tolerance; d++) {
      const found = this.by_number.get(number - d) ?? this.by_number.get(number + d);
      if (found) return found;
    }
    return undefined;
  }

  /** Numbers of the frames held, ascending. */
  numbers(): number[] {
    return [...this.by_number.keys()].sort((a, b) => a - b);
  }

  on_frame(listener: (frame: Frame) => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }
}
