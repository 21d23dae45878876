#include "ugoki/motion_edit/edit.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/smooth_motion.h"

namespace ugoki::motion_edit {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::string place_of(const Motion& motion) { return "motion " + motion.name; }

/// Samples `source` at other times.
/// @param frames number of new frames  @param moment_of function from the index of a new frame to a time in the source [s]
template <class MomentOf>
Motion played(const Mechanism& m, const Motion& source, const SmoothMotion& smooth, int frames, double rate, const MomentOf& moment_of) {
  Motion out = source;
  out.rate = rate;
  out.frames = frames;
  out.q.assign(at(frames) * at(source.nq), 0.0);
  for (ContactTrack& track : out.contacts) track.on.assign(at(frames), 0);
  std::vector<double> v(at(m.nv())), a(v.size());
  for (int f = 0; f < frames; ++f) {
    const double t = std::clamp(moment_of(f), 0.0, source.duration());
    smooth.sample(m, t, {out.frame(f), at(out.nq)}, v, a);
    const auto nearest = static_cast<std::size_t>(std::clamp(t * source.rate + 0.5, 0.0, static_cast<double>(source.frames - 1)));
    for (std::size_t k = 0; k < out.contacts.size(); ++k) out.contacts[k].on[at(f)] = source.contacts[k].on[nearest];
  }
  return out;
}

constexpr double min_factor = 1e-6, max_factor = 1e6, min_rate = 0.001, max_rate = 1e5;

Error check_factor(const char* quantity, double x) {
  if (x >= min_factor && x <= max_factor) return {};
  return {ErrorCode::range, std::string("factor of ") + quantity, "The factor is " + to_text(x) + ".",
          "Use a factor from 0.000001 to 1000000."};
}

/// Refuses results with more than 100 million coordinates (0.8 GB). @param frames number of new frames
Error check_size(const Motion& motion, double frames) {
  const double maximum = std::floor(1e8 / std::max(1, motion.nq));
  if (frames <= maximum) return {};
  return {ErrorCode::range, place_of(motion), "The result would have " + to_fixed(frames, 0) + " frames.",
          "Reduce its duration or its frame rate: at most " + to_fixed(maximum, 0) + " frames are allowed."};
}

/// Formats a time [s] with three decimals, rounded down so that a limit shown to the user is valid.
std::string seconds(double s) { return to_fixed(std::floor(1000 * s + 1e-6) / 1000, 3) + " s"; }

}  // namespace

Result<Motion> trim(const Motion& motion, int first, int last) {
  if (first < 0 || last >= motion.frames || first > last)
    return fail(ErrorCode::range, place_of(motion),
                "Frames " + std::to_string(first) + " to " + std::to_string(last) + " are not a range within the motion's " +
                    std::to_string(motion.frames) + " frames.",
                "Use frames from 0 to " + std::to_string(motion.frames - 1) + " (0 to " + seconds(motion.duration()) + ").");
  Motion out = motion;
  out.frames = last - first + 1;
  out.cyclic = motion.cyclic && out.frames == motion.frames;
  out.q.assign(motion.frame(first), motion.frame(last) + motion.nq);
  for (ContactTrack& track : out.contacts) track.on = std::vector<std::uint8_t>(track.on.begin() + first, track.on.begin() + last + 1);
  return out;
}

Motion reverse(const Motion& motion) {
  Motion out = motion;
  for (int f = 0; f < motion.frames; ++f) std::copy_n(motion.frame(motion.frames - 1 - f), motion.nq, out.frame(f));
  for (ContactTrack& track : out.contacts) std::reverse(track.on.begin(), track.on.end());
  return out;
}

