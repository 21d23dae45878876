#include "ugoki/motion/foot_slip.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"

namespace ugoki {
namespace {
constexpr double margin = 0.06;  // s: duration of each end of a stance that does not count (reason: foot_slip.h)
std::size_t at(int i) { return static_cast<std::size_t>(i); }
double length(const Vec3& x) { return std::sqrt(x.x * x.x + x.y * x.y); }
}  // namespace

FootSlip::FootSlip(const Mechanism& m, std::span<const int> links) : links_(links.begin(), links.end()), before_(links.size()) {
  int feet = 0;
  for (const int link : links_) {  // a link whose parent is a foot belongs to that foot
    const auto parent = std::find(links_.begin(), links_.end(), m.link(link).parent);
    const bool joined = parent != links_.end() && at(static_cast<int>(parent - links_.begin())) < foot_of_.size();
    foot_of_.push_back(joined ? foot_of_[at(static_cast<int>(parent - links_.begin()))] : feet++);
  }
  feet_.resize(at(feet));
  for (int f = 0; f < feet; ++f) {
    feet_[at(f)].first = static_cast<int>(points_.size());
    for (std::size_t slot = 0; slot < links_.size(); ++slot)
      if (foot_of_[slot] == f)
        for (const SupportPoint& p : support_points(m.link(links_[slot]))) points_.push_back({static_cast<int>(slot), p});
    feet_[at(f)].count = static_cast<int>(points_.size()) - feet_[at(f)].first;
  }
}

void FootSlip::finish(Foot& foot) {
  if (foot.age > 2 * margin) {
    const double slip = length(foot.slide);
    sum_ += slip;
    ++stances_;
    if (slip > worst_) {
      worst_ = slip;
      worst_time_ = time_;
    }
  }
  foot.stood = false;
  foot.age = 0;
  foot.slide = {};
  foot.head = foot.held = 0;
}

void FootSlip::add(std::span<const Pose> X_WB, std::span<const std::uint8_t> on, double dt) {
  UGOKI_CHECK(on.size() == links_.size());
  time_ += std::max(0.0, dt);
  for (std::size_t f = 0; f < feet_.size(); ++f) {
    Foot& foot = feet_[f];
    bool stands = false;
    for (std::size_t i = 0; i < links_.size(); ++i) stands = stands || (foot_of_[i] == static_cast<int>(f) && on[i] != 0);
    if (!stands || foot.count == 0) {
      if (foot.stood) finish(foot);
      continue;
    }
    if (foot.stood) {
      const Point* lowest = nullptr;
      double low = 0;
      for (int i = foot.first; i < foot.first + foot.count; ++i) {
        const Point& p = points_[at(i)];
        const double z = (X_WB[at(links_[at(p.slot)])] * p.at.p).z - p.at.radius;
        if (!lowest || z < low) {
          lowest = &p;
          low = z;
        }
      }
      const Pose& X = X_WB[at(links_[at(lowest->slot)])];
      const Vec3 p = lowest->at.p + transpose_times(X.R, Vec3{0, 0, -lowest->at.radius});
      const Vec3 d = X * p - before_[at(lowest->slot)] * p;
      foot.age += dt;
      // Displacements in the margin at the start of the stance are dropped. Later displacements count once they are older than the margin.
      if (foot.age > margin && foot.held < recent) {
        foot.steps[at((foot.head + foot.held) % recent)] = {d.x, d.y, dt};
        ++foot.held;
      }
      double kept = 0;
      for (int k = 0; k < foot.held; ++k) kept += foot.steps[at((foot.head + k) % recent)].z;
      while (foot.held > 0 && (kept > margin || foot.held == recent)) {
        const Vec3& step = foot.steps[at(foot.head)];
        foot.slide += {step.x, step.y, 0};
        kept -= step.z;
        foot.head = (foot.head + 1) % recent;
        --foot.held;
      }
    }
    foot.stood = true;
  }
  for (std::size_t i = 0; i < links_.size(); ++i) before_[i] = X_WB[at(links_[i])];
}

double FootSlip::mean_cm() const {
  double sum = sum_;
  int count = stances_;
  for (const Foot& f : feet_)
    if (f.stood && f.age > 2 * margin) {
      sum += length(f.slide);
      ++count;
    }
  return count > 0 ? 100 * sum / count : 0;
}

double FootSlip::now_cm() const {
  double now = 0;
  for (const Foot& f : feet_)
    if (f.stood && f.age > 2 * margin) now = std::max(now, length(f.slide));
  return 100 * now;
}

double FootSlip::worst_cm() const {
  double worst = worst_;
  for (const Foot& f : feet_)
    if (f.stood && f.age > 2 * margin) worst = std::max(worst, length(f.slide));
  return 100 * worst;
}

void FootSlip::reset() {
  for (Foot& f : feet_) {
    f.stood = false;
    f.age = 0;
    f.slide = {};
    f.head = f.held = 0;
  }
  stances_ = 0;
  sum_ = worst_ = time_ = worst_time_ = 0;
}

void FootSlip::save(std::span<double> out) const {
  UGOKI_CHECK(out.size() == memory_size());
  double* x = out.data();
  for (const double value : {static_cast<double>(stances_), sum_, worst_, time_, worst_time_}) *x++ = value;
  for (const Foot& f : feet_) {
    for (const double value : {f.stood ? 1.0 : 0.0, f.age, f.slide.x, f.slide.y, static_cast<double>(f.head), static_cast<double>(f.held)})
      *x++ = value;
    for (const Vec3& step : f.steps)
      for (const double value : {step.x, step.y, step.z}) *x++ = value;
  }
  for (const Pose& X : before_)
    for (const double value : {X.R.xx, X.R.xy, X.R.xz, X.R.yx, X.R.yy, X.R.yz, X.R.zx, X.R.zy, X.R.zz, X.p.x, X.p.y, X.p.z}) *x++ = value;
}

void FootSlip::restore(std::span<const double> in) {
  UGOKI_CHECK(in.size() == memory_size());
  const double* x = in.data();
  stances_ = static_cast<int>(*x++);
  for (double* value : {&sum_, &worst_, &time_, &worst_time_}) *value = *x++;
  for (Foot& f : feet_) {
    f.stood = *x++ != 0;
    f.age = *x++;
    f.slide.x = *x++;
    f.slide.y = *x++;
    f.head = static_cast<int>(*x++);
    f.held = static_cast<int>(*x++);
    for (Vec3& step : f.steps)
      for (double* value : {&step.x, &step.y, &step.z}) *value = *x++;
  }
  for (Pose& X : before_)
    for (double* value : {&X.R.xx, &X.R.xy, &X.R.xz, &X.R.yx, &X.R.yy, &X.R.yz, &X.R.zx, &X.R.zy, &X.R.zz, &X.p.x, &X.p.y, &X.p.z})
      *value = *x++;
}

}  // namespace ugoki
