/** Commands that add props where the viewport looks. */
import * as THREE from 'three';
import type { Command } from '../core/document';
import { add_mesh_prop, add_prop, prop_kinds, prop_shapes, type PlainShape } from '../core/props';
import type { LibraryEntry } from '../core/protocol';
import { imports, library, parts, session } from './app';
import { is_fixed_prop, place_on_ground } from './GroundNotes';

const in_view = (): { x: number; y: number } => parts.viewport?.looks_at ?? { x: 0, y: 0 };

async function add_and_select(make: (id: string) => Command): Promise<void> {
  const id = session.fresh_id('p');
  if (await session.edit(make(id))) session.select({ kind: 'character', character: id });
}

export function insert_prop(shape: PlainShape): void {
  const { document } = session.state;
  if (document) void add_and_select((id) => add_prop(document, shape, in_view(), id));
}

/** Adds a prop with the mesh of a library entry. @param at m; absent: where the viewport looks */
export async function insert_mesh(entry: LibraryEntry, at?: { x: number; y: number }): Promise<void> {
  const { document } = session.state;
  if (document) await add_and_select((id) => add_mesh_prop(document, entry, at ?? in_view(), id));
}

parts.add_mesh = (id, at) => {
  void library.find(id).then((entry) => entry && insert_mesh(entry, at));
};

/** The point on the ground under the mouse, if it is in the viewport; otherwise where the viewport looks, m. */
export function place_of_drop(event: { clientX: number; clientY: number; target: EventTarget | null }): { x: number; y: number } {
  const inside = event.target instanceof Element && event.target.closest('.viewport') !== null;
  const at = inside && parts.viewport?.on_plane(event.clientX, event.clientY, new THREE.Plane(new THREE.Vector3(0, 0, 1), 0));
  return at && at.length() < 100 ? { x: at.x, y: at.y } : in_view();
}

/** Lets the user choose a mesh file, which becomes a prop. */
export function insert_mesh_file(): void {
  const input = document.createElement('input');
  input.type = 'file';
  input.multiple = true; // an .obj with its .mtl
  input.accept = '.glb,.gltf,.obj,.stl,.ply,.dae,.fbx,.mtl,.bin';
  input.onchange = () => void imports.add([...(input.files ?? [])], in_view());
  input.click();
}

const has_document = (): boolean => session.state.document !== null;

/** The selected character, if it can be placed on the ground. */
function placeable(): string | null {
  const { document, selection, transport } = session.state;
  const id = selection.kind === 'character' && transport.mode === 'edit' ? selection.character : null;
  return document?.characters.some((c) => c.id === id && !is_fixed_prop(c)) ? id : null;
}

function ground_selection(): void {
  const { document } = session.state;
  const id = placeable();
  const command = document && id && place_on_ground(document, [id]);
  if (command) void session.edit(command);
  else session.notify('The character already stands on the ground.');
}

export const prop_commands = [
  ...prop_shapes.map((shape) => ({
    id: `prop.${shape}`,
    label: `Add prop: ${prop_kinds[shape].name.toLowerCase()}`,
    group: 'Edit' as const,
    enabled: has_document,
    run: (): void => insert_prop(shape),
  })),
  { id: 'edit.ground', label: 'Place the selected character on the ground', group: 'Edit' as const, enabled: (): boolean => placeable() !== null, run: ground_selection },
  { id: 'prop.mesh', label: 'Add prop: mesh file (GLB, OBJ, STL, PLY, DAE)…', group: 'Edit' as const, enabled: has_document, run: insert_mesh_file },
];
