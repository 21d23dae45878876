#pragma once
// Size of a four-legged animal: unit of length from the file, species, gravity and gait.

#include <optional>
#include <span>
#include <string>

#include "ugoki/body/body.h"
#include "ugoki/body/recognise.h"
#include "ugoki/intake/species.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Mass [kg] divided by the cube of the trunk's length [m] between hips and shoulders; see Bodies of animals in docs/design/anatomy.md.
constexpr double mass_of_trunk = 235;

/// Downward acceleration [m/s^2] of the trunk that is exceeded in 2 % of the frames; 0 if the motions are too short to measure it. The
/// ground does not pull, so this acceleration is at most g in a physical motion.
[[nodiscard]] double fall_of_trunk(const body::Character& character, std::span<const MeasuredMotion> motions);

/// Height [m] of the hips that the gait implies: animals that walk or run with equal Froude numbers v^2 / (g h) make strides of equal
/// length relative to the height h of their hips: stride / h = 2.4 Fr^0.34 below Fr = 2, 1.9 Fr^0.40 above. The stride of a motion relative
/// to h does not depend on its unit of length, so its period gives h = g T^2 Fr / (stride / h)^2. The period is that of the feet's motion
/// relative to the trunk, the speed that of the standing feet relative to the trunk: treadmills and animations in place count too. Source:
/// R. McN. Alexander and A. S. Jayes, J. Zoology 201 (1983), 135-152.
/// @return the median over the motions with at least two strides; nothing if there are none
[[nodiscard]] std::optional<double> hip_height_by_gait(const body::Character& character, std::span<const MeasuredMotion> motions);

/// Median height [m] of the hips above the lowest 5 % of the feet's heights.
[[nodiscard]] double hip_height(const body::Character& character, std::span<const MeasuredMotion> motions);

/// Unit of length of an animal, and why.
struct AnimalSize {
  double unit = 0;       ///< m per file unit
  bool changed = false;  ///< true: not the unit of the file
  std::string reason;    ///< sentence for the report
};
/// Chooses the unit of length of a four-legged animal. Candidates are the file's unit, the other usual units, and any scale; each has a
/// cost (a negative log-likelihood) for its unlikelihood, for a mass outside the species' range (without a species: 0.05 kg to 960 kg), for
/// a trunk that falls faster than with g, and, if the file states no unit, for hips at another height than its gait implies.
/// @param motions in m, with metres_per_unit  @param trusted the file states its unit
/// @return the unit with the minimum cost; nothing if the character is not a four-legged animal
[[nodiscard]] std::optional<AnimalSize> size_of_animal(const body::Character& character, std::span<const MeasuredMotion> motions,
                                                       double metres_per_unit, bool trusted, const std::optional<SpeciesMass>& species);

/// Gives an animal of unusual size the closest usual mass of its species.
/// @param body its mass and inertias change  @param motion of which the body was made  @param options with which it was made
/// @return a sentence about it; empty if its mass is usual
[[nodiscard]] std::string limit_mass(body::Body& body, const SpeciesMass& species, const MeasuredMotion& motion, body::BodyOptions options);

}  // namespace ugoki::intake
