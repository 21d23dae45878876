#include "ugoki/scene_formats/collada_core.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>

#include "ugoki/base/number.h"
#include "ugoki/formats/text.h"
#include "ugoki/scene_formats/collada_values.h"

namespace ugoki::scene_formats {
namespace {

using pugi::xml_node;
using Names = std::initializer_list<std::string_view>;

bool one_of(std::string_view name, Names names) { return std::ranges::find(names, name) != names.end(); }

/// Removes all child elements of `node` except those named in `names`; also removes its texts, unless `text` is true.
void keep_children(xml_node node, Names names, bool text = false) {
  for (xml_node child = node.first_child(); child;) {
    const xml_node next = child.next_sibling();
    const bool wanted = child.type() == pugi::node_element ? one_of(child.name(), names) : text;
    if (!wanted) node.remove_child(child);
    child = next;
  }
}

/// Sets an attribute; adds it if it does not exist.
void set(xml_node node, const char* attribute, const std::string& value) {
  pugi::xml_attribute a = node.attribute(attribute);
  if (!a) a = node.append_attribute(attribute);
  a.set_value(value.c_str());
}

/// Adds a <source> with an array and an accessor under `parent`.
/// @param words number of words in `text`
/// @param count, stride, size of the accessor: number of values, words from one value to the next, words in a value
void add_source(xml_node parent, const std::string& id, const char* array, std::size_t words, const std::string& text, std::size_t count,
                std::size_t stride, std::size_t size) {
  xml_node source = parent.append_child("source");
  set(source, "id", id);
  xml_node values = source.append_child(array);
  set(values, "id", id + "-array");
  set(values, "count", std::to_string(words));
  values.text().set(text.c_str());
  xml_node accessor = source.append_child("technique_common").append_child("accessor");
  set(accessor, "source", "#" + id + "-array");
  set(accessor, "count", std::to_string(count));
  set(accessor, "stride", std::to_string(stride));
  for (std::size_t i = 0; i < size; ++i) {
    xml_node param = accessor.append_child("param");
    set(param, "name", size == 3 ? std::string(1, static_cast<char>('X' + i)) : "V");
    set(param, "type", std::string_view(array) == "float_array" ? "float" : "name");
  }
}

/// Adds an <input> that refers to a source.
void add_input(xml_node parent, const char* semantic, const std::string& source, int offset = -1) {
  xml_node input = parent.append_child("input");
  set(input, "semantic", semantic);
  set(input, "source", "#" + source);
  if (offset >= 0) set(input, "offset", std::to_string(offset));
}

/// Returns the <input> of `node` with this semantic; empty if there is none.
xml_node input_of(xml_node node, std::string_view semantic) {
  for (const xml_node input : node.children("input"))
    if (input.attribute("semantic").value() == semantic) return input;
  return {};
}

/// Returns the count of numbers in a transformation element of this name; 0 if the name is not that of a transformation.
std::size_t numbers_of(std::string_view name) {
  if (name == "translate" || name == "scale") return 3;
  if (name == "rotate") return 4;
  if (name == "skew") return 7;
  if (name == "lookat") return 9;
  return name == "matrix" ? 16 : 0;
}

/// The target of a channel: "node/transformation.ANGLE" or "node/transformation(3)(0)".
struct Target {
  std::string node, transformation;
  std::size_t first = 0;  ///< index, within the values of the transformation element, of the first value that the channel animates
};
/// Parses the target of a channel; std::nullopt if the text has another form.
std::optional<Target> target_of(std::string_view text) {
  const std::size_t slash = text.find('/'), dot = text.find('.'), bracket = text.find('(');
  constexpr auto none = std::string_view::npos;
  if (slash == none || text.find('/', slash + 1) != none || (dot != none && text.find('.', dot + 1) != none)) return std::nullopt;
  Target out{std::string(text.substr(0, slash)), std::string(text.substr(slash + 1)), 0};
  if (dot != none && dot > slash) {
    out.transformation = text.substr(slash + 1, dot - slash - 1);
    const std::string_view part = text.substr(dot + 1);
    out.first = part == "ANGLE" ? 3 : part == "Y" ? 1 : part == "Z" ? 2 : 0;
  }
  if (bracket != none) {
    if (bracket < slash) return std::nullopt;
    out.transformation = text.substr(slash + 1, bracket - slash - 1);
    const std::string_view part = text.substr(bracket);
    const bool whole = part.size() == 6 && part[2] == ')' && part[3] == '(' && part[5] == ')' && part[1] >= '0' && part[1] <= '3' &&
                       part[4] >= '0' && part[4] <= '3';
    out.first = whole ? static_cast<std::size_t>(part[1] - '0') + 4 * static_cast<std::size_t>(part[4] - '0') : 0;
  }
  return out;
}

/// Cleans and checks the libraries of the document one by one: removes data that the skeleton does not need, checks all other data.
class Core {
 public:
  explicit Core(std::string_view location) : document_(location) {}

