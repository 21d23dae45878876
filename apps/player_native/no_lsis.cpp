#include "carried_lsis.h"
#include "ugoki/studio/launch_page.h"

namespace ugoki::player_native {

BrowserOpener::BrowserOpener(bool) {}
BrowserOpener::~BrowserOpener() = default;
void BrowserOpener::open(const std::string& path) { studio::open_browser(path); }

std::FILE* results() { return stdout; }

Result<int> with_carried_lsis(std::span<const publish::CarriedLibrary> libraries, const std::string& name,
                              const std::function<int(const content::PlayerOptions&)>& work) {
  if (!libraries.empty())
    return fail(ErrorCode::unsupported, name, "This player cannot load the libraries of LSIs inside the program.",
                "Export it again with `ugoki export --native --carry-lsis`.");
  return work({});
}

}  // namespace ugoki::player_native
