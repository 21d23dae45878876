/** Chooses how the parts of a circuit are drawn: LSIs and wires in view as DOM elements (React Flow), all others on a canvas. */
import { useCallback, useEffect, useMemo, useRef, useState, type RefObject } from 'react';
import { loop_wires } from '../../core/circuit/problems';
import type { Box } from '../../core/circuit/spatial';
import type { View, ViewNode } from '../../core/circuit/view';
import { circuit, useCircuit, useStudio } from '../app';
import type { WireEdgeType } from './edges';
import { make_elements, next_elements, reuse_edges, reuse_nodes, type AnyNode } from './elements';
import { paint_under, prepare, read_colors, type Colors } from './paint';
import type { Surface } from './surface';

/** At a zoom below `far_zoom`, or with more than `max_elements` nodes in view, everything is drawn on the canvas. */
const far_zoom = 0.42;
const max_elements = 160;
const max_too_wide = 2; // after zooming in, nodes are searched again once the searched area is this many times wider than needed
const margin = 260; // px; nodes are also searched this far outside the visible area, so that a small pan needs no new search

/** The result of the latest culling, that is, the search for the nodes in view. */
export interface Drawn {
  view: View;
  /** Area in which nodes were searched, circuit coordinates. */
  box: Box;
  /** True: the zoom is below `far_zoom`. */
  zoom_far: boolean;
  /** True: all LSIs are painted on the canvas, none is a DOM element. */
  far: boolean;
  /** Nodes that overlap `box`. */
  near: ViewNode[];
  /** LSIs that should be DOM elements; all other LSIs are painted on the canvas. */
  wanted: ReadonlySet<string>;
  /** LSIs that are DOM elements now. Each frame adds or removes some of them until this set equals `wanted`. */
  ids: ReadonlySet<string>;
  /** Wires that are DOM elements now. */
  wires: ReadonlySet<string>;
}

export interface Drawing {
  nodes: AnyNode[];
  edges: WireEdgeType[];
  set_nodes: (change: (before: AnyNode[]) => AnyNode[]) => void;
  far: boolean;
  colors: Colors;
  drawn: RefObject<Drawn | null>;
  /** Requests that the canvas is painted at the next animation frame. */
  invalidate: () => void;
  /** Rebuilds the React Flow elements (DOM nodes) of the LSIs in view. */
  refresh: () => void;
  /** Calls `listener` after each painting of the canvas. @return a function that removes the listener */
  on_paint: (listener: () => void) => () => void;
  /** Counts and times of the drawing, read by the end-to-end tests. */
  facts: RefObject<{ paints: number; paint_ms: number; culls: number; values: number }>;
}

const none: ReadonlySet<string> = new Set();

export function useDrawing(view: View, surface: Surface, under: RefObject<HTMLCanvasElement | null>): Drawing {
  const path = useCircuit((s) => s.path);
  const selected = useCircuit((s) => s.nodes);
  const selected_wires = useCircuit((s) => s.wires);
  const problems = useCircuit((s) => s.problems);
  const theme = useStudio((s) => s.theme);
  const [nodes, set_nodes] = useState<AnyNode[]>([]);
  const [edges, set_edges] = useState<WireEdgeType[]>([]);
  const [far, set_far] = useState(false);
  const colors = useMemo(() => read_colors(document.documentElement), [theme]); // eslint-disable-line react-hooks/exhaustive-deps
  const loop = useMemo(() => loop_wires(problems, path, view.wires), [problems, path, view]);
  const bad = useMemo(() => new Set(problems.length > 0 ? view.nodes.filter((n) => circuit.problems_of(n.id).length > 0).map((n) => n.id) : []), [problems, view]);

  const drawn = useRef<Drawn | null>(null);
  const frame = useRef(0);
  const listeners = useRef(new Set<() => void>());
  const facts = useRef({ paints: 0, paint_ms: 0, culls: 0, values: 0 });

  const show = useCallback((at: Drawn) => {
    const made = make_elements(at.view, at.ids, at.far ? null : at.box, circuit.state, loop);
    drawn.current = { ...at, wires: made.wires };
    set_nodes((before) => reuse_nodes(before, made.nodes));
    set_edges((before) => reuse_edges(before, made.edges));
    set_far(at.far);
  }, [loop]);

  const paint = useCallback(() => {
    frame.current = 0;
    const at = drawn.current;
    const current = circuit.view;
    if (!under.current || !at || !current) return;
    const begin = performance.now();
    const { ids, done } = next_elements(at.ids, at.wanted, false);
    if (ids.size !== at.ids.size || !done) show({ ...at, ids });
    const prepared = prepare(under.current, { willReadFrequently: true });
    if (prepared) {
      paint_under(prepared.c, prepared, current, surface.viewport(), colors, {
        boxes: at.near, elements: ids, wires: drawn.current!.wires, drag: circuit.drag, selected: circuit.state.nodes, selected_wires: circuit.state.wires, bad, loop,
      });
    }
    for (const listener of listeners.current) listener();
    facts.current.paints++;
    facts.current.paint_ms += performance.now() - begin;
    if (!done) frame.current = requestAnimationFrame(paint);
  }, [under, surface, colors, loop, bad, show]);
  const invalidate = useCallback(() => {
    if (frame.current === 0) frame.current = requestAnimationFrame(paint);
  }, [paint]);
  useEffect(() => () => {
    cancelAnimationFrame(frame.current);
    frame.current = 0;
  }, [paint]);

  const cull = useCallback((force: boolean) => {
    const zoom_far = surface.viewport().zoom < far_zoom;
    const old = drawn.current;
    const box = surface.seen(margin);
    const fits = old && contains(old.box, surface.seen()) && old.box.width < max_too_wide * box.width;
    if (!force && old?.view === view && old.zoom_far === zoom_far && fits) return;
    facts.current.culls++;
    const near = view.index.find(box);
    const is_far = zoom_far || near.length > max_elements;
    const wanted = is_far ? none : with_neighbours(view, near);
    const before = old?.view.level.path.join('/') === view.level.path.join('/') ? old : null;
    const { ids } = next_elements(before?.ids ?? none, wanted, wanted.size <= 24);
    show({ view, box, zoom_far, far: is_far, near, wanted, ids, wires: none });
    invalidate();
  }, [view, surface, show, invalidate]);

  useEffect(() => cull(true), [cull, selected, selected_wires]);
  useEffect(() => surface.on_move(() => {
    cull(false);
    invalidate();
  }), [surface, cull, invalidate]);

  const refresh = useCallback(() => cull(true), [cull]);
  const on_paint = useCallback((listener: () => void) => {
    listeners.current.add(listener);
    return () => void listeners.current.delete(listener);
  }, []);
  return { nodes, edges, set_nodes, far, colors, drawn, invalidate, refresh, on_paint, facts };
}

const contains = (a: Box, b: Box): boolean => b.x >= a.x && b.y >= a.y && b.x + b.width <= a.x + a.width && b.y + b.height <= a.y + a.height;

/** Ids of the nodes in view, and of the nodes out of view that are wired to a node in view. */
function with_neighbours(view: View, near: readonly ViewNode[]): Set<string> {
  const ids = new Set(near.map((n) => n.id));
  for (const node of near) {
    for (const wire of view.at_node(node.id)) {
      if (wire.broken || ids.size >= 2 * max_elements) continue;
      ids.add(wire.from).add(wire.to);
    }
  }
  return ids;
}
