/** Edits that depend on the document: each begins after the effect of the one before is in the document. */
import type { StoreApi } from 'zustand/vanilla';
import type { StudioState } from './state';

const patience = 600; // ms, for the `document` event after the reply to a command

/**
 * Runs edits one after the other. A copy needs a free name and a free place; if a key is pressed again before the service has confirmed the
 * first copy, the second would otherwise get the same name and place.
 */
export class EditTurns {
  private last: Promise<void> = Promise.resolve();

  constructor(private readonly store: StoreApi<StudioState>) {}

  /**
   * @param edit reads the document and sends a command; its promise is fulfilled with true if the service accepted the command. It selects the result.
   * @return fulfilled when the edit has ended, also if it failed
   */
  run(edit: () => Promise<boolean> | undefined): Promise<void> {
    this.last = this.last.then(async () => {
      const { revision } = this.store.getState();
      const accepted = await Promise.resolve()
        .then(edit)
        .catch(() => false);
      if (accepted) await this.change_after(revision);
    });
    return this.last;
  }

  private change_after(revision: number): Promise<void> {
    if (this.store.getState().revision !== revision) return Promise.resolve();
    return new Promise((resolve) => {
      const done = (): void => {
        clearTimeout(timer);
        stop();
        resolve();
      };
      const timer = setTimeout(done, patience);
      const stop = this.store.subscribe((state) => state.revision !== revision && done());
    });
  }
}
