/**
 * React Flow elements (nodes and edges) of the LSIs in view. In each frame a few elements are added and removed, so that no frame takes
 * long; until an LSI has its element, the canvas draws the LSI.
 */
import { Position } from '@xyflow/react';
import type { EditorState } from '../../core/circuit/editor';
import { boxes_meet, type Box } from '../../core/circuit/spatial';
import { note_id, note_size, pin_offset, probe_id, probe_size, type View, type ViewNode, type ViewWire } from '../../core/circuit/view';
import type { WireEdgeType } from './edges';
import type { LsiNodeType, NoteNodeType, ProbeNodeType } from './nodes';

export type AnyNode = LsiNodeType | NoteNodeType | ProbeNodeType;

/** Maximum number of LSIs that become elements, and that stop being elements, in one frame. */
const max_new = 10;
const max_gone = 60;

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

/** One step from the elements `before` to the elements `wanted`. @return ids of the LSIs that are elements now; done: no step is left */
export function next_elements(before: ReadonlySet<string>, wanted: ReadonlySet<string>, at_once: boolean): { ids: Set<string>; done: boolean } {
  if (at_once) return { ids: new Set(wanted), done: true };
  const ids = new Set<string>();
  let removed = 0;
  for (const id of before) if (wanted.has(id) || removed++ >= max_gone) ids.add(id);
  let added = 0;
  let done = removed <= max_gone;
  for (const id of wanted) {
    if (ids.has(id)) continue;
    if (added++ < max_new) ids.add(id);
    else done = false;
  }
  return { ids, done };
}

/** Elements of the LSIs `ids`, of the wires between them, and of the notes and probes in `box` (null: none). */
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

/** Replaces elements by the equal objects of the previous list, so that React Flow does not render them again. */
export function reuse_nodes(before: readonly AnyNode[], next: readonly AnyNode[]): AnyNode[] {
  const old = new Map(before.map((n) => [n.id, n]));
  return next.map((n) => {
    const previous = old.get(n.id);
    return previous && previous.selected === n.selected && previous.position.x === n.position.x && previous.position.y === n.position.y && previous.type === n.type && Object.values(previous.data)[0] === Object.values(n.data)[0] ? previous : n;
  });
}

export function reuse_edges(before: readonly WireEdgeType[], next: readonly WireEdgeType[]): WireEdgeType[] {
  const old = new Map(before.map((e) => [e.id, e]));
  return next.map((e) => {
    const previous = old.get(e.id);
    return previous && previous.selected === e.selected && previous.data!.wire === e.data!.wire && previous.data!.loop === e.data!.loop && previous.ariaLabel === e.ariaLabel ? previous : e;
  });
}
