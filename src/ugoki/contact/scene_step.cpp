#include "ugoki/contact/scene_step.h"

#include <algorithm>

namespace ugoki::contact {

SceneStep::SceneStep(const std::vector<MechanismPtr>& systems, const collision::Ground& ground, const StepperOptions& options)
    : stepper_(systems, options), scene_(systems, ground), guard_(scene_, stepper_), touches_itself_(systems.size()) {}

StepReport SceneStep::step(std::span<StepSystem> systems, std::vector<collision::ContactPoint>& contacts, double dt) {
  forces_ = {};
  if (contacts.empty()) {
    const StepReport report = stepper_.step(systems, contacts, dt);
    guard_.set_end(systems);
    return report;
  }
  std::ranges::fill(touches_itself_, char{0});  // self-collision is tested only for systems with contacts between their own links
  for (const collision::ContactPoint& c : contacts)
    if (c.system_a >= 0 && c.system_a == c.system_b) touches_itself_[static_cast<std::size_t>(c.system_a)] = 1;
  for (std::size_t s = 0; s < systems.size(); ++s) scene_.set_self_collision(static_cast<int>(s), touches_itself_[s] != 0);
  guard_.forget();  // a step must depend only on the state, so that a restored run gives the same bits
  const StepReport report = guard_.step(systems, contacts, dt);
  forces_ = guard_.forces();
  const std::span<const collision::ContactPoint> all = guard_.contacts();
  contacts.insert(contacts.end(), all.begin() + static_cast<std::ptrdiff_t>(contacts.size()), all.end());
  return report;
}

}  // namespace ugoki::contact
