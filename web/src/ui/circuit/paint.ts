/**
 * Drawing on two canvases, below and above the DOM elements of React Flow. The lower canvas shows the wires and LSIs that have no element.
 * The upper canvas shows the values of the LSIs in view.
 */
import { hue_of } from '../../core/circuit/classes';
import type { CircuitEditor } from '../../core/circuit/editor';
import type { Point } from '../../core/circuit/form';
import { short_time, short_value, type LiveValues } from '../../core/circuit/live';
import type { Box } from '../../core/circuit/spatial';
import { head_height, note_size, pin_offset, pin_point, wire_curve, type View, type ViewNode, type ViewWire } from '../../core/circuit/view';

export interface Viewport {
  x: number;
  y: number;
  zoom: number;
}

export type Colors = (name: string) => string;

const letters = '"Inter Variable", Inter, system-ui, "DejaVu Sans", sans-serif';

/** Zoom levels below which a detail is omitted: curved wires, borders of LSI boxes, titles and pins. */
const curve_zoom = 0.16;
const frame_zoom = 0.06;
const word_zoom = 0.2;
const pin_zoom = 0.24;
const widest_value = 240; // maximum width of a value, circuit coordinates
/**
 * At small zoom, wires shorter than this on the screen (px) are not drawn: such a wire is too small to see, and drawing thousands is slow.
 */
const shortest_wire = 3;

/** Reads the theme's colours (CSS variables) of an element; each is read once. */
export function read_colors(element: Element): Colors {
  const style = getComputedStyle(element);
  const known = new Map<string, string>();
  return (name) => {
    let color = known.get(name);
    if (color === undefined) known.set(name, (color = style.getPropertyValue(name).trim() || '#888'));
    return color;
  };
}

/** Resizes a canvas to its size on the page and clears it. @return context and size in px; null while the canvas has no size */
export function prepare(canvas: HTMLCanvasElement, options?: CanvasRenderingContext2DSettings): { c: CanvasRenderingContext2D; width: number; height: number } | null {
  const ratio = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  const c = canvas.getContext('2d', options);
  if (!c || width === 0 || height === 0) return null;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) {
    canvas.width = w;
    canvas.height = h;
  }
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  c.clearRect(0, 0, width, height);
  return { c, width, height };
}

/** The node, moved to its position in `drag` if it is being dragged. */
const moved = (node: ViewNode, drag: ReadonlyMap<string, Point> | null): ViewNode => {
  const at = drag?.get(node.id);
  return at ? { ...node, x: at[0], y: at[1] } : node;
};

export interface UnderOptions {
  /** LSIs in view. */
  boxes: readonly ViewNode[];
  /** Ids of LSIs and keys of wires that have an element; the canvas does not show them. */
  elements: ReadonlySet<string>;
  wires: ReadonlySet<string>;
  drag: ReadonlyMap<string, Point> | null;
  selected: ReadonlySet<string>;
  selected_wires: ReadonlySet<string>;
  bad: ReadonlySet<string>;
  loop: ReadonlySet<string>;
}

/** Draws the canvas below the elements: the wires and LSIs that have no element. */
export function paint_under(c: CanvasRenderingContext2D, size: { width: number; height: number }, view: View, viewport: Viewport, colors: Colors, options: UnderOptions): void {
  const { zoom } = viewport;
  const seen: Box = { x: -viewport.x / zoom, y: -viewport.y / zoom, width: size.width / zoom, height: size.height / zoom };
  c.save();
  c.translate(viewport.x, viewport.y);
  c.scale(zoom, zoom);
  paint_wires(c, view, zoom, colors, seen, options);
  const nodes = options.boxes.filter((n) => !options.elements.has(n.id));
  if (nodes.length > 0) paint_boxes(c, view, nodes, zoom, colors, options);
  c.restore();
}

function ends_of_wire(view: View, wire: ViewWire, drag: ReadonlyMap<string, Point> | null): [Point, Point] {
  if (!drag || (!drag.has(wire.from) && !drag.has(wire.to))) return [wire.a, wire.b];
  return [pin_point(moved(view.node(wire.from)!, drag), 'out', wire.from_pin), pin_point(moved(view.node(wire.to)!, drag), 'in', wire.to_pin)];
}

