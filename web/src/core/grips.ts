/** Events `grab` and `release` of the scenario document: how long a grip lasts, and sentences that describe it. */
import { find_character, type ScenarioDocument, type ScenarioEvent } from './document';
import { format_label, format_number } from './format';

export const is_grip = (event: ScenarioEvent): boolean => event.type === 'grab' || event.type === 'release';

/** End of a grab, s: the next grab or release of the same link, or the end of the scenario. A grip can open earlier, at its limit. */
export function grip_end(document: ScenarioDocument, grab: ScenarioEvent): number {
  const ends = document.events.filter((e) => is_grip(e) && e.id !== grab.id && e.character === grab.character && e.link === grab.link && e.time > grab.time).map((e) => e.time);
  return Math.min(...ends, Math.max(document.duration, grab.time));
}

/** "Anna hand left grabs bar, up to 450 N". @param label of a link of a character */
export function describe_grip(event: ScenarioEvent, document: ScenarioDocument, label: (character: string, link: string) => string): string {
  const name = event.character ? (find_character(document, event.character)?.name ?? event.character) : '';
  const hand = `${name} ${format_label(label(event.character ?? '', event.link ?? '')).toLowerCase()}`.trim();
  if (event.type === 'release') return `release · ${hand}`;
  const other = event.other ? (find_character(document, event.other)?.name ?? event.other) : 'the world';
  return `grab · ${hand} on ${other}, up to ${format_number(event.limit ?? 450, 0)} N`;
}
