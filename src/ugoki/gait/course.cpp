#include "ugoki/gait/course.h"

#include <algorithm>
#include <cmath>

#include "ugoki/gait/path.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::gait {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

double fraction(double x) { return x - std::floor(x); }

/// Load of a leg over its stance: rises and falls smoothly within the share `ramp` at both ends.
double load_of(double share, double ramp) { return smooth_step(std::min(share, 1 - share) / std::max(ramp, 1e-6)); }

/// Moving average over `half` frames before and after each frame.
void smooth(std::vector<double>& x, int half) {
  if (half < 1) return;
  const int n = static_cast<int>(x.size());
  std::vector<double> sum(at(n + 1));
  for (int i = 0; i < n; ++i) sum[at(i + 1)] = sum[at(i)] + x[at(i)];
  for (int i = 0; i < n; ++i) {
    const int h = std::min({half, i, n - 1 - i});
    x[at(i)] = (sum[at(i + h + 1)] - sum[at(i - h)]) / (2 * h + 1);
  }
}

class Maker {
 public:
  Maker(const Walker& w, const GaitOptions& o) : w_(w), o_(o) {}

  Course run() {
    set_times();
    set_speeds();
    set_phases();
    set_path();
    for (std::size_t k = 0; k < w_.legs.size(); ++k) set_leg(k);
    set_ground();
    return std::move(c_);
  }

 private:
  [[nodiscard]] Pattern pattern(GaitKind kind, double speed) const {
    std::vector<LegPlace> places;
    for (const WalkerLeg& leg : w_.legs) places.push_back(leg.place);
    Pattern p = pattern_of(kind, places, w_.hip_height, speed, o_.gravity);
    if (o_.duty > 0) p.duty = o_.duty;
    if (!o_.phases.empty()) p.phases = o_.phases;
    if (o_.stride_time > 0) p.stride_time = o_.stride_time;
    p.stride_time /= o_.style.cadence;
    return p;
  }
  [[nodiscard]] double effective(double speed, double turn) const {
    double width = 0;
    for (const WalkerLeg& leg : w_.legs) width = std::max(width, norm(leg.home));
    return std::sqrt(speed * speed + turn * width * turn * width);
  }

  void set_times() {
    c_.rate = o_.rate;
    const GaitStage& s = o_.stages.front();
    double seconds = o_.seconds;
    if (o_.one_stride) {
      // The stride time is a whole number of frames, so that the motion repeats exactly.
      stride_frames_ = std::max(8, static_cast<int>(std::lround(pattern(s.kind, effective(s.speed, s.turn)).stride_time * o_.rate)));
      seconds = stride_frames_ / o_.rate;
    }
    const int n = static_cast<int>(std::lround(seconds * o_.rate));
    const int before = o_.one_stride ? 4 * stride_frames_ : static_cast<int>(3.0 * o_.rate);
    c_.first = before;
    c_.last = before + n;
    c_.frames = n + 1 + 2 * before;
    c_.body.resize(at(c_.frames));
  }

  /// m/s: maximum change of speed from a stage to the next, from the start and to the end, if a stage runs or gallops.
  [[nodiscard]] double max_change() const {
    double previous = o_.from_stand ? 0 : o_.stages.front().speed, change = 0;
    bool fast = false;
    for (const GaitStage& s : o_.stages) {
      fast = fast || kind_at(s.kind, 0) != s.kind;
      change = std::max(change, std::fabs(s.speed - previous));
      previous = s.speed;
    }
    if (o_.to_stand) change = std::max(change, std::fabs(previous));
    return fast ? change : 0;
  }

  /// The gait at a speed during starts and stops: animals trot and people walk before they gallop and run.
  [[nodiscard]] GaitKind kind_at(GaitKind kind, double speed) const {
    const double V = std::fabs(speed) / std::sqrt(o_.gravity * w_.hip_height);
    constexpr double slow_gallop = 0.9,
                     slow_run = 0.7;  // of V: an animal's usual trot; people change to a run at V^2 = 0.5 (Alexander 1989)
    if (w_.biped) return V < slow_run ? GaitKind::walk : kind;
    const bool leaps = kind == GaitKind::canter || kind == GaitKind::gallop || kind == GaitKind::rotary || kind == GaitKind::bound ||
                       kind == GaitKind::pronk;
    return leaps && V < slow_gallop ? GaitKind::trot : kind;
  }

