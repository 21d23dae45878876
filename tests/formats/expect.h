#pragma once
// Checks shared by the tests of readers: complete error reports, and positions of joints.

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <string>

#include "ugoki/base/result.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki {

inline std::string text_of(const Error& e) { return e.text(); }

/// True if `location` ends with ":<line number>".
inline bool has_line(const std::string& location) {
  const std::size_t colon = location.rfind(':');
  if (colon == std::string::npos || colon + 1 == location.size()) return false;
  for (std::size_t i = colon + 1; i < location.size(); ++i)
    if (!std::isdigit(static_cast<unsigned char>(location[i]))) return false;
  return true;
}

/// Expects an error of one to twenty problems, each with the location file:line, a message and a remedy.
/// @param what description of the input, for failure messages
template <class T>
void expect_refused(const Result<T>& result, const std::string& what) {
  ASSERT_FALSE(result.has_value()) << what << " was accepted";
  ASSERT_FALSE(result.error().problems.empty()) << what;
  EXPECT_LE(result.error().problems.size(), 20U) << what;
  for (const Problem& p : result.error().problems) {
    EXPECT_TRUE(has_line(p.location)) << what << ": " << p.text();
    EXPECT_FALSE(p.message.empty()) << what;
    EXPECT_TRUE(p.message.ends_with('.')) << what << ": " << p.text();
    EXPECT_FALSE(p.remedy.empty()) << what << ": " << p.text();
  }
}

/// Expects an error whose first problem is in line `line`.
template <class T>
void expect_refused_at(const Result<T>& result, int line, const std::string& what) {
  expect_refused(result, what);
  if (result) return;
  const std::string& location = result.error().problems[0].location;
  EXPECT_EQ(location.substr(location.rfind(':') + 1), std::to_string(line)) << what << ": " << result.error().text();
}

inline void expect_near(const Vec3& a, const Vec3& b, double tolerance, const std::string& what) {
  EXPECT_LE(norm(a - b), tolerance) << what << ": (" << a.x << ", " << a.y << ", " << a.z << ") is not (" << b.x << ", " << b.y << ", "
                                    << b.z << ")";
}

/// Maximum distance [m] between the world positions of corresponding joints and end sites of two motions, over every `stride`-th frame.
/// Joints correspond by name. Infinity if the motions differ in joints, end sites or number of frames.
inline double max_distance(const MeasuredMotion& a, const MeasuredMotion& b, int stride) {
  constexpr double different = std::numeric_limits<double>::infinity();
  if (a.frames != b.frames || a.joint_count() != b.joint_count()) return different;
  std::vector<std::size_t> in_b;
  for (const SkeletonJoint& j : a.skeleton.joints) {
    std::size_t k = 0;
    while (k < b.skeleton.joints.size() && b.skeleton.joints[k].name != j.name) ++k;
    if (k == b.skeleton.joints.size() || b.skeleton.joints[k].end_sites.size() != j.end_sites.size()) return different;
    in_b.push_back(k);
  }
  double worst = 0;
  std::vector<Pose> X, Y;
  for (int f = 0; f < a.frames; f += stride) {
    a.calc_joint_poses(f, X);
    b.calc_joint_poses(f, Y);
    for (std::size_t i = 0; i < X.size(); ++i) {
      const std::size_t k = in_b[i];
      worst = std::max(worst, norm(X[i].p - Y[k].p));
      const auto& ends = a.skeleton.joints[i].end_sites;
      for (std::size_t e = 0; e < ends.size(); ++e)
        worst = std::max(worst, norm(X[i] * ends[e] - Y[k] * b.skeleton.joints[k].end_sites[e]));
    }
  }
  return worst;
}

}  // namespace ugoki
