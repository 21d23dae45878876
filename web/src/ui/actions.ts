/** All commands of the page: id, label, keys, and the function that runs. */
import { content_end, find_character, find_clip, find_event, fit_blends, free_name, free_place, track_end, with_room, type Clip, type ClipFields, type Command, type ScenarioDocument, type ScenarioInstance } from '../core/document';
import { count_instances, find_instance, find_scenario, selected_tracks } from '../core/nested';
import { insert_time, ripple_remove } from '../core/ripple';
import { link_position } from '../core/frames';
import { all_items, duplicate_items, remove_items, selection_of } from '../core/items';
import { next_span, type BadSpan } from '../core/measures';
import type { AppCommand } from '../core/commands';
import { add_rule } from './rules/templates';
import { draft_key, selected_character, type Selection } from '../core/state';
import { reads_anything } from '../core/play_controls';
import type { StudioState, ViewOptions } from '../core/state';
import { EditTurns } from '../core/turns';
import { format_bytes } from '../core/library/words';
import { RequestError, type ServiceError, type UsedLibrary } from '../core/protocol';
import { lowest_point } from '../view/character_view';
import { new_pose_name, store_pose } from '../core/posing/pose_library';
import { end_tour } from './Tour';
import { insert_mesh, prop_commands } from './prop_actions';
import { add_camera, cut_here, key_view, place_camera, toggle_through } from './film/actions';
import { access, circuit, comparer, page, parts, poser, registry, session } from './app';
import { duplicate_instance, leave_to, nest_selection, open_instance } from './nested/actions';
import { add_gait, body_for_gait } from './motion/gait_actions';

const state = (): StudioState => session.state;
const turns = new EditTurns(session.store);
const has_document = (): boolean => state().document !== null;
const has_canvas = (): boolean => parts.circuit !== null;
let copied: { character: string; clip: Clip } | null = null;

export function selected_clip(): { character: string; clip: Clip } | null {
  const { selection, document } = state();
  if (selection.kind !== 'clip' || !document) return null;
  const clip = find_clip(document, selection.character, selection.clip);
  return clip ? { character: selection.character, clip } : null;
}

export function set_view(part: Partial<ViewOptions>): void {
  session.set({ view: { ...state().view, ...part } });
  session.remember();
}

/** Switches the draft resolution, which this browser keeps for the next page. */
function toggle_draft(): void {
  toggle('draft')();
  try {
    localStorage.setItem(draft_key, state().view.draft ? 'on' : 'off');
  } catch {
    // pages without storage do not keep it
  }
}

const toggle = (option: keyof ViewOptions) => (): void => set_view({ [option]: !state().view[option] });

function remove_selection(): void {
  const { selection, document } = state();
  const clip = selected_clip();
  if (page.getState().ripple && clip && document) return void session.edit(ripple_remove(document, clip.character, clip.clip));
  if (selection.kind === 'items' && document) {
    const command = remove_items(document, selection.items);
    if (command) void session.edit(command);
  } else if (selection.kind === 'marker') void session.edit({ type: 'marker.remove', id: selection.marker });
  else if (selection.kind === 'camera') void session.edit({ type: 'camera.remove', id: selection.camera });
  else if (selection.kind === 'shot') void session.edit({ type: 'shot.remove', id: selection.shot });
  else if (selection.kind === 'clip') void session.edit({ type: 'clip.remove', character: selection.character, id: selection.clip });
  else if (selection.kind === 'event') void session.edit({ type: 'event.remove', id: selection.event });
  else if (selection.kind === 'character') void session.edit({ type: 'character.remove', id: selection.character });
  else if (selection.kind === 'instance' && document) void remove_instance(document, selection.instance);
  else if (selection.kind === 'tracks' && document) void session.edit({ type: 'group', label: `Remove ${selection.tracks.length} tracks`, commands: selection.tracks.map((id): Command => ({ type: find_instance(document, id) ? 'instance.remove' : 'character.remove', id })) });
  else if (selection.kind === 'rule') void session.edit({ type: 'rule.remove', id: selection.rule });
  else if (selection.kind === 'variable') void session.edit({ type: 'variable.remove', id: selection.variable });
  else if (selection.kind === 'circuit') circuit.remove();
}

/** Removes an instance. The inner scenario stays in the project, and a message names the place. */
async function remove_instance(document: ScenarioDocument, id: string): Promise<void> {
  const scenario = find_instance(document, id)?.scenario ?? '';
  const last = count_instances(document, scenario, []) === 1;
  if ((await session.edit({ type: 'instance.remove', id })) && last) session.notify(`“${find_scenario(document, scenario)?.name ?? scenario}” is not placed any more. It stays in the list of nested scenarios: deselect all to see it in the inspector.`);
}

function selected_instance(): ScenarioInstance | null {
  const { selection, document } = state();
  return (document && selection.kind === 'instance' && find_instance(document, selection.instance)) || null;
}

function add_copy(character: string, clip: Clip, start: number): Promise<boolean> | undefined {
  const { id: _id, ...fields } = clip;
  return insert_clip(character, { ...fields, start, id: session.fresh_id('k') });
}

