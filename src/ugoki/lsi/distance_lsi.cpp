// Distance between two links (successive Gilbert), closest points of two characters, and collision impulses.
//
// The LSI's state is the warm start of the next query: plain bytes that are saved and restored with the circuit. A restored run therefore
// gives the same bits as an uninterrupted run.

#include <type_traits>

#include "ugoki/collision/collider.h"
#include "ugoki/collision/pair_distance.h"
#include "ugoki/contact/collision_impulse.h"
#include "ugoki/lsi/declare.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::lsi {
namespace {

using circuit::input;
using circuit::output;

void put(const Vec3& v, double* to) {
  to[0] = v.x;
  to[1] = v.y;
  to[2] = v.z;
}

/// One shape of a link.
struct Part {
  collision::Collider collider;
  int link;
};

/// The shapes of one of the two link systems whose distance is computed, or of one link of a system.
struct Side {
  const Character* character = nullptr;
  std::vector<Part> parts;
  std::vector<Pose> X_WB;  // [links] world poses of the system's links

  void move_to(const double* state) { calc_poses(*character->mechanism, q_of(*character, state), X_WB); }
  /// World pose of the shape with index `part`.
  [[nodiscard]] Pose pose(std::size_t part) const {
    return X_WB[static_cast<std::size_t>(parts[part].link)] * parts[part].collider.shape.X_BS;
  }
};

/// Collects the shapes of a character's links. @param link index of the only link to use; -1: all links
Side make_side(const Character& who, int link) {
  Side side;
  side.character = &who;
  side.X_WB.resize(static_cast<std::size_t>(who.mechanism->link_count()));
  for (int l = 0; l < who.mechanism->link_count(); ++l) {
    if (link >= 0 && l != link) continue;
    for (const Shape& shape : who.mechanism->link(l).shapes) side.parts.push_back({collision::make_collider(shape), l});
  }
  return side;
}

/// Warm start of the next query: the closest pair of shapes found by the last query.
struct Warm {
  std::int32_t a = 0, b = 0;  // indices of the two shapes (parts)
  collision::PairCache cache;
};
static_assert(std::is_trivially_copyable_v<Warm>);

struct Distance {
  Side a, b;
  collision::DistanceWorkspace workspace;
};

/// Lower bound of the distance between two shapes [m]: the distance between their bounding spheres.
double min_distance(const Part& a, const Pose& X_a, const Part& b, const Pose& X_b) {
  return norm(X_a * a.collider.centre - X_b * b.collider.centre) - a.collider.bound - b.collider.bound;
}

std::int32_t distance(const Call* call) {
  auto& self = object_of<Distance>(call);
  self.a.move_to(input(call, 0));
  self.b.move_to(input(call, 0));
  constexpr double any = std::numeric_limits<double>::infinity();
  Warm warm;
  std::memcpy(&warm, call->state, sizeof warm);
  const auto [first_a, first_b] = std::pair(static_cast<std::size_t>(warm.a), static_cast<std::size_t>(warm.b));
  collision::PairDistance best = find_pair_distance(self.a.parts[first_a].collider, self.a.pose(first_a), self.b.parts[first_b].collider,
                                                    self.b.pose(first_b), any, warm.cache, self.workspace);
  for (std::size_t i = 0; i < self.a.parts.size(); ++i) {
    const Pose X_a = self.a.pose(i);
    for (std::size_t k = 0; k < self.b.parts.size(); ++k) {
      if (i == first_a && k == first_b) continue;
      const Pose X_b = self.b.pose(k);
      if (min_distance(self.a.parts[i], X_a, self.b.parts[k], X_b) >= best.distance) continue;
      collision::PairCache cache;
      const collision::PairDistance d =
          find_pair_distance(self.a.parts[i].collider, X_a, self.b.parts[k].collider, X_b, best.distance, cache, self.workspace);
      if (!d.exact || d.distance >= best.distance) continue;
      best = d;
      warm = {static_cast<std::int32_t>(i), static_cast<std::int32_t>(k), cache};
    }
  }
  if (best.method == collision::DistanceMethod::none)
    return circuit::stop(call, "The distance is undefined, because a position is not finite.");
  std::memcpy(call->state, &warm, sizeof warm);
  *output(call, 0) = best.distance;
  put(best.pa, output(call, 1));
  put(best.pb, output(call, 2));
  put(best.n, output(call, 3));
  *output(call, 4) = self.a.parts[static_cast<std::size_t>(warm.a)].link;
  *output(call, 5) = self.b.parts[static_cast<std::size_t>(warm.b)].link;
  return 0;
}

circuit::Parameter text_parameter(std::string name, std::string doc) {
  circuit::Parameter p;
  p.name = std::move(name);
  p.kind = circuit::ParameterKind::text;
  p.initial = std::string();
  p.doc = std::move(doc);
  p.live = false;
  return p;
}

/// Returns the index of the link that the parameter `name` names, by its name or label; -1: all links. Reports an unknown link, and a link
/// without shapes.
int link_of(Setup& s, const Character* who, const char* name) {
  const std::string& text = s.text(name);
  if (!who || (text.empty() && s.lsi_class().name == "closest pair")) return -1;
  const Mechanism& m = *who->mechanism;
  int link = m.find_link(text);
  for (int i = 0; link < 0 && i < m.link_count(); ++i)
    if (!text.empty() && m.link(i).label == text) link = i;
  if (link < 0)
    s.fail(ErrorCode::unknown, "'" + who->id + "' has no link '" + s.text(name) + "'.", "Use the name of one of its links.");
  else if (who->mechanism->link(link).shapes.empty())
    s.fail(ErrorCode::structure, "The link '" + s.text(name) + "' of '" + who->id + "' has no shape.", "Use a link that has a shape.");
  return link;
}

void configure_distance(Setup& s) {
  const Character *a = s.resource<Character>(s.text("character")), *b = s.resource<Character>(s.text("other"));
  (void)link_of(s, a, "link");
  (void)link_of(s, b, "other link");
  for (const Character* who : {a, b})
    if (who && make_side(*who, -1).parts.empty())
      s.fail(ErrorCode::structure, "'" + who->id + "' has no shapes.", "Use a character that has shapes.");
}

void* make_distance(Setup& s) {
  const Character *a = s.resource<Character>(s.text("character")), *b = s.resource<Character>(s.text("other"));
  return new Distance{make_side(*a, link_of(s, a, "link")), make_side(*b, link_of(s, b, "other link")), {}};
}

circuit::LsiClass distance_class(std::string name, std::string doc) {
  circuit::LsiClass c;
  c.group = "collision";
  c.name = std::move(name);
  c.doc = std::move(doc);
  c.inputs = {input_pin("state", PinTypeId::state, "", "Positions now.")};
  c.outputs = {output_pin("distance", PinTypeId::scalar, "m", "Distance of the surfaces; negative: depth of penetration."),
               output_pin("a", PinTypeId::vector, "m", "Closest point on the first character, world."),
               output_pin("b", PinTypeId::vector, "m", "Closest point on the other character, world."),
               output_pin("normal", PinTypeId::vector, "1", "Unit vector from b towards a, world."),
               output_pin("link a", PinTypeId::scalar, "", "Index of the first character's link."),
               output_pin("link b", PinTypeId::scalar, "", "Index of the other character's link.")};
  c.parameters = {character_parameter(), text_parameter("other", "Id of the other character.")};
  c.state_bytes = sizeof(Warm);
  c.configure = configure_distance;
  c.make = make_distance;
  c.destroy = destroy<Distance>;
  c.init = [](const Call* call) -> std::int32_t {
    const Warm fresh;
    std::memcpy(call->state, &fresh, sizeof fresh);
    return 0;
  };
  c.step = distance;
  return c;
}

struct Impulse {
  const World* world;
  contact::CollisionImpulse solver;
  std::vector<dynamics::Workspace> workspaces;  // [characters]
  std::vector<contact::LinkSystem> systems;
  std::vector<collision::ContactPoint> contacts;
};

std::int32_t impulse(const Call* call) {
  auto& self = object_of<Impulse>(call);
  const double* state = input(call, 0);
  double* next = output(call, 0);
  std::memcpy(next, state, self.world->state_size() * sizeof(double));
  self.systems.clear();
  for (const Character& who : self.world->characters()) {
    dynamics::Workspace& ws = self.workspaces[static_cast<std::size_t>(who.index)];
    dynamics::update_kinematics(*who.mechanism, q_of(who, state), v_of(who, state), ws);
    self.systems.push_back({who.mechanism.get(), &ws, nullptr, q_of(who, state), v_of(who, next)});
  }
  const std::span<const ContactRecord> found = records<ContactRecord>(call->in[1]);
  self.contacts.clear();
  for (const ContactRecord& c : found) self.contacts.push_back(c.point);
  const contact::ImpactReport report = self.solver.collide(self.systems, self.contacts, {});
  if (report.status == contact::ImpactStatus::singular)
    return circuit::stop(call, "The inertia of '" + self.world->characters()[static_cast<std::size_t>(report.system)].id +
                                   "' is not positive, so its velocity change is undefined.");
  auto* out = record_room<ContactRecord>(call->out[1]);
  const std::span<const double> p = self.solver.impulses();
  for (std::size_t i = 0; i < found.size(); ++i) {
    out[i] = found[i];
    out[i].force = (p[i] / call->tick->dt) * found[i].point.n;  // paper eq. (17): the impulse, divided by the duration of the step
  }
  set_count(call->out[1], found.size());
  return 0;
}

void configure_impulse(Setup& s) {
  const World* world = world_of(s);
  if (!world) return;
  for (const Character& who : world->characters())
    if (who.mechanism->has_loops())
      s.fail(ErrorCode::unsupported, "'" + who.id + "' has closed loops.", "Use the LSI 'dynamics', whose impulses keep loops closed.");
  s.set_out(0, world->state_count());
  s.set_out(1, world->contact_capacity());
}

}  // namespace

