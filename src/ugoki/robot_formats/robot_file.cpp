#include "ugoki/robot_formats/robot_file.h"

#include <string>

#include "ugoki/robot_formats/mjcf.h"
#include "ugoki/robot_formats/osim.h"
#include "ugoki/robot_formats/sdf.h"
#include "ugoki/robot_formats/urdf.h"

namespace ugoki::robot_formats {
namespace {

/// Returns the name of the root element; empty if there is none.
std::string_view root_element(std::string_view text) {
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
  const std::string_view element = root_element(text);
  if (element == "robot") return RobotFormat::urdf;
  if (element == "sdf") return RobotFormat::sdf;
  if (element == "mujoco") return RobotFormat::mjcf;
  if (element == "OpenSimDocument") return RobotFormat::osim;
  return std::nullopt;
}

Result<RobotModel> read_robot_file(std::string_view text, std::string_view file_name, const RobotOptions& options) {
  const std::optional<RobotFormat> format = robot_format_of(text);
  if (!format)
    return fail(ErrorCode::unsupported, std::string(file_name), "The file is not a robot description of a known format.",
                "Use URDF (<robot>), SDF (<sdf>), MJCF (<mujoco>) or an OpenSim model (<OpenSimDocument>).");
  switch (*format) {
    case RobotFormat::urdf: return read_urdf(text, file_name, options);
    case RobotFormat::sdf: return read_sdf(text, file_name, options);
    case RobotFormat::mjcf: return read_mjcf(text, file_name, options);
    case RobotFormat::osim: return read_osim(text, file_name, options);
  }
  return fail(ErrorCode::unsupported, std::string(file_name), "The format is unknown.", "Use URDF, SDF or MJCF.");
}

}  // namespace ugoki::robot_formats
