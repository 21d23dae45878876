#include "ugoki/content/layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "ugoki/base/number.h"

namespace ugoki::content {
namespace {

using motion_edit::JointKeys;
using motion_edit::JointPart;
using motion_edit::LayerKey;
using motion_edit::LayerMode;
using motion_edit::Tangent;

constexpr std::array<std::string_view, 4> tangents = {"smooth", "linear", "step", "free"};
constexpr std::array<std::string_view, 3> parts = {"joint", "rotation", "position"};
constexpr std::array<std::string_view, 2> modes = {"additive", "replace"};

/// Reads a text that must be one of `names`. @return its index
template <class Enum, std::size_t n>
void read_choice(Fields& f, std::string_view key, const std::array<std::string_view, n>& names, Enum& out) {
  std::string text(names[static_cast<std::size_t>(out)]);
  f.text(key, text);
  const auto found = std::find(names.begin(), names.end(), text);
  if (found != names.end()) {
    out = static_cast<Enum>(found - names.begin());
    return;
  }
  std::string wanted;
  for (const std::string_view name : names) wanted += (wanted.empty() ? "\"" : ", \"") + std::string(name) + "\"";
  f.report(ErrorCode::unknown, f.path(key), "The value '" + text + "' is not known.", "Use one of " + wanted + ".");
}

/// Reads seconds, or null for "no fade", which is stored as -1.
void read_ease(Fields& f, std::string_view key, double& out) {
  if (const Json* value = f.find(key); value && value->is_null())
    out = -1;
  else if (value) {
    f.number(key, out);
    if (!(out >= 0 && out <= 3600))
      f.report(ErrorCode::range, f.path(key), "The value " + ugoki::to_text(out) + " is out of range.",
               "Give 0 to 3600 s, or null for no fade.");
  }
}

/// Reads a list of 1 to 3 numbers. @param components [in and out] wanted number; 0: any, then set
void read_value(Fields& f, std::string_view key, int& components, std::array<double, 3>& out) {
  const Json* list = f.list(key, 3, "components");
  if (!list) return;
  if (list->empty() || (components != 0 && static_cast<int>(list->size()) != components)) {
    f.report(
        ErrorCode::structure, f.path(key), "The value has " + std::to_string(list->size()) + " components.",
        components == 0 ? "Give one to three numbers." : "Give " + std::to_string(components) + ", as for the other keys of this joint.");
    return;
  }
  components = static_cast<int>(list->size());
  out = {};
  if (f.numbers(*list, f.path(key), {out.data(), list->size()}))
    for (double& x : out) x = x == 0 ? 0 : x;  // negative zero becomes zero, so that equal documents have equal text
}

template <class Read>
void read_objects(Fields& parent, std::string_view key, std::size_t max_count, Read read) {
  const Json* list = parent.list(key, max_count, key);
  if (!list) return;
  for (std::size_t i = 0; i < list->size(); ++i) {
    Fields fields((*list)[i], parent.path(key) + "/" + std::to_string(i), parent.problems());
    read(fields);
    fields.refuse_others();
  }
}

Json value_json(const std::array<double, 3>& value, int components) {
  Json out = Json::array();
  for (int k = 0; k < components; ++k) out.push_back(value[static_cast<std::size_t>(k)]);
  return out;
}

}  // namespace

void read_joint(Fields& f, JointKeys& out) {
  f.require("link", "the name of the link that the joint moves");
  f.text("link", out.link);
  read_choice(f, "part", parts, out.part);
}

void read_key(Fields& f, int& components, LayerKey& out) {
  f.require("time", "the time of the key in the motion, in seconds");
  f.number("time", out.time);
  read_value(f, "value", components, out.value);
  read_choice(f, "tangent", tangents, out.tangent);
  read_value(f, "in", components, out.slope_in);
  read_value(f, "out", components, out.slope_out);
  if (out.tangent != Tangent::free) out.slope_in = out.slope_out = {};
}

void read_layer(Fields& f, ScenarioLayer& out) {
  f.text("id", out.id);
  f.text("name", out.name);
  f.boolean("on", out.on);
  read_choice(f, "mode", modes, out.keyed.mode);
  f.number("weight", out.keyed.weight);
  read_ease(f, "ease_in", out.keyed.ease_in);
  read_ease(f, "ease_out", out.keyed.ease_out);
}

void read_layers(Fields& clip, std::vector<ScenarioLayer>& out) {
  out.clear();
  read_objects(clip, "layers", max_layers, [&](Fields& f) {
    ScenarioLayer layer;
    f.require("id", "an id");
    read_layer(f, layer);
    if (layer.name.empty()) layer.name = layer.id;
    read_objects(f, "joints", max_keys, [&](Fields& g) {
      JointKeys joint;
      read_joint(g, joint);
      int components = 0;
      read_objects(g, "keys", max_keys, [&](Fields& h) {
        h.require("value", "one to three numbers");
        read_key(h, components, joint.keys.emplace_back());
      });
      joint.components = std::max(components, 1);
      layer.keyed.joints.push_back(std::move(joint));
    });
    put_in_order(layer);
    out.push_back(std::move(layer));
  });
}

void put_in_order(ScenarioLayer& layer) {
  std::sort(layer.keyed.joints.begin(), layer.keyed.joints.end(),
            [](const JointKeys& a, const JointKeys& b) { return a.link != b.link ? a.link < b.link : a.part < b.part; });
  for (JointKeys& joint : layer.keyed.joints)
    std::sort(joint.keys.begin(), joint.keys.end(), [](const LayerKey& a, const LayerKey& b) { return a.time < b.time; });
}

void check_layers(const std::vector<ScenarioLayer>& layers, const MechanismFacts* mechanism, const std::string& location, Error& problems) {
  std::set<std::string> ids;
  const auto range = [&](const std::string& at, double value, double low, double high, const std::string& unit) {
    if (!(value >= low && value <= high))
      problems.add(ErrorCode::range, at, "The value " + ugoki::to_text(value) + " is out of range.",
                   "Give a value from " + ugoki::to_text(low) + " to " + ugoki::to_text(high) + unit + ".");
  };
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const ScenarioLayer& layer = layers[i];
    const std::string at = location + "/" + std::to_string(i);
    if (!is_id(layer.id))
      problems.add(ErrorCode::syntax, at + "/id", "'" + layer.id + "' cannot be an id.", "Use 1 to 40 letters, digits, '-', '_' or '.'.");
    else if (!ids.insert(layer.id).second)
      problems.add(ErrorCode::duplicate, at + "/id", "Two layers of the clip have the id '" + layer.id + "'.",
                   "Give each layer its own id.");
    if (layer.name.empty() || layer.name.size() > 200)
      problems.add(ErrorCode::range, at + "/name", "The name is empty or longer than 200 bytes.", "Give it a short name.");
    range(at + "/weight", layer.keyed.weight, 0, 1, "");
    const JointKeys* previous = nullptr;
    for (std::size_t j = 0; j < layer.keyed.joints.size(); ++j) {
      const JointKeys& joint = layer.keyed.joints[j];
      const std::string where = at + "/joints/" + std::to_string(j);
      if (previous && previous->link == joint.link && previous->part == joint.part)
        problems.add(ErrorCode::duplicate, where, "The layer has two curves for the same joint of link '" + joint.link + "'.",
                     "Keep one of them.");
      previous = &joint;
      if (mechanism) {
        const auto found = std::find(mechanism->links.begin(), mechanism->links.end(), joint.link);
        const int count =
            found == mechanism->links.end()
                ? 0
                : motion_edit::component_count(mechanism->joints[static_cast<std::size_t>(found - mechanism->links.begin())], joint.part);
        if (found == mechanism->links.end())
          problems.add(ErrorCode::unknown, where + "/link", "Mechanism '" + mechanism->name + "' has no link '" + joint.link + "'.",
                       "Remove these keys, or use a motion of the mechanism for which the layer was made.");
        else if (count != joint.components)
          problems.add(ErrorCode::structure, where,
                       "The keys have " + std::to_string(joint.components) + " components, but the joint of link '" + joint.link +
                           "' needs " + std::to_string(count) + ".",
                       count == 0 ? "Use the parts \"rotation\" and \"position\" for floating joints only, and \"joint\" for all others."
                                  : "Give one number for each DOF.");
      }
      if (joint.keys.empty())
        problems.add(ErrorCode::structure, where + "/keys", "The curve has no key.", "Add a key, or remove the curve.");
      for (std::size_t k = 0; k < joint.keys.size(); ++k) {
        const LayerKey& key = joint.keys[k];
        const std::string key_at = where + "/keys/" + std::to_string(k);
        range(key_at + "/time", key.time, 0, 86400, " s");
        for (const double x : key.value) range(key_at + "/value", x, -1000, 1000, "");
        for (const auto* slopes : {&key.slope_in, &key.slope_out})
          for (const double x : *slopes) range(key_at + "/" + (slopes == &key.slope_in ? "in" : "out"), x, -1e6, 1e6, " per second");
        if (k > 0 && key.time - joint.keys[k - 1].time < motion_edit::min_key_distance)
          problems.add(ErrorCode::duplicate, key_at + "/time", "Two keys of one joint are less than 0.5 ms apart.", "Remove one of them.");
      }
    }
  }
}

