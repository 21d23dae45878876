#include "ugoki/control/return_motion.h"

#include <algorithm>
#include <vector>

#include "ugoki/control/balance_model.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::control {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr double rate = 100;         // Hz: frames of the computed parts
constexpr double lead = 0.1;         // s: rest in the squat before rising
constexpr double hold = 0.3;         // s: rest in standing
constexpr double start_time = 2;     // s: from standing to the full motion of the track
constexpr double tail = 0.5;         // s: part of the track behind the start, so that the filter does not change the end of the start
constexpr double rise_cutoff = 2.5;  // Hz: the postures of the plan are joined by straight lines
constexpr double start_cutoff = 8;   // Hz

/// Places a posture. @param q [nq, in and out] a posture whose root is anywhere; its height and tilt stay
void place(const Mechanism& m, const Placement& where, std::span<double> q) {
  Placement now = root_placement(m, q);
  now.z = 0;
  displace_root(m, where * inverse(now), q);
}

class Builder {
 public:
  Builder(const Mechanism& m, const ReferenceMotion& track, const GetUpPlan& plan, double floor)
      : m_(m),
        track_(track),
        plan_(plan),
        floor_(floor),
        feet_(feet_of(m)),
        q_(at(m.nq())),
        stand_(plan.way.back().q),
        X_(at(m.link_count())) {}

  [[nodiscard]] double rise_time() const {
    double time = lead + hold;
    for (std::size_t k = first() + 1; k < plan_.way.size(); ++k) time += plan_.way[k].time;
    return time;
  }

  Motion rise(const Placement& where) {
    Motion motion = empty();
    const int frames = static_cast<int>(rise_time() * rate + 0.5) + 1;
    for (int i = 0; i < frames; ++i) {
      double t = std::max(0.0, i / rate - lead);
      std::size_t k = first();
      while (k + 1 < plan_.way.size() && t > plan_.way[k + 1].time) t -= plan_.way[++k].time;
      if (k + 1 < plan_.way.size())
        interpolate(m_, plan_.way[k].q, plan_.way[k + 1].q, t / plan_.way[k + 1].time, q_);
      else
        q_ = stand_;
      // Relative to the standing posture, so that the feet stay in place.
      Placement end = root_placement(m_, stand_);
      end.z = -floor_;
      displace_root(m_, where * inverse(end), q_);
      add(motion);
    }
    return motion;
  }

  /// @param where [out] placement at the begin
  Motion start(double begin, Placement& where) {
    Motion motion = empty();
    const int grow = static_cast<int>(start_time * rate + 0.5), frames = grow + static_cast<int>(tail * rate) + 1;
    std::vector<double> v(at(m_.nv())), a(v.size()), own(q_.size());
    std::vector<Placement> recorded, placed(at(frames));
    const auto sample = [&](int i) { track_.sample(begin + i / rate, own, v, a); };
    for (int i = 0; i < frames; ++i) {
      sample(i);
      recorded.push_back(root_placement(m_, own));
      recorded.back().z = 0;
    }
    for (int i = frames - 1; i >= 0; --i) {
      if (i >= grow) {
        placed[at(i)] = recorded[at(i)];
        continue;
      }
      Placement step = inverse(recorded[at(i)]) * recorded[at(i + 1)];
      const double share = smooth_step((i + 0.5) / grow).value;
      step = {step.x * share, step.y * share, 0, step.heading * share};
      placed[at(i)] = placed[at(i + 1)] * inverse(step);
    }
    where = placed[0];
    std::vector<double> still = stand_;
    place(m_, {}, still);
    for (int i = 0; i < frames; ++i) {
      sample(i);
      place(m_, {}, own);
      const double share = smooth_step(static_cast<double>(i) / grow).value, wanted = share * (lowest(own) - floor_) + floor_;
      interpolate(m_, still, own, share, q_);
      displace_root(m_, {0, 0, wanted - lowest(q_), 0}, q_);
      place(m_, placed[at(i)], q_);
      add(motion);
    }
    return motion;
  }

 private:
  [[nodiscard]] std::size_t first() const { return at(plan_.stage_end[GetUpPlan::rock]); }
  [[nodiscard]] Motion empty() const {
    Motion motion;
    motion.rate = rate;
    motion.nq = m_.nq();
    return motion;
  }
  void add(Motion& motion) const {
    motion.q.insert(motion.q.end(), q_.begin(), q_.end());
    ++motion.frames;
  }
  double lowest(std::span<const double> q) {
    calc_poses(m_, q, X_);
    double low = 1e300;
    for (const Foot& foot : feet_)
      for (const LinkPoint& p : foot.points) low = std::min(low, (X_[at(p.link)] * p.location.p).z - p.location.radius);
    return low;
  }

  const Mechanism& m_;
  const ReferenceMotion& track_;
  const GetUpPlan& plan_;
  double floor_;
  std::vector<Foot> feet_;
  std::vector<double> q_, stand_;
  std::vector<Pose> X_;
};

}  // namespace

ReturnMotion::ReturnMotion(MechanismPtr mechanism, std::shared_ptr<const ReferenceMotion> track, const GetUpPlan& plan, double time,
                           double floor)
    : mechanism_(std::move(mechanism)), track_(std::move(track)) {
  Builder builder(*mechanism_, *track_, plan, floor);
  stands_ = std::max(time, builder.rise_time());
  begin_ = stands_ - builder.rise_time();
  joins_ = stands_ + start_time;
  Placement where;
  start_ = std::make_unique<SmoothMotion>(builder.start(stands_, where), *mechanism_, start_cutoff);
  rise_ = std::make_unique<SmoothMotion>(builder.rise(where), *mechanism_, rise_cutoff);
}

double ReturnMotion::end() const { return std::max(track_->end(), joins_ + 0.1); }

Placement ReturnMotion::placement_at(std::span<const double> q, std::span<const Foot> feet) const {
  const Mechanism& m = *mechanism_;
  std::vector<double> own(at(m.nq())), v(at(m.nv())), a(v.size());
  sample(begin_, own, v, a);
  const auto middle = [&](std::span<const double> posture) {
    std::vector<Pose> X(at(m.link_count()));
    calc_poses(m, posture, X);
    Vec3 sum;
    for (const Foot& f : feet) sum += X[at(f.link)] * f.sole / static_cast<double>(feet.size());
    return Placement{sum.x, sum.y, 0, root_placement(m, posture).heading};
  };
  return middle(q) * inverse(middle(own));
}

void ReturnMotion::sample(double t, std::span<double> q, std::span<double> v, std::span<double> a) const {
  if (t >= joins_)
    track_->sample(t, q, v, a);
  else if (t >= stands_)
    start_->sample(*mechanism_, t - stands_, q, v, a);
  else
    rise_->sample(*mechanism_, std::max(0.0, t - begin_), q, v, a);
}

}  // namespace ugoki::control
