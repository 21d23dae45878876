import { describe, expect, it } from 'vitest';
import { is_pull, keep_pull } from '../src/core/pulls';
import type { PulledEvent } from '../src/core/protocol';
import type { Session } from '../src/core/session';

const pulled: PulledEvent = { character: 'a', link: 1, point: [0, 0, 0.1], time: 0.4, duration: 0.3, path: [[0, 1, 2, 3], [0.1, 2, 2, 3]] };

function make(known: boolean, accepted = true): { session: Session; sent: unknown[]; left: () => PulledEvent | null } {
  const sent: unknown[] = [];
  const state = { pulled: pulled as PulledEvent | null, document: { characters: [{ id: 'a', mechanism: 'm' }] }, mechanisms: known ? { m: { links: [{ name: 'root' }, { name: 'hand' }] } } : {} };
  const session = {
    state,
    set: (change: Partial<typeof state>) => Object.assign(state, change),
    fresh_id: () => 'e7',
    ask: (request: unknown) => (sent.push(request), Promise.reject(new Error('restarted'))),
    edit: (command: unknown) => (sent.push(command), Promise.resolve(accepted)),
  };
  return { session: session as unknown as Session, sent, left: () => state.pulled };
}

describe('a pull of the user', () => {
  it('becomes an event, after it was removed from the inputs', async () => {
    const { session, sent, left } = make(true);
    expect(await keep_pull(session)).toBe('e7');
    const { link: _link, ...same } = pulled;
    expect(sent).toEqual([{ op: 'forget_pull', time: 0.4 }, { type: 'event.add', event: { id: 'e7', type: 'pull', link: 'hand', ...same } }]);
    expect(left()).toBeNull();
    expect(await keep_pull(session)).toBeNull(); // there is none any more
  });

  it('stays an offer while the mechanism is not loaded, and reports a refusal', async () => {
    const unknown = make(false);
    expect(await keep_pull(unknown.session)).toBeNull();
    expect(unknown.left()).not.toBeNull();
    expect(await keep_pull(make(true, false).session)).toBeNull();
  });

  it('is longer than a click', () => {
    expect(is_pull(pulled)).toBe(true);
    expect(is_pull({ ...pulled, duration: 0.01 })).toBe(false);
  });
});
