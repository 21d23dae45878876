/** Decoder of the service's binary frames (docs/studio-protocol.md), and the ring that keeps the latest frames. */

export const frame_magic = 0x46474b55;
export const frame_version = 1;
const header_bytes = 64;
const character_floats = 14;
const pose_floats = 7;
const contact_floats = 8;
const normal_floats = 3;
const closest_floats = 8;

/** Control state of a character in a frame. */
export const enum CharacterState {
  /** The controller follows the track. */
  tracking = 0,
  /** The character fell or lost its reference, so control was released: the character is a ragdoll. */
  released = 1,
  /** The character is a passive body without control. */
  passive = 2,
  /** Edit mode: the pose comes from the track, without physics. */
  edit = 3,
}

/**
 * Where the values of one character are in a frame. Offsets are indices into `Frame.floats`. Consecutive frames with the same numbers of links
 * share these objects.
 */
export interface CharacterFrame {
  readonly links: number;
  /** Index of the first link pose. Each link has 7 floats: position xyz (m), quaternion wxyz. */
  readonly poses: number;
  /** Index of the first value: assist force xyz (N), assist moment xyz (N m), assist / cap, body weight (N), centre of mass xyz (m). */
  readonly data: number;
}

/** A decoded frame. `floats` and `words` are views of the message's bytes; nothing is copied. */
export interface Frame {
  /** Simulated time of the frame, s. */
  time: number;
  /** Frame number: time times the document's frame rate, rounded. */
  number: number;
  playing: boolean;
  simulate: boolean;
  live: boolean;
  grabbing: boolean;
  characters: readonly CharacterFrame[];
  floats: Float32Array;
  words: Uint32Array;
  /** Index of the grabbed point xyz (m), followed by its target xyz (m). */
  grab: number;
  /** Index of the first contact, 8 values each: point xyz (m), force xyz (N), character (word), link (word). */
  contacts: number;
  contact_count: number;
  /** Index of the first contact normal, 3 floats each, unit vector towards the link; -1 if the frame has no normals. */
  normals: number;
  /** Index of the first closest pair, 8 values each: point on a xyz, point on b xyz (m), distance (m), characters a << 16 | b (word). */
  closest: number;
  closest_count: number;
}

/** The layout of the last decoded frame. */
let last_layout: readonly CharacterFrame[] = [];

/** Whether the frame has the characters of `last_layout`. */
function has_last_layout(words: Uint32Array, count: number): boolean {
  if (count !== last_layout.length) return false;
  for (const character of last_layout) if (character.poses + character.links * pose_floats > words.length || words[character.data - 2] !== character.links) return false;
  return true;
}

/** Decodes one binary message. @return the frame, or a sentence that states why the message is not a valid frame */
export function decode_frame(buffer: ArrayBuffer): Frame | string {
  if (buffer.byteLength < header_bytes) return `The frame has ${buffer.byteLength} bytes; its header alone has ${header_bytes}.`;
  if (buffer.byteLength % 4 !== 0) return `The frame has ${buffer.byteLength} bytes, which is not a multiple of 4.`;
  const view = new DataView(buffer);
  if (view.getUint32(0, true) !== frame_magic) return 'The message is not a frame: its first four bytes are not UKGF.';
  const version = view.getUint32(4, true);
  if (version !== frame_version) return `The frame has version ${version}, but this page reads version ${frame_version}. Reload the page.`;
  const flags = view.getUint32(20, true);
  const character_count = view.getUint32(24, true);
  const contact_count = view.getUint32(28, true);
  const words = new Uint32Array(buffer);
  const floats = new Float32Array(buffer);
  let at = header_bytes / 4;
  if (has_last_layout(words, character_count)) {
    const last = last_layout.at(-1);
    if (last) at = last.poses + last.links * pose_floats;
  } else {
    const characters: CharacterFrame[] = [];
    for (let i = 0; i < character_count; i++) {
      if (at + character_floats > floats.length) return `The frame ends in character ${i} of ${character_count}.`;
      const links = words[at]!;
      const poses = at + character_floats;
      const next = poses + links * pose_floats;
      if (next > floats.length) return `The frame ends in the poses of character ${i} of ${character_count}.`;
      characters.push({ links, data: at + 2, poses });
      at = next;
    }
    last_layout = characters;
  }
  const contacts = at;
  const closest_count = view.getUint32(56, true);
  const has_normals = view.getUint32(60, true) === 1;
  at += contact_count * contact_floats;
  if (at > floats.length) return `The frame ends in its ${contact_count} contacts.`;
  const normals = has_normals ? at : -1;
  if (has_normals) at += contact_count * normal_floats;
  if (at + closest_count * closest_floats > floats.length) return `The frame ends in its ${closest_count} closest pairs.`;
  return {
    time: view.getFloat64(8, true),
    number: view.getUint32(16, true),
    playing: (flags & 1) !== 0,
    simulate: (flags & 2) !== 0,
    live: (flags & 4) !== 0,
    grabbing: (flags & 8) !== 0,
    characters: last_layout,
    floats,
    words,
    grab: 8,
    contacts,
    contact_count,
    normals,
    closest: at,
    closest_count,
  };
}

