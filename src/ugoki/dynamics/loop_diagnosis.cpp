#include "ugoki/dynamics/loop_diagnosis.h"

#include <algorithm>

#include "ugoki/base/number.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

/// Text of a positive value for messages: values below 10 with two significant digits.
std::string two_digits(double x) {
  int decimals = 0;
  for (double y = x; y > 0 && y < 10 && decimals < 15; y *= 10) ++decimals;
  return to_fixed(x, decimals);
}

/// True if `ancestor` is `link` itself, an ancestor of it, or the world (negative index).
bool is_above(const Mechanism& m, int ancestor, int link) {
  for (; link >= 0; link = m.link(link).parent)
    if (link == ancestor) return true;
  return ancestor < 0;
}

/// A link, and the distance between its two joints in a loop, m.
struct Bar {
  std::string link;
  double length = 0;
};

/// The links around the loop as sides of a polygon: for each link, the distance between its two joints in the loop.
/// @param sliding [in/out] set to true if a joint in the loop can change one of these distances
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

/// Name of a row for messages, such as "loop knee: rotation about x".
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
  d.dofs = m.nv() - d.rank;
  std::vector<int> independent;
  const std::vector<double> rest(static_cast<std::size_t>(m.nv()), 0.0);
  update_closed(m, general, rest, cw);
  d.pivot_ratio = cw.pivot_ratio;
  for (int k = 0; k < d.rows; ++k) {
    const int active = cw.row_order[static_cast<std::size_t>(k)];
    if (k < d.rank)
      independent.push_back(active);
    else
      d.redundant.push_back(cw.active[static_cast<std::size_t>(active)]);
  }
  // Find which of the rows that are independent in general position are still independent at q
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
  d.dofs_here = m.nv() - d.rank_here;
  std::ranges::sort(d.redundant);
  std::ranges::sort(d.vanishing);
  return d;
}

std::string describe(const LoopDiagnosis& d, const ClosedWorkspace& cw) {
  std::string text = counted(d.dofs, "degree", "degrees") +
                     " of freedom: " + counted(d.dofs + d.rank, "degree of freedom", "degrees of freedom") + " of joints less " +
                     counted(d.rank, "independent row", "independent rows") + " of " + std::to_string(d.rows) + ".";
  if (!d.redundant.empty()) {
    text += " Over-constrained: these rows depend on other rows, and the forces in the loops are not unique:";
    add_rows(cw, d.redundant, text);
  }
  if (d.is_singular_here()) {
    text += " Singular configuration: " + counted(d.dofs_here, "degree", "degrees") +
            " of freedom here, because these rows are dependent here:";
    add_rows(cw, d.vanishing, text);
  }
  if (d.pivot_ratio < 1e-3 && d.rank > 0)
    text +=
        " One row is nearly dependent (pivot ratio " + two_digits(d.pivot_ratio) + "): the frames of its loop may be slightly misaligned.";
  return text;
}

Error explain_gap(const Mechanism& m, const ClosedWorkspace& cw, const Closure& closure) {
  std::size_t i = 0;
  while (cw.rows.first[i + 1] <= closure.row) ++i;
  const Loop& loop = cw.loops[i];
  const std::string row(row_name(loop.type, closure.row - cw.rows.first[i]));
  const char* const unit = row.starts_with("translation") || row == "distance" ? " m" : "";
  std::string message = "The loop cannot be closed: a gap of " + two_digits(closure.gap) + unit + " remains in its " + row + ".";
  if (loop.type == LoopType::gear)
    return {ErrorCode::structure, "loop " + loop.name, message, "Correct the gear's polynomial or the initial configuration."};
  bool sliding = false;
  const std::vector<Bar> bars = polygon(m, loop, sliding);
  double sum = 0;
  const Bar* longest = &bars.front();
  message += " Lengths of its links, from joint to joint:";
  for (const Bar& bar : bars) {
    sum += bar.length;
    if (bar.length > longest->length) longest = &bar;
    message += (&bar == &bars.front() ? " " : ", ") + bar.link + " " + to_fixed(bar.length, 4) + " m";
  }
  const double missing = 2 * longest->length - sum;
  if (!sliding && missing > 0)
    return {ErrorCode::structure, "loop " + loop.name,
            message + ". The longest, " + longest->link + ", is " + to_fixed(missing, 4) + " m longer than all the others together.",
            "Shorten the longest, or lengthen the others."};
  return {ErrorCode::structure, "loop " + loop.name, message + ".",
          "Correct the lengths and the frames of the loop, or start nearer to a closed configuration."};
}

}  // namespace ugoki::dynamics
