#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>

#include "ugoki/base/number.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/text.h"

namespace ugoki::formats {
namespace {

using nlohmann::json;

/// Finds where broken JSON breaks: nlohmann tells it to a SAX handler only when exceptions are off.
struct FaultFinder : json::json_sax_t {
  std::size_t position = 0;
  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool string(string_t&) override { return true; }
  bool binary(binary_t&) override { return true; }
  bool start_object(std::size_t) override { return true; }
  bool key(string_t&) override { return true; }
  bool end_object() override { return true; }
  bool start_array(std::size_t) override { return true; }
  bool end_array() override { return true; }
  bool parse_error(std::size_t at, const std::string&, const nlohmann::detail::exception&) override {
    position = at;
    return false;
  }
};

class Reader {
 public:
  explicit Reader(std::string_view file) : file_(file) {}

  Error errors;

  [[nodiscard]] bool full() const { return errors.problems.size() >= 20; }
  void add(ErrorCode code, const std::string& path, std::string message, std::string remedy) {
    if (!full()) errors.add(code, file_ + ":" + (path.empty() ? "/" : path), std::move(message), std::move(remedy));
  }

  MechanismSpec read(const json& j) {
    MechanismSpec spec;
    if (!is_object(j, "", {"format", "version", "name", "links", "loops"})) return spec;
    std::string format;
    read_string(j, "", "format", format);
    if (format != "ugoki-mechanism")
      add(ErrorCode::syntax, "format", "this is not a mechanism of Ugoki.", "A mechanism has \"format\": \"ugoki-mechanism\".");
    double version = 0;
    read_number(j, "", "version", version);
    if (version != 1)
      add(ErrorCode::unsupported, "version", "this version of the format is not known.", "Use version 1, or a newer Ugoki.");
    read_string(j, "", "name", spec.name);
    const json* links = find(j, "links");
    if (!links || !links->is_array()) {
      add(ErrorCode::syntax, "links", "the list of links is missing.", "Add \"links\": [ ... ].");
      return spec;
    }
    for (std::size_t i = 0; i < links->size() && !full(); ++i) spec.links.push_back(read_link((*links)[i], "links/" + std::to_string(i)));
    if (const json* loops = find(j, "loops")) {
      if (!loops->is_array())
        add(ErrorCode::syntax, "loops", "a list of loops is expected, not " + std::string(loops->type_name()) + ".", "Write [ ... ].");
      else
        for (std::size_t i = 0; i < loops->size() && !full(); ++i)
          spec.loops.push_back(read_loop((*loops)[i], "loops/" + std::to_string(i)));
    }
    return spec;
  }

 private:
  static const json* find(const json& j, const char* key) {
    const auto it = j.find(key);
    return it == j.end() ? nullptr : &*it;
  }
  static std::string join(const std::string& path, const char* key) { return path.empty() ? key : path + "/" + key; }

  bool is_object(const json& j, const std::string& path, std::initializer_list<std::string_view> keys) {
    if (!j.is_object()) {
      add(ErrorCode::syntax, path, "an object is expected, not " + std::string(j.type_name()) + ".", "Write { ... }.");
      return false;
    }
    for (auto it = j.begin(); it != j.end(); ++it) {
      if (std::find(keys.begin(), keys.end(), it.key()) != keys.end()) continue;
      std::string known;
      for (const std::string_view k : keys) known += (known.empty() ? "" : ", ") + std::string(k);
      add(ErrorCode::unknown, path, in_quotes(it.key()) + " is not known here.", "Known are " + known + ".");
    }
    return true;
  }

  void read_string(const json& j, const std::string& path, const char* key, std::string& value) {
    const json* v = find(j, key);
    if (!v) return;
    if (v->is_string())
      value = *v->get_ptr<const std::string*>();
    else
      add(ErrorCode::syntax, join(path, key), "a text is expected, not " + std::string(v->type_name()) + ".", "Put it into quotes.");
  }
  void read_number(const json& j, const std::string& path, const char* key, double& value) {
    const json* v = find(j, key);
    if (!v) return;
    if (v->is_number())
      value = v->get<double>();
    else
      add(ErrorCode::syntax, join(path, key), "a number is expected, not " + std::string(v->type_name()) + ".",
          "Write a number; leave it out for the default.");
  }
  void read_bool(const json& j, const std::string& path, const char* key, bool& value) {
    const json* v = find(j, key);
    if (!v) return;
    if (v->is_boolean())
      value = v->get<bool>();
    else
      add(ErrorCode::syntax, join(path, key), "true or false is expected, not " + std::string(v->type_name()) + ".",
          "Write true or false.");
  }
  /// A list of exactly `count` numbers; false if it is something else (told).
  bool numbers(const json& v, const std::string& path, std::size_t count, double* out) {
    bool good = v.is_array() && v.size() == count;
    for (std::size_t i = 0; good && i < count; ++i) good = v[i].is_number();
    if (!good) {
      add(ErrorCode::syntax, path, "a list of " + std::to_string(count) + " numbers is expected.",
          "Write [..] with " + std::to_string(count) + " numbers.");
      return false;
    }
    for (std::size_t i = 0; i < count; ++i) out[i] = v[i].get<double>();
    return true;
  }
  void read_vector(const json& j, const std::string& path, const char* key, Vec3& value) {
    double x[3];
    if (const json* v = find(j, key); v && numbers(*v, join(path, key), 3, x)) value = {x[0], x[1], x[2]};
  }
  void read_symmetric(const json& j, const std::string& path, const char* key, Sym3& value) {
    double x[6];
    if (const json* v = find(j, key); v && numbers(*v, join(path, key), 6, x)) value = {x[0], x[1], x[2], x[3], x[4], x[5]};
  }

