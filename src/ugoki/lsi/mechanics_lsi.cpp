// Quantities computed from the state of a link system: coordinates, poses of links, centre of mass, energy, inverse and forward dynamics.

#include <memory>

#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/closed_links.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/lsi/declare.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::lsi {
namespace {

using circuit::input;
using circuit::output;

/// The object of the LSIs of this file: the character and working memory.
struct Body {
  const Character* character;
  const World* world;
  dynamics::Workspace workspace;
  std::vector<double> zero;  // [nv]
  int link = 0;
  std::unique_ptr<dynamics::ClosedLinks> closed = nullptr;  // only for forward dynamics of a mechanism with loops

  [[nodiscard]] const Mechanism& mechanism() const { return *character->mechanism; }
  void move_to(const double* state) {
    dynamics::update_kinematics(mechanism(), q_of(*character, state), v_of(*character, state), workspace);
  }
};

void* make_body(Setup& s) {
  const Character* character = character_of(s);
  const World* world = world_of(s);
  if (!character || !world) return nullptr;
  auto* body = new Body{character, world, dynamics::Workspace(*character->mechanism), {}};
  body->zero.assign(static_cast<std::size_t>(character->mechanism->nv()), 0.0);
  return body;
}

void put(const Vec3& v, double* to) {
  to[0] = v.x;
  to[1] = v.y;
  to[2] = v.z;
}

/// Makes an LSI class with the input `state` and the parameter `character`.
circuit::LsiClass about_character(std::string name, std::string doc, std::vector<circuit::InputPin> more,
                                  std::vector<circuit::OutputPin> outputs, circuit::StepFunction step) {
  circuit::LsiClass c;
  c.group = "mechanics";
  c.name = std::move(name);
  c.doc = std::move(doc);
  c.inputs = {input_pin("state", PinTypeId::state, "", "Positions and velocities of all characters.")};
  c.inputs.insert(c.inputs.end(), more.begin(), more.end());
  c.outputs = std::move(outputs);
  c.parameters = {character_parameter()};
  c.make = make_body;
  c.destroy = destroy<Body>;
  c.step = step;
  c.configure = [](Setup& s) { (void)character_of(s); };
  return c;
}

std::int32_t coordinates(const Call* call) {
  const Character& who = *object_of<Body>(call).character;
  const auto q = q_of(who, input(call, 0)), v = v_of(who, input(call, 0));
  std::copy(q.begin(), q.end(), output(call, 0));
  std::copy(v.begin(), v.end(), output(call, 1));
  return 0;
}

std::int32_t centre_of_mass(const Call* call) {
  Body& body = object_of<Body>(call);
  body.move_to(input(call, 0));
  const dynamics::Centroidal c = dynamics::calc_centroidal(body.mechanism(), body.workspace);
  put(c.centre, output(call, 0));
  put(c.velocity, output(call, 1));
  put(c.momentum.w, output(call, 2));
  *output(call, 3) = c.mass;
  return 0;
}

std::int32_t energy(const Call* call) {
  Body& body = object_of<Body>(call);
  body.move_to(input(call, 0));
  *output(call, 0) = dynamics::kinetic_energy(body.mechanism(), body.workspace);
  *output(call, 1) = dynamics::potential_energy(body.mechanism(), body.workspace, body.world->gravity());
  return 0;
}

std::int32_t link_pose(const Call* call) {
  Body& body = object_of<Body>(call);
  body.move_to(input(call, 0));
  const Pose& X = body.workspace.X_WB[static_cast<std::size_t>(body.link)];
  const Quat r = to_quat(X.R);
  put(X.p, output(call, 0));
  const double turn[] = {r.w, r.x, r.y, r.z};
  std::copy(turn, turn + 4, output(call, 0) + 3);
  put(dynamics::point_velocity(body.workspace, body.link, X.p), output(call, 1));
  return 0;
}

/// Returns the numbers of an optional input of type `joint values`; zeros if it has no wire.
std::span<const double> dofs_in(const Call* call, std::size_t pin, const Body& body) {
  return {call->in[pin] ? input(call, pin) : body.zero.data(), body.zero.size()};
}

std::int32_t inverse_dynamics(const Call* call) {
  Body& body = object_of<Body>(call);
  const Character& who = *body.character;
  dynamics::calc_inverse_dynamics(body.mechanism(), body.workspace, q_of(who, input(call, 0)), v_of(who, input(call, 0)),
                                  dofs_in(call, 1, body), body.world->gravity(), {}, {output(call, 0), body.zero.size()});
  return 0;
}

std::int32_t forward_dynamics(const Call* call) {
  Body& body = object_of<Body>(call);
  const Character& who = *body.character;
  const Mechanism& m = body.mechanism();
  const auto q = q_of(who, input(call, 0)), v = v_of(who, input(call, 0)), tau = dofs_in(call, 1, body);
  const Vec3& gravity = body.world->gravity();
  const std::span<double> out(output(call, 0), body.zero.size());
  const bool good = body.closed
                        ? dynamics::calc_closed_forward_dynamics(m, *body.closed, q, v, tau, gravity, {}, out) == dynamics::ClosedStatus::ok
                        : dynamics::calc_forward_dynamics(m, body.workspace, q, v, tau, gravity, {}, out);
  return good ? 0 : circuit::stop(call, "The inertia at a joint is not positive, so its acceleration is undefined.");
}

/// Checks the size of input 1 and sets the size of output 0. Both pins have one number for each DOF of the character.
void configure_dofs(Setup& s) {
  const Character* who = character_of(s);
  if (!who) return;
  const auto nv = static_cast<std::uint32_t>(who->mechanism->nv());
  check_subject(s, 1, s.lsi_class().inputs[1].name, *who);
  if (s.in(1).count != 0 && s.in(1).count != nv)
    s.fail(ErrorCode::structure,
           "'" + who->id + "' has " + std::to_string(nv) + " degrees of freedom; the wired value has " + std::to_string(s.in(1).count) +
               " numbers.",
           "Wire joint values of the same character.");
  if (s.lsi_class().name == "inverse dynamics" && who->mechanism->has_loops())
    s.fail(ErrorCode::unsupported, "'" + who->id + "' has closed loops, so the joint forces of an acceleration are not unique.",
           "Use 'forward dynamics' or 'link dynamics', or a mechanism without loops.");
  s.set_out(0, World::payload_count(nv), who->index);
}

circuit::LsiClass with_link(circuit::LsiClass c) {
  circuit::Parameter link;
  link.name = "link";
  link.kind = circuit::ParameterKind::text;
  link.initial = std::string();
  link.doc = "Name of the link; empty: the root.";
  link.live = false;
  c.parameters.push_back(std::move(link));
  c.configure = [](Setup& s) {
    const Character* who = character_of(s);
    if (who && !s.text("link").empty() && who->mechanism->find_link(s.text("link")) < 0)
      s.fail(ErrorCode::unknown, "'" + who->id + "' has no link '" + s.text("link") + "'.", "Use the name of one of its links.");
  };
  c.make = [](Setup& s) -> void* {
    auto* body = static_cast<Body*>(make_body(s));
    if (body && !s.text("link").empty()) body->link = body->mechanism().find_link(s.text("link"));
    return body;
  };
  return c;
}

}  // namespace

