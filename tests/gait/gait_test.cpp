// Gaits without measurement: timing, feet, centre of mass, limits, and gaits that are simulated without root assist.

#include "ugoki/gait/gait.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "../control/balance_scene.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/gait/centre.h"
#include "ugoki/gait/pattern.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/samples/samples.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::gait {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

MechanismPtr person() {
  static const MechanismPtr made = samples::make_person(1.75).value();
  return made;
}
MechanismPtr dog() {
  static const MechanismPtr made = samples::make_dog();
  return made;
}

MechanismPtr hexapod() {
  static const MechanismPtr made = [] {
    const std::string file = std::string(UGOKI_SOURCE_DIR) + "/examples/mechanisms/hexapod.json";
    std::ifstream in(file);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    return formats::read_mechanism(text, file).value();
  }();
  return made;
}

GaitOptions stride_of(GaitKind kind, double speed, double turn = 0) {
  GaitOptions o;
  o.stages = {{0, kind, speed, turn}};
  o.one_stride = true;
  return o;
}

std::vector<std::vector<Pose>> poses_of(const Mechanism& m, const Motion& motion) {
  std::vector<std::vector<Pose>> out;
  for (int f = 0; f < motion.frames; ++f) {
    out.emplace_back(at(m.link_count()));
    calc_poses(m, {motion.frame(f), at(motion.nq)}, out.back());
  }
  return out;
}

/// Share of the stride in which the label of a foot is on, and the frame of its touch-down.
std::pair<double, int> timing_of(const ContactTrack& track) {
  const int n = static_cast<int>(track.on.size()) - 1;
  int on = 0, down = -1;
  for (int f = 0; f < n; ++f) {
    on += track.on[at(f)];
    if (track.on[at(f)] && !track.on[at((f + n - 1) % n)]) down = f;
  }
  return {static_cast<double>(on) / n, down};
}

double around(double x) { return x - std::floor(x + 0.5); }

// The bounded solution of c'' = w^2 (c - p) for a centre of pressure that steps from 0 to 1 at t = 0 is exp(w t) / 2 before and
// 1 - exp(-w t) / 2 after the step: its divergent component of motion c + c' / w moves by the closed form xi' = w (xi - p).
TEST(Gait, CentreOfMassFollowsTheClosedForm) {
  constexpr double rate = 480, w = 3.2, height = 0.95;
  std::vector<CentreFrame> frames(4801);
  for (std::size_t i = 0; i < frames.size(); ++i)
    frames[i] = {{i < 2400 ? 0.0 : i == 2400 ? 0.5 : 1.0, 0, 0}, w * w * height, height, {}, 1};
  const std::vector<Vec3> c = solve_centre(frames, rate);
  for (std::size_t i = 1200; i <= 3600; i += 100) {
    const double t = (static_cast<double>(i) - 2400) / rate;
    EXPECT_NEAR(c[i].x, t < 0 ? 0.5 * ugoki::exp(w * t) : 1 - 0.5 * ugoki::exp(-w * t), 1e-4) << t;
  }
}

TEST(Gait, TimingEqualsTheTable) {
  struct Case {
    MechanismPtr m;
    GaitKind kind;
    double speed;
    std::vector<double> phases;  // published offsets, in the order of the legs: left from the back to the front, then right
  };
  const std::vector<Case> cases = {{person(), GaitKind::walk, 1.25, {0, 0.5}},
                                   {dog(), GaitKind::walk, 0.9, {0, 0.25, 0.5, 0.75}},
                                   {dog(), GaitKind::trot, 1.9, {0, 0.5, 0.5, 0}},
                                   {dog(), GaitKind::pace, 1.9, {0, 0, 0.5, 0.5}}};
  for (const Case& c : cases) {
    GaitReport report;
    const Result<Motion> made = make_gait(c.m, stride_of(c.kind, c.speed), &report);
    ASSERT_TRUE(made) << made.error().text();
    const double frame = 1.0 / (made->frames - 1);
    ASSERT_EQ(made->contacts.size(), c.phases.size());
    const int first = timing_of(made->contacts[0]).second;
    for (std::size_t k = 0; k < c.phases.size(); ++k) {
      const auto [duty, down] = timing_of(made->contacts[k]);
      EXPECT_NEAR(duty, report.duty, 1.01 * frame) << name_of(c.kind) << " " << report.legs[k];
      EXPECT_NEAR(around((down - first) * frame - c.phases[k]), 0, 1.01 * frame) << name_of(c.kind) << " " << report.legs[k];
    }
  }
  EXPECT_NEAR(pattern_of(GaitKind::walk, {{0, true}, {0, false}}, 0.92, 1.25, 9.81).duty, 0.618, 0.002);
}

