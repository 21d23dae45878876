#include "ugoki/gait/gait.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/gait/centre.h"
#include "ugoki/gait/path.h"
#include "ugoki/gait/posture.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/torques.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::gait {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }
// Share of the moment of the ground forces about the centre of mass that pitches the trunk in gallops. The rest accelerates the body along
// its path. With 0.85, the body pitches by up to 18 degrees and is lowered by 22 cm, so that the feet reach the ground.
constexpr double trunk_share = 0.6;
constexpr int rounds = 4;  // of centre of mass, postures, and angular momentum of these postures

/// Centred moving average.
template <class T>
std::vector<T> averaged(const std::vector<T>& x, int half) {
  const int n = static_cast<int>(x.size());
  std::vector<T> sum(at(n + 1)), out(at(n));
  for (int i = 0; i < n; ++i) sum[at(i + 1)] = sum[at(i)] + x[at(i)];
  for (int i = 0; i < n; ++i) {
    const int h = std::min({half, i, n - 1 - i});
    out[at(i)] = (sum[at(i + h + 1)] - sum[at(i - h)]) * (1.0 / (2 * h + 1));
  }
  return out;
}

class Generator {
 public:
  Generator(const Walker& w, const GaitOptions& o, GaitReport& report) : w_(w), o_(o), report_(report), course_(make_course(w, o)) {}

  Motion run() {
    const int n = course_.frames;
    Poser poser(w_, o_, course_);
    set_heights();
    set_pressures();
    std::vector<double> pitch(at(n));
    std::vector<Vec3> moment(at(n));
    lower_.assign(at(n), 0);
    Swing swing;
    const std::size_t nq = at(w_.mechanism->nq());
    q_.assign(at(n) * nq, 0);
    for (int f = 0; f < n; ++f) std::copy(w_.q_stand.begin(), w_.q_stand.end(), q_.begin() + static_cast<std::ptrdiff_t>(at(f) * nq));
    for (int round = 0; round < rounds; ++round) {
      solve_path(moment, round == 0);
      if (round == 0) set_pitch(pitch);
      double miss = 0;
      std::vector<double> excess(at(n));
      for (int f = 0; f < n; ++f) {
        if (o_.cancelled && o_.cancelled()) return {};
        std::span<double> q(q_.data() + at(f) * nq, nq);
        const double own = poser.pose(f, centre_[at(f)], pitch[at(f)], swing, q);
        if (f >= course_.first && f <= course_.last) miss = std::max(miss, own);
        excess[at(f)] = poser.excess(f);
      }
      report_.max_miss = miss;
      if (round + 1 < rounds) {
        lower_for_reach(excess);
        measure(moment, poser.arms(), swing);
      }
    }
    return take();
  }

 private:
  /// Load of each frame and the height of the centre of mass before it is lowered for the reach of the legs.
  void set_heights() {
    const int n = course_.frames;
    load_.resize(at(n));
    height_.resize(at(n));
    std::vector<double> a(at(n));
    double time = 1;
    for (int f = 0; f < n; ++f) {
      const CourseFrame& b = course_.body[at(f)];
      double sum = 0, mean = 0;
      for (const std::vector<LegFrame>& leg : course_.legs) {
        sum += leg[at(f)].load;
        mean += leg[at(f)].duty * (1 - b.ramp);
      }
      // Six legs and more bear the body at a constant height as long as half of them stand.
      const double walk = w_.biped ? 1 - b.run : many_legs() && course_.legs[0][at(f)].duty >= 0.5 ? 1 : 0;
      a[at(f)] = o_.gravity * b.moving * (1 - walk) * (sum / std::max(mean, 1e-6) - 1);
      time = b.stride_time;
    }
    // The stride time of the last frame decides the slowest frequency that counts as movement of the gait.
    const std::vector<double> bob = integrate_twice(a, 0.15 * 2 * pi / time, o_.rate);
    for (int f = 0; f < n; ++f) {
      const CourseFrame& b = course_.body[at(f)];
      const double step = 0.5 * std::fabs(b.speed) * b.stride_time, leg = w_.hip_height;
      double z = w_.centre_height - o_.style.crouch * leg + b.ground + bob[at(f)] * o_.style.bounce;
      if (w_.biped) {
        const LegFrame& left = course_.legs[0][at(f)];
        const double ratio = step / (0.733 * leg);
        const double size = 0.5 * 0.046 * leg / 0.9 * std::min(1.4, ratio * ratio) * b.moving * (1 - b.run) * o_.style.bounce;
        z += size * (cos(4 * pi * (phase_of(left) - 0.5 * left.duty + 0.035)) - 1);
      } else {
        z -= (w_.legs.size() == 4 ? 0.04 : 0.02) * leg * b.moving;
      }
      height_[at(f)] = z;
    }
  }

