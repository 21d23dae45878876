/** A character at other times: its ghosts, and the trail of its centre of mass. */
import * as THREE from 'three';
import { centre_of_mass, type Frame, type FrameRing } from '../core/frames';
import type { MechanismData } from '../core/protocol';
import { body_surface } from './body_view';
import { Ghost } from './character_view';
import { Polyline } from './overlays';

const ghost_offsets = [-0.8, -0.4, 0.4, 0.8]; // times of the ghosts relative to the current frame, s
const earlier_color = 0x5f8fc4; // ghosts of a posed character, before and after the playhead
const later_color = 0x9a79cf;
const before_color = 0x34d399; // the motion before a correction
const trail_seconds = 4; // time span of a trail, s

/** Poses of the posed character before and after the present one, in turn; packed values of all links. */
export interface PoseGhosts {
  character: string;
  poses: readonly (readonly number[])[];
}

export class OtherTimes {
  readonly group = new THREE.Group();
  /** Made when they are shown for the first time. */
  private ghosts: Ghost[] = [];
  private readonly trail = new Polyline(0xff9d5c, 1.6, 0.8);
  private ghosts_shown = false;
  /** The motion before a correction; made when it is shown for the first time. */
  private before: Ghost | null = null;

  constructor(
    private readonly mechanism: MechanismData,
    private readonly geometries: (THREE.BufferGeometry | null)[],
  ) {
    this.group.add(this.trail.line);
  }

  /**
   * Shows the character shortly before and after `frame`.
   * @param index of the character in the frames  @param rate frames a second  @param posed poses to show instead of those of the frames; null: none
   */
  show_ghosts(on: boolean, frames: FrameRing, frame: Frame, index: number, rate: number, posed: PoseGhosts['poses'] | null): void {
    if (!on) {
      if (this.ghosts_shown) for (const ghost of this.ghosts) ghost.hide();
      this.ghosts_shown = false;
      return;
    }
    this.ghosts_shown = true;
    this.make_ghosts();
    this.ghosts.forEach((ghost, i) => {
      if (posed) {
        const pose = posed[i];
        if (pose) ghost.show_poses(pose, 0.24, i % 2 === 0 ? earlier_color : later_color);
        else ghost.hide();
        return;
      }
      const seconds = ghost_offsets[i]!;
      const other = frames.near(frame.number + Math.round(seconds * rate), 2);
      const character = other?.characters[index];
      if (other && character && character.links === frame.characters[index]?.links) ghost.show(other, character, Math.abs(seconds) > 0.5 ? 0.13 : 0.22);
      else ghost.hide();
    });
  }

  private make_ghosts(): void {
    if (this.ghosts.length > 0) return;
    this.ghosts = ghost_offsets.map((_offset, order) => new Ghost(this.geometries, order, body_surface(this.mechanism)));
    this.group.add(...this.ghosts.map((g) => g.group));
  }

  /** Shows the character as it was before a correction, by its rim. @param pose packed values of all links; null: nothing is shown */
  show_before(pose: readonly number[] | null): void {
    if (!pose) return this.before?.hide();
    if (!this.before) {
      this.before = new Ghost(this.geometries, ghost_offsets.length, body_surface(this.mechanism), true);
      this.group.add(this.before.group);
    }
    this.before.show_poses(pose, 0.9, before_color);
  }

  /** Shows the path of the centre of mass in the last seconds before `frame`. */
  show_trail(on: boolean, frames: FrameRing, frame: Frame, index: number, rate: number): void {
    if (!on) return this.trail.hide();
    const points: number[] = [];
    const first = Math.max(0, frame.number - Math.round(trail_seconds * rate));
    for (let n = first; n <= frame.number; n++) {
      const other = frames.at(n);
      const character = other?.characters[index];
      if (other && character) points.push(...centre_of_mass(other, character));
    }
    this.trail.show(points);
  }

  dispose(): void {
    for (const ghost of this.ghosts) ghost.dispose();
    this.before?.dispose();
  }
}
