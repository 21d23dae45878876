#include "ugoki/dynamics/shared_kinematics.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace ugoki::dynamics {
namespace {

/// Lets one user at a time use the kinematics. A user who comes second does not wait.
class Turn {
 public:
  explicit Turn(bool& busy) : busy_(busy), taken_(!__atomic_test_and_set(&busy, __ATOMIC_ACQUIRE)) {}
  ~Turn() {
    if (taken_) __atomic_clear(&busy_, __ATOMIC_RELEASE);
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  [[nodiscard]] bool taken() const { return taken_; }

 private:
  bool& busy_;
  bool taken_;
};

bool equal(const std::vector<double>& a, std::span<const double> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), b.size_bytes()) == 0;
}

}  // namespace

KinematicsAt::KinematicsAt(const Mechanism& m) : q(static_cast<std::size_t>(m.nq())), v(static_cast<std::size_t>(m.nv())), kinematics(m) {}

SharedKinematics::SharedKinematics(const Mechanism& m) : values_{KinematicsAt(m), KinematicsAt(m)} {}

const KinematicsAt* SharedKinematics::known_at(std::span<const double> q, std::span<const double> v) const {
  for (const std::size_t i : {newer_, 1 - newer_})
    if (known_[i] && equal(values_[i].q, q) && equal(values_[i].v, v)) return &values_[i];
  return nullptr;
}

bool SharedKinematics::find(std::span<const double> q, std::span<const double> v, Kinematics& to) {
  const Turn turn(busy_);
  const KinematicsAt* const known = turn.taken() ? known_at(q, v) : nullptr;
  if (known == nullptr) return false;
  to = known->kinematics;  // vectors of equal sizes: copies without allocation
  return true;
}

void SharedKinematics::update(const Mechanism& m, std::span<const double> q, std::span<const double> v, std::span<Pose> X_WB,
                              std::span<Vec6> V) {
  const Turn turn(busy_);
  if (!turn.taken()) {
    Kinematics own(m);
    update_kinematics(m, q, v, own);
    std::ranges::copy(own.X_WB, X_WB.begin());
    std::ranges::copy(own.V, V.begin());
    return;
  }
  const KinematicsAt* known = known_at(q, v);
  if (known == nullptr) {
    KinematicsAt& next = older();
    std::ranges::copy(q, next.q.begin());
    std::ranges::copy(v, next.v.begin());
    update_kinematics(m, q, v, next.kinematics);
    newer_ = 1 - newer_;
    known_[newer_] = true;
    known = &next;
  }
  std::ranges::copy(known->kinematics.X_WB, X_WB.begin());
  std::ranges::copy(known->kinematics.V, V.begin());
}

void SharedKinematics::exchange(KinematicsAt& next) {
  const Turn turn(busy_);
  if (!turn.taken()) return;
  std::swap(older(), next);
  newer_ = 1 - newer_;
  known_[newer_] = true;
}

SceneKinematics make_scene_kinematics(std::span<const MechanismPtr> systems) {
  SceneKinematics out;
  for (const MechanismPtr& m : systems) out.emplace_back(*m);
  return out;
}

void update_kinematics(const Mechanism& m, std::span<const double> q, std::span<const double> v, SharedKinematics* shared, Kinematics& k) {
  if (shared == nullptr || !shared->find(q, v, k)) update_kinematics(m, q, v, k);
}

}  // namespace ugoki::dynamics
