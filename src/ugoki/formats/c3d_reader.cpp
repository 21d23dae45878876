#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "ugoki/formats/c3d.h"
#include "ugoki/formats/c3d_parameters.h"
#include "ugoki/formats/marker_axes.h"
#include "ugoki/formats/text.h"

namespace ugoki::formats {
namespace {

constexpr const char* again = "Export or copy the file again.";
constexpr std::size_t block = 512;

std::string upper(std::string text) {
  for (char& c : text)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return text;
}

/// Size and format of the data section, from the header and the parameters.
struct Layout {
  std::size_t frames = 0, points = 0, channels = 0, samples = 0;  // samples: per analog channel and frame
  std::size_t start = 0;                                          // offset of the first byte of the data
  int first_frame = 1;
  double rate = 0;    // frames per second
  double scale = 0;   // file units per integer step; negative: floating-point data
  bool real = false;  // the data are floating point

  [[nodiscard]] std::size_t frame_bytes() const { return (4 * points + channels * samples) * (real ? 4 : 2); }
};

class Reader {
 public:
  Reader(std::span<const std::byte> file, std::string_view name, const MarkerOptions& options, ReadNotes& notes)
      : file_(file), name_(name), options_(options), notes_(notes) {}

  Result<MarkerMotion> read() {
    if (file_.size() < block)
      return fail(file_.empty() ? ErrorCode::truncated : ErrorCode::syntax, location("header"),
                  "This is not a C3D file: it has fewer than 512 bytes.", again);
    if (byte(1) != 0x50)
      return fail(ErrorCode::syntax, location("header"), "This is not a C3D file: its second byte is not 80.",
                  "Check the type of the file.");
    if (byte(0) == 0) return fail(ErrorCode::structure, location("header"), "The block number of the parameter section is 0.", again);
    auto parameters = C3dParameters::read(file_, (byte(0) - 1) * block, name_);
    if (!parameters) return fail(std::move(parameters.error()));
    parameters_ = std::move(*parameters);
    if (auto problem = lay_out(); !problem.empty()) return fail(std::move(problem));
    motion_.name = stem_of(name_);
    motion_.source = std::string(name_);
    motion_.rate = layout_.rate;
    motion_.frames = static_cast<int>(layout_.frames);
    motion_.first_frame = layout_.first_frame;
    read_labels();
    read_analog();
    read_plates();
    if (auto problem = read_frames(); !problem.empty()) return fail(std::move(problem));
    drop_quantities();
    read_events();
    if (!finish_axes())
      return fail(ErrorCode::range, location("data"), "A marker is farther than 1e9 m from the origin.", "Set the correct unit of length.");
    return std::move(motion_);
  }

 private:
  [[nodiscard]] std::string location(const std::string& part) const { return std::string(name_) + ": " + part; }
  [[nodiscard]] std::size_t byte(std::size_t at) const { return std::to_integer<std::size_t>(file_[at]); }
  [[nodiscard]] std::size_t header_word(std::size_t number) const { return numbers().word(file_.data() + 2 * (number - 1)); }
  [[nodiscard]] double header_real(std::size_t number) const {
    return static_cast<double>(numbers().real(file_.data() + 2 * (number - 1)));
  }
  [[nodiscard]] const C3dNumbers& numbers() const { return parameters_.numbers(); }

  /// Reads a 32-bit value that the group TRIAL stores in two words, low word first; 0 if it is missing.
  [[nodiscard]] double field(std::string_view name) const {
    const std::vector<double> v = parameters_.values("TRIAL", name);
    if (v.size() < 2) return 0;
    return (v[0] < 0 ? v[0] + 65536 : v[0]) + 65536 * (v[1] < 0 ? v[1] + 65536 : v[1]);
  }

