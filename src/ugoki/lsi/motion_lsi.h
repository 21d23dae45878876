#pragma once
// What the LSIs of motion operations share. Internal to lsi.

#include <vector>

#include "ugoki/lsi/declare.h"
#include "ugoki/lsi/track_sampler.h"
#include "ugoki/motion/smooth_motion.h"

namespace ugoki::lsi {

/// The motion of clip `parameter` (an integer) of the character's track, or null with a problem.
[[nodiscard]] const Motion* clip_motion(Setup& setup, const Character& character, const char* parameter);

/// Reports an operation's problems as those of this LSI.
void report(Setup& setup, const Error& error);

/// Numbers of a text: "0 0, 1 0.5" -> 0 0 1 0.5; anything between numbers but a point, a sign or a letter parts them. False: something else
/// is in it.
[[nodiscard]] bool parse_numbers(const std::string& text, std::vector<double>& out);

[[nodiscard]] circuit::Parameter text_parameter(std::string name, std::string doc);
[[nodiscard]] circuit::Parameter clip_parameter(std::string name, double initial, std::string doc);

/// A motion that plays as a reference: q, v, a, stance.
class PlayedMotion {
 public:
  PlayedMotion(const Character& character, const Motion& motion);
  /// @param reference [layout.size(), out]. A cyclic motion goes on for ever, others hold their ends. Allocates nothing.
  void sample(double t, std::span<double> reference) const;

 private:
  const Character* character_;
  ReferenceLayout layout_;
  SmoothMotion smooth_;
  Clip clip_;
  int frames_;
  std::vector<std::uint8_t> stance_;  // [frames][feet]
};

/// An LSI whose object is a PlayedMotion: its pins and how it plays; parameters, configure and make are its own.
[[nodiscard]] circuit::LsiClass played_motion_class(std::string name, std::string doc);

void add_motion_operations(circuit::Library& library);
void add_intermediate_motion(circuit::Library& library);
void add_motion_retarget(circuit::Library& library);

}  // namespace ugoki::lsi
