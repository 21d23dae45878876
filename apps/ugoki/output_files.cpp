#include "output_files.h"

#include <sys/stat.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <set>

#include "ugoki/files/files.h"
#include "ugoki/project/project_file.h"
#include "ugoki/store/library_schema.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

bool is_device(const std::string& path) {
  std::error_code none;
  return fs::is_character_file(path, none);
}

bool same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  if (fs::equivalent(a, b, error)) return true;
  const fs::path whole_a = fs::weakly_canonical(fs::absolute(a, error), error),
                 whole_b = fs::weakly_canonical(fs::absolute(b, error), error);
  return !error && whole_a == whole_b;
}

/// "a project" or "a library" if the header of the file shows this; else null. SQLite stores the application id big-endian at byte 68.
const char* kind_of_database(const std::string& path) {
  std::error_code none;
  if (!fs::is_regular_file(path, none)) return nullptr;
  std::array<char, 72> head{};
  std::ifstream file(path, std::ios::binary);
  if (!file.read(head.data(), head.size()) || !std::string_view(head.data(), head.size()).starts_with("SQLite format 3")) return nullptr;
  std::int64_t application = 0;
  for (std::size_t i = 68; i < 72; ++i) application = application << 8 | static_cast<unsigned char>(head[i]);
  return application == project::project_application_id ? "a project"
         : application == store::library_application_id ? "a library"
                                                        : nullptr;
}

std::set<std::string>& noted_files() {
  static std::set<std::string> files;
  return files;
}

}  // namespace

void note_read(const std::string& path) { noted_files().insert(path); }

Result<void> check_outputs(const std::vector<NamedFile>& inputs, const std::vector<NamedFile>& outputs) {
  std::error_code none;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const NamedFile& out = outputs[i];
    if (out.path.empty() || is_device(out.path)) continue;
    for (const NamedFile& in : inputs)
      if (!in.path.empty() && fs::exists(in.path, none) && same_file(in.path, out.path))
        return fail(ErrorCode::conflict, out.path,
                    "The output is an input file: " + out.option + " would overwrite " + in.path + " (" + in.option + ").",
                    "Name another file for the output.");
    for (const std::string& read : noted_files())
      if (fs::exists(read, none) && same_file(read, out.path))
        return fail(ErrorCode::conflict, out.path,
                    "The output is a file of the input: " + out.option + " would overwrite " + read + ", which the input uses.",
                    "Choose another name or folder for the output.");
    for (std::size_t k = 0; k < i; ++k)
      if (!outputs[k].path.empty() && same_file(outputs[k].path, out.path))
        return fail(
            ErrorCode::conflict, out.path,
            "Two outputs have the same file: " + out.option + " would overwrite " + outputs[k].path + " (" + outputs[k].option + ").",
            "Name a file of its own for each output.");
    if (const char* kind = kind_of_database(out.path))
      return fail(ErrorCode::conflict, out.path, out.option + " would overwrite " + out.path + ", which is " + kind + ".",
                  "Name another file for the output, or remove this one first.");
  }
  return {};
}

Result<void> check_pictures(const std::vector<NamedFile>& inputs, const std::vector<NamedFile>& others,
                            const std::vector<std::string>& pictures) {
  std::error_code none;
  const auto whole = [&](const std::string& path) { return fs::absolute(path, none).lexically_normal().string(); };
  std::set<std::string> named;
  for (const NamedFile& other : others)
    if (!other.path.empty()) named.insert(whole(other.path));
  std::vector<NamedFile> outputs = others;
  outputs.push_back({"a picture of --png", ""});
  for (const std::string& picture : pictures) {
    if (!fs::exists(picture, none) && !named.contains(whole(picture))) continue;
    outputs.back().path = picture;
    if (Result<void> may = check_outputs(inputs, outputs); !may) return may;
  }
  return {};
}

Result<void> check_derived(const std::string& path, std::string_view mark) {
  std::error_code none;
  if (!fs::exists(path, none)) return {};
  const Result<std::string> text = files::read_regular_file(path);
  if (text && text->find(mark) != std::string::npos) return {};
  return fail(ErrorCode::conflict, path, "The file exists and was not written by Ugoki; this command would overwrite " + path + ".",
              "Choose another name or folder for the output, or remove the file first.");
}

std::vector<NamedFile> input_files(const std::string& target, const SourceOptions& options) {
  std::vector<NamedFile> out = {
      {"the input", target}, {"--skeleton", options.asf}, {"--mapping", options.mapping}, {"--loops", options.robot.loops}};
  if (options.asf.empty() && intake::file_kind(target) == intake::FileKind::amc)
    out.push_back({"the skeleton of the input", intake::skeleton_name_for(target)});
  return out;
}

std::vector<NamedFile> input_files(const std::vector<std::string>& targets, const SourceOptions& options) {
  std::vector<NamedFile> out;
  for (const std::string& target : targets)
    for (NamedFile& file : input_files(target, options)) out.push_back(std::move(file));
  return out;
}

}  // namespace ugoki::cli