  /// Centre of pressure in every frame: the mean of the feet, weighted by their loads.
  void set_pressures() {
    const int n = course_.frames;
    pressure_.resize(at(n));
    // Share of each leg, so that the mean pressure is below the centre of mass of the standing body
    double mean = 0, square = 0;
    for (const WalkerLeg& leg : w_.legs) mean += leg.home.x / static_cast<double>(w_.legs.size());
    for (const WalkerLeg& leg : w_.legs) square += (leg.home.x - mean) * (leg.home.x - mean) / static_cast<double>(w_.legs.size());
    flight_.assign(at(n), 0);
    std::vector<BearingFoot> feet;
    for (int f = 0; f < n; ++f) {
      const CourseFrame& b = course_.body[at(f)];
      Vec3 sum;
      double weight = 0;
      feet.clear();
      for (std::size_t k = 0; k < w_.legs.size(); ++k) {
        const LegFrame& leg = course_.legs[k][at(f)];
        if (!leg.stands) continue;
        double own = b.moving * leg.load + (1 - b.moving);
        if (many_legs()) {
          const Vec3 p = foot_pose(w_, o_, course_, k, f).pressure;
          feet.push_back({p, own, {p.x - b.x, p.y - b.y, 0}});
          continue;
        }
        if (!w_.biped && square > 1e-9) own *= std::max(0.2, 1 - mean * (w_.legs[k].home.x - mean) / square);
        const FootPose foot = foot_pose(w_, o_, course_, k, f);
        sum += foot.pressure * own;
        weight += own;
      }
      balance_loads(feet);
      for (const BearingFoot& foot : feet) sum += foot.pressure * foot.load, weight += foot.load;
      if (weight > 0)
        pressure_[at(f)] = sum / weight;
      else
        flight_[at(f)] = 1;
      if (weight <= 0 && f > 0) pressure_[at(f)] = pressure_[at(f - 1)];
    }
  }

  struct BearingFoot {
    Vec3 pressure;
    double load = 0;
    Vec3 from_body;  // m, horizontal: the foot relative to the body
  };

  /// Changes the loads as little as possible so that their mean is below the body, if the body is inside the support. A machine on many
  /// legs then goes straight ahead and does not sway from one tripod to the next. With the loads e_k and the places d_k, the new loads e_k
  /// max(0, 1 + x . d_k) follow from the minimum over x of sum e_k max(0, 1 + x . d_k)^2 / 2, which is convex (Newton steps).
  static void balance_loads(std::span<BearingFoot> feet) {
    constexpr double firm = 1e-3;  // m^2, share of the total load: keeps x finite if the body is outside the support
    constexpr int max_steps = 40;
    double total = 0;
    for (const BearingFoot& foot : feet) total += foot.load;
    if (!(total > 0)) return;
    double x = 0, y = 0;
    const auto value = [&](double u, double v) {
      double sum = 0.5 * firm * total * (u * u + v * v);
      for (const BearingFoot& foot : feet) {
        const double s = std::max(0.0, 1 + u * foot.from_body.x + v * foot.from_body.y);
        sum += 0.5 * foot.load * s * s;
      }
      return sum;
    };
    for (int step = 0; step < max_steps; ++step) {
      double gx = firm * total * x, gy = firm * total * y, xx = firm * total, xy = 0, yy = firm * total;
      for (const BearingFoot& foot : feet) {
        const Vec3& d = foot.from_body;
        const double s = 1 + x * d.x + y * d.y;
        if (s <= 0) continue;
        gx += foot.load * s * d.x, gy += foot.load * s * d.y;
        xx += foot.load * d.x * d.x, xy += foot.load * d.x * d.y, yy += foot.load * d.y * d.y;
      }
      const double det = xx * yy - xy * xy, dx = (yy * gx - xy * gy) / det, dy = (xx * gy - xy * gx) / det;
      if (dx * dx + dy * dy < 1e-20 * (1 + x * x + y * y)) break;
      double share = 1;
      const double here = value(x, y), slope = gx * dx + gy * dy;
      while (share > 1e-4 && value(x - share * dx, y - share * dy) > here - 1e-4 * share * slope) share *= 0.5;
      x -= share * dx, y -= share * dy;
    }
    for (BearingFoot& foot : feet) foot.load *= std::max(0.0, 1 + x * foot.from_body.x + y * foot.from_body.y);
  }

