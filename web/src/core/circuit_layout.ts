/** Places the LSIs of a circuit in columns from its inputs to its outputs, for a diagram that is only looked at. */
import type { CircuitData } from './protocol';

export type PinHue = 'scalar' | 'vector' | 'rotation' | 'joints' | 'state' | 'contacts' | 'event' | 'motion' | 'any';

export interface CircuitBox {
  id: string;
  name: string;
  type: string;
  x: number;
  y: number;
  width: number;
  height: number;
  pins: { name: string; side: 'in' | 'out'; y: number; hue: PinHue }[];
}

export interface CircuitLayout {
  boxes: CircuitBox[];
  wires: { from: string; to: string; path: string; hue: PinHue; title: string }[];
  width: number;
  height: number;
}

const box_width = 178;
const column_gap = 84;
const row_gap = 22;
const head = 44;
const pin_step = 18;
const margin = 24;
const side_margin = 68; // wires back to the first column turn in it

/** The hue of a pin by what it carries. */
export function pin_hue(type_or_name: string): PinHue {
  const text = type_or_name.toLowerCase();
  if (/contact/.test(text)) return 'contacts';
  if (/event/.test(text)) return 'event';
  if (/motion|clip|sample|reference/.test(text)) return 'motion';
  if (/state|status/.test(text)) return 'state';
  if (/rotation|quat/.test(text)) return 'rotation';
  if (/joint|tau|torque|drive|pose/.test(text)) return 'joints';
  if (/vec|force|wrench|point/.test(text)) return 'vector';
  if (/scalar|number|time|real|double/.test(text)) return 'scalar';
  return 'any';
}

const split_end = (end: string | [string, string]): [string, string] => {
  if (Array.isArray(end)) return end;
  const dot = end.lastIndexOf('.');
  return dot < 0 ? [end, ''] : [end.slice(0, dot), end.slice(dot + 1)];
};

export function lay_out_circuit(circuit: CircuitData): CircuitLayout {
  const ids = circuit.lsis.map((l) => l.id);
  const known = new Set(ids);
  const wires = circuit.wires
    .map((w) => ({ from: split_end(w.from), to: split_end(w.to) }))
    .filter((w) => known.has(w.from[0]) && known.has(w.to[0]));

  // columns: the longest way from a source; wires back (through the tick) are left out of it
  const column = new Map<string, number>();
  const visiting = new Set<string>();
  const column_of = (id: string): number => {
    const done = column.get(id);
    if (done !== undefined) return done;
    if (visiting.has(id)) return -1;
    visiting.add(id);
    let depth = 0;
    for (const w of wires) if (w.to[0] === id && w.from[0] !== id) depth = Math.max(depth, column_of(w.from[0]) + 1);
    visiting.delete(id);
    column.set(id, depth);
    return depth;
  };
  ids.forEach(column_of);

  const pins = new Map<string, CircuitBox['pins']>();
  for (const lsi of circuit.lsis) {
    const list: CircuitBox['pins'] = [];
    const add = (name: string, side: 'in' | 'out', type: string): void => {
      if (!name || list.some((p) => p.name === name && p.side === side)) return;
      const row = list.filter((p) => p.side === side).length;
      list.push({ name, side, y: head + 8 + row * pin_step, hue: pin_hue(type) });
    };
    for (const pin of lsi.pins ?? []) add(pin.name, pin.direction, `${pin.type} ${pin.name}`);
    for (const w of wires) {
      if (w.from[0] === lsi.id) add(w.from[1], 'out', w.from[1]);
      if (w.to[0] === lsi.id) add(w.to[1], 'in', w.to[1]);
    }
    pins.set(lsi.id, list);
  }

  const columns: CircuitBox[][] = [];
  for (const lsi of circuit.lsis) {
    const c = column.get(lsi.id) ?? 0;
    const list = pins.get(lsi.id) ?? [];
    const rows = Math.max(list.filter((p) => p.side === 'in').length, list.filter((p) => p.side === 'out').length);
    (columns[c] ??= []).push({
      id: lsi.id,
      name: lsi.name || lsi.id,
      type: lsi.type,
      x: side_margin + c * (box_width + column_gap),
      y: 0,
      width: box_width,
      height: head + rows * pin_step + (rows > 0 ? 4 : 0),
      pins: list,
    });
  }
  const tallest = Math.max(0, ...columns.map((boxes) => (boxes ?? []).reduce((sum, b) => sum + b.height + row_gap, -row_gap)));
  const boxes: CircuitBox[] = [];
  for (const list of columns) {
    const tall = (list ?? []).reduce((sum, b) => sum + b.height + row_gap, -row_gap);
    let y = margin + (tallest - tall) / 2;
    for (const box of list ?? []) {
      box.y = y;
      y += box.height + row_gap;
      boxes.push(box);
    }
  }

  const by_id = new Map(boxes.map((b) => [b.id, b]));
  const drawn = wires.map((w) => {
    const from = by_id.get(w.from[0])!;
    const to = by_id.get(w.to[0])!;
    const out = from.pins.find((p) => p.side === 'out' && p.name === w.from[1]);
    const into = to.pins.find((p) => p.side === 'in' && p.name === w.to[1]);
    const x1 = from.x + from.width;
    const y1 = from.y + (out?.y ?? head / 2);
    const x2 = to.x;
    const y2 = to.y + (into?.y ?? head / 2);
    const bend = Math.max(32, Math.abs(x2 - x1) / 2);
    const below = margin + tallest + 14;
    const path =
      x2 > x1
        ? `M${x1} ${y1}C${x1 + bend} ${y1} ${x2 - bend} ${y2} ${x2} ${y2}`
        : `M${x1} ${y1}C${x1 + 60} ${y1} ${x1 + 60} ${below} ${x1 - 20} ${below}L${x2 + 20} ${below}C${x2 - 60} ${below} ${x2 - 60} ${y2} ${x2} ${y2}`;
    return { from: from.id, to: to.id, path, hue: out?.hue ?? into?.hue ?? 'any', title: `${w.from.join('.')} → ${w.to.join('.')}` };
  });
  return {
    boxes,
    wires: drawn,
    width: 2 * side_margin + Math.max(1, columns.length) * (box_width + column_gap) - column_gap,
    height: 2 * margin + tallest + 16,
  };
}
