// Rows of closed links: the humanoid with feet and hands welded to the world (6 constraint rows each), with hand welded to hand and foot to
// foot, and four-bars in series. Forward dynamics from q and v, including loop forces. MuJoCo's loops are soft, so its results differ.

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scenes.h"
#include "table.h"
#include "ugoki/dynamics/closed_system.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::benchmarks {
namespace {

void put(const Vec3& v, double* to) { to[0] = v.x, to[1] = v.y, to[2] = v.z; }
void put(const Mat3& R, double* to) {
  const Quat q = to_quat(R);
  to[0] = q.w, to[1] = q.x, to[2] = q.y, to[3] = q.z;
}

/// Closes the loops in the state s, projects the velocity of s onto the loop constraints, and measures forward dynamics.
void measure_closed(Table& table, const std::string& row, double per, const MechanismPtr& m, State s, const std::vector<Loop>& loops,
                    PlainTree tree) {
  dynamics::OpenSystemOptions options;
  options.joint_forces_on = false;
  dynamics::ClosedSystem system(m, options);
  for (const Loop& l : loops) {
    const int i = system.add_loop(l);
    if (system.close(i, s.q, s.v).status != dynamics::ClosedStatus::ok) throw std::runtime_error(row + ": the loops do not close");
  }
  (void)system.leave_out_redundant_rows(s.q);
  if (system.project(0, s.q, s.v) == dynamics::Projection::failed) throw std::runtime_error(row + ": the loops do not close");
  tree.q = s.q;
  tree.v = s.v;
  system.drive = s.tau;
  std::vector<double> vdot(s.v.size());
  if (system.calc_acceleration(0, s.q, s.v, vdot) >= 0) throw std::runtime_error(row + ": singular");
  const std::vector<double> accelerations = of_joints(*m, vdot);
  std::vector<std::function<void()>> functions{[&] { (void)system.calc_acceleration(0, s.q, s.v, vdot); }};
  std::vector<std::unique_ptr<Peer>> peers;
  const bool open = tree.loops.empty();  // an empty list of loops marks mechanisms that are too large for the peers
  for (auto make : {make_mujoco, make_simbody}) {
    auto peer = open ? nullptr : make(tree);
    if (!peer || !peer->forward()) continue;
    if (peer->name().starts_with("Simbody")) require_same(peer->joint_accelerations(), accelerations, 1e-6, row + ", " + peer->name());
    functions.push_back([p = peer.get()] { (void)p->forward(); });
    peers.push_back(std::move(peer));
  }
  const std::vector<double> ns = measure(functions);
  if (peers.empty()) table.add({.row = row, .ours_ns = ns[0], .peer = {}, .per = per});
  for (std::size_t i = 0; i < peers.size(); ++i)
    table.add({.row = row, .ours_ns = ns[0], .peer = peers[i]->name(), .peer_ns = ns[i + 1], .per = per});
}

/// Index of the link in the plain tree, in which links fixed to others are merged.
int plain_index(const Mechanism& m, int link) {
  int index = -1;
  for (int i = 0; i <= link; ++i) index += m.link(i).joint.nv() > 0 ? 1 : 0;
  return link < 0 ? -1 : index;
}

/// The link itself or its closest ancestor that has a movable joint.
int moving_link(const Mechanism& m, int link) {
  while (m.link(link).joint.nv() == 0) link = m.link(link).parent;
  return link;
}

void humanoid_loops(Table& table) {
  const MechanismPtr m = make_humanoid();
  const State s = lively_state(*m);
  dynamics::Workspace ws(*m);
  update_kinematics(*m, s.q, s.v, ws);
  // The links at the ends of the four longest chains: hands and feet.
  std::vector<std::pair<int, int>> leaves;  // (depth, link)
  for (int i = 0; i < m->link_count(); ++i) {
    bool leaf = true;
    for (const Link& l : m->links()) leaf = leaf && (l.parent < 0 || moving_link(*m, l.parent) != i || l.joint.nv() == 0);
    if (!leaf || m->link(i).joint.nv() == 0) continue;
    int depth = 0;
    for (int k = i; k >= 0; k = m->link(k).parent) depth += m->link(k).joint.nv();
    leaves.push_back({-depth, i});
  }
  std::ranges::sort(leaves);
  if (leaves.size() < 4) throw std::runtime_error("the humanoid has fewer than four limbs");
  const auto weld = [&](int a, int b) {
    Loop l{.name = "weld", .type = LoopType::weld, .link_a = a, .link_b = b};
    const Pose X_WA = a < 0 ? Pose{} : ws.X_WB[static_cast<std::size_t>(a)];
    l.X_AJ = X_WA.inverse() * ws.X_WB[static_cast<std::size_t>(b)];
    return l;
  };
  const auto run = [&](const std::string& row, const std::vector<Loop>& loops) {
    PlainTree tree = plain(*m, s);
    for (const Loop& l : loops) {
      PlainLoop p;
      p.a = plain_index(*m, l.link_a);
      p.b = plain_index(*m, l.link_b);
      const Pose back = l.X_AJ.inverse();
      put(l.X_AJ.p, p.p), put(l.X_AJ.R, p.rotation), put(back.p, p.inverse_p), put(back.R, p.inverse_rotation);
      tree.loops.push_back(p);
    }
    measure_closed(table, row, 0, m, s, loops, tree);
  };
  const int limb[4] = {leaves[0].second, leaves[1].second, leaves[2].second, leaves[3].second};
  run("humanoid, 2 contacts of 6 rows", {weld(-1, limb[0]), weld(-1, limb[1])});
  run("humanoid, 4 contacts of 6 rows", {weld(-1, limb[0]), weld(-1, limb[1]), weld(-1, limb[2]), weld(-1, limb[3])});
  run("humanoid, 2 inner loops of 6 rows", {weld(limb[0], limb[1]), weld(limb[2], limb[3])});
}
const RowRegistration register_humanoid_loops(400, humanoid_loops);

/// Four-bar linkages in a vertical plane, each mounted on the coupler of the previous one, closed at q = 0.
void four_bars(Table& table) {
  for (const int n : {1, 10, 100, 1000}) {
    MechanismSpec spec;
    PlainTree tree;
    const Vec3 crank{0.03, 0, -0.1}, coupler{0.2, 0, -0.02}, rocker{0.0, 0, -0.11};
    const Vec3 ground = crank + coupler - rocker;
    const auto bar = [&](const std::string& name, const std::string& parent, const Vec3& at, const Vec3& along) {
      LinkSpec l;
      l.name = name;
      l.parent = parent;
      l.joint.type = JointType::revolute;
      l.joint.axis = {0, 1, 0};
      l.joint.X_PJ.p = at;
      l.inertia = Inertia::from_centre(0.2, along * 0.5, {1e-3, 1e-3, 1e-3, 0, 0, 0});
      spec.links.push_back(l);
    };
    std::string base;
    for (int i = 0; i < n; ++i) {
      const std::string k = std::to_string(i);
      const Vec3 start = i == 0 ? Vec3{} : coupler * 0.5;
      bar("crank" + k, base, start, crank);
      bar("coupler" + k, "crank" + k, crank, coupler);
      bar("rocker" + k, base, start + ground, rocker);
      spec.loops.push_back({.name = "pin" + k,
                            .type = LoopType::revolute,
                            .link_a = "coupler" + k,
                            .link_b = "rocker" + k,
                            .X_AJ = {Mat3::identity(), coupler},
                            .X_BJ = {Mat3::identity(), rocker},
                            .axis = {0, 1, 0}});
      PlainLoop p;
      p.a = 3 * i + 1;
      p.b = 3 * i + 2;
      p.weld = false;
      put(coupler, p.p), put(rocker, p.inverse_p);
      tree.loops.push_back(p);
      base = "coupler" + k;
    }
    const MechanismPtr m = Mechanism::make(std::move(spec)).value();
    const State s(*m);
    const std::vector<PlainLoop> loops = tree.loops;
    tree = plain(*m, s);
    if (n <= 100) tree.loops = loops;
    measure_closed(table, std::to_string(n) + " four-bars in series", n, m, s, {}, tree);
  }
}
const RowRegistration register_four_bars(410, four_bars);

}  // namespace
}  // namespace ugoki::benchmarks
