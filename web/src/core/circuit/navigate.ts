/** Keyboard navigation in a circuit, and descriptions of nodes and pins for screen readers. */
import type { PinAt } from './fits';
import { inputs_node, outputs_node, type View, type ViewNode } from './view';

export type Direction = 'left' | 'right' | 'up' | 'down';

/**
 * Finds the closest node in a direction. A distance perpendicular to the direction counts 2.2 times as much as one along it.
 * @return its id, or null
 */
export function next_node(view: View, from: string | null, direction: Direction): string | null {
  const start = from ? view.node(from) : undefined;
  if (!start) return [...view.nodes].sort((a, b) => a.x - b.x || a.y - b.y)[0]?.id ?? null;
  const middle = (n: ViewNode): [number, number] => [n.x + n.width / 2, n.y + n.height / 2];
  const [x, y] = middle(start);
  let best: string | null = null;
  let min_cost = Infinity;
  for (const node of view.nodes) {
    if (node === start) continue;
    const [u, v] = middle(node);
    const [dx, dy] = [u - x, v - y];
    const ahead = direction === 'left' ? -dx : direction === 'right' ? dx : direction === 'up' ? -dy : dy;
    const aside = Math.abs(direction === 'left' || direction === 'right' ? dy : dx);
    if (ahead <= 1) continue;
    const cost = ahead + 2.2 * aside;
    if (cost < min_cost) {
      min_cost = cost;
      best = node.id;
    }
  }
  return best;
}

/** The next pin in a direction: up and down within a side of the node, sideways to the node's other side or along a wire. */
export function next_pin(view: View, at: PinAt, direction: Direction): PinAt | null {
  const node = view.node(at.node);
  if (!node) return null;
  const list = at.side === 'in' ? node.inputs : node.outputs;
  const index = list.findIndex((p) => p.name === at.pin);
  if (direction === 'up' || direction === 'down') {
    const next = list[index + (direction === 'up' ? -1 : 1)];
    return next ? { ...at, pin: next.name } : null;
  }
  const outwards = (direction === 'right') === (at.side === 'out');
  if (!outwards) {
    const other = at.side === 'in' ? node.outputs : node.inputs;
    const pin = other[Math.min(Math.max(0, index), other.length - 1)];
    return pin ? { node: at.node, side: at.side === 'in' ? 'out' : 'in', pin: pin.name } : null;
  }
  const wire = view.at_pin(at.node, at.side, at.pin)[0];
  if (!wire) return null;
  return at.side === 'out' ? { node: wire.to, side: 'in', pin: wire.to_pin } : { node: wire.from, side: 'out', pin: wire.from_pin };
}

/** The first output of a node, or its first input, or null. */
export function first_pin(view: View, node: string): PinAt | null {
  const found = view.node(node);
  if (!found) return null;
  const out = found.outputs[0];
  if (out) return { node, side: 'out', pin: out.name };
  const into = found.inputs[0];
  return into ? { node, side: 'in', pin: into.name } : null;
}

/** Description of a pin for screen readers. */
export function describe_pin(view: View, at: PinAt): string {
  const pin = view.pin(at.node, at.side, at.pin);
  const node = view.node(at.node);
  if (!pin || !node) return '';
  const wires = view.at_pin(at.node, at.side, at.pin);
  const other = (w: (typeof wires)[number]): string => {
    const id = at.side === 'in' ? w.from : w.to;
    return `${view.node(id)?.title ?? id}, ${at.side === 'in' ? w.from_pin : w.to_pin}`;
  };
  const to = wires.length === 0 ? 'not wired' : `wired ${at.side === 'in' ? 'from' : 'to'} ${wires.map(other).join(' and ')}`;
  return `${at.side === 'in' ? 'Input' : 'Output'} ${pin.name} of ${node.title}, ${pin.type}${pin.unit ? `, ${pin.unit}` : ''}, ${to}`;
}

/** Description of a node for screen readers. */
export function describe_node(node: ViewNode): string {
  if (node.id === inputs_node) return `The circuit’s own inputs, ${node.outputs.length}`;
  if (node.id === outputs_node) return `The circuit’s own outputs, ${node.inputs.length}`;
  const kind = node.kind === 'missing' ? 'missing LSI' : node.kind === 'circuit' ? 'circuit' : 'LSI';
  return `${node.title}${node.subtitle ? `, ${node.subtitle}` : ''}, ${kind}, ${node.inputs.length} inputs, ${node.outputs.length} outputs`;
}
