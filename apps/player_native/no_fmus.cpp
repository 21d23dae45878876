// Replaces the functions of the module fmi that the module plugin calls: programs carry no FMUs, because reading FMUs needs libzip.
// `ugoki export` refuses content with FMUs before this code is reached.

#include "ugoki/fmi/archive.h"
#include "ugoki/fmi/load.h"
#include "ugoki/fmi/messages.h"

namespace ugoki::fmi {
namespace {
Error no_fmus(const std::string& path) {
  return Error(ErrorCode::unsupported, path, "FMUs cannot be used in a native program.", "Run the content with `ugoki run`.");
}
}  // namespace

bool is_zip(std::string_view bytes) { return bytes.starts_with("PK"); }

Result<LoadedFmu> load_fmu(const std::string& path, std::string, std::string, Phase) { return fail(no_fmus(path)); }

Result<void> try_fmu(const std::string& path, std::string, std::string, Phase) { return fail(no_fmus(path)); }

std::vector<std::string> take_messages() { return {}; }

}  // namespace ugoki::fmi
