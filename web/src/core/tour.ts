/** Steps of the tour for the first start, and the place of its card. */
export interface Step {
  /** CSS selector of the part of the page. */
  part: string;
  title: string;
  text: string;
}

export const tour_steps: readonly Step[] = [
  { part: '.library', title: 'Begin with a character', text: 'Drag a mechanism or a motion from the library onto the floor or a track. Motion files (BVH, C3D, glTF, FBX …) can be dropped anywhere on the page.' },
  { part: '.scenario', title: 'Arrange motions in time', text: 'Each character has a track. Drag clips to move them, drag their edges to trim them, overlap two clips to blend them. Space plays.' },
  { part: '.viewport', title: 'Look and pose', text: 'Drag to turn the view, turn the wheel to zoom. Press E to pose: drag a hand or a foot, or turn joints by their arcs. Every change sets keys.' },
  { part: '.modes', title: 'Let physics act', text: 'Simulate replaces the recorded poses by dynamics. While it runs, drag a character to pull it. Shift+P adds a push at the playhead.' },
  { part: '.inspector', title: 'Change what is selected', text: 'The inspector shows the fields of what you clicked. Rest the pointer on a field to read its meaning. Ctrl+Z undoes every change.' },
  { part: '[data-command="page.keys"]', title: 'Help', text: 'F1 shows all keys, Ctrl+K finds every command by its name. “Take the tour” starts this tour again.' },
];

export interface Box {
  left: number;
  top: number;
  width: number;
  height: number;
}

/** Place of the card beside a part: on the side with the most room, inside of the window. Sizes in px. */
export function card_place(part: Box, card: { width: number; height: number }, window: { width: number; height: number }): { left: number; top: number } {
  const gap = 12;
  const rooms = [
    { room: part.left, left: part.left - card.width - gap, top: part.top + part.height / 2 - card.height / 2 },
    { room: window.width - part.left - part.width, left: part.left + part.width + gap, top: part.top + part.height / 2 - card.height / 2 },
    { room: (part.top * window.width) / window.height, left: part.left + part.width / 2 - card.width / 2, top: part.top - card.height - gap },
    { room: ((window.height - part.top - part.height) * window.width) / window.height, left: part.left + part.width / 2 - card.width / 2, top: part.top + part.height + gap },
  ].sort((a, b) => b.room - a.room);
  const { left, top } = rooms[0]!;
  const inside = (value: number, size: number, total: number): number => Math.max(gap, Math.min(total - size - gap, value));
  return { left: inside(left, card.width, window.width), top: inside(top, card.height, window.height) };
}