function paint_wires(c: CanvasRenderingContext2D, view: View, zoom: number, colors: Colors, seen: Box, options: UnderOptions): void {
  // one path for each colour, because the drawing time grows with the number of strokes
  const paths = new Map<string, Path2D>();
  const straight = zoom < curve_zoom;
  const shortest = straight ? shortest_wire / zoom : 0;
  const [left, top, right, bottom] = [seen.x, seen.y, seen.x + seen.width, seen.y + seen.height];
  for (const wire of view.wires) {
    const [a, b] = options.drag ? ends_of_wire(view, wire, options.drag) : [wire.a, wire.b];
    const dx = b[0] - a[0];
    const sag = dx < 0 ? 270 : 0;
    if (Math.max(a[0], b[0]) + sag < left || Math.min(a[0], b[0]) - sag > right || Math.max(a[1], b[1]) + (sag && 90) < top || Math.min(a[1], b[1]) > bottom) continue;
    if (Math.abs(dx) + Math.abs(b[1] - a[1]) < shortest || wire.broken || options.wires.has(wire.key)) continue;
    const lit = options.selected_wires.has(wire.key);
    const key = options.loop.has(wire.key) ? 'loop' : lit ? 'lit' : `${wire.delayed ? 'delayed ' : ''}${hue_of(wire.type)}`;
    let path = paths.get(key);
    if (!path) paths.set(key, (path = new Path2D()));
    path.moveTo(a[0], a[1]);
    if (straight) path.lineTo(b[0], b[1]);
    else {
      const [, q, r, s] = wire_curve(a, b);
      path.bezierCurveTo(q[0], q[1], r[0], r[1], s[0], s[1]);
    }
  }
  for (const [key, path] of paths) {
    const delayed = key.startsWith('delayed ');
    const special = key === 'loop' || key === 'lit';
    c.strokeStyle = key === 'loop' ? colors('--bad') : key === 'lit' ? colors('--accent') : colors(`--pin-${delayed ? key.slice(8) : key}`);
    c.globalAlpha = special ? 1 : zoom < 0.25 ? 0.45 : 0.8;
    // the browser draws lines narrower than one pixel much faster than wider lines
    c.lineWidth = straight && !special ? 0.98 / zoom : Math.max(1 / zoom, special ? 3 : 1.8);
    c.setLineDash(delayed && !straight ? [5, 4] : []);
    c.stroke(path);
  }
  c.setLineDash([]);
  c.globalAlpha = 1;
}

function paint_boxes(c: CanvasRenderingContext2D, view: View, nodes: readonly ViewNode[], zoom: number, colors: Colors, options: UnderOptions): void {
  for (const note of view.notes) {
    const [w, h] = note_size(note);
    c.fillStyle = colors('--raised-hover');
    c.fillRect(note.at[0], note.at[1], w, h);
  }
  c.fillStyle = zoom < frame_zoom ? colors('--line-strong') : colors('--raised');
  c.strokeStyle = colors('--line-strong');
  c.lineWidth = 0.98 / zoom;
  // one rectangle at a time: a single path of thousands of them is much slower
  for (const at of nodes) {
    const node = moved(at, options.drag);
    c.fillRect(node.x, node.y, node.width, node.height);
    if (zoom > frame_zoom) c.strokeRect(node.x, node.y, node.width, node.height);
  }
  for (const at of nodes) {
    const bad = options.bad.has(at.id);
    if (!bad && !options.selected.has(at.id) && at.kind !== 'missing') continue;
    const node = moved(at, options.drag);
    c.strokeStyle = bad ? colors('--bad') : options.selected.has(node.id) ? colors('--accent') : colors('--text-faint');
    c.lineWidth = 2 / zoom;
    c.strokeRect(node.x, node.y, node.width, node.height);
  }
  if (zoom > pin_zoom) for (const at of nodes) paint_pins(c, moved(at, options.drag), colors);
  if (zoom > word_zoom) paint_titles(c, nodes, zoom, colors, options);
}

function paint_pins(c: CanvasRenderingContext2D, node: ViewNode, colors: Colors): void {
  for (const [list, side] of [[node.inputs, 'in'], [node.outputs, 'out']] as const) {
    list.forEach((pin, i) => {
      const [x, y] = pin_offset(node, side, i);
      c.fillStyle = colors(`--pin-${hue_of(pin.type)}`);
      c.fillRect(node.x + x - 4, node.y + y - 4, 8, 8);
    });
  }
}

