#include "ugoki/motion_edit/intermediate.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/smooth_motion.h"
#include "ugoki/motion_edit/flight.h"
#include "ugoki/motion_edit/mean_pose.h"
#include "ugoki/motion_edit/phase_curve.h"
#include "ugoki/motion_edit/progression.h"
#include "ugoki/motion_edit/rounds.h"

namespace ugoki::motion_edit {
namespace {

constexpr double min_anchor_gap = 0.05;  // cycles, minimum distance between the touch-downs by which phases are aligned (anchors)
constexpr double main_stance = 0.4;      // fraction of the foot's longest stance; shorter stances do not count as steps
constexpr double still = 0.05;           // m/s: the direction of travel of slower motions is ignored
constexpr double min_part = 0.02;        // cycles, minimum duration of a stance or swing that is aligned separately

std::size_t at(int i) { return static_cast<std::size_t>(i); }

double wrapped(double x, double period) { return x - period * std::floor(x / period + 0.5); }

/// One stance of a foot: phases of touch-down and lift-off in cycles; on in [0, 1), off in (on, on + 1).
struct Step {
  double on = 0, off = 0;
};

/// A source in its cyclic form, with its contacts and steps.
struct Source {
  Motion cycle;
  CycleReport report;
  FootContacts contacts;
  SmoothMotion smooth;
  Progression progression;
  std::vector<std::vector<Step>> steps;  ///< [feet]

  [[nodiscard]] double duration() const { return cycle.duration(); }
};

std::vector<Step> steps_of(const std::vector<std::uint8_t>& on) {
  const int n = static_cast<int>(on.size()) - 1;
  std::vector<Step> steps;
  int longest = 0;
  for (int f = 0; f < n; ++f) {
    if (!on[at(f)] || on[at((f + n - 1) % n)]) continue;
    int length = 1;
    while (length < n && on[at((f + length) % n)]) ++length;
    steps.push_back({static_cast<double>(f) / n, static_cast<double>(f + length - 1) / n});
    longest = std::max(longest, length);
  }
  std::erase_if(steps, [&](const Step& s) { return (s.off - s.on) * n + 1 < main_stance * longest; });
  return steps;
}

}  // namespace

struct Intermediate::Impl {
  const Mechanism* mechanism = nullptr;
  IntermediateOptions options;
  std::vector<FootLimb> feet;
  std::vector<Source> sources;
  std::vector<bool> foot_steps;  ///< [feet] true if the foot steps in all sources
  std::vector<std::vector<int>>
      in_limb;  ///< [feet] links whose joints follow the foot's own phase: the foot's limb and the foot's descendants
  std::vector<std::vector<double>>
      anchors;  ///< [sources][anchors] cycles, increasing: phases of corresponding touch-downs; their range is below one cycle

  [[nodiscard]] const Mechanism& m() const { return *mechanism; }

  Result<void> add_source(const Motion& motion);
  Result<void> align();
  void align_by_pose();
  void find_limbs();

