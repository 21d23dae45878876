#pragma once
// Detects in which animation frames each foot of a motion is in contact with the ground. "Frame" without an owner: animation frame.

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "ugoki/motion/motion.h"

namespace ugoki {

/// A point of a link that can touch the ground: the centre of a sphere of radius `radius`, or a corner (radius 0).
struct SupportPoint {
  Vec3 p;             ///< m, in the link's frame
  double radius = 0;  ///< m
};

/// Support points of all colliding shapes of the link. Box: its corners. Mesh: the corners of its bounding box. Sphere: its centre.
/// Capsule: the centres of both caps. Ellipsoid: the centres of two inscribed spheres, one at each end of the longest axis.
/// Cylinder: four points on each rim. Height field: none.
[[nodiscard]] std::vector<SupportPoint> support_points(const Link& link);

/// Indices of the feet: links whose label begins with "foot", "toes" or "paw" and that have a colliding shape; and a "carpus" or "hock"
/// with such a shape below which there is no paw.
[[nodiscard]] std::vector<int> find_feet(const Mechanism& mechanism);

struct ContactLabelOptions {
  double ground = 0;          ///< m, height of the ground
  double height_on = 0.03;    ///< m: a contact starts when a point is lower than this and slower than speed_on
  double speed_on = 0.35;     ///< m/s: see height_on
  double height_off = 0.045;  ///< m: a contact continues while a point is lower than this and slower than speed_off
  double speed_off = 0.6;     ///< m/s: see height_off
  double span = 0;            ///< s: the speed is averaged over this time before the frame and after it, at least one frame each
  double min_contact = 0.05;  ///< s: shorter contacts are removed
  double min_gap = 0.04;      ///< s: shorter gaps between contacts are closed
};

/// A support point of one of the mechanism's links.
struct LinkPoint {
  int link = 0;           ///< index of the link
  SupportPoint location;  ///< position and radius in the link's frame
};

/// Returns [frames]: 1 for each frame in which any of the points is in contact with the ground, else 0. A point is in contact while it is
/// low and slow, with hysteresis (ContactLabelOptions).
/// @param poses [frames][links] world poses of all links  @param rate frames per second
[[nodiscard]] std::vector<std::uint8_t> find_contact(std::span<const std::vector<Pose>> poses, double rate,
                                                     std::span<const LinkPoint> places, const ContactLabelOptions& options = {});

/// Finds the turns of a standing foot about a vertical axis, for example of a pirouette: frames in which it turns faster than 0.5 rad/s, by
/// more than 20 degrees in one direction. Feet in the stances of recorded walks turn by less.
/// @param stands [frames] 1: the foot stands @param yaw_rate [frames] rad/s @param rate frames per second
/// @return first frame of each turn and the frame behind its last one
[[nodiscard]] std::vector<std::pair<std::size_t, std::size_t>> find_turns(std::span<const std::uint8_t> stands,
                                                                          std::span<const double> yaw_rate, double rate);

/// Replaces motion.contacts by one track per given link, in this order. A link is in contact while any of its support points is low and
/// slow, so that heel strike, flat foot and toe-off belong to one contact. O(frames * links).
void label_contacts(const Mechanism& mechanism, Motion& motion, std::span<const int> links, const ContactLabelOptions& options = {});
/// Labels the contacts of the links returned by find_feet(mechanism).
void label_contacts(const Mechanism& mechanism, Motion& motion, const ContactLabelOptions& options = {});

}  // namespace ugoki
