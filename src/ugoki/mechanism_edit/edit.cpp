#include "ugoki/mechanism_edit/edit.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/mechanism_edit/link_frames.h"

namespace ugoki {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

std::optional<std::vector<double>> numbers(std::string_view text) {
  std::vector<double> out;
  while (true) {
    const std::size_t comma = text.find(',');
    std::string_view word = text.substr(0, comma);
    while (!word.empty() && word.front() == ' ') word.remove_prefix(1);
    while (!word.empty() && word.back() == ' ') word.remove_suffix(1);
    const std::optional<double> x = parse_double(word);
    if (!x) return std::nullopt;
    out.push_back(*x);
    if (comma == std::string_view::npos) return out;
    text.remove_prefix(comma + 1);
  }
}

/// Applies one assignment to one link.
class Editor {
 public:
  Editor(MechanismSpec& spec, int link, const Assignment& assignment, Edited& out)
      : spec_(spec), link_(spec.links[static_cast<std::size_t>(link)]), a_(assignment), out_(out) {}

  /// @return empty on success, otherwise a sentence that explains why the assignment is not possible
  std::string run() {
    const std::string_view field = a_.field;
    if (field == "name") return rename();
    if (field == "label") return link_.label = a_.value, "";
    if (field.starts_with("joint.")) return joint(field.substr(6));
    if (field.starts_with("inertia.")) return inertia(field.substr(8));
    if (field.starts_with("shapes.")) return shapes(field.substr(7));
    return unknown();
  }

 private:
  static std::string unknown() { return "The field does not exist."; }
  std::optional<Vec3> vector() const {
    const auto x = numbers(a_.value);
    if (!x || x->size() != 3) return std::nullopt;
    return Vec3{(*x)[0], (*x)[1], (*x)[2]};
  }

  std::string rename() {
    if (a_.value.empty()) return "A link needs a name.";
    const std::string old = link_.name;
    for (LinkSpec& l : spec_.links) {
      if (l.parent == old) l.parent = a_.value;
      if (l.real == old) l.real = a_.value;
    }
    for (LoopSpec& l : spec_.loops) {
      if (l.link_a == old) l.link_a = a_.value;
      if (l.link_b == old) l.link_b = a_.value;
    }
    for (SkinBone& bone : spec_.skin_bones)
      if (bone.link == old) bone.link = a_.value;
    for (auto& exclusion : spec_.exclusions) std::ranges::replace(exclusion, old, a_.value);
    link_.name = a_.value;
    return "";
  }

  std::string joint(std::string_view field) {
    Joint& j = link_.joint;
    if (field == "type") {
      const auto type = joint_type_named(a_.value);
      if (!type) return "The joint type does not exist.";
      if (velocity_count(*type) != j.nv()) {
        if (j.nv() > 0)
          out_.report.push_back("The joint of " + link_.name +
                                " now has other degrees of freedom; the limits and springs of the old ones were dropped.");
        j.dofs = {};
      }
      j.type = *type;
      return "";
    }
    if (field == "rotation") {
      const auto q = numbers(a_.value);
      if (!q || q->size() != 4) return "The value must be four numbers: w,x,y,z.";
      const Quat r{(*q)[0], (*q)[1], (*q)[2], (*q)[3]};
      if (!(r.w * r.w + r.x * r.x + r.y * r.y + r.z * r.z > 1e-12)) return "A quaternion of length 0 is not a rotation.";
      j.X_PJ.R = to_matrix(normalized(r));
      return "";
    }
    if (field == "axis" || field == "axis2" || field == "position") {
      const auto v = vector();
      if (!v) return "The value must be three numbers.";
      if (field == "position") return j.X_PJ.p = *v, "";
      if (!(norm(*v) > 1e-9)) return "An axis of length 0 has no direction.";
      (field == "axis" ? j.axis : j.axis2) = normalized(*v);
      return "";
    }
    if (field == "pitch") {
      const auto x = numbers(a_.value);
      if (!x || x->size() != 1) return "The value must be a number.";
      return j.pitch = (*x)[0], "";
    }
    return dofs(field);
  }

