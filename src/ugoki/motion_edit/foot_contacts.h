#pragma once
// When each foot of a motion stands, and with which part of the sole.

#include <cstdint>
#include <vector>

#include "ugoki/motion_edit/feet.h"

namespace ugoki::motion_edit {

/// Heights and speeds are those of a leg of 0.9 m; heights scale with the leg's length, speeds with its square root (Froude's law).
struct FootContactOptions {
  bool find_ground = false;     ///< the ground is where the feet stand in this motion (find_ground)
  double ground = 0;            ///< m, otherwise
  double height_on = 0.03;      ///< m: a place lower than this ...
  double speed_on = 0.35;       ///< m/s: ... and slower than this starts a contact,
  double height_off = 0.045;    ///< which lasts while a place is below this ...
  double speed_off = 0.8;       ///< ... and slower than this
  double span = 0.02;           ///< s on both sides over which speed is measured, whatever the frame rate; at least one frame
  double least_contact = 0.05;  ///< s: shorter contacts are none
  double least_gap = 0.04;      ///< s: shorter gaps are none
};

/// One unbroken contact of a foot: frames [first, last].
struct Stance {
  int first = 0, last = 0;
};

struct FootContacts {
  std::vector<FootLimb> feet;
  double ground = 0;                                 ///< m
  std::vector<std::vector<std::uint8_t>> bears;      ///< [feet][frames] 1 while any place of the foot bears
  std::vector<std::vector<std::uint8_t>> heel, toe;  ///< [feet][frames] the same for its back and its front

  [[nodiscard]] std::vector<Stance> stances(std::size_t foot) const;
};

/// Contacts of the motion's feet. A foot bears while one of its places is low and slow, with hysteresis. In a cyclic motion contacts run on
/// over the seam. O(frames * points).
[[nodiscard]] FootContacts find_contacts(const Mechanism& mechanism, const Motion& motion, std::vector<FootLimb> feet,
                                         const FootContactOptions& options = {});
[[nodiscard]] FootContacts find_contacts(const Mechanism& mechanism, const Motion& motion, const FootContactOptions& options = {});

/// Contacts as the motion's own labels have them (Motion::contacts, links of each foot united); detected where it has none for a foot.
[[nodiscard]] FootContacts labelled_contacts(const Mechanism& mechanism, const Motion& motion, std::vector<FootLimb> feet,
                                             const FootContactOptions& options = {});

/// Writes the contacts as labels: one track a foot, for its first link.
void set_labels(const Mechanism& mechanism, const FootContacts& contacts, Motion& motion);

/// Height [m] at which the feet stand: the median of the lowest places of the slow quarter of the frames. 0 without feet.
[[nodiscard]] double find_ground(const Mechanism& mechanism, const Motion& motion, std::span<const FootLimb> feet);

/// Sliding of standing feet, of each stance the horizontal path of whatever material point is lowest (as FootSkate, for feet with
/// toes). cm
struct SkateReport {
  double mean_cm = 0, worst_cm = 0;
  int stances = 0;
};
[[nodiscard]] SkateReport measure_skate(const Mechanism& mechanism, const Motion& motion, const FootContacts& contacts);

}  // namespace ugoki::motion_edit
