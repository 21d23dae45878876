/** Sizes and curves in the circuit's plane, in its pixels. */
import type { Note, Point } from './form';
import type { ViewNode } from './view';

export const grid = 10;
export const head_height = 34;
export const row_height = 22;
const foot = 8;
const least_width = 160;
const most_width = 280;

export const probe_size: Point = [216, 96];
export const note_size = (note: Note): Point => note.size ?? [180, 80];

/** About the width of a text in the page's font at 13 px. */
const text_width = (text: string, size = 13): number => text.length * size * 0.56;
const up = (value: number): number => Math.ceil(value / grid) * grid;

export function size_of(node: Pick<ViewNode, 'title' | 'inputs' | 'outputs' | 'kind'>): { width: number; height: number } {
  const rows = Math.max(node.inputs.length, node.outputs.length);
  let widest = text_width(node.title) + (node.kind === 'class' || node.kind === 'circuit' ? 74 : 28);
  for (let i = 0; i < rows; i++) widest = Math.max(widest, text_width(node.inputs[i]?.name ?? '', 12) + text_width(node.outputs[i]?.name ?? '', 12) + 48);
  return { width: up(Math.min(most_width, Math.max(least_width, widest))), height: head_height + Math.max(1, rows) * row_height + foot };
}

/** Middle of pin `index` of a side, from the node's corner. */
export const pin_offset = (node: Pick<ViewNode, 'width'>, side: 'in' | 'out', index: number): Point => [side === 'in' ? 0 : node.width, head_height + row_height * (index + 0.5) + foot / 2];

/** Where a wire begins or ends; the node's first pin where the pin is not there. */
export function pin_point(node: ViewNode, side: 'in' | 'out', name: string): Point {
  const list = side === 'in' ? node.inputs : node.outputs;
  const [x, y] = pin_offset(node, side, Math.max(0, list.findIndex((p) => p.name === name)));
  return [node.x + x, node.y + y];
}

/** Control points of a wire from a to b: level at both ends; a wire that runs back bows out far enough to be seen. */
export function wire_curve(a: Point, b: Point): [Point, Point, Point, Point] {
  const dx = b[0] - a[0];
  const bend = dx >= 0 ? Math.max(24, dx / 2) : Math.min(260, 60 - dx / 3);
  const sag = dx < -40 && Math.abs(b[1] - a[1]) < 60 ? 90 : 0;
  return [a, [a[0] + bend, a[1] + sag], [b[0] - bend, b[1] + sag], b];
}

export function wire_path(a: Point, b: Point): string {
  const [p, q, r, s] = wire_curve(a, b);
  return `M${p[0]} ${p[1]}C${q[0]} ${q[1]} ${r[0]} ${r[1]} ${s[0]} ${s[1]}`;
}
