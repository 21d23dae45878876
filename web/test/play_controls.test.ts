import { describe, expect, it } from 'vitest';
import { describe_devices, min_ms, name_key, PlayControls, read_devices, type InputMessage } from '../src/core/play_controls';

function make() {
  const sent: { at: number; message: InputMessage }[] = [];
  let now = 0;
  const tasks: { at: number; run: () => void }[] = [];
  const controls = new PlayControls((message) => sent.push({ at: now, message: structuredClone(message) }), { now: () => now, later: (run, ms) => tasks.push({ at: now + ms, run }) });
  const pass = (ms: number): void => {
    const end = now + ms;
    for (;;) {
      tasks.sort((a, b) => a.at - b.at);
      if (tasks.length === 0 || tasks[0]!.at > end) break;
      const task = tasks.shift()!;
      now = Math.max(now, task.at);
      task.run();
    }
    now = end;
  };
  return { controls, sent, pass };
}

describe('play controls', () => {
  it('sends the keys that the content reads, only on change', () => {
    const { controls, sent, pass } = make();
    controls.set_devices({ keyboard: ['KeyW', 'KeyS'], mouse: false, gamepads: [] });
    controls.key('KeyW', true);
    expect(sent).toEqual([]); // the controls are still off
    controls.key('KeyW', false);
    controls.enter();
    pass(100);
    expect(sent.map((s) => s.message)).toEqual([{ keyboard: [] }]);
    controls.key('KeyW', true);
    controls.key('KeyW', true); // key repeat
    controls.key('KeyQ', true); // the content does not read this key
    pass(100);
    controls.key('KeyW', false);
    pass(100);
    expect(sent.slice(1).map((s) => s.message)).toEqual([{ keyboard: ['KeyW'] }, { keyboard: [] }]);
  });

  it('sends the press and the release of a tap that is shorter than the time between two messages', () => {
    const { controls, sent, pass } = make();
    controls.set_devices({ keyboard: ['KeyW', 'KeyS'], mouse: false, gamepads: [] });
    controls.enter();
    pass(100);
    controls.key('KeyS', true);
    pass(2);
    controls.key('KeyW', true);
    pass(2);
    controls.key('KeyW', false);
    pass(100);
    expect(sent.slice(1).map((s) => s.message)).toEqual([{ keyboard: ['KeyS'] }, { keyboard: ['KeyW', 'KeyS'] }, { keyboard: ['KeyS'] }]);
  });

  it('sends the newest state at most sixty times a second', () => {
    const { controls, sent, pass } = make();
    controls.set_devices({ keyboard: [], mouse: true, gamepads: [] });
    controls.enter();
    for (let i = 1; i <= 1000; i++) {
      controls.pointer(i / 1000, 0.5, i % 2);
      pass(1);
    }
    pass(100);
    expect(sent.length).toBeLessThanOrEqual(61);
    expect(sent.length).toBeGreaterThan(50);
    for (let i = 1; i < sent.length; i++) expect(sent[i]!.at - sent[i - 1]!.at).toBeGreaterThanOrEqual(min_ms - 1e-9);
    expect(sent.at(-1)!.message.mouse).toMatchObject({ x: 1, left: false });
  });

  it('sums wheel notches between messages and sends them once', () => {
    const { controls, sent, pass } = make();
    controls.set_devices({ keyboard: [], mouse: true, gamepads: [] });
    controls.enter();
    pass(100);
    sent.length = 0;
    controls.wheel(100, 0);
    controls.wheel(100, 0);
    controls.wheel(-300, 0);
    pass(100);
    expect(sent.map((s) => s.message.mouse!.wheel).reduce((a, b) => a + b, 0)).toBe(-1);
    sent.length = 0;
    controls.pointer(0.2, 0.2, 0);
    pass(100);
    expect(sent[0]!.message.mouse!.wheel).toBe(0);
  });

  it('releases all devices when it is turned off, and when the window loses the focus', () => {
    const { controls, sent, pass } = make();
    controls.set_devices({ keyboard: ['Space'], mouse: true, gamepads: [1] });
    controls.enter();
    controls.key('Space', true);
    controls.pointer(0.1, 0.1, 3);
    controls.gamepads([{ axes: [1], buttons: [{ value: 1 }] }, { axes: [0.5, -0.25], buttons: [{ value: 1 }] }]);
    pass(100);
    expect(sent.at(-1)!.message.gamepads).toEqual([null, { axes: [0.5, -0.25], buttons: [1] }]);
    controls.release();
    pass(100);
    expect(sent.at(-1)!.message).toMatchObject({ keyboard: [], mouse: { left: false, right: false }, gamepads: [null, { axes: [0, 0], buttons: [0] }] });
    const before = sent.length;
    controls.key('Space', true);
    controls.leave();
    expect(sent.at(-1)!.message.keyboard).toEqual([]);
    controls.key('Space', true);
    pass(100);
    expect(sent.length).toBeLessThanOrEqual(before + 2);
    expect(controls.on).toBe(false);
  });

  it('stays off, or turns off, if the content reads no device', () => {
    const { controls } = make();
    controls.enter();
    expect(controls.on).toBe(false);
    controls.set_devices({ keyboard: ['KeyA'], mouse: false, gamepads: [] });
    controls.enter();
    expect(controls.on).toBe(true);
    controls.set_devices({ keyboard: [], mouse: false, gamepads: [] });
    expect(controls.on).toBe(false);
  });

  it('names keys and devices, and ignores invalid device lists', () => {
    expect(['KeyW', 'Digit5', 'ArrowUp', 'Space', 'ShiftLeft', 'F1'].map(name_key)).toEqual(['W', '5', '↑', 'Space', 'Shift', 'F1']);
    expect(describe_devices({ keyboard: ['KeyW', 'KeyA'], mouse: true, gamepads: [0] })).toBe('W  A · mouse · gamepad');
    expect(read_devices(null)).toEqual({ keyboard: [], mouse: false, gamepads: [] });
    expect(read_devices({ keyboard: ['KeyW', 3], mouse: 1, gamepads: [0, 9, 'x'] })).toEqual({ keyboard: ['KeyW'], mouse: false, gamepads: [0] });
  });
});
