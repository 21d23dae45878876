/** Curves panel: the keys of a layer of a clip, the curves of its joints, and the motion without the layer. */
import { useEffect, useMemo, useRef, useState, type ReactElement } from 'react';
import { find_character, find_clip, type Clip, type Command } from '../../core/document';
import { format_label } from '../../core/format';
import { curve_id, curves_of, sample, set_tangent, type Curve, type KeyPick } from '../../core/posing/curves';
import { motion_time, type KeyedLayer } from '../../core/posing/keys';
import { clip_at } from '../../core/posing/poser';
import type { CurvesReply, RecordedEvent } from '../../core/protocol';
import { selected_character } from '../../core/state';
import { run } from '../actions';
import { poser, session, usePoser, useStudio } from '../app';
import { Icon } from '../icons';
import { NumberField } from '../NumberField';
import { CurvePlot } from './CurvePlot';

/** Drawn while the clip has no layer. */
const no_layer: KeyedLayer = { id: '', name: '', mode: 'additive', weight: 1, ease_in: null, ease_out: null, joints: [] };
const record_wait = 1000; // ms between two requests for the recorded curves while the simulation runs

/** Joints of a character in the recorded simulation; null while nothing was simulated. */
function use_recorded(character: string | undefined, links: readonly string[]): RecordedEvent | null {
  const recorded = useStudio((s) => s.recorded);
  const some = useStudio((s) => s.transport.simulated > 0);
  const frames = useStudio((s) => s.transport.simulated);
  const key = links.join(' ');
  const asked = useRef(0);
  useEffect(() => {
    if (!character || !some || key === '') return undefined;
    const timer = setTimeout(() => {
      asked.current = Date.now();
      session.ask({ op: 'recorded', character, links: [...links] }).catch(() => undefined); // the next change of the simulation asks again
    }, Math.max(0, asked.current + record_wait - Date.now()));
    return () => clearTimeout(timer);
  }, [character, key, some, frames]);
  return some && recorded?.character === character ? recorded : null;
}

const send = (command: Command): void => void session.edit(command);

/** The clip whose curves are shown: the selected one, or that of the selected character at the playhead. */
function use_clip(): { character: string; clip: Clip } | null {
  const doc = useStudio((s) => s.document);
  const selection = useStudio((s) => s.selection);
  const character = useStudio(selected_character);
  const time = useStudio((s) => s.transport.time);
  if (!doc || !character) return null;
  const clip = selection.kind === 'clip' ? find_clip(doc, character, selection.clip) : (clip_at(doc, character, time) ?? find_character(doc, character)?.track[0]);
  return clip ? { character, clip } : null;
}

