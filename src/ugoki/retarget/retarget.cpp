#include "ugoki/retarget/retarget.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion_edit/rounds.h"
#include "ugoki/retarget/feet_plan.h"
#include "ugoki/retarget/findings.h"
#include "ugoki/retarget/holds.h"

namespace ugoki::retarget {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }
constexpr double near_enough = 1e-5;  // fraction of the leg's length: at a smaller distance a standing foot has reached its goal
constexpr double slip_weight =
    20;  // roll() minimises goal distance + slip_weight * sliding; sliding accumulates over a stance, a height error does not
constexpr int max_roll_iterations = 100;  // maximum number of iterations of roll(); usually 2 or 3 suffice
constexpr double fade_time = 0.06;        // s, time constant with which a swinging foot returns to its planned path
constexpr double shift_time = 0.1;        // s, time before and after a frame with an unreachable foot in which the root is displaced

/// One retargeting run; run() performs the steps in order.
class Retargeting {
 public:
  Retargeting(const Rig& source, const Rig& target, const Motion& motion, const RetargetOptions& options)
      : s_(source), t_(target), m_(*target.mechanism), in_(motion), o_(options), driver_(source, target, options.mapping) {
    if (o_.path_scale > 0) driver_.set_path_scale(o_.path_scale);
    out_.motion.name = motion.name;
    out_.motion.source = motion.source;
    out_.motion.mechanism = m_.name();
    out_.motion.rate = motion.rate;
    out_.motion.frames = motion.frames;
    out_.motion.nq = m_.nq();
    out_.motion.cyclic = motion.cyclic;
    out_.motion.q.resize(at(motion.frames) * at(m_.nq()));
    X_.resize(at(m_.link_count()));
    q_.resize(at(m_.nq()));
  }

  [[nodiscard]] const std::vector<Miss>& hand_misses() const { return hand_misses_; }

  Retargeted run() {
    double ground = 0;
    bears_ = source_contacts(s_, in_, ground);
    driver_.set_ground(ground);
    driver_.set_crouch(usual_crouch(ground));
    copy_postures();
    make_paths();
    solve_all();
    follow_real_soles();
    if (cancelled()) return std::move(out_);
    hold();
    label();
    complete_report(t_, driver_, o_, out_);
    for (FootPlan& plan : feet_) add_foot_facts(plan);
    out_.report.scale = driver_.scale();
    out_.report.mapping = driver_.describe_mapping();
    out_.report.notes.insert(out_.report.notes.end(), t_.notes.begin(), t_.notes.end());
    return std::move(out_);
  }

 private:
  [[nodiscard]] bool cancelled() const { return o_.cancelled && o_.cancelled(); }
  [[nodiscard]] double* frame(int f) { return out_.motion.frame(f); }
  [[nodiscard]] const double* posture(int f) const { return postures_.data() + at(f) * at(m_.nq()); }

  /// Usual height [m] of the source's hips below their height on straight legs (75th percentile of the hips' height), at most 0.1 of the
  /// hip height. 0 unless the source is a biped and the target has four legs.
  [[nodiscard]] double usual_crouch(double ground) const {
    if (s_.anatomy.four_legs == t_.anatomy.four_legs || s_.anatomy.four_legs) return 0;
    std::vector<double> heights;
    std::vector<Pose> X(at(s_.mechanism->link_count()));
    for (int f = 0; f < in_.frames; f += std::max(1, in_.frames / 200)) {
      calc_poses(*s_.mechanism, std::span<const double>(in_.frame(f), at(in_.nq)), X);
      heights.push_back(0.5 * (X[at(s_.limbs[0].root)].p.z + X[at(s_.limbs[1].root)].p.z) - ground);
    }
    std::sort(heights.begin(), heights.end());
    return std::clamp(s_.hip_height - heights[heights.size() * 3 / 4], 0.0, 0.1 * s_.hip_height);
  }

