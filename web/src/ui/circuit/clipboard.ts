/** Copies LSIs to the system clipboard as text, and pastes them. */
import type { Point } from '../../core/circuit/form';
import { circuit } from '../app';

const patience = 250; // ms to wait for the clipboard; a browser that asks the user for permission takes longer

export function copy(): void {
  const text = circuit.copy();
  if (text) void navigator.clipboard?.writeText(text).catch(() => undefined); // without clipboard access, paste uses the page's own copy
}

export async function paste(at: Point): Promise<void> {
  const text = await Promise.race([navigator.clipboard?.readText().catch(() => '') ?? '', new Promise<string>((r) => setTimeout(() => r(''), patience))]);
  circuit.paste(at, text);
}
