/** Where the canvas is looked at: all, a selection, where it was left, where the keyboard goes. */
import { useCallback, useEffect, useRef, type RefObject } from 'react';
import { boxes_meet } from '../../core/circuit/spatial';
import { circuit, useCircuit } from '../app';
import type { Viewport } from './paint';
import type { Surface } from './surface';

const bar_height = 44; // px at the top that the bar covers

/** Where the canvas was looked at when the tab was left. */
const kept: { path: string; at: Viewport | null; fitted: boolean } = { path: '', at: null, fitted: false };
export const kept_viewport = (): Viewport => kept.at ?? { x: 0, y: 0, zoom: 1 };

export interface Framing {
  /** Shows all, or what is called `ids`. */
  fit: (ids?: ReadonlySet<string>) => void;
  /** The user looks elsewhere: a change of the panel's size no longer shows all. */
  let_go: () => void;
}

/** @param pressing while true, nothing is brought into sight */
export function useFraming(surface: Surface, panel: RefObject<HTMLDivElement | null>, pressing: RefObject<boolean>): Framing {
  const path = useCircuit((s) => s.path);
  const cursor = useCircuit((s) => s.cursor);
  const fitted = useRef(false);
  /** Something was shown on purpose: a panel that was only made and put away again has nothing to keep. */
  const looked = useRef(false);

  const fit = useCallback((ids?: ReadonlySet<string>) => {
    const { view } = circuit;
    const { width, height } = surface.size();
    if (!view || width < 60 || height < 60) return;
    fitted.current = !ids || ids.size === 0;
    looked.current = true;
    const box = view.bounds(ids && ids.size > 0 ? ids : undefined);
    const zoom = Math.min(1.15, Math.max(0.015, Math.min((width - 70) / Math.max(1, box.width), (height - bar_height - 30) / Math.max(1, box.height))));
    void surface.flow.setViewport({ x: width / 2 - zoom * (box.x + box.width / 2), y: bar_height + (height - bar_height - 12) / 2 - zoom * (box.y + box.height / 2), zoom });
  }, [surface]);

  const shown_path = useRef<string | null>(null);
  useEffect(() => {
    const key = path.join('/');
    if (shown_path.current === key) return;
    const first = shown_path.current === null;
    shown_path.current = key;
    if (first && kept.path === key && kept.at) {
      fitted.current = kept.fitted;
      looked.current = true;
      void surface.flow.setViewport(kept.at);
    } else requestAnimationFrame(() => fit());
  }, [path, fit, surface]);
  useEffect(() => () => {
    if (!looked.current) return;
    kept.path = circuit.state.path.join('/');
    kept.at = surface.viewport();
    kept.fitted = fitted.current;
  }, [surface]);
  useEffect(() => {
    if (!panel.current) return;
    const observer = new ResizeObserver(() => {
      if (fitted.current || kept.at === null) fit();
    });
    observer.observe(panel.current);
    return () => observer.disconnect();
  }, [panel, fit]);

  // the cursor of the keyboard stays in sight
  useEffect(() => {
    const node = cursor ? circuit.view?.node(cursor) : undefined;
    if (!node || pressing.current) return;
    const visible = surface.seen(-30);
    if (boxes_meet(node, visible) && node.x >= visible.x && node.x + node.width <= visible.x + visible.width && node.y >= visible.y && node.y + node.height <= visible.y + visible.height) return;
    if (node.width > visible.width || node.height > visible.height) return;
    void surface.flow.setCenter(node.x + node.width / 2, node.y + node.height / 2, { zoom: Math.max(surface.viewport().zoom, 0.5) });
  }, [cursor, surface, pressing]);

  const let_go = useCallback(() => {
    fitted.current = false;
    looked.current = true;
  }, []);
  return { fit, let_go };
}
