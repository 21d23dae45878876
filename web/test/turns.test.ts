import { describe, expect, it, vi } from 'vitest';
import { createStore, type StoreApi } from 'zustand/vanilla';
import { initial_state, type StudioState } from '../src/core/state';
import { EditTurns } from '../src/core/turns';

const make = (): { store: StoreApi<StudioState>; turns: EditTurns; seen: number[] } => {
  const store = createStore<StudioState>(() => ({ ...initial_state, revision: 1 }));
  return { store, turns: new EditTurns(store), seen: [] };
};

describe('edits in turn', () => {
  it('begins an edit only after the revision of the one before', async () => {
    const { store, turns, seen } = make();
    const edit = (): Promise<boolean> => {
      seen.push(store.getState().revision);
      return Promise.resolve(true);
    };
    void turns.run(edit);
    const second = turns.run(edit);
    await new Promise((resolve) => setTimeout(resolve, 20));
    expect(seen).toEqual([1]); // accepted, but not yet in the document
    store.setState({ revision: 2 });
    await new Promise((resolve) => setTimeout(resolve, 20));
    expect(seen).toEqual([1, 2]);
    store.setState({ revision: 3 });
    await second;
  });

  it('goes on after a refused, a failed and an empty edit', async () => {
    const { turns } = make();
    void turns.run(() => Promise.resolve(false));
    void turns.run(() => Promise.reject(new Error('lost')));
    void turns.run(() => undefined);
    const last = vi.fn(() => Promise.resolve(false));
    await turns.run(last);
    expect(last).toHaveBeenCalledOnce();
  });
});
