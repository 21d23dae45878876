#pragma once
// Measured data without a skeleton: positions of markers over time, and the analog channels, force platforms and events recorded with them.
// Metres, seconds, Z up, X forward.

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "ugoki/spatial/vec3.h"

namespace ugoki {

/// Description of one analog channel. Its samples are in the calibrated unit.
struct AnalogChannel {
  std::string label;
  std::string unit;         ///< as written in the file: "N", "Nmm", "V"
  std::string description;  ///< may be empty
};

/// A moment that was marked in a recording, for example "Left Foot Strike".
struct MarkedEvent {
  double time = 0;      ///< s since the start of the recording; frame index i is at (first_frame - 1 + i) / rate
  std::string label;    ///< "Foot Strike"
  std::string context;  ///< "Left"; may be empty
};

/// A force platform as described in C3D files.
struct ForcePlate {
  int type = 2;     ///< C3D type: 1 force and centre of pressure, 2 and 4 force and moment, 3 eight sensors
  Vec3 corners[4];  ///< m, world; order of the quadrants in the plate's axes: +x +y, -x +y, -x -y, +x -y
  Vec3 origin;      ///< m, plate's axes; types 2, 4: sensor position from the centre of the surface; type 3: sensor distances a, b, depth
  std::vector<int> channels;        ///< indices into MarkerMotion::analog
  std::vector<double> calibration;  ///< [6][6] row-major calibration matrix of type 4; otherwise empty
};

/// A recording of markers.
struct MarkerMotion {
  std::string name;
  std::string source;               ///< file name as read
  std::vector<std::string> labels;  ///< [markers] names of the markers
  double unit = 1;                  ///< m per length unit of the file
  double rate = 100;                ///< frames per second
  int frames = 0;
  int first_frame = 1;           ///< number of the first frame in the recording, counted from 1
  std::vector<Vec3> positions;   ///< [frames][markers] m; zero where the marker was not seen
  std::vector<float> residuals;  ///< [frames][markers] m, residual of the reconstruction from the cameras; -1 if the marker was not seen

  double analog_rate = 0;             ///< samples per second, an integer multiple of `rate`; 0 without channels
  std::vector<AnalogChannel> analog;  ///< [channels]
  std::vector<double> samples;        ///< [frames * analog_rate / rate][channels] in calibrated units

  std::vector<ForcePlate> plates;
  std::vector<MarkedEvent> events;

  [[nodiscard]] int marker_count() const { return static_cast<int>(labels.size()); }
  [[nodiscard]] double duration() const { return frames > 1 ? (frames - 1) / rate : 0; }
  [[nodiscard]] int samples_per_frame() const { return analog.empty() ? 0 : static_cast<int>(std::lround(analog_rate / rate)); }
  [[nodiscard]] bool seen(int frame, int marker) const { return residuals[index(frame, marker)] >= 0; }
  [[nodiscard]] const Vec3& at(int frame, int marker) const { return positions[index(frame, marker)]; }
  [[nodiscard]] std::size_t index(int frame, int marker) const {
    return static_cast<std::size_t>(frame) * labels.size() + static_cast<std::size_t>(marker);
  }
  /// Index of the marker with this label; -1 if there is none.
  [[nodiscard]] int find(const std::string& label) const;
};

/// Fraction of the frames * markers positions that were seen, 0 to 1.
[[nodiscard]] double seen_share(const MarkerMotion& motion);

}  // namespace ugoki
