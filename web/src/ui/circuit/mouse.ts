/** Mouse control of the canvas: moves LSIs, draws wires, selects areas. */
import { applyNodeChanges, type FinalConnectionState, type NodeChange, type OnConnectStart } from '@xyflow/react';
import { useCallback, useRef, useState, type MouseEvent, type PointerEvent } from 'react';
import type { PinAt } from '../../core/circuit/fits';
import type { Point } from '../../core/circuit/form';
import { boxes_meet, type Box } from '../../core/circuit/spatial';
import { note_id, note_size, pin_point, probe_id, probe_size, type View, type ViewNode, type ViewWire } from '../../core/circuit/view';
import { circuit } from '../app';
import type { Drawing } from './drawing';
import type { WireEdgeType } from './edges';
import type { AnyNode } from './elements';
import type { Client, Surface } from './surface';

/** The pin of a React Flow handle, whose id is "in:name" or "out:name". */
export const pin_of = (node: string | null | undefined, handle: string | null | undefined): PinAt | null => {
  if (!node || !handle) return null;
  const colon = handle.indexOf(':');
  return { node, side: handle.slice(0, colon) === 'in' ? 'in' : 'out', pin: handle.slice(colon + 1) };
};

/** Applies React Flow's node changes: selections, and positions while nodes are dragged. One drag is one command. */
export function useNodeDrag(drawing: Drawing) {
  const { set_nodes, invalidate, refresh } = drawing;
  const start = useRef<{ id: string; places: Map<string, Point> } | null>(null);

  const on_nodes_change = useCallback((changes: NodeChange<AnyNode>[]) => {
    const moves = changes.filter((c) => c.type === 'position' || c.type === 'dimensions');
    if (moves.length > 0) set_nodes((before) => applyNodeChanges(moves, before));
    const picks = changes.filter((c) => c.type === 'select');
    if (picks.length === 0) return;
    const next = new Set(circuit.state.nodes);
    for (const c of picks) c.selected ? next.add(c.id) : next.delete(c.id);
    circuit.select(next, picks.some((c) => c.selected) ? [] : circuit.state.wires);
  }, [set_nodes]);

  const drag_start = useCallback((_e: unknown, node: AnyNode) => {
    const ids = circuit.state.nodes.has(node.id) ? circuit.state.nodes : new Set([node.id]);
    const places = new Map<string, Point>();
    for (const id of ids) {
      const at = circuit.place_of(id);
      if (at) places.set(id, at);
    }
    start.current = { id: node.id, places };
  }, []);
  const places_at = (node: AnyNode): Map<string, Point> | null => {
    const own = start.current?.places.get(start.current.id);
    if (!own) return null;
    const [dx, dy] = [node.position.x - own[0], node.position.y - own[1]];
    return new Map([...start.current!.places].map(([id, at]) => [id, [at[0] + dx, at[1] + dy] as Point]));
  };
  const on_drag = useCallback((_e: unknown, node: AnyNode) => {
    circuit.drag = places_at(node);
    invalidate();
  }, [invalidate]);
  const drag_stop = useCallback((_e: unknown, node: AnyNode) => {
    const places = places_at(node);
    start.current = null;
    circuit.drag = null;
    if (places) circuit.move(places);
    refresh();
  }, [refresh]);
  return { on_nodes_change, drag_start, on_drag, drag_stop };
}

/** Draws wires. A wire starts at a pin and ends at a pin, on an LSI, or on the empty canvas, which opens the search. */
export function useWiring(view: View, open_search: (client: Client, fits: PinAt) => void) {
  /** Existing wire of which one end is being moved. */
  const moved_wire = useRef<ViewWire | null>(null);

  const connect_start: OnConnectStart = useCallback((_e, { nodeId, handleId }) => {
    const pin = pin_of(nodeId, handleId);
    if (pin) circuit.begin_wire(pin);
  }, []);
  const connect_end = useCallback((event: globalThis.MouseEvent | TouchEvent, state: FinalConnectionState) => {
    const from = circuit.state.connecting ?? pin_of(state.fromNode?.id, state.fromHandle?.id);
    const moved = moved_wire.current ?? undefined;
    moved_wire.current = null;
    if (!from) return;
    const client = 'changedTouches' in event ? { x: event.changedTouches[0]!.clientX, y: event.changedTouches[0]!.clientY } : { x: event.clientX, y: event.clientY };
    const to = pin_of(state.toNode?.id, state.toHandle?.id) ?? body_pin(client, from);
    const hit = document.elementFromPoint(client.x, client.y);
    if (to) {
      const reason = circuit.end_wire(from, to, moved);
      if (reason) circuit.refuse(reason, client);
    } else if (moved) {
      circuit.cancel_wire();
      circuit.disconnect([moved]);
    } else if (hit?.closest('.circuit .lsi')) {
      circuit.cancel_wire();
      circuit.refuse('No pin of this LSI has a matching type.', client);
    } else if (hit?.closest('.circuit')) open_search(client, from);
    else circuit.cancel_wire();
  }, [open_search]);
  /** `side` is the end of the wire that stays connected. */
  const reconnect_start = useCallback((_e: unknown, edge: WireEdgeType, side: 'source' | 'target') => {
    const wire = (moved_wire.current = view.wire(edge.id) ?? null);
    if (wire) circuit.begin_wire(side === 'target' ? { node: wire.to, side: 'in', pin: wire.to_pin } : { node: wire.from, side: 'out', pin: wire.from_pin });
  }, [view]);
  return { connect_start, connect_end, reconnect_start };
}

