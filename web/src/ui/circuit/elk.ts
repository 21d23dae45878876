/** The layout engine (ELK) in a web worker, loaded at first use. */
import type { ElkGraph } from '../../core/circuit/layout';

type Engine = { layout(graph: ElkGraph): Promise<ElkGraph> };
let engine: Promise<Engine> | null = null;

export async function lay_out(graph: ElkGraph): Promise<ElkGraph> {
  engine ??= Promise.all([import('elkjs/lib/elk-api.js'), import('elkjs/lib/elk-worker.min.js?url')]).then(
    ([{ default: Elk }, { default: url }]) => new Elk({ workerFactory: () => new Worker(url) }) as unknown as Engine,
  );
  return (await engine).layout(graph);
}
