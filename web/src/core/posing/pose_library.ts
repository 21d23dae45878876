/** The stored poses of a scenario document (docs/scenario.md, "Stored poses"): which of them fit a mechanism, and which joints they set. */
import type { Command, ScenarioDocument } from '../document';
import type { MechanismData } from '../protocol';

export interface StoredPose {
  id: string;
  name: string;
  /** Id of the mechanism of the posed character. */
  mechanism: string;
  /** Coordinates of the joints; the root is at x = y = 0 with heading 0. */
  joints: { link: string; q: number[] }[];
}

/**
 * The joints that a stored pose sets: all; all except the root, so that height and tilt of the character stay; or those from one link to the
 * ends of its limbs.
 */
export type PoseScope = 'all' | 'joints' | 'limb';

/** True if the mechanism has all links of the pose. */
export function fits(pose: StoredPose, mechanism: MechanismData): boolean {
  if (pose.mechanism === mechanism.id) return true;
  const names = new Set(mechanism.links.map((l) => l.name));
  return pose.joints.every((joint) => names.has(joint.link));
}

/** Stored poses that fit the mechanism and whose names contain all words of `text`. */
export function find_poses(doc: ScenarioDocument, mechanism: MechanismData, text: string): StoredPose[] {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  return (doc.poses ?? []).filter((pose) => fits(pose, mechanism) && words.every((word) => pose.name.toLowerCase().includes(word)));
}

/** Names of the links whose joints a pose sets; undefined: all. @param link index of the selected link, for the scope `limb` */
export function scope_links(mechanism: MechanismData, scope: PoseScope, link: number | undefined): string[] | undefined {
  if (scope === 'all' || (scope === 'limb' && link === undefined)) return undefined;
  const { links } = mechanism;
  if (scope === 'joints') return links.filter((l) => l.parent >= 0).map((l) => l.name);
  const below = (index: number): boolean => {
    for (let i = index; i >= 0; i = links[i]!.parent) if (i === link) return true;
    return false;
  };
  return links.filter((_l, i) => below(i)).map((l) => l.name);
}

/** A name for a new pose that no stored pose has: "Pose 3". */
export function new_pose_name(doc: ScenarioDocument): string {
  const used = new Set((doc.poses ?? []).map((p) => p.name));
  let n = used.size + 1;
  while (used.has(`Pose ${n}`)) n++;
  return `Pose ${n}`;
}

export const store_pose = (id: string, name: string, mechanism: string, joints: StoredPose['joints']): Command => ({ type: 'pose.add', pose: { id, name, mechanism, joints } });