// A stride repeats exactly, and the right side does half a stride later what the left side does.
TEST(Gait, StrideIsPeriodicAndSymmetric) {
  const MechanismPtr m = person();
  const Motion motion = make_gait(m, stride_of(GaitKind::walk, 1.25)).value();
  const std::vector<std::vector<Pose>> X = poses_of(*m, motion);
  const int n = motion.frames - 1;
  const Vec3 way = X.back()[0].p - X.front()[0].p;
  EXPECT_NEAR(way.x, 1.25 * n / motion.rate, 1e-3);
  EXPECT_NEAR(way.y, 0, 1e-4);
  for (std::size_t i = 0; i < X.front().size(); ++i)
    EXPECT_LT(norm(X.back()[i].p - X.front()[i].p - way), 1e-4) << m->link(static_cast<int>(i)).name;
  const int left = m->find_link("LeftFoot"), right = m->find_link("RightFoot");
  ASSERT_EQ(n % 2, 0) << "this test compares frames half a stride apart";
  for (int f = 0; f < n / 2; ++f) {
    const Vec3 a = X[at(f)][at(left)].p - X[at(f)][0].p, b = X[at(f + n / 2)][at(right)].p - X[at(f + n / 2)][0].p;
    EXPECT_LT(norm(a - Vec3{b.x, -b.y, b.z}), 2e-3) << f;
  }
}

// While a foot is flat it does not move; in the rest of its stance its lowest point rolls without slipping.
TEST(Gait, StandingFeetDoNotSlide) {
  for (const auto& [m, kind, speed, turn] :
       {std::tuple{person(), GaitKind::walk, 1.25, 0.0}, {person(), GaitKind::walk, 1.0, 0.785}, {person(), GaitKind::walk, 0.6, 0.0}}) {
    const Motion motion = make_gait(m, stride_of(kind, speed, turn)).value();
    const std::vector<std::vector<Pose>> X = poses_of(*m, motion);
    for (const ContactTrack& track : motion.contacts) {
      const int link = m->find_link(track.link);
      const std::vector<SupportPoint> points = support_points(m->link(link));
      double low = 1e9, worst = 0;
      for (int f = 0; f + 1 < motion.frames; ++f) {
        if (!track.on[at(f)] || !track.on[at(f + 1)]) continue;
        const Pose &a = X[at(f)][at(link)], &b = X[at(f + 1)][at(link)];
        Vec3 lowest;
        double height = 1e9;
        for (const SupportPoint& p : points)
          if (const double z = (a * p.p).z - p.radius; z < height) {
            height = z;
            lowest = p.p + transpose_times(a.R, Vec3{0, 0, -p.radius});
          }
        low = std::min(low, height);
        const Vec3 slide = b * lowest - a * lowest;
        worst = std::max(worst, std::hypot(slide.x, slide.y));
      }
      EXPECT_NEAR(low, 0, 1e-3) << name_of(kind) << " " << track.link;
      EXPECT_LT(worst, 1e-3) << name_of(kind) << " " << track.link;
    }
  }
}

