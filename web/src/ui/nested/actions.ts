/** Actions on nested scenarios: nest, open, leave, place, duplicate. */
import { content_end, with_room, type Command, type ScenarioInstance } from '../../core/document';
import { find_instance, find_scenario, nest_name, selected_tracks } from '../../core/nested';
import { session } from '../app';

/**
 * Shows another scenario: the last one of these inner scenarios, or the outermost one.
 * @param time playhead in that scenario, s
 */
async function enter(path: readonly string[], time: number): Promise<void> {
  session.select({ kind: 'none' });
  try {
    await session.ask({ op: 'enter', path });
    session.seek(time);
  } catch (error) {
    session.fail(error as Error);
  }
}

/** Moves the selected tracks to a new inner scenario, and selects its instance. */
export async function nest_selection(): Promise<void> {
  const { document, selection } = session.state;
  if (!document) return;
  const tracks = selected_tracks(selection);
  if (tracks.length === 0) return session.notify('Select the tracks to nest first: click their names, with Ctrl for more than one.');
  const before = new Set((document.instances ?? []).map((i) => i.id));
  const instances = tracks.filter((t) => find_instance(document, t));
  const characters = tracks.filter((t) => !instances.includes(t));
  if (!(await session.edit({ type: 'scenario.nest', name: nest_name(document, tracks), characters, ...(instances.length > 0 ? { instances } : {}) }))) return;
  select_new(before);
}

/** Selects the instance that was not there before. */
function select_new(before: ReadonlySet<string>): void {
  const added = session.state.document?.instances?.find((i) => !before.has(i.id));
  if (added) session.select({ kind: 'instance', instance: added.id });
}

/** Starts of the instances through which the user entered the open scenarios, s. */
const entered: number[] = [];

/** Shows the inside of an instance. The playhead stays at the same moment. */
export function open_instance(instance: ScenarioInstance): void {
  const { open, document } = session.state;
  const length = (document && find_scenario(document, instance.scenario)?.duration) ?? Infinity;
  entered[open.length] = instance.start;
  void enter([...open, instance.scenario], Math.min(length, Math.max(0, session.now - instance.start)));
}

/** Shows an inner scenario from its beginning. */
export function open_scenario(scenario: string): void {
  entered[session.state.open.length] = 0;
  void enter([...session.state.open, scenario], 0);
}

/** Returns to the scenario at this level of the open ones; 0: the outermost one. */
export function leave_to(level: number): void {
  const { open } = session.state;
  const shift = open.slice(level).reduce((sum, _id, i) => sum + (entered[level + i] ?? 0), 0);
  void enter(open.slice(0, level), session.now + shift);
}

/** Adds an instance with these fields, makes room for it in time, and selects it. */
async function add_instance(fields: Omit<Extract<Command, { type: 'instance.add' }>, 'type'>, label: string): Promise<boolean> {
  const { document } = session.state;
  if (!document) return false;
  const before = new Set((document.instances ?? []).map((i) => i.id));
  const end = (fields.start ?? 0) + (find_scenario(document, fields.scenario)?.duration ?? 0);
  const accepted = await session.edit(with_room(document, { type: 'instance.add', ...fields }, Math.max(end, content_end(document)), label));
  if (accepted) select_new(before);
  return accepted;
}

const spacing = 2; // m, from an instance to its copy

/** Places a copy beside the instance, to its right. */
export function duplicate_instance(instance: ScenarioInstance): Promise<boolean> {
  const { scenario, start, place } = instance;
  const turn = (place.heading * Math.PI) / 180;
  const round = (v: number): number => Math.round(v * 1000) / 1000;
  const beside = { ...place, x: round(place.x + spacing * Math.sin(turn)), y: round(place.y - spacing * Math.cos(turn)) };
  return add_instance({ scenario, start, place: beside }, `Duplicate ${instance.name}`);
}

/** Places an inner scenario at the playhead. */
export function place_scenario(scenario: string): void {
  const start = Math.round(session.now * 1e3) / 1e3;
  void add_instance({ scenario, start }, 'Place scenario');
}
