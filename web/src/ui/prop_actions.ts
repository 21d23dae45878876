/** Commands that add props where the viewport looks. */
import { add_prop, prop_kinds, prop_shapes, type PropShape } from '../core/props';
import { parts, session } from './app';

export function insert_prop(shape: PropShape): void {
  const { document } = session.state;
  if (!document) return;
  const id = session.fresh_id('p');
  const at = parts.viewport?.looks_at ?? { x: 0, y: 0 };
  void session.edit(add_prop(document, shape, at, id)).then((done) => {
    if (done) session.select({ kind: 'character', character: id });
  });
}

export const prop_commands = prop_shapes.map((shape) => ({
  id: `prop.${shape}`,
  label: `Add prop: ${prop_kinds[shape].name.toLowerCase()}`,
  group: 'Edit' as const,
  enabled: (): boolean => session.state.document !== null,
  run: (): void => insert_prop(shape),
}));
