/** React Flow components of the wires in view and of the wire that is being drawn. */
import { BaseEdge, type ConnectionLineComponentProps, type Edge, type EdgeProps } from '@xyflow/react';
import { memo, type ReactElement } from 'react';
import { hue_of } from '../../core/circuit/classes';
import { wire_path, type ViewWire } from '../../core/circuit/view';
import { circuit } from '../app';

export type WireEdgeType = Edge<{ wire: ViewWire; loop: boolean }, 'wire'>;

const WireEdge = memo(function WireEdge({ id, data, sourceX, sourceY, targetX, targetY, selected }: EdgeProps<WireEdgeType>): ReactElement {
  const wire = data!.wire;
  return (
    <BaseEdge
      id={id}
      path={wire_path([sourceX, sourceY], [targetX, targetY])}
      interactionWidth={14}
      className={`wire-line${selected ? ' selected' : ''}${wire.delayed ? ' delayed' : ''}${data!.loop ? ' loop' : ''}`}
      style={{ stroke: selected || data!.loop ? undefined : `var(--pin-${hue_of(wire.type)})` }}
    />
  );
});

export function ConnectionLine({ fromX, fromY, toX, toY, fromHandle, connectionStatus }: ConnectionLineComponentProps): ReactElement {
  const backwards = fromHandle.type === 'target';
  const { connecting } = circuit.state;
  const type = connecting ? (circuit.view?.pin(connecting.node, connecting.side, connecting.pin)?.type ?? 'any') : 'any';
  const path = backwards ? wire_path([toX, toY], [fromX, fromY]) : wire_path([fromX, fromY], [toX, toY]);
  return <path d={path} className={`wire-line drawing ${connectionStatus ?? ''}`} style={{ stroke: connectionStatus === 'invalid' ? 'var(--bad)' : `var(--pin-${hue_of(type)})` }} />;
}

export const edge_types = { wire: WireEdge };
