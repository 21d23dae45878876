// Unpacks the script of the page (gzip in Base64) and runs it.
(async () => {
  try {
    const letters = atob(document.getElementById('ugoki-page').textContent);
    const bytes = Uint8Array.from(letters, (c) => c.charCodeAt(0));
    const text = await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'))).text();
    const script = document.createElement('script');
    script.textContent = text;
    document.head.append(script);
  } catch (error) {
    document.body.innerHTML = '<p style="color:#e3e5ea;font:14px sans-serif;margin:2em">This browser is too old to play this page. It needs Chrome 80, Firefox 113, Safari 16.4 or newer.</p>';
    throw error;
  }
})();
