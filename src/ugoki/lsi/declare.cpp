#include "ugoki/lsi/declare.h"

namespace ugoki::lsi {

circuit::InputPin input_pin(std::string name, PinTypeId type, std::string unit, std::string doc) {
  circuit::InputPin pin;
  pin.name = std::move(name);
  pin.type = type;
  pin.unit = std::move(unit);
  pin.doc = std::move(doc);
  return pin;
}

circuit::OutputPin output_pin(std::string name, PinTypeId type, std::string unit, std::string doc) {
  circuit::OutputPin pin;
  pin.name = std::move(name);
  pin.type = type;
  pin.unit = std::move(unit);
  pin.doc = std::move(doc);
  return pin;
}

circuit::Parameter number_parameter(std::string name, double initial, double minimum, double maximum, std::string unit, std::string doc) {
  circuit::Parameter p;
  p.name = std::move(name);
  p.initial = initial;
  p.minimum = minimum;
  p.maximum = maximum;
  p.unit = std::move(unit);
  p.doc = std::move(doc);
  p.live = false;  // the LSIs of this module read their parameters only in `make`
  return p;
}

circuit::Parameter character_parameter() {
  circuit::Parameter p;
  p.name = "character";
  p.kind = circuit::ParameterKind::text;
  p.initial = std::string();
  p.doc = "Id of the character that this LSI works on.";
  p.live = false;
  return p;
}

const World* world_of(Setup& setup) { return setup.resource<World>(""); }
const Character* character_of(Setup& setup) { return setup.resource<Character>(setup.text("character")); }

void check_subject(Setup& setup, std::size_t pin, const std::string& pin_name, const Character& character) {
  const circuit::Shape shape = setup.in(pin);
  if (shape.count == 0 || shape.subject < 0 || shape.subject == character.index) return;
  const World* world = world_of(setup);
  const std::string other = world ? world->characters()[static_cast<std::size_t>(shape.subject)].id : std::string();
  setup.fail(ErrorCode::structure,
             "The value wired to '" + setup.id() + "." + pin_name + "' belongs to the character '" + other + "', but the LSI to '" +
                 character.id + "'.",
             "Wire an output of the same character, or change the parameter 'character'.");
}

}  // namespace ugoki::lsi
