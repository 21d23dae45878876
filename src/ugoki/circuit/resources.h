#pragma once
// What LSIs may ask the host for while a circuit is built: mechanisms, motions, settings. The runtime does not know what they are.

#include <string_view>

namespace ugoki::circuit {

class Resources {
 public:
  virtual ~Resources() = default;
  /// The thing of this kind and name, or null. It stays where it is as long as the interpreter lives.
  [[nodiscard]] virtual const void* find(std::string_view kind, std::string_view name) const = 0;
};

}  // namespace ugoki::circuit
