/** Sizes of the skins of a document, for the export. */
import type { MechanismData, SkinData } from './protocol';

const lists = ['positions', 'normals', 'uvs', 'colors', 'bones', 'weights', 'indices'] as const;

/** Bytes of a Base64 text. */
const decoded_length = (text: string): number => (text.length / 4) * 3 - (text.endsWith('==') ? 2 : text.endsWith('=') ? 1 : 0);

/** Size of the vertices, triangles and textures of a skin, bytes. */
export function skin_bytes(skin: SkinData): number {
  return [...lists.map((list) => skin[list] ?? ''), ...skin.textures.map((t) => t.data)].reduce((sum, text) => sum + decoded_length(text), 0);
}

/** Size of all skins of the characters, bytes; characters of one mechanism share its skin. */
export function bytes_of_skins(characters: readonly { mechanism: string }[], mechanisms: Readonly<Record<string, MechanismData>>): number {
  return [...new Set(characters.map((c) => c.mechanism))].reduce((sum, id) => sum + (mechanisms[id]?.skin ? skin_bytes(mechanisms[id].skin) : 0), 0);
}
