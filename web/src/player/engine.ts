/** Interface of the engine of a player. The engine runs the content and returns its frames; it draws nothing. */
import type { Frame } from '../core/frames';
import type { FilmCamera, FilmShot } from '../core/film';
import type { Look, Material } from '../core/look';
import type { Devices, InputMessage } from '../core/play_controls';
import type { Variable } from '../core/variables';
import type { MechanismData, Vec3 } from '../core/protocol';

export interface SceneCharacter extends Material {
  id: string;
  name: string;
  color: string;
  /** Index into `Scene.mechanisms`. */
  mechanism: number;
  /** True: motion control follows a track, so a root assist may act. */
  tracks: boolean;
  /** Limit of the root assist, body weights. */
  assist_limit: number;
}

/** Description of the content, known before the first frame: scene_json() of the engine. */
export interface Scene {
  name: string;
  /** Duration of the content, s. */
  duration: number;
  /** Display frames per second. */
  frame_rate: number;
  /** Simulation step, s. */
  step: number;
  ground: { height: number };
  /** `follow`: id of the followed character, or empty. Distance in m, angles in rad. */
  camera: { follow: string; distance: number; azimuth: number; elevation: number };
  /** Absent: there are none. */
  cameras?: FilmCamera[];
  shots?: FilmShot[];
  look: Look;
  characters: SceneCharacter[];
  mechanisms: MechanismData[];
  /** Variables that viewers see. Absent: there are none. */
  variables?: Variable[];
}

/** One recorded input (docs/export.md, "Recorded inputs"). */
export interface RecordedInput {
  step: number;
  type: 'push' | 'grab' | 'drag' | 'release' | 'throw' | 'input';
  [field: string]: unknown;
}

export interface Engine {
  readonly scene: Scene;
  readonly devices: Devices;
  /** Steps since time 0. */
  readonly steps: number;
  /** Time since the beginning of the content, s. */
  readonly time: number;
  /** Reason why the run stopped before its end; empty while it runs. */
  readonly stopped: string;
  /** The current frame; null before the first one. */
  readonly frame: Frame | null;
  /** Present values of `Scene.variables`, in its order. */
  readonly variables: readonly number[];

  /** Runs `seconds` of content, within about `budget` ms of processor time. @return seconds of content that were run */
  advance(seconds: number, budget: number): number;
  /** Runs exactly `count` steps, or fewer if the run stops. @return steps done */
  step(count: number): number | Promise<number>;
  reset(): void;

  /** Applies a force [N], world, at the link's centre of mass for `duration` s. Characters and links are indices. */
  push(character: number, link: number, force: Vec3, duration: number): void;
  /** Pulls `point` [m, link's frame] towards `target` [m, world] until release(). */
  grab(character: number, link: number, point: Vec3, target: Vec3): void;
  drag(target: Vec3): void;
  release(): void;
  input(message: InputMessage): void;

  /** Sets inputs that act at their steps after the next reset(). Throws an Error that describes the problem if they are not valid. */
  schedule(inputs: RecordedInput[]): void | Promise<void>;
  /** Returns all inputs since the last reset(). */
  recorded(): RecordedInput[] | Promise<RecordedInput[]>;
  /** Hash of the positions and velocities of all characters, 16 hexadecimal digits. */
  state_hash(): string | Promise<string>;
  dispose(): void;
}