// Paws do not reach every orientation, but the middle of the sole stays at its place until the heel rises.
TEST(Gait, StandingPawsStayAtTheirPlaces) {
  for (const auto& [kind, speed] : {std::pair{GaitKind::walk, 0.9}, {GaitKind::trot, 1.8}}) {
    const MechanismPtr m = dog();
    const Motion motion = make_gait(m, stride_of(kind, speed)).value();
    const std::vector<std::vector<Pose>> X = poses_of(*m, motion);
    for (const ContactTrack& track : motion.contacts) {
      const int link = m->find_link(track.link), n = motion.frames - 1, down = timing_of(track).second;
      const int half = static_cast<int>(0.5 * timing_of(track).first * n);
      if (down < 0 || down + half >= n) continue;  // the stance continues across the seam
      const std::vector<SupportPoint> points = support_points(m->link(link));
      const Pose& first = X[at(down)][at(link)];
      double low = 1e9, count = 0;
      for (const SupportPoint& p : points) low = std::min(low, (first * p.p).z - p.radius);
      Vec3 back{1e9, 0, 0}, front{-1e9, 0, 0};
      for (const SupportPoint& p : points)
        if ((first * p.p).z - p.radius < low + 0.01) {
          if (p.p.x < back.x) back = p.p;
          if (p.p.x > front.x) front = p.p;
          count += 1;
        }
      ASSERT_GT(count, 0);
      const Vec3 middle = (back + front) * 0.5, place = X[at(down + 1)][at(link)] * middle;
      for (int f = down + 1; f < down + half; ++f) {
        const Vec3 moved = X[at(f)][at(link)] * middle - place;
        EXPECT_LT(std::hypot(moved.x, moved.y), 3e-3) << name_of(kind) << " " << track.link << " frame " << f - down;
      }
    }
  }
}

TEST(Gait, JointsKeepTheirLimits) {
  for (const auto& [m, kind, speed] : {std::tuple{person(), GaitKind::walk, 2.0}, {dog(), GaitKind::trot, 2.0}}) {
    const Motion motion = make_gait(m, stride_of(kind, speed)).value();
    EXPECT_TRUE(check_motion(motion, *m).empty());
    for (int f = 0; f < motion.frames; ++f)
      for (const Link& link : m->links()) {
        if (link.joint.type == JointType::floating) continue;
        double x[6];
        joint_displacement(link.joint, motion.frame(f) + link.q_index, x);
        for (int k = 0; k < link.joint.nv(); ++k) {
          EXPECT_GE(x[k], link.joint.dofs[at(k)].lower - 1e-6) << link.name;
          EXPECT_LE(x[k], link.joint.dofs[at(k)].upper + 1e-6) << link.name;
        }
      }
  }
}

// Start, stop and turn: the character begins and ends standing at rest, and the way is the integral of the speed.
TEST(Gait, StartsStopsAndTurns) {
  GaitOptions o;
  o.stages = {{0, GaitKind::walk, 1.2, 0}, {3, GaitKind::walk, 1.2, 0.785}, {5, GaitKind::walk, 0, 0}, {10, GaitKind::walk, 0.8, 0}};
  o.seconds = 16;
  const Motion motion = make_gait(person(), o).value();
  const std::vector<std::vector<Pose>> X = poses_of(*person(), motion);
  for (const int f : {0, motion.frames - 2, static_cast<int>(9.8 * motion.rate)})
    EXPECT_LT(norm(X[at(f + 1)][0].p - X[at(f)][0].p) * motion.rate, 0.06) << f;
  const Mat3 turned = X.back()[0].R * X.front()[0].R.transposed();
  EXPECT_NEAR(ugoki::atan2(turned.yx, turned.xx), 2 * 0.785, 0.06);
}

TEST(Gait, PathIsFollowed) {
  GaitOptions o;
  o.stages = {{0, GaitKind::walk, 1.2, 0}};
  o.path = {{0, 0, 0}, {3, 0, 0}, {5, 2, 0}, {5, 6, 0}};
  o.seconds = 11;
  const Motion motion = make_gait(person(), o).value();
  const std::vector<std::vector<Pose>> X = poses_of(*person(), motion);
  const Vec3 end = X.back()[0].p;
  EXPECT_GT(end.y, 1.5);
  EXPECT_NEAR(end.x, 5, 0.5);
}

