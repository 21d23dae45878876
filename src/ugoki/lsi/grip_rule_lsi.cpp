// Grips that rules make and open.

#include <algorithm>

#include "ugoki/lsi/declare.h"

namespace ugoki::lsi {
namespace {

enum class Mode { grab, release, hold };

/// Plain data.
struct GripState {
  double held = 0;   ///< 1: the condition was true in the previous tick
  double count = 0;  ///< how often the condition became true
};
struct GripSaved {
  GripState now, next;
};
struct GripRule {
  EventRecord grab, release;
  Mode mode;
};

/// Returns the index of the link with the name or label in a parameter. Reports an unknown link.
/// @param if_empty  result for an empty text; -1: an empty text is reported
int link_of(Setup& s, const Character& who, const char* parameter, int if_empty) {
  const std::string& text = s.text(parameter);
  if (text.empty() && if_empty >= 0) return if_empty;
  const Mechanism& m = *who.mechanism;
  if (const int named = m.find_link(text); named >= 0) return named;
  for (int i = 0; i < m.link_count(); ++i)
    if (!text.empty() && m.link(i).label == text) return i;
  s.fail(ErrorCode::unknown, "'" + who.id + "' has no link '" + text + "'.", "Use the name of one of its links.");
  return 0;
}

void configure(Setup& s) {
  const Character* who = character_of(s);
  if (!who) return;
  const int link = link_of(s, *who, "link", -1);
  const Character* other = s.text("other").empty() ? nullptr : s.resource<Character>(s.text("other"));
  if (!other) return;
  if (other == who && link_of(s, *other, "other link", 0) == link)
    s.fail(ErrorCode::structure, "The link '" + s.text("link") + "' grips itself.", "Name another link.");
}

void* make(Setup& s) {
  const Character& who = *character_of(s);
  const Character* other = s.text("other").empty() ? nullptr : s.resource<Character>(s.text("other"));
  auto* self = new GripRule;
  self->mode = s.text("mode") == "grab" ? Mode::grab : s.text("mode") == "release" ? Mode::release : Mode::hold;
  EventRecord& e = self->grab;
  e.kind = EventKind::gripping;
  e.character = static_cast<std::uint32_t>(who.index);
  e.link = link_of(s, who, "link", -1);
  e.a = who.mechanism->link(e.link).inertia.centre();
  e.c = {other ? static_cast<double>(other->index) : -1.0, other ? static_cast<double>(link_of(s, *other, "other link", 0)) : 0.0,
         s.boolean("rigid") ? static_cast<double>(grip_rigid) : 0.0};
  e.spare[0] = s.number("limit");
  self->release = e;
  self->release.kind = EventKind::opening;
  return self;
}

std::int32_t step(const Call* call) {
  const auto& self = object_of<GripRule>(call);
  auto& saved = *static_cast<GripSaved*>(call->state);
  GripState& s = saved.next = saved.now;
  const bool held = circuit::input(call, 1)[0] > 0, rise = held && s.held == 0, fall = !held && s.held > 0;
  if (rise) s.count += 1;
  s.held = held ? 1 : 0;
  std::uint64_t count = 0;
  auto* out = record_room<EventRecord>(call->out[0]);
  for (const EventRecord& e : records<EventRecord>(call->in[0])) {
    if (count == call->out_count[0]) break;
    out[count++] = e;
  }
  if (rise || (fall && self.mode == Mode::hold)) {
    if (count == call->out_count[0])
      return circuit::stop(call, "More than " + std::to_string(call->out_count[0]) + " events act at the same tick.");
    out[count++] = fall || self.mode == Mode::release ? self.release : self.grab;
  }
  set_count(call->out[0], count);
  circuit::output(call, 1)[0] = s.held;
  circuit::output(call, 2)[0] = s.count;
  return 0;
}

circuit::Parameter text_parameter(std::string name, std::string doc) {
  circuit::Parameter p = character_parameter();
  p.name = std::move(name);
  p.doc = std::move(doc);
  return p;
}

}  // namespace

void add_grip_rule(circuit::Library& library) {
  circuit::LsiClass c;
  c.group = "rules";
  c.name = "grip rule";
  c.doc = "Adds events to the events of the tick that make a link grip another link or the world where it is, or release it.";
  c.inputs = {input_pin("events", PinTypeId::event, "", "Other events of the tick; they are passed on."),
              input_pin("when", PinTypeId::scalar, "", "The condition; true above 0.")};
  c.inputs[0].required = false;
  c.outputs = {output_pin("events", PinTypeId::event, "", "All events, with those of the grip."),
               output_pin("active", PinTypeId::scalar, "", "1 while the condition is true, otherwise 0."),
               output_pin("count", PinTypeId::scalar, "", "How often the condition became true.")};
  circuit::Parameter mode =
      text_parameter("mode", "`grab` or `release` when the condition becomes true; `hold`: grab, and release when it ends.");
  mode.kind = circuit::ParameterKind::choice;
  mode.choices = {"grab", "release", "hold"};
  mode.initial = mode.choices[0];
  circuit::Parameter rigid = text_parameter("rigid", "Whether the orientation is held as well.");
  rigid.kind = circuit::ParameterKind::boolean;
  rigid.initial = false;
  c.parameters = {character_parameter(),
                  text_parameter("link", "Name or label of the link that grips, at its centre of mass."),
                  text_parameter("other", "Id of the character that is gripped; empty: the world."),
                  text_parameter("other link", "Name or label of the gripped link; empty: the root."),
                  rigid,
                  number_parameter("limit", 450, 1, 1e6, "N", "A larger force opens the grip."),
                  mode};
  for (circuit::Parameter& p : c.parameters) p.live = false;
  c.state_bytes = sizeof(GripSaved);
  c.configure = configure;
  c.make = make;
  c.destroy = destroy<GripRule>;
  c.step = step;
  c.advance = [](const Call* call) -> std::int32_t {
    auto& saved = *static_cast<GripSaved*>(call->state);
    saved.now = saved.next;
    return 0;
  };
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
