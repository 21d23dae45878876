// Goal poses of standing feet that roll without slipping.

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/motion/pass_through.h"
#include "ugoki/motion_edit/foot_lock.h"

namespace ugoki::motion_edit {
namespace {

constexpr double leg_of_options = 0.9;  // m, leg length for which FootLockOptions is specified
constexpr double still_speed = 0.2;     // m/s: at this vertical speed the weight of a foot in contact is a quarter of its weight at rest
constexpr double lift_time = 0.02;      // s, time constant of the height correction
constexpr double twist_radius = 0.02;   // m: if all loaded points are within this radius, the foot's twist is kept, not locked

std::size_t at(int i) { return static_cast<std::size_t>(i); }

class Pinning {
 public:
  Pinning(FootPath& path, double rate, double ground, double leg, const FootLockOptions& o)
      : path_(path), rate_(rate), ground_(ground), size_(leg > 0 ? leg / leg_of_options : 1), o_(o), n_(path.X_WF.size()) {
    count_ = n_ > 0 ? path.points.size() / n_ : 0;
  }

  void run() {
    if (n_ == 0 || count_ == 0) return;
    if (o_.keep_on_ground) bring_to_ground();
    turns_ = turning_frames(path_, rate_);
    yaw_.assign(n_, 0.0);
    move_.assign(n_, Vec3{});
    std::vector<std::pair<std::size_t, std::size_t>> stances;
    for (std::size_t f = 0; f < n_; ++f) {
      if (!path_.bears[f]) continue;
      if (f == 0 || !path_.bears[f - 1]) stances.emplace_back(f, f);
      stances.back().second = f;
    }
    if (stances.empty()) return;
    for (const auto& [first, last] : stances) pin(first, last);
    for (std::size_t f = 0; f < stances.front().first; ++f) hold(f, stances.front().first);
    for (std::size_t f = stances.back().second + 1; f < n_; ++f) hold(f, stances.back().second);
    for (std::size_t k = 1; k < stances.size(); ++k) ease(stances[k - 1], stances[k]);
    for (std::size_t f = 0; f < n_; ++f) {
      Pose& X = path_.X_WF[f];
      X = {rotation_about({0, 0, 1}, yaw_[f]) * X.R, X.p + move_[f]};
    }
  }

 private:
  [[nodiscard]] const SupportPoint& point(std::size_t f, std::size_t i) const { return path_.points[f * count_ + i]; }
  /// Lowest point [m] of the sphere of support point i in frame f, in the coordinate frame of the foot.
  [[nodiscard]] Vec3 material(std::size_t f, std::size_t i) const {
    const SupportPoint& s = point(f, i);
    return s.p + transpose_times(path_.X_WF[f].R, Vec3{0, 0, -s.radius});
  }
  [[nodiscard]] double lowest(std::size_t f) const {
    double low = 1e300;
    for (std::size_t i = 0; i < count_; ++i) low = std::min(low, (path_.X_WF[f] * material(f, i)).z);
    return low;
  }

  void bring_to_ground() {
    std::vector<double> value(n_), weight(n_);
    for (std::size_t f = 0; f < n_; ++f) value[f] = ground_ - lowest(f);
    for (std::size_t f = 0; f < n_; ++f) {
      const std::size_t before = f > 0 ? f - 1 : f, after = std::min(f + 1, n_ - 1);
      const double speed = after > before ? (value[after] - value[before]) * rate_ / static_cast<double>(after - before) : 0;
      const double share = 1 / (1 + speed * speed / (still_speed * still_speed * size_));
      weight[f] = path_.bears[f] ? share * share : 0;
    }
    const std::vector<double> lift = pass_through(value, weight, lift_time * rate_ * lift_time * rate_);
    for (std::size_t f = 0; f < n_; ++f) path_.X_WF[f].p.z += std::max(lift[f], value[f]);
  }