  Result<std::string> make(std::span<const std::byte> bytes) {
    if (Result<void> done = document_.load(reinterpret_cast<const char*>(bytes.data()), bytes.size()); !done)
      return fail(std::move(done.error()));
    const xml_node root = document_.root();
    keep_children(root, {"asset", "library_animations", "library_controllers", "library_geometries", "library_nodes",
                         "library_visual_scenes", "scene"});
    clean_asset();
    for (const auto step :
         {&Core::clean_geometries, &Core::clean_controllers, &Core::clean_scenes, &Core::check_instances, &Core::clean_animations})
      if (Result<void> done = (this->*step)(); !done) return fail(std::move(done.error()));
    std::ostringstream out;
    document_.document().save(out, "", pugi::format_raw | pugi::format_no_declaration, pugi::encoding_utf8);
    return std::move(out).str();
  }

 private:
  void clean_asset() {
    for (const xml_node asset : document_.root().children("asset")) {
      keep_children(asset, {"unit", "up_axis"});
      for (xml_node unit : asset.children("unit")) {
        const std::optional<double> metres = parse_double(unit.attribute("meter").value());
        if (!metres || !(*metres >= 1e-9 && *metres <= 1e9)) unit.remove_attribute("meter");
      }
    }
  }

  /// Replaces each mesh that has faces by one triangle, because only the existence of the mesh matters.
  Result<void> clean_geometries() {
    for (const xml_node library : document_.root().children("library_geometries")) {
      keep_children(library, {"geometry"});
      for (xml_node geometry : library.children("geometry")) {
        const bool faces = has_faces(geometry.child("mesh"));
        const std::string old = geometry.attribute("id").value(), id = "geometry" + std::to_string(++made_);
        geometry.remove_children();
        if (!old.empty()) geometries_.emplace(old, id);
        set(geometry, "id", id);
        xml_node mesh = geometry.append_child("mesh");
        if (!faces) continue;
        add_source(mesh, id + "-points", "float_array", 9, "0 0 0 1 0 0 0 1 0", 3, 3, 3);
        xml_node vertices = mesh.append_child("vertices");
        set(vertices, "id", id + "-vertices");
        add_input(vertices, "POSITION", id + "-points");
        xml_node triangles = mesh.append_child("triangles");
        set(triangles, "count", "1");
        add_input(triangles, "VERTEX", id + "-vertices", 0);
        triangles.append_child("p").text().set("0 1 2");
      }
    }
    return {};
  }
  static bool has_faces(xml_node mesh) {
    for (const xml_node group : mesh.children())
      if (one_of(group.name(), {"lines", "linestrips", "polygons", "polylist", "triangles", "trifans", "tristrips"}) &&
          std::string_view(group.attribute("count").value()) != "0")
        for (const xml_node p : group.children("p"))
          if (!words_in(p).empty()) return true;
    return false;
  }

