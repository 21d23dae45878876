#include "ugoki/dynamics/known_kinematics.h"

#include <algorithm>
#include <cstring>

namespace ugoki::dynamics {
namespace {

bool equal(const std::vector<double>& a, std::span<const double> b) {
  return a.size() == b.size() && (b.empty() || std::memcmp(a.data(), b.data(), b.size_bytes()) == 0);
}

}  // namespace

KnownKinematics::KnownKinematics(const Mechanism& m)
    : q_(static_cast<std::size_t>(m.nq())), v_(static_cast<std::size_t>(m.nv())), kinematics_(m) {}

void KnownKinematics::update(const Mechanism& m, std::span<const double> q, std::span<const double> v) {
  update_kinematics(m, q, v, kinematics_);
  std::ranges::copy(q, q_.begin());
  std::ranges::copy(v, v_.begin());
  is_known_ = true;
}

const Kinematics* KnownKinematics::find(std::span<const double> q, std::span<const double> v) const {
  return is_known_ && equal(q_, q) && equal(v_, v) ? &kinematics_ : nullptr;
}

void update_kinematics(const Mechanism& m, std::span<const double> q, std::span<const double> v, const KnownKinematics* known,
                       Kinematics& k) {
  const Kinematics* const found = known == nullptr ? nullptr : known->find(q, v);
  if (found == nullptr) return update_kinematics(m, q, v, k);
  k = *found;  // vectors of equal sizes: copies without allocation
}

}  // namespace ugoki::dynamics
