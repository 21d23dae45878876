#include "ugoki/scene_formats/fbx_tree.h"

#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "ugoki/base/number.h"
#include "ugoki/formats/text.h"

namespace ugoki::scene_formats {
namespace {

constexpr std::string_view binary_start{"Kaydara FBX Binary  \0", 21};
constexpr const char* remedy = "Export it again, in another version of the format or as glTF or BVH.";
constexpr int max_depth = 64;                   // maximum depth of nested records; bounds the recursion
constexpr std::size_t max_values = 50'000'000;  // maximum number of values in an ASCII file, to bound memory

/// Size in bytes of an array element of this type.
std::size_t size_of(char type) { return type == 'd' || type == 'l' ? 8 : type == 'b' || type == 'c' ? 1 : 4; }

template <class T>
T number_at(std::string_view bytes, std::size_t at) {
  T x;
  std::memcpy(&x, bytes.data() + at, sizeof x);
  return x;
}

FbxValue whole_number(std::int64_t x) { return {.kind = FbxValue::Kind::number, .number = static_cast<double>(x), .whole = x}; }
FbxValue real_number(double x) { return {.kind = FbxValue::Kind::number, .number = x, .whole = std::fabs(x) < 9e15 ? std::llrint(x) : 0}; }

/// Position and message of a syntax error.
struct Broken {
  std::size_t at;
  std::string message;
};

class BinaryReader {
 public:
  BinaryReader(std::string_view bytes, bool wide) : bytes_(bytes), wide_(wide) {}

  /// Reads records from `at` to an empty record or to `end`. Returns false on error; `broken` then describes the error.
  bool records(std::size_t at, std::size_t end, int depth, std::vector<FbxRecord>& out) {
    if (depth > max_depth) return stop(at, "The records are nested too deeply.");
    const std::size_t head = wide_ ? 25 : 13;
    while (at < end) {
      if (end - at < head) return stop(at, "The header of a record is truncated.");
      const std::size_t record_end = size_at(at), count = size_at(at + head / 3), length = size_at(at + 2 * (head / 3));
      const std::size_t name = static_cast<unsigned char>(bytes_[at + head - 1]), first = at + head;
      if (record_end == 0) return true;
      if (record_end > end || record_end < first || name > record_end - first || length > record_end - first - name)
        return stop(at, "A record exceeds its parent record.");
      FbxRecord record;
      record.name = bytes_.substr(first, name);
      record.at = at;
      if (!values(first + name, length, count, record.values)) return false;
      if (!records(first + name + length, record_end, depth + 1, record.children)) return false;
      out.push_back(std::move(record));
      at = record_end;
    }
    return true;
  }
  Broken broken{0, ""};

 private:
  bool stop(std::size_t at, std::string message) {
    broken = {at, std::move(message)};
    return false;
  }
  [[nodiscard]] std::size_t size_at(std::size_t at) const {
    return wide_ ? static_cast<std::size_t>(number_at<std::uint64_t>(bytes_, at)) : number_at<std::uint32_t>(bytes_, at);
  }
  bool values(std::size_t at, std::size_t length, std::size_t count, std::vector<FbxValue>& out) {
    const std::size_t end = at + length;
    for (std::size_t i = 0; i < count; ++i) {
      if (at >= end) return stop(at, "A record has fewer properties than its header declares.");
      const char type = bytes_[at++];
      const std::size_t left = end - at;
      std::size_t used = 0;
      switch (type) {
        case 'C':
        case 'B': used = 1; break;
        case 'Y': used = 2; break;
        case 'I':
        case 'F': used = 4; break;
        case 'D':
        case 'L': used = 8; break;
        case 'S':
        case 'R': used = left < 4 ? left + 1 : 4 + std::size_t{number_at<std::uint32_t>(bytes_, at)}; break;
        case 'd':
        case 'f':
        case 'l':
        case 'i':
        case 'b':
        case 'c': used = left < 12 ? left + 1 : 12 + std::size_t{number_at<std::uint32_t>(bytes_, at + 8)}; break;
        default: return stop(at - 1, "A property has an unknown type.");
      }
      if (used > left) return stop(at, "A property is longer than its record.");
      out.push_back(value(type, at, used));
      at += used;
    }
    return at == end || stop(at, "A record has more properties than its header declares.");
  }
  [[nodiscard]] FbxValue value(char type, std::size_t at, std::size_t used) const {
    switch (type) {
      case 'C':
      case 'B': return whole_number(bytes_[at]);
      case 'Y': return whole_number(number_at<std::int16_t>(bytes_, at));
      case 'I': return whole_number(number_at<std::int32_t>(bytes_, at));
      case 'L': return whole_number(number_at<std::int64_t>(bytes_, at));
      case 'F': return real_number(static_cast<double>(number_at<float>(bytes_, at)));
      case 'D': return real_number(number_at<double>(bytes_, at));
      case 'S':
      case 'R': return {.kind = FbxValue::Kind::text, .text = bytes_.substr(at + 4, used - 4)};
      default: break;
    }
    return {.kind = FbxValue::Kind::array,
            .text = bytes_.substr(at + 12, used - 12),
            .type = type,
            .count = number_at<std::uint32_t>(bytes_, at),
            .packed = number_at<std::uint32_t>(bytes_, at + 4) == 1};
  }

