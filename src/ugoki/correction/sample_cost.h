#pragma once
// How far a simulated state is from the state that it shall reach. Internal to correction.

#include <span>
#include <vector>

#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::correction {

/// Cost of a state. With errors relative to the wanted state, d: error of the capture point c + c' 0.3 s relative to the ends of the limbs:
///   20 mean joint angle^2 + 10 root turn^2 + 60 mean link place^2 (from c; height from the floor: twice) + 90 height of c^2
///   + 4 horizontal place of c^2 + 1.8 velocity of c^2 + 6 (angular momentum / mass)^2 + 30 d^2            units: m, rad, s
/// The horizontal place has a small weight: a body that rolls less far than its reference is not wrong.
class SampleCost {
 public:
  explicit SampleCost(const Mechanism& m);
  /// Sets the wanted state. @param dofs velocity indices of the joints whose angles count
  void set_goal(std::span<const double> q, std::span<const double> v, std::span<const int> dofs);
  [[nodiscard]] double operator()(std::span<const double> q, std::span<const double> v);
  /// True if the state of the last call is too far away to go on: the root is turned by more than 1 rad or c is 0.25 m too high or low.
  [[nodiscard]] bool is_lost() const { return lost_; }

 private:
  struct Body {
    explicit Body(const Mechanism& m) : ws(m) {}
    dynamics::Workspace ws;
    dynamics::Centroidal c;
    Vec3 ends;  // m: mean place of the ends of the limbs
  };
  void observe(std::span<const double> q, std::span<const double> v, Body& body) const;

  const Mechanism& m_;
  std::vector<int> ends_;  // links without children
  Body goal_, now_;
  std::vector<double> q_goal_, error_;
  std::vector<int> dofs_;
  bool lost_ = false;
};

}  // namespace ugoki::correction
