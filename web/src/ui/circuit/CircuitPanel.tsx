/** The wiring editor: React Flow for what is near and alive, canvases for the rest. Only what is seen is rendered. */
import {
  applyNodeChanges, Background, BackgroundVariant, BaseEdge, ReactFlow, ReactFlowProvider, Position, useReactFlow, useStoreApi,
  type ConnectionLineComponentProps, type Edge, type EdgeProps, type FinalConnectionState, type NodeChange, type OnConnectStart, type XYPosition,
} from '@xyflow/react';
import '@xyflow/react/dist/base.css';
import 'uplot/dist/uPlot.min.css';
import './circuit.css';
import { memo, useCallback, useEffect, useMemo, useRef, useState, type KeyboardEvent, type MouseEvent, type PointerEvent, type ReactElement } from 'react';
import { hue_of } from '../../core/circuit/classes';
import type { PinAt } from '../../core/circuit/fits';
import type { Point } from '../../core/circuit/form';
import { short_time } from '../../core/circuit/live';
import { elk_graph, read_layout } from '../../core/circuit/layout';
import { loop_wires } from '../../core/circuit/problems';
import { boxes_meet, SpatialIndex, type Box } from '../../core/circuit/spatial';
import { type Direction } from '../../core/circuit/navigate';
import { grid, note_id, note_size, pin_offset, pin_point, probe_id, probe_size, wire_path, type View, type ViewNode, type ViewWire } from '../../core/circuit/view';
import { is_typing } from '../../core/keymap';
import { circuit, parts, session, useCircuit, useStudio } from '../app';
import { Icon } from '../icons';
import { lay_out } from './elk';
import { Menu, type MenuItem } from './Menu';
import { Minimap } from './Minimap';
import { LsiNode, NoteNode, ProbeNode, Refusal, type LsiNodeType, type NoteNodeType, type ProbeNodeType } from './nodes';
import { paint_under, paint_values, prepare, read_colors, type Viewport } from './paint';
import { Search } from './Search';

type AnyNode = LsiNodeType | NoteNodeType | ProbeNodeType;
type WireEdgeType = Edge<{ wire: ViewWire; loop: boolean }, 'wire'>;

/** Below this zoom, or with more nodes than this in sight, all is drawn on the canvas. */
const far_zoom = 0.42;
const most_elements = 240;
const value_zoom = 0.44;
const values_period = 70; // ms: below 15 a second
const margin = 260; // px around what is seen, so that not every step of a pan brings new nodes

const WireEdge = memo(function WireEdge({ id, data, sourceX, sourceY, targetX, targetY, selected }: EdgeProps<WireEdgeType>): ReactElement {
  const wire = data!.wire;
  return (
    <BaseEdge
      id={id}
      path={wire_path([sourceX, sourceY], [targetX, targetY])}
      interactionWidth={14}
      className={`wire-line${selected ? ' selected' : ''}${wire.delayed ? ' delayed' : ''}${data!.loop ? ' loop' : ''}`}
      style={{ stroke: selected || data!.loop ? undefined : `var(--pin-${hue_of(wire.type)})` }}
    />
  );
});

function ConnectionLine({ fromX, fromY, toX, toY, fromHandle, connectionStatus }: ConnectionLineComponentProps): ReactElement {
  const backwards = fromHandle.type === 'target';
  const connecting = circuit.state.connecting;
  const type = connecting ? (circuit.view?.pin(connecting.node, connecting.side, connecting.pin)?.type ?? 'any') : 'any';
  const path = backwards ? wire_path([toX, toY], [fromX, fromY]) : wire_path([fromX, fromY], [toX, toY]);
  return <path d={path} className={`wire-line drawing ${connectionStatus ?? ''}`} style={{ stroke: connectionStatus === 'invalid' ? 'var(--bad)' : `var(--pin-${hue_of(type)})` }} />;
}

const node_types = { lsi: LsiNode, note: NoteNode, probe: ProbeNode };
const edge_types = { wire: WireEdge };

/** "in:pin" of a handle. */
const pin_of = (node: string | null | undefined, handle: string | null | undefined): PinAt | null => {
  if (!node || !handle) return null;
  const colon = handle.indexOf(':');
  return { node, side: handle.slice(0, colon) === 'in' ? 'in' : 'out', pin: handle.slice(colon + 1) };
};

function lsi_element(node: ViewNode, selected: boolean): LsiNodeType {
  const handle = (pin: ViewNode['inputs'][number], i: number) => {
    const [x, y] = pin_offset(node, pin.side, i);
    return { id: `${pin.side}:${pin.name}`, type: pin.side === 'in' ? ('target' as const) : ('source' as const), position: pin.side === 'in' ? Position.Left : Position.Right, x: x - 5, y: y - 5, width: 10, height: 10 };
  };
  return {
    id: node.id, type: 'lsi', position: { x: node.x, y: node.y }, data: { node }, selected, width: node.width, height: node.height,
    measured: { width: node.width, height: node.height }, handles: [...node.inputs.map(handle), ...node.outputs.map(handle)],
  };
}

export function CircuitPanel(): ReactElement {
  const has = useCircuit((s) => s.view !== null);
  if (!has) return <div className="panel empty">The circuit has not come from the service yet.</div>;
  return (
    <ReactFlowProvider>
      <Canvas />
    </ReactFlowProvider>
  );
}

