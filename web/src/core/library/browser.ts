/** The library browser: search while typing, further pages on scrolling, edits with undo, and save conflicts. Framework-free. */
import { createStore, type StoreApi } from 'zustand/vanilla';
import { RequestError, type LibraryEntry, type ServiceError } from '../protocol';
import { from_service, key_of, tags_of } from './words';

export type KindFilter = 'all' | 'mechanism' | 'motion';
export type LibraryOrder = 'relevance' | 'name' | 'newest' | 'oldest' | 'longest' | 'shortest';

export interface TagCount {
  name: string;
  count: number;
}

export interface EntryVersion {
  version: number;
  content: string;
  name: string;
  note?: string;
  by?: string;
  when?: string;
  size?: number;
}

/** A conflict: another user saved an entry while this page was changing it. */
export interface Conflict {
  /** The change of this page as text: "the name “walk slow”". */
  mine: string;
  /** The entry as the other user saved it. */
  theirs: LibraryEntry;
  /** Saves this page's change as a new version; the other user's version stays in the history. */
  keep_mine: () => Promise<void>;
}

/** An edit that can be undone. */
export interface Done {
  label: string;
  undo: () => Promise<void>;
}

export interface BrowserState {
  query: string;
  kind: KindFilter;
  tags: string[];
  order: LibraryOrder | null;
  /** True: the browser shows the trash instead of the library. */
  trash: boolean;
  entries: LibraryEntry[];
  /** Number of entries that match the query. */
  total: number;
  /** False if `total` is a lower bound. */
  total_exact: boolean;
  /** True if the service has more entries than `entries`. */
  more: boolean;
  status: 'loading' | 'ready' | 'failed';
  failure: string;
  /** The library's server does not respond; the entries that were loaded before are still shown. */
  away: boolean;
  all_tags: TagCount[];
  conflict: Conflict | null;
  /** The latest edit that can be undone, for display. */
  done: Done | null;
}

const initial: BrowserState = {
  query: '', kind: 'all', tags: [], order: null, trash: false, entries: [], total: 0, total_exact: true, more: false, status: 'loading', failure: '', away: false, all_tags: [], conflict: null,
  done: null,
};

export interface BrowserHost {
  fetch: (path: string, init?: RequestInit) => Promise<Response>;
  /** Stores entries from replies, so that names of motions and mechanisms can be looked up. */
  cache_entries: (entries: readonly LibraryEntry[]) => void;
  fail: (error: Error) => void;
}

const page_size = 100;
const undo_depth = 50;

interface Page {
  entries: LibraryEntry[];
  next?: string | null;
  total?: number;
  total_exact?: boolean;
}

export class LibraryBrowser {
  readonly store: StoreApi<BrowserState> = createStore<BrowserState>(() => initial);
  private next: string | null = null;
  private running: AbortController | null = null;
  private loading_more = false;
  private timer: ReturnType<typeof setTimeout> | null = null;
  private undo_stack: Done[] = [];

  constructor(private readonly host: BrowserHost) {}

  get state(): BrowserState {
    return this.store.getState();
  }

  // ---- finding ----

