/** The wiring editor: React Flow elements for LSIs in view, canvases for the others. LSIs and wires out of view are not rendered. */
import { Background, BackgroundVariant, ReactFlow, ReactFlowProvider } from '@xyflow/react';
import '@xyflow/react/dist/base.css';
import 'uplot/dist/uPlot.min.css';
import './circuit.css';
import { useCallback, useEffect, useMemo, useRef, useState, type MouseEvent, type PointerEvent, type ReactElement } from 'react';
import type { PinAt } from '../../core/circuit/fits';
import { elk_graph, read_layout } from '../../core/circuit/layout';
import { grid, type View } from '../../core/circuit/view';
import { is_typing } from '../../core/keymap';
import { circuit, parts, session, useCircuit } from '../app';
import { Bar } from './Bar';
import { StopForm, StopNotice } from './Breakpoints';
import { useDrawing, type Drawing } from './drawing';
import { ConnectionLine, edge_types, type WireEdgeType } from './edges';
import type { AnyNode } from './elements';
import { lay_out } from './elk';
import { kept_viewport, useFraming, type Framing } from './framing';
import { on_key } from './keys';
import { Menu, type MenuItem } from '../Menu';
import { menu_items, type CanvasActions } from './menu_items';
import { Minimap } from './Minimap';
import { double_click, pin_of, useMarquee, useNodeDrag, useWiring } from './mouse';
import { LsiNode, NoteNode, ProbeNode, Refusal } from './nodes';
import { Search } from './Search';
import { useSurface, type Client, type Surface } from './surface';
import { useValues, useWatch } from './values';

const node_types = { lsi: LsiNode, note: NoteNode, probe: ProbeNode };
const min_mapped = 12; // the overview map is shown only if the circuit has more LSIs than this

export function CircuitPanel(): ReactElement {
  const has = useCircuit((s) => s.view !== null);
  if (!has) return <div className="panel empty">Waiting for the circuit from the studio…</div>;
  return (
    <ReactFlowProvider>
      <Canvas />
    </ReactFlowProvider>
  );
}

/** Functions of the canvas for menus, keys and the command list. */
function useActions(surface: Surface, framing: Framing, drawing: Drawing): CanvasActions {
  const actions = useMemo((): CanvasActions => ({
    fit: framing.fit,
    open_search: (client = surface.here(), fits?: PinAt) => circuit.open_search(surface.to_plane(client), client, fits),
    arrange: () => void arrange(framing.fit),
  }), [surface, framing.fit]);
  useEffect(() => {
    const { drawn, facts } = drawing;
    parts.circuit = {
      fit: actions.fit, open_search: () => actions.open_search(), lay_out: actions.arrange,
      point: () => surface.to_plane(surface.here()),
      facts: () => ({ ...facts.current, far: drawn.current?.far, near: drawn.current?.near.length, elements: drawn.current?.ids.size, viewport: surface.viewport() }),
    };
    return () => {
      parts.circuit = null;
    };
  }, [surface, actions, drawing]);
  return actions;
}

async function arrange(fit: () => void): Promise<void> {
  const current = circuit.view;
  if (!current) return;
  const ids = circuit.state.nodes.size > 1 ? circuit.state.nodes : undefined;
  try {
    const answer = await lay_out(elk_graph(current, ids));
    if (circuit.view !== current) return session.notify('The circuit changed while its layout was computed; nothing was moved. Lay it out again.');
    circuit.lay_out(read_layout(current, answer, ids));
    if (!ids) requestAnimationFrame(() => fit());
  } catch (error) {
    session.fail(error as Error, 'auto-layout');
  }
}

const label_of = (view: View): string =>
  `Circuit${view.level.path.length > 0 ? `, inside ${view.level.path.join(', ')}` : ''}, ${view.level.circuit.lsis?.length ?? 0} LSIs. Arrow keys move the cursor, Enter selects pins, Tab adds an LSI.`;