function Canvas(): ReactElement {
  const view = useCircuit((s) => s.view)!;
  const path = useCircuit((s) => s.path);
  const selected = useCircuit((s) => s.nodes);
  const selected_wires = useCircuit((s) => s.wires);
  const problems = useCircuit((s) => s.problems);
  const connecting = useCircuit((s) => s.connecting !== null);
  const said = useCircuit((s) => s.said);
  const theme = useStudio((s) => s.theme);
  const flow = useReactFlow<AnyNode, WireEdgeType>();
  const store = useStoreApi();
  const panel = useRef<HTMLDivElement>(null);
  const under = useRef<HTMLCanvasElement>(null);
  const over = useRef<HTMLCanvasElement>(null);
  const [nodes, set_nodes] = useState<AnyNode[]>([]);
  const [edges, set_edges] = useState<WireEdgeType[]>([]);
  const [far, set_far] = useState(false);
  const [menu, set_menu] = useState<{ x: number; y: number; items: MenuItem[] } | null>(null);
  const [marquee, set_marquee] = useState<Box | null>(null);
  const [snapping, set_snapping] = useState(true);
  const pointer = useRef<{ x: number; y: number } | null>(null);
  const listeners = useRef(new Set<() => void>());
  const reconnecting = useRef<ViewWire | null>(null);
  const colors = useMemo(() => read_colors(document.documentElement), [theme]); // eslint-disable-line react-hooks/exhaustive-deps

  const index = useMemo(() => new SpatialIndex(view.nodes), [view]);
  const loop = useMemo(() => loop_wires(problems, path, view.wires), [problems, path, view]);

  const viewport = useCallback((): Viewport => {
    const [x, y, zoom] = store.getState().transform;
    return { x, y, zoom };
  }, [store]);
  const size = useCallback(() => ({ width: panel.current?.clientWidth || 1, height: panel.current?.clientHeight || 1 }), []);
  const seen = useCallback((around = 0): Box => {
    const { x, y, zoom } = viewport();
    const { width, height } = size();
    return { x: (-x - around) / zoom, y: (-y - around) / zoom, width: (width + 2 * around) / zoom, height: (height + 2 * around) / zoom };
  }, [viewport, size]);

  // ---- what is rendered ----

  const drawn = useRef<{ view: View; box: Box; zoom_far: boolean; near: ViewNode[]; elements: Set<string>; far: boolean; selected: ReadonlySet<string> } | null>(null);
  const frame = useRef(0);
  const facts = useRef({ paints: 0, paint_ms: 0, culls: 0, values: 0 });

  const paint = useCallback(() => {
    frame.current = 0;
    const canvas = under.current;
    const at = drawn.current;
    const current = circuit.view;
    if (!canvas || !at || !current) return;
    const begin = performance.now();
    const prepared = prepare(canvas);
    if (prepared) {
      const bad = (id: string): boolean => circuit.state.problems.length > 0 && circuit.problems_of(id).length > 0;
      paint_under(prepared.c, prepared, current, viewport(), colors, {
        far: at.far, elements: at.elements, drag: circuit.drag, nodes: at.far ? at.near : [], selected: circuit.state.nodes, selected_wires: circuit.state.wires, bad, loop,
      });
    }
    for (const listener of listeners.current) listener();
    facts.current.paints++;
    facts.current.paint_ms += performance.now() - begin;
  }, [viewport, colors, loop]);
  const invalidate = useCallback(() => {
    if (frame.current === 0) frame.current = requestAnimationFrame(paint);
  }, [paint]);

  const cull = useCallback((force: boolean) => {
    const zoom = viewport().zoom;
    const zoom_far = zoom < far_zoom;
    const exact = seen();
    const old = drawn.current;
    if (!force && old && old.view === view && old.zoom_far === zoom_far) {
      const b = old.box;
      if (exact.x >= b.x && exact.y >= b.y && exact.x + exact.width <= b.x + b.width && exact.y + exact.height <= b.y + b.height) return;
    }
    facts.current.culls++;
    const box = seen(margin);
    const near = index.find(box);
    const is_far = zoom_far || near.length > most_elements;
    const elements = new Set<string>();
    const next: AnyNode[] = [];
    const next_edges: WireEdgeType[] = [];
    if (!is_far) {
      const chosen = circuit.state.nodes;
      const wires = new Set<ViewWire>();
      for (const node of near) {
        for (const pin of node.inputs) for (const wire of view.at_pin(node.id, 'in', pin.name)) wires.add(wire);
        for (const pin of node.outputs) for (const wire of view.at_pin(node.id, 'out', pin.name)) wires.add(wire);
      }
      const listed = new Map(near.map((n) => [n.id, n]));
      for (const wire of wires) {
        if (wire.broken || next_edges.length >= 2 * most_elements) continue;
        for (const id of [wire.from, wire.to]) if (!listed.has(id)) listed.set(id, view.node(id)!); // not seen, but its wire is
        elements.add(wire.key);
        next_edges.push({
          id: wire.key, type: 'wire', source: wire.from, sourceHandle: `out:${wire.from_pin}`, target: wire.to, targetHandle: `in:${wire.to_pin}`, data: { wire, loop: loop.has(wire.key) }, selected: circuit.state.wires.has(wire.key),
          ariaLabel: `Wire from ${view.node(wire.from)?.title}, ${wire.from_pin}, to ${view.node(wire.to)?.title}, ${wire.to_pin}`,
        });
      }
      for (const node of listed.values()) next.push(lsi_element(node, chosen.has(node.id)));
      for (const note of view.notes) {
        const [width, height] = note_size(note);
        if (boxes_meet({ x: note.at[0], y: note.at[1], width, height }, box)) next.push({ id: note_id(note.id), type: 'note', position: { x: note.at[0], y: note.at[1] }, data: { note }, width, height, measured: { width, height }, selected: chosen.has(note_id(note.id)), zIndex: -1 });
      }
      for (const probe of view.probes) {
        const [width, height] = probe_size;
        next.push({ id: probe_id(probe.pin), type: 'probe', position: { x: probe.at[0], y: probe.at[1] }, data: { probe }, width, height, measured: { width, height }, selected: chosen.has(probe_id(probe.pin)) });
      }
    }
    drawn.current = { view, box, zoom_far, near, elements, far: is_far, selected: circuit.state.nodes };
    set_nodes((before) => reuse(before, next));
    set_edges(next_edges);
    set_far(is_far);
    watch_soon();
    invalidate();
  }, [view, index, viewport, seen, invalidate, loop]); // eslint-disable-line react-hooks/exhaustive-deps

  useEffect(() => cull(true), [cull, selected, selected_wires]);
  useEffect(() => store.subscribe((now, before) => {
    if (now.transform !== before.transform || now.width !== before.width || now.height !== before.height) {
      cull(false);
      invalidate();
    }
  }), [store, cull, invalidate]);

  // ---- the running circuit ----

  const watching = useRef<ReturnType<typeof setTimeout> | null>(null);
  const watch_soon = useCallback(() => {
    if (watching.current) return;
    watching.current = setTimeout(() => {
      watching.current = null;
      const now = circuit.view;
      const at = drawn.current;
      if (!now) return;
      const pins = new Set<string>();
      if (at && !at.far && viewport().zoom >= value_zoom) {
        for (const node of at.near) for (const pin of node.outputs) {
          const flat = circuit.flat_output(node.id, pin.name);
          if (flat && pins.size < 400) pins.add(flat);
        }
      }
      const probes = now.probes.flatMap((p) => circuit.flat_output(...(p.pin.split('.') as [string, string])) ?? []);
      session.watch([...pins], probes, true);
    }, 180);
  }, [viewport]);
  useEffect(watch_soon, [view, watch_soon]);
  useEffect(() => {
    const again = session.store.subscribe((s, b) => {
      if (s.connection !== b.connection && s.connection === 'open') watch_soon();
    });
    return () => {
      again();
      if (watching.current) clearTimeout(watching.current);
      watching.current = null;
      session.watch([], [], false);
    };
  }, [watch_soon]);

  const count = useRef<HTMLSpanElement>(null);
  useEffect(() => {
    let revision = -1;
    let transform: unknown = null;
    let drag: unknown = null;
    let busy = 0;
    const draw = (): void => {
      const canvas = over.current;
      const at = drawn.current;
      const current = circuit.view;
      if (!canvas || !at || !current) return;
      const now = performance.now();
      const { live } = session;
      const moving = store.getState().transform !== transform || circuit.drag !== drag;
      if (live.revision === revision && !moving && now > busy) return;
      if (live.revision !== revision) busy = now + 700;
      revision = live.revision;
      transform = store.getState().transform;
      drag = circuit.drag;
      const prepared = prepare(canvas);
      if (!prepared) return;
      const zoom = viewport().zoom;
      const visible = seen();
      facts.current.values = at.far || zoom < value_zoom ? 0 : paint_values(prepared.c, current, viewport(), at.near.filter((n) => boxes_meet(n, visible)), colors, circuit, live, now);
      if (count.current && live.timed > 0) count.current.textContent = `${short_time(live.tick_us)} a tick`;
    };
    let handle = 0;
    let last = 0;
    // with the pan at each frame, with the values at most 15 times a second
    const tick = (): void => {
      handle = requestAnimationFrame(tick);
      const now = performance.now();
      if (now - last < values_period && store.getState().transform === transform && circuit.drag === drag) return;
      last = now;
      draw();
    };
    tick();
    return () => cancelAnimationFrame(handle);
  }, [store, viewport, seen, colors]);

  // ---- where things are ----

  const origin = useCallback(() => panel.current?.getBoundingClientRect(), []);
  const to_plane = useCallback((client: { x: number; y: number }): Point => {
    const p = flow.screenToFlowPosition(client, { snapToGrid: false });
    return [p.x, p.y];
  }, [flow]);
  const here = useCallback((): { x: number; y: number } => {
    const box = origin();
    return pointer.current ?? { x: (box?.left ?? 0) + (box?.width ?? 0) / 2, y: (box?.top ?? 0) + (box?.height ?? 0) / 2 };
  }, [origin]);

  /** All is shown, and stays so when the panel changes its size, until somebody pans or zooms. */
  const fitted = useRef(false);
  const fit = useCallback((ids?: ReadonlySet<string>) => {
    const current = circuit.view;
    const { width, height } = size();
    if (!current || width < 60 || height < 60) return;
    fitted.current = !ids || ids.size === 0;
    const box = current.bounds(ids && ids.size > 0 ? ids : undefined);
    const top = 44;
    const zoom = Math.min(1.15, Math.max(0.015, Math.min((width - 70) / Math.max(1, box.width), (height - top - 30) / Math.max(1, box.height))));
    void flow.setViewport({ x: width / 2 - zoom * (box.x + box.width / 2), y: top + (height - top - 12) / 2 - zoom * (box.y + box.height / 2), zoom });
  }, [flow, size]);

  const shown_path = useRef<string | null>(null);
  useEffect(() => {
    const key = path.join('/');
    if (shown_path.current === key) return;
    const first = shown_path.current === null;
    shown_path.current = key;
    if (first && kept_viewport.path === key && kept_viewport.at) {
      fitted.current = kept_viewport.fitted;
      void flow.setViewport(kept_viewport.at);
    } else requestAnimationFrame(() => fit());
  }, [path, fit, flow]);
  useEffect(() => () => {
    kept_viewport.path = circuit.state.path.join('/');
    kept_viewport.at = viewport();
    kept_viewport.fitted = fitted.current;
  }, [viewport]);
  useEffect(() => {
    const element = panel.current;
    if (!element) return;
    const observer = new ResizeObserver(() => {
      if (fitted.current || kept_viewport.at === null) fit();
    });
    observer.observe(element);
    return () => observer.disconnect();
  }, [fit]);
  // the cursor of the keyboard stays in sight
  const cursor = useCircuit((s) => s.cursor);
  useEffect(() => {
    const node = cursor ? circuit.view?.node(cursor) : undefined;
    if (!node || pointer_down.current) return;
    const visible = seen(-30);
    if (boxes_meet(node, visible) && node.x >= visible.x && node.x + node.width <= visible.x + visible.width && node.y >= visible.y && node.y + node.height <= visible.y + visible.height) return;
    if (node.width > visible.width || node.height > visible.height) return;
    void flow.setCenter(node.x + node.width / 2, node.y + node.height / 2, { zoom: Math.max(viewport().zoom, 0.5) });
  }, [cursor, flow, seen, viewport]);

  const open_search = useCallback((client = here(), fits?: PinAt) => {
    circuit.open_search(to_plane(client), client, fits);
  }, [here, to_plane]);

  const arrange = useCallback(async () => {
    const current = circuit.view;
    if (!current) return;
    const ids = circuit.state.nodes.size > 1 ? circuit.state.nodes : undefined;
    try {
      const answer = await lay_out(elk_graph(current, ids));
      if (circuit.view !== current) return session.notify('The circuit changed meanwhile; nothing was moved.');
      circuit.lay_out(read_layout(current, answer, ids));
      if (!ids) requestAnimationFrame(() => fit());
    } catch (error) {
      session.fail(error as Error, 'auto-layout');
    }
  }, [fit]);

  useEffect(() => {
    parts.circuit = {
      fit, open_search: () => open_search(), lay_out: () => void arrange(),
      point: () => to_plane(here()),
      facts: () => ({ ...facts.current, far: drawn.current?.far, near: drawn.current?.near.length, elements: drawn.current?.elements.size, viewport: viewport() }),
    };
    return () => {
      parts.circuit = null;
    };
  }, [fit, open_search, arrange, to_plane, here, viewport]);

  // ---- mouse ----

  const pointer_down = useRef(false);
  const drag_from = useRef<{ id: string; at: XYPosition; places: Map<string, Point> } | null>(null);

  const on_nodes_change = useCallback((changes: NodeChange<AnyNode>[]) => {
    const moves = changes.filter((c) => c.type === 'position' || c.type === 'dimensions');
    if (moves.length > 0) set_nodes((before) => applyNodeChanges(moves, before));
    const picks = changes.filter((c) => c.type === 'select');
    if (picks.length === 0) return;
    const next = new Set(circuit.state.nodes);
    for (const c of picks) c.selected ? next.add(c.id) : next.delete(c.id);
    circuit.select(next, picks.some((c) => c.selected) ? [] : circuit.state.wires);
  }, []);

  const drag_start = useCallback((_e: unknown, node: AnyNode) => {
    const ids = circuit.state.nodes.has(node.id) ? circuit.state.nodes : new Set([node.id]);
    const places = new Map<string, Point>();
    for (const id of ids) {
      const at = circuit.place_of(id);
      if (at) places.set(id, at);
    }
    drag_from.current = { id: node.id, at: { ...node.position }, places };
  }, []);
  const drag_places = (node: AnyNode): Map<string, Point> | null => {
    const start = drag_from.current;
    const own = start?.places.get(start.id);
    if (!start || !own) return null;
    const [dx, dy] = [node.position.x - own[0], node.position.y - own[1]];
    return new Map([...start.places].map(([id, at]) => [id, [at[0] + dx, at[1] + dy] as Point]));
  };
  const on_drag = useCallback((_e: unknown, node: AnyNode) => {
    circuit.drag = drag_places(node);
    invalidate();
  }, [invalidate]);
  const drag_stop = useCallback((_e: unknown, node: AnyNode) => {
    const places = drag_places(node);
    drag_from.current = null;
    circuit.drag = null;
    if (places) circuit.move(places);
    cull(true);
  }, [cull]);

  const connect_start: OnConnectStart = useCallback((_e, { nodeId, handleId }) => {
    const pin = pin_of(nodeId, handleId);
    if (pin) circuit.begin_wire(pin);
  }, []);
  const connect_end = useCallback((event: globalThis.MouseEvent | TouchEvent, state: FinalConnectionState) => {
    const from = circuit.state.connecting ?? pin_of(state.fromNode?.id, state.fromHandle?.id);
    const instead = reconnecting.current ?? undefined;
    reconnecting.current = null;
    if (!from) return;
    const client = 'changedTouches' in event ? { x: event.changedTouches[0]!.clientX, y: event.changedTouches[0]!.clientY } : { x: event.clientX, y: event.clientY };
    const to = pin_of(state.toNode?.id, state.toHandle?.id) ?? body_pin(client, from);
    if (to) {
      const reason = circuit.end_wire(from, to, instead);
      if (reason) circuit.refuse(reason, client);
    } else if (instead) {
      circuit.cancel_wire();
      circuit.disconnect([instead]);
    } else if (document.elementFromPoint(client.x, client.y)?.closest('.circuit .lsi')) {
      circuit.cancel_wire();
      circuit.refuse('No pin of this LSI fits.', client);
    } else if (document.elementFromPoint(client.x, client.y)?.closest('.circuit')) {
      open_search(client, from);
    } else circuit.cancel_wire();
  }, [open_search]);

  const press = (event: PointerEvent<HTMLDivElement>): void => {
    const target = event.target as HTMLElement;
    if (target.closest('.circuit-menu, .circuit-search')) return; // theirs
    pointer_down.current = true;
    circuit.forget_refusal();
    if (!is_typing(target)) panel.current?.focus({ preventScroll: true });
    if (menu) set_menu(null);
    if (event.button !== 0 || event.altKey || !target.classList.contains('react-flow__pane')) return;
    begin_marquee(event);
  };

  const begin_marquee = (event: PointerEvent<HTMLDivElement>): void => {
    const start = { x: event.clientX, y: event.clientY };
    const before = event.shiftKey || event.ctrlKey ? new Set(circuit.state.nodes) : new Set<string>();
    const box = origin()!;
    let moved = false;
    const rect = (e: { clientX: number; clientY: number }): Box => ({ x: Math.min(start.x, e.clientX), y: Math.min(start.y, e.clientY), width: Math.abs(e.clientX - start.x), height: Math.abs(e.clientY - start.y) });
    const within = (r: Box): Set<string> => {
      const [x, y] = to_plane({ x: r.x, y: r.y });
      const [x2, y2] = to_plane({ x: r.x + r.width, y: r.y + r.height });
      const area = { x, y, width: x2 - x, height: y2 - y };
      const found = new Set(before);
      for (const node of index.find(area)) found.add(node.id);
      for (const note of view.notes) if (boxes_meet({ x: note.at[0], y: note.at[1], width: note_size(note)[0], height: note_size(note)[1] }, area)) found.add(note_id(note.id));
      for (const probe of view.probes) if (boxes_meet({ x: probe.at[0], y: probe.at[1], width: probe_size[0], height: probe_size[1] }, area)) found.add(probe_id(probe.pin));
      return found;
    };
    const move = (e: globalThis.PointerEvent): void => {
      const r = rect(e);
      if (!moved && r.width + r.height < 5) return;
      moved = true;
      set_marquee({ ...r, x: r.x - box.left, y: r.y - box.top });
      circuit.select(within(r));
    };
    const end = (e: globalThis.PointerEvent): void => {
      window.removeEventListener('pointermove', move);
      window.removeEventListener('pointerup', end);
      window.removeEventListener('pointercancel', end);
      set_marquee(null);
      if (moved) return;
      // a click: from afar it may be on an LSI
      const [x, y] = to_plane({ x: e.clientX, y: e.clientY });
      const hit = drawn.current?.far ? index.find({ x, y, width: 1, height: 1 })[0] : undefined;
      if (hit) circuit.select([...before, hit.id]);
      else if (before.size === 0) circuit.select([]);
    };
    window.addEventListener('pointermove', move);
    window.addEventListener('pointerup', end);
    window.addEventListener('pointercancel', end);
  };

  const double_click = (event: MouseEvent<HTMLDivElement>): void => {
    const target = event.target as HTMLElement;
    if (target.closest('.circuit-search, .circuit-menu, .circuit-bar, .circuit-map, .note, .probe, .problem-bubble, input, textarea')) return;
    const lsi = target.closest<HTMLElement>('[data-lsi]')?.dataset.lsi;
    if (lsi !== undefined) {
      if (circuit.view?.node(lsi)?.kind === 'circuit') circuit.go_inside(lsi);
      else if (target.closest('.lsi-head') && circuit.view?.node(lsi)?.lsi) circuit.type_in(lsi);
      return;
    }
    if (!target.classList.contains('react-flow__pane')) return;
    const [x, y] = to_plane({ x: event.clientX, y: event.clientY });
    const hit = drawn.current?.far ? index.find({ x, y, width: 1, height: 1 })[0] : undefined;
    if (hit) return void flow.setCenter(hit.x + hit.width / 2, hit.y + hit.height / 2, { zoom: 1 });
    open_search({ x: event.clientX, y: event.clientY });
  };

  const context_menu = (event: MouseEvent<HTMLDivElement>): void => {
    const target = event.target as HTMLElement;
    if (target.closest('input, textarea, .circuit-search')) return;
    event.preventDefault();
    const client = { x: event.clientX, y: event.clientY };
    const items = menu_items(target, client);
    const box = origin();
    if (items.length > 0 && box) set_menu({ x: Math.min(client.x - box.left, box.width - 250), y: Math.max(6, Math.min(client.y - box.top, box.height - items.length * 27 - 14)), items });
  };

  const menu_items = (target: HTMLElement, client: { x: number; y: number }): MenuItem[] => {
    const row = target.closest<HTMLElement>('[data-pin]');
    const id = target.closest<HTMLElement>('[data-lsi]')?.dataset.lsi;
    const wire = target.closest<HTMLElement>('.react-flow__edge')?.dataset.id;
    const clear = circuit.state;
    if (row && id !== undefined) {
      const name = row.dataset.pin!.slice(id.length + 1);
      const pin: PinAt = { node: id, side: row.dataset.side as 'in' | 'out', pin: name };
      const wires = view.at_pin(id, pin.side, name);
      const own = view.node(id)?.kind === 'inputs' ? 'inputs' : view.node(id)?.kind === 'outputs' ? 'outputs' : null;
      return [
        { label: view.probes.some((p) => p.pin === `${id}.${name}`) ? 'Remove probe' : 'Probe', key: 'P', run: () => circuit.toggle_probe(pin), disabled: own !== null },
        { label: wires.length > 1 ? `Remove ${wires.length} wires` : 'Remove wire', run: () => circuit.disconnect(wires), disabled: wires.length === 0 },
        { label: 'Add what fits…', run: () => open_search(client, pin) },
        ...(own ? [{ label: `Remove pin “${name}”`, run: () => circuit.remove_pin(own, name) }] : []),
      ];
    }
    if (id !== undefined && view.node(id)) {
      const node = view.node(id)!;
      if (!clear.nodes.has(id)) circuit.select([id]);
      if (!node.lsi) return [];
      return [
        ...(node.kind === 'circuit' ? [{ label: 'Go inside', key: 'I', run: () => void circuit.go_inside(id) }, { label: 'Ungroup', key: 'Ctrl Shift G', run: () => circuit.ungroup() }] : []),
        { label: circuit.state.nodes.size > 1 ? `Group ${circuit.state.nodes.size} LSIs` : 'Make it a circuit', key: 'Ctrl G', run: () => circuit.group() },
        { label: 'Rename', key: 'F2', run: () => circuit.type_in(id) },
        { label: node.note ? 'Change comment' : 'Comment', key: 'Shift C', run: () => circuit.type_in(`comment:${id}`) },
        { label: 'Copy', key: 'Ctrl C', run: copy },
        { label: 'Duplicate', key: 'Ctrl D', run: () => circuit.duplicate() },
        { label: 'Delete', key: 'Del', run: () => circuit.remove() },
      ];
    }
    if (wire !== undefined) {
      const found = view.wire(wire);
      if (!found) return [];
      return [
        { label: 'Remove wire', key: 'Del', run: () => circuit.disconnect([found]) },
        { label: 'Probe', run: () => circuit.toggle_probe({ node: found.from, side: 'out', pin: found.from_pin }) },
      ];
    }
    const point = to_plane(client);
    return [
      { label: 'Add an LSI…', key: 'Tab', run: () => open_search(client) },
      { label: 'Add a note', key: 'N', run: () => circuit.add_note(point) },
      { label: 'Paste', key: 'Ctrl V', run: () => void paste(point) },
      { label: 'Lay out', key: 'Shift L', run: () => void arrange() },
      { label: 'Show all', key: 'A', run: () => fit() },
      ...(clear.edited ? [{ label: 'Reset to generated', run: () => circuit.reset_to_generated() }] : []),
    ];
  };

  const copy = (): void => {
    const text = circuit.copy();
    if (text) void navigator.clipboard?.writeText(text).catch(() => undefined); // the page's own copy is enough
  };
  const paste = async (at: Point): Promise<void> => {
    const text = await Promise.race([navigator.clipboard?.readText().catch(() => '') ?? '', new Promise<string>((r) => setTimeout(() => r(''), 250))]);
    circuit.paste(at, text);
  };

  // ---- keyboard ----

  const key = (event: KeyboardEvent<HTMLDivElement>): void => {
    if (is_typing(event.target as HTMLElement) || event.defaultPrevented) return;
    const arrows: Record<string, Direction> = { ArrowLeft: 'left', ArrowRight: 'right', ArrowUp: 'up', ArrowDown: 'down' };
    const ctrl = event.ctrlKey || event.metaKey;
    const direction = arrows[event.key];
    const step: Record<Direction, Point> = { left: [-1, 0], right: [1, 0], up: [0, -1], down: [0, 1] };
    let done = true;
    const letter = event.key.toLowerCase();
    if (direction && (event.shiftKey || event.altKey)) circuit.nudge(step[direction][0] * (event.shiftKey ? 1 : 4), step[direction][1] * (event.shiftKey ? 1 : 4));
    else if (direction && !ctrl) circuit.go(direction);
    else if ((event.key === 'Tab' && !event.shiftKey && !ctrl) || (event.key === ' ' && !ctrl)) {
      const { connecting: from, pin } = circuit.state;
      const node = (from ?? pin) && view.node((from ?? pin)!.node);
      const beside = node ? flow.flowToScreenPosition({ x: node.x + ((from ?? pin)!.side === 'out' ? node.width + 60 : -240), y: node.y }) : undefined;
      open_search(beside, from ?? undefined);
    } else if (event.key === 'Enter' && !ctrl) circuit.enter_key();
    else if (event.key === 'Escape') done = circuit.escape();
    else if (event.key === 'Home' || (letter === 'a' && !ctrl && !event.shiftKey)) fit();
    else if (letter === 'f' && !ctrl) fit(circuit.state.nodes);
    else if (letter === 'a' && ctrl) circuit.select_all();
    else if (event.key === 'Delete' || event.key === 'Backspace') circuit.state.pin && circuit.state.nodes.size === 0 ? circuit.disconnect(view.at_pin(circuit.state.pin.node, circuit.state.pin.side, circuit.state.pin.pin)) : circuit.remove();
    else if (letter === 'x' && !ctrl && circuit.state.pin) circuit.disconnect(view.at_pin(circuit.state.pin.node, circuit.state.pin.side, circuit.state.pin.pin));
    else if (letter === 'c' && ctrl) copy();
    else if (letter === 'x' && ctrl) {
      copy();
      circuit.remove();
    } else if (letter === 'v' && ctrl) void paste(to_plane(here()));
    else if (letter === 'd' && ctrl) circuit.duplicate();
    else if (letter === 'g' && ctrl) event.shiftKey ? circuit.ungroup() : circuit.group();
    else if (letter === 'i' && !ctrl && circuit.chosen) circuit.go_inside(circuit.chosen);
    else if (letter === 'u' && !ctrl) circuit.go_out();
    else if (letter === 'n' && !ctrl) circuit.add_note(to_plane(here()));
    else if (letter === 'p' && !ctrl && !event.shiftKey) {
      const { pin } = circuit.state;
      const output = circuit.chosen && view.node(circuit.chosen)?.outputs[0];
      if (pin) circuit.toggle_probe(pin);
      else if (output) circuit.toggle_probe({ node: circuit.chosen!, side: 'out', pin: output.name });
    } else if (event.key === 'F2' && circuit.chosen) circuit.type_in(circuit.chosen);
    else if (letter === 'c' && event.shiftKey && !ctrl && circuit.chosen) circuit.type_in(`comment:${circuit.chosen}`);
    else if (letter === 'l' && event.shiftKey && !ctrl) void arrange();
    else if ((event.key === '+' || event.key === '=') && !ctrl) void flow.zoomIn();
    else if (event.key === '-' && !ctrl) void flow.zoomOut();
    else done = false;
    if (done) {
      event.preventDefault();
      event.stopPropagation();
    }
  };

  return (
    <div
      ref={panel}
      className={`circuit${connecting ? ' connecting' : ''}${far ? ' far' : ''}`}
      tabIndex={0}
      role="application"
      aria-roledescription="wiring editor"
      aria-label={`Circuit${path.length > 0 ? `, inside ${path.join(', ')}` : ''}, ${view.nodes.filter((n) => n.lsi).length} LSIs. Arrows move, Enter goes to pins, Tab adds.`}
      onKeyDown={key}
      onKeyUp={(e) => e.key === 'Control' && set_snapping(true)}
      onKeyDownCapture={(e) => e.key === 'Control' && set_snapping(false)}
      onPointerDownCapture={press}
      onPointerUpCapture={() => (pointer_down.current = false)}
      onPointerMove={(e) => (pointer.current = { x: e.clientX, y: e.clientY })}
      onPointerLeave={() => (pointer.current = null)}
      onDoubleClick={double_click}
      onContextMenu={context_menu}
    >
      <canvas ref={under} className="circuit-under" aria-hidden="true" />
      <ReactFlow<AnyNode, WireEdgeType>
        nodes={nodes}
        edges={edges}
        nodeTypes={node_types}
        edgeTypes={edge_types}
        onNodesChange={on_nodes_change}
        onEdgeClick={(e, edge) => circuit.select(e.shiftKey || e.ctrlKey ? circuit.state.nodes : [], e.shiftKey || e.ctrlKey ? [...circuit.state.wires, edge.id] : [edge.id])}
        onMoveStart={(e) => {
          if (e) fitted.current = false;
        }}
        onNodeDragStart={drag_start}
        onNodeDrag={on_drag}
        onNodeDragStop={drag_stop}
        onSelectionDragStart={(e, list) => list[0] && drag_start(e, list[0])}
        onSelectionDrag={(e, list) => list[0] && on_drag(e, list[0])}
        onSelectionDragStop={(e, list) => list[0] && drag_stop(e, list[0])}
        onConnectStart={connect_start}
        onConnectEnd={connect_end}
        isValidConnection={(c) => {
          const from = pin_of(c.source, c.sourceHandle);
          const to = pin_of(c.target, c.targetHandle);
          const start = circuit.state.connecting;
          return from !== null && to !== null && (start ? circuit.judge(start.side === 'out' ? to : from) === null : true);
        }}
        edgesReconnectable
        onReconnectStart={(_e, edge, side) => {
          reconnecting.current = view.wire(edge.id) ?? null;
          const wire = reconnecting.current;
          // React Flow names the end that stays
          if (wire) circuit.begin_wire(side === 'target' ? { node: wire.to, side: 'in', pin: wire.to_pin } : { node: wire.from, side: 'out', pin: wire.from_pin });
        }}
        onReconnectEnd={(event, _edge, _side, state) => connect_end(event, state)}
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
        onlyRenderVisibleElements
        selectNodesOnDrag
        nodeDragThreshold={2}
        defaultViewport={kept_viewport.at ?? { x: 0, y: 0, zoom: 1 }}
        proOptions={{ hideAttribution: true }}
      >
        <Background variant={BackgroundVariant.Dots} gap={20} size={1.4} color="var(--circuit-dot)" />
      </ReactFlow>
      <canvas ref={over} className="circuit-over" aria-hidden="true" />
      {marquee && <div className="marquee" style={{ left: marquee.x, top: marquee.y, width: marquee.width, height: marquee.height }} />}
      <Bar count={count} fit={fit} arrange={() => void arrange()} />
      {view.nodes.length > 12 && <Minimap view={view} viewport={viewport} size={size} go={(x, y) => void flow.setCenter(x, y, { zoom: viewport().zoom })} subscribe={(listener) => { listeners.current.add(listener); return () => listeners.current.delete(listener); }} />}
      {view.nodes.length === 0 && <div className="circuit-empty">Nothing is here yet. Press Tab or double-click to add an LSI.</div>}
      <Search origin={origin} />
      <Refusal origin={origin} />
      {menu && <Menu {...menu} close={() => set_menu(null)} />}
      <div className="unseen" role="status" aria-live="polite">{said}</div>
    </div>
  );
}

