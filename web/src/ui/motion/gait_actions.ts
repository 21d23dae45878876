/** Commands on gaits. */
import { find_character, track_end } from '../../core/document';
import { selected_character } from '../../core/state';
import { desk, session } from '../app';

/** The character that a new gait moves: the selected one, or the only one. */
export function body_for_gait(): string | null {
  const { document } = session.state;
  const bodies = document?.characters.filter((c) => !c.prop) ?? [];
  const selected = selected_character(session.state);
  if (selected) return bodies.some((c) => c.id === selected) ? selected : null;
  return bodies.length === 1 ? bodies[0]!.id : null;
}

/** Lets the character walk after its last clip. */
export function add_gait(): void {
  const id = body_for_gait();
  const character = id && session.state.document ? find_character(session.state.document!, id) : undefined;
  if (!character) return;
  const moving = (session.state.characters.find((c) => c.id === id)?.end_speed ?? 0) > 0.3; // m/s: the last clip ends in a walk, which goes on
  void desk.make_gait({ character: character.id, start: track_end(character), ...(moving ? { gait: { from_stand: false } } : {}) });
}
