#include "ugoki/content/generate.h"

#include <algorithm>
#include <set>

#include "ugoki/content/default_circuit.h"
#include "ugoki/content/flatten.h"
#include "ugoki/content/json_fields.h"
#include "ugoki/content/layered_motions.h"
#include "ugoki/content/secondary_motion.h"
#include "ugoki/content/track.h"
#include "ugoki/content/ugx.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/motion/torques.h"

namespace ugoki::content {

void add_props(const Scenario& scenario, Resources& resources) {
  const auto add = [&](const ScenarioCharacter& c) {
    if (c.prop && !resources.mechanisms.contains(c.mechanism)) {
      const auto mesh = resources.mechanisms.find(c.prop->mesh);
      const bool of_mesh = c.prop->shape == PropShape::mesh;
      if (of_mesh && (mesh == resources.mechanisms.end() || !is_mesh_body(*mesh->second))) return;  // check_scenario() reports it
      resources.mechanisms.emplace(c.mechanism, make_prop(*c.prop, of_mesh ? mesh->second : nullptr));
    }
  };
  for_each_scenario(scenario, [&](const Scenario& s) { std::ranges::for_each(s.characters, add); });
}

MechanismFacts facts_of(const Mechanism& mechanism) {
  MechanismFacts facts;
  facts.name = mechanism.name();
  facts.nq = mechanism.nq();
  facts.free_root = mechanism.link_count() > 0 && mechanism.link(0).joint.type == JointType::floating;
  for (const Link& link : mechanism.links()) {
    facts.links.push_back(link.name);
    facts.joints.push_back(link.joint.type);
    if (!link.label.empty()) facts.labels.push_back(link.label);
  }
  facts.mesh_body = is_mesh_body(mechanism);
  return facts;
}

MotionFacts facts_of(const Motion& motion) {
  const MotionTorques* const torques = torques_of(motion);
  return {motion.name, motion.duration(), motion.nq, motion.cyclic, torques ? torques->step : 0};
}

Catalogue catalogue_of(const Resources& resources) {
  Catalogue catalogue;
  for (const auto& [id, mechanism] : resources.mechanisms) catalogue.mechanisms.emplace(id, facts_of(*mechanism));
  for (const auto& [id, motion] : resources.motions) catalogue.motions.emplace(id, facts_of(*motion));
  return catalogue;
}

int find_link(const Mechanism& mechanism, std::string_view text) {
  if (const int named = mechanism.find_link(text); named >= 0) return named;
  for (int i = 0; i < mechanism.link_count(); ++i)
    if (!text.empty() && mechanism.link(i).label == text) return i;
  return -1;
}

Result<std::vector<std::byte>> generate(const Scenario& scenario, const Resources& unlayered) {
  Scenario document = scenario;
  put_in_order(document);
  const Catalogue catalogue = catalogue_of(unlayered);
  Error problems = check_scenario(document, &catalogue);
  if (!problems.empty()) return fail(std::move(problems));
  Result<LayeredContent> layered = apply_layers(played_part(std::move(document)), unlayered);
  if (!layered) return fail(std::move(layered.error()));
  document = std::move(layered->scenario);
  Resources& resources = layered->resources;
  add_props(document, resources);
  for (ScenarioCharacter& c : document.characters) c.prop.reset();  // for the player, a prop is a character like any other

  std::set<std::string> mechanisms, motions;
  for (const ScenarioCharacter& c : document.characters) {
    mechanisms.insert(c.mechanism);
    const auto add_motion = [&](const std::string& id) {
      motions.insert(id);
      for (Problem& p : check_motion(*resources.motions.at(id), *resources.mechanisms.at(c.mechanism)).problems)
        problems.problems.push_back(std::move(p));
    };
    for (const ScenarioClip& clip : c.track) add_motion(clip.motion);
    for (const Rule* rule : play_rules(document, c.id)) add_motion(rule->action.motion);
  }
  if (!problems.empty()) return fail(std::move(problems));

  std::vector<double> placements;
  for (const ScenarioCharacter& c : document.characters) {
    const Mechanism& mechanism = *resources.mechanisms.at(c.mechanism);
    const std::vector<Clip> track = lay_track(c, mechanism, resources);
    for (const Clip& clip : track)
      placements.insert(placements.end(), {clip.placement.x, clip.placement.y, clip.placement.z, clip.placement.heading});
    if (c.secondary.empty()) continue;
    const Result<MechanismPtr> sprung = with_secondary_motion(c, mechanism, start_position(c, mechanism, track, resources), document);
    if (!sprung) return fail(sprung.error());
  }

  UgxWriter writer;
  const Json head = {{"generator", "ugoki 0.1.0"}, {"project", document.name}};
  writer.add("head", head.dump(-1, ' ', false, Json::error_handler_t::replace));
  writer.add("circuit", document.circuit.empty() ? default_circuit(document) : document.circuit);
  document.circuit.clear();
  writer.add("scenario", write_scenario(document));
  const auto* bytes = reinterpret_cast<const std::byte*>(placements.data());
  writer.add("placements", std::vector<std::byte>(bytes, bytes + placements.size() * sizeof(double)));
  for (const std::string& id : mechanisms) writer.add("mechanism/" + id, formats::write_mechanism(*resources.mechanisms.at(id)));
  for (const std::string& id : motions) writer.add("motion/" + id, formats::write_motion(*resources.motions.at(id)));
  return writer.finish();
}

}  // namespace ugoki::content
