#include "ugoki/scene_formats/npz.h"

#include <zip.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>

#include "ugoki/base/number.h"
#include "ugoki/formats/text.h"

namespace ugoki::scene_formats {
namespace {

constexpr const char* again = "Write the file with numpy.savez, or get it again.";

/// Deleter for the handles of libzip.
struct Closer {
  void operator()(zip_t* zip) const { zip_discard(zip); }
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

/// Text after `key` in the header of an .npy file (a Python dictionary): "'descr': '<f8'" gives " '<f8'...". Empty if it is missing.
std::string_view after_key(std::string_view header, std::string_view key) {
  const std::size_t found = header.find(key);
  if (found == std::string_view::npos) return {};
  const std::size_t colon = header.find(':', found + key.size());
  return colon == std::string_view::npos ? std::string_view() : header.substr(colon + 1);
}

double half_to_double(std::uint16_t h) {
  const int exponent = h >> 10 & 31, mantissa = h & 1023;
  const double sign = (h & 0x8000) != 0 ? -1 : 1;
  if (exponent == 31) return std::nan("");
  return sign * (exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25));
}

template <class T>
double read_as(const char* p) {
  T x;
  std::memcpy(&x, p, sizeof x);
  return static_cast<double>(x);
}

/// Function that converts the little-endian bytes of one number; null for other types. @param size [out] bytes of a number
double (*reader_of(std::string_view type, std::size_t& size))(const char*) {
  static_assert(std::endian::native == std::endian::little);
  if (type.size() < 3 || (type[0] != '<' && type[0] != '|')) return nullptr;
  const std::string_view kind = type.substr(1);
  size = static_cast<std::size_t>(kind[1] - '0');
  if (kind == "f8") return read_as<double>;
  if (kind == "f4") return read_as<float>;
  if (kind == "f2") return [](const char* p) { return half_to_double(static_cast<std::uint16_t>(read_as<std::uint16_t>(p))); };
  if (kind == "i8") return read_as<std::int64_t>;
  if (kind == "i4") return read_as<std::int32_t>;
  if (kind == "i2") return read_as<std::int16_t>;
  if (kind == "i1") return read_as<std::int8_t>;
  if (kind == "u4") return read_as<std::uint32_t>;
  if (kind == "u2") return read_as<std::uint16_t>;
  if (kind == "u1" || kind == "b1") return read_as<std::uint8_t>;
  return nullptr;
}

/// Numbers in "(100, 156), ..."; std::nullopt if they are not a tuple of integers whose product is at most formats::max_numbers.
std::optional<std::vector<std::size_t>> shape_of(std::string_view text) {
  const std::size_t open = text.find('('), close = text.find(')');
  if (open == std::string_view::npos || close == std::string_view::npos || close < open) return std::nullopt;
  std::vector<std::size_t> shape;
  std::size_t product = 1, value = 0;
  bool digits = false;
  for (const char c : text.substr(open + 1, close - open)) {
    if (c >= '0' && c <= '9') {
      value = value * 10 + static_cast<std::size_t>(c - '0');
      digits = true;
      if (value > formats::max_numbers) return std::nullopt;
    } else if (c == ',' || c == ')') {
      if (digits) shape.push_back(value);
      if (digits) product *= value;
      if (product > formats::max_numbers || shape.size() > 8) return std::nullopt;
      value = 0;
      digits = false;
    } else if (c != ' ' && c != 'L') {
      return std::nullopt;
    }
  }
  return shape;
}

}  // namespace

Result<NpyArray> read_npy(std::string_view bytes, std::string_view location) {
  const auto damaged = [&](const char* what) {
    return fail(ErrorCode::syntax, std::string(location), std::string("The array ") + what + ".", again);
  };
  if (!bytes.starts_with("\x93NUMPY") || bytes.size() < 12) return damaged("does not begin with the mark of the NPY format");
  const bool wide = bytes[6] >= 2;  // version 1.0 stores the length of the header in 2 bytes, later versions in 4
  const std::size_t begin = wide ? 12 : 10;
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 8, wide ? 4 : 2);
  if (bytes.size() - begin < length) return damaged("ends within its header");
  const std::string_view header = bytes.substr(begin, length);
  const std::string_view type_text = after_key(header, "'descr'");
  const auto shape = shape_of(after_key(header, "'shape'"));
  const std::size_t quote = type_text.find('\'');
  if (quote == std::string_view::npos || !shape) return damaged("has a header without type or shape");
  const std::string_view type = type_text.substr(quote + 1, type_text.find('\'', quote + 1) - quote - 1);
  NpyArray out;
  std::size_t size = 0;
  const auto read = reader_of(type, size);
  if (read == nullptr) {
    out.shape = {0};
    return out;
  }
  out.shape = *shape;
  std::size_t count = 1;
  for (const std::size_t n : *shape) count *= n;
  const std::string_view data = bytes.substr(begin + length);
  if (data.size() / size < count) return damaged("has fewer numbers than its shape states");
  const std::string_view order = after_key(header, "'fortran_order'");
  if (shape->size() > 1 && order.find("True") < order.find("False"))
    return fail(ErrorCode::unsupported, std::string(location), "The array is stored column by column (fortran_order).",
                "Write it with numpy.ascontiguousarray.");
  out.values.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double x = read(data.data() + i * size);
    if (!(std::fabs(x) <= formats::max_magnitude))
      return fail(ErrorCode::range, std::string(location), "Number " + std::to_string(i + 1) + " of the array is not finite or above 1e9.",
                  "Correct the recording.");
    out.values.push_back(x);
  }
  return out;
}

