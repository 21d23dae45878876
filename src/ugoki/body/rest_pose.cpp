// Canonical rest poses. Limits, masses and shapes are measured in this pose. It does not depend on the rest pose of the file.

#include <algorithm>

#include "ugoki/base/check.h"
#include "ugoki/body/motion_shape.h"
#include "ugoki/body/recognise.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::body {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Rotation closest to the sum of rotations `m` (polar decomposition by Newton's iteration); `fallback` if the sum is degenerate.
Mat3 nearest_rotation(Mat3 m, const Mat3& fallback) {
  const auto determinant = [](const Mat3& a) { return dot(a.column(0), cross(a.column(1), a.column(2))); };
  double scale = 0;
  for (int k = 0; k < 3; ++k) scale = std::max(scale, norm(m.column(k)));
  if (!(scale > 1e-12)) return fallback;
  m = m * (1 / scale);
  if (!(determinant(m) > 0.02)) return fallback;
  for (int k = 0; k < 60; ++k) {
    const Mat3 next = (m + inverse(m).transposed()) * 0.5;
    const Mat3 change = next - m;
    m = next;
    if (norm(change.column(0)) + norm(change.column(1)) + norm(change.column(2)) < 1e-15) break;
  }
  return to_matrix(normalized(to_quat(m)));
}

Mat3 turn_between(const Vec3& from, const Vec3& to) {
  if (!(norm(from) > 1e-12) || !(norm(to) > 1e-12)) return Mat3::identity();
  return to_matrix(rotation_between(normalized(from), normalized(to)));
}

/// Makes the canonical pose of one motion.
class Poser {
 public:
  Poser(const MeasuredMotion& m, const Character& f) : m_(m), f_(f), n_(m.joint_count()), shape_(m) {}

  std::vector<Mat3> human() {
    weigh_frames();
    find_mean();
    Q_.assign(at(n_), Mat3::identity());
    std::vector<char> done(at(n_), 0);
    for (int i = 0; i < n_; ++i) {
      const int p = m_.skeleton.joints[at(i)].parent;
      Q_[at(i)] = p < 0 ? Mat3::identity() : Q_[at(p)];
      if (i == f_.pelvis) Q_[at(i)] = turn_between(side_line(f_.legs), {0, 1, 0});
      for (std::size_t k = 1; k < f_.trunk.size(); ++k)
        if (f_.trunk[k] == i) pose_trunk(i, k);
      for (std::size_t k = 0; k < f_.neck.size(); ++k)
        if (f_.neck[k] == i && k + 1 < f_.neck.size()) level(i, mean_p_[at(f_.neck[k + 1])] - mean_p_[at(i)]);
      for (int s = 0; s < 2; ++s) {
        const double side = s == 0 ? 1 : -1;
        const Limb &leg = f_.legs[at(s)], &arm = f_.arms[at(s)];
        if (i == leg.proximal) point(i, leg.distal, {0, 0, -1});
        if (i == leg.distal) point(i, leg.end, {0, 0, -1});
        if (i == leg.end) pose_foot(s, done);
        if (i == arm.proximal) point(i, arm.distal, {0, side, 0});
        if (i == arm.distal) aim(i, arm.end >= 0 ? mean_p_[at(arm.end)] - mean_p_[at(i)] : mean_tip(i), {0, side, 0});
        if (i == arm.end) aim(i, arm.tip >= 0 ? mean_p_[at(arm.tip)] - mean_p_[at(i)] : mean_tip(i), {0, side, 0});
      }
      if (done[at(i)] != 0) Q_[at(i)] = Mat3::identity();
    }
    std::vector<Mat3> turns(at(n_));
    for (int i = 0; i < n_; ++i) turns[at(i)] = Q_[at(i)] * mean_[at(i)];
    return turns;
  }

  /// Pose of the frame that is closest to the mean posture, heading along x.
  std::vector<Mat3> creature() {
    const int frames = shape_.frames();
    std::vector<Mat3> heading(at(frames));
    for (int f = 0; f < frames; ++f) heading[at(f)] = heading_of(f);
    // Mean posture: mean positions relative to the first joint, in heading axes.
    const int base = f_.pelvis >= 0 ? f_.pelvis : 0;
    std::vector<Vec3> mean(at(n_));
    const auto local = [&](int f, int i) { return transpose_times(heading[at(f)], shape_.p(f, i) - shape_.p(f, base)); };
    for (int f = 0; f < frames; ++f)
      for (int i = 0; i < n_; ++i) mean[at(i)] += local(f, i) / frames;
    int best = 0;
    double smallest = 1e300;
    for (int f = 0; f < frames; ++f) {
      double error = 0;
      for (int i = 0; i < n_; ++i) {
        const Vec3 d = local(f, i) - mean[at(i)];
        error += dot(d, d);
      }
      if (error < smallest) {
        smallest = error;
        best = f;
      }
    }
    std::vector<Mat3> turns(at(n_));
    for (int i = 0; i < n_; ++i) turns[at(i)] = heading[at(best)].transposed() * shape_.pose(best, i).R;
    return turns;
  }

