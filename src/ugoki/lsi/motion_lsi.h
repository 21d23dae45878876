#pragma once
// Common functions of the LSIs for motion operations. Internal to this module.

#include <vector>

#include "ugoki/lsi/declare.h"
#include "ugoki/lsi/track_sampler.h"
#include "ugoki/motion/smooth_motion.h"

namespace ugoki::lsi {

/// Returns the motion of a clip of the character's track. The LSI's parameter named `parameter` is the clip's index. If there is no such
/// clip: reports a problem and returns null.
[[nodiscard]] const Motion* clip_motion(Setup& setup, const Character& character, const char* parameter);

/// Reports the problems of a motion operation as problems of the LSI that is being built.
void report(Setup& setup, const Error& error);

/// Appends the numbers of a text: "0 0, 1 0.5" gives 0 0 1 0.5. Separators are space, tab, newline, ',' and ';'.
/// @return false if a word between separators is not a number
[[nodiscard]] bool parse_numbers(const std::string& text, std::vector<double>& out);

[[nodiscard]] circuit::Parameter text_parameter(std::string name, std::string doc);
[[nodiscard]] circuit::Parameter clip_parameter(std::string name, double initial, std::string doc);

/// A motion that is played as a reference (its layout: ReferenceLayout).
class PlayedMotion {
 public:
  PlayedMotion(const Character& character, const Motion& motion);
  /// Writes the reference at time t [s]. A cyclic motion repeats without end. Any other motion holds its first frame before its begin and
  /// its last frame after its end. Allocates nothing.
  /// @param reference [layout.size(), out]
  void sample(double t, std::span<double> reference) const;

 private:
  const Character* character_;
  ReferenceLayout layout_;
  SmoothMotion smooth_;
  Clip clip_;
  int frames_;
  std::vector<std::uint8_t> stance_;  // [frames][feet]
};

/// Makes an LSI class with pins and step function, whose object is a PlayedMotion. The caller adds parameters, `configure` and `make`.
[[nodiscard]] circuit::LsiClass played_motion_class(std::string name, std::string doc);

void add_motion_operations(circuit::Library& library);
void add_intermediate_motion(circuit::Library& library);
void add_motion_retarget(circuit::Library& library);

}  // namespace ugoki::lsi
