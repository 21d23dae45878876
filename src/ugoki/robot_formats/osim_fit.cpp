// Replaces the joints of OpenSim models by chains of the joint types of joint.h.
#include <algorithm>
#include <cmath>

#include "ugoki/robot_formats/osim_model.h"

namespace ugoki::robot_formats {
namespace {

constexpr double still = 1e-6;  // rad or m: an axis whose value changes by less is constant
constexpr int samples = 21;     // values of each coordinate within its range

std::size_t at(int i) { return static_cast<std::size_t>(i); }

class Fit {
 public:
  Fit(const OsimModel& model, const OsimBody& body) : model_(model), body_(body) {
    rest_.reserve(model.coordinates.size());
    for (const OsimCoordinate& c : model.coordinates) rest_.push_back(c.rest);
    model.complete(rest_);
  }

  OsimJointFit make() {
    choose_axes();
    build();
    centre();
    measure();
    return std::move(out_);
  }

 private:
  [[nodiscard]] double value(int axis, std::span<const double> q) const {
    const OsimAxis& a = body_.motion[at(axis)];
    std::vector<double> x;
    for (const int c : a.coordinates) x.push_back(q[at(c)]);
    return a.function(x);
  }

  /// All coordinates with the coordinate `c` at its s-th sample, the others at their default.
  [[nodiscard]] std::vector<double> sample(int c, int s) const {
    const OsimCoordinate& k = model_.coordinates[at(c)];
    double low = k.lower, high = k.upper;
    const double reach = k.rotational ? 1.0 : 0.5;
    if (!(high > low) || high - low > 6 * reach) {
      low = k.rest - reach;
      high = k.rest + reach;
    }
    std::vector<double> q = rest_;
    q[at(c)] = low + (high - low) * s / (samples - 1);
    model_.complete(q);
    return q;
  }

  /// Range of an axis's value over the range of the coordinate `c`.
  [[nodiscard]] double range(int axis, int c) const {
    double low = 1e300, high = -1e300;
    for (int s = 0; s < samples; ++s) {
      const double v = value(axis, sample(c, s));
      low = std::min(low, v);
      high = std::max(high, v);
    }
    return high - low;
  }

  /// Each free coordinate drives one axis: the rotation, otherwise the translation, with the largest range.
  void choose_axes() {
    for (std::size_t c = 0; c < model_.coordinates.size(); ++c) {
      const OsimCoordinate& k = model_.coordinates[c];
      if (k.locked || k.source >= 0) continue;
      int best = -1;
      double widest = still;
      for (int i = 0; i < 6; ++i) {
        const std::vector<int>& list = body_.motion[at(i)].coordinates;
        if (taken_[at(i)] || std::find(list.begin(), list.end(), static_cast<int>(c)) == list.end()) continue;
        if (i >= 3 && best >= 0 && best < 3) break;
        // A linear function is the coordinate itself; a spline usually follows from another axis.
        const double r = range(i, static_cast<int>(c)) * (body_.motion[at(i)].function.kind == OsimFunction::Kind::linear ? 1e3 : 1);
        if (r > widest) {
          widest = r;
          best = i;
        }
      }
      if (best < 0) continue;
      taken_[at(best)] = true;
      driver_[at(best)] = static_cast<int>(c);
    }
  }

  [[nodiscard]] Dof dof(int axis) const {
    Dof d;
    const OsimCoordinate& k = model_.coordinates[at(driver_[at(axis)])];
    if (!(k.upper > k.lower)) return d;
    std::vector<double> q = rest_;
    double ends[2];
    for (int e = 0; e < 2; ++e) {
      q[at(driver_[at(axis)])] = e == 0 ? k.lower : k.upper;
      ends[e] = value(axis, q);
    }
    d.lower = std::min(ends[0], ends[1]);
    d.upper = std::max(ends[0], ends[1]);
    return d;
  }