 private:
  /// Rotation about z whose x axis is the character's forward direction in a frame; from the hips' line, or for characters without legs
  /// from the horizontal direction of the longest extent.
  [[nodiscard]] Mat3 heading_of(int f) const {
    Vec3 left{};
    if (f_.legs[0].proximal >= 0 && f_.legs[1].proximal >= 0) left = shape_.p(f, f_.legs[0].proximal) - shape_.p(f, f_.legs[1].proximal);
    if (f_.arms[0].proximal >= 0 && f_.arms[1].proximal >= 0) left += shape_.p(f, f_.arms[0].proximal) - shape_.p(f, f_.arms[1].proximal);
    Vec3 forward = cross(left, Vec3{0, 0, 1});
    if (f_.plan != BodyPlan::human && f_.pelvis >= 0 && f_.chest >= 0) {
      const Vec3 spine = shape_.p(f, f_.chest) - shape_.p(f, f_.pelvis);
      forward = {spine.x, spine.y, 0};
    }
    if (f_.plan == BodyPlan::other) forward = {1, 0, 0};
    forward = normalized(Vec3{forward.x, forward.y, 0}, {1, 0, 0});
    if (norm(forward) < 0.5) forward = {1, 0, 0};
    return Mat3::columns(forward, {-forward.y, forward.x, 0}, {0, 0, 1});
  }

  /// Calculates the weights of the frames. Frames in which the character stands upright with straight legs get the largest weights.
  void weigh_frames() {
    const int frames = shape_.frames();
    std::vector<double> score(at(frames));
    double best = -1e9;
    for (int f = 0; f < frames; ++f) {
      const auto middle = [&](const std::array<Limb, 2>& l) { return (shape_.p(f, l[0].proximal) + shape_.p(f, l[1].proximal)) * 0.5; };
      double s = normalized(middle(f_.arms) - middle(f_.legs)).z;
      for (const Limb& l : f_.legs) {
        const Vec3 hip = shape_.p(f, l.proximal), knee = shape_.p(f, l.distal), ankle = shape_.p(f, l.end);
        s += 0.5 * (hip.z - ankle.z) / std::max(1e-9, norm(knee - hip) + norm(ankle - knee));
      }
      score[at(f)] = s;
      best = std::max(best, s);
      heading_.push_back(heading_of(f));
    }
    for (int f = 0; f < frames; ++f) weight_.push_back(ugoki::exp(20 * (score[at(f)] - best)));
  }

  /// Calculates the weighted mean orientations and positions of all joints over the frames, in heading axes.
  void find_mean() {
    const int frames = shape_.frames();
    int best = 0;
    for (int f = 0; f < frames; ++f)
      if (weight_[at(f)] > weight_[at(best)]) best = f;
    mean_.resize(at(n_));
    mean_p_.resize(at(n_));
    for (int i = 0; i < n_; ++i) {
      Mat3 sum{};
      for (int f = 0; f < frames; ++f) sum += (heading_[at(f)].transposed() * shape_.pose(f, i).R) * weight_[at(f)];
      mean_[at(i)] = nearest_rotation(sum, heading_[at(best)].transposed() * shape_.pose(best, i).R);
      const int p = m_.skeleton.joints[at(i)].parent;
      Vec3 offset{};
      double total = 0;
      for (int f = 0; f < frames && p >= 0; ++f) {
        offset += transpose_times(shape_.pose(f, p).R, shape_.p(f, i) - shape_.p(f, p)) * weight_[at(f)];
        total += weight_[at(f)];
      }
      mean_p_[at(i)] = p < 0 ? Vec3{} : mean_p_[at(p)] + mean_[at(p)] * (offset / std::max(total, 1e-300));
    }
  }

  [[nodiscard]] Vec3 side_line(const std::array<Limb, 2>& limbs) const {
    return mean_p_[at(limbs[0].proximal)] - mean_p_[at(limbs[1].proximal)];
  }
  /// Vector [m] to the farthest end site of the joint in the mean pose.
  [[nodiscard]] Vec3 mean_tip(int i) const {
    Vec3 best{};
    for (const Vec3& e : m_.skeleton.joints[at(i)].end_sites)
      if (norm(e) > norm(best)) best = e;
    return mean_[at(i)] * best;
  }

  /// Turns joint i so that `direction` (mean pose) points along `target`.
  void aim(int i, const Vec3& direction, const Vec3& target) {
    if (norm(direction) > 1e-6) Q_[at(i)] = turn_between(Q_[at(i)] * direction, target) * Q_[at(i)];
  }
  void point(int i, int to, const Vec3& target) { aim(i, mean_p_[at(to)] - mean_p_[at(i)], target); }
  /// Turns joint i so that `direction` lies in the middle plane.
  void level(int i, const Vec3& direction) {
    const Vec3 d = Q_[at(i)] * direction;
    if (norm(d) > 1e-6 && std::fabs(d.y) < 0.9 * norm(d)) Q_[at(i)] = turn_between(d, {d.x, 0, d.z}) * Q_[at(i)];
  }
  void pose_trunk(int i, std::size_t k) {
    if (i == f_.chest) {
      Q_[at(i)] = turn_between(Q_[at(i)] * side_line(f_.arms), {0, 1, 0}) * Q_[at(i)];
      return;
    }
    level(i, mean_p_[at(f_.trunk[k + 1])] - mean_p_[at(i)]);
  }

