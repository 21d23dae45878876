/**
 * The scenario document (docs/scenario.md) and its commands. The service owns the document. `apply_command` implements only the commands
 * that the page previews before the service has answered.
 */
import { apply_changes, type Change, type Circuit } from './circuit/form';
import type { FilmCamera, FilmShot } from './film';
import type { Look, Material } from './look';
import type { GaitRecipe } from './motion/gait';
import type { Vec3 } from './protocol';
import type { Prop } from './props';
import { edit_keys, type KeyedLayer, type KeyName, type KeyPut } from './posing/keys';
import type { StoredPose } from './posing/pose_library';
import type { Rule } from './rules';
import type { Variable, VariableFields } from './variables';

/** Place on the floor of a character's first frame, world frame, m. Without clips: place of its neutral pose. */
export interface Place {
  x: number;
  y: number;
  z: number;
  /** Rotation about the world's z axis, degrees. */
  heading: number;
}

export interface Control {
  mode: 'track' | 'passive' | 'path' | 'torque';
  /** Factor on the gains of the tracking controller, 0 ... 2. */
  tracking: number;
  /** Factor on the gains of the balance controller, 0 ... 2. */
  balance: number;
  /** Cap of the root-assist wrench, body weights. */
  assist_limit: number;
  /** Amplitude to which the character swings while it hangs from its grips, degrees; absent: 0. Only without root assist. */
  swing?: number;
  /** Behaviour when the character has fallen: "release" switches control off. */
  beyond: string;
}

export interface Clip {
  id: string;
  motion: string;
  /** Start of the clip on the track, s. */
  start: number;
  /** Length of the clip on the track, s. */
  length: number;
  /** Time within the motion at which the clip starts, s at speed 1. */
  offset: number;
  speed: number;
  /** Length of the cross-fade from the previous clip, s. */
  blend: number;
  loop: boolean;
  /** Keys over the motion, applied in this order. Absent: there are none. */
  layers?: KeyedLayer[];
  /** Settings from which the service made the motion. Absent: a motion of the library. */
  gait?: GaitRecipe;
}

export interface Character extends Material {
  id: string;
  name: string;
  mechanism: string;
  color?: string;
  /** True: left out of playing, with its events. */
  muted?: boolean;
  /** True: characters that are not solo are left out of playing. */
  solo?: boolean;
  /** True: the service refuses commands that change the clips of the character or remove it. */
  locked?: boolean;
  /** Name of the group of tracks to which the character belongs in the timeline. */
  group?: string;
  place: Place;
  control: Control;
  track: Clip[];
  /** The character is a prop: the service makes its mechanism from these values. */
  prop?: Prop;
}

/** Axes in which the force of a push is given. */
export type PushAxes = 'world' | 'body';

export interface ScenarioEvent {
  id: string;
  type: string;
  /** Time of the event, s. */
  time: number;
  /** Duration of a push or a pull, s. */
  duration?: number;
  character?: string;
  link?: string;
  /** Force of a push, N. */
  force?: Vec3;
  /** Axes of the force: of the world, or of the pushed link, with which the force turns. Absent: world. */
  axes?: PushAxes;
  /** Start position of a thrown body, world frame, m. */
  from?: Vec3;
  /** Velocity of a thrown body, world frame, m/s. */
  velocity?: Vec3;
  /** Angular velocity of a thrown body, world frame, rad/s. */
  spin?: Vec3;
  /** Targets of a pull: time since its begin (s), x, y, z (m). */
  path?: [number, number, number, number][];
  /** Gripping or pulled point of a grab or a pull in the frame of the link, m. */
  point?: Vec3;
  /** Character and link that a grab grips; both empty: the world. */
  other?: string;
  other_link?: string;
  /** Gripped point in the frame of the other link, or in the world, m; null: the link grips where it is. */
  at?: Vec3 | null;
  /** True: the grip holds the orientation too. */
  rigid?: boolean;
  /** Force that opens a grip, N. */
  limit?: number;
  /** Maximum distance of the two points of a grip, m. */
  reach?: number;
}

