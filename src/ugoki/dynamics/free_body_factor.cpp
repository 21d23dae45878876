#include "ugoki/dynamics/free_body_factor.h"

#include <cmath>
#include <cstring>

#include "ugoki/base/check.h"

namespace ugoki::dynamics {
namespace {

/// Three constraint rows in SIMD lanes, as in articulated_factor.cpp.
typedef double Four __attribute__((vector_size(32)));

struct FourVec {
  Four x, y, z;
};

FourVec lanes_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  return {Four{a.x, b.x, c.x, 0}, Four{a.y, b.y, c.y, 0}, Four{a.z, b.z, c.z, 0}};
}

/// R^T a.
FourVec transpose_times(const Mat3& R, const FourVec& a) {
  const Vec3 x = R.column(0), y = R.column(1), z = R.column(2);
  return {x.x * a.x + x.y * a.y + x.z * a.z, y.x * a.x + y.y * a.y + y.z * a.z, z.x * a.x + z.y * a.y + z.z * a.z};
}

void store(const Four& value, double* to) { std::memcpy(to, &value, sizeof value); }

}  // namespace

bool FreeBodyFactor::applies_to(const Mechanism& m) {
  if (m.link_count() != 1 || m.link(0).joint.type != JointType::floating || !(m.link(0).inertia.mass > 0)) return false;
  for (const Dof& f : m.link(0).joint.dofs)
    if (f.armature != 0) return false;
  return true;
}

FreeBodyFactor::FreeBodyFactor(const Mechanism& m) {
  const Inertia& body = m.link(0).inertia;
  const Sym3 I = body.about_centre();
  c_B_ = body.centre();
  centred_ = c_B_ == Vec3{};
  T_ = m.link(0).joint.X_PJ.R;
  turned_ = !(T_ == Mat3::identity());
  D_[2] = I.zz;
  l20_ = I.xz / D_[2];
  l21_ = I.yz / D_[2];
  const double xy = I.xy - I.yz * l20_;
  D_[1] = I.yy - I.yz * l21_;
  l10_ = xy / D_[1];
  D_[0] = I.xx - I.xz * l20_ - xy * l10_;
  for (int k = 3; k < 6; ++k) D_[static_cast<std::size_t>(k)] = body.mass;
  for (std::size_t k = 6; k-- > 0;) {
    if (singular_ < 0 && !(D_[k] > 0 && std::isfinite(D_[k]))) singular_ = static_cast<int>(k);
    D_inverse_[k] = 1 / D_[k];
    root_[k] = std::sqrt(D_inverse_[k]);
  }
}

int FreeBodyFactor::factor(const Workspace& ws) {
  R_ = ws.X_WB[0].R;
  if (!centred_) c_W_ = R_ * c_B_;
  return singular_;
}

Vec3 FreeBodyFactor::centre_velocity(const Vec3& w) const {
  if (centred_) return {};
  const Vec3 turning = R_ * cross(w, c_B_);
  return turned_ ? transpose_times(T_, turning) : turning;
}

Vec3 FreeBodyFactor::centre_moment(const Vec3& moment, const Vec3& force) const {
  return centred_ ? moment : moment - cross(c_B_, transpose_times(R_, turned_ ? T_ * force : force));
}

void FreeBodyFactor::solve(std::span<double> x) const {
  UGOKI_CHECK(x.size() == 6);
  const Vec3 force{x[3], x[4], x[5]}, moment = centre_moment({x[0], x[1], x[2]}, force);
  const double y = moment.y - l21_ * moment.z, t = moment.x - l20_ * moment.z - l10_ * y;
  Vec3 w;
  w.x = t * D_inverse_[0];
  w.y = y * D_inverse_[1] - l10_ * w.x;
  w.z = moment.z * D_inverse_[2] - l21_ * w.y - l20_ * w.x;
  const Vec3 v = force * D_inverse_[3] - centre_velocity(w);
  for (int k = 0; k < 3; ++k) {
    x[static_cast<std::size_t>(k)] = w[k];
    x[static_cast<std::size_t>(k) + 3] = v[k];
  }
}

void FreeBodyFactor::whiten_wrenches(int last, const Vec6* f, double* y) const {
  UGOKI_CHECK(last == 5 || last == 2);
  FourVec moment = lanes_of(f[0].w, f[1].w, f[2].w);
  if (last == 5) {
    FourVec force = lanes_of(f[0].v, f[1].v, f[2].v);
    if (!centred_) {
      moment.x -= c_W_.y * force.z - c_W_.z * force.y;
      moment.y -= c_W_.z * force.x - c_W_.x * force.z;
      moment.z -= c_W_.x * force.y - c_W_.y * force.x;
    }
    if (turned_) force = transpose_times(T_, force);
    store(force.x * root_[3], y + 12);
    store(force.y * root_[3], y + 16);
    store(force.z * root_[3], y + 20);
  }
  const FourVec a = transpose_times(R_, moment);
  const Four second = a.y - l21_ * a.z;
  store((a.x - l20_ * a.z - l10_ * second) * root_[0], y);
  store(second * root_[1], y + 4);
  store(a.z * root_[2], y + 8);
}

void FreeBodyFactor::whiten_row(int last, std::span<const double> tail, double* y) const {
  UGOKI_CHECK(last == 5 && tail.size() <= 6);
  double J[6] = {};
  std::memcpy(J + (6 - tail.size()), tail.data(), tail.size() * sizeof(double));
  const Vec3 force{J[3], J[4], J[5]}, moment = centre_moment({J[0], J[1], J[2]}, force);
  const double second = moment.y - l21_ * moment.z;
  const double out[6] = {moment.x - l20_ * moment.z - l10_ * second, second, moment.z, force.x, force.y, force.z};
  for (std::size_t k = 0; k < 6; ++k) store(Four{out[k] * root_[k], 0, 0, 0}, y + 4 * k);
}

void FreeBodyFactor::add_whitened(std::span<const double> w, std::span<double> v) const {
  UGOKI_CHECK(w.size() == 6 && v.size() == 6);
  Vec3 spin;
  spin.x = w[0] * root_[0];
  spin.y = w[1] * root_[1] - l10_ * spin.x;
  spin.z = w[2] * root_[2] - l21_ * spin.y - l20_ * spin.x;
  const Vec3 origin = Vec3{w[3], w[4], w[5]} * root_[3] - centre_velocity(spin);
  for (int k = 0; k < 3; ++k) {
    v[static_cast<std::size_t>(k)] += spin[k];
    v[static_cast<std::size_t>(k) + 3] += origin[k];
  }
}

void FreeBodyFactor::whiten_velocity(std::span<const double> v, std::span<double> w) const {
  UGOKI_CHECK(w.size() == 6 && v.size() == 6);
  const Vec3 spin{v[0], v[1], v[2]}, centre = Vec3{v[3], v[4], v[5]} + centre_velocity(spin);
  w[0] = spin.x * D_[0] * root_[0];
  w[1] = (spin.y + l10_ * spin.x) * D_[1] * root_[1];
  w[2] = (spin.z + l21_ * spin.y + l20_ * spin.x) * D_[2] * root_[2];
  for (int k = 0; k < 3; ++k) w[static_cast<std::size_t>(k) + 3] = centre[k] * D_[3] * root_[3];
}

}  // namespace ugoki::dynamics
