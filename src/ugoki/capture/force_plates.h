#pragma once
// Contact forces from the analog channels of force plates.
// Sources: C3D file format manual, FORCE_PLATFORM group (platform types 1-4); Kistler's formulae for four three-component sensors.

#include <span>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/motion/markers.h"

namespace ugoki::capture {

/// Measurement of one plate in one animation frame: the force of the plate on the body above it.
struct PlateForce {
  Vec3 force;              ///< N, world; z is positive while the plate is loaded
  Vec3 centre;             ///< m, world: centre of pressure on the plate's surface; the plate's centre if unloaded
  double free_moment = 0;  ///< N m about the plate's normal through the centre of pressure
  bool loaded = false;     ///< the force is above the threshold, so `centre` is valid
};

/// Options of calc_contact_forces.
struct ForcePlateOptions {
  double threshold = 15;      ///< N, smaller vertical forces count as unloaded
  double cutoff = 20;         ///< Hz, zero-lag Butterworth low-pass filter; 0: none
  bool remove_offset = true;  ///< subtract the channels' offset, if the plate is unloaded in at least a tenth of the recording's samples
};

/// Result of calc_contact_forces.
struct ForceRecording {
  std::vector<std::vector<PlateForce>> plates;  ///< [plates][frames], mean of each frame's samples
  std::vector<std::string> report;              ///< sentences for display: offsets removed, signs inverted
};

/// Computes the contact forces of all plates for each frame of the markers. Plate types: 1 force and centre of pressure, 2 force and
/// moment, 3 eight channels of four sensors, 4 like 2 with a calibration matrix. Signs are chosen so that the mean vertical force points up
/// and the sensor is below the surface. The channels' units are used (N, kN, lbf; Nm, Nmm, lbf in; m, cm, mm). Moments and positions
/// without a unit use the file's length unit. Errors: no plates; unknown type; missing channels; analog rate below the frame rate; samples
/// that are not finite; corners that enclose no area; a type 4 plate without matrix.
[[nodiscard]] Result<ForceRecording> calc_contact_forces(const MarkerMotion& motion, const ForcePlateOptions& options = {});

/// Trajectory of one foot: any points of its sole, for example the markers of heel and toe.
struct SolePoints {
  std::vector<Vec3> points;  ///< [frames][count] m
  int count = 0;             ///< number of points in each frame
};

/// A range of frames in which a plate is loaded, and the foot on it.
struct PlateStep {
  int plate = 0, first = 0, last = 0;  ///< index of the plate; first and last frame, both included
  int foot = -1;                       ///< index of the foot closest (mean distance) to the centre of pressure; -1: none within `near`
  double distance = 0;                 ///< m, load-weighted mean horizontal distance of the centre of pressure from the foot
  bool shared = false;                 ///< true: another foot carried over 20 % of the summed load on this plate; both feet share the force
};

/// Finds the steps on the plates and assigns them to feet.
/// @param near m, maximum of the mean distance between centre of pressure and foot
[[nodiscard]] std::vector<PlateStep> find_plate_steps(const MarkerMotion& motion, const ForceRecording& forces,
                                                      std::span<const SolePoints> feet, double near = 0.15);

}  // namespace ugoki::capture