  /// Maps the joints of every frame and records the uncorrected paths of the feet.
  void copy_postures() {
    for (int k = 0; k < limb_count; ++k)
      if (driver_.limb(k).ground && driver_.limb(k).source >= 0) {
        FootPlan& plan = feet_.emplace_back();
        plan.limb = k;
        plan.from_hip.resize(at(in_.frames));
        plan.turn.resize(at(in_.frames));
        plan.raw.X_WF.resize(at(in_.frames));
        plan.raw.points.reserve(at(in_.frames) * t_.limbs[at(k)].sole.points.size());
        plan.miss.assign(at(in_.frames), 0.0);
      }
    std::vector<Pose> X_S(at(s_.mechanism->link_count()));
    q_ = t_.q_stand;
    for (int f = 0; f < in_.frames; ++f) {
      const std::span<const double> q_S(in_.frame(f), at(in_.nq));
      calc_poses(*s_.mechanism, q_S, X_S);
      if (f == 0)  // the first frame has no previous solution: iterate until convergence
        for (int i = 0; i < 5; ++i) driver_.pose(q_S, X_S, q_, X_);
      driver_.pose(q_S, X_S, q_, X_);
      std::copy(q_.begin(), q_.end(), frame(f));
      hips_.push_back((X_S[at(s_.limbs[0].root)].p + X_S[at(s_.limbs[1].root)].p) * 0.5);
      for (int hand = 0; hand < 2; ++hand)
        if (has_hand(hand)) hands_[at(hand)].push_back(X_S[at(s_.limbs[at(2 + hand)].end)].p);
      for (FootPlan& plan : feet_) {
        const LimbRig& limb = t_.limbs[at(plan.limb)];
        plan.from_hip[at(f)] = driver_.end_position(plan.limb, X_S);
        plan.turn[at(f)] = limb.point_foot ? Mat3::identity() : driver_.end_orientation(plan.limb, X_S);
        plan.raw.X_WF[at(f)].p = X_[at(limb.root)].p;
        const Pose& X_end = X_[at(limb.end)];
        for (const LinkPoint& p : limb.sole.points)
          plan.raw.points.push_back(
              limb.point_foot ? p.location
                              : SupportPoint{transpose_times(X_end.R, X_[at(p.link)] * p.location.p - X_end.p), p.location.radius});
      }
    }
    postures_ = out_.motion.q;
  }

  /// Builds the feet's paths and contacts.
  void make_paths() {
    for (FootPlan& plan : feet_) {
      const LimbDrive& drive = driver_.limb(plan.limb);
      std::vector<std::uint8_t> on = bears_[at(drive.source)];
      if (on.empty()) on.assign(at(in_.frames), 0);
      if (plan.limb >= 2 && drive.source < 2) {
        const double part = o_.gait_phase - 0.5;
        delay(plan, on, static_cast<int>(std::lround(part * stride_of(on))));
      }
      plan.raw.bears = std::move(on);
      if (drive.flat && !t_.limbs[at(plan.limb)].point_foot) flatten(plan, t_.F[at(t_.limbs[at(plan.limb)].end)], in_.rate);
      for (int f = 0; f < in_.frames; ++f) {
        Pose& X = plan.raw.X_WF[at(f)];
        X.p += plan.from_hip[at(f)];
        X.R = plan.turn[at(f)];
      }
      if (drive.mode == LimbMode::placed) step_where_dragged(plan, in_.rate, t_.limbs[at(plan.limb)].length);
    }
    pin();
  }

  /// Fixes the stances of all feet to the ground.
  void pin() {
    std::vector<motion_edit::FootPath> paths;
    for (const FootPlan& plan : feet_) paths.push_back(plan.raw);
    if (o_.keep_contacts) motion_edit::pin_stances(paths, in_.rate, 0, t_.leg_length, {});
    for (std::size_t k = 0; k < feet_.size(); ++k) feet_[k].path = std::move(paths[k]);
  }

  /// Solves the legs of one frame with the root displaced by `shift` [m]. @return largest distance [m] of a standing foot from its goal
  double solve_frame(int f, const Vec3& shift) {
    std::copy_n(posture(f), m_.nq(), frame(f));
    calc_poses(m_, std::span<const double>(frame(f), at(m_.nq())), X_);
    double worst = 0;
    for (FootPlan& plan : feet_) {
      if (!o_.keep_contacts && driver_.limb(plan.limb).mode == LimbMode::copied) continue;
      const LimbRig& limb = t_.limbs[at(plan.limb)];
      Pose goal = plan.path.X_WF[at(f)];
      goal.p = goal.p - shift - goal.R * limb.end_point;
      plan.miss[at(f)] = driver_.reach(plan.limb, goal, frame(f), X_);
      if (plan.path.bears[at(f)]) worst = std::max(worst, plan.miss[at(f)]);
    }
    return worst;
  }

