import { describe, expect, it } from 'vitest';
import { band_gradient, MotionDesk } from '../src/core/motion/desk';
import { asks, find_operation, first_values, operations, options_of, refusal } from '../src/core/motion/operations';
import type { MotionRequest } from '../src/core/protocol';
import { sample_document } from './sample';

function make(answer: (request: MotionRequest | { op: 'motion.cancel'; task: string }) => Promise<Record<string, unknown>>) {
  const reported: string[] = [];
  const selected: unknown[] = [];
  let fetches = 0;
  const desk = new MotionDesk({
    request: answer,
    fetch: () => {
      fetches++;
      return Promise.resolve(new Response(JSON.stringify({ feet: ['foot'], labelled: true, bands: [[0, 1, 1]] })));
    },
    fail: (error) => reported.push(`failed: ${error.message}`),
    report: (title, lines) => reported.push([title, ...lines].join(' | ')),
    clip: () => undefined,
    log_report: () => undefined,
    corrected: () => Promise.resolve(false),
    select: (selection) => selected.push(selection),
  });
  return { desk, reported, selected, fetches: () => fetches };
}

describe('operations on motions', () => {
  it('have unique ids, a hint sentence and defined options', () => {
    expect(new Set(operations.map((o) => o.id)).size).toBe(operations.length);
    for (const o of operations) {
      expect(o.hint.endsWith('.')).toBe(true);
      expect(Object.values(options_of(o, first_values(o))).every((v) => v !== undefined)).toBe(true);
    }
  });

  it('convert field values to the options of the request', () => {
    const of = (id: string, values = {}): object => {
      const o = find_operation(id)!;
      return options_of(o, { ...first_values(o), ...values });
    };
    expect(of('warp', { begin: 50, end: 200 })).toEqual({ speeds: [50, 100, 200] });
    expect(of('scale', { way: 120 })).toEqual({ way: 1.2, time: 1 });
    expect(of('reduce')).toEqual({ degrees: 0.25, metres: 0.001 });
    expect(of('path', { shape: 'turn' })).toEqual({ shape: 'turn', turn: 90 });
    expect(of('path', { shape: 'to' })).toEqual({ shape: 'to', forward: 2, left: 0 });
    expect(of('path', { shape: 'straight' })).toEqual({ shape: 'straight' });
  });

  it('ask for input only if needed, and give the reason of a refusal', () => {
    expect(operations.filter((o) => !asks(o)).map((o) => o.id)).toEqual(['trim', 'join', 'reverse', 'mirror']);
    const doc = sample_document();
    const character = doc.characters.find((c) => c.track.length > 0)!;
    const last = [...character.track].sort((a, b) => b.start - a.start)[0]!;
    expect(refusal(find_operation('join')!, doc, character.id, last)).toMatch(/last clip of its track/);
    expect(refusal(find_operation('mirror')!, doc, character.id, last)).toBeNull();
  });
});

describe('MotionDesk', () => {
  const target = { character: 'human', clip: 'k1' };

  it('runs an operation, reports what was done and selects the result', async () => {
    const asked: object[] = [];
    const { desk, reported, selected } = make((request) => {
      asked.push(request);
      expect(desk.state.tasks.length).toBe(1);
      return Promise.resolve({ character: 'c2', clip: 'k2', report: ['One.', 'Two.'] });
    });
    expect(await desk.run('retarget', target, { balance: true }, { height: 1.1 })).toBe(true);
    expect(asked[0]).toMatchObject({ op: 'motion', ...target, operation: 'retarget', options: { balance: true }, height: 1.1 });
    expect(reported).toEqual(['For another body | One. | Two.']);
    expect(selected).toEqual([{ kind: 'clip', character: 'c2', clip: 'k2' }]);
    expect(desk.state.tasks).toEqual([]);
  });

  it('reports a failure but not a cancellation', async () => {
    const cancelled = make(() => Promise.resolve({ cancelled: true }));
    expect(await cancelled.desk.run('mirror', target)).toBe(false);
    expect(cancelled.reported).toEqual([]);
    const failing = make(() => Promise.reject(new Error('no feet')));
    expect(await failing.desk.run('lock', target)).toBe(false);
    expect(failing.reported).toEqual(['failed: no feet']);
    expect(failing.desk.state.tasks).toEqual([]);
  });

  it('gives every task a new id, and cancels by id', async () => {
    const tasks: string[] = [];
    const { desk } = make((request) => {
      tasks.push(request.task);
      return Promise.resolve({});
    });
    await desk.run('mirror', target);
    await desk.run('mirror', target);
    desk.cancel('x-1');
    expect(new Set(tasks).size).toBe(3);
    expect(tasks[2]).toBe('x-1');
  });

  it('loads the contacts of a motion once', async () => {
    const { desk, fetches } = make(() => Promise.resolve({}));
    await Promise.all([desk.need_contacts('n-1'), desk.need_contacts('n-1')]);
    await desk.need_contacts('n-1');
    expect(fetches()).toBe(1);
    expect(desk.state.contacts['n-1']?.bands).toEqual([[0, 1, 1]]);
  });

  it('draws contact bands over the whole motion', () => {
    expect(band_gradient([], 1)).toBe('none');
    expect(band_gradient([[0, 0.5, 2], [0.5, 1, 0], [1, 2, 1]], 2)).toBe(
      'linear-gradient(to right, var(--good) 0.000% 25.000%, var(--flight) 25.000% 50.000%, var(--one) 50.000% 100.000%)',
    );
  });
});
