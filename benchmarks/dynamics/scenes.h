#pragma once
// The mechanisms of the table and their states; deterministic.

#include "plain_tree.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::benchmarks {

inline constexpr Vec3 gravity{0, 0, -9.81};

/// simple_humanoid: a floating base and 29 revolute joints. Read from its URDF file if available, otherwise built with similar values.
MechanismPtr make_humanoid();

/// A chain of `links` links of 0.3 m with revolute joints about x, y, z, x, ... and a fixed base.
MechanismPtr make_chain(int links);

/// A state in which all joints are bent, moving and driven; no force acts on a floating base. `which` selects one of many states.
State lively_state(const Mechanism& m, int which = 0, double speed = 1);

/// Converts a mechanism and its state for peers; fixed links are merged with their parents. Throws if a joint is neither floating, revolute
/// nor fixed.
PlainTree plain(const Mechanism& m, const State& s);

/// Selects from x [nv] the values of the revolute joints, in the order of links.
std::vector<double> of_joints(const Mechanism& m, const std::vector<double>& x);

}  // namespace ugoki::benchmarks
