#include "ugoki/scene_formats/fbx_core.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "ugoki/formats/text.h"
#include "ugoki/scene_formats/fbx_mesh_ends.h"
#include "ugoki/scene_formats/fbx_tree.h"
#include "ugoki/scene_formats/fbx_writer.h"

namespace ugoki::scene_formats {
namespace {

using Names = std::initializer_list<std::string_view>;
template <class Range>
bool one_of(std::string_view name, const Range& names) {
  return std::ranges::find(names, name) != names.end();
}
bool one_of(std::string_view name, Names names) { return std::ranges::find(names, name) != names.end(); }

constexpr double max_number = 1e30;  // maximum magnitude of a number in the file; the results of assimp are checked separately
constexpr std::int64_t max_time = 46'186'158'000 * 1'000'000;  // one million seconds, in FBX time units of 1/46186158000 s
constexpr std::size_t max_depth = 400;                         // maximum depth of nested models; bounds the recursion in assimp

enum class Kind : std::uint8_t { model, attribute, mesh, skin, cluster, stack, layer, curve_node, curve };

/// An object of the file that the skeleton needs.
struct Object {
  Kind kind;
  const FbxRecord* record;
  std::vector<std::int64_t> times;  ///< [keys] of a curve, strictly increasing, 1/46186158000 s
  std::vector<float> values;        ///< [keys] of a curve
  bool kept = true;                 ///< false: the object is not written
  bool spanned = true;              ///< of a stack: its span of time is written
};

/// Returns the kind of an object; std::nullopt if the skeleton does not need the object.
std::optional<Kind> kind_of(const FbxRecord& r) {
  const std::string_view tag = r.text(2);
  if (r.name == "Model" && !one_of(tag, {"IKEffector", "FKEffector"})) return Kind::model;
  if (r.name == "NodeAttribute" && one_of(tag, {"LimbNode", "Null"})) return Kind::attribute;
  if (r.name == "Geometry" && tag == "Mesh") return Kind::mesh;
  if (r.name == "Deformer" && tag == "Skin") return Kind::skin;
  if (r.name == "Deformer" && tag == "Cluster") return Kind::cluster;
  if (r.name == "AnimationStack") return Kind::stack;
  if (r.name == "AnimationLayer") return Kind::layer;
  if (r.name == "AnimationCurveNode") return Kind::curve_node;
  if (r.name == "AnimationCurve") return Kind::curve;
  return std::nullopt;
}

/// True if assimp uses a connection between objects of these kinds. @param property the connection ends at a property of the target
bool may_connect(Kind from, Kind to, bool property) {
  constexpr std::pair<Kind, Kind> plain[] = {{Kind::model, Kind::model}, {Kind::attribute, Kind::model}, {Kind::mesh, Kind::model},
                                             {Kind::skin, Kind::mesh},   {Kind::cluster, Kind::skin},    {Kind::model, Kind::cluster},
                                             {Kind::layer, Kind::stack}, {Kind::curve_node, Kind::layer}};
  constexpr std::pair<Kind, Kind> to_property[] = {{Kind::curve_node, Kind::model}, {Kind::curve, Kind::curve_node}};
  const std::pair<Kind, Kind> pair{from, to};
  return property ? std::ranges::find(to_property, pair) != std::end(to_property) : std::ranges::find(plain, pair) != std::end(plain);
}

/// Selects, checks and writes the objects.
class Core {
 public:
  explicit Core(std::string_view location) : location_(location), file_(location) {}

  Result<std::string> make(std::string_view bytes, std::map<std::string, Vec3>* mesh_ends) {
    // ASCII files before version 7 have another syntax.
    if (bytes.starts_with("; FBX 6.") || bytes.starts_with("; FBX 5.")) return refuse_version("6100 or earlier");
    if (Result<void> done = file_.load(bytes); !done) return fail(std::move(done.error()));
    if (file_.version() < 7100) return refuse_version(std::to_string(file_.version()));
    for (const auto step : {&Core::collect_objects, &Core::collect_connections, &Core::check_tree, &Core::check_turns, &Core::check_spans})
      if (Result<void> done = (this->*step)(); !done) return fail(std::move(done.error()));
    if (mesh_ends) *mesh_ends = fbx_mesh_ends(file_, skin_parts(), rigid_meshes());
    write();
    return out_.take();
  }

