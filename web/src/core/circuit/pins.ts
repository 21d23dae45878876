/**
 * Pins as the editor shows them. They are declared by an LSI class, by a circuit that is used as an LSI, or by the shown circuit itself.
 */
import type { LsiClass } from './classes';
import type { Circuit, OwnPin } from './form';

export interface PinInfo {
  name: string;
  type: string;
  side: 'in' | 'out';
  unit: string;
  doc: string;
  /** For inputs: `required` and `multiple` as in InputDeclaration. */
  required: boolean;
  multiple: boolean;
  direct: boolean;
  /** For outputs: true if consumers see the value from the next tick on. */
  delayed: boolean;
  wired: boolean;
  /** Number of elements of the value; 0: given by the wire. */
  count: number;
}

export interface Pins {
  inputs: PinInfo[];
  outputs: PinInfo[];
}

const input_info = (pin: LsiClass['inputs'][number]): PinInfo => ({
  name: pin.name, type: pin.type, side: 'in', unit: pin.unit ?? '', doc: pin.doc ?? '',
  required: pin.required ?? true, multiple: pin.multiple ?? false, direct: pin.direct ?? true, delayed: false, wired: false, count: pin.count ?? 0,
});
const output_info = (pin: LsiClass['outputs'][number]): PinInfo => ({
  name: pin.name, type: pin.type, side: 'out', unit: pin.unit ?? '', doc: pin.doc ?? '',
  required: false, multiple: true, direct: true, delayed: pin.delayed ?? false, wired: false, count: pin.count ?? 0,
});
/** A pin of the shown circuit itself. */
export const own_info = (pin: OwnPin, side: 'in' | 'out'): PinInfo => ({
  name: pin.name, type: pin.type, side, unit: pin.unit ?? '', doc: pin.doc ?? '',
  required: false, multiple: side === 'out', direct: true, delayed: false, wired: false, count: 0,
});

/** Pins of a node of an LSI class. */
export const class_pins = (c: LsiClass): Pins => ({ inputs: c.inputs.map(input_info), outputs: c.outputs.map(output_info) });
/** Pins of a node of a circuit that is used as an LSI. */
export const circuit_pins = (c: Circuit): Pins => ({
  inputs: (c.inputs ?? []).map((p) => ({ ...own_info(p, 'in'), required: true })),
  outputs: (c.outputs ?? []).map((p) => own_info(p, 'out')),
});

export function same_pins(a: readonly PinInfo[], b: readonly PinInfo[]): boolean {
  return a.length === b.length && a.every((p, i) => {
    const q = b[i]!;
    return p.name === q.name && p.type === q.type && p.wired === q.wired && p.unit === q.unit && p.doc === q.doc && p.required === q.required && p.multiple === q.multiple && p.delayed === q.delayed;
  });
}
