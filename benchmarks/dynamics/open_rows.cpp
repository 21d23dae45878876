// Rows of open links, one instance per call: the humanoid and chains. All times, of Ugoki and of the peers, include kinematics from q and
// v.

#include "scenes.h"
#include "table.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::benchmarks {
namespace {

using Peers = std::vector<std::unique_ptr<Peer>>;

Peers peers_of(const PlainTree& tree, int max_links_of_mujoco) {
  Peers all;
  if (static_cast<int>(tree.links.size()) <= max_links_of_mujoco) all.push_back(make_mujoco(tree));
  if (tree.links.size() <= 3000) all.push_back(make_bullet(tree));
  if (tree.links.size() <= 300) all.push_back(make_dart(tree));
  if (tree.links.size() <= 300) all.push_back(make_simbody(tree));
  std::erase(all, nullptr);
  return all;
}

/// Measures our time and that of each peer that supports `task`, after comparing the results.
void compare(Table& table, const std::string& row, double per, const std::function<void()>& ours, const Peers& peers, bool (Peer::*task)(),
             const std::function<void(Peer&)>& check) {
  std::vector<std::function<void()>> functions{ours};
  std::vector<std::string> names;
  for (const auto& peer : peers) {
    Peer* const p = peer.get();
    (void)p->forward();  // sets the accelerations that inverse() uses
    if (!(p->*task)()) continue;
    check(*p);
    names.push_back(p->name());
    functions.push_back([p, task] { (void)(p->*task)(); });
  }
  const std::vector<double> ns = measure(functions);
  if (names.empty()) table.add({.row = row, .ours_ns = ns[0], .peer = {}, .per = per});
  for (std::size_t i = 0; i < names.size(); ++i)
    table.add({.row = row, .ours_ns = ns[0], .peer = names[i], .peer_ns = ns[i + 1], .per = per});
}

void humanoid(Table& table) {
  const MechanismPtr m = make_humanoid();
  const State s = lively_state(*m);
  dynamics::Workspace ws(*m);
  std::vector<double> vdot(s.v.size()), tau(s.v.size());
  if (!dynamics::calc_forward_dynamics(*m, ws, s.q, s.v, s.tau, gravity, {}, vdot)) throw std::runtime_error("the humanoid is singular");
  const std::vector<double> accelerations = of_joints(*m, vdot), torques = of_joints(*m, s.tau);
  const Peers peers = peers_of(plain(*m, s), 1000);
  for (const auto& p : peers)
    if (p->forward()) require_same(p->joint_accelerations(), accelerations, 1e-8, "humanoid forward, " + p->name());
  compare(
      table, "humanoid inverse", 0, [&] { dynamics::calc_inverse_dynamics(*m, ws, s.q, s.v, vdot, gravity, {}, tau); }, peers,
      &Peer::inverse, [&](Peer& p) { require_same(p.joint_torques(), torques, 1e-8, "humanoid inverse, " + p.name()); });
  require_same(tau, s.tau, 1e-9, "humanoid, inverse of forward");
  compare(table, "humanoid inertia matrix", 0, [&] { dynamics::calc_inertia_rows(*m, ws, s.q); }, peers, &Peer::inertia, [](Peer&) {});
  compare(
      table, "humanoid forward", 0, [&] { (void)dynamics::calc_forward_dynamics(*m, ws, s.q, s.v, s.tau, gravity, {}, vdot); }, peers,
      &Peer::forward, [&](Peer& p) { require_same(p.joint_accelerations(), accelerations, 1e-8, "humanoid forward, " + p.name()); });
}
const RowRegistration register_humanoid(100, humanoid);

void chains(Table& table) {
  for (const int links : {10, 30, 100, 300, 1000, 3000, 10000}) {
    const std::string row = "chain " + std::to_string(links) + " forward";
    const MechanismPtr m = make_chain(links);
    const State s = lively_state(*m, 0, links <= 100 ? 0.1 : 0.0);
    dynamics::Workspace ws(*m);
    std::vector<double> vdot(s.v.size()), tau(s.v.size());
    if (!dynamics::calc_forward_dynamics(*m, ws, s.q, s.v, s.tau, gravity, {}, vdot)) throw std::runtime_error(row + " is singular");
    const std::vector<double> accelerations = of_joints(*m, vdot);
    compare(
        table, row, links, [&] { (void)dynamics::calc_forward_dynamics(*m, ws, s.q, s.v, s.tau, gravity, {}, vdot); },
        peers_of(plain(*m, s), 300), &Peer::forward,
        [&](Peer& p) { require_same(p.joint_accelerations(), accelerations, 1e-8, row + ", " + p.name()); });
  }
}
const RowRegistration register_chains(200, chains);

}  // namespace
}  // namespace ugoki::benchmarks
