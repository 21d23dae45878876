/** The whole circuit small, with the part that is seen; a press goes there. */
import { useEffect, useRef, type PointerEvent, type ReactElement } from 'react';
import { hue_of } from '../../core/circuit/classes';
import type { View } from '../../core/circuit/view';
import { plain_canvas, useStudio } from '../app';
import { prepare, read_colors, type Viewport } from './paint';

const width = 168;
const height = 104;
const margin = 6;

export function Minimap({ view, viewport, size, go, subscribe }: { view: View; viewport: () => Viewport; size: () => { width: number; height: number }; go: (x: number, y: number) => void; subscribe: (listener: () => void) => () => void }): ReactElement {
  const canvas = useRef<HTMLCanvasElement>(null);
  const theme = useStudio((s) => s.theme);
  const map = useRef({ scale: 1, left: 0, top: 0 });
  useEffect(() => {
    const element = canvas.current;
    if (!element) return;
    const colors = read_colors(element);
    const box = view.bounds();
    const scale = Math.min((width - 2 * margin) / Math.max(1, box.width), (height - 2 * margin) / Math.max(1, box.height), 0.2);
    const left = box.x - (width / scale - box.width) / 2;
    const top = box.y - (height / scale - box.height) / 2;
    map.current = { scale, left, top };
    // the circuit itself is drawn once
    const picture = document.createElement('canvas');
    const ratio = window.devicePixelRatio || 1;
    picture.width = width * ratio;
    picture.height = height * ratio;
    const p = picture.getContext('2d', plain_canvas);
    if (p) {
      p.scale(ratio, ratio);
      p.globalAlpha = 0.55;
      let last = '';
      for (const node of view.nodes) {
        const color = node.outputs[0] ? colors(`--pin-${hue_of(node.outputs[0].type)}`) : colors('--text-faint');
        if (color !== last) p.fillStyle = last = color; // setting it is what costs
        p.fillRect((node.x - left) * scale, (node.y - top) * scale, Math.max(1, node.width * scale), Math.max(1, node.height * scale));
      }
    }
    const draw = (): void => {
      const drawn = prepare(element, plain_canvas);
      if (!drawn) return;
      const { c } = drawn;
      c.drawImage(picture, 0, 0, width, height);
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
