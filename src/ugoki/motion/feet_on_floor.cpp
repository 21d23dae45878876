#include "ugoki/motion/feet_on_floor.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"

namespace ugoki {
namespace {

constexpr double root_time = 0.1;    // s in which the root follows what the standing feet have in common
constexpr double foot_time = 0.03;   // s in which a foot follows its own correction
constexpr double still_speed = 0.2;  // m/s upwards or downwards: a foot that is slower counts fully as standing
constexpr double damping = 0.02;     // m: a straight leg is not bent for less
constexpr double lever = 0.3;        // m: an error of the foot's orientation counts as one of its place at this distance

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A foot with its toes.
struct Foot {
  int link;
  std::vector<int> parts;  ///< links that can bear: the foot and those behind it
  std::vector<std::vector<SupportPoint>> points;
  std::vector<int> limb;      ///< links from the limb's base to the foot, whose joints can move it alone
  std::vector<double> low;    ///< m above the floor, lowest point in each frame
  std::vector<double> bears;  ///< 0 ... 1 in each frame
};

std::vector<Foot> find_whole_feet(const Mechanism& m) {
  const std::vector<int> links = find_feet(m);  // parents first
  std::vector<Foot> feet;
  std::vector<int> feet_behind(at(m.link_count()), 0);
  for (const int link : links) {
    const auto whole = std::find_if(feet.begin(), feet.end(), [&](const Foot& f) {
      return std::find(f.parts.begin(), f.parts.end(), m.link(link).parent) != f.parts.end();
    });
    Foot& foot = whole == feet.end() ? feet.emplace_back() : *whole;
    if (foot.parts.empty()) {
      foot.link = link;
      for (int i = link; i >= 0; i = m.link(i).parent) ++feet_behind[at(i)];
    }
    foot.parts.push_back(link);
    foot.points.push_back(support_points(m.link(link)));
  }
  for (Foot& foot : feet)
    for (int i = foot.link; i > 0 && feet_behind[at(i)] == 1; i = m.link(i).parent) foot.limb.insert(foot.limb.begin(), i);
  return feet;
}

double lowest_point(const Foot& foot, std::span<const Pose> X_WB) {
  double low = 1e300;
  for (std::size_t p = 0; p < foot.parts.size(); ++p)
    for (const SupportPoint& s : foot.points[p]) low = std::min(low, (X_WB[at(foot.parts[p])] * s.p).z - s.radius);
  return low;
}

/// x of least sum of weight (x - value)^2 + stiffness (x[i + 1] - x[i])^2: follows the values where they have weight, runs straight
/// between, and level before the first and after the last. All zero without any weight.
std::vector<double> pass_through(std::span<const double> value, std::span<const double> weight, double stiffness) {
  const std::size_t n = value.size();
  std::vector<double> x(n, 0.0), pivot(n);
  if (std::all_of(weight.begin(), weight.end(), [](double w) { return !(w > 1e-3); })) return x;
  for (std::size_t i = 0; i < n; ++i) {
    pivot[i] = weight[i] + stiffness * ((i > 0 ? 1 : 0) + (i + 1 < n ? 1 : 0));
    x[i] = weight[i] * value[i];
    if (i == 0) continue;
    pivot[i] -= stiffness * stiffness / pivot[i - 1];
    x[i] += stiffness / pivot[i - 1] * x[i - 1];
  }
  for (std::size_t i = n; i-- > 0;) x[i] = (x[i] + (i + 1 < n ? stiffness * x[i + 1] : 0.0)) / pivot[i];
  return x;
}

/// Fills `low` and `bears` of the feet.
void observe(const Motion& motion, const Mechanism& m, double floor, std::vector<Foot>& feet) {
  std::vector<Pose> X(at(m.link_count()));
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, std::span(motion.frame(f), at(motion.nq)), X);
    for (Foot& foot : feet) foot.low.push_back(lowest_point(foot, X) - floor);
  }
  std::vector<int> links;
  for (const Foot& foot : feet) links.push_back(foot.link);
  Motion labelled = motion;
  ContactLabelOptions options;
  options.ground = floor;
  label_contacts(m, labelled, links, options);
  for (std::size_t k = 0; k < feet.size(); ++k) {
    Foot& foot = feet[k];
    for (int f = 0; f < motion.frames; ++f) {
      const int before = std::max(0, f - 1), after = std::min(motion.frames - 1, f + 1);
      const double speed = (foot.low[at(after)] - foot.low[at(before)]) * motion.rate / (after - before);
      const double share = 1 / (1 + speed * speed / (still_speed * still_speed));
      foot.bears.push_back(labelled.contacts[k].on[at(f)] ? share * share : 0.0);
    }
  }
}

/// The place that all standing feet ask of the root, [frames] m.
std::vector<double> lift_of_root(const std::vector<Foot>& feet, double rate) {
  const std::size_t frames = feet.front().low.size();
  std::vector<double> value(frames), weight(frames);
  for (std::size_t f = 0; f < frames; ++f) {
    for (const Foot& foot : feet) {
      weight[f] += foot.bears[f];
      value[f] -= foot.bears[f] * foot.low[f];
    }
    if (weight[f] > 0) value[f] /= weight[f];
  }
  return pass_through(value, weight, root_time * rate * root_time * rate);
}

