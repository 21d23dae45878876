#pragma once
// Objects of the host that LSIs may request while a circuit is built: mechanisms, motions, settings. The runtime does not know their types.

#include <string_view>

namespace ugoki::circuit {

class Resources {
 public:
  virtual ~Resources() = default;
  /// The object of this kind and name, or null. Its address is valid for the lifetime of the interpreter.
  [[nodiscard]] virtual const void* find(std::string_view kind, std::string_view name) const = 0;
};

}  // namespace ugoki::circuit
