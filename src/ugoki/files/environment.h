#pragma once
// The environment variables of a program that is to be started.

#include <string>
#include <string_view>
#include <vector>

namespace ugoki::files {

/// A copy of this program's environment variables that can be changed.
class Environment {
 public:
  Environment();
  void set(std::string_view name, std::string_view value);
  /// "NAME=VALUE" texts and a null pointer at the end, for posix_spawn. Valid until the next call of a member or the end of the object.
  [[nodiscard]] char** pointers();

 private:
  std::vector<std::string> variables_;
  std::vector<char*> pointers_;
};

}  // namespace ugoki::files
