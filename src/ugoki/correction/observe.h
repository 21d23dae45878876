#pragma once
// Momentum of a motion, loaded points of the soles, and the forces that are missing. Internal to correction.

#include <vector>

#include "ugoki/correction/correct.h"
#include "ugoki/motion_edit/foot_contacts.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::correction {

/// Frames [first, last] in which nothing is in contact.
struct Flight {
  int first = 0, last = 0;
  [[nodiscard]] int frames() const { return last - first + 1; }
};

struct Observation {
  double mass = 0;                 ///< kg
  double rate = 0;                 ///< frames per second
  std::vector<Vec3> centre;        ///< [frames] m: centre of mass
  std::vector<Vec3> acceleration;  ///< [frames] m/s^2, of the centre of mass
  std::vector<Vec3> spin, moment;  ///< [frames] N m s, N m: angular momentum about the centre of mass, and its rate
  std::vector<Sym3> inertia;       ///< [frames] kg m^2, about the centre of mass with all joints locked
  std::vector<std::vector<Vec3>>
      supports;                         ///< [frames] m: points that can carry load: of soles in contact, and of other links on the floor
  std::vector<double> clearance;        ///< [frames] m: height of the lowest point of all links
  std::vector<double> trunk_clearance;  ///< [frames] m: the same for the links that are not part of the limbs with contacts
  std::vector<std::uint8_t> on_feet;    ///< [frames] 1: only feet carry load
  std::vector<Flight> flights;          ///< of at least `min_flight`
  [[nodiscard]] int frames() const { return static_cast<int>(centre.size()); }
};

/// s: shorter times without contact are gaps in the detection of contacts rather than flights, which last 0.05 s in the slowest runs.
inline constexpr double min_flight = 0.05;

[[nodiscard]] Observation observe(const Mechanism& m, const Motion& motion, const motion_edit::FootContacts& contacts);

/// Measures of the motion for the report.
[[nodiscard]] CorrectionMeasures measure(const Mechanism& m, const Motion& motion, const motion_edit::FootContacts& contacts,
                                         const CorrectOptions& options);

/// rms rotation of the joints between the frames of two motions of equal length, degrees. @param root_cm [out] rms displacement of the root
[[nodiscard]] double rms_change(const Mechanism& m, const Motion& a, const Motion& b, double& root_cm);

/// Moves the whole character by the rigid displacement X (world). The root must be floating. @param q [nq, in and out]
void displace(const Mechanism& m, const Pose& X, double* q);

}  // namespace ugoki::correction