/** A named time of the scenario, for snapping and jumping. */
export interface Marker {
  id: string;
  /** Time of the marker, s. */
  time: number;
  name: string;
}

/** In and out point of playing, s. */
export interface PlayRange {
  from: number;
  to: number;
}

/** An inner scenario that the scenario places in time and space. */
export interface ScenarioInstance {
  id: string;
  name: string;
  /** Id of an inner scenario of the document. */
  scenario: string;
  /** Time in this scenario at which the inner scenario begins, s. */
  start: number;
  place: Place;
  /** True: its characters are left out of playing. */
  muted?: boolean;
  solo?: boolean;
}

/** An inner scenario, as far as the page shows it from outside. The service makes a whole document of the one that is open. */
export interface InnerScenario {
  id: string;
  name: string;
  duration: number;
  characters: Character[];
  instances?: ScenarioInstance[];
}

export interface ScenarioDocument {
  version: number;
  name: string;
  /** Duration of the scenario, s. */
  duration: number;
  /** Display frames per second. */
  frame_rate: number;
  /** Time step of the dynamics, s. */
  step: number;
  /** Acceleration of gravity, world frame, m/s^2. */
  gravity: Vec3;
  ground: { height: number; friction: number; restitution: number };
  characters: Character[];
  events: ScenarioEvent[];
  /** Absent: there are none. */
  markers?: Marker[];
  /** By falling priority. Absent: there are none. */
  rules?: Rule[];
  /** In the order in which they are shown. Absent: there are none. */
  variables?: Variable[];
  /** Stored poses. Absent: there are none. */
  poses?: StoredPose[];
  /** Ids of characters in the order of their tracks; the others follow. Absent: the order of `characters`. */
  track_order?: string[];
  /** Absent or null: the whole scenario is played. */
  range?: PlayRange | null;
  camera?: { follow?: string | null; distance?: number; azimuth?: number; elevation?: number };
  look?: Look;
  /** Absent: there are none. */
  cameras?: FilmCamera[];
  /** Sorted by start. Absent: there are none. */
  shots?: FilmShot[];
  circuit?: Circuit | null;
  /** Placed inner scenarios. Absent: there are none. */
  instances?: ScenarioInstance[];
  /** Inner scenarios of the whole document, placed or not. Absent: there are none. */
  scenarios?: InnerScenario[];
}

export type ClipFields = Partial<Omit<Clip, 'id'>>;

