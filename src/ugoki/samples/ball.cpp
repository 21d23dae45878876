#include "ugoki/base/check.h"
#include "ugoki/samples/samples.h"

namespace ugoki::samples {

MechanismPtr make_ball() {
  constexpr double radius = 0.11, mass = 0.35;
  LinkSpec link;
  link.name = "Ball";
  link.label = "ball";
  link.joint.type = JointType::floating;
  for (std::size_t k = 0; k < 3; ++k) link.joint.dofs[k].damping = 0.0015;  // N m s/rad: rolling resistance of grass
  Shape shape = Shape::sphere(radius);
  shape.friction = 0.7;
  shape.restitution = 0.7;
  link.shapes = {shape};
  const double moment = 2.0 / 3.0 * mass * radius * radius;  // kg m^2, moment of inertia of a thin shell
  link.inertia = Inertia::from_centre(mass, {}, {moment, moment, moment, 0, 0, 0});
  MechanismSpec spec;
  spec.name = "Ball";
  spec.links = {link};
  auto made = Mechanism::make(std::move(spec));
  UGOKI_CHECK(made.has_value());
  return *made;
}

}  // namespace ugoki::samples
