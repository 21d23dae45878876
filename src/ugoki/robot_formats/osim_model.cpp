#include "ugoki/robot_formats/osim_model.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace ugoki::robot_formats {
namespace {

using formats::in_quotes;

constexpr std::size_t max_knots = 100'000;
constexpr int max_frames_deep = 50;
constexpr std::size_t max_bodies = 10'000;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Second derivatives of the interpolating cubic spline. At both ends the third derivative is that of the cubic through the four outermost
/// points (Forsythe, Malcolm, Moler 1977), as in OpenSim; with fewer than four points the spline is natural.
std::vector<double> second_derivatives(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t n = x.size();
  std::vector<double> m(n, 0.0), diagonal(n), right(n, 0.0);
  if (n < 3) return m;
  const auto h = [&](std::size_t i) { return x[i + 1] - x[i]; };
  const auto slope = [&](std::size_t i) { return (y[i + 1] - y[i]) / h(i); };
  const auto third = [&](std::size_t i) {  // third divided difference of the points i to i + 3
    const auto second = [&](std::size_t k) { return (slope(k + 1) - slope(k)) / (x[k + 2] - x[k]); };
    return (second(i + 1) - second(i)) / (x[i + 3] - x[i]);
  };
  // In the unknowns m / 6: h_{i-1} m_{i-1} + 2 (h_{i-1} + h_i) m_i + h_i m_{i+1} = slope_i - slope_{i-1}.
  diagonal[0] = -h(0);
  diagonal[n - 1] = -h(n - 2);
  if (n > 3) {
    right[0] = h(0) * h(0) * third(0);
    right[n - 1] = -h(n - 2) * h(n - 2) * third(n - 4);
  }
  for (std::size_t i = 1; i + 1 < n; ++i) {
    diagonal[i] = 2 * (h(i - 1) + h(i));
    right[i] = slope(i) - slope(i - 1);
  }
  for (std::size_t i = 1; i < n; ++i) {
    const double f = h(i - 1) / diagonal[i - 1];
    diagonal[i] -= f * h(i - 1);
    right[i] -= f * right[i - 1];
  }
  m[n - 1] = right[n - 1] / diagonal[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) m[i] = (right[i] - h(i) * m[i + 1]) / diagonal[i];
  for (double& v : m) v *= 6;
  return m;
}

class Reader {
 public:
  Reader(XmlFields& xml, OsimModel& model) : xml_(xml), model_(model) {}

  bool read() {
    const pugi::xml_node root = xml_.root();
    pugi::xml_node node = std::string_view(root.name()) == "Model" ? root : root.child("Model");
    if (std::string_view(root.name()) != "OpenSimDocument" && std::string_view(root.name()) != "Model") node = {};
    if (!node) {
      xml_.problem(root, ErrorCode::syntax, "The file is not an OpenSim model: it has no <Model>.", "Give a model (.osim) of OpenSim.");
      return false;
    }
    model_.name = xml_.text(xml_.attribute(node, "name"));
    const Vec3 gravity = xml_.vec3(xml_.element(node, "gravity"), {0, -9.8, 0});
    // OpenSim's usual ground axes are X forward, Y up, Z right.
    if (!(gravity.z < -std::fabs(gravity.y))) model_.to_world = {1, 0, 0, 0, 0, -1, 0, 1, 0};
    for (const pugi::xml_node body : node.child("BodySet").child("objects").children("Body")) read_body(body);
    if (index_.empty() && !xml_.failed()) xml_.problem(node, ErrorCode::structure, "The model has no <Body>.", "Give a model with bodies.");
    for (const pugi::xml_node joint : node.child("JointSet").child("objects").children())
      if (!xml_.full()) read_joint(joint, -1);
    if (!xml_.failed()) read_couplers(node.child("ConstraintSet").child("objects"));
    if (!xml_.failed()) read_contacts(node.child("ContactGeometrySet").child("objects"));
    return !xml_.failed() && sort_bodies(node);
  }

