#pragma once
// All LSI classes that circuits may use, by name.

#include <map>
#include <span>
#include <string>
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

  /// The library `name` is installed and could not be used: for messages about its LSIs. @param why a sentence
  void note_refused(std::string name, std::string why) { refused_[std::move(name)] = std::move(why); }
  /// Why the library `name` is not used; null: it was not refused.
  [[nodiscard]] const std::string* find_refusal(std::string_view name) const;

 private:
  [[nodiscard]] const LsiClass* find_exactly(std::string_view name) const;
  std::vector<LsiClass> classes_;
  std::map<std::string, std::string, std::less<>> refused_;
};

}  // namespace ugoki::circuit
