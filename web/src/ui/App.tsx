import { DockviewReact, type DockviewApi, type DockviewReadyEvent, type IDockviewPanelHeaderProps } from 'dockview';
import { useEffect, useRef, type FunctionComponent, type ReactElement } from 'react';
import { is_typing, key_of } from '../core/keymap';
import { imports, parts, registry, session, useStudio } from './app';
import { Banners, Dialogs, Toasts } from './dialogs';
import { InspectorPanel } from './InspectorPanel';
import { files_of } from './library/files';
import { ImportDialog } from './library/ImportDialog';
import { LibraryPanel } from './library/LibraryPanel';
import { CircuitPanel } from './circuit/CircuitPanel';
import { LogPanel, NaturalnessPanel } from './lower_panels';
import { ClipMenu } from './motion/ClipMenu';
import { MotionDialog } from './motion/MotionDialog';
import { Tasks } from './motion/Tasks';
import { ScenarioPanel } from './ScenarioPanel';
import { TopBar } from './TopBar';
import { ViewportPanel } from './ViewportPanel';

const layout_key = 'ugoki.layout.1';

const components: Record<string, FunctionComponent> = {
  viewport: ViewportPanel,
  library: LibraryPanel,
  inspector: InspectorPanel,
  scenario: ScenarioPanel,
  naturalness: NaturalnessPanel,
  log: LogPanel,
  circuit: CircuitPanel,
};

const toggle_maximized = (api: { isMaximized(): boolean; maximize(): void; exitMaximized(): void }): void => (api.isMaximized() ? api.exitMaximized() : api.maximize());

function Tab({ api }: IDockviewPanelHeaderProps): ReactElement {
  return <div className="tab" onDoubleClick={() => toggle_maximized(api)} title="Double-click to maximise or restore the panel  (Ctrl Space)">{api.title}</div>;
}

/** Replaces the layout by the initial one: viewport in the middle, library left, inspector right, tabs below. */
function default_layout(api: DockviewApi): void {
  api.clear();
  const unit = parseFloat(getComputedStyle(document.documentElement).fontSize) / 13;
  const height = Math.round(Math.min(268 * unit, window.innerHeight * 0.34));
  const viewport = api.addPanel({ id: 'viewport', component: 'viewport', title: 'Viewport', renderer: 'always' });
  viewport.group.header.hidden = true;
  viewport.group.locked = true;
  const scenario = api.addPanel({ id: 'scenario', component: 'scenario', title: 'Scenario', renderer: 'always', initialHeight: height, position: { referencePanel: 'viewport', direction: 'below' } });
  add_circuit(api);
  api.addPanel({ id: 'naturalness', component: 'naturalness', title: 'Naturalness', inactive: true, position: { referencePanel: 'scenario', direction: 'within' } });
  api.addPanel({ id: 'log', component: 'log', title: 'Log', inactive: true, position: { referencePanel: 'scenario', direction: 'within' } });
  const narrow = window.innerWidth < 1400;
  api.addPanel({ id: 'library', component: 'library', title: 'Library', initialWidth: Math.round((narrow ? 220 : 248) * unit), position: { referencePanel: 'viewport', direction: 'left' } });
  api.addPanel({ id: 'inspector', component: 'inspector', title: 'Inspector', initialWidth: Math.round((narrow ? 256 : 284) * unit), position: { referencePanel: 'viewport', direction: 'right' } });
  scenario.group.api.setSize({ height });
  scenario.api.setActive();
}

/** Adds the circuit panel if the layout has none: layouts stored by older versions lack it. */
function add_circuit(api: DockviewApi): void {
  if (api.getPanel('circuit')) return;
  api.addPanel({ id: 'circuit', component: 'circuit', title: 'Circuit', inactive: true, position: { referencePanel: 'scenario', direction: 'within', index: 1 } });
}

/** Restores the layout stored in this browser. @return false if there is none or it is unusable */
function restore_layout(api: DockviewApi): boolean {
  try {
    const text = localStorage.getItem(layout_key);
    if (!text) return false;
    api.fromJSON(JSON.parse(text));
    return ['viewport', 'scenario', 'library', 'inspector'].every((id) => api.getPanel(id));
  } catch {
    return false; // the stored layout is damaged or from another version
  }
}

