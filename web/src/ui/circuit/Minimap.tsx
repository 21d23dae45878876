/** Overview of the whole circuit with the visible area; a press or drag moves the viewport there. */
import { useEffect, useRef, type PointerEvent, type ReactElement } from 'react';
import { hue_of } from '../../core/circuit/classes';
import type { View } from '../../core/circuit/view';
import { plain_canvas, useStudio } from '../app';
import { prepare, read_colors, type Colors, type Viewport } from './paint';

const width = 168; // width of the overview, px
const height = 104; // height of the overview, px
const margin = 6; // free border around the drawn circuit, px

/** A colour such as "#7dd3fc" as a pixel of ImageData (little-endian RGBA) with 55 % opacity. */
function dot_of(color: string): number {
  const hex = /^#([0-9a-f]{6})$/i.exec(color)?.[1] ?? '888888';
  const [r, g, b] = [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16)) as [number, number, number];
  return ((0x8c << 24) | (b << 16) | (g << 8) | r) >>> 0;
}

function paint_dots(picture: ImageData, view: View, colors: Colors, map: { left: number; top: number; scale: number }): void {
  const dots = new Uint32Array(picture.data.buffer);
  const known = new Map<string, number>();
  for (const node of view.nodes) {
    const name = node.outputs[0] ? `--pin-${hue_of(node.outputs[0].type)}` : '--text-faint';
    let dot = known.get(name);
    if (dot === undefined) known.set(name, (dot = dot_of(colors(name))));
    const x = Math.round((node.x - map.left) * map.scale);
    const y = Math.round((node.y - map.top) * map.scale);
    const right = Math.min(picture.width, Math.max(x + 1, Math.round((node.x + node.width - map.left) * map.scale)));
    const bottom = Math.min(picture.height, Math.max(y + 1, Math.round((node.y + node.height - map.top) * map.scale)));
    for (let row = Math.max(0, y); row < bottom; row++) dots.fill(dot, row * picture.width + Math.max(0, x), row * picture.width + right);
  }
}

export function Minimap({ view, viewport, size, go, subscribe }: { view: View; viewport: () => Viewport; size: () => { width: number; height: number }; go: (x: number, y: number) => void; subscribe: (listener: () => void) => () => void }): ReactElement {
  const canvas = useRef<HTMLCanvasElement>(null);
  const theme = useStudio((s) => s.theme);
  const map = useRef({ scale: 1, left: 0, top: 0 });
  useEffect(() => {
    const element = canvas.current;
    if (!element) return;
    const colors = read_colors(document.documentElement); // not of the canvas, which may not be attached to the page yet
    const box = view.bounds();
    const scale = Math.min((width - 2 * margin) / Math.max(1, box.width), (height - 2 * margin) / Math.max(1, box.height), 0.2);
    const left = box.x - (width / scale - box.width) / 2;
    const top = box.y - (height / scale - box.height) / 2;
    map.current = { scale, left, top };
    // the circuit is drawn once per edit, pixel by pixel: as canvas rectangles, thousands of LSIs take tens of milliseconds
    const ratio = window.devicePixelRatio || 1;
    const picture = new ImageData(Math.round(width * ratio), Math.round(height * ratio));
    paint_dots(picture, view, colors, { left, top, scale: scale * ratio });
    const draw = (): void => {
      const drawn = prepare(element, plain_canvas);
      if (!drawn) return;
      const { c } = drawn;
      c.putImageData(picture, 0, 0);
      const at = viewport();
      const seen = size();
      c.strokeStyle = colors('--text-dim');
      c.lineWidth = 1;
      c.strokeRect((-at.x / at.zoom - left) * scale + 0.5, (-at.y / at.zoom - top) * scale + 0.5, (seen.width / at.zoom) * scale, (seen.height / at.zoom) * scale);
    };
    draw();
    return subscribe(draw);
  }, [view, theme, viewport, size, subscribe]);
  const press = (event: PointerEvent<HTMLCanvasElement>): void => {
    if (event.type === 'pointerdown') event.currentTarget.setPointerCapture(event.pointerId);
    if (event.buttons !== 1) return;
    const rect = event.currentTarget.getBoundingClientRect();
    const { scale, left, top } = map.current;
    go((event.clientX - rect.left) / scale + left, (event.clientY - rect.top) / scale + top);
  };
  return <canvas ref={canvas} className="circuit-map" style={{ width, height }} role="img" aria-label="Overview of the circuit" onPointerDown={press} onPointerMove={press} />;
}
