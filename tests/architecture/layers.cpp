#include "layers.h"

#include <fstream>
#include <sstream>

namespace ugoki::architecture {

std::vector<Layer> read_layers(const std::string& path) {
  std::ifstream file(path);
  std::vector<Layer> layers;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::string kind, colon, used;
    Layer layer;
    words >> kind >> layer.module >> colon;
    layer.core = kind == "core";
    if ((!layer.core && kind != "native") || colon != ":") layer.module.clear();
    while (words >> used) layer.may_use.insert(used);
    layers.push_back(std::move(layer));
  }
  return layers;
}

std::map<std::string, std::set<std::string>> read_depends(const std::string& path) {
  std::ifstream file(path);
  std::map<std::string, std::set<std::string>> depends;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string module, colon, used;
    if (!(words >> module >> colon)) continue;
    std::set<std::string>& of_module = depends[module];
    while (words >> used) of_module.insert(used);
  }
  return depends;
}

std::set<std::string> reach(const std::map<std::string, std::set<std::string>>& depends, const std::string& module) {
  std::set<std::string> reached;
  std::vector<std::string> open{module};
  while (!open.empty()) {
    const std::string next = open.back();
    open.pop_back();
    const auto found = depends.find(next);
    if (found == depends.end()) continue;
    for (const std::string& used : found->second)
      if (reached.insert(used).second) open.push_back(used);
  }
  return reached;
}

}  // namespace ugoki::architecture
