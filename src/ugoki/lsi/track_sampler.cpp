#include "ugoki/lsi/track_sampler.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/motion/reference.h"
#include "ugoki/motion/torques.h"

namespace ugoki::lsi {
namespace {

/// Returns the stance of every foot in every frame, [frames][feet], from the motion's contact labels; without labels, from label_contacts.
std::vector<std::uint8_t> stance_of(const Mechanism& mechanism, const Motion& motion, std::span<const int> feet) {
  Motion labelled;
  const Motion* source = &motion;
  if (motion.contacts.empty() && !feet.empty()) {
    labelled = motion;
    label_contacts(mechanism, labelled, feet);
    source = &labelled;
  }
  std::vector<std::uint8_t> stance(static_cast<std::size_t>(motion.frames) * feet.size(), 0);
  for (std::size_t k = 0; k < feet.size(); ++k)
    for (const ContactTrack& track : source->contacts) {
      if (track.link != mechanism.link(feet[k]).name) continue;
      for (std::size_t f = 0; f < std::min(track.on.size(), static_cast<std::size_t>(motion.frames)); ++f)
        stance[f * feet.size() + k] = track.on[f];
    }
  return stance;
}

}  // namespace

ReferenceLayout reference_layout(const Mechanism& m, std::size_t feet) {
  return {static_cast<std::size_t>(m.nq()), static_cast<std::size_t>(m.nv()), feet};
}

BlendWeight blend_weight(double passed, double duration) {
  if (!(passed < duration)) return {};
  // weight = 10 x^3 - 15 x^4 + 6 x^5: the rate and acceleration of the weight are zero at both ends
  const double rate = 1 / duration, x = passed * rate;
  return {x * x * x * (10 + x * (6 * x - 15)), 30 * x * x * (1 - x) * (1 - x) * rate, 60 * x * (1 - x) * (1 - 2 * x) * rate * rate};
}

TrackSampler::TrackSampler(MechanismPtr mechanism, std::vector<TrackClip> track, std::span<const int> feet, bool smooth)
    : mechanism_(std::move(mechanism)), track_(std::move(track)), layout_(reference_layout(*mechanism_, feet.size())), smooth_(smooth) {
  UGOKI_CHECK(!track_.empty());
  std::vector<const Motion*> known;
  for (std::size_t i = 0; i < track_.size(); ++i) {
    const Motion& motion = *track_[i].motion;
    const auto found = std::find(known.begin(), known.end(), &motion);
    motion_of_.push_back(static_cast<std::size_t>(found - known.begin()));
    if (found == known.end()) {
      known.push_back(&motion);
      motions_.push_back(smooth ? make_reference(motion, *mechanism_, 0) : SmoothMotion(motion, *mechanism_, 0));
      stance_.push_back(stance_of(*mechanism_, motion, feet));
      computed_.push_back(is_computed(motion) && !motion.contacts.empty());
    }
    Clip playing = track_[i].clip;
    if (i + 1 < track_.size()) {  // this clip continues during the transition to the next clip, if its motion is long enough
      const Clip& next = track_[i + 1].clip;
      playing.length = std::max(playing.length, next.start + next.blend - playing.start);
      if (!playing.loop && playing.speed > 0)
        playing.length = std::max(track_[i].clip.length, std::min(playing.length, (motion.duration() - playing.offset) / playing.speed));
    }
    playing_.push_back(playing);
  }
}

TrackMoment TrackSampler::moment(double t) const {
  TrackMoment m;
  while (m.current + 1 < static_cast<int>(track_.size()) && track_[static_cast<std::size_t>(m.current) + 1].clip.start <= t) ++m.current;
  m.previous = m.current;
  const Clip& clip = track_[static_cast<std::size_t>(m.current)].clip;
  const double passed = t - clip.start;
  if (m.current == 0 || !(passed < clip.blend)) return m;
  m.previous = m.current - 1;
  m.blend = blend_weight(passed, clip.blend);
  return m;
}

void TrackSampler::sample_clip(int clip, double t, std::span<double> reference) const { sample_as(clip, playing(clip), t, reference); }

void TrackSampler::sample_as(int clip, const Clip& placed, double t, std::span<double> reference) const {
  const auto i = static_cast<std::size_t>(clip);
  const SmoothMotion& motion = motions_[motion_of_[i]];
  ugoki::sample(placed, motion, *mechanism_, t, reference.first(layout_.nq), reference.subspan(layout_.v(), layout_.nv),
                reference.subspan(layout_.a(), layout_.nv));
  const double time = phase_of(placed, motion.duration(), t).time;
  const Motion& labelled = *track_[i].motion;  // the reference can have more frames a second
  const auto frame =
      static_cast<std::size_t>(std::clamp(std::floor(time * labelled.rate + 0.5), 0.0, static_cast<double>(labelled.frames - 1)));
  for (std::size_t k = 0; k < layout_.feet; ++k)
    reference[layout_.stance() + k] = stance_[motion_of_[i]][frame * layout_.feet + k] ? 1.0 : 0.0;
}

void TrackSampler::sample(double t, std::span<double> reference) const {
  const TrackMoment now = moment(t);
  if (now.previous == now.current) return sample_clip(now.current, t, reference);
  std::vector<double> previous(layout_.size()), current(layout_.size());
  sample_clip(now.previous, t, previous);
  sample_clip(now.current, t, current);
  blend_references(*mechanism_, layout_, previous, current, now.blend, reference);
}

void blend_references(const Mechanism& m, const ReferenceLayout& at, std::span<const double> previous, std::span<const double> current,
                      const BlendWeight& blend, std::span<double> out) {
  const double s = blend.weight;
  interpolate(m, previous.first(at.nq), current.first(at.nq), s, out.first(at.nq));
  const std::span<double> v = out.subspan(at.v(), at.nv), a = out.subspan(at.a(), at.nv);
  difference(m, previous.first(at.nq), current.first(at.nq), v);  // displacement from `previous` to `current`
  for (std::size_t i = 0; i < at.nv; ++i) {
    const double offset = v[i], v0 = previous[at.v() + i], v1 = current[at.v() + i], a0 = previous[at.a() + i], a1 = current[at.a() + i];
    v[i] = v0 + s * (v1 - v0) + blend.rate * offset;
    a[i] = a0 + s * (a1 - a0) + 2 * blend.rate * (v1 - v0) + blend.acceleration * offset;
  }
  for (std::size_t k = 0; k < at.feet; ++k) out[at.stance() + k] = s < 0.5 ? previous[at.stance() + k] : current[at.stance() + k];
}

}  // namespace ugoki::lsi