Result<Npz> read_npz(std::span<const std::byte> bytes, std::string_view location, std::span<const std::string_view> wanted) {
  // Bounds against zip bombs: unpacked size of one array, and of all arrays together.
  constexpr std::uint64_t max_bytes = std::uint64_t{2} << 30;
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  const std::unique_ptr<zip_t, Closer> zip(source != nullptr ? zip_open_from_source(source, ZIP_RDONLY, &error) : nullptr);
  zip_error_fini(&error);
  if (!zip) {
    if (source != nullptr) zip_source_free(source);
    return fail(ErrorCode::syntax, std::string(location), "The file is not a zip of NumPy arrays, or is truncated or damaged.", again);
  }
  Npz out;
  std::uint64_t total = 0;
  for (const std::string_view name : wanted) {
    const std::string entry = std::string(name) + ".npy", where = std::string(location) + ": " + std::string(name);
    zip_stat_t stat;
    if (zip_stat(zip.get(), entry.c_str(), 0, &stat) != 0) continue;
    total += (stat.valid & ZIP_STAT_SIZE) != 0 ? std::min(stat.size, max_bytes + 1) : max_bytes + 1;
    if (total > max_bytes) return fail(ErrorCode::range, where, "The arrays of the file have more than 2 GiB.", "Split the recording.");
    const std::unique_ptr<zip_file_t, Closer> file(zip_fopen(zip.get(), entry.c_str(), 0));
    std::string text;
    zip_int64_t n = -1;
    char buffer[1 << 14];
    while (file && text.size() <= stat.size && (n = zip_fread(file.get(), buffer, sizeof buffer)) > 0)
      text.append(buffer, static_cast<std::size_t>(n));
    if (!file || n != 0 || text.size() != stat.size)
      return fail(ErrorCode::truncated, where, "The array cannot be unpacked; it is damaged or encrypted.", again);
    Result<NpyArray> array = read_npy(text, where);
    if (!array) return fail(std::move(array.error()));
    if (array->shape != std::vector<std::size_t>{0}) out.emplace(name, std::move(*array));
  }
  return out;
}

}  // namespace ugoki::scene_formats
