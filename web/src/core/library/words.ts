/** Library entries, searched and told apart. */
import { format_number, join_facts } from './format';
import type { LibraryEntry } from './protocol';

export function tags_of(entry: LibraryEntry): string[] {
  if (Array.isArray(entry.tags)) return entry.tags;
  return entry.tags ? entry.tags.split(/[\s,]+/).filter(Boolean) : [];
}

/** The second line under an entry's name. */
export function describe_entry(entry: LibraryEntry): string {
  if (entry.kind === 'mechanism') {
    return join_facts([
      entry.freedoms !== undefined && `${entry.freedoms} freedoms`,
      entry.mass !== undefined && `${format_number(entry.mass, 1)} kg`,
      entry.height !== undefined && entry.height > 0 && `${format_number(entry.height, 2)} m`,
    ]);
  }
  return join_facts([
    entry.duration !== undefined && `${entry.duration.toFixed(2)} s`,
    entry.rate !== undefined && entry.rate > 0 && `${format_number(entry.rate, 0)} Hz`,
    entry.cyclic && 'cyclic',
  ]);
}

/** Entries that hold every word in name, summary or tags, in the order given. */
export function search_library(entries: readonly LibraryEntry[], query: string): LibraryEntry[] {
  const words = query.toLowerCase().split(/\s+/).filter(Boolean);
  if (words.length === 0) return [...entries];
  return entries.filter((entry) => {
    const text = `${entry.name} ${entry.summary ?? ''} ${tags_of(entry).join(' ')} ${entry.kind}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
}
