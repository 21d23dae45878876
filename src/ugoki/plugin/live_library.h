#pragma once
// All LSIs that circuits of this process may use: those of the program, those on the shelf, and files that were named. Loads them, and
// loads them again when they change on disk.

#include <memory>
#include <string>
#include <vector>

#include "ugoki/circuit/library.h"

namespace ugoki::plugin {

class LiveLibrary {
 public:
  /// @param base the program's own LSIs @param shelf folder; empty: none @param files libraries to use from where they are
  LiveLibrary(const circuit::Library& base, std::string shelf, std::vector<std::string> files = {});
  ~LiveLibrary();

  /// The code of its plug-ins lives as long as the pointer.
  [[nodiscard]] std::shared_ptr<const circuit::Library> library() const { return library_; }
  /// Looks at the disk. True: library() is another one from now on.
  bool poll();
  /// What could not be loaded, and what FMUs said while they ran, since it was asked for last.
  [[nodiscard]] std::vector<std::string> take_messages();

 private:
  struct Source;
  void find_sources(std::vector<Source>& out) const;
  void assemble();

  const circuit::Library& base_;
  std::string shelf_;
  std::vector<std::string> files_;
  std::vector<Source> sources_;
  std::string shelf_stamp_;
  std::shared_ptr<const circuit::Library> library_;
  std::vector<std::string> messages_;
};

}  // namespace ugoki::plugin
