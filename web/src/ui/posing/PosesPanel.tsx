/** Poses panel: the stored poses of the project that fit the selected character, with pictures; stores, applies, renames and removes them. */
import { useEffect, useMemo, useRef, useState, type KeyboardEvent, type ReactElement } from 'react';
import { find_character } from '../../core/document';
import { format_label } from '../../core/format';
import { find_poses, scope_links, type PoseScope, type StoredPose } from '../../core/posing/pose_library';
import type { MechanismData } from '../../core/protocol';
import { selected_character, shown_document } from '../../core/state';
import { picture_size } from '../../view/preview';
import { run, store_pose_of_selection } from '../actions';
import { plain_canvas, poser, session, usePoser, useStudio } from '../app';
import { Icon } from '../icons';
import { character_color, preview_renderer } from '../library/pictures';

const scopes: [PoseScope, string][] = [['all', 'Whole character'], ['joints', 'Joints without the root'], ['limb', 'Selected link and below']];

/** Poses of all links of the stored poses that fit a mechanism, by the id of the stored pose. */
function use_pictures(mechanism: string | undefined, poses: readonly StoredPose[] | undefined): ReadonlyMap<string, number[]> {
  const [pictures, set_pictures] = useState<ReadonlyMap<string, number[]>>(new Map());
  const revision = useStudio((s) => s.revision);
  const key = (poses ?? []).map((p) => p.id).join(' ');
  useEffect(() => {
    if (!mechanism || !key) return undefined;
    let current = true;
    session.ask({ op: 'poses', mechanism }).then(
      (reply) => current && set_pictures(new Map((reply.poses as { id: string; links: number[] }[]).map((p) => [p.id, p.links]))),
      () => undefined, // the mechanism has just been removed
    );
    return () => {
      current = false;
    };
  }, [mechanism, key, revision]);
  return pictures;
}

