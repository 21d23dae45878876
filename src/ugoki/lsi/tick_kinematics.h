#pragma once
// Kinematics of the characters at the beginning of a tick. The dynamics LSI leaves those at the end of its step for the next tick; all LSIs
// of the next tick read them. Writers and readers of one tick use different memory, so that they may run at the same time.

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "ugoki/dynamics/known_kinematics.h"

namespace ugoki::lsi {

class TickKinematics {
 public:
  explicit TickKinematics(std::span<const MechanismPtr> mechanisms) {
    for (auto& of_tick : values_)
      for (const MechanismPtr& m : mechanisms) of_tick.emplace_back(*m);
  }

  /// Kinematics of a character that were left for the tick. They may belong to another state (KnownKinematics::find).
  [[nodiscard]] const dynamics::KnownKinematics& at(std::uint64_t tick, int character) const {
    return values_[tick & 1][static_cast<std::size_t>(character)];
  }
  /// The same of all characters.
  [[nodiscard]] std::span<const dynamics::KnownKinematics> at(std::uint64_t tick) const { return values_[tick & 1]; }
  /// Leaves `values` for the tick after `tick`, and gives older ones in exchange. @param writer the LSI that calls; see claim()
  void leave(const void* writer, std::uint64_t tick, int character, dynamics::KnownKinematics& values) {
    if (writer == writer_) std::swap(values_[(tick + 1) & 1][static_cast<std::size_t>(character)], values);
  }

  /// The first LSI that calls becomes the only writer until it calls release(). Call both while no circuit runs.
  void claim(const void* writer) {
    if (writer_ == nullptr) writer_ = writer;
  }
  void release(const void* writer) {
    if (writer_ == writer) writer_ = nullptr;
  }

 private:
  std::array<std::vector<dynamics::KnownKinematics>, 2> values_;  // [parity of the tick][characters]
  const void* writer_ = nullptr;
};

}  // namespace ugoki::lsi
