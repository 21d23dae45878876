#include "ugoki/files/environment.h"

#include <unistd.h>

namespace ugoki::files {

Environment::Environment() {
  for (char** variable = environ; variable != nullptr && *variable != nullptr; ++variable) variables_.emplace_back(*variable);
}

void Environment::set(std::string_view name, std::string_view value) {
  const std::string begin = std::string(name) + '=';
  std::erase_if(variables_, [&](const std::string& variable) { return variable.starts_with(begin); });
  variables_.push_back(begin + std::string(value));
}

char** Environment::pointers() {
  pointers_.clear();
  for (std::string& variable : variables_) pointers_.push_back(variable.data());
  pointers_.push_back(nullptr);
  return pointers_.data();
}

}  // namespace ugoki::files