/** Where the canvas was looked at when the tab was left. */
const kept_viewport: { path: string; at: Viewport | null; fitted: boolean } = { path: '', at: null, fitted: false };

/** Elements that are equal stay the same objects, so that React Flow has nothing to do with them. */
function reuse(before: AnyNode[], next: AnyNode[]): AnyNode[] {
  const old = new Map(before.map((n) => [n.id, n]));
  return next.map((n) => {
    const twin = old.get(n.id);
    return twin && twin.selected === n.selected && twin.position.x === n.position.x && twin.position.y === n.position.y && twin.type === n.type && Object.values(twin.data)[0] === Object.values(n.data)[0] ? twin : n;
  });
}

/** Dropped on an LSI beside its pins: the first pin of it that fits. */
function body_pin(client: { x: number; y: number }, from: PinAt): PinAt | null {
  const id = document.elementFromPoint(client.x, client.y)?.closest<HTMLElement>('[data-lsi]')?.dataset.lsi;
  const view = circuit.view;
  const node = id !== undefined ? view?.node(id) : undefined;
  if (!view || !node || node.id === from.node) return null;
  const rows = (from.side === 'out' ? node.inputs : node.outputs).map((pin): PinAt => ({ node: node.id, side: pin.side, pin: pin.name }));
  const near = rows.filter((pin) => {
    const [x, y] = pin_point(node, pin.side, pin.pin);
    const handle = document.querySelector(`[data-lsi="${CSS.escape(node.id)}"]`)?.getBoundingClientRect();
    const zoom = handle ? handle.width / node.width : 1;
    return handle && Math.abs(client.y - (handle.top + (y - node.y) * zoom)) < 11 * zoom && x >= 0;
  });
  return near[0] ?? rows.find((pin) => circuit.judge(pin) === null && (view.pin(pin.node, pin.side, pin.pin)?.multiple || view.at_pin(pin.node, pin.side, pin.pin).length === 0)) ?? null;
}