 private:
  void read_body(pugi::xml_node node) {
    const std::string name = xml_.required_text(xml_.attribute(node, "name"));
    if (xml_.full() || name.empty() || name == "ground") return;
    if (index_.contains(name)) {
      xml_.problem(node, ErrorCode::duplicate, "Two bodies are named " + in_quotes(name) + ".", "Rename one of them.");
      return;
    }
    if (index_.size() >= max_bodies) {
      xml_.problem(node, ErrorCode::range, "The model has more than 10000 bodies.", "Use fewer bodies.");
      return;
    }
    OsimBody body;
    body.name = name;
    body.node = node;
    const double mass = xml_.number(xml_.element(node, "mass"), 0, not_negative);
    const Vec3 centre = xml_.vec3(xml_.element(node, "mass_center"), {});
    std::array<double, 6> I{};  // xx yy zz xy xz yz
    if (!xml_.numbers(xml_.element(node, "inertia"), I)) {
      constexpr std::array<const char*, 6> names = {"inertia_xx", "inertia_yy", "inertia_zz", "inertia_xy", "inertia_xz", "inertia_yz"};
      for (std::size_t i = 0; i < 6; ++i) I[i] = xml_.number(xml_.element(node, names[i]), 0);
    }
    body.inertia = Inertia::from_centre(mass, centre, Sym3{I[0], I[1], I[2], I[3], I[4], I[5]});
    index_[name] = static_cast<int>(model_.bodies.size());
    model_.bodies.push_back(std::move(body));
    const pugi::xml_node joint = node.child("Joint").first_child();  // versions before 4: the joint is part of the body
    if (joint) read_joint(joint, static_cast<int>(model_.bodies.size()) - 1);
  }

  /// A frame by the last part of its path: the body it is fixed in (-1: ground, -2: none) and its pose there.
  struct Frame {
    int body = -2;
    Pose X;
  };
  Frame find_frame(pugi::xml_node joint, std::string_view path, int depth) {
    const std::string name(path.substr(path.find_last_of('/') + 1));
    for (const pugi::xml_node frame : joint.child("frames").children("PhysicalOffsetFrame")) {
      if (name != xml_.text(xml_.attribute(frame, "name")) || depth > max_frames_deep) continue;
      Frame parent = find_frame(joint, socket(frame, "socket_parent", "socket_parent_connectee_name"), depth + 1);
      parent.X = parent.X * Pose{from_euler(xml_.vec3(xml_.element(frame, "orientation"), {}), "XYZ"),
                                 xml_.vec3(xml_.element(frame, "translation"), {})};
      return parent;
    }
    if (name == "ground") return {-1, {}};
    const auto it = index_.find(name);
    return {it == index_.end() ? -2 : it->second, {}};
  }

  std::string socket(pugi::xml_node node, const char* name, const char* older) {
    const XmlField field = xml_.element(node, name);
    return xml_.text(field.present ? field : xml_.element(node, older));
  }

  /// @param owner body that contains the joint (versions before 4); -1: the joint names its frames
  void read_joint(pugi::xml_node node, int owner) {
    const std::string kind = node.name();
    const std::string name = xml_.text(xml_.attribute(node, "name"));
    Frame above, below;
    if (owner >= 0) {
      const std::string parent = xml_.text(xml_.element(node, "parent_body"));
      above = find_frame(node, parent, 0);
      // Versions before 4 list parents first, so an unknown parent is an error.
      above.X = {from_euler(xml_.vec3(xml_.element(node, "orientation_in_parent"), {}), "XYZ"),
                 xml_.vec3(xml_.element(node, "location_in_parent"), {})};
      below = {owner, {from_euler(xml_.vec3(xml_.element(node, "orientation"), {}), "XYZ"), xml_.vec3(xml_.element(node, "location"), {})}};
      if (xml_.flag(xml_.element(node, "reverse"), false))
        xml_.problem(node, ErrorCode::unsupported, "A reversed joint is not supported.", "Save the model with OpenSim 4.");
    } else {
      above = find_frame(node, socket(node, "socket_parent_frame", "socket_parent_frame_connectee_name"), 0);
      below = find_frame(node, socket(node, "socket_child_frame", "socket_child_frame_connectee_name"), 0);
    }
    if (above.body == -2 || below.body < 0) {
      xml_.problem(node, ErrorCode::unknown,
                   "The " + std::string(above.body == -2 ? "parent" : "child") + " frame of " + xml_.title(node) + " does not exist.",
                   "Name a body, the ground, or a frame in the <frames> of the joint.");
      return;
    }
    OsimBody& body = model_.bodies[at(below.body)];
    if (!body.joint.empty()) {
      xml_.note(node, "A body with two joints keeps its first joint; closed loops are left out.");
      return;
    }
    body.joint = name.empty() ? body.name : name;
    body.parent = above.body;
    body.X_PF = above.X;
    body.X_BM = below.X;
    read_coordinates(node, body);
    set_motion(node, kind, body);
  }