  void build() {
    std::vector<int> turns, shifts;
    for (int i = 0; i < 6; ++i)
      if (taken_[at(i)]) (i < 3 ? turns : shifts).push_back(i);
    Pose before;  // constant translation, then constant rotations, in front of the next joint
    for (int i = 3; i < 6; ++i)
      if (!taken_[at(i)]) before.p += body_.motion[at(i)].axis * value(i, rest_);
    const auto constant = [&](int i) { return rotation_about(body_.motion[at(i)].axis, value(i, rest_)); };
    const auto axis = [&](int i) { return body_.motion[at(i)].axis; };
    const auto square = [&](int a, int b) { return std::fabs(dot(axis(a), axis(b))) < 1e-9; };

    const bool three = turns.size() == 3 && square(0, 1) && square(0, 2) && square(1, 2);
    if (three && shifts.size() == 3 && square(3, 4) && square(3, 5) && square(4, 5)) {
      Step step;
      step.joint.type = JointType::floating;
      step.joint.X_PJ = before;
      step.axes = {0, 1, 2, 3, 4, 5};
      out_.chain.push_back(step);
      return;
    }
    const bool in_plane = shifts.size() == 2 && turns.size() == 1 && square(shifts[0], shifts[1]) && square(shifts[0], turns[0]) &&
                          square(shifts[1], turns[0]);
    if (in_plane) {
      const Vec3 x = axis(shifts[0]), z = axis(turns[0]), y = cross(z, x);
      const bool flipped = dot(y, axis(shifts[1])) < 0;
      Step step;
      step.joint.type = JointType::planar;
      const Vec3 x2 = flipped ? axis(shifts[1]) : x, y2 = flipped ? x : y;
      const Mat3 J{x2.x, y2.x, z.x, x2.y, y2.y, z.y, x2.z, y2.z, z.z};
      Mat3 pre = Mat3::identity(), post = Mat3::identity();
      for (int i = 0; i < turns[0]; ++i) pre = pre * constant(i);
      for (int i = turns[0] + 1; i < 3; ++i) post = post * constant(i);
      // A rotation in front of the hinge would turn its axis out of the plane; without one the joint is exact.
      if (norm(pre * z - z) < 1e-9) {
        step.joint.X_PJ = before * Pose{J, {}};
        step.joint.dofs[0] = dof(flipped ? shifts[1] : shifts[0]);
        step.joint.dofs[1] = dof(flipped ? shifts[0] : shifts[1]);
        step.joint.dofs[2] = dof(turns[0]);
        step.axes = {flipped ? shifts[1] : shifts[0], flipped ? shifts[0] : shifts[1], turns[0]};
        out_.chain.push_back(step);
        out_.X_LM = Pose{J.transposed() * pre * post, {}};
        return;
      }
    }
    for (const int i : shifts) {
      Step step;
      step.joint.type = JointType::prismatic;
      step.joint.X_PJ = before;
      step.joint.axis = axis(i);
      step.joint.dofs[0] = dof(i);
      step.axes = {i};
      out_.chain.push_back(step);
      before = {};
    }
    if (three) {
      Step step;
      step.joint.type = JointType::spherical;
      step.joint.X_PJ = before;
      for (int i = 0; i < 3; ++i)  // the rotation vector has these components for rotations about one axis
        for (int e = 0; e < 3; ++e) {
          const double along = e == 0 ? axis(i).x : e == 1 ? axis(i).y : axis(i).z;
          if (std::fabs(std::fabs(along) - 1) > 1e-6) continue;
          const Dof d = dof(i);
          step.joint.dofs[at(e)].lower = along > 0 ? d.lower : -d.upper;
          step.joint.dofs[at(e)].upper = along > 0 ? d.upper : -d.lower;
        }
      step.axes = {0, 1, 2};
      out_.chain.push_back(step);
      return;
    }
    Mat3 pre = before.R;
    Vec3 p = before.p;
    std::size_t done = 0;
    for (int i = 0; i < 3; ++i) {
      if (!taken_[at(i)]) {
        pre = pre * constant(i);
        continue;
      }
      // Two successive rotations are a universal joint: constant rotations between them turn the second axis.
      Step step;
      step.joint.X_PJ = {pre, p};
      step.joint.axis = axis(i);
      step.joint.dofs[0] = dof(i);
      step.axes = {i};
      pre = Mat3::identity();
      p = {};
      ++done;
      if (done + 1 == turns.size() && turns.size() == 2) {
        const int j = turns[1];
        Mat3 between = Mat3::identity();
        for (int k = i + 1; k < j; ++k) between = between * constant(k);
        step.joint.type = JointType::universal;
        step.joint.axis2 = between * axis(j);
        step.joint.dofs[1] = dof(j);
        step.axes.push_back(j);
        pre = between;
        i = j;
      } else {
        step.joint.type = JointType::revolute;
      }
      out_.chain.push_back(step);
    }
    if (out_.chain.empty()) {
      Step step;
      step.joint.X_PJ = {pre, p};
      out_.chain.push_back(step);
      return;
    }
    out_.X_LM = {pre, p};
  }

  /// Pose of M in F by the chain.
  [[nodiscard]] Pose chain_pose(std::span<const double> q) const {
    Pose X;
    for (const Step& step : out_.chain) {
      std::vector<double> own(7, 0.0);
      osim_joint_coordinates(body_, step, q, own);
      X = X * step.joint.X_PJ * joint_pose(step.joint, own.data());
    }
    return X * out_.X_LM;
  }

