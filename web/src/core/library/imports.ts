/**
 * The import queue: files are staged by the service one by one, previewed, corrected by the user, then stored in the library or dropped.
 * Framework-free.
 */
import { createStore, type StoreApi } from 'zustand/vanilla';
import { RequestError, type MechanismData, type Problem, type ServiceError } from '../protocol';

export interface ImportSettings {
  /** Length of the file's unit, m. */
  unit: number;
  /** True if the file does not specify its unit. */
  unit_guessed: boolean;
  /** Axis of the file that points up, such as "y". */
  up: string;
  /** Axis of the file that points forwards, such as "z". */
  forward: string;
  /** Frames a second; 0 if the file has no motion. */
  rate: number;
  /** True if the file specifies its frame rate. */
  rate_specified: boolean;
  /** JSON of the corrected anatomy; empty: as recognised. */
  mapping?: string;
  /** Of a file with several characters: root joint of the chosen one; empty: as recognised. */
  character?: string;
  /** Of a file with several motions: name of the chosen one; empty: all. */
  take?: string;
  /** Give a character that walks in place the travel of its feet. */
  travel?: boolean;
}

/** A limb of the recognised anatomy with the joints at which its sections begin. */
export interface AnatomyLimb {
  limb: string;
  /** 0 to 1 */
  confidence: number;
  evidence: string;
  /** An empty joint: the limb has no such section. */
  sections: { section: string; joint: string }[];
  /** Indices of the links that belong to the limb. */
  links: number[];
}

export interface Anatomy {
  format: string;
  version: number;
  plan: 'human' | 'four legs' | 'other';
  confidence: number;
  limbs: AnatomyLimb[];
  /** Names of all joints. */
  joints: string[];
}

/**
 * JSON of a mapping with one joint changed. All limbs are written, so that a joint that was recognised stays where it is.
 * @param change nothing: the mapping as recognised
 */
export function mapping_of(anatomy: Anatomy, change?: { plan?: Anatomy['plan']; limb?: string; section?: string; joint?: string }): string {
  const limbs = anatomy.limbs.map((l) => ({
    limb: l.limb,
    sections: l.sections.map((s) => (change?.limb === l.limb && change.section === s.section ? { section: s.section, joint: change.joint ?? '' } : s)),
  }));
  return JSON.stringify({ format: anatomy.format, version: anatomy.version, plan: change?.plan ?? anatomy.plan, limbs });
}

/** The service's report on a converted file, a sentence each. */
export interface ConversionReport {
  read: string[];
  guessed: string[];
  changed: string[];
  left_out: string[];
  /** Sentences about points that the user should check. */
  check: string[];
}

/** Poses of a motion for the preview: every `stride`-th frame. */
export interface MotionPreview {
  name: string;
  /** Frame rate of the motion, 1/s. */
  rate: number;
  /** Number of frames of the motion. */
  frames: number;
  /** Duration of the motion, s. */
  duration: number;
  stride: number;
  /** Number of frames in `poses`. */
  count: number;
  links: number;
  /** World poses [count][links][7]: x y z (m) qw qx qy qz, as base64 of 32-bit floats. */
  poses: string;
  mechanism?: string;
}

export interface MarkerPreview {
  labels: string[];
  count: number;
  stride: number;
  /** Marker positions [count][markers][3], m, as base64 of 32-bit floats; NaN where a marker was not visible. */
  points: string;
  /** Pose of the markers' coordinate frame in the character's world: x y z (m) qw qx qy qz. Absent: identity. */
  pose?: number[];
}

/** A file that the service has read but not stored. */
export interface StagedFile {
  /** Id of the staged file, for further requests to the service. */
  stage: string;
  file: string;
  format: string;
  settings: ImportSettings;
  /** Settings that the user can correct; `travel` if a motion of the file is a walk in place. */
  can: { unit: boolean; axes: boolean; rate: boolean; travel?: boolean };
  entries: { kind: 'mechanism' | 'motion'; name: string; bytes: number }[];
  report: ConversionReport;
  /** Root joints of the characters in the file, if there are several. */
  characters?: string[];
  /** Names of the motions in the file, if there are several. */
  takes?: string[];
  anatomy?: Anatomy;
  mechanism?: MechanismData;
  /** The file is a mesh without a skeleton. */
  mesh?: { colors: string[] };
  motion?: MotionPreview;
  markers?: MarkerPreview;
}

export type ImportStatus = 'waiting' | 'reading' | 'ready' | 'storing' | 'stored' | 'refused' | 'cancelled';

export interface ImportItem {
  id: number;
  file: string;
  /** Size of the file, bytes. */
  size: number;
  status: ImportStatus;
  staged: StagedFile | null;
  /** Name for the entries; empty: keep the name from the file. */
  name: string;
  tags: string;
  /** Why the file, or its last correction, was refused. */
  problems: Problem[];
  /** The library entries that were created. */
  stored: { id: string; kind: string; name: string }[];
  /** True while the file is read again with other settings. */
  rereading: boolean;
  /** Where a mesh is added to the scenario as a prop when it is stored, m; absent: it is only stored. */
  prop_at?: { x: number; y: number };
}

