/** The page's state, drawn by React. Frames are not part of it: the viewport reads them from the FrameRing. */
import type { ScenarioDocument } from './document';
import { tracks_selection } from './nested';
import { valid_items, type Item } from './items';
import { no_key_edits, read_key_edits, type KeyEdits } from './key_edits';
import type { KeymapName } from './keymap';
import type { Breakpoint, BreakpointHit } from './circuit/breakpoints';
import { ClassList } from './circuit/classes';
import type { Circuit } from './circuit/form';
import { MeasureHistory } from './measures';
import type { CharacterInfo, LogLine, MechanismData, Problem, ProjectInfo, PulledEvent, RecentProject, RecordedEvent, Summary, Transport, UsedLibrary } from './protocol';

export type Selection =
  | { kind: 'none' }
  | { kind: 'character'; character: string; link?: number }
  /** A placed inner scenario. */
  | { kind: 'instance'; instance: string }
  /** Two or more tracks: ids of characters and instances. */
  | { kind: 'tracks'; tracks: readonly string[] }
  | { kind: 'clip'; character: string; clip: string }
  | { kind: 'event'; event: string }
  /** Two or more clips and events. */
  | { kind: 'items'; items: readonly Item[] }
  | { kind: 'marker'; marker: string }
  | { kind: 'camera'; camera: string }
  | { kind: 'shot'; shot: string }
  | { kind: 'rule'; rule: string }
  | { kind: 'variable'; variable: string }
  | { kind: 'entry'; entry: string }
  /** The selection is in the wiring editor (EditorState). */
  | { kind: 'circuit' };

export interface Toast {
  id: number;
  level: 'info' | 'error';
  problems: Problem[];
}

/** Key under which a browser keeps ViewOptions.draft: 'on' or 'off'. */
export const draft_key = 'ugoki.draft';

export interface ViewOptions {
  perspective: boolean;
  ghosts: boolean;
  trail: boolean;
  contacts: boolean;
  /** Show lines between the closest points of characters and objects, with their distance. */
  closest: boolean;
  /** Show the collision shapes of bodies instead of their smooth surface. */
  shapes: boolean;
  follow: boolean;
  assist: boolean;
  /** The safe areas of the picture are drawn while the view is that of a camera of the document. */
  safe: boolean;
  /** The viewport is drawn at a lower resolution, for machines without a graphics processor. Saved pictures keep their resolution. */
  draft: boolean;
}

export interface LoggedLine extends LogLine {
  id: number;
  at: Date;
}

export interface StudioState {
  /** `refused`: the service does not accept this page's token; the page does not try to connect. */
  connection: 'connecting' | 'open' | 'lost' | 'refused';
  /** Time of the next attempt to connect, as returned by Date.now(), ms. */
  retry_at: number;
  project: ProjectInfo | null;
  /** Number of projects opened in place of the first one. */
  opened: number;
  /** Recently opened projects, newest first; the first is the open one. */
  recent: readonly RecentProject[];
  /** The document as the service has it. */
  document: ScenarioDocument | null;
  /** The document to show during a drag or an unanswered edit; null: show `document`. */
  preview: ScenarioDocument | null;
  /** Ids of the inner scenarios through which the user came to the shown one; empty: the outermost scenario is shown. */
  open: readonly string[];
  /** Name of the outermost scenario. */
  outermost: string;
  revision: number;
  can_undo: boolean;
  can_redo: boolean;
  undo_label: string;
  redo_label: string;
  characters: CharacterInfo[];
  transport: Transport;
  summary: Summary;
  /** Measures of the simulated motion over time. A new object after every change. */
  measures: MeasureHistory;
  /** The last answer to a request `recorded`; null: none in this project. */
  recorded: RecordedEvent | null;
  /** The generated circuit; used only if the document has no circuit of its own. */
  generated: Circuit | null;
  classes: ClassList;
  /** Problems that keep the circuit from running. */
  circuit_problems: Problem[];
  log: LoggedLine[];
  /** Why the interpreter stopped; null after the next start or after the user dismissed it. */
  stopped: string | null;
  /** Problems that stopped the interpreter, with their locations; empty while it runs. */
  stop_problems: Problem[];
  breakpoints: readonly Breakpoint[];
  /** The breakpoint at which the run is paused; null if none. */
  breakpoint_hit: BreakpointHit | null;
  /** Incremented when the result of Session.entry() may have changed. */
  library_revision: number;
  mechanisms: Record<string, MechanismData>;
  selection: Selection;
  /** The last pull of the user, which can become an event; null: none. */
  pulled: PulledEvent | null;
  view: ViewOptions;
  keymap: KeymapName;
  /** Keys that the user has changed. */
  key_edits: KeyEdits;
  theme: 'dark' | 'light';
  toasts: Toast[];
  /** The camera of the viewport: 'free' (moved by the user), 'shots' (the shot at the playhead), or the id of a camera of the document. */
  through: string;
  dialog: 'none' | 'palette' | 'keys' | 'edit_keys' | 'save_as' | 'open' | 'new' | 'sweep' | 'carry';
  /** Installed libraries whose LSIs the content uses, while the dialog 'carry' asks whether a native program may carry them. */
  used_libraries: UsedLibrary[];
}

