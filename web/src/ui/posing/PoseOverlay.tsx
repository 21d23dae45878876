/** Elements of posing over the viewport: tools, handles on hands, feet, head and pelvis, and the angles beside the gizmo. */
import { useEffect, useRef, type ReactElement } from 'react';
import * as THREE from 'three';
import { format_label } from '../../core/format';
import { show_key } from '../../core/keymap';
import { find_character, find_clip, type Clip } from '../../core/document';
import type { MechanismData } from '../../core/protocol';
import { selected_character } from '../../core/state';
import type { Viewport } from '../../view/viewport';
import { clip_at, cross_fade_at } from '../../core/posing/poser';
import { run } from '../actions';
import { parts, poser, registry, session, usePoser, useStudio } from '../app';
import { Icon } from '../icons';

const key_hint = (id: string): string => {
  const command = registry.get(id);
  const key = command && registry.keys_of(command, session.state.keymap)[0];
  return key ? `  (${show_key(key)})` : '';
};

/** The tools of the viewport: select, or pose. */
export function ToolChoice(): ReactElement | null {
  const on = usePoser((s) => s.on);
  const empty = useStudio((s) => (s.document?.characters.length ?? 0) === 0);
  if (empty) return null;
  return (
    <div className="pose-tools" role="toolbar" aria-label="Tools" aria-orientation="vertical">
      <button type="button" aria-pressed={!on} aria-label="Select" title="Select and place characters" onClick={() => poser.switch_on(false)}><Icon name="pointer" /></button>
      <button type="button" aria-pressed={on} aria-label="Pose" title={`Pose: rotate joints, drag hands and feet${key_hint('pose.tool')}`} onClick={() => poser.switch_on(true)}><Icon name="pose" /></button>
    </div>
  );
}

export function PoseTools(): ReactElement | null {
  const on = usePoser((s) => s.on);
  const moves = usePoser((s) => s.moves);
  const auto_key = usePoser((s) => s.auto_key);
  const pending = usePoser((s) => s.pending);
  const target = usePoser((s) => s.target);
  const empty = useStudio((s) => (s.document?.characters.length ?? 0) === 0);
  const blocked = useStudio((s) => s.transport.mode !== 'edit' || s.transport.playing);
  const named = useStudio((s) => s.document?.characters.find((c) => c.id === selected_character(s))?.name);
  const fade = useStudio((s) => target && cross_fade_at(s.document, target));
  const posed_clip = useStudio((s) => (target && s.document ? find_clip(s.document, target.character, target.clip) : undefined));
  const nearest = useStudio((s) => {
    const id = selected_character(s);
    const track = id && s.document ? (find_character(s.document, id)?.track ?? []) : [];
    const away = (k: Clip): number => Math.max(k.start - s.transport.time, s.transport.time - k.start - k.length);
    return id && s.document && !clip_at(s.document, id, s.transport.time) ? [...track].sort((a, b) => away(a) - away(b))[0] : undefined;
  });
  useStudio((s) => s.library_revision);
  const motion_name = (clip: Clip): string => session.entry(clip.motion)?.name ?? clip.motion;
  if (empty) return null;
  return (
    <>
      {on && (
        <div className="pose-bar" role="toolbar" aria-label="Posing">
          <span className="segments" role="group" aria-label="Drag moves">
            <button type="button" aria-pressed={moves === 'limb'} title={`A drag moves the limb of the dragged link${key_hint('pose.moves')}`} onClick={() => poser.set_moves('limb')}>Limb</button>
            <button type="button" aria-pressed={moves === 'body'} title={`A drag moves the whole body; pinned links keep their place${key_hint('pose.moves')}`} onClick={() => poser.set_moves('body')}>Body</button>
            <button type="button" aria-pressed={moves === 'physics'} title={`The body follows the hand as a body: with inertia, joints that resist, limits, and the floor; pinned links are held${key_hint('pose.moves')}`} onClick={() => poser.set_moves('physics')}>Physics</button>
          </span>
          <button type="button" disabled={!target} aria-label="Mirror" title={`Mirror the pose${key_hint('pose.mirror')}`} onClick={() => run('pose.mirror')}><Icon name="mirror" /><span className="word">Mirror</span></button>
          <button type="button" disabled={!target} aria-label="Key" title={`Key the selected joint${key_hint('pose.key')}; the whole character${key_hint('pose.key_all')}`} onClick={() => run('pose.key')}><Icon name="key" /><span className="word">Key</span></button>
          <button type="button" className="auto-key" aria-label="Auto-key" aria-pressed={auto_key} title="Every change of a pose sets keys for the joints that changed" onClick={() => run('pose.auto_key')}><span className="key-dot" /><span className="word">Auto-key</span></button>
          {pending && !auto_key && (
            <span className="pose-pending" role="status">
              Not keyed
              <button type="button" onClick={() => void poser.key_changes()}>Key changes</button>
              <button type="button" onClick={() => poser.restore()}>Discard</button>
            </span>
          )}
          {fade && posed_clip && (
            <span className="pose-note" role="status">
              Cross-fade: the pose of {motion_name(posed_clip)} is shown, which is mixed with {motion_name(fade)}.
              <button type="button" onClick={() => session.select({ kind: 'clip', character: target!.character, clip: fade.id })}>Pose {motion_name(fade)}</button>
            </span>
          )}
          {!target && (
            <span className="pose-note" role="status">
              {blocked ? 'Poses are edited in the mode Edit, while paused.' : !named ? 'Click a character to pose it.' : nearest ? `Poses are keys over a clip, and ${named} has none here.` : `${named} has no clip. Drag a motion onto its track; poses are keys over a clip.`}
              {!blocked && nearest && <button type="button" onClick={() => session.seek(Math.min(Math.max(session.now, nearest.start), nearest.start + nearest.length))}>Go to {motion_name(nearest)}</button>}
            </span>
          )}
        </div>
      )}
    </>
  );
}

