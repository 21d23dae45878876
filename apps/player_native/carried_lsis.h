#pragma once
// Libraries of LSIs (native code) that a program carries. Two implementations: carried_lsis.cpp loads them; no_lsis.cpp is that of the
// statically linked player, which cannot load code.

#include <cstdio>
#include <functional>
#include <span>
#include <string>

#include "ugoki/content/player.h"
#include "ugoki/publish/payload.h"

namespace ugoki::player_native {

/// Opens the user's browser. With `detached`, a process that is no descendant of this one opens it, because with_carried_lsis() ends all
/// processes that the code of libraries may have started. Create it before the first thread.
class BrowserOpener {
 public:
  explicit BrowserOpener(bool detached);
  ~BrowserOpener();
  BrowserOpener(const BrowserOpener&) = delete;
  BrowserOpener& operator=(const BrowserOpener&) = delete;
  void open(const std::string& path);

 private:
  [[maybe_unused]] int pipe_ = -1;  // to the detached process; -1: none
};

/// Stream for the results of the program. The code of libraries may print to stdout; its text goes to stderr.
[[nodiscard]] std::FILE* results();

/// Calls `work` with the options of a player that may use the LSIs of the libraries. If there are libraries, `work` runs in a guarded child
/// process (plugin::run_guarded): the error of a crash names the LSI. @param name name of the program in messages
/// @return result of `work`. Errors: a library cannot be loaded on this machine; an LSI crashed or hung.
[[nodiscard]] Result<int> with_carried_lsis(std::span<const publish::CarriedLibrary> libraries, const std::string& name,
                                            const std::function<int(const content::PlayerOptions&)>& work);

}  // namespace ugoki::player_native
