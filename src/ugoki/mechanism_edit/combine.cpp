#include "ugoki/mechanism_edit/combine.h"

#include <set>
#include <utility>

#include "ugoki/mechanism_edit/link_frames.h"

namespace ugoki {
namespace {

using Names = std::set<std::string, std::less<>>;

Names names_of(const MechanismSpec& spec) {
  Names names;
  for (const LinkSpec& l : spec.links) names.insert(l.name);
  for (const LoopSpec& l : spec.loops) names.insert(l.name);
  return names;
}

void put_prefix(MechanismSpec& spec, const std::string& prefix) {
  if (prefix.empty()) return;
  const auto put = [&](std::string& name) {
    if (!name.empty()) name.insert(0, prefix);
  };
  for (LinkSpec& l : spec.links) {
    put(l.name);
    put(l.parent);
    put(l.real);
  }
  for (LoopSpec& l : spec.loops) {
    put(l.name);
    put(l.link_a);
    put(l.link_b);
  }
  for (auto& [a, b] : spec.exclusions) {
    put(a);
    put(b);
  }
  for (SkinBone& bone : spec.skin_bones) put(bone.link);
}

/// Returns a prefix for b's names that makes them different from a's; empty if none is needed.
std::string needed_prefix(const Names& a, const Names& b, const std::string& b_name) {
  const auto disjoint = [&](const std::string& prefix) {
    for (const std::string& name : b)
      if (a.contains(prefix + name)) return false;
    return true;
  };
  if (disjoint("")) return {};
  const std::string stem = b_name.empty() ? "second" : b_name;
  std::string prefix = stem + " ";
  for (int number = 2; !disjoint(prefix); ++number) prefix = stem + " " + std::to_string(number) + " ";
  return prefix;
}

/// Index of the root of the link's tree. O(links * depth)
int root_of(const MechanismSpec& spec, int link) {
  while (!spec.links[static_cast<std::size_t>(link)].parent.empty())
    link = find_link(spec, spec.links[static_cast<std::size_t>(link)].parent);
  return link;
}

/// `name`, with a number appended if it is one of `used`.
std::string unused(std::string name, const Names& used) {
  const std::string stem = name;
  for (int number = 2; used.contains(name); ++number) name = stem + " " + std::to_string(number);
  return name;
}

}  // namespace

Result<Combined> combine(const Mechanism& a, const Mechanism& b, const CombineOptions& options) {
  MechanismSpec first = a.spec(), second = b.spec();
  const int link_a = options.link_a.empty() ? -1 : find_link(first, options.link_a);
  const int link_b = find_link(second, options.link_b);
  Error errors;
  if (link_a < 0 && !options.link_a.empty())
    errors.add(ErrorCode::unknown, "mechanism " + a.name(), "The mechanism has no link '" + options.link_a + "'.",
               "Name one of its links.");
  if (link_b < 0)
    errors.add(ErrorCode::unknown, "mechanism " + b.name(), "The mechanism has no link '" + options.link_b + "'.",
               "Name one of its links.");
  if (!errors.empty()) return fail(std::move(errors));

  Combined out;
  put_prefix(first, options.prefix_a);
  put_prefix(second, options.prefix_b);
  if (const std::string prefix = needed_prefix(names_of(first), names_of(second), b.name()); !prefix.empty()) {
    put_prefix(second, prefix);
    out.report.push_back("Both mechanisms have links of the same name; the names of " + b.name() + " now begin with '" + prefix + "'.");
  }
  for (const LinkSpec& l : first.links) out.links_a.push_back(l.name);
  for (const LinkSpec& l : second.links) out.links_b.push_back(l.name);

  const std::string name_a = link_a < 0 ? "" : first.links[static_cast<std::size_t>(link_a)].name;
  if (options.attachment == Attachment::joint) {
    make_root(second, link_b, out.report);
    LinkSpec& root = second.links[static_cast<std::size_t>(link_b)];
    move_link_frame(second, link_b, options.X_BJ);
    root.parent = name_a;
    root.joint = options.joint;
    root.joint.X_PJ = options.X_AB * options.X_BJ;
  } else {
    const Pose X_WA = link_a < 0 ? Pose{} : neutral_poses(first)[static_cast<std::size_t>(link_a)];
    const Pose X_WB = neutral_poses(second)[static_cast<std::size_t>(link_b)];
    const Pose moved = X_WA * options.X_AB * X_WB.inverse();
    Joint& base = second.links[static_cast<std::size_t>(root_of(second, link_b))].joint;
    base.X_PJ = moved * base.X_PJ;
    LoopSpec loop = options.loop;
    loop.link_a = name_a;
    loop.link_b = second.links[static_cast<std::size_t>(link_b)].name;
    loop.X_AJ = options.X_AB * options.X_BJ;
    loop.X_BJ = options.X_BJ;
    if (loop.type == LoopType::distance) loop.X_AJ.p = loop.X_AJ.p + loop.X_AJ.R * Vec3{0, 0, -loop.length};
    if (loop.name.empty()) loop.name = (name_a.empty() ? "world" : name_a) + " to " + loop.link_b;
    Names used = names_of(first);
    used.merge(names_of(second));
    loop.name = unused(std::move(loop.name), used);
    second.loops.push_back(std::move(loop));
  }

  first.name = options.name.empty() ? a.name() + " + " + b.name() : options.name;
  for (LinkSpec& l : second.links) first.links.push_back(std::move(l));
  for (LoopSpec& l : second.loops) first.loops.push_back(std::move(l));
  for (auto& e : second.exclusions) first.exclusions.push_back(std::move(e));
  if (first.skin && second.skin) {
    out.report.push_back("The skin of " + b.name() + " was dropped: a mechanism has one skin.");
  } else if (second.skin) {
    first.skin = second.skin;
    first.skin_bones = std::move(second.skin_bones);
  }
  Result<MechanismPtr> made = Mechanism::make(std::move(first));
  if (!made) return fail(std::move(made.error()));
  out.mechanism = std::move(*made);
  return out;
}

}  // namespace ugoki
