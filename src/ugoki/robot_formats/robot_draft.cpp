#include "ugoki/robot_formats/robot_draft.h"

#include <algorithm>

#include "ugoki/base/number.h"
#include "ugoki/robot_formats/inertia_repair.h"

namespace ugoki::robot_formats {
namespace {

constexpr double least_armature = 1e-6;  // kg m^2 or kg

double weight(const Inertia& i) { return i.mass + i.I.xx + i.I.yy + i.I.zz; }

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
                 "two links have the name " + formats::in_quotes(link.name) + "; the first stands in line " +
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

/// Empty with a problem where the parents form a circle.
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
  xml_.problem(links[i].node, ErrorCode::structure, "the parents of the link " + formats::in_quotes(spec.links[i].name) + " form a circle.",
               "Take out one of the circle's joints, and name it as a loop.");
  return {};
}

void RobotDraft::repair_inertias() {
  std::vector<std::string> repaired;
  double largest = 0;
  for (std::size_t i = 0; i < spec.links.size(); ++i) {
    LinkSpec& link = spec.links[i];
    const std::optional<double> change = make_possible(link.inertia);
    if (!change) continue;
    if (options_.inertias == Inertias::strict)
      xml_.problem(links[i].node, ErrorCode::structure,
                   "no body has the moments of inertia of the link " + formats::in_quotes(link.name) +
                       " (about its centre of mass they must be positive, and none above the sum of the other two).",
                   "Correct them, or allow that the nearest possible are taken.");
    repaired.push_back(link.name);
    largest = std::max(largest, *change);
  }
  if (!repaired.empty())
    xml_.note("No body has the moments of inertia that the file gives to " + listed(repaired) +
              "; the nearest possible were taken (greatest change " + to_fixed(100 * largest, 3) + " % of a link's greatest moment).");
}

void RobotDraft::decide_bases(const std::vector<int>& order) {
  // The weight of each group of links that fixed joints hold together, at its first link.
  const std::size_t n = spec.links.size();
  std::vector<int> group(n);
  std::vector<double> weights(n, 0.0);
  for (const int k : order) {
    const auto i = static_cast<std::size_t>(k);
    group[i] = spec.links[i].joint.type == JointType::fixed && parents_[i] >= 0 ? group[static_cast<std::size_t>(parents_[i])] : k;
    weights[static_cast<std::size_t>(group[i])] += weight(spec.links[i].inertia);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!links[i].base_open) continue;
    const std::string& name = spec.links[i].name;
    const bool heavy = weights[i] > 0;
    bool floats = options_.base == Base::floating || (options_.base == Base::by_file && name != "world" && heavy);
    if (floats && !heavy) {
      xml_.problem(links[i].node, ErrorCode::structure, "the base " + formats::in_quotes(name) + " has no mass, so it cannot float.",
                   "Give it mass, or fix it to the world.");
      floats = false;
    }
    spec.links[i].joint.type = floats ? JointType::floating : JointType::fixed;
    if (options_.base != Base::by_file) continue;
    if (floats)
      xml_.note("The base " + name + " is free to move, because the file does not join it to the world.");
    else
      xml_.note("The base " + name + " is fixed to the world, because it " + (name == "world" ? "has that name." : "has no mass."));
  }
}

void RobotDraft::weigh_joints(const std::vector<int>& order) {
  std::vector<double> behind(spec.links.size(), 0.0);
  std::vector<std::string> weightless;
  for (auto it = order.rbegin(); it != order.rend(); ++it) {
    const auto i = static_cast<std::size_t>(*it);
    LinkSpec& link = spec.links[i];
    behind[i] += weight(link.inertia);
    if (parents_[i] >= 0) behind[static_cast<std::size_t>(parents_[i])] += behind[i];
    if (behind[i] > 0 || link.joint.nv() == 0 || !link.real.empty()) continue;
    const std::span freedoms(link.joint.freedoms.data(), static_cast<std::size_t>(link.joint.nv()));
    if (std::ranges::all_of(freedoms, [](const Freedom& f) { return f.armature > 0; })) continue;
    if (options_.inertias == Inertias::strict)
      xml_.problem(links[i].node, ErrorCode::structure,
                   "the joint of the link " + formats::in_quotes(link.name) + " can move, but nothing behind it has mass.",
                   "Give it mass, make the joint fixed, or allow that it is given a small inertia.");
    for (Freedom& f : freedoms) f.armature = std::max(f.armature, least_armature);
    weightless.push_back(link.name);
  }
  if (!weightless.empty())
    xml_.note("Nothing behind the joints of " + listed(weightless) +
              " has mass; so that they have an acceleration, they were given a rotor's inertia of 1e-6 kg m^2 (sliding: kg).");
}

Result<RobotModel> RobotDraft::finish() {
  if (spec.links.empty() && !xml_.failed())
    xml_.problem(xml_.root(), ErrorCode::structure, "the file has no link.", "Check that it is whole.");
  if (xml_.failed()) return fail(xml_.take_problems());
  const std::vector<int> order = parents_first();
  if (!order.empty()) {
    repair_inertias();
    decide_bases(order);
    weigh_joints(order);
  }
  if (xml_.failed()) return fail(xml_.take_problems());

  Result<MechanismPtr> mechanism = Mechanism::make(std::move(spec));
  if (!mechanism) {
    for (Problem& p : mechanism.error().problems) {
      const int i = p.place.starts_with("link ") ? find_link(std::string_view(p.place).substr(5)) : -1;
      p.place = xml_.place(i >= 0 ? draft(i).node : xml_.root()) + ", " + p.place;
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