Result<Motion> resample(const Mechanism& m, const Motion& motion, double rate) {
  if (Error wrong = check_motion(motion, m); !wrong.empty()) return fail(std::move(wrong));
  if (!(rate >= 1 && rate <= max_rate))
    return fail(ErrorCode::range, place_of(motion), "The new frame rate is " + to_text(rate) + " frames per second.",
                "Use 1 to 100000 frames per second.");
  if (motion.frames < 2) {
    Motion out = motion;
    out.rate = rate;
    return out;
  }
  const bool around = motion.cyclic;
  if (Error wrong = check_size(motion, motion.duration() * rate + 1); !wrong.empty()) return fail(std::move(wrong));
  const int steps = std::max(1, static_cast<int>(std::floor(motion.duration() * rate + (around ? 0.5 : 1e-6))));
  const double new_rate = around ? steps / motion.duration() : rate;
  const double cutoff = rate < 0.8 * motion.rate ? 0.4 * rate : 0;
  const SmoothMotion smooth(motion, m, cutoff);
  return played(m, motion, smooth, steps + 1, new_rate, [&](int f) { return f / new_rate; });
}

Result<Motion> scale(const Mechanism& m, const Motion& motion, const ScaleOptions& o) {
  Error errors = check_motion(motion, m);
  for (const Error& wrong : {check_factor("length", o.length), check_factor("time", o.time)})
    errors.problems.insert(errors.problems.end(), wrong.problems.begin(), wrong.problems.end());
  if (!errors.empty()) return fail(std::move(errors));
  Motion out = motion;
  out.rate = motion.rate / (o.time * (o.froude ? std::sqrt(o.length) : 1.0));
  if (!(out.rate >= min_rate && out.rate <= max_rate))
    return fail(ErrorCode::range, place_of(motion), "The result would have " + to_text(out.rate) + " frames per second.",
                "Use a time factor that gives 0.001 to 100000 frames per second.");
  for (int f = 0; f < out.frames; ++f)
    for (const Link& link : m.links()) {
      double* q = out.frame(f) + link.q_index;
      switch (link.joint.type) {
        case JointType::prismatic: q[0] *= o.length; break;
        case JointType::cylindrical: q[1] *= o.length; break;
        case JointType::planar:
        case JointType::floating:
          for (int k = 0; k < (link.joint.type == JointType::planar ? 2 : 3); ++k) q[k] *= o.length;
          break;
        default: break;
      }
    }
  return out;
}

Result<Motion> time_warp(const Mechanism& m, const Motion& motion, std::span<const TimePoint> p) {
  if (Error wrong = check_motion(motion, m); !wrong.empty()) return fail(std::move(wrong));
  if (p.size() < 2)
    return fail(ErrorCode::structure, "time curve", "The time curve has fewer than two points.", "Specify at least its start and end.");
  for (std::size_t i = 0; i < p.size(); ++i) {
    const std::string location = "time curve, point " + std::to_string(i);
    if (!std::isfinite(p[i].time) || !(p[i].source >= 0 && p[i].source <= motion.duration() + 1e-9))
      return fail(ErrorCode::range, location,
                  "The source time is " + to_text(p[i].source) + " s, but the motion lasts " + seconds(motion.duration()) + ".",
                  "Keep source times within the motion.");
    if (i > 0 && !(p[i].time > p[i - 1].time && p[i].source >= p[i - 1].source))
      return fail(ErrorCode::range, location, "The time does not increase, or the source time decreases.",
                  "Use increasing times; use `reverse` to play backwards.");
  }
  std::vector<double> slope(p.size());
  const auto rise = [&](std::size_t i) { return (p[i + 1].source - p[i].source) / (p[i + 1].time - p[i].time); };
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (i == 0 || i + 1 == p.size()) {
      slope[i] = rise(i == 0 ? 0 : i - 1);
    } else {
      const double a = rise(i - 1), b = rise(i);
      slope[i] = a > 0 && b > 0 ? 2 * a * b / (a + b) : 0;
    }
  }
  const auto moment = [&](int f) {
    const double t = std::min(p[0].time + f / motion.rate, p.back().time);
    std::size_t i = p.size() - 2;
    while (i > 0 && p[i].time > t) --i;
    const double h = p[i + 1].time - p[i].time, s = (t - p[i].time) / h, d = p[i + 1].source - p[i].source;
    const double m0 = slope[i] * h, m1 = slope[i + 1] * h;
    return p[i].source + s * (m0 + s * ((3 * d - 2 * m0 - m1) + s * (m0 + m1 - 2 * d)));
  };
  if (Error wrong = check_size(motion, (p.back().time - p[0].time) * motion.rate + 1); !wrong.empty()) return fail(std::move(wrong));
  const int frames = static_cast<int>(std::floor((p.back().time - p[0].time) * motion.rate + 1e-6)) + 1;
  Motion out = played(m, motion, SmoothMotion(motion, m, 0), frames, motion.rate, moment);
  const bool whole = p[0].source <= 0 && p.back().source >= motion.duration() - 1e-9;
  out.cyclic = motion.cyclic && whole && std::fabs((frames - 1) / motion.rate - (p.back().time - p[0].time)) < 1e-6;
  return out;
}

