// Collision analysis: contact points between links, and between links and the ground.

#include <algorithm>
#include <cmath>
#include <memory>

#include "ugoki/collision/scene.h"
#include "ugoki/contact/swept_contacts.h"
#include "ugoki/lsi/declare.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::lsi {
namespace {

struct Collision {
  const World* world;
  collision::Scene scene;
  collision::Workspace workspace;
  std::vector<std::vector<Pose>> poses;  // [characters][links]
  std::vector<std::span<const Pose>> views;
  std::vector<collision::ContactPoint> contacts;
  double margin;  // m: two shapes with a smaller gap than this are in contact
  std::unique_ptr<contact::SweptContacts> swept;
  std::vector<collision::SystemMotion> motions;
  std::vector<double> reach;  // [characters] free body: maximum distance of its shapes from its origin, m; otherwise 0
};

/// True if a body may move farther than half the margin in one step; contacts must then be searched along the motion. Joint velocities in
/// rad/s and m/s have the same limit, because links are about 1 m long.
bool is_fast(const Collision& self, double dt) {
  const double limit = 0.5 * self.margin / dt;
  for (std::size_t i = 0; i < self.motions.size(); ++i) {
    const std::span<const double> v = self.motions[i].v;
    if (self.reach[i] > 0) {
      if (norm(Vec3{v[3], v[4], v[5]}) + norm(Vec3{v[0], v[1], v[2]}) * self.reach[i] > limit) return true;
    } else if (std::ranges::any_of(v, [limit](double x) { return std::fabs(x) > limit; })) {
      return true;
    }
  }
  return false;
}

std::int32_t step(const Call* call) {
  auto& self = object_of<Collision>(call);
  for (const Character& c : self.world->characters())
    calc_poses(*c.mechanism, q_of(c, circuit::input(call, 0)), self.poses[static_cast<std::size_t>(c.index)]);
  self.workspace.forget();  // contacts must depend only on the state, so that a restored run gives the same bits
  collision::find_contacts(self.scene, self.views, self.margin, self.workspace, self.contacts);
  for (const Character& who : self.world->characters())
    self.motions[static_cast<std::size_t>(who.index)] = {q_of(who, circuit::input(call, 0)), v_of(who, circuit::input(call, 0))};
  if (is_fast(self, call->tick->dt)) self.swept->add(self.motions, self.views, call->tick->dt, self.margin, self.contacts);
  const std::size_t room = call->out_count[0];
  if (self.contacts.size() > room) {  // keep the closest contacts; equal distances are ordered by key, so that the order is unique
    std::sort(self.contacts.begin(), self.contacts.end(),
              [](const auto& a, const auto& b) { return a.distance != b.distance ? a.distance < b.distance : a.key < b.key; });
    self.contacts.resize(room);
  }
  auto* out = record_room<ContactRecord>(call->out[0]);
  for (std::size_t i = 0; i < self.contacts.size(); ++i) out[i] = {self.contacts[i], {}, 0};
  set_count(call->out[0], self.contacts.size());
  return 0;
}

void* make(Setup& s) {
  const World* world = world_of(s);
  collision::SceneOptions options;
  options.self_collision = s.boolean("self-collision");
  auto* self =
      new Collision{world, collision::Scene(world->mechanisms(), world->ground(), options), {}, {}, {}, {}, s.number("margin"), {}, {}, {}};
  self->workspace = collision::Workspace(self->scene);
  self->swept = std::make_unique<contact::SweptContacts>(self->scene);
  self->motions.resize(world->characters().size());
  self->reach.resize(world->characters().size());
  for (const collision::SceneShape& shape : self->scene.shapes()) {
    const Mechanism& m = *self->scene.systems()[static_cast<std::size_t>(shape.system)];
    double& reach = self->reach[static_cast<std::size_t>(shape.system)];
    if (m.link_count() == 1 && m.link(0).joint.type == JointType::floating) reach = std::max(reach, norm(shape.shape.X_BS.p) + shape.reach);
  }
  for (const Character& c : world->characters()) self->poses.emplace_back(static_cast<std::size_t>(c.mechanism->link_count()));
  for (const auto& p : self->poses) self->views.emplace_back(p);
  self->contacts.reserve(2 * std::size_t{world->contact_capacity()});
  return self;
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
