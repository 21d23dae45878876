/** Breakpoints as the service reports them, and their conditions as text (docs/studio-protocol.md). */

export interface Breakpoint {
  /** Text of the condition, for example "arm/elbow.out[2] > 3". */
  condition: string;
  /** Output pin with its path, the ids of all enclosing circuits: "arm/elbow.out". */
  pin: string;
  /** Index of the compared component of the pin's value. */
  component: number;
  /** False: the breakpoint is disabled. */
  on: boolean;
}

/** The breakpoint at which a run paused, and the value there. */
export interface BreakpointHit {
  condition: string;
  pin: string;
  component: number;
  value: number | null;
  /** Simulated time at which the run paused, s. */
  time: number;
  tick: number;
}

export type Relation = '>' | '<' | '==' | '!=' | 'becomes true' | 'changes';

/** The comparisons that a condition can make, with their labels in the interface. */
export const relations: [Relation, string][] = [
  ['>', 'rises above'],
  ['<', 'falls below'],
  ['==', 'becomes equal to'],
  ['!=', 'leaves'],
  ['becomes true', 'becomes true'],
  ['changes', 'changes'],
];

/** Whether a relation compares the pin with a given value. */
export const takes_value = (relation: Relation): boolean => relation !== 'becomes true' && relation !== 'changes';

/** Names of the components of a value, by pin type. */
const component_names: Record<string, string[]> = { scalar: [], vector: ['x', 'y', 'z'], rotation: ['w', 'x', 'y', 'z'], pose: ['x', 'y', 'z', 'qw', 'qx', 'qy', 'qz'] };
/** Names of the components of a pin type; null: components have only an index. */
export const components_of = (type: string): string[] | null => component_names[type] ?? null;

/** Whether a breakpoint can compare values of a pin type; contacts and events are records, not scalars. */
export const can_stop_at = (type: string): boolean => type !== 'contacts' && type !== 'event';

/** Text of a condition: "arm/elbow.out[2] > 3". */
export function write_condition(pin: string, component: number, relation: Relation, value: number): string {
  const operand = component > 0 ? `${pin}[${component}]` : pin;
  return takes_value(relation) ? `${operand} ${relation} ${value}` : `${operand} ${relation}`;
}

/** The condition without the name of the pin: "[2] > 3" for "arm/elbow.out[2] > 3". */
export const condition_alone = (b: { condition: string; pin: string }): string => (b.condition.startsWith(b.pin) ? b.condition.slice(b.pin.length) : b.condition).trim();