  std::string_view bytes_;
  bool wide_;  ///< sizes have 64 bits (version 7500 and later)
};

class TextReader {
 public:
  explicit TextReader(std::string_view bytes) : bytes_(bytes) {}

  /// Reads records up to '}' or, at depth 0, to the end of the file. Returns false on error; `broken` then describes the error.
  bool records(int depth, std::vector<FbxRecord>& out) {
    if (depth > max_depth) return stop("The records are nested too deeply.");
    for (skip(); at_ < bytes_.size() && bytes_[at_] != '}'; skip()) {
      FbxRecord record;
      record.at = at_;
      record.name = word(":");
      skip();
      if (record.name.empty() || at_ >= bytes_.size() || bytes_[at_] != ':') return stop("A record name followed by a colon is missing.");
      ++at_;
      if (!rest(record, depth)) return false;
      out.push_back(std::move(record));
    }
    return (depth == 0) == (at_ >= bytes_.size()) || stop(depth == 0 ? "A '}' has no matching '{'." : "A '}' is missing.");
  }
  Broken broken{0, ""};

 private:
  bool stop(std::string message) {
    broken = {at_, std::move(message)};
    return false;
  }
  void skip() {
    while (at_ < bytes_.size()) {
      if (bytes_[at_] == ';')
        at_ = std::min(bytes_.find('\n', at_), bytes_.size());
      else if (std::string_view(" \t\r\n").contains(bytes_[at_]))
        ++at_;
      else
        return;
    }
  }
  std::string_view word(std::string_view ends) {
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && !std::string_view(" \t\r\n,{};").contains(bytes_[at_]) && !ends.contains(bytes_[at_])) ++at_;
    return bytes_.substr(begin, at_ - begin);
  }
  /// Reads the values and child records of a record, whose name and colon have been read.
  bool rest(FbxRecord& record, int depth) {
    // The first value is on the same line as the name; after a comma, the next value may be on any line.
    while (at_ < bytes_.size() && (bytes_[at_] == ' ' || bytes_[at_] == '\t' || bytes_[at_] == '\r')) ++at_;
    if (at_ < bytes_.size() && !std::string_view("\n{};").contains(bytes_[at_])) {
      for (bool more = true; more;) {
        skip();
        FbxValue value;
        if (!read(value)) return false;
        record.values.push_back(value);
        if (++count_ > max_values) return stop("The file has more than 50 million values.");
        const std::size_t end = at_;
        skip();
        more = at_ < bytes_.size() && bytes_[at_] == ',';
        if (more)
          ++at_;
        else if (at_ >= bytes_.size() || bytes_[at_] != '{')
          at_ = end;
      }
    }
    skip();
    if (at_ >= bytes_.size() || bytes_[at_] != '{') return true;
    ++at_;
    if (!record.values.empty() && record.values[0].type == 'a') return numbers(record.values[0]);
    if (!records(depth + 1, record.children)) return false;
    ++at_;
    return true;
  }
  bool read(FbxValue& value) {
    if (at_ < bytes_.size() && bytes_[at_] == '"') {
      const std::size_t end = bytes_.find('"', at_ + 1);
      if (end == std::string_view::npos) return stop("A text is not closed.");
      value.text = bytes_.substr(at_ + 1, end - at_ - 1);
      at_ = end + 1;
      return true;
    }
    value.text = word("");
    if (value.text.empty() && at_ < bytes_.size() && bytes_[at_] == ',') return true;  // an empty value, as in "Content: , ..."
    if (value.text.empty()) return stop("A value is missing.");
    if (value.text[0] == '*') {
      const auto [end, error] = std::from_chars(value.text.data() + 1, value.text.data() + value.text.size(), value.count);
      if (error != std::errc{} || end != value.text.data() + value.text.size()) return stop("The length of an array is not a number.");
      value.kind = FbxValue::Kind::array;
      value.type = 'a';
      value.text = {};
      return true;
    }
    if (const std::optional<double> x = parse_double(value.text)) {
      const std::optional<long> n = parse_long(value.text);
      const std::string_view text = value.text;
      value = n ? whole_number(*n) : real_number(*x);
      value.text = text;
    }
    return true;
  }
  /// Stores the text of an array "{ a: 1,2,3 }".
  bool numbers(FbxValue& array) {
    const std::size_t end = bytes_.find('}', at_);
    if (end == std::string_view::npos) return stop("A '}' is missing.");
    const std::size_t colon = bytes_.find(':', at_);
    array.text = colon < end ? bytes_.substr(colon + 1, end - colon - 1) : std::string_view();
    at_ = end + 1;
    return true;
  }