  /// Computes the correction of one stance: rolls the foot over its sole from frame to frame, then restores the stance's mean position and
  /// heading.
  void pin(std::size_t first, std::size_t last) {
    std::vector<Vec3> bearing(n_ ? last - first + 1 : 0);  // [frames of the stance] load-weighted centre of the sole on the original path
    double yaw = 0;
    Vec3 shift;  // translation of the correction; the correction's rotation by yaw is about the world's origin
    std::vector<Vec3> shifts;
    std::vector<double> yaws;
    for (std::size_t f = first; f <= last; ++f) {
      const double low = lowest(f);
      double sum = 0;
      Vec3 a, b;  // load-weighted centres of the points: a: previous frame, corrected positions; b: this frame, original positions
      std::vector<Vec3> was(count_), is(count_);
      std::vector<double> w(count_);
      const Mat3 R_before = rotation_about({0, 0, 1}, yaw);
      for (std::size_t i = 0; i < count_; ++i) {
        const Vec3 p = material(f, i);
        is[i] = path_.X_WF[f] * p;
        const double above = (is[i].z - low) / (o_.sole * size_);
        w[i] = above < 1 ? (1 - above) * (1 - above) : 0;
        was[i] = is[i];
        if (f > first) {
          const Vec3 same = p - point(f, i).p + point(f - 1, i).p;
          was[i] = R_before * (path_.X_WF[f - 1] * same) + shift;
        }
        sum += w[i];
        a += was[i] * w[i];
        b += is[i] * w[i];
      }
      a = a / sum;
      b = b / sum;
      bearing[f - first] = b;
      if (f > first && turns_[f]) {
        const Vec3& last_bearing = bearing[f - first - 1];
        shift += (R_before * last_bearing - last_bearing) - (R_before * b - b);  // the displacement of the foot stays
      } else if (f > first) {
        double turn = 0, lever = twist_radius * twist_radius * size_ * size_;
        for (std::size_t i = 0; i < count_; ++i) {
          const Vec3 u = R_before * (is[i] - b), v = was[i] - a;
          turn += w[i] * (u.x * v.y - u.y * v.x);
          lever += w[i] * (u.x * v.x + u.y * v.y);
        }
        yaw += turn / std::max(lever, 1e-9);
        shift = a - rotation_about({0, 0, 1}, yaw) * b;
        shift.z = 0;
      }
      yaws.push_back(yaw);
      shifts.push_back(shift);
    }
    double mean_yaw = 0;
    Vec3 from, to;
    const double count = static_cast<double>(yaws.size());
    for (std::size_t k = 0; k < yaws.size(); ++k) mean_yaw += yaws[k] / count;
    const Mat3 back = rotation_about({0, 0, 1}, -mean_yaw);
    for (std::size_t k = 0; k < yaws.size(); ++k) {
      from += back * (rotation_about({0, 0, 1}, yaws[k]) * bearing[k] + shifts[k]) / count;
      to += bearing[k] / count;
    }
    for (std::size_t k = 0; k < yaws.size(); ++k) {
      const std::size_t f = first + k;
      const Vec3 p = path_.X_WF[f].p;
      yaw_[f] = yaws[k] - mean_yaw;
      move_[f] = back * (rotation_about({0, 0, 1}, yaws[k]) * p + shifts[k]) + (to - from) - p;
      move_[f].z = 0;
    }
  }

  void hold(std::size_t f, std::size_t like) {
    yaw_[f] = yaw_[like];
    move_[f] = move_[like];
  }

  /// Interpolates the correction from one stance to the next, with continuous velocity of the foot at both ends.
  void ease(const std::pair<std::size_t, std::size_t>& a, const std::pair<std::size_t, std::size_t>& b) {
    const std::size_t from = a.second, to = b.first;
    const double length = static_cast<double>(to - from), near = std::min(o_.ease * rate_, 0.5 * length);
    const auto slope = [&](std::size_t f, std::size_t g, bool any) {
      return any ? std::pair<double, Vec3>{yaw_[g] - yaw_[f], move_[g] - move_[f]} : std::pair<double, Vec3>{0, {}};
    };
    const auto leave = slope(from - 1, from, a.second > a.first), land = slope(to, to + 1, b.second > b.first);
    for (std::size_t f = from + 1; f < to; ++f) {
      const double t = static_cast<double>(f - from), left = length - t, s = t / length;
      const double h = s * s * (3 - 2 * s);
      const double out = t < near ? t * (1 - t / near) * (1 - t / near) : 0,
                   in = left < near ? left * (1 - left / near) * (1 - left / near) : 0;
      yaw_[f] = yaw_[from] + h * (yaw_[to] - yaw_[from]) + out * leave.first - in * land.first;
      move_[f] = move_[from] + (move_[to] - move_[from]) * h + leave.second * out - land.second * in;
    }
  }

  FootPath& path_;
  double rate_, ground_, size_;
  const FootLockOptions& o_;
  std::size_t n_, count_ = 0;
  std::vector<std::uint8_t> turns_;  // [frames] 1: the foot turns about a vertical axis
  std::vector<double> yaw_;          // [frames] rad, correction
  std::vector<Vec3> move_;           // [frames] m, correction of the foot's origin
};

}  // namespace

std::vector<FootPath> foot_paths(const Mechanism& m, const Motion& motion, const FootContacts& contacts) {
  std::vector<FootPath> paths(contacts.feet.size());
  std::vector<Pose> X(at(m.link_count()));
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, std::span(motion.frame(f), at(motion.nq)), X);
    for (std::size_t k = 0; k < paths.size(); ++k) {
      const FootLimb& foot = contacts.feet[k];
      const Pose& X_WF = X[at(foot.link)];
      paths[k].X_WF.push_back(X_WF);
      for (const LinkPoint& p : foot.points)
        paths[k].points.push_back({transpose_times(X_WF.R, X[at(p.link)] * p.location.p - X_WF.p), p.location.radius});
    }
  }
  for (std::size_t k = 0; k < paths.size(); ++k) paths[k].bears = contacts.bears[k];
  return paths;
}

std::vector<std::uint8_t> turning_frames(const FootPath& path, double rate) {
  const std::size_t n = path.X_WF.size();
  std::vector<double> yaw_rate(n);
  for (std::size_t f = 0; f + 1 < n; ++f) yaw_rate[f] = log_map(to_quat(path.X_WF[f + 1].R * path.X_WF[f].R.transposed())).z * rate;
  std::vector<std::uint8_t> out(n, 0);
  for (const auto& [begin, end] : find_turns(path.bears, yaw_rate, rate))
    std::fill(out.begin() + static_cast<std::ptrdiff_t>(begin), out.begin() + static_cast<std::ptrdiff_t>(end), std::uint8_t{1});
  return out;
}

void pin_stances(std::vector<FootPath>& paths, double rate, double ground, double leg, const FootLockOptions& options) {
  for (FootPath& path : paths) Pinning(path, rate, ground, leg, options).run();
}

}  // namespace ugoki::motion_edit
