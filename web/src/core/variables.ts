/** Variables of a scenario (docs/scenario.md): numbers and switches that rules compare and change, for example the points of a game. */
import type { ScenarioDocument } from './document';
import { format_field } from './format';

export interface Variable {
  id: string;
  name: string;
  /** A switch is 0 (off) or 1 (on). */
  kind: 'number' | 'switch';
  initial: number;
  /** Bounds that rules cannot pass; absent or null: none. */
  minimum?: number | null;
  maximum?: number | null;
  /** Text behind the value, for example "%". */
  unit?: string;
  /** False: viewers do not show the value. */
  shown?: boolean;
}

/** Fields of a variable that a command can change. */
export type VariableFields = Partial<Omit<Variable, 'id'>>;

export const find_variable = (doc: ScenarioDocument, id: string | undefined): Variable | undefined => doc.variables?.find((v) => v.id === id);

/** The output of the generated circuit that has the value of a variable. */
export const variable_pin = (variable: { id: string }): string => `variable-${variable.id.replaceAll('.', '_')}.value`;

/** "3", "72 %", "on". */
export function variable_text(variable: Pick<Variable, 'kind' | 'unit'>, value: number): string {
  if (variable.kind === 'switch') return value > 0 ? 'on' : 'off';
  return [format_field(value, 2), variable.unit].filter(Boolean).join(' ');
}

/** A name that no variable has: "Score", "Score 2". */
export function free_variable_name(doc: ScenarioDocument, wanted: string): string {
  const used = new Set(doc.variables?.map((v) => v.name.toLowerCase()));
  let name = wanted;
  for (let n = 2; used.has(name.toLowerCase()); n++) name = `${wanted} ${n}`;
  return name;
}

/** A new variable of a kind: a score that begins at 0, or a switch that is off. */
export const new_variable = (doc: ScenarioDocument, kind: Variable['kind'], id: string): Variable => ({ id, name: free_variable_name(doc, kind === 'switch' ? 'Switch' : 'Score'), kind, initial: 0 });
