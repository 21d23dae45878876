#pragma once
// The house's plan (layers.txt) and what the build says of each module (written by CMake), as data.

#include <map>
#include <set>
#include <string>
#include <vector>

namespace ugoki::architecture {

struct Layer {
  std::string module;
  bool core = false;              ///< builds for WebAssembly
  std::set<std::string> may_use;  ///< modules it may include, itself not named
};

/// layers.txt, lowest layer first. Lines that cannot be read come back as layers with an empty name.
std::vector<Layer> read_layers(const std::string& path);

/// "name : depends..." lines as CMake wrote them.
std::map<std::string, std::set<std::string>> read_depends(const std::string& path);

/// What `module` reaches through the modules it depends on, itself not named.
std::set<std::string> reach(const std::map<std::string, std::set<std::string>>& depends, const std::string& module);

}  // namespace ugoki::architecture