/** The pin for a wire dropped on the body of an LSI: the pin in that row, otherwise the first free pin that fits. */
function body_pin(client: Client, from: PinAt): PinAt | null {
  const element = document.elementFromPoint(client.x, client.y)?.closest<HTMLElement>('[data-lsi]');
  const view = circuit.view;
  const node = element?.dataset.lsi !== undefined ? view?.node(element.dataset.lsi) : undefined;
  if (!view || !node || !element || node.id === from.node) return null;
  const rows = (from.side === 'out' ? node.inputs : node.outputs).map((pin): PinAt => ({ node: node.id, side: pin.side, pin: pin.name }));
  const rect = element.getBoundingClientRect();
  const zoom = rect.width / node.width;
  const near = rows.find((pin) => Math.abs(client.y - (rect.top + (pin_point(node, pin.side, pin.pin)[1] - node.y) * zoom)) < 11 * zoom);
  return near ?? rows.find((pin) => circuit.wire_refusal(pin) === null && (view.pin(pin.node, pin.side, pin.pin)?.multiple || view.at_pin(pin.node, pin.side, pin.pin).length === 0)) ?? null;
}

/** Selection by a rectangle dragged on the empty canvas. A click selects the LSI that the canvas draws there, or clears the selection. */
export function useMarquee(view: View, surface: Surface, drawing: Drawing) {
  const [marquee, set_marquee] = useState<Box | null>(null);
  const at_point = useCallback((client: Client): ViewNode | undefined => {
    const drawn = drawing.drawn.current;
    const [x, y] = surface.to_plane(client);
    const hit = view.index.find({ x, y, width: 1, height: 1 })[0];
    return hit && !drawn?.ids.has(hit.id) ? hit : undefined;
  }, [view, surface, drawing.drawn]);

  const begin = (event: PointerEvent<HTMLDivElement>): void => {
    const start = { x: event.clientX, y: event.clientY };
    const before = event.shiftKey || event.ctrlKey ? new Set(circuit.state.nodes) : new Set<string>();
    const box = surface.origin()!;
    let moved = false;
    const within = (r: Box): Set<string> => {
      const [x, y] = surface.to_plane({ x: r.x, y: r.y });
      const [x2, y2] = surface.to_plane({ x: r.x + r.width, y: r.y + r.height });
      return new Set([...before, ...ids_in(view, { x, y, width: x2 - x, height: y2 - y })]);
    };
    const move = (e: globalThis.PointerEvent): void => {
      const r = { x: Math.min(start.x, e.clientX), y: Math.min(start.y, e.clientY), width: Math.abs(e.clientX - start.x), height: Math.abs(e.clientY - start.y) };
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
      const hit = at_point({ x: e.clientX, y: e.clientY });
      if (hit) circuit.select([...before, hit.id]);
      else if (before.size === 0) circuit.select([]);
    };
    window.addEventListener('pointermove', move);
    window.addEventListener('pointerup', end);
    window.addEventListener('pointercancel', end);
  };
  return { marquee, begin, at_point };
}

function* ids_in(view: View, area: Box): Generator<string> {
  for (const node of view.index.find(area)) yield node.id;
  for (const note of view.notes) if (boxes_meet({ x: note.at[0], y: note.at[1], width: note_size(note)[0], height: note_size(note)[1] }, area)) yield note_id(note.id);
  for (const probe of view.probes) if (boxes_meet({ x: probe.at[0], y: probe.at[1], width: probe_size[0], height: probe_size[1] }, area)) yield probe_id(probe.pin);
}

/** A double click opens a circuit, renames an LSI, zooms to an LSI that is drawn on the canvas, or opens the search. */
export function double_click(event: MouseEvent<HTMLDivElement>, at_point: (client: Client) => ViewNode | undefined, surface: Surface, open_search: (client: Client) => void): void {
  const target = event.target as HTMLElement;
  if (target.closest('.circuit-search, .stop-form, .stop-notice, .menu, .circuit-bar, .circuit-map, .note, .probe, .problem-bubble, input, textarea')) return;
  const lsi = target.closest<HTMLElement>('[data-lsi]')?.dataset.lsi;
  if (lsi !== undefined) {
    if (circuit.view?.node(lsi)?.kind === 'circuit') circuit.go_inside(lsi);
    else if (target.closest('.lsi-head') && circuit.view?.node(lsi)?.lsi) circuit.type_in(lsi);
    return;
  }
  if (!target.classList.contains('react-flow__pane')) return;
  const client = { x: event.clientX, y: event.clientY };
  const hit = at_point(client);
  if (hit) void surface.flow.setCenter(hit.x + hit.width / 2, hit.y + hit.height / 2, { zoom: 1 });
  else open_search(client);
}
