#pragma once
// Colliding systems for the tests of the paper's impulse: built by hand, or random trees and loops.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "../dynamics/random_loops.h"
#include "ugoki/contact/collision_impulse.h"
#include "world.h"

namespace ugoki::contact {

using collision::ContactPoint;
using testing::RandomSource;

/// Systems with their states, prepared for CollisionImpulse.
struct Party {
  std::vector<MechanismPtr> mechanisms;
  std::vector<State> states;
  std::vector<std::unique_ptr<dynamics::Workspace>> workspaces;
  std::vector<std::unique_ptr<dynamics::ClosedLinks>> loops;
  std::vector<LinkSystem> systems;
  CollisionImpulse impulse;

  void add(const MechanismPtr& m, State s, std::unique_ptr<dynamics::ClosedLinks> closed = nullptr) {
    mechanisms.push_back(m);
    states.push_back(std::move(s));
    workspaces.push_back(std::make_unique<dynamics::Workspace>(*m));
    loops.push_back(std::move(closed));
  }
  void update() {
    systems.clear();
    for (std::size_t i = 0; i < mechanisms.size(); ++i) {
      dynamics::update_kinematics(*mechanisms[i], states[i].q, states[i].v, *workspaces[i]);
      systems.push_back({mechanisms[i].get(), workspaces[i].get(), loops[i].get(), states[i].q, states[i].v});
    }
  }
  ImpactReport collide(std::span<const ContactPoint> contacts, const ImpactOptions& options = {}) {
    update();
    const ImpactReport report = impulse.collide(systems, contacts, options);
    update();
    return report;
  }
  double energy() {  // J: v^T M v / 2, including armatures
    update();
    double sum = 0;
    for (std::size_t i = 0; i < mechanisms.size(); ++i) {
      const auto n = states[i].v.size();
      std::vector<double> M(n * n);
      if (loops[i]) dynamics::share_virtual_inertias(*loops[i], *workspaces[i]);
      dynamics::calc_inertia_matrix(*mechanisms[i], *workspaces[i], M);
      for (std::size_t r = 0; r < n; ++r)
        for (std::size_t c = 0; c < n; ++c) sum += 0.5 * states[i].v[r] * M[r * n + c] * states[i].v[c];
    }
    return sum;
  }
  Vec6 momentum() {
    update();
    Vec6 sum;
    for (std::size_t i = 0; i < mechanisms.size(); ++i) sum += dynamics::momentum(*mechanisms[i], *workspaces[i]);
    return sum;
  }
  double approach(const ContactPoint& c) const {
    double u = 0;
    if (c.system_a >= 0) u += dot(c.n, dynamics::point_velocity(*workspaces[static_cast<std::size_t>(c.system_a)], c.link_a, c.p));
    if (c.system_b >= 0) u -= dot(c.n, dynamics::point_velocity(*workspaces[static_cast<std::size_t>(c.system_b)], c.link_b, c.p));
    return -u;
  }
};

inline ContactPoint between(int a, int link_a, int b, int link_b, const Vec3& p, const Vec3& n, double e) {
  ContactPoint c;
  c.system_a = a;
  c.link_a = link_a;
  c.system_b = b;
  c.link_b = link_b;
  c.p = p;
  c.n = n;
  c.restitution = e;
  return c;
}

/// Random trees, closed systems and free bodies that touch at random points.
struct RandomParty : Party {
  std::vector<ContactPoint> contacts;

  RandomParty(RandomSource& random, unsigned seed, int kind, double e, bool grounded, int touching, bool one_loop = false) {
    for (int side = 0; side < 2; ++side) {
      const bool closed = kind == 2 || (kind == 1 && side == 0);
      if (closed) {
        testing::RandomLoops r(seed + static_cast<unsigned>(side) * 1000);
        r.m = *Mechanism::make(testing::without_armature(r.m->spec()));  // the momentum of the links does not include that of armatures
        std::vector<Loop> some;
        if (one_loop) some.push_back(r.loops[seed % r.loops.size()]);
        for (std::size_t i = 0; i < r.loops.size() && !one_loop; i += 3)
          if (r.loops[i].link_a >= 0) some.push_back(r.loops[i]);
        if (some.empty()) some.push_back(r.loops[0]);
        const std::vector<char> shut(some.size(), 1);
        auto links = std::make_unique<dynamics::ClosedLinks>(*r.m, some, shut);
        dynamics::Workspace ws(*r.m);
        dynamics::update_kinematics(*r.m, r.state.q, r.state.v, ws);
        EXPECT_EQ(dynamics::factor_closed_links(*r.m, ws, *links, r.state.q, r.state.v), dynamics::ClosedStatus::ok);
        dynamics::project_velocity(*r.m, ws, *links, r.state.v);
        dynamics::update_kinematics(*r.m, r.state.q, r.state.v, ws);
        EXPECT_EQ(dynamics::factor_closed_links(*r.m, ws, *links, r.state.q, r.state.v), dynamics::ClosedStatus::ok);
        dynamics::project_velocity(*r.m, ws, *links, r.state.v);
        add(r.m, r.state, std::move(links));
      } else {
        const MechanismPtr m = *Mechanism::make(testing::without_armature(testing::random_spec(random, 1 + random.below(9))));
        State s(*m);
        testing::randomize(random, *m, s);
        add(m, s);
      }
    }
    update();
    for (int i = 0; i < touching; ++i) {
      const bool ground = grounded && random.below(3) == 0;
      const int link_a = random.below(mechanisms[0]->link_count()), link_b = random.below(mechanisms[1]->link_count());
      contacts.push_back(between(0, link_a, ground ? -1 : 1, ground ? -1 : link_b, random.vec(1), random.direction(), e));
    }
  }
};

}  // namespace ugoki::contact
