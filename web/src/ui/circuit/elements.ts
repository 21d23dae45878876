/** What is near as React Flow's nodes and edges. Elements come and go a few at a time, so that no frame waits for them; until they are there, the canvas draws. */
import { Position } from '@xyflow/react';
import type { EditorState } from '../../core/circuit/editor';
import { boxes_meet, type Box } from '../../core/circuit/spatial';
import { note_id, note_size, pin_offset, probe_id, probe_size, type View, type ViewNode, type ViewWire } from '../../core/circuit/view';
import type { WireEdgeType } from './edges';
import type { LsiNodeType, NoteNodeType, ProbeNodeType } from './nodes';

export type AnyNode = LsiNodeType | NoteNodeType | ProbeNodeType;

/** LSIs that become elements, or cease to be, in one frame. */
const most_new = 10;
const most_gone = 60;

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

/** Which LSIs are elements now, and whether more are to come or go: some steps from `before` to `wanted`. */
export function next_elements(before: ReadonlySet<string>, wanted: ReadonlySet<string>, at_once: boolean): { ids: Set<string>; done: boolean } {
  if (at_once) return { ids: new Set(wanted), done: true };
  const ids = new Set<string>();
  let gone = 0;
  for (const id of before) if (wanted.has(id) || gone++ >= most_gone) ids.add(id);
  let come = 0;
  let done = gone <= most_gone;
  for (const id of wanted) {
    if (ids.has(id)) continue;
    if (come++ < most_new) ids.add(id);
    else done = false;
  }
  return { ids, done };
}

/** The LSIs of `ids` as nodes, with the wires between them, and the notes and probes in `box`. */
export function make_elements(view: View, ids: ReadonlySet<string>, box: Box | null, state: EditorState, loop: ReadonlySet<string>): { nodes: AnyNode[]; edges: WireEdgeType[]; wires: Set<string> } {
  const nodes: AnyNode[] = [];
  const edges: WireEdgeType[] = [];
  const wires = new Set<string>();
  const seen = new Set<ViewWire>();
  for (const id of ids) {
    const node = view.node(id);
    if (!node) continue;
    nodes.push(lsi_element(node, state.nodes.has(id)));
    for (const wire of view.at_node(id)) {
      if (seen.has(wire) || wire.broken || !ids.has(wire.from) || !ids.has(wire.to)) continue;
      seen.add(wire);
      wires.add(wire.key);
      edges.push({
        id: wire.key, type: 'wire', source: wire.from, sourceHandle: `out:${wire.from_pin}`, target: wire.to, targetHandle: `in:${wire.to_pin}`, data: { wire, loop: loop.has(wire.key) }, selected: state.wires.has(wire.key),
        ariaLabel: `Wire from ${view.node(wire.from)?.title}, ${wire.from_pin}, to ${view.node(wire.to)?.title}, ${wire.to_pin}`,
      });
    }
  }
  if (!box) return { nodes, edges, wires };
  const place = (id: string, at: readonly [number, number], [width, height]: readonly [number, number]) =>
    boxes_meet({ x: at[0], y: at[1], width, height }, box) ? { id, position: { x: at[0], y: at[1] }, width, height, measured: { width, height }, selected: state.nodes.has(id) } : null;
  for (const note of view.notes) {
    const at = place(note_id(note.id), note.at, note_size(note));
    if (at) nodes.push({ ...at, type: 'note', data: { note }, zIndex: -1 });
  }
  for (const probe of view.probes) {
    const at = place(probe_id(probe.pin), probe.at, probe_size);
    if (at) nodes.push({ ...at, type: 'probe', data: { probe } });
  }
  return { nodes, edges, wires };
}

/** Elements that are equal stay the same objects, so that React Flow has nothing to do with them. */
export function reuse_nodes(before: readonly AnyNode[], next: readonly AnyNode[]): AnyNode[] {
  const old = new Map(before.map((n) => [n.id, n]));
  return next.map((n) => {
    const twin = old.get(n.id);
    return twin && twin.selected === n.selected && twin.position.x === n.position.x && twin.position.y === n.position.y && twin.type === n.type && Object.values(twin.data)[0] === Object.values(n.data)[0] ? twin : n;
  });
}

export function reuse_edges(before: readonly WireEdgeType[], next: readonly WireEdgeType[]): WireEdgeType[] {
  const old = new Map(before.map((e) => [e.id, e]));
  return next.map((e) => {
    const twin = old.get(e.id);
    return twin && twin.selected === e.selected && twin.data!.wire === e.data!.wire && twin.data!.loop === e.data!.loop && twin.ariaLabel === e.ariaLabel ? twin : e;
  });
}