export type Command =
  | ({ type: 'clip.add'; character: string; motion: string; start: number; id?: string } & ClipFields)
  | ({ type: 'clip.set'; character: string; id: string } & ClipFields)
  | { type: 'clip.remove'; character: string; id: string }
  | { type: 'clip.split'; character: string; id: string; time: number }
  | { type: 'layer.add'; character: string; clip: string; value: Partial<Omit<KeyedLayer, 'joints'>>; at?: number }
  | { type: 'layer.set'; character: string; clip: string; layer: string; value: Partial<Omit<KeyedLayer, 'id' | 'joints'>> }
  | { type: 'layer.remove'; character: string; clip: string; layer: string }
  | { type: 'layer.move'; character: string; clip: string; layer: string; at: number }
  | { type: 'key.edit'; character: string; clip: string; layer: string; take?: KeyName[]; put?: KeyPut[]; label?: string }
  | { type: 'character.add'; mechanism?: string; prop?: Partial<Prop>; id?: string; name?: string; place?: Partial<Place>; color?: string; shape_colors?: string[]; group?: string; control?: Partial<Control> }
  | { type: 'track.move'; character: string; at: number }
  | { type: 'pose.add'; pose: Omit<StoredPose, 'id'> & { id?: string }; at?: number }
  | { type: 'pose.set'; id: string; pose: Partial<Omit<StoredPose, 'id'>> }
  | { type: 'pose.remove'; id: string }
  | ({ type: 'character.set'; id: string } & Material & { prop?: Partial<Prop>; name?: string; color?: string; place?: Partial<Place>; control?: Partial<Control>; muted?: boolean; solo?: boolean; locked?: boolean; group?: string })
  | { type: 'character.remove'; id: string }
  | { type: 'event.add'; event: Omit<ScenarioEvent, 'id'> & { id?: string } }
  | { type: 'event.set'; id: string; event: Partial<Omit<ScenarioEvent, 'id' | 'type'>> }
  | { type: 'event.remove'; id: string }
  | { type: 'marker.add'; id?: string; time: number; name?: string }
  | { type: 'marker.set'; id: string; time?: number; name?: string }
  | { type: 'marker.remove'; id: string }
  | { type: 'rule.add'; rule: Omit<Rule, 'id'> & { id?: string }; at?: number }
  | { type: 'rule.set'; id: string; rule: Partial<Omit<Rule, 'id'>> }
  | { type: 'rule.move'; id: string; at: number }
  | { type: 'rule.remove'; id: string }
  | { type: 'variable.add'; variable: VariableFields & { id?: string } }
  | { type: 'variable.set'; id: string; variable: VariableFields }
  | { type: 'variable.remove'; id: string }
  | { type: 'camera.add'; camera: Partial<FilmCamera> }
  | { type: 'camera.set'; id: string; camera: Partial<Omit<FilmCamera, 'id'>> }
  | { type: 'camera.remove'; id: string }
  | { type: 'shot.add'; shot: FilmShot }
  | { type: 'shot.set'; id: string; shot: Partial<Omit<FilmShot, 'id'>> }
  | { type: 'shot.remove'; id: string }
  | ({ type: 'scenario.set' } & Partial<Omit<ScenarioDocument, 'version' | 'characters' | 'events' | 'rules' | 'variables' | 'poses' | 'track_order' | 'cameras' | 'shots' | 'circuit' | 'instances' | 'scenarios'>>)
  | { type: 'scenario.nest'; name: string; characters: string[]; instances?: string[] }
  | { type: 'scenario.remove'; id: string }
  | { type: 'instance.add'; scenario: string; id?: string; name?: string; start?: number; place?: Partial<Place>; muted?: boolean; solo?: boolean }
  | { type: 'instance.set'; id: string; name?: string; start?: number; place?: Partial<Place>; muted?: boolean; solo?: boolean }
  | { type: 'instance.remove' | 'instance.unnest'; id: string }
  | { type: 'circuit.set'; circuit: Circuit | null }
  | { type: 'circuit.edit'; label: string; changes: Change[] }
  | { type: 'group'; label: string; commands: Command[] };

export const find_character = (doc: ScenarioDocument, id: string): Character | undefined => doc.characters.find((c) => c.id === id);

export function find_clip(doc: ScenarioDocument, character: string, id: string): Clip | undefined {
  return find_character(doc, character)?.track.find((k) => k.id === id);
}

export const find_marker = (doc: ScenarioDocument, id: string): Marker | undefined => doc.markers?.find((m) => m.id === id);

/** True if the character is left out of playing: it is muted, or others are solo and it is not. */
export const is_left_out = (doc: ScenarioDocument, character: Character): boolean =>
  Boolean(character.muted) || (!character.solo && any_solo(doc));

const any_solo = (doc: ScenarioDocument): boolean => doc.characters.some((c) => c.solo) || Boolean(doc.instances?.some((i) => i.solo));

export const find_event = (doc: ScenarioDocument, id: string): ScenarioEvent | undefined => doc.events.find((e) => e.id === id);

/** The characters in the order of their tracks in the timeline. */
export function in_track_order(doc: ScenarioDocument): Character[] {
  const order = doc.track_order ?? [];
  const first = order.flatMap((id) => find_character(doc, id) ?? []);
  return [...first, ...doc.characters.filter((c) => !order.includes(c.id))];
}

/** The list with one more item, at index `at`. */
const with_item = <T>(list: readonly T[], at: number, item: T): T[] => [...list.slice(0, at), item, ...list.slice(at)];

/** Ids in the order of the tracks, after the track of `character` has moved to index `at`. */
function move_track(doc: ScenarioDocument, character: string, at: number): string[] {
  const ids = in_track_order(doc).map((c) => c.id).filter((id) => id !== character);
  return with_item(ids, Math.min(Math.max(0, at), ids.length), character);
}

