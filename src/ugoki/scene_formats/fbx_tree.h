#pragma once
// The records of an FBX file, binary or ASCII, as a tree. Each record is checked to be inside its parent. Internal to scene_formats.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::scene_formats {

/// A property of a record. Texts are views into the bytes of the file.
struct FbxValue {
  enum class Kind : std::uint8_t { number, text, array };
  Kind kind = Kind::text;
  double number = 0;
  std::int64_t whole = 0;      ///< exact value of an integer
  std::string_view text = {};  ///< for an array: its bytes, or its numbers separated by commas
  char type = 0;               ///< element type of an array: 'd' double, 'f' float, 'l' int64, 'i' int32, 'b' byte; 'a': ASCII text
  std::uint32_t count = 0;     ///< number of elements of an array
  bool packed = false;         ///< true: the bytes are compressed by zlib
};

/// A record (node) of an FBX file with its properties and child records.
struct FbxRecord {
  std::string_view name;
  std::size_t at = 0;  ///< byte offset in the file
  std::vector<FbxValue> values;
  std::vector<FbxRecord> children;
  /// Returns the first child record of this name, or null.
  [[nodiscard]] const FbxRecord* child(std::string_view wanted) const;
  /// Returns the property `i` as text; empty if it does not exist or is not a text.
  [[nodiscard]] std::string_view text(std::size_t i) const;
};

/// A parsed FBX file. Keeps views into the bytes passed to load(), which must outlive this object.
class FbxFile {
 public:
  explicit FbxFile(std::string_view location) : location_(location) {}
  /// Reads all records. Errors: not FBX, truncated, nested too deeply, a record that exceeds its parent.
  [[nodiscard]] Result<void> load(std::string_view bytes);
  [[nodiscard]] const FbxRecord& root() const { return root_; }
  /// Returns the version of the format, for example 7400; 0 if the file does not state it.
  [[nodiscard]] std::int64_t version() const;
  /// Returns an Error whose location is this record.
  [[nodiscard]] std::unexpected<Error> refuse(const FbxRecord& record, ErrorCode code, std::string message) const;
  /// Returns the elements of a record's array. An Error unless each element is finite and its magnitude is at most `maximum`.
  [[nodiscard]] Result<std::vector<double>> numbers(const FbxRecord& record, double maximum) const;
  /// Returns the elements of a record's array of integers.
  [[nodiscard]] Result<std::vector<std::int64_t>> integers(const FbxRecord& record) const;

 private:
  [[nodiscard]] Result<void> read_binary();
  [[nodiscard]] Result<void> read_text();
  /// Returns the bytes of the array, decompressed if necessary.
  [[nodiscard]] Result<std::string> unpacked(const FbxRecord& record, const FbxValue& array) const;
  template <class T>
  [[nodiscard]] Result<std::vector<T>> array(const FbxRecord& record) const;

  std::string location_;
  std::string_view bytes_;
  bool binary_ = false;
  std::uint32_t binary_version_ = 0;  ///< version from the header of a binary file
  FbxRecord root_;
};

}  // namespace ugoki::scene_formats