  Error lay_out() {
    const auto used = parameters_.count("POINT", "USED");
    const std::size_t in_header = header_word(2);
    layout_.points = used && *used >= 0 && *used <= 65535 ? static_cast<std::size_t>(*used) : in_header;
    if (layout_.points != in_header && in_header != 0) {
      notes_.remarks.push_back("The header specifies " + std::to_string(in_header) + " markers, but POINT:USED is " +
                               std::to_string(layout_.points) + "; the header is assumed to be right.");
      layout_.points = in_header;
    }
    layout_.scale = header_real(7);
    if (!std::isfinite(layout_.scale) || layout_.scale == 0) layout_.scale = parameters_.value("POINT", "SCALE", -1);
    if (!std::isfinite(layout_.scale) || layout_.scale == 0)
      return {ErrorCode::range, location("POINT:SCALE"), "The scale is zero or not finite.", again};
    layout_.real = layout_.scale < 0;
    layout_.rate = header_real(11);
    if (!(layout_.rate > 0) || !std::isfinite(layout_.rate)) layout_.rate = parameters_.value("POINT", "RATE", 0);
    if (!(layout_.rate > 1e-3 && layout_.rate < 1e6))
      return {ErrorCode::range, location("POINT:RATE"), "The frame rate is not between 0.001 and 1e6 frames per second.",
              "Correct the rate in the program that wrote the file."};
    count_frames();
    const std::size_t measurements = header_word(3);
    const auto channels = parameters_.count("ANALOG", "USED");
    layout_.samples = measurements == 0 ? 0 : std::max<std::size_t>(header_word(10), 1);
    layout_.channels = layout_.samples == 0 ? 0 : measurements / layout_.samples;
    if (layout_.channels * layout_.samples != measurements)
      return {ErrorCode::structure, location("header"),
              std::to_string(measurements) + " analog measurements in a frame are not a multiple of " + std::to_string(layout_.samples) +
                  " samples.",
              again};
    if (channels && static_cast<std::size_t>(std::clamp(*channels, 0.0, 65535.0)) != layout_.channels)
      notes_.remarks.push_back("ANALOG:USED disagrees with the header; the " + std::to_string(layout_.channels) +
                               " channels of the header are read.");
    std::size_t first_block = header_word(9);
    if (first_block < 2)
      first_block = static_cast<std::size_t>(std::clamp(parameters_.count("POINT", "DATA_START").value_or(0), 0.0, 65535.0));
    if (first_block < 2) return {ErrorCode::structure, location("header"), "The block number of the data section is missing.", again};
    layout_.start = (first_block - 1) * block;
    return check_size();
  }

  /// The header counts frames in 16 bits. Longer recordings store first and last frame in TRIAL, or the number of frames in POINT:FRAMES.
  void count_frames() {
    const std::size_t first = header_word(4), last = header_word(5);
    layout_.first_frame = static_cast<int>(first);
    std::size_t frames = last >= first ? last - first + 1 : 0;
    const double actual_first = field("ACTUAL_START_FIELD"), actual_last = field("ACTUAL_END_FIELD");
    const double point_frames = parameters_.count("POINT", "FRAMES").value_or(0);
    if (actual_last >= actual_first && actual_first >= 0 && actual_last > 0 && actual_last < 2e9) {
      frames = static_cast<std::size_t>(actual_last - actual_first) + 1;
      layout_.first_frame = static_cast<int>(actual_first);
    } else if ((frames == 0 || last == 65535) && point_frames > static_cast<double>(frames) && point_frames < 2e9) {
      frames = static_cast<std::size_t>(point_frames);
    }
    layout_.frames = frames;
  }

  Error check_size() {
    if (layout_.frames == 0) return {ErrorCode::structure, location("header"), "The file has no frames.", again};
    if (layout_.points == 0 && layout_.channels == 0)
      return {ErrorCode::structure, location("header"), "The file has neither markers nor analog channels.", again};
    const std::size_t bytes = layout_.frame_bytes();
    const std::size_t complete = layout_.start < file_.size() ? (file_.size() - layout_.start) / bytes : 0;
    // Programs that crop a recording may leave the frame numbers in TRIAL unchanged; then only the header's frame numbers match the data.
    const std::size_t in_header = header_word(5) >= header_word(4) ? header_word(5) - header_word(4) + 1 : 0;
    if (complete < layout_.frames && in_header > 0 && in_header < layout_.frames && complete >= in_header) {
      layout_.frames = in_header;
      layout_.first_frame = static_cast<int>(header_word(4));
    }
    if (complete < layout_.frames)
      return {ErrorCode::truncated, location("data"),
              "The file declares " + std::to_string(layout_.frames) + " frames of " + std::to_string(bytes) + " bytes, but ends after " +
                  std::to_string(complete) + " frames.",
              again};
    if (layout_.frames > max_numbers / (4 * layout_.points + layout_.channels * layout_.samples))
      return {ErrorCode::range, location("data"), "The recording has more than 400 million numbers.", "Split it into several files."};
    return {};
  }

