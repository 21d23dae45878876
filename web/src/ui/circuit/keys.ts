/** Keyboard control of the canvas; docs/circuit-editor.md has the table of keys. */
import type { KeyboardEvent } from 'react';
import type { Point } from '../../core/circuit/form';
import type { Direction } from '../../core/circuit/navigate';
import { is_typing } from '../../core/keymap';
import { circuit, session } from '../app';
import { copy, paste } from './clipboard';
import type { CanvasActions } from './menu_items';
import type { Surface } from './surface';

const arrows: Record<string, Direction> = { ArrowLeft: 'left', ArrowRight: 'right', ArrowUp: 'up', ArrowDown: 'down' };
const steps: Record<Direction, Point> = { left: [-1, 0], right: [1, 0], up: [0, -1], down: [0, 1] };

export function on_key(event: KeyboardEvent<HTMLDivElement>, surface: Surface, actions: CanvasActions): void {
  if (is_typing(event.target as HTMLElement) || event.defaultPrevented) return;
  const ctrl = event.ctrlKey || event.metaKey;
  const handled = ctrl ? with_ctrl(event, surface) : move_key(event) || letter_key(event, surface, actions);
  if (!handled) return;
  event.preventDefault();
  event.stopPropagation();
}

function with_ctrl(event: KeyboardEvent, surface: Surface): boolean {
  switch (event.key.toLowerCase()) {
    case 'a': circuit.select_all(); return true;
    case 'c': copy(); return true;
    case 'x': copy(); circuit.remove(); return true;
    case 'v': void paste(surface.to_plane(surface.here())); return true;
    case 'd': circuit.duplicate(); return true;
    case 'g': event.shiftKey ? circuit.ungroup() : circuit.group(); return true;
    default: return false;
  }
}

function move_key(event: KeyboardEvent): boolean {
  const direction = arrows[event.key];
  if (!direction) return false;
  const [x, y] = steps[direction];
  if (event.shiftKey) circuit.nudge(x, y);
  else if (event.altKey) circuit.nudge(4 * x, 4 * y);
  else circuit.go(direction);
  return true;
}

function letter_key(event: KeyboardEvent, surface: Surface, actions: CanvasActions): boolean {
  const { chosen, view } = circuit;
  const { pin } = circuit.state;
  const shift = event.shiftKey;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  switch (shift ? `shift ${key}` : key) {
    case 'Tab':
    case ' ': search_beside(surface, actions); return true;
    case 'Enter': circuit.enter_key(); return true;
    case 'Escape': return circuit.escape();
    case 'Home':
    case 'a': actions.fit(); return true;
    case 'f': actions.fit(circuit.state.nodes); return true;
    case 'Delete':
    case 'Backspace': pin && circuit.state.nodes.size === 0 ? disconnect_pin() : circuit.remove(); return true;
    case 'x': if (!pin) return false; disconnect_pin(); return true;
    case 'i': if (!chosen) return false; circuit.go_inside(chosen); return true;
    case 'u': circuit.go_out(); return true;
    case 'n': circuit.add_note(surface.to_plane(surface.here())); return true;
    case 'p': {
      const output = chosen ? view?.node(chosen)?.outputs[0] : undefined;
      if (pin) circuit.toggle_probe(pin);
      else if (chosen && output) circuit.toggle_probe({ node: chosen, side: 'out', pin: output.name });
      return true;
    }
    case 'b': {
      const output = chosen ? view?.node(chosen)?.outputs[0] : undefined;
      const at = pin ?? (chosen && output ? { node: chosen, side: 'out' as const, pin: output.name } : null);
      if (!at) return false;
      const node = view?.node(at.node);
      circuit.ask_stop(at, node ? surface.flow.flowToScreenPosition({ x: node.x + node.width + 20, y: node.y }) : surface.here());
      return true;
    }
    case 't': session.step_tick(); return true;
    case 'F2': if (!chosen) return false; circuit.type_in(chosen); return true;
    case 'shift c': if (!chosen) return false; circuit.type_in(`comment:${chosen}`); return true;
    case 'shift l': actions.arrange(); return true;
    case '+':
    case 'shift +':
    case '=': void surface.flow.zoomIn(); return true;
    case '-': void surface.flow.zoomOut(); return true;
    default: return false;
  }
}

function disconnect_pin(): void {
  const { pin } = circuit.state;
  if (pin && circuit.view) circuit.disconnect(circuit.view.at_pin(pin.node, pin.side, pin.pin));
}

/** Opens the search next to the pin under the keyboard cursor, limited to LSIs that fit while a wire is being drawn. */
function search_beside(surface: Surface, actions: CanvasActions): void {
  const from = circuit.state.connecting;
  const at = from ?? circuit.state.pin;
  const node = at && circuit.view?.node(at.node);
  const beside = node ? surface.flow.flowToScreenPosition({ x: node.x + (at.side === 'out' ? node.width + 60 : -240), y: node.y }) : undefined;
  actions.open_search(beside, from ?? undefined);
}