/// What is left for one limb, [frames] m.
std::vector<double> lift_of_foot(const Foot& foot, std::span<const double> root, double rate) {
  std::vector<double> value(root.size());
  for (std::size_t f = 0; f < root.size(); ++f) value[f] = -foot.low[f] - root[f];
  std::vector<double> lift = pass_through(value, foot.bears, foot_time * rate * foot_time * rate);
  for (std::size_t f = 0; f < root.size(); ++f) lift[f] = std::max(lift[f], value[f]);
  return lift;
}

/// Solves the symmetric positive definite A x = b in place.
void solve_spd(std::array<std::array<double, 6>, 6>& A, std::array<double, 6>& b) {
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = i + 1; j < 6; ++j) {
      const double factor = A[j][i] / A[i][i];
      for (std::size_t k = i; k < 6; ++k) A[j][k] -= factor * A[i][k];
      b[j] -= factor * b[i];
    }
  for (std::size_t i = 6; i-- > 0;) {
    for (std::size_t k = i + 1; k < 6; ++k) b[i] -= A[i][k] * b[k];
    b[i] /= A[i][i];
  }
}

/// Moves the limb's joints so that its foot comes to X_goal as nearly as damping lets it. @param q coordinates of one frame
/// @param X_WB poses of all links at q, kept up to date for the limb
void reach(const Mechanism& m, const Foot& foot, const Pose& X_goal, double* q, std::span<Pose> X_WB) {
  struct Column {
    const Link* link;
    std::array<double, 6> J;  // place of the foot, then its orientation times the lever
  };
  std::vector<Column> columns;
  for (int iteration = 0; iteration < 6; ++iteration) {
    const Pose& X_WF = X_WB[at(foot.link)];
    const Vec3 place = X_goal.p - X_WF.p, turn = log_map(to_quat(X_goal.R * X_WF.R.transposed())) * lever;
    if (dot(place, place) + dot(turn, turn) < 1e-10) return;
    columns.clear();
    for (const int i : foot.limb) {
      const Link& link = m.link(i);
      const Pose& X = X_WB[at(i)];
      Vec6 S[6];
      for (int k = 0, n = joint_subspace(link.joint, q + link.q_index, S); k < n; ++k) {
        const Vec3 w = X.R * S[k].w, v = X.R * S[k].v + cross(w, X_WF.p - X.p);
        columns.push_back({&link, {v.x, v.y, v.z, lever * w.x, lever * w.y, lever * w.z}});
      }
    }
    std::array<double, 6> y = {place.x, place.y, place.z, turn.x, turn.y, turn.z};
    std::array<std::array<double, 6>, 6> A{};
    for (std::size_t r = 0; r < 6; ++r) {
      A[r][r] = damping * damping;
      for (std::size_t s = 0; s < 6; ++s)
        for (const Column& c : columns) A[r][s] += c.J[r] * c.J[s];
    }
    solve_spd(A, y);
    for (auto c = columns.begin(); c != columns.end();) {
      const Link& link = *c->link;
      const Joint& joint = link.joint;
      double step[6] = {0, 0, 0, 0, 0, 0};
      for (int k = 0; k < joint.nv(); ++k, ++c)
        for (std::size_t r = 0; r < 6; ++r) step[k] += c->J[r] * y[r];
      double* own = q + link.q_index;
      const double before = own[0];
      joint_integrate(joint, own, step, 1.0, own);
      if (joint.type == JointType::revolute)  // a hinge is not led beyond its limit, and not back from where it was beyond it
        own[0] = std::clamp(own[0], std::min(before, joint.freedoms[0].lower), std::max(before, joint.freedoms[0].upper));
    }
    for (const int i : foot.limb) {
      const Link& link = m.link(i);
      X_WB[at(i)] = X_WB[at(link.parent)] * link.joint.X_PJ * joint_pose(link.joint, q + link.q_index);
    }
  }
}

}  // namespace

Motion with_feet_on_floor(const Motion& motion, const Mechanism& m, double floor) {
  Motion out = motion;
  std::vector<Foot> feet = find_whole_feet(m);
  if (feet.empty() || motion.frames < 2 || m.link(0).joint.type != JointType::floating) return out;
  observe(motion, m, floor, feet);
  const std::vector<double> root = lift_of_root(feet, motion.rate);
  std::vector<std::vector<double>> lifts;
  for (const Foot& foot : feet) lifts.push_back(lift_of_foot(foot, root, motion.rate));
  std::vector<Pose> X(at(m.link_count()));
  for (int f = 0; f < motion.frames; ++f) {
    double* q = out.frame(f);
    const Vec3 up = transpose_times(m.link(0).joint.X_PJ.R, Vec3{0, 0, root[at(f)]});
    for (int k = 0; k < 3; ++k) q[k] += up[k];
    calc_poses(m, std::span<const double>(q, at(motion.nq)), X);
    for (std::size_t k = 0; k < feet.size(); ++k) {
      Pose goal = X[at(feet[k].link)];
      goal.p.z += lifts[k][at(f)];
      reach(m, feet[k], goal, q, X);
    }
  }
  return out;
}

}  // namespace ugoki