// The duration is chosen such that the body stands at the end of the path, also where the path is too short for the speed.
TEST(Gait, FittedGaitEndsAtTheEndOfThePath) {
  for (const MechanismPtr& body : {person(), dog()})
    for (const Vec3 end : {Vec3{1, 0.3, 0}, Vec3{5, 2, 0}}) {
      GaitOptions o;
      o.stages = {{0, GaitKind::walk, 0.9, 0}};
      o.path = {{0, 0, 0}, {0.5 * end.x, 0, 0}, end};
      ASSERT_TRUE(fit_to_path(body, o));
      const Motion motion = make_gait(body, o).value();
      const std::vector<std::vector<Pose>> X = poses_of(*body, motion);
      // the root of the dog is behind its centre of mass
      const Vec3 travelled = X.back()[0].p - X.front()[0].p;
      EXPECT_NEAR(std::hypot(travelled.x, travelled.y), std::hypot(end.x, end.y), 0.12) << end.x << " " << body->name();
      EXPECT_GT(motion.duration(), 1);
    }
  GaitOptions none;
  none.stages = {{0, GaitKind::walk, 0.9, 0}};
  EXPECT_FALSE(fit_to_path(person(), none));
  none.path = {{0, 0, 0}, {3, 0, 0}};
  none.stages[0].speed = 0;
  EXPECT_FALSE(fit_to_path(person(), none));
}

TEST(Gait, CanBeCancelled) {
  GaitOptions o;
  o.stages = {{0, GaitKind::walk, 1, 0}};
  o.seconds = 600;
  int asked = 0;
  o.cancelled = [&] { return ++asked > 10; };
  const Result<Motion> made = make_gait(person(), o);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().problems.front().code, ErrorCode::cancelled);
  EXPECT_LT(asked, 20);
}

// On a slope and on stairs, standing feet are on the ground, and no foot goes through it.
TEST(Gait, FeetAreOnUnevenGround) {
  for (const bool stairs : {false, true}) {
    GaitOptions o;
    o.stages = {{0, GaitKind::walk, 0.9, 0}};
    o.seconds = 8;
    o.ground = [stairs](double x, double) { return stairs ? (x > 1 ? 0.1 * (std::floor((x - 1) / 0.3) + 1) : 0.0) : 0.176 * x; };
    GaitReport report;
    const Motion motion = make_gait(person(), o, &report).value();
    const std::vector<std::vector<Pose>> X = poses_of(*person(), motion);
    EXPECT_GT(X.back()[0].p.z, X.front()[0].p.z + 0.4);
    for (const std::vector<FootStance>& leg : report.stances)
      for (const FootStance& s : leg) EXPECT_NEAR(s.place.z, o.ground(s.place.x, s.place.y), 1e-9);
    EXPECT_LT(report.max_miss, 0.03);
  }
}

TEST(Gait, ErrorsNameTheRemedy) {
  GaitOptions o;
  o.stages = {{0, GaitKind::gallop, 2, 0}};
  const Result<Motion> made = make_gait(person(), o);
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().text().find("Use walk"), std::string::npos);
  EXPECT_FALSE(make_gait(samples::make_ball(), {}));
  o.stages = {{0, GaitKind::walk, 100, 0}};
  EXPECT_FALSE(make_gait(person(), o));
  o.stages = {{0, GaitKind::walk, 1, 0}};
  o.phases = {0, 0.5, 0.7};
  EXPECT_FALSE(make_gait(person(), o));
}

/// Simulates a gait of 8 s, with start and stop, without root assist. Returns the rms error of the joints, degrees.
/// @param min_way share of the way of the motion that the character has to cover
double tracking_error(const MechanismPtr& m, GaitOptions o, double min_way) {
  o.seconds = 8;
  const Motion motion = make_gait(m, o).value();
  control::Simulation s(m, std::make_shared<const control::Looped>(m, motion, motion.duration()));
  std::vector<Pose> X(at(m->link_count()));
  calc_poses(*m, s.state.q, X);
  const double height = centre_of_mass(*m, X).z, start = s.state.q[0];
  double sum = 0, count = 0;
  while (s.memory.time < motion.duration() - 0.01) {
    s.step();
    sum += s.tracking_error() * s.tracking_error();
    count += 1;
    if (std::fabs(s.below()) < 0.2 * height) continue;
    ADD_FAILURE() << m->name() << " fell at " << s.memory.time << " s";
    break;
  }
  const double* end = motion.frame(motion.frames - 1);
  const double way = std::hypot(end[0] - motion.frame(0)[0], end[1]);
  EXPECT_NEAR(std::hypot(s.state.q[0] - start, s.state.q[1]), way, (1 - min_way) * way);
  return std::sqrt(sum / count);
}

