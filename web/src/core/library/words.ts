/** Names, identities and descriptions of library entries. */
import { format_number, join_facts } from '../format';
import type { LibraryEntry } from '../protocol';

/** Tags of an entry as a list; the service may send them as one text. */
export function tags_of(entry: LibraryEntry): string[] {
  if (Array.isArray(entry.tags)) return entry.tags;
  return entry.tags ? entry.tags.split(/[\s,]+/).filter(Boolean) : [];
}

/** A length in metres as text: "4 mm", "35 cm", "1.75 m", "12 m". */
export function format_length(metres: number): string {
  if (metres < 0.995) return metres < 0.0095 ? `${format_number(1000 * metres, 1)} mm` : `${format_number(100 * metres, metres < 0.0995 ? 1 : 0)} cm`;
  return `${format_number(metres, metres < 9.995 ? 2 : 0)} m`;
}

/** A mass in kilograms as text: "0.8 g", "32 g", "4.5 kg", "70 kg". */
export function format_mass(kilograms: number): string {
  if (kilograms < 0.9995) return `${format_number(1000 * kilograms, kilograms < 0.00995 ? 1 : 0)} g`;
  return `${format_number(kilograms, kilograms < 9.95 ? 1 : 0)} kg`;
}

/** The line under an entry's name. The most distinctive facts come first, because a narrow panel cuts off the end. */
export function describe_entry(entry: LibraryEntry): string {
  if (entry.mesh) return join_facts(['mesh', entry.mesh.size?.map((x) => format_length(x)).join(' × '), entry.mesh.triangles !== undefined && `${entry.mesh.triangles} triangles`]);
  if (entry.kind === 'mechanism') {
    return join_facts([
      entry.height !== undefined && entry.height > 0 && format_length(entry.height),
      entry.mass !== undefined && format_mass(entry.mass),
      entry.dofs !== undefined && `${entry.dofs} DOF`,
    ]);
  }
  return join_facts([
    entry.duration !== undefined && `${entry.duration.toFixed(2)} s`,
    entry.rate !== undefined && entry.rate > 0 && `${format_number(entry.rate, 0)} Hz`,
    entry.cyclic && 'cyclic',
  ]);
}

/**
 * Converts an entry of the service into an entry of the page. `id` becomes the data id of the newest version, which scenarios and previews
 * use. `entry` becomes the entry id, which is the same for all versions and is used in the library's URLs; it is absent if the entry is
 * only in the open project.
 */
export function from_service(entry: LibraryEntry & { content?: string }): LibraryEntry {
  const { content, ...rest } = entry;
  return { ...rest, id: content ?? entry.id, entry: entry.version === undefined ? undefined : entry.id };
}

/** Key of an entry in lists and selections: the entry id if it has one, because two entries may have the same data id. */
export const key_of = (entry: LibraryEntry): string => entry.entry ?? entry.id;

/** Splits typed tags at commas; spaces within a tag are kept. */
export const split_tags = (text: string): string[] => [...new Set(text.split(',').map((t) => t.trim().replace(/\s+/g, ' ')).filter(Boolean))];

/** A date for display: "today 14:05", "12 Mar 2026"; empty if `text` is not a date. */
export function format_when(text: string | undefined, now = new Date()): string {
  const date = text ? new Date(text) : null;
  if (!date || Number.isNaN(date.getTime())) return '';
  const same_day = date.toDateString() === now.toDateString();
  if (same_day) return `today ${date.toLocaleTimeString([], { hour: '2-digit', minute: '2-digit', hour12: false })}`;
  return date.toLocaleDateString('en-GB', { day: 'numeric', month: 'short', year: 'numeric' });
}

export function format_bytes(bytes: number | undefined): string {
  if (bytes === undefined) return '';
  if (bytes < 1000) return `${bytes} B`;
  if (bytes < 999_500) return `${(bytes / 1000).toFixed(bytes < 9950 ? 1 : 0)} kB`;
  return `${(bytes / 1e6).toFixed(bytes < 9.95e6 ? 1 : 0)} MB`;
}