  void read_coordinates(pugi::xml_node joint, OsimBody& body) {
    const pugi::xml_node sets[2] = {joint.child("coordinates"), joint.child("CoordinateSet").child("objects")};
    for (const pugi::xml_node set : sets)
      for (const pugi::xml_node node : set.children("Coordinate")) {
        if (xml_.full()) return;
        OsimCoordinate c;
        c.name = xml_.required_text(xml_.attribute(node, "name"));
        c.rest = xml_.number(xml_.element(node, "default_value"), 0);
        c.locked = xml_.flag(xml_.element(node, "locked"), false);
        std::array<double, 2> range{};
        if (xml_.numbers(xml_.element(node, "range"), range) && range[0] < range[1]) {
          c.lower = range[0];
          c.upper = range[1];
        }
        if (model_.find_coordinate(c.name) >= 0)
          xml_.problem(node, ErrorCode::duplicate, "Two coordinates are named " + in_quotes(c.name) + ".", "Rename one of them.");
        body.coordinates.push_back(static_cast<int>(model_.coordinates.size()));
        model_.coordinates.push_back(std::move(c));
      }
  }

  void set_motion(pugi::xml_node node, std::string_view kind, OsimBody& body) {
    const Vec3 unit[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (std::size_t i = 0; i < 6; ++i) body.motion[i].axis = unit[i % 3];
    if (kind == "CustomJoint") return read_transform(node, body);
    static const std::map<std::string_view, std::vector<int>> axes = {{"WeldJoint", {}},
                                                                      {"PinJoint", {2}},
                                                                      {"SliderJoint", {3}},
                                                                      {"UniversalJoint", {0, 1}},
                                                                      {"BallJoint", {0, 1, 2}},
                                                                      {"GimbalJoint", {0, 1, 2}},
                                                                      {"PlanarJoint", {2, 3, 4}},
                                                                      {"FreeJoint", {0, 1, 2, 3, 4, 5}},
                                                                      {"EllipsoidJoint", {0, 1, 2}}};
    const auto it = axes.find(kind);
    if (it == axes.end()) {
      xml_.note(node, "The joint type <" + std::string(kind) + "> is not supported; the body is fixed to its parent.");
      return;
    }
    if (body.coordinates.size() != it->second.size()) {
      xml_.problem(node, ErrorCode::structure,
                   xml_.title(node) + " has " + std::to_string(body.coordinates.size()) + " coordinates, but a <" + std::string(kind) +
                       "> needs " + std::to_string(it->second.size()) + ".",
                   "Correct the <coordinates>.");
      return;
    }
    for (std::size_t i = 0; i < it->second.size(); ++i) {
      OsimAxis& axis = body.motion[at(it->second[i])];
      axis.coordinates = {body.coordinates[i]};
      axis.function.a = {1, 0};
      model_.coordinates[at(body.coordinates[i])].rotational = it->second[i] < 3;
    }
    if (kind == "EllipsoidJoint") {
      const Vec3 radii = xml_.vec3(xml_.element(node, "radii_x_y_z"), {});
      std::vector<double> q;
      for (const OsimCoordinate& c : model_.coordinates) q.push_back(c.rest);
      const Vec3 n = model_.joint_pose(body, q).R * Vec3{0, 0, 1};
      const double p[3] = {radii.x * n.x, radii.y * n.y, radii.z * n.z};
      for (std::size_t i = 0; i < 3; ++i) body.motion[3 + i].function.a = {p[i]};
      xml_.note(node, "An ellipsoid joint is replaced by a ball joint at its default position.");
    }
  }

  void read_transform(pugi::xml_node joint, OsimBody& body) {
    constexpr std::array<const char*, 6> names = {"rotation1", "rotation2", "rotation3", "translation1", "translation2", "translation3"};
    const pugi::xml_node transform = joint.child("SpatialTransform");
    const pugi::xml_node old = transform.child("TransformAxisSet").child("objects");  // versions 2
    if (!transform) {
      xml_.problem(joint, ErrorCode::structure, xml_.title(joint) + " has no <SpatialTransform>.", "Add it.");
      return;
    }
    for (const pugi::xml_node node : (old ? old : transform).children("TransformAxis")) {
      const std::string name = xml_.text(xml_.attribute(node, "name"));
      const auto slot = std::find(names.begin(), names.end(), name);
      if (slot == names.end()) {
        xml_.note(node, "A <TransformAxis> without a known name is left out.");
        continue;
      }
      const int i = static_cast<int>(slot - names.begin());
      OsimAxis& axis = body.motion[at(i)];
      axis.axis = xml_.direction(xml_.element(node, "axis"), axis.axis);
      const std::string list = xml_.text(xml_.element(node, "coordinates"));
      for (std::size_t from = 0; (from = list.find_first_not_of(" \t\r\n", from)) != std::string::npos;) {
        const std::size_t end = std::min(list.find_first_of(" \t\r\n", from), list.size());
        const int c = model_.find_coordinate(list.substr(from, end - from));
        if (c < 0)
          xml_.problem(node, ErrorCode::unknown, "There is no coordinate " + in_quotes(list.substr(from, end - from)) + ".",
                       "Name a <Coordinate> of the joint.");
        else
          axis.coordinates.push_back(c);
        from = end;
      }
      axis.function = read_function(node, 0);
      if (axis.function.kind == OsimFunction::Kind::linear && !axis.coordinates.empty() &&
          axis.function.a.size() > axis.coordinates.size() + 1)
        xml_.problem(node, ErrorCode::structure, "The linear function has more coefficients than the axis has coordinates.",
                     "Give one slope for each coordinate, and the constant.");
      if (axis.coordinates.size() != 1 && axis.function.kind != OsimFunction::Kind::linear) {
        if (axis.coordinates.size() > 1) xml_.note(node, "A spline of several coordinates is replaced by its value at their defaults.");
        std::vector<double> rest(1, axis.coordinates.empty() ? 0 : model_.coordinates[at(axis.coordinates[0])].rest);
        axis.function = {.a = {axis.function(rest)}};
        axis.coordinates.clear();
      }
      if (i < 3)
        for (const int c : axis.coordinates) model_.coordinates[at(c)].rotational = true;
    }
    for (const OsimAxis& axis : {body.motion[3], body.motion[4], body.motion[5]})  // a coordinate with a slope of 1 is a length
      if (axis.coordinates.size() == 1 && axis.function.kind == OsimFunction::Kind::linear && std::fabs(axis.function.a[0]) == 1 &&
          axis.function.a.size() > 1)
        model_.coordinates[at(axis.coordinates[0])].rotational = false;
  }

  /// Reads the function in a child element of `parent`, or in its <function>. Without one, the function is zero.
  OsimFunction read_function(pugi::xml_node parent, int depth) {
    OsimFunction f;
    if (depth > 20) return f;
    for (const pugi::xml_node node : parent.children()) {
      const std::string_view kind = node.name();
      if (kind == "function" || kind == "coupled_coordinates_function" || kind == "Function") {
        if (node.find_child([](pugi::xml_node n) { return n.type() == pugi::node_element; })) return read_function(node, depth + 1);
        continue;
      }
      if (kind == "MultiplierFunction") {
        f = read_function(node, depth + 1);
        f.scale *= xml_.number(xml_.element(node, "scale"), 1);
        return f;
      }
      if (kind == "Constant") {
        f.a = {xml_.number(xml_.element(node, "value"), 0)};
        return f;
      }
      if (kind == "LinearFunction" || kind == "PolynomialFunction") {
        f.kind = kind[0] == 'L' ? OsimFunction::Kind::linear : OsimFunction::Kind::polynomial;
        f.a = xml_.list(xml_.element(node, "coefficients"), 1, 1000);
        if (f.a.empty()) f.a = {0};
        return f;
      }
      if (kind == "SimmSpline" || kind == "NaturalCubicSpline" || kind == "natCubicSpline" || kind == "GCVSpline" ||
          kind == "PiecewiseLinearFunction") {
        f.a = xml_.list(xml_.element(node, "x"), 1, max_knots);
        f.y = xml_.list(xml_.element(node, "y"), 1, max_knots);
        const bool rises = std::adjacent_find(f.a.begin(), f.a.end(), [](double u, double v) { return !(v - u > 1e-12); }) == f.a.end();
        if (f.a.empty() || f.a.size() != f.y.size() || !rises) {
          xml_.problem(node, ErrorCode::structure, "The knots of the function do not rise, or x and y differ in number.",
                       "Give rising x, and one y for each.");
          return {};
        }
        f.kind = kind[0] == 'P' ? OsimFunction::Kind::lines : OsimFunction::Kind::spline;
        if (f.a.size() == 1) f = {.a = {f.y[0]}};
        if (f.kind == OsimFunction::Kind::spline) f.m = second_derivatives(f.a, f.y);
        return f;
      }
      if (kind.ends_with("Function") || kind.ends_with("Spline"))
        xml_.note(node, "The function <" + std::string(kind) + "> is not supported; it is replaced by zero.");
    }
    return f;
  }

  void read_couplers(pugi::xml_node set) {
    for (const pugi::xml_node node : set.children()) {
      if (node.type() != pugi::node_element) continue;
      if (xml_.flag(xml_.element(node, "isDisabled"), false) || !xml_.flag(xml_.element(node, "isEnforced"), true)) continue;
      if (std::string_view(node.name()) != "CoordinateCouplerConstraint") {
        xml_.note(node, "The constraint <" + std::string(node.name()) + "> is left out.");
        continue;
      }
      const int dependent = model_.find_coordinate(xml_.text(xml_.element(node, "dependent_coordinate_name")));
      const int source = model_.find_coordinate(xml_.text(xml_.element(node, "independent_coordinate_names")));
      if (dependent < 0 || source < 0 || dependent == source) {
        xml_.note(node, "A coupling between other than two coordinates is left out.");
        continue;
      }
      OsimCoordinate& c = model_.coordinates[at(dependent)];
      c.source = source;
      c.coupling = read_function(node, 0);
    }
    for (OsimCoordinate& c : model_.coordinates)  // chains of couplings are cut
      if (c.source >= 0 && model_.coordinates[at(c.source)].source >= 0) c.source = -1;
  }

  void read_contacts(pugi::xml_node set) {
    for (const pugi::xml_node node : set.children("ContactSphere")) {
      std::string path = xml_.text(xml_.element(node, "socket_frame"));
      if (path.empty()) path = xml_.text(xml_.element(node, "body_name"));
      const auto it = index_.find(path.substr(path.find_last_of('/') + 1));
      const double radius = xml_.number(xml_.element(node, "radius"), 0, not_negative);
      if (it == index_.end() || radius == 0) continue;
      model_.bodies[at(it->second)].contacts.push_back({xml_.vec3(xml_.element(node, "location"), {}), radius});
    }
  }

  /// Puts parents before children. Bodies without a joint move freely.
  bool sort_bodies(pugi::xml_node model) {
    const std::size_t n = model_.bodies.size();
    std::vector<int> order, place(n, -1);
    while (order.size() < n) {
      const std::size_t before = order.size();
      for (std::size_t i = 0; i < n; ++i) {
        const int parent = model_.bodies[i].parent;
        if (place[i] >= 0 || (parent >= 0 && place[at(parent)] < 0)) continue;
        place[i] = static_cast<int>(order.size());
        order.push_back(static_cast<int>(i));
      }
      if (order.size() > before) continue;
      xml_.problem(model, ErrorCode::structure, "The joints form a loop of bodies.", "Correct the parents of the joints.");
      return false;
    }
    std::vector<OsimBody> sorted;
    sorted.reserve(n);
    for (const int i : order) {
      sorted.push_back(std::move(model_.bodies[at(i)]));
      if (sorted.back().parent >= 0) sorted.back().parent = place[at(sorted.back().parent)];
    }
    model_.bodies = std::move(sorted);
    return true;
  }

  XmlFields& xml_;
  OsimModel& model_;
  std::map<std::string, int, std::less<>> index_;
};

}  // namespace

double OsimFunction::operator()(std::span<const double> x) const {
  double value = 0;
  const double u = x.empty() ? 0 : x[0];
  switch (kind) {
    case Kind::linear:
      value = a.back();
      for (std::size_t i = 0; i + 1 < a.size() && i < x.size(); ++i) value += a[i] * x[i];
      break;
    case Kind::polynomial:
      for (const double c : a) value = value * u + c;
      break;
    case Kind::lines:
    case Kind::spline: {
      const std::size_t n = a.size();
      const auto above = static_cast<std::size_t>(std::upper_bound(a.begin(), a.end(), u) - a.begin());
      const std::size_t i = std::min(std::max<std::size_t>(above, 1), n - 1) - 1;
      const double h = a[i + 1] - a[i], slope = (y[i + 1] - y[i]) / h;
      if (kind == Kind::lines) {
        value = y[i] + slope * (u - a[i]);
        break;
      }
      const double inside = std::clamp(u, a[i], a[i + 1]), s = inside - a[i], r = a[i + 1] - inside;
      value = (m[i] * r * r * r + m[i + 1] * s * s * s) / (6 * h) + (y[i] / h - m[i] * h / 6) * r + (y[i + 1] / h - m[i + 1] * h / 6) * s;
      const double tangent = (m[i + 1] * s * s - m[i] * r * r) / (2 * h) + slope - (m[i + 1] - m[i]) * h / 6;
      value += tangent * (u - inside);
      break;
    }
  }
  return scale * value;
}

void OsimModel::complete(std::vector<double>& q) const {
  q.resize(coordinates.size());
  for (std::size_t i = 0; i < q.size(); ++i)
    if (coordinates[i].locked) q[i] = coordinates[i].rest;
  for (std::size_t i = 0; i < q.size(); ++i)
    if (const OsimCoordinate& c = coordinates[i]; c.source >= 0) {
      const double x[1] = {q[at(c.source)]};
      q[i] = c.coupling(x);
    }
}

Pose OsimModel::joint_pose(const OsimBody& body, std::span<const double> q) const {
  Pose X;
  std::vector<double> x;
  for (std::size_t i = 0; i < 6; ++i) {
    const OsimAxis& axis = body.motion[i];
    x.clear();
    for (const int c : axis.coordinates) x.push_back(q[at(c)]);
    const double value = axis.function(x);
    if (i < 3)
      X.R = X.R * rotation_about(axis.axis, value);
    else
      X.p += axis.axis * value;
  }
  return X;
}

int OsimModel::find_coordinate(std::string_view wanted) const {
  for (std::size_t i = 0; i < coordinates.size(); ++i)
    if (coordinates[i].name == wanted) return static_cast<int>(i);
  return -1;
}

bool read_osim_model(XmlFields& xml, OsimModel& model) { return Reader(xml, model).read(); }

}  // namespace ugoki::robot_formats