  [[nodiscard]] bool many_legs() const { return w_.legs.size() > 4; }

  /// Trajectory of the centre of mass.
  void solve_path(const std::vector<Vec3>& moment, bool first) {
    const int n = course_.frames;
    std::vector<double> z(at(n));
    for (int f = 0; f < n; ++f) z[at(f)] = height_[at(f)] - lower_[at(f)];
    frames_.resize(at(n));
    for (int f = 0; f < n; ++f) {
      CentreFrame& c = frames_[at(f)];
      const int i = std::clamp(f, 1, n - 2);
      const double up = (z[at(i - 1)] - 2 * z[at(i)] + z[at(i + 1)]) * o_.rate * o_.rate;
      c.pressure = pressure_[at(f)];
      c.load = flight_[at(f)] ? 0 : std::max(0.0, o_.gravity + up);
      c.height = std::max(0.2 * w_.centre_height, z[at(f)] - c.pressure.z);
      c.moment = flight_[at(f)] ? Vec3{} : moment[at(f)];
      c.share = first ? 1 - trunk_share * course_.body[at(f)].spring : 1;
    }
    centre_ = solve_centre(frames_, o_.rate);
    for (int f = 0; f < n; ++f) centre_[at(f)].z = z[at(f)];
  }

  /// Pitch of the trunk in gallops: the moment of the ground forces that do not point to the centre of mass.
  void set_pitch(std::vector<double>& pitch) {
    const int n = course_.frames;
    std::vector<double> a(at(n));
    double spring = 0;
    const double inertia = trunk_inertia();
    for (int f = 0; f < n; ++f) {
      const CentreFrame& c = frames_[at(f)];
      const Vec3 arm = centre_[at(f)] - c.pressure;
      const SinCos h = sin_cos(course_.body[at(f)].heading);
      a[at(f)] = (1 - c.share) * c.load * (h.cos * arm.x + h.sin * arm.y) / inertia;
      spring = std::max(spring, course_.body[at(f)].spring);
    }
    if (spring <= 0) return;
    // The mean over a stride accelerates the body and does not turn it.
    std::vector<double> sum(at(n + 1)), turning(at(n));
    for (int f = 0; f < n; ++f) sum[at(f + 1)] = sum[at(f)] + a[at(f)];
    for (int f = 0; f < n; ++f) {
      const int half = std::min({static_cast<int>(0.5 * course_.body[at(f)].stride_time * o_.rate), f, n - 1 - f});
      turning[at(f)] = a[at(f)] - (sum[at(f + half + 1)] - sum[at(f - half)]) / (2 * half + 1);
    }
    pitch = integrate_twice(turning, 0.25 * 2 * pi / course_.body[at(course_.last)].stride_time, o_.rate);
  }

  /// Moment of inertia about the lateral axis divided by the mass, m^2, of the standing body.
  [[nodiscard]] double trunk_inertia() const {
    dynamics::Workspace ws(*w_.mechanism);
    const std::vector<double> v(at(w_.mechanism->nv()));
    dynamics::update_kinematics(*w_.mechanism, w_.q_stand, v, ws);
    const dynamics::Centroidal c = dynamics::calc_centroidal(*w_.mechanism, ws);
    return std::max(1e-6, c.inertia.yy / std::max(1e-9, c.mass));
  }

