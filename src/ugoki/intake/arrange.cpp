#include "ugoki/intake/arrange.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "ugoki/base/number.h"
#include "ugoki/body/joint_names.h"
#include "ugoki/body/limb_geometry.h"
#include "ugoki/intake/coincident_joints.h"
#include "ugoki/intake/conversion_report.h"
#include "ugoki/intake/correction.h"
#include "ugoki/intake/deform_bones.h"
#include "ugoki/intake/four_legs.h"
#include "ugoki/intake/headless.h"
#include "ugoki/intake/hip_root.h"
#include "ugoki/intake/join_branches.h"
#include "ugoki/intake/limb_ends.h"
#include "ugoki/intake/paw_ends.h"
#include "ugoki/intake/tree_edit.h"
#include "ugoki/intake/usual_plan.h"

namespace ugoki::intake {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

void keep_joints(MeasuredMotion& m, std::span<const char> keep) {
  const std::size_t n = m.skeleton.joints.size();
  const std::vector<std::vector<Pose>> world = world_of(m);
  const std::vector<Vec3> rest = rest_positions(m.skeleton);
  std::vector<int> place(n, -1);
  std::vector<int> kept;
  std::vector<SkeletonJoint> joints;
  for (std::size_t i = 0; i < n; ++i) {
    if (keep[i] == 0) continue;
    SkeletonJoint j = m.skeleton.joints[i];
    int parent = j.parent;
    while (parent >= 0 && keep[at(parent)] == 0) parent = m.skeleton.joints[at(parent)].parent;
    if (parent != j.parent) {
      j.offset = rest[i] - (parent < 0 ? Vec3{} : rest[at(parent)]);
      j.translates = true;
    }
    j.parent = parent < 0 ? -1 : place[at(parent)];
    place[i] = static_cast<int>(joints.size());
    kept.push_back(static_cast<int>(i));
    joints.push_back(std::move(j));
  }
  // Joints whose parent stays keep their local values exactly.
  std::vector<Vec3> translations;
  std::vector<Quat> rotations;
  for (std::size_t f = 0; f < at(m.frames); ++f)
    for (const int i : kept) {
      int parent = m.skeleton.joints[at(i)].parent;
      if (parent < 0 || keep[at(parent)] != 0) {
        translations.push_back(m.translations[f * n + at(i)]);
        rotations.push_back(m.rotations[f * n + at(i)]);
        continue;
      }
      while (parent >= 0 && keep[at(parent)] == 0) parent = m.skeleton.joints[at(parent)].parent;
      const Pose local = parent < 0 ? world[f][at(i)] : world[f][at(parent)].inverse() * world[f][at(i)];
      translations.push_back(local.p);
      rotations.push_back(to_quat(local.R));
    }
  m.skeleton.joints = std::move(joints);
  m.translations = std::move(translations);
  m.rotations = std::move(rotations);
}

std::vector<std::string> attach_to_rigid_ancestors(std::span<MeasuredMotion> motions) {
  constexpr double rigid = 3e-4;  // m: maximum shift relative to a rigid ancestor; also at most a tenth of the shift relative to the parent
  std::vector<std::string> names;
  const std::size_t n = motions[0].skeleton.joints.size();
  std::vector<int> parents;
  for (const SkeletonJoint& j : motions[0].skeleton.joints) parents.push_back(j.parent);
  const auto shift_to_parent = [&](std::size_t i) {
    double shift = 0;
    for (const MeasuredMotion& m : motions)
      for (std::size_t f = 1; f < at(m.frames); ++f) shift = std::max(shift, norm(m.translations[f * n + i] - motions[0].translations[i]));
    return shift;
  };
  std::vector<std::pair<std::size_t, double>> shifting;
  for (std::size_t i = 0; i < n; ++i)
    if (parents[i] >= 0 && parents[at(parents[i])] >= 0)
      if (const double shift = shift_to_parent(i); shift > 2 * rigid) shifting.emplace_back(i, shift);
  if (shifting.empty()) return names;
  std::vector<std::vector<std::vector<Pose>>> worlds;
  for (const MeasuredMotion& m : motions) worlds.push_back(world_of(m));
  for (const auto& [i, shift] : shifting)
    for (int a = parents[at(parents[i])]; a >= 0; a = parents[at(a)]) {
      const auto local = [&](const std::vector<Pose>& X) { return X[at(a)].inverse() * X[i].p; };
      const Vec3 first = local(worlds[0][0]);
      double worst = 0;
      for (const auto& world : worlds)
        for (const auto& X : world) worst = std::max(worst, norm(local(X) - first));
      if (worst > std::min(rigid, 0.1 * shift)) continue;
      names.push_back(motions[0].skeleton.joints[i].name);
      const std::vector<Vec3> rest = rest_positions(motions[0].skeleton);
      for (MeasuredMotion& m : motions) {
        m.skeleton.joints[i].parent = a;
        m.skeleton.joints[i].offset = rest[i] - rest[at(a)];
      }
      break;
    }
  if (!names.empty())
    for (std::size_t k = 0; k < motions.size(); ++k) set_world(motions[k], worlds[k]);
  return names;
}

namespace {

/// Number of joints below each joint, without itself.
std::vector<int> descendants(const Skeleton& s) {
  std::vector<int> count(s.joints.size(), 0);
  for (std::size_t i = s.joints.size(); i-- > 0;)
    for (int a = s.joints[i].parent; a >= 0; a = s.joints[at(a)].parent) ++count[at(a)];
  return count;
}

}  // namespace

std::vector<std::string> attach_fore_limbs_to_spine(std::span<MeasuredMotion> motions) {
  constexpr double rigid = 0.05;  // share of the skeleton's extent; the body holds a limb's root at its mean place, so this is its error
  std::vector<std::string> names;
  const Skeleton& s = motions[0].skeleton;
  const std::size_t n = s.joints.size();
  const std::vector<std::vector<Pose>> samples = sample_poses(motions);
  if (samples.empty()) return names;
  std::vector<std::string> joint_names;
  for (const SkeletonJoint& j : s.joints) joint_names.push_back(j.name);
  const std::vector<body::NameEvidence> evidence = body::read_joint_names(joint_names);
  std::vector<int> new_parent(n, -1);
  for (std::size_t hub = 0; hub < n; ++hub) {
    std::vector<std::size_t> fore, hind;
    int spine = -1;  // child of the hub that carries neck and head, but is neither
    for (std::size_t i = 0; i < n; ++i) {
      if (s.joints[i].parent != static_cast<int>(hub) || evidence[i].helper) continue;
      const body::Part part = evidence[i].part;
      bool carries_head = false;
      for (std::size_t k = 0; k < n; ++k)
        carries_head = carries_head || (evidence[k].part == body::Part::head && is_below(s, static_cast<int>(k), static_cast<int>(i)));
      if (carries_head) {
        if (part != body::Part::head && part != body::Part::neck) spine = static_cast<int>(i);
      } else if (evidence[i].fore || body::is_arm(part)) {
        fore.push_back(i);
      } else if (evidence[i].hind || body::is_leg(part)) {
        hind.push_back(i);
      }
    }
    if (fore.size() < 2 || hind.size() < 2 || spine < 0) continue;
    const double limit = rigid * extent_of(samples[0]);
    if (!std::ranges::all_of(fore, [&](std::size_t i) { return quantile(deviations(samples, i, at(spine)), 0.8) < limit; })) continue;
    for (const std::size_t i : fore) {
      new_parent[i] = spine;
      names.push_back(s.joints[i].name);
    }
  }
  if (!names.empty()) reparent(motions, new_parent);
  return names;
}

std::vector<std::string> attach_to_rigid_joints(std::span<MeasuredMotion> motions) {
  // Lengths are shares of the skeleton's extent. Baked inverse kinematics leaves errors below 1 % except where a limb cannot reach its
  // target. In animations of games a limb does not reach its target in up to 15 % of the frames (jumps, rolls).
  constexpr double min_shift = 0.05, rigid = 0.01, reached = 0.8, loose = 0.1, mostly = 0.95, same_place = 0.02, longest = 0.35,
                   usual = 0.06;
  std::vector<std::string> names;
  const std::size_t n = motions[0].skeleton.joints.size();
  const std::vector<std::vector<Pose>> samples = sample_poses(motions);
  if (samples.size() < 10) return names;
  const Skeleton& s = motions[0].skeleton;
  const double extent = extent_of_trees(s, samples[0]);
  const std::vector<int> below = descendants(s);
  const std::size_t main_root = at(static_cast<int>(std::ranges::max_element(below) - below.begin()));
  const auto stays = [&](const std::vector<double>& d) {
    return quantile(d, reached) < rigid * extent && quantile(d, mostly) < loose * extent;
  };
  std::vector<int> new_parent(n, -1);
  const auto is_below_now = [&](std::size_t joint, std::size_t ancestor) {
    for (int k = static_cast<int>(joint); k >= 0; k = new_parent[at(k)] >= 0 ? new_parent[at(k)] : s.joints[at(k)].parent)
      if (at(k) == ancestor) return true;
    return false;
  };
  // Only the end of a limb can lack its foot or hand: joints below it only twist it.
  std::vector<char> is_end(n, 1);
  for (std::size_t i = 0; i < n; ++i)
    for (int a = s.joints[i].parent; a >= 0; a = s.joints[at(a)].parent)
      if (is_end[at(a)] != 0 && !stays(deviations(samples, i, at(a)))) is_end[at(a)] = 0;
  std::vector<char> shifts(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    if (i == main_root) continue;
    const int parent = s.joints[i].parent;
    const std::vector<double> d = parent < 0 ? std::vector<double>{} : deviations(samples, i, at(parent));
    shifts[i] = parent < 0 || (d.back() >= min_shift * extent && !stays(d)) ? 1 : 0;
  }
  // Another character that moves in the same way is no foot.
  const auto is_small = [&](std::size_t i) {
    for (std::size_t k = 0; k < n; ++k)
      if (is_below(s, static_cast<int>(k), static_cast<int>(i)) && norm(samples[0][k].p - samples[0][i].p) > longest * extent) return false;
    return true;
  };
  for (std::size_t i = 0; i < n; ++i) {
    if (shifts[i] == 0 || !is_small(i)) continue;
    std::size_t best = n;
    double smallest = rigid * extent;
    bool follows = false;
    for (std::size_t a = 0; a < n && !follows; ++a) {
      if (shifts[a] != 0 || is_below_now(a, i)) continue;
      const std::vector<double> d = deviations(samples, i, a);
      if (!stays(d)) continue;
      if (norm(samples[0][a].p - samples[0][i].p) < same_place * extent) {
        // A joint at the same place is no end of a bone. If it carries other joints, joint i is its target or control.
        follows = below[a] > 0 || below[i] == 0;
      } else if (is_end[a] != 0 && norm(samples[0][a].p - samples[0][i].p) < longest * extent && quantile(d, reached) < smallest) {
        smallest = quantile(d, reached);
        best = a;
      }
    }
    if (follows || best == n) continue;
    names.push_back(s.joints[i].name);
    shifts[i] = 0;
    new_parent[i] = static_cast<int>(best);
  }
  // Animated limbs do not always reach the controls of their feet. A control that carries a foot belongs to the limb of its side whose end
  // is usually nearest to it.
  std::vector<std::string> joint_names;
  for (const SkeletonJoint& j : s.joints) joint_names.push_back(j.name);
  const std::vector<body::NameEvidence> evidence = body::read_joint_names(joint_names);
  for (std::size_t i = 0; i < n; ++i) {
    if (shifts[i] == 0 || !is_small(i) || !evidence[i].control || evidence[i].side == 0 || below[i] == 0) continue;
    std::size_t best = n;
    double smallest = usual * extent;
    for (std::size_t a = 0; a < n; ++a) {
      if (shifts[a] != 0 || is_end[a] == 0 || is_below_now(a, i) || evidence[a].helper || evidence[a].side != evidence[i].side) continue;
      if (evidence[a].fore != evidence[i].fore || evidence[a].hind != evidence[i].hind) continue;
      const double d = quantile(deviations(samples, i, a), 0.5), away = norm(samples[0][a].p - samples[0][i].p);
      if (away < same_place * extent || away > longest * extent || d >= smallest) continue;
      smallest = d;
      best = a;
    }
    if (best == n) continue;
    names.push_back(s.joints[i].name);
    shifts[i] = 0;
    new_parent[i] = static_cast<int>(best);
  }
  if (names.empty()) return names;
  reparent(motions, new_parent);
  return names;
}

void make_root(MeasuredMotion& m, int root) {
  const std::size_t n = m.skeleton.joints.size();
  std::vector<int> chain;  // root ... present root
  for (int i = root; i >= 0; i = m.skeleton.joints[at(i)].parent) chain.push_back(i);
  if (chain.size() < 2) return;
  std::vector<std::vector<Pose>> world = world_of(m);
  std::vector<Vec3> rest = rest_positions(m.skeleton);
  // Each reversed joint moves to the position of its former child on the chain.
  for (std::size_t k = chain.size(); k-- > 1;) {
    const auto i = at(chain[k]), child = at(chain[k - 1]);
    const Vec3 shift = rest[child] - rest[i];
    for (Vec3& e : m.skeleton.joints[i].end_sites) e -= shift;
  }
  for (auto& X : world) {
    std::vector<Vec3> before;
    for (const int i : chain) before.push_back(X[at(i)].p);
    for (std::size_t k = 1; k < chain.size(); ++k) X[at(chain[k])].p = before[k - 1];
  }
  {
    std::vector<Vec3> before;
    for (const int i : chain) before.push_back(rest[at(i)]);
    for (std::size_t k = 1; k < chain.size(); ++k) rest[at(chain[k])] = before[k - 1];
  }
  std::vector<int> parent(n);
  for (std::size_t i = 0; i < n; ++i) parent[i] = m.skeleton.joints[i].parent;
  for (std::size_t k = 1; k < chain.size(); ++k) parent[at(chain[k])] = chain[k - 1];
  parent[at(root)] = -1;
  // Parents first.
  std::vector<int> order, place(n, -1);
  const auto add = [&](auto&& self, int i) -> void {
    place[at(i)] = static_cast<int>(order.size());
    order.push_back(i);
    for (std::size_t c = 0; c < n; ++c)
      if (parent[c] == i) self(self, static_cast<int>(c));
  };
  add(add, root);
  for (std::size_t i = 0; i < n; ++i)
    if (place[i] < 0 && parent[i] < 0) add(add, static_cast<int>(i));
  std::vector<SkeletonJoint> joints;
  for (const int i : order) {
    SkeletonJoint j = m.skeleton.joints[at(i)];
    j.parent = parent[at(i)] < 0 ? -1 : place[at(parent[at(i)])];
    j.offset = rest[at(i)] - (parent[at(i)] < 0 ? Vec3{} : rest[at(parent[at(i)])]);
    if (i == root) j.translates = true;
    joints.push_back(std::move(j));
  }
  m.skeleton.joints = std::move(joints);
  for (auto& X : world) {
    std::vector<Pose> sorted;
    for (const int i : order) sorted.push_back(X[at(i)]);
    X = std::move(sorted);
  }
  set_world(m, world);
}

std::vector<std::string> merge_rigid_joints(std::span<MeasuredMotion> motions) {
  constexpr double same_place = 1e-6, turned = 1e-6;  // m and rad: rounding errors of files
  const std::size_t n = motions[0].skeleton.joints.size();
  std::vector<std::string> names;
  std::vector<char> keep(n, 1);
  std::vector<int> children(n, 0);
  for (const SkeletonJoint& j : motions[0].skeleton.joints)
    if (j.parent >= 0) ++children[at(j.parent)];
  for (std::size_t i = 0; i < n; ++i) {
    const SkeletonJoint& joint = motions[0].skeleton.joints[i];
    if (joint.parent < 0 || children[i] == 0 || norm(joint.offset) > same_place) continue;
    bool rigid = true;
    for (const MeasuredMotion& m : motions)
      for (std::size_t f = 0; f < at(m.frames) && rigid; ++f)
        rigid = norm(m.translations[f * n + i]) <= same_place && 2 * norm(m.rotations[f * n + i].vec()) <= turned;
    if (!rigid) continue;
    keep[i] = 0;
    names.push_back(joint.name);
  }
  if (names.empty()) return names;
  std::vector<char> translates;
  for (std::size_t i = 0; i < n; ++i)
    if (keep[i] != 0) translates.push_back(motions[0].skeleton.joints[i].translates ? 1 : 0);
  for (MeasuredMotion& m : motions) {
    keep_joints(m, keep);
    for (std::size_t i = 0; i < translates.size(); ++i) m.skeleton.joints[i].translates = translates[i] != 0;
  }
  return names;
}

namespace {
/// True if the sections of all limbs begin at the same joints.
bool same_sections(const body::Character& a, const body::Character& b) {
  const auto same = [](const body::Limb& x, const body::Limb& y) {
    return x.proximal == y.proximal && x.distal == y.distal && x.end == y.end;
  };
  return std::ranges::equal(a.legs, b.legs, same) && std::ranges::equal(a.arms, b.arms, same);
}

body::Character arrange_joints(std::span<MeasuredMotion> motions, std::vector<std::string>& report, const body::AnatomyMapping* mapping,
                               bool mesh_ends) {
  const MeasuredMotion* longest = &motions[0];
  for (const MeasuredMotion& m : motions)
    if (m.frames > longest->frames) longest = &m;
  // Ends of bones that were estimated from the mesh are used only if no character is recognised without them.
  std::vector<MeasuredMotion> with_ends;
  if (mesh_ends) {
    with_ends.assign(motions.begin(), motions.end());
    for (MeasuredMotion& m : motions)
      for (SkeletonJoint& j : m.skeleton.joints) j.end_sites.clear();
  }
  if (const std::vector<std::string> joints = attach_to_rigid_ancestors(motions); !joints.empty())
    report.push_back("Joints that shift relative to their parent, but not relative to a joint above it, were attached to that joint: " +
                     list_of(joints) + ".");
  body::Character character = body::recognise_character(*longest, mapping);
  const auto index = static_cast<std::size_t>(longest - motions.data());
  {
    std::vector<MeasuredMotion> attached(motions.begin(), motions.end());
    if (const std::vector<std::string> joints = attach_to_rigid_joints(attached); !joints.empty())
      if (body::Character better = body::recognise_character(attached[index], mapping); better.plan != body::BodyPlan::other) {
        std::ranges::move(attached, motions.begin());
        character = std::move(better);
        report.push_back(
            "Joints that stay at another joint than their parent (feet or hands driven by inverse kinematics) were attached to it: " +
            list_of(joints) + ".");
      }
  }
  if (character.plan == body::BodyPlan::other) {
    std::vector<MeasuredMotion> attached(motions.begin(), motions.end());
    attach_to_rigid_joints(attached);
    if (const std::vector<std::string> joints = attach_fore_limbs_to_spine(attached); !joints.empty())
      if (body::Character better = body::recognise_character(attached[index], mapping); better.plan != body::BodyPlan::other) {
        std::ranges::move(attached, motions.begin());
        character = std::move(better);
        report.push_back("Fore limbs at the same joint as the hind limbs were attached to the spine: " + list_of(joints) + ".");
      }
  }
  if (character.plan == body::BodyPlan::other)
    for (const bool with_chest : {false, true}) {  // a person whose head is a part of the trunk
      std::vector<MeasuredMotion> extended = with_ends.empty() ? std::vector<MeasuredMotion>(motions.begin(), motions.end()) : with_ends;
      attach_to_rigid_ancestors(extended);
      if (with_chest && add_chest(extended).empty()) continue;
      const std::vector<std::string> ends = add_limb_ends(extended);
      const std::string chest = add_head(extended);
      if (chest.empty()) continue;
      body::Character better = body::recognise_character(extended[index], mapping);
      if (better.plan != body::BodyPlan::human) continue;
      std::ranges::move(extended, motions.begin());
      character = std::move(better);
      report.push_back("No joint carries the head; a neck and a head that do not turn were added to " + chest + ".");
      if (!ends.empty())
        report.push_back("Joints that do not turn were added at the ends of limbs with one or two bones: " + list_of(ends) + ".");
      break;
    }
  if (character.plan == body::BodyPlan::other)
    for (int attempt = 0; attempt < (with_ends.empty() ? 4 : 8); ++attempt) {  // rigs with few bones; the last four without ends of meshes
      std::vector<MeasuredMotion> extended =
          with_ends.empty() || attempt >= 4 ? std::vector<MeasuredMotion>(motions.begin(), motions.end()) : with_ends;
      attach_to_rigid_ancestors(extended);
      if (attempt % 4 >= 2) attach_to_rigid_joints(extended);
      const bool with_chest = attempt % 2 == 1;
      const std::vector<std::string> limbs = with_chest ? add_chest(extended) : std::vector<std::string>{};
      if (with_chest && limbs.empty()) continue;
      const std::vector<std::string> ends = add_limb_ends(extended);
      if (limbs.empty() && ends.empty()) continue;
      body::Character better = body::recognise_character(extended[index], mapping);
      if (better.plan == body::BodyPlan::other) continue;
      std::ranges::move(extended, motions.begin());
      character = std::move(better);
      if (!limbs.empty())
        report.push_back("All limbs have one common joint; a joint for the chest was added, which carries " + list_of(limbs) + ".");
      if (!ends.empty())
        report.push_back("Joints that do not turn were added at the ends of limbs with one or two bones: " + list_of(ends) + ".");
      break;
    }
  if (character.plan == body::BodyPlan::other)
    for (const bool attach : {false, true}) {  // limbs, chest and head of a four-legged animal by what touches the ground
      std::vector<MeasuredMotion> completed = with_ends.empty() ? std::vector<MeasuredMotion>(motions.begin(), motions.end()) : with_ends;
      attach_to_rigid_ancestors(completed);
      if (attach) attach_to_rigid_joints(completed);
      const std::vector<std::string> changes = complete_four_legs(completed);
      if (changes.empty()) continue;
      const std::vector<std::string> ends = add_limb_ends(completed);
      body::Character better = body::recognise_character(completed[index], mapping);
      if (better.plan != body::BodyPlan::four_legs) continue;
      std::ranges::move(completed, motions.begin());
      character = std::move(better);
      report.insert(report.end(), changes.begin(), changes.end());
      if (!ends.empty())
        report.push_back("Joints that do not turn were added at the ends of limbs with one or two bones: " + list_of(ends) + ".");
      break;
    }
  if (character.plan == body::BodyPlan::other && character.pelvis >= 0 && character.chest >= 0) {
    // Legs and arms were found, but the root is between or beyond them. The joint that carries the legs becomes the root.
    std::vector<MeasuredMotion> turned(motions.begin(), motions.end());
    const std::string name = motions[0].skeleton.joints[at(character.pelvis)].name;
    for (MeasuredMotion& m : turned) make_root(m, character.pelvis);
    body::Character again = body::recognise_character(turned[index], mapping);
    if (again.plan != body::BodyPlan::other) {
      std::ranges::move(turned, motions.begin());
      character = std::move(again);
      report.push_back("The skeleton was re-rooted at joint " + name + ", which carries the legs.");
    }
  }
  if (character.plan == body::BodyPlan::other || consists_of_mechanisms(motions[0].skeleton, character)) {
    std::vector<MeasuredMotion> fewer = with_ends.empty() ? std::vector<MeasuredMotion>(motions.begin(), motions.end()) : with_ends;
    if (keep_deform_bones(fewer)) {
      std::vector<std::string> changes = {
          "The rig was reduced to the bones that deform its mesh (DEF-...), each attached to the next of them."};
      body::Character better = arrange_joints(fewer, changes, mapping, mesh_ends);
      if (better.plan != body::BodyPlan::other && (character.plan == body::BodyPlan::other || better.plan == character.plan)) {
        std::ranges::move(fewer, motions.begin());
        report = std::move(changes);
        return better;
      }
    }
  }
  if (character.plan == body::BodyPlan::other) {
    std::vector<MeasuredMotion> joined = with_ends.empty() ? std::vector<MeasuredMotion>(motions.begin(), motions.end()) : with_ends;
    if (const std::vector<std::string> joints = join_rigid_branches(joined); !joints.empty()) {
      std::vector<std::string> changes = {"Joints that move together with another branch were attached to it: " + list_of(joints) + "."};
      body::Character better = arrange_joints(joined, changes, mapping, mesh_ends);
      if (better.plan != body::BodyPlan::other) {
        std::ranges::move(joined, motions.begin());
        report = std::move(changes);
        return better;
      }
    }
  }
  if (character.plan == body::BodyPlan::other) {
    const std::vector<std::string> removed = remove_carrier_roots(motions);
    for (const std::string& joint : removed)
      report.push_back("Joint " + joint + " only carries " + motions[0].skeleton.joints[0].name + ", which moves relative to it; " + joint +
                       " is left out, and its movement was added to that joint.");
    if (!removed.empty()) character = body::recognise_character(*longest, mapping);
    if (character.plan == body::BodyPlan::other) return character;
  }
  const Skeleton& s = motions[0].skeleton;
  // The pelvis becomes the root of the character.
  const int root = character.pelvis;
  std::vector<char> keep(s.joints.size(), 0);
  std::vector<std::string> carriers, strangers;
  for (int i = 0; i < static_cast<int>(s.joints.size()); ++i) {
    keep[at(i)] = is_below(s, i, root) ? 1 : 0;
    if (keep[at(i)] != 0) continue;
    (is_below(s, root, i) ? carriers : strangers).push_back(s.joints[at(i)].name);
  }
  // Remove bodies that move freely although they are below the character's root in the tree (cameras, targets).
  for (int i = root + 1; i < static_cast<int>(s.joints.size()); ++i) {
    const int parent = s.joints[at(i)].parent;
    if (keep[at(i)] == 0 || parent < 0) continue;
    if (keep[at(parent)] == 0 && i != root) {
      keep[at(i)] = 0;
      continue;
    }
    if (character.free[at(i)] != 0 && i != root) {
      keep[at(i)] = 0;
      strangers.push_back(s.joints[at(i)].name);
    }
  }
  // The trunk of an animal is divided among its joints, so joints without a bone and without movement would take mass from the others.
  // The merged limbs can lack a section; then ends are added, or the joints stay.
  const auto merged = [&]() -> std::optional<body::Character> {
    if (character.plan != body::BodyPlan::four_legs || mapping) return std::nullopt;
    std::vector<MeasuredMotion> fewer(motions.begin(), motions.end());
    const std::vector<std::string> joints = merge_rigid_joints(fewer);
    if (joints.empty()) return std::nullopt;
    body::Character again = body::recognise_character(fewer[index]);
    std::vector<std::string> ends;
    if (again.plan != body::BodyPlan::four_legs) {
      ends = add_limb_ends(fewer);
      again = body::recognise_character(fewer[index]);
    }
    if (again.plan != body::BodyPlan::four_legs) return std::nullopt;
    std::ranges::move(fewer, motions.begin());
    report.push_back("Joints at the place of their parent that do not turn were merged with it: " + list_of(joints) + ".");
    if (!ends.empty())
      report.push_back("Joints that do not turn were added at the ends of limbs with one or two bones: " + list_of(ends) + ".");
    return again;
  };
  if (carriers.empty() && strangers.empty()) return merged().value_or(character);
  const std::string root_name = s.joints[at(root)].name;
  for (MeasuredMotion& m : motions) {
    keep_joints(m, keep);
    m.skeleton.joints[0].translates = true;
  }
  if (!carriers.empty())
    report.push_back("Joint " + list_of(carriers) + " only carries " + root_name + "; it is left out, and its movement was added to " +
                     root_name + ".");
  if (!strangers.empty()) report.push_back("Joints that are not part of the character were left out: " + list_of(strangers) + ".");
  if (std::optional<body::Character> fewer = merged()) return *fewer;
  return body::recognise_character(*longest, mapping);
}

/// As arrange(); the root can be far from the hips.
body::Character arrange_with_paws(std::span<MeasuredMotion> motions, std::vector<std::string>& report, const body::AnatomyMapping* mapping,
                                  bool mesh_ends) {
  Skeleton with_ends;
  if (mesh_ends) with_ends = motions[0].skeleton;
  body::Character character = arrange_joints(motions, report, mapping, mesh_ends);
  // The paws of an animal reach to the ends of their bones, as in a file that contains these ends.
  if (!mesh_ends || character.plan != body::BodyPlan::four_legs) return character;
  std::vector<MeasuredMotion> ended(motions.begin(), motions.end());
  if (std::ranges::any_of(report, [](const std::string& r) { return r.starts_with("The skeleton was re-rooted"); })) return character;
  if (!restore_ends_of_meshes(ended, with_ends, character)) return character;
  const auto longest = std::ranges::max_element(ended, {}, &MeasuredMotion::frames);
  body::Character again = body::recognise_character(*longest, mapping);
  if (again.plan != body::BodyPlan::four_legs || !same_sections(again, character)) return character;
  std::ranges::move(ended, motions.begin());
  return again;
}

/// As arrange(); several joints can be at one place.
body::Character arrange_plan(std::span<MeasuredMotion> motions, std::vector<std::string>& report, const body::AnatomyMapping* mapping,
                             bool mesh_ends) {
  body::Character character = arrange_with_paws(motions, report, mapping, mesh_ends);
  if (character.plan == body::BodyPlan::four_legs && !mapping)
    if (std::optional<body::Character> human = human_in_most(motions)) {
      report.emplace_back("Most motions of the file show a person, although the longest one shows it on four limbs.");
      return *std::move(human);
    }
  if (character.plan != body::BodyPlan::four_legs) return character;
  std::vector<MeasuredMotion> moved(motions.begin(), motions.end());
  std::string change = move_root_to_hips(moved, character);
  if (change.empty()) return character;
  const auto longest = std::ranges::max_element(moved, {}, &MeasuredMotion::frames);
  body::Character again = body::recognise_character(*longest, mapping);
  if (again.plan != character.plan) return character;
  std::ranges::move(moved, motions.begin());
  report.push_back(std::move(change));
  return again;
}

}  // namespace

body::Character arrange(std::span<MeasuredMotion> motions, std::vector<std::string>& report, const body::AnatomyMapping* mapping,
                        bool mesh_ends) {
  body::Character character = arrange_plan(motions, report, mapping, mesh_ends);
  std::vector<MeasuredMotion> merged(motions.begin(), motions.end());
  const CoincidentJoints joints = merge_coincident_joints(merged, character);
  if (joints.empty()) return character;
  body::Character again = body::recognise_character(*std::ranges::max_element(merged, {}, &MeasuredMotion::frames), mapping);
  if (again.plan != character.plan) return character;
  std::ranges::move(merged, motions.begin());
  if (!joints.points.empty())
    report.push_back("Joints at the place of another joint that carry nothing were left out: " + list_of(joints.points) + ".");
  if (!joints.carriers.empty())
    report.push_back("Joints that carry one joint at their own place were merged with it: " + list_of(joints.carriers) + ".");
  return again;
}

}  // namespace ugoki::intake
