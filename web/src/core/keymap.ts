/** Keymaps: names of keys as text, and the action of a pointer press on the viewport in both keymaps. */

export type KeymapName = 'industry' | 'blender';

export interface KeyLike {
  key: string;
  code?: string;
  ctrlKey: boolean;
  metaKey: boolean;
  shiftKey: boolean;
  altKey: boolean;
}

/**
 * Name of the key of an event, such as "Ctrl+Shift+Z". Cmd counts as Ctrl. Letters are upper case. Shift is omitted where the character
 * implies it ("?").
 */
export function key_of(event: KeyLike): string {
  let key = event.key === ' ' ? 'Space' : event.key;
  const letter = /^[a-z]$/i.test(key);
  if (key.length === 1) key = key.toUpperCase();
  const parts: string[] = [];
  if (event.ctrlKey || event.metaKey) parts.push('Ctrl');
  if (event.altKey) parts.push('Alt');
  if (event.shiftKey && (letter || key.length > 1)) parts.push('Shift');
  parts.push(key);
  return parts.join('+');
}

const symbols: Record<string, string> = { ArrowLeft: '←', ArrowRight: '→', ArrowUp: '↑', ArrowDown: '↓', Delete: 'Del', Escape: 'Esc' };

/** A key's name for display: "Ctrl ←". */
export const show_key = (key: string): string =>
  key
    .split('+')
    .map((part) => symbols[part] ?? part)
    .join(' ');

export type PointerAction = 'orbit' | 'pan' | 'zoom' | 'select_or_orbit' | 'none';

/**
 * The action that a button press on the viewport starts. `select_or_orbit` selects or pulls the link under the pointer, and orbits if there
 * is none.
 */
export function pointer_action(keymap: KeymapName, button: number, event: { altKey: boolean; shiftKey: boolean; ctrlKey: boolean }): PointerAction {
  if (keymap === 'industry') {
    if (event.altKey) return button === 0 ? 'orbit' : button === 1 ? 'pan' : 'zoom';
    if (button === 0) return event.shiftKey ? 'pan' : 'select_or_orbit';
    return button === 1 ? 'pan' : button === 2 ? 'pan' : 'none';
  }
  if (button === 1) return event.shiftKey ? 'pan' : event.ctrlKey ? 'zoom' : 'orbit';
  if (button === 2) return 'pan';
  return button === 0 ? (event.altKey ? 'orbit' : 'select_or_orbit') : 'none';
}

/** Whether `target` takes typed text, so that keys pressed in it are not shortcuts. */
export function is_typing(target: { tagName?: string; isContentEditable?: boolean; type?: string } | null): boolean {
  if (!target) return false;
  if (target.isContentEditable) return true;
  const tag = target.tagName?.toUpperCase();
  if (tag === 'TEXTAREA' || tag === 'SELECT') return true;
  return tag === 'INPUT' && !['range', 'checkbox', 'radio', 'button', 'color'].includes(target.type ?? 'text');
}
