#pragma once
// The parameter section of C3D files, and the three number formats (Intel, DEC, SGI/MIPS) of C3D files. Internal to formats.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::formats {

/// Processor whose number format a file uses; the value is the byte in the file.
enum class C3dProcessor : std::uint8_t { intel = 84, dec = 85, mips = 86 };

/// Decodes the numbers of a C3D file. The caller must have checked that `p` points to 2 bytes (word, integer) or 4 bytes (real).
struct C3dNumbers {
  C3dProcessor processor = C3dProcessor::intel;

  [[nodiscard]] std::uint16_t word(const std::byte* p) const;
  [[nodiscard]] std::int16_t integer(const std::byte* p) const { return static_cast<std::int16_t>(word(p)); }
  /// DEC's F format has no NaN or infinity; its reserved operands are returned as NaN.
  [[nodiscard]] float real(const std::byte* p) const;
};

/// One parameter, for example POINT:RATE.
struct C3dParameter {
  std::string group, name;           ///< converted to capital letters
  int type = 0;                      ///< -1 text, 1 bytes, 2 integers (16 bits), 4 floating point
  std::vector<int> sizes;            ///< dimensions, fastest index first; empty: one value
  std::span<const std::byte> bytes;  ///< the values, a view into the file's bytes
};

/// All parameters of a file. Keeps views into the bytes of the file, which must outlive this object.
class C3dParameters {
 public:
  /// Reads the section that begins at byte `at` of `file`. Error messages name the last parameter that was read before the fault.
  [[nodiscard]] static Result<C3dParameters> read(std::span<const std::byte> file, std::size_t at, std::string_view file_name);

  [[nodiscard]] const C3dNumbers& numbers() const { return numbers_; }
  /// Returns the parameter, or null if the file does not have it. @param group, name in capital letters
  [[nodiscard]] const C3dParameter* find(std::string_view group, std::string_view name) const;
  /// Returns all values as numbers; 16-bit integers are read as signed. Empty if the parameter is missing or is text.
  [[nodiscard]] std::vector<double> values(std::string_view group, std::string_view name) const;
  /// Returns the first value; `otherwise` if the parameter is missing or is text.
  [[nodiscard]] double value(std::string_view group, std::string_view name, double otherwise) const;
  /// Returns the first value of a parameter that is a count. Files store counts as signed or unsigned 16-bit words; negative words are
  /// therefore read as 32768 ... 65535. Floating-point values are returned unchanged. std::nullopt if the value is missing or not finite.
  [[nodiscard]] std::optional<double> count(std::string_view group, std::string_view name) const;
  /// Returns the texts of the parameter NAME and of its continuations NAME2, NAME3 ..., without blanks at either end, as UTF-8.
  [[nodiscard]] std::vector<std::string> texts(std::string_view group, std::string_view name) const;

 private:
  C3dNumbers numbers_;
  std::vector<C3dParameter> parameters_;
};

}  // namespace ugoki::formats