export function CurvesPanel(): ReactElement {
  const shown = use_clip();
  const layers = usePoser((s) => s.layers);
  const selection = useStudio((s) => s.selection);
  const revision = useStudio((s) => s.revision);
  const mechanism = useStudio((s) => {
    const id = shown && s.document ? find_character(s.document, shown.character)?.mechanism : undefined;
    return id ? s.mechanisms[id] : undefined;
  });
  const joints = usePoser((s) => (mechanism ? s.joints[mechanism.id] : undefined));
  const [reply, set_reply] = useState<CurvesReply | null>(null);
  const [hidden, set_hidden] = useState<ReadonlySet<string>>(new Set());
  const [picks, set_picks] = useState<readonly KeyPick[]>([]);
  const layer = shown ? poser.layer_of({ character: shown.character, clip: shown.clip.id }) : null;
  const link = selection.kind === 'character' && selection.link !== undefined ? mechanism?.links[selection.link]?.name : undefined;
  const wanted = useMemo(() => [...new Set([...(layer?.joints.map((j) => j.link) ?? []), ...(link ? [link] : [])])].slice(0, 64), [layer, link]);
  const target = shown ? `${shown.character} ${shown.clip.id}` : '';
  const key = wanted.join(' ');
  void layers;
  const recorded = use_recorded(shown?.character, wanted);

  useEffect(() => {
    if (shown) void poser.need_joints(shown.character);
  }, [target]);
  useEffect(() => set_picks([]), [target, layer?.id]);
  useEffect(() => {
    if (!shown || wanted.length === 0) {
      set_reply(null);
      return undefined;
    }
    let current = true;
    session.ask({ op: 'curves', character: shown.character, clip: shown.clip.id, links: wanted }).then(
      (answer) => current && set_reply(answer as unknown as CurvesReply),
      (error: Error) => current && session.fail(error),
    );
    return () => {
      current = false;
    };
  }, [target, key, revision]);

  const curves = useMemo(() => {
    const translates = (name: string, component: number): boolean => {
      const index = mechanism?.links.findIndex((l) => l.name === name) ?? -1;
      return joints?.[index]?.dofs[component]?.turns === false;
    };
    const order = (c: Curve): number => (c.link === link ? -1 : (mechanism?.links.findIndex((l) => l.name === c.link) ?? 0));
    return reply ? curves_of(reply, layer, translates).sort((a, b) => order(a) - order(b)) : [];
  }, [reply, layer, joints, mechanism, link]);

  if (!shown) return <div className="panel empty">Select a character with a clip to see the curves of its joints.</div>;
  const { character, clip } = shown;
  const name_of = (c: Curve): string => {
    const l = mechanism?.links.find((x) => x.name === c.link);
    return format_label(l?.label || c.link);
  };
  const several = (c: Curve): boolean => curves.some((o) => o.link === c.link && o.part === c.part && o.component !== c.component);
  const suffix = (c: Curve): string => (c.part === 'position' ? ` ${'xyz'[c.component]} position` : several(c) ? ` ${'xyz'[c.component]}` : '');
  const tangents: ['smooth' | 'linear' | 'step' | 'flat', string][] = [['smooth', 'Smooth tangents'], ['flat', 'Flat tangents'], ['linear', 'Linear'], ['step', 'Step: constant until the next key']];
  const edit = (put: ReturnType<typeof set_tangent>, label: string): void => {
    if (layer) void poser.edit_keys({ character, clip: clip.id }, layer, { put }, label);
  };
  const remove = (): void => {
    if (!layer || picks.length === 0) return;
    const take = picks.filter((p, i) => picks.findIndex((o) => o.link === p.link && o.part === p.part && o.time === p.time) === i).map(({ link: l, part, time }) => ({ link: l, part, time }));
    void poser.edit_keys({ character, clip: clip.id }, layer, { take }, take.length === 1 ? 'Remove key' : `Remove ${take.length} keys`);
    set_picks([]);
  };
  const status = picks.length > 0 ? `${picks.length === 1 ? '1 key' : `${picks.length} keys`} selected · ${picks[0]!.time.toFixed(2)} s in the motion` : layer && layer.joints.length > 0 ? 'Drag keys to move them; Alt breaks a tangent.' : curves.length > 0 ? 'No keys yet. Press E and turn the joint to set one.' : '';
  return (
    <div className="panel curves" role="group" aria-label="Curves">
      <div className="curves-side">
        <LayerHead character={character} clip={clip} layer={layer} />
        {curves.length === 0 ? (
          <p className="hint curves-hint">{layer && layer.joints.length > 0 ? 'Loading…' : 'Click a joint in the viewport to see its curve.'}</p>
        ) : (
          <ul className="curve-list" aria-label="Curves of joints">
            {curves.map((c) => (
              <CurveRow key={curve_id(c)} curve={c} name={name_of(c)} suffix={suffix(c)} reply={reply!} clip={clip} hidden={hidden.has(curve_id(c))} selected={c.link === link}
                toggle={() => set_hidden((h) => { const next = new Set(h); if (!next.delete(curve_id(c))) next.add(curve_id(c)); return next; })}
                select={() => {
                  const index = mechanism?.links.findIndex((l) => l.name === c.link) ?? -1;
                  if (index >= 0) session.select({ kind: 'character', character, link: index });
                }}
              />
            ))}
          </ul>
        )}
      </div>
      <div className="curves-main">
        <div className="curves-tools" role="toolbar" aria-label="Keys">
          {tangents.map(([tangent, label]) => (
            <button key={tangent} type="button" aria-label={label} title={`${label} for the selected keys`} disabled={!layer || picks.length === 0} onClick={() => layer && edit(set_tangent(layer, picks, tangent), 'Set tangents')}><Icon name={tangent} /></button>
          ))}
          <button type="button" disabled={!layer || picks.length === 0} title="Remove the selected keys  (Del)" onClick={remove}>Delete</button>
          <span className="curves-status" title={status}>{status}</span>
          {curves.length > 0 && (
            <span className="curves-legend" aria-hidden="true">
              <span><i />with keys</span>
              <span><i className="dotted" />motion</span>
              <span><i className="simulated" />{recorded ? 'simulated' : 'not simulated yet'}</span>
            </span>
          )}
        </div>
        {curves.length > 0 && reply ? (
          <CurvePlot character={character} clip={clip} layer={layer ?? no_layer} reply={reply} recorded={recorded} curves={curves.filter((c) => !hidden.has(curve_id(c)))} link={link && curves.some((c) => c.link === link) ? link : null} picks={picks} set_picks={set_picks} remove={remove} />
        ) : (
          <div className="curves-empty">
            <strong>No keys yet</strong>
            <span>Press E, drag a hand or turn a joint in the viewport. Its keys appear here.</span>
            <button type="button" onClick={() => run('pose.tool')}>Pose characters</button>
          </div>
        )}
      </div>
    </div>
  );
}

