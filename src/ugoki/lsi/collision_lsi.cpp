// Collision analysis: contact points between links, and between links and the ground.

#include <algorithm>

#include "ugoki/contact/contact_search.h"
#include "ugoki/lsi/declare.h"

namespace ugoki::lsi {
namespace {

struct Collision {
  Collision(const World& world_, const collision::SceneOptions& options, double margin)
      : world(&world_), scene(world_.mechanisms(), world_.ground(), options), search(scene, margin), motions(world_.characters().size()) {
    search.set_executor(world_.executor());
  }

  const World* world;
  collision::Scene scene;
  contact::ContactSearch search;
  std::vector<collision::SystemMotion> motions;
};

std::int32_t step(const Call* call) {
  auto& self = object_of<Collision>(call);
  for (const Character& who : self.world->characters())
    self.motions[static_cast<std::size_t>(who.index)] = {q_of(who, circuit::input(call, 0)), v_of(who, circuit::input(call, 0))};
  std::vector<collision::ContactPoint>& contacts =
      self.search.find(self.motions, call->tick->dt, self.world->kinematics().at(call->tick->index));
  const std::size_t room = call->out_count[0];
  if (contacts.size() > room) {  // keep the closest contacts; equal distances are ordered by key, so that the order is unique
    std::sort(contacts.begin(), contacts.end(),
              [](const auto& a, const auto& b) { return a.distance != b.distance ? a.distance < b.distance : a.key < b.key; });
    contacts.resize(room);
  }
  auto* out = record_room<ContactRecord>(call->out[0]);
  for (std::size_t i = 0; i < contacts.size(); ++i) out[i] = {contacts[i], {}, 0};
  set_count(call->out[0], contacts.size());
  return 0;
}

void* make(Setup& s) {
  collision::SceneOptions options;
  options.self_collision = s.boolean("self-collision");
  return new Collision(*world_of(s), options, s.number("margin"));
}

}  // namespace

void add_collision(circuit::Library& library) {
  circuit::LsiClass c;
  c.name = "collision analysis";
  c.doc =
      "Finds the points where links touch the ground, other characters and (optionally) links of the same character, or will do so within "
      "one tick.";
  c.inputs = {input_pin("state", PinTypeId::state, "", "Positions and velocities now.")};
  c.outputs = {output_pin("contacts", PinTypeId::contacts, "", "Contact points, with zero forces.")};
  circuit::Parameter self_collision;
  self_collision.name = "self-collision";
  self_collision.kind = circuit::ParameterKind::boolean;
  self_collision.initial = false;
  self_collision.doc = "Whether links of the same character collide with each other.";
  self_collision.live = false;
  c.parameters = {number_parameter("margin", 0.02, 0, 1, "m", "Points closer than this distance become contacts."), self_collision};
  c.configure = [](Setup& s) {
    if (const World* world = world_of(s)) s.set_out(0, world->contact_capacity());
  };
  c.make = make;
  c.destroy = destroy<Collision>;
  c.step = step;
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
