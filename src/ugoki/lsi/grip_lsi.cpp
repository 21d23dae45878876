// Grip: the state of one link's grip, from the output `grips` of dynamics.

#include <cmath>

#include "ugoki/lsi/declare.h"

namespace ugoki::lsi {
namespace {

struct Reader {
  std::uint32_t character;
  std::int32_t link;
};

int link_named(const Mechanism& m, const std::string& name) {
  if (const int found = m.find_link(name); found >= 0) return found;
  for (int i = 0; i < m.link_count(); ++i)
    if (!name.empty() && m.link(i).label == name) return i;
  return -1;
}

std::int32_t step(const Call* call) {
  const auto& self = object_of<Reader>(call);
  double* const force = circuit::output(call, 1);
  for (std::size_t k = 0; k < 3; ++k) force[k] = 0;
  for (const std::size_t pin : {std::size_t{0}, std::size_t{2}, std::size_t{3}}) circuit::output(call, pin)[0] = 0;
  for (const EventRecord& e : records<EventRecord>(call->in[0])) {
    if (e.kind != EventKind::gripping || e.character != self.character || e.link != self.link) continue;
    circuit::output(call, 0)[0] = 1;
    for (int k = 0; k < 3; ++k) force[k] = e.a[k];
    circuit::output(call, 2)[0] = e.c.z;
    circuit::output(call, 3)[0] = e.spare[0];
  }
  return 0;
}

}  // namespace

void add_grip(circuit::Library& library) {
  circuit::LsiClass c;
  c.name = "grip";
  c.doc = "The grip of one link of a character: whether it holds, its force and its gap.";
  c.inputs = {input_pin("grips", PinTypeId::event, "", "Output `grips` of `dynamics`.")};
  c.outputs = {output_pin("holds", PinTypeId::scalar, "", "1 while the link grips something, otherwise 0."),
               output_pin("force", PinTypeId::vector, "N", "Force on the link, in world axes."),
               output_pin("load", PinTypeId::scalar, "1", "Size of the force, as a fraction of the limit of the grip."),
               output_pin("gap", PinTypeId::scalar, "m", "Distance of the two points that the grip holds together.")};
  circuit::Parameter link;
  link.name = "link";
  link.kind = circuit::ParameterKind::text;
  link.initial = std::string();
  link.doc = "Name or label of the link.";
  c.parameters = {character_parameter(), link};
  c.configure = [](Setup& s) {
    const Character* const character = character_of(s);
    if (character && link_named(*character->mechanism, s.text("link")) < 0)
      s.fail(ErrorCode::unknown, "Character '" + character->id + "' has no link '" + s.text("link") + "'.", "Name one of its links.");
  };
  c.make = [](Setup& s) -> void* {
    const Character& character = *character_of(s);
    return new Reader{static_cast<std::uint32_t>(character.index), link_named(*character.mechanism, s.text("link"))};
  };
  c.destroy = destroy<Reader>;
  c.step = step;
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