Json to_json(const ScenarioLayer& layer) {
  const motion_edit::KeyedLayer& keyed = layer.keyed;
  const auto ease = [](double seconds) { return seconds < 0 ? Json(nullptr) : Json(seconds); };
  Json joints = Json::array();
  for (const JointKeys& joint : keyed.joints) {
    Json keys = Json::array();
    for (const LayerKey& key : joint.keys) {
      Json item = {{"time", key.time}, {"value", value_json(key.value, joint.components)}};
      if (key.tangent != Tangent::smooth) item["tangent"] = tangents[static_cast<std::size_t>(key.tangent)];
      if (key.tangent == Tangent::free) {
        item["in"] = value_json(key.slope_in, joint.components);
        item["out"] = value_json(key.slope_out, joint.components);
      }
      keys.push_back(std::move(item));
    }
    Json item = {{"link", joint.link}};
    if (joint.part != JointPart::whole) item["part"] = parts[static_cast<std::size_t>(joint.part)];
    item["keys"] = std::move(keys);
    joints.push_back(std::move(item));
  }
  Json json = {{"id", layer.id},
               {"name", layer.name},
               {"mode", modes[static_cast<std::size_t>(keyed.mode)]},
               {"weight", keyed.weight},
               {"ease_in", ease(keyed.ease_in)},
               {"ease_out", ease(keyed.ease_out)},
               {"joints", std::move(joints)}};
  if (!layer.on) json["on"] = false;
  return json;
}

}  // namespace ugoki::content
