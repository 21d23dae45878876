/**
 * React Flow components of LSIs, of the circuit's own pins, of notes and of probes. Values and times are drawn on the canvas above them.
 */
import { Handle, NodeResizer, Position, type Node, type NodeProps } from '@xyflow/react';
import { memo, useEffect, useRef, useState, type ReactElement } from 'react';
import { hue_of } from '../../core/circuit/classes';
import { same_pin, why_not } from '../../core/circuit/fits';
import type { Note, Probe } from '../../core/circuit/form';
import { describe_node } from '../../core/circuit/navigate';
import { head_height, new_pin, pin_offset, type PinInfo, type ViewNode } from '../../core/circuit/view';
import { circuit, useCircuit, useStudio } from '../app';
import { ProblemBubble } from './ProblemBubble';
import { ProbeCurve } from './ProbeCurve';

export type LsiNodeType = Node<{ node: ViewNode }, 'lsi'>;
export type NoteNodeType = Node<{ note: Note }, 'note'>;
export type ProbeNodeType = Node<{ probe: Probe }, 'probe'>;

const pin_title = (pin: PinInfo): string =>
  [`${pin.name}: ${pin.type}${pin.unit ? ` [${pin.unit}]` : ''}`, pin.doc, pin.delayed ? 'Delayed: available from the next tick on.' : '', pin.multiple && pin.side === 'in' ? 'Accepts several wires.' : ''].filter(Boolean).join('\n');

function Pin({ node, pin, index }: { node: ViewNode; pin: PinInfo; index: number }): ReactElement {
  const own = { node: node.id, side: pin.side, pin: pin.name } as const;
  const connecting = useCircuit((s) => s.connecting);
  const at = useCircuit((s) => same_pin(s.pin, own));
  const target = useCircuit((s) => same_pin(s.target, own));
  const bad = useCircuit((s) => pin.side === 'out' && s.problems.length > 0 && s.problems.some((p) => p.pin === pin.name && p.lsi === [...s.path, node.id].join('/')));
  // state of the breakpoint at this output: 'on', 'off', 'hit' (the run stopped at it), or '' if there is none
  const stop = useStudio((s) => {
    if (pin.side === 'in' || s.breakpoints.length === 0) return '';
    const flat = circuit.flat_output(node.id, pin.name);
    if (s.breakpoint_hit !== null && s.breakpoint_hit.pin === flat) return 'hit';
    const here = s.breakpoints.filter((b) => b.pin === flat);
    return here.length === 0 ? '' : here.some((b) => b.on) ? 'on' : 'off';
  });
  let fit = '';
  if (connecting && circuit.view) fit = same_pin(connecting, own) ? ' source' : why_not(circuit.view, connecting, own) === null ? ' fits' : ' unfit';
  const [, y] = pin_offset(node, pin.side, index);
  const fresh = pin.name === new_pin;
  return (
    <div className={`pin-row ${pin.side}${fit}${pin.wired ? ' wired' : ''}${at ? ' at' : ''}${target ? ' target' : ''}${bad ? ' bad-pin' : ''}${stop ? ` stop-${stop}` : ''}`} style={{ top: y - 11 }} title={fresh ? 'Connect a wire here to add a pin to the circuit' : pin_title(pin)} data-pin={`${node.id}.${pin.name}`} data-side={pin.side}>
      <Handle
        type={pin.side === 'in' ? 'target' : 'source'}
        position={pin.side === 'in' ? Position.Left : Position.Right}
        id={`${pin.side}:${pin.name}`}
        className={`pin hue-${hue_of(pin.type)}${fresh ? ' fresh' : ''}`}
        role="img"
        aria-label={`${pin.side === 'in' ? 'Input' : 'Output'} ${fresh ? 'new pin' : pin.name}, ${pin.type}`}
        onDoubleClick={(e) => {
          e.stopPropagation();
          circuit.toggle_probe(own);
        }}
      />
      {stop && <span className={`stop-dot${stop === 'off' ? ' off' : ''}`} title={stop === 'off' ? 'Breakpoint, switched off' : stop === 'hit' ? 'The run stopped at this breakpoint' : 'Breakpoint'} />}
      <span className="pin-name">{fresh ? 'new pin' : pin.name}</span>
      {pin.side === 'in' && pin.required && !pin.wired && node.lsi && node.lsi.values?.[pin.name] === undefined && node.kind !== 'missing' && <span className="open-mark" title="Required input: connect a wire or set a value">○</span>}
    </div>
  );
}

/** The title of an LSI; a text field while it is renamed (double click, F2 or menu). */
function Title({ node }: { node: ViewNode }): ReactElement {
  const typing = useCircuit((s) => s.typing === node.id);
  if (!typing) return <span className="lsi-title">{node.title}</span>;
  return (
    <input
      className="lsi-title nodrag nopan"
      aria-label="Name"
      autoFocus
      defaultValue={node.title}
      spellCheck={false}
      onFocus={(e) => e.target.select()}
      onBlur={(e) => {
        circuit.rename(node.id, e.target.value);
        circuit.type_in(null);
      }}
      onKeyDown={(e) => {
        e.stopPropagation();
        if (e.key === 'Enter') e.currentTarget.blur();
        if (e.key === 'Escape') {
          e.currentTarget.value = node.title;
          e.currentTarget.blur();
        }
      }}
    />
  );
}

