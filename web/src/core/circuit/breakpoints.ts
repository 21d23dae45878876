/** Breakpoints as the service tells them, and their conditions as text (docs/studio-protocol.md). */

export interface Breakpoint {
  /** "arm/elbow.out[2] > 3" */
  condition: string;
  /** "arm/elbow.out" */
  pin: string;
  component: number;
  on: boolean;
}

/** What a run stopped at. */
export interface BreakpointHit {
  condition: string;
  pin: string;
  component: number;
  value: number | null;
  /** s */
  time: number;
  tick: number;
}

export type Relation = '>' | '<' | '==' | '!=' | 'becomes true' | 'changes';

export const relations: [Relation, string][] = [
  ['>', 'rises above'],
  ['<', 'falls below'],
  ['==', 'becomes equal to'],
  ['!=', 'leaves'],
  ['becomes true', 'becomes true'],
  ['changes', 'changes'],
];

export const takes_value = (relation: Relation): boolean => relation !== 'becomes true' && relation !== 'changes';

/** Names of the numbers of a payload; null: they have none but their index. */
const component_names: Record<string, string[]> = { scalar: [], vector: ['x', 'y', 'z'], rotation: ['w', 'x', 'y', 'z'], pose: ['x', 'y', 'z', 'qw', 'qx', 'qy', 'qz'] };
export const components_of = (type: string): string[] | null => component_names[type] ?? null;

/** Types whose payload is not numbers cannot be compared. */
export const can_stop_at = (type: string): boolean => type !== 'contacts' && type !== 'event';

export function write_condition(pin: string, component: number, relation: Relation, value: number): string {
  const number = component > 0 ? `${pin}[${component}]` : pin;
  return takes_value(relation) ? `${number} ${relation} ${value}` : `${number} ${relation}`;
}

/** The condition without the pin: "[2] > 3". */
export const condition_alone = (b: { condition: string; pin: string }): string => (b.condition.startsWith(b.pin) ? b.condition.slice(b.pin.length) : b.condition).trim();
