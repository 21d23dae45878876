import { useEffect, useRef, type ReactElement } from 'react';
import { format_factor, format_time } from '../core/format';
import { show_key } from '../core/keymap';
import { registry, session, useStudio } from './app';
import { run } from './actions';
import { ExportMenu } from './ExportMenu';
import { ProjectMenu } from './files';
import { Icon, type IconName } from './icons';

function CommandButton({ id, icon, title, accent, pressed }: { id: string; icon: IconName; title?: string; accent?: boolean; pressed?: boolean }): ReactElement {
  const command = registry.get(id);
  const keymap = useStudio((s) => s.keymap);
  useStudio((s) => s.revision + Number(s.can_undo) + 2 * Number(s.can_redo) + Number(s.document !== null));
  const key = command && registry.keys_of(command, keymap)[0];
  const label = title ?? command?.label ?? '';
  return (
    <button
      type="button"
      className={accent ? 'tool accent' : 'tool'}
      disabled={command?.enabled?.() === false}
      aria-label={label}
      aria-pressed={pressed}
      data-command={id}
      title={key ? `${label}  (${show_key(key)})` : label}
      onClick={() => run(id)}
    >
      <Icon name={icon} />
    </button>
  );
}

/** Time and frame number of the playhead, written to the DOM at each animation frame, without rendering in React. */
function Clock(): ReactElement {
  const time = useRef<HTMLSpanElement>(null);
  const frame = useRef<HTMLSpanElement>(null);
  const rate = useStudio((s) => s.document?.frame_rate ?? 60);
  useEffect(() => {
    let shown = NaN;
    let handle = 0;
    const tick = (): void => {
      handle = requestAnimationFrame(tick);
      const now = session.now;
      if (now === shown) return;
      shown = now;
      if (time.current) time.current.textContent = format_time(now);
      if (frame.current) frame.current.textContent = `f ${Math.round(now * rate)}`;
    };
    tick();
    return () => cancelAnimationFrame(handle);
  }, [rate]);
  return (
    <div className="clock" role="timer" aria-label="Time and frame">
      <span ref={time} className="time">00:00.00</span>
      <span ref={frame} className="frame">f 0</span>
    </div>
  );
}

const speeds = [0.1, 0.25, 0.5, 1, 1.5, 2, 4];

export function TopBar(): ReactElement {
  const transport = useStudio((s) => s.transport);
  const undo_label = useStudio((s) => s.undo_label);
  const redo_label = useStudio((s) => s.redo_label);
  const step = useStudio((s) => s.document?.step);
  const ready = useStudio((s) => s.document !== null);
  const simulate = transport.mode === 'simulate';
  return (
    <header className="topbar">
      <div className="bar-left">
        <span className="brand">Ugoki</span>
        <ProjectMenu />
        <div className="tools">
          <CommandButton id="edit.undo" icon="undo" title={undo_label ? `Undo: ${undo_label}` : 'Undo'} />
          <CommandButton id="edit.redo" icon="redo" title={redo_label ? `Redo: ${redo_label}` : 'Redo'} />
          <CommandButton id="file.save" icon="save" />
        </div>
        <div className="segmented modes" role="radiogroup" aria-label="Mode">
          {(['edit', 'simulate'] as const).map((mode) => (
            <button
              key={mode}
              type="button"
              role="radio"
              aria-checked={transport.mode === mode}
              disabled={!ready}
              title={mode === 'edit' ? 'Show the motions of the tracks, without physics' : 'Compute the dynamics; characters can be pulled and pushed'}
              onClick={() => session.set_mode(mode)}
            >
              {mode === 'edit' ? 'Edit' : 'Simulate'}
            </button>
          ))}
        </div>
      </div>
      <div className="bar-centre">
        <div className="transport" role="group" aria-label="Transport">
          <CommandButton id="play.start" icon="to_start" />
          <CommandButton id="play.back" icon="back" />
          <CommandButton id="play.toggle" icon={transport.playing ? 'pause' : 'play'} title={transport.playing ? 'Pause' : 'Play'} accent pressed={transport.playing} />
          <CommandButton id="play.on" icon="on" />
          <CommandButton id="play.end" icon="to_end" />
          <CommandButton id="play.loop" icon="loop" pressed={transport.loop} />
        </div>
        <Clock />
        <select className="speed" aria-label="Playback speed" title="Playback speed" value={transport.speed} onChange={(e) => session.set_speed(Number(e.target.value))}>
          {(speeds.includes(transport.speed) ? speeds : [...speeds, transport.speed].sort((a, b) => a - b)).map((speed) => (
            <option key={speed} value={speed}>
              {speed}×
            </option>
          ))}
        </select>
      </div>
      <div className="bar-right">
        {simulate && (
          <span className="rate" title="Simulation rate, and simulated time per computing time">
            {step ? `${Math.round(1 / step)} Hz` : ''}
            {transport.realtime_factor > 0 && <> · {format_factor(transport.realtime_factor)} real time</>}
          </span>
        )}
        <button type="button" className="tool wide" title="Search all commands  (Ctrl K)" onClick={() => run('page.palette')}>
          <Icon name="search" />
          <span>Commands</span>
        </button>
        <ExportMenu />
        <CommandButton id="page.theme" icon="sun" />
        <CommandButton id="page.keys" icon="help" />
      </div>
    </header>
  );
}
