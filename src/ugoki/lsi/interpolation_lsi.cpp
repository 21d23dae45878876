// Interpolation: blends the two references of motion retrieval into one.

#include "ugoki/lsi/declare.h"
#include "ugoki/lsi/track_sampler.h"

namespace ugoki::lsi {
namespace {

std::int32_t step(const Call* call) {
  const auto& character = *static_cast<const Character*>(call->object);
  const ReferenceLayout layout = reference_layout(*character.mechanism, character.feet.size());
  const double* blend = circuit::input(call, 2);
  const std::size_t size = layout.size();
  if (blend[0] >= 1) {
    std::memcpy(circuit::output(call, 0), circuit::input(call, 0), size * sizeof(double));
  } else {
    blend_references(*character.mechanism, layout, {circuit::input(call, 1), size}, {circuit::input(call, 0), size},
                     {blend[0], blend[1], blend[2]}, {circuit::output(call, 0), size});
  }
  return 0;
}

}  // namespace

void add_interpolation(circuit::Library& library) {
  circuit::LsiClass c;
  c.name = "interpolation";
  c.doc =
      "Blends two references into one. Rotations are interpolated along great arcs; velocities and accelerations are the derivatives of "
      "the "
      "blended motion.";
  c.inputs = {input_pin("current", PinTypeId::motion, "", "Reference that is blended in."),
              input_pin("previous", PinTypeId::motion, "", "Reference that is blended out."),
              input_pin("blend", PinTypeId::vector, "1, 1/s, 1/s^2", "Weight of the current one, its rate and its acceleration.")};
  c.outputs = {output_pin("reference", PinTypeId::motion, "", "Reference motion of the character at this tick: q, v, a, stance.")};
  c.parameters = {character_parameter()};
  c.configure = [](Setup& s) {
    const Character* character = character_of(s);
    if (!character) return;
    const auto size = static_cast<std::uint32_t>(reference_layout(*character->mechanism, character->feet.size()).size());
    for (const std::size_t pin : {std::size_t{0}, std::size_t{1}}) {
      check_subject(s, pin, pin == 0 ? "current" : "previous", *character);
      if (s.in(pin).count != 0 && s.in(pin).count != size)
        s.fail(ErrorCode::structure,
               "The wired reference has " + std::to_string(s.in(pin).count) + " numbers; references of '" + character->id + "' have " +
                   std::to_string(size) + ".",
               "Wire a reference of the character '" + character->id + "'.");
    }
    s.set_out(0, size, character->index);
  };
  c.make = [](Setup& s) -> void* { return const_cast<Character*>(character_of(s)); };  // the LSI does not write to the character
  c.step = step;
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
