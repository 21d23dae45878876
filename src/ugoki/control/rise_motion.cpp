#include "ugoki/control/rise_motion.h"

#include <algorithm>

#include "ugoki/mechanism/state.h"

namespace ugoki::control {
namespace {

Motion rise(const Mechanism& m, const GetUpPlan& plan) {
  Motion motion;
  motion.rate = 100;
  motion.nq = m.nq();
  const auto first = static_cast<std::size_t>(plan.stage_end[GetUpPlan::rock]);
  std::vector<double> q(static_cast<std::size_t>(m.nq()));
  double time = 0;
  for (std::size_t k = first + 1; k < plan.way.size(); ++k) time += plan.way[k].time;
  const double hold = 1, lead = 0.15;
  motion.frames = static_cast<int>((lead + time + hold) * motion.rate) + 1;
  for (int i = 0; i < motion.frames; ++i) {
    double t = std::max(0.0, i / motion.rate - lead);
    std::size_t k = first;
    while (k + 1 < plan.way.size() && t > plan.way[k + 1].time) t -= plan.way[++k].time;
    if (k + 1 < plan.way.size())
      interpolate(m, plan.way[k].q, plan.way[k + 1].q, t / plan.way[k + 1].time, q);
    else
      q = plan.way.back().q;
    motion.q.insert(motion.q.end(), q.begin(), q.end());
  }
  return motion;
}

}  // namespace

RiseMotion::RiseMotion(MechanismPtr mechanism, const GetUpPlan& plan)
    : mechanism_(std::move(mechanism)), motion_(rise(*mechanism_, plan), *mechanism_, 2.5) {}

}  // namespace ugoki::control
