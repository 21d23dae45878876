#include "run_blender.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace ugoki {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder() : path((fs::temp_directory_path() / "ugoki-blender-XXXXXX").string()) {
  if (::mkdtemp(path.data()) == nullptr) path.clear();
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  if (!path.empty()) fs::remove_all(path, ignored);
}

bool blender_is_installed() { return std::system("blender --version > /dev/null 2>&1") == 0; }

BlenderOutput run_blender(const std::string& script, const std::string& arguments, const TemporaryFolder& folder) {
  const std::string scripts = UGOKI_SOURCE_DIR "/tests/blender", log = folder.path + "/log";
  const std::string command = "PATH=/usr/bin:/bin:$PATH PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=" + scripts +
                              " blender -b --factory-startup --python-use-system-env --python-exit-code 3 --python " + scripts + "/" +
                              script + " -- " + arguments + " > " + log + " 2>&1";
  BlenderOutput out;
  out.status = std::system(command.c_str());
  out.text = text_of_file(log);
  return out;
}

std::string text_of_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace ugoki