  /// A single hinge (or universal or ball joint) is moved to the point that moves least: with R(q) and p(q) of M in F, the points c of F
  /// and e of M minimise sum |c + R(q) e - p(q)|^2. A small weight on |e| decides the position along a hinge's axis.
  void centre() {
    bool moves = false;
    for (int i = 3; i < 6; ++i) {
      if (taken_[at(i)]) return;
      for (const int c : body_.motion[at(i)].coordinates) moves = moves || range(i, c) > still;
    }
    if (!moves || out_.chain.size() != 1 || out_.chain[0].joint.type == JointType::fixed) return;
    double A[6][7] = {};
    int count = 0;
    for (int i = 0; i < 3; ++i) {
      if (!taken_[at(i)]) continue;
      for (int s = 0; s < samples; ++s, ++count) {
        const std::vector<double> q = sample(driver_[at(i)], s);
        const Mat3 R = chain_pose(q).R;
        const Vec3 p = model_.joint_pose(body_, q).p;
        for (int r = 0; r < 3; ++r) {
          double row[7] = {
              r == 0 ? 1.0 : 0, r == 1 ? 1.0 : 0, r == 2 ? 1.0 : 0, R.row(r).x, R.row(r).y, R.row(r).z, r == 0 ? p.x : r == 1 ? p.y : p.z};
          for (int a = 0; a < 6; ++a)
            for (int b = 0; b < 7; ++b) A[a][b] += row[a] * row[b];
        }
      }
    }
    for (int a = 3; a < 6; ++a) A[a][a] += 1e-6 * count;
    double x[6];
    for (int k = 0; k < 6; ++k) {  // elimination with pivoting
      int pivot = k;
      for (int r = k + 1; r < 6; ++r)
        if (std::fabs(A[r][k]) > std::fabs(A[pivot][k])) pivot = r;
      if (std::fabs(A[pivot][k]) < 1e-12) return;
      std::swap(A[k], A[pivot]);
      for (int r = k + 1; r < 6; ++r)
        for (int b = 6; b >= k; --b) A[r][b] -= A[r][k] / A[k][k] * A[k][b];
    }
    for (int k = 5; k >= 0; --k) {
      x[k] = A[k][6];
      for (int b = k + 1; b < 6; ++b) x[k] -= A[k][b] * x[b];
      x[k] /= A[k][k];
    }
    out_.chain[0].joint.X_PJ.p = {x[0], x[1], x[2]};
    out_.X_LM.p = out_.X_LM.R * Vec3{x[3], x[4], x[5]};
  }

  void measure() {
    for (int i = 0; i < 6; ++i)
      for (const int c : body_.motion[at(i)].coordinates) {
        if (model_.coordinates[at(c)].locked) continue;
        for (int s = 0; s < samples; ++s) {
          const std::vector<double> q = sample(c, s);
          const Pose a = chain_pose(q), b = model_.joint_pose(body_, q);
          out_.deviation = std::max(out_.deviation, norm(a.p - b.p));
          out_.turn = std::max(out_.turn, norm(log_map(to_quat(a.R.transposed() * b.R))));
        }
      }
  }

  using Step = OsimJointFit::Step;
  const OsimModel& model_;
  const OsimBody& body_;
  std::vector<double> rest_;  // [coordinates] defaults
  std::array<bool, 6> taken_{};
  std::array<int, 6> driver_{};
  OsimJointFit out_;
};

}  // namespace

void osim_joint_coordinates(const OsimBody& body, const OsimJointFit::Step& step, std::span<const double> q, std::span<double> out) {
  double values[6] = {};
  std::vector<double> x;
  for (const int i : step.axes) {
    const OsimAxis& a = body.motion[at(i)];
    x.clear();
    for (const int c : a.coordinates) x.push_back(q[at(c)]);
    values[i] = a.function(x);
  }
  const auto turned = [&] {
    Mat3 R = Mat3::identity();
    for (std::size_t i = 0; i < 3; ++i) R = R * rotation_about(body.motion[i].axis, values[i]);
    return to_quat(R);
  };
  switch (step.joint.type) {
    case JointType::spherical: {
      const Quat r = turned();
      out[0] = r.w, out[1] = r.x, out[2] = r.y, out[3] = r.z;
      break;
    }
    case JointType::floating: {
      const Quat r = turned();
      Vec3 p;
      for (std::size_t i = 3; i < 6; ++i) p += body.motion[i].axis * values[i];
      out[0] = p.x, out[1] = p.y, out[2] = p.z, out[3] = r.w, out[4] = r.x, out[5] = r.y, out[6] = r.z;
      break;
    }
    default:
      for (std::size_t i = 0; i < step.axes.size(); ++i) out[i] = values[step.axes[i]];
  }
}

OsimJointFit fit_joint(const OsimModel& model, const OsimBody& body) { return Fit(model, body).make(); }

}  // namespace ugoki::robot_formats