function Canvas(): ReactElement {
  const view = useCircuit((s) => s.view)!;
  const connecting = useCircuit((s) => s.connecting !== null);
  const announcement = useCircuit((s) => s.announcement);
  const panel = useRef<HTMLDivElement>(null);
  const under = useRef<HTMLCanvasElement>(null);
  const over = useRef<HTMLCanvasElement>(null);
  const tick = useRef<HTMLSpanElement>(null);
  const pointer = useRef<Client | null>(null);
  const pressing = useRef(false);
  const [menu, set_menu] = useState<{ x: number; y: number; items: MenuItem[] } | null>(null);
  const [snapping, set_snapping] = useState(true);

  const surface = useSurface(panel, pointer);
  const drawing = useDrawing(view, surface, under);
  const framing = useFraming(surface, panel, pressing);
  const actions = useActions(surface, framing, drawing);
  useWatch(view, surface, drawing);
  useValues(surface, drawing, over, tick);
  const dragging = useNodeDrag(drawing);
  const wiring = useWiring(view, actions.open_search);
  const { marquee, begin, at_point } = useMarquee(view, surface, drawing);

  const press = (event: PointerEvent<HTMLDivElement>): void => {
    const target = event.target as HTMLElement;
    if (target.closest('.menu, .circuit-search, .stop-form')) return; // menu, search and breakpoint form handle presses themselves
    circuit.close_stop();
    pressing.current = true;
    set_snapping(!event.ctrlKey); // the release of Ctrl is not seen here if a shortcut has moved the focus
    circuit.forget_refusal();
    if (!is_typing(target)) panel.current?.focus({ preventScroll: true });
    if (menu) set_menu(null);
    if (event.button === 0 && !event.altKey && target.classList.contains('react-flow__pane')) begin(event);
  };
  const context_menu = (event: MouseEvent<HTMLDivElement>): void => {
    const target = event.target as HTMLElement;
    if (target.closest('input, textarea, .circuit-search, .stop-form')) return;
    event.preventDefault();
    const client = { x: event.clientX, y: event.clientY };
    const items = menu_items(view, target, client, surface, actions);
    const box = surface.origin();
    if (items.length > 0 && box) set_menu({ x: Math.min(client.x - box.left, box.width - 250), y: Math.max(6, Math.min(client.y - box.top, box.height - items.length * 27 - 14)), items });
  };
  const go = useCallback((x: number, y: number) => void surface.flow.setCenter(x, y, { zoom: surface.viewport().zoom }), [surface]);

  return (
    <div
      ref={panel}
      className={`circuit${connecting ? ' connecting' : ''}${drawing.far ? ' far' : ''}`}
      tabIndex={0}
      role="application"
      aria-roledescription="wiring editor"
      aria-label={label_of(view)}
      onKeyDown={(e) => on_key(e, surface, actions)}
      onKeyUp={(e) => e.key === 'Control' && set_snapping(true)}
      onKeyDownCapture={(e) => e.key === 'Control' && set_snapping(false)}
      onPointerDownCapture={press}
      onPointerUpCapture={() => (pressing.current = false)}
      onPointerMove={(e) => (pointer.current = { x: e.clientX, y: e.clientY })}
      onPointerLeave={() => (pointer.current = null)}
      onDoubleClick={(e) => double_click(e, at_point, surface, actions.open_search)}
      onContextMenu={context_menu}
    >
      <canvas ref={under} className="circuit-under" aria-hidden="true" />
      <ReactFlow<AnyNode, WireEdgeType>
        nodes={drawing.nodes}
        edges={drawing.edges}
        nodeTypes={node_types}
        edgeTypes={edge_types}
        onNodesChange={dragging.on_nodes_change}
        onNodeClick={(e, node) => {
          // a click on one of several selected nodes selects it alone
          if (!e.shiftKey && !e.ctrlKey && !e.metaKey && circuit.state.nodes.size > 1) circuit.select([node.id]);
        }}
        onEdgeClick={(e, edge) => circuit.select(e.shiftKey || e.ctrlKey ? circuit.state.nodes : [], e.shiftKey || e.ctrlKey ? [...circuit.state.wires, edge.id] : [edge.id])}
        onMoveStart={(e) => e && framing.release()}
        onNodeDragStart={dragging.drag_start}
        onNodeDrag={dragging.on_drag}
        onNodeDragStop={dragging.drag_stop}
        onSelectionDragStart={(e, list) => list[0] && dragging.drag_start(e, list[0])}
        onSelectionDrag={(e, list) => list[0] && dragging.on_drag(e, list[0])}
        onSelectionDragStop={(e, list) => list[0] && dragging.drag_stop(e, list[0])}
        onConnectStart={wiring.connect_start}
        onConnectEnd={wiring.connect_end}
        isValidConnection={(c) => {
          const from = pin_of(c.source, c.sourceHandle);
          const to = pin_of(c.target, c.targetHandle);
          const start = circuit.state.connecting;
          return from !== null && to !== null && (start ? circuit.wire_refusal(start.side === 'out' ? to : from) === null : true);
        }}
        edgesReconnectable
        onReconnectStart={wiring.reconnect_start}
        onReconnectEnd={(event, _edge, _side, state) => wiring.connect_end(event, state)}
        connectionLineComponent={ConnectionLine}
        connectionRadius={16}
        nodeOrigin={[0, 0]}
        minZoom={0.015}
        maxZoom={2.5}
        snapToGrid={snapping}
        snapGrid={[grid, grid]}
        panOnDrag={[1]}
        panActivationKeyCode="Alt"
        selectionKeyCode={null}
        multiSelectionKeyCode={['Shift', 'Control', 'Meta']}
        deleteKeyCode={null}
        zoomOnDoubleClick={false}
        disableKeyboardA11y
        nodesFocusable={false}
        edgesFocusable={false}
        elevateNodesOnSelect
        selectNodesOnDrag
        nodeDragThreshold={2}
        defaultViewport={kept_viewport()}
        proOptions={{ hideAttribution: true }}
      >
        {!drawing.far && <Background variant={BackgroundVariant.Dots} gap={20} size={1.4} color="var(--circuit-dot)" />}
      </ReactFlow>
      <canvas ref={over} className="circuit-over" aria-hidden="true" />
      {marquee && <div className="marquee" style={{ left: marquee.x, top: marquee.y, width: marquee.width, height: marquee.height }} />}
      <Bar tick={tick} fit={() => framing.fit()} arrange={actions.arrange} />
      {view.nodes.length > min_mapped && <Minimap view={view} viewport={surface.viewport} size={surface.size} go={go} subscribe={drawing.on_paint} />}
      {view.nodes.length === 0 && <div className="circuit-empty">The circuit is empty. Press Tab or double-click to add an LSI.</div>}
      <StopNotice />
      <Search origin={surface.origin} />
      <StopForm origin={surface.origin} />
      <Refusal origin={surface.origin} />
      {menu && <Menu {...menu} close={() => set_menu(null)} />}
      <div className="unseen" role="status" aria-live="polite">{announcement}</div>
    </div>
  );
}