  void shift_root(int f, const Vec3& shift) {
    if (m_.link(0).joint.type != JointType::floating) return;
    const Vec3 own = transpose_times(m_.link(0).joint.X_PJ.R, shift);
    for (int k = 0; k < 3; ++k) frame(f)[k] += own[k];
  }

  /// Returns a displacement [m] of the root with which all standing feet reach their goals: Newton's method on the errors that remain after
  /// inverse kinematics of the limbs.
  Vec3 find_shift(int f, Vec3 shift) {
    const double enough = near_enough * t_.leg_length, longest = 0.15 * t_.leg_length;
    Vec3 best = shift;
    double minimum = 1e300;
    for (int i = 0; i < 12; ++i) {
      const double worst = solve_frame(f, shift);
      if (worst < minimum) {
        minimum = worst;
        best = shift;
      }
      if (worst < enough) break;
      Vec3 wish, pull;
      std::vector<Vec3>& missing = missing_;
      missing.clear();
      for (const FootPlan& plan : feet_) {
        const LimbRig& limb = t_.limbs[at(plan.limb)];
        missing.push_back(plan.path.bears[at(f)] ? plan.path.X_WF[at(f)].p - shift - X_[at(limb.end)] * limb.end_point : Vec3{});
        wish += missing.back();
      }
      Mat3 A = Mat3::diagonal(1e-4, 1e-4, 1e-4);
      for (std::size_t k = 0; k < feet_.size(); ++k) {
        if (!feet_[k].path.bears[at(f)]) continue;
        // A foot that has reached its goal resists a motion of the root opposite to `wish`.
        const bool there = norm(missing[k]) < enough;
        const Mat3 P = driver_.resistance(feet_[k].limb, there ? -wish : missing[k], frame(f), X_);
        A += P * P;
        pull += P * (P * missing[k]);
      }
      const Vec3 step = inverse(A) * pull;
      shift += step * std::min(1.0, longest / std::max(norm(step), 1e-12));
    }
    return best;
  }

  /// Smooth envelope of the displacements d [frames]: sum of minimum and maximum within shift_time of each frame, then a Hann average over
  /// the same time.
  [[nodiscard]] std::vector<Vec3> envelope(const std::vector<Vec3>& d) const {
    const int n = static_cast<int>(d.size()), w = std::max(1, static_cast<int>(shift_time * in_.rate + 0.5));
    std::vector<Vec3> wide(d.size()), out(d.size());
    std::vector<double> hann;
    double sum = 0;
    for (int i = -w; i <= w; ++i) {
      hann.push_back(0.5 + 0.5 * cos(pi * i / (w + 1)));
      sum += hann.back();
    }
    int quiet = w + 1;  // frames since the last nonzero displacement
    for (int f = 0; f < n + w; ++f) {
      quiet = f < n && d[at(f)] != Vec3{} ? 0 : quiet + 1;
      const int g = f - w;
      if (g < 0 || quiet > 2 * w) continue;
      for (int k = 0; k < 3; ++k) {
        double low = 0, high = 0;
        for (int i = std::max(0, g - w); i <= std::min(n - 1, g + w); ++i) {
          low = std::min(low, d[at(i)][k]);
          high = std::max(high, d[at(i)][k]);
        }
        wide[at(g)][k] = low + high;
      }
    }
    for (int f = 0; f < n; ++f)
      for (int i = -w; i <= w; ++i) out[at(f)] += wide[at(std::clamp(f + i, 0, n - 1))] * (hann[at(i + w)] / sum);
    return out;
  }

