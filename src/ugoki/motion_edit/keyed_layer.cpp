#include "ugoki/motion_edit/keyed_layer.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"

namespace ugoki::motion_edit {
namespace {

using Values = std::array<double, 3>;

constexpr double full = 1 - 1e-9;  // a layer with this weight replaces the motion completely: the rest is rounding

/// Index in v, relative to the joint's first DOF, of the first component of a part. Floating joints: rotation, then position.
int first_dof(JointPart part) { return part == JointPart::position ? 3 : 0; }

double eased(double x) { return x >= 1 ? 1.0 : x <= 0 ? 0.0 : x * x * (3 - 2 * x); }

/// Monotone slope at a key between two pieces of lengths h0, h1 with mean slopes d0, d1 (Fritsch and Butland 1984).
double smooth_slope(double h0, double h1, double d0, double d1) {
  if (!(d0 * d1 > 0)) return 0;
  const double w0 = 2 * h1 + h0, w1 = h1 + 2 * h0;
  return (w0 + w1) / (w0 / d0 + w1 / d1);
}

/// Velocity that moves the joint by the value's components in 1 s. @param v [6, out]
void to_velocity(const Values& value, int count, JointPart part, double scale, double* v) {
  std::fill_n(v, 6, 0.0);
  for (int k = 0; k < count; ++k) v[first_dof(part) + k] = scale * value[static_cast<std::size_t>(k)];
}

/// The joint's position that a replacing layer gives: the neutral position displaced by the value. The other part of a floating joint is
/// copied from q.
void replaced(const Joint& joint, JointPart part, const Values& value, const double* q, double* out) {
  double v[6];
  joint_neutral(joint, out);
  if (joint.type == JointType::floating) {
    if (part == JointPart::rotation)
      std::copy_n(q, 3, out);
    else
      std::copy_n(q + 3, 4, out + 3);
  }
  to_velocity(value, component_count(joint.type, part), part, 1, v);
  joint_integrate(joint, out, v, 1, out);
}

Values value_in(const JointKeys& keyed, const LayerMoment& moment) {
  Values out = value_at(keyed.keys, moment.from);
  if (moment.mix == 0) return out;
  const Values to = value_at(keyed.keys, moment.to);
  for (std::size_t k = 0; k < 3; ++k) out[k] += moment.mix * (to[k] - out[k]);
  return out;
}

/// Moves q by `share` of the displacement that leads it to `goal`.
void approach(const Joint& joint, const double* goal, double share, double* q) {
  double v[6];
  joint_difference(joint, q, goal, v);
  joint_integrate(joint, q, v, share, q);
}

}  // namespace

int component_count(JointType type, JointPart part) {
  if (type == JointType::floating) return part == JointPart::whole ? 0 : 3;
  return part == JointPart::whole ? velocity_count(type) : 0;
}

const JointKeys* KeyedLayer::find(std::string_view link, JointPart part) const {
  for (const JointKeys& joint : joints)
    if (joint.link == link && joint.part == part) return &joint;
  return nullptr;
}

double KeyedLayer::weight_at(double t, double period) const { return moment_of(*this, t, period).weight; }

LayerMoment moment_of(const KeyedLayer& layer, double t, double period) {
  double first = INFINITY, last = -INFINITY;
  for (const JointKeys& joint : layer.joints) {
    if (joint.keys.empty()) continue;
    first = std::min(first, joint.keys.front().time);
    last = std::max(last, joint.keys.back().time);
  }
  if (first > last) return {};
  const auto faded = [](double away, double ease) { return away <= 0 ? 1.0 : ease > 0 ? eased(1 - away / ease) : 0.0; };
  if (!(period > 0)) {
    double share = layer.weight;
    if (t < first && layer.ease_in >= 0) share *= faded(first - t, layer.ease_in);
    if (t > last && layer.ease_out >= 0) share *= faded(t - last, layer.ease_out);
    return {share, t, t, 0};
  }
  t -= period * std::floor(t / period);
  if (t >= first && t <= last) return {layer.weight, t, t, 0};
  const double gap = std::max(period - (last - first), 0.0);
  const double since = t > last ? t - last : t + period - last, until = std::max(gap - since, 0.0);
  if (layer.ease_in < 0 && layer.ease_out < 0) return {layer.weight, last, first, gap > 0 ? eased(since / gap) : 0};
  double in = layer.ease_in, out = layer.ease_out;
  if (in < 0) in = std::max(gap - out, 0.0);
  if (out < 0) out = std::max(gap - in, 0.0);
  if (in + out > gap) {
    const double fit = gap / (in + out);
    in *= fit;
    out *= fit;
  }
  const double leaving = faded(since, out), coming = faded(until, in);
  return leaving >= coming ? LayerMoment{layer.weight * leaving, last, last, 0} : LayerMoment{layer.weight * coming, first, first, 0};
}

std::vector<std::array<Values, 2>> slopes_of(std::span<const LayerKey> keys) {
  std::vector<std::array<Values, 2>> out(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const LayerKey& key = keys[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const bool before = i > 0, after = i + 1 < keys.size();
      const double h0 = before ? key.time - keys[i - 1].time : 0, h1 = after ? keys[i + 1].time - key.time : 0;
      const double d0 = before ? (key.value[k] - keys[i - 1].value[k]) / h0 : 0,
                   d1 = after ? (keys[i + 1].value[k] - key.value[k]) / h1 : 0;
      double in = 0, next = 0;
      if (key.tangent == Tangent::free) {
        in = key.slope_in[k];
        next = key.slope_out[k];
      } else if (key.tangent == Tangent::linear) {
        in = d0;
        next = d1;
      } else if (key.tangent == Tangent::smooth && before && after) {
        in = next = smooth_slope(h0, h1, d0, d1);
      }
      out[i][0][k] = in;
      out[i][1][k] = next;
    }
  }
  return out;
}

Values value_at(std::span<const LayerKey> keys, double t) {
  if (keys.empty()) return {};
  if (t <= keys.front().time) return keys.front().value;
  if (t >= keys.back().time) return keys.back().value;
  const auto b = std::upper_bound(keys.begin(), keys.end(), t, [](double x, const LayerKey& key) { return x < key.time; });
  const auto a = b - 1;
  if (a->tangent == Tangent::step) return a->value;
  // The slopes of the two keys depend on at most one further key on each side.
  const auto from = a - (a != keys.begin() ? 1 : 0), to = b + (b + 1 != keys.end() ? 2 : 1);
  const auto slopes = slopes_of({from, to});
  const auto ia = static_cast<std::size_t>(a - from);
  const double h = b->time - a->time, s = (t - a->time) / h, s2 = s * s, s3 = s2 * s;
  Values out{};
  for (std::size_t k = 0; k < 3; ++k)
    out[k] = (2 * s3 - 3 * s2 + 1) * a->value[k] + (s3 - 2 * s2 + s) * h * slopes[ia][1][k] + (3 * s2 - 2 * s3) * b->value[k] +
             (s3 - s2) * h * slopes[ia + 1][0][k];
  return out;
}

namespace {

/// Calls `work(joint, part, count, value, own)` for each keyed joint that the mechanism has: the number of components of its part, their
/// values at the moment, and its coordinates in q.
template <class Work>
void for_each_joint(const Mechanism& m, const KeyedLayer& layer, const LayerMoment& moment, std::span<double> q, Work work) {
  for (const JointKeys& keyed : layer.joints) {
    const int i = m.find_link(keyed.link);
    if (i < 0 || keyed.keys.empty()) continue;
    const Joint& joint = m.link(i).joint;
    const int count = component_count(joint.type, keyed.part);
    if (count > 0) work(joint, keyed.part, count, value_in(keyed, moment), q.data() + m.link(i).q_index);
  }
}

}  // namespace

void apply_layer(const Mechanism& m, const KeyedLayer& layer, double t, std::span<double> q, double period) {
  const LayerMoment moment = moment_of(layer, t, period);
  const double weight = moment.weight;
  if (weight == 0) return;
  double v[6], goal[7];
  for_each_joint(m, layer, moment, q, [&](const Joint& joint, JointPart part, int count, const Values& value, double* own) {
    if (layer.mode == LayerMode::additive) {
      to_velocity(value, count, part, weight, v);
      joint_integrate(joint, own, v, 1, own);
    } else {
      replaced(joint, part, value, own, goal);
      if (weight >= full)
        std::copy_n(goal, joint.nq(), own);
      else
        approach(joint, goal, weight, own);
    }
  });
}

bool remove_layer(const Mechanism& m, const KeyedLayer& layer, double t, std::span<double> q, double period) {
  const LayerMoment moment = moment_of(layer, t, period);
  const double weight = moment.weight;
  if (weight == 0) return true;
  bool all = true;
  double v[6], goal[7];
  for_each_joint(m, layer, moment, q, [&](const Joint& joint, JointPart part, int count, const Values& value, double* own) {
    if (layer.mode == LayerMode::additive) {
      to_velocity(value, count, part, -weight, v);
      joint_integrate(joint, own, v, 1, own);
    } else if (weight >= full) {
      all = false;
    } else {
      // own = below + weight (goal - below) on a geodesic, so below = goal + (own - goal) / (1 - weight)
      replaced(joint, part, value, own, goal);
      joint_difference(joint, goal, own, v);
      joint_integrate(joint, goal, v, 1 / (1 - weight), own);
    }
  });
  return all;
}

Values key_value(const Joint& joint, JointPart part, LayerMode mode, double weight, const double* below, const double* wanted) {
  double v[6], goal[7];
  const int count = component_count(joint.type, part);
  joint_difference(joint, below, wanted, v);
  for (double& x : v) x /= weight;
  if (mode == LayerMode::replace) {
    joint_integrate(joint, below, v, 1, goal);
    if (joint.type == JointType::floating) {
      double zero[7];
      joint_neutral(joint, zero);
      joint_difference(joint, zero, goal, v);
    } else {
      joint_displacement(joint, goal, v);
    }
  }
  Values out{};
  for (int k = 0; k < count; ++k) out[static_cast<std::size_t>(k)] = v[first_dof(part) + k];
  return out;
}

Result<Motion> apply_layers(const Mechanism& m, const Motion& motion, std::span<const KeyedLayer> layers, bool repeats) {
  Error errors = check_motion(motion, m);
  for (const KeyedLayer& layer : layers)
    for (const JointKeys& keyed : layer.joints) {
      const int i = m.find_link(keyed.link);
      const std::string location = "keys of link " + keyed.link;
      if (i < 0)
        errors.add(ErrorCode::unknown, location, "Mechanism " + m.name() + " has no such link.", "Remove these keys.");
      else if (component_count(m.link(i).joint.type, keyed.part) == 0)
        errors.add(ErrorCode::structure, location, "The link's joint cannot be moved in this way.", "Remove these keys.");
      for (std::size_t k = 0; k < keyed.keys.size(); ++k)
        if (!std::isfinite(keyed.keys[k].time) || (k > 0 && !(keyed.keys[k].time > keyed.keys[k - 1].time)))
          errors.add(ErrorCode::structure, location, "Key " + std::to_string(k) + " is not later than the previous one.",
                     "Sort the keys by time.");
    }
  if (!errors.empty()) return fail(std::move(errors));
  Motion out = motion;
  const double period = repeats ? motion.duration() : 0;
  for (int f = 0; f < out.frames; ++f)
    for (const KeyedLayer& layer : layers) apply_layer(m, layer, f / out.rate, {out.frame(f), static_cast<std::size_t>(out.nq)}, period);
  return out;
}

}  // namespace ugoki::motion_edit
