// Real C3D recordings, rewritten in the byte orders of the other processors and as integers, are read as the same recordings.
#include <bit>
#include <cmath>
#include <cstdint>

#include "shared_files.h"
#include "ugoki/formats/c3d.h"

namespace ugoki {
namespace {

enum class Processor : std::uint8_t { intel = 84, dec = 85, mips = 86 };

/// Rewrites an Intel floating-point file in another form. Implemented independently of the reader, from the C3D user's guide.
class Rewritten {
 public:
  /// @param scale file units per integer step; 0: keep floating point
  Rewritten(std::string bytes, Processor processor, float scale) : b_(std::move(bytes)), processor_(processor), scale_(scale) {
    parameters_ = 512 * (byte(0) - 1);
    data_ = 512 * (intel_word(16) - 1);
    markers_ = intel_word(2);
    frames_ = intel_word(8) - intel_word(6) + 1;
    EXPECT_EQ(byte(parameters_ + 3), 84u) << "the file should be in Intel byte order";
    EXPECT_LT(intel_real(12), 0) << "the file should be in floating point";
    EXPECT_EQ(intel_word(4), 0u) << "files with analog data cannot be rewritten here";
    rewrite_data();
    rewrite_parameters();
    rewrite_header();
  }
  [[nodiscard]] const std::string& bytes() const { return b_; }

 private:
  [[nodiscard]] std::size_t byte(std::size_t at) const { return static_cast<unsigned char>(b_.at(at)); }
  [[nodiscard]] std::size_t intel_word(std::size_t at) const { return byte(at) | byte(at + 1) << 8; }
  [[nodiscard]] float intel_real(std::size_t at) const {
    return std::bit_cast<float>(static_cast<std::uint32_t>(intel_word(at) | intel_word(at + 2) << 16));
  }
  void put(std::size_t at, std::size_t value) { b_.at(at) = static_cast<char>(value & 0xff); }
  void put_word(std::size_t at, std::size_t value) {
    const bool big = processor_ == Processor::mips;
    put(at + (big ? 1 : 0), value);
    put(at + (big ? 0 : 1), value >> 8);
  }
  /// Encodes a DEC (VAX) float: exponent bias larger by two, upper 16-bit word first.
  void put_real(std::size_t at, float value) {
    std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
    if (processor_ == Processor::dec && value != 0) bits = std::bit_cast<std::uint32_t>(value * 4);
    const bool upper_first = processor_ != Processor::intel;
    put_word(at + (upper_first ? 2 : 0), bits);
    put_word(at + (upper_first ? 0 : 2), bits >> 16);
  }

  void rewrite_data() {
    std::size_t out = data_;
    for (std::size_t i = 0; i < 4 * markers_ * frames_; ++i) {
      const float value = intel_real(data_ + 4 * i);
      if (scale_ > 0) {
        const double whole = i % 4 == 3 ? static_cast<double>(value) : std::round(static_cast<double>(value) / static_cast<double>(scale_));
        EXPECT_LE(std::fabs(whole), 32767);
        put_word(out, static_cast<std::size_t>(static_cast<std::int64_t>(whole)));
        out += 2;
      } else {
        put_real(out, value);
        out += 4;
      }
    }
    b_.resize((out + 511) / 512 * 512, '\0');
  }

  void rewrite_parameters() {
    put(parameters_ + 3, static_cast<std::size_t>(processor_));
    std::string group_of[128], group;
    for (std::size_t at = parameters_ + 4;;) {
      const std::size_t name_size = byte(at) > 127 ? 256 - byte(at) : byte(at);  // the length of a locked parameter's name is negative
      if (name_size == 0) break;
      const bool is_group = byte(at + 1) > 127;
      const std::size_t link = at + 2 + name_size, next = link + intel_word(link);
      const bool last = intel_word(link) == 0;
      const std::string name = b_.substr(at + 2, name_size);
      if (is_group) {
        group_of[256 - byte(at + 1)] = name;
      } else {
        const std::size_t type = byte(link + 2), dimensions = byte(link + 3);
        std::size_t count = 1;
        for (std::size_t d = 0; d < dimensions; ++d) count *= byte(link + 4 + d);
        const std::size_t values = link + 4 + dimensions;
        const bool scale = group_of[byte(at + 1)] == "POINT" && name == "SCALE" && scale_ > 0;
        for (std::size_t i = 0; i < count; ++i) {
          if (type == 2) put_word(values + 2 * i, intel_word(values + 2 * i));
          if (type == 4) put_real(values + 4 * i, scale ? scale_ : intel_real(values + 4 * i));
        }
      }
      put_word(link, intel_word(link));
      if (last) break;
      at = next;
    }
  }

  void rewrite_header() {
    const float scale = scale_ > 0 ? scale_ : intel_real(12), rate = intel_real(20);
    for (std::size_t at = 24; at < 512; at += 2)
      EXPECT_TRUE(at == 294 || intel_word(at) == 0 || at >= 296) << "events in the header cannot be rewritten here";
    for (const std::size_t at : {2u, 4u, 6u, 8u, 10u, 16u, 18u}) put_word(at, intel_word(at));
    put_real(12, scale);
    put_real(20, rate);
  }

  std::string b_;
  Processor processor_;
  float scale_;
  std::size_t parameters_ = 0, data_ = 0, markers_ = 0, frames_ = 0;
};

TEST(SharedC3d, AllProcessorAndNumberFormatsAreReadEqually) {
  NEEDS_SHARED_FILES();
  for (const std::string& path : shared_files({".c3d"})) {
    const MarkerMotion m = read_markers(path);
    for (const Processor processor : {Processor::intel, Processor::dec, Processor::mips})
      for (const float scale : {0.0F, 0.1F}) {
        SCOPED_TRACE(path + ", processor " + std::to_string(static_cast<int>(processor)) + (scale > 0 ? ", integers" : ""));
        const Rewritten file(shared_text(path), processor, scale);
        const auto back = formats::read_c3d(bytes_of(file.bytes()), path);
        ASSERT_TRUE(back) << back.error().text();
        EXPECT_EQ(back->labels, m.labels);
        EXPECT_EQ(back->rate, m.rate);
        EXPECT_EQ(back->first_frame, m.first_frame);
        EXPECT_EQ(back->unit, m.unit);
        ASSERT_EQ(back->frames, m.frames);
        double worst = 0;
        for (int f = 0; f < m.frames; ++f)
          for (int i = 0; i < m.marker_count(); ++i) {
            ASSERT_EQ(back->seen(f, i), m.seen(f, i));
            worst = std::max(worst, norm(back->at(f, i) - m.at(f, i)));
          }
        if (scale > 0)
          EXPECT_LE(worst, 0.51 * std::sqrt(3.0) * static_cast<double>(scale) * m.unit);
        else
          EXPECT_EQ(worst, 0) << "all three forms store 24 bits";
        EXPECT_EQ(worst > 0, scale > 0);
      }
  }
}

}  // namespace
}  // namespace ugoki
