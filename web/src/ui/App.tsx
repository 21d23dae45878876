import { DockviewReact, type DockviewApi, type DockviewReadyEvent, type IDockviewPanelHeaderProps } from 'dockview';
import { useEffect, useRef, useState, type FunctionComponent, type KeyboardEvent as ReactKeyboardEvent, type ReactElement } from 'react';
import { is_typing, key_of } from '../core/keymap';
import { imports, parts, registry, session, useStudio } from './app';
import { Banners, Dialogs, Toasts } from './dialogs';
import { InspectorPanel } from './InspectorPanel';
import { place_of_drop } from './prop_actions';
import { files_of } from './library/files';
import { ImportDialog } from './library/ImportDialog';
import { LibraryPanel } from './library/LibraryPanel';
import { LookPanel } from './film/LookPanel';
import { CircuitPanel } from './circuit/CircuitPanel';
import { LogPanel } from './LogPanel';
import { NaturalnessPanel } from './NaturalnessPanel';
import { PlotsPanel } from './PlotsPanel';
import { ClipMenu } from './motion/ClipMenu';
import { MotionDialog } from './motion/MotionDialog';
import { CurvesPanel } from './posing/CurvesPanel';
import { PosesPanel } from './posing/PosesPanel';
import { Tasks } from './motion/Tasks';
import { RulesPanel } from './rules/RulesPanel';
import { ScenarioPanel } from './ScenarioPanel';
import { begin_first_tour, Tour } from './Tour';
import { TopBar } from './TopBar';
import { ViewportPanel } from './ViewportPanel';

const layout_key = 'ugoki.layout.1';

const components: Record<string, FunctionComponent> = {
  viewport: ViewportPanel,
  library: LibraryPanel,
  inspector: InspectorPanel,
  look: LookPanel,
  scenario: ScenarioPanel,
  naturalness: NaturalnessPanel,
  plots: PlotsPanel,
  log: LogPanel,
  circuit: CircuitPanel,
  rules: RulesPanel,
  curves: CurvesPanel,
  poses: PosesPanel,
};

const toggle_maximized = (api: { isMaximized(): boolean; maximize(): void; exitMaximized(): void }): void => (api.isMaximized() ? api.exitMaximized() : api.maximize());

/** The tab of a panel. The Tab key reaches only the selected tab of a group; arrow keys, Home and End select another tab. */
function Tab({ api }: IDockviewPanelHeaderProps): ReactElement {
  const element = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const tab = element.current?.closest<HTMLElement>('.dv-tab');
    if (!tab) return;
    const mark = (): void => {
      tab.setAttribute('role', 'tab');
      tab.setAttribute('aria-selected', String(api.isVisible));
      tab.tabIndex = api.isVisible ? 0 : -1;
      tab.parentElement?.setAttribute('role', 'tablist');
    };
    mark();
    const changes = [api.onDidVisibilityChange(mark), api.onDidGroupChange(mark), api.onDidActiveChange(mark)];
    return () => changes.forEach((change) => change.dispose());
  }, [api]);
  return <div ref={element} className="tab" onDoubleClick={() => toggle_maximized(api)} title="Double-click to maximise or restore the panel  (Ctrl Space)">{api.title}</div>;
}

/** Key handler of a focused tab: selects and focuses the tab of the same group that the key names. */
function move_between_tabs(event: ReactKeyboardEvent): void {
  const tab = (event.target as HTMLElement).closest<HTMLElement>('.dv-tab');
  if (!tab || event.target !== tab || event.ctrlKey || event.altKey || event.metaKey || event.shiftKey) return;
  const tabs = [...(tab.parentElement?.querySelectorAll<HTMLElement>(':scope > .dv-tab') ?? [])];
  const at = tabs.indexOf(tab);
  const next = { ArrowRight: (at + 1) % tabs.length, ArrowLeft: (at - 1 + tabs.length) % tabs.length, Home: 0, End: tabs.length - 1, Enter: at, ' ': at }[event.key];
  if (next === undefined) return;
  event.preventDefault();
  event.stopPropagation();
  tabs[next]!.dispatchEvent(new PointerEvent('pointerdown', { bubbles: true, button: 0 })); // selects the tab, as a click does
  tabs[next]!.focus();
}

/** Font size of the page, in px. It is larger in very large windows. */
const font_size = (): number => parseFloat(getComputedStyle(document.documentElement).fontSize);

