#pragma once
// Mechanisms with known motions, and integrator options, for the tests of the integrators.

#include <cmath>

#include "random_mechanism.h"
#include "ugoki/dynamics/integrators.h"
#include "ugoki/dynamics/open_system.h"

namespace ugoki::testing {

inline constexpr dynamics::IntegrationMethod all_methods[] = {
    dynamics::IntegrationMethod::semi_implicit_euler, dynamics::IntegrationMethod::runge_kutta_4,
    dynamics::IntegrationMethod::dormand_prince_54, dynamics::IntegrationMethod::gauss_legendre_6,
    dynamics::IntegrationMethod::radau_iia_5};

/// Options for fixed steps.
inline dynamics::IntegratorOptions fixed(dynamics::IntegrationMethod method, double step) {
  dynamics::IntegratorOptions o;
  o.method = method;
  o.step = step;
  o.adaptive = false;
  o.relative_tolerance = o.absolute_tolerance = 1e-13;  // tolerance of Newton's method in the implicit methods
  return o;
}
/// Options for adaptive steps.
inline dynamics::IntegratorOptions adaptive(dynamics::IntegrationMethod method, double tolerance) {
  dynamics::IntegratorOptions o;
  o.method = method;
  o.relative_tolerance = o.absolute_tolerance = tolerance;
  return o;
}

/// A link that is a point mass at `centre` in the link's frame.
inline LinkSpec point_link(const char* name, const char* parent, JointType type, const Vec3& axis, const Vec3& centre, double mass) {
  LinkSpec l;
  l.name = name;
  l.parent = parent;
  l.joint.type = type;
  l.joint.axis = axis;
  l.inertia = Inertia::from_centre(mass, centre, {});
  return l;
}

/// A chain of point masses on massless rods that swing in the x-z plane. The first angle is measured from straight down, each further
/// angle from the rod before.
inline MechanismPtr pendulum(std::initializer_list<double> lengths) {
  MechanismSpec spec;
  spec.name = "pendulum";
  std::string parent;
  double above = 0;
  for (const double length : lengths) {
    LinkSpec l = point_link("", parent.c_str(), JointType::revolute, {0, -1, 0}, {0, 0, -length}, 1.0);
    l.name = "rod" + std::to_string(spec.links.size());
    l.joint.X_PJ.p = {0, 0, -above};
    above = length;
    parent = l.name;
    spec.links.push_back(l);
  }
  return Mechanism::make(std::move(spec)).value();
}

/// Independent masses of 1 kg on vertical prismatic joints: q is the height of each, m.
inline MechanismPtr sliders(int count, const Dof& dof = {}) {
  MechanismSpec spec;
  spec.name = "sliders";
  for (int i = 0; i < count; ++i) {
    LinkSpec l = point_link("", "", JointType::prismatic, {0, 0, 1}, {}, 1.0);
    l.name = "mass" + std::to_string(i);
    l.joint.dofs[0] = dof;
    spec.links.push_back(l);
  }
  return Mechanism::make(std::move(spec)).value();
}

}  // namespace ugoki::testing
