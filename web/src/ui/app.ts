/** The page's single instances of session, editors, library and command list, and the React hooks that read their state. */
import { useStore } from 'zustand';
import { createStore } from 'zustand/vanilla';
import { Access } from '../core/access';
import { find_clip } from '../core/document';
import { condition_alone } from '../core/circuit/breakpoints';
import { CircuitEditor, type EditorState } from '../core/circuit/editor';
import { CommandRegistry } from '../core/commands';
import type { CharacterState } from '../core/frames';
import { LibraryBrowser, type BrowserState } from '../core/library/browser';
import { ImportQueue, type ImportState } from '../core/library/imports';
import { Comparer, type CompareState } from '../core/motion/comparer';
import { MotionDesk, type DeskState } from '../core/motion/desk';
import { GaitDesk, type GaitState } from '../core/motion/gait';
import { Poser, type PoserState } from '../core/posing/poser';
import { Session } from '../core/session';
import { shown_circuit, type StudioState } from '../core/state';
import type { SocketLike } from '../core/client';
import type { ImportView } from '../view/import_view';
import type { Viewport } from '../view/viewport';
import type { PointerControl } from '../view/pointer';
import type { PoseView } from '../view/pose_view';

export const access = new Access({
  fragment: () => location.hash,
  clear_fragment: () => history.replaceState(null, '', location.pathname + location.search),
  storage: sessionStorage,
  fetch: (path, init) => fetch(path, init),
});

function socket_address(): string {
  const address = new URL('ws', location.href);
  address.protocol = location.protocol === 'https:' ? 'wss:' : 'ws:';
  return address.href;
}

export const session = new Session({
  make_socket: () => new WebSocket(socket_address(), access.subprotocols) as unknown as SocketLike,
  fetch: (path, init) => access.fetch(path, init),
});

export const circuit = new CircuitEditor({ edit: (command) => session.edit(command), notify: (text) => session.notify(text) });
session.store.subscribe((state, before) => {
  if (state.document === before.document && state.preview === before.preview && state.generated === before.generated && state.classes === before.classes && state.circuit_problems === before.circuit_problems && state.stop_problems === before.stop_problems) return;
  const shown = shown_circuit(state);
  circuit.show(shown.circuit, shown.edited, state.classes, state.circuit_problems, state.stop_problems);
});
// the wiring editor marks the pin at which a run stopped; while it is not mounted, a notice is shown instead
session.store.subscribe((state, before) => {
  const { breakpoint_hit } = state;
  if (!breakpoint_hit || breakpoint_hit === before.breakpoint_hit || parts.circuit) return;
  session.notify(`Stopped at ${breakpoint_hit.time.toFixed(3)} s: ${circuit.name_of(breakpoint_hit.pin)} ${condition_alone(breakpoint_hit)}`);
});
// a selection in the wiring editor replaces the page's selection, so that the inspector shows the later of the two selections
circuit.store.subscribe((state, before) => {
  if (state.nodes === before.nodes && state.wires === before.wires) return;
  const any = state.nodes.size + state.wires.size > 0;
  if (any) session.select({ kind: 'circuit' });
  else if (session.state.selection.kind === 'circuit') session.select({ kind: 'none' });
});

export const library = new LibraryBrowser({
  fetch: (path, init) => access.fetch(path, init),
  cache_entries: (entries) => session.cache_entries(entries),
  fail: (error) => session.fail(error),
});
session.on_library = () => void library.load();

export const imports = new ImportQueue({
  fetch: (path, init) => access.fetch(path, init),
  log: (level, text) => session.log(level, text),
  stored: (item) => {
    const entry = item.stored.find((e) => e.kind === 'motion') ?? item.stored[0];
    if (entry && item.prop_at && item.staged?.mesh) parts.add_mesh(entry.id, item.prop_at);
    else if (entry) session.select({ kind: 'entry', entry: entry.id });
  },
});

export const desk = new MotionDesk({
  request: (request) => session.ask(request),
  fetch: (path) => access.fetch(path),
  fail: (error) => session.fail(error),
  report: (title, lines) => session.report(title, lines),
  log_report: (title, lines) => session.log_report(title, lines),
  select: (selection) => session.select(selection),
  clip: ({ character, clip }) => (session.state.document ? find_clip(session.state.document, character, clip) : undefined),
  corrected: ({ character, clip }, before, report) => comparer.begin(character, clip, before, report),
});

