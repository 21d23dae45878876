#pragma once
// Contact forces from the analog channels of force plates.
// Sources: the C3D format's manual, FORCE_PLATFORM group (platform types 1-4); Kistler's formulae for four three-component sensors.

#include <span>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/motion/markers.h"

namespace ugoki::capture {

/// What a plate measures in one frame: the force of the ground on what stands on it.
struct PlateForce {
  Vec3 force;              ///< N, world; z is positive when something stands on the plate
  Vec3 centre;             ///< m, world: centre of pressure on the plate's surface; the plate's middle where nothing stands
  double free_moment = 0;  ///< N m about the plate's normal through the centre of pressure
  bool loaded = false;     ///< the force is above the threshold: the centre means something
};

struct ForcePlateOptions {
  double threshold = 15;      ///< N: less is nothing
  double cutoff = 20;         ///< Hz, zero-lag Butterworth; 0: none
  bool remove_offset = true;  ///< channels are zero where the plate carries nothing for long enough (a tenth of the recording)
};

struct ForceRecording {
  std::vector<std::vector<PlateForce>> plates;  ///< [plates][frames]: means of each frame's samples
  std::vector<std::string> report;              ///< sentences for people: offsets taken away, signs turned
};

/// Contact forces of all plates, one row a frame of the markers. Types: 1 force and centre of pressure, 2 force and moment, 3 eight
/// channels of four sensors, 4 as 2 with a calibration matrix. The sign of a plate is the one with which it carries what stands on it; its
/// sensor lies below its surface. Units are those of the channels' labels (N, kN, lbf; Nm, Nmm, lbf in; m, cm, mm); moments and places
/// without one are in the file's length unit. Errors: no plates; another type; channels missing or of a length that does not fit; corners
/// without area; a type 4 plate without matrix.
[[nodiscard]] Result<ForceRecording> calc_contact_forces(const MarkerMotion& motion, const ForcePlateOptions& options = {});

/// A foot on the ground: any points of its sole, for example markers of heel and toe.
struct SolePlaces {
  std::vector<Vec3> places;  ///< [frames][count] m
  int count = 0;             ///< points of one frame
};

/// A stretch of frames in which a plate carries something, and whose foot it is.
struct PlateStep {
  int plate = 0, first = 0, last = 0;
  int foot = -1;        ///< nearest to the centre of pressure while the load is greatest; -1: none is near
  double distance = 0;  ///< m, mean horizontal distance of the centre of pressure from the foot's line
  bool shared = false;  ///< another foot stood on the plate too, so the force belongs to both
};

/// Steps on the plates. @param feet any number  @param near m: a foot farther from the centre of pressure does not stand there
[[nodiscard]] std::vector<PlateStep> find_plate_steps(const MarkerMotion& motion, const ForceRecording& forces,
                                                      std::span<const SolePlaces> feet, double near = 0.15);

}  // namespace ugoki::capture