/** Adds a clip and selects it. A clip that ends after the scenario makes it longer. An overlap with another clip becomes their cross-fade. */
function insert_clip(character: string, clip: ClipFields & { id: string; motion: string; start: number }): Promise<boolean> | undefined {
  const { document } = state();
  const track = document && find_character(document, character)?.track;
  if (!document || !track) return undefined;
  const length = clip.length ?? 0;
  const added = { offset: 0, speed: 1, blend: 0.3, loop: false, ...clip, length };
  const blends = length > 0 ? fit_blends(character, track, [...track, added]) : [];
  const commands: Command[] = [{ type: 'clip.add', character, ...clip }, ...blends];
  // `place` is the place of the neutral pose if the character has no clip, and a point on the floor if it has clips
  const { mechanism, place } = find_character(document, character)!;
  if (track.length === 0 && place.z !== 0 && Math.abs(place.z - standing_height(mechanism)) < 2e-3) commands.unshift({ type: 'character.set', id: character, place: { z: ground_height() } });
  const command: Command = commands.length > 1 ? { type: 'group', label: 'Add clip', commands } : commands[0]!;
  return edit_and_select(with_room(document, command, clip.start + length, 'Add clip'), { kind: 'clip', character, clip: clip.id });
}

/** Sends a command and selects `result` if the service accepted it. */
async function edit_and_select(command: Command, result: Selection): Promise<boolean> {
  const accepted = await session.edit(command);
  if (accepted) session.select(result);
  return accepted;
}

function duplicate(): void {
  if (state().selection.kind === 'circuit') return circuit.duplicate();
  void turns.run(duplicate_selection);
}

function duplicate_selection(): Promise<boolean> | undefined {
  const { selection, document } = state();
  const chosen = selected_clip();
  if (chosen) return add_copy(chosen.character, chosen.clip, Math.round((chosen.clip.start + chosen.clip.length) * 1e6) / 1e6);
  if (!document) return undefined;
  if (selection.kind === 'items') {
    const made = duplicate_items(document, selection.items, (prefix) => session.fresh_id(prefix));
    return made ? edit_and_select(made.command, selection_of(made.copies)) : undefined;
  } else if (selection.kind === 'instance') {
    const instance = find_instance(document, selection.instance);
    return instance && duplicate_instance(instance);
  } else if (selection.kind === 'event') {
    const event = find_event(document, selection.event);
    if (!event) return undefined;
    const id = session.fresh_id('e');
    return edit_and_select({ type: 'event.add', event: { ...event, id, time: event.time + 0.5 } }, { kind: 'event', event: id });
  } else if (selection.kind === 'character') {
    const character = find_character(document, selection.character);
    if (!character) return undefined;
    const id = session.fresh_id('c');
    const { track, ...fields } = character;
    const place = { ...character.place, ...free_place(document, { x: character.place.x, y: character.place.y + 1 }) };
    const clips = track.map((clip): Command => ({ ...clip, type: 'clip.add', character: id, id: session.fresh_id('k') }));
    const name = free_name(document, character.name);
    const commands: Command[] = [{ ...fields, type: 'character.add', id, name, place }, ...clips];
    return edit_and_select({ type: 'group', label: `Duplicate ${character.name}`, commands }, { kind: 'character', character: id });
  }
  return undefined;
}

/** Appends a motion to a character's track, as one command. */
export function append_motion(character: string, motion: string): void {
  void turns.run(() => {
    const { document } = state();
    const target = document && find_character(document, character);
    return target ? add_motion(character, motion, track_end(target)) : undefined;
  });
}

export function add_motion(character: string, motion: string, start: number): Promise<boolean> | undefined {
  const entry = session.entry(motion);
  const target = state().document && find_character(state().document!, character);
  if (entry?.mechanism && target && entry.mechanism !== target.mechanism) {
    session.fail(new Error(`“${entry.name}” is a motion for another mechanism than that of ${target.name}. Choose a character with the motion's mechanism.`));
    return undefined;
  }
  return insert_clip(character, { motion, start, id: session.fresh_id('k'), ...(entry?.duration ? { length: entry.duration } : {}) });
}

const ground_height = (): number => state().document?.ground?.height ?? 0;

/** Height of the place at which a mechanism in its neutral pose stands on the floor, m; the floor's height if the mechanism is not loaded. */
function standing_height(mechanism: string): number {
  const data = state().mechanisms[mechanism];
  return ground_height() - (data ? Math.round(lowest_point(data) * 1000) / 1000 : 0);
}

/** Adds a character that stands on the floor at `place` (m), or beside the others if there is no room. @param motion motion of its first clip */
export async function add_character(mechanism: string, place?: { x: number; y: number }, motion?: string): Promise<void> {
  const mesh = session.entry(mechanism);
  if (mesh?.mesh && !motion) return insert_mesh(mesh, place);
  if (!motion) await session.need_mechanism(mechanism);
  await turns.run(() => {
    const entry = session.entry(mechanism);
    const id = session.fresh_id('c');
    const { document } = state();
    const name = document ? free_name(document, entry?.name ?? 'Character') : (entry?.name ?? 'Character');
    const wanted = place ?? { x: 0, y: 0 };
    const position = document ? free_place(document, wanted) : wanted;
    const round = (v: number): number => Math.round(v * 100) / 100;
    const add: Command = { type: 'character.add', mechanism, id, name, place: { x: round(position.x), y: round(position.y), ...(motion ? {} : { z: standing_height(mechanism) }) } };
    const length = motion ? session.entry(motion)?.duration : undefined;
    const command: Command = motion
      ? { type: 'group', label: `Add ${name}`, commands: [add, { type: 'clip.add', character: id, motion, start: 0, ...(length ? { length } : {}) }] }
      : add;
    return edit_and_select(command, { kind: 'character', character: id });
  });
}

