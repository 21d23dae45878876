// Conditions and actions of rules: touches between links, choice of a motion, push while a condition is true.

#include <algorithm>
#include <cmath>

#include "ugoki/lsi/declare.h"

namespace ugoki::lsi {
namespace {

circuit::Parameter text_parameter(std::string name, std::string doc) {
  circuit::Parameter p = character_parameter();
  p.name = std::move(name);
  p.doc = std::move(doc);
  return p;
}

circuit::Parameter choice_parameter(std::string name, std::vector<std::string> choices, std::string doc) {
  circuit::Parameter p = text_parameter(std::move(name), std::move(doc));
  p.kind = circuit::ParameterKind::choice;
  p.initial = choices[0];
  p.choices = std::move(choices);
  return p;
}

circuit::InputPin optional(circuit::InputPin pin) {
  pin.required = false;
  return pin;
}

/// Returns the index of the link with the name or label `text`; -1: every link. Reports an unknown link.
int link_of(Setup& s, const Character& who, const std::string& text) {
  if (text.empty()) return -1;
  const Mechanism& m = *who.mechanism;
  if (const int named = m.find_link(text); named >= 0) return named;
  for (int i = 0; i < m.link_count(); ++i)
    if (m.link(i).label == text) return i;
  s.fail(ErrorCode::unknown, "'" + who.id + "' has no link '" + text + "'.", "Use the name of one of its links.");
  return -1;
}

// ---- touch

constexpr int any_system = -2, ground_system = -1;

struct Body {
  int system = any_system;  ///< index of the character; ground_system, any_system
  int link = -1;            ///< -1: every link
  [[nodiscard]] bool fits(int other_system, int other_link) const {
    return (system == any_system || system == other_system) && (link < 0 || link == other_link);
  }
};
struct Touch {
  Body a, b;
};

Body body_of(Setup& s, const char* character, const char* link) {
  const std::string& id = s.text(character);
  if (id.empty()) return {};
  if (id == "ground") return {ground_system, -1};
  const Character* who = s.resource<Character>(id);
  if (!who) return {};
  return {who->index, link_of(s, *who, s.text(link))};
}

std::int32_t touch(const Call* call) {
  const auto& self = object_of<Touch>(call);
  double force = 0;
  for (const ContactRecord& c : records<ContactRecord>(call->in[0])) {
    const collision::ContactPoint& p = c.point;
    const bool fits = (self.a.fits(p.system_a, p.link_a) && self.b.fits(p.system_b, p.link_b)) ||
                      (self.a.fits(p.system_b, p.link_b) && self.b.fits(p.system_a, p.link_a));
    if (fits) force += norm(c.force);
  }
  circuit::output(call, 0)[0] = force > 0 ? 1 : 0;
  circuit::output(call, 1)[0] = force;
  return 0;
}

void add_touch(circuit::Library& library) {
  circuit::LsiClass c;
  c.group = "rules";
  c.name = "touch";
  c.doc = "Whether a link touches another link or the ground, in the previous tick.";
  c.inputs = {input_pin("contacts", PinTypeId::contacts, "", "Contacts with forces, from `dynamics`.")};
  c.inputs[0].direct = false;
  c.outputs = {output_pin("touching", PinTypeId::scalar, "", "1 while they press on each other, otherwise 0."),
               output_pin("force", PinTypeId::scalar, "N", "Sum of the magnitudes of the contact forces.")};
  c.outputs[0].delayed = c.outputs[1].delayed = true;
  c.parameters = {character_parameter(), text_parameter("link", "Name or label of the character's link; empty: every link."),
                  text_parameter("other", "Id of the other character; `ground`: the ground; empty: everything."),
                  text_parameter("other link", "Name or label of the other character's link; empty: every link.")};
  c.configure = [](Setup& s) {
    (void)character_of(s);
    (void)body_of(s, "character", "link");
    (void)body_of(s, "other", "other link");
  };
  c.make = [](Setup& s) -> void* { return new Touch{body_of(s, "character", "link"), body_of(s, "other", "other link")}; };
  c.destroy = destroy<Touch>;
  c.advance = touch;
  library.add(std::move(c));
}

// ---- play rule

/// Plain data.
struct PlayState {
  double active = 0;    ///< 1: the rule selects its motion
  double begun = 0;     ///< 1: the motion has begun to play since the rule became active
  double finished = 0;  ///< 1: the motion has ended while the condition remained true
  double held = 0;      ///< 1: the condition was true in the previous tick
  double count = 0;     ///< how often the rule became active
};
struct PlaySaved {
  PlayState now, next;
};
struct PlayRule {
  double number;
  bool lasting;  ///< mode `while`
};

std::int32_t play(const Call* call) {
  const auto& self = object_of<PlayRule>(call);
  auto& saved = *static_cast<PlaySaved*>(call->state);
  PlayState& s = saved.next = saved.now;
  const bool held = circuit::input(call, 0)[0] > 0, rise = held && s.held == 0;
  const bool playing = circuit::input(call, 2)[0] == self.number;
  if (s.active > 0 && playing) s.begun = 1;
  const bool ended = s.begun > 0 && (!playing || circuit::input(call, 3)[0] > 0);  // another rule plays instead, or the motion is over
  if (self.lasting) {
    if (!held) s.finished = 0;
    if (s.active > 0 && playing && ended) s.finished = 1;
    const bool active = held && s.finished == 0;
    if (active && s.active == 0) s.count += 1;
    s.active = active ? 1 : 0;
  } else {
    if (s.active > 0 && ended) s.active = 0;
    if (rise && s.active == 0) {
      s.active = 1;
      s.count += 1;
    }
  }
  if (s.active == 0) s.begun = 0;
  s.held = held ? 1 : 0;
  circuit::output(call, 0)[0] = s.active > 0 ? self.number : circuit::input(call, 1)[0];
  circuit::output(call, 1)[0] = s.active;
  circuit::output(call, 2)[0] = s.count;
  return 0;
}

void add_play(circuit::Library& library) {
  circuit::LsiClass c;
  c.group = "rules";
  c.name = "play rule";
  c.doc =
      "Selects a motion for `motion choice`. In the mode `when`, from the tick in which the condition becomes true until the motion ends; in "
      "the mode `while`, as long as the condition is true. Several rules are wired in series by `below`; the last one has priority.";
  c.inputs = {input_pin("condition", PinTypeId::scalar, "", "The condition; true above 0."),
              optional(input_pin("below", PinTypeId::scalar, "", "Choice of the rules with lower priority, for the time without effect.")),
              input_pin("now", PinTypeId::scalar, "", "The choice that plays, from `motion choice`."),
              input_pin("ended", PinTypeId::scalar, "", "1 when the playing motion is near its end, from `motion choice`.")};
  c.outputs = {output_pin("choice", PinTypeId::scalar, "", "Number of the motion, or the value of `below`."),
               output_pin("active", PinTypeId::scalar, "", "1 while the rule selects its motion, otherwise 0."),
               output_pin("count", PinTypeId::scalar, "", "How often the rule became active.")};
  c.parameters = {number_parameter("number", 1, 1, 1000, "", "Number of the motion among the motions of the character's rules."),
                  choice_parameter("mode", {"when", "while"}, "`when`: the motion plays once; `while`: as long as the condition is true.")};
  c.parameters[0].kind = circuit::ParameterKind::integer;
  c.state_bytes = sizeof(PlaySaved);
  c.make = [](Setup& s) -> void* { return new PlayRule{s.number("number"), s.text("mode") == "while"}; };
  c.destroy = destroy<PlayRule>;
  c.step = play;
  c.advance = [](const Call* call) -> std::int32_t {
    auto& saved = *static_cast<PlaySaved*>(call->state);
    saved.now = saved.next;
    return 0;
  };
  library.add(std::move(c));
}

// ---- push

/// Plain data.
struct PushState {
  double ticks_left = 0;  ///< of a push of fixed duration
  double held = 0;        ///< 1: the condition was true in the previous tick
  double count = 0;       ///< how often the push has begun
};
struct PushSaved {
  PushState now, next;
};
struct Push {
  std::uint32_t character;
  std::int32_t link;
  double ticks;         ///< 0: as long as the condition is true
  std::uint32_t flags;  ///< PushFlag
};

std::int32_t push(const Call* call) {
  const auto& self = object_of<Push>(call);
  auto& saved = *static_cast<PushSaved*>(call->state);
  PushState& s = saved.next = saved.now;
  const bool held = circuit::input(call, 1)[0] > 0;
  const double* force = circuit::input(call, 2);
  if (held && s.held == 0) {
    s.count += 1;
    s.ticks_left = self.ticks;
  }
  s.held = held ? 1 : 0;
  const bool active = self.ticks > 0 ? s.ticks_left > 0 : held;
  if (s.ticks_left > 0) s.ticks_left -= 1;
  std::uint64_t count = 0;
  auto* out = record_room<EventRecord>(call->out[0]);
  for (const EventRecord& e : records<EventRecord>(call->in[0])) {
    if (count == call->out_count[0]) break;
    out[count++] = e;
  }
  const Vec3 f{force[0], force[1], force[2]};
  if (active && dot(f, f) > 0) {
    if (count == call->out_count[0])
      return circuit::stop(call, "More than " + std::to_string(call->out_count[0]) + " events act at the same tick.");
    EventRecord& e = out[count++] = {};
    e.kind = EventKind::push;
    e.character = self.character;
    e.link = self.link;
    e.flags = self.flags;
    e.a = f;
  }
  set_count(call->out[0], count);
  circuit::output(call, 1)[0] = active ? 1 : 0;
  circuit::output(call, 2)[0] = s.count;
  return 0;
}

void add_push(circuit::Library& library) {
  circuit::LsiClass c;
  c.group = "rules";
  c.name = "push";
  c.doc = "Adds a push to the events: a force on the centre of mass of a link.";
  c.inputs = {optional(input_pin("events", PinTypeId::event, "", "Other events of the tick; they are passed on.")),
              input_pin("when", PinTypeId::scalar, "", "The condition; true above 0."),
              input_pin("force", PinTypeId::vector, "N", "Force, in world axes or in those of the link.")};
  c.outputs = {output_pin("events", PinTypeId::event, "", "All events, with the push."),
               output_pin("active", PinTypeId::scalar, "", "1 while the push acts, otherwise 0."),
               output_pin("count", PinTypeId::scalar, "", "How often the push has begun.")};
  circuit::Parameter body_axes = text_parameter("body axes", "Whether the force is in the axes of the link and turns with it.");
  body_axes.kind = circuit::ParameterKind::boolean;
  body_axes.initial = false;
  c.parameters = {character_parameter(), text_parameter("link", "Name or label of the pushed link; empty: the root."), body_axes,
                  number_parameter("duration", 0, 0, 3600, "s",
                                   "Duration of the push, from the tick in which the condition becomes true; 0: as long as it is true.")};
  c.state_bytes = sizeof(PushSaved);
  c.configure = [](Setup& s) {
    if (const Character* who = character_of(s)) (void)link_of(s, *who, s.text("link"));
  };
  c.make = [](Setup& s) -> void* {
    const Character& who = *character_of(s);
    const double duration = s.number("duration");
    return new Push{static_cast<std::uint32_t>(who.index), std::max(0, link_of(s, who, s.text("link"))),
                    duration > 0 ? std::max(1.0, std::floor(duration / s.dt() + 0.5)) : 0,
                    s.boolean("body axes") ? push_body_axes : std::uint32_t{0}};
  };
  c.destroy = destroy<Push>;
  c.step = push;
  c.advance = [](const Call* call) -> std::int32_t {
    auto& saved = *static_cast<PushSaved*>(call->state);
    saved.now = saved.next;
    return 0;
  };
  library.add(std::move(c));
}

}  // namespace

void add_rules(circuit::Library& library) {
  add_touch(library);
  add_play(library);
  add_push(library);
}

}  // namespace ugoki::lsi