  /// Horizontal displacements [m] of the root. They bring the centre of mass to a distance of at most 0.06 of the leg's length from the
  /// line segment between the standing feet.
  [[nodiscard]] std::vector<Vec3> shift_for_balance() {
    const double tolerance = 0.06 * t_.leg_length;
    std::vector<Vec3> need(at(in_.frames));
    for (int f = 0; f < in_.frames && !cancelled(); ++f) {
      solve_frame(f, {});
      calc_poses(m_, std::span<const double>(frame(f), at(m_.nq())), X_);
      std::vector<Vec3> feet;
      for (const FootPlan& plan : feet_)
        if (plan.path.bears[at(f)]) feet.push_back(plan.path.X_WF[at(f)].p);
      if (feet.empty()) continue;
      Vec3 com = centre_of_mass(m_, X_), nearest;
      double minimum = 1e300;
      for (const Vec3& a : feet)
        for (const Vec3& b : feet) {
          const Vec3 ab{b.x - a.x, b.y - a.y, 0}, ac{com.x - a.x, com.y - a.y, 0};
          const double s = dot(ab, ab) > 0 ? std::clamp(dot(ab, ac) / dot(ab, ab), 0.0, 1.0) : 0;
          if (const Vec3 d = ab * s - ac; norm(d) < minimum) {
            minimum = norm(d);
            nearest = d;
          }
        }
      if (minimum > tolerance) need[at(f)] = nearest * (1 - tolerance / minimum);
    }
    return envelope(need);
  }

  /// Solves all frames. If feet cannot reach their goals, displaces the root smoothly and solves again, up to three times.
  void solve_all() {
    std::vector<Vec3> shift(at(in_.frames)), extra(at(in_.frames));
    const bool movable = m_.link(0).joint.type == JointType::floating && o_.keep_contacts;
    const double enough = near_enough * t_.leg_length;
    if (o_.balance && movable) shift = shift_for_balance();
    for (int round = 0;; ++round) {
      bool any = false;
      const bool last = round == 3;
      for (int f = 0; f < in_.frames && !cancelled(); ++f) {
        extra[at(f)] = {};
        if (round > 0 && !dirty_[at(f)]) continue;
        if (solve_frame(f, shift[at(f)]) > enough && movable) {
          const Vec3 found = find_shift(f, shift[at(f)]);
          extra[at(f)] = found - shift[at(f)];
          any = any || extra[at(f)] != Vec3{};
          if (last) shift[at(f)] = found;
          (void)solve_frame(f, shift[at(f)]);
        }
        shift_root(f, shift[at(f)]);
      }
      if (!any || last) break;
      const std::vector<Vec3> smooth = envelope(extra);
      dirty_.assign(at(in_.frames), 0);
      for (int f = 0; f < in_.frames; ++f) {
        if (smooth[at(f)] == Vec3{}) continue;
        shift[at(f)] += smooth[at(f)];
        dirty_[at(f)] = 1;
      }
    }
    out_.report.max_shift = 0;
    for (int f = 0; f < in_.frames; ++f)
      if (norm(shift[at(f)]) > out_.report.max_shift) {
        out_.report.max_shift = norm(shift[at(f)]);
        out_.report.shift_frame = f;
      }
  }

  /// Soles whose orientation could not be reached (limits, missing DOFs) are planned again with the orientation that was reached. roll()
  /// removes the remaining differences frame by frame.
  void follow_real_soles() {
    if (!o_.keep_contacts) return;
    double worst = 0;
    std::vector<std::vector<Pose>> real(feet_.size(), std::vector<Pose>(at(in_.frames)));
    for (int f = 0; f < in_.frames; ++f) {
      calc_poses(m_, std::span<const double>(frame(f), at(m_.nq())), X_);
      for (std::size_t k = 0; k < feet_.size(); ++k) {
        const LimbRig& limb = t_.limbs[at(feet_[k].limb)];
        real[k][at(f)] = X_[at(limb.end)];
        if (limb.point_foot || !feet_[k].path.bears[at(f)]) continue;
        const Mat3 off = real[k][at(f)].R.transposed() * feet_[k].path.X_WF[at(f)].R;
        worst = std::max(worst, 3 - off.trace());
      }
    }
    if (worst > 1e-7) {  // 3 - trace is the squared angle: 1e-7 is 0.3 mrad
      for (std::size_t k = 0; k < feet_.size(); ++k) {
        if (t_.limbs[at(feet_[k].limb)].point_foot) continue;
        for (int f = 0; f < in_.frames; ++f) feet_[k].raw.X_WF[at(f)].R = real[k][at(f)].R;
      }
      pin();
      dirty_.clear();
      solve_all();
    }
    for (FootPlan& plan : feet_) {
      const LimbRig& limb = t_.limbs[at(plan.limb)];
      int stances = 0;
      if (!limb.point_foot && (worst > 1e-7 || limb.sole.parts.size() > 1 || path_skate(plan.path, stances) > 2e-3)) roll(plan);
    }
  }