Result<Motion> join(const Mechanism& m, const Motion& first, const Motion& second, const JoinOptions& o) {
  Error errors = check_motion(first, m);
  const Error wrong = check_motion(second, m);
  errors.problems.insert(errors.problems.end(), wrong.problems.begin(), wrong.problems.end());
  if (!errors.empty()) return fail(std::move(errors));
  if (!(o.blend >= 0 && o.blend <= std::min(first.duration(), second.duration())))
    return fail(ErrorCode::range, "join", "A blend of " + to_text(o.blend) + " s does not fit into both motions.",
                "Use a blend from 0 s to " + seconds(std::min(first.duration(), second.duration())) + ".");
  Result<Motion> next = second.rate == first.rate ? Result<Motion>(second) : resample(m, second, first.rate);
  if (!next) return next;
  if (Error too_long = check_size(first, static_cast<double>(first.frames) + next->frames); !too_long.empty())
    return fail(std::move(too_long));
  const auto nq = at(first.nq);
  const int overlap = static_cast<int>(o.blend * first.rate + 0.5), start = first.frames - 1 - overlap;
  Placement by;
  if (o.where_it_ends) {
    const Placement from = root_placement(m, {next->frame(0), nq}), to = root_placement(m, {first.frame(start), nq});
    by = to * inverse(from);
    by.z = 0;  // z = 0: heights above the floor are not changed
  }
  Motion out = first;
  out.name = first.name + " + " + second.name;
  out.source = first.source + ", then " + second.source;
  out.cyclic = false;
  out.frames = start + next->frames;
  out.q.resize(at(out.frames) * nq);
  for (ContactTrack& track : out.contacts) track.on.resize(at(out.frames), 0);
  for (const ContactTrack& track : next->contacts)
    if (std::none_of(out.contacts.begin(), out.contacts.end(), [&](const ContactTrack& t) { return t.link == track.link; }))
      out.contacts.push_back({track.link, std::vector<std::uint8_t>(at(out.frames), 0)});
  std::vector<double> q(nq);
  for (int f = start; f < out.frames; ++f) {
    const int own = f - start;
    std::copy_n(next->frame(own), nq, q.data());
    displace_root(m, by, q);
    const double x = overlap > 0 ? std::min(1.0, static_cast<double>(own) / overlap) : 1;
    const double s = x * x * x * (10 + x * (6 * x - 15));
    if (s < 1 && f < first.frames)
      interpolate(m, {first.frame(f), nq}, q, s, {out.frame(f), nq});
    else
      std::copy(q.begin(), q.end(), out.frame(f));
    if (s < 0.5) continue;
    for (ContactTrack& track : out.contacts) {
      track.on[at(f)] = 0;
      for (const ContactTrack& from : next->contacts)
        if (from.link == track.link) track.on[at(f)] = from.on[at(own)];
    }
  }
  return out;
}

}  // namespace ugoki::motion_edit
