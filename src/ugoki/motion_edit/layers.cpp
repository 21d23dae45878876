#include "ugoki/motion_edit/layers.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::motion_edit {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// State of a layer at one time of the base motion: time in the layer [s], and weight of its fade in and out (0 to 1).
struct Moment {
  double time = 0, share = 0;
};
Moment moment_of(const Motion& layer, const LayerOptions& o, double t, double end) {
  double local = t - o.offset;
  const double last = layer.cyclic ? std::max(end - o.offset, 0.0) : layer.duration();
  if (local < -1e-9 || local > last + 1e-9) return {};
  const auto eased = [](double x) { return x >= 1 ? 1.0 : x <= 0 ? 0.0 : x * x * x * (10 + x * (6 * x - 15)); };
  // No fade-in if the layer starts with the base motion; no fade-out if it ends with the base motion.
  const double in = o.fade > 0 && o.offset > 0 ? eased(local / o.fade) : 1;
  const double out = o.fade > 0 && o.offset + last < end - 1e-9 ? eased((last - local) / o.fade) : 1;
  if (layer.cyclic && local > layer.duration() + 1e-9) local -= layer.duration() * std::floor(local / layer.duration());
  return {local, in * out};
}

Error check(const Mechanism& m, const Motion& base, const Motion& layer, const JointMask& mask) {
  Error errors = check_motion(base, m);
  const Error wrong = check_motion(layer, m);
  errors.problems.insert(errors.problems.end(), wrong.problems.begin(), wrong.problems.end());
  if (mask.size() != at(m.link_count()))
    errors.add(
        ErrorCode::structure, "mask",
        "The mask has " + std::to_string(mask.size()) + " weights, but the mechanism has " + std::to_string(m.link_count()) + " links.",
        "Make the mask for this mechanism.");
  return errors;
}

Error check_times(const Motion& other, const LayerOptions& o) {
  if (std::isfinite(o.offset) && o.fade >= 0 && std::isfinite(o.fade)) return {};
  return {ErrorCode::range, "layer " + other.name, "The layer's offset or fade is not a valid time.",
          "Use a finite offset, and a fade of 0 s or more."};
}

}  // namespace

Result<JointMask> make_mask(const Mechanism& m, std::span<const MaskEntry> entries) {
  JointMask mask(at(m.link_count()), entries.empty() ? 1.0 : 0.0);
  Error errors;
  for (const MaskEntry& e : entries) {
    if (!(e.weight >= 0 && e.weight <= 1))
      errors.add(ErrorCode::range, "mask, link '" + e.link + "'", "The weight is " + to_text(e.weight) + ".", "Use a weight from 0 to 1.");
    bool found = e.link == "*";
    std::vector<bool> in(mask.size(), e.link == "*");
    for (int i = 0; i < m.link_count(); ++i) {
      const Link& link = m.link(i);
      const bool named = link.name == e.link || (!link.label.empty() && link.label == e.link);
      found = found || named;
      if (named || (e.with_children && link.parent >= 0 && in[at(link.parent)])) in[at(i)] = true;
      if (in[at(i)]) mask[at(i)] = e.weight;
    }
    if (!found)
      errors.add(ErrorCode::unknown, "mask, link '" + e.link + "'", "Mechanism " + m.name() + " has no link of this name or label.",
                 "List the links with `ugoki info`.");
  }
  if (!errors.empty()) return fail(std::move(errors));
  return mask;
}

Result<Motion> mix_joints(const Mechanism& m, const Motion& base, const Motion& other, const JointMask& mask, const LayerOptions& o) {
  if (Error wrong = check(m, base, other, mask); !wrong.empty()) return fail(std::move(wrong));
  if (Error wrong = check_times(other, o); !wrong.empty()) return fail(std::move(wrong));
  if (!(o.weight >= 0 && o.weight <= 1))
    return fail(ErrorCode::range, "layer " + other.name, "The weight is " + to_text(o.weight) + ".", "Use a weight from 0 to 1.");
  Motion out = base;
  std::vector<double> q(at(m.nq())), step(6);
  for (int f = 0; f < base.frames; ++f) {
    const Moment now = moment_of(other, o, f / base.rate, base.duration());
    if (now.share == 0) continue;
    sample(other, m, now.time, q);
    for (int i = 0; i < m.link_count(); ++i) {
      const Link& link = m.link(i);
      const double s = mask[at(i)] * o.weight * now.share;
      double* own = out.frame(f) + link.q_index;
      if (s == 0) continue;
      if (s == 1) {
        std::copy_n(q.data() + link.q_index, link.joint.nq(), own);
        continue;
      }
      joint_difference(link.joint, own, q.data() + link.q_index, step.data());
      joint_integrate(link.joint, own, step.data(), s, own);
    }
  }
  return out;
}

Result<Motion> add_layer(const Mechanism& m, const Motion& base, const Motion& layer, const JointMask& mask, const LayerOptions& o) {
  if (Error wrong = check(m, base, layer, mask); !wrong.empty()) return fail(std::move(wrong));
  if (Error wrong = check_times(layer, o); !wrong.empty()) return fail(std::move(wrong));
  if (!std::isfinite(o.weight)) return fail(ErrorCode::range, "layer " + layer.name, "The weight is not finite.", "Use a finite weight.");
  Motion out = base;
  std::vector<double> q(at(m.nq())), step(6);
  for (int f = 0; f < base.frames; ++f) {
    const Moment now = moment_of(layer, o, f / base.rate, base.duration());
    if (now.share == 0) continue;
    sample(layer, m, now.time, q);
    for (int i = 0; i < m.link_count(); ++i) {
      const Link& link = m.link(i);
      const double s = mask[at(i)] * o.weight * now.share;
      if (s == 0) continue;
      double* own = out.frame(f) + link.q_index;
      joint_difference(link.joint, layer.frame(0) + link.q_index, q.data() + link.q_index, step.data());
      joint_integrate(link.joint, own, step.data(), s, own);
    }
  }
  return out;
}

}  // namespace ugoki::motion_edit