  void read_labels() {
    motion_.labels = parameters_.texts("POINT", "LABELS");
    motion_.labels.resize(layout_.points);
    std::size_t nameless = 0;
    for (std::size_t i = 0; i < layout_.points; ++i) {
      std::string& label = motion_.labels[i];
      if (label.empty()) {
        label = "*" + std::to_string(i);
        ++nameless;
      }
    }
    drop_common_prefix();
    std::vector<std::string> sorted = motion_.labels;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) make_unique_labels();
    if (nameless > 0) notes_.remarks.push_back(std::to_string(nameless) + " markers have no label; they were named '*' and their index.");
  }

  /// Leaves out points that are no positions. Programs store joint angles, forces, moments and powers as points, and list them in the
  /// parameters of the same names.
  void drop_quantities() {
    const auto plain = [](const std::string& label) { return label.substr(label.rfind(':') + 1); };
    std::set<std::string> listed;
    for (const char* kind : {"ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS"})
      for (const std::string& label : parameters_.texts("POINT", kind))
        if (!label.empty()) listed.insert(plain(label));
    const auto is_quantity = [&](const std::string& label) {
      constexpr std::string_view endings[] = {"Angles", "Force", "Moment", "Power", "GroundReactionForce"};
      return listed.contains(plain(label)) || std::ranges::any_of(endings, [&](std::string_view e) { return label.ends_with(e); });
    };
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < motion_.labels.size(); ++i)
      if (!is_quantity(motion_.labels[i])) kept.push_back(i);
    const std::size_t all = motion_.labels.size();
    if (kept.size() == all || kept.empty()) return;
    const auto frames = static_cast<std::size_t>(motion_.frames);
    for (std::size_t f = 0; f < frames; ++f)
      for (std::size_t k = 0; k < kept.size(); ++k) {
        motion_.positions[f * kept.size() + k] = motion_.positions[f * all + kept[k]];
        motion_.residuals[f * kept.size() + k] = motion_.residuals[f * all + kept[k]];
      }
    motion_.positions.resize(frames * kept.size());
    motion_.residuals.resize(frames * kept.size());
    std::vector<std::string> labels;
    for (const std::size_t i : kept) labels.push_back(std::move(motion_.labels[i]));
    motion_.labels = std::move(labels);
    notes_.remarks.push_back(std::to_string(all - kept.size()) +
                             " points are angles, forces, moments or powers instead of positions; they are left out.");
  }

  /// Removes the subject's name from labels such as "Subject:LASI" if all labels begin with the same name.
  void drop_common_prefix() {
    if (motion_.labels.empty()) return;
    const std::size_t colon = motion_.labels[0].find(':');
    if (colon == std::string::npos) return;
    const std::string prefix = motion_.labels[0].substr(0, colon + 1);
    std::size_t with = 0, labelled = 0;
    for (const std::string& label : motion_.labels) {
      with += label.starts_with(prefix) && label.size() > prefix.size() ? 1 : 0;
      labelled += label.starts_with("*") ? 0 : 1;
    }
    if (with != labelled) return;
    for (std::string& label : motion_.labels)
      if (label.starts_with(prefix)) label.erase(0, prefix.size());
    notes_.remarks.push_back("The labels' common prefix " + in_quotes(prefix) + " is left out.");
  }

  void make_unique_labels() {
    std::vector<std::pair<std::string, std::size_t>> order;
    for (std::size_t i = 0; i < motion_.labels.size(); ++i) order.emplace_back(motion_.labels[i], i);
    std::sort(order.begin(), order.end());
    std::size_t renamed = 0;
    for (std::size_t i = 1, count = 1; i < order.size(); ++i) {
      count = order[i].first == order[i - 1].first ? count + 1 : 1;
      if (count == 1) continue;
      motion_.labels[order[i].second] = order[i].first + "_" + std::to_string(count);
      ++renamed;
    }
    notes_.remarks.push_back(std::to_string(renamed) +
                             " markers have the same label as another marker and were renamed by an appended number.");
  }

  void read_analog() {
    if (layout_.channels == 0) return;
    motion_.analog_rate = motion_.rate * static_cast<double>(layout_.samples);
    const auto labels = parameters_.texts("ANALOG", "LABELS"), units = parameters_.texts("ANALOG", "UNITS"),
               descriptions = parameters_.texts("ANALOG", "DESCRIPTIONS");
    for (std::size_t i = 0; i < layout_.channels; ++i)
      motion_.analog.push_back({i < labels.size() && !labels[i].empty() ? labels[i] : "channel " + std::to_string(i + 1),
                                i < units.size() ? units[i] : "", i < descriptions.size() ? descriptions[i] : ""});
  }