 private:
  struct Connection {
    std::int64_t from, to;
    std::string_view property;
  };

  [[nodiscard]] std::unexpected<Error> refuse_version(const std::string& version) const {
    return fail(ErrorCode::unsupported, location_,
                "The file cannot be read as FBX: its version is " + version + ", but 7100 or later is needed.",
                "Export it again as FBX 2011 or later, or as glTF or BVH.");
  }

  Result<void> collect_objects() {
    const FbxRecord* objects = file_.root().child("Objects");
    if (!objects) return fail(ErrorCode::structure, location_, "The file cannot be read as FBX: it has no objects.", "Export it again.");
    for (const FbxRecord& r : objects->children) {
      const std::optional<Kind> kind = kind_of(r);
      if (!kind) continue;
      if (r.values.size() < 3 || r.values[0].kind != FbxValue::Kind::number || r.values[0].whole == 0)
        return file_.refuse(r, ErrorCode::structure, "The object has no valid id, name and class.");
      Object object{*kind, &r, {}, {}};
      if (*kind == Kind::curve)
        if (Result<void> done = read_curve(object); !done) return done;
      if (*kind == Kind::cluster) object.kept = has_weights(r);
      objects_.insert_or_assign(r.values[0].whole, std::move(object));  // of several objects with the same id, the last one is used
    }
    return {};
  }

  static bool has_weights(const FbxRecord& cluster) {
    const FbxRecord* indexes = cluster.child("Indexes");
    if (!indexes || indexes->values.empty()) return false;
    const FbxValue& first = indexes->values[0];
    return first.kind == FbxValue::Kind::number || first.count > 0;
  }

  Result<void> read_curve(Object& curve) {
    const FbxRecord *times = curve.record->child("KeyTime"), *values = curve.record->child("KeyValueFloat");
    if (!times || !values) return file_.refuse(*curve.record, ErrorCode::structure, "The curve has no KeyTime or no KeyValueFloat.");
    const Result<std::vector<std::int64_t>> t = file_.integers(*times);
    const Result<std::vector<double>> x = file_.numbers(*values, max_number);
    if (!t) return fail(t.error());
    if (!x) return fail(x.error());
    if (t->size() != x->size())
      return file_.refuse(*curve.record, ErrorCode::structure,
                          "The curve has " + std::to_string(t->size()) + " times, but " + std::to_string(x->size()) + " values.");
    for (std::size_t i = 0; i < t->size(); ++i) {
      const std::int64_t time = (*t)[i];
      if (time < -max_time || time > max_time)
        return file_.refuse(*times, ErrorCode::range, "The magnitude of a key time exceeds one million seconds.");
      if (!curve.times.empty() && time < curve.times.back()) return file_.refuse(*times, ErrorCode::structure, "The key times decrease.");
      if (!curve.times.empty() && time == curve.times.back()) {  // of two keys with the same time, the later one is used
        curve.values.back() = static_cast<float>((*x)[i]);
        continue;
      }
      curve.times.push_back(time);
      curve.values.push_back(static_cast<float>((*x)[i]));
    }
    curve.kept = !curve.times.empty();
    return {};
  }

  Result<void> collect_connections() {
    const FbxRecord* all = file_.root().child("Connections");
    if (!all) return {};
    for (const FbxRecord& r : all->children) {
      const std::string_view how = r.text(0);
      const bool property = how == "OP";
      if ((how != "OO" && !property) || r.values.size() < (property ? 4u : 3u) || r.values[1].kind != FbxValue::Kind::number ||
          r.values[2].kind != FbxValue::Kind::number)
        continue;
      const std::int64_t from = r.values[1].whole, to = r.values[2].whole;
      const auto a = objects_.find(from), b = objects_.find(to);
      if (a == objects_.end() || !a->second.kept || (to != 0 && (b == objects_.end() || !b->second.kept))) continue;
      if (to == 0 ? a->second.kind != Kind::model || property : !may_connect(a->second.kind, b->second.kind, property)) continue;
      if (property && r.text(3).empty()) continue;
      connections_.push_back({from, to, property ? r.text(3) : std::string_view()});
      if (a->second.kind == Kind::model && (to == 0 || b->second.kind == Kind::model)) below_.emplace(to, from);
    }
    return {};
  }