  /// Lowers the body smoothly where a leg is too long. The body stays low over a stride, so that it does not bounce.
  void lower_for_reach(const std::vector<double>& excess) {
    const int n = course_.frames;
    int half = 1;
    for (int f = course_.first; f <= course_.last; ++f)
      half = std::max(half, static_cast<int>(0.55 * course_.body[at(f)].stride_time * o_.rate));
    std::vector<double> total(at(n)), max_total(at(n));
    for (int f = 0; f < n; ++f) total[at(f)] = std::max(0.0, lower_[at(f)] + excess[at(f)]);
    // A sliding maximum; its window is larger than that of the averages that follow, which therefore stay above every value.
    for (int f = 0; f < n; ++f) {
      double m = 0;
      for (int k = std::max(0, f - half); k <= std::min(n - 1, f + half); ++k) m = std::max(m, total[at(k)]);
      max_total[at(f)] = m;
    }
    for (int pass = 0; pass < 3; ++pass) max_total = averaged(max_total, half / 3);
    lower_ = std::move(max_total);
    for (int f = course_.first; f <= course_.last; ++f) report_.max_lowering = std::max(report_.max_lowering, lower_[at(f)]);
  }

  /// Measures the rate of the angular momentum of the postures, and adapts the swing of the arms so that it cancels the angular momentum
  /// about the vertical axis.
  void measure(std::vector<Vec3>& moment, std::span<const int> arms, Swing& swing) {
    const Mechanism& m = *w_.mechanism;
    const int n = course_.frames;
    const std::size_t nq = at(m.nq());
    std::vector<Vec3> spin(at(n));
    std::vector<double> v(at(m.nv()));
    dynamics::Workspace ws(m);
    double with_arms = 0, arms_square = 0;
    for (int f = 0; f < n; ++f) {
      const int a = std::max(0, f - 1), b = std::min(n - 1, f + 1);
      difference(m, {q_.data() + at(a) * nq, nq}, {q_.data() + at(b) * nq, nq}, v);
      for (double& x : v) x *= o_.rate / (b - a);
      dynamics::update_kinematics(m, {q_.data() + at(f) * nq, nq}, v, ws);
      const dynamics::Centroidal c = dynamics::calc_centroidal(m, ws);
      spin[at(f)] = c.momentum.w / c.mass;
      if (arms.empty() || f < course_.first || f > course_.last) continue;
      double own = 0;  // about the vertical axis, relative to a body that moves like the trunk
      for (const int i : arms) {
        const Vec6 h = ws.X_WB[at(i)].force_to_parent(m.link(i).inertia * ws.V[at(i)]);
        const double mass = m.link(i).inertia.mass;
        own += (h.w - cross(c.centre, h.v)).z - mass * cross(ws.X_WB[at(i)] * m.link(i).inertia.centre() - c.centre, c.velocity).z;
      }
      own /= c.mass;
      const double turn = course_.body[at(f)].turn * (c.inertia.zz / c.mass);
      with_arms += (spin[at(f)].z - turn) * own;
      arms_square += own * own;
    }
    if (arms_square > 1e-12) swing.arms = std::clamp(swing.arms * (1 - with_arms / arms_square), 0.4, 1.6);
    for (int f = 0; f < n; ++f) {
      const int a = std::max(0, f - 1), b = std::min(n - 1, f + 1);
      moment[at(f)] = (spin[at(b)] - spin[at(a)]) * (o_.rate / (b - a));
    }
    for (int pass = 0; pass < 2; ++pass) moment = averaged(moment, static_cast<int>(0.02 * o_.rate));
  }

