/** Rules for wires: which pins may be wired together, and why others may not. */
import { inputs_node, new_pin, outputs_node, type PinInfo, type View } from './view';

/** A pin at a node of the shown level. */
export interface PinAt {
  node: string;
  side: 'in' | 'out';
  pin: string;
}

export const same_pin = (a: PinAt | null, b: PinAt | null): boolean => a === b || (a !== null && b !== null && a.node === b.node && a.side === b.side && a.pin === b.pin);

/** True if the pin types are equal or one is `any` (a pin of a missing LSI, or a new pin of the circuit itself). */
export const types_fit = (a: string, b: string): boolean => a === b || a === 'any' || b === 'any';

/** Why two pins may not be wired, as a sentence; null if they may. */
export function why_not(view: View, a: PinAt, b: PinAt): string | null {
  if (a.side === b.side) return a.side === 'in' ? 'Both are inputs: a wire begins at an output.' : 'Both are outputs: a wire ends at an input.';
  const [out, into] = a.side === 'out' ? [a, b] : [b, a];
  const source = view.pin(out.node, 'out', out.pin);
  const target = view.pin(into.node, 'in', into.pin);
  if (!source || !target) return 'One of the pins no longer exists.';
  if (out.node === inputs_node && into.node === outputs_node) return 'An input of the circuit cannot be wired directly to an output of the circuit: put an LSI in between.';
  if (source.name === new_pin && target.name === new_pin) return 'One end of the wire must be a pin of an LSI.';
  if (!types_fit(source.type, target.type)) {
    const between = source.type === 'vector' && target.type === 'scalar' ? ' Put a “split vector” in between.' : source.type === 'scalar' && target.type === 'vector' ? ' Put a “make vector” in between.' : '';
    return `“${source.name}” carries ${source.type}, “${target.name}” takes ${target.type}.${between}`;
  }
  if (view.at_pin(out.node, 'out', out.pin).some((w) => w.to === into.node && w.to_pin === into.pin)) return 'These two pins are already wired.';
  return null;
}

/** Pins of the view that may be wired to `from`, sorted by the distance of their nodes. */
export function pins_that_fit(view: View, from: PinAt): PinAt[] {
  const origin = view.node(from.node);
  const found: { pin: PinAt; distance: number }[] = [];
  for (const node of view.nodes) {
    const list: PinInfo[] = from.side === 'out' ? node.inputs : node.outputs;
    for (const pin of list) {
      const at: PinAt = { node: node.id, side: pin.side, pin: pin.name };
      if (why_not(view, from, at) === null) found.push({ pin: at, distance: origin ? Math.hypot(node.x - origin.x, node.y - origin.y) : 0 });
    }
  }
  return found.sort((a, b) => a.distance - b.distance).map((f) => f.pin);
}
