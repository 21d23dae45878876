/** The state machine that the rules of one character form: its track, the motions of its rules, and the transitions between them. */
import { Fragment, useRef, useState, type DragEvent, type PointerEvent, type ReactElement } from 'react';
import type { Character, ScenarioDocument } from '../../core/document';
import { condition_text, key_name, state_graph, type GraphEdge, type MotionName } from '../../core/rules';
import { page, session } from '../app';

const [box_width, box_height, gap_x, gap_y, margin] = [128, 38, 124, 26, 12]; // px
const loop_width = 64; // px, room for transitions between states of the last column

interface Props {
  doc: ScenarioDocument;
  character: Character;
  motion_name: MotionName;
  /** Number of the state that plays, from 0: the track; null: nothing runs. */
  now: number | null;
  /** A drag from one state to another. @param from, to rules of the states; empty: the track */
  connect: (from: string, to: string) => void;
  /** A motion of the library was dropped on the graph. */
  add_state: (entry: string) => void;
}

const drag_start = 5; // px, pointer travel at which a press becomes a drag

export function Graph({ doc, character, motion_name, now, connect, add_state }: Props): ReactElement {
  const { states, edges } = state_graph(doc, character.id);
  const others = states.length - 1;
  const columns = others > 4 ? 2 : 1;
  const rows = Math.max(1, Math.ceil(others / columns));
  const height = Math.max(2 * margin + rows * box_height + (rows - 1) * gap_y, 96);
  const inner = edges.some((e) => e.from !== '' && e.to !== '');
  const width = 2 * margin + (columns + 1) * box_width + columns * gap_x + (inner ? loop_width : 0);
  const at = states.map((_, i) => {
    if (i === 0) return { x: margin, y: (height - box_height) / 2 };
    const column = Math.floor((i - 1) / rows);
    const in_column = Math.min(rows, others - column * rows);
    const used = in_column * box_height + (in_column - 1) * gap_y;
    return { x: margin + (column + 1) * (box_width + gap_x), y: (height - used) / 2 + ((i - 1) % rows) * (box_height + gap_y) };
  });
  const index = (rule: string): number => states.findIndex((s) => s.rule === rule);
  // rules are numbered in the order of the list; the choice that plays is the number of a rule
  const ids = ['', ...(doc.rules ?? []).filter((r) => r.on && r.do.type === 'play' && r.do.character === character.id).map((r) => r.id)];
  const playing = now === null ? -1 : states.findIndex((s) => s.rules.includes(ids[now] ?? '-'));
  const box = useRef<HTMLDivElement>(null);
  const [drag, set_drag] = useState<{ from: number; x: number; y: number } | null>(null);
  const press = useRef<{ from: number; x: number; y: number } | null>(null);
  const state_at = (x: number, y: number): number => at.findIndex((p) => x >= p.x && x <= p.x + box_width && y >= p.y && y <= p.y + box_height);
  const place = (event: PointerEvent): { x: number; y: number } => {
    const rect = box.current!.getBoundingClientRect();
    return { x: event.clientX - rect.left, y: event.clientY - rect.top };
  };
  const move = (event: PointerEvent): void => {
    if (!press.current) return;
    const p = place(event);
    if (drag || Math.hypot(p.x - press.current.x, p.y - press.current.y) > drag_start) set_drag({ from: press.current.from, ...p });
  };
  const end = (event: PointerEvent): void => {
    if (drag) {
      const p = place(event);
      const to = state_at(p.x, p.y);
      if (to >= 0 && to !== drag.from) connect(states[drag.from]!.rule, states[to]!.rule);
    }
    press.current = null;
    set_drag(null);
  };
  const accepts = (event: DragEvent): void => {
    const entry = page.getState().dragged_entry;
    if (entry && session.entry(entry)?.kind === 'motion') event.preventDefault();
  };
  const drop = (event: DragEvent): void => {
    const entry = page.getState().dragged_entry;
    if (!entry || session.entry(entry)?.kind !== 'motion') return;
    event.preventDefault();
    event.stopPropagation();
    page.setState({ dragged_entry: null });
    add_state(entry);
  };
  const target = drag ? state_at(drag.x, drag.y) : -1;
  return (
    <div ref={box} className="rule-graph" style={{ width, height }} onDragOver={accepts} onDrop={drop} role="group" aria-label={`States of ${character.name}`}>
      <svg width={width} height={height} aria-hidden="true">
        <defs>
          <marker id="rule-arrow" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto-start-reverse">
            <path d="M0 0.800L7.500 4L0 7.200z" fill="context-stroke" />
          </marker>
        </defs>
        {edges.map((edge, i) => (
          <Arrow key={`${edge.from}>${edge.to}>${edge.back}>${i}`} edge={edge} from={at[index(edge.from)]!} to={at[index(edge.to)]!} active={!edge.back && playing >= 0 && playing === index(edge.to)} text={edge.back ? back_label(edge) : label(doc, edge, motion_name)} />
        ))}
        {drag && <path className="rule-arrow" data-active="true" d={`M${at[drag.from]!.x + box_width / 2} ${at[drag.from]!.y + box_height / 2}L${drag.x} ${drag.y}`} markerEnd="url(#rule-arrow)" />}
      </svg>
      {states.map((state, i) => (
        <button
          key={state.rule}
          type="button"
          className="rule-state"
          data-active={playing === i}
          data-target={target === i && drag !== null && target !== drag.from}
          style={{ left: at[i]!.x, top: at[i]!.y, width: box_width, height: box_height }}
          onPointerDown={(e) => {
            if (e.button !== 0) return;
            e.currentTarget.setPointerCapture(e.pointerId);
            press.current = { from: i, ...place(e) };
          }}
          onPointerMove={move}
          onPointerUp={end}
          onPointerCancel={end}
          title={state.rule ? `${motion_name(state.motion)}: select the rule; drag to another state to add a transition` : 'The clips of the track play while no rule is active'}
          onClick={() => session.select(state.rule ? { kind: 'rule', rule: state.rule } : { kind: 'character', character: character.id })}
        >
          <strong>{state.rule ? motion_name(state.motion) : 'Track'}</strong>
          <span>{state.rule ? describe(state.motion, state.speed, state.loop) : `${character.track.length} ${character.track.length === 1 ? 'clip' : 'clips'}`}</span>
        </button>
      ))}
    </div>
  );
}