export const LsiNode = memo(function LsiNode({ data: { node }, selected }: NodeProps<LsiNodeType>): ReactElement {
  const cursor = useCircuit((s) => s.cursor === node.id && s.nodes.size > 0);
  const bad = useCircuit((s) => (s.problems.length > 0 ? circuit.problems_of(node.id).length : 0));
  const commenting = useCircuit((s) => s.typing === `comment:${node.id}`);
  return (
    <div
      className={`lsi kind-${node.kind}${selected ? ' selected' : ''}${cursor ? ' cursor' : ''}${bad ? ' bad' : ''}`}
      style={{ width: node.width, height: node.height }}
      role="group"
      aria-label={describe_node(node)}
      data-lsi={node.id}
    >
      <div className="lsi-head" style={{ height: head_height }} title={[node.subtitle || node.lsi?.type, node.doc].filter(Boolean).join('\n')}>
        <Title node={node} />
        {node.kind === 'missing' && <span className="missing-mark">missing</span>}
      </div>
      {node.kind === 'circuit' && <div className="lsi-stack" aria-hidden="true" />}
      {node.inputs.map((pin, i) => <Pin key={`in ${pin.name}`} node={node} pin={pin} index={i} />)}
      {node.outputs.map((pin, i) => <Pin key={`out ${pin.name}`} node={node} pin={pin} index={i} />)}
      {(node.note || commenting) && (
        commenting ? (
          <textarea
            className="lsi-note nodrag nopan nowheel"
            aria-label={`Comment on ${node.title}`}
            autoFocus
            defaultValue={node.note}
            onBlur={(e) => {
              circuit.comment(node.id, e.target.value);
              circuit.type_in(null);
            }}
            onKeyDown={(e) => {
              e.stopPropagation();
              if (e.key === 'Escape' || (e.key === 'Enter' && e.ctrlKey)) e.currentTarget.blur();
            }}
          />
        ) : <div className="lsi-note" onDoubleClick={(e) => { e.stopPropagation(); circuit.type_in(`comment:${node.id}`); }}>{node.note}</div>
      )}
      {bad > 0 && <ProblemBubble id={node.id} />}
    </div>
  );
});

export const NoteNode = memo(function NoteNode({ id, data: { note }, selected }: NodeProps<NoteNodeType>): ReactElement {
  const typing = useCircuit((s) => s.typing === id);
  const field = useRef<HTMLTextAreaElement>(null);
  useEffect(() => {
    if (typing) field.current?.focus();
  }, [typing]);
  return (
    <div className={`note${selected ? ' selected' : ''}`} role="note" aria-label={note.text || 'Empty note'} onDoubleClick={(e) => { e.stopPropagation(); circuit.type_in(id); }}>
      <NodeResizer isVisible={selected} minWidth={80} minHeight={40} onResizeEnd={(_e, p) => circuit.size_note(note.id, [p.x, p.y], [p.width, p.height])} />
      {typing ? (
        <textarea
          ref={field}
          className="nodrag nopan nowheel"
          aria-label="Note"
          defaultValue={note.text}
          onBlur={(e) => {
            circuit.write_note(note.id, e.target.value);
            circuit.type_in(null);
          }}
          onKeyDown={(e) => {
            e.stopPropagation();
            if (e.key === 'Escape' || (e.key === 'Enter' && e.ctrlKey)) e.currentTarget.blur();
          }}
        />
      ) : <p>{note.text || 'Double-click to edit'}</p>}
    </div>
  );
});

export const ProbeNode = memo(function ProbeNode({ data: { probe }, selected }: NodeProps<ProbeNodeType>): ReactElement {
  return (
    <div className={`probe${selected ? ' selected' : ''}`} role="figure" aria-label={`Curve of ${probe.pin}`}>
      <ProbeCurve probe={probe} />
    </div>
  );
});

/** The reason why a wire was refused, shown for 5 s where it was dropped. */
export function Refusal({ origin }: { origin: () => DOMRect | undefined }): ReactElement | null {
  const refusal = useCircuit((s) => s.refusal);
  const [shown, set_shown] = useState(refusal);
  useEffect(() => {
    set_shown(refusal);
    if (!refusal) return;
    const timer = setTimeout(() => circuit.forget_refusal(), 5000);
    return () => clearTimeout(timer);
  }, [refusal]);
  if (!shown) return null;
  const box = origin();
  return (
    <div className="refusal" role="alert" style={{ left: Math.min(shown.screen.x - (box?.left ?? 0) + 14, Math.max(8, (box?.width ?? 600) - 320)), top: Math.min(shown.screen.y - (box?.top ?? 0) + 10, Math.max(8, (box?.height ?? 300) - 70)) }}>
      {shown.text}
    </div>
  );
}