export const comparer: Comparer = new Comparer({ ask: (request) => session.ask(request), document: () => session.state.document });
session.store.subscribe((state, before) => {
  if (state.document !== before.document) comparer.check();
});

export const gaits = new GaitDesk({
  ask: (request) => session.ask(request),
  make: (request) => desk.make_gait(request),
  fail: (error) => session.fail(error),
});

export const poser = new Poser(session);

// looks up, once each, the mechanisms and motions of the scenario that are not among the loaded library entries
const requested = new Set<string>();
session.store.subscribe((state, before) => {
  if (state.document === before.document) return;
  for (const character of state.document?.characters ?? []) {
    for (const clip of character.track) void desk.need_contacts(clip.motion);
    for (const id of [character.mechanism, ...character.track.map((clip) => clip.motion)]) {
      if (session.entry(id) || requested.has(id)) continue;
      requested.add(id);
      void library.find(id);
    }
  }
});

/** Fetches a path of the service, with the access token. */
export const service_fetch = (path: string, init?: RequestInit): Promise<Response> => access.fetch(path, init);

/** Options for small 2D canvases: draw them on the CPU, so that the page does not wait for a busy GPU. */
export const plain_canvas: CanvasRenderingContext2DSettings = { willReadFrequently: true };

export const registry = new CommandRegistry();
session.store.subscribe((state) => {
  registry.edits = state.key_edits;
});

/** State of the page that is not part of the session. */
export interface PageState {
  character_states: Record<string, CharacterState>;
  /** Id of the library entry that is being dragged. Kept here because browsers hide the drag data until the drop. */
  dragged_entry: string | null;
  /** True: edits of clips move everything after them. */
  ripple: boolean;
  /** Names of the folded groups of tracks. */
  folded: ReadonlySet<string>;
  /** Index of the shown step of the tour; null: the tour is not shown. */
  tour: number | null;
}
export const page = createStore<PageState>(() => ({ character_states: {}, dragged_entry: null, ripple: false, folded: new Set(), tour: null }));

/** Functions of the mounted canvas of the wiring editor, for commands and for the end-to-end tests. */
export interface CircuitCanvas {
  fit(ids?: ReadonlySet<string>): void;
  /** Circuit coordinates under the pointer, or of the canvas centre while the pointer is elsewhere. */
  point(): [number, number];
  open_search(): void;
  lay_out(): void;
  /** Counts and times of the drawing, read by the end-to-end tests. */
  facts(): Record<string, unknown>;
}

/** Mounted views and functions of panels; null or without effect while the panel is not mounted. */
export const parts: { viewport: Viewport | null; pointer: PointerControl | null; posing: PoseView | null; fit_timeline: () => void; reset_layout: () => void; toggle_maximized: () => void; show_panel: (id: string) => void; search_library: () => void; choose_files: () => void; import_view: ImportView | null; circuit: CircuitCanvas | null; drawn_keys: () => { x: number; y: number }[]; add_mesh: (entry: string, at: { x: number; y: number }) => void } = {
  viewport: null,
  pointer: null,
  posing: null,
  fit_timeline: () => undefined,
  reset_layout: () => undefined,
  toggle_maximized: () => undefined,
  show_panel: () => undefined,
  search_library: () => undefined,
  choose_files: () => undefined,
  import_view: null,
  circuit: null,
  drawn_keys: () => [],
  add_mesh: () => undefined,
};

export function useStudio<T>(pick: (state: StudioState) => T): T {
  return useStore(session.store, pick);
}

export function useCircuit<T>(pick: (state: EditorState) => T): T {
  return useStore(circuit.store, pick);
}

export function useLibrary<T>(pick: (state: BrowserState) => T): T {
  return useStore(library.store, pick);
}

export function useImports<T>(pick: (state: ImportState) => T): T {
  return useStore(imports.store, pick);
}

export function useControls<T>(pick: (state: ReturnType<typeof session.controls.store.getState>) => T): T {
  return useStore(session.controls.store, pick);
}

export function useComparer<T>(pick: (state: CompareState) => T): T {
  return useStore(comparer.store, pick);
}

export function useDesk<T>(pick: (state: DeskState) => T): T {
  return useStore(desk.store, pick);
}

export function useGaits<T>(pick: (state: GaitState) => T): T {
  return useStore(gaits.store, pick);
}

export function usePoser<T>(pick: (state: PoserState) => T): T {
  return useStore(poser.store, pick);
}

export function usePage<T>(pick: (state: PageState) => T): T {
  return useStore(page, pick);
}
