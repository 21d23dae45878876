/** The look panel: material of the selected character or link, lights, sky and ground. */
import type { ReactElement } from 'react';
import { apply_command, find_character, type Character, type Command, type ScenarioDocument } from '../../core/document';
import { format_label } from '../../core/format';
import { plain_look, type Look, type Sun } from '../../core/look';
import { clothes_of, grounds, materials, skies, type MaterialPreset } from '../../core/look_presets';
import { selected_character, shown_document } from '../../core/state';
import { session, useStudio } from '../app';
import { ColorField } from '../ColorField';
import { ChoiceField, NumberField } from '../NumberField';

const send = (command: Command): void => void session.edit(command);
const preview = (command: Command | null): void => {
  const { document } = session.state;
  if (document) session.show_preview(command ? apply_command(document, command) : null);
};
const degrees = 180 / Math.PI;

export function LookPanel(): ReactElement {
  const doc = useStudio(shown_document);
  const id = useStudio(selected_character);
  const link = useStudio((s) => (s.selection.kind === 'character' ? s.selection.link : undefined));
  if (!doc) return <div className="panel empty">No project is open yet.</div>;
  const character = id ? find_character(doc, id) : undefined;
  return (
    <div className="panel inspector look-panel" role="form" aria-label="Look">
      {character ? <MaterialFields key={character.id} character={character} link={link} /> : <p className="facts">Select a character to change its material.</p>}
      <LightFields doc={doc} />
    </div>
  );
}

/** What of a character with a skin is shown: value, text, title. */
const shown_choices = [
  ['skin', 'Skin', 'Show the skin of the character file'],
  ['body', 'Body', 'Show the body that is simulated'],
  ['both', 'Both', 'Show the body through the skin'],
] as const;
/** The same for a prop, whose skin is its surface with the textures of the file. */
const shown_of_props = [
  ['skin', 'Textures', 'Show the textures of the mesh file'],
  ['body', 'Colours', 'Show the mesh in the colours of its materials'],
] as const;

function MaterialFields({ character, link }: { character: Character; link: number | undefined }): ReactElement {
  const mechanism = useStudio((s) => s.mechanisms[character.mechanism]);
  const set = (fields: Partial<Character>): Command => ({ type: 'character.set', id: character.id, ...fields }) as Command;
  const color = character.color ?? '#e6e6ea';
  const { roughness = 0.6, metalness = 0, link_colors = {} } = character;
  const part = link !== undefined ? mechanism?.links[link] : undefined;
  const textured = character.prop !== undefined && mechanism?.skin !== undefined && character.shown !== 'body';
  const painted = !textured && (character.shape_colors ?? []).length > 0 && character.shape_colors!.every(Boolean);
  const clothes = mechanism ? clothes_of(mechanism) : [];
  const colors_with = (links: readonly string[], value: string | null): Command => {
    const colors = { ...link_colors };
    for (const name of links) {
      if (value === null) delete colors[name];
      else colors[name] = value;
    }
    return set({ link_colors: colors });
  };
  const take = (preset: MaterialPreset): void =>
    send(part ? colors_with([part.name], preset.color) : set({ ...(textured || painted ? {} : { color: preset.color }), roughness: preset.roughness, metalness: preset.metalness }));
  const number = (key: 'roughness' | 'metalness') => ({
    on_preview: (value: number | null) => preview(value === null ? null : set({ [key]: value })),
    on_commit: (value: number) => send(set({ [key]: value })),
  });
  const is_taken = (m: MaterialPreset): boolean => !part && (textured || painted || m.color === color) && m.roughness === roughness && m.metalness === metalness;
  return (
    <>
      <h3>
        Material <span className="of">{part ? `${character.name}, ${format_label(part.label || part.name)}` : character.name}</span>
      </h3>
      <div className="materials" role="group" aria-label="Materials">
        {materials.map((m) => (
          <button key={m.name} type="button" aria-pressed={is_taken(m)} title={part ? `Colour this part like ${m.name.toLowerCase()}` : `Make ${character.name} of ${m.name.toLowerCase()}`} onClick={() => take(m)}>
            <span className="ball" style={{ '--ball': m.color, '--shine': `${Math.round(100 * (1 - (m.roughness ?? 0.6)))}%` } as React.CSSProperties} data-metal={Boolean(m.metalness)} />
            {m.name}
          </button>
        ))}
      </div>
      {part ? (
        <>
          <ColorField label="Colour of the part" value={link_colors[part.name] ?? color} on_preview={(v) => preview(colors_with([part.name], v))} on_commit={(v) => send(colors_with([part.name], v))} />
          {link_colors[part.name] !== undefined && (
            <div className="actions">
              <button type="button" onClick={() => send(colors_with([part.name], null))}>Colour of the character</button>
            </div>
          )}
        </>
      ) : (
        <>
          {!textured && !painted && <ColorField label="Colour" value={color} on_preview={(v) => preview(set({ color: v }))} on_commit={(v) => send(set({ color: v }))} />}
          {textured && <p className="facts">Drawn with the textures of its file. <em>Colours</em> draws it in colours that you can change.</p>}
          {painted && <p className="facts">Its materials have colours of their own, which the inspector shows.</p>}
          <NumberField label="Roughness" value={roughness} step={0.01} min={0} max={1} slider title="0: sharp highlights, 1: matt" {...number('roughness')} />
          <NumberField label="Metal" value={metalness} step={0.01} min={0} max={1} slider title="0: plastic, skin, cloth, wood; 1: metal, which reflects sky and ground" {...number('metalness')} />
        </>
      )}
      {!part && mechanism?.skin && (
        <div className="segments" role="group" aria-label="Shown">
          {(character.prop ? shown_of_props : shown_choices).map(([shown, text, title]) => (
            <button key={shown} type="button" aria-pressed={(character.shown ?? 'skin') === shown} title={title} onClick={() => send(set({ shown }))}>
              {text}
            </button>
          ))}
        </div>
      )}
      {!part && clothes.length > 0 && (
        <>
          <h4>Parts</h4>
          {clothes.map(({ name, links }) => (
            <ColorField key={name} label={name} value={link_colors[links[0]!] ?? color} on_preview={(v) => preview(colors_with(links, v))} on_commit={(v) => send(colors_with(links, v))} />
          ))}
        </>
      )}
      {!part && Object.keys(link_colors).length > 0 && (
        <div className="actions">
          <button type="button" onClick={() => send(set({ link_colors: {} }))}>One colour for all parts</button>
        </div>
      )}
    </>
  );
}

