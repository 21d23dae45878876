/** The drawing of the curves panel: ruler, key lane, curves with keys and tangents. Drawn on a canvas; drags change the keys. */
import { useEffect, useLayoutEffect, useRef, useState, type KeyboardEvent, type PointerEvent as ReactPointerEvent, type ReactElement } from 'react';
import type { Clip } from '../../core/document';
import { format_ruler } from '../../core/format';
import { move_keys, picks_at, points, same_pick, set_slope, value_of, type Curve, type KeyPick } from '../../core/posing/curves';
import { edit_keys, find_joint, key_slopes, key_times, scenario_times, type KeyedLayer, type KeyName, type KeyPut } from '../../core/posing/keys';
import type { CurvesReply, RecordedEvent } from '../../core/protocol';
import { pan_by, round_to_frame, ruler_steps, time_to_x, x_to_time, zoom_at, type TimeView } from '../../core/timeline';
import { parts, plain_canvas, poser, session, useStudio } from '../app';

const ruler_height = 22; // px
const lane_height = 20; // px
const reach = 7; // px, maximum distance between the pointer and a key that is picked
const handle_length = 46; // px, length of a drawn tangent

interface Range {
  low: number;
  high: number;
}
interface Props {
  character: string;
  clip: Clip;
  layer: KeyedLayer;
  reply: CurvesReply;
  curves: readonly Curve[];
  /** Joints of the character in the recorded simulation; null: none are known. */
  recorded: RecordedEvent | null;
  /** The selected link, whose curves are drawn in full; null: no link is selected. */
  link: string | null;
  picks: readonly KeyPick[];
  set_picks: (picks: readonly KeyPick[]) => void;
  remove: () => void;
}
interface Edit {
  take?: KeyName[];
  put: KeyPut[];
}

/** Samples of a curve in the recorded simulation, rad or m; empty for the root, whose coordinates depend on the place of the clip. */
const simulated = (recorded: RecordedEvent | null, c: Curve): readonly number[] => (c.part === 'joint' && recorded?.curves.find((r) => r.link === c.link)?.values[c.component]) || [];

