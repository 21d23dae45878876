// Motions read from glTF files match counts from their JSON, calculated here with nlohmann-json only.
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "shared_files.h"

namespace ugoki {
namespace {

using Json = nlohmann::json;

Json json_of(const std::string& path) {
  const std::string bytes = shared_text(path);
  if (!bytes.starts_with("glTF")) return Json::parse(bytes);
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, 4);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  return Json::parse(bytes.substr(20, size));
}

struct Nodes {
  std::vector<int> parents;
  std::vector<bool> skinned, moved, kept;

  explicit Nodes(const Json& file) {
    const std::size_t n = file["nodes"].size();
    parents.assign(n, -1);
    skinned.assign(n, !file.contains("skins"));
    moved.assign(n, false);
    for (std::size_t i = 0; i < n; ++i)
      for (const std::size_t child : file["nodes"][i].value("children", std::vector<std::size_t>{})) parents[child] = static_cast<int>(i);
    for (const Json& skin : file.value("skins", Json::array()))
      for (const std::size_t joint : skin["joints"]) skinned[joint] = true;
    for (const Json& animation : file.value("animations", Json::array()))
      for (const Json& channel : animation["channels"])
        if (channel["target"].contains("node") && channel["target"]["path"] != "weights")
          moved[channel["target"]["node"].get<std::size_t>()] = true;
    // Expected joints: the joints of skins, and every ancestor of a joint that is itself animated or is below a joint or an animated node.
    kept = skinned;
    for (std::size_t i = 0; i < n; ++i) {
      if (!skinned[i]) continue;
      const std::vector<std::size_t> way = above(i);
      for (std::size_t k = 0; k < way.size(); ++k)
        for (std::size_t top = k; top < way.size(); ++top) kept[way[k]] = kept[way[k]] || skinned[way[top]] || moved[way[top]];
    }
  }
  /// Ancestors of a node, parent first.
  std::vector<std::size_t> above(std::size_t node) const {
    std::vector<std::size_t> out;
    for (int n = parents[node]; n >= 0; n = parents[static_cast<std::size_t>(n)]) out.push_back(static_cast<std::size_t>(n));
    return out;
  }
  /// Whether the node or a descendant is a joint.
  bool moves_a_joint(std::size_t node) const {
    for (std::size_t i = 0; i < kept.size(); ++i) {
      if (!kept[i]) continue;
      if (i == node) return true;
      for (const std::size_t a : above(i))
        if (a == node) return true;
    }
    return false;
  }
};

TEST(SharedCounts, Gltf) {
  NEEDS_SHARED_FILES();
  for (const std::string& path : shared_files({".gltf", ".glb"})) {
    SCOPED_TRACE(path);
    if (!is_whole(path)) continue;
    const Json file = json_of(path);
    const Nodes nodes(file);
    const std::vector<MeasuredMotion> motions = read_motions(path);
    ASSERT_FALSE(motions.empty());
    EXPECT_EQ(motions[0].joint_count(), std::ranges::count(nodes.kept, true));
    std::size_t count = 0;
    for (const Json& animation : file.value("animations", Json::array())) {
      double first = INFINITY, last = -INFINITY, densest = 0;
      bool moves = false;
      for (const Json& channel : animation["channels"]) {
        if (!channel["target"].contains("node") || channel["target"]["path"] == "weights") continue;
        moves = moves || nodes.moves_a_joint(channel["target"]["node"].get<std::size_t>());
        const Json& input = file["accessors"][animation["samplers"][channel["sampler"].get<std::size_t>()]["input"].get<std::size_t>()];
        const double low = input["min"][0].get<double>(), high = input["max"][0].get<double>();
        first = std::min(first, low);
        last = std::max(last, high);
        if (high > low) densest = std::max(densest, (input["count"].get<double>() - 1) / (high - low));
      }
      if (!moves) continue;
      ASSERT_LT(count, motions.size());
      const MeasuredMotion& m = motions[count++];
      if (animation.contains("name")) EXPECT_EQ(m.name, animation["name"].get<std::string>());
      EXPECT_GE(m.rate, densest * (1 - 2e-3)) << "there should be as many frames as keys";
      EXPECT_NEAR((m.frames - 1) / m.rate, last - first, 1 / m.rate) << m.name;
      EXPECT_LE((m.frames - 1) / m.rate, last - first + 1e-2 / m.rate) << m.name;
    }
    EXPECT_EQ(motions.size(), std::max<std::size_t>(count, 1));
  }
}

}  // namespace
}  // namespace ugoki
