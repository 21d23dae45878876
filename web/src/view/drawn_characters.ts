/** The characters of the document as drawn: made and removed with the document, posed from frames, and highlighted. */
import * as THREE from 'three';
import { is_left_out } from '../core/document';
import { format_label } from '../core/format';
import type { Material } from '../core/look';
import { instance_of } from '../core/nested';
import { state_of, type CharacterState, type Frame } from '../core/frames';
import type { MechanismData } from '../core/protocol';
import { shown_document, type StudioState } from '../core/state';
import { mechanism_geometries, type LinkTag } from './character_view';
import { Crowd } from './crowd';
import type { CrowdMember } from './crowd_member';
import { OtherTimes } from './other_times';
import { Arrow } from './overlays';

/** The objects drawn for one character. */
export interface Drawn {
  member: CrowdMember;
  times: OtherTimes;
  assist: Arrow;
  /** Packed poses of all links to draw instead of those of the frames; null: draw the frames. */
  pose: Float32Array | null;
}

export class DrawnCharacters {
  readonly crowd = new Crowd();
  private readonly drawn = new Map<string, Drawn>();
  private readonly geometries = new Map<string, (THREE.BufferGeometry | null)[]>();
  /** The last reported states, in the order of the characters. */
  private readonly shown_states: CharacterState[] = [];
  private hovered: LinkTag | null = null;
  private pulled: LinkTag | null = null;

  /** @param report_states receives the states of all characters, by id, when one changed */
  constructor(
    private readonly scene: THREE.Scene,
    private readonly state: () => StudioState,
    private readonly report_states: (states: Record<string, CharacterState>) => void,
  ) {
    scene.add(this.crowd.group);
  }

  dispose(): void {
    this.crowd.dispose();
  }

  get count(): number {
    return this.drawn.size;
  }

  find(character: string): Drawn | undefined {
    return this.drawn.get(character);
  }

  /** Groups of meshes that rays can hit. */
  get targets(): THREE.Group[] {
    return [...this.drawn.values()].map((entry) => entry.member.group);
  }

  /** Makes and removes what is drawn so that it agrees with the document. @param environment reflected by metal; null: none */
  sync(environment: THREE.Texture | null): void {
    const state = this.state();
    const doc = shown_document(state);
    const wanted = new Map<string, MechanismData>();
    const looks = new Map<string, Material & { color?: string }>();
    for (const character of doc?.characters ?? []) {
      const mechanism = state.mechanisms[character.mechanism];
      if (!mechanism || !doc || is_left_out(doc, character)) continue;
      wanted.set(character.id, mechanism);
      looks.set(character.id, character);
    }
    for (const { id, mechanism: name, look } of state.characters) {
      const mechanism = state.mechanisms[name];
      if (!mechanism || !look || !doc?.instances?.some((i) => i.id === instance_of(id))) continue;
      wanted.set(id, mechanism);
      looks.set(id, look);
    }
    for (const [id, entry] of this.drawn) {
      if (wanted.get(id) === entry.member.mechanism) continue;
      this.remove(entry);
      this.drawn.delete(id);
    }
    for (const [id, mechanism] of wanted) {
      const look = looks.get(id)!;
      const color = look.color || '#e6e6ea';
      const entry = this.drawn.get(id) ?? this.add(id, mechanism, color);
      this.drawn.set(id, entry);
      this.crowd.set_look(entry.member, color, look, look.metalness ? environment : null);
    }
    this.emphasise();
  }

  private add(id: string, mechanism: MechanismData, color: string): Drawn {
    let geometries = this.geometries.get(mechanism.id);
    if (!geometries) {
      geometries = mechanism_geometries(mechanism);
      this.geometries.set(mechanism.id, geometries);
    }
    const entry: Drawn = {
      member: this.crowd.add(id, mechanism, geometries, color),
      times: new OtherTimes(mechanism, geometries),
      assist: new Arrow(0x34d399, 0.011, true),
      pose: null,
    };
    this.scene.add(entry.assist.group, entry.times.group);
    return entry;
  }

  private remove(entry: Drawn): void {
    this.scene.remove(entry.assist.group, entry.times.group);
    this.crowd.remove(entry.member);
    entry.times.dispose();
  }

  // ---- highlights ----

