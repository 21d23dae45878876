/** Types of the messages between the page and the service (docs/studio-protocol.md). */
import type { Breakpoint, BreakpointHit } from './circuit/breakpoints';
import type { LsiClass, PinType } from './circuit/classes';
import type { Change, Circuit } from './circuit/form';
import type { ValuesEvent } from './circuit/live';
import type { Command, ScenarioDocument } from './document';
import type { Material } from './look';
import type { InputMessage } from './play_controls';
import type { MeshFacts } from './props';

/** One problem that the service or the page reports to the user. */
export interface Problem {
  code?: string;
  /** Where the problem is: file and line, JSON path, or an LSI or pin with its path ("arm/elbow.out"). */
  location?: string;
  message: string;
  remedy?: string;
}

/** An installed library of LSIs that the open project uses (GET /api/export/libraries). */
export interface UsedLibrary {
  name: string;
  sha256: string;
  bytes: number;
}

export interface ServiceError {
  problems: Problem[];
}

export interface CharacterInfo {
  id: string;
  name: string;
  mechanism: string;
  /** Number of links, or their names. A frame has one pose for each link. */
  links: number | string[];
  /** Speed of the character at the end of its track, m/s. */
  end_speed?: number;
  /** Colours and materials of a character of an instance, which the document does not list. Absent: a character of the document itself. */
  look?: Material & { color?: string };
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
  /** Playback speed; 1 is real time. */
  speed: number;
  /** True: playing continues at the begin of the range when it reaches the end. */
  loop: boolean;
  /** Time of the playhead, s. */
  time: number;
  /** Duration of the scenario, s. */
  duration: number;
  /** Length of the simulation recorded so far, s. */
  simulated: number;
  steps_per_s: number;
  realtime_factor: number;
  status: string;
}

export interface CharacterSummary {
  id: string;
  /** RMS of the root-assist force, body weights. */
  assist_rms_bw: number;
  foot_skate_cm: number;
  tracking_rms_deg: number;
  penetration_mm: number;
  fell: boolean;
}

/** A time span in which the number of feet on the ground does not change. */
export interface ContactSpan {
  character: string;
  /** Begin of the span, s. */
  from: number;
  /** End of the span, s. */
  to: number;
  /** Number of feet on the ground; 0: the character is in the air. */
  feet: number;
}

/** A measure of naturalness with its limits. null: no limit on this side. */
export interface MeasureInfo {
  /** Name with unit, as in CSV tables and in the JSON output of `ugoki judge`. */
  key: string;
  name: string;
  unit: string;
  /** How the value of the run follows from the values over time. */
  total: 'rms' | 'mean' | 'maximum' | 'share';
  digits: number;
  /** Limits of the value of the run: bad below `low` and above `high`, good from `good_low` to `good_high`. */
  low: number | null;
  good_low: number | null;
  good_high: number | null;
  high: number | null;
  /** Limits of the values over time. */
  now_low: number | null;
  now_high: number | null;
  /** True: the limits over time hold for root mean squares over 0.25 s. */
  smooth: boolean;
  meaning: string;
}

/** Measures of one character in consecutive recorded frames. */
export interface MeasureSamples {
  id: string;
  /** For each measure with values in these frames: one value for each frame; null: no value. */
  values: Record<string, (number | null)[]>;
  /** For each measure the value since time 0, or the reason why there is none. */
  totals: Record<string, number | string>;
}

export interface MeasuresEvent {
  /** Recorded frames per second. */
  rate: number;
  /** Index of the first frame of this event. The values of this and later frames that the page has are outdated. */
  from: number;
  /** Number of frames of this event. */
  frames: number;
  /** All measures; only in events from frame 0. */
  list?: MeasureInfo[];
  characters: MeasureSamples[];
}

export interface RecentProject {
  path: string;
  name: string;
}

export interface Summary {
  characters: CharacterSummary[];
  contacts: ContactSpan[];
}

