/** Pictures of library entries: those stored in the library; missing ones are drawn once from the character and stored there. */
import { unpack_floats, type MotionPreview } from '../../core/library/imports';
import type { LibraryEntry, MechanismData } from '../../core/protocol';
import { picture_size, PreviewRenderer, type Poses } from '../../view/preview';
import { textures_ready } from '../../view/skin_view';
import { service_fetch } from '../app';

export const character_color = '#d5d8df';

export interface Moving {
  mechanism: MechanismData;
  poses: Poses;
}

/** Cache of the newest `capacity` results of `make`; failed ones are not kept. */
class RecentCache<T> {
  private readonly map = new Map<string, Promise<T>>();
  constructor(
    private readonly capacity: number,
    private readonly make: (id: string) => Promise<T>,
    private readonly dropped: (value: T) => void = () => undefined,
  ) {}

  get(id: string): Promise<T> {
    const known = this.map.get(id);
    if (known) return known;
    const made = this.make(id);
    made.catch(() => this.map.delete(id));
    this.map.set(id, made);
    if (this.map.size > this.capacity) {
      const [oldest] = this.map.keys();
      if (oldest !== undefined) {
        void this.map.get(oldest)?.then(this.dropped, () => undefined);
        this.map.delete(oldest);
      }
    }
    return made;
  }
}

async function json<T>(path: string): Promise<T> {
  const response = await service_fetch(path);
  if (!response.ok) throw new Error(`${path}: ${response.status}`);
  return (await response.json()) as T;
}

const mechanisms = new RecentCache<MechanismData>(24, (id) => json(`api/mechanism/${encodeURIComponent(id)}`));
const motions = new RecentCache<Moving>(12, async (id) => {
  const motion = await json<MotionPreview>(`api/motion/${encodeURIComponent(id)}`);
  return { mechanism: await mechanisms.get(motion.mechanism ?? ''), poses: poses_of(motion) };
});

export const poses_of = (motion: MotionPreview): Poses => ({ count: motion.count, links: motion.links, duration: motion.duration, values: unpack_floats(motion.poses) });

let renderer: PreviewRenderer | null | undefined;
/** The shared renderer of pictures; null if the browser has no WebGL. */
export function preview_renderer(): PreviewRenderer | null {
  if (renderer === undefined) {
    try {
      renderer = new PreviewRenderer();
    } catch {
      renderer = null;
    }
  }
  return renderer;
}

export const moving = (id: string): Promise<Moving> => motions.get(id);
export const mechanism_data = (id: string): Promise<MechanismData> => mechanisms.get(id);

// ---- still pictures ----

const mesh_color = '#b9bdc6';
const drawn_here = new Map<string, string>(); // entry data id -> blob URL of a picture drawn by this page
const undrawable = new Set<string>(); // data ids of entries whose drawing failed
const waiting: { entry: LibraryEntry; done: (address: string | null) => void }[] = [];
let working = false;

/** URL of the picture of an entry that this page drew; null if it drew none. */
export const drawn_picture = (entry: LibraryEntry): string | null => drawn_here.get(entry.id) ?? null;

/** Path of the entry's picture in the library; null if the library has none. */
export const stored_path = (entry: LibraryEntry): string | null =>
  entry.thumbnail && entry.entry ? `api/thumbnail/${encodeURIComponent(entry.entry)}?v=${entry.version ?? 1}` : null;

// An <img> cannot send the page's token, so pictures are fetched and shown by object URLs. Images that are shown keep their picture after
// their URL was revoked.
const stored = new RecentCache<string>(
  400,
  async (path) => {
    const response = await service_fetch(path);
    if (!response.ok) throw new Error(`${path}: ${response.status}`);
    return URL.createObjectURL(await response.blob());
  },
  (address) => URL.revokeObjectURL(address),
);

/** Object URL of the picture at `path` (stored_path); rejected if the service does not send it. */
export const stored_picture = (path: string): Promise<string> => stored.get(path);

/**
 * Queues the drawing of an entry's picture; pictures are drawn one at a time, the newest request first.
 * @return a function that removes the request from the queue
 */
export function want_picture(entry: LibraryEntry, done: (address: string | null) => void): () => void {
  if (undrawable.has(entry.id)) {
    done(null);
    return () => undefined;
  }
  const job = { entry, done };
  waiting.unshift(job); // newest first: the user looks at the entry that scrolled into view last
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
    let address = drawn_here.get(entry.id) ?? null;
    if (!address) {
      const blob = await draw(entry).catch(() => null);
      if (blob) {
        address = URL.createObjectURL(blob);
        drawn_here.set(entry.id, address);
        if (entry.entry && !entry.thumbnail) void service_fetch(`api/thumbnail/${encodeURIComponent(entry.entry)}`, { method: 'POST', body: blob }).catch(() => undefined);
      } else {
        undrawable.add(entry.id);
      }
    }
    done(address);
    await new Promise((resolve) => setTimeout(resolve, 12)); // leave the main thread free between two pictures
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
  const { mechanism, poses } = entry.kind === 'motion' ? await moving(entry.id) : { mechanism: await mechanism_data(entry.id), poses: undefined };
  const draw_once = () => renderer.draw(mechanism, entry.mesh ? mesh_color : character_color, context, poses, poses ? 0.4 : 0, entry.mesh?.colors);
  let seen = draw_once();
  if (mechanism.skin) {
    await textures_ready(); // the first drawing began to decode them
    seen = draw_once();
  }
  return seen ? new Promise((resolve) => canvas.toBlob(resolve, 'image/webp', 0.86)) : null;
}
