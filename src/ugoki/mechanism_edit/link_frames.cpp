#include "ugoki/mechanism_edit/link_frames.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace ugoki {
namespace {

/// Changes the limits and rest position of a DOF whose coordinate changes its sign.
void negate_coordinate(Dof& f) {
  std::swap(f.lower, f.upper);
  f.lower = -f.lower;
  f.upper = -f.upper;
  f.rest = f.rest == 0 ? 0 : -f.rest;
}

bool acts_on_position(const Dof& f) { return std::isfinite(f.lower) || std::isfinite(f.upper) || f.stiffness != 0; }

}  // namespace

int find_link(const MechanismSpec& spec, std::string_view name) {
  const auto it = std::ranges::find_if(spec.links, [&](const LinkSpec& l) { return l.name == name; });
  return it == spec.links.end() ? -1 : static_cast<int>(it - spec.links.begin());
}

void move_link_frame(MechanismSpec& spec, int index, const Pose& X_LN) {
  LinkSpec& link = spec.links[static_cast<std::size_t>(index)];
  const Pose X_NL = X_LN.inverse();
  link.inertia = link.inertia.in_parent(X_NL);
  for (Shape& s : link.shapes) s.X_BS = X_NL * s.X_BS;
  if (!link.real.empty()) link.X_RV = link.X_RV * X_LN;
  for (SkinBone& bone : spec.skin_bones)
    if (bone.link == link.name) {
      bone.A = X_LN.R.transposed() * bone.A;
      bone.p = X_LN.inverse() * bone.p;
    }
  for (LinkSpec& other : spec.links) {
    if (other.parent == link.name) other.joint.X_PJ = X_NL * other.joint.X_PJ;
    if (other.real == link.name) other.X_RV = X_NL * other.X_RV;
  }
  for (LoopSpec& loop : spec.loops) {
    if (loop.type == LoopType::gear) continue;
    if (loop.link_a == link.name) loop.X_AJ = X_NL * loop.X_AJ;
    if (loop.link_b == link.name) loop.X_BJ = X_NL * loop.X_BJ;
  }
}

Joint reversed(const Joint& joint, std::string& lost) {
  Joint out = joint;
  out.X_PJ = {};
  switch (joint.type) {
    case JointType::fixed:
    case JointType::floating: break;
    case JointType::revolute:
    case JointType::prismatic:
    case JointType::helical:
    case JointType::cylindrical: out.axis = -joint.axis; break;
    case JointType::universal:
      out.axis = -joint.axis2;
      out.axis2 = -joint.axis;
      std::swap(out.dofs[0], out.dofs[1]);
      break;
    case JointType::spherical:
      for (std::size_t i = 0; i < 3; ++i) negate_coordinate(out.dofs[i]);
      break;
    case JointType::planar:
      negate_coordinate(out.dofs[2]);
      for (std::size_t i = 0; i < 2; ++i)
        if (Dof& f = out.dofs[i]; acts_on_position(f)) {
          lost = "the limits and springs of its displacements, which the reversed joint cannot have";
          f.lower = Dof{}.lower;
          f.upper = Dof{}.upper;
          f.stiffness = 0;
        }
      break;
  }
  return out;
}

void make_root(MechanismSpec& spec, int link, std::vector<std::string>& report) {
  std::vector<int> path = {link};
  for (int i = find_link(spec, spec.links[static_cast<std::size_t>(link)].parent); i >= 0;
       i = find_link(spec, spec.links[static_cast<std::size_t>(i)].parent))
    path.push_back(i);
  const auto at = [&](std::size_t i) -> LinkSpec& { return spec.links[static_cast<std::size_t>(path[i])]; };
  if (const JointType base = at(path.size() - 1).joint.type; base != JointType::fixed)
    report.push_back("The " + std::string(name_of(base)) + " joint between " + at(path.size() - 1).name + " and the world was dropped.");

  std::vector<Joint> joints;
  std::vector<Pose> frames;  // poses of the joint frames in the old parents' frames
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    std::string lost;
    joints.push_back(reversed(at(i).joint, lost));
    frames.push_back(at(i).joint.X_PJ);
    if (!lost.empty()) report.push_back("The joint of " + at(i).name + " was reversed and lost " + lost + ".");
  }
  std::erase_if(spec.loops, [&](const LoopSpec& loop) {
    if (loop.type != LoopType::gear) return false;
    for (std::size_t i = 0; i + 1 < path.size(); ++i)
      if (at(i).joint.type == JointType::planar && (loop.link_a == at(i).name || loop.link_b == at(i).name)) {
        report.push_back("The gear " + loop.name + " was dropped: the planar joint that it drives was reversed.");
        return true;
      }
    return false;
  });
  for (LoopSpec& loop : spec.loops) {
    if (loop.type != LoopType::gear) continue;
    for (const bool a : {true, false}) {
      std::string& name = a ? loop.link_a : loop.link_b;
      int& dof = a ? loop.dof_a : loop.dof_b;
      for (std::size_t i = 0; i + 1 < path.size(); ++i)
        if (name == at(i).name) {  // the joint now belongs to the old parent
          if (at(i).joint.type == JointType::universal) dof = 1 - dof;
          name = at(i + 1).name;
          break;
        }
    }
  }
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    at(i + 1).joint = joints[i];
    at(i + 1).parent = at(i).name;
  }
  at(0).parent.clear();
  at(0).joint = Joint{};
  for (std::size_t i = path.size() - 1; i >= 1; --i) {
    // Converts the link's contents and its children's joints to the new frame; the link's own joint already has the new form.
    move_link_frame(spec, path[i], frames[i - 1]);
  }
  if (path.size() > 1)
    report.push_back("The tree was rerooted: " + at(0).name + " is now its root, and " + std::to_string(path.size() - 1) +
                     (path.size() == 2 ? " joint is" : " joints are") + " reversed.");
}

std::vector<Pose> neutral_poses(const MechanismSpec& spec) {
  std::map<std::string_view, int> index_of;
  for (std::size_t i = 0; i < spec.links.size(); ++i) index_of.emplace(spec.links[i].name, static_cast<int>(i));
  const auto parent_of = [&](int i) {
    const auto it = index_of.find(spec.links[static_cast<std::size_t>(i)].parent);
    return it == index_of.end() ? -1 : it->second;
  };
  std::vector<Pose> X(spec.links.size());
  std::vector<char> done(spec.links.size(), 0);
  for (std::size_t start = 0; start < spec.links.size(); ++start) {
    std::vector<std::size_t> chain;
    int i = static_cast<int>(start);
    while (i >= 0 && !done[static_cast<std::size_t>(i)] && chain.size() <= spec.links.size()) {
      chain.push_back(static_cast<std::size_t>(i));
      i = parent_of(i);
    }
    Pose X_W = i >= 0 ? X[static_cast<std::size_t>(i)] : Pose{};
    for (auto it = chain.rbegin(); it != chain.rend(); ++it) {
      double q[7];
      joint_neutral(spec.links[*it].joint, q);
      X_W = X_W * spec.links[*it].joint.X_PJ * joint_pose(spec.links[*it].joint, q);
      X[*it] = X_W;
      done[*it] = 1;
    }
  }
  return X;
}

}  // namespace ugoki