export interface DocumentState {
  document: ScenarioDocument;
  /** Ids of the inner scenarios through which the user came to `document`. Absent in `edited`: unchanged. */
  open?: string[];
  /** Name of the outermost scenario. */
  outermost?: string;
  revision: number;
  can_undo: boolean;
  can_redo: boolean;
  undo_label: string;
  redo_label: string;
  characters: CharacterInfo[];
  /** The generated circuit. It runs when the document has no circuit of its own. */
  generated_circuit?: Circuit | null;
}

export interface LsisEvent {
  pin_types?: PinType[];
  classes?: LsiClass[];
}

export interface HelloReply extends DocumentState {
  project: ProjectInfo;
  transport: Transport;
  /** Choices stored by `remember`. Another version or a person may have written them, so validate them (read_choices). */
  choices?: unknown;
  recent?: RecentProject[];
  lsis?: LsisEvent | null;
  circuit_problems?: Problem[];
  stopped?: StoppedEvent | null;
  /** The keyboard keys, mouse and gamepads that the running circuit reads. Validate it with read_devices. */
  devices?: unknown;
  breakpoints?: Breakpoint[];
}

export interface StoppedEvent {
  reason: string;
  /** The problems that `reason` summarises. Each location is an LSI with its path ("arm/elbow"), one of its outputs, or other text. */
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
  | ({ event: 'measures' } & MeasuresEvent)
  /** Another project was opened in place of the open one. */
  | { event: 'opened' }
  | ({ event: 'log'; notice?: boolean } & LogLine)
  | { event: 'library' }
  | ({ event: 'lsis' } & LsisEvent)
  | { event: 'devices' }
  | { event: 'breakpoints'; list: Breakpoint[] }
  | ({ event: 'breakpoint' } & BreakpointHit)
  | { event: 'circuit'; problems: Problem[] }
  | ({ event: 'values' } & ValuesEvent)
  | ({ event: 'recorded' } & RecordedEvent)
  | ({ event: 'pulled' } & PulledEvent)
  | ({ event: 'stopped' } & StoppedEvent);

export type Request =
  | { op: 'hello' }
  /** @param scenario id of the inner scenario in which the command acts; absent: the document */
  | { op: 'command'; command: Command; scenario?: string }
  | { op: 'enter'; path: readonly string[] }
  | { op: 'undo' | 'redo' | 'pause' | 'restart' | 'release' }
  | { op: 'save'; path?: string; overwrite?: boolean }
  | { op: 'open'; path: string }
  | { op: 'new'; path: string; from: 'empty' | 'sample' | object }
  | { op: 'loop'; on: boolean }
  | { op: 'remember'; choices: object }
  | { op: 'mode'; mode: Mode }
  | { op: 'play'; speed?: number }
  | { op: 'step'; frames: 1 | -1 }
  | { op: 'step'; ticks: 1 }
  | { op: 'breakpoints'; list: { condition: string; on: boolean }[] }
  | { op: 'seek'; time: number }
  | { op: 'grab'; character: string; link: number; point: Vec3; target: Vec3 }
  | { op: 'drag'; target: Vec3 }
  | { op: 'forget_pull'; time: number }
  | { op: 'compare'; character: string; clip: string; before: object }
  | { op: 'watch'; pins: string[]; probes: string[]; timing: boolean; closest: boolean }
  | ({ op: 'input' } & InputMessage)
  | { op: 'push'; character: string; link: number; force: Vec3; duration: number }
  | MotionRequest
  | GaitMakeRequest
  | { op: 'gaits'; character: string; clip?: string }
  | PoseRequest
  | { op: 'curves'; character: string; clip: string; links: string[] }
  | { op: 'joints' | 'poses'; mechanism: string }
  | { op: 'recorded'; character: string; links: string[] }
  | { op: 'motion.cancel'; task: string };

/**
 * An operation on the motion of a clip. `motion` names the second motion; `mechanism`, `height` or `sample` selects the target body.
 */
export interface MotionRequest {
  op: 'motion';
  task: string;
  character: string;
  clip: string;
  operation: string;
  options: object;
  motion?: string;
  mechanism?: string;
  /** Height of a human target body, m. */
  height?: number;
  sample?: 'dog' | 'human';
}

/** Makes the motion of a clip from a recipe; without `clip`, a new clip plays it from `start` (s) on. */
export interface GaitMakeRequest {
  op: 'gait';
  task: string;
  character: string;
  clip?: string;
  start?: number;
  gait?: object;
}

/** A change of a pose. Links are given by their index. */
export type PoseEdit =
  | { type: 'turn'; link: number; axis: Vec3; angle: number }
  | { type: 'set'; link: number; dof: number; value: number }
  | { type: 'reach'; link: number; point: Vec3; target: Vec3; moves: 'limb' | 'body' }
  /** A drag with dynamics: its requests have the id `drag` in common. `seconds`: time since the last one, at most 0.1. */
  | { type: 'reach'; link: number; point: Vec3; target: Vec3; moves: 'physics'; drag?: string; seconds?: number }
  | { type: 'mirror' }
  /** Moves joints towards a stored pose. `links`: names of the links whose joints move; absent: all. */
  | { type: 'pose'; share: number; joints: { link: string; q: number[] }[]; mirror?: boolean; links?: string[] };

export interface PoseRequest {
  op: 'pose';
  character: string;
  clip: string;
  /** Time of the scenario, s. */
  time: number;
  /** The layer that gets the keys; absent: a new layer above all others. */
  layer?: string;
  /** Joints that differ from the document's pose, as in `changed` of an earlier answer. */
  from?: { link: number; q: number[] }[];
  edit?: PoseEdit;
  pins?: number[];
  /** True: joints may pass their limits. */
  free?: boolean;
  /** Times of the scenario for which the poses of the document are also answered, s. */
  ghosts?: number[];
  /** True: the answer contains `joints`. */
  coordinates?: boolean;
}

export interface PoseReply {
  /** Time in the motion, s. */
  motion_time: number;
  /** Packed poses of all links, 7 numbers each: x y z (m) qw qx qy qz. */
  links: number[];
  /** For each link the displacement of its DOFs from the neutral position, rad or m; empty for floating joints. */
  angles: number[][];
  changed: { link: number; q: number[] }[];
  /** Keys of the layer that give this pose, for all joints. `moved`: the joint differs from the document's pose. */
  keys: { link: string; part: 'joint' | 'rotation' | 'position'; value: number[]; moved: boolean }[];
  /** Links that touch the ground at this time in the motion. */
  planted: number[];
  ghosts?: number[][];
  /** Coordinates of all joints, as a stored pose has them. */
  joints?: { link: string; q: number[] }[];
}

/** Joints of a character in the recorded simulation. */
/** A pull of the user that has ended. */
export interface PulledEvent {
  character: string;
  /** Index of the link. */
  link: number;
  /** Pulled point in the frame of the link, m. */
  point: Vec3;
  /** Begin and duration, s. */
  time: number;
  duration: number;
  /** Targets: time since the begin (s), x, y, z (m). Each holds until the next one. */
  path: [number, number, number, number][];
}

export interface RecordedEvent {
  character: string;
  /** Distance of the samples, s; the first is at time 0. */
  step: number;
  /** Displacements from the neutral position, rad or m: a list of samples for each DOF. */
  curves: { link: string; values: number[][] }[];
}

export interface JointFacts {
  type: string;
  /** Limits (rad or m; null: none), maximum torque or force, and axis in the link's frame of each DOF. */
  dofs: { lower: number | null; upper: number | null; effort: number | null; turns: boolean; axis: Vec3 }[];
  /** Index of the link on the other side. */
  mirror: number;
}

export interface CurvesReply {
  /** Duration of the motion, s. */
  duration: number;
  /** Time of the first sample in the motion, and distance of the samples, s. */
  from: number;
  step: number;
  curves: { link: string; part: 'joint' | 'rotation' | 'position'; base: number[][]; result: number[][] }[];
}

export type Vec3 = [number, number, number];

export interface LibraryEntry {
  id: string;
  kind: 'mechanism' | 'motion';
  name: string;
  summary?: string;
  tags?: string[] | string;
  mechanism?: string;
  /** The mechanism is a mesh, of which props are made. */
  mesh?: MeshFacts;
  /** Duration of a motion, s. */
  duration?: number;
  /** Frame rate of a motion, 1/s. */
  rate?: number;
  frames?: number;
  /** Number of degrees of freedom. */
  dofs?: number;
  /** Mass of a mechanism, kg. */
  mass?: number;
  /** Height of a mechanism, m. */
  height?: number;
  cyclic?: boolean;
  created?: string;
  /** Id of the library entry, the same for all its versions; absent if the entry is only in the open project. */
  entry?: string;
  version?: number;
  note?: string;
  source?: string;
  /** User who saved the newest version. */
  by?: string;
  /** When the newest version was saved, ISO 8601. */
  changed?: string;
  /** Size of the entry's data, bytes. */
  size?: number;
  /** True if the library has a picture of the entry. */
  thumbnail?: boolean;
  /** When the entry was moved to the trash; empty if it was not. */
  removed?: string;
}

export interface ShapeData {
  type: 'capsule' | 'sphere' | 'box' | 'cylinder' | 'ellipsoid' | 'mesh' | 'height_field';
  /** Radius of a sphere, capsule or cylinder, m. */
  radius?: number;
  /** Capsule, cylinder: distance along the shape's z axis from its centre to the centre of a cap or to an end face, m. */
  half_length?: number;
  /** Half edge lengths of a box, or radii of an ellipsoid, m. */
  half_extents?: Vec3;
  /** Key of a mesh or height field in the mechanism's `surfaces`. */
  surface?: string;
  /** Pose of the shape in the link's frame: x, y, z (m), qw, qx, qy, qz. */
  pose: number[];
}

export interface LinkData {
  name: string;
  label?: string;
  /** Index of the parent link; -1 for the root. */
  parent: number;
  /** Type of the joint to the parent. */
  joint: string;
  /** Degrees of freedom of the joint. */
  dofs: number;
  shapes: ShapeData[];
  /** World pose in the neutral position: x, y, z (m), qw, qx, qy, qz. */
  neutral?: number[];
}

/** A triangle mesh: vertices are base64 of 32-bit floats x y z (m), triangles are base64 of 32-bit vertex indices. */
export interface MeshSurface {
  vertices: string;
  triangles: string;
}

/** A height field. `heights` is base64 of 32-bit floats (m), row by row; x grows with the column, y with the row. */
export interface HeightFieldSurface {
  columns: number;
  rows: number;
  /** Half the extent along x, m. */
  half_x: number;
  /** Half the extent along y, m. */
  half_y: number;
  /** Depth of the base below height 0, m. */
  base: number;
  heights: string;
}

/** The skin of a character file: lists as Base64 of little-endian numbers. */
export interface SkinData {
  /** 32-bit floats: [vertices][3], [vertices][3], [vertices][2]. */
  positions: string;
  normals: string;
  uvs: string;
  /** 16-bit numbers [vertices][3]: linear red, green, blue in 1/65535; absent: white. */
  colors?: string;
  /** 16-bit numbers [vertices][4]: bones, and their weights in 1/65535. */
  bones: string;
  weights: string;
  /** 32-bit numbers: corners of the triangles. */
  indices: string;
  parts: { color: string; texture: number; first: number; count: number; cutoff: number; both_sides: boolean }[];
  textures: { type: string; data: string }[];
  /** Link of each bone. */
  links: number[];
  /** [bones][3][4] from the vertices to the frame of the link, m. */
  matrices: number[];
}

export interface MechanismData {
  id: string;
  name: string;
  /** Total number of degrees of freedom. */
  dofs: number;
  /** Total mass, kg. */
  mass: number;
  /** Height in the neutral position, m. */
  height: number;
  /** Meshes and height fields that shapes refer to, by key. */
  surfaces?: Record<string, MeshSurface | HeightFieldSurface>;
  skin?: SkinData;
  links: LinkData[];
}

/** A failed request: the problems that the service reported, or one problem with the text `fallback` if it reported none. */
export class RequestError extends Error {
  readonly problems: Problem[];
  /** @param status HTTP status of the answer; 503: the library does not respond */
  constructor(error: Partial<ServiceError> | undefined, fallback: string, readonly status = 0) {
    const problems = error?.problems?.length ? error.problems : [{ message: fallback }];
    super(problems[0]?.message ?? fallback);
    this.problems = problems;
  }
}
