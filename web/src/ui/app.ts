/** The one session and command list of this page, and React's way to them. */
import { useStore } from 'zustand';
import { createStore } from 'zustand/vanilla';
import { condition_alone } from '../core/circuit/breakpoints';
import { CircuitEditor, type EditorState } from '../core/circuit/editor';
import { CommandRegistry } from '../core/commands';
import type { FigureState } from '../core/frames';
import { LibraryBrowser, type BrowserState } from '../core/library/browser';
import { ImportQueue, type ImportState } from '../core/library/imports';
import { MotionDesk, type DeskState } from '../core/motion/desk';
import { Session } from '../core/session';
import { shown_circuit, type StudioState } from '../core/state';
import type { SocketLike } from '../core/client';
import type { ImportView } from '../view/import_view';
import type { Viewport } from '../view/viewport';
import type { PointerControl } from '../view/pointer';

/** Where the service is: the page's own address, and the token if the address has one. */
const token = new URLSearchParams(location.search).get('token');
const with_token = (path: string): string => (token ? `${path}${path.includes('?') ? '&' : '?'}token=${encodeURIComponent(token)}` : path);

function socket_address(): string {
  const address = new URL(with_token('ws'), location.href);
  address.protocol = location.protocol === 'https:' ? 'wss:' : 'ws:';
  return address.href;
}

export const session = new Session({
  make_socket: () => new WebSocket(socket_address()) as unknown as SocketLike,
  fetch: (path, init) => fetch(with_token(path), init),
});

export const circuit = new CircuitEditor({ edit: (command) => session.edit(command), notify: (text) => session.notify(text) });
session.store.subscribe((state, before) => {
  if (state.document === before.document && state.preview === before.preview && state.generated === before.generated && state.classes === before.classes && state.circuit_problems === before.circuit_problems && state.stop_problems === before.stop_problems) return;
  const shown = shown_circuit(state);
  circuit.show(shown.circuit, shown.edited, state.classes, state.circuit_problems, state.stop_problems);
});
// the wiring editor shows where a run stopped; while it is not in sight, a notice tells it
session.store.subscribe((state, before) => {
  const { broken } = state;
  if (!broken || broken === before.broken || parts.circuit) return;
  session.notify(`Stopped at ${broken.time.toFixed(3)} s: ${circuit.name_of(broken.pin)} ${condition_alone(broken)}`);
});
// what is selected last, there or elsewhere in the page, is what the inspector shows
circuit.store.subscribe((state, before) => {
  if (state.nodes === before.nodes && state.wires === before.wires) return;
  const any = state.nodes.size + state.wires.size > 0;
  if (any) session.select({ kind: 'circuit' });
  else if (session.state.selection.kind === 'circuit') session.select({ kind: 'none' });
});

export const library = new LibraryBrowser({
  fetch: (path, init) => fetch(with_token(path), init),
  know: (entries) => session.know(entries),
  fail: (error) => session.fail(error),
});
session.on_library = () => void library.load();

export const imports = new ImportQueue({
  fetch: (path, init) => fetch(with_token(path), init),
  log: (level, text) => session.log(level, text),
  stored: (item) => {
    const made = item.stored.find((e) => e.kind === 'motion') ?? item.stored[0];
    if (made) session.select({ kind: 'entry', entry: made.id });
  },
});

export const desk = new MotionDesk({
  request: (request) => session.ask(request),
  fetch: (path) => fetch(with_token(path)),
  fail: (error) => session.fail(error),
  tell: (title, lines) => session.tell(title, lines),
  select: (selection) => session.select(selection),
});

// motions of the scenario that no page of the library has brought yet: looked up once each
const asked = new Set<string>();
session.store.subscribe((state, before) => {
  if (state.document === before.document) return;
  for (const character of state.document?.characters ?? []) {
    for (const clip of character.track) void desk.need_contacts(clip.motion);
    for (const id of [character.mechanism, ...character.track.map((clip) => clip.motion)]) {
      if (session.entry(id) || asked.has(id)) continue;
      asked.add(id);
      void library.find(id);
    }
  }
});

/** An address of the service for an image. */
export const service_path = (path: string): string => with_token(path);

/** Small canvases are drawn by the processor: sent to a busy graphics processor they would make the page wait. */
export const plain_canvas: CanvasRenderingContext2DSettings = { willReadFrequently: true };

export const registry = new CommandRegistry();

/** Small facts of the page that are not the session's. */
export interface PageState {
  figure_states: Record<string, FigureState>;
  /** The library entry that is dragged: a browser hides it from those it hovers over. */
  dragged_entry: string | null;
}
export const page = createStore<PageState>(() => ({ figure_states: {}, dragged_entry: null }));

/** What the mounted canvas of the wiring editor can do. */
export interface CircuitCanvas {
  fit(ids?: ReadonlySet<string>): void;
  /** The plane's point in the middle of the canvas, or under the pointer if it is over it. */
  point(): [number, number];
  open_search(): void;
  lay_out(): void;
  /** For journeys: what is drawn, and how fast. */
  facts(): Record<string, unknown>;
}

/** What is mounted now; null while it is not. */
export const parts: { viewport: Viewport | null; pointer: PointerControl | null; fit_timeline: () => void; reset_layout: () => void; toggle_large: () => void; show_panel: (id: string) => void; choose_files: () => void; import_view: ImportView | null; circuit: CircuitCanvas | null } = {
  viewport: null,
  pointer: null,
  fit_timeline: () => undefined,
  reset_layout: () => undefined,
  toggle_large: () => undefined,
  show_panel: () => undefined,
  choose_files: () => undefined,
  import_view: null,
  circuit: null,
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

export function useDesk<T>(pick: (state: DeskState) => T): T {
  return useStore(desk.store, pick);
}

export function usePage<T>(pick: (state: PageState) => T): T {
  return useStore(page, pick);
}