void add_mechanics(circuit::Library& library) {
  circuit::LsiClass c =
      about_character("coordinates", "The joint values of one character.", {},
                      {output_pin("q", PinTypeId::joint_values, "m | rad", "Coordinates; unit quaternions where joints have them."),
                       output_pin("v", PinTypeId::joint_values, "m/s | rad/s", "Velocities of the degrees of freedom.")},
                      coordinates);
  c.configure = [](Setup& s) {
    const Character* who = character_of(s);
    if (!who) return;
    s.set_out(0, World::payload_count(static_cast<std::size_t>(who->mechanism->nq())), who->index);
    s.set_out(1, World::payload_count(static_cast<std::size_t>(who->mechanism->nv())), who->index);
  };
  library.add(std::move(c));
  library.add(about_character("centre of mass",
                              "Position and velocity of the centre of mass of one character, its angular momentum and mass.", {},
                              {output_pin("position", PinTypeId::vector, "m", ""), output_pin("velocity", PinTypeId::vector, "m/s", ""),
                               output_pin("angular momentum", PinTypeId::vector, "N m s", "About the centre of mass, in world axes."),
                               output_pin("mass", PinTypeId::scalar, "kg", "")},
                              centre_of_mass));
  library.add(about_character("energy", "Kinetic and potential energy of one character.", {},
                              {output_pin("kinetic", PinTypeId::scalar, "J", ""),
                               output_pin("potential", PinTypeId::scalar, "J", "In the gravity of the world; zero at the origin.")},
                              energy));
  library.add(with_link(
      about_character("link pose", "Pose of a link in the world, and velocity of its origin.", {},
                      {output_pin("pose", PinTypeId::pose, "m", ""), output_pin("velocity", PinTypeId::vector, "m/s", "")}, link_pose)));
  for (const bool inverse : {true, false}) {
    circuit::InputPin in = inverse ? input_pin("acceleration", PinTypeId::joint_values, "m/s^2 | rad/s^2", "Without a wire: zero.")
                                   : input_pin("torque", PinTypeId::joint_values, "N | N m", "Without a wire: zero.");
    in.required = false;
    circuit::LsiClass d =
        inverse ? about_character("inverse dynamics", "Joint forces that produce this acceleration, including gravity, without contacts.",
                                  {in}, {output_pin("torque", PinTypeId::joint_values, "N | N m", "")}, inverse_dynamics)
                : about_character("forward dynamics",
                                  "Acceleration that these joint forces produce, including gravity and closed loops, without contacts.",
                                  {in}, {output_pin("acceleration", PinTypeId::joint_values, "m/s^2 | rad/s^2", "")}, forward_dynamics);
    d.configure = configure_dofs;
    if (!inverse)
      d.make = [](Setup& s) -> void* {
        auto* body = static_cast<Body*>(make_body(s));
        if (body && body->mechanism().has_loops()) body->closed = std::make_unique<dynamics::ClosedLinks>(body->mechanism());
        return body;
      };
    library.add(std::move(d));
  }
}

}  // namespace ugoki::lsi