  Motion take() {
    const Mechanism& m = *w_.mechanism;
    const std::size_t nq = at(m.nq());
    Motion out;
    out.name = std::string(name_of(o_.stages.front().kind)) + " " + to_fixed(o_.stages.front().speed, 2) + " m/s";
    out.source = "computed gait";
    out.mechanism = m.name();
    out.rate = o_.rate;
    out.frames = course_.last - course_.first + 1;
    out.nq = m.nq();
    out.cyclic = o_.one_stride;
    out.q.assign(q_.begin() + static_cast<std::ptrdiff_t>(at(course_.first) * nq),
                 q_.begin() + static_cast<std::ptrdiff_t>(at(course_.last + 1) * nq));
    keep_signs(out);
    mark_computed(out);
    for (std::size_t k = 0; k < w_.legs.size(); ++k) {
      ContactTrack track{m.link(w_.legs[k].link).name, {}};
      for (int f = course_.first; f <= course_.last; ++f) track.on.push_back(course_.legs[k][at(f)].stands ? 1 : 0);
      out.contacts.push_back(std::move(track));
      report_.legs.push_back(m.link(w_.legs[k].link).name);
      std::vector<FootStance>& list = report_.stances.emplace_back();
      for (const Stance& s : course_.stances[k]) {
        if (s.end < course_.first || s.begin > course_.last) continue;
        list.push_back({(s.begin - course_.first) / o_.rate, (s.end - course_.first) / o_.rate, s.place, s.heading});
      }
    }
    report_.stride_time = course_.body[at(course_.last)].stride_time;
    report_.duty = course_.legs[0][at(course_.last)].duty;
    report_.notes = w_.notes;
    note_shortness();
    note_balance();
    measure_pressure();
    return out;
  }

  /// A start and a stop take some seconds. In a shorter motion the character only stands, and its maker should know why.
  void note_shortness() {
    const bool wants = std::ranges::any_of(o_.stages, [](const GaitStage& s) { return s.speed != 0 || s.turn != 0; });
    double moving = 0;
    for (int f = course_.first; f <= course_.last; ++f) moving = std::max(moving, course_.body[at(f)].moving);
    if (wants && moving < 0.01)
      report_.notes.push_back(
          "The motion is too short for a start and a stop, so the character stands. Make it longer, or let it begin or end moving.");
  }

  /// Reports a motion in which balance control has not kept the body upright without root assist (docs/gait.md).
  void note_balance() {
    const double unit = std::sqrt(o_.gravity * w_.hip_height);
    constexpr double max_gallop = 1.9, max_miss = 0.03;  // speed / sqrt(g l); share of the hip height
    for (const GaitStage& s : o_.stages) {
      const bool gallops = s.kind == GaitKind::gallop || s.kind == GaitKind::rotary;
      if (s.kind == GaitKind::pronk || (gallops && s.speed > max_gallop * unit)) {
        report_.notes.push_back("Without root assist, a character usually falls in the gait '" + std::string(name_of(s.kind)) + "'" +
                                (gallops ? " at more than " + to_fixed(max_gallop * unit, 1) + " m/s." : "."));
        return;
      }
    }
    if (w_.biped && report_.max_miss > max_miss * w_.hip_height)
      report_.notes.push_back("The legs are too short for this gait: feet miss their places by up to " +
                              to_fixed(100 * report_.max_miss, 1) + " cm. Without root assist, a character falls. Choose a lower speed.");
  }

  /// rms distance of the centre of pressure of the final postures from the planned one.
  void measure_pressure() {
    const Mechanism& m = *w_.mechanism;
    const int n = course_.frames;
    std::vector<Vec3> moment(at(n));
    Swing unused;
    measure(moment, {}, unused);
    std::vector<Pose> X(at(m.link_count()));
    std::vector<Vec3> c(at(n));
    for (int f = 0; f < n; ++f) {
      calc_poses(m, {q_.data() + at(f) * at(m.nq()), at(m.nq())}, X);
      c[at(f)] = centre_of_mass(m, X);
    }
    double sum = 0, count = 0;
    for (int f = course_.first + 1; f < course_.last; ++f) {
      const Vec3 a = (c[at(f - 1)] - c[at(f)] * 2 + c[at(f + 1)]) * (o_.rate * o_.rate);
      const double load = a.z + o_.gravity;
      if (flight_[at(f)] || load < 0.3 * o_.gravity) continue;
      const double h = c[at(f)].z - pressure_[at(f)].z;
      const double x = c[at(f)].x - (h * a.x + moment[at(f)].y) / load - pressure_[at(f)].x;
      const double y = c[at(f)].y - (h * a.y - moment[at(f)].x) / load - pressure_[at(f)].y;
      sum += x * x + y * y;
      count += 1;
    }
    report_.pressure_rms = count > 0 ? std::sqrt(sum / count) : 0;
  }

