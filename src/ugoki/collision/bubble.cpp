#include "ugoki/collision/bubble.h"

#include <algorithm>

#include "ugoki/collision/bubble_kernel.h"
#include "ugoki/collision/triangle_distance.h"

namespace ugoki::collision {
namespace {

constexpr double farthest_pose = 1e9;  // m: poses farther away get status not_finite

const BubbleKernel* table_of(BubbleWidth width) {
#ifdef UGOKI_X86_WIDTHS
  if (width == BubbleWidth::avx512)
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") ? &avx512::bubble_table : nullptr;
  if (width == BubbleWidth::avx2) return __builtin_cpu_supports("avx2") ? &avx2::bubble_table : nullptr;
#endif
  return width == BubbleWidth::plain ? &plain::bubble_table : nullptr;
}

// Kernel selected by use_bubble_width() (tests and benchmarks, before other threads run); null: the widest one.
const BubbleKernel* chosen = nullptr;

KernelTree plain_tree(const SphereTree& t) { return {t.blocks.data(), &t.vertices.data()->x, t.triangles.data()->data()}; }

template <class Real>
KernelPose<Real> kernel_pose(const Pose& X) {
  KernelPose<Real> out;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) out.R[i][j] = static_cast<Real>(X.R.row(i)[j]);
    out.p[i] = static_cast<Real>(X.p[i]);
  }
  return out;
}

/// Maximum count of entries on the stack of a depth-first search: each level adds at most seven (block_lanes - 1).
std::size_t stack_size(const SphereTree& a, const SphereTree& b) {
  const auto levels = [](std::size_t n) {
    std::size_t out = 2;
    for (; n > 1; n = (n + 1) / 2) ++out;
    return out;
  };
  return (block_lanes - 1) * (levels(a.triangles.size()) + levels(b.triangles.size())) + block_lanes;
}

/// Two sphere trees at their poses. The origins of the frames A and B of this struct are at the trees' centres.
struct Placed {
  const SphereTree& a;
  const SphereTree& b;
  Pose X_WA, X_AB;  // m
  double reach;     // m: upper bound of all coordinates in frame A

  Placed(const SphereTree& ta, const Pose& A, const SphereTree& tb, const Pose& B)
      : a(ta),
        b(tb),
        X_WA{A.R, A * ta.centre},
        X_AB{A.R.transposed() * B.R, transpose_times(A.R, (B.p - A.p) + (B.R * tb.centre - A.R * ta.centre))} {
    reach = norm(X_AB.p) + a.radius + b.radius;
  }

  /// Distance and closest points of two triangles, in frame A.
  [[nodiscard]] TriangleDistance test(const TrianglePair& pair) const {
    return triangle_distance({a.corner(pair.a, 0), a.corner(pair.a, 1), a.corner(pair.a, 2)},
                             {X_AB * b.corner(pair.b, 0), X_AB * b.corner(pair.b, 1), X_AB * b.corner(pair.b, 2)});
  }
  /// Returns the distance, or 0 if it is at most 1e-14 of the summed bounding radii: such values are rounding errors.
  [[nodiscard]] double snapped(double distance) const { return distance <= 1e-14 * (a.radius + b.radius) ? 0 : distance; }

  /// Makes the query for the SIMD kernel.
  /// @param best m: search radius
  [[nodiscard]] KernelQuery query(BubbleWorkspace& workspace, double best) const {
    KernelQuery q{};
    q.a = plain_tree(a);
    q.b = plain_tree(b);
    q.X_AB = kernel_pose<double>(X_AB);
    q.X_AB_f = kernel_pose<float>(X_AB);
    q.X_BA_f = kernel_pose<float>(X_AB.inverse());
    q.slack = static_cast<float>(4e-6 * reach);  // covers the rounding of the float tests, about 30 float epsilons of the coordinates
    q.best2 = best * best;
    q.shrink = 1;
    q.nearest = {-1, -1};
    const std::size_t entries = stack_size(a, b);
    if (workspace.stack.size() < entries) workspace.stack.resize(entries);
    q.stack = workspace.stack.data();
    return q;
  }
};

bool is_valid_pair(const TrianglePair& p, const SphereTree& a, const SphereTree& b) {
  return p.a >= 0 && p.b >= 0 && static_cast<std::size_t>(p.a) < a.triangles.size() && static_cast<std::size_t>(p.b) < b.triangles.size();
}

}  // namespace

