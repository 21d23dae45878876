#include "ugoki/mechanism_edit/cut.h"

#include <algorithm>
#include <utility>

#include "ugoki/mechanism_edit/link_frames.h"

namespace ugoki {
namespace {

std::string end_name(const std::string& link) { return link.empty() ? "the world" : link; }

/// Drops the loops with an end on a link that is not kept, and reports each.
void drop_loops(MechanismSpec& spec, const Mechanism& m, const std::vector<char>& kept, std::vector<std::string>& report) {
  const auto lost = [&](const std::string& link) { return !link.empty() && !kept[static_cast<std::size_t>(m.find_link(link))]; };
  std::erase_if(spec.loops, [&](const LoopSpec& loop) {
    const bool a = lost(loop.link_a), b = lost(loop.link_b);
    if (!a && !b) return false;
    const bool other_is_kept = a ? !b && !loop.link_b.empty() : !loop.link_a.empty();
    const std::string description =
        std::string(name_of(loop.type)) + " " + loop.name + " between " + end_name(loop.link_a) + " and " + end_name(loop.link_b);
    report.push_back(other_is_kept ? "The loop " + description + " was dropped: " + (a ? loop.link_a : loop.link_b) + " is cut off, so " +
                                         (a ? loop.link_b : loop.link_a) + " moves without it."
                                   : "The loop " + description + " was dropped together with the links that it connects.");
    return true;
  });
}

}  // namespace

Result<Edited> cut(const Mechanism& m, std::string_view link, const CutOptions& options) {
  const int at = m.find_link(link);
  const std::string location = "mechanism " + m.name();
  if (at < 0) return fail(ErrorCode::unknown, location, "The mechanism has no link '" + std::string(link) + "'.", "Name one of its links.");
  if (options.keep == Keep::part && options.base != JointType::fixed && options.base != JointType::floating)
    return fail(ErrorCode::unsupported, location,
                "The joint of the cut part to the world is " + std::string(name_of(options.base)) + "; it must be fixed or floating.",
                "Use fixed or floating.");

  const std::size_t n = static_cast<std::size_t>(m.link_count());
  std::vector<char> kept(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const int parent = m.links()[i].parent;
    kept[i] = static_cast<int>(i) == at || (parent >= 0 && kept[static_cast<std::size_t>(parent)]);
  }
  if (options.keep == Keep::rest)
    for (char& k : kept) k = !k;

  Edited out;
  MechanismSpec spec = m.spec();
  drop_loops(spec, m, kept, out.report);
  if (options.keep == Keep::part) {
    std::erase_if(spec.loops, [&](const LoopSpec& loop) {
      const bool on_joint = loop.type == LoopType::gear && (loop.link_a == link || loop.link_b == link);
      if (on_joint) out.report.push_back("The gear " + loop.name + " was dropped: it drives the joint at which the cut was made.");
      return on_joint;
    });
    LinkSpec& root = spec.links[static_cast<std::size_t>(at)];
    const Pose X_W = neutral_poses(spec)[static_cast<std::size_t>(at)];
    root.parent.clear();
    root.joint = Joint{.type = options.base, .X_PJ = X_W};
  }
  std::erase_if(spec.exclusions, [&](const auto& pair) {
    return std::ranges::any_of(pair, [&](const std::string& name) { return !kept[static_cast<std::size_t>(m.find_link(name))]; });
  });
  std::vector<LinkSpec> links;
  for (std::size_t i = 0; i < n; ++i) {
    const int real = m.links()[i].real;
    LinkSpec& l = spec.links[i];
    if (!kept[i]) {
      if (real >= 0 && kept[static_cast<std::size_t>(real)])
        out.report.push_back("The loop at the virtual link " + l.name + " was dropped: the virtual link is cut off, so " + l.real +
                             " moves without it.");
      continue;
    }
    if (real >= 0 && !kept[static_cast<std::size_t>(real)]) {
      out.report.push_back("The virtual link " + l.name + " is a link of its own now: " + l.real + ", its real link, is cut off.");
      l.real.clear();
      l.X_RV = {};
    }
    links.push_back(std::move(l));
  }
  if (links.empty())
    return fail(ErrorCode::structure, location, "No link is left without " + std::string(link) + " and its descendants.",
                "Cut at another link, or keep the part.");
  spec.links = std::move(links);
  if (std::ranges::any_of(spec.skin_bones, [&](const SkinBone& b) { return !kept[static_cast<std::size_t>(m.find_link(b.link))]; })) {
    out.report.push_back("The skin was dropped: parts of it are on links that are cut off.");
    spec.skin = nullptr;
    spec.skin_bones.clear();
  }
  Result<MechanismPtr> made = Mechanism::make(std::move(spec));
  if (!made) return fail(std::move(made.error()));
  out.mechanism = std::move(*made);
  return out;
}

}  // namespace ugoki
