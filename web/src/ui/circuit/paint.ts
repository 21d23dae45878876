/** What is drawn on canvases: wires that no element stands for, the whole circuit from afar, and values over what is near. */
import { hue_of } from '../../core/circuit/classes';
import type { CircuitEditor } from '../../core/circuit/editor';
import type { Point } from '../../core/circuit/form';
import { short_time, short_value, type LiveValues } from '../../core/circuit/live';
import { boxes_meet, type Box } from '../../core/circuit/spatial';
import { head_height, note_size, pin_offset, pin_point, wire_curve, type View, type ViewNode } from '../../core/circuit/view';

export interface Viewport {
  x: number;
  y: number;
  zoom: number;
}

export type Colors = (name: string) => string;

/** Colours of the page's theme, read once. */
export function read_colors(element: Element): Colors {
  const style = getComputedStyle(element);
  const known = new Map<string, string>();
  return (name) => {
    let color = known.get(name);
    if (color === undefined) known.set(name, (color = style.getPropertyValue(name).trim() || '#888'));
    return color;
  };
}

/** Clears it at the size that it has on the page. @return null while it has none */
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

const moved = (node: ViewNode, drag: ReadonlyMap<string, Point> | null): ViewNode => {
  const at = drag?.get(node.id);
  return at ? { ...node, x: at[0], y: at[1] } : node;
};

/** Wires that are not among `elements`, and with `far` also the LSIs. */
export function paint_under(
  c: CanvasRenderingContext2D, size: { width: number; height: number }, view: View, viewport: Viewport, colors: Colors,
  options: { far: boolean; elements: ReadonlySet<string>; drag: ReadonlyMap<string, Point> | null; nodes: readonly ViewNode[]; selected: ReadonlySet<string>; selected_wires: ReadonlySet<string>; bad: (id: string) => boolean; loop: ReadonlySet<string> },
): void {
  const { zoom } = viewport;
  const seen: Box = { x: -viewport.x / zoom, y: -viewport.y / zoom, width: size.width / zoom, height: size.height / zoom };
  c.save();
  c.translate(viewport.x, viewport.y);
  c.scale(zoom, zoom);
  // one path for each hue: strokes are what costs
  const paths = new Map<string, Path2D>();
  const straight = zoom < 0.12;
  for (const wire of view.wires) {
    if (wire.broken || options.elements.has(wire.key)) continue;
    const from = view.node(wire.from)!;
    const to = view.node(wire.to)!;
    const drag = options.drag;
    const a = drag ? pin_point(moved(from, drag), 'out', wire.from_pin) : pin_point(from, 'out', wire.from_pin);
    const b = drag ? pin_point(moved(to, drag), 'in', wire.to_pin) : pin_point(to, 'in', wire.to_pin);
    const sag = b[0] < a[0] ? 270 : 0;
    if (!boxes_meet({ x: Math.min(a[0], b[0]) - sag, y: Math.min(a[1], b[1]), width: Math.abs(b[0] - a[0]) + 2 * sag + 1, height: Math.abs(b[1] - a[1]) + (sag ? 90 : 1) }, seen)) continue;
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
    c.strokeStyle = key === 'loop' ? colors('--bad') : key === 'lit' ? colors('--accent') : colors(`--pin-${delayed ? key.slice(8) : key}`);
    c.globalAlpha = key === 'loop' || key === 'lit' ? 1 : zoom < 0.25 ? 0.45 : 0.75;
    c.lineWidth = Math.max(1 / zoom, key === 'loop' ? 3 : 1.8);
    c.setLineDash(delayed && !straight ? [5, 4] : []);
    c.stroke(path);
  }
  c.setLineDash([]);
  c.globalAlpha = 1;
  if (options.far) paint_far(c, view, zoom, colors, seen, options);
  c.restore();
}