  /// Name of a model as assimp gives it to the node: without the class that binary files append and ASCII files put in front.
  static std::string node_name(const FbxRecord& model) {
    std::string_view text = model.text(1);
    text = text.substr(0, text.find('\0'));
    if (text.starts_with("Model::")) text.remove_prefix(7);
    return std::string(text);
  }

  /// The clusters of all skins with the mesh and the bone to which they are connected.
  [[nodiscard]] std::vector<FbxSkinPart> skin_parts() const {
    std::map<std::int64_t, std::int64_t> skin_of, mesh_of;  // of a cluster, of a skin
    for (const Connection& c : connections_) {
      const Kind from = objects_.at(c.from).kind;
      if (from == Kind::cluster) skin_of[c.from] = c.to;
      if (from == Kind::skin) mesh_of[c.from] = c.to;
    }
    std::vector<FbxSkinPart> out;
    for (const Connection& c : connections_) {
      if (c.to == 0 || objects_.at(c.from).kind != Kind::model || objects_.at(c.to).kind != Kind::cluster) continue;
      const auto skin = skin_of.find(c.to);
      const auto mesh = skin == skin_of.end() ? mesh_of.end() : mesh_of.find(skin->second);
      if (mesh == mesh_of.end()) continue;
      out.push_back({objects_.at(mesh->second).record, objects_.at(c.to).record, node_name(*objects_.at(c.from).record)});
    }
    return out;
  }

  /// The meshes without a skin, each with the model that carries it.
  [[nodiscard]] std::vector<FbxRigidMesh> rigid_meshes() const {
    std::set<std::int64_t> skinned;
    for (const Connection& c : connections_)
      if (objects_.at(c.from).kind == Kind::skin) skinned.insert(c.to);
    std::vector<FbxRigidMesh> out;
    for (const Connection& c : connections_) {
      if (c.to == 0 || objects_.at(c.from).kind != Kind::mesh || objects_.at(c.to).kind != Kind::model || skinned.contains(c.from))
        continue;
      const FbxRecord* model = objects_.at(c.to).record;
      out.push_back({objects_.at(c.from).record, model, node_name(*model)});
    }
    return out;
  }

  /// Checks the hierarchy of models: no cycle, and not too many nodes.
  Result<void> check_tree() {
    std::vector<std::pair<std::int64_t, std::size_t>> open = {{0, 0}};  // ids of models to visit, with their depth
    for (std::size_t count = 0; !open.empty(); ++count) {
      const auto [id, depth] = open.back();
      open.pop_back();
      if (depth > max_depth)
        return file_.refuse(*objects_.at(id).record, ErrorCode::structure, "The model is its own ancestor, or nested too deeply.");
      if (count > 20 * formats::max_joints)
        return fail(ErrorCode::range, location_, "The file has more than " + std::to_string(20 * formats::max_joints) + " nodes.",
                    "Export the skeleton only.");
      for (auto [it, end] = below_.equal_range(id); it != end; ++it) open.emplace_back(it->second, depth + 1);
    }
    return {};
  }

  /// Checks rotation curves. assimp splits rotations between keys into small pieces, so the total angle of a curve must be bounded.
  Result<void> check_turns() {
    std::set<std::int64_t> turning;
    for (const Connection& c : connections_)
      if (c.property.contains("Rotation")) turning.insert(c.from);
    for (const Connection& c : connections_) {
      const Object& curve = objects_.at(c.from);
      if (curve.kind != Kind::curve || !turning.contains(c.to)) continue;
      double turns = 0;
      for (std::size_t i = 1; i < curve.values.size(); ++i)
        turns += std::fabs(static_cast<double>(curve.values[i]) - static_cast<double>(curve.values[i - 1])) / 360;
      if (turns > 1e5 || std::ranges::any_of(curve.values, [](float x) { return std::fabs(x) > 1e7F; }))
        return file_.refuse(*curve.record, ErrorCode::range, "The rotation curve makes more than 100,000 turns.");
    }
    return {};
  }

