#pragma once
// Small scenes with a known answer for balance control and the steps of the dynamics.

#include <cstdint>
#include <string>
#include <vector>

namespace ugoki::bench {

/// Result of a scene.
struct SceneRow {
  std::string name, unit;
  double value = 0;
  std::string expected;  ///< bound or closed form, for display
  bool good = false;
  bool same_bits = false;  ///< a second run has the same bits
};

/// Runs the scenes. @param wind_seconds duration of the scene with wind, s
[[nodiscard]] std::vector<SceneRow> run_scenes(double wind_seconds);

}  // namespace ugoki::bench