  /// Replaces each skin by a list of its weighted joints, and removes all other controllers.
  Result<void> clean_controllers() {
    std::map<std::string, std::string, std::less<>> morphs;
    for (const xml_node library : document_.root().children("library_controllers"))
      for (const xml_node controller : library.children("controller"))
        if (const xml_node morph = controller.child("morph"))
          morphs.emplace(controller.attribute("id").value(), std::string(local_id(morph, "source")));
    const auto geometry_of = [&](std::string id) {
      for (int hops = 0; hops < 8 && morphs.contains(id); ++hops) id = morphs.find(id)->second;
      const auto found = geometries_.find(id);
      return found == geometries_.end() ? std::string() : found->second;
    };
    for (const auto& [id, source] : morphs) geometry_instead_[id] = geometry_of(id);
    for (xml_node library : document_.root().children("library_controllers")) {
      for (xml_node controller = library.first_child(); controller;) {
        const xml_node next = controller.next_sibling();
        const std::string old = controller.attribute("id").value();
        const xml_node skin = controller.child("skin");
        std::vector<std::string> joints;
        if (skin && std::string_view(controller.name()) == "controller") {
          Result<std::vector<std::string>> joint_names = joints_of(skin);
          if (!joint_names) return fail(std::move(joint_names.error()));
          joints = std::move(*joint_names);
          const std::string geometry = geometry_of(std::string(local_id(skin, "source")));
          geometry_instead_.emplace(old, geometry);
          if (geometry.empty()) joints.clear();
          if (!joints.empty()) write_skin(controller, old, geometry, joints);
        }
        if (joints.empty()) library.remove_child(controller);
        controller = next;
      }
    }
    return {};
  }

  /// Returns the names of the joints that have a positive weight for at least one vertex.
  Result<std::vector<std::string>> joints_of(xml_node skin) {
    const xml_node weighted = skin.child("vertex_weights");
    const xml_node names_in = input_of(weighted, "JOINT"), weights_in = input_of(weighted, "WEIGHT");
    if (!weighted || !names_in || !weights_in)
      return document_.refuse(skin, ErrorCode::structure, "The skin has no vertex weights with inputs JOINT and WEIGHT.");
    const Result<ColladaValues> names = document_.values_of(names_in), weights = document_.values_of(weights_in);
    if (!names) return fail(names.error());
    if (!weights) return fail(weights.error());
    if (!names->text || weights->text)
      return document_.refuse(weighted, ErrorCode::structure, "The joints of the skin must be names, and its weights numbers.");
    std::size_t columns = 1;
    for (const xml_node input : weighted.children("input")) {
      const Result<std::size_t> offset = document_.count_of(input, "offset", 0);
      if (!offset) return fail(offset.error());
      columns = std::max(columns, *offset + 1);
    }
    const std::size_t name_column = *document_.count_of(names_in, "offset", 0),
                      weight_column = *document_.count_of(weights_in, "offset", 0);
    const std::vector<std::string_view> table = words_in(weighted.child("v"));
    std::size_t pairs = 0;
    for (const std::string_view word : words_in(weighted.child("vcount"))) {
      const std::optional<long> n = parse_long(word);
      if (!n || *n < 0 || *n > 1'000'000)
        return document_.refuse(weighted.child("vcount"), ErrorCode::syntax, formats::in_quotes(word) + " is not a valid count.");
      pairs += static_cast<std::size_t>(*n);
    }
    if (columns > 16 || pairs * columns > table.size())
      return document_.refuse(weighted, ErrorCode::truncated, "The <v> of the skin is shorter than its <vcount> requires.");
    std::set<std::size_t> used;
    for (std::size_t i = 0; i < pairs; ++i) {
      const std::optional<long> joint = parse_long(table[i * columns + name_column]),
                                weight = parse_long(table[i * columns + weight_column]);
      if (joint == -1) continue;  // -1: the weight belongs to no joint
      if (!joint || !weight || *joint < 0 || *weight < 0 || static_cast<std::size_t>(*joint) >= names->count ||
          static_cast<std::size_t>(*weight) >= weights->count)
        return document_.refuse(weighted.child("v"), ErrorCode::range,
                                "Pair " + std::to_string(i + 1) + " of <v> refers to a joint or a weight that does not exist.");
      const Result<double> x = document_.number(weights_in, weights->word(static_cast<std::size_t>(*weight), 0));
      if (!x) return fail(x.error());
      if (*x > 0) used.insert(static_cast<std::size_t>(*joint));
    }
    std::vector<std::string> out;
    out.reserve(used.size());
    for (const std::size_t joint : used) out.emplace_back(names->word(joint, 0));
    return out;
  }