  /** Highlights the link under the pointer; null: none. @return whether it is another link than before */
  hover(tag: LinkTag | null): boolean {
    if (this.hovered?.character === tag?.character && this.hovered?.link === tag?.link) return false;
    this.hovered = tag;
    this.emphasise();
    return true;
  }

  /** Highlights the pulled link; null: none. */
  pull(tag: LinkTag | null): void {
    this.pulled = tag;
    this.emphasise();
  }

  /** Applies the highlights of selection, pointer and pull. */
  emphasise(): void {
    const { selection } = this.state();
    for (const [id, entry] of this.drawn) {
      entry.member.mechanism.links.forEach((_link, link) => {
        const pulled = this.pulled?.character === id && this.pulled.link === link;
        const selected =
          (selection.kind === 'character' && selection.character === id && selection.link === link) ||
          (selection.kind === 'instance' && instance_of(id) === selection.instance);
        const hovered = this.hovered?.character === id && this.hovered.link === link;
        entry.member.emphasise(link, pulled ? 'pulled' : hovered ? 'hover' : selected ? 'selected' : 'none');
      });
    }
  }

  // ---- poses ----

  /** Poses the characters as in a frame, and reports their states if they changed. */
  place(frame: Frame): void {
    const { characters } = this.state();
    let changed = this.shown_states.length !== characters.length;
    characters.forEach((character, index) => {
      const entry = this.drawn.get(character.id);
      const character_frame = frame.characters[index];
      if (!character_frame) return;
      const state = state_of(frame, character_frame);
      changed ||= this.shown_states[index] !== state;
      this.shown_states[index] = state;
      if (!entry) return;
      if (entry.pose) entry.member.place_poses(entry.pose, 0, entry.pose.length / 7);
      else entry.member.place(frame, character_frame);
    });
    if (!changed) return;
    this.shown_states.length = characters.length;
    this.report_states(Object.fromEntries(characters.map((character, index) => [character.id, this.shown_states[index]!])));
  }

  /** Draws a character displaced by `offset` (m) from its position in the frames. */
  show_offset(character: string, offset: THREE.Vector3): void {
    this.drawn.get(character)?.member.offset.copy(offset);
  }

  /** Draws a character in a pose that is not in the frames; null: as in the frames. */
  show_pose(pose: { character: string; links: readonly number[] } | null): void {
    for (const [id, entry] of this.drawn) entry.pose = pose?.character === id ? Float32Array.from(pose.links) : null;
  }

  // ---- questions ----

  mechanism_of(character: string): MechanismData | undefined {
    return this.drawn.get(character)?.member.mechanism;
  }

  link_label(tag: LinkTag): string {
    const link = this.drawn.get(tag.character)?.member.mechanism.links[tag.link];
    return format_label(link?.label || link?.name || '');
  }

  /** Mesh of a link with its world matrix; undefined or null if the link is not drawn. */
  link_mesh(tag: LinkTag): THREE.Mesh | null | undefined {
    return this.drawn.get(tag.character)?.member.links[tag.link];
  }

  /** Converts a world point into a link's frame, m; null if the link is not drawn. */
  to_link(tag: LinkTag, point: THREE.Vector3): THREE.Vector3 | null {
    const mesh = this.link_mesh(tag);
    if (!mesh) return null;
    return point.clone().applyMatrix4(mesh.matrixWorld.clone().invert());
  }

  /** Bounding spheres of the links of a character (null: of all characters) as drawn now, m. */
  spheres(character: string | null): THREE.Sphere[] {
    const out: THREE.Sphere[] = [];
    for (const [id, entry] of this.drawn) {
      if (character !== null && id !== character) continue;
      out.push(...entry.member.spheres);
    }
    return out;
  }

  *each_sphere(): Generator<THREE.Sphere> {
    for (const entry of this.drawn.values()) yield* entry.member.spheres;
  }

  /** Bounding sphere of a character (null: of all characters) as drawn now, m; null if nothing is drawn. */
  bounds(character: string | null): THREE.Sphere | null {
    const box = new THREE.Box3();
    for (const s of this.spheres(character))
      box.expandByPoint(s.center.clone().addScalar(s.radius)).expandByPoint(s.center.clone().subScalar(s.radius));
    return box.isEmpty() ? null : box.getBoundingSphere(new THREE.Sphere());
  }
}
