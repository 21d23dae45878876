/** `window.ugoki`: read-only access to the page's state, for the end-to-end tests. */
import * as THREE from 'three';
import { assist_force, assist_over_cap, body_weight, centre_of_mass, link_position, state_of } from '../core/frames';
import { all_bad_spans } from './actions';
import { circuit, imports, library, parts, poser, session } from './app';

export interface PageHook {
  readonly connected: boolean;
  readonly pictures: number;
  readonly frames_received: number;
  document(): unknown;
  /** Ids of the inner scenarios through which the user came to the shown one. */
  open(): readonly string[];
  transport(): unknown;
  selection(): unknown;
  summary(): unknown;
  /** Measures over time: number and rate of the frames, and the spans in which a measure is bad. */
  measures(): { frames: number; rate: number; bad: { character: string; measure: string; from: number; to: number; at: number }[] };
  /** Paths of the recently opened projects, newest first. */
  recent(): string[];
  log(): string[];
  undo(): { can_undo: boolean; can_redo: boolean; undo_label: string; redo_label: string; revision: number };
  frame(): { time: number; number: number; playing: boolean; simulate: boolean; grabbing: boolean; contacts: number } | null;
  /** State of the wiring editor: shown circuit, selection, problems, and counts of the drawing; null if there is no circuit. */
  circuit(): { name: string; edited: boolean; path: string[]; lsis: unknown[]; wires: string[]; notes: unknown[]; probes: unknown[]; circuits: string[]; selected: string[]; problems: string[]; facts: unknown } | null;
  /** The drawn lines between closest points: ids of the two characters and distance, m (negative: overlap). */
  closest_pairs(): { a: string; b: string; distance: number; simulate: boolean }[];
  /** Unit normals of the contacts in the latest frame, world frame. */
  normals(): [number, number, number][];
  library(): { names: string[]; ids: string[]; total: number; more: boolean; status: string; query: string; done: string; conflict: string };
  imports(): { file: string; status: string; rereading: boolean; settings: unknown; report: unknown; problems: unknown; anatomy: unknown }[];
  /**
   * The import preview: heights of the imported and the reference character as drawn, m; time of the preview, s; number of frames drawn.
   */
  import_view(): { character: number; reference: number; time: number; pictures: number; colors: readonly (string | null)[] } | null;
  /** The newest values of an output in the shown level; null if none was received. */
  pin_value(node: string, pin: string): number[] | null;
  /** Index of the link with this name or label, or -1. */
  link_index(character: string, name: string): number;
  /** World position of a link's frame, m. */
  link_position(character: string, link: number): [number, number, number] | null;
  /** Ends of the spring of a mouse pull in the latest frame, world frame, m; null while nothing is pulled. */
  pull(): { point: [number, number, number]; target: [number, number, number] } | null;
  character(id: string): { state: number; assist: number; over_cap: number; com: [number, number, number] } | null;
  /** The camera: height above the floor and distance from its target, m; angle about the vertical, rad; whether it still moves to its place. */
  camera(): { height: number; distance: number; azimuth: number; moving: boolean } | null;
  /** Page position, px, of the centre of a link's first shape; null while it is not in view. */
  link_on_screen(character: string, link: number): { x: number; y: number } | null;
  /** State of posing: whether the pose of the playhead is known, points of the first arc on the page (px), ghosts, and keys drawn in the curves panel (px in the canvas); null while the tool is off. */
  posing(): { ready: boolean; pending: boolean; arc: { x: number; y: number; handle: boolean }[]; ghosts: number; drawn_keys: { x: number; y: number }[] } | null;
  /** Page position, px, of a point in the world frame (m). */
  to_screen(point: [number, number, number]): { x: number; y: number } | null;
}

declare global {
  interface Window {
    ugoki: PageHook;
  }
}

function character_of(character: string) {
  const frame = session.frames.latest;
  const character_frame = frame?.characters[session.state.characters.findIndex((c) => c.id === character)];
  return frame && character_frame ? { frame, character_frame } : null;
}

const mechanism_of = (character: string) => {
  const id = session.state.characters.find((c) => c.id === character)?.mechanism;
  return id ? session.state.mechanisms[id] : undefined;
};