  /// Quaternions change continuously from frame to frame.
  void keep_signs(Motion& motion) const {
    for (const Link& link : w_.mechanism->links()) {
      const int offset = link.joint.type == JointType::floating ? 3 : link.joint.type == JointType::spherical ? 0 : -1;
      if (offset < 0) continue;
      for (int f = 1; f < motion.frames; ++f) {
        const double* a = motion.frame(f - 1) + link.q_index + offset;
        double* b = motion.frame(f) + link.q_index + offset;
        if (a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0)
          for (int k = 0; k < 4; ++k) b[k] = -b[k];
      }
    }
  }

  const Walker& w_;
  const GaitOptions& o_;
  GaitReport& report_;
  Course course_;
  std::vector<double> load_, height_, lower_;  // [frames]
  std::vector<Vec3> pressure_, centre_;        // [frames]
  std::vector<std::uint8_t> flight_;           // [frames]
  std::vector<CentreFrame> frames_;
  std::vector<double> q_;  // [frames][nq]
};

/// Problems of the options.
Error check(const Walker& w, const GaitOptions& o) {
  Error e;
  const std::string where = "gait";
  if (o.stages.empty()) e.add(ErrorCode::range, where, "The gait has no stage.", "Give at least one stage.");
  const auto finite = [](double x) { return std::isfinite(x); };
  const double unit = std::sqrt(o.gravity * w.hip_height);
  for (const GaitStage& s : o.stages) {
    if (!finite(s.time) || !finite(s.speed) || !finite(s.turn) || std::fabs(s.turn) > 10)
      e.add(ErrorCode::range, where, "Time, speed or turn rate is out of range.", "Use finite numbers, and a turn rate up to 10 rad/s.");
    else if (std::fabs(s.speed) > 6 * unit)
      e.add(ErrorCode::range, where, "The speed " + to_text(s.speed) + " m/s is too high for legs of " + to_fixed(w.hip_height, 2) + " m.",
            "Use at most " + to_fixed(6 * unit, 1) + " m/s.");
    const std::vector<GaitKind> kinds = kinds_for(static_cast<int>(w.legs.size()));
    if (std::ranges::find(kinds, s.kind) == kinds.end()) {
      std::string names;
      for (const GaitKind k : kinds) names += (names.empty() ? "" : ", ") + std::string(name_of(k));
      e.add(ErrorCode::range, where,
            "A mechanism with " + std::to_string(w.legs.size()) + " legs has no gait '" + std::string(name_of(s.kind)) + "'.",
            "Use " + names + ".");
    }
  }
  if (!o.one_stride && !(o.seconds > 0.05 && o.seconds <= 3600))
    e.add(ErrorCode::range, where, "The duration is out of range.", "Use 0.05 to 3600 s.");
  if (!(o.rate >= 20 && o.rate <= 1000)) e.add(ErrorCode::range, where, "The rate is out of range.", "Use 20 to 1000 frames per second.");
  if (!(o.gravity > 0.1 && o.gravity < 100)) e.add(ErrorCode::range, where, "The gravity is out of range.", "Use 0.1 to 100 m/s^2.");
  if (!(o.duty == 0 || (o.duty > 0.1 && o.duty < 0.95)))
    e.add(ErrorCode::range, where, "The duty factor is out of range.", "Use 0.1 to 0.95.");
  if (!(o.step_height >= 0 && o.step_height < w.hip_height))
    e.add(ErrorCode::range, where, "The height of the steps is out of range.", "Use less than the height of the hips.");
  if (!(o.stride_time == 0 || (o.stride_time > 0.05 && o.stride_time < 20)))
    e.add(ErrorCode::range, where, "The duration of a stride is out of range.", "Use 0.05 to 20 s.");
  if (!o.phases.empty() && o.phases.size() != w.legs.size())
    e.add(ErrorCode::range, where,
          "There are " + std::to_string(o.phases.size()) + " phases for " + std::to_string(w.legs.size()) + " legs.",
          "Give one phase for each leg, in the order of the report.");
  if (o.one_stride && !o.stages.empty() && o.stages.front().speed == 0 && o.stages.front().turn == 0)
    e.add(ErrorCode::range, where, "One stride needs a speed or a turn rate.", "Give a speed other than 0.");
  return e;
}

}  // namespace

