// The LSIs "motion retarget" (adapts a motion of another character to this one) and "split reference".

#include <algorithm>

#include "ugoki/lsi/motion_lsi.h"
#include "ugoki/retarget/retarget.h"

namespace ugoki::lsi {
namespace {

const Character* source_of(Setup& s) { return s.resource<Character>(s.text("from")); }

circuit::Parameter yes_or_no(std::string name, bool initial, std::string doc) {
  circuit::Parameter p;
  p.name = std::move(name);
  p.kind = circuit::ParameterKind::boolean;
  p.initial = initial;
  p.doc = std::move(doc);
  return p;
}

void configure(Setup& s) {
  const Character *to = character_of(s), *from = source_of(s);
  if (!to || !from) return;
  (void)clip_motion(s, *from, "clip");
  s.set_out(0, static_cast<std::uint32_t>(reference_layout(*to->mechanism, to->feet.size()).size()), to->index);
}

void* make(Setup& s) {
  const Character *to = character_of(s), *from = source_of(s);
  const Motion* motion = clip_motion(s, *from, "clip");
  if (!motion) return nullptr;
  retarget::RetargetOptions options;
  options.keep_contacts = s.boolean("feet");
  options.keep_holds = s.boolean("hands");
  options.balance = s.boolean("balance");
  options.path_scale = s.number("path scale");
  options.gait_phase = s.number("gait phase");
  const Result<retarget::Retargeted> made = retarget::retarget(from->mechanism, *motion, to->mechanism, options);
  if (made) return new PlayedMotion(*to, made->motion);
  report(s, made.error());
  return nullptr;
}

std::int32_t split(const Call* call) {
  const ReferenceLayout& l = object_of<ReferenceLayout>(call);
  const double* r = circuit::input(call, 0);
  std::copy_n(r, l.nq, circuit::output(call, 0));
  std::copy_n(r + l.v(), l.nv, circuit::output(call, 1));
  std::copy_n(r + l.a(), l.nv, circuit::output(call, 2));
  std::copy_n(r + l.stance(), l.feet, circuit::output(call, 3));
  return 0;
}

void configure_split(Setup& s) {
  const Character* who = character_of(s);
  if (!who) return;
  check_subject(s, 0, "reference", *who);
  const ReferenceLayout l = reference_layout(*who->mechanism, who->feet.size());
  std::size_t pin = 0;
  for (const std::size_t n : {l.nq, l.nv, l.nv, l.feet}) s.set_out(pin++, World::payload_count(n), who->index);
}

circuit::LsiClass split_reference() {
  circuit::LsiClass c;
  c.name = "split reference";
  c.group = "motion";
  c.doc = "Splits a reference into joint values, velocities, accelerations and the stance of the feet.";
  c.inputs = {input_pin("reference", PinTypeId::motion, "", "Reference motion of the character.")};
  c.outputs = {output_pin("q", PinTypeId::joint_values, "m | rad", "Coordinates; unit quaternions where joints have them."),
               output_pin("v", PinTypeId::joint_values, "m/s | rad/s", "Velocities of the degrees of freedom."),
               output_pin("a", PinTypeId::joint_values, "m/s^2 | rad/s^2", "Accelerations of the degrees of freedom."),
               output_pin("stance", PinTypeId::joint_values, "1", "For each foot: 1 while it should stand, otherwise 0.")};
  c.parameters = {character_parameter()};
  c.configure = configure_split;
  c.make = [](Setup& s) -> void* {
    const Character* who = character_of(s);
    return who ? new ReferenceLayout(reference_layout(*who->mechanism, who->feet.size())) : nullptr;
  };
  c.destroy = destroy<ReferenceLayout>;
  c.step = split;
  return c;
}

}  // namespace

void add_motion_retarget(circuit::Library& library) {
  circuit::LsiClass c = played_motion_class(
      "motion retarget",
      "Plays a motion of another character, adapted to the structure of this one (other proportions, an animal, a robot).");
  circuit::Parameter from = text_parameter("from", "Id of the character whose track contains the motion.");
  c.parameters = {
      character_parameter(),
      std::move(from),
      clip_parameter("clip", 0, "Clip of this character's track, counted from 0."),
      yes_or_no("feet", true, "Whether standing feet are kept from sliding and sinking."),
      yes_or_no("hands", true, "Whether hands that hold each other or an object at rest keep holding it."),
      yes_or_no("balance", false, "Whether the centre of mass is kept over the standing feet."),
      number_parameter("path scale", 0, 0, 100, "1", "Scale of the path on the ground; 0: ratio of the leg lengths."),
      number_parameter("gait phase", 0.5, 0, 1, "1",
                       "Two legs to four: delay of the fore legs after the hind legs of the same side, as a fraction of a stride.")};
  for (circuit::Parameter& p : c.parameters) p.live = false;
  c.configure = configure;
  c.make = make;
  library.add(std::move(c));
  library.add(split_reference());
}

}  // namespace ugoki::lsi
