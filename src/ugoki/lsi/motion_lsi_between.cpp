// Intermediate motion: a cyclic motion between two clips, with a weight that may change at every tick.

#include <algorithm>
#include <cmath>

#include "ugoki/lsi/motion_lsi.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion_edit/intermediate.h"
#include "ugoki/motion_edit/progression.h"

namespace ugoki::lsi {
namespace {

using motion_edit::Intermediate;
using motion_edit::Progression;

constexpr int steps_between = 8;  // number of weight intervals; cycles are computed at their ends, poses are interpolated inside

/// The motion cycle at one weight between the two clips.
struct Between {
  Progression progression;  // coordinate frame that moves with the character at constant speed and turning rate
  SmoothMotion smooth;
  double duration;  // s
  int frames;
  std::vector<std::uint8_t> stance;  // [frames][feet]
};

/// Data of the LSI that do not change while it runs, and working memory.
struct Gait {
  const Character* character;
  std::vector<Between> cycles;                    // [steps_between + 1] in ascending order of weight
  mutable std::vector<double> q[3], other, v, a;  // working memory of step

  /// Computes the position coordinates at a phase of the mix of cycles i and i + 1, relative to their progression.
  /// @param s weight of cycle i + 1, 0 to 1
  void local(std::size_t i, double s, double phase, std::vector<double>& out) const {
    const Mechanism& m = *character->mechanism;
    phase -= std::floor(phase);
    for (std::size_t k = 0; k < 2; ++k) {
      const Between& b = cycles[i + k];
      std::vector<double>& to = k == 0 ? out : other;
      b.smooth.sample(m, phase * b.duration, to, v, a);
      displace_root(m, inverse(b.progression.at(phase)), to);
    }
    interpolate(m, out, other, s, out);
  }
};

/// State of the LSI: phase of the cycle (0 to 1), and placement of the progression on the floor.
struct Memory {
  double phase, x, y, heading;  // dimensionless, m, m, rad
};

/// The mix of the neighbouring cycles i and i + 1 for the present weight.
struct Mix {
  std::size_t i;
  double s;             // weight of cycle i + 1, 0 to 1
  double duration;      // s, duration of a cycle
  double vx, vy, turn;  // m/s, m/s, rad/s: velocity of the mixed progression
};
Mix mix_at(const Gait& gait, double weight) {
  const double x = std::clamp(std::isfinite(weight) ? weight : 0.0, 0.0, 1.0) * steps_between;
  const auto i = std::min(static_cast<std::size_t>(x), static_cast<std::size_t>(steps_between - 1));
  const double s = x - static_cast<double>(i);
  const Between &a = gait.cycles[i], &b = gait.cycles[i + 1];
  const double T = a.duration + s * (b.duration - a.duration);
  const auto rate = [&](double Progression::* part) {
    return a.progression.*part / a.duration + s * (b.progression.*part / b.duration - a.progression.*part / a.duration);
  };
  return {i, s, T, rate(&Progression::vx), rate(&Progression::vy), rate(&Progression::turn)};
}

/// Returns the placement of the progression dt seconds after `at`, at constant speed and turning rate.
Placement moved(const Memory& at, const Mix& mix, double dt) {
  Progression p;
  p.start = {at.x, at.y, 0, at.heading};
  p.vx = mix.vx * dt;
  p.vy = mix.vy * dt;
  p.turn = mix.turn * dt;
  return p.at(1);
}

std::int32_t step(const Call* call) {
  const auto& gait = object_of<Gait>(call);
  const auto& at = *static_cast<const Memory*>(call->state);
  const Mechanism& m = *gait.character->mechanism;
  const Mix mix = mix_at(gait, circuit::input(call, 0)[0]);
  const double h = std::max(call->tick->dt, 1e-3);  // s; shorter intervals would amplify rounding in the second difference
  for (int k = -1; k <= 1; ++k) {
    std::vector<double>& q = gait.q[k + 1];
    gait.local(mix.i, mix.s, at.phase + k * h / mix.duration, q);
    displace_root(m, moved(at, mix, k * h), q);
  }
  const ReferenceLayout l = reference_layout(m, gait.character->feet.size());
  const std::span<double> out(circuit::output(call, 0), l.size());
  std::copy(gait.q[1].begin(), gait.q[1].end(), out.begin());
  const std::span<double> v = out.subspan(l.v(), l.nv), a = out.subspan(l.a(), l.nv);
  difference(m, gait.q[1], gait.q[2], v);  // displacement from t to t + h
  difference(m, gait.q[0], gait.q[1], a);  // displacement from t - h to t
  for (std::size_t k = 0; k < l.nv; ++k) {
    const double ahead = v[k] / h, behind = a[k] / h;
    v[k] = 0.5 * (ahead + behind);
    a[k] = (ahead - behind) / h;
  }
  const Between& near = gait.cycles[mix.i + (mix.s < 0.5 ? 0 : 1)];
  const auto frame = static_cast<std::size_t>((at.phase - std::floor(at.phase)) * (near.frames - 1) + 0.5);
  for (std::size_t k = 0; k < l.feet; ++k) out[l.stance() + k] = near.stance[frame * l.feet + k] ? 1.0 : 0.0;
  double* speed = circuit::output(call, 1);
  speed[0] = std::sqrt(mix.vx * mix.vx + mix.vy * mix.vy);
  return 0;
}

std::int32_t advance(const Call* call) {
  const auto& gait = object_of<Gait>(call);
  auto& at = *static_cast<Memory*>(call->state);
  const Mix mix = mix_at(gait, circuit::input(call, 0)[0]);
  const Placement next = moved(at, mix, call->tick->dt);
  at = {at.phase + call->tick->dt / mix.duration, next.x, next.y, next.heading};
  at.phase -= std::floor(at.phase);
  return 0;
}

std::int32_t init(const Call* call) {
  const Placement& start = object_of<Gait>(call).cycles.front().progression.start;
  *static_cast<Memory*>(call->state) = {0, start.x, start.y, start.heading};
  return 0;
}

void* make(Setup& s) {
  const Character& character = *character_of(s);
  const Mechanism& m = *character.mechanism;
  const Motion* sources[] = {clip_motion(s, character, "clip"), clip_motion(s, character, "second clip")};
  if (!sources[0] || !sources[1]) return nullptr;
  const Result<Intermediate> between = Intermediate::make(m, sources);
  if (!between) {
    report(s, between.error());
    return nullptr;
  }
  auto gait = std::make_unique<Gait>();
  gait->character = &character;
  for (std::vector<double>* q : {&gait->q[0], &gait->q[1], &gait->q[2], &gait->other}) q->resize(static_cast<std::size_t>(m.nq()));
  for (std::vector<double>* v : {&gait->v, &gait->a}) v->resize(static_cast<std::size_t>(m.nv()));
  for (int i = 0; i <= steps_between; ++i) {
    const double w = static_cast<double>(i) / steps_between, weights[] = {1 - w, w};
    const Result<Motion> motion = between->blend(weights);
    if (!motion) {
      report(s, motion.error());
      return nullptr;
    }
    std::vector<std::uint8_t> stance(static_cast<std::size_t>(motion->frames) * character.feet.size(), 0);
    for (std::size_t k = 0; k < character.feet.size(); ++k)
      for (const ContactTrack& track : motion->contacts)
        if (track.link == m.link(character.feet[k]).name)
          for (std::size_t f = 0; f < track.on.size(); ++f) stance[f * character.feet.size() + k] = track.on[f];
    gait->cycles.push_back(
        {motion_edit::find_progression(*motion, m), SmoothMotion(*motion, m, 0), motion->duration(), motion->frames, std::move(stance)});
  }
  return gait.release();
}

}  // namespace

void add_intermediate_motion(circuit::Library& library) {
  circuit::LsiClass c;
  c.name = "intermediate motion";
  c.doc = "A cyclic motion between two clips. The weight of the second clip may change while it plays.";
  c.group = "motion";
  circuit::InputPin weight =
      input_pin("weight", PinTypeId::scalar, "1", "Weight of the second clip: 0 gives the first clip, 1 the second.");
  weight.required = false;
  weight.value = 0.5;
  weight.minimum = 0;
  weight.maximum = 1;
  c.inputs = {weight};
  c.outputs = {output_pin("reference", PinTypeId::motion, "", "Reference motion of the character: q, v, a, stance."),
               output_pin("speed", PinTypeId::scalar, "m/s", "Mean speed over the ground.")};
  c.parameters = {character_parameter(), clip_parameter("clip", 0, "First clip of the character's track, counted from 0."),
                  clip_parameter("second clip", 1, "Second clip of the character's track, counted from 0.")};
  c.state_bytes = sizeof(Memory);
  c.configure = [](Setup& s) {
    const Character* character = character_of(s);
    if (!character) return;
    (void)clip_motion(s, *character, "clip");
    (void)clip_motion(s, *character, "second clip");
    s.set_out(0, static_cast<std::uint32_t>(reference_layout(*character->mechanism, character->feet.size()).size()), character->index);
  };
  c.make = make;
  c.destroy = destroy<Gait>;
  c.init = init;
  c.step = step;
  c.advance = advance;
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