  std::string_view bytes_;
  std::size_t at_ = 0, count_ = 0;
};

}  // namespace

const FbxRecord* FbxRecord::child(std::string_view wanted) const {
  for (const FbxRecord& c : children)
    if (c.name == wanted) return &c;
  return nullptr;
}

std::string_view FbxRecord::text(std::size_t i) const {
  return i < values.size() && values[i].kind == FbxValue::Kind::text ? values[i].text : std::string_view();
}

Result<void> FbxFile::load(std::string_view bytes) {
  bytes_ = bytes;
  binary_ = bytes.starts_with(binary_start);
  return binary_ ? read_binary() : read_text();
}

Result<void> FbxFile::read_binary() {
  if (bytes_.size() < 27) return fail(ErrorCode::truncated, location_, "The file ends within its header.", remedy);
  binary_version_ = number_at<std::uint32_t>(bytes_, 23);
  BinaryReader reader(bytes_, binary_version_ >= 7500);
  if (reader.records(27, bytes_.size(), 0, root_.children)) return {};
  return fail(ErrorCode::syntax, location_ + ", byte " + std::to_string(reader.broken.at), std::move(reader.broken.message), remedy);
}

Result<void> FbxFile::read_text() {
  TextReader reader(bytes_);
  if (reader.records(0, root_.children)) return {};
  FbxRecord here;
  here.at = reader.broken.at;
  return refuse(here, ErrorCode::syntax, "The file cannot be read as FBX: " + std::move(reader.broken.message));
}

std::int64_t FbxFile::version() const {
  const FbxRecord* header = root_.child("FBXHeaderExtension");
  const FbxRecord* version = header ? header->child("FBXVersion") : nullptr;
  if (version && !version->values.empty() && version->values[0].kind == FbxValue::Kind::number) return version->values[0].whole;
  return binary_version_;
}

std::unexpected<Error> FbxFile::refuse(const FbxRecord& record, ErrorCode code, std::string message) const {
  const auto at = static_cast<std::ptrdiff_t>(std::min(record.at, bytes_.size()));
  std::string location = location_ + (binary_ ? ", byte " + std::to_string(at)
                                              : ", line " + std::to_string(1 + std::count(bytes_.begin(), bytes_.begin() + at, '\n')));
  if (!record.name.empty()) location += ", " + formats::in_quotes(record.name);
  return fail(code, std::move(location), std::move(message), remedy);
}