Result<double> usual_speed(const MechanismPtr& mechanism, GaitKind kind, double gravity) {
  const Result<Walker> w = make_walker(mechanism);
  if (!w) return fail(w.error());
  const double unit = std::sqrt(gravity * w->hip_height);
  switch (kind) {
    case GaitKind::walk: return (w->legs.size() > 4 ? 0.15 : 0.42) * unit;
    case GaitKind::run: return (w->biped ? 1.0 : w->legs.size() > 4 ? 0.5 : 0.9) * unit;
    case GaitKind::trot:
    case GaitKind::pace: return (w->legs.size() > 4 ? 0.5 : 0.9) * unit;
    case GaitKind::canter:
    case GaitKind::bound:
    case GaitKind::pronk: return 1.4 * unit;
    case GaitKind::gallop:
    case GaitKind::rotary: return 1.6 * unit;
  }
  return unit;
}

Result<std::vector<GaitKind>> kinds_of(const MechanismPtr& mechanism) {
  const Result<Walker> w = make_walker(mechanism);
  if (!w) return fail(w.error());
  return kinds_for(static_cast<int>(w->legs.size()));
}

Result<void> fit_to_path(const MechanismPtr& mechanism, GaitOptions& options) {
  const Result<Walker> walker = make_walker(mechanism);
  if (!walker) return fail(walker.error());
  const auto wrong = [&](const std::string& what, const std::string& remedy) {
    return fail(ErrorCode::range, mechanism->name(), what, remedy);
  };
  if (options.path.size() < 2) return wrong("The gait has no path.", "Give two or more points.");
  const double length = SmoothPath(options.path).length();
  options.from_stand = options.to_stand = true;
  options.one_stride = false;
  const auto final_speed = [&] { return std::fabs(options.stages.back().speed); };
  if (options.stages.empty() || !(final_speed() > 0.01))
    return wrong("The last stage of the gait stands, so the end of the path is not reached.", "Give the last stage a speed.");
  options.seconds = length / final_speed() + 4;
  // The distance grows by speed times duration, except for short paths, on which the speed is not reached.
  constexpr int max_rounds = 30;
  constexpr double tolerance = 0.01, shortest = 1;  // m, s
  for (int round = 0; round < max_rounds; ++round) {
    if (!(options.seconds <= 3600))
      return wrong("The gait along the path takes longer than an hour.", "Give a shorter path or a higher speed.");
    if (Error problems = check(*walker, options); !problems.empty()) return fail(std::move(problems));
    const Course course = make_course(*walker, options);
    double travelled = 0;
    for (int f = course.first; f < course.last; ++f) travelled += course.body[at(f)].speed / options.rate;
    const double excess = travelled - length;
    if (std::fabs(excess) < tolerance) break;
    options.seconds -= excess / final_speed();
    if (options.seconds < shortest || (round > 4 && excess > 0)) {
      for (GaitStage& stage : options.stages) stage.speed *= 0.8;
      options.seconds = std::max(options.seconds, length / final_speed() + 4);
    }
  }
  return {};
}

Result<Motion> make_gait(const MechanismPtr& mechanism, const GaitOptions& options, GaitReport* report) {
  Result<Walker> walker = make_walker(mechanism);
  if (!walker) return fail(std::move(walker.error()));
  if (Error wrong = check(*walker, options); !wrong.empty()) return fail(std::move(wrong));
  GaitReport unused;
  GaitReport& out = report ? *report : unused;
  out = {};
  Motion made = Generator(*walker, options, out).run();
  if (options.cancelled && options.cancelled()) return fail(ErrorCode::cancelled, mechanism->name(), "The gait was cancelled.", "");
  return made;
}

}  // namespace ugoki::gait
