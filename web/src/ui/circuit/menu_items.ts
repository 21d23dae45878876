/** Context menu items of the canvas: for the pin, LSI, wire or empty area under the pointer. */
import type { PinAt } from '../../core/circuit/fits';
import type { View } from '../../core/circuit/view';
import { circuit, session } from '../app';
import { copy, paste } from './clipboard';
import type { MenuItem } from '../Menu';
import type { Client, Surface } from './surface';

/** Functions of the canvas for menus and keys. */
export interface CanvasActions {
  fit: (ids?: ReadonlySet<string>) => void;
  arrange: () => void;
  open_search: (client?: Client, fits?: PinAt) => void;
}

export function menu_items(view: View, target: HTMLElement, client: Client, surface: Surface, actions: CanvasActions): MenuItem[] {
  const row = target.closest<HTMLElement>('[data-pin]');
  const id = target.closest<HTMLElement>('[data-lsi]')?.dataset.lsi;
  const wire = target.closest<HTMLElement>('.react-flow__edge')?.dataset.id;
  if (row && id !== undefined) return pin_items(view, { node: id, side: row.dataset.side as 'in' | 'out', pin: row.dataset.pin!.slice(id.length + 1) }, client, actions);
  if (id !== undefined && view.node(id)) return lsi_items(view, id);
  if (wire !== undefined) return wire_items(view, wire);
  const point = surface.to_plane(client);
  return [
    { label: 'Add an LSI…', key: 'Tab', run: () => actions.open_search(client) },
    { label: 'Add a note', key: 'N', run: () => circuit.add_note(point) },
    { label: 'Paste', key: 'Ctrl V', run: () => void paste(point) },
    { label: 'Lay out', key: 'Shift L', run: actions.arrange },
    { label: 'Show all', key: 'A', run: () => actions.fit() },
    ...(circuit.state.edited ? [{ label: 'Reset to generated', run: () => circuit.reset_to_generated() }] : []),
  ];
}

function pin_items(view: View, pin: PinAt, client: Client, actions: CanvasActions): MenuItem[] {
  const wires = view.at_pin(pin.node, pin.side, pin.pin);
  const kind = view.node(pin.node)?.kind;
  const own = kind === 'inputs' || kind === 'outputs' ? kind : null;
  return [
    { label: view.probes.some((p) => p.pin === `${pin.node}.${pin.pin}`) ? 'Remove probe' : 'Add probe', key: 'P', run: () => circuit.toggle_probe(pin), disabled: own !== null },
    ...stop_items(pin, client),
    { label: wires.length > 1 ? `Remove ${wires.length} wires` : 'Remove wire', run: () => circuit.disconnect(wires), disabled: wires.length === 0 },
    { label: 'Add a matching LSI…', run: () => actions.open_search(client, pin) },
    ...(own ? [{ label: `Remove pin “${pin.pin}”`, run: () => circuit.remove_pin(own, pin.pin) }] : []),
  ];
}

function stop_items(pin: PinAt, client: Client): MenuItem[] {
  const source = circuit.stop_source(pin);
  const here = session.state.breakpoints.filter((b) => b.pin === source?.flat);
  const at_source = (b: { pin: string }): boolean => b.pin === source?.flat;
  const on = here.some((b) => b.on);
  return [
    { label: 'Add breakpoint…', key: 'B', run: () => circuit.ask_stop(pin, client), disabled: source === null },
    ...(here.length > 0
      ? [
          { label: on ? 'Switch breakpoint off' : 'Switch breakpoint on', run: () => session.switch_breakpoints(at_source, !on) },
          { label: here.length > 1 ? `Remove ${here.length} breakpoints` : 'Remove breakpoint', run: () => session.remove_breakpoints(at_source) },
        ]
      : []),
  ];
}

function lsi_items(view: View, id: string): MenuItem[] {
  const node = view.node(id)!;
  if (!circuit.state.nodes.has(id)) circuit.select([id]);
  if (!node.lsi) return [];
  return [
    ...(node.kind === 'circuit' ? [{ label: 'Open', key: 'I', run: () => void circuit.go_inside(id) }, { label: 'Ungroup', key: 'Ctrl Shift G', run: () => circuit.ungroup() }] : []),
    { label: circuit.state.nodes.size > 1 ? `Group ${circuit.state.nodes.size} LSIs` : 'Make a circuit', key: 'Ctrl G', run: () => circuit.group() },
    { label: 'Rename', key: 'F2', run: () => circuit.type_in(id) },
    { label: node.note ? 'Edit comment' : 'Add comment', key: 'Shift C', run: () => circuit.type_in(`comment:${id}`) },
    { label: 'Copy', key: 'Ctrl C', run: copy },
    { label: 'Duplicate', key: 'Ctrl D', run: () => circuit.duplicate() },
    { label: 'Delete', key: 'Del', run: () => circuit.remove() },
  ];
}

function wire_items(view: View, key: string): MenuItem[] {
  const wire = view.wire(key);
  if (!wire) return [];
  return [
    { label: 'Remove wire', key: 'Del', run: () => circuit.disconnect([wire]) },
    { label: 'Add or remove probe', run: () => circuit.toggle_probe({ node: wire.from, side: 'out', pin: wire.from_pin }) },
  ];
}
