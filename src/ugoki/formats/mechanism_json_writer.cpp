#include <cmath>
#include <nlohmann/json.hpp>

#include "ugoki/base/number.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/mechanism_json_geometry.h"
#include "ugoki/formats/mechanism_json_skin.h"

namespace ugoki::formats {
namespace {

std::string text_of(double value) {
  // "-0" is read as the integer 0, which has no sign.
  return value == 0 && std::signbit(value) ? "-0.0" : to_text(value);
}
std::string text_of(const std::string& value) {
  return nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}
std::string text_of(bool value) { return value ? "true" : "false"; }
std::string text_of(const Vec3& v) { return "[" + text_of(v.x) + ", " + text_of(v.y) + ", " + text_of(v.z) + "]"; }
std::string text_of(const Mat3& m) { return "[" + text_of(m.row(0)) + ", " + text_of(m.row(1)) + ", " + text_of(m.row(2)) + "]"; }
std::string text_of(const Sym3& s) {
  return "[" + text_of(s.xx) + ", " + text_of(s.yy) + ", " + text_of(s.zz) + ", " + text_of(s.xy) + ", " + text_of(s.xz) + ", " +
         text_of(s.yz) + "]";
}

bool same_bits(double a, double b) { return a == b && std::signbit(a) == std::signbit(b); }
bool same_bits(const Vec3& a, const Vec3& b) { return same_bits(a.x, b.x) && same_bits(a.y, b.y) && same_bits(a.z, b.z); }
bool same_bits(const Mat3& a, const Mat3& b) {
  return same_bits(a.row(0), b.row(0)) && same_bits(a.row(1), b.row(1)) && same_bits(a.row(2), b.row(2));
}
bool same_bits(const Sym3& a, const Sym3& b) {
  return same_bits(a.xx, b.xx) && same_bits(a.yy, b.yy) && same_bits(a.zz, b.zz) && same_bits(a.xy, b.xy) && same_bits(a.xz, b.xz) &&
         same_bits(a.yz, b.yz);
}

/// The members of one JSON object on one line.
class Members {
 public:
  void add(const char* name, const std::string& text) { text_ += (text_.empty() ? "\"" : ", \"") + std::string(name) + "\": " + text; }
  /// Adds the member unless `value` is bit for bit equal to `standard`, its default.
  template <class T>
  void add_unless(const char* name, const T& value, const T& standard) {
    if (!same(value, standard)) add(name, text_of(value));
  }
  void add_pose(const Pose& X) {
    add_unless("position", X.p, Vec3{});
    add_unless("rotation", X.R, Mat3::identity());
  }
  [[nodiscard]] bool empty() const { return text_.empty(); }
  [[nodiscard]] std::string object() const { return "{" + text_ + "}"; }

