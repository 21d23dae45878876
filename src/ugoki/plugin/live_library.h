#pragma once
// All LSIs that circuits of this process may use: those of the program, the installed ones (shelf.h), and libraries named by path.
// Libraries are reloaded when their files change. Loading runs foreign code; use this class only in a process that may crash (guard.h).

#include <memory>
#include <string>
#include <vector>

#include "ugoki/circuit/library.h"

namespace ugoki::plugin {

class LiveLibrary {
 public:
  /// @param base the program's own LSIs; must outlive this object @param shelf folder of the installed libraries; empty: none
  /// @param files paths of further libraries and FMUs; they are used without being installed
  LiveLibrary(const circuit::Library& base, std::string shelf, std::vector<std::string> files = {});
  ~LiveLibrary();

  /// The current set of LSIs. The loaded code stays in memory as long as a copy of the pointer exists.
  [[nodiscard]] std::shared_ptr<const circuit::Library> library() const { return library_; }
  /// Checks the files for changes and reloads those that changed. A file that cannot be loaded keeps its previous code.
  /// @return true if library() now returns another set
  bool poll();
  /// Loads new copies of the libraries whose code has global or static variables that it can change. LSIs of circuits that are built with
  /// the new library() then begin with the initial values of these variables. @return true if library() now returns another set
  bool renew();
  /// Messages since the last call: libraries that could not be loaded, and log messages of running FMUs.
  [[nodiscard]] std::vector<std::string> take_messages();

 private:
  struct Source;  // a library file and the code loaded from it
  void find_sources(std::vector<Source>& out) const;
  void assemble();

  const circuit::Library& base_;
  std::string shelf_;
  std::vector<std::string> files_;
  std::vector<Source> sources_;
  std::string shelf_stamp_;  // names and stamps (size, time ...) of the manifests when the shelf was read last
  std::shared_ptr<const circuit::Library> library_;
  std::vector<std::string> messages_;
};

}  // namespace ugoki::plugin
