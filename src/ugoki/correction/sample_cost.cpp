#include "ugoki/correction/sample_cost.h"

#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::correction {

SampleCost::SampleCost(const Mechanism& m)
    : m_(m), goal_(m), now_(m), q_goal_(static_cast<std::size_t>(m.nq())), error_(static_cast<std::size_t>(m.nv())) {
  std::vector<bool> parent(m.links().size());
  for (const Link& link : m.links())
    if (link.parent >= 0) parent[static_cast<std::size_t>(link.parent)] = true;
  for (std::size_t i = 0; i < parent.size(); ++i)
    if (!parent[i]) ends_.push_back(static_cast<int>(i));
}

void SampleCost::observe(std::span<const double> q, std::span<const double> v, Body& body) const {
  dynamics::update_kinematics(m_, q, v, body.ws);
  body.c = dynamics::calc_centroidal(m_, body.ws);
  body.ends = {};
  for (const int i : ends_) body.ends += body.ws.X_WB[static_cast<std::size_t>(i)].p / static_cast<double>(ends_.size());
}

void SampleCost::set_goal(std::span<const double> q, std::span<const double> v, std::span<const int> dofs) {
  q_goal_.assign(q.begin(), q.end());
  dofs_.assign(dofs.begin(), dofs.end());
  observe(q, v, goal_);
}

double SampleCost::operator()(std::span<const double> q, std::span<const double> v) {
  constexpr double ahead = 0.3;  // s: time constant of the fall of a person, as a pendulum
  observe(q, v, now_);
  difference(m_, q, q_goal_, error_);
  double joints = 0, links = 0;
  for (const int i : dofs_) joints += error_[static_cast<std::size_t>(i)] * error_[static_cast<std::size_t>(i)];
  const dynamics::Centroidal &c = now_.c, &d = goal_.c;
  for (std::size_t i = 0; i < m_.links().size(); ++i) {
    const Vec3 &p = now_.ws.X_WB[i].p, &r = goal_.ws.X_WB[i].p;
    const Vec3 place = (p - c.centre) - (r - d.centre);
    links += place.x * place.x + place.y * place.y + 2 * (p.z - r.z) * (p.z - r.z);
  }
  const double turn = norm(log_map(to_quat(goal_.ws.X_WB[0].R * now_.ws.X_WB[0].R.transposed())));
  const Vec3 place = c.centre - d.centre, velocity = c.velocity - d.velocity, spin = (c.momentum.w - d.momentum.w) / d.mass;
  const Vec3 capture = place + velocity * ahead - (now_.ends - goal_.ends);
  lost_ = turn > 1 || std::fabs(place.z) > 0.25;
  return 20 * joints / static_cast<double>(dofs_.size()) + 10 * turn * turn + 60 * links / static_cast<double>(m_.links().size()) +
         90 * place.z * place.z + 4 * (place.x * place.x + place.y * place.y) + 1.8 * dot(velocity, velocity) + 6 * dot(spin, spin) +
         30 * (capture.x * capture.x + capture.y * capture.y);
}

}  // namespace ugoki::correction