function paint_far(c: CanvasRenderingContext2D, view: View, zoom: number, colors: Colors, seen: Box, options: { nodes: readonly ViewNode[]; selected: ReadonlySet<string>; drag: ReadonlyMap<string, Point> | null; bad: (id: string) => boolean }): void {
  const words = zoom > 0.2;
  const boxes = new Path2D();
  const special: ViewNode[] = [];
  for (const note of view.notes) {
    const [w, h] = note_size(note);
    c.fillStyle = colors('--raised-hover');
    c.fillRect(note.at[0], note.at[1], w, h);
  }
  for (const at of options.nodes) {
    const node = moved(at, options.drag);
    boxes.rect(node.x, node.y, node.width, node.height);
    if (options.selected.has(node.id) || node.kind === 'missing' || options.bad(node.id)) special.push(node);
  }
  c.fillStyle = colors('--raised');
  c.fill(boxes);
  if (zoom > 0.06) {
    c.strokeStyle = colors('--line-strong');
    c.lineWidth = 1 / zoom;
    c.stroke(boxes);
  }
  for (const node of special) {
    c.strokeStyle = options.bad(node.id) ? colors('--bad') : options.selected.has(node.id) ? colors('--accent') : colors('--text-faint');
    c.lineWidth = 2 / zoom;
    c.strokeRect(node.x, node.y, node.width, node.height);
  }
  if (!words) return;
  c.fillStyle = colors('--text');
  c.font = '15px system-ui, sans-serif';
  c.textBaseline = 'middle';
  for (const at of options.nodes) {
    const node = moved(at, options.drag);
    if (!boxes_meet(node, seen)) continue;
    c.fillText(node.title, node.x + 10, node.y + head_height / 2 + 1, node.width - 20);
    for (const [list, side] of [[node.inputs, 'in'], [node.outputs, 'out']] as const) {
      list.forEach((pin, i) => {
        const [x, y] = pin_offset(node, side, i);
        c.fillStyle = colors(`--pin-${hue_of(pin.type)}`);
        c.fillRect(node.x + x - 4, node.y + y - 4, 8, 8);
      });
    }
    c.fillStyle = colors('--text');
  }
}

/** Values beside output pins, and the time of each LSI in its head. Only `nodes`, which are near and seen. */
export function paint_values(c: CanvasRenderingContext2D, view: View, viewport: Viewport, nodes: readonly ViewNode[], colors: Colors, editor: CircuitEditor, live: LiveValues, now: number): number {
  const { zoom } = viewport;
  let drawn = 0;
  const small = Math.max(10.5, 8.5 / zoom); // readable also from a little farther away
  c.save();
  c.translate(viewport.x, viewport.y);
  c.scale(zoom, zoom);
  c.textBaseline = 'middle';
  for (const at of nodes) {
    const node = moved(at, editor.drag);
    if (node.lsi) {
      const us = live.time_of([...view.level.path, node.id].join('/'));
      if (us !== undefined) {
        c.font = `${Math.max(11, 8.5 / zoom)}px Inter, system-ui, "DejaVu Sans", sans-serif`;
        c.fillStyle = colors('--text-faint');
        c.textAlign = 'right';
        c.fillText(short_time(us), node.x + node.width - 10, node.y + head_height / 2 + 0.5);
      }
    }
    c.textAlign = 'left';
    c.font = `${small}px Inter, system-ui, "DejaVu Sans", sans-serif`;
    node.outputs.forEach((pin, i) => {
      const flat = editor.flat_output(node.id, pin.name);
      const value = flat ? live.pin(flat) : undefined;
      if (!value) return;
      const text = short_value(pin.type, value);
      const [x, y] = pin_offset(node, 'out', i);
      const width = c.measureText(text).width;
      const fresh = Math.max(0, 1 - (now - value.changed) / 600);
      c.globalAlpha = 0.85;
      c.fillStyle = colors('--bg');
      c.fillRect(node.x + x + 9, node.y + y - 4 - small * 1.2, width + 4, small * 1.25);
      c.globalAlpha = 0.6 + 0.4 * fresh;
      c.fillStyle = colors(`--pin-${hue_of(pin.type)}`);
      c.fillText(text, node.x + x + 11, node.y + y - 4 - small * 0.56);
      c.globalAlpha = 1;
      drawn++;
    });
  }
  c.restore();
  return drawn;
}