// Accessors that hide the layout of a character's data from the readers of a frame.

export const state_of = (frame: Frame, character: CharacterFrame): CharacterState => frame.words[character.data - 1] as CharacterState;
/** Root-assist force on a character, world frame, N. */
export const assist_force = (frame: Frame, character: CharacterFrame): [number, number, number] => [
  frame.floats[character.data]!,
  frame.floats[character.data + 1]!,
  frame.floats[character.data + 2]!,
];
/** Root assist as a fraction of its cap; 1 at the cap. */
export const assist_over_cap = (frame: Frame, character: CharacterFrame): number => frame.floats[character.data + 6]!;
/** Applied root assist, force and moment together, as a fraction of its cap: from 0 to 1. */
export const assist_of_cap = (frame: Frame, character: CharacterFrame): number => Math.min(1, Math.max(0, assist_over_cap(frame, character)));
/** Body weight of a character, N. */
export const body_weight = (frame: Frame, character: CharacterFrame): number => frame.floats[character.data + 7]!;
/** Centre of mass of a character, world frame, m; without mass (fixed props) the origin of its first link. */
export const centre_of_mass = (frame: Frame, character: CharacterFrame): [number, number, number] => {
  if (body_weight(frame, character) === 0 && character.links > 0) return link_position(frame, character, 0);
  return [frame.floats[character.data + 8]!, frame.floats[character.data + 9]!, frame.floats[character.data + 10]!];
};
/** Origin of link `link` of a character, world frame, m. */
export function link_position(frame: Frame, character: CharacterFrame, link: number): [number, number, number] {
  const at = character.poses + link * pose_floats;
  return [frame.floats[at]!, frame.floats[at + 1]!, frame.floats[at + 2]!];
}

/** Rotation of link `link` of a character: unit quaternion qw qx qy qz from the link's axes to those of the world. */
export function link_rotation(frame: Frame, character: CharacterFrame, link: number): [number, number, number, number] {
  const at = character.poses + link * pose_floats + 3;
  return [frame.floats[at]!, frame.floats[at + 1]!, frame.floats[at + 2]!, frame.floats[at + 3]!];
}

/**
 * The latest frames by frame number, read by ghosts, trails and curves. It keeps at most `capacity` frames and `max_bytes` bytes, and drops
 * the frames that were received first. It is cleared when the document or the mode changes, because its frames then no longer match what would play.
 */
export class FrameRing {
  private readonly by_number = new Map<number, Frame>();
  private readonly listeners = new Set<(frame: Frame) => void>();
  latest: Frame | null = null;
  received = 0;
  private bytes = 0;

  constructor(private readonly capacity = 2400, private readonly max_bytes = 64 * 1024 * 1024) {}

  push(frame: Frame): void {
    if (this.latest && this.latest.simulate !== frame.simulate) this.drop_all();
    this.drop(frame.number);
    this.by_number.set(frame.number, frame);
    this.bytes += frame.floats.byteLength;
    while (this.by_number.size > 1 && (this.by_number.size > this.capacity || this.bytes > this.max_bytes)) this.drop(this.by_number.keys().next().value!);
    this.latest = frame;
    this.received++;
    for (const listener of this.listeners) listener(frame);
  }

  clear(): void {
    this.drop_all();
    if (!this.latest) return;
    this.by_number.set(this.latest.number, this.latest);
    this.bytes = this.latest.floats.byteLength;
  }

  /** Forgets all frames: they belong to another project. */
  reset(): void {
    this.latest = null;
    this.drop_all();
  }

  private drop_all(): void {
    this.by_number.clear();
    this.bytes = 0;
  }

  private drop(number: number): void {
    const frame = this.by_number.get(number);
    if (!frame) return;
    this.by_number.delete(number);
    this.bytes -= frame.floats.byteLength;
  }

  at(number: number): Frame | undefined {
    return this.by_number.get(number);
  }

  /** The frame with the number closest to `number`, at most `tolerance` frames away. */
  near(number: number, tolerance: number): Frame | undefined {
    for (let d = 0; d <= tolerance; d++) {
      const found = this.by_number.get(number - d) ?? this.by_number.get(number + d);
      if (found) return found;
    }
    return undefined;
  }

  /** Numbers of the frames in the ring, ascending. */
  numbers(): number[] {
    return [...this.by_number.keys()].sort((a, b) => a - b);
  }

  /** Calls `listener` with each new frame. @return a function that removes the listener */
  on_frame(listener: (frame: Frame) => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }
}
