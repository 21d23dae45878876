#include "ugoki/content/layered_motions.h"

#include <memory>

#include "ugoki/base/hash.h"
#include "ugoki/content/layers.h"

namespace ugoki::content {
namespace {

/// The layers of the clip that have an effect.
std::vector<motion_edit::KeyedLayer> active_layers(const ScenarioClip& clip) {
  std::vector<motion_edit::KeyedLayer> out;
  for (const ScenarioLayer& layer : clip.layers)
    if (layer.on && layer.keyed.weight > 0 && !layer.keyed.joints.empty()) out.push_back(layer.keyed);
  return out;
}

std::string id_of(const ScenarioClip& clip) {
  std::string text = clip.motion + (clip.loop ? " loop" : "");
  for (const ScenarioLayer& layer : clip.layers) text += "\n" + to_text(to_json(layer));
  Hash64 hash;
  hash.add_bytes(text.data(), text.size());
  return "l-" + hash.hex();
}

}  // namespace

Result<MotionPtr> layered_motion(const ScenarioClip& clip, const Mechanism& mechanism, const MotionPtr& motion) {
  const std::vector<motion_edit::KeyedLayer> layers = active_layers(clip);
  if (layers.empty()) return motion;
  Result<Motion> made = motion_edit::apply_layers(mechanism, *motion, layers, clip.loop);
  if (!made) return fail(std::move(made.error()));
  return std::make_shared<const Motion>(std::move(*made));
}

Result<LayeredContent> apply_layers(const Scenario& scenario, const Resources& resources) {
  LayeredContent out{scenario, resources};
  for (ScenarioCharacter& c : out.scenario.characters) {
    const auto mechanism = resources.mechanisms.find(c.mechanism);
    for (ScenarioClip& clip : c.track) {
      const auto motion = resources.motions.find(clip.motion);
      if (clip.layers.empty() || mechanism == resources.mechanisms.end() || motion == resources.motions.end()) continue;
      if (!active_layers(clip).empty()) {
        const std::string id = id_of(clip);
        if (!out.resources.motions.contains(id)) {
          Result<MotionPtr> made = layered_motion(clip, *mechanism->second, motion->second);
          if (!made) return fail(std::move(made.error()));
          out.resources.motions[id] = std::move(*made);
        }
        clip.motion = id;
      }
      clip.layers.clear();
    }
  }
  return out;
}

}  // namespace ugoki::content