  /// Speed, turn rate and kind in every frame.
  void set_speeds() {
    const int n = c_.frames;
    std::vector<double> speed(at(n)), turn(at(n));
    kinds_.resize(at(n));
    const double end = (c_.last - c_.first) / o_.rate;
    // Before the end the speed has to fall to zero, and the last foot has to land.
    const GaitStage& final = o_.stages.back();
    const double unit = std::sqrt(w_.hip_height / 0.9);  // Froude scaling of times
    // A change of speed takes 1.4 s for a human; in runs and gallops it takes longer where the acceleration would exceed a quarter of g. It
    // begins at the time of its stage.
    const int half = static_cast<int>(std::max(0.35 * unit, max_change() / (2 * 0.25 * o_.gravity)) * o_.rate);
    const double delay = o_.one_stride ? 0 : 2 * half / o_.rate,
                 closing = 2 * delay + 0.3 * unit + 1.4 * pattern(final.kind, 0).stride_time;
    for (int f = 0; f < n; ++f) {
      const double t = (f - c_.first) / o_.rate;
      const GaitStage* stage = &o_.stages.front();
      for (const GaitStage& s : o_.stages)
        if (s.time <= t - delay) stage = &s;
      kinds_[at(f)] = stage->kind;
      speed[at(f)] = stage->speed;
      turn[at(f)] = stage->turn;
      if (o_.one_stride) continue;
      if ((o_.from_stand && t < delay + 0.5 * unit) || (o_.to_stand && t > end - closing)) speed[at(f)] = turn[at(f)] = 0;
    }
    if (!o_.one_stride) {
      for (int pass = 0; pass < 2; ++pass) {
        smooth(speed, half);
        smooth(turn, half);
      }
    }
    const double usual = 0.12 * std::sqrt(o_.gravity * w_.hip_height);
    for (int f = 0; f < n; ++f) {
      CourseFrame& b = c_.body[at(f)];
      b.speed = speed[at(f)];
      b.turn = turn[at(f)];
      if (!o_.one_stride) kinds_[at(f)] = kind_at(kinds_[at(f)], b.speed);
      b.moving = smooth_step(effective(b.speed, b.turn) / usual);
    }
    // Share of the kind of each frame, smooth over a stride: transitions interpolate the table.
    const int mix = static_cast<int>(0.6 * pattern(final.kind, final.speed).stride_time * o_.rate);
    for (int k = 0; k < kind_count; ++k) {
      std::vector<double> share(at(n));
      for (int f = 0; f < n; ++f) share[at(f)] = kinds_[at(f)] == static_cast<GaitKind>(k) ? 1 : 0;
      if (std::ranges::max(share) > 0 && !o_.one_stride) {
        smooth(share, mix);
        smooth(share, mix);
      }
      shares_.push_back(std::move(share));
    }
  }

  [[nodiscard]] double share(GaitKind kind, int f) const { return shares_[static_cast<std::size_t>(kind)][at(f)]; }

