#include "ugoki/content/secondary_motion.h"

#include "ugoki/content/generate.h"
#include "ugoki/dynamics/spring_chains.h"

namespace ugoki::content {

Result<MechanismPtr> with_secondary_motion(const ScenarioCharacter& c, const Mechanism& mechanism, std::span<const double> q0,
                                           const Scenario& scenario) {
  if (c.secondary.empty()) return MechanismPtr();
  // The pose in which the springs rest: that of time 0, except for the chains that rest in their neutral position. These keep the
  // orientation in which their parent is at time 0, so that gravity has the same direction.
  std::vector<double> rest(q0.begin(), q0.end());
  std::vector<dynamics::SpringChain> chains;
  std::vector<unsigned char> neutral(mechanism.links().size(), 0);
  for (const ScenarioSecondary& s : c.secondary) {
    const int link = find_link(mechanism, s.link);
    chains.push_back({link, s.frequency, s.damping});
    if (s.neutral) neutral[static_cast<std::size_t>(link)] = 1;
  }
  for (std::size_t i = 0; i < neutral.size(); ++i) {
    const Link& link = mechanism.links()[i];
    if (link.parent >= 0 && neutral[static_cast<std::size_t>(link.parent)]) neutral[i] = 1;
    if (neutral[i]) joint_neutral(link.joint, rest.data() + link.q_index);
  }
  Result<MechanismPtr> sprung = dynamics::with_spring_chains(mechanism, chains, rest, scenario.gravity, scenario.step);
  if (!sprung)
    for (Problem& p : sprung.error().problems) p.location = "character '" + c.id + "', " + p.location;
  return sprung;
}

}  // namespace ugoki::content