function describe(motion: string, speed: number, loop: boolean): string {
  const duration = session.entry(motion)?.duration;
  return [loop ? 'loop' : '', duration ? `${(duration / speed).toFixed(2)} s` : ''].filter(Boolean).join(' · ');
}

function label(doc: ScenarioDocument, edge: GraphEdge, motion_name: MotionName): string {
  return edge.conditions.map((c) => (c.type === 'key' ? `${c.not ? 'not ' : ''}${key_name(c.key ?? '')}` : condition_text(doc, c, motion_name))).join(' + ');
}
const back_label = (edge: GraphEdge): string => (edge.mode === 'while' ? 'released' : 'ends');

const longest_label = 18; // characters; longer labels would overlap the states
const letter_width = 6; // px, mean width of a letter of a label
const arrow_head = 8; // px

/** A transition: outward arrows bend upwards, returning ones downwards. */
function Arrow({ edge, from, to, active, text }: { edge: GraphEdge; from: { x: number; y: number }; to: { x: number; y: number }; active: boolean; text: string }): ReactElement {
  const right = to.x > from.x;
  const same = to.x === from.x;
  const shift = edge.back ? 7 : -7;
  const x0 = from.x + (right || same ? box_width : 0);
  const x1 = to.x + (right ? 0 : box_width);
  const y0 = from.y + box_height / 2 + shift;
  const y1 = to.y + box_height / 2 + shift;
  const bend = same ? 36 : (x1 - x0) / 2;
  const c0 = x0 + bend;
  const c1 = same ? x1 + 36 : x1 - bend;
  // the label is near the rule's state, where the arrows of a fan are apart
  const t = edge.back ? 0.28 : 0.72;
  const point = (a: number, b: number, c: number, d: number): number => (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t * t * c + t ** 3 * d;
  const shown = text.length > longest_label ? `${text.slice(0, longest_label - 1)}…` : text;
  // between states, the label stays in the gap
  const half = (shown.length * letter_width) / 2;
  const middle = point(x0, c0, c1, x1);
  const x = same ? middle : Math.max(Math.min(x0, x1) + half, Math.min(Math.max(x0, x1) - half - arrow_head, middle));
  return (
    <Fragment>
      <path className="rule-arrow" data-active={active} data-back={edge.back} d={`M${x0} ${y0}C${c0} ${y0} ${c1} ${y1} ${x1} ${y1}`} markerEnd="url(#rule-arrow)" />
      <text className="rule-arrow-label" data-back={edge.back} x={x} y={point(y0, y0, y1, y1) + (edge.back ? 13 : -5)} textAnchor="middle">
        {shown}
        <title>{text}</title>
      </text>
    </Fragment>
  );
}
