/** The motion desk of one page: the open menu and dialog, the running operations on motions, and foot contacts. Framework-free. */
import { createStore, type StoreApi } from 'zustand/vanilla';
import type { GaitMakeRequest, MotionRequest } from '../protocol';
import type { Clip } from '../document';
import type { Selection } from '../state';
import { find_operation, type Values } from './operations';

/** A span of time with a constant number of feet on the ground; `from` and `to` are seconds from the motion's first frame. */
export type Band = [from: number, to: number, feet: number];
/** Foot contacts of a motion. */
export interface Contacts {
  /** Names of the foot links. */
  feet: string[];
  /** True if the contacts are stored with the motion. */
  labelled: boolean;
  bands: Band[];
}

export interface ClipTarget {
  character: string;
  clip: string;
}

/** The second operand of an operation: another motion, or the target body (height in m). */
export type With = { motion: string } | { mechanism: string } | { height: number } | { sample: 'dog' | 'human' } | Record<string, never>;

export interface MotionTask {
  id: string;
  label: string;
  /** Start time, as returned by performance.now(), ms. */
  since: number;
}

export interface DeskState {
  /** The open menu of a clip and its position on the page, px. */
  menu: (ClipTarget & { x: number; y: number }) | null;
  /** The operation whose options dialog is open. */
  dialog: (ClipTarget & { operation: string }) | null;
  tasks: MotionTask[];
  /** Foot contacts by the motion's id; null while they are loaded, and if loading failed. */
  contacts: Record<string, Contacts | null>;
}

export interface DeskHost {
  request(request: MotionRequest | GaitMakeRequest | { op: 'motion.cancel'; task: string }): Promise<Record<string, unknown>>;
  fetch(path: string): Promise<Response>;
  fail(error: Error): void;
  /** Shows the result of an operation, a sentence for each line. */
  report(title: string, lines: string[]): void;
  /** Writes the report of an operation to the log only. */
  log_report(title: string, lines: string[]): void;
  select(selection: Selection): void;
  /** The clip as the document has it. */
  clip(target: ClipTarget): Clip | undefined;
  /** A correction has changed a clip. */
  /** @return whether the comparison of before and after is shown */
  corrected(target: ClipTarget, before: Clip, report: readonly string[]): Promise<boolean>;
}

export class MotionDesk {
  readonly store: StoreApi<DeskState> = createStore<DeskState>(() => ({ menu: null, dialog: null, tasks: [], contacts: {} }));
  private next = 1;
  private readonly page = Math.random().toString(36).slice(2, 8);

  constructor(private readonly host: DeskHost) {}

  get state(): DeskState {
    return this.store.getState();
  }

  /** Runs an operation on a clip and selects the resulting clip. @return false if it was cancelled or failed */
  async run(operation: string, { character, clip }: ClipTarget, options: Values = {}, other: With = {}): Promise<boolean> {
    const before = operation === 'correct' ? this.host.clip({ character, clip }) : undefined;
    return this.work(find_operation(operation)?.label ?? operation, (task) => ({ op: 'motion', task, character, clip, operation, options, ...other }), false, before);
  }

  /** Makes a gait for a new clip, or another gait for a clip, and selects the clip. @return false if it was cancelled or failed */
  async make_gait(request: Omit<GaitMakeRequest, 'op' | 'task'>): Promise<boolean> {
    return this.work(request.clip ? 'Change gait' : 'Make a gait', (task) => ({ op: 'gait', task, ...request }), true);
  }

  /** @param quiet a report without sentences is not shown  @param before the clip, if a correction changes it */
  private async work(label: string, to_request: (task: string) => MotionRequest | GaitMakeRequest, quiet = false, before?: Clip): Promise<boolean> {
    const id = `${this.page}-${this.next++}`;
    this.store.setState({ tasks: [...this.state.tasks, { id, label, since: performance.now() }] });
    try {
      const reply = await this.host.request(to_request(id));
      if (reply.cancelled === true) return false;
      if (typeof reply.character === 'string' && typeof reply.clip === 'string') this.host.select({ kind: 'clip', character: reply.character, clip: reply.clip });
      const report = Array.isArray(reply.report) ? reply.report.map(String) : [];
      const compared = before && reply.clip === before.id && typeof reply.character === 'string' && (await this.host.corrected({ character: reply.character, clip: before.id }, before, report));
      if (compared) this.host.log_report(label, report); // the comparison shows the same numbers
      else if (!quiet || report.length > 0) this.host.report(label, report);
      return true;
    } catch (error) {
      this.host.fail(error as Error);
      return false;
    } finally {
      this.store.setState({ tasks: this.state.tasks.filter((t) => t.id !== id) });
    }
  }

  cancel(task: string): void {
    this.host.request({ op: 'motion.cancel', task }).catch((error: Error) => this.host.fail(error));
  }

  open_menu(menu: NonNullable<DeskState['menu']>): void {
    this.store.setState({ menu });
  }
  open(operation: string, target: ClipTarget): void {
    this.store.setState({ dialog: { ...target, operation }, menu: null });
  }
  close(): void {
    this.store.setState({ menu: null, dialog: null });
  }

  /** Loads the foot contacts of a motion; only the first call for each motion sends a request. */
  async need_contacts(motion: string): Promise<void> {
    if (motion in this.state.contacts) return;
    this.keep_contacts(motion, null);
    try {
      const response = await this.host.fetch(`api/contacts/${encodeURIComponent(motion)}`);
      if (response.ok) this.keep_contacts(motion, (await response.json()) as Contacts);
    } catch {
      // a lost connection is already reported elsewhere; the clip is drawn without contact bands
    }
  }
  private keep_contacts(motion: string, contacts: Contacts | null): void {
    this.store.setState({ contacts: { ...this.state.contacts, [motion]: contacts } });
  }
}

/** A CSS gradient over the whole motion: the colour of a band shows the number of feet on the ground. @param duration of the motion, s */
export function band_gradient(bands: readonly Band[], duration: number): string {
  if (bands.length === 0 || !(duration > 0)) return 'none';
  const share = (t: number): string => `${((100 * Math.min(t, duration)) / duration).toFixed(3)}%`;
  const colour = (feet: number): string => (feet >= 2 ? 'var(--good)' : feet === 1 ? 'var(--one)' : 'var(--flight)');
  return `linear-gradient(to right, ${bands.map(([from, to, feet]) => `${colour(feet)} ${share(from)} ${share(to)}`).join(', ')})`;
}
