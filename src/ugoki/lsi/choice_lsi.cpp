// Motion choice: plays the editing track of a character, or one of the motions of its rules, with transitions between them.

#include <algorithm>
#include <cmath>

#include "ugoki/lsi/declare.h"
#include "ugoki/lsi/track_sampler.h"

namespace ugoki::lsi {
namespace {

enum Output : std::size_t { out_current, out_previous, out_blend, out_now, out_ended };

/// One source of the reference: the track (choice 0), or the motion of a rule (choice 1, 2, ...), displaced on the floor.
struct Side {
  std::int64_t choice = 0;
  double start = 0;  ///< s, time at which the motion began
  Placement by;      ///< displacement of the track or of the motion, so that it continues at the place of its predecessor
};
/// The playing source, and the transition to it. Plain data.
struct State {
  Side now, before;
  double begun = -1, blend = 0;  ///< s, begin and duration of the transition; duration 0: none
};
struct Saved {
  State now, next;  ///< `step` computes `next` from `now`; `advance` copies it to `now`
};

struct Choice {
  Choice(const Character& who)
      : mechanism(who.mechanism),
        track(who.track),
        moves(who.moves),
        scratch_a(track->layout().size()),
        scratch_b(track->layout().size()),
        scratch(track->layout().size()) {
    for (std::size_t k = 0; moves && k < moves->clips().size(); ++k) {
      moves->sample_as(static_cast<int>(k), moves->clips()[k].clip, 0, scratch);
      origins.push_back(floor_of(scratch));
    }
  }

  [[nodiscard]] std::size_t move_count() const { return origins.size(); }
  [[nodiscard]] const Clip& move(std::int64_t choice) const { return moves->clips()[static_cast<std::size_t>(choice - 1)].clip; }

  /// x, y and heading of the root of a reference; z is 0.
  [[nodiscard]] Placement floor_of(std::span<const double> reference) const {
    Placement at = root_placement(*mechanism, reference.first(track->layout().nq));
    at.z = 0;
    return at;
  }

  /// Writes the reference of a source at time t, s.
  void sample(const Side& side, double t, std::span<double> out) {
    if (side.choice > 0) {
      Clip clip = move(side.choice);
      clip.start = side.start;
      clip.placement = side.by * clip.placement;
      return moves->sample_as(static_cast<int>(side.choice - 1), clip, t, out);
    }
    const TrackMoment at = track->moment(t);
    const auto play = [&](int index, std::span<double> into) {
      Clip clip = track->playing(index);
      clip.placement = side.by * clip.placement;
      track->sample_as(index, clip, t, into);
    };
    if (at.previous == at.current) return play(at.current, out);
    play(at.previous, scratch_a);
    play(at.current, scratch_b);
    blend_references(*mechanism, track->layout(), scratch_a, scratch_b, at.blend, out);
  }

  /// The source `choice`, placed so that at time t, s, its root is where the root of `reference` is.
  Side begin(std::int64_t choice, double t, std::span<const double> reference) {
    const Placement at = floor_of(reference);
    if (choice > 0) return {choice, t, at * inverse(origins[static_cast<std::size_t>(choice - 1)])};
    sample({}, t, scratch);
    return {0, t, at * inverse(floor_of(scratch))};
  }

  /// Whether the motion of a rule is so near to its end that the transition to its successor must begin.
  [[nodiscard]] bool ended(const Side& side, double t) const {
    if (side.choice == 0 || move(side.choice).loop) return false;
    const Clip& clip = move(side.choice);
    return t >= side.start + std::max(0.0, clip.length - clip.blend);
  }

  MechanismPtr mechanism;
  std::shared_ptr<const TrackSampler> track, moves;
  std::vector<Placement> origins;  // [moves] x, y and heading of the root in the first frame
  std::vector<double> scratch_a, scratch_b, scratch;
};

std::int32_t step(const Call* call) {
  auto& self = object_of<Choice>(call);
  auto& saved = *static_cast<Saved*>(call->state);
  State& s = saved.next = saved.now;
  const double t = call->tick->time;
  const std::size_t size = self.track->layout().size();
  const std::span<double> current{circuit::output(call, out_current), size}, previous{circuit::output(call, out_previous), size};
  // A transition that has begun is completed first: a third source would make the reference jump.
  const bool free = !(t < s.begun + s.blend);
  const double wanted = std::clamp(std::floor(circuit::input(call, 0)[0] + 0.5), 0.0, static_cast<double>(self.move_count()));
  self.sample(s.now, t, current);
  if (const auto choice = static_cast<std::int64_t>(wanted); free && choice != s.now.choice) {
    s.before = s.now;
    s.now = self.begin(choice, t, current);
    s.begun = t;
    s.blend = self.move(choice > 0 ? choice : s.before.choice).blend;
    self.sample(s.now, t, current);
  }
  const BlendWeight blend = blend_weight(t - s.begun, s.blend);
  if (t < s.begun + s.blend)
    self.sample(s.before, t, previous);
  else
    std::copy(current.begin(), current.end(), previous.begin());
  double* weight = circuit::output(call, out_blend);
  weight[0] = blend.weight;
  weight[1] = blend.rate;
  weight[2] = blend.acceleration;
  return 0;
}

std::int32_t advance(const Call* call) {
  auto& saved = *static_cast<Saved*>(call->state);
  saved.now = saved.next;
  circuit::output(call, out_now)[0] = static_cast<double>(saved.now.now.choice);
  circuit::output(call, out_ended)[0] = object_of<Choice>(call).ended(saved.now.now, call->tick->time + call->tick->dt) ? 1 : 0;
  return 0;
}

void configure(Setup& s) {
  const Character* who = character_of(s);
  if (!who) return;
  s.set_state(sizeof(Saved));
  if (!who->track)
    return s.fail(ErrorCode::structure, "The character '" + who->id + "' has no clips.",
                  "Add a clip to its track. It plays while no rule is active.");
  const auto size = static_cast<std::uint32_t>(who->track->layout().size());
  s.set_out(out_current, size, who->index);
  s.set_out(out_previous, size, who->index);
  s.set_out(out_blend, 1, who->index);
}

}  // namespace

void add_choice(circuit::Library& library) {
  circuit::LsiClass c;
  c.name = "motion choice";
  c.doc =
      "Plays the editing track of a character, or the motion of one of its rules. A motion begins where the root of the reference is. "
      "Transitions last as long as the blend of the motion.";
  c.inputs = {input_pin("choice", PinTypeId::scalar, "", "0: the track; 1, 2, ...: the motions of the character's rules, in their order.")};
  c.inputs[0].required = false;
  c.outputs = {
      output_pin("current", PinTypeId::motion, "", "Reference of the playing motion: q, v, a, stance."),
      output_pin("previous", PinTypeId::motion, "", "Reference of the previous motion during a transition, otherwise the same as `current`."),
      output_pin("blend", PinTypeId::vector, "1, 1/s, 1/s^2", "Weight of the playing motion, its rate and its acceleration."),
      output_pin("now", PinTypeId::scalar, "", "The choice that plays."),
      output_pin("ended", PinTypeId::scalar, "", "1 when the motion of a rule that does not loop is near its end, otherwise 0.")};
  c.outputs[out_now].delayed = c.outputs[out_ended].delayed = true;
  c.parameters = {character_parameter()};
  c.configure = configure;
  c.make = [](Setup& s) -> void* { return new Choice(*character_of(s)); };
  c.destroy = destroy<Choice>;
  c.init = [](const Call* call) -> std::int32_t {
    *static_cast<Saved*>(call->state) = {};
    return 0;
  };
  c.step = step;
  c.advance = advance;
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
