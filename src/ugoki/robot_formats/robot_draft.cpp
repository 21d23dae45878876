#include "ugoki/robot_formats/robot_draft.h"

#include <algorithm>

#include "ugoki/base/number.h"
#include "ugoki/robot_formats/inertia_repair.h"

namespace ugoki::robot_formats {
namespace {

constexpr double min_armature = 1e-6;  // kg m^2 or kg: small for usual links, but enough to make the inertia matrix invertible

/// Mass plus trace of the inertia: zero only if the body has neither. Used only for comparison with zero.
double total_inertia(const Inertia& i) { return i.mass + i.I.xx + i.I.yy + i.I.zz; }

}  // namespace

std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t shown = 4;
  std::string out;
  for (std::size_t i = 0; i < std::min(names.size(), shown); ++i) out += (i == 0 ? "" : ", ") + names[i];
  if (names.size() > shown) out += " and " + std::to_string(names.size() - shown) + " more";
  return out;
}

int RobotDraft::add_link(LinkSpec link, DraftLink draft) {
  const int index = static_cast<int>(spec.links.size());
  if (const auto [it, is_new] = index_.emplace(link.name, index); !is_new) {
    xml_.problem(draft.node, ErrorCode::duplicate,
                 "Two links are named " + formats::in_quotes(link.name) + "; the first one is in line " +
                     std::to_string(xml_.line(links[static_cast<std::size_t>(it->second)].node)) + ".",
                 "Rename one of them.");
    return -1;
  }
  spec.links.push_back(std::move(link));
  links.push_back(std::move(draft));
  return index;
}

int RobotDraft::find_link(std::string_view name) const {
  const auto it = index_.find(name);
  return it == index_.end() ? -1 : it->second;
}

/// Returns the link indices, parents before children. If the parents form a cycle, adds a problem and returns an empty list.
std::vector<int> RobotDraft::parents_first() {
  const std::size_t n = spec.links.size();
  std::vector<std::vector<int>> children(n);
  std::vector<int> order;
  parents_.assign(n, -1);
  for (std::size_t i = 0; i < n; ++i) {
    parents_[i] = spec.links[i].parent.empty() ? -1 : find_link(spec.links[i].parent);
    if (parents_[i] < 0)
      order.push_back(static_cast<int>(i));
    else
      children[static_cast<std::size_t>(parents_[i])].push_back(static_cast<int>(i));
  }
  for (std::size_t at = 0; at < order.size(); ++at)
    for (const int child : children[static_cast<std::size_t>(order[at])]) order.push_back(child);
  if (order.size() == n) return order;
  std::vector<char> reached(n, 0);
  for (const int i : order) reached[static_cast<std::size_t>(i)] = 1;
  const auto i = static_cast<std::size_t>(std::find(reached.begin(), reached.end(), 0) - reached.begin());
  xml_.problem(links[i].node, ErrorCode::structure, "The parents of the link " + formats::in_quotes(spec.links[i].name) + " form a cycle.",
               "Remove one joint of the cycle, and define it as a loop in a loops file.");
  return {};
}

void RobotDraft::repair_inertias() {
  std::vector<std::string> repaired;
  double largest = 0;
  for (std::size_t i = 0; i < spec.links.size(); ++i) {
    LinkSpec& link = spec.links[i];
    const std::optional<double> change = make_physical(link.inertia);
    if (!change) continue;
    if (options_.inertias == Inertias::strict)
      xml_.problem(
          links[i].node, ErrorCode::structure,
          "The moments of inertia of the link " + formats::in_quotes(link.name) +
              " are not physically possible (about the centre of mass each must be positive and at most the sum of the other two).",
          "Correct them, or allow the reader to repair them.");
    repaired.push_back(link.name);
    largest = std::max(largest, *change);
  }
  if (!repaired.empty())
    xml_.note("The moments of inertia of " + listed(repaired) +
              " are not physically possible; they were replaced by the nearest possible ones (maximum change " +
              to_fixed(100 * largest, 3) + " % of a link's largest moment).");
}