export function expose_hook(): void {
  window.ugoki = {
    get connected() {
      return session.state.connection === 'open';
    },
    get pictures() {
      return parts.viewport?.pictures ?? 0;
    },
    get frames_received() {
      return session.frames.received;
    },
    document: () => structuredClone(session.state.document),
    open: () => [...session.state.open],
    transport: () => structuredClone(session.state.transport),
    selection: () => structuredClone(session.state.selection),
    summary: () => structuredClone(session.state.summary),
    measures: () => {
      const { frames, rate } = session.state.measures;
      return { frames, rate, bad: all_bad_spans().map(({ character, measure, from, to, at }) => ({ character, measure: measure.key, from, to, at })) };
    },
    recent: () => session.state.recent.map((r) => r.path),
    log: () => session.state.log.map((line) => `${line.level}: ${line.text}`),
    undo: () => {
      const { can_undo, can_redo, undo_label, redo_label, revision } = session.state;
      return { can_undo, can_redo, undo_label, redo_label, revision };
    },
    frame: () => {
      const f = session.frames.latest;
      return f && { time: f.time, number: f.number, playing: f.playing, simulate: f.simulate, grabbing: f.grabbing, contacts: f.contact_count };
    },
    closest_pairs: () => {
      const f = session.frames.latest;
      const { characters } = session.state;
      return (parts.viewport?.closest_pairs ?? []).map((p) => ({ a: characters[p.a]?.id ?? '', b: characters[p.b]?.id ?? '', distance: p.distance, simulate: f?.simulate ?? false }));
    },
    normals: () => {
      const f = session.frames.latest;
      if (!f || f.normals < 0) return [];
      return Array.from({ length: f.contact_count }, (_, i): [number, number, number] => [f.floats[f.normals + 3 * i]!, f.floats[f.normals + 3 * i + 1]!, f.floats[f.normals + 3 * i + 2]!]);
    },
    library: () => {
      const { entries, total, more, status, query, done, conflict } = library.state;
      return structuredClone({ names: entries.map((e) => e.name), ids: entries.map((e) => e.entry ?? e.id), total, more, status, query, done: done?.label ?? '', conflict: conflict?.theirs.name ?? '' });
    },
    imports: () => structuredClone(imports.state.items.map((i) => ({ file: i.file, status: i.status, rereading: i.rereading, settings: i.staged?.settings ?? null, report: i.staged?.report ?? null, problems: i.problems, anatomy: i.staged?.anatomy ?? null }))),
    import_view: () => (parts.import_view ? { ...parts.import_view.heights, time: parts.import_view.time, pictures: parts.import_view.pictures, colors: parts.import_view.colors } : null),
    circuit: () => {
      const { view, edited, path, nodes, problems } = circuit.state;
      const shown = view?.level.circuit;
      return shown
        ? structuredClone({
            name: shown.name, edited, path: [...path], lsis: shown.lsis ?? [], wires: view.wires.map((w) => `${w.from}.${w.from_pin} > ${w.to}.${w.to_pin}`), notes: shown.notes ?? [], probes: shown.probes ?? [],
            circuits: (shown.circuits ?? []).map((c) => c.name), selected: [...nodes], problems: problems.map((p) => `${p.lsi}: ${p.message}`), facts: parts.circuit?.facts() ?? null,
          })
        : null;
    },
    pin_value: (node, pin) => {
      const flat = circuit.flat_output(node, pin);
      const value = flat ? session.live.pin(flat) : undefined;
      return value ? [...value.numbers] : null;
    },
    link_index: (character, name) => mechanism_of(character)?.links.findIndex((l) => l.name === name || l.label === name) ?? -1,
    link_position: (character, link) => {
      const found = character_of(character);
      return found && link < found.character_frame.links ? link_position(found.frame, found.character_frame, link) : null;
    },
    pull: () => {
      const f = session.frames.latest;
      if (!f?.grabbing) return null;
      const three = (at: number): [number, number, number] => [f.floats[at]!, f.floats[at + 1]!, f.floats[at + 2]!];
      return { point: three(f.grab), target: three(f.grab + 3) };
    },
    character: (id) => {
      const found = character_of(id);
      if (!found) return null;
      const weight = body_weight(found.frame, found.character_frame);
      return {
        state: state_of(found.frame, found.character_frame),
        assist: weight > 0 ? Math.hypot(...assist_force(found.frame, found.character_frame)) / weight : 0,
        over_cap: assist_over_cap(found.frame, found.character_frame),
        com: centre_of_mass(found.frame, found.character_frame),
      };
    },
    camera: () => (parts.viewport ? { height: parts.viewport.rig.camera.position.z, distance: parts.viewport.rig.current.distance, azimuth: parts.viewport.rig.current.azimuth, moving: parts.viewport.rig.moving } : null),
    link_on_screen: (character, link) => {
      const found = character_of(character);
      const shape = mechanism_of(character)?.links[link]?.shapes[0];
      if (!found || link >= found.character_frame.links || !parts.viewport) return null;
      const at = found.character_frame.poses + 7 * link;
      const f = found.frame.floats;
      const rotation = new THREE.Quaternion(f[at + 4], f[at + 5], f[at + 6], f[at + 3]);
      const middle = new THREE.Vector3(...(shape ? (shape.pose.slice(0, 3) as [number, number, number]) : ([0, 0, 0] as const)));
      const point = parts.viewport.to_client(middle.applyQuaternion(rotation).add(new THREE.Vector3(f[at], f[at + 1], f[at + 2])));
      const { left, right, top, bottom } = parts.viewport.canvas.getBoundingClientRect();
      return point && point.x > left && point.x < right && point.y > top && point.y < bottom ? point : null;
    },
    posing: () => {
      const { on, reply, target, pending, ghosts } = poser.state;
      if (!on) return null;
      const to_page = (p: THREE.Vector3): { x: number; y: number } | null => parts.viewport?.to_client(p) ?? null;
      const arc = parts.posing?.gizmo.first_arc().flatMap(({ point, handle }) => {
        const at = to_page(point);
        return at ? [{ ...at, handle }] : [];
      });
      return { ready: target !== null && reply !== null, pending, arc: arc ?? [], ghosts: ghosts?.poses.length ?? 0, drawn_keys: parts.drawn_keys() };
    },
    to_screen: (point) => parts.viewport?.to_client(new THREE.Vector3(...point)) ?? null,
  };
}
