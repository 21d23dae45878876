/** LSI classes as the service declares them (docs/studio-protocol.md, event `lsis`), and which pins fit each other. */

export interface InputDeclaration {
  name: string;
  type: string;
  unit?: string;
  doc?: string;
  required?: boolean;
  direct?: boolean;
  multiple?: boolean;
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
  delayed?: boolean;
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
  live?: boolean;
}

export interface LsiClass {
  name: string;
  doc?: string;
  group?: string;
  /** Of which installed library; empty: built in. */
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

export class ClassList {
  private readonly by_name: Map<string, LsiClass>;
  private readonly types: Map<string, PinType>;
  constructor(
    readonly all: readonly LsiClass[] = [],
    readonly pin_types: readonly PinType[] = [],
  ) {
    this.by_name = new Map(all.map((c) => [c.name, c]));
    // the short name of an installed one, where only one library has it
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
  get known(): boolean {
    return this.all.length > 0;
  }
}

const hues: Record<string, string> = {
  scalar: 'scalar', vector: 'vector', rotation: 'rotation', pose: 'pose', 'joint values': 'joints', state: 'state', contacts: 'contacts', event: 'event', motion: 'motion',
};

/** Name of the hue (`--pin-…`) of a pin type. */
export const hue_of = (type: string): string => hues[type] ?? 'any';

export const hue_names = [...Object.values(hues), 'any'];
