/**
 * Reads the data inside an exported page. The content is gzip in Base64, the script gzip in base 91, which is 8 % shorter, and the engine LZMA in
 * base 91.
 */
import { from_lzma } from './lzma';

/** Decodes Base64 text; white space is ignored. */
export function from_base64(text: string): Uint8Array<ArrayBuffer> {
  const letters = atob(text.replace(/\s/g, ''));
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

/**
 * Decodes text in base 91, which player/build.mjs writes: two letters for 13 bits, most significant first. The letters are the printable
 * characters of ASCII without "<\, which have a meaning in a script element or in a string. The first letter is the number of bytes to drop
 * at the end.
 */
export function from_base91(text: string): Uint8Array<ArrayBuffer> {
  const value = new Uint8Array(128);
  let letter = 0;
  for (let code = 33; code < 127; code++) if (!'"<\\'.includes(String.fromCharCode(code))) value[code] = letter++;
  const at = (i: number): number => value[text.charCodeAt(i)]!;
  const bytes = new Uint8Array(Math.floor(((text.length - 1) * 13) / 16) - at(0));
  let word = 0;
  let bits = 0;
  let to = 0;
  for (let from = 1; from < text.length; from += 2) {
    word = (word << 13) | (at(from) * 91 + at(from + 1));
    for (bits += 13; bits >= 8; ) bytes[to++] = word >> (bits -= 8);
  }
  return bytes;
}

/** The engine in the text that player/build.mjs makes of it. */
export const engine_of = (text: string): Uint8Array<ArrayBuffer> => from_lzma(from_base91(text));

/** Unpacks gzip data; returns other data unchanged. */
export async function unpack(bytes: Uint8Array<ArrayBuffer>): Promise<Uint8Array<ArrayBuffer>> {
  if (bytes[0] !== 0x1f || bytes[1] !== 0x8b) return bytes;
  if (typeof DecompressionStream === 'undefined') throw new Error('This browser is too old to play this page. It needs DecompressionStream (Chrome 80, Firefox 113, Safari 16.4 or newer).');
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Returns the data of an element `<script type="..." id="ID">TEXT</script>`; null if the page has no such element or the element is empty. */
export async function inline_data(id: string, decode = from_base64): Promise<Uint8Array<ArrayBuffer> | null> {
  const text = document.getElementById(id)?.textContent?.trim();
  return text ? unpack(decode(text)) : null;
}