  /// Leaves out the spans of stacks (LocalStart to LocalStop) that contain no key of some of their animated properties. assimp reads only
  /// the keys in the span, and stops the process if a property has none. Without a span, the stack lasts from its first to its last key.
  Result<void> check_spans() {
    constexpr std::int64_t tolerance = 10'000;  // of assimp around the span
    std::map<std::int64_t, std::int64_t> stack_of, layer_of;
    for (const Connection& c : connections_) {
      const Kind from = objects_.at(c.from).kind;
      if (from == Kind::layer) stack_of[c.from] = c.to;
      if (from == Kind::curve_node && c.property.empty()) layer_of[c.from] = c.to;
    }
    for (const Connection& c : connections_) {
      const Object& curve = objects_.at(c.from);
      const auto layer = layer_of.find(c.to);
      const auto stack = layer == layer_of.end() ? stack_of.end() : stack_of.find(layer->second);
      if (curve.kind != Kind::curve || stack == stack_of.end()) continue;
      Object& owner = objects_.at(stack->second);
      const std::int64_t start = time_of(*owner.record, "LocalStart"), stop = time_of(*owner.record, "LocalStop");
      if (start == 0 && stop == 0) continue;  // no span
      const auto first = std::ranges::lower_bound(curve.times, start - tolerance);
      if (first == curve.times.end() || *first > stop + tolerance) owner.spanned = false;
    }
    return {};
  }
  /// A time in the properties of a stack, 1/46186158000 s, at most a third of the largest number; 0 if it does not exist.
  static std::int64_t time_of(const FbxRecord& stack, std::string_view name) {
    constexpr std::int64_t largest = std::numeric_limits<std::int64_t>::max() / 3;
    if (const FbxRecord* all = stack.child("Properties70"))
      for (const FbxRecord& p : all->children)
        if (p.text(0) == name && p.text(1) == "KTime" && p.values.size() > 4) return std::clamp(p.values[4].whole, -largest, largest);
    return 0;
  }

  void write() {
    out_.begin("FBXHeaderExtension");
    out_.begin("FBXVersion");
    out_.integer(7400);
    out_.end();
    out_.end();
    write_settings();
    write_definitions();
    out_.begin("Objects");
    out_.scope();
    // Objects are written in file order, because the nodes and animations of the result keep this order.
    for (const FbxRecord& r : file_.root().child("Objects")->children) {
      const auto it = kind_of(r) ? objects_.find(r.values[0].whole) : objects_.end();
      if (it != objects_.end() && it->second.record == &r && it->second.kept) write_object(it->first, it->second);
    }
    out_.end();
    out_.begin("Connections");
    out_.scope();
    for (const Connection& c : connections_) {
      out_.begin("C");
      out_.text(c.property.empty() ? "OO" : "OP");
      out_.long_integer(c.from);
      out_.long_integer(c.to);
      if (!c.property.empty()) out_.text(c.property);
      out_.end();
    }
    out_.end();
  }

  void write_settings() {
    const FbxRecord* settings = file_.root().child("GlobalSettings");
    if (!settings) return;
    out_.begin("GlobalSettings");
    write_properties(*settings, Names{"UpAxis", "UpAxisSign", "FrontAxis", "FrontAxisSign", "CoordAxis", "CoordAxisSign", "UnitScaleFactor",
                                      "OriginalUnitScaleFactor", "TimeMode", "TimeSpanStart", "TimeSpanStop", "CustomFrameRate"});
    out_.end();
  }

  static constexpr std::array<std::string_view, 15> model_properties = {
      "Lcl Translation", "Lcl Rotation",         "Lcl Scaling",       "PreRotation",      "PostRotation",
      "RotationOffset",  "RotationPivot",        "ScalingOffset",     "ScalingPivot",     "RotationOrder",
      "InheritType",     "GeometricTranslation", "GeometricRotation", "GeometricScaling", "RotationActive"};

  /// Writes the default properties of models (PropertyTemplate).
  void write_definitions() {
    const FbxRecord* definitions = file_.root().child("Definitions");
    if (!definitions) return;
    for (const FbxRecord& type : definitions->children) {
      const FbxRecord* model = type.name == "ObjectType" && type.text(0) == "Model" ? type.child("PropertyTemplate") : nullptr;
      if (!model || model->text(0).empty()) continue;
      out_.begin("Definitions");
      out_.begin("ObjectType");
      out_.text("Model");
      out_.begin("PropertyTemplate");
      out_.text(model->text(0));
      write_properties(*model, model_properties);
      out_.end();
      out_.end();
      out_.end();
      return;
    }
  }

