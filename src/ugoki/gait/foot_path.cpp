#include "ugoki/gait/foot_path.h"

#include <algorithm>
#include <cmath>

#include "ugoki/spatial/elementary.h"

namespace ugoki::gait {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }
constexpr double degree = pi / 180;
constexpr double flat_from = 0.13, flat_to = 0.49;  // shares of the stance: the foot becomes flat, the heel rises (Perry 1992)
constexpr double toe_bend = 1.0;                    // pitch of the toes relative to that of the foot: they stay flat on the ground

/// Value, and first and second derivative.
struct Jet {
  double x = 0, v = 0, a = 0;
};

/// Quintic polynomial from `from` at s = 0 to `to` at s = 1.
double quintic(const Jet& from, const Jet& to, double s) {
  const double dx = to.x - from.x - from.v - 0.5 * from.a, dv = to.v - from.v - from.a, da = to.a - from.a;
  const double c3 = 10 * dx - 4 * dv + 0.5 * da, c4 = -15 * dx + 7 * dv - da, c5 = 6 * dx - 3 * dv + 0.5 * da;
  return from.x + s * (from.v + s * (0.5 * from.a + s * (c3 + s * (c4 + s * c5))));
}

/// 1 at s = 0.5; 0 with zero first and second derivatives at s = 0 and s = 1.
double bump(double s) {
  s = std::clamp(s, 0.0, 1.0);
  const double p = s * (1 - s);
  return 64 * p * p * p;
}

/// How far the foot pitches in this gait.
struct Roll {
  double strike = 0, lift = 0;   ///< rad: pitch at touch-down (negative: toes up) and at lift-off
  double passing = 0, rate = 0;  ///< rad, rad per swing: pitch in mid-swing
  double level = 0.5;            ///< share of the swing with the pitch `passing`
  double flat_from = 0.1, flat_to = 0.5;
};

Roll roll_of(const Walker& w, const GaitOptions& o, const CourseFrame& b) {
  const double V = std::fabs(b.speed) / std::sqrt(o.gravity * w.hip_height);
  const double size = b.moving * o.style.foot_roll;
  Roll r;
  if (w.biped) {
    const double walk = std::min(1.12, pow(std::max(V, 1e-3) / 0.42, 0.6)) * size, run = b.run;
    // Backwards, and in steps on the spot, the foot lands flat.
    const double ahead = b.speed > 0 ? 1 : 0.3;
    r.strike = ahead * degree * ((1 - run) * -21 * walk + run * -1 * size);
    r.lift = ahead * degree * ((1 - run) * 55 * walk + run * 52 * size);
    r.passing = degree * ((1 - run) * 7 * walk + run * 38 * size);
    r.rate = degree * ((1 - run) * -95 * walk + run * -110 * size);
    r.level = 0.55;
    r.flat_from = flat_from + run * 0.02;
    r.flat_to = flat_to - run * 0.2;  // the ankle would reach its limit in the middle of the stance
  } else {
    r.lift = 32 * degree * size * std::min(1.0, V / 0.5);
    r.passing = 45 * degree * size * std::min(1.0, V / 0.5);
    r.level = 0.45;
    r.flat_from = 0;
    r.flat_to = 0.65;
  }
  return r;
}

double stance_pitch(const Roll& r, double s) {
  if (s < r.flat_from) return r.strike * (1 - smooth_step(s / r.flat_from));
  if (s < r.flat_to) return 0;
  const double u = (s - r.flat_to) / (1 - r.flat_to);
  return r.lift * u * u * u * (1.6 - 0.6 * u);
}

Mat3 about_y(double a) { return rotation_about({0, 1, 0}, a); }

/// Axes of the ground at a stance: x along the foot, z normal to the ground.
Mat3 ground_axes(const Stance& s) { return to_matrix(rotation_between({0, 0, 1}, s.normal)) * rotation_about({0, 0, 1}, s.heading); }

/// Pose of a standing foot with the pitch `a`: it rolls over its heel or its toes without slipping.
Pose standing_foot(const WalkerLeg& leg, const Stance& s, double a) {
  const Mat3 G = ground_axes(s), flat = G * leg.R_HF;
  const Vec3 origin = s.place - flat * leg.sole;
  if (leg.point_foot) return {flat, origin};
  const bool forward = a > 0;
  const Vec3 pivot = forward ? leg.toe : leg.heel;
  const double radius = forward ? leg.toe_radius : leg.heel_radius;
  const Vec3 centre = origin + flat * pivot + G * Vec3{radius * a, 0, 0};
  const Mat3 R = G * about_y(a) * leg.R_HF;
  return {R, centre - R * pivot};
}

/// m: height of the swing foot above the line between its places.
double swing_height(const Walker& w, const GaitOptions& o, const CourseFrame& b) {
  const double l = w.hip_height, V = std::fabs(b.speed) / std::sqrt(o.gravity * l);
  double height;
  if (o.step_height > 0)
    height = o.step_height;
  else if (w.biped)
    height = l * ((1 - b.run) * (0.05 + 0.05 * std::min(1.0, V / 0.42)) + b.run * (0.18 + 0.06 * V));
  else if (w.legs.size() == 4)
    height = l * (0.11 + 0.06 * std::min(1.0, V / 1.0) + 0.06 * b.spring);
  else
    height = 0.16 * l;
  return height * o.style.lift;
}

}  // namespace