/** Angles beside the gizmo, written to the DOM after each drawn frame. */
export function PoseLabels({ viewport }: { viewport: Viewport }): ReactElement | null {
  const on = usePoser((s) => s.on);
  const host = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (!on) return;
    const place = (): void => {
      const labels = parts.posing?.labels() ?? [];
      const box = viewport.canvas.getBoundingClientRect();
      const placed: { x: number; y: number }[] = [];
      [...(host.current?.children ?? [])].forEach((child, i) => {
        const element = child as HTMLElement;
        const label = labels[i];
        const at = label && viewport.to_client(label.at);
        // the present angle comes first; a limit that would overlap it is hidden
        const free = at && !placed.some((o) => Math.abs(o.x - at.x) < 66 && Math.abs(o.y - at.y) < 22);
        element.style.visibility = free ? 'visible' : 'hidden';
        if (!label || !at || !free) return;
        placed.push(at);
        element.textContent = label.text;
        element.dataset.strong = String(label.strong);
        element.style.transform = `translate(${at.x - box.left}px, ${at.y - box.top}px) translate(-50%, -50%)`;
      });
    };
    place();
    return viewport.on_draw(place);
  }, [viewport, on]);
  if (!on) return null;
  return (
    <div ref={host} className="pose-labels" aria-hidden="true">
      {[0, 1, 2].map((i) => <span key={i} style={{ visibility: 'hidden' }} />)}
    </div>
  );
}

const handle_words = /^(hand|foot|paw|hoof|head|pelvis|hips?)\b/i;
const max_handles = 12;

/** Links that get a handle: hands, feet, head and pelvis; of other mechanisms the root and the ends of the limbs. */
export function handle_links(mechanism: MechanismData): number[] {
  const named = mechanism.links.flatMap((l, i) => (handle_words.test(l.label ?? '') ? [i] : []));
  const ends = mechanism.links.flatMap((_l, i) => (mechanism.links.some((other) => other.parent === i) ? [] : [i]));
  const root = mechanism.links.findIndex((l) => l.parent < 0);
  const found = named.filter((i) => i !== root).length >= 2 ? named : ends;
  return [...new Set([root, ...found])].slice(0, max_handles);
}