/** End of the last clip or event, s. The "fit" command shows the time up to here, and a new clip starts here. */
export function content_end(doc: ScenarioDocument): number {
  let end = 0;
  for (const c of doc.characters) for (const k of c.track) end = Math.max(end, k.start + k.length);
  for (const e of doc.events) end = Math.max(end, e.time + (e.duration ?? 0));
  for (const i of doc.instances ?? []) end = Math.max(end, i.start + (doc.scenarios?.find((s) => s.id === i.scenario)?.duration ?? 0));
  return end;
}

/** End of the last clip on a character's track, s; 0 without clips. */
export function track_end(character: Character): number {
  return character.track.reduce((end, k) => Math.max(end, k.start + k.length), 0);
}

const map_layers = (doc: ScenarioDocument, { character, clip }: { character: string; clip: string }, change: (layers: KeyedLayer[]) => KeyedLayer[]): ScenarioDocument =>
  map_character(doc, character, (c) => ({ ...c, track: c.track.map((k) => (k.id === clip ? { ...k, layers: change(k.layers ?? []) } : k)) }));

const map_character = (doc: ScenarioDocument, id: string, change: (c: Character) => Character): ScenarioDocument => ({
  ...doc,
  characters: doc.characters.map((c) => (c.id === id ? change(c) : c)),
});

/**
 * The document as it will be if the service accepts `command`. A command whose result the page cannot predict returns `doc` unchanged.
 * @param generated the circuit to which edits apply if the document has no circuit of its own
 */