/** Replaces the layout by the initial one: viewport in the middle, library left, inspector right, tabs below. */
function default_layout(api: DockviewApi): void {
  api.clear();
  const unit = font_size() / 13;
  const height = Math.round(Math.min(268 * unit, window.innerHeight * 0.34));
  const viewport = api.addPanel({ id: 'viewport', component: 'viewport', title: 'Viewport', renderer: 'always' });
  viewport.group.header.hidden = true;
  viewport.group.locked = true;
  const scenario = api.addPanel({ id: 'scenario', component: 'scenario', title: 'Scenario', renderer: 'always', initialHeight: height, position: { referencePanel: 'viewport', direction: 'below' } });
  add_missing(api);
  api.addPanel({ id: 'naturalness', component: 'naturalness', title: 'Naturalness', inactive: true, position: { referencePanel: 'scenario', direction: 'within' } });
  api.addPanel({ id: 'log', component: 'log', title: 'Log', inactive: true, position: { referencePanel: 'scenario', direction: 'within' } });
  const narrow = window.innerWidth < 1400;
  api.addPanel({ id: 'library', component: 'library', title: 'Library', initialWidth: Math.round((window.innerWidth < 1200 ? 220 : 248) * unit), position: { referencePanel: 'viewport', direction: 'left' } });
  add_poses(api);
  api.addPanel({ id: 'inspector', component: 'inspector', title: 'Inspector', initialWidth: Math.round((narrow ? 256 : 284) * unit), position: { referencePanel: 'viewport', direction: 'right' } });
  add_missing(api);
  scenario.group.api.setSize({ height });
  scenario.api.setActive();
}

function add_poses(api: DockviewApi): void {
  if (api.getPanel('library') && !api.getPanel('poses')) api.addPanel({ id: 'poses', component: 'poses', title: 'Poses', inactive: true, position: { referencePanel: 'library', direction: 'within' } });
}

/** Adds the panels that layouts stored by older versions lack. */
function add_missing(api: DockviewApi): void {
  add_poses(api);
  for (const [id, title, index] of [['curves', 'Curves', 1], ['circuit', 'Circuit', 2], ['rules', 'Rules', 3]] as const)
    if (!api.getPanel(id)) api.addPanel({ id, component: id, title, inactive: true, position: { referencePanel: 'scenario', direction: 'within', index } });
  if (api.getPanel('naturalness') && !api.getPanel('plots')) api.addPanel({ id: 'plots', component: 'plots', title: 'Plots', inactive: true, position: { referencePanel: 'naturalness', direction: 'within' } });
  if (api.getPanel('inspector') && !api.getPanel('look')) api.addPanel({ id: 'look', component: 'look', title: 'Look', inactive: true, position: { referencePanel: 'inspector', direction: 'within' } });
}

const min_viewport_width = 320; // px; with a smaller viewport the panels shrink with the window
const min_viewport_share = 0.5; // of the height of a low window
const smallest_share = 0.25; // of its size that a panel keeps in a very small window
let laid_out_font = 0; // px: font size of the last lay_out()
/** By group: the size that it has if the window is large enough (in font sizes), and the size that lay_out() gave it (px). */
const sizes = new Map<string, { wanted: number; given: number }>();

type Axis = 'width' | 'height';
interface SideGroup {
  group: DockviewApi['groups'][number];
  axis: Axis;
  /** Position across the axis; groups of one column, or of one row, have the same. px */
  at: number;
  size: number;
}

/** The groups beside, above and below the viewport, whose size is kept along one axis. */
function side_groups(api: DockviewApi, viewport: SideGroup['group'], middle: DOMRect): SideGroup[] {
  return api.groups.flatMap((group): SideGroup[] => {
    const box = group.element.getBoundingClientRect();
    if (group === viewport || box.width === 0) return [];
    if (box.right <= middle.left + 1 || box.left >= middle.right - 1) return [{ group, axis: 'width', at: Math.round(box.left), size: box.width }];
    if (box.bottom <= middle.top + 1 || box.top >= middle.bottom - 1) return [{ group, axis: 'height', at: Math.round(box.top), size: box.height }];
    return [];
  });
}

/**
 * Sets the size of the dock to `width` x `height` px. Only the viewport changes its size, unless it would become too small: groups of panels
 * beside it keep their width, and groups above and below it keep their height. If the font size has changed, these change with it. Groups that
 * a small window has made smaller get their size back with the window.
 */
