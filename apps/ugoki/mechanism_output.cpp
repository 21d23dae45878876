#include "mechanism_output.h"

#include "output_files.h"

#include <filesystem>

#include "ugoki/files/files.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/robot_formats/robot_writer.h"

namespace ugoki::cli {

Result<std::vector<std::string>> write_mechanism_file(const Mechanism& mechanism, const std::string& path) {
  const std::filesystem::path file(path);
  const std::string ending = file.extension().string();
  robot_formats::RobotText out;
  if (ending == ".json")
    out.text = formats::write_mechanism(mechanism);
  else if (ending == ".urdf")
    out = robot_formats::write_urdf(mechanism, file.stem().string());
  else if (ending == ".xml" || ending == ".mjcf")
    out = robot_formats::write_mjcf(mechanism);
  else
    return fail(ErrorCode::unsupported, path, "Mechanisms cannot be written to files with this extension.",
                "Name a .json, .urdf or .xml (MJCF) file.");
  // All files are checked before the first one is written.
  std::vector<NamedFile> outputs = {{"the output", path}};
  for (const robot_formats::SideFile& extra : out.files)
    outputs.push_back({"a file beside the output", (file.parent_path() / extra.name).string()});
  if (Result<void> may = check_outputs({}, outputs); !may) return fail(std::move(may.error()));
  for (const robot_formats::SideFile& extra : out.files) {
    const std::string location = (file.parent_path() / extra.name).string();
    if (Result<void> done = files::write_file(location, extra.text); !done) return fail(std::move(done.error()));
    out.notes.push_back("Additional file: " + extra.name + ".");
  }
  if (Result<void> done = files::write_file(path, out.text); !done) return fail(std::move(done.error()));
  return std::move(out.notes);
}

}  // namespace ugoki::cli