  /// Lowest point of a sole.
  struct Bearing {
    std::size_t point = 0;  // index into the sole's points
    Vec3 bottom;            // m, in the frame of the point's link
    double height = 1e300;  // m, world
  };
  /// @param X_FP [points] pose of each point's link in the foot's frame
  [[nodiscard]] Bearing find_bearing(const LimbRig& limb, const Pose& X_WF, std::span<const Pose> X_FP) const {
    Bearing out;
    for (std::size_t i = 0; i < limb.sole.points.size(); ++i) {
      const SupportPoint& s = limb.sole.points[i].location;
      const Pose X = X_WF * X_FP[i];
      const Vec3 bottom = s.p + transpose_times(X.R, Vec3{0, 0, -s.radius});
      if (const double height = (X * bottom).z; height < out.height) out = {i, bottom, height};
    }
    return out;
  }

  /// Horizontal distance [m] that the lowest point has slid since the previous frame.
  /// @param X_WP [points] world poses of the points' links in the previous frame
  [[nodiscard]] double slip_of(const LimbRig& limb, const Pose& X, std::span<const Pose> X_FP, std::span<const Pose> X_WP) const {
    const Bearing low = find_bearing(limb, X, X_FP);
    const Vec3 d = X * (X_FP[low.point] * low.bottom) - X_WP[low.point] * low.bottom;
    return std::sqrt(d.x * d.x + d.y * d.y);
  }

  /// In each frame, keeps the lowest point of the sole at its position in the previous frame and at the planned height.
  void roll(FootPlan& plan) {
    const LimbRig& limb = t_.limbs[at(plan.limb)];
    const std::vector<LinkPoint>& points = limb.sole.points;
    const double fade = 1 / (1 + fade_time * in_.rate);
    std::vector<Pose> X_FP(points.size()), X_WP(points.size());
    Vec3 off, best_off;  // m, displacement of the foot from its planned path
    for (int f = 0; f < in_.frames && !cancelled(); ++f) {
      const bool stands = plan.path.bears[at(f)] != 0, stood = f > 0 && plan.path.bears[at(f - 1)] != 0;
      if (!stands) off = off * (1 - fade);
      calc_poses(m_, std::span<const double>(frame(f), at(m_.nq())), X_);
      Pose X = X_[at(limb.end)];
      for (std::size_t i = 0; i < points.size(); ++i) X_FP[i] = X.inverse() * X_[at(points[i].link)];
      const Pose& planned = plan.path.X_WF[at(f)];
      const double height = find_bearing(limb, planned, X_FP).height;
      double minimum = 1e300;
      for (int i = 0; i < max_roll_iterations; ++i) {
        const Bearing low = find_bearing(limb, X, X_FP);
        const Vec3 in_foot = X_FP[low.point] * low.bottom;
        Pose goal{planned.R, planned.p + off};
        goal.p.z = height - (X.R * in_foot).z;
        if (stands && stood) {
          const Vec3 moved = goal.p + X.R * in_foot - X_WP[low.point] * low.bottom;
          off -= Vec3{moved.x, moved.y, 0};
          goal.p -= Vec3{moved.x, moved.y, 0};
        }
        const double miss = driver_.reach(plan.limb, goal, frame(f), X_, i == 0);
        const Mat3 turned = X.R.transposed() * X_[at(limb.end)].R;
        X = X_[at(limb.end)];
        const bool settled = i > 0 && 3 - turned.trace() < 1e-13;
        // If turning the sole changes which point is lowest, the iteration may oscillate: keep the best solution found.
        const double slip = stands && stood ? slip_of(limb, X, X_FP, X_WP) : 0;
        if (settled || miss + slip_weight * slip < minimum) {
          minimum = miss + slip_weight * slip;
          plan.miss[at(f)] = miss;
          best_.assign(frame(f), frame(f) + m_.nq());
          best_off = off;
        }
        if (settled) break;
      }
      std::copy(best_.begin(), best_.end(), frame(f));
      off = best_off;
      calc_poses(m_, std::span<const double>(frame(f), at(m_.nq())), X_);
      X = X_[at(limb.end)];
      for (std::size_t i = 0; i < points.size(); ++i) X_WP[i] = X * X_FP[i];
    }
  }

