#include "ugoki/dynamics/loop_diagnosis.h"

#include <algorithm>

#include "ugoki/base/number.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

/// Two digits, for people.
std::string in_short(double x) {
  int places = 0;
  for (double y = x; y > 0 && y < 10 && places < 15; y *= 10) ++places;
  return to_fixed(x, places);
}

/// True if `ancestor` is `link` or lies between it and the base.
bool is_above(const Mechanism& m, int ancestor, int link) {
  for (; link >= 0; link = m.link(link).parent)
    if (link == ancestor) return true;
  return ancestor < 0;
}

/// A distance between two joints in one link.
struct Bar {
  std::string link;
  double length = 0;
};

/// The polygon of links that the loop closes: distances between the joints that follow each other around it.
/// @param sliding [out] true if a joint in it can change such a distance
std::vector<Bar> polygon(const Mechanism& m, const Loop& loop, bool& sliding) {
  std::vector<Bar> bars;
  const auto climb = [&](int link, Vec3 p, int ancestor) {
    for (; link != ancestor; link = m.link(link).parent) {
      const Link& l = m.link(link);
      bars.push_back({l.name, norm(p)});
      for (int k = 0; k < l.joint.nv(); ++k) sliding = sliding || is_distance(l.joint, k) || l.joint.type == JointType::helical;
      p = l.joint.X_PJ.p;
    }
    return p;
  };
  int common = loop.link_a;
  while (common >= 0 && !is_above(m, common, loop.link_b)) common = m.link(common).parent;
  const Vec3 a = climb(loop.link_a, loop.X_AJ.p, common), b = climb(loop.link_b, loop.X_BJ.p, common);
  bars.push_back({common < 0 ? "the world" : m.link(common).name, norm(a - b)});
  if (loop.type == LoopType::distance) bars.push_back({"the distance", loop.length});
  sliding = sliding || loop.type == LoopType::prismatic || loop.type == LoopType::cylindrical || loop.type == LoopType::planar;
  return bars;
}

/// "loop knee: rotation about x"
std::string name_of_row(const ClosedWorkspace& cw, int row) {
  std::size_t i = 0;
  while (cw.rows.first[i + 1] <= row) ++i;
  return "loop " + cw.loops[i].name + ": " + std::string(row_name(cw.loops[i].type, row - cw.rows.first[i]));
}

std::string counted(int n, const char* one, const char* many) { return std::to_string(n) + " " + (n == 1 ? one : many); }

void add_rows(const ClosedWorkspace& cw, std::span<const int> rows, std::string& text) {
  for (std::size_t k = 0; k < rows.size(); ++k) text += (k == 0 ? " " : "; ") + name_of_row(cw, rows[k]);
  text += ".";
}

}  // namespace

LoopDiagnosis diagnose_loops(const Mechanism& m, std::span<const double> q, ClosedWorkspace& cw) {
  LoopDiagnosis d;
  std::vector<double> general(q.begin(), q.end());
  d.rank = find_full_rank(m, general, cw, general);
  d.rows = static_cast<int>(cw.active.size());
  d.freedoms = m.nv() - d.rank;
  std::vector<int> independent;
  const std::vector<double> rest(static_cast<std::size_t>(m.nv()), 0.0);
  update_closed(m, general, rest, cw);
  d.pivot_part = cw.pivot_part;
  for (int k = 0; k < d.rows; ++k) {
    const int active = cw.row_order[static_cast<std::size_t>(k)];
    if (k < d.rank)
      independent.push_back(active);
    else
      d.redundant.push_back(cw.active[static_cast<std::size_t>(active)]);
  }
  // Here: which of the rows that are independent in general still are
  cw.rank = -1;
  update_closed(m, q, rest, cw);
  const auto n = static_cast<std::size_t>(m.nv());
  std::vector<double> J;
  for (const int active : independent)
    J.insert(J.end(), cw.J.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(active) * n),
             cw.J.begin() + static_cast<std::ptrdiff_t>((static_cast<std::size_t>(active) + 1) * n));
  std::vector<int> rows(independent.size()), columns(n);
  d.rank_here = choose_pivots(J, cw.rank_tolerance, d.rank, rows, columns);
  for (std::size_t k = static_cast<std::size_t>(d.rank_here); k < rows.size(); ++k)
    d.vanishing.push_back(cw.active[static_cast<std::size_t>(independent[static_cast<std::size_t>(rows[k])])]);
  d.freedoms_here = m.nv() - d.rank_here;
  std::ranges::sort(d.redundant);
  std::ranges::sort(d.vanishing);
  return d;
}

std::string describe(const LoopDiagnosis& d, const ClosedWorkspace& cw) {
  std::string text = counted(d.freedoms, "degree", "degrees") + " of freedom: " + counted(d.freedoms + d.rank, "freedom", "freedoms") +
                     " of joints less " + counted(d.rank, "independent row", "independent rows") + " of " + std::to_string(d.rows) + ".";
  if (!d.redundant.empty()) {
    text += " Over-constrained; these rows follow from others, and the loops' forces are not unique:";
    add_rows(cw, d.redundant, text);
  }
  if (d.is_singular_here()) {
    text += " A singular position: here " + counted(d.freedoms_here, "degree", "degrees") + " of freedom, because these rows vanish:";
    add_rows(cw, d.vanishing, text);
  }
  if (d.pivot_part < 1e-3 && d.rank > 0)
    text += " One row is nearly dependent (" + in_short(d.pivot_part) + " of the strongest): frames of its loop may not quite agree.";
  return text;
}

Error explain_gap(const Mechanism& m, const ClosedWorkspace& cw, const Closure& closure) {
  std::size_t i = 0;
  while (cw.rows.first[i + 1] <= closure.row) ++i;
  const Loop& loop = cw.loops[i];
  const std::string row(row_name(loop.type, closure.row - cw.rows.first[i]));
  std::string message = "it stays open by " + in_short(closure.gap) + " in its " + row + ".";
  if (loop.type == LoopType::gear) return {ErrorCode::structure, "loop " + loop.name, message, "Correct its polynomial or the start."};
  bool sliding = false;
  const std::vector<Bar> bars = polygon(m, loop, sliding);
  double sum = 0;
  const Bar* longest = &bars.front();
  message += " Around it, from joint to joint:";
  for (const Bar& bar : bars) {
    sum += bar.length;
    if (bar.length > longest->length) longest = &bar;
    message += (&bar == &bars.front() ? " " : ", ") + bar.link + " " + to_fixed(bar.length, 4) + " m";
  }
  const double missing = 2 * longest->length - sum;
  if (!sliding && missing > 0)
    return {ErrorCode::structure, "loop " + loop.name,
            message + ". " + longest->link + " is " + to_fixed(missing, 4) + " m longer than all the others together.",
            "Shorten it, or lengthen the others."};
  return {ErrorCode::structure, "loop " + loop.name, message + ".",
          "Correct the lengths and the frames of the loop, or start nearer to a closed position."};
}

}  // namespace ugoki::dynamics