  /// "position": 3 numbers; "rotation": three rows, or a quaternion w x y z (made unit).
  void read_pose(const json& j, const std::string& path, Pose& X) {
    read_vector(j, path, "position", X.p);
    const json* r = find(j, "rotation");
    if (!r) return;
    const std::string place = join(path, "rotation");
    if (r->is_array() && r->size() == 4) {
      double q[4];
      if (!numbers(*r, place, 4, q)) return;
      const double n = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
      if (!(n > 1e-6 && n < 1e6))
        add(ErrorCode::range, place, "the quaternion has no usable length.", "Write a unit quaternion w x y z.");
      else
        X.R = to_matrix(normalized(Quat{q[0], q[1], q[2], q[3]}));
      return;
    }
    if (!r->is_array() || r->size() != 3) {
      add(ErrorCode::syntax, place, "a rotation is three rows of three numbers, or a quaternion of four.",
          "Write [w, x, y, z] or three rows.");
      return;
    }
    double m[9];
    for (std::size_t i = 0; i < 3; ++i)
      if (!numbers((*r)[i], place + "/" + std::to_string(i), 3, m + 3 * i)) return;
    X.R = {m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]};
  }

  void read_freedom(const json& j, const std::string& path, Freedom& f) {
    if (!is_object(j, path, {"lower", "upper", "damping", "stiffness", "rest", "armature", "friction", "effort"})) return;
    read_number(j, path, "lower", f.lower);
    read_number(j, path, "upper", f.upper);
    read_number(j, path, "damping", f.damping);
    read_number(j, path, "stiffness", f.stiffness);
    read_number(j, path, "rest", f.rest);
    read_number(j, path, "armature", f.armature);
    read_number(j, path, "friction", f.friction);
    read_number(j, path, "effort", f.effort);
  }

  Joint read_joint(const json& j, const std::string& path) {
    Joint joint;
    if (!is_object(j, path, {"type", "position", "rotation", "axis", "axis2", "pitch", "freedoms"})) return joint;
    std::string type;
    read_string(j, path, "type", type);
    if (const auto known = joint_type_named(type)) {
      joint.type = *known;
    } else {
      add(ErrorCode::unknown, join(path, "type"), "there is no joint type " + in_quotes(type) + ".",
          "Types are fixed, revolute, prismatic, helical, cylindrical, planar, universal, spherical and floating.");
      return joint;
    }
    read_pose(j, path, joint.X_PJ);
    read_vector(j, path, "axis", joint.axis);
    read_vector(j, path, "axis2", joint.axis2);
    read_number(j, path, "pitch", joint.pitch);
    if (const json* list = find(j, "freedoms")) {
      const std::string place = join(path, "freedoms");
      const auto nv = static_cast<std::size_t>(joint.nv());
      if (!list->is_array() || list->size() > nv)
        add(ErrorCode::structure, place, "a list of at most " + std::to_string(nv) + " freedoms is expected for a " + type + " joint.",
            "Write one object for each freedom.");
      else
        for (std::size_t i = 0; i < list->size(); ++i) read_freedom((*list)[i], place + "/" + std::to_string(i), joint.freedoms[i]);
    }
    return joint;
  }

  Inertia read_inertia(const json& j, const std::string& path) {
    Inertia inertia;
    if (!is_object(j, path, {"mass", "centre", "about_centre", "first_moment", "about_origin"})) return inertia;
    read_number(j, path, "mass", inertia.mass);
    const bool stored = find(j, "first_moment") || find(j, "about_origin");
    if (stored && (find(j, "centre") || find(j, "about_centre"))) {
      add(ErrorCode::conflict, path, "the inertia is given in two ways.",
          "Give centre and about_centre, or first_moment and about_origin.");
    } else if (stored) {
      read_vector(j, path, "first_moment", inertia.h);
      read_symmetric(j, path, "about_origin", inertia.I);
    } else {
      Vec3 centre;
      Sym3 about_centre;
      read_vector(j, path, "centre", centre);
      read_symmetric(j, path, "about_centre", about_centre);
      inertia = Inertia::from_centre(inertia.mass, centre, about_centre);
    }
    return inertia;
  }