const frame_time = (): number => {
  const { document } = state();
  return document ? Math.round(Math.round(session.now * document.frame_rate) / document.frame_rate * 1e6) / 1e6 : 0;
};

function add_marker(): void {
  const id = session.fresh_id('m');
  void session.edit({ type: 'marker.add', id, time: frame_time() }).then((ok) => ok && session.select({ kind: 'marker', marker: id }));
}

/** Moves the playhead to the next marker, or with `back` to the previous one. */
function go_to_marker(back: boolean): void {
  const times = (state().document?.markers ?? []).map((m) => m.time);
  const now = session.now;
  const time = back ? times.reverse().find((t) => t < now - 1e-3) : times.find((t) => t > now + 1e-3);
  if (time !== undefined) session.seek(time);
}

/** Sets the in or out point at the playhead; the other point stays, or is the begin or the end of the scenario. */
function set_range(end: 'from' | 'to'): void {
  const { document } = state();
  if (!document) return;
  const time = frame_time();
  const range = { from: document.range?.from ?? 0, to: document.range?.to ?? document.duration, [end]: time };
  if (range.from >= range.to) {
    if (end === 'from') range.to = document.duration;
    else range.from = 0;
  }
  if (range.to - range.from < 1e-3) return session.notify('In and out are at the same time. Move the playhead first.');
  void session.edit({ type: 'scenario.set', range });
}

/** All time spans of the simulation in which a measure of a character that follows its track is bad. */
export function all_bad_spans(): BadSpan[] {
  const { document, measures } = state();
  const driven = document?.characters.filter((c) => c.control.mode === 'track') ?? [];
  return driven.flatMap((c) => measures.list.flatMap((measure) => measures.bad_spans(c.id, measure)));
}

function go_to_problem(back: boolean): void {
  const span = next_span(all_bad_spans(), session.now, back);
  if (span) session.seek(span.at);
  else session.notify(back ? 'No problem before the playhead.' : 'No problem after the playhead.');
}

/** Offers `data` as a download. */
export function download(data: Blob, name: string): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(data);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
  session.notify(`Exported ${name}, ${format_bytes(data.size)}`);
}