export function PosesPanel(): ReactElement {
  const doc = useStudio(shown_document);
  const id = useStudio(selected_character);
  const link = useStudio((s) => (s.selection.kind === 'character' ? s.selection.link : undefined));
  const posed = usePoser((s) => s.target?.character);
  const character = doc && id ? find_character(doc, id) : undefined;
  const mechanism = useStudio((s) => (character ? s.mechanisms[character.mechanism] : undefined));
  const [text, set_text] = useState('');
  const [chosen, set_chosen] = useState<string | null>(null);
  const [renamed, set_renamed] = useState<string | null>(null);
  const [share, set_share] = useState(100);
  const [mirror, set_mirror] = useState(false);
  const [scope, set_scope] = useState<PoseScope>('all');
  const pictures = use_pictures(character?.mechanism, doc?.poses);
  const poses = useMemo(() => (doc && mechanism ? find_poses(doc, mechanism, text) : []), [doc, mechanism, text]);
  const others = mechanism && doc ? (doc.poses?.length ?? 0) - find_poses(doc, mechanism, '').length : 0;
  const pose = poses.find((p) => p.id === chosen);
  const limb_missing = scope === 'limb' && link === undefined;
  const list = useRef<HTMLDivElement>(null);

  if (!doc) return <div className="panel empty">No project is open yet.</div>;
  if (!character || !mechanism)
    return (
      <div className="panel empty poses-empty">
        <strong>Poses</strong>
        <span>{doc.characters.length === 0 ? 'Add a character from the library first.' : 'Click a character to store its pose, or to apply a stored one.'}</span>
        {doc.characters.length > 0 && <button type="button" onClick={() => run('pose.tool')}>Pose characters</button>}
      </div>
    );

  const apply = async (wanted: StoredPose): Promise<void> => {
    if (limb_missing) return session.notify('Click a link in the viewport first: the pose is applied to it and the links below it.');
    if (!(await poser.ready())) return;
    const links = scope_links(mechanism, scope, link);
    await poser.apply({ type: 'pose', share: share / 100, joints: wanted.joints, ...(mirror ? { mirror } : {}), ...(links ? { links } : {}) }, `Apply pose ${wanted.name}`);
  };
  const store = async (): Promise<void> => {
    const made = await store_pose_of_selection();
    if (!made) return;
    set_text('');
    set_chosen(made);
    set_renamed(made);
  };
  const replace = async (wanted: StoredPose): Promise<void> => {
    const joints = await poser.capture();
    if (joints) void session.edit({ type: 'pose.set', id: wanted.id, pose: { joints, mechanism: character.mechanism } });
  };
  const remove = (wanted: StoredPose): void => {
    const at = poses.indexOf(wanted);
    set_chosen((poses[at + 1] ?? poses[at - 1])?.id ?? null);
    void session.edit({ type: 'pose.remove', id: wanted.id });
  };
  const rename = (name: string): void => {
    const now = poses.find((p) => p.id === renamed);
    if (now && name.trim() && name.trim() !== now.name) void session.edit({ type: 'pose.set', id: now.id, pose: { name: name.trim() } });
    set_renamed(null);
    requestAnimationFrame(() => {
      if (document.activeElement === document.body) list.current?.querySelector<HTMLElement>(`[data-pose="${renamed}"]`)?.focus();
    });
  };
  const keys = (event: KeyboardEvent<HTMLDivElement>): void => {
    if (renamed || event.ctrlKey || event.metaKey || event.altKey) return;
    const at = Math.max(0, poses.findIndex((p) => p.id === chosen));
    const columns = list.current ? getComputedStyle(list.current).gridTemplateColumns.split(' ').length : 1;
    const step = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: columns, ArrowUp: -columns }[event.key];
    if (step !== undefined) {
      const next = poses[Math.min(poses.length - 1, Math.max(0, at + step))];
      if (next) list.current?.querySelector<HTMLElement>(`[data-pose="${next.id}"]`)?.focus(); // which chooses it
    } else if (event.key === 'Enter' && pose) void apply(pose);
    else if (event.key === 'F2' && pose) set_renamed(pose.id);
    else if (event.key === 'Delete' && pose) remove(pose);
    else return;
    event.preventDefault();
    event.stopPropagation();
  };

  return (
    <div className="panel poses" role="group" aria-label="Poses">
      <div className="poses-head">
        <input type="search" value={text} placeholder="Search poses" aria-label="Search poses" onChange={(e) => set_text(e.target.value)} />
        <button type="button" className="store" title="Store the present pose of the character under a name  (Alt P)" onClick={() => void store()}><Icon name="add" /> Store pose</button>
      </div>
      {poses.length === 0 ? (
        <div className="poses-empty">
          <strong>{text ? 'No pose has this name' : 'No poses yet'}</strong>
          {!text && <span>Press E, pose {character.name}, then press Store pose. A stored pose can be applied at every time, whole or in part, and mirrored.</span>}
        </div>
      ) : (
        <div ref={list} className="pose-grid" role="listbox" aria-label={`Poses for ${character.name}`} onKeyDown={keys}>
          {poses.map((p, i) => (
            <div
              key={p.id}
              role="option"
              aria-selected={p.id === chosen}
              aria-label={p.name}
              data-pose={p.id}
              tabIndex={p.id === chosen || (!pose && i === 0) ? 0 : -1}
              className="pose-card"
              title={`${p.name}\nDouble-click: apply`}
              onClick={() => set_chosen(p.id)}
              onFocus={() => set_chosen(p.id)}
              onDoubleClick={() => void apply(p)}
            >
              <Picture mechanism={mechanism} links={pictures.get(p.id)} mirror={mirror && p.id === chosen} />
              {renamed === p.id ? <NameField name={p.name} done={rename} /> : <span className="pose-name">{p.name}</span>}
            </div>
          ))}
        </div>
      )}
      {others > 0 && <p className="hint poses-others">{others === 1 ? '1 pose is' : `${others} poses are`} for other bodies.</p>}
      {pose && (
        <div className="poses-foot">
          <label className="pose-share">
            <span>Apply</span>
            <input type="range" min={5} max={100} step={5} value={share} style={{ ['--fill' as string]: `${share}%` }} aria-label="Share of the pose, percent" onChange={(e) => set_share(Number(e.target.value))} />
            <output>{share} %</output>
          </label>
          <div className="pose-row">
            <button type="button" aria-pressed={mirror} title="Exchange left and right of the pose" onClick={() => set_mirror(!mirror)}><Icon name="mirror" /> Mirror</button>
            <select aria-label="Joints that the pose sets" value={scope} onChange={(e) => set_scope(e.target.value as PoseScope)}>
              {scopes.map(([value, label]) => (
                <option key={value} value={value}>{value === 'limb' && link !== undefined ? `${format_label(mechanism.links[link]?.label || mechanism.links[link]?.name || '')} and below` : label}</option>
              ))}
            </select>
          </div>
          <div className="pose-row">
            <button type="button" className="primary" disabled={limb_missing} title={`Apply the pose at the playhead  (Enter)${posed ? '' : '; switches the pose tool on'}`} onClick={() => void apply(pose)}>Apply</button>
            <button type="button" aria-label="Rename" title="Rename  (F2)" onClick={() => set_renamed(pose.id)}>Rename</button>
            <button type="button" title="Store the present pose of the character in place of this one" onClick={() => void replace(pose)}>Replace</button>
            <button type="button" title="Remove the stored pose  (Delete)" onClick={() => remove(pose)}>Delete</button>
          </div>
          {limb_missing && <p className="hint">Click a link in the viewport: the pose is applied to it and the links below it.</p>}
        </div>
      )}
    </div>
  );
}

function Picture({ mechanism, links, mirror }: { mechanism: MechanismData; links: number[] | undefined; mirror: boolean }): ReactElement {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const context = canvas.current?.getContext('2d', plain_canvas);
    if (!context || !links) return;
    preview_renderer()?.draw(mechanism, character_color, context, { count: 1, links: mechanism.links.length, duration: 0, values: Float32Array.from(links) });
  }, [mechanism, links]);
  return <canvas ref={canvas} className="pose-picture" data-mirror={mirror} width={picture_size.width} height={picture_size.height} aria-hidden="true" />;
}

function NameField({ name, done }: { name: string; done: (name: string) => void }): ReactElement {
  const input = useRef<HTMLInputElement>(null);
  useEffect(() => input.current?.select(), []);
  return (
    <input
      ref={input}
      className="pose-name"
      aria-label="Name of the pose"
      defaultValue={name}
      autoFocus
      onBlur={(e) => done(e.target.value)}
      onClick={(e) => e.stopPropagation()}
      onKeyDown={(e) => {
        if (e.key !== 'Enter' && e.key !== 'Escape') return;
        e.stopPropagation();
        if (e.key === 'Escape') e.currentTarget.value = name;
        e.currentTarget.blur();
      }}
    />
  );
}
