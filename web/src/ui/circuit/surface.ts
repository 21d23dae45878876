/** The canvas on the screen: viewport, size, and conversion between window px and circuit coordinates. */
import { useReactFlow, useStoreApi, type ReactFlowInstance } from '@xyflow/react';
import { useMemo, type RefObject } from 'react';
import type { Point } from '../../core/circuit/form';
import type { Box } from '../../core/circuit/spatial';
import type { WireEdgeType } from './edges';
import type { AnyNode } from './elements';
import type { Viewport } from './paint';

/** A position in the window, px. */
export interface Client {
  x: number;
  y: number;
}

export interface Surface {
  flow: ReactFlowInstance<AnyNode, WireEdgeType>;
  viewport(): Viewport;
  /** Size of the panel, px. */
  size(): { width: number; height: number };
  /** Visible area in circuit coordinates, enlarged by `around` px on each side. */
  seen(around?: number): Box;
  /** Rectangle of the panel in the window, px. */
  origin(): DOMRect | undefined;
  to_plane(client: Client): Point;
  /** Position of the pointer; the panel's centre while the pointer is elsewhere. */
  here(): Client;
  /** Calls `listener` after each pan, zoom and resize. @return function that removes the listener */
  on_move(listener: () => void): () => void;
}

export function useSurface(panel: RefObject<HTMLDivElement | null>, pointer: RefObject<Client | null>): Surface {
  const flow = useReactFlow<AnyNode, WireEdgeType>();
  const store = useStoreApi();
  return useMemo(() => {
    const viewport = (): Viewport => {
      const [x, y, zoom] = store.getState().transform;
      return { x, y, zoom };
    };
    const size = () => ({ width: panel.current?.clientWidth || 1, height: panel.current?.clientHeight || 1 });
    const origin = () => panel.current?.getBoundingClientRect();
    return {
      flow, viewport, size, origin,
      seen: (around = 0) => {
        const { x, y, zoom } = viewport();
        const { width, height } = size();
        return { x: (-x - around) / zoom, y: (-y - around) / zoom, width: (width + 2 * around) / zoom, height: (height + 2 * around) / zoom };
      },
      to_plane: (client) => {
        const p = flow.screenToFlowPosition(client, { snapToGrid: false });
        return [p.x, p.y];
      },
      here: () => {
        const box = origin();
        return pointer.current ?? { x: (box?.left ?? 0) + (box?.width ?? 0) / 2, y: (box?.top ?? 0) + (box?.height ?? 0) / 2 };
      },
      on_move: (listener) =>
        store.subscribe((now, before) => {
          if (now.transform !== before.transform || now.width !== before.width || now.height !== before.height) listener();
        }),
    };
  }, [flow, store, panel, pointer]);
}
