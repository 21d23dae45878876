#pragma once
// Computes the measures of naturalness of one character from samples in the order of time. Simulations and recorded motions use the same
// Meter; they differ only in where forces and torques come from.

#include <array>
#include <span>
#include <vector>

#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/known_kinematics.h"
#include "ugoki/motion/foot_slip.h"
#include "ugoki/motion/measures.h"
#include "ugoki/naturalness/legs.h"
#include "ugoki/naturalness/measure_list.h"
#include "ugoki/naturalness/step_series.h"

namespace ugoki::naturalness {

/// State of a character at one instant. Empty spans: not known.
struct Sample {
  double dt = 0;                                     ///< s since the previous sample; not used in the first one
  std::span<const double> q, v;                      ///< [nq], [nv] position; velocity, of a recording filtered
  std::span<const Pose> X_WB;                        ///< [links] poses at q
  const dynamics::KnownKinematics* known = nullptr;  ///< may have the kinematics at q and v; null: the meter computes them
  std::span<const Pose> reference;                   ///< [links] poses that the character should have
  std::span<const std::uint8_t> stance;              ///< [feet of find_feet] nonzero: the foot is to stand without sliding
  std::span<const std::uint8_t> stands;              ///< [legs] nonzero: the foot is meant to bear load
  std::span<const std::uint8_t> touches;             ///< [legs] nonzero: the foot touches something
  std::span<const Vec3> forces;                      ///< [legs] N, world: force on the foot
  bool other_contact = false;                        ///< another link touches something, or something else holds the character
  std::span<const double> torque;                    ///< [nv] N m | N: forces of the joints
  bool has_missing = false;                          ///< the next two are known
  Vec3 missing_force, missing_moment;                ///< N, N m about the centre of mass, world: wrench that no contact supplies
};

struct MeterOptions {
  double gravity = 9.81;   ///< m/s^2
  double ground = 0;       ///< m: height of the ground
  bool simulated = false;  ///< jerk is compared with the reference instead of with bounds of recordings
};

class Meter {
 public:
  Meter(const Mechanism& mechanism, const MeterOptions& options);

  void reset();
  /// Adds a sample. Does not allocate. O(links).
  void add(const Sample& sample);
  /// Sets the present value of a measure that the host computes (tracking, assist, fall). @param weight 0: the value is not accumulated
  void set(MeasureId id, double value, double weight = 1);

  /// Value of the measure since the start; negative: it does not apply, value_of() the reason.
  [[nodiscard]] double total(MeasureId id) const;
  /// total() of all measures.
  [[nodiscard]] std::array<double, measure_count> totals() const;
  /// Value of the measure at the last sample; no_value: none. Values of stances, swings, steps and flights are kept until the next one.
  [[nodiscard]] double now(MeasureId id) const { return now_[index_of(id)]; }
  [[nodiscard]] std::span<const double> now() const { return now_; }

  [[nodiscard]] const BodyLegs& body() const { return body_; }
  [[nodiscard]] const FootSlip& slip() const { return slip_; }
  [[nodiscard]] const GroundPenetration& penetration() const { return penetration_; }
  /// Momentum and centre of mass at the last sample.
  [[nodiscard]] const dynamics::Centroidal& centroidal() const { return centroidal_; }

  /// Internal state as an array of doubles, for saving and restoring. @param out, in [memory_size()]
  [[nodiscard]] std::size_t memory_size() const;
  void save(std::span<double> out) const;
  void restore(std::span<const double> in);

 private:
  /// Sums of powers of the time for a fit of degree 2 to a trajectory. Plain data.
  struct Flight {
    double t = 0, n = 0, s[5] = {};
    Vec3 y[3];  ///< sums of c, c t, c t^2, relative to the first point
    Vec3 origin, pending[2];
    double held = 0, pending_t[2] = {};
  };
  struct Sums {
    double time = 0, samples = 0;
    double speed_x = 0, speed_y = 0;       ///< m/s: velocity of the centre of mass over the last 0.4 s
    double ground_time = 0, air_time = 0;  ///< s: since the last flight of 0.05 s; duration of the present flight
    double load = 0, peak = 0;             ///< N: vertical ground force, filtered; its maximum so far
    double work = 0, distance = 0;         ///< J, m
    double power = 0;                      ///< W, positive power of the joints, mean over the last 0.5 s
    double walked = 0, ran = 0;            ///< s
    double had_flight = 0, had_forces = 0, had_torque = 0;
    Vec3 centre;
    Flight flight;
  };
  struct LegState {
    double on = 0, since = 0;                                   ///< 1: the foot touches; s: duration of the present stance or swing
    double complete = 0;                                        ///< 1: the begin of the stance or swing was seen, in a gait
    double touched_at = -1;                                     ///< s: time of the last touch-down
    double torque_sum = 0, torque_time = 0;                     ///< since the last touch-down
    double height_sum = 0, height_count = 0, stand_height = 0;  ///< m: height of the standing foot
    double step_time = no_value, step_length = no_value, stance_time = no_value, torque = no_value;  ///< of the last step or stance
    double step_times = 0, step_lengths = 0, steps = 0, stance_times = 0, stances = 0, torques = 0, strides = 0;  ///< sums and counts
    double peak = 0, last_height = 0, rest = 0;  ///< rest, s: since when the foot stands still
    Vec3 place;
    StepSeries series;  ///< stance: N, vertical force; swing: m, height of the lowest point
  };
  /// Low-pass filter of order 4 that gives derivatives: four equal stages of order 1. Plain data.
  struct Stages {
    Vec3 input, y[4];
  };
  struct Smooth {
    Stages body, reference;
    double square = 0, reference_square = 0;                        ///< mean squared jerk of the last 0.15 s
    double sum = 0, bounded_sum = 0, reference_sum = 0, count = 0;  ///< since the start; bounded: in units of the bound
  };

  [[nodiscard]] double value(MeasureId id) const;   ///< total(), or no_value
  [[nodiscard]] Reason reason(MeasureId id) const;  ///< why value() is no_value
  [[nodiscard]] bool gait() const;
  [[nodiscard]] bool walks() const;
  static void filter(Stages& stages, const Vec3& input, double a, double b);
  void add_flight(const Sample& s);
  void end_flight();
  void add_forces(const Sample& s);
  void add_legs(const Sample& s);
  void touch_down(std::size_t leg, const Sample& s);
  void lift_off(std::size_t leg);
  void compare_sides(std::size_t leg);
  void add_hover(const Sample& s);
  void add_jerk(const Sample& s);
  void add_torque(const Sample& s);

  const Mechanism& m_;
  MeterOptions options_;
  BodyLegs body_;
  FootSlip slip_;
  GroundPenetration penetration_;
  dynamics::Workspace ws_;
  dynamics::Centroidal centroidal_;
  double weight_ = 0, unit_speed_ = 0, unit_jerk_ = 0;  ///< N; m/s: sqrt(g h); m/s^3: g sqrt(g / h)
  bool limited_torque_ = false;
  // Saved state
  Sums sums_;
  std::array<double, measure_count> now_{}, sum_{}, count_{};
  std::vector<LegState> leg_states_;
  std::vector<Smooth> smooth_;  ///< [links]
};

}  // namespace ugoki::naturalness
