/** The canvas viewport: fits the circuit or a selection, restores the viewport of the last visit, and keeps the keyboard cursor in view. */
import { useCallback, useEffect, useRef, type RefObject } from 'react';
import { boxes_meet } from '../../core/circuit/spatial';
import { circuit, useCircuit } from '../app';
import type { Viewport } from './paint';
import type { Surface } from './surface';

const bar_height = 44; // height of the bar that covers the top of the canvas, px

/** Viewport of the canvas when it was last unmounted, and the circuit level that it belongs to. */
const kept: { path: string; at: Viewport | null; fitted: boolean } = { path: '', at: null, fitted: false };
export const kept_viewport = (): Viewport => kept.at ?? { x: 0, y: 0, zoom: 1 };

export interface Framing {
  /** Zooms so that the whole shown circuit, or the nodes `ids`, fit into the panel. */
  fit: (ids?: ReadonlySet<string>) => void;
  /** To be called when the user moved the viewport: later changes of the panel's size no longer refit the circuit. */
  release: () => void;
}

/** @param pressing while true (a mouse button is down), the viewport does not follow the cursor */
export function useFraming(surface: Surface, panel: RefObject<HTMLDivElement | null>, pressing: RefObject<boolean>): Framing {
  const path = useCircuit((s) => s.path);
  const cursor = useCircuit((s) => s.cursor);
  const fitted = useRef(false);
  /** True after the viewport was first set or moved. A panel that was never visible has no viewport worth saving when it is unmounted. */
  const placed = useRef(false);

  const fit = useCallback((ids?: ReadonlySet<string>) => {
    const { view } = circuit;
    const { width, height } = surface.size();
    if (!view || width < 60 || height < 60) return;
    fitted.current = !ids || ids.size === 0;
    placed.current = true;
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
      placed.current = true;
      void surface.flow.setViewport(kept.at);
    } else requestAnimationFrame(() => fit());
  }, [path, fit, surface]);
  useEffect(() => () => {
    if (!placed.current) return;
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

  // move the viewport when the keyboard cursor leaves it
  useEffect(() => {
    const node = cursor ? circuit.view?.node(cursor) : undefined;
    if (!node || pressing.current) return;
    const visible = surface.seen(-30);
    if (boxes_meet(node, visible) && node.x >= visible.x && node.x + node.width <= visible.x + visible.width && node.y >= visible.y && node.y + node.height <= visible.y + visible.height) return;
    if (node.width > visible.width || node.height > visible.height) return;
    void surface.flow.setCenter(node.x + node.width / 2, node.y + node.height / 2, { zoom: Math.max(surface.viewport().zoom, 0.5) });
  }, [cursor, surface, pressing]);

  const release = useCallback(() => {
    fitted.current = false;
    placed.current = true;
  }, []);
  return { fit, release };
}
