#pragma once
// Detects when each foot of a motion is in contact with the ground, and with which part of the sole.

#include <cstdint>
#include <vector>

#include "ugoki/motion_edit/feet.h"

namespace ugoki::motion_edit {

/// Thresholds of contact detection for a leg length of 0.9 m. Heights scale with leg length, speeds with its root (Froude scaling).
struct FootContactOptions {
  bool find_ground = false;   ///< true: estimate the height of the ground from this motion (find_ground)
  double ground = 0;          ///< m, height of the ground; used if find_ground is false
  double height_on = 0.03;    ///< m: a contact starts when a point is lower than this and slower than speed_on
  double speed_on = 0.35;     ///< m/s: maximum speed of a point at which a contact starts
  double height_off = 0.045;  ///< m: a contact continues while a point is lower than this and slower than speed_off
  double speed_off = 0.8;     ///< s before and after a frame over which the speed of a point is averaged; at least one frame
  double span = 0.02;         ///< s before and after the frame over which the speed is averaged; at least one frame
  double min_contact = 0.05;  ///< s: shorter contacts are removed
  double min_gap = 0.04;      ///< s: shorter gaps between contacts are closed
};

/// One unbroken contact of a foot: frames [first, last].
struct Stance {
  int first = 0, last = 0;
};

struct FootContacts {
  std::vector<FootLimb> feet;
  double ground = 0;                                 ///< m, height of the ground
  std::vector<std::vector<std::uint8_t>> bears;      ///< [feet][frames] 1 while any point of the foot is in contact
  std::vector<std::vector<std::uint8_t>> heel, toe;  ///< [feet][frames] 1 while any point of the back (front) of the sole is in contact

  [[nodiscard]] std::vector<Stance> stances(std::size_t foot) const;
};

/// Detects the contacts of `feet`; the overload without `feet` uses the feet of find_foot_limbs. A foot is in contact while one of its
/// points is low and slow, with hysteresis. In a cyclic motion contacts continue across the seam. O(frames * points).
[[nodiscard]] FootContacts find_contacts(const Mechanism& mechanism, const Motion& motion, std::vector<FootLimb> feet,
                                         const FootContactOptions& options = {});
[[nodiscard]] FootContacts find_contacts(const Mechanism& mechanism, const Motion& motion, const FootContactOptions& options = {});

/// Contacts from the motion's labels (Motion::contacts); a foot is in contact if any of its links is labelled as in contact. The contacts
/// of feet without labels, and of all heels and toes, are detected as in find_contacts.
[[nodiscard]] FootContacts labelled_contacts(const Mechanism& mechanism, const Motion& motion, std::vector<FootLimb> feet,
                                             const FootContactOptions& options = {});

/// Replaces the motion's labels by the contacts: one track per foot, named after the foot's first link.
void set_labels(const Mechanism& mechanism, const FootContacts& contacts, Motion& motion);

/// Returns the estimated height [m] of the ground: the median height of the feet's lowest points in the slowest quarter of the frames. 0 if
/// `feet` is empty.
[[nodiscard]] double find_ground(const Mechanism& mechanism, const Motion& motion, std::span<const FootLimb> feet);

/// Sliding of standing feet [cm]: length of the horizontal path of the lowest material point in a stance, mean and maximum over the
/// stances. FootSkate measures the same sliding, but for feet of one link.
struct SkateReport {
  double mean_cm = 0, worst_cm = 0;
  int stances = 0;
};
[[nodiscard]] SkateReport measure_skate(const Mechanism& mechanism, const Motion& motion, const FootContacts& contacts);

}  // namespace ugoki::motion_edit
