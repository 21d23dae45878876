// Runs the fuzz targets on the seed corpus, which includes every file that once broke a reader.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "fuzz_targets.h"

namespace ugoki {
namespace {

void run(const char* name, void (*target)(const std::uint8_t*, std::size_t)) {
  std::vector<std::filesystem::path> files;
  for (const auto& e : std::filesystem::directory_iterator(std::string(UGOKI_SOURCE_DIR) + "/tests/fuzz/seeds/" + name))
    files.push_back(e.path());
  std::sort(files.begin(), files.end());
  EXPECT_FALSE(files.empty());
  for (const auto& file : files) {
    SCOPED_TRACE(file.filename());
    std::ifstream in(file, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    target(data, bytes.size());
    for (std::size_t n = 0; n < bytes.size(); n += 1 + bytes.size() / 200) target(data, n);  // truncated
  }
}

TEST(FuzzSeeds, Bvh) { run("bvh", fuzz_bvh); }
TEST(FuzzSeeds, Asf) { run("asf", fuzz_asf); }
TEST(FuzzSeeds, Amc) { run("amc", fuzz_amc); }
TEST(FuzzSeeds, Mechanism) { run("mechanism", fuzz_mechanism); }
TEST(FuzzSeeds, Motion) { run("motion", fuzz_motion); }
TEST(FuzzSeeds, Urdf) { run("urdf", fuzz_urdf); }
TEST(FuzzSeeds, Sdf) { run("sdf", fuzz_sdf); }
TEST(FuzzSeeds, Mesh) { run("mesh", fuzz_mesh); }
TEST(FuzzSeeds, Mjcf) { run("mjcf", fuzz_mjcf); }
TEST(FuzzSeeds, C3d) { run("c3d", fuzz_c3d); }
TEST(FuzzSeeds, Trc) { run("trc", fuzz_trc); }
TEST(FuzzSeeds, Gltf) { run("gltf", fuzz_gltf); }
TEST(FuzzSeeds, GltfSkin) { run("gltf_skin", fuzz_gltf_skin); }
TEST(FuzzSeeds, FmuDescription) { run("fmu_description", fuzz_fmu_description); }
TEST(FuzzSeeds, Fmu) { run("fmu", fuzz_fmu); }
TEST(FuzzSeeds, Csv) { run("csv", fuzz_csv); }
TEST(FuzzSeeds, Fbx) { run("fbx", fuzz_fbx); }
TEST(FuzzSeeds, Collada) { run("collada", fuzz_collada); }
TEST(FuzzSeeds, Circuit) { run("circuit", fuzz_circuit); }
TEST(FuzzSeeds, Ugx) { run("ugx", fuzz_ugx); }
TEST(FuzzSeeds, UgxRun) { run("ugx_run", fuzz_ugx_run); }
TEST(FuzzSeeds, Project) { run("project", fuzz_project); }
TEST(FuzzSeeds, Skeleton) { run("skeleton", fuzz_skeleton); }
TEST(FuzzSeeds, Mvnx) { run("mvnx", fuzz_mvnx); }
TEST(FuzzSeeds, Usda) { run("usda", fuzz_usda); }
TEST(FuzzSeeds, Smpl) { run("smpl", fuzz_smpl); }
TEST(FuzzSeeds, OpenSim) { run("opensim", fuzz_opensim); }
TEST(FuzzSeeds, DeepMimic) { run("deepmimic", fuzz_deepmimic); }
TEST(FuzzSeeds, Set) { run("set", fuzz_set); }

}  // namespace
}  // namespace ugoki
