/** Keys that the user has given to commands, in place of those of the keymap. Kept with the user's other choices, and written to files. */
import type { AppCommand } from './commands';
import type { KeymapName } from './keymap';

/** For each keymap: the keys of commands that differ from the keymap. An empty list: the command has no key. */
export type KeyEdits = Readonly<Record<KeymapName, Readonly<Record<string, readonly string[]>>>>;

export const no_key_edits: KeyEdits = { industry: {}, blender: {} };

const max_keys = 8; // of one command
const max_length = 32; // characters of a key's name

/** The keys that the keymap gives to a command. */
export const default_keys = (command: AppCommand, keymap: KeymapName): string[] => [...(command.keys ?? []), ...(command[keymap] ?? [])];

export const edited_keys = (command: AppCommand, keymap: KeymapName, edits: KeyEdits): readonly string[] => edits[keymap][command.id] ?? default_keys(command, keymap);

const equal = (a: readonly string[], b: readonly string[]): boolean => a.length === b.length && a.every((key, i) => key === b[i]);

/** Gives a command these keys. Keys that equal those of the keymap are not stored. */
export function set_keys(edits: KeyEdits, keymap: KeymapName, command: AppCommand, keys: readonly string[]): KeyEdits {
  const { [command.id]: _old, ...rest } = edits[keymap];
  return { ...edits, [keymap]: equal(keys, default_keys(command, keymap)) ? rest : { ...rest, [command.id]: [...keys] } };
}

/** The other commands that `key` runs. Commands that share the key in the keymap itself take turns, and are no conflict. */
export function conflicts(commands: readonly AppCommand[], command: AppCommand, key: string, keymap: KeymapName, edits: KeyEdits): AppCommand[] {
  const shared = default_keys(command, keymap).includes(key);
  return commands.filter((other) => other.id !== command.id && edited_keys(other, keymap, edits).includes(key) && !(shared && default_keys(other, keymap).includes(key)));
}

/** Adds a key to a command and takes it from the commands with which it would conflict. */
export function give_key(edits: KeyEdits, commands: readonly AppCommand[], command: AppCommand, key: string, keymap: KeymapName): KeyEdits {
  let next = edits;
  for (const other of conflicts(commands, command, key, keymap, edits)) next = set_keys(next, keymap, other, edited_keys(other, keymap, next).filter((k) => k !== key));
  const keys = edited_keys(command, keymap, next);
  return keys.includes(key) ? next : set_keys(next, keymap, command, [...keys, key]);
}

export const count_edits = (edits: KeyEdits, keymap: KeymapName): number => Object.keys(edits[keymap]).length;

/** Keys that browsers and the page keep for themselves. @returns the reason as a sentence, or null */
export function reserved(key: string): string | null {
  if (/^(Ctrl\+)?(Alt\+)?(Shift\+)?(Control|Shift|Alt|Meta|AltGraph|CapsLock|Dead|Unidentified|Process)$/.test(key)) return 'A modifier alone cannot be a key. Hold it and press another key.';
  if (['Escape', 'Enter', 'Tab', 'Shift+Tab', 'Shift+Enter'].includes(key)) return 'Escape, Enter and Tab move through dialogs and fields. Use another key.';
  if (/^Ctrl\+(Shift\+)?[NTW]$/.test(key) || ['F5', 'F11', 'F12', 'Ctrl+R', 'Ctrl+L', 'Alt+F4'].includes(key)) return `The browser keeps ${key.replaceAll('+', ' ')} for itself. Use another key.`;
  return null;
}

/** The edits as a file. */
export const write_key_edits = (edits: KeyEdits): string => `${JSON.stringify({ format: 'ugoki keys', version: 1, ...edits }, null, 2)}\n`;

export interface ReadKeys {
  edits: KeyEdits;
  /** Sentences about entries that were left out. */
  problems: string[];
}

/**
 * Reads edits from a file or from stored choices. Entries that are not valid are left out.
 * @param known whether a command of this id exists; stored choices keep unknown commands of other versions
 */
export function read_key_edits(value: unknown, known: (id: string) => boolean = () => true): ReadKeys {
  const edits: Record<KeymapName, Record<string, string[]>> = { industry: {}, blender: {} };
  const problems: string[] = [];
  const object = typeof value === 'object' && value !== null && !Array.isArray(value) ? (value as Record<string, unknown>) : {};
  for (const keymap of ['industry', 'blender'] as const) {
    const list = object[keymap];
    if (list === undefined) continue;
    if (typeof list !== 'object' || list === null || Array.isArray(list)) {
      problems.push(`${keymap}: the value must be an object of command ids with lists of keys.`);
      continue;
    }
    for (const [id, keys] of Object.entries(list)) {
      const valid = Array.isArray(keys) && keys.length <= max_keys && keys.every((k) => typeof k === 'string' && k.length > 0 && k.length <= max_length && !reserved(k));
      if (!known(id)) problems.push(`${keymap}/${id}: there is no such command; the entry is left out.`);
      else if (!valid) problems.push(`${keymap}/${id}: give a list of at most ${max_keys} keys, such as ["Shift+R"]; the entry is left out.`);
      else edits[keymap][id] = [...(keys as string[])];
    }
  }
  return { edits, problems };
}

/** Reads the text of a file. @throws Error with a sentence if the text is not a file of keys */
export function parse_key_file(text: string, known: (id: string) => boolean): ReadKeys {
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    throw new Error('The file is not JSON. Choose a file that “Export” has written.');
  }
  const head = (typeof value === 'object' && value !== null ? value : {}) as { format?: unknown; version?: unknown };
  if (head.format !== 'ugoki keys') throw new Error('The file is not a list of keys of Ugoki. Choose a file that “Export” has written.');
  if (head.version !== 1) throw new Error(`The file has version ${String(head.version)}; this studio reads version 1. Open it with a newer Ugoki.`);
  return read_key_edits(value, known);
}