/** Handles on the posed character: a drag moves the link, P or the pin in the inspector holds it in place. */
export function PoseHandles({ viewport }: { viewport: Viewport }): ReactElement | null {
  const target = usePoser((s) => s.target);
  const pinned = usePoser((s) => (s.target ? (s.pins[s.target.character] ?? s.reply?.planted) : undefined));
  const moves = usePoser((s) => s.moves);
  const mechanism = useStudio((s) => {
    const character = target && s.document ? find_character(s.document, target.character) : undefined;
    return character ? s.mechanisms[character.mechanism] : undefined;
  });
  const selected = useStudio((s) => (s.selection.kind === 'character' ? s.selection.link : undefined));
  const host = useRef<HTMLDivElement>(null);
  const links = mechanism ? handle_links(mechanism) : [];
  const pins = (pinned ?? []).filter((l) => !links.includes(l));
  const all = [...links, ...pins];
  const key = all.join(' ');

  useEffect(() => {
    const place = (): void => {
      const reply = poser.state.reply;
      const box = viewport.canvas.getBoundingClientRect();
      for (const child of host.current?.children ?? []) {
        const element = child as HTMLElement;
        const link = Number(element.dataset.link);
        const point = reply && mechanism ? handle_point(reply.links, mechanism, link) : null;
        const at = point && viewport.to_client(point);
        element.style.visibility = at ? 'visible' : 'hidden';
        if (at) element.style.transform = `translate(${at.x - box.left}px, ${at.y - box.top}px) translate(-50%, -50%)`;
      }
    };
    place();
    return viewport.on_draw(place);
  }, [viewport, mechanism, key]);
  if (!target || !mechanism) return null;
  return (
    <div ref={host} className="pose-handles" role="group" aria-label="Handles">
      {all.map((link) => {
        const name = format_label(mechanism.links[link]!.label || mechanism.links[link]!.name);
        const pin = pinned?.includes(link) ?? false;
        return (
          <button
            key={link}
            type="button"
            data-link={link}
            data-pinned={pin && moves !== 'limb'}
            data-selected={link === selected}
            aria-label={`${name}${pin ? ', pinned' : ''}`}
            title={`${name}: drag to move${pin ? '; pinned while the body moves' : ''}`}
            onPointerDown={(event) => drag_handle(event, viewport, mechanism, target.character, link)}
          >
            <Icon name={pin && moves !== 'limb' ? 'pin' : 'move'} />
          </button>
        );
      })}
    </div>
  );
}

/** World position of a link's handle: the centre of its first shape, m. */
function handle_point(poses: readonly number[], mechanism: MechanismData, link: number): THREE.Vector3 {
  const p = poses.slice(7 * link, 7 * link + 7);
  const shape = mechanism.links[link]?.shapes[0]?.pose;
  const point = shape ? new THREE.Vector3(shape[0], shape[1], shape[2]) : new THREE.Vector3();
  return point.applyQuaternion(new THREE.Quaternion(p[4], p[5], p[6], p[3])).add(new THREE.Vector3(p[0], p[1], p[2]));
}

function drag_handle(event: React.PointerEvent<HTMLButtonElement>, viewport: Viewport, mechanism: MechanismData, character: string, link: number): void {
  const { reply } = poser.state;
  const view = parts.posing;
  if (event.button !== 0 || !reply || !view?.begin_reach(link, handle_point(reply.links, mechanism, link))) return;
  event.preventDefault();
  event.stopPropagation();
  viewport.canvas.focus({ preventScroll: true });
  const element = event.currentTarget;
  element.setPointerCapture(event.pointerId);
  const from = { x: event.clientX, y: event.clientY };
  let moved = false;
  const move = (e: PointerEvent): void => {
    moved ||= Math.hypot(e.clientX - from.x, e.clientY - from.y) >= 3;
    if (moved) view.move(e);
  };
  const stop = (): void => {
    element.removeEventListener('pointermove', move);
    element.removeEventListener('pointerup', up);
    element.removeEventListener('pointercancel', cancel);
    window.removeEventListener('keydown', key, true);
  };
  const up = (): void => {
    stop();
    if (view.up() !== null) session.select({ kind: 'character', character, link });
  };
  const cancel = (): void => {
    stop();
    view.cancel();
  };
  const key = (e: KeyboardEvent): void => {
    if (e.key !== 'Escape') return;
    e.preventDefault();
    e.stopPropagation();
    cancel();
  };
  element.addEventListener('pointermove', move);
  element.addEventListener('pointerup', up);
  element.addEventListener('pointercancel', cancel);
  window.addEventListener('keydown', key, true);
}
