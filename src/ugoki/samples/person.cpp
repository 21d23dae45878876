// A person of any height: the project's human with all joints movable, scaled by growth curves.

#include "ugoki/base/check.h"
#include "ugoki/body/body.h"
#include "ugoki/mechanism_edit/growth.h"
#include "ugoki/samples/samples.h"

namespace ugoki::samples {
namespace {

constexpr double adult_height = 1.6;  // m: below this height, proportions are those of a child

/// Age [years] at which the median height of boys equals `height` [m].
double age_of(double height) {
  double low = 2, high = 20;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (median_growth(middle, GrowthSex::boy).height < height ? low : high) = middle;
  }
  return low;
}

}  // namespace

Result<MechanismPtr> make_person(double height) {
  body::BodyOptions options;
  options.keep_unmoved = true;
  const Result<body::Body> body = body::make_body(make_human_stand(), options);
  UGOKI_CHECK(body.has_value());
  MechanismSpec spec = body->mechanism->spec();
  spec.name = "Person";
  for (LinkSpec& link : spec.links) {
    const bool knee = link.label.starts_with("shank"), elbow = link.label.starts_with("forearm");
    if (!knee && !elbow) continue;
    // Hinge axes for the T position: positive angles bend a forearm forward and a shank backward.
    link.joint.type = JointType::revolute;
    link.joint.axis = knee ? Vec3{0, 1, 0} : Vec3{0, 0, link.label.ends_with("left") ? -1.0 : 1.0};
    link.joint.dofs[0].lower = knee ? -0.05 : 0;
    link.joint.dofs[0].upper = 2.6;
  }
  Result<MechanismPtr> adult = Mechanism::make(std::move(spec));
  UGOKI_CHECK(adult.has_value());
  GrowOptions grown;
  grown.height = height;
  if (height < adult_height) grown.age = age_of(height);
  Result<Edited> person = grow(**adult, grown);
  if (!person) return fail(std::move(person.error()));
  return person->mechanism;
}

}  // namespace ugoki::samples