  /// Poses foot and toes as they stand: in their mean orientation over the frames in which ankle and toes are lowest, pointing forward.
  void pose_foot(int s, std::vector<char>& done) {
    const Limb& leg = f_.legs[at(s)];
    const int frames = shape_.frames();
    const auto front = [&](int f) { return leg.tip >= 0 ? shape_.p(f, leg.tip) : shape_.tip(f, leg.end); };
    std::vector<double> low_ankle, low_front;
    for (int f = 0; f < frames; ++f) {
      low_ankle.push_back(shape_.p(f, leg.end).z);
      low_front.push_back(front(f).z);
    }
    const auto percentile = [](std::vector<double> v) {
      const auto k = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 20);
      std::nth_element(v.begin(), k, v.end());
      return *k;
    };
    const double ankle = percentile(low_ankle), toes = percentile(low_front);
    const double length = norm(mean_p_[at(leg.end)] - mean_p_[at(leg.proximal)]), scale = 0.02 * std::max(length, 1e-9);
    double best = -1;
    int best_frame = 0;
    std::vector<double> weight;
    std::vector<Mat3> heading;
    for (int f = 0; f < frames; ++f) {
      const Vec3 along = front(f) - shape_.p(f, leg.end);
      const Vec3 flat = {along.x, along.y, 0};
      const Vec3 x = norm(flat) > 0.3 * norm(along) && norm(along) > 1e-9 ? normalized(flat) : heading_[at(f)].column(0);
      heading.push_back(Mat3::columns(x, {-x.y, x.x, 0}, {0, 0, 1}));
      const double high = std::max(0.0, low_ankle[at(f)] - ankle) + std::max(0.0, low_front[at(f)] - toes);
      weight.push_back(ugoki::exp(-high / scale));
      if (weight.back() > best) {
        best = weight.back();
        best_frame = f;
      }
    }
    for (int i = leg.end; i < n_; ++i) {
      bool below = false;
      for (int k = i; k >= 0 && !below; k = m_.skeleton.joints[at(k)].parent) below = k == leg.end;
      if (!below) continue;
      Mat3 sum{};
      for (int f = 0; f < frames; ++f) sum += (heading[at(f)].transposed() * shape_.pose(f, i).R) * weight[at(f)];
      mean_[at(i)] = nearest_rotation(sum, heading[at(best_frame)].transposed() * shape_.pose(best_frame, i).R);
      done[at(i)] = 1;
    }
  }

  const MeasuredMotion& m_;
  const Character& f_;
  int n_;
  MotionShape shape_;
  std::vector<double> weight_;  // [frames]
  std::vector<Mat3> heading_;   // [frames]
  std::vector<Mat3> mean_;      // [joints] mean orientation in heading axes
  std::vector<Vec3> mean_p_;    // [joints] m, positions in the mean pose
  std::vector<Mat3> Q_;         // [joints] rotation from the mean pose to the canonical pose, world axes
};

}  // namespace

std::vector<Mat3> canonical_turns(const MeasuredMotion& motion, const Character& character) {
  if (motion.frames == 0 || motion.skeleton.joints.empty()) return {};
  Poser poser(motion, character);
  return character.plan == BodyPlan::human ? poser.human() : poser.creature();
}

MeasuredMotion with_rest_pose(const MeasuredMotion& motion, std::span<const Mat3> turns) {
  const std::size_t n = motion.skeleton.joints.size();
  UGOKI_CHECK(turns.size() == n);
  MeasuredMotion out = motion;
  std::vector<Quat> q;
  for (const Mat3& R : turns) q.push_back(to_quat(R));
  for (std::size_t i = 0; i < n; ++i) {
    SkeletonJoint& j = out.skeleton.joints[i];
    j.offset = j.parent < 0 ? Vec3{} : turns[at(j.parent)] * j.offset;
    for (Vec3& e : j.end_sites) e = turns[i] * e;
    for (MeasuredDof& d : j.dofs) d.axis = turns[i] * d.axis;
  }
  for (std::size_t f = 0; f < at(motion.frames); ++f)
    for (std::size_t i = 0; i < n; ++i) {
      const int parent = motion.skeleton.joints[i].parent;
      Quat& r = out.rotations[f * n + i];
      r = r * q[i].conjugate();
      if (parent >= 0) {
        r = q[at(parent)] * r;
        out.translations[f * n + i] = turns[at(parent)] * out.translations[f * n + i];
      }
      r = normalized(r);
    }
  return out;
}

}  // namespace ugoki::body