export function CurvePlot({ character, clip, layer, reply, curves, recorded, link, picks, set_picks, remove }: Props): ReactElement {
  const canvas = useRef<HTMLCanvasElement>(null);
  const host = useRef<HTMLDivElement>(null);
  const line = useRef<HTMLDivElement>(null);
  const [size, set_size] = useState({ width: 600, height: 160 });
  const [view, set_view] = useState<TimeView | null>(null);
  /** The edit of a running drag, which is drawn and not sent yet. */
  const [edit, set_edit] = useState<Edit | null>(null);
  const [marquee, set_marquee] = useState<{ left: number; top: number; width: number; height: number } | null>(null);
  useStudio((s) => s.theme); // the colours are read from the theme when the component renders
  const rate = useStudio((s) => s.document?.frame_rate ?? 60);
  const shown = edit ? edit_keys(layer, edit.take ?? [], edit.put) : layer;
  const fitted = fit(clip, reply.duration, size.width, clip.loop ? session.state.transport.time : clip.start);
  const time_view = view ?? fitted;
  const { duration } = reply;
  const value = (c: Curve, t: number): number => value_of(c, reply, layer, shown, t, clip.loop ? duration : 0);

  useEffect(() => set_view(null), [clip.id]);
  useEffect(() => set_edit(null), [layer, reply]);
  useLayoutEffect(() => {
    const element = host.current;
    if (!element) return;
    const observer = new ResizeObserver(() => set_size({ width: element.clientWidth, height: element.clientHeight }));
    observer.observe(element);
    return () => observer.disconnect();
  }, []);

  const range = ((): Range => {
    let low = Infinity;
    let high = -Infinity;
    for (const c of curves) for (const v of [...c.result, ...c.base, ...(c.link === link ? simulated(recorded, c) : [])]) {
      low = Math.min(low, v * c.scale);
      high = Math.max(high, v * c.scale);
    }
    if (!(low <= high)) return { low: -10, high: 10 };
    const margin = Math.max(4, 0.14 * (high - low));
    return { low: low - margin, high: high + margin };
  })();
  const top = ruler_height + lane_height;
  const y_of = (v: number): number => top + ((range.high - v) / (range.high - range.low)) * (size.height - top);
  const per_pixel = (range.high - range.low) / Math.max(1, size.height - top);
  const x_of = (time: number): number => time_to_x(time_view, time);

  /** Keys as drawn: position in px, and what a press picks. */
  const drawn_keys = (source: KeyedLayer): { x: number; y: number; curve: Curve; pick: KeyPick }[] =>
    curves.flatMap((curve) =>
      (find_joint(source, curve.link, curve.part)?.keys ?? []).flatMap((key) =>
        scenario_times(clip, key.time, duration).map((time) => ({ x: x_of(time), y: y_of(value(curve, key.time) * curve.scale), curve, pick: { link: curve.link, part: curve.part, time: key.time, component: curve.component } })),
      ),
    );
  useEffect(() => {
    parts.drawn_keys = () => drawn_keys(shown).map(({ x, y }) => ({ x, y }));
    return () => {
      parts.drawn_keys = () => [];
    };
  });
  const is_picked = (pick: KeyPick): boolean => picks.some((p) => (p.component === null ? p.link === pick.link && p.part === pick.part && Math.abs(p.time - pick.time) < 1e-6 : same_pick(p, pick)));

  /** Ends of the tangents of the only selected key, in px. */
  const tangents = ((): { x: number; y: number; side: 0 | 1; key: { x: number; y: number }; curve: Curve; pick: KeyPick }[] => {
    const pick = picks.length === 1 ? picks[0] : undefined;
    const curve = pick && curves.find((c) => c.link === pick.link && c.part === pick.part && c.component === pick.component);
    const joint = curve && find_joint(shown, curve.link, curve.part);
    const index = joint && pick ? joint.keys.findIndex((k) => Math.abs(k.time - pick.time) < 1e-6) : -1;
    if (!pick || !curve || !joint || index < 0) return [];
    const slopes = key_slopes(joint.keys, index, curve.component);
    const at = drawn_keys(shown).find((k) => k.curve === curve && same_pick(k.pick, pick));
    if (!at) return [];
    return ([0, 1] as const).filter((side) => joint.keys[index + (side === 0 ? -1 : 1)]).map((side) => {
      const dx = 1;
      const dy = (-slopes[side] * curve.scale * clip.speed * layer.weight) / per_pixel / time_view.scale;
      const length = handle_length / Math.hypot(dx, dy);
      const way = side === 0 ? -1 : 1;
      return { x: at.x + way * dx * length, y: at.y + way * dy * length, side, key: { x: at.x, y: at.y }, curve, pick };
    });
  })();

  useLayoutEffect(() => {
    const element = canvas.current;
    const context = element?.getContext('2d', plain_canvas);
    if (!element || !context) return;
    const ratio = window.devicePixelRatio || 1;
    element.width = Math.round(size.width * ratio);
    element.height = Math.round(size.height * ratio);
    const style = getComputedStyle(element);
    const color = (name: string): string => style.getPropertyValue(name);
    context.scale(ratio, ratio);
    context.clearRect(0, 0, size.width, size.height);
    context.font = `${parseFloat(style.fontSize)}px ${style.fontFamily}`;
    context.textBaseline = 'middle';
    // the clip, the ruler
    context.fillStyle = color('--bg');
    const [x0, x1] = [x_of(clip.start), x_of(clip.start + clip.length)];
    context.fillRect(Math.max(0, x0), top, Math.min(size.width, x1) - Math.max(0, x0), size.height - top);
    const { label, tick } = ruler_steps(time_view.scale, rate);
    for (let i = Math.max(0, Math.ceil(time_view.origin / tick)); i * tick <= x_to_time(time_view, size.width); i++) {
      const x = Math.round(x_of(i * tick)) + 0.5;
      const major = i % Math.round(label / tick) === 0;
      context.fillStyle = color(major ? '--line-strong' : '--line');
      context.fillRect(x - 0.5, ruler_height - (major ? 8 : 4), 1, major ? 8 : 4);
      if (!major) continue;
      context.fillStyle = color('--line');
      context.fillRect(x - 0.5, top, 1, size.height - top);
      context.fillStyle = color('--text-dim');
      context.fillText(format_ruler(i * tick, label), x + 4, ruler_height / 2 - 1);
    }
    // values: lines at round numbers
    const steps = [1, 2, 5, 10, 15, 30, 45, 90, 180, 360].find((s) => s / per_pixel >= 26) ?? 360;
    context.textAlign = 'right';
    for (let v = Math.ceil(range.low / steps) * steps; v <= range.high; v += steps) {
      const y = Math.round(y_of(v)) + 0.5;
      context.fillStyle = color(v === 0 ? '--line-strong' : '--line');
      context.fillRect(0, y - 0.5, size.width, 1);
      context.fillStyle = color('--text-faint');
      if (y < top + 16) continue;
      context.fillText(`${String(v).replace('-', '−')}${curves.every((c) => c.unit === 'cm') ? ' cm' : '°'}`, size.width - 4, Math.max(top + 7, y - 7));
    }
    context.textAlign = 'left';
    // the lane with the times of keys
    context.fillStyle = color('--panel');
    context.fillRect(0, ruler_height, size.width, lane_height);
    context.fillStyle = color('--line');
    context.fillRect(0, top - 1, size.width, 1);
    for (const time of key_times(shown))
      for (const t of scenario_times(clip, time, duration)) {
        const picked = picks.some((p) => Math.abs(p.time - time) < 5e-4);
        diamond(context, x_of(t), ruler_height + lane_height / 2, 5, picked ? color('--accent') : color('--text-dim'));
      }
    // curves: without the layers dotted, with them solid
    context.save();
    context.beginPath();
    context.rect(0, top, size.width, size.height - top);
    context.clip();
    const count = Math.max(60, Math.round((Math.min(x1, size.width) - Math.max(x0, 0)) / 2));
    const draw = (curve: Curve, of: (t: number) => number, width: number, dash: number[], alpha: number): void => {
      context.strokeStyle = color(`--curve-${curve.component % 3}`);
      context.globalAlpha = alpha;
      context.lineWidth = width;
      context.setLineDash(dash);
      context.beginPath();
      points(curve, of, clip, duration, x_to_time(time_view, -4), x_to_time(time_view, size.width + 4), count).forEach(([time, v], i) => (i === 0 ? context.moveTo(x_of(time), y_of(v)) : context.lineTo(x_of(time), y_of(v))));
      context.stroke();
      context.setLineDash([]);
      context.globalAlpha = 1;
    };
    const faint = (c: Curve): boolean => link !== null && c.link !== link && !picks.some((p) => p.link === c.link);
    const ordered = [...curves].sort((a, b) => Number(faint(b)) - Number(faint(a)));
    for (const c of ordered) if (c.keys.length > 0 && !faint(c)) draw(c, (t) => value_of({ ...c, result: c.base }, reply, layer, layer, t), 1.2, [2, 3], 0.75);
    for (const c of ordered) draw(c, (t) => value(c, t), faint(c) || c.keys.length === 0 ? 1.2 : 2, [], faint(c) ? 0.28 : c.keys.length > 0 ? 1 : 0.6);
    // the simulated curve of the joints that are drawn in full, with dashes
    context.strokeStyle = color('--simulated');
    context.lineWidth = 1.4;
    context.setLineDash([6, 3]);
    for (const c of ordered) {
      if (faint(c) || !recorded) continue;
      const values = simulated(recorded, c);
      const first = Math.max(0, Math.floor(Math.max(clip.start, x_to_time(time_view, -4)) / recorded.step));
      const last = Math.min(values.length - 1, Math.ceil(Math.min(clip.start + clip.length, x_to_time(time_view, size.width + 4)) / recorded.step));
      context.beginPath();
      for (let i = first; i <= last; i++) context.lineTo(x_of(i * recorded.step), y_of(values[i]! * c.scale));
      context.stroke();
    }
    context.setLineDash([]);
    for (const t of tangents) {
      context.strokeStyle = color('--text-dim');
      context.lineWidth = 1;
      context.beginPath();
      context.moveTo(t.key.x, t.key.y);
      context.lineTo(t.x, t.y);
      context.stroke();
      context.beginPath();
      context.arc(t.x, t.y, 3.5, 0, 2 * Math.PI);
      context.fillStyle = color('--panel');
      context.fill();
      context.strokeStyle = color('--text');
      context.stroke();
    }
    const marks = drawn_keys(shown).sort((a, b) => Number(faint(b.curve)) - Number(faint(a.curve)));
    for (const k of marks) diamond(context, k.x, k.y, is_picked(k.pick) ? 5.5 : faint(k.curve) ? 2.5 : 4.5, is_picked(k.pick) ? color('--accent') : color(`--curve-${k.curve.component % 3}`), color('--panel'));
    context.restore();
  });

  // the playhead is moved without React
  const latest = useRef(time_view);
  latest.current = time_view;
  useEffect(() => {
    let handle = 0;
    const tick = (): void => {
      handle = requestAnimationFrame(tick);
      const x = time_to_x(latest.current, session.now);
      if (line.current) line.current.style.transform = `translateX(${x.toFixed(1)}px)`;
    };
    tick();
    return () => cancelAnimationFrame(handle);
  }, []);

  useEffect(() => {
    const element = canvas.current;
    if (!element) return;
    const wheel = (event: WheelEvent): void => {
      event.preventDefault();
      const amount = event.deltaY || event.deltaX;
      const x = event.clientX - element.getBoundingClientRect().left;
      set_view(event.shiftKey ? pan_by(latest.current, amount) : zoom_at(latest.current, x, Math.exp(-Math.max(-150, Math.min(150, amount)) * 0.0022)));
    };
    element.addEventListener('wheel', wheel, { passive: false });
    return () => element.removeEventListener('wheel', wheel);
  }, []);

  const commit = (change: Edit, label: string): void => {
    set_edit(change);
    void poser.edit_keys({ character, clip: clip.id }, layer, change, label).then((ok) => {
      if (!ok) set_edit(null);
    });
  };

  const press = (event: ReactPointerEvent<HTMLCanvasElement>): void => {
    if (event.button !== 0 && event.button !== 1) return;
    const element = event.currentTarget;
    const box = element.getBoundingClientRect();
    const at = { x: event.clientX - box.left, y: event.clientY - box.top };
    const follow = (move: (e: PointerEvent, dx: number, dy: number) => void, up: (e: PointerEvent, moved: boolean) => void): void => {
      let moved = false;
      element.setPointerCapture(event.pointerId);
      const stop = (): void => {
        element.removeEventListener('pointermove', on_move);
        element.removeEventListener('pointerup', on_up);
        element.removeEventListener('pointercancel', cancel);
        window.removeEventListener('keydown', key, true);
      };
      const on_move = (e: PointerEvent): void => {
        moved ||= Math.hypot(e.clientX - event.clientX, e.clientY - event.clientY) >= 3;
        if (moved) move(e, e.clientX - event.clientX, e.clientY - event.clientY);
      };
      const on_up = (e: PointerEvent): void => {
        stop();
        up(e, moved);
      };
      const cancel = (): void => {
        stop();
        set_edit(null);
        set_marquee(null);
      };
      const key = (e: globalThis.KeyboardEvent): void => {
        if (e.key !== 'Escape') return;
        e.preventDefault();
        e.stopPropagation();
        cancel();
      };
      element.addEventListener('pointermove', on_move);
      element.addEventListener('pointerup', on_up);
      element.addEventListener('pointercancel', cancel);
      window.addEventListener('keydown', key, true);
    };
    if (event.button === 1) {
      const start = time_view;
      return follow((_e, dx) => set_view(pan_by(start, -dx)), () => undefined);
    }
    if (at.y < ruler_height) {
      const seek = (x: number): void => session.seek(round_to_frame(x_to_time(time_view, x), rate));
      seek(at.x);
      return follow((e) => seek(e.clientX - box.left), () => undefined);
    }
    const handle = tangents.find((t) => Math.hypot(t.x - at.x, t.y - at.y) <= reach);
    if (handle) {
      let change: Edit | null = null;
      return follow(
        (e) => {
          const way = handle.side === 0 ? -1 : 1;
          const dx = Math.max(2, way * (e.clientX - box.left - handle.key.x));
          const dy = way * (e.clientY - box.top - handle.key.y);
          const slope = (-dy * per_pixel * time_view.scale) / dx / handle.curve.scale / clip.speed / (layer.weight || 1);
          change = { put: set_slope(layer, handle.pick, handle.side, slope, e.altKey) };
          set_edit(change);
        },
        (_e, moved) => moved && change && commit(change, 'Turn tangent'),
      );
    }
    const lane = at.y < top;
    const near = drawn_keys(layer).map((k) => ({ ...k, distance: Math.hypot(k.x - at.x, k.y - at.y) })).filter((k) => k.distance <= reach).sort((a, b) => Number(link !== null && a.curve.link !== link) - Number(link !== null && b.curve.link !== link) || a.distance - b.distance)[0];
    const lane_time = lane ? key_times(layer).find((t) => scenario_times(clip, t, duration).some((s) => Math.abs(x_of(s) - at.x) <= reach)) : undefined;
    const hit = lane ? (lane_time === undefined ? [] : picks_at(layer, lane_time)) : near ? [near.pick] : [];
    const adds = event.shiftKey || event.ctrlKey || event.metaKey;
    if (hit.length > 0) {
      const already = hit.every(is_picked);
      const chosen = adds ? (already ? picks.filter((p) => !hit.some((h) => same_pick(h, p))) : [...picks, ...hit]) : already ? picks : hit;
      set_picks(chosen);
      if (chosen.length === 0) return;
      let change: ReturnType<typeof move_keys> | null = null;
      return follow(
        (e, dx, dy) => {
          // the pressed key snaps to frames of the scenario
          const time = hit[0]!.time;
          const from = scenario_times(clip, time, duration)[0] ?? clip.start;
          const wanted = round_to_frame(from + dx / time_view.scale, rate) - from;
          const curve = near?.curve;
          change = move_keys(layer, chosen, Math.abs(dx) < 3 ? 0 : wanted * clip.speed, lane || !curve || Math.abs(dy) < 3 ? 0 : ((-dy * per_pixel) / curve.scale) * (e.shiftKey ? 0.1 : 1), duration);
          set_edit(change);
          set_picks(change.picks);
        },
        (_e, moved) => {
          if (moved && change) commit({ take: change.take, put: change.put }, change.take.length > 0 ? 'Move keys' : 'Change keys');
          else if (!adds && already && picks.length > hit.length) set_picks(hit);
        },
      );
    }
    follow(
      (e) => set_marquee({ left: Math.min(at.x, e.clientX - box.left), top: Math.min(at.y, e.clientY - box.top), width: Math.abs(e.clientX - event.clientX), height: Math.abs(e.clientY - event.clientY) }),
      (e, moved) => {
        set_marquee(null);
        if (!moved) {
          if (!adds) set_picks([]);
          return;
        }
        const [left, right] = [at.x, e.clientX - box.left].sort((a, b) => a - b) as [number, number];
        const [high, low] = [at.y, e.clientY - box.top].sort((a, b) => a - b) as [number, number];
        const inside = drawn_keys(layer).filter((k) => k.x >= left && k.x <= right && k.y >= high && k.y <= low).map((k) => k.pick);
        const unique = inside.filter((p, i) => inside.findIndex((o) => same_pick(o, p)) === i);
        set_picks(adds ? [...picks.filter((p) => !unique.some((u) => same_pick(u, p))), ...unique] : unique);
      },
    );
  };

  const key_down = (event: KeyboardEvent): void => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if ((event.key === 'Delete' || event.key === 'Backspace') && picks.length > 0) remove();
    else if (event.key.toLowerCase() === 'a' && (event.ctrlKey || event.metaKey)) set_picks(drawn_keys(layer).map((k) => k.pick).filter((p, i, all) => all.findIndex((o) => same_pick(o, p)) === i));
    else if (event.key === 'Escape' && picks.length > 0) set_picks([]);
    else if (event.key === 'Home' || event.key.toLowerCase() === 'f') set_view(null);
    else if (step && picks.length > 0 && !event.ctrlKey && !event.altKey) {
      const curve = curves.find((c) => picks.some((p) => p.link === c.link && p.part === c.part && p.component === c.component));
      const change = move_keys(layer, picks, (step[0]! * clip.speed) / rate, curve ? (step[1]! * (event.shiftKey ? 0.1 : 1)) / curve.scale : 0, duration);
      set_picks(change.picks);
      commit({ take: change.take, put: change.put }, 'Move keys');
    } else return;
    event.preventDefault();
    event.stopPropagation();
  };

  return (
    <div ref={host} className="curve-plot">
      <canvas ref={canvas} tabIndex={0} role="img" aria-label={`Curves with ${key_times(layer).length} keys`} onPointerDown={press} onKeyDown={key_down} />
      {marquee && <div className="marquee" style={marquee} />}
      <div className="overlay" aria-hidden="true">
        <div ref={line} className="playhead"><div className="playhead-cap" /></div>
      </div>
    </div>
  );
}

/** The view that shows a clip; of a looped clip, the round of its motion that plays at `time`. */
function fit(clip: Clip, duration: number, width: number, time: number): TimeView {
  const period = clip.loop && duration > 0 ? duration / clip.speed : clip.length;
  const first = clip.start - (clip.loop ? clip.offset / clip.speed : 0);
  const round = Math.floor((Math.min(Math.max(time, clip.start), clip.start + clip.length) - first) / period + 1e-6);
  const from = Math.max(clip.start, first + (clip.loop ? round * period : 0));
  const span = Math.max(0.1, Math.min(period, clip.start + clip.length - from));
  const scale = Math.min(2400, Math.max(4, (width - 64) / span));
  return { scale, origin: from - 16 / scale };
}

function diamond(context: CanvasRenderingContext2D, x: number, y: number, r: number, fill: string, rim?: string): void {
  context.beginPath();
  context.moveTo(x, y - r);
  context.lineTo(x + r, y);
  context.lineTo(x, y + r);
  context.lineTo(x - r, y);
  context.closePath();
  context.fillStyle = fill;
  context.fill();
  if (!rim) return;
  context.strokeStyle = rim;
  context.lineWidth = 1;
  context.stroke();
}
