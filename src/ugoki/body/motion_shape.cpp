#include "ugoki/body/motion_shape.h"

#include <algorithm>

namespace ugoki::body {
namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
constexpr double free_share = 0.25;  // share of the character's size; no bone connects a joint that shifts further to its parent
}  // namespace

MotionShape::MotionShape(const MeasuredMotion& m, int max_frames) : m_(m) {
  const int n = m.joint_count();
  const int count = std::min(m.frames, max_frames);
  children_.resize(at(n));
  length_.assign(at(n), 0);
  free_.assign(at(n), 0);
  std::vector<double> shift(at(n), 0);
  std::vector<std::vector<double>> lengths(at(n));
  for (int k = 0; k < count; ++k) {
    const int f = count > 1 ? static_cast<int>(static_cast<std::int64_t>(k) * (m.frames - 1) / (count - 1)) : 0;
    X_.emplace_back();
    m.calc_joint_poses(f, X_.back());
    for (int i = 0; i < n; ++i) {
      const Vec3& t = m.translations[at(f) * at(n) + at(i)];
      lengths[at(i)].push_back(norm(t));
      shift[at(i)] = std::max(shift[at(i)], norm(t - m.translations[at(i)]));
    }
  }
  for (int i = 0; i < n; ++i) {
    const int parent = m.skeleton.joints[at(i)].parent;
    if (parent < 0) continue;
    children_[at(parent)].push_back(i);
    auto& l = lengths[at(i)];
    if (l.empty()) continue;
    std::nth_element(l.begin(), l.begin() + static_cast<std::ptrdiff_t>(l.size() / 2), l.end());
    length_[at(i)] = l[l.size() / 2];
  }
  // The character's size is the longest path along bones of constant length. Bones that are far longer than most others connect a character
  // to its scene and do not count.
  std::vector<double> rigid;
  for (int i = 0; i < n; ++i)
    if (m.skeleton.joints[at(i)].parent >= 0 && length_[at(i)] > 0 && shift[at(i)] <= 0.05 * length_[at(i)])
      rigid.push_back(length_[at(i)]);
  double longest = 1e300;
  if (!rigid.empty()) {
    const auto k = rigid.begin() + static_cast<std::ptrdiff_t>(rigid.size() * 3 / 4);
    std::nth_element(rigid.begin(), k, rigid.end());
    longest = 12 * *k;
  }
  std::vector<double> down(at(n), 0);
  double size = 0;
  for (int i = n - 1; i >= 0; --i) {
    const int parent = m.skeleton.joints[at(i)].parent;
    if (parent < 0 || length_[at(i)] > longest || (!rigid.empty() && shift[at(i)] > 0.05 * length_[at(i)])) continue;
    const double d = down[at(i)] + length_[at(i)];
    size = std::max(size, down[at(parent)] + d);
    down[at(parent)] = std::max(down[at(parent)], d);
  }
  for (int i = 0; i < n; ++i) free_[at(i)] = m.skeleton.joints[at(i)].parent < 0 || shift[at(i)] > free_share * size + 1e-12 ? 1 : 0;
}

Vec3 MotionShape::tip(int f, int i) const {
  const Pose& X = pose(f, i);
  Vec3 end{};
  for (const Vec3& e : m_.skeleton.joints[at(i)].end_sites)
    if (norm(e) > norm(end)) end = e;
  return X * end;
}

MotionShape::Distance MotionShape::distance(int i, int j) const {
  double sum = 0, squares = 0;
  for (int f = 0; f < frames(); ++f) {
    const double d = norm(p(f, i) - p(f, j));
    sum += d;
    squares += d * d;
  }
  const double count = std::max(1, frames()), mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean))};
}

}  // namespace ugoki::body