TEST(Gait, TooShortMotionsAreNoted) {
  GaitOptions o;
  o.stages = {{0, GaitKind::walk, 1, 0}};
  for (const double seconds : {4.0, 8.0}) {
    o.seconds = seconds;
    GaitReport report;
    ASSERT_TRUE(make_gait(person(), o, &report));
    const bool noted = std::ranges::any_of(report.notes, [](const std::string& note) { return note.contains("too short"); });
    EXPECT_EQ(noted, seconds < 5);
  }
}

// Without root assist: a person who starts, walks, turns and stops does not fall.
TEST(Gait, SurvivesWithoutAssist) {
  GaitOptions o;
  o.stages = {{0, GaitKind::walk, 1.25, 0}, {3, GaitKind::walk, 1.25, 0.785}};
  EXPECT_LT(tracking_error(person(), o, 0.9), 1.5);
}

// Soles that stand bear load from heel to toe. With pressure at the toes only, each step is braked, and a slow walk nearly stands still.
TEST(Gait, SlowWalksKeepTheirSpeed) {
  GaitOptions o;
  o.stages = {{0, GaitKind::walk, 0.75, 0}};
  o.seconds = 12;
  const Motion motion = make_gait(person(), o).value();
  const double way = motion.frame(motion.frames - 1)[0] - motion.frame(0)[0];
  control::Simulation s(person(), std::make_shared<const control::Looped>(person(), motion, motion.duration()));
  const double start = s.state.q[0];
  while (s.memory.time < motion.duration() - 0.01) s.step();
  EXPECT_NEAR(s.state.q[0] - start, way, 0.05 * way);
}

// The legs of the machine have three joints: the place of a foot determines the orientation of its shank.
TEST(Gait, SixLegsSurviveWithoutAssist) {
  const MechanismPtr machine = hexapod();
  for (const GaitKind kind : {GaitKind::walk, GaitKind::trot}) {
    GaitOptions o;
    o.stages = {{0, kind, usual_speed(machine, kind).value(), 0}};
    EXPECT_LT(tracking_error(machine, o, 0.97), 1.5) << name_of(kind);
  }
}

// While two or three feet stand, the next one has not landed yet, and its place is not known.
TEST(Gait, DogWalkSurvivesWithoutAssist) {
  GaitOptions o;
  o.stages = {{0, GaitKind::walk, 0.9, 0}};
  EXPECT_LT(tracking_error(dog(), o, 0.9), 4.5);
}

TEST(Gait, DogTrotSurvivesWithoutAssist) {
  GaitOptions o;
  o.stages = {{0, GaitKind::trot, 1.8, 0}};
  EXPECT_LT(tracking_error(dog(), o, 0.95), 3);
}

// A person starts walking, runs with flights, and stops.
TEST(Gait, RunSurvivesWithoutAssist) {
  GaitOptions o;
  o.stages = {{0, GaitKind::run, 3, 0}};
  EXPECT_LT(tracking_error(person(), o, 0.8), 6);
}

// A dog starts with a trot and canters. While it accelerates, its trunk keeps its mean pitch.
TEST(Gait, DogCanterSurvivesWithoutAssist) {
  GaitOptions o;
  o.stages = {{0, GaitKind::canter, 2.4, 0}};
  EXPECT_LT(tracking_error(dog(), o, 0.85), 5);
}

TEST(Gait, DogGallopSurvivesWithoutAssist) {
  GaitOptions o;
  o.stages = {{0, GaitKind::gallop, 3.5, 0}};
  EXPECT_LT(tracking_error(dog(), o, 0.8), 7);
}

