#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "ugoki/formats/c3d.h"
#include "ugoki/formats/file_axes.h"
#include "ugoki/formats/marker_axes.h"

namespace ugoki::formats {
namespace {

static_assert(std::endian::native == std::endian::little, "values are written as their bytes in memory, which must be little-endian");
constexpr std::size_t block = 512;

/// Returns the low 16 bits of `n`. The words of C3D are signed; a count from 32768 to 65535 has the bits of the unsigned 16-bit value.
std::int16_t low_word(std::int64_t n) { return static_cast<std::int16_t>(static_cast<std::uint16_t>(n & 0xffff)); }

/// Builds the parameter section. A parameter belongs to the group that was added last before it.
class Section {
 public:
  void group(const std::string& name) {
    ++group_;
    begin(name, -group_);
    bytes_.push_back(std::byte{0});  // no description text
    link();
  }
  void real(const std::string& name, std::vector<std::size_t> sizes, const std::vector<float>& values) {
    parameter(name, 4, sizes, values.data(), values.size() * 4);
  }
  void word(const std::string& name, std::vector<std::size_t> sizes, const std::vector<std::int16_t>& values) {
    parameter(name, 2, sizes, values.data(), values.size() * 2);
  }
  /// Adds texts, padded to one common length. A parameter has at most 255 texts; the others follow in NAME2, NAME3 ...
  void texts(const std::string& name, const std::vector<std::string>& values) {
    for (std::size_t part = 0, at = 0; part == 0 || at < values.size(); ++part) {
      const std::size_t count = std::min<std::size_t>(values.size() - at, 255);
      std::size_t length = 1;
      for (std::size_t i = 0; i < count; ++i) length = std::max(length, std::min<std::size_t>(values[at + i].size(), 255));
      length = std::min(length, std::max<std::size_t>(1, 65000 / std::max<std::size_t>(count, 1)));
      std::string all;
      for (std::size_t i = 0; i < count; ++i) {
        std::string text = values[at + i].substr(0, length);
        text.resize(length, ' ');
        all += text;
      }
      parameter(part == 0 ? name : name + std::to_string(part + 1), -1, {length, count}, all.data(), all.size());
      at += count;
    }
  }
  void text(const std::string& name, const std::string& value) { parameter(name, -1, {value.size()}, value.data(), value.size()); }

  /// Returns the bytes of the section, padded to a multiple of 512 bytes. Call once, after all other functions.
  std::vector<std::byte> finish() {
    bytes_.insert(bytes_.end(), 2, std::byte{0});
    bytes_.resize((bytes_.size() + block - 1) / block * block);
    bytes_[0] = std::byte{1};
    bytes_[1] = std::byte{0x50};
    bytes_[2] = static_cast<std::byte>(std::min<std::size_t>(bytes_.size() / block, 255));
    bytes_[3] = std::byte{84};
    return std::move(bytes_);
  }

 private:
  void begin(const std::string& name, int id) {
    bytes_.push_back(static_cast<std::byte>(name.size()));
    bytes_.push_back(static_cast<std::byte>(static_cast<signed char>(id)));
    for (const char c : name) bytes_.push_back(static_cast<std::byte>(c));
    link_ = bytes_.size();
    bytes_.insert(bytes_.end(), 2, std::byte{0});
  }
  void link() {
    const std::size_t distance = bytes_.size() - link_;
    bytes_[link_] = static_cast<std::byte>(distance & 0xff);
    bytes_[link_ + 1] = static_cast<std::byte>(distance >> 8);
  }
  void parameter(const std::string& name, int type, const std::vector<std::size_t>& sizes, const void* data, std::size_t size) {
    begin(name, group_);
    bytes_.push_back(static_cast<std::byte>(static_cast<signed char>(type)));
    bytes_.push_back(static_cast<std::byte>(sizes.size()));
    for (const std::size_t s : sizes) bytes_.push_back(static_cast<std::byte>(s));
    const std::size_t at = bytes_.size();
    bytes_.resize(at + size);
    if (size > 0) std::memcpy(bytes_.data() + at, data, size);
    bytes_.push_back(std::byte{0});  // no description text
    link();
  }

