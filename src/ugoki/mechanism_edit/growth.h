#pragma once
// Scales the body of a person to another age, height and mass.

#include "ugoki/mechanism_edit/edited.h"

namespace ugoki {

enum class GrowthSex { boy, girl };

/// Median stature [m] and mass [kg] at an age of 2 to 20 years. Source: Kuczmarski et al., 2000 CDC growth charts for the
/// United States (Vital and Health Statistics 11/246, 2002), 50th percentile, linear between yearly values.
struct Growth {
  double height = 0, mass = 0;
};
/// @param age years; clamped to 2 to 20
[[nodiscard]] Growth median_growth(double age, GrowthSex sex);

/// Mass of body parts as fractions of the body mass; arm and leg parts: one side only. Source: R. K. Jensen, "Changes in segment inertia
/// proportions between 4 and 20 years", J. Biomechanics 22 (1989) 529-536, boys. The head follows the regression given there. The other
/// parts follow the parabola through the values at 6, 12 and 18 years. All shares are then divided by their sum.
struct MassShares {
  double head, trunk, upper_arm, forearm, hand, thigh, shank, foot;
};
/// @param age years; clamped to 4 to 20
[[nodiscard]] MassShares mass_shares(double age);

struct GrowOptions {
  double age = 0;          ///< years, at least 2 (from 20 on: adult); 0: not specified
  double height = 0;       ///< m; 0: the median of the age; if no age is given either: unchanged
  double mass = 0;         ///< kg; 0: the median of the age; if no age is given, scaled with the cube of the height
  double from_age = 20;    ///< years, age of the given body
  double from_height = 0;  ///< m, height of the given body; 0: standing_height()
  GrowthSex sex = GrowthSex::boy;
};

/// Scales the body to another age, height and mass. If an age is given and most links are labelled as parts of a human (body/body.h):
///   - the mass of each link follows the mass shares of the two ages;
///   - the length of each link along the bone is proportional to the cube root of its mass, times a common factor that gives the height;
///     head and neck are scaled evenly instead;
///   - the thickness of each link is such that its density is kept.
/// Otherwise all links are scaled by the same factors; if an age is given, the report states this.
/// Errors: no age, height or mass; values out of range; a body without height or mass.
[[nodiscard]] Result<Edited> grow(const Mechanism& mechanism, const GrowOptions& options);

/// Height [m] from the lowest to the highest point of all shapes and joints in the neutral position.
[[nodiscard]] double standing_height(const Mechanism& mechanism);

}  // namespace ugoki
