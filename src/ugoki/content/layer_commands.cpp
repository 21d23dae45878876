#include "ugoki/content/layer_commands.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/content/layers.h"

namespace ugoki::content {
namespace {

using motion_edit::JointKeys;
using motion_edit::LayerKey;

ScenarioLayer* layer_in(Fields& f, ScenarioClip& clip) {
  std::string id;
  f.require("layer", "the layer's id");
  f.text("layer", id);
  for (ScenarioLayer& layer : clip.layers)
    if (layer.id == id) return &layer;
  if (f.problems().empty())
    f.report(ErrorCode::unknown, f.path("layer"), "The clip has no layer '" + id + "'.", "It may have been removed; reload the document.");
  return nullptr;
}

std::vector<JointKeys>::iterator find_joint(ScenarioLayer& layer, const JointKeys& wanted) {
  return std::find_if(layer.keyed.joints.begin(), layer.keyed.joints.end(),
                      [&](const JointKeys& j) { return j.link == wanted.link && j.part == wanted.part; });
}

std::vector<LayerKey>::iterator find_key(JointKeys& joint, double time) {
  return std::find_if(joint.keys.begin(), joint.keys.end(),
                      [&](const LayerKey& key) { return std::fabs(key.time - time) < motion_edit::min_key_distance; });
}

/// Calls work(fields) for each object of the list in field `key`.
template <class Work>
void each(Fields& f, std::string_view key, Work work) {
  const Json* list = f.list(key, max_keys, "keys");
  for (std::size_t i = 0; list && i < list->size() && f.problems().empty(); ++i) {
    Fields fields((*list)[i], f.path(key) + "/" + std::to_string(i), f.problems());
    work(fields);
    fields.refuse_others();
  }
}

}  // namespace

std::string add_layer(Fields& f, ScenarioClip& clip, const std::string& free_id, std::string& id) {
  ScenarioLayer layer;
  f.require("value", "an object with the fields of the layer");
  if (const Json* object = f.find("value")) {
    Fields g(*object, f.path("value"), f.problems());
    read_layer(g, layer);
    g.refuse_others();
  }
  if (layer.id.empty()) layer.id = free_id;
  if (layer.name.empty()) layer.name = "Layer " + std::to_string(clip.layers.size() + 1);
  int at = static_cast<int>(clip.layers.size());
  f.integer("at", at);
  if (!f.problems().empty()) return {};
  id = layer.id;
  clip.layers.insert(clip.layers.begin() + std::clamp(at, 0, static_cast<int>(clip.layers.size())), std::move(layer));
  return "Add layer";
}

std::string set_layer(Fields& f, ScenarioClip& clip) {
  ScenarioLayer* layer = layer_in(f, clip);
  f.require("value", "an object with the fields to change");
  const Json* object = f.find("value");
  if (!layer || !object) return {};
  const ScenarioLayer before = *layer;
  Fields g(*object, f.path("value"), f.problems());
  read_layer(g, *layer);
  g.refuse_others();
  layer->id = before.id;
  if (layer->on != before.on) return layer->on ? "Switch on layer" : "Switch off layer";
  if (layer->name != before.name) return "Rename layer";
  if (layer->keyed.weight != before.keyed.weight) return "Set weight of layer";
  return "Change layer";
}

std::string remove_layer(Fields& f, ScenarioClip& clip) {
  if (const ScenarioLayer* layer = layer_in(f, clip)) clip.layers.erase(clip.layers.begin() + (layer - clip.layers.data()));
  return "Remove layer";
}

std::string move_layer(Fields& f, ScenarioClip& clip) {
  const ScenarioLayer* layer = layer_in(f, clip);
  int at = 0;
  f.require("at", "the new index in the list of layers");
  f.integer("at", at);
  if (!layer || !f.problems().empty()) return {};
  const std::ptrdiff_t from = layer - clip.layers.data();
  ScenarioLayer moved = clip.layers[static_cast<std::size_t>(from)];
  clip.layers.erase(clip.layers.begin() + from);
  clip.layers.insert(clip.layers.begin() + std::clamp(at, 0, static_cast<int>(clip.layers.size())), std::move(moved));
  return "Move layer";
}

std::string edit_keys(Fields& f, ScenarioClip& clip) {
  ScenarioLayer* layer = layer_in(f, clip);
  std::string label;
  f.text("label", label);
  if (!layer) return {};
  std::size_t taken = 0, put = 0;
  each(f, "take", [&](Fields& g) {
    JointKeys joint;
    double time = 0;
    read_joint(g, joint);
    g.require("time", "the time of the key in the motion, in seconds");
    g.number("time", time);
    const auto own = find_joint(*layer, joint);
    const auto key = own != layer->keyed.joints.end() ? find_key(*own, time) : std::vector<LayerKey>::iterator{};
    if (own == layer->keyed.joints.end() || key == own->keys.end()) {
      g.report(ErrorCode::unknown, g.path("time"), "The joint of link '" + joint.link + "' has no key at " + ugoki::to_text(time) + " s.",
               "Reload the document.");
      return;
    }
    own->keys.erase(key);
    ++taken;
  });
  each(f, "put", [&](Fields& g) {
    JointKeys joint;
    read_joint(g, joint);
    double time = 0;
    g.number("time", time);
    auto own = find_joint(*layer, joint);
    if (own == layer->keyed.joints.end()) own = layer->keyed.joints.insert(own, joint);
    auto key = find_key(*own, time);
    int components = own->keys.empty() ? 0 : own->components;
    LayerKey changed = key != own->keys.end() ? *key : LayerKey{};
    if (key == own->keys.end()) g.require("value", "one number for each DOF of the joint");
    read_key(g, components, changed);
    own->components = std::max(components, 1);
    if (key != own->keys.end())
      *key = changed;
    else
      own->keys.push_back(changed);
    ++put;
  });
  std::erase_if(layer->keyed.joints, [](const JointKeys& joint) { return joint.keys.empty(); });
  put_in_order(*layer);
  if (!label.empty()) return label.substr(0, 200);
  return put > 0 ? (taken > 0 ? "Move keys" : "Set key") : "Remove keys";
}

}  // namespace ugoki::content