  void write_skin(xml_node controller, const std::string& old, const std::string& geometry, const std::vector<std::string>& joints) {
    const std::string id = "controller" + std::to_string(++made_), identity = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";
    skins_.emplace(old, id);
    controller.remove_children();
    set(controller, "id", id);
    xml_node skin = controller.append_child("skin");
    set(skin, "source", "#" + geometry);
    skin.append_child("bind_shape_matrix").text().set(identity.c_str());
    std::string names, matrices, pairs;
    for (std::size_t i = 0; i < joints.size(); ++i) {
      names += (i ? " " : "") + joints[i];
      matrices += (i ? " " : "") + identity;
      pairs += (i ? " " : "") + std::to_string(i) + " 0";
    }
    add_source(skin, id + "-joints", "Name_array", joints.size(), names, joints.size(), 1, 1);
    add_source(skin, id + "-matrices", "float_array", 16 * joints.size(), matrices, joints.size(), 16, 16);
    add_source(skin, id + "-weights", "float_array", 1, "1", 1, 1, 1);
    xml_node list = skin.append_child("joints");
    add_input(list, "JOINT", id + "-joints");
    add_input(list, "INV_BIND_MATRIX", id + "-matrices");
    xml_node weights = skin.append_child("vertex_weights");
    set(weights, "count", "3");
    add_input(weights, "JOINT", id + "-joints", 0);
    add_input(weights, "WEIGHT", id + "-weights", 1);
    weights.append_child("vcount").text().set((std::to_string(joints.size()) + " 0 0").c_str());
    weights.append_child("v").text().set(pairs.c_str());
  }

  /// Cleans the visual scenes and library nodes, and checks the references of <scene>.
  Result<void> clean_scenes() {
    const xml_node root = document_.root();
    for (xml_node library : root.children("library_visual_scenes")) {
      keep_children(library, {"visual_scene"});
      for (xml_node scene : library.children("visual_scene"))
        if (Result<void> done = clean_node(scene); !done) return done;
    }
    for (xml_node library : root.children("library_nodes")) {
      keep_children(library, {"node"});
      for (xml_node node : library.children("node"))
        if (Result<void> done = clean_node(node); !done) return done;
    }
    for (xml_node scene : root.children("scene")) {
      keep_children(scene, {"instance_visual_scene"});
      for (const xml_node instance : scene.children("instance_visual_scene"))
        if (!named_.contains(local_id(instance, "url")))
          return document_.refuse(
              instance, ErrorCode::structure,
              "The element refers to the scene " + formats::in_quotes(instance.attribute("url").value()) + ", which does not exist.");
    }
    return {};
  }

  /// Cleans a node or scene with all its descendants. The recursion is bounded, because load() has limited the depth of the document.
  Result<void> clean_node(xml_node node) {
    keep_children(node, {"node", "translate", "rotate", "scale", "matrix", "skew", "lookat", "instance_node", "instance_geometry",
                         "instance_controller"});
    const std::string id = node.attribute("id").value(), name = node.attribute("name").value();
    named_.emplace(id, node);
    if (name != id) named_.emplace(name, node);
    for (xml_node child = node.first_child(); child;) {
      const xml_node next = child.next_sibling();
      const std::string_view kind = child.name();
      if (kind == "node") {
        if (Result<void> done = clean_node(child); !done) return done;
      } else if (const std::size_t count = numbers_of(kind); count > 0) {
        if (Result<void> done = check_transformation(child, count); !done) return done;
        transformations_.insert({id, child.attribute("sid").value()});
      } else if (kind != "instance_node" && !instance_shape(child)) {
        node.remove_child(child);
      }
      child = next;
    }
    return {};
  }

  Result<void> check_transformation(xml_node node, std::size_t count) {
    const std::vector<std::string_view> words = words_in(node);
    if (words.size() < count)
      return document_.refuse(node, ErrorCode::truncated,
                              "The transformation has " + std::to_string(words.size()) + " of " + std::to_string(count) + " numbers.");
    for (std::size_t i = 0; i < count; ++i)
      if (const Result<double> x = document_.number(node, words[i]); !x) return fail(x.error());
    return {};
  }