bool can_be_placed(const Pose& X) {
  double sum = std::fabs(X.p.x) + std::fabs(X.p.y) + std::fabs(X.p.z);
  for (int i = 0; i < 3; ++i) sum += std::fabs(X.R.row(i).x) + std::fabs(X.R.row(i).y) + std::fabs(X.R.row(i).z);
  return sum < farthest_pose;  // false for NaN
}

const BubbleKernel& bubble_kernel() {
  static const BubbleKernel* const widest = [] {
    for (const BubbleWidth width : {BubbleWidth::avx512, BubbleWidth::avx2})
      if (table_of(width) != nullptr) return table_of(width);
    return table_of(BubbleWidth::plain);
  }();
  return chosen != nullptr ? *chosen : *widest;
}

bool use_bubble_width(BubbleWidth width) {
  const BubbleKernel* const table = table_of(width);
  if (table != nullptr) chosen = table;
  return table != nullptr;
}

BubbleDistance find_distance(const SphereTree& a, const Pose& X_WA, const SphereTree& b, const Pose& X_WB, TrianglePair& warm,
                             BubbleWorkspace& workspace, const BubbleOptions& options) {
  BubbleDistance out;
  if (a.empty() || b.empty() || !can_be_placed(X_WA) || !can_be_placed(X_WB) || std::isnan(options.farthest)) return out;
  const Placed placed(a, X_WA, b, X_WB);
  // No two points of the bodies are farther apart than 2 * reach.
  const double above = std::min(std::max(options.farthest, 0.0), 2 * placed.reach);
  TriangleDistance nearest;
  nearest.distance = above;
  TrianglePair pair;
  if (is_valid_pair(warm, a, b)) {
    const TriangleDistance last = placed.test(warm);
    if (last.distance < above) {
      nearest = last;
      pair = warm;
    }
  }
  KernelQuery query = placed.query(workspace, nearest.distance);
  query.nearest = {pair.a, pair.b};
  query.shrink = 1 / (1 + std::max(0.0, options.relative_error));
  if (pair.a >= 0 && nearest.distance > 0)
    for (int i = 0; i < 3; ++i) query.towards_b[i] = static_cast<float>((nearest.pb[i] - nearest.pa[i]) / nearest.distance);
  if (nearest.distance > 0) bubble_kernel().search(query);
  out.bound_tests = query.bound_tests;
  out.triangle_tests = query.triangle_tests;
  if (query.nearest.a != pair.a || query.nearest.b != pair.b) {
    pair = {query.nearest.a, query.nearest.b};
    nearest = placed.test(pair);
  }
  if (pair.a < 0) {
    out.status = BubbleStatus::beyond;
    out.distance = out.lower = above;
    return out;
  }
  warm = out.nearest = pair;
  out.distance = placed.snapped(nearest.distance);
  out.lower = out.distance * query.shrink;
  out.pa = placed.X_WA * nearest.pa;
  out.pb = placed.X_WA * nearest.pb;
  out.status = out.distance > 0 ? BubbleStatus::separated : BubbleStatus::touching;
  if (out.distance > 0) out.n = placed.X_WA.R * normalized(nearest.pa - nearest.pb);
  return out;
}

PairsFound find_pairs_within(const SphereTree& a, const Pose& X_WA, const SphereTree& b, const Pose& X_WB, double margin,
                             std::span<TriangleContact> out, BubbleWorkspace& workspace) {
  PairsFound found;
  if (a.empty() || b.empty() || !can_be_placed(X_WA) || !can_be_placed(X_WB) || std::isnan(margin)) {
    found.status = BubbleStatus::not_finite;
    return found;
  }
  if (!(margin > 0)) return found;
  const Placed placed(a, X_WA, b, X_WB);
  KernelQuery query = placed.query(workspace, std::min(margin, 2 * placed.reach));
  if (workspace.pairs.size() < out.size() + 1) workspace.pairs.resize(out.size() + 1);
  query.pairs = workspace.pairs.data();
  query.room = out.size();
  bubble_kernel().search(query);
  found.count = std::min(query.found, out.size());
  found.complete = query.found <= out.size();
  for (std::size_t i = 0; i < found.count; ++i) {
    const TrianglePair pair{query.pairs[i].a, query.pairs[i].b};
    const TriangleDistance d = placed.test(pair);
    out[i] = {pair, placed.snapped(d.distance), placed.X_WA * d.pa, placed.X_WA * d.pb};
  }
  return found;
}

}  // namespace ugoki::collision