  /// True if the hand of the target follows a hand of the source.
  [[nodiscard]] bool has_hand(int hand) const {
    const LimbDrive& drive = driver_.limb(2 + hand);
    return drive.mode == LimbMode::copied && !drive.ground && !s_.anatomy.four_legs;
  }

  /// Moves a hand that holds a fixed object to the object's point in the scaled world. Moves hands that hold each other to the scaled
  /// distance between them.
  void hold() {
    if (!o_.keep_holds || !o_.keep_contacts) return;
    std::vector<Miss> misses(2);
    for (const Hold& hold : find_holds(hands_, hips_, in_.rate, s_.leg_length)) {
      out_.report.holds.push_back(text_of(hold));
      const int beside = static_cast<int>(0.2 * in_.rate);
      for (int f = std::max(0, hold.first - beside); f <= std::min(in_.frames - 1, hold.last + beside); ++f) {
        const double weight = weight_of(hold, f, in_.rate);
        if (!(weight > 0)) continue;
        calc_poses(m_, std::span<const double>(frame(f), at(m_.nq())), X_);
        std::array<Vec3, 2> goals;
        for (int hand = 0; hand < 2; ++hand)
          if (has_hand(hand)) goals[at(hand)] = X_[at(t_.limbs[at(2 + hand)].end)].p;
        if (hold.kind == Hold::Kind::fixed) {
          goals[at(hold.hand)] += (driver_.scaled_position(hold.point) - goals[at(hold.hand)]) * weight;
        } else {
          const Vec3 between = (hands_[1][at(f)] - hands_[0][at(f)]) * driver_.scale();
          const Vec3 off = between - (goals[1] - goals[0]);
          goals[0] -= off * (0.5 * weight);
          goals[1] += off * (0.5 * weight);
        }
        for (int hand = 0; hand < 2; ++hand) {
          if (!has_hand(hand) || (hold.kind == Hold::Kind::fixed && hand != hold.hand)) continue;
          const LimbRig& limb = t_.limbs[at(2 + hand)];
          const double off = driver_.reach(2 + hand, {X_[at(limb.end)].R, goals[at(hand)]}, frame(f), X_);
          Miss& miss = misses[at(hand)];
          miss.link = m_.link(limb.end).name;
          if (weight < 1 || off < 1e-3) continue;
          ++miss.frames;
          if (off > miss.maximum) {
            miss.maximum = off;
            miss.frame = f;
          }
        }
      }
    }
    for (const Miss& miss : misses)
      if (miss.frames > 0) hand_misses_.push_back(miss);
  }

  /// Writes contact labels. A frame in which the foot misses its goal by more than 0.002 of the leg's length gets no label.
  void label() {
    for (FootPlan& plan : feet_) {
      const LimbRig& limb = t_.limbs[at(plan.limb)];
      ContactTrack track;
      track.link = m_.link(limb.end).name;
      track.on = plan.path.bears;
      for (int f = 0; f < in_.frames; ++f)
        if (plan.miss[at(f)] > 2e-3 * limb.length) track.on[at(f)] = 0;
      out_.motion.contacts.push_back(std::move(track));
    }
  }

  /// Adds to the report the sliding of one foot before correction, and its distances from the goal.
  void add_foot_facts(FootPlan& plan) {
    int none = 0;
    out_.report.skate_before = std::max(out_.report.skate_before, path_skate(plan.raw, none));
    Miss miss;
    miss.link = m_.link(t_.limbs[at(plan.limb)].end).name;
    for (int f = 0; f < in_.frames; ++f) {
      if (!plan.path.bears[at(f)] || plan.miss[at(f)] < 1e-3) continue;
      ++miss.frames;
      if (plan.miss[at(f)] > miss.maximum) {
        miss.maximum = plan.miss[at(f)];
        miss.frame = f;
      }
    }
    if (miss.frames > 0) out_.report.misses.push_back(miss);
  }