export function apply_command(doc: ScenarioDocument, command: Command, generated: Circuit | null = null): ScenarioDocument {
  switch (command.type) {
    case 'clip.set': {
      const { type: _type, character, id, ...fields } = command;
      return map_character(doc, character, (c) => ({ ...c, track: c.track.map((k) => (k.id === id ? { ...k, ...fields } : k)) }));
    }
    case 'layer.add': {
      const { id, name = '', mode = 'additive', weight = 1, ease_in = null, ease_out = null, on = true } = command.value;
      if (id === undefined) return doc;
      const layer: KeyedLayer = { id, name, mode, weight, ease_in, ease_out, ...(on ? {} : { on }), joints: [] };
      return map_layers(doc, command, (layers) => with_item(layers, command.at ?? layers.length, layer));
    }
    case 'layer.set':
      return map_layers(doc, command, (layers) => layers.map((l) => (l.id === command.layer ? { ...l, ...command.value } : l)));
    case 'layer.remove':
      return map_layers(doc, command, (layers) => layers.filter((l) => l.id !== command.layer));
    case 'layer.move':
      return map_layers(doc, command, (layers) => {
        const moved = layers.find((l) => l.id === command.layer);
        return moved ? with_item(layers.filter((l) => l !== moved), command.at, moved) : layers;
      });
    case 'key.edit':
      return map_layers(doc, command, (layers) => layers.map((l) => (l.id === command.layer ? edit_keys(l, command.take ?? [], command.put ?? []) : l)));
    case 'clip.add': {
      const { type: _type, character, id, offset, length, speed, blend, loop, motion, start, layers } = command;
      // the service fills in missing fields, and the page does not know their values
      if (id === undefined || offset === undefined || length === undefined || speed === undefined || blend === undefined || loop === undefined) return doc;
      const clip = { id, motion, start, length, offset, speed, blend, loop, ...(layers ? { layers } : {}) };
      return map_character(doc, character, (c) => ({ ...c, track: [...c.track, clip].sort((a, b) => a.start - b.start) }));
    }
    case 'clip.remove':
      return map_character(doc, command.character, (c) => ({ ...c, track: c.track.filter((k) => k.id !== command.id) }));
    case 'character.set': {
      const { type: _type, id, place, control, prop, ...fields } = command;
      return map_character(doc, id, (c) => ({ ...c, ...fields, place: { ...c.place, ...place }, control: { ...c.control, ...control }, ...(c.prop ? { prop: { ...c.prop, ...prop } } : {}) }));
    }
    case 'track.move':
      return { ...doc, track_order: move_track(doc, command.character, command.at) };
    case 'pose.add': {
      const { id } = command.pose;
      const poses = doc.poses ?? [];
      return id === undefined ? doc : { ...doc, poses: with_item(poses, command.at ?? poses.length, { ...command.pose, id }) };
    }
    case 'pose.set':
      return { ...doc, poses: (doc.poses ?? []).map((p) => (p.id === command.id ? { ...p, ...command.pose } : p)) };
    case 'pose.remove':
      return { ...doc, poses: (doc.poses ?? []).filter((p) => p.id !== command.id) };
    case 'instance.set': {
      const { type: _type, id, place, ...fields } = command;
      return { ...doc, instances: (doc.instances ?? []).map((i) => (i.id === id ? { ...i, ...fields, place: { ...i.place, ...place } } : i)) };
    }
    case 'instance.remove':
      return { ...doc, instances: (doc.instances ?? []).filter((i) => i.id !== command.id) };
    case 'character.remove':
      return { ...doc, characters: doc.characters.filter((c) => c.id !== command.id) };
    case 'event.set': {
      const { id, event } = command;
      return { ...doc, events: doc.events.map((e) => (e.id === id ? { ...e, ...event } : e)) };
    }
    case 'event.remove':
      return { ...doc, events: doc.events.filter((e) => e.id !== command.id) };
    case 'marker.add': {
      const markers = doc.markers ?? [];
      const { id, time, name = `Marker ${markers.length + 1}` } = command;
      return id === undefined ? doc : { ...doc, markers: [...markers, { id, time, name }].sort((a, b) => a.time - b.time) };
    }
    case 'marker.set': {
      const { type: _type, id, ...fields } = command;
      return { ...doc, markers: (doc.markers ?? []).map((m) => (m.id === id ? { ...m, ...fields } : m)) };
    }
    case 'marker.remove':
      return { ...doc, markers: (doc.markers ?? []).filter((m) => m.id !== command.id) };
    case 'rule.add': {
      const { id } = command.rule;
      if (id === undefined) return doc;
      const rules = [...(doc.rules ?? [])];
      rules.splice(command.at ?? rules.length, 0, { ...command.rule, id });
      return { ...doc, rules };
    }
    case 'rule.set':
      return { ...doc, rules: (doc.rules ?? []).map((r) => (r.id === command.id ? { ...r, ...command.rule } : r)) };
    case 'rule.move': {
      const moved = doc.rules?.find((r) => r.id === command.id);
      if (!moved) return doc;
      const rules = doc.rules!.filter((r) => r !== moved);
      rules.splice(command.at, 0, moved);
      return { ...doc, rules };
    }
    case 'rule.remove':
      return { ...doc, rules: (doc.rules ?? []).filter((r) => r.id !== command.id) };
    case 'variable.set':
      return { ...doc, variables: (doc.variables ?? []).map((v) => (v.id === command.id ? { ...v, ...command.variable } : v)) };
    case 'variable.remove':
      return { ...doc, variables: (doc.variables ?? []).filter((v) => v.id !== command.id) };
    case 'event.add': {
      const { id } = command.event;
      return id === undefined ? doc : { ...doc, events: [...doc.events, { ...command.event, id }].sort((a, b) => a.time - b.time) };
    }
    case 'camera.set':
      return { ...doc, cameras: (doc.cameras ?? []).map((c) => (c.id === command.id ? { ...c, ...command.camera } : c)) };
    case 'camera.remove':
      return { ...doc, cameras: (doc.cameras ?? []).filter((c) => c.id !== command.id), shots: (doc.shots ?? []).filter((s) => s.camera !== command.id) };
    case 'shot.add':
      return { ...doc, shots: [...(doc.shots ?? []), command.shot].sort((a, b) => a.start - b.start) };
    case 'shot.set':
      return { ...doc, shots: (doc.shots ?? []).map((s) => (s.id === command.id ? { ...s, ...command.shot } : s)).sort((a, b) => a.start - b.start) };
    case 'shot.remove':
      return { ...doc, shots: (doc.shots ?? []).filter((s) => s.id !== command.id) };
    case 'scenario.set': {
      const { type: _type, ...fields } = command;
      return { ...doc, ...fields };
    }
    case 'circuit.set':
      return { ...doc, circuit: command.circuit };
    case 'circuit.edit': {
      const circuit = doc.circuit ?? generated;
      return circuit ? { ...doc, circuit: apply_changes(circuit, command.changes) } : doc;
    }
    case 'group':
      return command.commands.reduce((d, c) => apply_command(d, c, generated), doc);
    default:
      return doc;
  }
}