export interface ImportState {
  open: boolean;
  items: ImportItem[];
  shown: number | null;
}

export interface ImportHost {
  fetch: (path: string, init?: RequestInit) => Promise<Response>;
  log: (level: 'info' | 'warning' | 'error', text: string) => void;
  /** Called when the entries of a file have been stored in the library. */
  stored: (item: ImportItem) => void;
}

const meshes = /\.(stl|obj|dae|ply)$/i;

/**
 * The files of a batch that others need (skeletons, textures, and beside a robot description its meshes). They never become entries.
 */
function companions_among(files: readonly File[]): File[] {
  const robot = files.some((f) => /\.(urdf|sdf|xml|xacro|osim)$/i.test(f.name));
  return files.filter((f) => /\.(asf|bin|png|jpe?g|ya?ml|mtl)$/i.test(f.name) || (robot && meshes.test(f.name)));
}

export class ImportQueue {
  readonly store: StoreApi<ImportState> = createStore<ImportState>(() => ({ open: false, items: [], shown: null }));
  private readonly files = new Map<number, File>();
  private readonly running = new Map<number, AbortController>();
  private readonly wanted = new Map<number, Partial<ImportSettings>>();
  private next_id = 1;
  private working = false;

  constructor(private readonly host: ImportHost) {}

  get state(): ImportState {
    return this.store.getState();
  }

  item(id: number | null): ImportItem | undefined {
    return this.state.items.find((i) => i.id === id);
  }

  /**
   * Adds files to the queue. Companions are sent first. The service refuses a file whose companions are missing.
   * @param prop_at place at which meshes are added to the scenario as props, m
   */
  async add(files: readonly File[], prop_at?: { x: number; y: number }): Promise<void> {
    if (files.length === 0) return;
    const companions = companions_among(files);
    const main = files.filter((f) => !companions.includes(f));
    if (!this.state.open) this.store.setState({ items: [], shown: null });
    const items = main.map((file): ImportItem => {
      const id = this.next_id++;
      this.files.set(id, file);
      return { id, file: file.name, size: file.size, status: 'waiting', staged: null, name: '', tags: '', problems: [], stored: [], rereading: false, ...(prop_at ? { prop_at } : {}) };
    });
    const all = [...this.state.items, ...items];
    this.store.setState({ open: true, items: all, shown: this.state.shown ?? all[0]?.id ?? null });
    for (const file of companions) {
      try {
        await this.send(`api/import/file?name=${encodeURIComponent(file.name)}`, file);
        if (main.length === 0) this.note_companion(file, []);
      } catch (error) {
        this.note_companion(file, problems_of(error as Error));
      }
    }
    await this.work();
  }

  /** Lists a companion (skeleton, mesh) that was added alone or that cannot be read. */
  private note_companion(file: File, problems: Problem[]): void {
    const id = this.next_id++;
    const shown = problems.length > 0 ? problems : [{ message: `${file.name} is kept for the files that need it.`, remedy: 'Add those files now: the AMC of an ASF, the .gltf of a .bin, the .obj of an .mtl.' }];
    const item: ImportItem = { id, file: file.name, size: file.size, status: 'refused', staged: null, name: '', tags: '', problems: shown, stored: [], rereading: false };
    this.store.setState({ items: [...this.state.items, item], shown: this.state.shown ?? id });
  }

  private async work(): Promise<void> {
    if (this.working) return;
    this.working = true;
    for (let item = this.state.items.find((i) => i.status === 'waiting'); item; item = this.state.items.find((i) => i.status === 'waiting')) {
      const file = this.files.get(item.id);
      if (!file) break;
      this.change(item.id, { status: 'reading' });
      await this.read(item.id, `api/import/stage?name=${encodeURIComponent(file.name)}`, file);
      this.files.delete(item.id);
    }
    this.working = false;
  }

  private async read(id: number, address: string, body: Blob | string): Promise<void> {
    const running = new AbortController();
    this.running.set(id, running);
    try {
      const staged = await this.send<StagedFile>(address, body, running.signal);
      if (running.signal.aborted || !this.item(id)) void this.drop_stage(staged.stage);
      else this.change(id, { status: 'ready', staged, problems: [], rereading: false });
    } catch (error) {
      if (running.signal.aborted) return;
      const before = this.item(id);
      const problems = problems_of(error as Error);
      // a failed correction leaves the previous stage in place
      this.change(id, { status: before?.staged ? 'ready' : 'refused', problems, rereading: false });
      for (const p of problems) this.host.log('error', [before?.file, p.location, p.message, p.remedy].filter(Boolean).join(' — '));
    } finally {
      this.running.delete(id);
    }
  }