  const Rig& s_;
  const Rig& t_;
  const Mechanism& m_;
  const Motion& in_;
  const RetargetOptions& o_;
  Driver driver_;
  std::vector<std::vector<std::uint8_t>> bears_;  // [limbs of the source][frames]
  std::vector<FootPlan> feet_;
  std::vector<double> postures_, q_, best_;
  std::vector<Pose> X_;
  std::vector<std::uint8_t> dirty_;
  std::vector<Vec3> missing_, hips_;
  std::array<std::vector<Vec3>, 2> hands_;  // [frames] m, positions of the source's wrists
  std::vector<Miss> hand_misses_;
  Retargeted out_;
};

/// Repeats the retargeting with shorter steps (factor 0.8 each, at most 5 runs) until the feet reach their goals; returns the best run.
Retargeted run_with_steps(const Rig& source, const Rig& target, const Motion& motion, const RetargetOptions& options) {
  Retargeted best;
  double minimum = 1e300;
  RetargetOptions tried = options;
  const double usual = Driver(source, target, options.mapping).scale();
  for (int i = 0; i < 5; ++i) {
    Retargeting run(source, target, motion, tried);
    Retargeted out = run.run();
    double maximum = 0;
    for (const Miss& miss : out.report.misses) maximum = std::max(maximum, miss.maximum);
    out.report.misses.insert(out.report.misses.end(), run.hand_misses().begin(), run.hand_misses().end());
    // A large displacement of the root counts like a foot that misses its goal.
    maximum += 0.1 * std::max(0.0, out.report.max_shift - 0.1 * target.leg_length);
    if (maximum < minimum - 1e-4 || i == 0) {
      minimum = maximum;
      best = std::move(out);
      if (i > 0)
        best.report.notes.push_back(
            "Steps are " + to_fixed(100 * (1 - tried.path_scale / usual), 0) +
            " % shorter than those of the source, because the legs cannot reach further within their joint limits.");
    }
    if (maximum < 2e-3 * target.leg_length || options.path_scale > 0 || (options.cancelled && options.cancelled())) break;
    tried.path_scale = usual * pow(0.8, i + 1);
  }
  return best;
}

/// Returns one problem for each link name of the mapping that does not exist. Names of the anatomy are checked by find_anatomy.
Error unknown_names(const Mapping& mapping, const Mechanism& from, const Mechanism& to) {
  Error out;
  const auto look = [&](const Mechanism& m, const std::string& name, const char* where) {
    if (m.find_link(name) < 0)
      out.add(ErrorCode::unknown, where, "'" + m.name() + "' has no link '" + name + "'.", "Correct the name in the mapping file.");
  };
  for (const auto& [source, target] : mapping.links) {
    look(from, source, "mapping/links");
    look(to, target, "mapping/links");
  }
  for (const SoleSpec& sole : mapping.soles) look(to, sole.link, "mapping/soles");
  for (const auto& [link, speed] : mapping.link_speeds) look(to, link, "mapping/speeds");
  return out;
}

}  // namespace

Result<Retargeted> retarget(MechanismPtr from, const Motion& motion, MechanismPtr to, const RetargetOptions& options) {
  if (Error wrong = check_motion(motion, *from); !wrong.empty()) return fail(std::move(wrong));
  if (Error wrong = unknown_names(options.mapping, *from, *to); !wrong.empty()) return fail(std::move(wrong));
  Result<Rig> source = make_rig(from, options.mapping.source);
  if (!source) return fail(std::move(source.error()));
  Result<Rig> target = make_rig(to, options.mapping.target, options.mapping.soles);
  if (!target) return fail(std::move(target.error()));
  if (to->link(0).joint.type != JointType::floating)
    return fail(ErrorCode::structure, to->name(),
                "The base of the target mechanism is fixed to the world, so the target cannot follow the motion.",
                "Import the mechanism with a floating base (--base floating).");
  const bool around = motion.cyclic && options.keep_contacts && motion.frames >= 3;
  Retargeted out = run_with_steps(*source, *target, around ? motion_edit::three_rounds(motion, *from) : motion, options);
  if (options.cancelled && options.cancelled())
    return fail(ErrorCode::cancelled, "motion " + motion.name, "The retargeting was cancelled.", "");
  if (!around) return out;
  const auto placement = [&](int frame) { return root_placement(*to, {out.motion.frame(frame), at(to->nq())}); };
  const int round = motion.frames - 1;
  out.motion = motion_edit::middle_round(out.motion, *to, placement(2 * round) * inverse(placement(round)));
  return out;
}

}  // namespace ugoki::retarget
