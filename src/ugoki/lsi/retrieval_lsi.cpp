// Motion retrieval: the references of the clips that play in a character's track at this tick.

#include "ugoki/lsi/declare.h"
#include "ugoki/lsi/track_sampler.h"

namespace ugoki::lsi {
namespace {

struct Retrieval {
  std::shared_ptr<const TrackSampler> track;
};

std::int32_t step(const Call* call) {
  const TrackSampler& track = *object_of<Retrieval>(call).track;
  const double t = call->tick->time;
  const TrackMoment now = track.moment(t);
  const std::size_t size = track.layout().size();
  double* current = circuit::output(call, 0);
  double* previous = circuit::output(call, 1);
  track.sample_clip(now.current, t, {current, size});
  if (now.previous == now.current) {
    std::memcpy(previous, current, size * sizeof(double));
  } else {
    track.sample_clip(now.previous, t, {previous, size});
  }
  double* blend = circuit::output(call, 2);
  blend[0] = now.blend.weight;
  blend[1] = now.blend.rate;
  blend[2] = now.blend.acceleration;
  return 0;
}

}  // namespace

void add_retrieval(circuit::Library& library) {
  circuit::LsiClass c;
  c.name = "motion retrieval";
  c.doc =
      "Reads the editing track of a character: the reference of the current clip, that of the previous clip, and the weight of the "
      "transition between them.";
  c.outputs = {
      output_pin("current", PinTypeId::motion, "", "Reference of the current clip: q, v, a, stance."),
      output_pin("previous", PinTypeId::motion, "", "Reference of the previous clip during a transition, otherwise the same as `current`."),
      output_pin("blend", PinTypeId::vector, "1, 1/s, 1/s^2", "Weight of the current clip, its rate and its acceleration.")};
  circuit::Parameter smooth;
  smooth.name = "smooth";
  smooth.kind = circuit::ParameterKind::boolean;
  smooth.initial = true;
  smooth.doc = "Whether motions are low-pass filtered and their soles kept above the floor; false: they are played unchanged.";
  smooth.live = false;
  c.parameters = {character_parameter(), smooth};
  c.configure = [](Setup& s) {
    const Character* character = character_of(s);
    if (!character) return;
    if (!character->track)
      return s.fail(ErrorCode::structure, "The character '" + character->id + "' has no clips.",
                    "Add a clip to its track, or set its control to passive.");
    const auto size = static_cast<std::uint32_t>(character->track->layout().size());
    s.set_out(0, size, character->index);
    s.set_out(1, size, character->index);
    s.set_out(2, 1, character->index);
  };
  c.make = [](Setup& s) -> void* {
    const Character& character = *character_of(s);
    const bool wanted = s.boolean("smooth");
    if (wanted == character.track->smooth()) return new Retrieval{character.track};
    return new Retrieval{std::make_shared<const TrackSampler>(character.mechanism, character.track->clips(), character.feet, wanted)};
  };
  c.destroy = destroy<Retrieval>;
  c.step = step;
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
