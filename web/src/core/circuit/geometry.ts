/** Sizes of nodes and curves of wires in the circuit's plane; all lengths in px of that plane. */
import type { Note, Point } from './form';
import type { ViewNode } from './view';

export const grid = 10;
export const head_height = 34;
export const row_height = 22;
const foot = 8;
const min_width = 160;
const max_width = 280;

export const probe_size: Point = [216, 96];
export const note_size = (note: Note): Point => note.size ?? [180, 80];

/** Estimated width of a text in the page's font; 0.56 is the mean width of a character relative to the font size. */
const text_width = (text: string, size = 13): number => text.length * size * 0.56;
// rounds a length up to a multiple of the grid spacing
const up = (value: number): number => Math.ceil(value / grid) * grid;

export function size_of(node: Pick<ViewNode, 'title' | 'inputs' | 'outputs' | 'kind'>): { width: number; height: number } {
  const rows = Math.max(node.inputs.length, node.outputs.length);
  let widest = text_width(node.title) + (node.kind === 'class' || node.kind === 'circuit' ? 74 : 28);
  for (let i = 0; i < rows; i++) widest = Math.max(widest, text_width(node.inputs[i]?.name ?? '', 12) + text_width(node.outputs[i]?.name ?? '', 12) + 48);
  return { width: up(Math.min(max_width, Math.max(min_width, widest))), height: head_height + Math.max(1, rows) * row_height + foot };
}

/** Position of pin `index` of a side, relative to the node's upper left corner. */
export const pin_offset = (node: Pick<ViewNode, 'width'>, side: 'in' | 'out', index: number): Point => [side === 'in' ? 0 : node.width, head_height + row_height * (index + 0.5) + foot / 2];

/** End point of a wire at a pin. If the pin does not exist, the node's first pin is used. */
export function pin_point(node: ViewNode, side: 'in' | 'out', name: string): Point {
  const list = side === 'in' ? node.inputs : node.outputs;
  const [x, y] = pin_offset(node, side, Math.max(0, list.findIndex((p) => p.name === name)));
  return [node.x + x, node.y + y];
}

/**
 * Bezier control points of a wire from a to b, horizontal at both ends. A wire that runs backwards bends outwards so that it stays visible.
 */
export function wire_curve(a: Point, b: Point): [Point, Point, Point, Point] {
  const dx = b[0] - a[0];
  const bend = dx >= 0 ? Math.max(24, dx / 2) : Math.min(260, 60 - dx / 3);
  const sag = dx < -40 && Math.abs(b[1] - a[1]) < 60 ? 90 : 0;
  return [a, [a[0] + bend, a[1] + sag], [b[0] - bend, b[1] + sag], b];
}

/** Path of a wire from a to b, in SVG syntax. */
export function wire_path(a: Point, b: Point): string {
  const [p, q, r, s] = wire_curve(a, b);
  return `M${p[0]} ${p[1]}C${q[0]} ${q[1]} ${r[0]} ${r[1]} ${s[0]} ${s[1]}`;
}
