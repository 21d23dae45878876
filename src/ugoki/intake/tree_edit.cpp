#include "ugoki/intake/tree_edit.h"

#include <algorithm>

namespace ugoki::intake {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Puts parents before their children. Children keep their order.
void sort_parents_first(MeasuredMotion& m) {
  const std::size_t n = m.skeleton.joints.size();
  std::vector<std::vector<int>> children(n);
  std::vector<int> order, place(n), open;
  for (std::size_t i = n; i-- > 0;) {
    const int parent = m.skeleton.joints[i].parent;
    if (parent < 0)
      open.push_back(static_cast<int>(i));
    else
      children[at(parent)].push_back(static_cast<int>(i));
  }
  while (!open.empty()) {
    const int i = open.back();
    open.pop_back();
    place[at(i)] = static_cast<int>(order.size());
    order.push_back(i);
    open.insert(open.end(), children[at(i)].begin(), children[at(i)].end());  // the last child first; it is taken last
  }
  MeasuredMotion sorted = m;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t from = at(order[k]);
    sorted.skeleton.joints[k] = m.skeleton.joints[from];
    int& parent = sorted.skeleton.joints[k].parent;
    if (parent >= 0) parent = place[at(parent)];
    for (std::size_t f = 0; f < at(m.frames); ++f) {
      sorted.translations[f * n + k] = m.translations[f * n + from];
      sorted.rotations[f * n + k] = m.rotations[f * n + from];
    }
  }
  m = std::move(sorted);
}

}  // namespace

bool is_below(const Skeleton& s, int i, int ancestor) {
  for (; i >= 0; i = s.joints[at(i)].parent)
    if (i == ancestor) return true;
  return false;
}

std::vector<std::vector<Pose>> world_of(const MeasuredMotion& m) {
  std::vector<std::vector<Pose>> world(at(m.frames));
  for (int f = 0; f < m.frames; ++f) m.calc_joint_poses(f, world[at(f)]);
  return world;
}

void set_world(MeasuredMotion& m, const std::vector<std::vector<Pose>>& world) {
  const std::size_t n = m.skeleton.joints.size();
  m.translations.resize(at(m.frames) * n);
  m.rotations.resize(at(m.frames) * n);
  for (std::size_t f = 0; f < world.size(); ++f)
    for (std::size_t i = 0; i < n; ++i) {
      const int parent = m.skeleton.joints[i].parent;
      const Pose& X = world[f][i];
      const Pose local = parent < 0 ? X : world[f][at(parent)].inverse() * X;
      m.translations[f * n + i] = local.p;
      m.rotations[f * n + i] = to_quat(local.R);
    }
}

std::vector<std::vector<Pose>> sample_poses(std::span<const MeasuredMotion> motions) {
  constexpr int max_samples = 120;
  std::vector<std::vector<Pose>> samples;
  for (const MeasuredMotion& m : motions) {
    const int step = std::max(1, m.frames * static_cast<int>(motions.size()) / max_samples);
    for (int f = 0; f < m.frames; f += step) m.calc_joint_poses(f, samples.emplace_back());
  }
  return samples;
}

double extent_of(const std::vector<Pose>& X) {
  Vec3 low = X[0].p, high = low;
  for (const Pose& x : X)
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], x.p[k]);
      high[k] = std::max(high[k], x.p[k]);
    }
  return norm(high - low);
}

double extent_of_trees(const Skeleton& s, const std::vector<Pose>& X) {
  std::vector<Pose> joined;
  for (std::size_t i = 0; i < s.joints.size(); ++i) {
    const bool carries = std::ranges::any_of(s.joints, [&](const SkeletonJoint& j) { return j.parent == static_cast<int>(i); });
    if (s.joints[i].parent >= 0 || carries) joined.push_back(X[i]);
  }
  return extent_of(joined.empty() ? X : joined);
}

std::vector<double> deviations(const std::vector<std::vector<Pose>>& samples, std::size_t i, std::size_t a) {
  std::vector<Vec3> local;
  for (const auto& X : samples) local.push_back(X[a].inverse() * X[i].p);
  Vec3 usual;
  std::vector<double> values(local.size());
  for (int k = 0; k < 3; ++k) {
    std::ranges::transform(local, values.begin(), [&](const Vec3& p) { return p[k]; });
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    usual[k] = *middle;
  }
  std::ranges::transform(local, values.begin(), [&](const Vec3& p) { return norm(p - usual); });
  std::ranges::sort(values);
  return values;
}

double quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

void reparent(std::span<MeasuredMotion> motions, std::span<const int> new_parent) {
  for (MeasuredMotion& m : motions) {
    const std::vector<std::vector<Pose>> world = world_of(m);
    const std::vector<Vec3> rest = rest_positions(m.skeleton);
    for (std::size_t i = 0; i < new_parent.size(); ++i) {
      if (new_parent[i] < 0) continue;
      m.skeleton.joints[i].translates = true;
      m.skeleton.joints[i].parent = new_parent[i];
      m.skeleton.joints[i].offset = rest[i] - rest[at(new_parent[i])];
    }
    set_world(m, world);
    sort_parents_first(m);
  }
}

void append_rigid(MeasuredMotion& m, const std::string& name, int parent, const Vec3& offset, std::vector<Vec3> end_sites) {
  const std::size_t n = m.skeleton.joints.size();
  SkeletonJoint joint;
  joint.name = name;
  joint.parent = parent;
  joint.offset = offset;
  joint.end_sites = std::move(end_sites);
  m.skeleton.joints.push_back(std::move(joint));
  std::vector<Vec3> translations;
  std::vector<Quat> rotations;
  for (std::size_t f = 0; f < at(m.frames); ++f) {
    for (std::size_t i = 0; i < n; ++i) {
      translations.push_back(m.translations[f * n + i]);
      rotations.push_back(m.rotations[f * n + i]);
    }
    translations.push_back(offset);
    rotations.push_back({});
  }
  m.translations = std::move(translations);
  m.rotations = std::move(rotations);
}

}  // namespace ugoki::intake
