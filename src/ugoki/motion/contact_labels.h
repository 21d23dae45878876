#pragma once
// When each foot of a motion bears on the ground.

#include <span>
#include <vector>

#include "ugoki/motion/motion.h"

namespace ugoki {

/// A place on a link that can bear on the ground: the surface lies `radius` around it.
struct SupportPoint {
  Vec3 p;             ///< m, in the link's frame
  double radius = 0;  ///< m
};

/// Corners of boxes, centres of spheres and of capsules' caps, of all shapes of the link that collide.
[[nodiscard]] std::vector<SupportPoint> support_points(const Link& link);

/// Links that stand on the ground: those whose label begins with "foot", "toes" or "paw" and that have colliding shapes.
[[nodiscard]] std::vector<int> find_feet(const Mechanism& mechanism);

struct ContactLabelOptions {
  double ground = 0;            ///< m, height of the ground
  double height_on = 0.03;      ///< m: a point lower than this ...
  double speed_on = 0.35;       ///< m/s: ... and slower than this starts a contact,
  double height_off = 0.045;    ///< which lasts while a point is below this ...
  double speed_off = 0.6;       ///< ... and slower than this
  double span = 0;              ///< s on both sides over which speed is measured; at least one frame
  double least_contact = 0.05;  ///< s: shorter contacts are none
  double least_gap = 0.04;      ///< s: shorter gaps are none
};

/// A place on one of the mechanism's links.
struct LinkPoint {
  int link = 0;
  SupportPoint place;  ///< in the link's frame
};

/// Frames in which any of the places bears on the ground: one that is low and slow, with hysteresis. [frames]
/// @param poses [frames][links] of all links
[[nodiscard]] std::vector<std::uint8_t> find_contact(std::span<const std::vector<Pose>> poses, double rate,
                                                     std::span<const LinkPoint> places, const ContactLabelOptions& options = {});

/// Labels the contacts of the given links in motion.contacts, one track a link, in this order. A link bears on the ground
/// while one of its support points is low and slow (with hysteresis), so heel strike, flat foot, and roll over the toes
/// are one contact. O(frames * links).
void label_contacts(const Mechanism& mechanism, Motion& motion, std::span<const int> links, const ContactLabelOptions& options = {});
/// The same for find_feet(mechanism).
void label_contacts(const Mechanism& mechanism, Motion& motion, const ContactLabelOptions& options = {});

}  // namespace ugoki
