/** Automatic layout: makes the graph for the layout engine, and reads its result. The page runs the engine (elkjs, in a worker). */
import type { Point } from './form';
import { grid, head_height, inputs_node, outputs_node, pin_offset, row_height, type View } from './view';

export interface ElkGraph {
  id: string;
  layoutOptions?: Record<string, string>;
  x?: number;
  y?: number;
  width?: number;
  height?: number;
  ports?: { id: string; x: number; y: number; width: number; height: number; layoutOptions?: Record<string, string> }[];
  children?: ElkGraph[];
  edges?: { id: string; sources: string[]; targets: string[] }[];
}

/** The graph of the nodes `ids`, or of all nodes of the view. Wires from delayed outputs have priority 0: they may run backwards. */
export function elk_graph(view: View, ids?: ReadonlySet<string>): ElkGraph {
  const nodes = view.nodes.filter((n) => !ids || ids.has(n.id));
  const known = new Set(nodes.map((n) => n.id));
  const port = (node: string, side: 'in' | 'out', pin: string): string => `${side} ${node}.${pin}`;
  const children = nodes.map((node): ElkGraph => ({
    id: node.id,
    width: node.width,
    height: node.height,
    layoutOptions: {
      'elk.portConstraints': 'FIXED_POS',
      ...(node.id === inputs_node ? { 'elk.layered.layering.layerConstraint': 'FIRST' } : {}),
      ...(node.id === outputs_node ? { 'elk.layered.layering.layerConstraint': 'LAST' } : {}),
    },
    ports: [...node.inputs, ...node.outputs].map((pin) => {
      const list = pin.side === 'in' ? node.inputs : node.outputs;
      const [x, y] = pin_offset(node, pin.side, list.indexOf(pin));
      return { id: port(node.id, pin.side, pin.name), x: pin.side === 'in' ? -1 : x, y, width: 1, height: 1, layoutOptions: { 'elk.port.side': pin.side === 'in' ? 'WEST' : 'EAST' } };
    }),
  }));
  const edges = view.wires
    .filter((w) => known.has(w.from) && known.has(w.to) && !w.broken)
    .map((w) => ({
      id: w.key, sources: [port(w.from, 'out', w.from_pin)], targets: [port(w.to, 'in', w.to_pin)],
      layoutOptions: { 'elk.layered.priority.direction': w.delayed ? '0' : '10' },
    }));
  return {
    id: 'circuit',
    layoutOptions: {
      'elk.algorithm': 'layered',
      'elk.direction': 'RIGHT',
      'elk.layered.spacing.nodeNodeBetweenLayers': '90',
      'elk.spacing.nodeNode': String(row_height + 8),
      'elk.layered.nodePlacement.strategy': 'BRANDES_KOEPF',
      'elk.layered.nodePlacement.bk.fixedAlignment': 'BALANCED',
      'elk.separateConnectedComponents': 'true',
      'elk.spacing.componentComponent': String(head_height),
    },
    children,
    edges,
  };
}

/** Positions on the grid by node id. The upper left corner of the laid-out nodes stays where it was. */
export function read_layout(view: View, answer: ElkGraph, ids?: ReadonlySet<string>): Map<string, Point> {
  const box = view.bounds(new Set(view.nodes.filter((n) => !ids || ids.has(n.id)).map((n) => n.id)));
  const children = answer.children ?? [];
  const left = Math.min(...children.map((c) => c.x ?? 0));
  const top = Math.min(...children.map((c) => c.y ?? 0));
  const to_grid = (v: number): number => Math.round(v / grid) * grid + 0; // + 0 converts -0, which JSON does not preserve, to 0
  return new Map(children.map((c) => [c.id, [to_grid((c.x ?? 0) - left + box.x), to_grid((c.y ?? 0) - top + box.y)] as Point]));
}
