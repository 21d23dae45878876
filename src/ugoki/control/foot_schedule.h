#pragma once
// The feet of a mechanism, and the times at which each foot stands in a reference motion.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/contact_labels.h"

namespace ugoki::control {

/// A motion over time that serves as the reference of a controller.
class ReferenceMotion {
 public:
  virtual ~ReferenceMotion() = default;
  /// Returns the reference at time t [s]. @param q [nq, out]  @param v, a [nv, out] rad/s | m/s, rad/s^2 | m/s^2
  virtual void sample(double t, std::span<double> q, std::span<double> v, std::span<double> a) const = 0;
  [[nodiscard]] virtual double end() const = 0;  ///< s: duration; the motion is sampled from 0 to end()
  /// Contacts with the ground at time t [s], if they are known, because the motion was computed for them. Contacts of measured motions are
  /// not known. @param on [links, out] 1: the link is in contact; valid if the result is true
  [[nodiscard]] virtual bool contacts(double /*t*/, std::span<std::uint8_t> /*on*/) const { return false; }
};

/// A foot: a link that can stand, with its descendants that can also touch the ground (toes).
struct Foot {
  int link = -1;
  std::vector<int> parts;         ///< links: `link` and its descendants that are feet
  std::vector<LinkPoint> points;  ///< support points of all parts
  std::vector<int> dofs;          ///< DOFs between the root and `link`, without the root's own DOFs
  /// True if the foot's joint and the joint before it turn the foot about axes that are not parallel (an ankle). Otherwise the place of the
  /// foot determines its orientation (a shank, a paw); a goal for the orientation would pull it from its place and turn the body.
  bool turns = false;
  int hip = -1;  ///< first link of the leg: the last ancestor of `link` that is not an ancestor of another foot
  Vec3 normal;   ///< unit, in the frame of `link`: upward normal of the sole, vertical in the neutral position
  Vec3 sole;     ///< m, in the frame of `link`: mean of the lowest support points of `link` in the neutral position
};
/// Returns the feet of a mechanism (find_feet). Toes are part of their foot.
[[nodiscard]] std::vector<Foot> feet_of(const Mechanism& mechanism);

/// A time interval [s] in which a foot stands.
struct Stance {
  double begin = 0, end = 0;
  Pose foot;  ///< m, world: pose of the foot's link at the begin
  Vec3 hip;   ///< m, world: origin of Foot::hip at the begin
};

/// State of a foot in the schedule at a given time.
struct ScheduledFoot {
  bool stands = false;
  double begin = 0;              ///< s: begin of the present stance or swing; -infinity if it began before the motion
  double end = 0;                ///< s: end of the present stance or swing; infinity if no stance or swing follows
  const Stance* next = nullptr;  ///< the stance that follows the present swing; null: none, or the foot stands
};

/// A time interval in which no foot stands.
struct Flight {
  double begin = 0, end = 0;  ///< s
  double landing = 0;         ///< m: height of the centre of mass above the floor at the end
};

/// Stances of all feet over a reference motion.
class FootSchedule {
 public:
  /// Samples the motion at `rate` [Hz]. Contacts that the motion does not know are labelled by height and speed of the feet. O(duration).
  FootSchedule(const Mechanism& mechanism, std::span<const Foot> feet, const ReferenceMotion& motion, double floor, double rate = 120);
  [[nodiscard]] ScheduledFoot at(std::size_t foot, double t) const;
  /// True if the foot turns about a vertical axis on the ground at time t [s], for example in a pirouette.
  [[nodiscard]] bool turns(std::size_t foot, double t) const;
  /// Intervals in which the foot stands and turns about a vertical axis by more than 20 degrees in one direction.
  [[nodiscard]] std::span<const Stance> turns(std::size_t foot) const { return turns_[foot]; }
  /// Flight at time t [s]; null: a foot stands.
  [[nodiscard]] const Flight* flight(double t) const;
  [[nodiscard]] std::span<const Flight> flights() const { return flights_; }
  /// m: maximum distance between the origin of the foot's hip and its sole.
  [[nodiscard]] double leg_length(std::size_t foot) const { return leg_length_[foot]; }
  [[nodiscard]] std::span<const Stance> stances(std::size_t foot) const { return stances_[foot]; }
  /// True if the motion knows its contacts at time t [s]: it was computed, and its standing soles have no error of measurement.
  [[nodiscard]] bool knows_contacts(double t) const;

 private:
  /// Replaces labels by the contacts that the motion knows. @param on [feet][frames, in, out]
  void use_known_contacts(const Mechanism& mechanism, std::span<const Foot> feet, const ReferenceMotion& motion,
                          std::span<std::vector<std::uint8_t>> on);

  void find_flights(std::span<const std::vector<std::uint8_t>> on, std::span<const double> height, double rate);

  std::vector<Flight> flights_;                       // sorted
  std::vector<double> leg_length_;                    // [feet]
  std::vector<std::vector<Stance>> stances_, turns_;  // [feet], sorted
  std::vector<std::uint8_t> known_;                   // [frames] 1: the motion knows its contacts
  double rate_ = 120;                                 // Hz, of the frames
};

}  // namespace ugoki::control