  std::vector<std::byte> bytes_{4};
  std::size_t link_ = 0;
  int group_ = 0;
};

float single(double x) { return static_cast<float>(x); }

void add_analog(Section& section, const MarkerMotion& m) {
  const std::size_t n = m.analog.size();
  section.group("ANALOG");
  section.word("USED", {}, {low_word(static_cast<std::int64_t>(n))});
  section.real("GEN_SCALE", {}, {1});
  section.real("RATE", {}, {single(n == 0 ? m.rate : m.analog_rate)});
  std::vector<std::string> labels, units, descriptions;
  for (const AnalogChannel& c : m.analog) {
    labels.push_back(c.label);
    units.push_back(c.unit);
    descriptions.push_back(c.description);
  }
  section.texts("LABELS", labels);
  section.texts("UNITS", units);
  section.texts("DESCRIPTIONS", descriptions);
  const std::size_t listed = std::min<std::size_t>(n, 255);
  section.real("SCALE", {listed}, std::vector<float>(listed, 1));
  section.word("OFFSET", {listed}, std::vector<std::int16_t>(listed, 0));
}

void add_plates(Section& section, const MarkerMotion& m, const FileAxes& axes, double metres) {
  section.group("FORCE_PLATFORM");
  const std::size_t n = std::min<std::size_t>(m.plates.size(), 64);
  std::size_t rows = 6;
  bool calibrated = false;
  for (std::size_t i = 0; i < n; ++i) {
    rows = std::max(rows, m.plates[i].channels.size());
    calibrated = calibrated || m.plates[i].calibration.size() == 36;
  }
  std::vector<std::int16_t> types, channels;
  std::vector<float> corners, origins, calibration;
  for (std::size_t i = 0; i < n; ++i) {
    const ForcePlate& p = m.plates[i];
    types.push_back(low_word(p.type));
    for (const Vec3& c : p.corners)
      for (int k = 0; k < 3; ++k) corners.push_back(single((axes.to_file(c) / metres)[k]));
    for (int k = 0; k < 3; ++k) origins.push_back(single(p.origin[k] / metres));
    for (std::size_t k = 0; k < rows; ++k) channels.push_back(low_word(k < p.channels.size() ? p.channels[k] + 1 : 0));
    for (std::size_t c = 0; c < 6 && calibrated; ++c)
      for (std::size_t r = 0; r < 6; ++r) calibration.push_back(p.calibration.size() == 36 ? single(p.calibration[6 * r + c]) : 0.0f);
  }
  section.word("USED", {}, {low_word(static_cast<std::int64_t>(n))});
  section.word("TYPE", {n}, types);
  section.real("CORNERS", {3, 4, n}, corners);
  section.real("ORIGIN", {3, n}, origins);
  section.word("CHANNEL", {rows, n}, channels);
  section.word("ZERO", {2}, {1, 0});
  if (calibrated) section.real("CAL_MATRIX", {6, 6, n}, calibration);
}

void add_events(Section& section, const MarkerMotion& m) {
  const std::size_t n = std::min<std::size_t>(m.events.size(), 255);
  std::vector<float> times;
  std::vector<std::string> labels, contexts;
  for (std::size_t i = 0; i < n; ++i) {
    const double minutes = std::floor(m.events[i].time / 60);
    times.push_back(single(minutes));
    times.push_back(single(m.events[i].time - 60 * minutes));
    labels.push_back(m.events[i].label);
    contexts.push_back(m.events[i].context);
  }
  section.group("EVENT");
  section.word("USED", {}, {low_word(static_cast<std::int64_t>(n))});
  section.texts("CONTEXTS", contexts);
  section.texts("LABELS", labels);
  section.real("TIMES", {2, n}, times);
}

std::vector<std::byte> make_parameters(const MarkerMotion& m, const FileAxes& axes, double metres) {
  Section section;
  const std::int64_t last = std::int64_t{m.first_frame} + m.frames - 1;
  section.group("TRIAL");
  section.word("ACTUAL_START_FIELD", {2}, {low_word(m.first_frame), low_word(m.first_frame >> 16)});
  section.word("ACTUAL_END_FIELD", {2}, {low_word(last), low_word(last >> 16)});
  section.group("POINT");
  section.word("USED", {}, {low_word(static_cast<std::int64_t>(m.labels.size()))});
  section.real("SCALE", {}, {-0.1f});
  section.real("RATE", {}, {single(m.rate)});
  section.word("FRAMES", {}, {low_word(std::min(m.frames, 65535))});
  section.text("UNITS", std::string(name_of_unit(metres)));
  section.text("X_SCREEN", axes.z_up ? "+Y" : "+X");
  section.text("Y_SCREEN", axes.z_up ? "+Z" : "+Y");
  section.texts("LABELS", m.labels);
  add_analog(section, m);
  if (!m.plates.empty()) add_plates(section, m, axes, metres);
  if (!m.events.empty()) add_events(section, m);
  // The section contains the block number of the data, which depends on the section's own length. A trial copy gives this length.
  Section trial = section;
  trial.word("DATA_START", {}, {0});
  const std::size_t blocks = trial.finish().size() / block;
  section.word("DATA_START", {}, {low_word(static_cast<std::int64_t>(blocks) + 2)});
  return section.finish();
}

}  // namespace

Result<std::vector<std::byte>> write_c3d(const MarkerMotion& m, const C3dWriteOptions& options) {
  double metres = options.metres_per_unit > 0 ? options.metres_per_unit : m.unit;
  if (name_of_unit(metres).empty()) metres = 0.001;
  const FileAxes axes{options.z_up};
  const std::size_t per_frame = static_cast<std::size_t>(m.samples_per_frame());
  if (m.labels.size() > 65535 || m.analog.size() * per_frame > 65535)
    return fail(ErrorCode::range, m.name,
                "The recording has " + std::to_string(m.labels.size()) + " markers and " + std::to_string(m.analog.size() * per_frame) +
                    " analog samples in a frame; a C3D file holds at most 65535 of each.",
                "Remove markers or channels.");
  const std::vector<std::byte> parameters = make_parameters(m, axes, metres);
  if (parameters.size() / block > 255)
    return fail(ErrorCode::range, m.name,
                "The parameter section has " + std::to_string(parameters.size()) + " bytes; a C3D file holds at most 130560.",
                "Shorten the labels and descriptions.");
  std::vector<std::byte> out(block + parameters.size());
  const auto word = [&](std::size_t number, std::int64_t value) {
    const std::int16_t w = low_word(value);
    std::memcpy(out.data() + 2 * (number - 1), &w, 2);
  };
  const auto real = [&](std::size_t number, float value) { std::memcpy(out.data() + 2 * (number - 1), &value, 4); };
  out[0] = std::byte{2};
  out[1] = std::byte{0x50};
  word(2, static_cast<std::int64_t>(m.labels.size()));
  word(3, static_cast<std::int64_t>(m.analog.size() * per_frame));
  word(4, std::min(m.first_frame, 65535));
  word(5, std::min<std::int64_t>(std::int64_t{m.first_frame} + m.frames - 1, 65535));
  real(7, -0.1f);
  word(9, static_cast<std::int64_t>(parameters.size() / block) + 2);
  word(10, static_cast<std::int64_t>(per_frame));
  real(11, single(m.rate));
  std::memcpy(out.data() + block, parameters.data(), parameters.size());
  const std::size_t floats = 4 * m.labels.size() + m.analog.size() * per_frame;
  std::vector<float> frame(floats);
  out.reserve(out.size() + static_cast<std::size_t>(m.frames) * floats * 4);
  for (int f = 0; f < m.frames; ++f) {
    float* p = frame.data();
    for (int i = 0; i < m.marker_count(); ++i) {
      const Vec3 x = axes.to_file(m.at(f, i)) / metres;
      const double residual = static_cast<double>(m.residuals[m.index(f, i)]);
      const double units = std::round(residual / metres / static_cast<double>(0.1f));
      *p++ = single(x.x), *p++ = single(x.y), *p++ = single(x.z);
      *p++ = residual < 0 ? -1.0f : single(std::min(units, 255.0));
    }
    const double* sample = m.samples.data() + static_cast<std::size_t>(f) * per_frame * m.analog.size();
    for (std::size_t i = 0; i < per_frame * m.analog.size(); ++i) *p++ = single(sample[i]);
    const auto* bytes = reinterpret_cast<const std::byte*>(frame.data());
    out.insert(out.end(), bytes, bytes + floats * 4);
  }
  out.resize((out.size() + block - 1) / block * block);
  return out;
}

}  // namespace ugoki::formats