  /// Sets the url of an instance to the id of the skin or geometry that replaces its target. Returns false if there is no such replacement.
  bool instance_shape(xml_node instance) {
    const std::string_view old = local_id(instance, "url");
    instance.remove_children();
    std::string id;
    if (const auto skin = skins_.find(old); skin != skins_.end())
      id = skin->second;
    else if (const auto shape = geometry_instead_.find(old); shape != geometry_instead_.end())
      id = shape->second;
    else if (const auto geometry = geometries_.find(old); geometry != geometries_.end())
      id = geometry->second;
    set(instance, "url", "#" + id);
    return !id.empty();
  }

  /// Checks <instance_node> elements: no cycle, and not too many nodes in total.
  Result<void> check_instances() {
    std::vector<std::pair<xml_node, std::size_t>> open;  // nodes to visit, with their depth
    for (const xml_node library : document_.root().children("library_visual_scenes"))
      for (const xml_node scene : library.children("visual_scene")) open.emplace_back(scene, 0);
    std::vector<xml_node> dead;
    for (std::size_t count = 0; !open.empty(); ++count) {
      const auto [node, depth] = open.back();
      open.pop_back();
      if (depth > formats::max_depth)
        return document_.refuse(node, ErrorCode::structure, "The node is its own ancestor through <instance_node>, or nested too deeply.");
      if (count > 20 * formats::max_joints)
        return document_.refuse(node, ErrorCode::range, "With all <instance_node> elements expanded there are too many nodes.");
      for (const xml_node child : node.children()) {
        const std::string_view kind = child.name();
        if (kind == "node") open.emplace_back(child, depth + 1);
        if (kind != "instance_node") continue;
        const auto [first, last] = named_.equal_range(local_id(child, "url"));
        const auto found = std::distance(first, last);
        if (found > 1)
          return document_.refuse(
              child, ErrorCode::structure,
              "The element refers to " + formats::in_quotes(child.attribute("url").value()) + ", but several nodes have this name.");
        if (found == 1)
          open.emplace_back(first->second, depth + 1);
        else
          dead.push_back(child);
      }
    }
    for (xml_node child : dead) child.set_name("extra");
    return {};
  }

  Result<void> clean_animations() {
    for (xml_node library : document_.root().children("library_animations")) {
      keep_children(library, {"animation"});
      for (const xml_node animation : library.children("animation"))
        if (Result<void> done = clean_animation(animation); !done) return done;
    }
    for (const xml_node node : replaced_) node.parent().remove_child(node);
    return {};
  }

  /// Keeps the channels that animate a node, each with a sampler and sources of its own, and cleans nested animations.
  Result<void> clean_animation(xml_node animation) {
    struct Channel {
      std::string target;
      ColladaValues times, values;
    };
    std::vector<Channel> channels;
    for (const xml_node channel : animation.children("channel")) {
      const std::optional<Target> target = target_of(channel.attribute("target").value());
      if (!target || !transformations_.contains({target->node, target->transformation})) continue;
      const xml_node sampler = animation.find_child_by_attribute("sampler", "id", std::string(local_id(channel, "source")).c_str());
      if (!sampler) continue;
      Result<ColladaValues> times = document_.values_of(input_of(sampler, "INPUT")),
                            values = document_.values_of(input_of(sampler, "OUTPUT"));
      if (!times) return fail(std::move(times.error()));
      if (!values) return fail(std::move(values.error()));
      if (times->count == 0 && values->count == 0) continue;
      if (Result<void> done = check_keys(channel, *target, *times, *values); !done) return done;
      channels.push_back({channel.attribute("target").value(), std::move(*times), std::move(*values)});
    }
    // The original elements are removed after all channels are written, because other channels may use their sources.
    for (const xml_node child : animation.children())
      if (std::string_view(child.name()) != "animation") replaced_.push_back(child);
    for (const Channel& c : channels) write_channel(animation, c.target, c.times, c.values);
    for (const xml_node child : animation.children("animation"))
      if (Result<void> done = clean_animation(child); !done) return done;
    return {};
  }

