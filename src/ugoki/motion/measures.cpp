#include "ugoki/motion/measures.h"

#include <algorithm>

#include "ugoki/base/check.h"

namespace ugoki {
namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

FootSkate::FootSkate(const Mechanism& mechanism, std::span<const int> links) {
  for (const int link : links) {
    Foot foot;
    foot.link = link;
    foot.first = static_cast<int>(points_.size());
    for (const SupportPoint& p : support_points(mechanism.link(link))) points_.push_back(p);
    foot.count = static_cast<int>(points_.size()) - foot.first;
    feet_.push_back(foot);
  }
}

void FootSkate::add(std::span<const Pose> X_WB, std::span<const std::uint8_t> on, double dt) {
  UGOKI_CHECK(on.size() == feet_.size());
  for (std::size_t k = 0; k < feet_.size(); ++k) {
    Foot& foot = feet_[k];
    const Pose& X = X_WB[at(foot.link)];
    const bool stands = on[k] != 0;
    if (stands && !foot.stood) {
      ++stances_;
      foot.path = 0;
    }
    if (stands && foot.stood && foot.count > 0) {
      // Horizontal displacement, since the previous frame, of the material point that is lowest now.
      const SupportPoint* lowest = nullptr;
      double minimum = 0;
      for (int i = foot.first; i < foot.first + foot.count; ++i) {
        const double z = (X * points_[at(i)].p).z - points_[at(i)].radius;
        if (!lowest || z < minimum) {
          lowest = &points_[at(i)];
          minimum = z;
        }
      }
      const Vec3 p = lowest->p + transpose_times(X.R, Vec3{0, 0, -lowest->radius});
      const Vec3 d = X * p - foot.before * p;
      const double step = std::sqrt(d.x * d.x + d.y * d.y);
      foot.path += step;
      path_ += step;
      worst_ = std::max(worst_, foot.path);
      if (dt > 0) {
        square_ += step * step / dt;
        time_ += dt;
      }
    }
    foot.stood = stands;
    foot.before = X;
  }
}

void FootSkate::reset() {
  for (Foot& f : feet_) f.stood = false;
  stances_ = 0;
  path_ = worst_ = square_ = time_ = 0;
}

void FootSkate::save(std::span<double> out) const {
  UGOKI_CHECK(out.size() == memory_size());
  double* x = out.data();
  for (const double value : {static_cast<double>(stances_), path_, worst_, square_, time_}) *x++ = value;
  for (const Foot& f : feet_) {
    const Mat3& R = f.before.R;
    const Vec3& p = f.before.p;
    for (const double value : {f.stood ? 1.0 : 0.0, f.path, R.xx, R.xy, R.xz, R.yx, R.yy, R.yz, R.zx, R.zy, R.zz, p.x, p.y, p.z})
      *x++ = value;
  }
}

void FootSkate::restore(std::span<const double> in) {
  UGOKI_CHECK(in.size() == memory_size());
  const double* x = in.data();
  stances_ = static_cast<int>(*x++);
  for (double* value : {&path_, &worst_, &square_, &time_}) *value = *x++;
  for (Foot& f : feet_) {
    f.stood = *x++ != 0;
    f.path = *x++;
    Mat3& R = f.before.R;
    Vec3& p = f.before.p;
    for (double* value : {&R.xx, &R.xy, &R.xz, &R.yx, &R.yy, &R.yz, &R.zx, &R.zy, &R.zz, &p.x, &p.y, &p.z}) *value = *x++;
  }
}

double FootSkate::mean_per_stance_cm() const { return stances_ > 0 ? 100 * path_ / stances_ : 0; }
double FootSkate::rms_speed() const { return time_ > 0 ? std::sqrt(square_ / time_) : 0; }

GroundPenetration::GroundPenetration(const Mechanism& mechanism, double ground) : ground_(ground) {
  for (int i = 0; i < mechanism.link_count(); ++i)
    for (const SupportPoint& p : support_points(mechanism.link(i))) points_.push_back({i, p});
}

double GroundPenetration::add(std::span<const Pose> X_WB) {
  double deepest = 0;
  for (const Point& p : points_) {
    const double depth = ground_ - ((X_WB[at(p.link)] * p.at.p).z - p.at.radius);
    if (depth <= deepest) continue;
    deepest = depth;
    if (depth > worst_) {
      worst_ = depth;
      worst_link_ = p.link;
    }
  }
  square_ += deepest * deepest;
  ++frames_;
  return deepest;
}

void GroundPenetration::reset() {
  worst_ = square_ = 0;
  frames_ = 0;
  worst_link_ = -1;
}

void GroundPenetration::save(std::span<double> out) const {
  UGOKI_CHECK(out.size() == memory_size());
  out[0] = worst_;
  out[1] = square_;
  out[2] = frames_;
  out[3] = worst_link_;
}

void GroundPenetration::restore(std::span<const double> in) {
  UGOKI_CHECK(in.size() == memory_size());
  worst_ = in[0];
  square_ = in[1];
  frames_ = static_cast<int>(in[2]);
  worst_link_ = static_cast<int>(in[3]);
}

double GroundPenetration::rms_mm() const { return frames_ > 0 ? 1000 * std::sqrt(square_ / frames_) : 0; }

}  // namespace ugoki