function lay_out(api: DockviewApi, width: number, height: number): void {
  const font = font_size();
  const before = laid_out_font > 0 ? laid_out_font : font;
  laid_out_font = font;
  const viewport = api.getPanel('viewport')?.group;
  const middle = viewport?.element.getBoundingClientRect();
  if (!viewport || !middle || middle.width === 0 || api.hasMaximizedGroup()) return api.layout(width, height, true);
  const sides = side_groups(api, viewport, middle).map((side) => {
    const last = sizes.get(side.group.id);
    const changed = !last || Math.abs(last.given - side.size) > 1.5; // by the user
    return { ...side, wanted: changed ? side.size / before : last.wanted };
  });
  const share = (axis: Axis, total: number, min_viewport: number): number => {
    const lines = new Map<number, number>();
    for (const side of sides) if (side.axis === axis) lines.set(side.at, Math.max(lines.get(side.at) ?? 0, side.wanted * font));
    const sum = [...lines.values()].reduce((a, b) => a + b, 0);
    return sum > 0 ? Math.min(1, Math.max(smallest_share, (total - min_viewport) / sum)) : 1;
  };
  const shares = { width: share('width', width, min_viewport_width), height: share('height', height, Math.max(min_viewport_width / 2, height * min_viewport_share)) };
  api.layout(width, height, true);
  for (const { group, axis, wanted } of sides) group.api.setSize({ [axis]: Math.round(wanted * font * shares[axis]) });
  for (const { group, axis, wanted } of sides) sizes.set(group.id, { wanted, given: group.element.getBoundingClientRect()[axis] });
}

/** Restores the layout stored in this browser. @return false if there is none or it is unusable */
function restore_layout(api: DockviewApi): boolean {
  try {
    const text = localStorage.getItem(layout_key);
    if (!text) return false;
    const layout = JSON.parse(text) as Parameters<DockviewApi['fromJSON']>[0];
    const { width, height } = api;
    api.layout(layout.grid.width, layout.grid.height, true); // the size of the dock when the layout was stored
    api.fromJSON(layout);
    lay_out(api, width, height);
    return ['viewport', 'scenario', 'library', 'inspector'].every((id) => api.getPanel(id));
  } catch {
    return false; // the stored layout is damaged or from another version
  }
}

export function App(): ReactElement {
  const title = useStudio((s) => (s.project ? `${s.project.unsaved ? '• ' : ''}${s.project.name} — Ugoki` : 'Ugoki'));
  const dock = useRef<DockviewApi | null>(null);
  const frame = useRef<HTMLElement>(null);
  const [files_over, set_files_over] = useState(false);

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
      if (event.repeat && !command.repeats) return;
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
    // files can be dropped anywhere; these handlers run in the capture phase, before those for dragged panels and library entries
    const file_over = (event: DragEvent): void => {
      if (!event.dataTransfer?.types.includes('Files')) return;
      event.preventDefault();
      event.stopPropagation();
      event.dataTransfer.dropEffect = 'copy';
      set_files_over(true);
    };
    const file_leave = (event: DragEvent): void => {
      if (event.relatedTarget === null) set_files_over(false);
    };
    const file_drop = (event: DragEvent): void => {
      set_files_over(false);
      if (!event.dataTransfer?.types.includes('Files')) return;
      event.preventDefault();
      event.stopPropagation();
      const in_library = event.target instanceof Element && event.target.closest('.library') !== null;
      const at = in_library || !session.state.document ? undefined : place_of_drop(event);
      void files_of(event.dataTransfer).then((files) => imports.add(files, at));
    };
    window.addEventListener('keydown', down);
    window.addEventListener('mousedown', press);
    window.addEventListener('beforeunload', before_unload);
    window.addEventListener('dragover', file_over, true);
    window.addEventListener('dragleave', file_leave);
    window.addEventListener('drop', file_drop, true);
    return () => {
      window.removeEventListener('keydown', down);
      window.removeEventListener('mousedown', press);
      window.removeEventListener('beforeunload', before_unload);
      window.removeEventListener('dragover', file_over, true);
      window.removeEventListener('dragleave', file_leave);
      window.removeEventListener('drop', file_drop, true);
    };
  }, []);

  useEffect(begin_first_tour, []);

  // lay out the dock whenever its element changes size, also while the page loads
  useEffect(() => {
    const element = frame.current;
    if (!element) return;
    const fill = (): void => {
      const { clientWidth, clientHeight } = element;
      if (dock.current && clientWidth > 0 && clientHeight > 0) lay_out(dock.current, clientWidth, clientHeight);
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
    add_missing(api);
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
    <div className={files_over ? 'page files-over' : 'page'}>
      <TopBar />
      <Banners />
      <main ref={frame} className="dock" onKeyDown={move_between_tabs}>
        <DockviewReact
          components={components}
          defaultTabComponent={Tab}
          onReady={ready}
          disableFloatingGroups
          disableAutoResizing // lay_out() does this
          theme={{ name: 'ugoki', className: 'dockview-theme-ugoki' }}
        />
        <ClipMenu />
      </main>
      <Toasts />
      <Dialogs />
      <ImportDialog />
      <MotionDialog />
      <Tasks />
      <Tour />
    </div>
  );
}