/** Name of the content without characters that file names must not contain. */
export const file_stem = (): string => (state().document?.name ?? 'content').replace(/[/\\:*?"<>|]/g, '-');

function export_measures(): void {
  const { measures, document: doc } = state();
  const characters = doc?.characters.filter((c) => c.control.mode === 'track') ?? [];
  download(new Blob([measures.csv(characters)], { type: 'text/csv' }), `${file_stem()} naturalness.csv`);
}

async function export_picture(): Promise<void> {
  const picture = await parts.viewport?.picture();
  if (picture) download(picture, `${file_stem()} ${session.now.toFixed(2)} s.png`);
}

function add_push(): void {
  const { document, selection } = state();
  const id = selection.kind === 'character' || selection.kind === 'clip' ? selection.character : document?.characters[0]?.id;
  const character = document && id ? find_character(document, id) : undefined;
  if (!character) return;
  const mechanism = state().mechanisms[character.mechanism];
  const chosen = selection.kind === 'character' && selection.link !== undefined ? mechanism?.links[selection.link] : undefined;
  const chest = mechanism?.links.find((l) => /chest|spine1|thorax|upper ?trunk/i.test(`${l.name} ${l.label ?? ''}`));
  const link = (chosen ?? chest ?? mechanism?.links[0])?.name;
  const event = session.fresh_id('e');
  const time = Math.round(session.now * 1000) / 1000;
  void session.edit({ type: 'event.add', event: { id: event, type: 'push', time, duration: 0.2, character: character.id, link, force: [150, 0, 0] } }).then((ok) => {
    if (ok) session.select({ kind: 'event', event });
  });
}

/** World position of a link in the shown frame, m; null if no frame shows it. */
function shown_position(character: string, link: number): readonly number[] | null {
  const frame = session.frames.latest;
  const shown = frame?.characters[state().characters.findIndex((c) => c.id === character)];
  return frame && shown && link < shown.links ? link_position(frame, shown, link) : null;
}

/** Adds a grab at the playhead: the selected link grips the nearest link of another character, or the world if there is none. */
function add_grab(): void {
  const { document, selection, mechanisms } = state();
  if (!document || selection.kind !== 'character' || selection.link === undefined) return session.notify('Click the link that shall grip, for example a hand, then add the grab.');
  const { character, link } = selection;
  const own = find_character(document, character);
  const name = own && mechanisms[own.mechanism]?.links[link]?.name;
  const hand = shown_position(character, link);
  if (!own || !name || !hand) return;
  let nearest: { distance: number; other: string; other_link: string } | null = null;
  for (const c of document.characters) {
    if (c.id === character) continue;
    mechanisms[c.mechanism]?.links.forEach((l, i) => {
      const at = shown_position(c.id, i);
      const distance = at ? Math.hypot(at[0]! - hand[0]!, at[1]! - hand[1]!, at[2]! - hand[2]!) : Infinity;
      if (l.shapes.length > 0 && distance < (nearest?.distance ?? Infinity)) nearest = { distance, other: c.id, other_link: l.name };
    });
  }
  const target = nearest as { distance: number; other: string; other_link: string } | null;
  const event = session.fresh_id('e');
  const { other, other_link } = target ?? { other: '', other_link: '' };
  void session.edit({ type: 'event.add', event: { id: event, type: 'grab', time: frame_time(), character, link: name, point: [0, 0, 0], other, other_link, at: null, rigid: false, limit: 450, reach: 0.15 } }).then((ok) => {
    if (ok) session.select({ kind: 'event', event });
  });
}

/** Adds a release at the playhead, of the link of the selected grab or of the selected link. */
function add_release(): void {
  const { document, selection, mechanisms } = state();
  if (!document) return;
  const grab = selection.kind === 'event' ? find_event(document, selection.event) : undefined;
  const own = selection.kind === 'character' ? find_character(document, selection.character) : undefined;
  const character = grab?.character ?? own?.id;
  const link = grab?.link ?? (own && selection.kind === 'character' && selection.link !== undefined ? mechanisms[own.mechanism]?.links[selection.link]?.name : undefined);
  if (!character || !link) return session.notify('Select a grab, or the link that shall release.');
  if (grab && frame_time() <= grab.time) return session.notify('Move the playhead after the grab first: the release is added at the playhead.');
  const event = session.fresh_id('e');
  void session.edit({ type: 'event.add', event: { id: event, type: 'release', time: frame_time(), character, link } }).then((ok) => {
    if (ok) session.select({ kind: 'event', event });
  });
}

/** Stores the present pose of the selected character, and shows the poses panel. @return the id of the stored pose; null if nothing can be posed */
export async function store_pose_of_selection(): Promise<string | null> {
  const joints = await poser.capture();
  const { document } = state();
  const character = document && poser.state.target ? find_character(document, poser.state.target.character) : undefined;
  if (!joints || !document || !character) return null;
  const id = session.fresh_id('p');
  if (!(await session.edit(store_pose(id, new_pose_name(document), character.mechanism, joints)))) return null;
  parts.show_panel('poses');
  return id;
}

function save_camera(): void {
  const eye = parts.viewport?.rig.current;
  if (!eye) return;
  const round = (value: number): number => Math.round(value * 1000) / 1000;
  const follow = state().view.follow ? (state().document?.camera?.follow ?? state().characters[0]?.id) : undefined;
  void session.edit({
    type: 'scenario.set',
    camera: { ...(follow ? { follow } : {}), distance: round(eye.distance), azimuth: round(eye.azimuth), elevation: round(eye.elevation) },
  });
}

/** Simulates, and sends keys, mouse and gamepads to the content until Escape is pressed. */
export function enter_controls(): void {
  const { transport } = state();
  if (transport.mode !== 'simulate') session.set_mode('simulate');
  if (!transport.playing) session.play();
  session.controls.enter();
}

/** Exports the project and offers the file as a download. @param form of GET /api/export/FORM */
export async function export_as(form: string, ending: string): Promise<void> {
  try {
    if (form === 'native') {
      const used = await access.fetch('api/export/libraries');
      const { libraries } = used.ok ? ((await used.json()) as { libraries: UsedLibrary[] }) : { libraries: [] };
      if (libraries.length > 0) return session.set({ dialog: 'carry', used_libraries: libraries });
    }
    session.notify('Exporting …');
    const chosen = form === 'bvh' ? selected_character(state()) : null;
    const response = await access.fetch(`api/export/${form}${chosen ? `.${chosen}` : ''}`);
    if (!response.ok) {
      const { problems } = new RequestError(((await response.json()) as { error?: ServiceError }).error, 'The export failed.');
      return session.notify(problems.map((p) => [p.message, p.remedy].filter(Boolean).join(' ')).join('\n'), 'error');
    }
    download(await response.blob(), `${file_stem()}${ending}`);
  } catch (error) {
    session.notify(`The export failed: ${(error as Error).message}`, 'error');
  }
}

const look_from = (azimuth: number, elevation: number) => (): void => {
  parts.viewport?.rig.look_from(azimuth, elevation);
  parts.viewport?.invalidate();
};

const key_step = 24; // px: one key press turns or moves the view like a drag of this length
/** Command that turns ('orbit') or moves ('pan') the view like a drag by (dx, dy) px. */
const move_view = (action: 'orbit' | 'pan', dx: number, dy: number) => (): void => {
  const { viewport } = parts;
  if (!viewport) return;
  if (action === 'orbit') viewport.rig.orbit(dx, dy);
  else viewport.rig.pan(dx, dy, viewport.size.height);
  viewport.invalidate();
};
const key_turn = Math.PI / 12; // rad: the number keys turn the view by 15 degrees
const turn_view = (azimuth: number, elevation: number) => (): void => {
  parts.viewport?.rig.turn(azimuth, elevation);
  parts.viewport?.invalidate();
};
/** Looks from the opposite direction, at the same height. */
const opposite_view = (): void => {
  parts.viewport?.rig.turn(Math.PI, 0);
  parts.viewport?.invalidate();
};
/** Returns to the view that the project stores, or to the initial view of new projects. */
const initial_view = (): void => {
  const { viewport } = parts;
  if (!viewport) return;
  const camera = state().document?.camera;
  viewport.rig.look_from(camera?.azimuth ?? 0.7, camera?.elevation ?? 0.25);
  viewport.rig.set({ distance: camera?.distance ?? 5 }, false);
  viewport.invalidate();
};
const zoom_view = (factor: number) => (): void => {
  parts.viewport?.rig.zoom(factor);
  parts.viewport?.invalidate();
};

const posing = (): boolean => poser.state.on && poser.state.target !== null;
const posed_link = (): string | null => {
  const { target } = poser.state;
  const link = parts.posing?.link;
  return target && typeof link === 'number' ? (parts.viewport?.mechanism_of(target.character)?.links[link]?.name ?? null) : null;
};

/** Commands of posing. While a character is posed, they have priority over other commands of the same key. */
const pose_commands: AppCommand[] = [
  { id: 'pose.tool', label: 'Pose characters: rotate joints, drag hands and feet', group: 'Pose', keys: ['E'], enabled: () => (state().document?.characters.length ?? 0) > 0, run: () => poser.switch_on(!poser.state.on) },
  { id: 'pose.key', label: 'Key the selected joint', group: 'Pose', industry: ['S'], blender: ['I'], enabled: posing, run: () => void poser.key_links(posed_link()) },
  { id: 'pose.key_all', label: 'Key the whole character', group: 'Pose', industry: ['Shift+S'], blender: ['Shift+K'], enabled: posing, run: () => void poser.key_links(null) },
  { id: 'pose.auto_key', label: 'Auto-key: every change of a pose sets keys', group: 'Pose', enabled: () => poser.state.on, run: () => poser.set_auto_key(!poser.state.auto_key) },
  { id: 'pose.moves', label: 'Drag moves the limb, the whole body, or the body with dynamics', group: 'Pose', keys: ['G'], enabled: () => poser.state.on, run: () => poser.set_moves(({ limb: 'body', body: 'physics', physics: 'limb' } as const)[poser.state.moves]) },
  { id: 'pose.pin', label: 'Pin the selected link, or remove its pin', group: 'Pose', keys: ['P'], enabled: () => posing() && typeof parts.posing?.link === 'number', run: () => poser.toggle_pin(poser.state.target!.character, parts.posing!.link!) },
  { id: 'pose.store', label: 'Store the pose of the selected character', group: 'Pose', keys: ['Alt+P'], enabled: () => selected_character(state()) !== null, run: () => void store_pose_of_selection() },
  { id: 'pose.mirror', label: 'Mirror the pose', group: 'Pose', keys: ['Shift+M'], enabled: posing, run: () => void poser.apply({ type: 'mirror' }, 'Mirror pose') },
];

const commands: AppCommand[] = [
  { id: 'file.new', label: 'New project…', group: 'Project', keys: ['Ctrl+Alt+N'], enabled: has_document, run: () => session.set({ dialog: 'new' }) },
  { id: 'file.open', label: 'Open project…', group: 'Project', keys: ['Ctrl+O'], enabled: has_document, run: () => session.set({ dialog: 'open' }) },
  { id: 'file.save', label: 'Save', group: 'Project', keys: ['Ctrl+S'], enabled: has_document, run: () => session.save() },
  { id: 'file.save_as', label: 'Save as…', group: 'Project', keys: ['Ctrl+Shift+S'], enabled: has_document, run: () => session.set({ dialog: 'save_as' }) },
  { id: 'file.import', label: 'Import motion or mechanism…', group: 'Project', keys: ['Ctrl+I'], run: () => parts.choose_files() },

  ...([
    ['html', 'one HTML page', '.html'],
    ['native', 'a native program', ''],
    ['glb', 'glTF with the simulated motion', '.glb'],
    ['usda', 'USD with the simulated motion', '.usda'],
    ['csv', 'a table of the simulated motion', '.csv'],
    ['bvh', 'BVH of the selected character', '.bvh'],
  ] as const).map(([form, what, ending]): AppCommand => ({ id: `file.export_${form}`, label: `Export as ${what}…`, group: 'Project', enabled: has_document, run: () => void export_as(form, ending) })),

  { id: 'file.export_picture', label: 'Save a picture of the viewport (PNG)', group: 'Project', keys: ['F2'], enabled: () => has_document() && parts.viewport !== null, run: () => void export_picture() },
  { id: 'file.sweep', label: 'Plot results of a sweep…', group: 'Project', enabled: has_document, run: () => session.set({ dialog: 'sweep' }) },
  { id: 'file.export_measures', label: 'Export naturalness as CSV', group: 'Project', enabled: () => state().measures.frames > 1, run: export_measures },

  { id: 'edit.undo', repeats: true, label: 'Undo', group: 'Edit', keys: ['Ctrl+Z'], enabled: () => state().can_undo, run: () => session.undo() },
  { id: 'edit.redo', repeats: true, label: 'Redo', group: 'Edit', keys: ['Ctrl+Shift+Z', 'Ctrl+Y'], enabled: () => state().can_redo, run: () => session.redo() },
  { id: 'edit.remove', label: 'Delete selection', group: 'Edit', keys: ['Delete', 'Backspace'], blender: ['X'], enabled: () => !['none', 'entry'].includes(state().selection.kind), run: remove_selection },
  { id: 'nest.nest', label: 'Nest the selected tracks in a scenario', group: 'Edit', keys: ['Shift+N'], enabled: () => selected_tracks(state().selection).length > 0, run: () => void nest_selection() },
  { id: 'nest.open', label: 'Open the selected nested scenario', group: 'Edit', enabled: () => selected_instance() !== null, run: () => { const found = selected_instance(); if (found) open_instance(found); } },
  { id: 'nest.unnest', label: 'Unnest: return the tracks of the nested scenario', group: 'Edit', enabled: () => selected_instance() !== null, run: () => { const found = selected_instance(); if (found) void session.edit({ type: 'instance.unnest', id: found.id }); } },
  { id: 'nest.leave', label: 'Leave the nested scenario', group: 'Edit', enabled: () => state().open.length > 0, run: () => leave_to(state().open.length - 1) },
  { id: 'edit.duplicate', label: 'Duplicate', group: 'Edit', keys: ['Ctrl+D'], blender: ['Shift+D'], enabled: () => !['none', 'entry'].includes(state().selection.kind), run: duplicate },
  { id: 'edit.select_all', label: 'Select all clips and events', group: 'Edit', keys: ['Ctrl+A'], enabled: has_document, run: () => { const { document } = state(); if (document) session.select(selection_of(all_items(document))); } },
  { id: 'edit.copy', label: 'Copy clip', group: 'Edit', keys: ['Ctrl+C'], enabled: () => selected_clip() !== null, run: () => { copied = selected_clip(); } },
  {
    id: 'edit.paste', label: 'Paste clip at playhead', group: 'Edit', keys: ['Ctrl+V'], enabled: () => copied !== null && has_document(),
    run: () => {
      if (!copied) return;
      const { selection } = state();
      const character = selection.kind === 'character' || selection.kind === 'clip' ? selection.character : copied.character;
      add_copy(character, copied.clip, Math.round(session.now * 1e6) / 1e6);
    },
  },
  {
    id: 'edit.split', label: 'Split clip at playhead', group: 'Edit', industry: ['S'], blender: ['K'],
    enabled: () => {
      const chosen = selected_clip();
      return chosen !== null && session.now > chosen.clip.start && session.now < chosen.clip.start + chosen.clip.length;
    },
    run: () => {
      const chosen = selected_clip();
      if (chosen) void session.edit({ type: 'clip.split', character: chosen.character, id: chosen.clip.id, time: Math.round(session.now * 1e6) / 1e6 });
    },
  },
  { id: 'edit.gait', label: 'Add a gait: a walk or trot without measured data', group: 'Edit', keys: ['Shift+W'], enabled: () => body_for_gait() !== null, run: add_gait },
  { id: 'edit.push', label: 'Add push at playhead', group: 'Edit', keys: ['Shift+P'], enabled: () => (state().document?.characters.length ?? 0) > 0, run: add_push },
  { id: 'edit.grab', label: 'Add grab of the selected link at playhead', group: 'Edit', keys: ['Shift+G'], enabled: () => (state().document?.characters.length ?? 0) > 0, run: add_grab },
  { id: 'edit.release', label: 'Add release of the selected grab or link at playhead', group: 'Edit', keys: ['Alt+G'], enabled: has_document, run: add_release },
  ...prop_commands,
  { id: 'edit.ripple', label: 'Ripple: edits of clips move everything after them', group: 'Edit', keys: ['Shift+E'], enabled: has_document, run: () => page.setState({ ripple: !page.getState().ripple }) },
  { id: 'edit.insert_time', label: 'Insert 1 s at the playhead: move everything after it', group: 'Edit', enabled: has_document, run: () => { const { document } = state(); if (document) void session.edit(insert_time(document, frame_time(), 1)); } },
  { id: 'marker.add', label: 'Add marker at playhead', group: 'Edit', keys: ['M'], enabled: has_document, run: add_marker },
  { id: 'marker.next', label: 'Go to the next marker', group: 'Transport', keys: ['PageDown'], enabled: () => (state().document?.markers?.length ?? 0) > 0, run: () => go_to_marker(false) },
  { id: 'marker.previous', label: 'Go to the previous marker', group: 'Transport', keys: ['PageUp'], enabled: () => (state().document?.markers?.length ?? 0) > 0, run: () => go_to_marker(true) },
  { id: 'range.in', label: 'Set in point at playhead', group: 'Transport', keys: ['I'], enabled: has_document, run: () => set_range('from') },
  { id: 'range.out', label: 'Set out point at playhead', group: 'Transport', keys: ['Shift+I'], enabled: has_document, run: () => set_range('to') },
  { id: 'range.clear', label: 'Clear in and out', group: 'Transport', keys: ['Alt+I'], enabled: () => Boolean(state().document?.range), run: () => void session.edit({ type: 'scenario.set', range: null }) },
  { id: 'play.loop', label: 'Loop between in and out', group: 'Transport', keys: ['Shift+L'], enabled: has_document, run: () => session.set_loop(!state().transport.loop) },
  { id: 'measure.next', label: 'Go to the next naturalness problem', group: 'Transport', keys: ['Shift+PageDown'], enabled: () => state().measures.frames > 1, run: () => go_to_problem(false) },
  { id: 'measure.previous', label: 'Go to the previous naturalness problem', group: 'Transport', keys: ['Shift+PageUp'], enabled: () => state().measures.frames > 1, run: () => go_to_problem(true) },
  { id: 'edit.camera', label: 'Save this view as the initial view', group: 'Edit', enabled: has_document, run: save_camera },

  { id: 'play.toggle', label: 'Play or pause', group: 'Transport', keys: ['Space'], enabled: has_document, run: () => session.toggle_play() },
  { id: 'play.start', label: 'Go to start', group: 'Transport', keys: ['Shift+ArrowLeft', 'Ctrl+Home'], enabled: has_document, run: () => session.seek(0) },
  { id: 'play.end', label: 'Go to end', group: 'Transport', keys: ['Shift+ArrowRight', 'Ctrl+End'], enabled: has_document, run: () => session.seek(state().transport.mode === 'simulate' && state().transport.simulated > 0 ? state().transport.simulated : content_end(state().document!) || state().document!.duration) },
  { id: 'play.back', repeats: true, label: 'One frame back', group: 'Transport', keys: ['ArrowLeft', ','], enabled: has_document, run: () => session.step(-1) },
  { id: 'play.on', repeats: true, label: 'One frame forward', group: 'Transport', keys: ['ArrowRight', '.'], enabled: has_document, run: () => session.step(1) },
  { id: 'play.restart', label: 'Restart the simulation', group: 'Transport', keys: ['Shift+R'], enabled: () => state().transport.mode === 'simulate', run: () => session.restart() },
  { id: 'mode.toggle', label: 'Switch between Edit and Simulate', group: 'Transport', keys: ['`'], industry: ['Q'], enabled: has_document, run: () => session.set_mode(state().transport.mode === 'edit' ? 'simulate' : 'edit') },
  { id: 'play.controls', label: 'Play controls: send keys, mouse and gamepad to the content', group: 'Transport', keys: ['Shift+Space'], enabled: () => reads_anything(session.controls.devices), run: enter_controls },
  ...[0.25, 0.5, 1, 2].map((speed): AppCommand => ({ id: `play.speed_${speed}`, label: `Speed ${speed}×`, group: 'Transport', run: () => session.set_speed(speed) })),

  { id: 'view.frame', label: 'Frame selection', group: 'View', keys: ['F'], blender: ['NumpadDecimal'], run: () => parts.viewport?.frame_selection() },
  { id: 'view.all', label: 'Frame all', group: 'View', keys: ['A'], run: () => parts.viewport?.frame_all() },
  { id: 'view.follow', label: 'Follow the character with the camera', group: 'View', keys: ['L'], run: toggle('follow') },
  { id: 'view.perspective', label: 'Switch between perspective and orthographic', group: 'View', keys: ['5', 'P'], run: toggle('perspective') },
  { id: 'view.shapes', label: 'Show collision shapes or smooth bodies', group: 'View', keys: ['B'], run: toggle('shapes') },
  { id: 'view.ghosts', label: 'Show or hide ghosts', group: 'View', keys: ['O'], run: toggle('ghosts') },
  { id: 'view.trail', label: 'Show or hide the trail of the centre of mass', group: 'View', keys: ['T'], run: toggle('trail') },
  { id: 'view.compare', label: 'Show or hide the motion before the correction', group: 'View', keys: ['Shift+C'], enabled: () => comparer.state.comparison !== null, run: () => comparer.show(!comparer.state.on) },
  { id: 'view.contacts', label: 'Show or hide contact forces', group: 'View', keys: ['C'], run: toggle('contacts') },
  { id: 'view.closest', label: 'Show or hide distances of the closest points', group: 'View', keys: ['N'], run: toggle('closest') },
  { id: 'view.assist', label: 'Show or hide the root-assist arrow', group: 'View', run: toggle('assist') },
  { id: 'view.front', label: 'View from the front', group: 'View', keys: ['1'], run: look_from(0, 0.02) },
  { id: 'view.left', label: 'View from the left', group: 'View', keys: ['3'], run: look_from(Math.PI / 2, 0.02) },
  ...([['left', 'ArrowLeft', 1, 0], ['right', 'ArrowRight', -1, 0], ['up', 'ArrowUp', 0, 1], ['down', 'ArrowDown', 0, -1]] as const).flatMap(([way, key, x, y]): AppCommand[] => [
    { id: `view.orbit_${way}`, label: `Turn the camera ${way}`, group: 'View', keys: [`Ctrl+${key}`], repeats: true, run: move_view('orbit', x * key_step, y * key_step) },
    { id: `view.pan_${way}`, label: `Move the camera ${way}`, group: 'View', keys: [`Ctrl+Shift+${key}`], repeats: true, run: move_view('pan', x * key_step, y * key_step) },
  ]),
  { id: 'view.nearer', label: 'Move the camera nearer', group: 'View', keys: ['+', '='], repeats: true, run: zoom_view(0.9) },
  { id: 'view.farther', label: 'Move the camera farther away', group: 'View', keys: ['-'], repeats: true, run: zoom_view(1 / 0.9) },
  ...([['left', '4', -key_turn, 0], ['right', '6', key_turn, 0], ['up', '8', 0, key_turn], ['down', '2', 0, -key_turn]] as const).map(([way, key, azimuth, elevation]): AppCommand => ({
    id: `view.turn_${way}`, label: `Turn the view ${way} by 15°`, group: 'View', keys: [key], repeats: true, run: turn_view(azimuth, elevation),
  })),
  { id: 'view.opposite', label: 'View from the opposite side', group: 'View', keys: ['9'], run: opposite_view },
  { id: 'view.initial', label: 'View as stored in the project', group: 'View', keys: ['0'], run: initial_view },
  { id: 'view.top', label: 'View from above', group: 'View', keys: ['7'], run: look_from(-Math.PI / 2, 1.55) },

  { id: 'camera.add', label: 'New camera from this view', group: 'Camera', enabled: has_document, run: () => void add_camera() },
  { id: 'view.through', label: 'Look through the camera, or leave it', group: 'Camera', keys: ['Ctrl+0'], enabled: has_document, run: toggle_through },
  { id: 'camera.place', label: 'Set the camera to the view', group: 'Camera', keys: ['Ctrl+Alt+0'], enabled: has_document, run: place_camera },
  { id: 'camera.key', label: 'Key the view of the camera at the playhead', group: 'Camera', industry: ['K'], enabled: has_document, run: key_view },
  { id: 'camera.cut', label: 'Cut to another camera at the playhead', group: 'Camera', industry: ['X'], enabled: has_document, run: cut_here },
  { id: 'view.draft', label: 'Draft: draw the viewport at a lower resolution', group: 'View', run: toggle_draft },
  { id: 'view.safe', label: 'Show or hide safe frames', group: 'Camera', run: toggle('safe') },
  { id: 'rule.add', label: 'Add a rule for the selected character', group: 'Rules', keys: ['R'], enabled: () => (state().document?.characters.length ?? 0) > 0, run: () => add_rule('pressed') },
  { id: 'circuit.add', label: 'Add an LSI…', group: 'Circuit', enabled: has_canvas, run: () => parts.circuit?.open_search() },
  { id: 'circuit.note', label: 'Add a note', group: 'Circuit', enabled: has_canvas, run: () => circuit.add_note(parts.circuit!.point()) },
  { id: 'circuit.group', label: 'Group the selected LSIs into a circuit', group: 'Circuit', enabled: () => circuit.state.nodes.size > 0, run: () => circuit.group() },
  { id: 'circuit.ungroup', label: 'Ungroup the selected circuit', group: 'Circuit', enabled: () => circuit.chosen !== null, run: () => circuit.ungroup() },
  { id: 'circuit.inside', label: 'Open the selected circuit', group: 'Circuit', enabled: () => circuit.chosen !== null, run: () => { if (circuit.chosen) circuit.go_inside(circuit.chosen); } },
  { id: 'circuit.outside', label: 'Leave this circuit', group: 'Circuit', enabled: () => circuit.state.path.length > 0, run: () => circuit.go_out() },
  { id: 'circuit.layout', label: 'Lay out the circuit', group: 'Circuit', enabled: has_canvas, run: () => parts.circuit?.lay_out() },
  { id: 'circuit.fit', label: 'Show the whole circuit', group: 'Circuit', enabled: has_canvas, run: () => parts.circuit?.fit() },
  { id: 'circuit.reset', label: 'Reset the circuit to the generated one', group: 'Circuit', enabled: () => circuit.state.edited, run: () => circuit.reset_to_generated() },

  { id: 'page.fit', label: 'Fit the timeline', group: 'Page', keys: ['Home'], run: () => parts.fit_timeline() },
  { id: 'page.palette', label: 'All commands…', group: 'Page', keys: ['Ctrl+K', 'Ctrl+P'], run: () => session.set({ dialog: state().dialog === 'palette' ? 'none' : 'palette' }) },
  { id: 'page.keys', label: 'Show keyboard shortcuts', group: 'Page', keys: ['?', 'F1'], run: () => session.set({ dialog: state().dialog === 'keys' ? 'none' : 'keys' }) },
  { id: 'page.edit_keys', label: 'Change keys…', group: 'Page', run: () => session.set({ dialog: 'edit_keys' }) },
  { id: 'page.tour', label: 'Take the tour', group: 'Page', run: () => { session.set({ dialog: 'none' }); page.setState({ tour: 0 }); } },
  { id: 'page.theme', label: 'Switch between dark and light theme', group: 'Page', run: () => { session.set({ theme: state().theme === 'dark' ? 'light' : 'dark' }); session.remember(); } },
  { id: 'page.keymap', label: 'Switch keymap: industry or Blender-like', group: 'Page', run: () => {
    session.set({ keymap: state().keymap === 'industry' ? 'blender' : 'industry' });
    session.remember();
    session.notify(state().keymap === 'industry' ? 'Keymap: industry' : 'Keymap: Blender-like');
  } },
  { id: 'page.large', label: 'Maximise or restore the panel', group: 'Page', keys: ['Ctrl+Space'], run: () => parts.toggle_maximized() },
  { id: 'page.layout', label: 'Reset the layout', group: 'Page', run: () => parts.reset_layout() },
  { id: 'library.search', label: 'Search the library', group: 'Page', keys: ['/'], run: () => parts.search_library() },
  ...(['library', 'poses', 'inspector', 'look', 'scenario', 'curves', 'rules', 'circuit', 'naturalness', 'plots', 'log'] as const).map((panel): AppCommand => ({ id: `page.${panel}`, label: `Show ${panel}`, group: 'Page', run: () => parts.show_panel(panel) })),
  {
    id: 'page.escape', label: 'Close, release or deselect', group: 'Page', keys: ['Escape'],
    run: () => {
      if (state().dialog !== 'none') return session.set({ dialog: 'none' });
      if (page.getState().tour !== null) return end_tour();
      if (parts.pointer?.abandon() || poser.restore()) return;
      if (poser.state.on && (state().selection.kind === 'character' || state().selection.kind === 'none')) return poser.switch_on(false);
      if (state().selection.kind === 'none' && state().open.length > 0) return leave_to(state().open.length - 1);
      session.select({ kind: 'none' });
    },
  },
];

export function register_commands(): void {
  registry.add(...pose_commands, ...commands);
}

export function run(id: string): void {
  registry.run(id);
}
