/** Draws over a frame: ghosts, trails, root assist, contacts, closest points, the pull, and the ring under the selected character. */
import * as THREE from 'three';
import { assist_over_cap, body_weight, centre_of_mass, type CharacterFrame, type Frame } from '../core/frames';
import { pose_before, type Comparison } from '../core/motion/comparer';
import type { Session } from '../core/session';
import { selected_character } from '../core/state';
import type { CameraRig } from './camera';
import type { LinkTag } from './character_view';
import type { Drawn, DrawnCharacters } from './drawn_characters';
import type { PoseGhosts } from './other_times';
import { Arrow, assist_color, ContactDiscs, make_ring, Segments, Spring } from './overlays';

const max_contact_arrows = 48; // maximum number of contacts that are drawn with arrows

const point_of_mass = new THREE.Vector3();
const force_of_assist = new THREE.Vector3();
const start_of_assist = new THREE.Vector3();

/** A pull from `local` (link frame, m) to `target` (world, m). */
export interface Pull {
  tag: LinkTag;
  local: THREE.Vector3;
  target: THREE.Vector3;
}

/** A closest pair as drawn: distance (m), midpoint of the line, indices of the characters. */
export interface ClosestPair {
  distance: number;
  middle: THREE.Vector3;
  a: number;
  b: number;
}

export class FrameOverlays {
  /** The closest pairs as drawn, smallest distance first. */
  closest_pairs: ClosestPair[] = [];
  /** Null: no pull. */
  pull: Pull | null = null;
  /** Ghosts of the posed character; null: ghosts are drawn from frames. */
  pose_ghosts: PoseGhosts | null = null;
  /** Returns the comparison whose earlier motion is drawn as a ghost; null: none. */
  before: () => Comparison | null = () => null;
  private readonly contact_arrows: Arrow[] = [];
  private readonly contact_discs = new ContactDiscs(max_contact_arrows);
  private readonly normals = new Segments(0x9adcf7, 1.6);
  private readonly closest_lines = new Segments(0x7dd3fc, 1.6);
  private readonly spring = new Spring();
  private readonly ring = make_ring();

  constructor(
    scene: THREE.Scene,
    private readonly session: Session,
    private readonly drawn: DrawnCharacters,
    private readonly rig: CameraRig,
  ) {
    for (let i = 0; i < max_contact_arrows; i++) {
      const arrow = new Arrow(0xfdba74, 0.009);
      this.contact_arrows.push(arrow);
      scene.add(arrow.group);
    }
    scene.add(this.spring.group, this.ring, this.contact_discs.mesh, this.normals.lines, this.closest_lines.lines);
  }

  draw(frame: Frame | null): void {
    const { view } = this.session.state;
    this.drawn.crowd.show_shapes(view.shapes);
    this.draw_characters(frame);
    this.draw_contacts(view.contacts ? frame : null);
    this.draw_closest_pairs(view.closest ? frame : null);
    this.draw_pull();
  }

  /** Ghosts, trail and root assist of each character, and the ring under the selected one. */
  private draw_characters(frame: Frame | null): void {
    const { session, ring } = this;
    const { state } = session;
    const { view, characters } = state;
    const selected = selected_character(state);
    ring.visible = false;
    characters.forEach((character, index) => {
      const entry = this.drawn.find(character.id);
      const character_frame = frame?.characters[index];
      if (!entry || !character_frame || !frame) return;
      const rate = state.document?.frame_rate ?? 60;
      const posed = this.pose_ghosts && (this.pose_ghosts.character === character.id ? this.pose_ghosts.poses : []);
      entry.times.show_ghosts(view.ghosts, session.frames, frame, index, rate, posed);
      const before = this.before();
      entry.times.show_before(before?.character === character.id ? pose_before(before.reply, frame.time) : null);
      entry.times.show_trail(view.trail, session.frames, frame, index, rate);
      if (!view.assist || !frame.simulate || !this.draw_assist(entry, frame, character_frame)) entry.assist.hide();
      if (selected === character.id) {
        const com = point_of_mass.set(...centre_of_mass(frame, character_frame)).add(entry.member.offset);
        const bounds = this.drawn.bounds(character.id);
        ring.scale.setScalar(Math.max(0.3, Math.min(0.5 * (bounds?.radius ?? 0.8), 0.62)));
        ring.position.set(com.x, com.y, (state.document?.ground?.height ?? 0) + 0.004);
        ring.visible = true;
      }
    });
  }

