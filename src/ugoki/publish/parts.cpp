#include "ugoki/publish/parts.h"

#include <filesystem>
#include <vector>

#include "ugoki/files/files.h"

namespace ugoki::publish {

namespace fs = std::filesystem;

Result<std::string> read_player_part(const std::string& name, const std::string& folder) {
  std::error_code ec;
  const fs::path here = fs::read_symlink("/proc/self/exe", ec).parent_path();
  std::vector<fs::path> places;
  if (!folder.empty())
    places.emplace_back(folder);
  else
    places = {here / "../share/ugoki", here, here / "../libexec/ugoki"};
  for (const fs::path& place : places)
    if (fs::is_regular_file(place / name, ec)) return files::read_file((place / name).string());
  return fail(ErrorCode::io, name, "This part of the player was not found in " + places.front().lexically_normal().string() + ".",
              "Build the player once with ./start, or specify its folder with --player.");
}

}  // namespace ugoki::publish