const by_start = (track: readonly Clip[]): Clip[] => [...track].sort((a, b) => a.start - b.start);

/** Times of the cross-fades between the clips of one track as they are played, s. `into` is the id of the later clip, which blends in. */
export function blend_spans(track: readonly Clip[]): { from: number; to: number; into: string }[] {
  return by_start(track)
    .slice(1)
    .filter((clip) => clip.blend > 0)
    .map((clip) => ({ from: clip.start, to: clip.start + Math.min(clip.blend, clip.length), into: clip.id }));
}

/** Map from the id of each clip to the duration of its overlap with the previous clip on the track, s. */
function overlaps(track: readonly Clip[]): Map<string, number> {
  const sorted = by_start(track);
  return new Map(
    sorted.map((clip, i) => {
      const before = sorted[i - 1];
      return [clip.id, before ? Math.max(0, Math.min(before.start + before.length, clip.start + clip.length) - clip.start) : 0];
    }),
  );
}

const default_blend = 0.3; // s, cross-fade of a clip without overlap; the service uses the same value for new clips

/**
 * Commands that update the cross-fades of the clips whose overlap with the previous clip changed between `before` and `after`. The cross-fade
 * becomes as long as the overlap, or, if the overlap ends, at most `default_blend`.
 */
export function fit_blends(character: string, before: readonly Clip[], after: readonly Clip[]): Command[] {
  const was = overlaps(before);
  const now = overlaps(after);
  return after.flatMap((clip): Command[] => {
    const overlap = now.get(clip.id)!;
    const old = was.get(clip.id) ?? 0;
    if (Math.abs(overlap - old) < 1e-6) return [];
    const blend = overlap > 0 ? Math.round(overlap * 1e6) / 1e6 : Math.min(clip.blend, default_blend);
    return blend === clip.blend ? [] : [{ type: 'clip.set', character, id: clip.id, blend }];
  });
}

/** `command` with a longer duration of the scenario, in one undo step, if `end` (s) is after the scenario's end; otherwise `command`. */
export function with_room(doc: ScenarioDocument, command: Command, end: number, label: string): Command {
  if (end <= doc.duration + 1e-9) return command;
  return { type: 'group', label, commands: [{ type: 'scenario.set', duration: Math.round(end * 1e6) / 1e6 }, command] };
}

/** Time of the frame that is `frames` after (negative: before) the frame at `time`, within the scenario, s. */
export const frame_after = (doc: ScenarioDocument, time: number, frames: number): number =>
  Math.min(Math.max(0, (Math.round(time * doc.frame_rate) + frames) / doc.frame_rate), doc.duration);

const clearance = 0.9; // m, between the places of two characters: two humans with outstretched elbows do not touch

/** The place nearest to `wanted`, in steps of 1 m to the left or right, at which no other character stands. */
export function free_place(doc: ScenarioDocument, wanted: { x: number; y: number }): { x: number; y: number } {
  const is_free = (y: number): boolean => doc.characters.every((c) => Math.hypot(c.place.x - wanted.x, c.place.y - y) >= clearance);
  for (let step = 0; step <= doc.characters.length; step++)
    for (const y of [wanted.y + step, wanted.y - step]) if (is_free(y)) return { x: wanted.x, y };
  return wanted;
}

/** `name` with the smallest number that no character has: "Human 2" for a copy of "Human" or of "Human 2". */
export function free_name(doc: ScenarioDocument, name: string): string {
  const used = new Set(doc.characters.map((c) => c.name));
  if (!used.has(name)) return name;
  const stem = name.replace(/ \d+$/, '');
  let n = 2;
  while (used.has(`${stem} ${n}`)) n++;
  return `${stem} ${n}`;
}