  void write_object(std::int64_t id, const Object& object) {
    out_.begin(object.record->name);
    out_.long_integer(id);
    out_.text(object.record->text(1));
    out_.text(object.record->text(2));
    out_.scope();
    switch (object.kind) {
      case Kind::model: write_properties(*object.record, model_properties); break;
      case Kind::mesh: write_triangle(); break;
      case Kind::cluster: write_cluster(); break;
      case Kind::stack:
        if (object.spanned) write_properties(*object.record, Names{"LocalStart", "LocalStop", "ReferenceStart", "ReferenceStop"});
        break;
      case Kind::curve_node: write_properties(*object.record, Names{"d", "d|X", "d|Y", "d|Z"}); break;
      case Kind::curve:
        write_array("KeyTime", 'l', object.times);
        write_array("KeyValueFloat", 'f', object.values);
        break;
      default: write_array("Version", 'i', std::vector<std::int32_t>{100}); break;
    }
    out_.end();
  }

  template <class T>
  void write_array(std::string_view name, char type, const std::vector<T>& numbers) {
    out_.begin(name);
    out_.array(type, numbers);
    out_.end();
  }
  /// Writes one triangle in place of a mesh, because only the existence of the mesh matters.
  void write_triangle() {
    write_array("Vertices", 'd', std::vector<double>{0, 0, 0, 1, 0, 0, 0, 1, 0});
    write_array("PolygonVertexIndex", 'i', std::vector<std::int32_t>{0, 1, -3});
  }
  void write_cluster() {
    const std::vector<double> identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    write_array("Indexes", 'i', std::vector<std::int32_t>{0});
    write_array("Weights", 'd', std::vector<double>{1});
    write_array("Transform", 'd', identity);
    write_array("TransformLink", 'd', identity);
  }

  /// Writes the properties of `record` whose names are in `names` and whose values fit their type.
  template <class Range>
  void write_properties(const FbxRecord& record, const Range& names) {
    out_.begin("Properties70");
    out_.scope();
    if (const FbxRecord* all = record.child("Properties70"))
      for (const FbxRecord& p : all->children)
        if (p.name == "P" && one_of(p.text(0), names)) write_property(p);
    out_.end();
  }
  void write_property(const FbxRecord& p) {
    const std::string_view type = p.text(1), name = p.text(0);
    const bool vector = one_of(type, {"Vector3D", "Vector", "Lcl Translation", "Lcl Rotation", "Lcl Scaling", "ColorRGB", "Color"});
    const bool real = one_of(type, {"double", "Number", "float", "Float", "UnitScaleFactor"});
    const bool whole = one_of(type, {"bool", "Bool", "int", "Int", "enum", "Enum", "Integer"}), time = type == "KTime";
    const std::size_t count = vector ? 3 : 1;
    if ((!vector && !real && !whole && !time) || p.values.size() < 4 + count) return;
    for (std::size_t i = 4; i < 4 + count; ++i)
      if (p.values[i].kind != FbxValue::Kind::number || !(std::fabs(p.values[i].number) <= max_number)) return;
    const FbxValue& first = p.values[4];
    const std::int64_t max_integer = time ? max_time : 1'000'000;
    if ((whole || time) && (first.whole < -max_integer || first.whole > max_integer)) return;
    if (name.ends_with("Axis") && (first.whole < 0 || first.whole > 2)) return;
    if (name == "TimeMode" && (first.whole < 0 || first.whole > 14)) return;
    if (name == "CustomFrameRate" && !(first.number > 0 && first.number <= 1e6)) return;
    out_.begin("P");
    for (std::size_t i = 0; i < 4; ++i) out_.text(p.text(i));
    for (std::size_t i = 4; i < 4 + count; ++i) {
      if (whole)
        out_.integer(static_cast<std::int32_t>(first.whole));
      else if (time)
        out_.long_integer(first.whole);
      else
        out_.number(p.values[i].number);
    }
    out_.end();
  }

  std::string location_;
  FbxFile file_;
  std::map<std::int64_t, Object> objects_;
  std::vector<Connection> connections_;
  std::multimap<std::int64_t, std::int64_t> below_;  ///< id of a parent model -> id of its child model
  FbxWriter out_;
};

}  // namespace

Result<std::string> fbx_core(std::span<const std::byte> bytes, std::string_view location, std::map<std::string, Vec3>* mesh_ends) {
  return Core(location).make({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, mesh_ends);
}

}  // namespace ugoki::scene_formats
