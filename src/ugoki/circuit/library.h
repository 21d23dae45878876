#pragma once
// All LSI classes that circuits may use, by name.

#include <span>
#include <string_view>
#include <vector>

#include "ugoki/circuit/lsi_class.h"

namespace ugoki::circuit {

class Library {
 public:
  /// Adds a class; a second one of the same name is the programmer's mistake, and so is a declaration that contradicts itself.
  void add(LsiClass lsi_class);
  /// The class of this name, or the only one "library/name" of an installed library, or null. Valid until the next add.
  [[nodiscard]] const LsiClass* find(std::string_view name) const;
  [[nodiscard]] bool has(std::string_view name) const;  ///< of exactly this name
  /// In the order of their names.
  [[nodiscard]] std::span<const LsiClass> classes() const { return classes_; }

 private:
  [[nodiscard]] const LsiClass* find_exactly(std::string_view name) const;
  std::vector<LsiClass> classes_;
};

}  // namespace ugoki::circuit