FootPose foot_pose(const Walker& w, const GaitOptions& o, const Course& course, std::size_t k, int frame) {
  const WalkerLeg& leg = w.legs[k];
  const LegFrame& now = course.legs[k][at(frame)];
  const CourseFrame& body = course.body[at(frame)];
  const Roll roll = roll_of(w, o, body);
  const Stance& from = course.stances[k][at(now.stance)];
  FootPose out;
  if (now.stands) {
    const double a = stance_pitch(roll, now.share);
    out.X_WF = standing_foot(leg, from, a);
    out.pivot = a > 0 ? leg.toe : a < 0 ? leg.heel : leg.sole;
    out.toes = -toe_bend * std::max(0.0, a);
    if (roll.strike < 0 && now.share < roll.flat_from)
      out.toes += -8 * degree * body.moving * (1 - smooth_step(now.share / roll.flat_from));
    const Mat3 G = ground_axes(from);
    const double heel = transpose_times(leg.R_HF.transposed(), leg.heel - leg.sole).x,
                 toe = transpose_times(leg.R_HF.transposed(), leg.toe - leg.sole).x;
    double x = 0;
    if (!leg.point_foot && w.biped) {
      // The pressure moves from the heel to the toes; while the body stands it is in the middle.
      const double u = smooth_step((now.share - 0.5 * roll.flat_from) / (0.52 - 0.5 * roll.flat_from));
      const double walk = 0.85 * heel + (0.92 * toe - 0.85 * heel) * u;
      const double run = 0.9 * heel + (0.8 * toe - 0.9 * heel) * smooth_step(now.share / 0.7);
      x = body.moving * ((1 - body.run) * walk + body.run * run);
    }
    out.pressure = from.place + G * Vec3{x, 0, 0};
    return out;
  }
  const int count = static_cast<int>(course.stances[k].size());
  const Stance& to = course.stances[k][at(std::min(now.stance + 1, count - 1))];
  const double s = now.share, span = (1 - now.duty) / now.duty;  // stances in a swing
  // Derivatives at lift-off, per swing
  const double h = 1e-3;
  const double end = stance_pitch(roll, 1 - 1e-9), before = stance_pitch(roll, 1 - h), before2 = stance_pitch(roll, 1 - 2 * h);
  const double pitch_rate = (3 * end - 4 * before + before2) / (2 * h) * span;
  const Pose lift = standing_foot(leg, from, end), earlier = standing_foot(leg, from, before),
             land = standing_foot(leg, to, stance_pitch(roll, 0));
  const Vec3 rate = (lift.p - earlier.p) * (span / h);
  double pitch;
  if (s < roll.level)
    pitch = quintic({end, pitch_rate * roll.level, 0}, {roll.passing, roll.rate * roll.level, 0}, s / roll.level);
  else
    pitch = quintic({roll.passing, roll.rate * (1 - roll.level), 0}, {roll.strike, 0, 0}, (s - roll.level) / (1 - roll.level));
  // Orientation of the ground, from one place to the next
  double turn = to.heading - from.heading;
  Stance between = from;
  between.heading += turn * smooth_step(s);
  between.normal = normalized(from.normal + (to.normal - from.normal) * smooth_step(s));
  out.X_WF.R = ground_axes(between) * about_y(leg.point_foot ? 0 : pitch) * leg.R_HF;
  // At touch-down the foot still moves ahead while it brakes, so that it does not wait at its place with a stretched leg.
  const SinCos ahead = sin_cos(to.heading);
  // Four legs accelerate their feet at once (cubic instead of quintic polynomial). The foot is then ahead of and behind its places by half
  // as much, relative to the body, and the legs stay within the limits of their joints.
  const double jump = w.legs.size() == 4 ? 6 * body.moving : 0;
  const double landing = w.biped ? 0.92 * (1 - 0.4 * body.run) * body.moving * std::max(0.0, body.speed) : 0, brake = -22 * landing;
  for (int i = 0; i < 3; ++i) {
    const double along = i == 0 ? ahead.cos : i == 1 ? ahead.sin : 0;
    const double a = i < 2 ? jump * (land.p[i] - lift.p[i]) : 0;
    out.X_WF.p[i] =
        quintic({lift.p[i], rate[i], a}, {land.p[i], along * landing * now.length, along * brake * now.length * now.length - a}, s);
  }
  // A walking foot is near the ground in the last part of its swing; a running foot is not, because it would touch too early.
  const double late = w.biped ? 1 - body.run : 0;
  double raise = swing_height(w, o, body) * (0.25 + 0.75 * body.moving) * bump(s * (late * (2 - s) + (1 - late) * (1.3 - 0.3 * s)));
  if (o.ground) {  // obstacles between both places
    double over = 0;
    for (int i = 1; i < 12; ++i) {
      const double u = i / 12.0;
      const Vec3 p = from.place + (to.place - from.place) * u;
      over = std::max(over, (ground_at(o, p.x, p.y) - p.z) / std::max(0.3, bump(u)));
    }
    raise += over * bump(s);
  }
  out.X_WF.p.z += raise;
  const double relax = smooth_step((s - 0.12) / 0.5), ready = smooth_step((s - 0.5) / 0.5);
  out.toes = -toe_bend * std::max(0.0, end) * (1 - relax) - (roll.strike < 0 ? 8 * degree * body.moving * ready : 0);
  out.pressure = out.X_WF.p;
  return out;
}

}  // namespace ugoki::gait
