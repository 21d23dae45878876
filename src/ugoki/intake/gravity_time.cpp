#include "ugoki/intake/gravity_time.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/intake/flight_timing.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/motion/upsample.h"

namespace ugoki::intake {
namespace {

constexpr double gravity = 9.81;   // m/s^2
constexpr double fine_rate = 120;  // frames per second, of the analysis
constexpr double min_rate = 60;    // frames per second, of the result
constexpr double gap = 0.03;       // share of the height: below it a point carries load
constexpr double high = 0.1;       // share of the height that the lowest point reaches in a flight; lower hovering is removed (lowering.h)
constexpr double shortest = 0.08;  // s: shorter flights have no accurate acceleration
constexpr double longest = 1.2;    // s: longer ones are no jumps (0.4 s for 0.2 m, 1.2 s for 1.8 m)
constexpr double tolerance = 0.3;  // of gravity: mean accelerations of captured flights deviate by up to 0.1
constexpr double froude = 0.25;    // square of the speed over the ground divided by gravity and height: faster flights are kept
constexpr double remaining = 0.2;  // of the impossible acceleration, at most, after the change
constexpr double exact = 0.1;      // g^2: with so little impossible acceleration, heights stay
constexpr double max_left = 0.3;   // g^2: with more, the motion is not changed
constexpr double max_raise = 0.3;  // share of the height

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Cubic through b and c with the slopes of Catmull and Rom, at s in [0, 1] from b to c.
double between(double a, double b, double c, double d, double s) {
  return b + 0.5 * s * (c - a + s * (2 * a - 5 * b + 4 * c - d + s * (3 * (b - c) + d - a)));
}

/// The pose at `frame`, which need not be whole. @param translations, rotations [joints, out]
void sample_at(const MeasuredMotion& m, double frame, Vec3* translations, Quat* rotations) {
  const std::size_t n = m.skeleton.joints.size();
  const int last = m.frames - 1, i = std::clamp(static_cast<int>(frame), 0, std::max(0, last - 1));
  const double s = std::clamp(frame - i, 0.0, 1.0);
  const std::size_t f[4] = {at(std::max(0, i - 1)), at(i), at(std::min(last, i + 1)), at(std::min(last, i + 2))};
  for (std::size_t j = 0; j < n; ++j) {
    Vec3 p[4];
    Quat r[4];
    for (int k = 0; k < 4; ++k) {
      p[k] = m.translations[f[k] * n + j];
      r[k] = m.rotations[f[k] * n + j];
      const Quat& near = r[std::max(0, k - 1)];  // of a quaternion and its negative, the one closer to the frame before
      if (r[k].w * near.w + r[k].x * near.x + r[k].y * near.y + r[k].z * near.z < 0) r[k] = {-r[k].w, -r[k].x, -r[k].y, -r[k].z};
    }
    for (int c = 0; c < 3; ++c) translations[j][c] = between(p[0][c], p[1][c], p[2][c], p[3][c], s);
    const Quat q{between(r[0].w, r[1].w, r[2].w, r[3].w, s), between(r[0].x, r[1].x, r[2].x, r[3].x, s),
                 between(r[0].y, r[1].y, r[2].y, r[3].y, s), between(r[0].z, r[1].z, r[2].z, r[3].z, s)};
    const double size = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    rotations[j] = {q.w / size, q.x / size, q.y / size, q.z / size};
  }
}

/// What the retiming needs to know of each frame.
struct Course {
  double rate = 0;  // frames per second
  std::vector<Vec3> centre;
  std::vector<double> lowest;
  std::vector<Support> support;
};

Course observe(const Mechanism& mechanism, const Motion& motion, double height) {
  Course out;
  out.rate = motion.rate;
  std::vector<std::vector<SupportPoint>> points;
  for (const Link& link : mechanism.links()) points.push_back(support_points(link));
  std::vector<Pose> X(at(mechanism.link_count()));
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(mechanism, {motion.frame(f), at(motion.nq)}, X);
    double low = 1e300;
    for (std::size_t i = 0; i < X.size(); ++i)
      for (const SupportPoint& s : points[i]) low = std::min(low, (X[i] * s.p).z - s.radius);
    out.lowest.push_back(low);
    out.support.push_back(low > gap * height ? Support::flight : Support::ground);
    out.centre.push_back(centre_of_mass(mechanism, X));
  }
  return out;
}

/// Leaves only those flights that do not suit gravity. @return whether there is one
bool find_wrong_flights(Course& course, double height) {
  const int n = static_cast<int>(course.centre.size());
  bool found = false;
  for (int f = 0; f < n; ++f) {
    if (course.support[at(f)] != Support::flight) continue;
    int end = f;
    while (end < n && course.support[at(end)] == Support::flight) ++end;
    const double time = (end - f) / course.rate, half = time / 2;
    const Vec3 &a = course.centre[at(f)], &b = course.centre[at((f + end - 1) / 2)], &c = course.centre[at(end - 1)];
    const double top = *std::max_element(course.lowest.begin() + f, course.lowest.begin() + end);
    Support kind = Support::flight;
    if (time < shortest || time > longest || top < high * height)
      kind = Support::ground;
    else if (std::fabs((a.z - 2 * b.z + c.z) / (half * half) + gravity) < tolerance * gravity ||
             std::hypot(c.x - a.x, c.y - a.y) > time * std::sqrt(froude * gravity * height))
      kind = Support::kept;
    std::fill(course.support.begin() + f, course.support.begin() + end, kind);
    found = found || kind == Support::flight;
    f = end - 1;
  }
  return found;
}

/// The new clock of a motion.
struct Clock {
  std::vector<double> times;        // [frames of the analysis] s
  double slowest = 1, fastest = 1;  // playing speeds
  double duration() const { return times.back(); }
  /// Frame of the analysis, with a fraction, at the time t.
  double frame_at(double t) const {
    const auto after = std::upper_bound(times.begin() + 1, times.end() - 1, t);
    return static_cast<double>(after - times.begin() - 1) + (t - *(after - 1)) / (*after - *(after - 1));
  }
};

Clock make_clock(const std::vector<double>& squared, double rate) {
  Clock out;
  out.times.assign(squared.size(), 0.0);
  for (std::size_t f = 1; f < squared.size(); ++f) {
    const double speed = std::sqrt(squared[f]);
    out.times[f] = out.times[f - 1] + 2 / (rate * (std::sqrt(squared[f - 1]) + speed));
    out.slowest = std::min(out.slowest, speed);
    out.fastest = std::max(out.fastest, speed);
  }
  return out;
}

/// The motion with the new clock, and its course. @param rate frames per second, of `old`
MeasuredMotion play(const MeasuredMotion& measured, const Clock& clock, const Course& old, Course& now) {
  MeasuredMotion out = measured;
  out.rate = measured.rate * std::max(1.0, std::ceil(min_rate / measured.rate - 1e-9));
  out.frames = std::max(2, static_cast<int>(std::lround(clock.duration() * out.rate)) + 1);
  now.rate = out.rate;
  const std::size_t joints = measured.skeleton.joints.size();
  out.translations.resize(at(out.frames) * joints);
  out.rotations.resize(at(out.frames) * joints);
  for (int f = 0; f < out.frames; ++f) {
    const double frame = std::max(0.0, clock.frame_at(clock.duration() * f / (out.frames - 1)));
    const std::size_t k = std::min(static_cast<std::size_t>(frame), old.centre.size() - 2);
    const double s = std::clamp(frame - static_cast<double>(k), 0.0, 1.0);
    sample_at(measured, frame * measured.rate / old.rate, out.translations.data() + at(f) * joints, out.rotations.data() + at(f) * joints);
    now.centre.push_back(old.centre[k] * (1 - s) + old.centre[k + 1] * s);
    now.lowest.push_back(old.lowest[k] * (1 - s) + old.lowest[k + 1] * s);
    now.support.push_back(old.support[s < 0.5 ? k : k + 1]);
  }
  return out;
}

}  // namespace