Result<std::string> FbxFile::unpacked(const FbxRecord& record, const FbxValue& array) const {
  const std::size_t size = size_of(array.type) * array.count;
  if (!array.packed) {
    if (array.text.size() != size) return refuse(record, ErrorCode::truncated, "The size of the array does not match its declared length.");
    return std::string(array.text);
  }
  // The compression factor of zlib is at most 1032.
  if (size / 1032 > array.text.size())
    return refuse(record, ErrorCode::truncated, "The compressed array is too short for its declared length.");
  std::string out(size, '\0');
  uLongf got = size;
  if (uncompress(reinterpret_cast<Bytef*>(out.data()), &got, reinterpret_cast<const Bytef*>(array.text.data()), array.text.size()) !=
          Z_OK ||
      got != size)
    return refuse(record, ErrorCode::syntax, "The compressed array cannot be decompressed.");
  return out;
}

template <class T>
Result<std::vector<T>> FbxFile::array(const FbxRecord& record) const {
  std::vector<T> out;
  if (record.values.empty()) return out;
  const FbxValue& v = record.values[0];
  if (v.kind == FbxValue::Kind::array && v.type != 'a') {
    const Result<std::string> bytes = unpacked(record, v);
    if (!bytes) return fail(bytes.error());
    out.reserve(v.count);
    for (std::size_t i = 0; i < v.count; ++i) {
      const std::size_t at = i * size_of(v.type);
      switch (v.type) {
        case 'd': out.push_back(static_cast<T>(std::clamp(number_at<double>(*bytes, at), -9e18, 9e18))); break;
        case 'f': out.push_back(static_cast<T>(std::clamp(static_cast<double>(number_at<float>(*bytes, at)), -9e18, 9e18))); break;
        case 'l': out.push_back(static_cast<T>(number_at<std::int64_t>(*bytes, at))); break;
        case 'i': out.push_back(static_cast<T>(number_at<std::int32_t>(*bytes, at))); break;
        default: out.push_back(static_cast<T>((*bytes)[at])); break;
      }
    }
    return out;
  }
  const auto add = [&](std::string_view word) {
    const std::optional<long> n = parse_long(word);
    const std::optional<double> x = n ? static_cast<double>(*n) : parse_double(word);
    if (!x || std::fabs(*x) > 9e18) return false;
    out.push_back(n ? static_cast<T>(*n) : static_cast<T>(*x));
    return true;
  };
  if (v.kind != FbxValue::Kind::array) {  // FBX 7.0 and earlier: numbers without a length
    for (const FbxValue& x : record.values)
      if (x.kind != FbxValue::Kind::number || !add(x.text.empty() ? to_text(x.number) : std::string(x.text)))
        return refuse(record, ErrorCode::syntax, formats::in_quotes(x.text) + " is not a valid number.");
    return out;
  }
  constexpr std::string_view between = " \t\r\n,";
  for (std::size_t at = v.text.find_first_not_of(between); at != std::string_view::npos;) {
    const std::size_t end = std::min(v.text.find_first_of(between, at), v.text.size());
    if (!add(v.text.substr(at, end - at)))
      return refuse(record, ErrorCode::syntax, formats::in_quotes(v.text.substr(at, end - at)) + " is not a valid number.");
    at = v.text.find_first_not_of(between, end);
  }
  if (out.size() != v.count)
    return refuse(record, ErrorCode::truncated,
                  "The array declares " + std::to_string(v.count) + " numbers, but has " + std::to_string(out.size()) + ".");
  return out;
}

Result<std::vector<double>> FbxFile::numbers(const FbxRecord& record, double maximum) const {
  Result<std::vector<double>> out = array<double>(record);
  if (!out) return out;
  for (const double x : *out)
    if (!(std::fabs(x) <= maximum))
      return refuse(record, ErrorCode::range, "A number is not finite or its magnitude exceeds " + to_text(maximum) + ".");
  return out;
}

Result<std::vector<std::int64_t>> FbxFile::integers(const FbxRecord& record) const {
  // Floating-point times are refused: NaN cannot be converted to an integer, and no exporter writes them.
  if (!record.values.empty() && (record.values[0].type == 'd' || record.values[0].type == 'f'))
    return refuse(record, ErrorCode::syntax, "The numbers of the array must be integers.");
  return array<std::int64_t>(record);
}

}  // namespace ugoki::scene_formats