  /// Checks the times and values of a channel.
  Result<void> check_keys(xml_node channel, const Target& target, const ColladaValues& times, const ColladaValues& values) {
    if (times.text || values.text)
      return document_.refuse(channel, ErrorCode::structure, "The times or values of the channel are names, not numbers.");
    if (times.count != values.count)
      return document_.refuse(
          channel, ErrorCode::structure,
          "The channel has " + std::to_string(times.count) + " times, but " + std::to_string(values.count) + " values.");
    if (target.first + values.size > 16)
      return document_.refuse(channel, ErrorCode::range, "The values of the channel have more components than their target.");
    float before = 0, angle_before = 0;
    double turns = 0;
    for (std::size_t k = 0; k < times.count; ++k) {
      const Result<double> time = document_.number(channel, times.word(k, 0));
      if (!time) return fail(time.error());
      for (std::size_t i = 0; i < values.size; ++i)
        if (const Result<double> x = document_.number(channel, values.word(k, i)); !x) return fail(x.error());
      const auto t = static_cast<float>(*time), angle = static_cast<float>(*document_.number(channel, values.word(k, 0)));
      if (k > 0 && t < before) return document_.refuse(channel, ErrorCode::structure, "The times of the channel decrease.");
      if (k > 0 && t > before && target.first == 3) {
        // assimp inserts keys every quarter turn between keys that are more than half a turn apart. The times of the inserted keys must be
        // distinct in single precision.
        const double quarters = std::fabs(static_cast<double>(angle) - static_cast<double>(angle_before)) / 90;
        const double room = 8 * static_cast<double>(std::numeric_limits<float>::epsilon()) * std::max(std::fabs(before), std::fabs(t));
        turns += quarters;
        if (turns > 1e6 || (quarters > 1.9 && (static_cast<double>(t) - static_cast<double>(before)) < quarters * (room + 1e-30)))
          return document_.refuse(channel, ErrorCode::range, "The channel makes too many turns in too short a time.");
      }
      before = t;
      angle_before = angle;
    }
    return {};
  }

  void write_channel(xml_node animation, const std::string& target, const ColladaValues& times, const ColladaValues& values) {
    const std::string id = "channel" + std::to_string(++made_);
    const auto write = [&](const std::string& name, const ColladaValues& v) {
      std::string text;
      for (std::size_t k = 0; k < v.count; ++k)
        for (std::size_t i = 0; i < v.size; ++i) text.append(text.empty() ? "" : " ").append(v.word(k, i));
      add_source(animation, name, "float_array", v.count * v.size, text, v.count, v.size, v.size);
    };
    write(id + "-times", times);
    write(id + "-values", values);
    xml_node sampler = animation.append_child("sampler");
    set(sampler, "id", id);
    add_input(sampler, "INPUT", id + "-times");
    add_input(sampler, "OUTPUT", id + "-values");
    xml_node channel = animation.append_child("channel");
    set(channel, "source", "#" + id);
    set(channel, "target", target);
  }

  ColladaDocument document_;
  int made_ = 0;
  std::map<std::string, std::string, std::less<>> geometries_;        ///< original id -> new id
  std::map<std::string, std::string, std::less<>> skins_;             ///< original id -> new id
  std::map<std::string, std::string, std::less<>> geometry_instead_;  ///< controller -> id of its geometry, used if the controller has no
                                                                      ///< joints
  std::multimap<std::string, xml_node, std::less<>> named_;           ///< nodes and scenes; keys: their ids and their names
  std::set<std::pair<std::string, std::string>> transformations_;     ///< of each transformation: id of its node, and its sid
  std::vector<xml_node> replaced_;                                    ///< original contents of the animations, to be removed
};

}  // namespace

Result<std::string> collada_core(std::span<const std::byte> bytes, std::string_view location) { return Core(location).make(bytes); }

int collada_up_axis(std::string_view document) {
  const std::size_t at = document.find("<up_axis>");
  const std::string_view axis = at == std::string_view::npos ? std::string_view("Y_UP") : document.substr(at + 9, 20);
  return axis.find("Z_UP") != std::string_view::npos ? 2 : axis.find("X_UP") != std::string_view::npos ? 0 : 1;
}

}  // namespace ugoki::scene_formats
