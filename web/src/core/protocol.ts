/** Messages between the page and the service: docs/studio-protocol.md, type by type. */
import type { Breakpoint, BreakpointHit } from './circuit/breakpoints';
import type { LsiClass, PinType } from './circuit/classes';
import type { Change, Circuit } from './circuit/form';
import type { ValuesEvent } from './circuit/live';
import type { Command, ScenarioDocument } from './document';
import type { InputMessage } from './play_controls';

export interface Problem {
  code?: string;
  place?: string;
  message: string;
  remedy?: string;
}

export interface ServiceError {
  problems: Problem[];
}

export interface CharacterInfo {
  id: string;
  name: string;
  mechanism: string;
  /** Number of links, or their names: frames hold one pose for each. */
  links: number | string[];
  /** How fast the track still moves it where it ends, m/s. */
  end_speed?: number;
}

export interface ProjectInfo {
  path: string;
  name: string;
  unsaved: boolean;
}

export type Mode = 'edit' | 'simulate';

export interface Transport {
  mode: Mode;
  playing: boolean;
  speed: number;
  /** s */
  time: number;
  duration: number;
  /** s recorded so far in simulation */
  simulated: number;
  steps_per_s: number;
  realtime_factor: number;
  status: string;
}

export interface CharacterSummary {
  id: string;
  /** body weights, rms */
  assist_rms_bw: number;
  foot_skate_cm: number;
  tracking_rms_deg: number;
  penetration_mm: number;
  fell: boolean;
}

export interface ContactSpan {
  character: string;
  from: number;
  to: number;
  /** 0 flight, 1 one foot, 2 or more: both */
  feet: number;
}

export interface Summary {
  characters: CharacterSummary[];
  contacts: ContactSpan[];
}

export interface DocumentState {
  document: ScenarioDocument;
  revision: number;
  can_undo: boolean;
  can_redo: boolean;
  undo_label: string;
  redo_label: string;
  characters: CharacterInfo[];
  /** The circuit that the generator makes, where the document has none of its own. */
  generated_circuit?: Circuit | null;
}

export interface LsisEvent {
  pin_types?: PinType[];
  classes?: LsiClass[];
}

export interface HelloReply extends DocumentState {
  project: ProjectInfo;
  transport: Transport;
  /** What `remember` kept; of another version, or edited by hand: not to be trusted. */
  choices?: unknown;
  lsis?: LsisEvent | null;
  circuit_problems?: Problem[];
  stopped?: StoppedEvent | null;
  /** What the running circuit reads of keyboard, mouse and gamepads. */
  devices?: unknown;
  breakpoints?: Breakpoint[];
}

export interface StoppedEvent {
  reason: string;
  /** The same, each with its place: an LSI's flat id, an output of it, or something else. */
  problems?: Problem[];
}

export interface LogLine {
  level: 'info' | 'warning' | 'error';
  text: string;
}

export type ServiceEvent =
  | ({ event: 'document'; unsaved: boolean } & DocumentState)
  | ({ event: 'edited'; unsaved: boolean; from: number; changes: Change[] } & Omit<DocumentState, 'document' | 'generated_circuit'>)
  | ({ event: 'transport' } & Transport)
  | ({ event: 'summary' } & Summary)
  | ({ event: 'log' } & LogLine)
  | { event: 'library' }
  | ({ event: 'lsis' } & LsisEvent)
  | { event: 'devices' }
  | { event: 'breakpoints'; list: Breakpoint[] }
  | ({ event: 'breakpoint' } & BreakpointHit)
  | { event: 'circuit'; problems: Problem[] }
  | ({ event: 'values' } & ValuesEvent)
  | ({ event: 'stopped' } & StoppedEvent);

export type Request =
  | { op: 'hello' }
  | { op: 'command'; command: Command }
  | { op: 'undo' | 'redo' | 'pause' | 'restart' | 'release' }
  | { op: 'save'; path?: string; overwrite?: boolean }
  | { op: 'remember'; choices: object }
  | { op: 'mode'; mode: Mode }
  | { op: 'play'; speed?: number }
  | { op: 'step'; frames: 1 | -1 }
  | { op: 'step'; ticks: 1 }
  | { op: 'breakpoints'; list: { condition: string; on: boolean }[] }
  | { op: 'seek'; time: number }
  | { op: 'grab'; character: string; link: number; point: Vec3; target: Vec3 }
  | { op: 'drag'; target: Vec3 }
  | { op: 'watch'; pins: string[]; probes: string[]; timing: boolean; nearest: boolean }
  | ({ op: 'input' } & InputMessage)
  | { op: 'push'; character: string; link: number; force: Vec3; duration: number }
  | MotionRequest
  | { op: 'motion.cancel'; task: string };

/** An operation on the motion of a clip; `motion` is the second one, the others say for which body. */
export interface MotionRequest {
  op: 'motion';
  task: string;
  character: string;
  clip: string;
  operation: string;
  options: object;
  motion?: string;
  mechanism?: string;
  height?: number;
  sample?: 'dog' | 'human';
}

export type Vec3 = [number, number, number];

export interface LibraryEntry {
  id: string;
  kind: 'mechanism' | 'motion';
  name: string;
  summary?: string;
  tags?: string[] | string;
  mechanism?: string;
  duration?: number;
  rate?: number;
  frames?: number;
  freedoms?: number;
  mass?: number;
  height?: number;
  cyclic?: boolean;
  created?: string;
  /** What the library calls it through all its versions; absent: it is in the open project only. */
  entry?: string;
  version?: number;
  note?: string;
  source?: string;
  /** Who saved its newest version, and when. */
  by?: string;
  changed?: string;
  size?: number;
  /** The library has a picture of it. */
  thumbnail?: boolean;
  /** When it was thrown into the trash; empty: it was not. */
  removed?: string;
}

export interface ShapeData {
  type: 'capsule' | 'sphere' | 'box' | 'cylinder' | 'ellipsoid' | 'mesh' | 'height_field';
  radius?: number;
  /** capsule, cylinder: centre to the centre of a cap or end, along the shape's z */
  half_length?: number;
  /** box; ellipsoid: its radii */
  half_extents?: Vec3;
  /** mesh, height field: which of the mechanism's surfaces */
  surface?: string;
  /** x, y, z, qw, qx, qy, qz in the link's frame */
  pose: number[];
}

export interface LinkData {
  name: string;
  label?: string;
  parent: number;
  joint: string;
  freedoms: number;
  shapes: ShapeData[];
  /** World pose in the neutral position: x, y, z, qw, qx, qy, qz. */
  neutral?: number[];
}

/** Packed: base64 of 32-bit floats x y z, and of 32-bit indices. */
export interface MeshSurface {
  vertices: string;
  triangles: string;
}

/** Heights packed row by row, x growing with the column, y with the row. */
export interface HeightFieldSurface {
  columns: number;
  rows: number;
  half_x: number;
  half_y: number;
  base: number;
  heights: string;
}

export interface MechanismData {
  id: string;
  name: string;
  freedoms: number;
  mass: number;
  height: number;
  /** Meshes and height fields that shapes refer to. */
  surfaces?: Record<string, MeshSurface | HeightFieldSurface>;
  links: LinkData[];
}

/** What went wrong in the words of the service; always with at least one problem. */
export class RequestError extends Error {
  readonly problems: Problem[];
  constructor(error: Partial<ServiceError> | undefined, fallback: string) {
    const problems = error?.problems?.length ? error.problems : [{ message: fallback }];
    super(problems[0]?.message ?? fallback);
    this.problems = problems;
  }
}