// Inverse kinematics of a leg that is nearly stretched out jumped from frame to frame.
TEST(Gait, LegsOfAWalkingDogDoNotJump) {
  const Motion motion = make_gait(dog(), stride_of(GaitKind::walk, 0.9)).value();
  std::vector<double> before(at(dog()->nv())), after(before.size());
  const auto frame = [&](int f) { return std::span(motion.frame(f), at(motion.nq)); };
  double jump = 0;
  for (int f = 1; f + 1 < motion.frames; ++f) {
    difference(*dog(), frame(f - 1), frame(f), before);
    difference(*dog(), frame(f), frame(f + 1), after);
    for (std::size_t i = 6; i < before.size(); ++i) jump = std::max(jump, std::fabs(after[i] - before[i]));
  }
  EXPECT_LT(jump, 0.2);  // rad: second difference of a joint
}

// A walk of four legs has always one foot in the air if each foot stands for 75 % of its stride, and could never stop.
TEST(Gait, MotionsBeginAndEndStanding) {
  const auto check = [](const MechanismPtr& m, GaitKind kind, double speed) {
    GaitOptions o;
    o.stages = {{0, kind, speed, 0}};
    o.seconds = 14;
    const Motion motion = make_gait(m, o).value();
    const int still = static_cast<int>(0.1 * motion.rate);
    for (const ContactTrack& track : motion.contacts)
      for (int f = 0; f < still; ++f) {
        EXPECT_TRUE(track.on[at(f)]) << name_of(kind) << " at the start";
        EXPECT_TRUE(track.on[at(motion.frames - 1 - f)]) << name_of(kind) << " at the end";
      }
  };
  for (const double speed : {0.4, 0.7, 1.0}) check(dog(), GaitKind::walk, speed);
  for (const GaitKind kind : {GaitKind::trot, GaitKind::pace, GaitKind::canter, GaitKind::gallop})
    check(dog(), kind, usual_speed(dog(), kind).value());
  for (const GaitKind kind : {GaitKind::walk, GaitKind::run}) check(person(), kind, usual_speed(person(), kind).value());
  for (const GaitKind kind : {GaitKind::walk, GaitKind::trot}) check(hexapod(), kind, usual_speed(hexapod(), kind).value());
}

// Balance control takes the stances of a computed gait as they are, and does not detect them again.
TEST(Gait, StancesReachTheController) {
  for (const MechanismPtr& m : {person(), dog(), hexapod()}) {
    const GaitKind kind = m == person() ? GaitKind::walk : GaitKind::trot;
    GaitOptions o;
    o.stages = {{0, kind, usual_speed(m, kind).value(), 0}};
    GaitReport report;
    const Motion motion = make_gait(m, o, &report).value();
    const control::Looped reference(m, motion, motion.duration());
    const std::vector<control::Foot> feet = control::feet_of(*m);
    const control::FootSchedule schedule(*m, feet, reference, 0);
    ASSERT_EQ(feet.size(), report.legs.size());
    for (std::size_t k = 0; k < feet.size(); ++k) {
      const auto leg = at(static_cast<int>(std::ranges::find(report.legs, m->link(feet[k].link).name) - report.legs.begin()));
      ASSERT_LT(leg, report.legs.size());
      const std::span<const control::Stance> found = schedule.stances(k);
      ASSERT_EQ(found.size(), report.stances[leg].size()) << m->name();
      for (std::size_t i = 1; i + 1 < found.size(); ++i) {
        EXPECT_NEAR(found[i].begin, report.stances[leg][i].begin, 1.01 / motion.rate);
        EXPECT_NEAR(found[i].end, report.stances[leg][i].end, 1.01 / motion.rate);
      }
    }
  }
}

// The machine's weight stays below its body although it stands on tripods, so it does not sway from one to the next.
TEST(Gait, SixLegsDoNotSway) {
  const MechanismPtr m = hexapod();
  const Motion motion = make_gait(m, stride_of(GaitKind::trot, 0.7)).value();
  double lowest = 1e9, highest = -1e9, left = -1e9, right = 1e9;
  for (const std::vector<Pose>& X : poses_of(*m, motion)) {
    const Vec3 c = centre_of_mass(*m, X);
    left = std::max(left, c.y), right = std::min(right, c.y);
    highest = std::max(highest, c.z), lowest = std::min(lowest, c.z);
  }
  EXPECT_LT(left - right, 5e-3);
  EXPECT_LT(highest - lowest, 2e-3);
}

}  // namespace
}  // namespace ugoki::gait