  void read_plates() {
    const auto count = static_cast<std::size_t>(std::clamp(parameters_.value("FORCE_PLATFORM", "USED", 0), 0.0, 64.0));
    const auto types = parameters_.values("FORCE_PLATFORM", "TYPE"), corners = parameters_.values("FORCE_PLATFORM", "CORNERS"),
               origins = parameters_.values("FORCE_PLATFORM", "ORIGIN"), channels = parameters_.values("FORCE_PLATFORM", "CHANNEL"),
               calibration = parameters_.values("FORCE_PLATFORM", "CAL_MATRIX");
    const C3dParameter* channel = parameters_.find("FORCE_PLATFORM", "CHANNEL");
    const std::size_t rows = channel != nullptr && !channel->sizes.empty() ? static_cast<std::size_t>(channel->sizes[0]) : 6;
    for (std::size_t i = 0; i < count; ++i) {
      if (i >= types.size() || 12 * (i + 1) > corners.size() || 3 * (i + 1) > origins.size() || rows * (i + 1) > channels.size()) {
        notes_.remarks.push_back("The description of force platform " + std::to_string(i + 1) +
                                 " is incomplete; the platform is left out.");
        continue;
      }
      ForcePlate plate;
      plate.type = static_cast<int>(std::clamp(types[i], -1.0, 100.0));
      bool valid = true;
      for (int c = 0; c < 4; ++c)
        for (int k = 0; k < 3; ++k) plate.corners[c][k] = corners[12 * i + static_cast<std::size_t>(3 * c + k)];
      for (int k = 0; k < 3; ++k) plate.origin[k] = origins[3 * i + static_cast<std::size_t>(k)];
      for (const Vec3& c : plate.corners) valid = valid && is_finite(c) && norm(c) < max_magnitude;
      valid = valid && is_finite(plate.origin) && norm(plate.origin) < max_magnitude;
      for (std::size_t k = 0; k < rows; ++k) {
        const double number = channels[rows * i + k];
        if (number == 0 && k >= 6) continue;  // the table has 8 rows if any platform has 8 channels; with 6 channels rows 7 and 8 are 0
        valid = valid && number >= 1 && number <= static_cast<double>(layout_.channels);
        if (valid) plate.channels.push_back(static_cast<int>(number) - 1);
      }
      if (plate.type == 4 && 36 * (i + 1) <= calibration.size())
        for (std::size_t r = 0; r < 6; ++r)  // the file stores the matrix by columns
          for (std::size_t c = 0; c < 6; ++c) plate.calibration.push_back(calibration[36 * i + 6 * c + r]);
      if (valid)
        motion_.plates.push_back(std::move(plate));
      else
        notes_.remarks.push_back("Force platform " + std::to_string(i + 1) + " has invalid corners or channels and is left out.");
    }
  }

  Error read_frames() {
    const std::size_t n = layout_.points, total = layout_.frames * n;
    motion_.positions.resize(total);
    motion_.residuals.resize(total);
    motion_.samples.resize(layout_.frames * layout_.channels * layout_.samples);
    const auto offsets = parameters_.values("ANALOG", "OFFSET"), scales = parameters_.values("ANALOG", "SCALE");
    const double general = parameters_.value("ANALOG", "GEN_SCALE", 1);
    const auto formats = parameters_.texts("ANALOG", "FORMAT");
    const bool is_unsigned = !formats.empty() && upper(formats[0]) == "UNSIGNED";
    const std::size_t size = layout_.real ? 4 : 2;
    std::size_t damaged = 0;
    double* sample = motion_.samples.data();
    for (std::size_t f = 0; f < layout_.frames; ++f) {
      const std::byte* p = file_.data() + layout_.start + f * layout_.frame_bytes();
      for (std::size_t i = 0; i < n; ++i, p += 4 * size) damaged += read_point(p, f * n + i) ? 0 : 1;
      for (std::size_t s = 0; s < layout_.samples; ++s) {
        for (std::size_t c = 0; c < layout_.channels; ++c, p += size) {
          const double raw = layout_.real  ? static_cast<double>(numbers().real(p))
                             : is_unsigned ? static_cast<double>(numbers().word(p))
                                           : numbers().integer(p);
          double offset = c < offsets.size() ? offsets[c] : 0;
          if (is_unsigned && offset < 0) offset += 65536;
          const double value = (raw - offset) * (c < scales.size() ? scales[c] : 1) * general;
          if (!(std::fabs(value) <= 1e30))
            return {ErrorCode::range, location("data"),
                    "Analog channel " + in_quotes(motion_.analog[c].label) + " has a value that is not finite or above 1e30 in frame " +
                        std::to_string(f) + ".",
                    again};
          *sample++ = value;
        }
      }
    }
    if (damaged > 0) notes_.remarks.push_back(std::to_string(damaged) + " positions are not finite numbers; they are marked as not seen.");
    return {};
  }

