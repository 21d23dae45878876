/** Draws pictures of the content for `ugoki export --png` and videos. The program that serves this page receives them. */
import { Access } from '../core/access';
import type { Scene } from './engine';
import { open_planar_converter, read_planar, type PlanarConverter } from './planar';
import { surfaces_ready } from '../view/body_surface';
import { textures_ready } from '../view/skin_view';
import { open_picture_socket, type PictureSocket } from './picture_socket';
import { SceneView } from './scene_view';

interface Settings {
  scene: Scene;
  width: number;
  height: number;
  /** Pictures per second. */
  rate: number;
  /** Time of the first picture, s. */
  from: number;
  count: number;
  /** This page draws the pictures first, first + stride, first + 2 stride ...; others draw the rest. */
  first: number;
  stride: number;
  /** Number of sub-frames of a picture. */
  blur: number;
  /** Fraction of the time between two pictures over which the sub-frames are spread. */
  shutter: number;
  transparent: boolean;
  theme: 'dark' | 'light';
  assist: boolean;
  png: boolean;
  /** Form of the pixels that are sent for videos: 'rgba' (rows from the bottom to the top), 'planar' (PlanarConverter) or '' (no video). */
  raw: '' | 'rgba' | 'planar';
  /** Maximum number of pictures that are sent but not yet answered. */
  ahead: number;
}

/** Draws all pictures and sends them to the program, which runs the content. Errors are reported to the program. */
export async function draw_pictures(): Promise<void> {
  const access = new Access({
    fragment: () => location.hash,
    clear_fragment: () => undefined,
    storage: sessionStorage,
    fetch: (path, init) => fetch(path, init),
  });
  await access.enter();
  try {
    const settings = (await (await access.fetch('api/pictures')).json()) as Settings;
    const { width, height } = settings;
    let planar: PlanarConverter | null = null;
    if (settings.raw === 'planar') planar = await open_planar_converter(await (await access.fetch('api/converter')).arrayBuffer(), width, height);
    await surfaces_ready;
    await draw_all(settings, access, await open_picture_socket(access), planar);
  } catch (error) {
    await access.fetch('api/failed', { method: 'POST', body: (error as Error).message });
  }
}

async function draw_all(settings: Settings, access: Access, socket: PictureSocket, planar: PlanarConverter | null): Promise<void> {
  const { width, height, scene } = settings;
  const canvas = document.createElement('canvas');
  const view = new SceneView(canvas, scene, { theme: settings.theme, pictures: true, transparent: settings.transparent });
  await textures_ready();
  view.assist = settings.assist;
  view.resize(width, height);
  let frame = await socket.frame(0);
  let steps = 0; // of `frame`
  view.place(frame);
  view.first_view();
  let shown = 0; // time up to which the camera has followed, s
  /** Runs the content and the camera to a time. The camera moves in equal steps, so that its motion does not depend on the pictures' rate. */
  const go_to = async (time: number): Promise<void> => {
    const tick = 1 / 60;
    for (;;) {
      const next = Math.min(shown + tick, time);
      const wanted = Math.round(next / scene.step);
      if (wanted > steps) frame = await socket.frame((steps = wanted));
      view.watch(frame);
      view.update_camera(Math.max(next - shown, 1e-4));
      shown = next;
      if (next >= time) return;
    }
  };
  const gl = view.stage.renderer.getContext() as WebGL2RenderingContext;
  const pixels = new Uint8Array(planar && settings.blur === 1 ? 0 : 4 * width * height);
  const sums = settings.blur > 1 ? new Uint32Array(pixels.length) : null;
  const flat = document.createElement('canvas');
  flat.width = width;
  flat.height = height;
  const under_way = new Set<Promise<void>>();
  const send_png = async (number: number, body: Blob): Promise<void> => {
    const answer = await access.fetch(`api/picture?number=${number}`, { method: 'POST', body });
    if (!answer.ok) throw new Error(`The program refused picture ${number + 1}: ${await answer.text()}`);
  };
  const send_all = async (sending: Promise<void>[]): Promise<void> => {
    const sent: Promise<void> = Promise.all(sending).then(() => {
      under_way.delete(sent);
    });
    under_way.add(sent);
    if (under_way.size >= settings.ahead) await Promise.race(under_way);
  };
  // A planar picture is read only before the next one is drawn: reading waits until the picture is drawn, and meanwhile the content is computed.
  let drawn = -1;
  const send_drawn = async (): Promise<void> => {
    if (!planar || drawn < 0) return;
    await send_all([socket.send(drawn, read_planar(gl, planar, width, height))]);
    drawn = -1;
  };
  for (let i = 0; i < settings.count; i++) {
    const mine = i % settings.stride === settings.first;
    const begin = settings.from + i / settings.rate;
    const open_time = (settings.shutter / settings.rate) * (settings.blur > 1 ? 1 : 0);
    sums?.fill(0);
    for (let k = 0; k < settings.blur; k++) {
      // the times of all pictures are visited, so that the camera moves in the same steps on all pages
      await go_to(begin + (open_time * k) / settings.blur);
      if (!mine) continue;
      await send_drawn();
      view.place(frame);
      view.draw(true);
      if (sums || settings.raw === 'rgba') gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      if (sums) for (let j = 0; j < pixels.length; j++) sums[j]! += pixels[j]!;
    }
    if (!mine) continue;
    if (sums) for (let j = 0; j < pixels.length; j++) pixels[j] = Math.round(sums[j]! / settings.blur);
    const sending: Promise<void>[] = [];
    if (settings.png) {
      const picture = sums ? draw_flat(flat, pixels) : canvas;
      const blob = await new Promise<Blob | null>((done) => picture.toBlob(done, 'image/png'));
      if (!blob) throw new Error('The browser cannot write PNG pictures of this size.');
      sending.push(send_png(i, blob));
    }
    if (planar) {
      drawn = i;
      gl.flush();
    } else if (settings.raw !== '') {
      if (settings.transparent) straighten(pixels);
      sending.push(socket.send(i, pixels));
    }
    if (sending.length > 0) await send_all(sending);
  }
  await send_drawn();
  await Promise.all(under_way);
}

/** Draws pixels (rows from the bottom to the top, premultiplied) into a canvas. */
function draw_flat(canvas: HTMLCanvasElement, pixels: Uint8Array): HTMLCanvasElement {
  const { width, height } = canvas;
  const image = new ImageData(width, height);
  for (let y = 0; y < height; y++) image.data.set(pixels.subarray(4 * width * (height - 1 - y), 4 * width * (height - y)), 4 * width * y);
  straighten(image.data);
  canvas.getContext('2d')!.putImageData(image, 0, 0);
  return canvas;
}

/** Divides colours by alpha, because WebGL uses premultiplied colours and picture files do not. */
function straighten(pixels: Uint8Array | Uint8ClampedArray): void {
  for (let j = 0; j < pixels.length; j += 4) {
    const alpha = pixels[j + 3]!;
    if (alpha === 0 || alpha === 255) continue;
    for (let k = 0; k < 3; k++) pixels[j + k] = Math.min(255, Math.round((pixels[j + k]! * 255) / alpha));
  }
}
