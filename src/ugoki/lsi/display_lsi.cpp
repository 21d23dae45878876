// Display: poses and other values that a viewer draws for the present state. The LSI runs on demand.

#include "ugoki/lsi/declare.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::lsi {
namespace {

enum Input : std::size_t { in_state, in_reports, in_measures };

struct Display {
  const World* world;
  std::vector<std::vector<Pose>> poses;        // [characters][links]
  std::vector<int> report_wire, measure_wire;  // [characters] index in Call::in; -1: no wire
};

std::int32_t step(const Call* call) {
  auto& self = object_of<Display>(call);
  const double* state = circuit::input(call, in_state);
  double* out = circuit::output(call, 0);
  double* records_out = circuit::output(call, 1);
  double* measures = circuit::output(call, 2);
  for (const Character& c : self.world->characters()) {
    const auto i = static_cast<std::size_t>(c.index);
    const Mechanism& m = *c.mechanism;
    std::vector<Pose>& X = self.poses[i];
    calc_poses(m, q_of(c, state), X);
    for (const Pose& pose : X) {
      const Quat r = to_quat(pose.R);
      for (const double x : {pose.p.x, pose.p.y, pose.p.z, r.w, r.x, r.y, r.z}) *out++ = x;
    }
    double* record = records_out + i * character_entry_count;
    const double* report = self.report_wire[i] < 0 ? nullptr : circuit::input(call, static_cast<std::size_t>(self.report_wire[i]));
    record[character_state] = !report ? 2 : report[report_released] > 0 ? 1 : 0;
    for (std::size_t k = 0; k < 3; ++k) {
      record[character_force + k] = report ? report[report_force + k] : 0;
      record[character_moment + k] = report ? report[report_moment + k] : 0;
    }
    record[character_ratio] = report ? report[report_ratio] : 0;
    record[character_weight] = m.mass() * norm(self.world->gravity());
    const Vec3 centre = centre_of_mass(m, X);
    for (int k = 0; k < 3; ++k) record[character_centre + static_cast<std::size_t>(k)] = centre[k];
    for (std::size_t k = 0; k < measure_count; ++k)
      measures[i * measure_count + k] = self.measure_wire[i] < 0
                                            ? (k == measure_release_time || k == measure_feet || k >= measure_totals ? -1.0 : 0.0)
                                            : circuit::input(call, static_cast<std::size_t>(self.measure_wire[i]))[k];
  }
  return 0;
}

/// Returns for each character the index in Call::in of its wire into input `pin`; -1: no wire. @param first  index of the pin's first wire
std::vector<int> wires_by_character(Setup& s, std::size_t pin, std::size_t first, std::uint32_t count, const World& world) {
  std::vector<int> wires(world.characters().size(), -1);
  for (std::size_t k = 0; k < s.wires(pin); ++k) {
    const circuit::Shape shape = s.in(pin, k);
    if (shape.subject < 0 || shape.count != count) {
      s.fail(ErrorCode::structure,
             "Wire " + std::to_string(k) + " into '" + s.id() + "." + s.lsi_class().inputs[pin].name + "' must have " +
                 std::to_string(count) + " numbers of one character; it has " + std::to_string(shape.count) + ".",
             "Wire the report of a motion control LSI to 'reports', and the measures of a naturalness LSI to 'measures'.");
    } else {
      wires[static_cast<std::size_t>(shape.subject)] = static_cast<int>(first + k);
    }
  }
  return wires;
}

void* make(Setup& s) {
  const World* world = world_of(s);
  auto* self = new Display{world,
                           {},
                           wires_by_character(s, in_reports, in_reports, report_count, *world),
                           wires_by_character(s, in_measures, in_reports + s.wires(in_reports), measure_count, *world)};
  for (const Character& c : world->characters()) self->poses.emplace_back(static_cast<std::size_t>(c.mechanism->link_count()));
  return self;
}

}  // namespace

void add_display(circuit::Library& library) {
  circuit::LsiClass c;
  c.name = "display";
  c.doc =
      "Poses of all links and the values of each character that viewers show. Set \"every\" to 0, so that it runs only when a frame is "
      "requested.";
  c.inputs = {input_pin("state", PinTypeId::state, "", "Positions and velocities now."),
              input_pin("reports", PinTypeId::joint_values, "", "Report of the motion control of each character, one wire each."),
              input_pin("measures", PinTypeId::joint_values, "", "Measures of naturalness of each character, one wire each.")};
  for (const std::size_t pin : {std::size_t{in_reports}, std::size_t{in_measures}}) {
    c.inputs[pin].required = false;
    c.inputs[pin].multiple = true;
  }
  c.outputs = {
      output_pin("poses", PinTypeId::pose, "m", "Poses of every link of every character in the world."),
      output_pin("characters", PinTypeId::joint_values, "",
                 "Twelve numbers for each character: state, root assist, weight, centre of mass."),
      output_pin("measures", PinTypeId::joint_values, "", "The measures of naturalness of each character, one character after the other.")};
  c.configure = [](Setup& s) {
    const World* world = world_of(s);
    if (!world) return;
    s.set_out(0, World::payload_count(world->link_count()));
    s.set_out(1, World::payload_count(world->characters().size() * character_entry_count));
    s.set_out(2, World::payload_count(world->characters().size() * measure_count));
  };
  c.make = make;
  c.destroy = destroy<Display>;
  c.step = step;
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