/** Titles of LSIs, enlarged at small zoom to stay readable and shortened with an ellipsis to fit. */
function paint_titles(c: CanvasRenderingContext2D, nodes: readonly ViewNode[], zoom: number, colors: Colors, options: UnderOptions): void {
  const size = Math.min(26, Math.max(13, 9 / zoom));
  c.fillStyle = colors('--text');
  c.font = `${size}px ${letters}`;
  c.textBaseline = 'middle';
  for (const at of nodes) {
    const node = moved(at, options.drag);
    const room = Math.floor((node.width - 20) / (size * 0.58));
    const text = node.title.length > room ? `${node.title.slice(0, Math.max(1, room - 1))}…` : node.title;
    c.fillText(text, node.x + 10, node.y + head_height / 2 + 1);
  }
}

/** Free width to the right of `x` up to the next of `others` between `top` and `bottom`; circuit coordinates. */
function room_right_of(x: number, top: number, bottom: number, others: readonly ViewNode[]): number {
  let room = Infinity;
  for (const other of others) if (other.y < bottom && other.y + other.height > top && other.x + other.width > x) room = Math.min(room, Math.max(0, other.x - x));
  return room;
}

/** Shortens a text to a width with an ellipsis; empty if fewer than three characters fit. */
function shorten(c: CanvasRenderingContext2D, text: string, room: number): string {
  const width = c.measureText(text).width;
  if (width <= room) return text;
  const letters_left = Math.floor((text.length * room) / width) - 1;
  return letters_left >= 3 ? `${text.slice(0, letters_left).trimEnd()}…` : '';
}

/** Draws the values next to the output pins of `nodes` and the time of each LSI in its head. @return number of values drawn */
export function paint_values(c: CanvasRenderingContext2D, view: View, viewport: Viewport, nodes: readonly ViewNode[], colors: Colors, editor: CircuitEditor, live: LiveValues, now: number): number {
  const { zoom } = viewport;
  let drawn = 0;
  const small = Math.max(10.5, 8.5 / zoom); // font size in circuit coordinates: at least 8.5 px on the screen
  c.save();
  c.translate(viewport.x, viewport.y);
  c.scale(zoom, zoom);
  c.textBaseline = 'middle';
  const placed = nodes.map((node) => moved(node, editor.drag));
  for (const node of placed) {
    const in_the_way = placed.filter((other) => other !== node && other.x + other.width > node.x + node.width && other.x < node.x + node.width + widest_value && other.y < node.y + node.height && other.y + other.height > node.y);
    const us = node.lsi ? live.time_of([...view.level.path, node.id].join('/')) : undefined;
    if (us !== undefined) {
      c.font = `${Math.max(11, 8.5 / zoom)}px ${letters}`;
      c.fillStyle = colors('--text-faint');
      c.textAlign = 'right';
      c.fillText(short_time(us), node.x + node.width - 10, node.y + head_height / 2 + 0.5);
    }
    c.textAlign = 'left';
    c.font = `${small}px ${letters}`;
    node.outputs.forEach((pin, i) => {
      const flat = editor.flat_output(node.id, pin.name);
      const value = flat ? live.pin(flat) : undefined;
      if (!value) return;
      const [x, y] = pin_offset(node, 'out', i);
      const top = node.y + y - 4 - small * 1.2;
      const text = shorten(c, short_value(pin.type, value), room_right_of(node.x + x + 11, top, top + small * 1.25, in_the_way) - 2);
      if (!text) return;
      const width = c.measureText(text).width;
      const fresh = Math.max(0, 1 - (now - value.changed) / 600);
      c.globalAlpha = 0.85;
      c.fillStyle = colors('--bg');
      c.fillRect(node.x + x + 9, top, width + 4, small * 1.25);
      c.globalAlpha = 0.78 + 0.22 * fresh;
      c.fillStyle = colors(`--pin-${hue_of(pin.type)}`);
      c.fillText(text, node.x + x + 11, node.y + y - 4 - small * 0.56);
      c.globalAlpha = 1;
      drawn++;
    });
  }
  c.restore();
  return drawn;
}
