// Unpacks the script of the page (gzip in base 91, see from_base91() in src/player/payload.ts) and runs it.
// A page that draws pictures for `ugoki export` reports errors that end its script, because nobody looks at it.
if (document.documentElement.dataset.engine === 'pictures') {
  const report = async (message) => {
    const send = async (path, body, headers) => (await fetch(`api/${path}`, { method: 'POST', body, headers })).json();
    const code = new URLSearchParams(location.hash.slice(1)).get('code');
    const token = sessionStorage.getItem('ugoki_token') ?? (await send('session', JSON.stringify({ code }), { 'Content-Type': 'application/json' })).token;
    await send('failed', `The page of the pictures has ended: ${message}.`, { Authorization: `Bearer ${token}` });
  };
  addEventListener('error', (event) => void report(event.message));
  addEventListener('unhandledrejection', (event) => void report(String(event.reason)));
}
(async () => {
  try {
    const packed = document.getElementById('ugoki-page').textContent.trim();
    const value = {};
    let letter = 0;
    for (let code = 33; code < 127; code++) if (!'"<\\'.includes(String.fromCharCode(code))) value[String.fromCharCode(code)] = letter++;
    const bytes = new Uint8Array(Math.floor(((packed.length - 1) * 13) / 16) - value[packed[0]]);
    let word = 0, bits = 0, to = 0;
    for (let from = 1; from < packed.length; from += 2) {
      word = (word << 13) | (value[packed[from]] * 91 + value[packed[from + 1]]);
      for (bits += 13; bits >= 8; ) bytes[to++] = word >> (bits -= 8);
    }
    const text = await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'))).text();
    const script = document.createElement('script');
    script.textContent = text;
    document.head.append(script);
  } catch (error) {
    document.body.innerHTML = '<p style="color:#e3e5ea;font:14px sans-serif;margin:2em">This browser is too old to play this page. It needs Chrome 80, Firefox 113, Safari 16.4 or newer.</p>';
    throw error;
  }
})();