  /// Phase clock, and the phase of each leg.
  void set_phases() {
    const int n = c_.frames;
    const std::size_t legs = w_.legs.size();
    duty_.resize(at(n));
    ramp_.resize(at(n));
    phases_.assign(legs, std::vector<double>(at(n)));
    frozen_.assign(at(n), 0);
    std::vector<double> offsets(legs);
    double clock = 0;
    bool clock_set = false;
    // Frames in which the body stands; the clock goes on until every foot has stepped to its place.
    double stopped_at = -1;
    std::vector<std::vector<double>> offset_of(at(n));
    for (int f = 0; f < n; ++f) {
      CourseFrame& b = c_.body[at(f)];
      const double speed = effective(b.speed, b.turn);
      double duty = 0, time = 0;
      std::fill(offsets.begin(), offsets.end(), 0.0);
      std::vector<double> first;
      for (int k = 0; k < kind_count; ++k) {
        const double s = shares_[at(k)][at(f)];
        if (s <= 0) continue;
        const Pattern p = pattern(static_cast<GaitKind>(k), speed);
        if (first.empty()) first = p.phases;
        duty += s * p.duty;
        time += s * p.stride_time;
        for (std::size_t i = 0; i < legs; ++i) {
          double d = p.phases[i] - first[i];  // along the shorter way around the circle
          d -= std::floor(d + 0.5);
          offsets[i] += s * (first[i] + d);
        }
      }
      duty_[at(f)] = duty;
      b.stride_time = o_.one_stride ? stride_frames_ / o_.rate : time;
      b.run = w_.biped ? share(GaitKind::run, f) : 0;
      b.spring = w_.legs.size() == 4
                     ? share(GaitKind::canter, f) + share(GaitKind::gallop, f) + share(GaitKind::rotary, f) + share(GaitKind::bound, f)
                     : 0;
      // Two legs walk: the load moves in double support.
      const double transfer = std::max(0.0, (2 * duty - 1) / (2 * duty));
      ramp_[at(f)] = b.ramp = w_.biped ? transfer + (flight_ramp - transfer) * b.run : 0.5;
      const auto all_stand = [&](double c) {
        for (std::size_t i = 0; i < legs; ++i)
          if (fraction(c - offsets[i]) > duty - 0.02) return false;
        return true;
      };
      if (!clock_set) {
        clock_set = true;
        clock = start_phase(offsets, duty);
        if (!o_.one_stride && b.moving <= 0) stopped_at = clock - 2;
      }
      const bool stands = b.moving <= 1e-3 && !o_.one_stride;
      if (!stands) stopped_at = -1;
      if (stands && stopped_at < 0) stopped_at = clock;
      // All feet have landed at least 0.5 duty before the middle of their stance if the clock has gone on for this share of a stride.
      const bool ready = stands && clock - stopped_at >= 1 + 0.5 * duty;
      const bool freeze = ready && (all_stand(clock) || duty < 0.5);
      frozen_[at(f)] = freeze ? 1 : 0;
      for (std::size_t i = 0; i < legs; ++i) phases_[i][at(f)] = clock - offsets[i];
      if (!freeze) clock += 1 / (b.stride_time * o_.rate);
    }
  }

  /// Clock at which all feet stand, in the middle of the longest such interval.
  [[nodiscard]] static double start_phase(const std::vector<double>& offsets, double duty) {
    double best = 0, max_margin = -1;
    for (int i = 0; i < 200; ++i) {
      const double c = i / 200.0;
      double margin = 1;
      for (const double o : offsets) {
        const double s = fraction(c - o);
        margin = std::min({margin, duty - s, s});
      }
      if (margin > max_margin) {
        max_margin = margin;
        best = c;
      }
    }
    return best;
  }

  /// Positions of the body. The motion begins at the origin in frame `first`.
  void set_path() {
    const int n = c_.frames;
    if (o_.path.size() > 1) {
      const SmoothPath path(o_.path);
      double s = 0;
      for (int f = c_.first; f < n; ++f) {
        place_on(path, s, c_.body[at(f)]);
        s += c_.body[at(f)].speed / o_.rate;
      }
      s = 0;
      for (int f = c_.first; f-- > 0;) {
        s -= c_.body[at(f)].speed / o_.rate;
        place_on(path, s, c_.body[at(f)]);
      }
      for (int f = 0; f < n; ++f) {
        const CourseFrame &a = c_.body[at(std::max(0, f - 1))], &b = c_.body[at(std::min(n - 1, f + 1))];
        c_.body[at(f)].turn = (b.heading - a.heading) * o_.rate / std::max(1, std::min(n - 1, f + 1) - std::max(0, f - 1));
      }
      return;
    }
    const auto advance = [&](const CourseFrame& from, CourseFrame& to, double dt, double speed, double turn) {
      const double middle = from.heading + 0.5 * turn * dt;
      to.x = from.x + speed * dt * cos(middle);
      to.y = from.y + speed * dt * sin(middle);
      to.heading = from.heading + turn * dt;
    };
    CourseFrame& start = c_.body[at(c_.first)];
    start.x = start.y = start.heading = 0;
    for (int f = c_.first; f + 1 < n; ++f) {
      const CourseFrame& b = c_.body[at(f)];
      advance(b, c_.body[at(f + 1)], 1 / o_.rate, b.speed, b.turn);
    }
    for (int f = c_.first; f > 0; --f) {
      const CourseFrame& b = c_.body[at(f - 1)];
      advance(c_.body[at(f)], c_.body[at(f - 1)], -1 / o_.rate, b.speed, b.turn);
    }
  }

