#pragma once
// Poses of all links that one user of a scene has computed and another one needs at the same positions: the guard computes them at the end
// of a step, and the contact search at the beginning of the next one.

#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::contact {

/// Poses of the links of several systems, with the positions to which they belong. A pose depends on the positions alone: a user who has
/// other positions computes the poses itself and gets the same bits. The users of an object must not run at the same time.
class SharedPoses {
 public:
  struct Values {
    std::vector<std::vector<double>> q;   ///< [systems][nq]
    std::vector<std::vector<Pose>> X_WB;  ///< [systems][links] m, world: the poses at q

    explicit Values(std::span<const MechanismPtr> systems) {
      for (const MechanismPtr& m : systems) {
        q.emplace_back(static_cast<std::size_t>(m->nq()));
        X_WB.emplace_back(static_cast<std::size_t>(m->link_count()));
      }
    }
  };

  explicit SharedPoses(std::span<const MechanismPtr> systems) : values_(systems) {}

  /// Exchanges the values, which must be those of the same systems.
  void exchange(Values& values) {
    std::swap(values_, values);
    known_ = true;
  }
  /// Poses of one system at the positions q, valid until the next exchange(); empty if they are not known.
  [[nodiscard]] std::span<const Pose> find(std::size_t system, std::span<const double> q) const {
    const std::vector<double>& at = values_.q[system];
    if (!known_ || at.size() != q.size() || std::memcmp(at.data(), q.data(), q.size_bytes()) != 0) return {};
    return values_.X_WB[system];
  }

 private:
  bool known_ = false;
  Values values_;
};

}  // namespace ugoki::contact