std::string retime_to_gravity(MeasuredMotion& measured, const Mechanism& mechanism, const Motion& motion, double height) {
  if (motion.frames != measured.frames || motion.frames < 5) return {};
  Course course = observe(mechanism, upsampled(motion, mechanism, fine_rate), height);
  if (!find_wrong_flights(course, height)) return {};
  const std::vector<double> as_given(course.centre.size(), 1.0);
  const double before = impossible_acceleration(course.centre, course.support, as_given, course.rate);
  const std::vector<double> squared = squared_speeds(course.centre, course.support, course.rate);
  if (impossible_acceleration(course.centre, course.support, squared, course.rate) > remaining * before) return {};
  const Clock clock = make_clock(squared, course.rate);
  if (clock.slowest > 0.9 && clock.fastest < 1.1) return {};
  Course now;
  MeasuredMotion out = play(measured, clock, course, now);
  const std::vector<double> played(now.centre.size(), 1.0);
  double raised = 0;
  if (impossible_acceleration(now.centre, now.support, played, now.rate) > exact) {
    const std::vector<double> up = flight_heights(now.centre, now.lowest, now.support, now.rate);
    const std::size_t joints = measured.skeleton.joints.size();
    for (std::size_t f = 0; f < up.size(); ++f) {
      if (std::fabs(up[f]) > std::fabs(raised)) raised = up[f];
      now.centre[f].z += up[f];
      for (std::size_t j = 0; j < joints; ++j)
        if (measured.skeleton.joints[j].parent < 0) out.translations[f * joints + j].z += up[f];
    }
  }
  if (std::fabs(raised) > max_raise * height || impossible_acceleration(now.centre, now.support, played, now.rate) > max_left) return {};
  std::string sentence = measured.name + ": flights did not suit gravity; the motion is played with " + to_fixed(clock.slowest, 2) +
                         " to " + to_fixed(clock.fastest, 2) + " times the speed of the file (" + to_fixed(measured.duration(), 2) +
                         " s became " + to_fixed(clock.duration(), 2) + " s)";
  if (std::fabs(raised) > 0.005)
    sentence += std::string(", and the character is ") + (raised > 0 ? "higher" : "lower") + " by up to " +
                to_fixed(100 * std::fabs(raised), 0) + " cm in the air";
  measured = std::move(out);
  return sentence + ".";
}

}  // namespace ugoki::intake
