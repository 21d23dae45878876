#include "ugoki/robot_formats/robot_file.h"

#include <string>

#include "ugoki/robot_formats/mjcf.h"
#include "ugoki/robot_formats/sdf.h"
#include "ugoki/robot_formats/urdf.h"

namespace ugoki::robot_formats {
namespace {

/// Name of the outermost element; empty where there is none.
std::string_view outermost_element(std::string_view text) {
  for (std::size_t at = text.find('<'); at != std::string_view::npos; at = text.find('<', at)) {
    const std::string_view rest = text.substr(at);
    const auto skip = [&](std::string_view closing) {
      const std::size_t end = rest.find(closing);
      at = end == std::string_view::npos ? text.size() : at + end + closing.size();
    };
    if (rest.starts_with("<!--"))
      skip("-->");
    else if (rest.starts_with("<?"))
      skip("?>");
    else if (rest.starts_with("<!"))
      skip(">");
    else
      return rest.substr(1, rest.substr(1).find_first_of(" \t\r\n/>"));
  }
  return {};
}

}  // namespace

std::optional<RobotFormat> robot_format_of(std::string_view text) {
  const std::string_view element = outermost_element(text);
  if (element == "robot") return RobotFormat::urdf;
  if (element == "sdf") return RobotFormat::sdf;
  if (element == "mujoco") return RobotFormat::mjcf;
  return std::nullopt;
}

Result<RobotModel> read_robot_file(std::string_view text, std::string_view file_name, const RobotOptions& options) {
  const std::optional<RobotFormat> format = robot_format_of(text);
  if (!format)
    return fail(ErrorCode::unsupported, std::string(file_name), "The file is no description of a mechanism that is known.",
                "Give URDF (<robot>), SDF (<sdf>) or MJCF (<mujoco>).");
  switch (*format) {
    case RobotFormat::urdf: return read_urdf(text, file_name, options);
    case RobotFormat::sdf: return read_sdf(text, file_name, options);
    case RobotFormat::mjcf: return read_mjcf(text, file_name, options);
  }
  return fail(ErrorCode::unsupported, std::string(file_name), "This format is not known.", "Give URDF, SDF or MJCF.");
}

}  // namespace ugoki::robot_formats
