/** LSIs on the system's clipboard, as text. */
import type { Point } from '../../core/circuit/form';
import { circuit } from '../app';

const patience = 250; // ms for a browser that asks before it lets the clipboard be read

export function copy(): void {
  const text = circuit.copy();
  if (text) void navigator.clipboard?.writeText(text).catch(() => undefined); // the page's own copy is enough
}

export async function paste(at: Point): Promise<void> {
  const text = await Promise.race([navigator.clipboard?.readText().catch(() => '') ?? '', new Promise<string>((r) => setTimeout(() => r(''), patience))]);
  circuit.paste(at, text);
}
