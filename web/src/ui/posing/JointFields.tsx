/** The joint of the selected link in the inspector: angles within their limits, pin, and what drags move. */
import { useRef, type ReactElement } from 'react';
import { run } from '../actions';
import { poser, usePoser } from '../app';
import { NumberField, SwitchField } from '../NumberField';

const axis_names = ['X', 'Y', 'Z'];

export function JointFields({ character, link, label }: { character: string; link: number; label: string }): ReactElement {
  const on = usePoser((s) => s.on);
  const target = usePoser((s) => s.target);
  const reply = usePoser((s) => s.reply);
  const pinned = usePoser((s) => (s.pins[character] ?? s.reply?.planted ?? []).includes(link));
  const facts = usePoser(() => poser.joints_of(character)?.[link]);
  const began = useRef(false);
  if (!on) {
    return (
      <div className="actions">
        <button type="button" title="Rotate joints, drag hands and feet  (E)" onClick={() => run('pose.tool')}>Pose</button>
      </div>
    );
  }
  if (!target || target.character !== character || !reply || !facts) return <p className="facts">{poser.why_not()}</p>;
  const angles = reply.angles[link] ?? [];
  const set = (dof: number, value: number, scale: number): void => {
    if (!began.current && !(began.current = poser.begin())) return;
    poser.drag({ type: 'set', link, dof, value: value / scale });
  };
  return (
    <>
      {angles.map((x, dof) => {
        const d = facts.dofs[dof]!;
        const scale = d.turns ? 180 / Math.PI : 100;
        const round = (v: number): number => Math.round(v * 10) / 10;
        const name = angles.length === 1 ? (d.turns ? 'Angle' : 'Shift') : `${d.turns ? 'Rotation' : 'Shift'} ${axis_names[dof] ?? dof + 1}`;
        const limited = d.lower !== null && d.upper !== null;
        return (
          <NumberField
            key={dof}
            label={name}
            unit={d.turns ? '°' : 'cm'}
            digits={1}
            value={round(x * scale)}
            step={0.5}
            {...(limited ? { min: round(d.lower! * scale), max: round(d.upper! * scale), slider: true } : {})}
            title={limited ? `From ${round(d.lower! * scale)} to ${round(d.upper! * scale)} ${d.turns ? 'degrees' : 'cm'}` : 'Without limits'}
            on_preview={(v) => {
              if (v !== null) return set(dof, v, scale);
              began.current = false;
              return poser.cancel();
            }}
            on_commit={(v) => {
              set(dof, v, scale);
              began.current = false;
              void poser.finish(`Rotate ${label}`);
            }}
          />
        );
      })}
      <SwitchField label="Pinned" value={pinned} title="The link keeps its place while the body is dragged  (P)" on_commit={() => poser.toggle_pin(character, link)} />
    </>
  );
}
