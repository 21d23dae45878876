/** The track of a placed inner scenario in the timeline: one row with one block. */
import { useState, type ReactElement } from 'react';
import { createPortal } from 'react-dom';
import { apply_command, type Command, type ScenarioDocument, type ScenarioInstance } from '../../core/document';
import { format_number, format_time } from '../../core/format';
import { characters_of, find_scenario, is_instance_left_out, selected_tracks, toggle_track } from '../../core/nested';
import { snap_delta, time_to_x, type TimeView } from '../../core/timeline';
import { run } from '../actions';
import { session, useStudio } from '../app';
import { Icon } from '../icons';
import { Menu } from '../Menu';
import { drag_ends, start_drag } from '../track_drag';
import { nest_selection, open_instance } from './actions';

/** The context menu of the header of a track. @param instance the track is that of an instance */
export function TrackMenu({ at, close, instance }: { at: { x: number; y: number }; close: () => void; instance?: ScenarioInstance }): ReactElement {
  const count = selected_tracks(session.state.selection).length;
  const nest = { label: 'Nest in a scenario', key: 'Shift N', detail: count > 1 ? `${count} tracks become one row` : 'The track becomes one row that you can place again', run: () => void nest_selection() };
  const items = instance
    ? [
        { label: 'Open', run: () => open_instance(instance) },
        { label: 'Duplicate', key: 'Ctrl D', run: () => run('edit.duplicate') },
        { label: 'Unnest', detail: 'Its tracks return to this scenario', run: () => void session.edit({ type: 'instance.unnest', id: instance.id }) },
        { ...nest, apart: true },
        { label: 'Delete', key: 'Del', apart: true, run: () => run('edit.remove') },
      ]
    : [nest, { label: 'Duplicate', key: 'Ctrl D', apart: true, disabled: count > 1, run: () => run('edit.duplicate') }, { label: 'Delete', key: 'Del', run: () => run('edit.remove') }];
  return createPortal(<Menu x={at.x} y={at.y} over label="Track" close={close} items={items} />, document.querySelector('main') ?? document.body);
}

/** Where the menu of a track's header opens: at the pointer, or with the menu key below the header. */
export function menu_point(event: React.MouseEvent<HTMLElement>): { x: number; y: number } {
  event.preventDefault();
  const box = event.currentTarget.getBoundingClientRect();
  return event.button === 2 ? { x: event.clientX, y: event.clientY } : { x: box.left + 8, y: box.bottom };
}

interface InstanceTrackProps {
  instance: ScenarioInstance;
  doc: ScenarioDocument;
  view: TimeView;
  on_guide: (time: number | null) => void;
}

export function InstanceTrack({ instance, doc, view, on_guide }: InstanceTrackProps): ReactElement {
  const selection = useStudio((s) => s.selection);
  const [menu, set_menu] = useState<{ x: number; y: number } | null>(null);
  const inner = find_scenario(doc, instance.scenario);
  const length = inner?.duration ?? 1;
  const chosen = selected_tracks(selection).includes(instance.id);
  const select = (): void => session.select({ kind: 'instance', instance: instance.id });
  const characters = characters_of(doc, instance.scenario);

  const down = (event: React.PointerEvent<HTMLElement>): void => {
    const { document } = session.state;
    if (event.button !== 0 || !document) return;
    event.stopPropagation();
    select();
    let start = instance.start;
    const command = (): Command => ({ type: 'instance.set', id: instance.id, start });
    start_drag({
      event,
      scale: view.scale,
      move: (delta, rules) => {
        const snapped = snap_delta([instance.start, instance.start + length], delta, rules(document, instance.id));
        start = Math.max(0, Math.round((instance.start + snapped.delta) * 1e6) / 1e6);
        on_guide(snapped.at);
        session.show_preview(apply_command(document, command()));
      },
      ...drag_ends(on_guide, () => (start === instance.start ? null : command())),
    });
  };

  const name = ['track', 'nested', chosen && 'active', is_instance_left_out(doc, instance) && 'left-out'].filter(Boolean).join(' ');
  return (
    <div className={name} data-instance={instance.id}>
      <div className="track-head">
        <button
          type="button"
          className="track-name"
          aria-pressed={chosen}
          title={`Select ${instance.name}\nDouble-click opens the scenario; Ctrl-click selects several tracks`}
          onClick={(e) => (e.ctrlKey || e.metaKey || e.shiftKey ? session.select(toggle_track(doc, session.state.selection, instance.id)) : select())}
          onDoubleClick={() => open_instance(instance)}
          onContextMenu={(e) => {
            if (!chosen) select();
            set_menu(menu_point(e));
          }}
        >
          <Icon name="box" />
          <span className="label">{instance.name}</span>
        </button>
        <span className="track-switches">
          {([['muted', 'M', 'Mute', 'leave its characters out of playing'], ['solo', 'S', 'Solo', 'play only solo tracks']] as const).map(([key, letter, label, meaning]) => (
            <button key={key} type="button" className={`track-switch ${key}`} aria-pressed={Boolean(instance[key])} aria-label={`${letter}: ${label} ${instance.name}`} title={`${label}: ${meaning}`} onClick={() => void session.edit({ type: 'instance.set', id: instance.id, [key]: !instance[key] })}>
              {letter}
            </button>
          ))}
        </span>
        {menu && <TrackMenu at={menu} close={() => set_menu(null)} instance={instance} />}
      </div>
      <div className="lane">
        <div className="items" role="list" aria-label={`Scenario of ${instance.name}`}>
          <div
            role="listitem"
            tabIndex={0}
            className={selection.kind === 'instance' && chosen ? 'clip nested selected' : 'clip nested'}
            aria-label={`${instance.name}: scenario ${inner?.name ?? ''}, from ${format_time(instance.start)} for ${format_number(length)} seconds. Enter opens it`}
            title={`${inner?.name ?? ''}\n${format_number(instance.start)} s … ${format_number(instance.start + length)} s\nDouble-click opens it`}
            style={{ left: time_to_x(view, instance.start), width: Math.max(8, length * view.scale) }}
            onPointerDown={down}
            onDoubleClick={() => open_instance(instance)}
            onFocus={(e) => e.currentTarget.matches(':focus-visible') && !chosen && select()}
            onKeyDown={(e) => {
              if (e.key !== 'Enter') return;
              e.preventDefault();
              e.stopPropagation();
              open_instance(instance);
            }}
            onContextMenu={(e) => {
              select();
              set_menu(menu_point(e));
            }}
          >
            <span className="clip-name">
              {inner?.name ?? instance.scenario}
              <span className="clip-details"> {characters.length === 1 ? '1 character' : `${characters.length} characters`}</span>
            </span>
          </div>
        </div>
      </div>
    </div>
  );
}
