/** Reports which characters are inside a prop that does not move, such as the hills of a terrain, and places them on the ground by one click. */
import { useEffect, useState, type ReactElement } from 'react';
import { find_character, type Character, type Command, type ScenarioDocument } from '../core/document';
import { format_number } from '../core/format';
import { parts, session, useStudio } from './app';

const deep = 0.03; // m: feet of measured motions sink in less

export const is_fixed_prop = (character: Character): boolean => character.prop !== undefined && !(character.prop.mass > 0);

/** The command that places characters on the ground at the playhead; null: all stand on it. */
export function place_on_ground(doc: ScenarioDocument, ids: readonly string[]): Command | null {
  const commands = ids.flatMap((id): Command[] => {
    const character = find_character(doc, id);
    const lift = parts.viewport?.standing(id)?.lift ?? 0;
    if (!character || Math.abs(lift) < 5e-4) return [];
    return [{ type: 'character.set', id, place: { z: Math.round((character.place.z + lift) * 1000) / 1000 } }];
  });
  if (commands.length === 0) return null;
  return { type: 'group', label: 'Place on the ground', commands };
}

interface Note {
  id: string;
  name: string;
  depth: number;
  prop: string;
}

/** Characters of `doc` that are inside fixed props at the playhead. @param about id of a character; of a fixed prop, the characters inside it are meant */
function find_notes(doc: ScenarioDocument, about: string): Note[] {
  const own = find_character(doc, about);
  if (!own || !doc.characters.some(is_fixed_prop)) return [];
  const asked = is_fixed_prop(own) ? doc.characters.filter((c) => !is_fixed_prop(c)) : [own];
  return asked.flatMap(({ id, name }) => {
    const found = parts.viewport?.standing(id);
    if (!found?.prop || found.lift < deep || (asked.length > 1 && found.prop !== about) || (is_fixed_prop(own) && found.prop !== about)) return [];
    return [{ id, name, depth: found.lift, prop: find_character(doc, found.prop)?.name ?? '' }];
  });
}

export function GroundNotes({ about }: { about: string }): ReactElement | null {
  const edit = useStudio((s) => s.transport.mode === 'edit');
  const [notes, set_notes] = useState<Note[]>([]);
  useEffect(() => {
    if (!edit) return set_notes([]);
    let seen: unknown[] = [];
    let text = '';
    const look = (): void => {
      const { document, preview } = session.state;
      const now = [document, preview, parts.viewport?.pictures];
      if (!document || preview || now.every((value, i) => value === seen[i])) return;
      seen = now;
      const found = find_notes(document, about);
      const words = JSON.stringify(found.map((n) => [n.id, n.prop, n.depth.toFixed(2)]));
      if (words !== text) set_notes(found);
      text = words;
    };
    look();
    const timer = setInterval(look, 300);
    return () => clearInterval(timer);
  }, [edit, about]);
  if (notes.length === 0) return null;
  const place = (): void => {
    const { document } = session.state;
    const command = document && place_on_ground(document, notes.map((n) => n.id));
    if (command) void session.edit(command);
  };
  return (
    <div className="ground-notes" role="status">
      {notes.map((n) => (
        <p key={n.id}>{n.name} is {format_number(100 * n.depth, 0)} cm inside {n.prop} at the playhead.</p>
      ))}
      <div className="actions">
        <button type="button" title="Change the height of the character so that it touches the ground at the playhead. In a simulation it then follows the ground" onClick={place}>Place on the ground</button>
      </div>
    </div>
  );
}