  /** Searches 90 ms after the last change of the query, so that fast typing causes one request. */
  search(query: string): void {
    this.store.setState({ query });
    if (this.timer) clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.load(), 90);
  }

  filter(part: Partial<Pick<BrowserState, 'kind' | 'tags' | 'order' | 'trash'>>): void {
    this.store.setState(part);
    void this.load();
  }

  toggle_tag(tag: string): void {
    const { tags } = this.state;
    this.filter({ tags: tags.includes(tag) ? tags.filter((t) => t !== tag) : [...tags, tag] });
  }

  /** Reloads the list from the start, with as many entries as are shown. The old list stays until the reply arrives. */
  async load(): Promise<void> {
    this.running?.abort();
    const running = new AbortController();
    this.running = running;
    const keep = Math.min(500, Math.max(page_size, this.state.entries.length));
    try {
      const page = await this.ask<Page>(this.address('', keep), { signal: running.signal });
      if (this.running !== running) return;
      const entries = page.entries.map(from_service);
      this.next = page.next ?? null;
      this.host.cache_entries(entries);
      this.store.setState({ entries, total: page.total ?? entries.length, total_exact: page.total_exact ?? true, more: this.next !== null, status: 'ready', failure: '', away: false });
    } catch (error) {
      if (running.signal.aborted) return;
      const away = error instanceof RequestError && error.status === 503;
      const failure = error instanceof RequestError ? error.problems.map((p) => [p.message, p.remedy].filter(Boolean).join(' ')).join(' ') : (error as Error).message;
      this.store.setState({ status: 'failed', failure, away });
      if (away) return; // the request for the list of tags would also wait for the library
    }
    void this.load_tags();
  }

  /** Loads the next page; does nothing if all entries are loaded or a page is being loaded. */
  async load_more(): Promise<void> {
    if (this.next === null || this.loading_more) return;
    this.loading_more = true;
    const before = this.running;
    try {
      const page = await this.ask<Page>(this.address(this.next, page_size));
      if (this.running !== before) return; // another search has started in the meantime: ignore this page
      const known = new Set(this.state.entries.map(key_of));
      const entries = page.entries.map(from_service).filter((e) => !known.has(key_of(e)));
      this.next = page.next ?? null;
      this.host.cache_entries(entries);
      this.store.setState({ entries: [...this.state.entries, ...entries], more: this.next !== null });
    } catch (error) {
      this.next = null;
      this.store.setState({ more: false });
      this.host.fail(error as Error);
    } finally {
      this.loading_more = false;
    }
  }

  private address(after: string, limit: number): string {
    const { query, kind, tags, order, trash } = this.state;
    const p = new URLSearchParams();
    if (query.trim()) p.set('q', query.trim());
    if (kind !== 'all') p.set('kind', kind);
    for (const tag of tags) p.append('tag', tag);
    if (order) p.set('order', order);
    if (trash) p.set('removed', '1');
    if (after) p.set('after', after);
    p.set('limit', String(limit));
    return `api/library?${p.toString()}`;
  }

  private async load_tags(): Promise<void> {
    const { kind } = this.state;
    try {
      const answer = await this.ask<{ tags: TagCount[] }>(`api/library/tags${kind === 'all' ? '' : `?kind=${kind}`}`);
      this.store.setState({ all_tags: answer.tags });
    } catch {
      // the list of tags is optional; load() reports connection problems
    }
  }

  async versions(entry: LibraryEntry): Promise<EntryVersion[]> {
    if (!entry.entry) return [];
    return (await this.ask<{ versions?: EntryVersion[] }>(`api/entry/${encodeURIComponent(entry.entry)}`)).versions ?? [];
  }

  /** Fetches an entry that is not in the loaded list, by entry id or data id; null if there is none. */
  async find(id: string): Promise<LibraryEntry | null> {
    try {
      const entry = from_service(await this.ask<LibraryEntry>(`api/entry/${encodeURIComponent(id)}`));
      this.host.cache_entries([{ ...entry, id }]);
      return entry;
    } catch {
      return null;
    }
  }

  // ---- editing: every edit can be undone ----

  async rename(entry: LibraryEntry, name: string): Promise<void> {
    const wanted = name.trim();
    if (!wanted || wanted === entry.name) return;
    const changed = await this.save(entry, { name: wanted }, `the name “${wanted}”`);
    if (changed) this.push_undo(`Renamed “${entry.name}” to “${wanted}”`, async () => void (await this.save(changed, { name: entry.name }, `the name “${entry.name}”`)));
  }

  async set_note(entry: LibraryEntry, note: string): Promise<void> {
    const before = entry.note ?? '';
    if (note === before) return;
    const changed = await this.save(entry, { note }, 'another note');
    if (changed) this.push_undo(`Changed the note of “${entry.name}”`, async () => void (await this.save(changed, { note: before }, 'the old note')));
  }

  async change_tags(entry: LibraryEntry, add: string[], remove: string[]): Promise<void> {
    const has = new Set(tags_of(entry));
    const really_add = add.filter((t) => !has.has(t));
    const really_remove = remove.filter((t) => has.has(t));
    if (really_add.length + really_remove.length === 0) return;
    const words = [really_add.length > 0 && `Tagged “${entry.name}” with ${really_add.join(', ')}`, really_remove.length > 0 && `Removed tag ${really_remove.join(', ')} from “${entry.name}”`];
    const changed = await this.save(entry, { add_tags: really_add, remove_tags: really_remove }, `the tags ${[...really_add].join(', ')}`);
    if (changed) this.push_undo(words.filter(Boolean).join('; '), async () => void (await this.save(changed, { add_tags: really_remove, remove_tags: really_add }, 'the old tags')));
  }

  async duplicate(entry: LibraryEntry): Promise<LibraryEntry | null> {
    const made = await this.post(entry, 'duplicate', { name: `${entry.name} copy` });
    if (!made) return null;
    this.push_undo(`Duplicated “${entry.name}”`, async () => void (await this.post(made, 'remove', {})));
    return made;
  }

  async remove(entry: LibraryEntry): Promise<boolean> {
    const gone = await this.post(entry, 'remove', {}, entry);
    if (!gone) return false;
    this.push_undo(`Deleted “${entry.name}”`, async () => void (await this.post(entry, 'undelete', {}, entry)));
    return true;
  }

  async undelete(entry: LibraryEntry): Promise<void> {
    if (await this.post(entry, 'undelete', {}, entry)) this.push_undo(`Restored “${entry.name}” from the trash`, async () => void (await this.post(entry, 'remove', {}, entry)));
  }

  async restore(entry: LibraryEntry, version: number): Promise<void> {
    const before = entry.version ?? 1;
    const changed = await this.post(entry, 'restore', { base: before, version });
    if (changed) this.push_undo(`Restored version ${version} of “${entry.name}”`, async () => void (await this.post(changed, 'restore', { base: changed.version, version: before })));
  }

  async undo(): Promise<void> {
    const last = this.undo_stack.pop();
    if (!last) return;
    this.store.setState({ done: this.undo_stack[this.undo_stack.length - 1] ?? null });
    const kept = this.undo_stack;
    this.undo_stack = []; // so that an undo is not itself recorded as an edit
    await last.undo();
    this.undo_stack = kept;
    this.store.setState({ done: kept[kept.length - 1] ?? null });
  }

  /** Hides the line that shows the latest edit. From then on the undo key undoes edits of the scenario instead. */
  forget_done(): void {
    this.store.setState({ done: null });
  }

  answer_conflict(keep_mine: boolean): void {
    const { conflict } = this.state;
    this.store.setState({ conflict: null });
    if (keep_mine && conflict) void conflict.keep_mine();
    else void this.load();
  }

  private push_undo(label: string, undo: () => Promise<void>): void {
    const done = { label, undo };
    this.undo_stack = [...this.undo_stack.slice(-undo_depth + 1), done];
    this.store.setState({ done });
  }

  /** Saves changed fields, based on this page's version. Null: the save was refused, or a conflict waits for the user's answer. */
  private async save(entry: LibraryEntry, fields: Record<string, unknown>, mine: string): Promise<LibraryEntry | null> {
    return this.post(entry, '', { base: entry.version ?? 1, ...fields }, undefined, mine, fields);
  }

  private async post(entry: LibraryEntry, action: string, body: object, without_answer?: LibraryEntry, mine = 'your change', fields?: Record<string, unknown>): Promise<LibraryEntry | null> {
    if (!entry.entry) {
      this.host.fail(new Error(`“${entry.name}” is in the open project only, not in the library.`));
      return null;
    }
    const address = `api/entry/${encodeURIComponent(entry.entry)}${action ? `/${action}` : ''}`;
    try {
      const response = await this.host.fetch(address, { method: 'POST', body: JSON.stringify(body) });
      const answer = (await response.json()) as { entry?: LibraryEntry; error?: ServiceError };
      if (response.status === 409 && answer.entry) {
        const theirs = from_service(answer.entry);
        const repeated = { ...body, ...(fields ?? {}), base: theirs.version };
        this.store.setState({ conflict: { mine, theirs, keep_mine: async () => void (await this.post(theirs, action, repeated, without_answer, mine, fields)) } });
        void this.load();
        return null;
      }
      if (!response.ok) throw new RequestError(answer.error, `The studio answered ${response.status}.`);
      const changed = answer.entry ? from_service(answer.entry) : (without_answer ?? null);
      if (changed) this.host.cache_entries([changed]);
      await this.load();
      return changed;
    } catch (error) {
      this.host.fail(error as Error);
      return null;
    }
  }

  private async ask<T>(path: string, init?: RequestInit): Promise<T> {
    const response = await this.host.fetch(path, init);
    const body = (await response.json()) as T & { error?: ServiceError };
    if (!response.ok) throw new RequestError(body.error, `The studio answered ${response.status}.`, response.status);
    return body;
  }
}