function LightFields({ doc }: { doc: ScenarioDocument }): ReactElement {
  const look = { ...plain_look, ...doc.look };
  const set = (fields: Partial<Look>): Command => ({ type: 'scenario.set', look: { ...session.state.document?.look, ...fields } });
  const field = (make: (value: number) => Partial<Look>) => ({
    on_preview: (value: number | null) => preview(value === null ? null : set(make(value))),
    on_commit: (value: number) => send(set(make(value))),
  });
  const color = (make: (value: string) => Partial<Look>) => ({
    on_preview: (value: string) => preview(set(make(value))),
    on_commit: (value: string) => send(set(make(value))),
  });
  const sun = (fields: Partial<Sun>): Partial<Look> => ({ sun: { ...look.sun, ...fields } });
  const { sky } = look as Look;
  const taken = skies.find((s) => JSON.stringify(s.look.sky) === JSON.stringify(sky ?? null) && s.look.sun.elevation === look.sun.elevation)?.name;
  return (
    <>
      <h3>Sky</h3>
      <div className="materials skies" role="group" aria-label="Skies">
        {skies.map((s) => (
          <button key={s.name} type="button" aria-pressed={s.name === taken} onClick={() => send(set(s.look))}>
            <span className="sky-sample" style={{ background: s.look.sky ? `linear-gradient(${s.look.sky.zenith}, ${s.look.sky.horizon} 72%, #0004 72%)` : undefined }} />
            {s.name}
          </button>
        ))}
      </div>
      {sky && (
        <>
          <ColorField label="Zenith" value={sky.zenith} {...color((zenith) => ({ sky: { ...sky, zenith } }))} />
          <ColorField label="Horizon" value={sky.horizon} {...color((horizon) => ({ sky: { ...sky, horizon } }))} />
        </>
      )}
      <h4>Lights</h4>
      <NumberField label="Brightness" value={look.light} step={0.01} min={0} max={2} slider title="Brightness of all lights" {...field((light) => ({ light }))} />
      <NumberField label="Sun" value={look.sun.intensity} step={0.01} min={0} max={4} slider title="Intensity of the light that casts shadows" {...field((intensity) => sun({ intensity }))} />
      <ColorField label="Sun colour" value={look.sun.color} {...color((value) => sun({ color: value }))} />
      <NumberField label="Sun direction" unit="°" value={look.sun.azimuth * degrees} step={1} digits={0} min={-180} max={360} slider title="Direction in which the sun stands, about the vertical axis from X" {...field((v) => sun({ azimuth: v / degrees }))} />
      <NumberField label="Sun height" unit="°" value={look.sun.elevation * degrees} step={0.5} digits={0} min={6} max={90} slider title="Angle of the sun above the horizon; a low sun makes long shadows" {...field((v) => sun({ elevation: v / degrees }))} />
      <NumberField label="Ambient" value={look.ambient} step={0.01} min={0} max={4} slider title="Light from all sides, which brightens the shadows" {...field((ambient) => ({ ambient }))} />
      <h4>Ground</h4>
      <ChoiceField label="Pattern" value={look.pattern} choices={grounds} on_commit={(pattern) => send(set({ pattern }))} />
      <ColorField label="Colour" value={look.floor} {...color((floor) => ({ floor }))} />
    </>
  );
}
