/** The cards of the player: root assist of the characters, and variables of the content. */
import { assist_of_cap, CharacterState, state_of, type Frame } from '../core/frames';
import { variable_text } from '../core/variables';
import type { Engine, Scene } from './engine';

const max_lines = 4; // further characters are not listed

/** Lists the root assist of the characters that follow a track; hides the card if there are none. */
export function show_assist(card: HTMLElement, scene: Scene, frame: Frame): void {
  const tracked = scene.characters.filter((c) => c.tracks);
  const lines: HTMLElement[] = [];
  scene.characters.forEach((c, i) => {
    const at = frame.characters[i];
    if (!c.tracks || !at || lines.length >= max_lines) return;
    const released = state_of(frame, at) === CharacterState.released;
    const over = assist_of_cap(frame, at);
    const line = document.createElement('div');
    line.dataset.grade = released || over > 0.7 ? 'bad' : over > 0.3 ? 'fair' : 'good';
    const [name, value] = [document.createElement('span'), document.createElement('span')];
    name.textContent = tracked.length > 1 ? `Assist, ${c.name}` : 'Root assist';
    value.textContent = released ? 'released' : `${(100 * over * c.assist_limit).toFixed(1)} %`;
    line.append(name, value);
    lines.push(line);
  });
  card.hidden = lines.length === 0;
  card.replaceChildren(...lines);
}

/** Lists the variables of the content; hides the card if there are none. */
export function show_variables(board: HTMLElement, engine: Engine): void {
  const variables = engine.scene.variables ?? [];
  board.hidden = variables.length === 0;
  if (board.childElementCount !== variables.length)
    board.replaceChildren(
      ...variables.map((variable) => {
        const row = document.createElement('div');
        row.append(Object.assign(document.createElement('dt'), { textContent: variable.name }), document.createElement('dd'));
        return row;
      }),
    );
  variables.forEach((variable, i) => (board.children[i]!.lastElementChild!.textContent = variable_text(variable, engine.variables[i] ?? variable.initial)));
}
