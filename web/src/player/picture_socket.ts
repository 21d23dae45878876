/** Frames from the program and pixels to it, by WebSocket. */
import type { Access } from '../core/access';
import { decode_frame, type Frame } from '../core/frames';

const piece = 512 * 1024; // bytes of a message: the browser has memory for blocks up to 1 MB at hand, larger ones are new each time

export interface PictureSocket {
  /** The frame after `step` steps. Steps must increase from call to call. */
  frame(step: number): Promise<Frame>;
  /** Sends a picture. The pixels may be changed afterwards. @return promise that the program has processed the picture */
  send(number: number, pixels: Uint8Array<ArrayBuffer>): Promise<void>;
}

/** Connects to the program that served this page. */
export async function open_picture_socket(access: Access): Promise<PictureSocket> {
  const socket = new WebSocket(`${location.origin.replace(/^http/, 'ws')}/ws`, access.subprotocols);
  socket.binaryType = 'arraybuffer';
  const lost = (): Error => new Error('The program does not answer.');
  await new Promise((done, failed) => {
    socket.addEventListener('open', done);
    socket.addEventListener('error', () => failed(lost()));
  });
  const waiting = new Map<number, { done: () => void; failed: (error: Error) => void }>();
  const frames: { done: (frame: Frame) => void; failed: (error: Error) => void }[] = []; // requested, the oldest first
  socket.addEventListener('message', (event: MessageEvent<string | ArrayBuffer>) => {
    if (typeof event.data !== 'string') {
      const frame = decode_frame(event.data);
      const request = frames.shift();
      if (typeof frame === 'string') request?.failed(new Error(frame));
      else request?.done(frame);
      return;
    }
    const number = Number(event.data);
    waiting.get(number)?.done();
    waiting.delete(number);
  });
  socket.addEventListener('close', () => {
    for (const { failed } of [...waiting.values(), ...frames.splice(0)]) failed(lost());
    waiting.clear();
  });
  return {
    frame: (step) =>
      new Promise((done, failed) => {
        if (socket.readyState !== WebSocket.OPEN) return failed(lost());
        frames.push({ done, failed });
        socket.send(`frame ${step}`);
      }),
    send: (number, pixels) =>
      new Promise((done, failed) => {
        if (socket.readyState !== WebSocket.OPEN) return failed(lost());
        waiting.set(number, { done, failed });
        socket.send(`${number} ${pixels.length}`);
        for (let at = 0; at < pixels.length; at += piece) socket.send(pixels.subarray(at, at + piece));
      }),
  };
}