function LayerHead({ character, clip, layer }: { character: string; clip: Clip; layer: KeyedLayer | null }): ReactElement | null {
  const on = (command: 'layer.set', value: Record<string, unknown>): void => {
    if (layer) send({ type: command, character, clip: clip.id, layer: layer.id, value } as Command);
  };
  const add = (mode: 'additive' | 'replace'): void => {
    const id = session.fresh_id('l');
    const name = `Layer ${(clip.layers?.length ?? 0) + 1}`;
    void session.edit({ type: 'layer.add', character, clip: clip.id, value: { id, name, mode, weight: 1, ease_in: 0.3, ease_out: 0.3 } }).then((ok) => ok && poser.choose_layer(clip.id, id));
  };
  const layers = clip.layers ?? [];
  return (
    <div className="layer-head">
      <div className="layer-row">
        <label htmlFor="layer-choice">Layer</label>
        <select id="layer-choice" value={layer?.id ?? layers[layers.length - 1]?.id ?? ''} disabled={layers.length === 0} onChange={(e) => poser.choose_layer(clip.id, e.target.value)}>
          {layers.length === 0 && <option value="">none</option>}
          {layers.map((l) => <option key={l.id} value={l.id}>{`${l.name}${l.on === false ? ' (off)' : ''}`}</option>)}
        </select>
        <button type="button" className="quiet" aria-label="Add a layer" title="Add a layer of keys above the others" onClick={() => add('additive')}>+</button>
        {layers.length > 0 && <button type="button" className="quiet" aria-label="Remove the layer" title="Remove the layer with its keys" onClick={() => send({ type: 'layer.remove', character, clip: clip.id, layer: (layer ?? layers[layers.length - 1]!).id })}><Icon name="close" /></button>}
      </div>
      {layers.filter((l) => l.on === false).map((l) => (
        <button key={l.id} type="button" className="quiet" onClick={() => send({ type: 'layer.set', character, clip: clip.id, layer: l.id, value: { on: true } })}>Switch on “{l.name}”</button>
      ))}
      {layer && (
        <>
          <div className="layer-row">
            <span className="segments" role="group" aria-label="Mode of the layer">
              <button type="button" aria-pressed={layer.mode === 'additive'} disabled={layer.joints.length > 0 && layer.mode !== 'additive'} title="Keys are added to the motion" onClick={() => on('layer.set', { mode: 'additive' })}>Add</button>
              <button type="button" aria-pressed={layer.mode === 'replace'} disabled={layer.joints.length > 0 && layer.mode !== 'replace'} title="Keys replace the motion of their joints. The mode can be changed while the layer has no keys" onClick={() => on('layer.set', { mode: 'replace' })}>Replace</button>
            </span>
            <button type="button" className="quiet" title="Leave the layer out" onClick={() => on('layer.set', { on: false })}>Off</button>
          </div>
          <NumberField label="Weight" unit="%" value={Math.round(layer.weight * 1000) / 10} step={1} digits={0} min={1} max={100} title="Share of the layer in the motion" on_commit={(v) => on('layer.set', { weight: v / 100 })} />
          <NumberField label="Ease in" unit="s" value={layer.ease_in ?? 0} step={0.01} min={0} max={60} title="Time before the first key in which the layer fades in" on_commit={(v) => on('layer.set', { ease_in: v })} />
          <NumberField label="Ease out" unit="s" value={layer.ease_out ?? 0} step={0.01} min={0} max={60} title="Time after the last key in which the layer fades out" on_commit={(v) => on('layer.set', { ease_out: v })} />
        </>
      )}
    </div>
  );
}

function CurveRow({ curve, name, suffix, reply, clip, hidden, selected, toggle, select }: { curve: Curve; name: string; suffix: string; reply: CurvesReply; clip: Clip; hidden: boolean; selected: boolean; toggle: () => void; select: () => void }): ReactElement {
  const time = useStudio((s) => s.transport.time);
  const value = sample(curve.result, reply.from, reply.step, motion_time(clip, time, reply.duration)) * curve.scale;
  return (
    <li className="curve-row" data-hidden={hidden} data-selected={selected} data-keyed={curve.keys.length > 0}>
      <button type="button" className="curve-name" onClick={select}>
        <span className="dot" style={{ background: `var(--curve-${curve.component % 3})` }} />
        <span className="label">{name}<em>{suffix}</em></span>
        <span className="value">{`${value.toFixed(1).replace('-', '−')}${curve.unit === '°' ? '°' : ' cm'}`}</span>
      </button>
      <button type="button" className="curve-eye" aria-pressed={!hidden} aria-label={`Show ${name}${suffix}`} onClick={toggle}><Icon name="eye" /></button>
    </li>
  );
}
