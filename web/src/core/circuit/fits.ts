/** Which pins may be wired, and in words why not. */
import { inputs_node, new_pin, outputs_node, type PinInfo, type View } from './view';

export interface PinAt {
  node: string;
  side: 'in' | 'out';
  pin: string;
}

export const same_pin = (a: PinAt | null, b: PinAt | null): boolean => a === b || (a !== null && b !== null && a.node === b.node && a.side === b.side && a.pin === b.pin);

/** Types fit if they are equal; the type of a pin that is not known (of a missing LSI, or a new own pin) fits all. */
export const types_fit = (a: string, b: string): boolean => a === b || a === 'any' || b === 'any';

/** null: the pins may be wired; otherwise the reason, a sentence. */
export function why_not(view: View, a: PinAt, b: PinAt): string | null {
  if (a.side === b.side) return a.side === 'in' ? 'Both are inputs: a wire begins at an output.' : 'Both are outputs: a wire ends at an input.';
  const [out, into] = a.side === 'out' ? [a, b] : [b, a];
  const source = view.pin(out.node, 'out', out.pin);
  const target = view.pin(into.node, 'in', into.pin);
  if (!source || !target) return 'One of the pins is not there any more.';
  if (out.node === inputs_node && into.node === outputs_node) return 'The circuit’s own input cannot lead straight to its own output: put an LSI between.';
  if (source.name === new_pin && target.name === new_pin) return 'Begin or end at a pin of an LSI.';
  if (!types_fit(source.type, target.type)) {
    const between = source.type === 'vector' && target.type === 'scalar' ? ' Put a “split vector” between.' : source.type === 'scalar' && target.type === 'vector' ? ' Put a “make vector” between.' : '';
    return `“${source.name}” carries ${source.type}, “${target.name}” takes ${target.type}.${between}`;
  }
  if (view.at_pin(out.node, 'out', out.pin).some((w) => w.to === into.node && w.to_pin === into.pin)) return 'These two are wired already.';
  return null;
}

/** Pins of the view that may be wired to `from`, nearest columns first. */
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
