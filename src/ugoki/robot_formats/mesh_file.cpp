#include "ugoki/robot_formats/mesh_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "ugoki/base/number.h"
#include "ugoki/formats/text.h"
#include "ugoki/robot_formats/collada_mesh.h"
#include "ugoki/robot_formats/symmetric_eigen.h"

namespace ugoki::robot_formats {
namespace {

constexpr double max_coordinate = 1e6;    // maximum magnitude of a coordinate, in the file's unit
constexpr double min_half_extent = 1e-4;  // m: minimum half thickness of a box, because a box of zero volume cannot collide
constexpr std::size_t max_points = 100'000'000;

bool ends_with(std::string_view name, std::string_view ending) {
  return name.size() >= ending.size() && formats::equal_ignoring_case(name.substr(name.size() - ending.size()), ending);
}

std::uint32_t u32(const char* p) {
  std::uint32_t out = 0;
  for (unsigned i = 0; i < 4; ++i) out |= std::uint32_t{static_cast<unsigned char>(p[i])} << (8 * i);
  return out;
}

/// Makes one triangle of every three consecutive points.
void join_in_threes(MeshFile& mesh) {
  for (int i = 0; i + 2 < static_cast<int>(mesh.points.size()); i += 3) mesh.triangles.push_back({i, i + 1, i + 2});
}

MeshFile binary_stl(std::string_view bytes, std::size_t triangles) {
  MeshFile out;
  out.points.reserve(3 * triangles);
  for (std::size_t t = 0; t < triangles; ++t)
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const char* p = bytes.data() + 84 + 50 * t + 12 + 12 * corner;
      out.points.push_back({std::bit_cast<float>(u32(p)), std::bit_cast<float>(u32(p + 4)), std::bit_cast<float>(u32(p + 8))});
    }
  join_in_threes(out);
  return out;
}

/// Reads the next three numbers on the line. If one is missing or invalid, adds a problem to `error` and returns std::nullopt.
std::optional<Vec3> point_on_line(formats::Scanner& scan, const std::string& file_name, Error& error) {
  Vec3 v;
  for (int i = 0; i < 3; ++i) {
    const std::string_view token = scan.word_on_line();
    const std::optional<double> value = formats::measured_number(token);
    if (!value) {
      const formats::NumberFault fault = formats::number_fault(token);
      error.add(fault.code, file_name + ":" + std::to_string(scan.line()), fault.message, fault.remedy);
      return std::nullopt;
    }
    v[i] = *value;
  }
  return v;
}

Result<MeshFile> ascii_stl(std::string_view text, const std::string& file_name) {
  MeshFile out;
  Error error;
  formats::Scanner scan(text);
  while (scan.skip_space()) {
    if (scan.word_on_line() != "vertex") continue;
    const std::optional<Vec3> p = point_on_line(scan, file_name, error);
    if (!p) return fail(std::move(error));
    out.points.push_back(*p);
  }
  join_in_threes(out);
  return out;
}

Result<MeshFile> obj(std::string_view text, const std::string& file_name) {
  MeshFile out;
  Error error;
  formats::Scanner scan(text);
  while (scan.skip_space()) {
    const std::string_view kind = scan.word_on_line();
    if (kind == "v") {
      const std::optional<Vec3> p = point_on_line(scan, file_name, error);
      if (!p) return fail(std::move(error));
      out.points.push_back(*p);
    } else if (kind == "f") {  // a polygon becomes a triangle fan; "7/2/3" means point 7, -1 the last point
      std::array<int, 3> fan{};
      int corner = 0;
      for (std::string_view token = scan.word_on_line(); !token.empty(); token = scan.word_on_line(), ++corner) {
        const long count = static_cast<long>(out.points.size());
        const std::optional<long> given = parse_long(token.substr(0, token.find('/')));
        const long index = !given ? -1 : *given < 0 ? count + *given : *given - 1;
        if (index < 0 || index >= count)
          return fail(ErrorCode::range, file_name + ":" + std::to_string(scan.line()),
                      formats::in_quotes(token) + " does not refer to a preceding vertex.", "Export the mesh again.");
        if (corner >= 2) out.triangles.push_back({fan[0], fan[1], static_cast<int>(index)});
        fan[corner == 0 ? 0 : 1] = static_cast<int>(index);
      }
    }
    while (!scan.word_on_line().empty()) {
    }
  }
  return out;
}

Result<MeshFile> read_kind(std::string_view bytes, const std::string& file_name) {
  if (ends_with(file_name, ".stl")) {
    const std::size_t triangles = bytes.size() >= 84 ? u32(bytes.data() + 80) : 0;
    if (triangles > 0 && (bytes.size() - 84) / 50 >= triangles) return binary_stl(bytes, triangles);
    if (bytes.starts_with("solid")) return ascii_stl(bytes, file_name);
    return fail(ErrorCode::truncated, file_name, "The STL file ends before its last triangle.", "Export the mesh again.");
  }
  if (ends_with(file_name, ".obj")) return obj(bytes, file_name);
  if (ends_with(file_name, ".dae")) return collada_mesh(bytes, file_name);
  return fail(ErrorCode::unsupported, file_name, "Mesh files of this type cannot be read.", "Give an STL, OBJ or DAE file.");
}

/// Returns the bounding box of the points with sides parallel to the columns of R.
Shape box_along(const std::vector<Vec3>& points, const Mat3& R) {
  Vec3 low = transpose_times(R, points.front()), high = low;
  for (const Vec3& point : points) {
    const Vec3 p = transpose_times(R, point);
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], p[i]);
      high[i] = std::max(high[i], p[i]);
    }
  }
  Vec3 half = (high - low) * 0.5;
  for (int i = 0; i < 3; ++i) half[i] = std::max(half[i], min_half_extent);
  return Shape::box(half, {R, R * ((low + high) * 0.5)});
}

Mat3 principal_axes(const std::vector<Vec3>& points) {
  Vec3 mean;
  for (const Vec3& p : points) mean += p * (1.0 / static_cast<double>(points.size()));
  Sym3 moments;
  for (const Vec3& point : points) {
    const Vec3 p = point - mean;
    moments = moments + Sym3{p.x * p.x, p.y * p.y, p.z * p.z, p.x * p.y, p.x * p.z, p.y * p.z};
  }
  return symmetric_eigen(moments).V;
}

}  // namespace

Result<MeshFile> read_mesh(std::string_view bytes, std::string_view file_name) {
  const std::string location(file_name);
  Result<MeshFile> mesh = read_kind(bytes, location);
  if (!mesh) return mesh;
  if (mesh->points.empty()) return fail(ErrorCode::structure, location, "The mesh has no vertex.", "Export the mesh again.");
  if (mesh->points.size() > max_points)
    return fail(ErrorCode::range, location, "The mesh has more than 100 million vertices.", "Reduce the mesh.");
  for (const Vec3& p : mesh->points)
    if (!(std::fabs(p.x) <= max_coordinate && std::fabs(p.y) <= max_coordinate && std::fabs(p.z) <= max_coordinate))
      return fail(ErrorCode::range, location, "A coordinate of a vertex is not finite or greater than 1e6.", "Export the mesh again.");
  return mesh;
}

Shape box_around(const std::vector<Vec3>& points) {
  const Shape aligned = box_along(points, Mat3::identity());
  const Shape rotated = box_along(points, principal_axes(points));
  // The rotated box is used only if it is clearly smaller (10 %), because the axis-aligned box is simpler.
  return volume(rotated) < 0.9 * volume(aligned) ? rotated : aligned;
}

}  // namespace ugoki::robot_formats
