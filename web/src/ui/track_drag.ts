/** Drags in the timeline: a press that becomes a drag, snapping, and the common drag of several selected items. */
import type React from 'react';
import { apply_command, type Command, type ScenarioDocument } from '../core/document';
import { is_selected, items_of, items_span, move_items, toggle_item, type Item } from '../core/items';
import { snap_delta, snap_targets, type SnapRules } from '../core/timeline';
import { session } from './app';

export const snap_px = 8; // distance, px, within which a dragged edge snaps to a target
const drag_px = 3; // pointer travel, px, below which a press is a click

type Exclude = string | readonly string[];
export const snap_rules = (doc: ScenarioDocument, exclude: Exclude, tolerance: number): Omit<SnapRules, 'enabled'> => ({
  targets: snap_targets(doc, exclude, session.now),
  tolerance,
  frame_rate: doc.frame_rate,
});

export interface DragSetup {
  event: React.PointerEvent<HTMLElement>;
  /** Scale of the time axis, px per s. */
  scale: number;
  /** Previews a drag by `delta` s. `rules` are the snapping rules for the modifier keys held, `over` is the element under the pointer. */
  move: (delta: number, rules: (doc: ScenarioDocument, exclude: Exclude) => SnapRules, over: Element | null) => void;
  /** Sends the command at the end of the drag. */
  done: () => void;
  cancel: () => void;
  /** Called instead of `done` if the pointer was released without a drag. */
  click?: () => void;
}

/**
 * Follows one drag from press to release; travel below `drag_px` is ignored. Shift: a tenth of the speed; Ctrl: no snapping; Escape:
 * cancel.
 */
export function start_drag({ event, scale, move, done, cancel, click }: DragSetup): void {
  const target = event.currentTarget;
  target.setPointerCapture(event.pointerId);
  let last = event.clientX;
  let travelled = 0;
  let dragging = false;
  const rules_of = (e: { ctrlKey: boolean; metaKey: boolean; shiftKey: boolean }) => (doc: ScenarioDocument, exclude: Exclude): SnapRules => ({
    ...snap_rules(doc, exclude, e.shiftKey ? 0 : snap_px / scale),
    enabled: !(e.ctrlKey || e.metaKey),
  });
  const on_move = (e: PointerEvent): void => {
    travelled += (e.clientX - last) * (e.shiftKey ? 0.1 : 1);
    last = e.clientX;
    if (!dragging && Math.abs(e.clientX - event.clientX) < drag_px) return;
    dragging = true;
    move(travelled / scale, rules_of(e), document.elementFromPoint(e.clientX, e.clientY));
  };
  const stop = (): void => {
    target.removeEventListener('pointermove', on_move);
    target.removeEventListener('pointerup', on_up);
    target.removeEventListener('pointercancel', on_cancel);
    window.removeEventListener('keydown', on_key, true);
  };
  const on_up = (): void => {
    stop();
    if (dragging) done();
    else click?.();
  };
  const on_cancel = (): void => {
    stop();
    cancel();
  };
  const on_key = (e: KeyboardEvent): void => {
    if (e.key !== 'Escape') return;
    e.preventDefault();
    e.stopPropagation();
    on_cancel();
  };
  target.addEventListener('pointermove', on_move);
  target.addEventListener('pointerup', on_up);
  target.addEventListener('pointercancel', on_cancel);
  window.addEventListener('keydown', on_key, true);
}

/** Whether a press adds to the selection or removes from it. */
const toggles = (event: { shiftKey: boolean; ctrlKey: boolean; metaKey: boolean }): boolean => event.shiftKey || event.ctrlKey || event.metaKey;

/**
 * The selection at a press on `item`: without Shift and Ctrl, the item is selected, unless it belongs to a selection of several items, which
 * a drag moves together.
 * @return ids of the items that a drag moves, or null if it moves `item` alone; `click` is the action of a press without a drag
 */
export function press_item(event: React.PointerEvent, item: Item): { together: readonly Item[] | null; click: () => void } {
  const { selection } = session.state;
  const together = items_of(selection).length > 1 && is_selected(selection, item) ? items_of(selection) : null;
  if (toggles(event)) return { together, click: () => session.select(toggle_item(session.state.selection, item)) };
  if (!together) session.select(item);
  return { together, click: () => session.select(item) };
}

/** The end of a drag on the timeline: executes `command()`, if there is one; Escape discards the preview. */
export function drag_ends(on_guide: (time: number | null) => void, command: () => Command | null): Pick<DragSetup, 'done' | 'cancel'> {
  const cancel = (): void => {
    on_guide(null);
    session.show_preview(null);
  };
  const done = (): void => {
    const last = command();
    if (!last) return cancel();
    on_guide(null);
    void session.edit(last);
  };
  return { done, cancel };
}

/** The drag of several selected items: they move together by one command. */
export function drag_together(items: readonly Item[], on_guide: (time: number | null) => void): Pick<DragSetup, 'move' | 'done' | 'cancel'> {
  const { document } = session.state;
  const span = document && items_span(document, items);
  const ids = items.map((item) => (item.kind === 'clip' ? item.clip : item.event));
  let command: Command | null = null;
  return {
    move: (delta, rules) => {
      if (!document || !span) return;
      const snapped = snap_delta([span.from, span.to], delta, rules(document, ids));
      on_guide(snapped.at);
      command = move_items(document, items, snapped.delta);
      session.show_preview(command && apply_command(document, command));
    },
    ...drag_ends(on_guide, () => command),
  };
}

/** Selects a focused item, but not when a press focused it: the press decides on the selection itself. */
export const select_focused = (event: React.FocusEvent<HTMLElement>, item: Item): void => {
  if (event.currentTarget.matches(':focus-visible') && !is_selected(session.state.selection, item)) session.select(item);
};
