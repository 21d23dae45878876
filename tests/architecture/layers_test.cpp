// Dependencies between modules: layers.txt has no cycle, the build conforms to layers.txt, and every #include conforms to both.

#include "layers.h"

#include <gtest/gtest.h>

#include "sources.h"

namespace ugoki::architecture {
namespace {

const std::string root = UGOKI_SOURCE_DIR;

std::vector<Layer> plan() { return read_layers(root + "/tests/architecture/layers.txt"); }

TEST(Layers, LayersHaveNoCycleAndNameOnlyListedModules) {
  const std::vector<Layer> layers = plan();
  ASSERT_FALSE(layers.empty()) << "tests/architecture/layers.txt is missing";
  std::set<std::string> below;
  bool native_begun = false;
  for (const Layer& layer : layers) {
    ASSERT_FALSE(layer.module.empty()) << "a line of layers.txt is not `core|native name : modules...`";
    for (const std::string& used : layer.may_use) {
      EXPECT_TRUE(below.contains(used)) << layer.module << " may use " << used << ", which is not listed above it";
    }
    native_begun = native_begun || !layer.core;
    EXPECT_FALSE(native_begun && layer.core) << "core module " << layer.module << " is listed after a native module";
    EXPECT_TRUE(below.insert(layer.module).second) << layer.module << " is listed twice";
  }
}

TEST(Layers, PhysicsAndCircuitsMeetOnlyInLsi) {
  std::map<std::string, std::set<std::string>> may;
  for (const Layer& layer : plan()) may[layer.module] = layer.may_use;
  for (const char* of_physics : {"spatial", "mechanism", "dynamics", "collision", "contact", "motion", "control"}) {
    EXPECT_FALSE(may["circuit"].contains(of_physics)) << "circuit must not depend on physics";
    EXPECT_FALSE(may["store"].contains(of_physics)) << "store must not depend on physics";
  }
  for (const char* of_circuits : {"circuit", "lsi", "content"}) {
    EXPECT_FALSE(may["dynamics"].contains(of_circuits)) << "dynamics must not depend on circuits";
  }
}

TEST(Layers, DeclaredDependenciesAreAllowed) {
  std::map<std::string, Layer> layers;
  for (const Layer& layer : plan()) layers[layer.module] = layer;
  const auto depends = read_depends(UGOKI_MODULES_FILE);
  ASSERT_FALSE(depends.empty());
  for (const auto& [module, used] : depends) {
    ASSERT_TRUE(layers.contains(module)) << "module " << module << " is not in tests/architecture/layers.txt";
    for (const std::string& other : used) {
      EXPECT_TRUE(layers[module].may_use.contains(other))
          << "src/ugoki/" << module << "/CMakeLists.txt: DEPENDS " << other << " is not allowed by tests/architecture/layers.txt";
    }
  }
}

TEST(Layers, IncludesAreAllowedAndDeclared) {
  std::map<std::string, Layer> layers;
  for (const Layer& layer : plan()) layers[layer.module] = layer;
  const auto depends = read_depends(UGOKI_MODULES_FILE);
  int checked = 0;
  for (const SourceFile& file : read_sources(root, "src/ugoki")) {
    ASSERT_TRUE(layers.contains(file.module)) << file.path << ": module not in tests/architecture/layers.txt";
    if (!depends.contains(file.module)) continue;  // not part of this build
    const std::set<std::string> linked = reach(depends, file.module);
    for (const Include& include : includes_of(file)) {
      const std::string used = module_of_include(include.target);
      if (used.empty() || used == file.module) continue;
      ++checked;
      EXPECT_TRUE(layers[file.module].may_use.contains(used))
          << file.location(include.line) << ": " << file.module << " may not include " << include.target;
      EXPECT_TRUE(linked.contains(used)) << file.location(include.line) << ": includes " << include.target << ", but " << file.module
                                         << " does not depend on " << used << " in its CMakeLists.txt";
    }
  }
  EXPECT_GT(checked, 0);
}

TEST(Layers, ReachContainsIndirectDependencies) {
  const std::map<std::string, std::set<std::string>> depends = {{"a", {}}, {"b", {"a"}}, {"c", {"b"}}, {"d", {"c", "a"}}};
  EXPECT_EQ(reach(depends, "d"), (std::set<std::string>{"a", "b", "c"}));
  EXPECT_TRUE(reach(depends, "a").empty());
}

}  // namespace
}  // namespace ugoki::architecture