export function App(): ReactElement {
  const title = useStudio((s) => (s.project ? `${s.project.unsaved ? '• ' : ''}${s.project.name} — Ugoki` : 'Ugoki'));
  const dock = useRef<DockviewApi | null>(null);
  const frame = useRef<HTMLElement>(null);

  useEffect(() => {
    document.title = title;
  }, [title]);

  useEffect(() => {
    const down = (event: KeyboardEvent): void => {
      if (event.defaultPrevented) return;
      const key = key_of(event);
      const { keymap, dialog } = session.state;
      const typing = is_typing(event.target as HTMLElement);
      if (typing && !/^(Ctrl\+[KPSZYI]|Ctrl\+Shift\+[SZ]|F1)$/.test(key)) return;
      if (typing && /^Ctrl\+(Shift\+)?[ZY]$/.test(key)) return; // text fields have their own undo
      const command = registry.by_key(key, keymap);
      if (!command) return;
      if (dialog !== 'none' && !command.id.startsWith('page.')) return;
      // the arrow keys belong to a focused slider or radio button
      const target = event.target as HTMLElement;
      if ((key === 'ArrowLeft' || key === 'ArrowRight') && (target.tagName === 'INPUT' || target.getAttribute('role') === 'radio')) return;
      event.preventDefault();
      if (command.enabled?.() === false) return;
      if (event.repeat && !['play.back', 'play.on', 'edit.undo', 'edit.redo'].includes(command.id)) return;
      command.run();
    };
    // a click on a button must not take the keyboard focus from the viewport or the timeline
    const press = (event: MouseEvent): void => {
      const button = (event.target as Element | null)?.closest?.('button');
      if (!button || button.draggable) return;
      event.preventDefault();
      const active = document.activeElement as HTMLElement | null;
      if (is_typing(active)) active?.blur();
    };
    const before_unload = (event: BeforeUnloadEvent): void => {
      if (session.state.project?.unsaved && session.state.connection === 'lost') event.preventDefault();
    };
    const stop_file_drop = (event: DragEvent): void => {
      if (event.dataTransfer?.types.includes('Files')) event.preventDefault();
    };
    const file_drop = (event: DragEvent): void => {
      if (!event.dataTransfer?.files.length || event.defaultPrevented) return;
      event.preventDefault();
      void files_of(event.dataTransfer).then((files) => imports.add(files));
    };
    window.addEventListener('keydown', down);
    window.addEventListener('mousedown', press);
    window.addEventListener('beforeunload', before_unload);
    window.addEventListener('dragover', stop_file_drop);
    window.addEventListener('drop', file_drop);
    return () => {
      window.removeEventListener('keydown', down);
      window.removeEventListener('mousedown', press);
      window.removeEventListener('beforeunload', before_unload);
      window.removeEventListener('dragover', stop_file_drop);
      window.removeEventListener('drop', file_drop);
    };
  }, []);

  // lay out the dock whenever its element changes size, also while the page loads
  useEffect(() => {
    const element = frame.current;
    if (!element) return;
    const fill = (): void => {
      const { clientWidth, clientHeight } = element;
      if (dock.current && clientWidth > 0 && clientHeight > 0) dock.current.layout(clientWidth, clientHeight, true);
    };
    const observer = new ResizeObserver(fill);
    observer.observe(element);
    window.addEventListener('resize', fill);
    return () => {
      observer.disconnect();
      window.removeEventListener('resize', fill);
    };
  }, []);

  const ready = ({ api }: DockviewReadyEvent): void => {
    dock.current = api;
    if (frame.current) api.layout(frame.current.clientWidth, frame.current.clientHeight, true); // panel sizes are stored relative to the dock's size
    if (!restore_layout(api)) default_layout(api);
    add_circuit(api);
    parts.reset_layout = () => {
      default_layout(api);
      requestAnimationFrame(() => parts.fit_timeline());
    };
    parts.toggle_maximized = () => {
      if (api.activePanel) toggle_maximized(api.activePanel.api);
    };
    parts.show_panel = (id) => api.getPanel(id)?.api.setActive();
    let timer: ReturnType<typeof setTimeout> | undefined;
    api.onDidLayoutChange(() => {
      clearTimeout(timer);
      timer = setTimeout(() => {
        try {
          localStorage.setItem(layout_key, JSON.stringify(api.toJSON()));
        } catch {
          // without local storage the layout is lost when the page closes
        }
      }, 400);
    });
  };

  return (
    <div className="page">
      <TopBar />
      <Banners />
      <main ref={frame} className="dock">
        <DockviewReact
          components={components}
          defaultTabComponent={Tab}
          onReady={ready}
          disableFloatingGroups
          theme={{ name: 'ugoki', className: 'dockview-theme-ugoki' }}
        />
      </main>
      <Toasts />
      <Dialogs />
      <ImportDialog />
      <ClipMenu />
      <MotionDialog />
      <Tasks />
    </div>
  );
}
