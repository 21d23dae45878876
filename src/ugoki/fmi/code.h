#pragma once
// The native code of an FMU. Its binary and resources are unpacked into a temporary folder, and its functions are looked up. Opening the
// code runs foreign code; do it only in a process that may crash.

#include <memory>
#include <string>
#include <utility>

#include "ugoki/base/result.h"
#include "ugoki/files/temporary_folder.h"
#include "ugoki/fmi/abi2.h"
#include "ugoki/fmi/abi3.h"
#include "ugoki/fmi/archive.h"
#include "ugoki/fmi/model_description.h"

namespace ugoki::fmi {

#define UGOKI_FMI_MEMBER(result, name, arguments) result(*name) arguments = nullptr;
#define UGOKI_FMI3_ACCESS(type)                                                                                      \
  fmi3Status (*Get##type)(fmi3Instance, const fmi3ValueReference*, std::size_t, fmi3##type*, std::size_t) = nullptr; \
  fmi3Status (*Set##type)(fmi3Instance, const fmi3ValueReference*, std::size_t, const fmi3##type*, std::size_t) = nullptr;
/// Pointers to functions of FMI 2.0: Functions2::DoStep is fmi2DoStep. Null: the FMU lacks the function and does not need it.
struct Functions2 {
  UGOKI_FMI2_FUNCTIONS(UGOKI_FMI_MEMBER)
};
/// Pointers to functions of FMI 3.0, as in Functions2.
struct Functions3 {
  UGOKI_FMI3_FUNCTIONS(UGOKI_FMI_MEMBER)
  UGOKI_FMI3_NUMBERS(UGOKI_FMI3_ACCESS)
};
#undef UGOKI_FMI3_ACCESS
#undef UGOKI_FMI_MEMBER

/// The loaded binary of an FMU. The destructor removes the temporary folder; the binary stays loaded until the process ends.
class Code {
 public:
  /// Errors (location: `location`): the FMU has no binary for this system, it cannot be opened, or it lacks functions.
  [[nodiscard]] static Result<std::shared_ptr<Code>> open(const Archive& archive, const ModelDescription& description,
                                                          std::string_view location);
  Code(const Code&) = delete;
  Code& operator=(const Code&) = delete;

  [[nodiscard]] const Functions2& two() const { return two_; }
  [[nodiscard]] const Functions3& three() const { return three_; }
  /// The folder with the unpacked resources: a URI in FMI 2.0, a path that ends with '/' in FMI 3.0.
  [[nodiscard]] const std::string& resources() const { return resources_; }

 private:
  explicit Code(files::TemporaryFolder folder) : folder_(std::move(folder)) {}
  files::TemporaryFolder folder_;
  std::string resources_;
  Functions2 two_;
  Functions3 three_;
};

/// Name of the binary for this system in the archive: "binaries/x86_64-linux/ball.so".
[[nodiscard]] std::string binary_name(const ModelDescription& description);
/// Error if the archive has no binary for this system; the message lists the systems that it has binaries for.
[[nodiscard]] Result<void> check_binary(const Archive& archive, const ModelDescription& description, std::string_view location);

}  // namespace ugoki::fmi