  void place_on(const SmoothPath& path, double s, CourseFrame& b) const {
    const SmoothPath::Point p = path.at(s);
    b.x = p.x;
    b.y = p.y;
    b.heading = p.heading;
  }

  [[nodiscard]] CourseFrame body_at(double frame) const {
    const double f = std::clamp(frame, 0.0, c_.frames - 1.0);
    const int i = std::min(static_cast<int>(f), c_.frames - 2);
    const double s = f - i;
    const CourseFrame &a = c_.body[at(i)], &b = c_.body[at(i + 1)];
    CourseFrame out = a;
    out.x += s * (b.x - a.x);
    out.y += s * (b.y - a.y);
    out.heading += s * (b.heading - a.heading);
    out.moving += s * (b.moving - a.moving);
    out.run += s * (b.run - a.run);
    return out;
  }

  /// Stances, places of the foot, and its state in every frame.
  void set_leg(std::size_t k) {
    const std::vector<double>& phase = phases_[k];
    const int n = c_.frames;
    std::vector<LegFrame> frames(at(n));
    std::vector<Stance> stances;
    const auto stands = [&](int f) { return fraction(phase[at(f)]) < duty_[at(f)]; };
    /// Frame at which phase - level crosses zero between f - 1 and f.
    const auto crossing = [&](int f, double before, double after) { return f - 1 + std::clamp(before / (before - after), 0.0, 1.0); };
    for (int f = 0; f < n; ++f) {
      LegFrame& leg = frames[at(f)];
      leg.stands = stands(f);
      leg.duty = duty_[at(f)];
      const double own = fraction(phase[at(f)]);
      leg.share = std::clamp(leg.stands ? own / leg.duty : (own - leg.duty) / (1 - leg.duty), 0.0, 1.0);
      leg.load = leg.stands ? std::max(1e-3, load_of(leg.share, ramp_[at(f)])) : 0;
      leg.length = (leg.stands ? leg.duty : 1 - leg.duty) * c_.body[at(f)].stride_time;
      if (f == 0 || (leg.stands && !stands(f - 1))) {
        Stance s;
        s.begin = f == 0 ? -1 : crossing(f, phase[at(f - 1)] - std::floor(phase[at(f)]), own);
        stances.push_back(s);
      }
      if (f > 0 && !leg.stands && stands(f - 1))
        stances.back().end = crossing(f, fraction(phase[at(f - 1)]) - duty_[at(f - 1)], own - leg.duty);
      leg.stance = static_cast<int>(stances.size()) - 1;
    }
    if (frames.back().stands) stances.back().end = n + 1;
    for (int i = 0; i < static_cast<int>(stances.size()); ++i) place_foot(k, frames, stances[at(i)], i, phase);
    c_.legs.push_back(std::move(frames));
    c_.stances.push_back(std::move(stances));
  }

