// Builds the player: one HTML page with engine and script inline, and ugoki-player.js, the element for other pages.
//   node player/build.mjs ENGINE.wasm FOLDER
// Writes FOLDER/player.html, in which `ugoki export --html` replaces @UGOKI_TITLE@, @UGOKI_FIRST@ and @UGOKI_CONTENT@, and FOLDER/ugoki-player.js.
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'vite';

const [engine_file, folder] = process.argv.slice(2);
if (!folder) {
  console.error('usage: node player/build.mjs ENGINE.wasm FOLDER');
  process.exit(2);
}
const here = dirname(fileURLToPath(import.meta.url));

/** The script as one classic script without imports. */
async function bundle(entry) {
  const result = await build({
    root: join(here, '..'),
    configFile: false,
    logLevel: 'warn',
    publicDir: false,
    build: { write: false, target: 'es2022', minify: 'esbuild', lib: { entry: join(here, '..', entry), formats: ['iife'], name: 'Ugoki' }, cssCodeSplit: false },
  });
  return result[0].output.find((o) => o.type === 'chunk').code;
}

/** The bytes as text in base 91 (from_base91() in src/player/payload.ts describes it). */
function base91(data) {
  const letters = [];
  for (let code = 33; code < 127; code++) if (!'"<\\'.includes(String.fromCharCode(code))) letters.push(String.fromCharCode(code));
  const pairs = Math.ceil((8 * data.length) / 13);
  const bytes = Buffer.concat([data, Buffer.alloc(2)]);
  const text = [letters[Math.floor((13 * pairs) / 8) - data.length]];
  let word = 0, bits = 0, at = 0;
  for (let pair = 0; pair < pairs; pair++) {
    for (; bits < 13; bits += 8) word = ((word << 8) | bytes[at++]) & 0xfffff;
    bits -= 13;
    const value = (word >> bits) & 8191;
    text.push(letters[Math.floor(value / 91)], letters[value % 91]);
  }
  return text.join('');
}

/** The data as text of LZMA (src/player/lzma.ts unpacks it): a quarter smaller than gzip. The header receives the size of the data. */
function squeezed(data) {
  const out = execFileSync('xz', ['--format=lzma', '-9e', '-c'], { input: data, maxBuffer: 1 << 28 });
  out.writeBigUInt64LE(BigInt(data.length), 5);
  return base91(out);
}
/** The data as text of gzip. zopfli makes it 4 % smaller than the most that zlib can do; any browser unpacks it. */
function packed(data) {
  const work = mkdtempSync(join(tmpdir(), 'ugoki-pack-'));
  try {
    writeFileSync(join(work, 'data'), data);
    return base91(execFileSync('zopfli', ['--i5', '-c', join(work, 'data')], { maxBuffer: 1 << 28 }));
  } finally {
    rmSync(work, { recursive: true });
  }
}
const engine = squeezed(readFileSync(engine_file));
const page = await bundle('src/player/main.ts');
const script = packed(page);
const element = await bundle('src/player/embed.ts');
const boot = readFileSync(join(here, 'boot.js'), 'utf8').replace(/^\/\/.*\n/gm, '').replace(/\n\s*/g, '');
const html = readFileSync(join(here, 'template.html'), 'utf8')
  .replace('@UGOKI_ENGINE@', () => engine)
  .replace('@UGOKI_PAGE@', () => script)
  .replace('@UGOKI_BOOT@', () => boot.trim());
mkdirSync(folder, { recursive: true });
writeFileSync(join(folder, 'player.html'), html);
if (!element.includes('"@UGOKI_ENGINE@"')) throw new Error('The bundler has changed the quotes of the engine in ugoki-player.js; base 91 excludes " only.');
writeFileSync(join(folder, 'ugoki-player.js'), element.replace('@UGOKI_ENGINE@', () => engine));
console.log(`player.html ${html.length} bytes, of which engine ${engine.length} and script ${script.length}`);
