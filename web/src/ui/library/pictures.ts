/** Pictures of library entries: the library's own where it has them, otherwise drawn once from the real figure and stored there. */
import { unpack_floats, type MotionPreview } from '../../core/library/imports';
import type { LibraryEntry, MechanismData } from '../../core/protocol';
import { picture_size, PreviewRenderer, type Poses } from '../../view/preview';
import { service_path } from '../app';

export const figure_color = '#d5d8df';

export interface Moving {
  mechanism: MechanismData;
  poses: Poses;
}

/** Answers kept: the newest `most`. */
class Kept<T> {
  private readonly map = new Map<string, Promise<T>>();
  constructor(
    private readonly most: number,
    private readonly make: (id: string) => Promise<T>,
  ) {}

  get(id: string): Promise<T> {
    const known = this.map.get(id);
    if (known) return known;
    const made = this.make(id);
    made.catch(() => this.map.delete(id));
    this.map.set(id, made);
    if (this.map.size > this.most) {
      const [oldest] = this.map.keys();
      if (oldest !== undefined) this.map.delete(oldest);
    }
    return made;
  }
}

async function json<T>(path: string): Promise<T> {
  const response = await fetch(service_path(path));
  if (!response.ok) throw new Error(`${path}: ${response.status}`);
  return (await response.json()) as T;
}

const mechanisms = new Kept<MechanismData>(24, (id) => json(`api/mechanism/${encodeURIComponent(id)}`));
const motions = new Kept<Moving>(12, async (id) => {
  const motion = await json<MotionPreview>(`api/motion/${encodeURIComponent(id)}`);
  return { mechanism: await mechanisms.get(motion.mechanism ?? ''), poses: poses_of(motion) };
});

export const poses_of = (motion: MotionPreview): Poses => ({ count: motion.count, links: motion.links, duration: motion.duration, values: unpack_floats(motion.poses) });

let made: PreviewRenderer | null | undefined;
/** Null where this browser draws no WebGL. */
export function preview_renderer(): PreviewRenderer | null {
  if (made === undefined) {
    try {
      made = new PreviewRenderer();
    } catch {
      made = null;
    }
  }
  return made;
}

export const moving = (id: string): Promise<Moving> => motions.get(id);
export const figure = (id: string): Promise<MechanismData> => mechanisms.get(id);

// ---- still pictures ----

const own = new Map<string, string>(); // by content: blob addresses of pictures that this page drew
const none = new Set<string>();
const waiting: { entry: LibraryEntry; done: (address: string | null) => void }[] = [];
let working = false;

/** Address of a still picture, if it is known without drawing. */
export function picture(entry: LibraryEntry): string | null {
  const drawn = own.get(entry.id);
  if (drawn) return drawn;
  return entry.thumbnail && entry.entry ? service_path(`api/thumbnail/${encodeURIComponent(entry.entry)}?v=${entry.version ?? 1}`) : null;
}

/** Draws what has no picture yet, one at a time; who is out of sight again is passed over. */
export function want_picture(entry: LibraryEntry, done: (address: string | null) => void): () => void {
  if (none.has(entry.id)) {
    done(null);
    return () => undefined;
  }
  const job = { entry, done };
  waiting.unshift(job); // what was scrolled to last is looked at now
  if (!working) void work();
  return () => {
    const at = waiting.indexOf(job);
    if (at >= 0) waiting.splice(at, 1);
  };
}

async function work(): Promise<void> {
  working = true;
  for (let job = waiting.shift(); job; job = waiting.shift()) {
    const { entry, done } = job;
    let address = own.get(entry.id) ?? null;
    if (!address) {
      const blob = await draw(entry).catch(() => null);
      if (blob) {
        address = URL.createObjectURL(blob);
        own.set(entry.id, address);
        if (entry.entry && !entry.thumbnail) void fetch(service_path(`api/thumbnail/${encodeURIComponent(entry.entry)}`), { method: 'POST', body: blob }).catch(() => undefined);
      } else {
        none.add(entry.id);
      }
    }
    done(address);
    await new Promise((resolve) => setTimeout(resolve, 12)); // the page goes before
  }
  working = false;
}

async function draw(entry: LibraryEntry): Promise<Blob | null> {
  const renderer = preview_renderer();
  if (!renderer) return null;
  const canvas = document.createElement('canvas');
  canvas.width = picture_size.width;
  canvas.height = picture_size.height;
  const context = canvas.getContext('2d', { willReadFrequently: true });
  if (!context) return null;
  let seen: boolean;
  if (entry.kind === 'motion') {
    const { mechanism, poses } = await moving(entry.id);
    seen = renderer.draw(mechanism, figure_color, context, poses, 0.4);
  } else {
    seen = renderer.draw(await figure(entry.id), figure_color, context);
  }
  return seen ? new Promise((resolve) => canvas.toBlob(resolve, 'image/webp', 0.86)) : null;
}
