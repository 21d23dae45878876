// Unpacks the script of the page (gzip in base 85, see from_base85() in src/player/payload.ts) and runs it.
(async () => {
  try {
    const packed = document.getElementById('ugoki-page').textContent.trim();
    const value = {};
    let letter = 0;
    for (let code = 33; code < 127; code++) if (!'"$&\'<>\\`'.includes(String.fromCharCode(code))) value[String.fromCharCode(code)] = letter++;
    const view = new DataView(new ArrayBuffer(((packed.length - 1) / 5) * 4));
    for (let from = 1, to = 0; from < packed.length; to += 4) {
      let word = 0;
      for (const end = from + 5; from < end; from++) word = word * 85 + value[packed[from]];
      view.setUint32(to, word);
    }
    const bytes = new Uint8Array(view.buffer, 0, view.byteLength - value[packed[0]]);
    const text = await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'))).text();
    const script = document.createElement('script');
    script.textContent = text;
    document.head.append(script);
  } catch (error) {
    document.body.innerHTML = '<p style="color:#e3e5ea;font:14px sans-serif;margin:2em">This browser is too old to play this page. It needs Chrome 80, Firefox 113, Safari 16.4 or newer.</p>';
    throw error;
  }
})();