export const initial_transport: Transport = {
  mode: 'edit',
  playing: false,
  speed: 1,
  loop: false,
  time: 0,
  duration: 0,
  simulated: 0,
  steps_per_s: 0,
  realtime_factor: 0,
  status: '',
};

export const initial_state: StudioState = {
  connection: 'connecting',
  retry_at: 0,
  project: null,
  opened: 0,
  recent: [],
  document: null,
  preview: null,
  open: [],
  outermost: '',
  revision: -1,
  can_undo: false,
  can_redo: false,
  undo_label: '',
  redo_label: '',
  characters: [],
  transport: initial_transport,
  summary: { characters: [], contacts: [] },
  measures: new MeasureHistory(),
  recorded: null,
  generated: null,
  classes: new ClassList(),
  circuit_problems: [],
  log: [],
  stopped: null,
  stop_problems: [],
  breakpoints: [],
  breakpoint_hit: null,
  library_revision: 0,
  mechanisms: {},
  selection: { kind: 'none' },
  pulled: null,
  view: { perspective: true, ghosts: false, trail: false, contacts: false, closest: false, shapes: false, follow: false, assist: true, safe: true, draft: false },
  keymap: 'industry',
  key_edits: no_key_edits,
  theme: 'dark',
  toasts: [],
  through: 'free',
  dialog: 'none',
  used_libraries: [],
};

/** Choices that the user made in another page or session. Unknown keys and values of a wrong type are ignored. */
export function read_choices(choices: unknown): Pick<StudioState, 'keymap' | 'key_edits' | 'theme' | 'view'> {
  const { keymap, keys, theme, view } = (typeof choices === 'object' && choices !== null ? choices : {}) as Record<string, unknown>;
  const kept = { ...initial_state.view };
  const stored = (view ?? {}) as Record<string, unknown>;
  for (const key of Object.keys(kept) as (keyof ViewOptions)[]) {
    const value = stored[key] ?? (key === 'closest' ? stored.nearest : undefined); // `nearest` is the old name of `closest`
    if (typeof value === 'boolean' && key !== 'follow') kept[key] = value;
  }
  return { keymap: keymap === 'blender' ? 'blender' : 'industry', key_edits: read_key_edits(keys).edits, theme: theme === 'light' ? 'light' : 'dark', view: kept };
}

/** The document to draw: the preview if there is one, otherwise the service's document. */
export const shown_document = (state: StudioState): ScenarioDocument | null => state.preview ?? state.document;

/** The circuit to draw. `edited`: it is the project's own circuit, not the generated one. */
export function shown_circuit(state: StudioState): { circuit: Circuit | null; edited: boolean } {
  const own = shown_document(state)?.circuit as Circuit | null | undefined;
  return own ? { circuit: own, edited: true } : { circuit: state.generated, edited: false };
}

/** Id of the character that the selection belongs to, or null. */
export function selected_character(state: StudioState): string | null {
  const { selection } = state;
  if (selection.kind === 'character' || selection.kind === 'clip') return selection.character;
  if (selection.kind === 'items') return selection.items.find((item) => item.kind === 'clip')?.character ?? null;
  if (selection.kind === 'event') return state.document?.events.find((e) => e.id === selection.event)?.character ?? null;
  return null;
}

/** The selection if its object is still in `document`. Otherwise the clip's character, or no selection. */
export function valid_selection(selection: Selection, document: ScenarioDocument): Selection {
  const none: Selection = { kind: 'none' };
  switch (selection.kind) {
    case 'character':
      return document.characters.some((c) => c.id === selection.character) ? selection : none;
    case 'instance':
      return document.instances?.some((i) => i.id === selection.instance) ? selection : none;
    case 'tracks': {
      const tracks = selection.tracks.filter((t) => document.characters.some((c) => c.id === t) || document.instances?.some((i) => i.id === t));
      return tracks_selection(document, tracks);
    }
    case 'clip': {
      const character = document.characters.find((c) => c.id === selection.character);
      if (character?.track.some((k) => k.id === selection.clip)) return selection;
      return character ? { kind: 'character', character: character.id } : none;
    }
    case 'event':
      return document.events.some((e) => e.id === selection.event) ? selection : none;
    case 'items':
      return valid_items(selection, document);
    case 'rule':
      return document.rules?.some((r) => r.id === selection.rule) ? selection : none;
    case 'variable':
      return document.variables?.some((v) => v.id === selection.variable) ? selection : none;
    case 'camera':
      return document.cameras?.some((c) => c.id === selection.camera) ? selection : none;
    case 'shot':
      return document.shots?.some((s) => s.id === selection.shot) ? selection : none;
    case 'marker':
      return document.markers?.some((m) => m.id === selection.marker) ? selection : none;
    default:
      return selection;
  }
}
