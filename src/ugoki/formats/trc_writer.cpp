#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/formats/file_axes.h"
#include "ugoki/formats/marker_axes.h"
#include "ugoki/formats/trc.h"

namespace ugoki::formats {

std::string write_trc(const MarkerMotion& motion, const TrcWriteOptions& options) {
  double metres = options.metres_per_unit > 0 ? options.metres_per_unit : motion.unit;
  if (name_of_unit(metres).empty()) metres = 0.001;
  const FileAxes axes{options.z_up};
  const int decimals = std::clamp(options.decimals, 1, 15);
  const std::string frames = std::to_string(motion.frames), rate = to_text(motion.rate), first = std::to_string(motion.first_frame);
  std::string out = "PathFileType\t4\t(X/Y/Z)\t" + motion.name + ".trc\n";
  out += "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n";
  out += rate + '\t' + rate + '\t' + frames + '\t' + std::to_string(motion.labels.size()) + '\t' + std::string(name_of_unit(metres)) +
         '\t' + rate + '\t' + first + '\t' + frames + "\nFrame#\tTime";
  for (std::size_t i = 0; i < motion.labels.size(); ++i) {
    std::string name = motion.labels[i];
    for (char& c : name) c = c == '\t' || c == '\n' || c == '\r' ? ' ' : c;
    if (name.find_first_not_of(' ') == std::string::npos) name = "*" + std::to_string(i);  // readers skip columns without a name
    out += '\t' + name + "\t\t";
  }
  out += "\n\t";
  for (std::size_t i = 1; i <= motion.labels.size(); ++i) {
    const std::string n = std::to_string(i);
    out += "\tX" + n + "\tY" + n + "\tZ" + n;
  }
  out += "\n\n";
  for (int f = 0; f < motion.frames; ++f) {
    out += std::to_string(motion.first_frame + f) + '\t' + to_fixed((motion.first_frame + f - 1) / motion.rate, 6);
    for (int i = 0; i < motion.marker_count(); ++i) {
      if (!motion.seen(f, i)) {
        out += "\t\t\t";
        continue;
      }
      const Vec3 x = axes.to_file(motion.at(f, i)) / metres;
      for (int k = 0; k < 3; ++k) out += '\t' + to_fixed(x[k], decimals);
    }
    out += '\n';
  }
  return out;
}

}  // namespace ugoki::formats