  Shape read_shape(const json& j, const std::string& path) {
    Shape shape;
    if (!is_object(
            j, path,
            {"type", "radius", "half_length", "half_extents", "position", "rotation", "friction", "restitution", "collides", "visible"}))
      return shape;
    std::string type;
    read_string(j, path, "type", type);
    if (type == "sphere")
      shape.type = ShapeType::sphere;
    else if (type == "capsule")
      shape.type = ShapeType::capsule;
    else if (type == "box")
      shape.type = ShapeType::box;
    else
      add(ErrorCode::unknown, join(path, "type"), "there is no shape type " + in_quotes(type) + ".", "Types are sphere, capsule and box.");
    read_number(j, path, "radius", shape.radius);
    read_number(j, path, "half_length", shape.half_length);
    read_vector(j, path, "half_extents", shape.half_extents);
    read_pose(j, path, shape.X_BS);
    read_number(j, path, "friction", shape.friction);
    read_number(j, path, "restitution", shape.restitution);
    read_bool(j, path, "collides", shape.collides);
    read_bool(j, path, "visible", shape.visible);
    return shape;
  }

  LinkSpec read_link(const json& j, const std::string& path) {
    LinkSpec link;
    if (!is_object(j, path, {"name", "label", "parent", "joint", "inertia", "shapes", "virtual"})) return link;
    read_string(j, path, "name", link.name);
    read_string(j, path, "label", link.label);
    read_string(j, path, "parent", link.parent);
    if (const json* v = find(j, "joint")) link.joint = read_joint(*v, path + "/joint");
    if (const json* v = find(j, "inertia")) link.inertia = read_inertia(*v, path + "/inertia");
    if (const json* v = find(j, "shapes")) {
      if (v->is_array())
        for (std::size_t i = 0; i < v->size() && !full(); ++i)
          link.shapes.push_back(read_shape((*v)[i], path + "/shapes/" + std::to_string(i)));
      else
        add(ErrorCode::syntax, path + "/shapes", "a list of shapes is expected, not " + std::string(v->type_name()) + ".",
            "Write [ ... ].");
    }
    if (const json* v = find(j, "virtual"); v && is_object(*v, path + "/virtual", {"real", "position", "rotation"})) {
      read_string(*v, path + "/virtual", "real", link.real);
      read_pose(*v, path + "/virtual", link.X_RV);
    }
    return link;
  }

  void read_loop_end(const json& j, const std::string& path, const char* key, std::string& link, Pose& X, int& freedom) {
    const json* end = find(j, key);
    const std::string place = join(path, key);
    if (!end || !is_object(*end, place, {"link", "position", "rotation", "freedom"})) return;
    read_string(*end, place, "link", link);
    read_pose(*end, place, X);
    double number = 0;
    read_number(*end, place, "freedom", number);
    if (number >= 0 && number <= 5 && number == std::floor(number))
      freedom = static_cast<int>(number);
    else
      add(ErrorCode::range, place + "/freedom", "a freedom is counted from 0 to 5.", "Give the place of the freedom in its joint.");
  }

  LoopSpec read_loop(const json& j, const std::string& path) {
    LoopSpec loop;
    if (!is_object(j, path, {"name", "type", "a", "b", "axis", "axis2", "length", "polynomial", "closed"})) return loop;
    read_string(j, path, "name", loop.name);
    std::string type;
    read_string(j, path, "type", type);
    if (const auto known = loop_type_named(type))
      loop.type = *known;
    else
      add(ErrorCode::unknown, join(path, "type"), "there is no loop type " + in_quotes(type) + ".",
          "Types are weld, ball, revolute, prismatic, cylindrical, planar, universal, distance and gear.");
    read_loop_end(j, path, "a", loop.link_a, loop.X_AJ, loop.freedom_a);
    read_loop_end(j, path, "b", loop.link_b, loop.X_BJ, loop.freedom_b);
    read_vector(j, path, "axis", loop.axis);
    read_vector(j, path, "axis2", loop.axis2);
    read_number(j, path, "length", loop.length);
    if (const json* v = find(j, "polynomial")) numbers(*v, join(path, "polynomial"), loop.polynomial.size(), loop.polynomial.data());
    read_bool(j, path, "closed", loop.closed);
    return loop;
  }

  std::string file_;
};

}  // namespace

Result<MechanismPtr> read_mechanism(std::string_view text, std::string_view file_name) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  const json document = json::parse(text.begin(), text.end(), nullptr, false);
  if (document.is_discarded()) {
    FaultFinder finder;
    (void)json::sax_parse(text.begin(), text.end(), &finder);
    const std::size_t at = std::min(finder.position, text.size());
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    const bool ended = text.find_first_not_of(" \t\r\n", at) == std::string_view::npos;
    return fail(ended ? ErrorCode::truncated : ErrorCode::syntax, std::string(file_name) + ":" + std::to_string(line),
                ended ? "the JSON text ends too early or is not closed." : "the text is not valid JSON here.",
                "Check quotes, commas and brackets before this place.");
  }
  Reader reader(file_name);
  MechanismSpec spec = reader.read(document);
  if (!reader.errors.empty()) return fail(std::move(reader.errors));
  auto mechanism = Mechanism::make(std::move(spec));
  if (!mechanism)
    for (Problem& p : mechanism.error().problems) p.place = std::string(file_name) + ": " + p.place;
  return mechanism;
}

}  // namespace ugoki::formats
