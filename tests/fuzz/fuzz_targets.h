#pragma once
// Fuzz targets of the readers. A function aborts the program if the reader breaks one of its guarantees, and returns otherwise.

#include <cstddef>
#include <cstdint>

namespace ugoki {

void fuzz_bvh(const std::uint8_t* data, std::size_t size);
void fuzz_asf(const std::uint8_t* data, std::size_t size);
void fuzz_amc(const std::uint8_t* data, std::size_t size);
void fuzz_mechanism(const std::uint8_t* data, std::size_t size);
void fuzz_motion(const std::uint8_t* data, std::size_t size);
void fuzz_urdf(const std::uint8_t* data, std::size_t size);
void fuzz_sdf(const std::uint8_t* data, std::size_t size);
void fuzz_mesh(const std::uint8_t* data, std::size_t size);
void fuzz_mjcf(const std::uint8_t* data, std::size_t size);
void fuzz_c3d(const std::uint8_t* data, std::size_t size);
void fuzz_trc(const std::uint8_t* data, std::size_t size);
void fuzz_gltf(const std::uint8_t* data, std::size_t size);
void fuzz_gltf_skin(const std::uint8_t* data, std::size_t size);
void fuzz_fmu_description(const std::uint8_t* data, std::size_t size);
void fuzz_fmu(const std::uint8_t* data, std::size_t size);
void fuzz_csv(const std::uint8_t* data, std::size_t size);
void fuzz_fbx(const std::uint8_t* data, std::size_t size);
void fuzz_collada(const std::uint8_t* data, std::size_t size);
void fuzz_circuit(const std::uint8_t* data, std::size_t size);
void fuzz_ugx(const std::uint8_t* data, std::size_t size);
void fuzz_ugx_run(const std::uint8_t* data, std::size_t size);
/// Number of inputs that fuzz_ugx_run() has accepted and run. A fuzz target whose inputs are all refused checks nothing.
extern long ugx_runs;
void fuzz_project(const std::uint8_t* data, std::size_t size);
void fuzz_skeleton(const std::uint8_t* data, std::size_t size);
void fuzz_mvnx(const std::uint8_t* data, std::size_t size);
void fuzz_usda(const std::uint8_t* data, std::size_t size);
void fuzz_smpl(const std::uint8_t* data, std::size_t size);
void fuzz_opensim(const std::uint8_t* data, std::size_t size);
void fuzz_deepmimic(const std::uint8_t* data, std::size_t size);
void fuzz_set(const std::uint8_t* data, std::size_t size);

}  // namespace ugoki