  void place_foot(std::size_t k, const std::vector<LegFrame>& frames, Stance& s, int index, const std::vector<double>& phase) const {
    const WalkerLeg& leg = w_.legs[k];
    // The body is over the foot in the middle of the stance; if the body stands in the stance, where it stands.
    double middle = -1;
    int still = 0;
    double still_sum = 0;
    const int from = std::max(0, static_cast<int>(std::ceil(s.begin))), to = std::min(c_.frames - 1, static_cast<int>(s.end));
    for (int f = from; f <= to; ++f) {
      if (frames[at(f)].stance != index) continue;
      if (frozen_[at(f)]) {
        ++still;
        still_sum += f;
      }
      const double own = fraction(phase[at(f)]) - 0.5 * frames[at(f)].duty;
      if (middle < 0 && own >= 0) {
        const double previous = f > from ? fraction(phase[at(f - 1)]) - 0.5 * frames[at(f - 1)].duty : own;
        middle = f > from && own > previous ? f - own / (own - previous) : f;
      }
    }
    if (still > 0) middle = still_sum / still;
    if (middle < 0) middle = 0.5 * (from + to);
    const CourseFrame b = body_at(middle);
    Vec3 home = leg.home;
    double toe_out = 0;
    if (w_.biped) {
      // The feet are closer together in fast gaits than while standing.
      const double walk = 0.62 - 0.3 * b.run;
      home.y = leg.hip_side * (1.15 + (walk - 1.15) * b.moving) * o_.style.width;
      toe_out = (leg.place.left ? 1 : -1) * (6 - 3 * b.run) * pi / 180;
    } else {
      home.y *= o_.style.width * (1 - 0.12 * b.moving);
      // Four legs swing about a place that is halfway below their hips, so that they reach as far ahead as behind.
      if (w_.legs.size() == 4) home.x += 0.5 * b.moving * (leg.hip_ahead - home.x);
    }
    const SinCos h = sin_cos(b.heading);
    s.place = {b.x + h.cos * home.x - h.sin * home.y, b.y + h.sin * home.x + h.cos * home.y, 0};
    s.heading = b.heading + toe_out;
    s.place.z = ground_at(o_, s.place.x, s.place.y);
    if (o_.ground) {
      constexpr double e = 0.05;
      const auto g = [&](double dx, double dy) { return ground_at(o_, s.place.x + dx, s.place.y + dy); };
      const Vec3 n{-(g(e, 0) - g(-e, 0)) / (2 * e), -(g(0, e) - g(0, -e)) / (2 * e), 1};
      s.normal = norm(n) < 1.6 ? normalized(n) : Vec3{0, 0, 1};  // an edge is no slope
    }
  }

  /// Smoothed height of the ground that the standing feet have: the body follows it.
  void set_ground() {
    if (!o_.ground) return;
    const int n = c_.frames;
    std::vector<double> height(at(n));
    for (int f = 0; f < n; ++f) {
      double sum = 0, weight = 0;
      for (std::size_t k = 0; k < w_.legs.size(); ++k) {
        const LegFrame& leg = c_.legs[k][at(f)];
        sum += leg.load * c_.stances[k][at(leg.stance)].place.z;
        weight += leg.load;
      }
      height[at(f)] = weight > 0 ? sum / weight : (f > 0 ? height[at(f - 1)] : 0);
    }
    const int half = static_cast<int>(0.35 * c_.body[at(c_.first)].stride_time * o_.rate);
    for (int pass = 0; pass < 3; ++pass) smooth(height, half);
    for (int f = 0; f < n; ++f) {
      CourseFrame& b = c_.body[at(f)];
      b.ground = height[at(f)];
      const double ahead = std::max(0.3, 0.5 * w_.hip_height);
      const SinCos h = sin_cos(b.heading);
      b.slope =
          (ground_at(o_, b.x + ahead * h.cos, b.y + ahead * h.sin) - ground_at(o_, b.x - ahead * h.cos, b.y - ahead * h.sin)) / (2 * ahead);
    }
    std::vector<double> slope(at(n));
    for (int f = 0; f < n; ++f) slope[at(f)] = c_.body[at(f)].slope;
    for (int pass = 0; pass < 2; ++pass) smooth(slope, half);
    for (int f = 0; f < n; ++f) c_.body[at(f)].slope = slope[at(f)];
  }

  const Walker& w_;
  const GaitOptions& o_;
  Course c_;
  int stride_frames_ = 0;
  std::vector<GaitKind> kinds_;
  std::vector<std::vector<double>> shares_;  // [kinds][frames]
  std::vector<std::vector<double>> phases_;  // [legs][frames]
  std::vector<double> duty_, ramp_;          // [frames]
  std::vector<std::uint8_t> frozen_;         // [frames] 1: the clock stands
};

}  // namespace

double smooth_step(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10 + s * (-15 + 6 * s));
}

double ground_at(const GaitOptions& options, double x, double y) { return options.ground ? options.ground(x, y) : 0; }

Course make_course(const Walker& walker, const GaitOptions& options) { return Maker(walker, options).run(); }

}  // namespace ugoki::gait
