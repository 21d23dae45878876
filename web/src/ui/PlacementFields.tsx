/** The inspector's fields for the place of a character or a prop. */
import type { ReactElement } from 'react';
import { apply_command, type Character, type Command, type Place } from '../core/document';
import { session } from './app';
import { NumberField } from './NumberField';

/** @param height what Z means, shown as a hint */
export function PlacementFields({ character, height }: { character: Character; height?: string }): ReactElement {
  const { place } = character;
  const set = (key: keyof Place) => {
    const command = (value: number): Command => ({ type: 'character.set', id: character.id, place: { [key]: value } });
    const preview = (value: number | null): void => {
      const { document } = session.state;
      if (document) session.show_preview(value === null ? null : apply_command(document, command(value)));
    };
    return { on_preview: preview, on_commit: (value: number) => void session.edit(command(value)) };
  };
  return (
    <>
      <h4>Placement</h4>
      <NumberField label="X" unit="m" value={place.x} step={0.01} {...set('x')} />
      <NumberField label="Y" unit="m" value={place.y} step={0.01} {...set('y')} />
      <NumberField label="Z" unit="m" value={place.z} step={0.01} title={height} {...set('z')} />
      <NumberField label="Heading" unit="°" value={place.heading} step={1} digits={1} title="Rotation about the vertical axis, positive to the left" {...set('heading')} />
    </>
  );
}