  /// Reads the position and residual of one marker in one frame. Returns false if a coordinate is not finite or the norm is 1e12 or more.
  /// @param index index in motion_.positions [frames][markers]
  bool read_point(const std::byte* p, std::size_t index) {
    Vec3& x = motion_.positions[index];
    int state = 0;
    if (layout_.real) {
      const auto at = [&](int k) { return static_cast<double>(numbers().real(p + 4 * k)); };
      x = {at(0), at(1), at(2)};
      const double fourth = at(3);
      state = fourth >= -32768 && fourth < 32768 ? static_cast<int>(fourth) : -1;
    } else {
      const auto at = [&](int k) { return layout_.scale * numbers().integer(p + 2 * k); };
      x = {at(0), at(1), at(2)};
      state = numbers().integer(p + 6);
    }
    const bool finite = is_finite(x) && norm(x) < 1e12;
    if (state < 0 || !finite) {
      x = {};
      motion_.residuals[index] = -1;
      return finite;
    }
    motion_.residuals[index] = static_cast<float>((state & 0xff) * std::fabs(layout_.scale));
    return true;
  }

  void read_events() {
    const auto times = parameters_.values("EVENT", "TIMES");
    const auto labels = parameters_.texts("EVENT", "LABELS"), contexts = parameters_.texts("EVENT", "CONTEXTS");
    for (std::size_t i = 0; 2 * i + 1 < times.size(); ++i) {
      const double t = 60 * times[2 * i] + times[2 * i + 1];
      if (std::isfinite(t)) motion_.events.push_back({t, i < labels.size() ? labels[i] : "", i < contexts.size() ? contexts[i] : ""});
    }
    if (motion_.events.empty() && header_word(150) == 12345) {
      const std::size_t count = std::min<std::size_t>(header_word(151), 18);
      for (std::size_t i = 0; i < count; ++i) {
        const double t = header_real(153 + 2 * i);
        std::string_view label(reinterpret_cast<const char*>(file_.data()) + 2 * (199 - 1) + 4 * i, 4);
        while (!label.empty() && (label.back() == ' ' || label.back() == '\0')) label.remove_suffix(1);
        if (std::isfinite(t)) motion_.events.push_back({t, utf8(label), ""});
      }
    }
    std::sort(motion_.events.begin(), motion_.events.end(), [](const MarkedEvent& a, const MarkedEvent& b) {
      return std::tie(a.time, a.label, a.context) < std::tie(b.time, b.label, b.context);
    });
  }

  bool finish_axes() {
    const auto screen = parameters_.texts("POINT", "Y_SCREEN"), units = parameters_.texts("POINT", "UNITS");
    UpAxis file_up = UpAxis::automatic;
    if (!screen.empty() && (upper(screen[0]) == "+Z" || upper(screen[0]) == "Z")) file_up = UpAxis::z;
    if (!screen.empty() && (upper(screen[0]) == "+Y" || upper(screen[0]) == "Y")) file_up = UpAxis::y;
    double metres = 0;
    if (!units.empty() && !units[0].empty()) {
      if (const auto known = metres_of(units[0]))
        metres = *known;
      else
        notes_.remarks.push_back("The unit of length " + in_quotes(units[0]) + " is not known.");
    }
    return to_our_axes(motion_, options_, file_up, metres, notes_);
  }

  std::span<const std::byte> file_;
  std::string_view name_;
  const MarkerOptions& options_;
  ReadNotes& notes_;
  C3dParameters parameters_;
  Layout layout_;
  MarkerMotion motion_;
};

}  // namespace

Result<MarkerMotion> read_c3d(std::span<const std::byte> bytes, std::string_view file_name, const MarkerOptions& options,
                              ReadNotes* notes) {
  ReadNotes own;
  return Reader(bytes, file_name, options, notes != nullptr ? *notes : own).read();
}

}  // namespace ugoki::formats
