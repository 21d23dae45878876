/** Classes of LSIs (components of circuits) and pin types, as the service declares them (docs/studio-protocol.md, event `lsis`). */

export interface InputDeclaration {
  name: string;
  type: string;
  unit?: string;
  doc?: string;
  /** True: the input must be wired or have a value. */
  required?: boolean;
  /** True: the outputs of a tick depend on this input in the same tick. */
  direct?: boolean;
  /** True: the input accepts several wires. */
  multiple?: boolean;
  /** Number of elements of the value. */
  count?: number;
  minimum?: number | null;
  maximum?: number | null;
  value?: number;
}

export interface OutputDeclaration {
  name: string;
  type: string;
  unit?: string;
  doc?: string;
  /** True: consumers see the value from the next tick on. */
  delayed?: boolean;
  /** Number of elements of the value. */
  count?: number;
}

export interface ParameterDeclaration {
  name: string;
  kind: 'number' | 'integer' | 'boolean' | 'text' | 'choice' | 'vector';
  initial: number | boolean | string | number[];
  minimum?: number | null;
  maximum?: number | null;
  choices?: string[];
  unit?: string;
  doc?: string;
  /** True: the parameter can change while the circuit runs. */
  live?: boolean;
}

export interface LsiClass {
  name: string;
  doc?: string;
  group?: string;
  /** Name of the installed library that has the class; empty if it is built in. */
  from?: string;
  inputs: InputDeclaration[];
  outputs: OutputDeclaration[];
  parameters: ParameterDeclaration[];
}

export interface PinType {
  name: string;
  color?: string;
  size?: number;
  numeric?: boolean;
  doc?: string;
}

/** All LSI classes and pin types, by name. */
export class ClassList {
  private readonly by_name: Map<string, LsiClass>;
  private readonly types: Map<string, PinType>;
  constructor(
    readonly all: readonly LsiClass[] = [],
    readonly pin_types: readonly PinType[] = [],
  ) {
    this.by_name = new Map(all.map((c) => [c.name, c]));
    // a class of a library is also found by its name without the library's prefix, if only one library has that name
    const short = new Map<string, LsiClass | null>();
    for (const c of all) {
      const name = c.from ? c.name.slice(c.from.length + 1) : '';
      if (name) short.set(name, short.has(name) ? null : c);
    }
    for (const [name, c] of short) if (c && !this.by_name.has(name)) this.by_name.set(name, c);
    this.types = new Map(pin_types.map((t) => [t.name, t]));
  }
  find(name: string): LsiClass | undefined {
    return this.by_name.get(name);
  }
  type(name: string): PinType | undefined {
    return this.types.get(name);
  }
  /** False until the service has sent its classes. */
  get known(): boolean {
    return this.all.length > 0;
  }
}

const hues: Record<string, string> = {
  scalar: 'scalar', vector: 'vector', rotation: 'rotation', pose: 'pose', 'joint values': 'joints', state: 'state', contacts: 'contacts', event: 'event', motion: 'motion',
};

/** Name of the colour of a pin type (CSS class `hue-…`, variable `--pin-…`). */
export const hue_of = (type: string): string => hues[type] ?? 'any';

export const hue_names = [...Object.values(hues), 'any'];
