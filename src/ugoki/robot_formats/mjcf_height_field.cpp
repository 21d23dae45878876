// Reads height fields of MJCF.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

#include "ugoki/robot_formats/mjcf_source.h"

namespace ugoki::robot_formats {
namespace {

constexpr int max_points_along = 100'000;  // maximum number of rows, and of columns

std::uint32_t u32(const char* p) {
  std::uint32_t out = 0;
  for (unsigned i = 0; i < 4; ++i) out |= std::uint32_t{static_cast<unsigned char>(p[i])} << (8 * i);
  return out;
}

/// Reads MuJoCo's own binary format: rows, columns (32 bits each), then one float per point. Returns false for any other format.
bool read_own_format(const std::string& bytes, HeightField& out) {
  if (bytes.size() < 8) return false;
  const std::uint32_t rows = u32(bytes.data()), columns = u32(bytes.data() + 4);
  if (rows < 2 || columns < 2 || rows > max_points_along || columns > max_points_along) return false;
  const std::size_t count = std::size_t{rows} * columns;
  if (count > max_heights || bytes.size() != 8 + 4 * count) return false;
  out.rows = static_cast<int>(rows);
  out.columns = static_cast<int>(columns);
  for (std::size_t i = 0; i < count; ++i) out.heights.push_back(std::bit_cast<float>(u32(bytes.data() + 8 + 4 * i)));
  return true;
}

}  // namespace

const MjcfHeightField* MjcfSource::height_field(const std::string& name) {
  const auto it = height_fields_.find(name);
  if (it == height_fields_.end()) return nullptr;
  if (!it->second.tried) load_height_field(it->second);
  return &it->second;
}

void MjcfSource::load_height_field(MjcfHeightField& asset) const {
  asset.tried = true;
  const MjcfAttributes a(asset.element);
  double size[4] = {0, 0, 0, 0};
  if (!a.numbers("size", size, not_negative) || !(size[0] > 0 && size[1] > 0 && size[2] > 0 && size[3] > 0)) {
    asset.element.problem(ErrorCode::range, asset.element.title() + " needs four sizes greater than zero.",
                          "Give size=\"x y height base\".");
    return;
  }
  HeightField field;
  field.half_x = size[0];
  field.half_y = size[1];
  field.base = size[3];
  if (a.has("file")) {
    const std::string path = mesh_path(a.text("file"));
    const Result<std::string> bytes = files_->read(path);
    if (!bytes || !read_own_format(*bytes, field)) {
      asset.absent = !bytes
                         ? "A height field is left out because its file was not found."
                         : "A height field is left out because its file is an image or damaged; only MuJoCo's binary format can be read.";
      return;
    }
  } else {
    field.rows = a.integer("nrow", 0, 0, max_points_along);
    field.columns = a.integer("ncol", 0, 0, max_points_along);
    const std::size_t count = static_cast<std::size_t>(field.rows) * static_cast<std::size_t>(field.columns);
    if (a.has("elevation") && count <= max_heights) {  // listed as seen from above: the first row is at the maximum y
      const std::vector<double> listed = asset.element.file->list(asset.element.attribute("elevation"), 0, max_heights);
      for (std::size_t r = static_cast<std::size_t>(field.rows); r-- > 0 && listed.size() == count;)
        for (std::size_t c = 0; c < static_cast<std::size_t>(field.columns); ++c)
          field.heights.push_back(listed[r * static_cast<std::size_t>(field.columns) + c]);
    } else if (count <= max_heights) {  // no heights in the file: in MuJoCo a program can set them after loading, so all are 0 here
      field.heights.assign(count, 0.0);
    }
  }
  if (!field.heights.empty()) {
    const auto [low, high] = std::ranges::minmax(field.heights);
    const double scale = high > low ? size[2] / (high - low) : 0;
    for (double& h : field.heights) h = (h - low) * scale;
  }
  Result<HeightFieldPtr> made = make_height_field(std::move(field), "");
  if (made) {
    asset.field = std::move(*made);
    return;
  }
  const Problem& why = made.error().problems[0];
  asset.element.problem(why.code, why.message, why.remedy);
}

}  // namespace ugoki::robot_formats
