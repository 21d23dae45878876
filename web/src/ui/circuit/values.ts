/** Values of the running circuit: requests those in view from the service, and draws them over the canvas. */
import { useCallback, useEffect, useRef, type RefObject } from 'react';
import { short_time } from '../../core/circuit/live';
import { boxes_meet } from '../../core/circuit/spatial';
import { split_end } from '../../core/circuit/form';
import type { View } from '../../core/circuit/view';
import { circuit, session } from '../app';
import type { Drawing } from './drawing';
import { paint_values, prepare } from './paint';
import type { Surface } from './surface';

const value_zoom = 0.44; // below this zoom, values would be unreadable and are not requested
const values_period = 70; // minimum time between two drawings, ms
const watch_delay = 180; // time between a change of the visible area and the request, ms
const max_watched = 400;
const fading = 700; // time for which a changed value is highlighted, ms

/** Requests the values of the outputs in view and of the probes. */
export function useWatch(view: View, surface: Surface, drawing: Drawing): void {
  const waiting = useRef<ReturnType<typeof setTimeout> | null>(null);
  const { drawn } = drawing;
  const request = useCallback(() => {
    waiting.current = null;
    const now = circuit.view;
    const at = drawn.current;
    if (!now) return;
    const pins = new Set<string>();
    if (at && !at.far && surface.viewport().zoom >= value_zoom) {
      for (const node of at.near) for (const pin of node.outputs) {
        const flat = circuit.flat_output(node.id, pin.name);
        if (flat && pins.size < max_watched) pins.add(flat);
      }
    }
    const probes = now.probes.flatMap((p) => circuit.flat_output(...split_end(p.pin)) ?? []);
    session.watch([...pins], probes, true);
  }, [surface, drawn]);
  const soon = useCallback(() => {
    waiting.current ??= setTimeout(request, watch_delay);
  }, [request]);
  useEffect(soon, [view, drawing.nodes, soon]);
  useEffect(() => {
    const reconnected = session.store.subscribe((s, b) => {
      if (s.connection !== b.connection && s.connection === 'open') soon();
    });
    const moved = surface.on_move(soon);
    return () => {
      reconnected();
      moved();
      if (waiting.current) clearTimeout(waiting.current);
      waiting.current = null;
      session.watch([], [], false);
    };
  }, [surface, soon]);
}

/** Draws the values: at each frame during a pan or drag, otherwise when new values arrive. */
export function useValues(surface: Surface, drawing: Drawing, over: RefObject<HTMLCanvasElement | null>, tick: RefObject<HTMLSpanElement | null>): void {
  const { drawn, facts, colors } = drawing;
  useEffect(() => {
    let revision = -1;
    let last = 0;
    let busy = 0;
    let moved = true;
    let drag: unknown = null;
    const draw = (now: number): void => {
      const at = drawn.current;
      const current = circuit.view;
      const { live } = session;
      if (!over.current || !at || !current || (live.revision === revision && !moved && now > busy)) return;
      if (live.revision !== revision) busy = now + fading;
      revision = live.revision;
      moved = false;
      const zoom = surface.viewport().zoom;
      const shown = !at.far && zoom >= value_zoom;
      if (!shown && facts.current.values === 0) return show_tick_time();
      const prepared = prepare(over.current);
      const visible = surface.seen();
      facts.current.values = shown && prepared ? paint_values(prepared.c, current, surface.viewport(), at.near.filter((n) => boxes_meet(n, visible)), colors, circuit, live, now) : 0;
      show_tick_time();
    };
    const show_tick_time = (): void => {
      if (tick.current && session.live.timed > 0) tick.current.textContent = `${short_time(session.live.tick_us)} per tick`;
    };
    let handle = 0;
    const run = (): void => {
      handle = requestAnimationFrame(run);
      const now = performance.now();
      if (circuit.drag !== drag) moved = true;
      drag = circuit.drag;
      if (now - last < values_period && !moved) return;
      last = now;
      draw(now);
    };
    run();
    const stop = surface.on_move(() => (moved = true));
    return () => {
      stop();
      cancelAnimationFrame(handle);
    };
  }, [surface, drawn, facts, colors, over, tick]);
}