function Bar({ count, fit, arrange }: { count: React.RefObject<HTMLSpanElement | null>; fit: () => void; arrange: () => void }): ReactElement {
  const path = useCircuit((s) => s.path);
  const edited = useCircuit((s) => s.edited);
  const lsis = useCircuit((s) => s.view?.nodes.filter((n) => n.lsi).length ?? 0);
  const problems = useCircuit((s) => s.problems);
  const step = useStudio((s) => s.document?.step ?? 0.002);
  const [listed, set_listed] = useState(false);
  const rate = 1 / step;
  const crumbs = circuit.crumbs;
  return (
    <div className="circuit-bar">
      <nav className="crumbs" aria-label="Where in the circuit">
        <button type="button" aria-current={path.length === 0 ? 'page' : undefined} onClick={() => circuit.go_out(path.length)}>Execution circuit</button>
        {crumbs.map((name, i) => (
          <span key={i}>
            <span className="crumb-arrow" aria-hidden="true">›</span>
            <button type="button" aria-current={i === crumbs.length - 1 ? 'page' : undefined} onClick={() => circuit.go_out(crumbs.length - 1 - i)}>{name}</button>
          </span>
        ))}
      </nav>
      <div className="circuit-facts">
        {problems.length > 0 && (
          <button type="button" className="problem-count" aria-expanded={listed} onClick={() => set_listed(!listed)}>
            {problems.length === 1 ? 'It does not run: 1 problem' : `It does not run: ${problems.length} problems`}
          </button>
        )}
        {edited && (
          <button type="button" title="The project has a circuit of its own. Back to the one that the generator makes of the scenario; can be undone." onClick={() => circuit.reset_to_generated()}>Reset to generated</button>
        )}
        <button type="button" title="Lay out (Shift L)" onClick={arrange}>Lay out</button>
        <button type="button" title="Show all (A or Home)" onClick={() => fit()}>Fit</button>
        <span className="fact">{lsis} {lsis === 1 ? 'LSI' : 'LSIs'}<span ref={count} className="tick" /></span>
        <span className="fact">{rate >= 1000 ? `${+(rate / 1000).toFixed(2)} kHz` : `${Math.round(rate)} Hz`}</span>
      </div>
      {listed && problems.length > 0 && (
        <ul className="problem-list" role="list">
          {problems.slice(0, 40).map((p, i) => (
            <li key={i}>
              <button
                type="button"
                onClick={() => {
                  const ids = p.lsi.split('/');
                  if (!p.lsi) return;
                  circuit.go_to(ids);
                  parts.circuit?.fit(new Set([ids.at(-1)!]));
                }}
              >
                {p.lsi && <code>{p.lsi}</code>} {p.message} <span className="remedy">{p.remedy}</span>
              </button>
              {p.loop.length > 0 && <button type="button" onClick={() => circuit.insert_delay(p)}>Insert delay</button>}
            </li>
          ))}
          <li><button type="button" className="tool small" aria-label="Close" onClick={() => set_listed(false)}><Icon name="close" /></button></li>
        </ul>
      )}
    </div>
  );
}

