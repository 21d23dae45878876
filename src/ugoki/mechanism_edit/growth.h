#pragma once
// Bodies of people of other ages.

#include "ugoki/mechanism_edit/edited.h"

namespace ugoki {

enum class GrowthSex { boy, girl };

/// Median stature [m] and mass [kg] at an age of 2 to 20 years. Source: Kuczmarski et al., 2000 CDC growth charts for the
/// United States (Vital and Health Statistics 11/246, 2002), 50th percentile; between the rows straight lines.
struct Growth {
  double height = 0, mass = 0;
};
[[nodiscard]] Growth median_growth(double age, GrowthSex sex);

/// Shares of the body's mass, limbs for one side. Source: R. K. Jensen, "Changes in segment inertia proportions between 4 and 20 years",
/// J. Biomechanics 22 (1989) 529-536: the head by its regression, the other parts by its values at 6, 12 and 18 years and the parabola
/// through them; divided by their sum. Boys; ages below 4 and above 20 years take the shares of 4 and 20.
struct MassShares {
  double head, trunk, upper_arm, forearm, hand, thigh, shank, foot;
};
[[nodiscard]] MassShares mass_shares(double age);

struct GrowOptions {
  double age = 0;        ///< years, 2 ... 20 (above: adult); 0: not given
  double height = 0;     ///< m; 0: the median of the age, or as it is
  double mass = 0;       ///< kg; 0: the median of the age, or with the cube of the height
  double from_age = 20;  ///< years of the body as it is
  double from_height =
      0;  ///< m of the body as it is; 0: from the lowest to the highest point of its shapes, standing in the neutral position
  GrowthSex sex = GrowthSex::boy;
};

/// The body at another age, height and mass. With an age, on bodies whose links are labelled as parts of a human (body/body.h): each link's
/// mass follows the shares of the two ages, its length along the bone the cube root of its mass (density and build kept), all lengths
/// together such that the height is met, and its thickness such that density is kept. Without age, or where no links are labelled: evenly,
/// and this is told. Heads are rounder than long: they grow evenly. Errors: nothing to do, numbers out of range, a body without height or
/// mass.
[[nodiscard]] Result<Edited> grow(const Mechanism& mechanism, const GrowOptions& options);

/// m, from the lowest to the highest point of all shapes (and joints) in the neutral position.
[[nodiscard]] double standing_height(const Mechanism& mechanism);

}  // namespace ugoki