  /** @return false: the force is too small to be shown */
  private draw_assist(entry: Drawn, frame: Frame, character_frame: CharacterFrame): boolean {
    const weight = body_weight(frame, character_frame);
    const force = force_of_assist.fromArray(frame.floats, character_frame.data);
    const share = weight > 0 ? force.length() / weight : 0;
    if (share <= 0.004 || !entry.member.root(start_of_assist)) return false;
    assist_color(assist_over_cap(frame, character_frame), entry.assist.material.color);
    // the length grows with the square root of the force: 1 % of the weight is visible (0.19 m), 100 % fits the view (1.9 m)
    entry.assist.show(start_of_assist, force.setLength(1.9 * Math.sqrt(Math.min(share, 1))));
    return true;
  }

  /** @param frame null: contacts are not shown */
  private draw_contacts(frame: Frame | null): void {
    let arrows = 0;
    this.contact_discs.begin();
    this.normals.begin();
    if (frame) {
      const longest = Math.max(1, ...frame.characters.map((f) => body_weight(frame, f)));
      for (let i = 0; i < frame.contact_count && arrows < max_contact_arrows; i++) {
        const at = frame.contacts + 8 * i;
        const f = frame.floats;
        const force = new THREE.Vector3(f[at + 3], f[at + 4], f[at + 5]).multiplyScalar(0.9 / longest).clampLength(0, 1.6);
        if (force.lengthSq() < 1e-6) continue;
        const point = new THREE.Vector3(f[at], f[at + 1], f[at + 2]);
        const k = frame.normals + 3 * i;
        const normal = frame.normals < 0 ? force : new THREE.Vector3(f[k], f[k + 1], f[k + 2]);
        this.contact_discs.add(point, normal, 0.012 + 0.006 * Math.min(1, force.length()));
        if (frame.normals >= 0) this.normals.add(point, point.clone().addScaledVector(normal, 0.14));
        this.contact_arrows[arrows++]!.show(point, force);
      }
    }
    for (; arrows < max_contact_arrows; arrows++) this.contact_arrows[arrows]!.hide();
    this.normals.end();
  }

  /** @param frame null: closest points are not shown */
  private draw_closest_pairs(frame: Frame | null): void {
    this.closest_lines.begin();
    this.closest_pairs = [];
    for (let i = 0; frame && i < frame.closest_count; i++) {
      const at = frame.closest + 8 * i;
      const f = frame.floats;
      const a = new THREE.Vector3(f[at], f[at + 1], f[at + 2]);
      const b = new THREE.Vector3(f[at + 3], f[at + 4], f[at + 5]);
      const who = frame.words[at + 7]!;
      this.closest_lines.add(a, b);
      this.closest_pairs.push({ distance: f[at + 6]!, middle: a.clone().add(b).multiplyScalar(0.5), a: who >>> 16, b: who & 0xffff });
    }
    this.closest_lines.end();
  }

  private draw_pull(): void {
    const mesh = this.pull && this.drawn.link_mesh(this.pull.tag);
    if (!this.pull || !mesh) {
      this.spring.hide();
      return;
    }
    const from = this.pull.local.clone().applyMatrix4(mesh.matrixWorld);
    this.spring.show(from, this.pull.target, this.rig.camera, this.rig.current.distance * 0.0042);
  }
}