 private:
  template <class T>
  static bool same(const T& a, const T& b) {
    if constexpr (std::is_same_v<T, bool>)
      return a == b;
    else
      return same_bits(a, b);
  }
  std::string text_;
};

std::string dof_text(const Dof& f) {
  const Dof standard;
  Members m;
  m.add_unless("lower", f.lower, standard.lower);
  m.add_unless("upper", f.upper, standard.upper);
  m.add_unless("damping", f.damping, standard.damping);
  m.add_unless("stiffness", f.stiffness, standard.stiffness);
  m.add_unless("rest", f.rest, standard.rest);
  m.add_unless("armature", f.armature, standard.armature);
  m.add_unless("friction", f.friction, standard.friction);
  m.add_unless("effort", f.effort, standard.effort);
  return m.object();
}

std::string joint_text(const Joint& j) {
  const Joint standard;
  Members m;
  m.add("type", text_of(std::string(name_of(j.type))));
  m.add_pose(j.X_PJ);
  m.add_unless("axis", j.axis, standard.axis);
  m.add_unless("axis2", j.axis2, standard.axis2);
  m.add_unless("pitch", j.pitch, standard.pitch);
  int written = 0;  // trailing DOFs with only default values are omitted
  for (int i = 0; i < j.nv(); ++i)
    if (dof_text(j.dofs[static_cast<std::size_t>(i)]) != "{}") written = i + 1;
  if (written > 0) {
    std::string list;
    for (int i = 0; i < written; ++i) list += (i > 0 ? ", " : "") + dof_text(j.dofs[static_cast<std::size_t>(i)]);
    m.add("dofs", "[" + list + "]");
  }
  return m.object();
}

std::string inertia_text(const Inertia& inertia) {
  Members m;
  m.add_unless("mass", inertia.mass, 0.0);
  // Mass, centre of mass and the inertia about the centre of mass are easier to read than the stored values. They are written if the stored
  // values can be computed from them bit for bit; otherwise the stored values are written.
  const Vec3 centre = inertia.centre();
  const Sym3 about_centre = inertia.about_centre();
  const Inertia back = Inertia::from_centre(inertia.mass, centre, about_centre);
  if (same_bits(back.h, inertia.h) && same_bits(back.I, inertia.I)) {
    m.add_unless("centre", centre, Vec3{});
    m.add_unless("about_centre", about_centre, Sym3{});
  } else {
    m.add_unless("first_moment", inertia.h, Vec3{});
    m.add_unless("about_origin", inertia.I, Sym3{});
  }
  return m.object();
}

std::string shape_text(const Shape& s) {
  const Shape standard;
  Members m;
  m.add("type", text_of(std::string(name_of(s.type))));
  m.add_unless("radius", s.radius, standard.radius);
  m.add_unless("half_length", s.half_length, standard.half_length);
  m.add_unless("half_extents", s.half_extents, standard.half_extents);
  if (s.geometry) m.add("geometry", text_of(surface_name(s.geometry->hash)));
  if (s.field) m.add("height_field", text_of(surface_name(s.field->hash)));
  m.add_pose(s.X_BS);
  m.add_unless("friction", s.friction, standard.friction);
  m.add_unless("restitution", s.restitution, standard.restitution);
  m.add_unless("collides", s.collides, standard.collides);
  if (s.groups != standard.groups) m.add("groups", std::to_string(s.groups));
  if (s.partners != standard.partners) m.add("partners", std::to_string(s.partners));
  m.add_unless("smooth", s.smooth, standard.smooth);
  m.add_unless("visible", s.visible, standard.visible);
  return m.object();
}

std::string link_text(const LinkSpec& l) {
  std::string out = "    {\n      \"name\": " + text_of(l.name);
  const auto add = [&](const char* name, const std::string& text) { out += ",\n      \"" + std::string(name) + "\": " + text; };
  if (!l.label.empty()) add("label", text_of(l.label));
  if (!l.parent.empty()) add("parent", text_of(l.parent));
  add("joint", joint_text(l.joint));
  if (const std::string inertia = inertia_text(l.inertia); inertia != "{}") add("inertia", inertia);
  if (!l.shapes.empty()) {
    std::string list;
    for (const Shape& s : l.shapes) list += (list.empty() ? "\n        " : ",\n        ") + shape_text(s);
    add("shapes", "[" + list + "\n      ]");
  }
  Members loop;
  if (!l.real.empty()) loop.add("real", text_of(l.real));
  loop.add_pose(l.X_RV);
  if (!loop.empty()) add("virtual", loop.object());
  return out + "\n    }";
}

std::string loop_text(const LoopSpec& l) {
  const LoopSpec standard;
  Members m;
  m.add("name", text_of(l.name));
  m.add("type", text_of(std::string(name_of(l.type))));
  const auto add_end = [&](const char* name, const std::string& link, const Pose& X, int dof) {
    Members end;
    if (!link.empty()) end.add("link", text_of(link));
    end.add_pose(X);
    if (dof != 0) end.add("dof", std::to_string(dof));
    if (!end.empty()) m.add(name, end.object());
  };
  add_end("a", l.link_a, l.X_AJ, l.dof_a);
  add_end("b", l.link_b, l.X_BJ, l.dof_b);
  m.add_unless("axis", l.axis, standard.axis);
  m.add_unless("axis2", l.axis2, standard.axis2);
  m.add_unless("length", l.length, standard.length);
  if (l.polynomial != standard.polynomial) {
    std::string list;
    for (const double c : l.polynomial) list += (list.empty() ? "" : ", ") + text_of(c);
    m.add("polynomial", "[" + list + "]");
  }
  m.add_unless("closed", l.closed, standard.closed);
  return "    " + m.object();
}

}  // namespace

std::string write_mechanism(const Mechanism& mechanism) {
  const MechanismSpec spec = mechanism.spec();
  std::string out = "{\n  \"format\": \"ugoki-mechanism\",\n  \"version\": 1,\n  \"name\": " + text_of(spec.name) + ",\n  \"links\": [";
  bool first = true;
  for (const LinkSpec& l : spec.links) {
    out += (first ? "\n" : ",\n") + link_text(l);
    first = false;
  }
  out += "\n  ]";
  if (!spec.loops.empty()) {
    out += ",\n  \"loops\": [";
    first = true;
    for (const LoopSpec& l : spec.loops) {
      out += (first ? "\n" : ",\n") + loop_text(l);
      first = false;
    }
    out += "\n  ]";
  }
  if (!spec.exclusions.empty()) {
    out += ",\n  \"exclusions\": [";
    first = true;
    for (const auto& [a, b] : spec.exclusions) {
      Members m;
      m.add("a", text_of(a));
      m.add("b", text_of(b));
      out += (first ? "\n    " : ",\n    ") + m.object();
      first = false;
    }
    out += "\n  ]";
  }
  return out + surfaces_text(spec) + (spec.skin ? skin_text(*spec.skin, spec.skin_bones) : "") + "\n}\n";
}

}  // namespace ugoki::formats