void add_distance(circuit::Library& library) {
  circuit::LsiClass gilbert =
      distance_class("successive Gilbert",
                     "Distance of two links. Each query starts at the result of the previous one, so its cost does not "
                     "grow with the number of vertices if the motion is coherent.");
  gilbert.parameters = {character_parameter(), text_parameter("link", "Name of the character's link."),
                        text_parameter("other", "Id of the other character."),
                        text_parameter("other link", "Name of the other character's link.")};
  library.add(std::move(gilbert));
  circuit::LsiClass pair = distance_class("closest pair", "The closest points of two characters, and the links on which they are.");
  pair.parameters.push_back(text_parameter("link", "Name or label of the character's link; empty: every link."));
  pair.parameters.push_back(text_parameter("other link", "Name or label of the other character's link; empty: every link."));
  library.add(std::move(pair));

  circuit::LsiClass c;
  c.group = "collision";
  c.name = "collision force";
  c.doc =
      "Impulses of colliding links by the law of impact: the velocities after the impact, and the forces that give the impulses during one "
      "step.";
  c.inputs = {input_pin("state", PinTypeId::state, "", "Positions and velocities before the impact."),
              input_pin("contacts", PinTypeId::contacts, "", "Contact points.")};
  c.outputs = {output_pin("next", PinTypeId::state, "", "The same positions, with the velocities after the impact."),
               output_pin("contacts", PinTypeId::contacts, "", "The contact points with their forces.")};
  c.configure = configure_impulse;
  c.make = [](Setup& s) -> void* {
    const World* world = world_of(s);
    auto* self = new Impulse{world, {}, {}, {}, {}};
    for (const Character& who : world->characters()) self->workspaces.emplace_back(*who.mechanism);
    self->systems.reserve(world->characters().size());
    self->contacts.reserve(world->contact_capacity());
    return self;
  };
  c.destroy = destroy<Impulse>;
  c.step = impulse;
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