void RobotDraft::decide_bases(const std::vector<int>& order) {
  // Total inertia of each group of links connected by fixed joints, stored at the first link of the group.
  const std::size_t n = spec.links.size();
  std::vector<int> group(n);
  std::vector<double> inertias(n, 0.0);
  for (const int k : order) {
    const auto i = static_cast<std::size_t>(k);
    group[i] = spec.links[i].joint.type == JointType::fixed && parents_[i] >= 0 ? group[static_cast<std::size_t>(parents_[i])] : k;
    inertias[static_cast<std::size_t>(group[i])] += total_inertia(spec.links[i].inertia);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!links[i].base_open) continue;
    const std::string& name = spec.links[i].name;
    const bool heavy = inertias[i] > 0;
    bool floats = options_.base == Base::floating || (options_.base == Base::by_file && name != "world" && heavy);
    if (floats && !heavy) {
      xml_.problem(links[i].node, ErrorCode::structure, "The base " + formats::in_quotes(name) + " has no mass, so it cannot float.",
                   "Give the base a mass, or fix it to the world.");
      floats = false;
    }
    spec.links[i].joint.type = floats ? JointType::floating : JointType::fixed;
    if (options_.base != Base::by_file) continue;
    if (floats)
      xml_.note("The base " + name + " floats, because no joint of the file connects it to the world.");
    else
      xml_.note("The base " + name + " is fixed to the world, because it " + (name == "world" ? "is named world." : "has no mass."));
  }
}

void RobotDraft::add_armature_to_massless_joints(const std::vector<int>& order) {
  std::vector<double> beyond(spec.links.size(), 0.0);
  std::vector<std::string> massless;
  for (auto it = order.rbegin(); it != order.rend(); ++it) {
    const auto i = static_cast<std::size_t>(*it);
    LinkSpec& link = spec.links[i];
    beyond[i] += total_inertia(link.inertia);
    if (parents_[i] >= 0) beyond[static_cast<std::size_t>(parents_[i])] += beyond[i];
    if (beyond[i] > 0 || link.joint.nv() == 0 || !link.real.empty()) continue;
    const std::span dofs(link.joint.dofs.data(), static_cast<std::size_t>(link.joint.nv()));
    if (std::ranges::all_of(dofs, [](const Dof& f) { return f.armature > 0; })) continue;
    if (options_.inertias == Inertias::strict)
      xml_.problem(links[i].node, ErrorCode::structure,
                   "The joint of the link " + formats::in_quotes(link.name) + " can move, but no link beyond it has mass.",
                   "Give the link a mass, make the joint fixed, or allow the reader to add a small armature.");
    for (Dof& f : dofs) f.armature = std::max(f.armature, min_armature);
    massless.push_back(link.name);
  }
  if (!massless.empty())
    xml_.note("No link beyond the joints of " + listed(massless) +
              " has mass; their degrees of freedom were given an armature of 1e-6 kg m^2 (sliding: 1e-6 kg).");
}

Result<RobotModel> RobotDraft::finish() {
  if (spec.links.empty() && !xml_.failed())
    xml_.problem(xml_.root(), ErrorCode::structure, "The file has no link.", "Check that the file is complete.");
  if (xml_.failed()) return fail(xml_.take_problems());
  const std::vector<int> order = parents_first();
  if (!order.empty()) {
    repair_inertias();
    decide_bases(order);
    add_armature_to_massless_joints(order);
  }
  if (xml_.failed()) return fail(xml_.take_problems());

  Result<MechanismPtr> mechanism = Mechanism::make(std::move(spec));
  if (!mechanism) {
    for (Problem& p : mechanism.error().problems) {
      const int i = p.location.starts_with("link ") ? find_link(std::string_view(p.location).substr(5)) : -1;
      p.location = xml_.location(i >= 0 ? draft(i).node : xml_.root()) + ", " + p.location;
    }
    return fail(std::move(mechanism.error()));
  }
  RobotModel model;
  model.mechanism = std::move(*mechanism);
  for (const Link& l : model.mechanism->links()) {
    DraftLink& d = draft(find_link(l.name));
    model.X_BF.push_back(d.X_BF);
    if (!d.joint.empty()) model.joints.push_back({std::move(d.joint), l.name});
  }
  model.joints.insert(model.joints.end(), loop_joints.begin(), loop_joints.end());
  model.driven = std::move(driven);
  model.notes = xml_.take_notes();
  return model;
}

}  // namespace ugoki::robot_formats
