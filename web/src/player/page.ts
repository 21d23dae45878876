/** The page of a player. It finds the engine and the content, and answers messages of a page that shows this page in a frame. */
import type { Engine } from './engine';
import { in_range } from './ranges';
import { set_engine_source, UgokiPlayer } from './element';
import { engine_of, inline_data } from './payload';
import { draw_pictures } from './pictures';
import { surfaces_ready } from '../view/body_surface';
import { open_remote_engine } from './remote_engine';
import { read_still } from './still_engine';
import { open_wasm_engine } from './wasm_engine';

const content_of = async (src: string | null): Promise<Uint8Array> => {
  if (src === null) {
    const inside = await inline_data('ugoki-content');
    if (!inside) throw new Error('This page has no content. Export it again, or give <ugoki-player> the attribute src.');
    return inside;
  }
  const response = await fetch(src);
  if (!response.ok) throw new Error(`${src}: the server answered ${response.status} ${response.statusText}.`);
  return new Uint8Array(await response.arrayBuffer());
};

let module: Promise<Uint8Array<ArrayBuffer> | null> | null = null;

/** Opens the engine inside the page. If a native program serves the page, the program is the engine. */
async function open_engine(src: string | null): Promise<Engine> {
  if (src === null && document.documentElement.dataset.engine === 'native') return surfaces_ready.then(open_remote_engine);
  module ??= engine_bytes();
  const [wasm, content] = await Promise.all([module, content_of(src), surfaces_ready]);
  if (!wasm) throw new Error('This page has no engine. Export it again.');
  return open_wasm_engine(wasm, content);
}

/** The first frame of the content inside this page; null if the page has none. */
async function open_still(): Promise<Engine | null> {
  const [data] = await Promise.all([inline_data('ugoki-first'), surfaces_ready]);
  return data && read_still(data);
}

let engine_bytes = (): Promise<Uint8Array<ArrayBuffer> | null> => inline_data('ugoki-engine', engine_of);
/** Sets an engine that is not inside the page: the script ugoki-player.js contains the engine. */
export function set_engine_bytes(get: () => Promise<Uint8Array<ArrayBuffer> | null>): void {
  engine_bytes = get;
}

/** Defines the element, or draws pictures if the page was made for pictures. Players that the page already contains begin to load. */
export function start(): void {
  set_engine_source(open_engine, open_still);
  if (document.documentElement.dataset.engine === 'pictures') void draw_pictures();
  else if (!customElements.get('ugoki-player')) customElements.define('ugoki-player', UgokiPlayer);
}

/** Commands that the page outside the frame may send, for example postMessage({ugoki: 'play'}). Each is answered with {ugoki: 'done', ...}. */
const commands: Record<string, (player: UgokiPlayer, arguments_: unknown[]) => unknown> = {
  play: (p) => p.play(),
  pause: (p) => p.pause(),
  reset: (p) => p.reset(),
  step: (p, [count]) => p.step(Number(count)),
  push: (p, a) => p.push(...(a as Parameters<UgokiPlayer['push']>)),
  grab: (p, a) => p.grab(...(a as Parameters<UgokiPlayer['grab']>)),
  drag: (p, a) => p.drag(...(a as Parameters<UgokiPlayer['drag']>)),
  release: (p) => p.release(),
  schedule: (p, [inputs]) => p.schedule(inputs as never),
  recorded: (p) => p.recorded(),
  state_hash: (p) => p.state_hash(),
  follow: (p, [character]) => p.follow(character as never),
  look: (p, a) => p.look(...(a as Parameters<UgokiPlayer['look']>)),
  frame_all: (p) => p.frame_all(),
  speed: (p, [value]) => (p.speed = in_range('speed', value, 0.05, 4)),
  state: (p) => ({ time: p.time, steps: p.steps, duration: p.duration, paused: p.paused, ended: p.ended, characters: p.characters }),
};

if (window.parent !== window) {
  addEventListener('message', (event: MessageEvent<{ ugoki?: string; id?: unknown; arguments?: unknown[] }>) => {
    if (event.source !== window.parent || typeof event.data?.ugoki !== 'string') return;
    const player = document.querySelector<UgokiPlayer>('ugoki-player');
    const command = Object.hasOwn(commands, event.data.ugoki) ? commands[event.data.ugoki] : undefined;
    const answer = (fields: object): void => window.parent.postMessage({ ugoki: 'done', id: event.data.id, ...fields }, '*');
    if (!player || !command) return answer({ error: `'${event.data.ugoki}' is not a command.` });
    void (async () => command(player, event.data.arguments ?? []))().then(
      (result) => answer({ result }),
      (error: Error) => answer({ error: error.message }),
    );
  });
  for (const type of ['ready', 'play', 'pause', 'reset', 'ended', 'error'])
    document.addEventListener(type, (event) => window.parent.postMessage({ ugoki: type, ...(event as CustomEvent<object>).detail }, '*'));
}