  /// Coordinates of a source at a phase of its own cycle, relative to its progression at that phase. @param q [nq, out]
  void sample_at(const Source& s, double phase, std::vector<double>& q) const {
    const double rounds = std::floor(phase);
    q.resize(at(m().nq()));
    std::vector<double> v(at(m().nv())), a(v.size());
    s.smooth.sample(m(), (phase - rounds) * s.duration(), q, v, a);
    displace_root(m(), inverse(s.progression.at(phase - rounds)), q);
  }
  [[nodiscard]] Progression mixed_progression(std::span<const double> w, int& frames, double rate) const;
  void correct_flight(std::span<const double> w, Motion& mixed, const std::vector<FootPath>& paths) const;
  [[nodiscard]] Motion mix(std::span<const double> w, std::vector<FootPath>& paths) const;
};

Result<void> Intermediate::Impl::add_source(const Motion& motion) {
  CycleReport report;
  CycleOptions o = options.cycle;
  Result<Motion> cycle = make_cyclic(m(), motion, o, &report);
  if (!cycle) return fail(std::move(cycle.error()));
  FootContacts contacts = labelled_contacts(m(), *cycle, feet, o.contacts);
  SmoothMotion smooth(*cycle, m(), 0);
  const Progression progression = find_progression(*cycle, m());
  std::vector<std::vector<Step>> steps;
  for (const std::vector<std::uint8_t>& on : contacts.bears) steps.push_back(steps_of(on));
  sources.push_back({std::move(*cycle), report, std::move(contacts), std::move(smooth), progression, std::move(steps)});
  return {};
}

Result<void> Intermediate::Impl::align() {
  foot_steps.assign(feet.size(), true);
  for (std::size_t k = 0; k < feet.size(); ++k) {
    for (const Source& s : sources) foot_steps[k] = foot_steps[k] && !s.steps[k].empty();
    for (const Source& s : sources) {
      if (!foot_steps[k] || s.steps[k].size() == sources[0].steps[k].size()) continue;
      return fail(ErrorCode::structure, "motion " + s.cycle.name + ", foot " + m().link(feet[k].link).name,
                  "The foot steps " + std::to_string(s.steps[k].size()) + " times per cycle, but " +
                      std::to_string(sources[0].steps[k].size()) + " times in motion " + sources[0].cycle.name + ".",
                  "Make cycles of one stride each, or label the contacts by hand.");
    }
  }
  // Unwrapped phases of all touch-downs in each source. The phase of the first touch-down is the one closest to its phase in source 0; the
  // other touch-downs follow within about one cycle.
  struct Anchor {
    std::vector<double> phase;  // [sources]
  };
  std::vector<Anchor> found;
  for (std::size_t k = 0; k < feet.size(); ++k) {
    if (!foot_steps[k]) continue;
    for (std::size_t i = 0; i < sources[0].steps[k].size(); ++i) {
      Anchor a;
      for (std::size_t j = 0; j < sources.size(); ++j) {
        const double reference = found.empty() ? 0 : found.front().phase[j], first = found.empty() ? 0 : found.front().phase[0];
        double own = sources[j].steps[k][i].on;
        if (found.empty())
          own = j == 0 ? own : a.phase[0] + wrapped(own - a.phase[0], 1);
        else if (j == 0)
          own = reference + (own - reference) - std::floor(own - reference);
        else  // choose the phase whose delay after the first touch-down is closest to the delay in source 0
          own = reference + (a.phase[0] - first) + wrapped(own - reference - (a.phase[0] - first), 1);
        a.phase.push_back(own);
      }
      found.push_back(std::move(a));
    }
  }
  std::sort(found.begin(), found.end(), [](const Anchor& a, const Anchor& b) { return a.phase[0] < b.phase[0]; });
  anchors.assign(sources.size(), {});
  for (const Anchor& a : found) {  // keep an anchor only if the anchors are in this order in every source
    bool rising = true;
    for (std::size_t j = 0; j < sources.size(); ++j)
      if (!anchors[j].empty())
        rising = rising && a.phase[j] - anchors[j].back() > min_anchor_gap && a.phase[j] < anchors[j].front() + 1 - min_anchor_gap;
    for (std::size_t j = 0; rising && j < sources.size(); ++j) anchors[j].push_back(a.phase[j]);
  }
  if (found.empty()) align_by_pose();
  return {};
}

void Intermediate::Impl::align_by_pose() {
  constexpr int parts = 64;
  std::vector<double> a, b, d(at(m().nv()));
  anchors.assign(sources.size(), {0.0});
  for (std::size_t j = 1; j < sources.size(); ++j) {
    double minimum = 1e300;
    for (int shift = 0; shift < parts; ++shift) {
      double sum = 0;
      for (int i = 0; i < parts; ++i) {
        sample_at(sources[0], static_cast<double>(i) / parts, a);
        sample_at(sources[j], static_cast<double>(i + shift) / parts, b);
        difference(m(), a, b, d);
        for (const double x : d) sum += x * x;
      }
      if (sum < minimum - 1e-12) {
        minimum = sum;
        anchors[j] = {wrapped(static_cast<double>(shift) / parts, 1)};
      }
    }
  }
}

void Intermediate::Impl::find_limbs() {
  in_limb.assign(feet.size(), {});
  for (std::size_t k = 0; k < feet.size(); ++k) {
    in_limb[k] = feet[k].chain;
    for (int i = feet[k].link + 1; i < m().link_count(); ++i) {
      int up = i;
      while (up > feet[k].link) up = m().link(up).parent;
      if (up == feet[k].link) in_limb[k].push_back(i);
    }
  }
}

/// Progression of the mixture: distance, change of heading and duration are the weighted means of the sources. The direction of travel is
/// interpolated as an angle. If directions differ by 90 degrees or more, displacements are averaged.
/// @param frames [out] number of frames of the cycle
Progression Intermediate::Impl::mixed_progression(std::span<const double> w, int& frames, double rate) const {
  double duration = 0, way = 0, turn = 0;
  for (std::size_t j = 0; j < sources.size(); ++j) {
    duration += w[j] * sources[j].duration();
    way += w[j] * std::sqrt(sources[j].progression.vx * sources[j].progression.vx + sources[j].progression.vy * sources[j].progression.vy);
    turn += w[j] * sources[j].progression.turn;
  }
  frames = std::max(3, static_cast<int>(duration * rate + 0.5));
  const double share = frames / rate / duration;  // rounded / exact duration: the duration is rounded to whole frames, the speed is kept
  const auto speed = [](const Source& s) {
    return std::sqrt(s.progression.vx * s.progression.vx + s.progression.vy * s.progression.vy) / s.duration();
  };
  const auto fastest =
      std::max_element(sources.begin(), sources.end(), [&](const Source& a, const Source& b) { return speed(a) < speed(b); });
  const double forward = atan2(fastest->progression.vy, fastest->progression.vx);
  double side = 0;
  bool alike = true;
  Vec3 sum;
  for (std::size_t j = 0; j < sources.size(); ++j) {
    const Progression& p = sources[j].progression;
    sum += Vec3{p.vx, p.vy, 0} * w[j];
    if (speed(sources[j]) < still) continue;
    const double off = wrapped(atan2(p.vy, p.vx) - forward, 2 * pi);
    alike = alike && std::fabs(off) < pi / 2;
    side += w[j] * off;
  }
  Progression out;
  const SinCos direction = sin_cos(forward + side);
  out.vx = share * (alike ? way * direction.cos : sum.x);
  out.vy = share * (alike ? way * direction.sin : sum.y);
  out.turn = share * turn;
  const Placement& first = sources[0].progression.start;
  for (std::size_t j = 0; j < sources.size(); ++j) {
    const Placement& p = sources[j].progression.start;
    out.start.x += w[j] * p.x;
    out.start.y += w[j] * p.y;
    out.start.heading += w[j] * (first.heading + wrapped(p.heading - first.heading, 2 * pi));
  }
  return out;
}

Motion Intermediate::Impl::mix(std::span<const double> w, std::vector<FootPath>& paths) const {
  const std::size_t count = sources.size();
  const double rate = sources[at(static_cast<int>(std::max_element(w.begin(), w.end()) - w.begin()))].cycle.rate;
  int n = 0;
  const Progression way = mixed_progression(w, n, rate);
  // Maps from the common phase to the phase of each source: an anchor's common phase is the weighted mean of its phases in the sources.
  std::vector<PhaseCurve> own(count);
  std::vector<PhaseCurve::Point> points;
  for (std::size_t j = 0; j < count; ++j) {
    points.clear();
    for (std::size_t i = 0; i < anchors[j].size(); ++i) {
      double common = 0;
      for (std::size_t k = 0; k < count; ++k) common += w[k] * anchors[k][i];
      points.push_back({common, anchors[j][i]});
    }
    own[j] = PhaseCurve(points);
  }
  // Stances of each foot: common phases of touch-down and lift-off. For each source also the map from the common phase to the phase at
  // which the source's foot has completed the same share of its stance or swing.
  std::vector<std::vector<Step>> steps(feet.size());
  std::vector<std::vector<PhaseCurve>> foot_phase(feet.size(), std::vector<PhaseCurve>(count));
  for (std::size_t k = 0; k < feet.size(); ++k) {
    if (!foot_steps[k]) continue;
    const std::size_t stances = sources[0].steps[k].size();
    std::vector<std::vector<Step>> common(count);
    for (std::size_t j = 0; j < count; ++j)
      for (std::size_t i = 0; i < stances; ++i) {
        Step s = sources[j].steps[k][i];
        s = {own[j].inverse(s.on), own[j].inverse(s.off)};
        if (j > 0) {  // unwrap to the cycle of source 0
          const double rounds = std::floor(s.on - common[0][i].on + 0.5);
          s = {s.on - rounds, s.off - rounds};
        }
        common[j].push_back(s);
      }
    steps[k].assign(stances, {});
    bool fits = true;
    for (std::size_t i = 0; i < stances; ++i)
      for (std::size_t j = 0; j < count; ++j) {
        steps[k][i].on += w[j] * common[j][i].on;
        steps[k][i].off += w[j] * common[j][i].off;
      }
    for (std::size_t j = 0; j < count; ++j) {
      points.clear();
      for (std::size_t i = 0; i < stances; ++i) {
        const Step& to = common[j][i];
        const double next = i + 1 < stances ? common[j][i + 1].on : common[j][0].on + 1;
        fits = fits && to.off - to.on > min_part && next - to.off > min_part;
        points.push_back({steps[k][i].on, to.on});
        points.push_back({steps[k][i].off, to.off});
      }
      if (fits) foot_phase[k][j] = PhaseCurve(points);
    }
    if (!fits) foot_phase[k].assign(count, PhaseCurve());
  }
  Motion out;
  out.rate = rate;
  out.frames = n + 1;
  out.nq = m().nq();
  out.cyclic = true;
  out.mechanism = m().name();
  out.q.resize(at(out.frames) * at(out.nq));
  paths.assign(feet.size(), {});
  std::vector<std::vector<double>> q(count), q_foot(count);
  std::vector<double> mean(at(out.nq)), limb(mean.size());
  std::vector<Quat> turns(count);
  std::vector<Pose> X(at(m().link_count()));
  for (int f = 0; f <= n; ++f) {
    const double phase = static_cast<double>(f % n) / n, round = f == n ? 1 : 0;
    for (std::size_t j = 0; j < count; ++j) sample_at(sources[j], own[j](phase), q[j]);
    calc_mean(m(), q, w, mean);
    for (std::size_t k = 0; k < feet.size(); ++k) {
      Pose foot;
      for (std::size_t j = 0; j < count; ++j) {
        sample_at(sources[j], own[j](foot_phase[k][j](phase)), q_foot[j]);
        calc_poses(m(), q_foot[j], X);
        const Pose& X_PF = X[at(feet[k].link)];
        foot.p += X_PF.p * w[j];
        turns[j] = to_quat(X_PF.R);
      }
      foot.R = to_matrix(calc_mean(turns, w));
      calc_mean(m(), q_foot, w, limb);
      for (const int i : in_limb[k])
        std::copy_n(limb.data() + m().link(i).q_index, m().link(i).joint.nq(), mean.data() + m().link(i).q_index);
      paths[k].X_WF.push_back(to_pose(way.at(phase + round)) * foot);
      bool bears = false;
      if (foot_steps[k]) {
        for (const Step& s : steps[k]) bears = bears || phase - s.on - std::floor(phase - s.on) <= s.off - s.on + 1e-9;
      } else {
        double share = 0;
        for (std::size_t j = 0; j < count; ++j) {
          const std::vector<std::uint8_t>& on = sources[j].contacts.bears[k];
          const double own_phase = own[j](phase), frame = (own_phase - std::floor(own_phase)) * static_cast<double>(on.size() - 1);
          share += w[j] * on[static_cast<std::size_t>(frame + 0.5)];
        }
        bears = share > 0.5;
      }
      paths[k].bears.push_back(bears ? 1 : 0);
    }
    std::copy(mean.begin(), mean.end(), out.frame(f));
    displace_root(m(), way.at(phase + round), {out.frame(f), at(out.nq)});
    calc_poses(m(), std::span<const double>(out.frame(f), at(out.nq)), X);
    for (std::size_t k = 0; k < feet.size(); ++k) {
      const Pose& X_WF = X[at(feet[k].link)];
      for (const LinkPoint& p : feet[k].points)
        paths[k].points.push_back({transpose_times(X_WF.R, X[at(p.link)] * p.location.p - X_WF.p), p.location.radius});
    }
  }
  return out;
}

namespace {

std::vector<std::uint8_t> any_of_three_rounds(std::span<const std::vector<std::uint8_t>* const> feet) {
  const std::size_t n = feet.empty() ? 0 : feet.front()->size() - 1;
  std::vector<std::uint8_t> out(3 * n + 1, 0);
  for (std::size_t f = 0; f < out.size(); ++f)
    for (const std::vector<std::uint8_t>* on : feet) out[f] = out[f] || (*on)[f % n] ? 1 : 0;
  return out;
}

}  // namespace

/// Corrects the height in flight phases. A mean of heights is also a mean of accelerations, so a mixture of motions with and without flight
/// would fall too slowly. After the correction, the acceleration in flight is the mean over those sources that have flight phases.
void Intermediate::Impl::correct_flight(std::span<const double> w, Motion& mixed, const std::vector<FootPath>& paths) const {
  if (m().link(0).joint.type != JointType::floating) return;
  double wanted = 0, sum = 0;
  for (std::size_t j = 0; j < sources.size(); ++j) {
    const Source& s = sources[j];
    std::vector<const std::vector<std::uint8_t>*> feet_on;
    for (const std::vector<std::uint8_t>& on : s.contacts.bears) feet_on.push_back(&on);
    int flying = 0;
    const double fall =
        flight_acceleration(centre_heights(m(), three_rounds(s.cycle, m())), any_of_three_rounds(feet_on), s.cycle.rate, flying);
    const double share = w[j] * flying / s.cycle.rate;
    wanted += share * fall;
    sum += share;
  }
  if (!(sum > 0)) return;
  std::vector<const std::vector<std::uint8_t>*> feet_on;
  for (const FootPath& path : paths) feet_on.push_back(&path.bears);
  const std::vector<double> raise =
      raise_for_flight(centre_heights(m(), three_rounds(mixed, m())), any_of_three_rounds(feet_on), mixed.rate, wanted / sum);
  const int n = round_frames(mixed);
  for (int f = 0; f <= n; ++f) displace_root(m(), {0, 0, raise[at(n + f % n)], 0}, {mixed.frame(f), at(mixed.nq)});
}

namespace {

/// Repeats the paths of one cycle three times, each displaced from the previous one by the displacement of one cycle.
std::vector<FootPath> three_rounds_of(const std::vector<FootPath>& paths, const Placement& cycle) {
  std::vector<FootPath> out(paths.size());
  const Pose shift[3] = {to_pose(inverse(cycle)), Pose{}, to_pose(cycle)};
  for (std::size_t k = 0; k < paths.size(); ++k) {
    const FootPath& one = paths[k];
    const std::size_t n = one.X_WF.size() - 1, points = one.points.size() / one.X_WF.size();
    for (std::size_t f = 0; f <= 3 * n; ++f) {
      const std::size_t i = f % n, round = std::min<std::size_t>(f / n, 2);
      out[k].X_WF.push_back(shift[round] * one.X_WF[f == 3 * n ? n : i]);
      out[k].bears.push_back(one.bears[i]);
      out[k].points.insert(out[k].points.end(), one.points.begin() + static_cast<std::ptrdiff_t>(i * points),
                           one.points.begin() + static_cast<std::ptrdiff_t>((i + 1) * points));
    }
  }
  return out;
}

}  // namespace

Result<Intermediate> Intermediate::make(const Mechanism& mechanism, std::span<const Motion* const> sources,
                                        const IntermediateOptions& options) {
  if (sources.empty())
    return fail(ErrorCode::structure, "intermediate motion", "There is no motion to mix.", "Specify at least one motion.");
  auto impl = std::make_unique<Impl>();
  impl->mechanism = &mechanism;
  impl->options = options;
  if (options.feet.empty()) {
    impl->feet = find_foot_limbs(mechanism);
  } else {
    Result<std::vector<FootLimb>> feet = find_foot_limbs(mechanism, options.feet);
    if (!feet) return fail(std::move(feet.error()));
    impl->feet = std::move(*feet);
  }
  Error errors;
  for (const Motion* motion : sources)
    if (Result<void> added = impl->add_source(*motion); !added)
      errors.problems.insert(errors.problems.end(), added.error().problems.begin(), added.error().problems.end());
  if (!errors.empty()) return fail(std::move(errors));
  impl->find_limbs();
  if (Result<void> aligned = impl->align(); !aligned) return fail(std::move(aligned.error()));
  return Intermediate(std::move(impl));
}

Intermediate::Intermediate(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Intermediate::Intermediate(Intermediate&&) noexcept = default;
Intermediate& Intermediate::operator=(Intermediate&&) noexcept = default;
Intermediate::~Intermediate() = default;

int Intermediate::count() const { return static_cast<int>(impl_->sources.size()); }
const Motion& Intermediate::cycle(int i) const { return impl_->sources[at(i)].cycle; }
const CycleReport& Intermediate::cycle_report(int i) const { return impl_->sources[at(i)].report; }
bool Intermediate::by_contacts() const {
  return std::any_of(impl_->foot_steps.begin(), impl_->foot_steps.end(), [](bool steps) { return steps; });
}

Result<Motion> Intermediate::blend(std::span<const double> weights, FootLockReport* report) const {
  const Impl& s = *impl_;
  double sum = 0;
  bool valid = weights.size() == s.sources.size();
  for (const double w : weights) {
    valid = valid && std::isfinite(w) && w >= 0;
    sum += w;
  }
  if (!valid || !(sum > 0))
    return fail(
        ErrorCode::range, "weights of the intermediate motion",
        "The weights must be one value for each of the " + std::to_string(s.sources.size()) + " motions, none below 0 and not all 0.",
        "Use, for example, 0.5 and 0.5 for two motions.");
  std::vector<double> w(weights.begin(), weights.end());
  for (double& x : w) x /= sum;
  for (std::size_t j = 0; j < w.size(); ++j)
    if (w[j] == 1) {
      if (report) *report = s.sources[j].report.feet;
      return s.sources[j].cycle;
    }
  std::vector<FootPath> paths;
  Motion mixed = s.mix(w, paths);
  for (std::size_t j = 0; j < w.size(); ++j) {
    if (w[j] == 0) continue;
    mixed.name += (mixed.name.empty() ? "" : " + ") + s.sources[j].cycle.name;
    mixed.source += (mixed.source.empty() ? "intermediate motion: " : ", ") + std::to_string(static_cast<int>(100 * w[j] + 0.5)) + " % " +
                    s.sources[j].cycle.name;
  }
  for (std::size_t k = 0; k < s.feet.size(); ++k) mixed.contacts.push_back({s.m().link(s.feet[k].link).name, paths[k].bears});
  if (!s.options.cycle.lock_feet || s.feet.empty()) return mixed;
  s.correct_flight(w, mixed, paths);
  const Placement cycle = cycle_of(mixed, s.m());
  const FootLockOptions& o = s.options.cycle.lock;
  FootContacts contacts = labelled_contacts(s.m(), mixed, s.feet, s.options.cycle.contacts);
  FootLockReport reported;
  std::vector<FootPath> rounds = three_rounds_of(paths, cycle);
  pin_stances(rounds, mixed.rate, contacts.ground, mean_leg_length(s.feet), o);
  Motion out = middle_round(follow_paths(s.m(), three_rounds(mixed, s.m()), s.feet, rounds, o, &reported), s.m(), cycle);
  reported.before = measure_skate(s.m(), mixed, contacts);
  reported.after = measure_skate(s.m(), out, contacts);
  if (reported.miss_frame >= 0) reported.miss_frame %= round_frames(out);
  if (report) *report = reported;
  return out;
}

CycleFacts Intermediate::facts(const Motion& cycle) const {
  const Progression p = find_progression(cycle, impl_->m());
  const double duration = cycle.duration();
  return {duration, std::sqrt(p.vx * p.vx + p.vy * p.vy) / duration, p.turn,
          measure_skate(impl_->m(), cycle, labelled_contacts(impl_->m(), cycle, impl_->feet, impl_->options.cycle.contacts))};
}

Result<Motion> make_intermediate(const Mechanism& mechanism, std::span<const Motion* const> sources, std::span<const double> weights,
                                 const IntermediateOptions& options) {
  Result<Intermediate> made = Intermediate::make(mechanism, sources, options);
  if (!made) return fail(std::move(made.error()));
  return made->blend(weights);
}

}  // namespace ugoki::motion_edit
