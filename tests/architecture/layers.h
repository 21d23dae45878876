#pragma once
// The allowed dependencies of the modules (layers.txt) and the declared ones (written by CMake), as data.

#include <map>
#include <set>
#include <string>
#include <vector>

namespace ugoki::architecture {

/// A module and its allowed dependencies.
struct Layer {
  std::string module;
  bool core = false;              ///< true: also builds for WebAssembly
  std::set<std::string> may_use;  ///< modules that it may include, without itself
};

/// Reads layers.txt, lowest layer first. A line that cannot be parsed becomes a layer with an empty name.
std::vector<Layer> read_layers(const std::string& path);

/// Reads the declared dependencies: lines "name : depends..." written by CMake.
std::map<std::string, std::set<std::string>> read_depends(const std::string& path);

/// All direct and indirect dependencies of `module`, without itself.
std::set<std::string> reach(const std::map<std::string, std::set<std::string>>& depends, const std::string& module);

}  // namespace ugoki::architecture
