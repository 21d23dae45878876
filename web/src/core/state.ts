/** The page's state: what React draws. Frames are not in it; they go from the ring straight to the viewport. */
import type { ScenarioDocument } from './document';
import type { KeymapName } from './keymap';
import type { Breakpoint, BreakpointHit } from './circuit/breakpoints';
import { ClassList } from './circuit/classes';
import type { Circuit } from './circuit/form';
import type { CharacterInfo, LogLine, MechanismData, Problem, ProjectInfo, Summary, Transport } from './protocol';

export type Selection =
  | { kind: 'none' }
  | { kind: 'character'; character: string; link?: number }
  | { kind: 'clip'; character: string; clip: string }
  | { kind: 'event'; event: string }
  | { kind: 'entry'; entry: string }
  /** What is selected in the wiring editor, which knows it. */
  | { kind: 'circuit' };

export interface Toast {
  id: number;
  level: 'info' | 'error';
  problems: Problem[];
}

export interface ViewOptions {
  perspective: boolean;
  ghosts: boolean;
  trail: boolean;
  contacts: boolean;
  /** Lines between the nearest points of figures and things, with the distance. */
  nearest: boolean;
  follow: boolean;
  assist: boolean;
}

export interface LoggedLine extends LogLine {
  id: number;
  at: Date;
}

export interface StudioState {
  connection: 'connecting' | 'open' | 'lost';
  /** Date.now() at which the next attempt starts. */
  retry_at: number;
  project: ProjectInfo | null;
  /** The service's truth. */
  document: ScenarioDocument | null;
  /** The document while a drag or an unanswered edit is shown; null: `document` is what counts. */
  preview: ScenarioDocument | null;
  revision: number;
  can_undo: boolean;
  can_redo: boolean;
  undo_label: string;
  redo_label: string;
  characters: CharacterInfo[];
  transport: Transport;
  summary: Summary;
  /** The circuit that the generator makes; the document's own, where it has one, goes before it. */
  generated: Circuit | null;
  classes: ClassList;
  /** Why the circuit does not run. */
  circuit_problems: Problem[];
  log: LoggedLine[];
  /** Reason why the interpreter stopped, until the next start or until it was read. */
  stopped: string | null;
  /** What stopped it, by place, until it runs again. */
  stop_problems: Problem[];
  /** Where runs stop; and what the run stands at. */
  breakpoints: readonly Breakpoint[];
  broken: BreakpointHit | null;
  /** Grows when Session.entry() may answer otherwise than before. */
  library_revision: number;
  mechanisms: Record<string, MechanismData>;
  selection: Selection;
  view: ViewOptions;
  keymap: KeymapName;
  theme: 'dark' | 'light';
  toasts: Toast[];
  dialog: 'none' | 'palette' | 'keys' | 'save_as';
}

export const initial_transport: Transport = {
  mode: 'edit',
  playing: false,
  speed: 1,
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
  document: null,
  preview: null,
  revision: -1,
  can_undo: false,
  can_redo: false,
  undo_label: '',
  redo_label: '',
  characters: [],
  transport: initial_transport,
  summary: { characters: [], contacts: [] },
  generated: null,
  classes: new ClassList(),
  circuit_problems: [],
  log: [],
  stopped: null,
  stop_problems: [],
  breakpoints: [],
  broken: null,
  library_revision: 0,
  mechanisms: {},
  selection: { kind: 'none' },
  view: { perspective: true, ghosts: false, trail: false, contacts: false, nearest: false, follow: false, assist: true },
  keymap: 'industry',
  theme: 'dark',
  toasts: [],
  dialog: 'none',
};

/** What the user chose in another page or at another time; whatever it is, only known words count. */
export function read_choices(choices: unknown): Pick<StudioState, 'keymap' | 'theme' | 'view'> {
  const { keymap, theme, view } = (typeof choices === 'object' && choices !== null ? choices : {}) as Record<string, unknown>;
  const kept = { ...initial_state.view };
  for (const key of Object.keys(kept) as (keyof ViewOptions)[]) {
    const value = (view as Record<string, unknown> | null | undefined)?.[key];
    if (typeof value === 'boolean' && key !== 'follow') kept[key] = value;
  }
  return { keymap: keymap === 'blender' ? 'blender' : 'industry', theme: theme === 'light' ? 'light' : 'dark', view: kept };
}

/** The document to draw. */
export const shown_document = (state: StudioState): ScenarioDocument | null => state.preview ?? state.document;

/** The circuit to draw, and whether it is the project's own. */
export function shown_circuit(state: StudioState): { circuit: Circuit | null; edited: boolean } {
  const own = shown_document(state)?.circuit as Circuit | null | undefined;
  return own ? { circuit: own, edited: true } : { circuit: state.generated, edited: false };
}

/** The character that the selection belongs to. */
export function selected_character(state: StudioState): string | null {
  const { selection } = state;
  if (selection.kind === 'character' || selection.kind === 'clip') return selection.character;
  if (selection.kind === 'event') return state.document?.events.find((e) => e.id === selection.event)?.character ?? null;
  return null;
}

/** The selection, or none if what it names is no longer in `document`. */
export function valid_selection(selection: Selection, document: ScenarioDocument): Selection {
  const none: Selection = { kind: 'none' };
  switch (selection.kind) {
    case 'character':
      return document.characters.some((c) => c.id === selection.character) ? selection : none;
    case 'clip': {
      const character = document.characters.find((c) => c.id === selection.character);
      if (character?.track.some((k) => k.id === selection.clip)) return selection;
      return character ? { kind: 'character', character: character.id } : none;
    }
    case 'event':
      return document.events.some((e) => e.id === selection.event) ? selection : none;
    default:
      return selection;
  }
}
