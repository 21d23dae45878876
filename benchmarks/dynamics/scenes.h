#pragma once
// The mechanisms of the table and their states; the same numbers each time.

#include "plain_tree.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::benchmarks {

inline constexpr Vec3 gravity{0, 0, -9.81};

/// simple_humanoid: a floating base and 29 revolute joints. From its URDF file where that is at hand, otherwise built alike.
MechanismPtr make_humanoid();

/// `links` links of 0.3 m with revolute joints about x, y, z, x, ...; fixed base.
MechanismPtr make_chain(int links);

/// Joints bent, moving and driven, but for the floating base, on which nothing acts. `which` varies it.
State lively_state(const Mechanism& m, int which = 0, double speed = 1);

/// The same for peers; links that are fixed to others are merged with them. Throws where a joint is of another kind.
PlainTree plain(const Mechanism& m, const State& s);

/// Of x [nv], the numbers of the revolute joints in the order of links.
std::vector<double> of_joints(const Mechanism& m, const std::vector<double>& x);

}  // namespace ugoki::benchmarks
