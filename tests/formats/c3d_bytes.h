#pragma once
// Builds C3D files byte by byte for tests, following the C3D user guide, independently of the reader and writer under test.

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace ugoki {

/// Options of a small C3D file; finish() returns its bytes.
struct C3dBytes {
  enum class Kind { intel = 84, dec = 85, mips = 86 };
  Kind kind = Kind::intel;
  bool real = true;              ///< floating-point data; otherwise 16-bit integers
  bool unsigned_analog = false;  ///< analog samples are unsigned 16-bit integers with the value 40000
  bool not_a_number = false;     ///< marker 0 has x = NaN in frame 0
  std::string units = "mm", y_screen = "+Z";

  static C3dBytes sample(Kind kind, bool real) {
    C3dBytes file;
    file.kind = kind;
    file.real = real;
    return file;
  }

  /// The file: two markers, two analog channels of two samples in each frame, three frames numbered from 5, 50 Hz, two events, one force
  /// platform. Marker i of frame f is at (10 f + 100 i, -20 f, 900 + 100 i) mm; marker 1 is not seen in frame 1.
  [[nodiscard]] std::vector<std::byte> finish() const {
    std::vector<std::byte> p(4);
    p[0] = std::byte{1};
    p[1] = std::byte{0x50};
    p[3] = static_cast<std::byte>(kind);
    group(p, 1, "Point");
    numbers(p, 1, "USED", 2, {}, {2});
    numbers(p, 1, "SCALE", 4, {}, {scale()});
    numbers(p, 1, "RATE", 4, {}, {50});
    numbers(p, 1, "FRAMES", 2, {}, {3});
    text(p, 1, "UNITS", {int(units.size())}, units);
    text(p, 1, "Y_SCREEN", {2}, y_screen);
    text(p, 1, "LABELS", {8, 2}, "LASI    RASI    ");
    group(p, 2, "ANALOG");
    numbers(p, 2, "USED", 2, {}, {2});
    numbers(p, 2, "GEN_SCALE", 4, {}, {3});
    numbers(p, 2, "SCALE", 4, {2}, {0.5, 2});
    numbers(p, 2, "OFFSET", 2, {2}, {10, 10});
    text(p, 2, "LABELS", {2, 2}, "FzMx");
    text(p, 2, "UNITS", {2, 2}, "N Nm");
    if (unsigned_analog) text(p, 2, "FORMAT", {8}, "UNSIGNED");
    group(p, 3, "EVENT");
    numbers(p, 3, "USED", 2, {}, {2});
    text(p, 3, "LABELS", {11, 2}, "Foot Off   Foot Strike");
    text(p, 3, "CONTEXTS", {5, 2}, "RightLeft ");
    numbers(p, 3, "TIMES", 4, {2, 2}, {1, 1.5, 0, 0.25});
    group(p, 4, "FORCE_PLATFORM");
    numbers(p, 4, "USED", 2, {}, {1});
    numbers(p, 4, "TYPE", 2, {1}, {2});
    numbers(p, 4, "CORNERS", 4, {3, 4, 1}, {500, 700, 0, 400, 700, 0, 400, 600, 0, 500, 600, 0});
    numbers(p, 4, "ORIGIN", 4, {3, 1}, {0, 0, -40});
    numbers(p, 4, "CHANNEL", 2, {6, 1}, {1, 2, 1, 2, 1, 2});
    p.insert(p.end(), 2, std::byte{0});
    while (p.size() % 512 != 0) p.push_back(std::byte{0});
    p[2] = static_cast<std::byte>(p.size() / 512);

    std::vector<std::byte> out;
    out.push_back(std::byte{2});
    out.push_back(std::byte{0x50});
    for (const int w : {2, 4, 5, 7, 0}) word(out, w);  // markers, analog values per frame, first and last frame, maximum gap
    number(out, scale());
    word(out, 2 + static_cast<int>(p.size() / 512));
    word(out, 2);
    number(out, 50);
    out.resize(512);
    out.insert(out.end(), p.begin(), p.end());
    for (int f = 0; f < 3; ++f) add_frame(out, f);
    while (out.size() % 512 != 0) out.push_back(std::byte{0});
    return out;
  }

 private:
  [[nodiscard]] double scale() const { return real ? -0.5 : 0.5; }

  void add_frame(std::vector<std::byte>& out, int f) const {
    for (int i = 0; i < 2; ++i) {
      const bool hidden = f == 1 && i == 1;
      double x = 10.0 * f + 100 * i;
      if (not_a_number && f == 0 && i == 0) x = std::numeric_limits<double>::quiet_NaN();
      for (const double c : {x, -20.0 * f, 900.0 + 100 * i}) real ? number(out, c) : word(out, static_cast<int>(c / 0.5));
      const int state = hidden ? -1 : f + 1;
      real ? number(out, state) : word(out, state);
    }
    for (int s = 0; s < 2; ++s)
      for (int c = 0; c < 2; ++c) {
        const int raw = unsigned_analog ? 40000 : 100 * (2 * f + s) + c;
        real ? number(out, raw) : word(out, raw);
      }
  }

  void word(std::vector<std::byte>& out, int value) const {
    const auto low = static_cast<std::byte>(value & 0xff), high = static_cast<std::byte>(value >> 8 & 0xff);
    out.push_back(kind == Kind::mips ? high : low);
    out.push_back(kind == Kind::mips ? low : high);
  }

  void number(std::vector<std::byte>& out, double value) const {
    std::uint32_t bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
    if (kind == Kind::dec && value != 0 && std::isfinite(value))
      bits += 2U << 23;  // a DEC value is a quarter of the IEEE value of the same bits
    const auto b = [&](int k) { out.push_back(static_cast<std::byte>(bits >> (8 * k) & 0xff)); };
    if (kind == Kind::intel) b(0), b(1), b(2), b(3);
    if (kind == Kind::mips) b(3), b(2), b(1), b(0);
    if (kind == Kind::dec) b(2), b(3), b(0), b(1);
  }

  void head(std::vector<std::byte>& out, int id, const std::string& name, std::size_t rest) const {
    out.push_back(static_cast<std::byte>(name.size()));
    out.push_back(static_cast<std::byte>(static_cast<signed char>(id)));
    for (const char c : name) out.push_back(static_cast<std::byte>(c));
    word(out, static_cast<int>(rest) + 2);
  }
  void group(std::vector<std::byte>& out, int id, const std::string& name) const {
    head(out, -id, name, 5);
    out.push_back(std::byte{4});
    for (const char c : std::string("note")) out.push_back(static_cast<std::byte>(c));
  }
  void numbers(std::vector<std::byte>& out, int id, const std::string& name, int type, const std::vector<int>& sizes,
               const std::vector<double>& values) const {
    head(out, id, name, 3 + sizes.size() + values.size() * static_cast<std::size_t>(type));
    out.push_back(static_cast<std::byte>(type));
    out.push_back(static_cast<std::byte>(sizes.size()));
    for (const int s : sizes) out.push_back(static_cast<std::byte>(s));
    for (const double v : values) type == 4 ? number(out, v) : word(out, static_cast<int>(v));
    out.push_back(std::byte{0});
  }
  void text(std::vector<std::byte>& out, int id, const std::string& name, const std::vector<int>& sizes, const std::string& value) const {
    head(out, id, name, 3 + sizes.size() + value.size());
    out.push_back(std::byte{0xff});
    out.push_back(static_cast<std::byte>(sizes.size()));
    for (const int s : sizes) out.push_back(static_cast<std::byte>(s));
    for (const char c : value) out.push_back(static_cast<std::byte>(c));
    out.push_back(std::byte{0});
  }
};

}  // namespace ugoki
