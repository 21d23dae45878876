#pragma once
// The set of LSI classes (kinds of components) that circuits can use, found by name.

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/circuit/lsi_class.h"

namespace ugoki::circuit {

class Library {
 public:
  /// Adds a class. A duplicate name or an inconsistent declaration fails a UGOKI_CHECK.
  void add(LsiClass lsi_class);
  /// Returns the class of this name. If there is none, returns the class "library/name" if exactly one installed library has it, else null.
  /// The pointer is valid until the next add.
  [[nodiscard]] const LsiClass* find(std::string_view name) const;
  [[nodiscard]] bool has(std::string_view name) const;  ///< true if a class has exactly this name
  /// All classes, sorted by name.
  [[nodiscard]] std::span<const LsiClass> classes() const { return classes_; }

  /// Records that the installed library `name` cannot be used. Messages about its LSIs then give the reason `why`, a sentence.
  void note_refused(std::string name, std::string why) { refused_[std::move(name)] = std::move(why); }
  /// The reason why the library `name` cannot be used; null: it was not refused.
  [[nodiscard]] const std::string* find_refusal(std::string_view name) const;

 private:
  [[nodiscard]] const LsiClass* find_exactly(std::string_view name) const;
  std::vector<LsiClass> classes_;
  std::map<std::string, std::string, std::less<>> refused_;
};

}  // namespace ugoki::circuit