  std::string dofs(std::string_view field) {
    Joint& j = link_.joint;
    int first = 0, last = j.nv() - 1;
    if (const std::size_t dot = field.rfind('.'); dot != std::string_view::npos) {
      const std::optional<long> which = parse_long(field.substr(dot + 1));
      if (!which || *which < 0 || *which > last) return "The joint does not have this degree of freedom (they are counted from 0).";
      first = last = static_cast<int>(*which);
      field = field.substr(0, dot);
    }
    double Dof::* member = field == "lower"       ? &Dof::lower
                           : field == "upper"     ? &Dof::upper
                           : field == "damping"   ? &Dof::damping
                           : field == "stiffness" ? &Dof::stiffness
                           : field == "rest"      ? &Dof::rest
                           : field == "armature"  ? &Dof::armature
                           : field == "friction"  ? &Dof::friction
                           : field == "effort"    ? &Dof::effort
                                                  : nullptr;
    if (!member) return unknown();
    if (last < 0) return "The joint is fixed and has no degrees of freedom.";
    const auto x = numbers(a_.value);
    double value = 0;
    if (x && x->size() == 1)
      value = (*x)[0];
    else if (a_.value == "none" && (field == "lower" || field == "upper" || field == "effort"))
      value = field == "lower" ? -infinity : infinity;
    else
      return "The value must be a number.";
    for (int k = first; k <= last; ++k) j.dofs[static_cast<std::size_t>(k)].*member = value;
    return "";
  }

  std::string inertia(std::string_view field) {
    Inertia& i = link_.inertia;
    const auto x = numbers(a_.value);
    if (!x) return "The value must be one or more numbers.";
    if (field == "mass") {
      if (x->size() != 1) return "The value must be a number.";
      const double m = (*x)[0];
      if (i.mass > 0) {
        const double f = m / i.mass;
        i = {m, i.h * f, i.I * f};
      } else {
        i.mass = m;
      }
      return "";
    }
    if (field == "centre") {
      if (x->size() != 3) return "The value must be three numbers.";
      i = Inertia::from_centre(i.mass, {(*x)[0], (*x)[1], (*x)[2]}, i.about_centre());
      return "";
    }
    if (field == "about_centre") {
      if (x->size() != 6) return "The value must be six numbers: xx,yy,zz,xy,xz,yz.";
      i = Inertia::from_centre(i.mass, i.centre(), {(*x)[0], (*x)[1], (*x)[2], (*x)[3], (*x)[4], (*x)[5]});
      return "";
    }
    if (field == "density") {
      if (x->size() != 1 || !((*x)[0] > 0)) return "The value must be a number above 0.";
      Inertia sum;
      for (const Shape& s : link_.shapes)
        if (s.type != ShapeType::height_field) sum += solid_inertia(s, (*x)[0]);
      if (!(sum.mass > 0)) return "The link has no shape that encloses a volume.";
      if (link_.shapes.size() > 1)
        out_.report.push_back("The mass of each shape of " + link_.name +
                              " was computed separately; where shapes overlap, mass counts twice.");
      i = sum;
      return "";
    }
    return unknown();
  }

  std::string shapes(std::string_view field) {
    if (field == "collides" || field == "visible") {
      if (a_.value != "true" && a_.value != "false") return "The value must be true or false.";
      for (Shape& s : link_.shapes) (field == "collides" ? s.collides : s.visible) = a_.value == "true";
      return "";
    }
    if (field != "friction" && field != "restitution") return unknown();
    const auto x = numbers(a_.value);
    if (!x || x->size() != 1) return "The value must be a number.";
    for (Shape& s : link_.shapes) (field == "friction" ? s.friction : s.restitution) = (*x)[0];
    return "";
  }

  MechanismSpec& spec_;
  LinkSpec& link_;
  const Assignment& a_;
  Edited& out_;
};

}  // namespace

Result<Assignment> parse_assignment(std::string_view text) {
  const std::size_t equals = text.find('=');
  const std::size_t colon = equals == std::string_view::npos ? equals : text.substr(0, equals).rfind(':');
  if (colon == std::string_view::npos || colon == 0)
    return fail(ErrorCode::syntax, std::string(text), "The text is not an assignment.",
                "Write LINK:FIELD=VALUE, as in 'shank left:joint.upper=2.4'.");
  return Assignment{std::string(text.substr(0, colon)), std::string(text.substr(colon + 1, equals - colon - 1)),
                    std::string(text.substr(equals + 1))};
}

Result<Edited> edit(const Mechanism& m, std::span<const Assignment> assignments) {
  MechanismSpec spec = m.spec();
  Edited out;
  Error errors;
  for (const Assignment& a : assignments) {
    const int link = find_link(spec, a.link);
    if (link < 0) {
      errors.add(ErrorCode::unknown, "mechanism " + m.name(), "The mechanism has no link '" + a.link + "'.",
                 "Name one of its links (`ugoki info` lists them).");
      continue;
    }
    if (std::string wrong = Editor(spec, link, a, out).run(); !wrong.empty())
      errors.add(ErrorCode::unknown, "link " + a.link + ", " + a.field + "=" + a.value, wrong,
                 "See the table of fields in docs/mechanisms.md.");
  }
  if (!errors.empty()) return fail(std::move(errors));
  Result<MechanismPtr> made = Mechanism::make(std::move(spec));
  if (!made) return fail(std::move(made.error()));
  out.mechanism = std::move(*made);
  return out;
}

}  // namespace ugoki
