/** The registry of named commands: palette, keys and buttons all run commands from it. */
import { default_keys, no_key_edits, type KeyEdits } from './key_edits';
import type { KeymapName } from './keymap';

export interface AppCommand {
  id: string;
  label: string;
  group: string;
  /** Keys in both keymaps. The fields `industry` and `blender` add keys to the keymap of that name only. */
  keys?: string[];
  industry?: string[];
  blender?: string[];
  enabled?: () => boolean;
  /** True: a held key runs the command repeatedly. */
  repeats?: boolean;
  run: () => void;
}

export class CommandRegistry {
  private readonly commands = new Map<string, AppCommand>();
  /** Keys that the user has changed. */
  edits: KeyEdits = no_key_edits;

  add(...commands: AppCommand[]): void {
    for (const command of commands) {
      if (this.commands.has(command.id)) throw new Error(`command ${command.id} is registered twice`);
      this.commands.set(command.id, command);
    }
  }

  get(id: string): AppCommand | undefined {
    return this.commands.get(id);
  }

  all(): AppCommand[] {
    return [...this.commands.values()];
  }

  keys_of(command: AppCommand, keymap: KeymapName): string[] {
    return [...(this.edits[keymap][command.id] ?? default_keys(command, keymap))];
  }

  /** The command of a key: the first that is enabled, otherwise the first. Tools, which are registered first, use keys of other commands. */
  by_key(key: string, keymap: KeymapName): AppCommand | undefined {
    const found = this.all().filter((command) => this.keys_of(command, keymap).includes(key));
    return found.find((command) => command.enabled?.() !== false) ?? found[0];
  }

  /** Runs a command if it exists and is enabled. @return whether it was run */
  run(id: string): boolean {
    const command = this.commands.get(id);
    if (!command || command.enabled?.() === false) return false;
    command.run();
    return true;
  }

  /**
   * Commands whose label or group contains every word of `query`. Matches at the start of the label come first, then at the start of a
   * word.
   */
  search(query: string): AppCommand[] {
    const words = query.toLowerCase().split(/\s+/).filter(Boolean);
    if (words.length === 0) return this.all();
    const scored: { command: AppCommand; score: number }[] = [];
    for (const command of this.all()) {
      const label = command.label.toLowerCase();
      const text = `${label} ${command.group.toLowerCase()}`;
      if (!words.every((word) => text.includes(word))) continue;
      const first = words[0]!;
      scored.push({ command, score: label.startsWith(first) ? 0 : label.includes(` ${first}`) ? 1 : label.includes(first) ? 2 : 3 });
    }
    return scored.sort((a, b) => a.score - b.score).map((entry) => entry.command);
  }
}
