/** Entries of menus that run commands. */
import { show_key, type KeymapName } from '../core/keymap';
import { run } from './actions';
import { registry } from './app';
import type { MenuItem } from './Menu';

/** The entry that runs the command `id`, with its label and its first key. @param more fields that replace those of the command */
export function command_item(id: string, keymap: KeymapName, more: Partial<MenuItem> = {}): MenuItem {
  const command = registry.get(id);
  const key = command && registry.keys_of(command, keymap)[0];
  return { label: command?.label ?? id, key: key && show_key(key), disabled: command?.enabled?.() === false, run: () => run(id), ...more };
}
