/** Reads the data inside an exported page: gzip in Base64. */

/** Decodes Base64 text; white space is ignored. */
export function from_base64(text: string): Uint8Array<ArrayBuffer> {
  const letters = atob(text.replace(/\s/g, ''));
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

/** Unpacks gzip data; returns other data unchanged. */
export async function unpack(bytes: Uint8Array<ArrayBuffer>): Promise<Uint8Array<ArrayBuffer>> {
  if (bytes[0] !== 0x1f || bytes[1] !== 0x8b) return bytes;
  if (typeof DecompressionStream === 'undefined') throw new Error('This browser is too old to play this page. It needs DecompressionStream (Chrome 80, Firefox 113, Safari 16.4 or newer).');
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Returns the data of an element `<script type="..." id="ID">BASE64</script>`; null if the page has no such element or the element is empty. */
export async function inline_data(id: string): Promise<Uint8Array<ArrayBuffer> | null> {
  const text = document.getElementById(id)?.textContent?.trim();
  return text ? unpack(from_base64(text)) : null;
}
