#pragma once
// The native part of an FMU: its binary and resources unpacked into a folder of their own, its functions found. Opening it runs foreign
// code: in a process that may end only.

#include <memory>
#include <string>

#include "ugoki/base/result.h"
#include "ugoki/fmi/abi2.h"
#include "ugoki/fmi/abi3.h"
#include "ugoki/fmi/archive.h"
#include "ugoki/fmi/model_description.h"

namespace ugoki::fmi {

#define UGOKI_FMI_MEMBER(result, name, arguments) result(*name) arguments = nullptr;
#define UGOKI_FMI3_ACCESS(type)                                                                                      \
  fmi3Status (*Get##type)(fmi3Instance, const fmi3ValueReference*, std::size_t, fmi3##type*, std::size_t) = nullptr; \
  fmi3Status (*Set##type)(fmi3Instance, const fmi3ValueReference*, std::size_t, const fmi3##type*, std::size_t) = nullptr;
struct Functions2 {
  UGOKI_FMI2_FUNCTIONS(UGOKI_FMI_MEMBER)
};
struct Functions3 {
  UGOKI_FMI3_FUNCTIONS(UGOKI_FMI_MEMBER)
  UGOKI_FMI3_NUMBERS(UGOKI_FMI3_ACCESS)
};
#undef UGOKI_FMI3_ACCESS
#undef UGOKI_FMI_MEMBER

class Code {
 public:
  /// Errors (place: `place`): no binary for this system, one that cannot be opened or lacks functions.
  [[nodiscard]] static Result<std::shared_ptr<Code>> open(const Archive& archive, const ModelDescription& description,
                                                          std::string_view place);
  ~Code();
  Code(const Code&) = delete;
  Code& operator=(const Code&) = delete;

  [[nodiscard]] const Functions2& two() const { return two_; }
  [[nodiscard]] const Functions3& three() const { return three_; }
  [[nodiscard]] const std::string& resources() const { return resources_; }  ///< FMI 2.0: URI; FMI 3.0: path with '/' at its end

 private:
  Code() = default;
  std::string folder_, resources_;
  Functions2 two_;
  Functions3 three_;
};

/// Name in the archive of the binary for this system.
[[nodiscard]] std::string binary_name(const ModelDescription& description);
/// An error that tells which systems there are binaries for, if this one's is missing.
[[nodiscard]] Result<void> check_binary(const Archive& archive, const ModelDescription& description, std::string_view place);

}  // namespace ugoki::fmi
