/** The inspector's fields of a gait: every change makes the motion again, in one undo step. */
import { useEffect, useState, type ReactElement } from 'react';
import type { Clip } from '../../core/document';
import { kind_labels, path_length, smooth_path, style_labels, with_lead, type GaitRecipe, type Gaits, type GaitStage } from '../../core/motion/gait';
import { gaits, useDesk, useGaits, useStudio } from '../app';
import { Icon } from '../icons';
import { ChoiceField, NumberField, SwitchField } from '../NumberField';

const usual_stage: GaitStage = { time: 0, kind: 'walk', speed: 1, turn: 0 };

export function GaitFields({ character, clip, gait }: { character: string; clip: Clip; gait: GaitRecipe }): ReactElement {
  const mechanism = useStudio((s) => s.document?.characters.find((c) => c.id === character)?.mechanism);
  const busy = useDesk((s) => s.tasks.length > 0);
  const drawing = useGaits((s) => s.drawing?.clip === clip.id);
  const [about, set_about] = useState<Gaits | null>(null);
  useEffect(() => {
    let valid = true;
    gaits.about(character).then((found) => valid && set_about(found), () => valid && set_about(null));
    return () => {
      valid = false;
    };
  }, [character, mechanism]);
  const target = { character, clip: clip.id };
  const set = (fields: Partial<GaitRecipe>): void => void gaits.change(target, fields);
  const kinds = about?.kinds ?? [{ kind: gait.kind, speed: gait.speed }];
  const kind_choices = kinds.map(({ kind }): [string, string] => [kind, kind_labels[kind] ?? kind]);
  const stages = gait.stages ?? [];
  const path = gait.path ?? [];
  const set_stage = (i: number, fields: Partial<GaitStage>): void => set({ stages: stages.map((s, k) => (k === i ? { ...s, ...fields } : s)) });
  const add_stage = (): void => {
    const last = stages.at(-1) ?? { ...usual_stage, kind: gait.kind, speed: gait.speed, turn: gait.turn };
    const time = Math.round(Math.min(gait.seconds * 0.9, Math.max(last.time + 2, gait.seconds / 2)) * 10) / 10;
    set({ stages: [...stages, { ...last, time }] });
  };
  return (
    <section className="gait-fields" aria-label="Gait" aria-busy={busy}>
      <h4>Gait</h4>
      {kind_choices.length > 1 && <ChoiceField label="Kind" value={gait.kind} choices={kind_choices} title="The order in which the feet step" on_commit={(kind) => set({ kind, speed: kinds.find((k) => k.kind === kind)?.speed ?? -1 })} />}
      <NumberField label="Speed" unit="m/s" value={gait.speed} step={0.01} min={0} max={12} title="Speed forward; 0: the body stands" on_commit={(speed) => set({ speed })} />
      {path.length === 0 && <NumberField label="Turn" unit="°/s" value={gait.turn} step={0.5} digits={1} min={-180} max={180} title="Turn rate, positive to the left" on_commit={(turn) => set({ turn })} />}
      <ChoiceField label="Style" value={gait.style} choices={(about?.styles ?? [gait.style]).map((s): [string, string] => [s, style_labels[s] ?? s])} title="How the body carries itself" on_commit={(style) => set({ style })} />
      {path.length === 0 ? (
        <>
          <NumberField label="Duration" unit="s" value={gait.seconds} step={0.1} min={0.5} max={600} title="Duration of the motion" on_commit={(seconds) => set({ seconds })} />
          <SwitchField label="From standing" value={gait.from_stand} title="The body stands at first. Off: it walks from the first frame on" on_commit={(from_stand) => set({ from_stand })} />
          <SwitchField label="To standing" value={gait.to_stand} title="The body stops at the end" on_commit={(to_stand) => set({ to_stand })} />
        </>
      ) : (
        <p className="facts">
          {path_length(smooth_path(with_lead(path))).toFixed(1)} m in {gait.seconds.toFixed(1)} s, from standing to standing.
        </p>
      )}
      {stages.map((stage, i) => (
        <div key={i} className="gait-stage" role="group" aria-label={`Change ${i + 1}`}>
          <div className="gait-stage-head">
            <span>Change {i + 1}</span>
            <button type="button" className="tool" aria-label={`Remove change ${i + 1}`} title="Remove this change" onClick={() => set({ stages: stages.filter((_s, k) => k !== i) })}>
              <Icon name="close" />
            </button>
          </div>
          <NumberField label="At" unit="s" value={stage.time} step={0.05} min={0} max={600} title="Time in the motion from which on the body goes otherwise" on_commit={(time) => set_stage(i, { time })} />
          {kind_choices.length > 1 && <ChoiceField label="Kind" value={stage.kind} choices={kind_choices} on_commit={(kind) => set_stage(i, { kind, speed: kinds.find((k) => k.kind === kind)?.speed ?? stage.speed })} />}
          <NumberField label="Speed" unit="m/s" value={stage.speed} step={0.01} min={0} max={12} on_commit={(speed) => set_stage(i, { speed })} />
          {path.length === 0 && <NumberField label="Turn" unit="°/s" value={stage.turn} step={0.5} digits={1} min={-180} max={180} on_commit={(turn) => set_stage(i, { turn })} />}
        </div>
      ))}
      <div className="actions">
        {drawing ? (
          <button type="button" onClick={() => void gaits.finish()}>Done</button>
        ) : (
          <button type="button" disabled={busy} title="Click points on the floor; the body goes through them" onClick={() => void gaits.draw(target)}>{path.length > 0 ? 'Draw again' : 'Draw path'}</button>
        )}
        {path.length > 0 && <button type="button" disabled={busy} title="The body no longer follows the path" onClick={() => set({ path: [] })}>Remove path</button>}
        <button type="button" disabled={busy} title="From a time on, another speed, turn rate or kind" onClick={add_stage}>Add change</button>
      </div>
    </section>
  );
}