  /** Reads the file again with corrected settings. Changes that arrive while it is read are merged into the next read. */
  async correct(id: number, change: Partial<ImportSettings>): Promise<void> {
    const item = this.item(id);
    if (!item?.staged || item.status !== 'ready') return;
    this.wanted.set(id, { ...this.wanted.get(id), ...change });
    if (item.rereading) return;
    this.change(id, { rereading: true });
    while (this.wanted.has(id)) {
      const now = this.item(id);
      if (!now?.staged) break;
      const s = { ...now.staged.settings, ...this.wanted.get(id) };
      this.wanted.delete(id);
      const p = new URLSearchParams({ up: s.up, forward: s.forward });
      if (now.staged.can.unit && s.unit > 0) p.set('unit', String(s.unit));
      if (now.staged.can.rate && s.rate > 0) p.set('rate', String(s.rate));
      if (s.mapping) p.set('mapping', s.mapping);
      if (s.character) p.set('character', s.character);
      if (s.take) p.set('take', s.take);
      if (s.travel) p.set('travel', '1');
      await this.read(id, `api/import/stage/${now.staged.stage}?${p.toString()}`, '');
    }
  }

  name(id: number, part: Partial<Pick<ImportItem, 'name' | 'tags'>>): void {
    this.change(id, part);
  }

  show(id: number): void {
    this.store.setState({ shown: id });
  }

  async store_one(id: number): Promise<void> {
    const item = this.item(id);
    if (!item?.staged || item.status !== 'ready' || item.rereading) return;
    this.change(id, { status: 'storing' });
    const p = new URLSearchParams();
    if (item.name.trim()) p.set('name', item.name.trim());
    if (item.tags.trim()) p.set('tags', item.tags);
    try {
      const answer = await this.send<{ entries: ImportItem['stored'] }>(`api/import/store/${item.staged.stage}?${p.toString()}`, '');
      this.change(id, { status: 'stored', stored: answer.entries });
      this.host.log('info', `Imported ${item.file}: ${answer.entries.map((e) => e.name).join(', ')}`);
      this.host.stored(this.item(id)!);
    } catch (error) {
      this.change(id, { status: 'ready', problems: problems_of(error as Error) });
    }
  }

  /** Stores all files that are ready; closes the queue if no other file is left. */
  async store_all(): Promise<void> {
    for (const item of this.state.items) if (item.status === 'ready') await this.store_one(item.id);
    if (this.state.items.every((i) => i.status === 'stored' || i.status === 'cancelled')) this.close();
  }

  /** Removes one file from the queue and drops its stage. A stored file stays. */
  cancel(id: number): void {
    this.running.get(id)?.abort();
    this.files.delete(id);
    const item = this.item(id);
    if (!item || item.status === 'stored') return;
    if (item.staged) void this.drop_stage(item.staged.stage);
    const left = this.state.items.filter((i) => i.id !== id);
    this.store.setState({ items: left, shown: this.state.shown === id ? (left.find((i) => i.status !== 'stored')?.id ?? left[0]?.id ?? null) : this.state.shown });
    if (left.length === 0) this.store.setState({ open: false });
  }

  /** Cancels all files that are not stored and closes the queue. */
  close(): void {
    for (const item of this.state.items) {
      this.running.get(item.id)?.abort();
      if (item.staged && item.status !== 'stored') void this.drop_stage(item.staged.stage);
    }
    this.files.clear();
    this.store.setState({ open: false, items: [], shown: null });
  }

  private async drop_stage(stage: string): Promise<void> {
    await this.send(`api/import/drop/${stage}`, '').catch(() => undefined); // on failure: the studio drops all stages when it ends
  }

  private change(id: number, part: Partial<ImportItem>): void {
    this.store.setState({ items: this.state.items.map((i) => (i.id === id ? { ...i, ...part } : i)) });
  }

  private async send<T>(path: string, body: Blob | string, signal?: AbortSignal): Promise<T> {
    let response: Response;
    try {
      response = await this.host.fetch(path, { method: 'POST', body, signal: signal ?? null });
    } catch (error) {
      if (signal?.aborted) throw error;
      throw new RequestError({ problems: [{ message: 'The studio does not answer.', remedy: 'Check that `ugoki studio` is running.' }] }, '');
    }
    const answer = (await response.json().catch(() => ({}))) as T & { error?: ServiceError };
    if (!response.ok) throw new RequestError(answer.error, `The studio answered ${response.status}.`);
    return answer;
  }
}

const problems_of = (error: Error): Problem[] => (error instanceof RequestError ? error.problems : [{ message: error.message }]);

/** Decodes base64 into 32-bit floats. */
export function unpack_floats(text: string): Float32Array {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  return new Float32Array(bytes.buffer);
}
