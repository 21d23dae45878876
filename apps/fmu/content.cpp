// LSIs of the binary ugoki_fmu_content: all built-in LSIs, which use the mechanisms and motions of content.

#include "session.h"
#include "ugoki/content/player.h"
#include "ugoki/lsi/standard_library.h"

namespace ugoki::fmu {

const circuit::Library& packed_library() { return lsi::standard_library(); }

std::unique_ptr<circuit::Resources> packed_content(std::string_view bytes, std::string& why) {
  if (bytes.empty()) return nullptr;
  const auto content = content::read_executable(std::as_bytes(std::span(bytes)), "content.ugx");
  if (content) return std::make_unique<lsi::World>(content::make_world(*content));
  why = content.error().problems[0].message;
  return nullptr;
}

}  // namespace ugoki::fmu
