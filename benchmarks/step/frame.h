#pragma once
// Rigid transformations as plain numbers, for translation units that are compiled with the flags of a peer.

#include <cmath>

namespace ugoki::benchmarks {

/// Pose of frame B in frame A: p_A = R p_B + p.
struct Frame {
  double R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row by row
  double p[3] = {0, 0, 0};                    ///< m
};

/// out = R v
inline void rotate(const double* R, const double* v, double* out) {
  for (int i = 0; i < 3; ++i) out[i] = R[3 * i] * v[0] + R[3 * i + 1] * v[1] + R[3 * i + 2] * v[2];
}
/// out = R^T v
inline void rotate_back(const double* R, const double* v, double* out) {
  for (int i = 0; i < 3; ++i) out[i] = R[i] * v[0] + R[3 + i] * v[1] + R[6 + i] * v[2];
}
inline Frame operator*(const Frame& a, const Frame& b) {
  Frame out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += a.R[3 * i + k] * b.R[3 * k + j];
      out.R[3 * i + j] = sum;
    }
  rotate(a.R, b.p, out.p);
  for (int i = 0; i < 3; ++i) out.p[i] += a.p[i];
  return out;
}
inline Frame inverse(const Frame& a) {
  Frame out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out.R[3 * i + j] = a.R[3 * j + i];
  rotate_back(a.R, a.p, out.p);
  for (double& x : out.p) x = -x;
  return out;
}

/// Unit quaternion w x y z of a rotation matrix (Shepperd's method).
inline void quaternion_of(const double* R, double* q) {
  const double t[4] = {R[0] + R[4] + R[8], R[0] - R[4] - R[8], -R[0] + R[4] - R[8], -R[0] - R[4] + R[8]};
  int k = 0;
  for (int i = 1; i < 4; ++i)
    if (t[i] > t[k]) k = i;
  const double s = 0.5 * std::sqrt(1 + t[k]), f = 0.25 / s;
  const double x = R[7] - R[5], y = R[2] - R[6], z = R[3] - R[1];
  const double xy = R[1] + R[3], xz = R[2] + R[6], yz = R[5] + R[7];
  const double all[4][4] = {{s, x * f, y * f, z * f}, {x * f, s, xy * f, xz * f}, {y * f, xy * f, s, yz * f}, {z * f, xz * f, yz * f, s}};
  for (int i = 0; i < 4; ++i) q[i] = all[k][i];
}

}  // namespace ugoki::benchmarks
