// Fuzz target of the CSV reader: points, and coordinates of a mechanism that has every kind of joint.
#include <cmath>
#include <string_view>

#include "fuzz_targets.h"
#include "ugoki/base/check.h"
#include "ugoki/formats/csv.h"

namespace ugoki {
namespace {

void check_error(const Error& e) {
  UGOKI_CHECK(!e.problems.empty() && e.problems.size() <= 20);
  for (const Problem& p : e.problems) UGOKI_CHECK(!p.location.empty() && p.message.ends_with('.') && !p.remedy.empty());
}

MechanismPtr every_joint() {
  MechanismSpec spec;
  spec.name = "every joint";
  std::string parent;
  for (const JointType type : {JointType::floating, JointType::revolute, JointType::prismatic, JointType::spherical, JointType::planar}) {
    LinkSpec link;
    link.name = "link" + std::to_string(spec.links.size());
    link.parent = parent;
    link.joint.type = type;
    link.inertia = Inertia::from_centre(1, {}, {0.1, 0.1, 0.1, 0, 0, 0});
    spec.links.push_back(link);
    parent = link.name;
  }
  Result<MechanismPtr> made = Mechanism::make(spec);
  UGOKI_CHECK(made.has_value());
  return *made;
}

void check_points(std::string_view text) {
  const auto m = formats::read_csv(text, "fuzz.csv");
  if (!m) return check_error(m.error());
  UGOKI_CHECK(m->frames > 0 && m->rate > 0 && std::isfinite(m->rate) && !m->labels.empty());
  UGOKI_CHECK(m->positions.size() == static_cast<std::size_t>(m->frames) * m->labels.size());
  UGOKI_CHECK(m->residuals.size() == m->positions.size());
  for (const Vec3& x : m->positions) UGOKI_CHECK(is_finite(x));
  if (m->positions.size() > 20'000) return;
  const auto back = formats::read_csv(formats::write_csv(*m), "again.csv");
  if (!back) return check_error(back.error());  // allowed: the writer may make two names equal
  UGOKI_CHECK(back->frames == m->frames && back->labels.size() == m->labels.size());
}

void check_coordinates(std::string_view text) {
  static const MechanismPtr mechanism = every_joint();
  const auto m = formats::read_csv(text, "fuzz.csv", *mechanism);
  if (!m) return check_error(m.error());
  UGOKI_CHECK(check_motion(*m, *mechanism).empty());
  if (m->q.size() > 100'000) return;
  const auto back = formats::read_csv(formats::write_csv(*m, *mechanism), "again.csv", *mechanism);
  UGOKI_CHECK(back.has_value() && back->frames == m->frames && back->contacts.size() == m->contacts.size());
}

}  // namespace

void fuzz_csv(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  (void)formats::csv_kind(text);
  check_points(text);
  check_coordinates(text);
}

}  // namespace ugoki
