/** Play controls over the viewport: the input devices that the content reads, and the buttons that start and stop sending their input. */
import { useEffect, type ReactElement, type RefObject } from 'react';
import { describe_devices, name_key, reads_anything } from '../core/play_controls';
import { run } from './actions';
import { session, useControls } from './app';

export function PlayControlsBar({ host }: { host: RefObject<HTMLDivElement | null> }): ReactElement | null {
  const on = useControls((s) => s.on);
  const devices = useControls((s) => s.devices);
  const held = useControls((s) => s.held);
  useEffect(() => (on && host.current ? take_input(host.current) : undefined), [on, host]);
  if (!reads_anything(devices)) return null;
  if (!on) {
    return (
      <button type="button" className="controls-bar" title="Send keys, mouse and gamepad to the content until Esc is pressed  (Shift Space)" onClick={() => run('play.controls')}>
        Play controls <span className="facts">{describe_devices(devices)}</span>
      </button>
    );
  }
  return (
    <div className="controls-bar on" role="status">
      <strong>Input goes to the content</strong>
      {devices.keyboard.length > 0 && (
        <span className="held-keys" aria-hidden="true">
          {devices.keyboard.slice(0, 12).map((code) => (
            <kbd key={code} data-held={held.includes(code)}>{name_key(code)}</kbd>
          ))}
        </span>
      )}
      <span className="facts">{describe_devices({ ...devices, keyboard: [] })}</span>
      <button type="button" onClick={() => session.controls.leave()}>
        Leave (Esc)
      </button>
    </div>
  );
}

/** Sends keys, the pointer over `host` and gamepads to the content. @return function that stops sending */
function take_input(host: HTMLElement): () => void {
  const { controls } = session;
  const stop = new AbortController();
  const listen = { capture: true, signal: stop.signal };
  const key = (event: KeyboardEvent): void => {
    // Ctrl and Cmd shortcuts stay with the browser and the page, unless the content reads these keys; releases are always sent
    const page_shortcut = (event.ctrlKey || event.metaKey) && !controls.devices.keyboard.some((code) => /^(Control|Meta)/.test(code));
    if (page_shortcut && event.type === 'keydown') return;
    event.preventDefault();
    event.stopPropagation();
    if (event.key === 'Escape') {
      if (event.type === 'keydown') controls.leave();
    } else controls.key(event.code, event.type === 'keydown');
  };
  window.addEventListener('keydown', key, listen);
  window.addEventListener('keyup', key, listen);
  // the page gets no keyup event while it has no focus: release all keys
  window.addEventListener('blur', () => controls.release(), { signal: stop.signal });
  document.addEventListener('visibilitychange', () => document.hidden && controls.release(), { signal: stop.signal });
  // a press in another panel gives the keyboard back to the page
  window.addEventListener('pointerdown', (event) => host.contains(event.target as Node) || controls.leave(), listen);

  const pointer = (event: PointerEvent): void => {
    if (!controls.devices.mouse || (event.target as Element).closest('button')) return;
    const box = host.getBoundingClientRect();
    controls.pointer((event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height, event.buttons);
    event.stopPropagation();
    if (event.type === 'pointerdown') {
      event.preventDefault();
      host.setPointerCapture(event.pointerId);
    }
  };
  for (const type of ['pointerdown', 'pointermove', 'pointerup', 'pointercancel'] as const) host.addEventListener(type, pointer, listen);
  host.addEventListener(
    'wheel',
    (event) => {
      if (!controls.devices.mouse) return;
      event.preventDefault();
      event.stopPropagation();
      controls.wheel(event.deltaY, event.deltaMode);
    },
    { ...listen, passive: false },
  );
  host.addEventListener('contextmenu', (event) => controls.devices.mouse && event.preventDefault(), listen);

  let handle = requestAnimationFrame(function poll() {
    if (controls.devices.gamepads.length > 0) controls.gamepads(navigator.getGamepads());
    handle = requestAnimationFrame(poll);
  });
  return () => {
    stop.abort();
    cancelAnimationFrame(handle);
  };
}
