#include "shared_files.h"

#include <algorithm>
#include <filesystem>

#include "ugoki/files/files.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/c3d.h"
#include "ugoki/formats/gltf.h"
#include "ugoki/formats/trc.h"
#include "ugoki/intake/intake.h"
#include "ugoki/robot_formats/robot_file.h"

namespace ugoki {

namespace fs = std::filesystem;

namespace {

template <class T>
T value_of(Result<T> result, const std::string& path) {
  EXPECT_TRUE(result.has_value()) << path << ": " << (result ? std::string() : result.error().text());
  return result ? std::move(*result) : T{};
}

}  // namespace

std::vector<std::string> shared_files() {
  std::vector<std::string> out;
  const fs::path root = UGOKI_SHARED_DATA;
  for (const char* folder : {"human", "animal", "gltf", "mechanism"}) {
    if (!fs::exists(root / folder)) continue;
    for (const auto& e : fs::recursive_directory_iterator(root / folder))
      if (e.is_regular_file()) out.push_back(e.path().lexically_relative(root).generic_string());
  }
  std::ranges::sort(out);
  return out;
}

std::string ending_of(const std::string& path) {
  std::string ending = fs::path(path).extension().string();
  std::ranges::transform(ending, ending.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return ending;
}

std::vector<std::string> shared_files(std::initializer_list<const char*> endings) {
  std::vector<std::string> out = shared_files();
  std::erase_if(out, [&](const std::string& path) { return std::ranges::find(endings, ending_of(path)) == endings.end(); });
  return out;
}

std::string shared_text(const std::string& path) { return value_of(files::read_file(std::string(UGOKI_SHARED_DATA) + "/" + path), path); }

std::string skeleton_path(const std::string& amc) { return intake::skeleton_name_for(amc); }

bool is_whole(const std::string& gltf) {
  if (ending_of(gltf) != ".gltf") return true;
  const std::string text = shared_text(gltf);
  for (std::size_t at = text.find("\"uri\""); at != std::string::npos; at = text.find("\"uri\"", at + 1)) {
    const std::size_t begin = text.find('"', text.find(':', at)) + 1;
    const std::string uri = text.substr(begin, text.find('"', begin) - begin);
    if (!uri.starts_with("data:") && uri.ends_with(".bin") && !fs::exists((fs::path(UGOKI_SHARED_DATA) / gltf).parent_path() / uri))
      return false;
  }
  return true;
}

std::vector<MeasuredMotion> read_motions(const std::string& path) {
  const std::string text = shared_text(path);
  if (ending_of(path) == ".bvh") return {value_of(formats::read_bvh(text, path), path)};
  if (ending_of(path) == ".amc") {
    const std::string skeleton = skeleton_path(path);
    return {value_of(formats::read_amc(text, path, value_of(formats::read_asf(shared_text(skeleton), skeleton), skeleton)), path)};
  }
  return value_of(formats::read_gltf(bytes_of(text), path), path);
}

MarkerMotion read_markers(const std::string& path) {
  const std::string text = shared_text(path);
  return value_of(ending_of(path) == ".c3d" ? formats::read_c3d(bytes_of(text), path) : formats::read_trc(text, path), path);
}

Result<robot_formats::RobotModel> read_robot(const std::string& path, robot_formats::RobotOptions options) {
  options.read_asset = [](const std::string& asset) { return files::read_file(std::string(UGOKI_SHARED_DATA) + "/" + asset); };
  const std::string yaml = fs::path(path).replace_extension(".yaml").generic_string();
  if (ending_of(path) == ".urdf" && fs::exists(std::string(UGOKI_SHARED_DATA) + "/" + yaml))
    options.loops = robot_formats::SideFile{yaml, shared_text(yaml)};
  return robot_formats::read_robot_file(shared_text(path), path, options);
}

}  // namespace ugoki
