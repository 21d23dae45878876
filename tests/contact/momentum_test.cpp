// Conservation of momentum and energy in collisions, to rounding, including nearly singular loops and very unequal masses.

#include <gtest/gtest.h>

#include <cmath>

#include "party.h"

namespace ugoki::contact {
namespace {

/// Kinds of random systems; each is a different numerical difficulty.
enum class Kind { open, plain, many_loops, unequal, flat, doubled };

void make_unequal(RandomSource& random, MechanismSpec& spec) {
  for (LinkSpec& l : spec.links) {
    const double part = std::pow(10.0, random.uniform(-2, 2));
    l.inertia = {l.inertia.mass * part, l.inertia.h * part, l.inertia.I * part};
  }
}

/// A free ring of links with parallel joint axes, 1e-7 to 0.1 rad away from a change point (a position in which all joints are on a line).
std::vector<Loop> make_flat_ring(RandomSource& random, MechanismPtr& m, State& state) {
  const int count = 4 + random.below(3);
  const double flat = std::pow(10.0, random.uniform(-7, -1));
  MechanismSpec spec;
  spec.name = "ring";
  for (int i = 0; i < count; ++i) {
    LinkSpec l;
    l.name = "link" + std::to_string(i);
    if (i > 0) l.parent = "link" + std::to_string(i - 1);
    l.joint.type = i == 0 ? JointType::floating : JointType::revolute;
    l.joint.axis = {0, 0, 1};
    if (i > 0) l.joint.X_PJ.p = {random.uniform(0.2, 0.5), 0, 0};
    l.inertia = testing::random_inertia(random);
    spec.links.push_back(std::move(l));
  }
  m = *Mechanism::make(std::move(spec));
  state = State(*m);
  testing::randomize(random, *m, state);
  constexpr double half_turn = 3.14159265358979;
  for (std::size_t k = 7; k < state.q.size(); ++k) state.q[k] = half_turn * random.below(2) + flat * random.uniform(-1, 1);
  dynamics::Workspace ws(*m);
  dynamics::update_kinematics(*m, state.q, state.v, ws);
  Loop l{.type = LoopType::revolute, .link_a = 0, .link_b = count - 1};
  l.axis = {0, 0, 1};
  l.X_BJ.p = {0.3, 0, 0};
  l.X_AJ = ws.X_WB[0].inverse() * ws.X_WB[static_cast<std::size_t>(count - 1)] * l.X_BJ;
  return {l};
}

void add_system(Party& party, RandomSource& random, unsigned seed, Kind kind) {
  if (kind == Kind::open) {
    MechanismSpec spec = testing::without_armature(testing::random_spec(random, 1 + random.below(9)));
    if (random.below(2) == 0) make_unequal(random, spec);
    const MechanismPtr m = *Mechanism::make(std::move(spec));
    State s(*m);
    testing::randomize(random, *m, s);
    party.add(m, s);
    return;
  }
  testing::RandomLoops r(seed);
  std::vector<Loop> some;
  if (kind == Kind::flat) {
    some = make_flat_ring(random, r.m, r.state);
  } else if (kind == Kind::doubled) {
    testing::DoubledJoints joints(random, true, 1);
    if (random.below(2) == 0) make_unequal(random, joints.doubled);
    r.m = *Mechanism::make(testing::without_armature(std::move(joints.doubled)));
    r.state = State(*r.m);
    testing::randomize(random, *r.m, r.state);
    some.assign(r.m->loops().begin(), r.m->loops().end());
  } else {
    MechanismSpec spec = testing::without_armature(r.m->spec());  // the momentum of the links does not include that of armatures
    if (kind == Kind::unequal) make_unequal(random, spec);
    r.m = *Mechanism::make(std::move(spec));
    const std::size_t every = kind == Kind::many_loops ? 1 : 3;
    for (std::size_t i = seed % every; i < r.loops.size(); i += every)
      if (r.loops[i].link_a >= 0 && (r.loops[i].type != LoopType::gear || r.loops[i].dof_b >= 6))
        some.push_back(r.loops[i]);  // keep only loops that are not attached to the world
  }
  const std::vector<char> shut(some.size(), 1);
  auto links = std::make_unique<dynamics::ClosedLinks>(*r.m, some, shut);
  dynamics::Workspace ws(*r.m);
  dynamics::update_kinematics(*r.m, r.state.q, r.state.v, ws);
  EXPECT_EQ(dynamics::factor_closed_links(*r.m, ws, *links, r.state.q, r.state.v), dynamics::ClosedStatus::ok);
  dynamics::share_virtual_inertias(*links, ws);
  dynamics::ClosedImpulse().project(*r.m, ws, *links, r.state.v);
  party.add(r.m, r.state, std::move(links));
}

struct Errors {
  double momentum = 0, energy = 0, approach = 0;
};

/// Kinetic energy [J], summed link by link, because v^T M v has larger rounding errors for very unequal masses.
double energy_of(Party& party) {
  party.update();
  double sum = 0;
  for (std::size_t s = 0; s < party.mechanisms.size(); ++s) sum += dynamics::kinetic_energy(*party.mechanisms[s], *party.workspaces[s]);
  return sum;
}

Errors collide(unsigned seed, Kind kind_a, Kind kind_b, double e) {
  RandomSource random(seed);
  Party party;
  add_system(party, random, 2 * seed, kind_a);
  add_system(party, random, 2 * seed + 1, kind_b);
  party.update();
  std::vector<ContactPoint> contacts;
  for (int i = random.below(6); i >= 0; --i)
    contacts.push_back(between(0, random.below(party.mechanisms[0]->link_count()), 1, random.below(party.mechanisms[1]->link_count()),
                               random.vec(1), random.direction(), e));
  const double energy = energy_of(party);
  const Vec6 momentum = party.momentum();
  const ImpactReport report = party.collide(contacts, {0, 0, e == 0});
  EXPECT_NE(report.status, ImpactStatus::singular)
      << "seed " << seed;  // `unfinished` is accepted: a light system between heavy ones may need too many collisions
  const Vec6 change = party.momentum() - momentum;
  Errors out;
  out.momentum = (norm(change.v) + norm(change.w)) / (1 + norm(momentum.v) + norm(momentum.w) + energy);
  out.energy = (energy_of(party) - energy) / energy;
  for (const ContactPoint& c : contacts) out.approach = std::max(out.approach, party.approach(c) / (1 + std::sqrt(energy)));
  return out;
}

constexpr Kind pairs[][2] = {{Kind::open, Kind::open},       {Kind::plain, Kind::plain},   {Kind::many_loops, Kind::many_loops},
                             {Kind::unequal, Kind::unequal}, {Kind::flat, Kind::flat},     {Kind::open, Kind::many_loops},
                             {Kind::flat, Kind::open},       {Kind::doubled, Kind::plain}, {Kind::doubled, Kind::doubled}};

void keep_momentum_and_energy(unsigned seeds) {
  for (const auto& [a, b] : pairs) {
    Errors worst;
    for (unsigned seed = 0; seed < seeds; ++seed) {
      const Errors x = collide(seed, a, b, 1);
      worst.momentum = std::max(worst.momentum, x.momentum);
      worst.energy = std::max(worst.energy, std::fabs(x.energy));
    }
    EXPECT_LT(worst.momentum, 1e-12) << "kinds " << static_cast<int>(a) << " " << static_cast<int>(b);
    EXPECT_LT(worst.energy, 4e-13) << "kinds " << static_cast<int>(a) << " " << static_cast<int>(b);
  }
}
TEST(Momentum, ElasticCollisionsConserveMomentumToRounding) { keep_momentum_and_energy(300); }
TEST(Slow_Momentum, ElasticCollisionsConserveMomentumToRounding) { keep_momentum_and_energy(4000); }

TEST(Momentum, PlasticCollisionsConserveMomentumAndEndWithoutApproach) {
  for (const auto& [a, b] : pairs)
    for (unsigned seed = 10000; seed < 10200; ++seed) {
      const Errors x = collide(seed, a, b, 0);
      EXPECT_LT(x.momentum, 1e-12) << "kinds " << static_cast<int>(a) << " " << static_cast<int>(b) << " seed " << seed;
      EXPECT_LT(x.energy, 1e-12) << "kinds " << static_cast<int>(a) << " " << static_cast<int>(b) << " seed " << seed;
      EXPECT_LT(x.approach, 1e-12) << "kinds " << static_cast<int>(a) << " " << static_cast<int>(b) << " seed " << seed;
    }
}

}  // namespace
}  // namespace ugoki::contact
