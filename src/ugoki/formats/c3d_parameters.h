#pragma once
// The parameter section of C3D files, and their three ways to write numbers. Internal to formats.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::formats {

/// How a file writes its numbers; the value is the byte in the file.
enum class C3dProcessor : std::uint8_t { intel = 84, dec = 85, mips = 86 };

/// Numbers out of bytes. The caller has checked that they are there.
struct C3dNumbers {
  C3dProcessor processor = C3dProcessor::intel;

  [[nodiscard]] std::uint16_t word(const std::byte* p) const;
  [[nodiscard]] std::int16_t integer(const std::byte* p) const { return static_cast<std::int16_t>(word(p)); }
  /// DEC's F format has no NaN or infinity; reserved operands give NaN.
  [[nodiscard]] float real(const std::byte* p) const;
};

struct C3dParameter {
  std::string group, name;           ///< in capital letters
  int type = 0;                      ///< -1 text, 1 bytes, 2 whole numbers, 4 floating point
  std::vector<int> sizes;            ///< none: one value
  std::span<const std::byte> bytes;  ///< of the file
};

class C3dParameters {
 public:
  /// Walks the section. Errors name the parameter after which it breaks. @param at where the section begins
  [[nodiscard]] static Result<C3dParameters> read(std::span<const std::byte> file, std::size_t at, std::string_view file_name);

  [[nodiscard]] const C3dNumbers& numbers() const { return numbers_; }
  [[nodiscard]] const C3dParameter* find(std::string_view group, std::string_view name) const;
  /// All values as numbers (whole numbers signed); empty if there is no such parameter or it is text.
  [[nodiscard]] std::vector<double> values(std::string_view group, std::string_view name) const;
  /// The first value, or `otherwise`.
  [[nodiscard]] double value(std::string_view group, std::string_view name, double otherwise) const;
  /// The first value of a count, which the format writes as a signed or unsigned word: 0 ... 65535 (floating point: as it is).
  [[nodiscard]] std::optional<double> count(std::string_view group, std::string_view name) const;
  /// Texts without blanks at their ends; of the parameter and its continuations NAME2, NAME3 ...
  [[nodiscard]] std::vector<std::string> texts(std::string_view group, std::string_view name) const;

 private:
  C3dNumbers numbers_;
  std::vector<C3dParameter> parameters_;
};

}  // namespace ugoki::formats
